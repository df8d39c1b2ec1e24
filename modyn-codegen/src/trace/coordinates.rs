//! The graphs of the configuration space. Neutral coordinates are constants:
//! [`coordinates::neutral`] on numbers.

use modyn_runtime::Scalar;
use modyn_runtime::equations::kinematics::coordinates;

use super::Tracer;
use crate::graph::{Expr, Graph};

impl Tracer<'_> {
    /// Returns the graph of the moved coordinates. Inputs: `q` and the tangent vector `v`.
    #[must_use]
    pub fn integrate(&self) -> Graph {
        self.trace(|model, [q, v]| {
            let mut moved = self.coordinates();
            coordinates::integrate(model, &q, &v, &mut moved);
            moved
        })
    }

    /// Returns the graph of the derivatives of the moved coordinates by `q`, then by `v`, by
    /// columns. Inputs: `q` and `v`.
    #[must_use]
    pub fn integrate_derivatives(&self) -> Graph {
        self.trace(|model, [_, v]| {
            let mut dq = self.square();
            let mut dv = self.square();
            coordinates::integrate_derivatives(model, &v, &mut dq, &mut dv);
            [dq, dv].concat()
        })
    }

    /// Returns the graph of the rates of the coordinates. Inputs: `q`, `qd`.
    #[must_use]
    pub fn velocity_to_qdot(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let mut rates = self.coordinates();
            coordinates::velocity_to_qdot(model, &q, &qd, &mut rates);
            rates
        })
    }

    /// Returns the graph of coordinates with quaternions of length 1. Inputs: `q`.
    #[must_use]
    pub fn normalize_configuration(&self) -> Graph {
        self.trace(|model, [mut q]| {
            coordinates::normalize_configuration(model, &mut q);
            q
        })
    }

    fn square(&self) -> Vec<Expr> {
        vec![Expr::zero(); self.model.nv * self.model.nv]
    }

    fn coordinates(&self) -> Vec<Expr> {
        vec![Expr::zero(); self.model.nq]
    }
}
