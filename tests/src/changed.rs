//! Models with changed inertias and lengths.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Inertial, Limits, Link, Model, MovingLink};
use modyn_runtime::spatial::Pose;

/// Returns the model with another inertia of frame `at`; the inertia of a moving link is the sum over its frames.
#[must_use]
pub fn changed(model: &Model, at: usize, inertial: Inertial) -> Model {
    let (mut links, mut frames) = (model.moving_links().to_vec(), model.links().to_vec());
    frames[at].inertial = inertial;
    if let Some(link) = frames[at].moving_link {
        let parts = frames.iter().filter(|frame| frame.moving_link == Some(link));
        links[link].inertial = parts.fold(Inertial::default(), |sum, frame| {
            sum.merged(&frame.inertial.transformed(&frame.pose))
        });
    }
    Model::new(model.name(), model.gravity(), links, frames)
        .and_then(|changed| changed.with_joint_friction(model.joint_friction()))
        .and_then(|changed| changed.with_springs(model.springs().to_vec()))
        .and_then(|changed| {
            changed.with_gravity_compensation(model.gravity_compensation().to_vec())
        })
        .expect("sound parts")
}

/// Returns a model without joint dynamics, springs and mimic joints whose lengths are multiplied by `scale`, and whose masses are the
/// same. Gravity is scaled as well, so that all motions take the same time.
#[must_use]
pub fn scaled(model: &Model, scale: f64) -> Model {
    let pose =
        |pose: &Pose<f64>| Pose { translation: pose.translation.map(|x| scale * x), ..*pose };
    let inertial = |inertial: &Inertial| Inertial {
        center_of_mass: inertial.center_of_mass.map(|x| scale * x),
        inertia: inertial.inertia.map(|x| scale * scale * x),
        ..*inertial
    };
    let link = |link: &MovingLink| {
        let mut link = MovingLink { inertial: inertial(&link.inertial), ..link.clone() };
        link.joint.origin = pose(&link.joint.origin);
        let slides = link.joint.joint_type == JointType::Prismatic;
        link.joint.limits = link.joint.limits.filter(|_| slides).map(|limits| Limits {
            lower: limits.lower.map(|x| scale * x),
            upper: limits.upper.map(|x| scale * x),
            ..limits
        });
        link
    };
    let frame = |frame: &Link| Link {
        pose: pose(&frame.pose),
        inertial: inertial(&frame.inertial),
        ..frame.clone()
    };
    let links = model.moving_links().iter().map(link).collect();
    let frames = model.links().iter().map(frame).collect();
    let gravity = model.gravity().map(|x| scale * x);
    Model::new(model.name(), gravity, links, frames).expect("sound parts")
}
