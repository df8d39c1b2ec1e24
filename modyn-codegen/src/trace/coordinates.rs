//! The graphs of the configuration space. Neutral coordinates are constants: [`coordinates::neutral`] on numbers.

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
            coordinates::integrate(model, (&q, &v), &mut moved);
            moved
        })
    }

    /// Returns the graph of the tangent vector between coordinates. Inputs: `from` and `to`.
    #[must_use]
    pub fn difference(&self) -> Graph {
        self.trace_groups([self.model.nq; 2], |model, [from, to]| {
            let mut v = self.vector();
            coordinates::difference(model, (&from, &to), &mut v);
            v
        })
    }

    /// Returns the graph of the derivatives of the moved coordinates by `q`, then by `v`, by columns. Inputs: `q` and `v`.
    #[must_use]
    pub fn integrate_derivatives(&self) -> Graph {
        self.trace(|model, [_, v]| {
            let (mut dq, mut dv) = (self.square(), self.square());
            coordinates::integrate_derivatives(model, &v, (&mut dq, &mut dv));
            [dq, dv].concat()
        })
    }

    /// Returns the graph of the derivatives of the tangent vector between coordinates by `from`, then by `to`, by
    /// columns. Inputs: `from` and `to`.
    #[must_use]
    pub fn difference_derivatives(&self) -> Graph {
        self.trace_groups([self.model.nq; 2], |model, [from, to]| {
            let (mut dfrom, mut dto) = (self.square(), self.square());
            coordinates::difference_derivatives(model, (&from, &to), (&mut dfrom, &mut dto));
            [dfrom, dto].concat()
        })
    }

    /// Returns the graph of the rates of the coordinates. Inputs: `q`, `qd`.
    #[must_use]
    pub fn velocity_to_qdot(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let mut rates = self.coordinates();
            coordinates::velocity_to_qdot(model, (&q, &qd), &mut rates);
            rates
        })
    }

    /// Returns the graph of coordinates with quaternions of length 1. Inputs: `q`.
    #[must_use]
    pub fn normalize(&self) -> Graph {
        self.trace(|model, [mut q]| {
            coordinates::normalize(model, &mut q);
            q
        })
    }

    /// Returns the graph of random coordinates. Inputs: [`uniforms`](Self::uniforms) numbers in 0..1.
    #[must_use]
    pub fn random(&self) -> Graph {
        self.trace_groups([self.uniforms()], |model, [uniforms]| {
            let mut q = self.coordinates();
            let mut next = uniforms.into_iter();
            let mut uniform = || next.next().unwrap_or_else(Expr::zero);
            coordinates::random(model, &mut uniform, &mut q);
            q
        })
    }

    /// Returns the number of inputs of [`random`](Self::random): one for each degree of freedom.
    #[must_use]
    pub fn uniforms(&self) -> usize {
        self.model.nv
    }

    fn square(&self) -> Vec<Expr> {
        vec![Expr::zero(); self.model.nv * self.model.nv]
    }

    fn coordinates(&self) -> Vec<Expr> {
        vec![Expr::zero(); self.model.nq]
    }
}
