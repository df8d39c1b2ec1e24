//! Moving in the space of the coordinates, as graphs. Neutral coordinates are constants:
//! [`coordinates::neutral`] on numbers.

use modyn_runtime::Scalar;
use modyn_runtime::equations::kinematics::coordinates;

use super::Tracer;
use crate::graph::{Expr, Graph};

impl Tracer<'_> {
    /// The coordinates `q` moved, from `q` and tangent vector `v`.
    #[must_use]
    pub fn integrate(&self) -> Graph {
        self.trace(|model, [q, v]| {
            let mut moved = self.coordinates();
            coordinates::integrate(model, (&q, &v), &mut moved);
            moved
        })
    }

    /// The tangent vector from coordinates `from` and `to`.
    #[must_use]
    pub fn difference(&self) -> Graph {
        self.trace_groups([self.model.nq; 2], |model, [from, to]| {
            let mut v = self.vector();
            coordinates::difference(model, (&from, &to), &mut v);
            v
        })
    }

    /// The rates of the coordinates from `q`, `qd`.
    #[must_use]
    pub fn velocity_to_qdot(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let mut rates = self.coordinates();
            coordinates::velocity_to_qdot(model, (&q, &qd), &mut rates);
            rates
        })
    }

    /// Coordinates with quaternions of length 1 from `q`.
    #[must_use]
    pub fn normalize(&self) -> Graph {
        self.trace(|model, [mut q]| {
            coordinates::normalize(model, &mut q);
            q
        })
    }

    /// Random coordinates from [`uniforms`](Self::uniforms) numbers in 0..1.
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

    /// How many numbers [`random`](Self::random) takes: one a degree of freedom.
    #[must_use]
    pub fn uniforms(&self) -> usize {
        self.model.nv
    }

    fn coordinates(&self) -> Vec<Expr> {
        vec![Expr::zero(); self.model.nq]
    }
}
