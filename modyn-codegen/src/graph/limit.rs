//! The limit of the nodes of graphs, while they are traced.

use std::cell::Cell;

/// The number of nodes of a graph without a limit.
pub(super) const UNLIMITED: usize = u32::MAX as usize;

thread_local! {
    /// The nodes that graphs may still have.
    static LEFT: Cell<usize> = const { Cell::new(UNLIMITED) };
    /// Whether a graph would have had more.
    static IS_EXCEEDED: Cell<bool> = const { Cell::new(false) };
    /// The nodes of all traces, and the operations beyond their limits.
    static TRACED: Cell<usize> = const { Cell::new(0) };
}

/// Restores the limit around the current one.
struct Outer {
    left: usize,
    is_exceeded: bool,
}

impl Drop for Outer {
    fn drop(&mut self) {
        LEFT.set(self.left);
        IS_EXCEEDED.set(self.is_exceeded);
    }
}

/// Returns the result of `work`; `None` if the traces of `work` take more nodes than this, all
/// together, or another graph does. An operation beyond the limit is one of its operands, so `work`
/// comes to an end soon.
pub fn within<T>(nodes: usize, work: impl FnOnce() -> T) -> Option<T> {
    let outer = Outer { left: LEFT.replace(nodes), is_exceeded: IS_EXCEEDED.replace(false) };
    let result = work();
    let is_exceeded = IS_EXCEEDED.get();
    drop(outer);
    (!is_exceeded).then_some(result)
}

/// Returns whether a graph would have had more nodes than the limit: nothing that follows from it
/// counts.
pub fn is_exceeded() -> bool {
    IS_EXCEEDED.get()
}

/// Returns the nodes that a new graph may have.
pub(super) fn of_new_graph() -> usize {
    LEFT.get()
}

/// Counts the nodes of a trace.
pub(super) fn count(nodes: usize) {
    TRACED.set(TRACED.get() + nodes);
    if LEFT.get() != UNLIMITED {
        LEFT.set(LEFT.get().saturating_sub(nodes));
    }
}

/// Notes that a graph would have had one more node.
#[cold]
pub(super) fn exceed() {
    IS_EXCEEDED.set(true);
    TRACED.set(TRACED.get() + 1);
}

/// Returns the number of nodes that this thread has traced, and of operations beyond their limits.
#[must_use]
pub fn traced_operations() -> usize {
    TRACED.get()
}
