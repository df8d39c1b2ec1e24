//! What touches the ground, the softness of joints and loops, and tendons and couplings.

use modyn_runtime::model::{JointSoftness, LoopSoftness, Model, SoftConstraints};
use rustc_hash::FxHashMap;

use crate::description::{Description, ReadOptions};
use crate::diagnostics::{Code, Report, Severity};

/// Returns the soft constraints of the model. `carriers` has, for each link of the description, the
/// moving link that carries it.
pub fn constraints(
    description: &Description,
    options: &ReadOptions,
    carriers: &[Option<usize>],
    model: &Model,
    report: &mut Report<'_>,
) -> SoftConstraints {
    let mut soft = description.soft.clone().unwrap_or_default();
    soft.ground = options.ground.map(|ground| ground.surface());
    soft.joint_friction &= options.joint_friction.is_none();
    soft.shapes.retain(|shape| carriers[shape.end.link].is_some());
    if options.ground.is_some() && soft.shapes.is_empty() && model.contacts().is_empty() {
        let message = "nothing touches the ground: no link that moves has a shape for contacts";
        let help = "describe collision shapes of the links, name `contacts`, or let the base float";
        report.add(Severity::Warning, Code::Option, description.at, None, message, help);
    }
    let links = model.moving_links().iter().enumerate();
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
    // Joints that constraints hold are no joints of the model.
    soft.references.retain_mut(|reference| {
        let joint = joints.get(description.joints[reference.joint].name.text.as_str());
        joint.map(|&joint| reference.joint = joint).is_some()
    });
    let lengths = soft.tendons.iter_mut().map(|tendon| &mut tendon.length);
    let sums = soft.couplings.iter_mut().flat_map(|coupling| &mut coupling.sums);
    for joint in lengths.chain(sums).flat_map(|sum| &mut sum.joints) {
        let name = description.joints[joint.link].name.text.as_str();
        // The model refuses a joint that none of its links has.
        joint.link = joints.get(name).copied().unwrap_or(model.moving_links().len());
    }
    soft
}
