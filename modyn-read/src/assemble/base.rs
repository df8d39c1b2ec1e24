//! The option `base`: whether the robot's own floating joints stay.

use modyn_runtime::joint::JointType;

use super::tree::Tree;
use crate::description::{Base, Description, Kind};
use crate::diagnostics::{Code, Report};

/// Fixes the floating joints that connect the robot to the world, for `base = fixed`; refuses
/// another floating joint before them, for `base = floating`. Returns the base without the refused
/// joint.
pub fn apply(
    description: &mut Description,
    tree: &Tree,
    base: Base,
    report: &mut Report<'_>,
) -> Base {
    if base == Base::Auto {
        return base;
    }
    let mut floats = base == Base::Floating;
    // Whether a link is the root, or fixed to it. A parent comes before its children.
    let mut is_base = vec![false; description.links.len()];
    for &link in &tree.order {
        let Some(joint) = tree.joint[link] else {
            is_base[link] = true;
            continue;
        };
        if !tree.parent[joint].is_some_and(|parent| is_base[parent]) {
            continue;
        }
        let record = &mut description.joints[joint];
        is_base[link] = record.kind == Kind::Fixed;
        if record.kind == Kind::Moving(JointType::Floating) {
            if base == Base::Fixed {
                record.kind = Kind::Fixed;
            } else {
                let message =
                    "`base = floating` is set, but the robot floats already, by this joint";
                let help = "remove the option; coordinates of the joint are those of the base";
                let subject = record.subject();
                report.error(Code::Option, record.name.at, Some(&subject), message, help);
                floats = false;
            }
        }
    }
    if floats { Base::Floating } else { Base::Auto }
}
