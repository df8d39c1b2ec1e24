//! Perturbations: the changes of the points' accelerations by a degree of freedom's coordinate or
//! rate.

use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::dynamics::newton_euler::is_base;
use crate::equations::kinematics::acceleration::parent_motion;
use crate::joint::ElementaryJoint;
use crate::mechanism::BodyTree;
use crate::spatial::{AccelerationPerturbation, Field, Matrix3, Vector3};

/// Computes the perturbation by each coordinate. Expects the bodies' accelerations.
///
/// With `falling` a floating base is in free fall, independent of its position and velocity.
pub(super) fn perturbations_by_coordinates<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    qd: &[S],
    falling: bool,
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    for i in 0..model.bodies.len() {
        let ancestor = AncestorMotion::of(tree, i, qd, falling, workspace);
        for d in model.bodies[i].dofs.clone() {
            workspace.perturbations[d] = ancestor.displaced(model.dofs[d].component);
        }
    }
}

/// Computes the perturbation by each rate. Expects the bodies' angular velocities.
pub(super) fn perturbations_by_rates<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    qd: &[S],
    falling: bool,
    workspace: &mut Workspace<S>,
) {
    let model = tree.mechanism();
    for i in 0..model.bodies.len() {
        let ancestor = AncestorMotion::of(tree, i, qd, falling, workspace);
        let sum = ancestor.omega + workspace.fields[i].omega;
        for d in model.bodies[i].dofs.clone() {
            workspace.perturbations[d] = match model.dofs[d].component.checked_sub(3) {
                Some(_) if falling && is_base(model, i) => AccelerationPerturbation::zero(),
                Some(k) => AccelerationPerturbation {
                    uniform: sum.cross(Vector3::unit(k)),
                    ..AccelerationPerturbation::zero()
                },
                None => {
                    let s = Vector3::unit(model.dofs[d].component);
                    AccelerationPerturbation {
                        gradient: sum.cross(s),
                        relative: ancestor.back.cross(s),
                        coriolis: s,
                        uniform: s.cross(ancestor.velocity),
                    }
                }
            };
        }
    }
}

/// The motion of a joint's parent frame, in the child frame's axes, at the point that coincides
/// with the child frame's origin.
struct AncestorMotion<S> {
    omega: Vector3<S>,
    /// E of [`Field`].
    gradient: Matrix3<S>,
    a: Vector3<S>,
    /// The velocity of the child frame's origin relative to the parent frame.
    velocity: Vector3<S>,
    /// The angular velocity of the parent frame relative to the child frame.
    back: Vector3<S>,
}

impl<S: Scalar> AncestorMotion<S> {
    fn of<T: BodyTree<S>>(
        tree: &T,
        i: usize,
        qd: &[S],
        falling: bool,
        workspace: &Workspace<S>,
    ) -> Self {
        let model = tree.mechanism();
        let motion = &workspace.motions[i];
        let field = &workspace.fields[i];
        let zero = Vector3::zero();
        match model.bodies[i].elementary_joint {
            // A revolute or prismatic axis is fixed in parent and child, so the child's motion will
            // do.
            ElementaryJoint::Revolute | ElementaryJoint::Prismatic => Self {
                omega: field.omega,
                gradient: field.gradient,
                a: field.a,
                velocity: zero,
                back: zero,
            },
            ElementaryJoint::Spherical | ElementaryJoint::Floating => {
                let from_parent = parent_motion(tree, i, workspace);
                let back = from_parent.omega - field.omega;
                let field = Field::rotating(from_parent.omega, from_parent.alpha);
                let mut a = from_parent.a;
                let mut velocity = zero;
                if let Some(displacement) = motion.displacement() {
                    let rates = model.rates(i, qd);
                    a += field.relative_acceleration(motion.to_child(displacement));
                    velocity = Vector3([rates[0], rates[1], rates[2]]);
                }
                if falling && is_base(model, i) {
                    (a, velocity) = (zero, zero);
                }
                Self { omega: from_parent.omega, gradient: field.gradient, a, velocity, back }
            }
        }
    }

    /// Returns the perturbation by a displacement in `component` that is fixed in the parent frame.
    fn displaced(&self, component: usize) -> AccelerationPerturbation<S> {
        if let Some(k) = component.checked_sub(3) {
            return AccelerationPerturbation {
                uniform: self.gradient.column(k),
                ..AccelerationPerturbation::zero()
            };
        }
        let s = Vector3::unit(component);
        let coriolis = self.omega.cross(s);
        let passing = coriolis.cross(self.velocity);
        let uniform = self.a.cross(s) + (passing + passing);
        // E_p s - 2 omega_p x (omega_p x s) = -E_p^T s
        let relative = (self.back + self.back).cross(coriolis) - self.gradient.row(component);
        AccelerationPerturbation {
            gradient: self.gradient.column(component),
            relative,
            coriolis,
            uniform,
        }
    }
}
