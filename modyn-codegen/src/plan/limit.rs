//! The limit of the operations of a robot's functions. Functions are counted one after the other,
//! and the graph of one cannot grow far beyond the limit while it is traced.
//!
//! A function that certainly exceeds the limit is not traced (`least`). Beyond a number of nodes a
//! traced operation is one of its operands (`graph/limit.rs`), so the equations run to their end
//! without new nodes.

use super::planned::{Kernels, Planned};
use crate::graph::within;

/// The largest number of operations of all functions of a robot. Their text has about 40 MB.
pub const MAX_OPERATIONS: usize = 800_000;

/// The largest number of nodes that are traced for one function, of all candidates together.
pub(super) const MAX_NODES: usize = 4 * MAX_OPERATIONS;

/// The number of numbers of a result whose text is as long as an operation's text. Most of a long
/// result are zeros.
pub(super) const RESULTS: usize = 8;

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
