//! Discrete dynamics: the state after a time step, and its derivatives.
//!
//! The joint forces are constant during the step. Coordinates follow the exponential maps of their
//! spaces (`kinematics/coordinates`), so quaternions keep length 1.

mod implicit_midpoint;
mod knot;
mod runge_kutta;
mod semi_implicit;

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::mechanism::Mechanism;

pub use {implicit_midpoint::*, knot::*, runge_kutta::*, semi_implicit::*};

/// The state after a step, and its derivatives: the results of [`step_semi_implicit_derivatives`],
/// [`step_rk4_derivatives`] and [`step_implicit_midpoint_derivatives`].
#[derive(Debug)]
pub struct StepOutputs<'a, S> {
    /// The coordinates after the step.
    pub q: &'a mut [S],
    /// The velocities after the step.
    pub qd: &'a mut [S],
    /// The derivatives with respect to q (in tangent space), then qd, before the step: 2 nv columns
    /// of 2 nv entries, the entries of q (in tangent space) first.
    pub a: &'a mut [S],
    /// The derivatives with respect to tau: nv columns of 2 nv entries.
    pub b: &'a mut [S],
}

/// The memory of the explicit and semi-implicit steps.
#[derive(Clone, Debug)]
pub struct StepWorkspace<S> {
    /// Coordinates on the way.
    q: Vec<S>,
    /// A displacement of the coordinates.
    displacement: Vec<S>,
    /// The velocities at each evaluation but the first.
    velocities: [Vec<S>; 3],
    /// The accelerations at each evaluation.
    accelerations: [Vec<S>; 4],
    /// Square matrices: derivatives of the accelerations, then derivatives of the moved
    /// coordinates.
    matrices: [Vec<S>; 3],
}

impl<S: Scalar> StepWorkspace<S> {
    /// Returns the memory for a mechanism.
    #[must_use]
    pub fn new(model: &Mechanism<S>) -> Self {
        Self::of_lengths(model.nq, model.nv, model.nv * model.nv)
    }

    /// Returns the memory for vectors of coordinates and velocities and for matrices of these
    /// numbers of entries.
    fn of_lengths(coordinates: usize, velocities: usize, matrix: usize) -> Self {
        let vector = |_| vec![S::zero(); velocities];
        Self {
            q: vec![S::zero(); coordinates],
            displacement: vector(0),
            velocities: core::array::from_fn(vector),
            accelerations: core::array::from_fn(vector),
            matrices: core::array::from_fn(|_| vec![S::zero(); matrix]),
        }
    }
}

/// Computes a + factor b, entry by entry.
fn add_scaled<S: Scalar>(a: &[S], factor: S, b: &[S], sum: &mut [S]) {
    for ((sum, &a), &b) in sum.iter_mut().zip(a).zip(b) {
        *sum = a + factor * b;
    }
}

/// Computes factor x, entry by entry.
fn scale<S: Scalar>(factor: S, x: &[S], product: &mut [S]) {
    for (product, &x) in product.iter_mut().zip(x) {
        *product = factor * x;
    }
}
