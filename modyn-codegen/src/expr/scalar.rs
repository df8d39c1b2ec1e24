//! Expressions as scalars: tracing.

use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Range, Sub};

use modyn_runtime::{LaneScalar, Scalar};

use super::{Graph, Id, Node};

thread_local! {
    static TRACED: RefCell<Graph> = RefCell::default();
}

/// A number that is not known yet: a node of the graph being traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expr(Id);

impl Graph {
    /// Runs `equations` on expressions; `equations` makes its inputs with [`Expr::input`] and
    /// returns its outputs.
    ///
    /// A trace inside a trace starts afresh; the outer one then goes on where it was.
    pub fn trace(equations: impl FnOnce() -> Vec<Expr>) -> Self {
        let outer = TRACED.take();
        let outputs = equations();
        let mut graph = TRACED.replace(outer);
        graph.outputs = outputs.into_iter().map(|Expr(id)| id).collect();
        graph
    }
}

impl Expr {
    /// The input of that number.
    #[must_use]
    pub fn input(number: usize) -> Self {
        Self::make(Node::Input(u32::try_from(number).expect("fewer than 2^32 inputs")))
    }

    /// Numbers side by side; the last one fills them up to a power of two.
    ///
    /// # Panics
    ///
    /// If there are none, or more than 128.
    #[must_use]
    pub fn beside(numbers: &[Self]) -> Self {
        fn filled(numbers: &[Expr], lanes: usize) -> Expr {
            if lanes == 1 {
                return numbers[0];
            }
            let (a, b) = numbers.split_at((lanes / 2).min(numbers.len()));
            let first = filled(a, lanes / 2);
            let rest = if b.is_empty() { &a[a.len() - 1..] } else { b };
            let width = u8::try_from(lanes).expect("few lanes");
            Expr::make(Node::Beside(first.0, filled(rest, lanes / 2).0, width))
        }
        filled(numbers, numbers.len().next_power_of_two())
    }

    /// The number in a lane.
    #[must_use]
    pub fn lane(self, lane: usize) -> Self {
        Self::make(Node::Lane(self.0, u8::try_from(lane).expect("few lanes")))
    }

    fn make(node: Node) -> Self {
        Self(TRACED.with_borrow_mut(|graph| graph.make(node)))
    }
}

impl Add for Expr {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::make(Node::Add(self.0, other.0))
    }
}

impl Sub for Expr {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::make(Node::Sub(self.0, other.0))
    }
}

impl Mul for Expr {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::make(Node::Mul(self.0, other.0))
    }
}

/// By the reciprocal, which the graph has once for all that is divided by the same.
impl Div for Expr {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl)]
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}

impl Neg for Expr {
    type Output = Self;
    fn neg(self) -> Self {
        Self::make(Node::Neg(self.0))
    }
}

impl Scalar for Expr {
    fn from_f64(value: f64) -> Self {
        Self::make(Node::Constant(value.to_bits()))
    }

    fn recip(self) -> Self {
        Self::make(Node::Recip(self.0))
    }

    fn sin_cos(self) -> (Self, Self) {
        (Self::make(Node::Sin(self.0)), Self::make(Node::Cos(self.0)))
    }

    fn atan2(self, x: Self) -> Self {
        Self::make(Node::Atan2(self.0, x.0))
    }

    fn sqrt(self) -> Self {
        Self::make(Node::Sqrt(self.0))
    }

    fn ln(self) -> Self {
        Self::make(Node::Ln(self.0))
    }

    fn abs(self) -> Self {
        Self::make(Node::Abs(self.0))
    }

    fn max(self, other: Self) -> Self {
        Self::make(Node::Max(self.0, other.0))
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        Self::make(Node::Select(self.0, then.0, otherwise.0))
    }
}

impl LaneScalar for Expr {
    fn pack(each: &[Self]) -> Self {
        Self::beside(each)
    }

    fn extract_lane(self, lane: usize) -> Self {
        self.lane(lane)
    }

    fn sum_lanes(self, lanes: Range<usize>) -> Self {
        // In pairs: as few additions one behind the other as can be.
        fn sum(x: Expr, lanes: Range<usize>) -> Expr {
            if lanes.len() == 1 {
                return x.lane(lanes.start);
            }
            let middle = lanes.start + lanes.len() / 2;
            sum(x, lanes.start..middle) + sum(x, middle..lanes.end)
        }
        sum(self, lanes)
    }
}
