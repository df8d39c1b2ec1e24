//! The limit of the operations of a robot's functions. Functions are counted one after the other,
//! and the graph of one cannot grow far beyond the limit while it is traced.

use modyn_runtime::quantities::Function;

use super::context::PlanContext;
use super::planned::{Kernels, Planned};
use crate::graph::within;

/// The largest number of operations of all functions of a robot. Their text has about 40 MB.
pub const MAX_OPERATIONS: usize = 800_000;

/// The largest number of nodes that are traced for one function, of all candidates together.
const MAX_NODES: usize = 4 * MAX_OPERATIONS;

/// The number of numbers of a result whose text is as long as that of an operation. Most of a long
/// result are zeros.
const RESULTS: usize = 8;

/// The number of operations whose text is as long as the row of a body in the tables of loops.
const ROW: usize = 16;

/// The largest number of moving links of a robot. The searches for equal limbs and for modules take
/// quadratic time, and forward dynamics of a longer chain takes more than [`MAX_OPERATIONS`].
pub const MAX_LINKS: usize = 4000;

/// The reason why a robot's functions are too long.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TooLong {
    /// The robot has more than [`MAX_LINKS`].
    Robot,
    /// The functions take more than [`MAX_OPERATIONS`].
    Function {
        /// The function that is too long by itself or with those before it.
        name: &'static str,
        /// The functions before it, with their operations.
        before: Vec<(&'static str, usize)>,
    },
}

/// The operations that the functions of a robot may still take.
pub(super) struct Budget {
    left: usize,
    planned: Vec<(&'static str, usize)>,
}

impl Budget {
    pub(super) fn new() -> Self {
        Self { left: MAX_OPERATIONS, planned: Vec::new() }
    }

    /// Returns the result of `plan` for the function with this name, which takes at least `least`
    /// operations, and has the operations that `operations` counts.
    pub(super) fn spend<T>(
        &mut self,
        name: &'static str,
        least: usize,
        plan: impl FnOnce() -> T,
        operations: impl FnOnce(&T) -> usize,
    ) -> Result<T, TooLong> {
        let planned = (least <= self.left).then(|| within(MAX_NODES, plan)).flatten();
        let length = planned.as_ref().map_or(usize::MAX, operations);
        match (planned, self.left.checked_sub(length)) {
            (Some(planned), Some(left)) => {
                self.left = left;
                self.planned.push((name, length));
                Ok(planned)
            }
            _ => Err(TooLong::Function { name, before: std::mem::take(&mut self.planned) }),
        }
    }
}

impl PlanContext<'_> {
    /// Returns a number of operations that a function takes at least, without tracing it: those of
    /// its results, of the factors of the mass matrix if the function has a dense solution or
    /// result, and one for each ancestor of a link.
    pub(super) fn least_operations(&self, function: Function) -> usize {
        let row = function.row();
        let sizes = &self.sizes;
        let numbers = (row.result)(sizes).len();
        let programs = if row.by_link { self.frames.program_count() } else { 1 };
        let is_dense = numbers >= sizes.nv * sizes.nv
            || row.of_constraints
            || matches!(function.batched().unwrap_or(function), Function::StepImplicitMidpoint);
        // The factors of a chain of n joints have n^2 / 2 entries, and take n^3 / 3 operations.
        let factors = if is_dense { self.for_derivatives.size() * sizes.nv / 64 } else { 0 };
        let paths = if row.by_link { self.ancestors_of_links() } else { 0 };
        numbers.saturating_mul(programs) / RESULTS + factors + paths
    }
}

impl PlanContext<'_> {
    /// Returns the sum of the numbers of ancestors of all links with a program of their own.
    fn ancestors_of_links(&self) -> usize {
        let mut depths: Vec<usize> = Vec::new();
        for link in self.model.links() {
            // Parents come before their children.
            depths.push(link.parent.map_or(0, |parent| depths[parent] + 1));
        }
        let depth = |frame: usize| self.model.frames()[frame].link.map_or(0, |link| depths[link]);
        self.frames.links_with_own_program().map(depth).sum()
    }
}

impl Planned {
    /// Returns the length of the text in operations.
    pub(super) fn length(&self) -> usize {
        let rows = match &self.kernels {
            Kernels::Straight { scalar, .. } => {
                scalar.tables.iter().map(|table| table.rows.len()).sum()
            }
            Kernels::ByLink(_) | Kernels::Poses { .. } => 0,
        };
        self.static_operations().total() + self.result.len() / RESULTS + ROW * rows
    }
}
