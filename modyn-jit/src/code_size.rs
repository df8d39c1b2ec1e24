//! Counts of the code of a function.

/// Counts of a function's code. A function of constraints may have two forms: one for independent
/// rows, and one for rows of any rank, which the first calls. Bytes and constants are of both, and
/// so is the stack frame. The other counts are of the first form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CodeSize {
    /// Bytes of instructions.
    pub bytes: usize,
    /// Bytes of constants.
    pub constants: usize,
    /// Bytes of the stack frame.
    pub frame: usize,
    /// Instructions, without those that only run for large angles or dependent rows.
    pub instructions: usize,
    /// Stores of values for which there was no register; they are among the instructions.
    pub spills: usize,
    /// Loads of values into registers, without operands in memory.
    pub loads: usize,
    /// Operands that instructions read from memory.
    pub memory_operands: usize,
    /// Copies between registers.
    pub copies: usize,
}

impl std::ops::AddAssign for CodeSize {
    fn add_assign(&mut self, other: Self) {
        self.bytes += other.bytes;
        self.constants += other.constants;
        self.frame = self.frame.max(other.frame);
        self.instructions += other.instructions;
        self.spills += other.spills;
        self.loads += other.loads;
        self.memory_operands += other.memory_operands;
        self.copies += other.copies;
    }
}
