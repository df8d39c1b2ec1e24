//! Steps of robots whose mass matrix is factorized as a whole, since mimic joints, loops, tendons or
//! couplings couple its links.

use alloc::{vec, vec::Vec};

use super::responses::{Effect, ImplicitDampers};
use crate::Scalar;
use crate::equations::dynamics::{inverse_dynamics, mass_matrix};
use crate::equations::factorization::{UduLayout, factorize_matrix, solve};
use crate::equations::{State, TimeStepInput, Workspace};
use crate::mechanism::Mechanism;

/// The matrices of a step.
pub(super) struct DenseProblem<S> {
    /// The mass matrix by columns.
    mass: Vec<S>,
    /// The joint forces that accelerate the robot.
    forces: Vec<S>,
    /// For each row of the constraints, its acceleration by each unit acceleration of a joint.
    jacobian: Vec<Vec<S>>,
}

impl<S: Scalar> DenseProblem<S> {
    /// Returns the matrices without rows. The workspace is used.
    pub fn new(
        model: &Mechanism<S>,
        input: TimeStepInput<'_, S>,
        workspace: &mut Workspace<S>,
    ) -> Self {
        let TimeStepInput { q, qd, tau, .. } = input;
        let mut forces = vec![S::zero(); model.nv];
        inverse_dynamics(model, State { q, qd }, None, None, workspace, &mut forces);
        for (force, &tau) in forces.iter_mut().zip(tau) {
            *force = tau - *force;
        }
        let mut mass = vec![S::zero(); model.nv * model.nv];
        mass_matrix(model, q, workspace, &mut mass);
        Self { mass, forces, jacobian: Vec::new() }
    }

    /// Returns the matrices with the rows of a problem, relative to the accelerations `fall` of free fall.
    pub fn with_rows(mut self, fall: &[S], jacobian: Vec<Vec<S>>) -> Self {
        for (column, &fall) in self.mass.chunks(fall.len()).zip(fall) {
            for (force, &mass) in self.forces.iter_mut().zip(column) {
                *force = *force - mass * fall;
            }
        }
        self.jacobian = jacobian;
        self
    }

    /// Returns the joint accelerations, relative to free fall, under these forces of the rows.
    pub fn accelerations(&self, layout: &UduLayout, forces: &[S], effect: Effect<'_, S>) -> Vec<S> {
        let nv = self.forces.len();
        let mut sum = self.forces.clone();
        for (row, &force) in self.jacobian.iter().zip(forces) {
            for (sum, &entry) in sum.iter_mut().zip(row) {
                *sum = *sum + entry * force;
            }
        }
        let mut matrix = self.mass.clone();
        let mut add = |a: &[S], b: &[S], stiffness: S| {
            for (column, &a) in matrix.chunks_mut(nv).zip(a) {
                for (entry, &b) in column.iter_mut().zip(b) {
                    *entry = *entry + a * stiffness * b;
                }
            }
        };
        match effect {
            Effect::Stiff(laws) => {
                let mut rest = &self.jacobian[..];
                for response in &laws.contacts {
                    let (rows, others) = rest.split_at(response.force.len());
                    rest = others;
                    for (i, stiffness) in response.stiffness.iter().enumerate() {
                        for (j, &stiffness) in stiffness.iter().enumerate() {
                            add(&rows[j], &rows[i], stiffness);
                        }
                    }
                }
                for (&[_, stiffness], row) in laws.single_rows.iter().zip(rest) {
                    add(row, row, stiffness);
                }
            }
            Effect::Forces(ImplicitDampers { armature, forces }) => {
                for ([row, column], entry) in armature.entries() {
                    let sum = &mut matrix[column * nv + row];
                    *sum = *sum + entry;
                }
                forces.iter().for_each(|&(dof, force)| sum[dof] = sum[dof] + force);
            }
        }
        let mut pivots = vec![S::zero(); layout.pivots()];
        let mut factors = vec![S::zero(); layout.size()];
        factorize_matrix(layout, &mut matrix, &mut pivots, &mut factors);
        solve(layout, &factors, &mut sum);
        sum
    }
}
