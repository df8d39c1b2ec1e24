//! Base inertias: the part of a body's inertia that has no effect on its joint is moved to the
//! parent.

use super::Body;
use crate::Scalar;
use crate::joint::ElementaryJoint;
use crate::spatial::{RigidInertia, Symmetric3, Vector3};

/// Recomputes the base inertias from the bodies' inertias, leaves first: inertia without effect on
/// a joint force is moved towards the root. Returns the static inertia, which is moved to the
/// world, about the world's origin.
pub(super) fn move_to_parents<S: Scalar>(bodies: &mut [Body<S>]) -> RigidInertia<S> {
    let mut static_inertia = RigidInertia::zero();
    for body in &mut *bodies {
        body.base_inertia = body.inertia;
    }
    for i in (0..bodies.len()).rev() {
        let Body { base_inertia: inertia, elementary_joint, .. } = bodies[i];
        let c = inertia.first_moment;
        let s = inertia.second_moment;
        let moved = match elementary_joint {
            ElementaryJoint::Revolute => RigidInertia {
                mass: inertia.mass,
                first_moment: Vector3::along_z(c[2]),
                second_moment: Symmetric3 { zz: s.zz, ..Symmetric3::zero() },
            },
            ElementaryJoint::Prismatic => RigidInertia { second_moment: s, ..RigidInertia::zero() },
            ElementaryJoint::Spherical => {
                RigidInertia { mass: inertia.mass, ..RigidInertia::zero() }
            }
            ElementaryJoint::Floating => continue,
        };
        bodies[i].base_inertia = inertia.minus(&moved);
        let at_parent = bodies[i].placement.rigid_to_parent(&moved);
        if let Some(parent) = bodies[i].parent {
            bodies[parent].base_inertia = bodies[parent].base_inertia + at_parent;
        } else {
            static_inertia = static_inertia + at_parent;
        }
    }
    static_inertia
}
