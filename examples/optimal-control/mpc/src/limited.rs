//! The least value of a quadratic function within limits, by the projected Newton method.
//!
//! - Tassa, Mansard and Todorov 2014, "Control-limited differential dynamic programming".

use modyn::Scalar;

use crate::matrix::{Matrix, add_scaled, dot};
use crate::solver::Limits;

/// The factors of a symmetric matrix U^T D U: U has ones on its diagonal and zeros below it, D is diagonal. The rows and
/// the columns of inputs at a limit are zero in U - 1 and in D^-1.
pub(crate) struct Factor<const NU: usize> {
    /// The entries of U above the diagonal; the others are zero.
    upper: Matrix<NU, NU>,
    /// The diagonal of D^-1.
    reciprocals: [f64; NU],
    /// Whether an input is free to change.
    free: [bool; NU],
}

impl<const NU: usize> Factor<NU> {
    /// Returns the factors of the matrix plus `damping` on its diagonal; `None` if the matrix is not positive definite.
    #[inline(never)]
    fn new(matrix: &Matrix<NU, NU>, damping: f64, free: [bool; NU]) -> Option<Self> {
        let mut factor = Self { upper: [[0.0; NU]; NU], reciprocals: [0.0; NU], free };
        // The matrix that remains for the next rows.
        let mut rest = *matrix;
        for i in 0..NU {
            if !free[i] {
                continue;
            }
            let row = rest[i];
            let pivot = row[i] + damping;
            if pivot <= 0.0 || pivot.is_nan() {
                return None;
            }
            let reciprocal = Scalar::recip(pivot);
            for j in i + 1..NU {
                if free[j] {
                    factor.upper[i][j] = row[j] * reciprocal;
                    add_scaled(&mut rest[j], -factor.upper[i][j], &row);
                }
            }
            factor.reciprocals[i] = reciprocal;
        }
        Some(factor)
    }

    /// Replaces b by U^-T b. An entry of b is a row of a matrix.
    #[inline(never)]
    pub(crate) fn solve_lower<const C: usize>(&self, b: &mut Matrix<NU, C>) {
        for i in 0..NU {
            let (before, rest) = b.split_at_mut(i + 1);
            for (row, factor) in rest.iter_mut().zip(&self.upper[i][i + 1..]) {
                add_scaled(row, -factor, &before[i]);
            }
        }
    }

    /// Returns -D^-1 b: zeros for inputs at a limit.
    #[inline(always)]
    pub(crate) fn minus_divided<const C: usize>(&self, b: &Matrix<NU, C>) -> Matrix<NU, C> {
        core::array::from_fn(|i| b[i].map(|x| -self.reciprocals[i] * x))
    }

    /// Replaces b by U^-1 b.
    #[inline(never)]
    pub(crate) fn solve_upper<const C: usize>(&self, b: &mut Matrix<NU, C>) {
        for i in (0..NU).rev() {
            let (before, after) = b.split_at_mut(i + 1);
            for (factor, row) in self.upper[i][i + 1..].iter().zip(after) {
                add_scaled(&mut before[i], -factor, row);
            }
        }
    }

    /// Returns the vector that the matrix takes to -g, with zeros for inputs at a limit.
    #[inline(always)]
    fn step(&self, g: &[f64; NU]) -> [f64; NU] {
        let mut x = g.map(|g| [g]);
        self.solve_lower(&mut x);
        x = self.minus_divided(&x);
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
        let change = factor.step(self.gradient);
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
            let uphill: [f64; NU] = core::array::from_fn(|i| if free[i] { slope[i] } else { 0.0 });
            if dot(&uphill, &uphill) <= CONVERGED * dot(self.gradient, self.gradient) {
                break;
            }
            let direction = minimum.factor.step(&uphill);
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
