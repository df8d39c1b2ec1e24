//! The dampers that act with the velocities after a step: of joints, and by MuJoCo's `implicitfast` also
//! of tendons, and the velocity gains of actuators. Where the flag `eulerdamp` is disabled there are none.
//!
//! The matrix of these dampers has the sparsity of the mass matrix, as in MuJoCo: a damper couples two
//! joints only if one of them carries the other.

use alloc::{vec, vec::Vec};

use super::lengths::RowEntry;
use super::rows::SoftModel;
use crate::Scalar;
use crate::equations::actuation::{ActuationWorkspace, moments, velocity_gains};
use crate::mechanism::Mechanism;
use crate::model::{Integrator, Model};

/// Minus the derivatives of forces with respect to the velocities.
#[derive(Clone, Debug)]
pub struct DampingMatrix<S> {
    /// The diagonal: for each entry of qd; `None` where no damper acts.
    pub diagonal: Vec<Option<S>>,
    /// The entries beside the diagonal: their row and column, in either order, and their value.
    pub coupled: Vec<([usize; 2], S)>,
}

impl<S: Scalar> DampingMatrix<S> {
    /// Returns the matrix without dampers.
    #[must_use]
    pub fn zero(nv: usize) -> Self {
        Self { diagonal: vec![None; nv], coupled: Vec::new() }
    }

    /// Returns the matrix of the dampers of joints that act with the velocities after the step, and
    /// by `implicitfast` of tendons.
    pub(super) fn of_step(soft: &SoftModel<S>, model: &Mechanism<S>) -> Self {
        let mut matrix = Self::zero(model.nv);
        if soft.integrator == Integrator::ExplicitEuler {
            return matrix;
        }
        for dof in &model.dofs {
            if let Some(damping) = dof.damping {
                let multiplier = dof.multiplier.unwrap_or_else(S::one);
                matrix.add_to_diagonal(dof.v, multiplier * damping * multiplier);
            }
        }
        let is_implicit = soft.integrator == Integrator::ImplicitFast;
        for tendon in soft.tendons.iter().filter(|_| is_implicit) {
            if let Some(damping) = tendon.damping {
                matrix.add_damper(model, &tendon.length.entries(), damping);
            }
        }
        matrix
    }

    /// Returns the matrix of the velocity gains of actuators whose forces were computed in this
    /// workspace; without dampers, unless the integrator is `implicitfast`.
    pub(super) fn of_actuators(
        model: &Model,
        mechanism: &Mechanism<S>,
        workspace: &ActuationWorkspace<S>,
    ) -> Self {
        let mut matrix = Self::zero(mechanism.nv);
        if model.soft_constraints().integrator == Integrator::ImplicitFast {
            let gains = velocity_gains(model, workspace);
            for (actuator, gain) in model.actuation().actuators.iter().zip(gains) {
                let Some(gain) = gain else { continue };
                let entry = |(dof, moment)| RowEntry { dof, factor: S::from_f64(moment) };
                let entries: Vec<RowEntry<S>> =
                    moments(model, actuator).into_iter().map(entry).collect();
                matrix.add_damper(mechanism, &entries, -gain);
            }
        }
        matrix
    }

    /// Adds a damper of the rate of a length.
    pub(super) fn add_damper(&mut self, model: &Mechanism<S>, entries: &[RowEntry<S>], damping: S) {
        for (k, &first) in entries.iter().enumerate() {
            self.add_to_diagonal(first.dof, first.factor * damping * first.factor);
            for &second in &entries[k + 1..] {
                let places = [first.dof, second.dof];
                if are_on_one_path(model, places) {
                    self.coupled.push((places, first.factor * damping * second.factor));
                }
            }
        }
    }

    /// Adds another matrix.
    pub(super) fn add(&mut self, other: &Self) {
        for (dof, damping) in other.diagonal.iter().enumerate() {
            if let Some(damping) = *damping {
                self.add_to_diagonal(dof, damping);
            }
        }
        self.coupled.extend_from_slice(&other.coupled);
    }

    fn add_to_diagonal(&mut self, dof: usize, damping: S) {
        let sum = &mut self.diagonal[dof];
        *sum = Some(sum.map_or(damping, |sum| sum + damping));
    }

    /// Returns whether no damper acts.
    pub(super) fn is_zero(&self) -> bool {
        self.diagonal.iter().all(Option::is_none) && self.coupled.is_empty()
    }

    /// Returns the matrix with `f` applied to its entries.
    pub(super) fn map<T>(&self, f: impl Fn(S) -> T) -> DampingMatrix<T> {
        DampingMatrix {
            diagonal: self.diagonal.iter().map(|entry| entry.map(&f)).collect(),
            coupled: self.coupled.iter().map(|&(places, entry)| (places, f(entry))).collect(),
        }
    }

    /// Returns the matrix times a number.
    pub(super) fn scaled(&self, factor: S) -> Self {
        Self {
            diagonal: self.diagonal.iter().map(|entry| entry.map(|x| x * factor)).collect(),
            coupled: self.coupled.iter().map(|&(places, x)| (places, x * factor)).collect(),
        }
    }

    /// Returns the entries, each with its row and its column. There may be several in one place.
    pub(super) fn entries(&self) -> impl Iterator<Item = ([usize; 2], S)> {
        let diagonal = self.diagonal.iter().enumerate();
        let coupled = self
            .coupled
            .iter()
            .flat_map(|&([row, column], entry)| [([row, column], entry), ([column, row], entry)]);
        diagonal.filter_map(|(k, entry)| Some(([k; 2], (*entry)?))).chain(coupled)
    }

    /// Returns the product with a joint vector.
    pub(super) fn times(&self, x: &[S]) -> Vec<S> {
        let mut product = vec![S::zero(); x.len()];
        for ([row, column], entry) in self.entries() {
            product[row] = product[row] + entry * x[column];
        }
        product
    }
}

/// Returns whether a damper of these entries of qd couples some of them.
pub(crate) fn couples<S: Scalar>(model: &Mechanism<S>, entries: &[usize]) -> bool {
    let later = |k: usize| entries[k + 1..].iter().map(move |&second| [entries[k], second]);
    (0..entries.len()).flat_map(later).any(|pair| are_on_one_path(model, pair))
}

/// Returns whether one of two entries of qd moves a body that carries a body of the other.
fn are_on_one_path<S: Scalar>(model: &Mechanism<S>, entries: [usize; 2]) -> bool {
    let bodies =
        |entry: usize| model.dofs.iter().filter(move |dof| dof.v == entry).map(|dof| dof.body);
    let carries = |ancestor: usize, body: usize| {
        let parent = |&body: &usize| model.bodies[body].parent;
        core::iter::successors(Some(body), parent).any(|body| body == ancestor)
    };
    let [first, second] = entries;
    bodies(first).any(|a| bodies(second).any(|b| carries(a, b) || carries(b, a)))
}
