//! Kinetic energy.

use crate::Scalar;
use crate::equations::Workspace;
use crate::mechanism::Mechanism;
use crate::spatial::Twist;

/// Returns the kinetic energy of the moving links and of the rotors, J.
///
/// Base inertias suffice: mass is moved between two bodies only where its motion is the same with
/// both.
pub fn kinetic_energy<S: Scalar>(
    model: &Mechanism<S>,
    q: &[S],
    qd: &[S],
    workspace: &mut Workspace<S>,
) -> S {
    workspace.move_to(model, q);
    let mut twice = S::zero();
    for (i, body) in model.bodies.iter().enumerate() {
        let motion = &workspace.motions[i];
        let from_parent = body
            .parent
            .map_or_else(Twist::zero, |p| body.twist_to_child(motion, workspace.twists[p]));
        let twist = model.add_rates(i, from_parent, qd);
        workspace.twists[i] = twist;
        let omega = twist.angular;
        let v = twist.linear;
        let inertia = &body.base_inertia;
        // omega.I omega + 2 v.(omega x c) + m v.v
        let rotational = omega.dot(inertia.rotational().full().mul_vector(omega));
        let mixed = v.dot(omega.cross(inertia.first_moment));
        twice = twice + (rotational + (mixed + mixed) + inertia.mass * v.dot(v));
    }
    for dof in &model.dofs {
        if let Some(armature) = dof.armature {
            let rate = dof.rate(qd);
            twice = twice + armature * (rate * rate);
        }
    }
    twice * S::from_f64(0.5)
}
