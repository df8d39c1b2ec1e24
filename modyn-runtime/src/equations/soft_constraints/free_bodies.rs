//! The rotation of rigid bodies that are free and carry no other body, in steps by MuJoCo's
//! `implicitfast`: the velocities after the step act on it, too.
//!
//! The velocities u of such a body are the velocity of its origin in the world, and its angular velocity,
//! both in its own axes. With their rates a0 under the forces of a step, the mass matrix M, the damping D and
//! the derivative B of the bias force with respect to u, the rates that move the body solve
//!
//! ```text
//! (M + dt D + dt B) a = M a0
//! ```

use alloc::{vec, vec::Vec};

use super::rows::SoftModel;
use crate::Scalar;
use crate::equations::TimeStepInput;
use crate::mechanism::Mechanism;
use crate::mechanism::coordinates::CoordinateSpace;
use crate::spatial::{Matrix3, Vector3};

/// Replaces the accelerations that move free bodies, given the accelerations `qdd` by the laws.
pub(super) fn move_free_bodies<S: Scalar>(
    model: &Mechanism<S>,
    soft: &SoftModel<impl Copy>,
    input: TimeStepInput<'_, S>,
    qdd: &[S],
    damped: &mut [S],
) {
    if soft.free_bodies.is_empty() {
        return;
    }
    let turning = turning(model, input.qd);
    let three = |x: &[S], first: usize| Vector3([x[first], x[first + 1], x[first + 2]]);
    for &body in &soft.free_bodies {
        let dofs = model.dofs_of(body);
        let [linear, angular] = [0, 3].map(|k| dofs[k].v);
        let inertia = &model.bodies[body].inertia;
        let free = FreeBody {
            mass: inertia.mass,
            moment: inertia.first_moment,
            inertia: inertia.rotational().full(),
            armature: dofs[0].armature.unwrap_or_else(S::zero),
            damping: dofs[0].damping.unwrap_or_else(S::zero),
            spin: three(input.qd, angular),
        };
        let rates = [linear, angular].map(|first| three(qdd, first) + three(&turning, first));
        let moved = free.rates(rates, input.dt);
        for (first, rates) in [linear, angular].into_iter().zip(moved) {
            let rates = rates - three(&turning, first);
            damped[first..first + 3].copy_from_slice(&rates.0);
        }
    }
}

/// A free body, in its own axes about its origin.
struct FreeBody<S> {
    mass: S,
    /// The first moment of mass.
    moment: Vector3<S>,
    /// The rotational inertia.
    inertia: Matrix3<S>,
    /// The inertia and the damping of each degree of freedom.
    armature: S,
    damping: S,
    /// The angular velocity.
    spin: Vector3<S>,
}

impl<S: Scalar> FreeBody<S> {
    /// Returns the rates of the linear and of the angular velocity that move the body.
    fn rates(&self, [linear, angular]: [Vector3<S>; 2], dt: S) -> [Vector3<S>; 2] {
        let Self { mass, moment, inertia, armature, damping, spin } = *self;
        let stiffened = armature + damping * dt;
        // M times the rates.
        let force = linear.scale(mass + armature) + angular.cross(moment);
        let torque = inertia.mul_vector(angular) + angular.scale(armature) + moment.cross(linear);
        // The forces of an angular rate, with the derivatives of omega x (omega x c) and of
        // omega x I omega.
        let force_of = |rate: Vector3<S>| {
            let bias = rate.cross(spin.cross(moment)) + spin.cross(rate.cross(moment));
            rate.cross(moment) + bias.scale(dt)
        };
        let torque_of = |rate: Vector3<S>| {
            let momentum = inertia.mul_vector(rate);
            let bias = rate.cross(inertia.mul_vector(spin)) + spin.cross(momentum);
            momentum + rate.scale(stiffened) + bias.scale(dt)
        };
        let per_force = (mass + stiffened).recip();
        let columns = [0, 1, 2].map(|k| {
            let mut unit = Vector3::zero();
            unit.0[k] = S::one();
            torque_of(unit) - moment.cross(force_of(unit)).scale(per_force)
        });
        let right = torque - moment.cross(force).scale(per_force);
        let [x, y, z] = columns;
        let normal = y.cross(z);
        let per_volume = x.dot(normal).recip();
        let parts = [right.dot(normal), x.dot(right.cross(z)), x.dot(y.cross(right))];
        let rate = Vector3(parts).scale(per_volume);
        [(force - force_of(rate)).scale(per_force), rate]
    }
}

/// Returns what the accelerations of floating joints lack to the rates of their velocities in the
/// world, in the axes of the joint: omega x v for linear entries, zero for all others.
pub(super) fn turning<S: Scalar>(model: &Mechanism<S>, qd: &[S]) -> Vec<S> {
    let mut turning = vec![S::zero(); model.nv];
    let spaces = model.coordinates.iter();
    for block in spaces.filter(|block| matches!(block.space, CoordinateSpace::Pose)) {
        let [linear, angular] =
            [block.v, block.v + 3].map(|start| Vector3([qd[start], qd[start + 1], qd[start + 2]]));
        turning[block.v..block.v + 3].copy_from_slice(&angular.cross(linear).0);
    }
    turning
}
