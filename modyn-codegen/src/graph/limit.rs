//! The limit of the nodes of graphs, while they are traced.

use std::cell::Cell;

/// The number of nodes of a graph without a limit.
pub(super) const UNLIMITED: usize = u32::MAX as usize;

thread_local! {
    /// The nodes that graphs may still have.
    static LEFT: Cell<usize> = const { Cell::new(UNLIMITED) };
    /// Whether a graph would have had more.
    static IS_EXCEEDED: Cell<bool> = const { Cell::new(false) };
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

/// Returns the nodes that a new graph may have.
pub(super) fn of_new_graph() -> usize {
    LEFT.get()
}

/// Counts the nodes of a trace.
pub(super) fn count(nodes: usize) {
    if LEFT.get() != UNLIMITED {
        LEFT.set(LEFT.get().saturating_sub(nodes));
    }
}

/// Notes that a graph would have had more nodes.
#[cold]
pub(super) fn exceed() {
    IS_EXCEEDED.set(true);
}
