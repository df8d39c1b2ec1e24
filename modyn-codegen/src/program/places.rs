//! Where printers find the operands of statements: entries of arguments, and values that earlier
//! chunks pass on.

use super::{Program, Value};

/// Returns the argument to which the scalar argument `number` belongs, and its index there, for
/// arguments of these lengths.
///
/// # Errors
///
/// If these arguments have fewer scalars: its index among the scalars after them.
pub fn argument_of(
    number: usize,
    lengths: impl IntoIterator<Item = usize>,
) -> Result<(usize, usize), usize> {
    let mut rest = number;
    for (argument, length) in lengths.into_iter().enumerate() {
        if rest < length {
            return Ok((argument, rest));
        }
        rest -= length;
    }
    Err(rest)
}

impl Program {
    /// Returns the chunk that computes a value, and the value's index among those that the chunk
    /// passes on; `None` if the chunk keeps it.
    #[must_use]
    pub fn place_of(&self, value: Value) -> Option<(usize, usize)> {
        let ends_before = |chunk: &super::Chunk| chunk.statements.end <= value.statement;
        let chunk = self.chunks.partition_point(ends_before);
        let key = |value: &Value| (self.statements[value.statement].lanes, *value);
        let passed_on = &self.chunks.get(chunk)?.live_out;
        Some((chunk, passed_on.binary_search_by_key(&key(&value), key).ok()?))
    }
}
