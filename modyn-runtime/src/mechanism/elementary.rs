//! The expansion of composite joints into bodies with one elementary joint each.

use alloc::vec::Vec;

use super::snapping::snap;
use super::{JointSpring, SpringReference};
use crate::joint::{ElementaryJoint, JointType, planar};
use crate::model::{Inertial, Joint, Model, Spring};
use crate::spatial::{Matrix3, Pose, Vector3};

/// A body with its elementary joint, before frames are rotated.
pub(super) struct ElementaryBody<'a> {
    pub(super) parent: Option<usize>,
    pub(super) elementary_joint: ElementaryJoint,
    /// The axes, as columns, of the frame whose z is the joint's axis, in the joint's frame.
    /// Identity for joints without an axis.
    pub(super) frame: Matrix3<f64>,
    /// The pose of the joint's frame in the parent's at coordinate zero.
    pub(super) origin: Pose<f64>,
    pub(super) joint: &'a Joint,
    pub(super) inertial: Inertial,
    pub(super) q: usize,
    pub(super) v: usize,
    pub(super) mimic: Option<(f64, f64)>,
    pub(super) spring: Option<JointSpring<f64>>,
}

/// Returns the bodies of a model, and the body of each link. Universal and planar joints are
/// expanded into several elementary joints.
pub(super) fn expand_composite_joints(model: &Model) -> (Vec<ElementaryBody<'_>>, Vec<usize>) {
    let mut elementary: Vec<ElementaryBody<'_>> = Vec::with_capacity(model.moving_links().len());
    let mut bodies: Vec<usize> = Vec::with_capacity(model.moving_links().len());
    for (i, link) in model.moving_links().iter().enumerate() {
        let joint = &link.joint;
        let axis = joint.axis;
        let plane = planar::plane(axis);
        let across = |column: usize| plane.map(|row| row[column]);
        let along = |elementary_joint, axis| (elementary_joint, frame_along(axis));
        let free = Matrix3(Pose::identity().rotation);
        let parts: &[(ElementaryJoint, Matrix3<f64>)] = match joint.joint_type {
            JointType::Revolute | JointType::Continuous => {
                &[along(ElementaryJoint::Revolute, axis)]
            }
            JointType::Prismatic => &[along(ElementaryJoint::Prismatic, axis)],
            JointType::Universal => &[
                along(ElementaryJoint::Revolute, axis),
                along(ElementaryJoint::Revolute, joint.second_axis),
            ],
            JointType::Planar => &[
                along(ElementaryJoint::Prismatic, across(0)),
                along(ElementaryJoint::Prismatic, across(1)),
                along(ElementaryJoint::Revolute, axis),
            ],
            JointType::Spherical => &[(ElementaryJoint::Spherical, free)],
            JointType::Floating => &[(ElementaryJoint::Floating, free)],
        };
        let mimic = model.mimic(i).map(|mimic| (mimic.multiplier, mimic.offset));
        for (k, &(elementary_joint, frame)) in parts.iter().enumerate() {
            let first = k == 0;
            let last = k + 1 == parts.len();
            elementary.push(ElementaryBody {
                parent: if first {
                    link.parent.map(|p| bodies[p])
                } else {
                    Some(elementary.len() - 1)
                },
                elementary_joint,
                frame,
                origin: if first { joint.origin } else { Pose::identity() },
                joint,
                inertial: if last { link.inertial } else { Inertial::default() },
                q: model.q_range(i).start + k,
                v: model.v_range(i).start + k,
                mimic,
                spring: model
                    .spring(i)
                    .map(|spring| elementary_spring(spring, k, elementary_joint)),
            });
        }
        bodies.push(elementary.len() - 1);
    }
    (elementary, bodies)
}

/// Returns the spring of the elementary joint whose coordinates begin with number `k` of its joint.
fn elementary_spring(spring: &Spring, k: usize, joint: ElementaryJoint) -> JointSpring<f64> {
    let [position, rotation] = match joint {
        ElementaryJoint::Floating => [0, 3],
        _ => [k, k],
    };
    let quaternion = || core::array::from_fn(|j| spring.reference[rotation + j]);
    let reference = match joint {
        ElementaryJoint::Revolute | ElementaryJoint::Prismatic => {
            SpringReference::Coordinate(spring.reference[position])
        }
        ElementaryJoint::Spherical => SpringReference::Rotation(quaternion()),
        ElementaryJoint::Floating => {
            SpringReference::Pose(core::array::from_fn(|j| spring.reference[j]), quaternion())
        }
    };
    JointSpring { stiffness: spring.stiffness, reference }
}

/// Returns a right-handed frame (as columns) whose z axis is `axis`; it is exact for a coordinate
/// axis.
fn frame_along(axis: [f64; 3]) -> Matrix3<f64> {
    let unit = |v: Vector3<f64>| v.scale(1.0 / libm::sqrt(v.dot(v)));
    let z = unit(Vector3(axis.map(snap)));
    // Any direction that is not close to the axis; `turn` chooses the x axis afterwards.
    let across = if z[0].abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let y = unit(z.cross(Vector3(across)));
    Matrix3([y.cross(z).0, y.0, z.0]).transposed()
}
