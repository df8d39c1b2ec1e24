//! Perturbations: the changes of the points' accelerations by a degree of freedom's coordinate or
//! rate.

use crate::Scalar;
use crate::equations::Workspace;
use crate::equations::dynamics::newton_euler::is_base;
use crate::equations::kinematics::acceleration::parent_motion;
use crate::joint::ElementaryJoint;
use crate::mechanism::BodyTree;
use crate::spatial::{AccelerationPerturbation, Field, Matrix3, SpatialAxis, Vector3};

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
            workspace.perturbations[d] = ancestor.displaced(model.dofs[d].axis());
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
            workspace.perturbations[d] = match model.dofs[d].axis() {
                SpatialAxis::Linear(_) if falling && is_base(model, i) => {
                    AccelerationPerturbation::zero()
                }
                SpatialAxis::Linear(k) => AccelerationPerturbation {
                    uniform: sum.cross(Vector3::unit(k)),
                    ..AccelerationPerturbation::zero()
                },
                SpatialAxis::Angular(k) => {
                    let s = Vector3::unit(k);
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

    /// Returns the perturbation by a displacement along `axis` that is fixed in the parent frame.
    fn displaced(&self, axis: SpatialAxis) -> AccelerationPerturbation<S> {
        let k = match axis {
            SpatialAxis::Linear(k) => {
                return AccelerationPerturbation {
                    uniform: self.gradient.column(k),
                    ..AccelerationPerturbation::zero()
                };
            }
            SpatialAxis::Angular(k) => k,
        };
        let s = Vector3::unit(k);
        let coriolis = self.omega.cross(s);
        let passing = coriolis.cross(self.velocity);
        let uniform = self.a.cross(s) + (passing + passing);
        // E_p s - 2 omega_p x (omega_p x s) = -E_p^T s
        let relative = (self.back + self.back).cross(coriolis) - self.gradient.row(k);
        AccelerationPerturbation { gradient: self.gradient.column(k), relative, coriolis, uniform }
    }
}
