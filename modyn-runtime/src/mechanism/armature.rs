//! The velocity-dependent forces of the armature of floating joints.
//!
//! The armature a of a floating joint is inertia in all directions: its kinetic energy is a/2
//! (v^2 + omega^2) with the velocities v and omega, in the link's own axes, which rotate. Its force
//! on the origin is therefore a times the classical acceleration, which is the rate of v plus omega
//! x v. The moments have no such part, since omega x omega = 0.

use super::Mechanism;
use crate::Scalar;
use crate::joint::ElementaryJoint;
use crate::spatial::{Matrix3, Vector3};

/// A floating joint with armature, and its motion.
struct Moving<S> {
    armature: S,
    /// The index of the first degree of freedom; the linear ones are first.
    first: usize,
    linear: Vector3<S>,
    angular: Vector3<S>,
}

impl<S: Scalar> Mechanism<S> {
    /// Returns the joint of body `i` and its motion at the rates `qd`, if it is a floating joint
    /// with armature.
    fn moving_armature(&self, i: usize, qd: &[S]) -> Option<Moving<S>> {
        let body = &self.bodies[i];
        if body.elementary_joint != ElementaryJoint::Floating {
            return None;
        }
        let armature = self.dofs_of(i).first()?.armature?;
        let [a, b, c, x, y, z] = self.rates(i, qd).numbers;
        let linear = Vector3([a, b, c]);
        let angular = Vector3([x, y, z]);
        Some(Moving { armature, first: body.dofs.start, linear, angular })
    }

    /// Returns the forces a (omega x v) of the armature of body `i`'s joint at the rates `qd`,
    /// along its linear degrees of freedom; `None` if it is no floating joint with armature.
    #[must_use]
    pub(crate) fn armature_forces(&self, i: usize, qd: &[S]) -> Option<Vector3<S>> {
        let Moving { armature, linear, angular, .. } = self.moving_armature(i, qd)?;
        Some(angular.cross(linear).scale(armature))
    }

    /// Calls `add` for the derivatives of the [`armature_forces`](Self::armature_forces) with
    /// respect to the rates, with two degrees of freedom: the force's and the rate's.
    pub(crate) fn armature_derivatives(&self, qd: &[S], mut add: impl FnMut(usize, usize, S)) {
        for i in 0..self.bodies.len() {
            let Some(moving) = self.moving_armature(i, qd) else { continue };
            let Moving { armature, first, linear, angular } = moving;
            for (column, v) in [(0, angular), (3, -linear)] {
                for (row, entries) in Matrix3::cross(v.scale(armature)).0.into_iter().enumerate() {
                    for (k, entry) in entries.into_iter().enumerate().filter(|(k, _)| *k != row) {
                        add(first + row, first + column + k, entry);
                    }
                }
            }
        }
    }

    /// Calls `add` for the part of the Coriolis matrix that belongs to the
    /// [`armature_forces`](Self::armature_forces), with the degrees of freedom of row and column.
    /// It is skew.
    pub(crate) fn armature_coriolis(&self, qd: &[S], mut add: impl FnMut(usize, usize, S)) {
        self.armature_derivatives(qd, |row, column, entry| {
            if !self.dofs[column].axis().is_angular() {
                add(row, column, entry);
            }
        });
    }
}
