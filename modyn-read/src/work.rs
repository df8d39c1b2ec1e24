//! The steps of readers: elements, attributes and names that are looked at. Tests see by their
//! number that the work of reading grows in proportion to the text.

use std::cell::Cell;

thread_local! {
    /// The steps of all readers.
    static STEPS: Cell<usize> = const { Cell::new(0) };
}

/// Counts steps of a reader.
pub fn count(steps: usize) {
    STEPS.set(STEPS.get() + steps);
}

/// Returns the items, each of which is a step.
pub fn counted<T>(items: impl DoubleEndedIterator<Item = T>) -> impl DoubleEndedIterator<Item = T> {
    items.inspect(|_| count(1))
}

/// Returns the number of steps of all readers in this thread.
#[must_use]
pub fn counted_steps() -> usize {
    STEPS.get()
}
