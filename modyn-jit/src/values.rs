//! Values in vector registers: a program in single assignment.
//!
//! Every value has a number of lanes, and is a constant, an argument, a lane of a stored vector, or
//! the result of an operation. Equal values are made once. Constants and arguments need no register
//! until an instruction reads one.

use rustc_hash::FxHashMap;

/// The number of a value.
pub(crate) type Value = u32;

/// The signs of a product and a sum: (-) a b (+ or -) c.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Negated {
    /// Whether the product is negated.
    pub product: bool,
    /// Whether c is negated.
    pub addend: bool,
}

/// The definition of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Definition {
    /// The constant with this number in the pool.
    Constant(u32),
    /// Consecutive numbers of an argument.
    Argument {
        /// The number of the array.
        array: u8,
        /// The first number.
        first: u32,
    },
    /// A lane of a vector, read from the vector's memory.
    Lane(Value, u8),
    /// The result of an operation.
    Result(Operation, [Value; 3]),
}

/// An operation, lane by lane unless it says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Operation {
    /// a + b
    Add,
    /// a - b
    Subtract,
    /// a b
    Multiply,
    /// a / b
    Divide,
    /// a if a > b, else b: b where one is NaN.
    Maximum,
    /// All bits where a <= b, else none.
    LessOrEqual,
    /// All bits where a is NaN, else none.
    IsNan,
    /// The bits that are in a and in b.
    And,
    /// The bits of b that are not in a.
    AndNot,
    /// The bits that are in a or in b.
    Or,
    /// The bits that are in a or in b but not in both.
    Xor,
    /// The square root.
    SquareRoot,
    /// The lowest bit as the sign, zeros below.
    ShiftToSign,
    /// (-) a b (+ or -) c, rounded once.
    MultiplyAdd(Negated),
    /// A scalar in all lanes.
    Broadcast,
    /// The lanes of a, then the lanes of b.
    Join,
    /// The angle from the x axis to the point (b, a), by a call.
    Atan2,
    /// The natural logarithm, by a call.
    Logarithm,
}

impl Operation {
    /// Returns the number of operands.
    pub fn operands(self) -> usize {
        match self {
            Self::IsNan
            | Self::SquareRoot
            | Self::ShiftToSign
            | Self::Broadcast
            | Self::Logarithm => 1,
            Self::MultiplyAdd(_) => 3,
            _ => 2,
        }
    }

    /// Returns whether the operands can be exchanged.
    pub fn commutes(self) -> bool {
        matches!(self, Self::Add | Self::Multiply | Self::And | Self::Or | Self::Xor)
    }

    /// Returns whether it operates on bits: its instructions on scalars have 16 bytes.
    pub fn is_bitwise(self) -> bool {
        matches!(self, Self::And | Self::AndNot | Self::Or | Self::Xor)
    }
}

/// A step of the code.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    /// Computes a value.
    Compute(Value),
    /// Reduces again the angles that are too large for the fast reduction.
    Check(FarCheck),
    /// Calls the code for rows of any rank and returns, unless all lanes of the first value are
    /// less than the lanes of the second value.
    Guard([Value; 2]),
}

/// Angles that were reduced as small ones, before any step reads their reductions.
#[derive(Clone, Debug)]
pub(crate) struct FarCheck {
    /// The sum of the angles' squares.
    pub squares: Value,
    /// The square of the limit: if all sums are less, no angle is too large.
    pub limit: Value,
    /// The angles.
    pub angles: Vec<Reduced>,
}

/// An angle and its reduction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reduced {
    /// The angle.
    pub angle: Value,
    /// The reduced angle, and a number whose lowest bit is the lowest bit of the multiple of pi.
    pub results: [Value; 2],
}

/// The numbers that a routine's results replace. States whose loop has ended keep them.
#[derive(Clone, Debug)]
pub(crate) struct Kept {
    /// The place of the number that is negative for states whose loop has ended.
    pub runs: usize,
    /// For each result, the place of the number that it replaces.
    pub places: Vec<usize>,
}

/// A program on values.
#[derive(Clone, Debug, Default)]
pub(crate) struct Values {
    /// The values by number.
    pub definitions: Vec<Definition>,
    /// The number of lanes of each.
    pub lanes: Vec<u8>,
    /// The constants: their bits, at least 16 bytes where bits are operated on.
    pub pool: Vec<Vec<u64>>,
    /// The steps, each after the steps whose values it reads.
    pub steps: Vec<Step>,
    /// The results. In batches each has the lanes of a vector.
    pub results: Vec<Value>,
    known: FxHashMap<(Definition, u8), Value>,
    pooled: FxHashMap<Vec<u64>, u32>,
}

