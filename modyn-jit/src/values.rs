//! Values in vector registers: a program as registers see it, in single assignment.
//!
//! Every value has a number of lanes, and is a constant, an argument, a lane of a vector that was stored, or the result
//! of an operation. Equal values are made once. Constants and arguments need no register until an instruction wants one.

use rustc_hash::FxHashMap;

/// A value by its number.
pub(crate) type Value = u32;

/// The definition of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Definition {
    /// The constant of that number in the pool.
    Constant(u32),
    /// Numbers of an argument from that one on.
    Argument {
        /// The number of the array.
        array: u8,
        /// The first number.
        first: u32,
    },
    /// A lane of a vector, read from where that is stored.
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
    /// All bits where a or b is NaN, else none.
    Unordered,
    /// The bits of both.
    And,
    /// The bits of b that are not in a.
    AndNot,
    /// The bits of either.
    Or,
    /// The bits of one of them.
    Xor,
    /// The square root.
    SquareRoot,
    /// The lowest bit as the sign, zeros below.
    ShiftToSign,
    /// (-) a b (+ or -) c, rounded once.
    MultiplyAdd {
        /// Whether the product is negated.
        negative_product: bool,
        /// Whether c is negated.
        negative_addend: bool,
    },
    /// A scalar in all lanes.
    Broadcast,
    /// The lanes of a, then those of b.
    Join,
    /// The angle from the x axis to the point (b, a), by a call.
    Atan2,
    /// The natural logarithm, by a call.
    Logarithm,
}

impl Operation {
    /// The number of operands.
    pub fn operands(self) -> usize {
        match self {
            Self::SquareRoot | Self::ShiftToSign | Self::Broadcast | Self::Logarithm => 1,
            Self::MultiplyAdd { .. } => 3,
            _ => 2,
        }
    }

    /// Whether the operands can be exchanged.
    pub fn commutes(self) -> bool {
        matches!(self, Self::Add | Self::Multiply | Self::And | Self::Or | Self::Xor)
    }

    /// Whether it acts on bits: also of scalars there are instructions on 16 bytes alone.
    pub fn is_bitwise(self) -> bool {
        matches!(self, Self::And | Self::AndNot | Self::Or | Self::Xor)
    }
}

/// A step of the code.
#[derive(Clone, Debug)]
pub(crate) enum Step {
    /// Computes a value.
    Compute(Value),
    /// Reduces again those angles that are too large for the fast reduction.
    Check(FarCheck),
}

/// Angles that were reduced as if they were small, before anything reads their reductions.
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
    /// The reduced angle, and a number whose lowest bit is that of the multiple of pi.
    pub results: [Value; 2],
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
    /// The value of that definition, with so many lanes.
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

    /// The result of an operation.
    pub fn operation(&mut self, operation: Operation, operands: &[Value], lanes: u8) -> Value {
        let mut all = [operands[0]; 3];
        all[..operands.len()].copy_from_slice(operands);
        self.value(Definition::Result(operation, all), lanes)
    }

    /// Constants as lanes, by their bits.
    pub fn constants(&mut self, bits: Vec<u64>, lanes: u8) -> Value {
        let next = self.pool.len() as u32;
        let place = *self.pooled.entry(bits.clone()).or_insert(next);
        if place == next {
            self.pool.push(bits);
        }
        self.value(Definition::Constant(place), lanes)
    }

    /// The bits of a constant.
    pub fn bits(&self, value: Value) -> Option<&[u64]> {
        match self.definitions[value as usize] {
            Definition::Constant(place) => Some(&self.pool[place as usize]),
            _ => None,
        }
    }

    /// The operands of a value.
    pub fn operands(&self, value: Value) -> &[Value] {
        match &self.definitions[value as usize] {
            Definition::Result(operation, operands) => &operands[..operation.operands()],
            _ => &[],
        }
    }

    /// The value that is computed for this one to be there: itself, or the vector that it is a lane of.
    pub fn computed(&self, value: Value) -> Option<Value> {
        match self.definitions[value as usize] {
            Definition::Result(..) => Some(value),
            Definition::Lane(vector, _) => self.computed(vector),
            Definition::Constant(_) | Definition::Argument { .. } => None,
        }
    }

    /// The values that a step reads.
    pub fn reads(&self, step: &Step) -> Vec<Value> {
        match step {
            Step::Compute(value) => self.operands(*value).to_vec(),
            Step::Check(FarCheck { squares, limit, angles }) => {
                let angles = angles
                    .iter()
                    .flat_map(|reduced| [reduced.angle, reduced.results[0], reduced.results[1]]);
                [*squares, *limit].into_iter().chain(angles).collect()
            }
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
            Step::Check(_) => true,
        });
    }
}
