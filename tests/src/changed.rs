//! Models with other figures.

use modyn_runtime::model::{Frame, Inertial, Link, Model};

/// The model with another inertia of frame `at`; a moving link's is the sum of its frames'.
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
    rebuilt(model, model.gravity(), links, frames)
}

/// The model where things fall like this.
#[must_use]
pub fn under(model: &Model, gravity: [f64; 3]) -> Model {
    rebuilt(model, gravity, model.links().to_vec(), model.frames().to_vec())
}

fn rebuilt(model: &Model, gravity: [f64; 3], links: Vec<Link>, frames: Vec<Frame>) -> Model {
    Model::new(model.name(), gravity, links, frames)
        .expect("sound parts")
        .with_friction(model.friction())
}
