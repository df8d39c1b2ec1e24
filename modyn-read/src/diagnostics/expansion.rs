//! The origins of a text that macros made: the place in a file of each part, and the calls that led
//! there.

/// A call of a macro, or an include.
#[derive(Clone, Debug, Default)]
pub struct ExpansionCall {
    /// The called macro in words, such as "macro `wheel`".
    pub name: String,
    /// The offset of the call in the report's files.
    pub at: usize,
    /// The call that this call is part of; 0 for the file itself.
    pub parent: usize,
}

/// The origin of a byte of an expanded text.
pub struct Origin<'c> {
    /// The offset in the report's files.
    pub at: usize,
    /// The calls of the expansion; the first is the file itself.
    pub calls: &'c [ExpansionCall],
    /// The call that led there.
    pub call: usize,
}

/// The origins of the bytes of an expanded text.
#[derive(Default)]
pub struct Expansion {
    /// For each part its start in the text, its offset in the report's files, and its call.
    parts: Vec<(usize, usize, usize)>,
    /// The calls; the first is the file itself.
    calls: Vec<ExpansionCall>,
}

impl Expansion {
    /// Adds a part of the text, which starts after all earlier ones.
    pub fn add(&mut self, start: usize, at: usize, call: usize) {
        self.parts.push((start, at, call));
    }

    /// Sets the calls that the parts name.
    pub fn set_calls(&mut self, calls: Vec<ExpansionCall>) {
        self.calls = calls;
    }

    /// Returns the origin of a byte of the text: its offset in the report's files, and its call.
    pub fn origin(&self, offset: usize) -> (usize, usize) {
        let after = self.parts.partition_point(|(start, ..)| *start <= offset);
        let part = after.checked_sub(1).and_then(|index| self.parts.get(index));
        part.map_or((0, 0), |(_, at, call)| (*at, *call))
    }

    /// Returns the calls.
    pub fn calls(&self) -> &[ExpansionCall] {
        &self.calls
    }
}
