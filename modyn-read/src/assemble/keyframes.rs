//! Keyframes of the description: named states.

use modyn_runtime::model::{Keyframe, Model};
use rustc_hash::FxHashMap;

use crate::description::Description;

/// Returns the keyframes with the coordinates and velocities of the model's joints: fixed joints and
/// mimic joints have none.
pub fn keyframes(description: &Description, model: &Model) -> Vec<Keyframe> {
    let independent = (0..).zip(model.moving_links()).filter(|(i, _)| model.mimic(*i).is_none());
    let links: FxHashMap<&str, usize> = if description.keyframes.is_empty() {
        FxHashMap::default()
    } else {
        independent.map(|(i, link)| (link.joint.name.as_str(), i)).collect()
    };
    let link_of = |joint: usize| links.get(description.joints[joint].name.text.as_str()).copied();
    let all = description.keyframes.iter().map(|record| {
        let mut q = vec![0.0; model.nq()];
        for (_, at) in model.quaternions() {
            q[at + 3] = 1.0;
        }
        let mut qd = vec![0.0; model.nv()];
        for (joint, values) in &record.coordinates {
            let Some(place) = link_of(*joint).map(|link| model.q_range(link)) else { continue };
            if place.len() == values.len() {
                q[place].copy_from_slice(values);
            }
        }
        for (joint, values) in &record.velocities {
            let Some(place) = link_of(*joint).map(|link| model.v_range(link)) else { continue };
            if place.len() == values.len() {
                qd[place].copy_from_slice(values);
            }
        }
        let some = |numbers: &[f64]| match numbers.iter().all(|x| *x == 0.0) {
            true => Vec::new(),
            false => numbers.to_vec(),
        };
        let [qd, ctrl, act] = [&qd, &record.ctrl, &record.act].map(|numbers| some(numbers));
        Keyframe { name: record.name.text.clone(), q, qd, ctrl, act }
    });
    all.collect()
}
