//! The nodes of a graph: operations with their operands.

/// The index of a node in its graph; operands come before their users.
pub type Id = u32;

/// An operation on earlier nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// A constant, by its bits: constants with equal bits are the same node.
    Constant(u64),
    /// The input with this number.
    Input(u32),
    /// -a
    Neg(Id),
    /// a + b
    Add(Id, Id),
    /// a - b
    Sub(Id, Id),
    /// a * b
    Mul(Id, Id),
    /// 1 / a
    Recip(Id),
    /// sin a
    Sin(Id),
    /// cos a
    Cos(Id),
    /// The angle from the x axis to the point (b, a).
    Atan2(Id, Id),
    /// The square root of a.
    Sqrt(Id),
    /// The natural logarithm of a.
    Ln(Id),
    /// |a|
    Abs(Id),
    /// The larger of a and b.
    Max(Id, Id),
    /// b if a >= 0, else c.
    Select(Id, Id, Id),
    /// A pack of this many lanes: the first half are the lanes of a, the second half the lanes of
    /// b. A scalar fills its half.
    Pack(Id, Id, u8),
    /// This lane of a.
    ExtractLane(Id, u8),
}

impl Node {
    /// Returns the input with this number.
    ///
    /// # Panics
    ///
    /// If the number is 2^32 or more.
    #[must_use]
    pub fn input(number: usize) -> Self {
        Self::Input(u32::try_from(number).expect("fewer than 2^32 inputs"))
    }

    /// Returns the same operation on other nodes.
    #[must_use]
    pub fn map(self, f: impl Fn(Id) -> Id) -> Self {
        match self {
            Self::Constant(_) | Self::Input(_) => self,
            Self::Neg(a) => Self::Neg(f(a)),
            Self::Add(a, b) => Self::Add(f(a), f(b)),
            Self::Sub(a, b) => Self::Sub(f(a), f(b)),
            Self::Mul(a, b) => Self::Mul(f(a), f(b)),
            Self::Recip(a) => Self::Recip(f(a)),
            Self::Sin(a) => Self::Sin(f(a)),
            Self::Cos(a) => Self::Cos(f(a)),
            Self::Atan2(a, b) => Self::Atan2(f(a), f(b)),
            Self::Sqrt(a) => Self::Sqrt(f(a)),
            Self::Ln(a) => Self::Ln(f(a)),
            Self::Abs(a) => Self::Abs(f(a)),
            Self::Max(a, b) => Self::Max(f(a), f(b)),
            Self::Select(a, b, c) => Self::Select(f(a), f(b), f(c)),
            Self::Pack(a, b, width) => Self::Pack(f(a), f(b), width),
            Self::ExtractLane(a, lane) => Self::ExtractLane(f(a), lane),
        }
    }

    /// Returns the operands.
    pub fn operands(self) -> impl Iterator<Item = Id> {
        let (ids, count) = match self {
            Self::Constant(_) | Self::Input(_) => ([0; 3], 0),
            Self::Neg(a)
            | Self::Recip(a)
            | Self::Sin(a)
            | Self::Cos(a)
            | Self::Sqrt(a)
            | Self::Ln(a)
            | Self::Abs(a)
            | Self::ExtractLane(a, _) => ([a, 0, 0], 1),
            Self::Add(a, b)
            | Self::Sub(a, b)
            | Self::Mul(a, b)
            | Self::Atan2(a, b)
            | Self::Max(a, b)
            | Self::Pack(a, b, _) => ([a, b, 0], 2),
            Self::Select(a, b, c) => ([a, b, c], 3),
        };
        Operands { ids, next: 0, count }
    }
}

/// The operands of a node, in order.
struct Operands {
    ids: [Id; 3],
    next: usize,
    count: usize,
}

impl Iterator for Operands {
    type Item = Id;

    fn next(&mut self) -> Option<Id> {
        if self.next == self.count {
            return None;
        }
        self.next += 1;
        Some(self.ids[self.next - 1])
    }
}
