//! What touches the ground, and the softness of joints and loops.

use modyn_runtime::model::{JointSoftness, LoopSoftness, Model, SoftConstraints};
use rustc_hash::FxHashMap;

use crate::description::{Description, ReadOptions};

/// Returns the soft constraints of the model. `carriers` has, for each link of the description, the
/// moving link that carries it.
pub fn constraints(
    description: &Description,
    options: &ReadOptions,
    carriers: &[Option<usize>],
    model: &Model,
) -> SoftConstraints {
    let Some(mut soft) = description.soft.clone() else { return SoftConstraints::default() };
    soft.joint_friction &= options.friction.is_none();
    soft.shapes.retain(|shape| carriers[shape.end.frame].is_some());
    let links = model.links().iter().enumerate();
    let joints: FxHashMap<&str, usize> =
        links.map(|(joint, link)| (link.joint.name.as_str(), joint)).collect();
    let softnesses = description.softnesses.iter().filter_map(|(joint, record)| {
        let name = description.joints[*joint].name.text.as_str();
        Some(JointSoftness {
            joint: *joints.get(name)?,
            margin: record.margin,
            limit: record.limit,
            friction: record.friction,
        })
    });
    soft.joints = softnesses.collect();
    let constraints = model.loop_constraints().iter().enumerate();
    let loops: FxHashMap<&str, usize> =
        constraints.map(|(i, constraint)| (constraint.name.as_str(), i)).collect();
    let softnesses = description.loop_softnesses.iter().filter_map(|softness| {
        let name = description.loops[softness.constraint].name.as_str();
        Some(LoopSoftness { constraint: *loops.get(name)?, ..*softness })
    });
    soft.loops = softnesses.collect();
    soft
}
