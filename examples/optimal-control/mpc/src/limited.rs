//! The least value of a quadratic function within limits, by the projected Newton method.
//!
//! - Tassa, Mansard and Todorov 2014, "Control-limited differential dynamic programming".

use modyn::Scalar;

use crate::matrix::{Matrix, add_scaled, dot};
use crate::solver::Limits;

/// The rows of a Cholesky factor L; the diagonal is stored as its reciprocal. The row of an input at a limit is a row of
/// the identity.
pub(crate) struct Factor<const NU: usize> {
    pub(crate) rows: Matrix<NU, NU>,
    /// Whether an input is free to change.
    pub(crate) free: [bool; NU],
}

impl<const NU: usize> Factor<NU> {
    /// Returns the factor of the matrix plus `damping` on its diagonal; `None` if the matrix is not positive definite.
    #[inline(always)]
    fn new(matrix: &Matrix<NU, NU>, damping: f64, free: [bool; NU]) -> Option<Self> {
        let mut rows = [[0.0; NU]; NU];
        for i in 0..NU {
            if !free[i] {
                rows[i][i] = 1.0;
                continue;
            }
            for j in 0..i {
                if free[j] {
                    let known = dot(&rows[i][..j], &rows[j][..j]);
                    rows[i][j] = (matrix[i][j] - known) * rows[j][j];
                }
            }
            let square = matrix[i][i] + damping - dot(&rows[i][..i], &rows[i][..i]);
            if square <= 0.0 || square.is_nan() {
                return None;
            }
            rows[i][i] = Scalar::recip(Scalar::sqrt(square));
        }
        Some(Self { rows, free })
    }

    /// Replaces b by L^-1 b, with zeros for inputs at a limit. An entry of b is a row of a matrix.
    #[inline(always)]
    pub(crate) fn solve_lower<const C: usize>(&self, b: &mut Matrix<NU, C>) {
        for i in 0..NU {
            if !self.free[i] {
                b[i] = [0.0; C];
                continue;
            }
            let (before, rest) = b.split_at_mut(i);
            for (factor, row) in self.rows[i].iter().zip(before) {
                add_scaled(&mut rest[0], -factor, row);
            }
            rest[0] = rest[0].map(|x| x * self.rows[i][i]);
        }
    }

    /// Replaces b by L^-T b.
    #[inline(always)]
    pub(crate) fn solve_upper<const C: usize>(&self, b: &mut Matrix<NU, C>) {
        for i in (0..NU).rev() {
            let (before, after) = b.split_at_mut(i + 1);
            for (factor, row) in self.rows[i + 1..].iter().zip(after) {
                add_scaled(&mut before[i], -factor[i], row);
            }
            before[i] = before[i].map(|x| x * self.rows[i][i]);
        }
    }

    /// Returns the vector that the matrix takes to b, with zeros for inputs at a limit.
    #[inline(always)]
    fn solve(&self, b: &[f64; NU]) -> [f64; NU] {
        let mut x = b.map(|b| [b]);
        self.solve_lower(&mut x);
        self.solve_upper(&mut x);
        x.map(|[x]| x)
    }
}

/// A quadratic function of a change x of the inputs: x^T (H + damping) x / 2 + g^T x.
pub(crate) struct Quadratic<'a, const NU: usize> {
    pub(crate) hessian: &'a Matrix<NU, NU>,
    pub(crate) gradient: &'a [f64; NU],
    pub(crate) damping: f64,
}

/// The change with the least value, and the factor of the Hessian at the free inputs.
pub(crate) struct Minimum<const NU: usize> {
    pub(crate) change: [f64; NU],
    pub(crate) factor: Factor<NU>,
}

/// The greatest numbers of changes of the free inputs, and of halvings in a line search.
const CHANGES: usize = 20;
const HALVINGS: usize = 20;
/// The squared gradient below which the free inputs have the least value, relative to the squared gradient at zero.
const CONVERGED: f64 = 1e-20;
/// The part of the promised decrease that a step must reach.
const SUFFICIENT: f64 = 0.1;

impl<const NU: usize> Quadratic<'_, NU> {
    /// Returns the least value within limits; `start` is a guess of it. `None` if the Hessian is not positive definite.
    #[inline(always)]
    pub(crate) fn minimum(&self, limits: &Limits<NU>, start: &[f64; NU]) -> Option<Minimum<NU>> {
        let factor = Factor::new(self.hessian, self.damping, [true; NU])?;
        let change = factor.solve(&self.gradient.map(|g| -g));
        if limits.contain(&change) {
            return Some(Minimum { change, factor });
        }
        let mut minimum = Minimum { change: limits.clamp(start), factor };
        for _ in 0..CHANGES {
            let slope = self.slope(&minimum.change);
            let free = limits.free(&minimum.change, &slope);
            if minimum.factor.free != free {
                minimum.factor = Factor::new(self.hessian, self.damping, free)?;
            }
            let downhill: [f64; NU] =
                core::array::from_fn(|i| if free[i] { -slope[i] } else { 0.0 });
            if dot(&downhill, &downhill) <= CONVERGED * dot(self.gradient, self.gradient) {
                break;
            }
            let direction = minimum.factor.solve(&downhill);
            let decrease = SUFFICIENT * dot(&slope, &direction);
            let value = self.value(&minimum.change);
            let mut length = 1.0;
            for _ in 0..HALVINGS {
                let change = limits
                    .clamp(&core::array::from_fn(|i| minimum.change[i] + length * direction[i]));
                if self.value(&change) <= value + length * decrease {
                    minimum.change = change;
                    break;
                }
                length *= 0.5;
            }
        }
        Some(minimum)
    }

    /// Returns the gradient at a change.
    #[inline(always)]
    fn slope(&self, change: &[f64; NU]) -> [f64; NU] {
        core::array::from_fn(|i| {
            dot(&self.hessian[i], change) + self.damping * change[i] + self.gradient[i]
        })
    }

    #[inline(always)]
    fn value(&self, change: &[f64; NU]) -> f64 {
        let slope = self.slope(change);
        0.5 * (dot(&slope, change) + dot(self.gradient, change))
    }
}
