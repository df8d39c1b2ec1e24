//! The conversion of byte offsets to lines and columns.

use super::diagnostic::Position;

/// The lines of a text.
///
/// A file may be one line of a million characters, so line and column are found by binary search.
pub struct LineIndex {
    /// Where each line begins.
    starts: Vec<usize>,
    /// The bytes that continue a character.
    continuations: Vec<usize>,
}

impl LineIndex {
    /// Returns the lines of this text.
    pub fn of(text: &str) -> Self {
        let mut starts = vec![0];
        let mut continuations = Vec::new();
        for (i, byte) in text.bytes().enumerate() {
            if byte == b'\n' {
                starts.push(i + 1);
            } else if byte & 0xc0 == 0x80 {
                continuations.push(i);
            }
        }
        Self { starts, continuations }
    }

    /// Returns line and column of the character at this byte.
    pub fn position(&self, offset: usize) -> Position {
        let line = self.starts.partition_point(|&start| start <= offset);
        let start = self.starts[line - 1];
        let before = |end| self.continuations.partition_point(|&i| i < end);
        Position { line, column: 1 + offset - start - (before(offset) - before(start)) }
    }
}
