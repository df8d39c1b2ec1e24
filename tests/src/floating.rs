//! Robots with a floating base.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Inertial, Joint, Link, Model, MovingLink, Spring};
use modyn_runtime::spatial::Pose;

/// Returns the robot with a floating base. The frames that were fixed to the world become its first link, with their
/// masses and `extra`.
#[must_use]
pub fn floated(model: &Model, extra: Inertial) -> Model {
    let world = model.links().iter().filter(|link| link.moving_link.is_none());
    let inertial =
        world.fold(extra, |sum, frame| sum.merged(&frame.inertial.transformed(&frame.pose)));
    let joint = Joint::new("floating_base", JointType::Floating, [0.0, 0.0, 1.0], Pose::identity());
    let mut links =
        vec![MovingLink { name: "floating_body".into(), parent: None, joint, inertial }];
    links.extend(model.moving_links().iter().cloned().map(|mut link| {
        link.parent = Some(link.parent.map_or(0, |parent| parent + 1));
        if let Some(mimic) = &mut link.joint.mimic {
            mimic.leader += 1;
        }
        link
    }));
    let springs = model.springs().iter().cloned();
    let springs = springs.map(|spring| Spring { link: spring.link + 1, ..spring });
    let frames = model.links().iter().cloned().map(|frame| Link {
        moving_link: Some(frame.moving_link.map_or(0, |link| link + 1)),
        ..frame
    });
    Model::new(model.name(), model.gravity(), links, frames.collect())
        .and_then(|floating| floating.with_joint_friction(model.joint_friction()))
        .and_then(|floating| floating.with_springs(springs.collect()))
        .and_then(|floating| {
            floating.with_gravity_compensation(model.gravity_compensation().to_vec())
        })
        .unwrap_or_else(|errors| panic!("{errors:?}"))
}
