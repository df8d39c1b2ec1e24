//! Actuators of the description: joints of the description become links of the model.

use modyn_runtime::model::{Actuation, JointForceRange, Link, Transmission};
use rustc_hash::FxHashMap;

use crate::description::Description;

/// Returns the actuators of the model. `joints` has the joint of the description of each link.
pub fn actuation(description: &Description, joints: &[Option<usize>], links: &[Link]) -> Actuation {
    let mut actuation = description.actuation.clone();
    let places = joints.iter().enumerate();
    let places: FxHashMap<usize, usize> =
        places.filter_map(|(link, joint)| Some(((*joint)?, link))).collect();
    // The model refuses a joint that none of its links has.
    let link = |joint: usize| places.get(&joint).copied().unwrap_or(links.len());
    for tendon in &mut actuation.tendons {
        tendon.joints.iter_mut().for_each(|joint| joint.link = link(joint.link));
    }
    for actuator in &mut actuation.actuators {
        if let Transmission::Joint(joint) = &mut actuator.transmission {
            *joint = link(*joint);
        }
    }
    let ranges = joints.iter().zip(0..).filter_map(|(joint, link)| {
        let range = description.joints[(*joint)?].actuator_forces?;
        Some(JointForceRange { link, range })
    });
    actuation.joint_force_ranges = ranges.collect();
    actuation
}