impl Values {
    /// Returns the value with that definition and this number of lanes.
    pub fn value(&mut self, definition: Definition, lanes: u8) -> Value {
        if let Some(&value) = self.known.get(&(definition, lanes)) {
            return value;
        }
        let value = self.definitions.len() as Value;
        self.definitions.push(definition);
        self.lanes.push(lanes);
        self.known.insert((definition, lanes), value);
        if matches!(definition, Definition::Result(..)) {
            self.steps.push(Step::Compute(value));
        }
        value
    }

    /// Returns the result of an operation.
    pub fn operation(&mut self, operation: Operation, operands: &[Value], lanes: u8) -> Value {
        let mut all = [operands[0]; 3];
        all[..operands.len()].copy_from_slice(operands);
        self.value(Definition::Result(operation, all), lanes)
    }

    /// Returns constants as lanes, by their bits.
    pub fn constants(&mut self, bits: Vec<u64>, lanes: u8) -> Value {
        let next = self.pool.len() as u32;
        let place = *self.pooled.entry(bits.clone()).or_insert(next);
        if place == next {
            self.pool.push(bits);
        }
        self.value(Definition::Constant(place), lanes)
    }

    /// Returns the bits of a constant.
    pub fn bits(&self, value: Value) -> Option<&[u64]> {
        match self.definitions[value as usize] {
            Definition::Constant(place) => Some(&self.pool[place as usize]),
            _ => None,
        }
    }

    /// Returns the operands of a value.
    pub fn operands(&self, value: Value) -> &[Value] {
        match &self.definitions[value as usize] {
            Definition::Result(operation, operands) => &operands[..operation.operands()],
            _ => &[],
        }
    }

    /// Returns the value that a step computes for this one: itself, or the vector whose lane it is.
    pub fn computed(&self, value: Value) -> Option<Value> {
        match self.definitions[value as usize] {
            Definition::Result(..) => Some(value),
            Definition::Lane(vector, _) => self.computed(vector),
            Definition::Constant(_) | Definition::Argument { .. } => None,
        }
    }

    /// Returns the values that a step reads.
    pub fn reads(&self, step: &Step) -> Vec<Value> {
        match step {
            Step::Compute(value) => self.operands(*value).to_vec(),
            Step::Guard(values) => values.to_vec(),
            Step::Check(FarCheck { squares, limit, angles }) => {
                let angles = angles
                    .iter()
                    .flat_map(|reduced| [reduced.angle, reduced.results[0], reduced.results[1]]);
                [*squares, *limit].into_iter().chain(angles).collect()
            }
        }
    }

    /// Replaces results by numbers of the first array of arguments, in the lanes that keep them.
    pub fn keep(&mut self, kept: &Kept) {
        let Some(&first) = self.results.first() else { return };
        let lanes = self.lanes[first as usize];
        let argument = |place: usize| {
            let first = place as u32 * u32::from(lanes);
            Definition::Argument { array: 0, first }
        };
        let zero = self.constants(vec![0; lanes.into()], lanes);
        let switch = self.value(argument(kept.runs), lanes);
        let runs = self.operation(Operation::LessOrEqual, &[zero, switch], lanes);
        for (k, &place) in kept.places.iter().enumerate() {
            let old = self.value(argument(place), lanes);
            let if_ended = self.operation(Operation::AndNot, &[runs, old], lanes);
            let if_running = self.operation(Operation::And, &[runs, self.results[k]], lanes);
            self.results[k] = self.operation(Operation::Or, &[if_running, if_ended], lanes);
        }
    }

    /// Removes the steps whose values are not needed.
    pub fn remove_unused(&mut self) {
        let mut needed = vec![false; self.definitions.len()];
        for &result in &self.results {
            if let Some(value) = self.computed(result) {
                needed[value as usize] = true;
            }
        }
        for step in self.steps.iter().rev() {
            if matches!(step, Step::Compute(value) if !needed[*value as usize]) {
                continue;
            }
            for value in self.reads(step) {
                if let Some(value) = self.computed(value) {
                    needed[value as usize] = true;
                }
            }
        }
        self.steps.retain(|step| match step {
            Step::Compute(value) => needed[*value as usize],
            Step::Check(_) | Step::Guard(_) => true,
        });
    }
}
