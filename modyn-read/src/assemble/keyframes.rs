//! Keyframes of the description: named coordinates.

use modyn_runtime::model::{Keyframe, Model};
use rustc_hash::FxHashMap;

use crate::description::Description;

/// Returns the keyframes with the coordinates of the model's joints: fixed joints and mimic joints
/// have none.
pub fn keyframes(description: &Description, model: &Model) -> Vec<Keyframe> {
    let independent = (0..).zip(model.links()).filter(|(i, _)| model.mimic(*i).is_none());
    let links: FxHashMap<&str, usize> = if description.keyframes.is_empty() {
        FxHashMap::default()
    } else {
        independent.map(|(i, link)| (link.joint.name.as_str(), i)).collect()
    };
    let place = |joint: usize| {
        let name = description.joints[joint].name.text.as_str();
        links.get(name).map(|link| model.q_range(*link))
    };
    let all = description.keyframes.iter().map(|record| {
        let mut q = vec![0.0; model.nq()];
        for (_, at) in model.quaternions() {
            q[at + 3] = 1.0;
        }
        for (joint, values) in &record.coordinates {
            let Some(place) = place(*joint) else { continue };
            if place.len() == values.len() {
                q[place].copy_from_slice(values);
            }
        }
        Keyframe { name: record.name.text.clone(), q }
    });
    all.collect()
}
