//! Expressions as scalars: tracing.
//!
//! An `Expr` has the number of its trace. If it is used in another trace, `Graph::try_trace`
//! returns an error, and `Graph::trace`, for modyn's own equations, panics.

use std::cell::RefCell;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Range, Sub};
use std::sync::atomic::{AtomicU32, Ordering};

use modyn_runtime::{LaneScalar, Scalar};

use super::{Graph, Id, Node, limit};

/// The graph that a thread is tracing.
#[derive(Default)]
struct OpenGraph {
    /// The number of the trace; 0 outside of any trace.
    number: u32,
    graph: Graph,
    /// Whether an expression of another trace was used.
    foreign: bool,
}

thread_local! {
    static TRACED: RefCell<OpenGraph> = RefCell::default();
}

/// The number of the next trace of any thread, since expressions may be sent to other threads.
static NEXT: AtomicU32 = AtomicU32::new(1);

/// A symbolic number: a node of the graph that is being traced.
///
/// An expression belongs to the trace in which it was created. Expressions of another trace have no
/// meaning; [`Graph::try_trace`] returns an error if one is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expr {
    id: Id,
    trace: u32,
}

/// An expression of one trace was used in another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ForeignExpr;

impl fmt::Display for ForeignExpr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "an expression of another trace was used: create inputs and constants in the \
             function that `Graph::trace` runs, and return the outputs from there",
        )
    }
}

impl std::error::Error for ForeignExpr {}

impl Graph {
    /// Returns the graph of `equations`, which create their inputs with [`Expr::input`] and return
    /// their outputs.
    ///
    /// A trace inside a trace starts a graph of its own; the outer trace continues afterwards.
    ///
    /// # Errors
    ///
    /// If `equations` use or return an expression of another trace, which would refer to an
    /// unrelated node of this graph.
    pub fn try_trace(equations: impl FnOnce() -> Vec<Expr>) -> Result<Self, ForeignExpr> {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let outer = TRACED.replace(OpenGraph { number, ..OpenGraph::default() });
        let outputs = equations();
        let OpenGraph { mut graph, mut foreign, .. } = TRACED.replace(outer);
        limit::count(graph.nodes().len());
        foreign |= outputs.iter().any(|output| output.trace != number);
        graph.outputs = outputs.into_iter().map(|output| output.id).collect();
        if limit::is_exceeded() {
            // The passes over a graph that does not count would take longer than the trace.
            graph = Graph::of_zeros(graph.outputs.len());
        }
        if foreign { Err(ForeignExpr) } else { Ok(graph) }
    }

    /// Returns the graph of `equations` that use their own expressions only, as all equations of
    /// modyn do.
    ///
    /// # Panics
    ///
    /// If [`try_trace`](Self::try_trace) returns an error.
    pub fn trace(equations: impl FnOnce() -> Vec<Expr>) -> Self {
        Self::try_trace(equations).unwrap_or_else(|error| panic!("{error}"))
    }
}

impl Expr {
    /// Returns the input with this number.
    #[must_use]
    pub fn input(number: usize) -> Self {
        Self::make([], |[]| Node::input(number))
    }

    /// Returns the pack of these numbers; copies of the last one fill it up to a power of two.
    ///
    /// # Panics
    ///
    /// If `numbers` is empty, or has more than 128 entries.
    #[must_use]
    pub fn pack(numbers: &[Self]) -> Self {
        fn filled(numbers: &[Expr], lanes: usize) -> Expr {
            if lanes == 1 {
                return numbers[0];
            }
            let (a, b) = numbers.split_at((lanes / 2).min(numbers.len()));
            let first = filled(a, lanes / 2);
            let rest = if b.is_empty() { &a[a.len() - 1..] } else { b };
            let width = u8::try_from(lanes).expect("few lanes");
            let second = filled(rest, lanes / 2);
            Expr::make([first, second], |[a, b]| Node::Pack(a, b, width))
        }
        filled(numbers, numbers.len().next_power_of_two())
    }

    /// Returns one lane of a pack.
    #[must_use]
    pub fn extract_lane(self, lane: usize) -> Self {
        let lane = u8::try_from(lane).expect("few lanes");
        Self::make([self], |[a]| Node::ExtractLane(a, lane))
    }

    /// Returns the node of these operands.
    fn make<const N: usize>(operands: [Self; N], node: impl FnOnce([Id; N]) -> Node) -> Self {
        TRACED.with_borrow_mut(|OpenGraph { number, graph, foreign }| {
            let ids = operands.map(|operand| {
                if operand.trace == *number {
                    return operand.id;
                }
                // Any node of this graph will do: the trace has failed.
                *foreign = true;
                graph.make(Node::Constant(0))
            });
            Self { id: graph.make(node(ids)), trace: *number }
        })
    }
}

impl Add for Expr {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::make([self, other], |[a, b]| Node::Add(a, b))
    }
}

impl Sub for Expr {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::make([self, other], |[a, b]| Node::Sub(a, b))
    }
}

impl Mul for Expr {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::make([self, other], |[a, b]| Node::Mul(a, b))
    }
}

/// Division multiplies by the reciprocal, which the graph has once for all divisions by the same
/// number.
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
        Self::make([self], |[a]| Node::Neg(a))
    }
}

impl Scalar for Expr {
    fn from_f64(value: f64) -> Self {
        Self::make([], |[]| Node::Constant(value.to_bits()))
    }

    fn recip(self) -> Self {
        Self::make([self], |[a]| Node::Recip(a))
    }

    fn sin_cos(self) -> (Self, Self) {
        (Self::make([self], |[a]| Node::Sin(a)), Self::make([self], |[a]| Node::Cos(a)))
    }

    fn atan2(self, x: Self) -> Self {
        Self::make([self, x], |[a, b]| Node::Atan2(a, b))
    }

    fn sqrt(self) -> Self {
        Self::make([self], |[a]| Node::Sqrt(a))
    }

    fn ln(self) -> Self {
        Self::make([self], |[a]| Node::Ln(a))
    }

    fn abs(self) -> Self {
        Self::make([self], |[a]| Node::Abs(a))
    }

    fn max(self, other: Self) -> Self {
        Self::make([self, other], |[a, b]| Node::Max(a, b))
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        Self::make([self, then, otherwise], |[a, b, c]| Node::Select(a, b, c))
    }

    fn is_constant_zero(self) -> bool {
        TRACED.with_borrow(|trace| {
            self.trace == trace.number && trace.graph.value(self.id) == Some(0.0)
        })
    }
}

impl LaneScalar for Expr {
    fn pack(each: &[Self]) -> Self {
        Self::pack(each)
    }

    fn extract_lane(self, lane: usize) -> Self {
        self.extract_lane(lane)
    }

    fn sum_lanes(self, lanes: Range<usize>) -> Self {
        // Pairwise, so that the chain of dependent additions is short.
        fn sum(x: Expr, lanes: Range<usize>) -> Expr {
            if lanes.len() == 1 {
                return x.extract_lane(lanes.start);
            }
            let middle = lanes.start + lanes.len() / 2;
            sum(x, lanes.start..middle) + sum(x, middle..lanes.end)
        }
        sum(self, lanes)
    }
}
