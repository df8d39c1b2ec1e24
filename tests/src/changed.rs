//! Models with changed inertias.

use modyn_runtime::model::{Inertial, Model};

/// Returns the model with another inertia of frame `at`; the inertia of a moving link is the sum over its frames.
#[must_use]
pub fn changed(model: &Model, at: usize, inertial: Inertial) -> Model {
    let (mut links, mut frames) = (model.links().to_vec(), model.frames().to_vec());
    frames[at].inertial = inertial;
    if let Some(link) = frames[at].link {
        let parts = frames.iter().filter(|frame| frame.link == Some(link));
        links[link].inertial = parts.fold(Inertial::default(), |sum, frame| {
            sum.merged(&frame.inertial.transformed(&frame.pose))
        });
    }
    Model::new(model.name(), model.gravity(), links, frames)
        .and_then(|changed| changed.with_friction(model.friction()))
        .and_then(|changed| changed.with_springs(model.springs().to_vec()))
        .and_then(|changed| {
            changed.with_gravity_compensation(model.gravity_compensation().to_vec())
        })
        .expect("sound parts")
}
