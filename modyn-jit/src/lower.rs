//! Lowers a program to values: signs, fused products, sines as polynomials, lanes that fit into
//! registers.
//!
//! The equations of constraint rows have two forms. One computes rows of any rank. The other leaves
//! this out, and has a guard, which finds the states that need it.

use modyn_codegen::program::{
    Addend, MultiplyAdd, Operand, Operation as Statement, Program, RowEquations, Source,
};
use modyn_runtime::trig_steps::{self, Step as SineStep, Steps};

use crate::instruction_set::InstructionSet;
use crate::real::Real;
use crate::values::{Definition, FarCheck, Negated, Operation, Reduced, Step, Value, Values};

/// The lengths of the arrays of arguments, in the order in which the program numbers their entries.
pub(crate) type Arrays = [usize];

/// The constraint rows that code computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rows {
    /// Rows of any rank.
    All,
    /// Independent rows, behind a [guard](Step::Guard).
    Independent,
}

/// Returns the values of a program. In a batch, the lanes of a register are states.
pub(crate) fn lower<S: Real>(
    program: &Program,
    arrays: &Arrays,
    instruction_set: InstructionSet,
    batch: bool,
    rows: Rows,
) -> Values {
    let native = (instruction_set.vector(batch) / size_of::<S>()) as u8;
    let mut lowering = Lowering::<S> {
        values: Values::default(),
        arrays,
        rows,
        equations: Equations::default(),
        fused: instruction_set.fuses(),
        native,
        scalar: if batch { native } else { 1 },
        results: Vec::with_capacity(program.statements.len()),
        reduction: Steps::reduction::<S>(),
        polynomials: Steps::polynomials::<S>(),
        number: std::marker::PhantomData,
    };
    lowering.values.results = lowering.program(program);
    lowering.values.remove_unused();
    lowering.values
}

/// The registers of one value of a program: vectors that are longer than registers have several.
type Registers = Vec<Value>;

struct Lowering<'a, S> {
    values: Values,
    arrays: &'a Arrays,
    rows: Rows,
    equations: Equations,
    /// Whether products are fused with sums.
    fused: bool,
    /// The number of lanes of the longest register.
    native: u8,
    /// The number of lanes of the program's scalars.
    scalar: u8,
    /// The results, by statement and place.
    results: Vec<Vec<Registers>>,
    reduction: Steps,
    polynomials: Steps,
    number: std::marker::PhantomData<S>,
}

/// What is known of the equations of constraint rows.
#[derive(Default)]
struct Equations {
    /// The numbers of the equations whose program is lowered, which are its arguments.
    numbers: Option<Vec<Value>>,
    /// The numbers that are not negative after the guards.
    margins: Vec<Operand>,
}

impl<S: Real> Lowering<'_, S> {
    /// Adds the values of a program's statements, and returns its results.
    fn program(&mut self, program: &Program) -> Registers {
        for statement in &program.statements {
            let results = self.statement(&statement.operation, statement.lanes);
            self.results.push(results);
        }
        program.results.iter().map(|result| self.scalar(result)).collect()
    }

    /// Adds the values of the equations of constraint rows, and returns the results. Their products
    /// are not fused with sums, as in the loops of the runtime.
    fn row_equations(&mut self, equations: &RowEquations) -> Registers {
        if self.rows == Rows::Independent {
            self.guard(equations.margin());
            return vec![self.constant(0.0, self.scalar); equations.results()];
        }
        let numbers = equations.numbers().iter().map(|number| self.scalar(number)).collect();
        self.equations.numbers = Some(numbers);
        let outer = (std::mem::take(&mut self.results), std::mem::take(&mut self.fused));
        let results = self.program(&equations.program());
        (self.results, self.fused) = outer;
        self.equations.numbers = None;
        results
    }

    /// Adds the guard that a number is not negative: that its negative is less than the smallest
    /// positive number.
    fn guard(&mut self, margin: &Operand) {
        self.equations.margins.push(*margin);
        let negative = self.scalar(&Operand { negated: !margin.negated, ..*margin });
        let smallest = self.values.constants(vec![1; self.scalar.into()], self.scalar);
        self.values.steps.push(Step::Guard([negative, smallest]));
    }

    /// Returns the number of lanes of each register of a value with this number of lanes.
    fn split(&self, lanes: u8) -> (usize, u8) {
        match lanes {
            1 => (1, self.scalar),
            // There are no shorter vectors.
            _ if usize::from(lanes) * size_of::<S>() < 16 => (lanes.into(), 1),
            _ if lanes > self.native => (usize::from(lanes / self.native), self.native),
            _ => (1, lanes),
        }
    }

    /// Adds the values of a statement, and returns its results by place.
    fn statement(&mut self, operation: &Statement, lanes: u8) -> Vec<Registers> {
        let (count, width) = self.split(lanes);
        let single = |result: Registers| vec![result];
        match operation {
            Statement::Add(a, b) => single(self.each(lanes, |this, k| this.sum(a, b, false, k))),
            Statement::Subtract(a, b) => {
                single(self.each(lanes, |this, k| this.sum(a, b, true, k)))
            }
            Statement::Multiply(a, b) => single(self.each(lanes, |this, k| {
                let negated = a.negated != b.negated;
                let [a, b] = [a, b].map(|x| this.magnitude(x, k));
                let product = this.binary(Operation::Multiply, a, b);
                this.signed(product, negated)
            })),
            Statement::MultiplyAdd(fused) => {
                single(self.each(lanes, |this, k| this.multiply_add(fused, k)))
            }
            Statement::Reciprocal(a) => single(self.each(lanes, |this, k| {
                let one = this.constant(1.0, width);
                let a = this.register(a, k);
                this.binary(Operation::Divide, one, a)
            })),
            Statement::SinCos(angles) => {
                let angles: Vec<Registers> = angles
                    .iter()
                    .map(|angle| (0..count).map(|k| self.register(angle, k)).collect())
                    .collect();
                self.sines_and_cosines(&angles)
            }
            Statement::Atan2(a, b) => single(self.each(lanes, |this, k| {
                let [a, b] = [a, b].map(|x| this.register(x, k));
                this.binary(Operation::Atan2, a, b)
            })),
            Statement::SquareRoot(a) => {
                single(self.each(lanes, |this, k| this.unary(Operation::SquareRoot, a, k)))
            }
            Statement::Logarithm(a) => {
                single(self.each(lanes, |this, k| this.unary(Operation::Logarithm, a, k)))
            }
            Statement::Absolute(a) => single(self.each(lanes, |this, k| {
                let a = this.magnitude(a, k);
                let bits = !this.sign();
                let mask = this.mask(bits, width);
                this.binary(Operation::And, a, mask)
            })),
            Statement::Maximum(a, b) => single(self.each(lanes, |this, k| {
                let [a, b] = [a, b].map(|x| this.register(x, k));
                // If one operand is NaN, the instruction returns its second operand.
                let larger = this.binary(Operation::Maximum, b, a);
                let nan = this.values.operation(Operation::IsNan, &[a], width);
                this.choose(nan, b, larger)
            })),
            Statement::Select(a, b, _) if self.is_known_nonnegative(a) => {
                single(self.each(lanes, |this, k| this.register(b, k)))
            }
            Statement::Select(a, b, c) => single(self.each(lanes, |this, k| {
                let [a, b, c] = [a, b, c].map(|x| this.register(x, k));
                let zero = this.constant(0.0, width);
                let nonnegative = this.binary(Operation::LessOrEqual, zero, a);
                this.choose(nonnegative, b, c)
            })),
            Statement::Pack(packed) => {
                let scalars: Vec<Value> = packed.iter().map(|x| self.scalar(x)).collect();
                single(scalars.chunks(width.into()).map(|scalars| self.pack(scalars)).collect())
            }
            Statement::Constants(packed) => {
                let constants = |chunk: &[f64]| {
                    let bits = chunk.iter().map(|&x| S::from_f64(x).bits()).collect();
                    self.values.constants(bits, width)
                };
                single(packed.chunks(width.into()).map(constants).collect())
            }
            Statement::Unpack(vector) => {
                let (_, width) = self.split(vector.lanes);
                let lane = |this: &mut Self, lane: u8| {
                    let register = this.register(vector, (lane / width).into());
                    this.lane(register, lane % width)
                };
                (0..vector.lanes).map(|k| vec![lane(self, k)]).collect()
            }
            Statement::RowEquations(equations) => {
                let results = self.row_equations(equations);
                results.into_iter().map(|result| vec![result]).collect()
            }
            Statement::Loops(_) => unreachable!("plans for machine code are straight-line code"),
        }
    }

    /// Returns whether a guard has found that a number is not negative.
    fn is_known_nonnegative(&self, operand: &Operand) -> bool {
        let margins = &self.equations.margins;
        margins.iter().any(|known| Operand { lanes: operand.lanes, ..*known } == *operand)
    }

    /// Returns a value for each register of a value with this number of lanes.
    fn each(&mut self, lanes: u8, value: impl Fn(&mut Self, usize) -> Value) -> Registers {
        (0..self.split(lanes).0).map(|k| value(self, k)).collect()
    }

    /// Returns register `k` of an operand without its sign.
    fn magnitude(&mut self, operand: &Operand, k: usize) -> Value {
        let (_, width) = self.split(operand.lanes);
        match operand.source {
            Source::Constant(value) => self.constant(value, width),
            Source::Argument(number) => {
                let argument = self.argument(number);
                self.wide(argument, width)
            }
            Source::Result(value) => {
                let registers = &self.results[value.statement][value.place];
                let register = if registers.len() == 1 { registers[0] } else { registers[k] };
                self.wide(register, width)
            }
        }
    }

    /// Returns register `k` of an operand.
    fn register(&mut self, operand: &Operand, k: usize) -> Value {
        let magnitude = self.magnitude(operand, k);
        self.signed(magnitude, operand.negated)
    }

    /// Returns a scalar operand.
    fn scalar(&mut self, operand: &Operand) -> Value {
        self.register(&Operand { lanes: 1, ..*operand }, 0)
    }

    /// Returns a scalar argument.
    fn argument(&mut self, number: usize) -> Value {
        if let Some(numbers) = &self.equations.numbers {
            return numbers[number];
        }
        let mut first = number;
        let mut array = 0;
        while first >= self.arrays[array] {
            first -= self.arrays[array];
            array += 1;
        }
        let array = array as u8;
        let first = first as u32 * u32::from(self.scalar);
        self.values.value(Definition::Argument { array, first }, self.scalar)
    }

    /// Returns a value in this number of lanes.
    fn wide(&mut self, value: Value, lanes: u8) -> Value {
        if self.values.lanes[value as usize] == lanes {
            return value;
        }
        match self.values.bits(value) {
            Some(bits) => {
                let bits = vec![bits[0]; lanes.into()];
                self.values.constants(bits, lanes)
            }
            None => self.values.operation(Operation::Broadcast, &[value], lanes),
        }
    }

    fn constant(&mut self, value: f64, lanes: u8) -> Value {
        self.values.constants(vec![S::from_f64(value).bits(); lanes.into()], lanes)
    }

    /// Returns a constant for operations on bits, which read at least 16 bytes.
    fn mask(&mut self, bits: u64, lanes: u8) -> Value {
        let count = usize::from(lanes).max(16 / size_of::<S>());
        self.values.constants(vec![bits; count], lanes)
    }

    /// Returns the sign bit.
    fn sign(&self) -> u64 {
        1 << (8 * size_of::<S>() - 1)
    }

    fn lanes(&self, value: Value) -> u8 {
        self.values.lanes[value as usize]
    }

    fn binary(&mut self, operation: Operation, a: Value, b: Value) -> Value {
        let lanes = self.lanes(a);
        self.values.operation(operation, &[a, b], lanes)
    }

    fn unary(&mut self, operation: Operation, operand: &Operand, k: usize) -> Value {
        let a = self.register(operand, k);
        let lanes = self.lanes(a);
        self.values.operation(operation, &[a], lanes)
    }

    fn signed(&mut self, value: Value, negated: bool) -> Value {
        if !negated {
            return value;
        }
        let lanes = self.lanes(value);
        let sign = self.sign();
        if let Some(bits) = self.values.bits(value) {
            let bits = bits.iter().map(|bits| bits ^ sign).collect();
            return self.values.constants(bits, lanes);
        }
        let mask = self.mask(sign, lanes);
        self.binary(Operation::Xor, value, mask)
    }

    /// Returns the second value where the mask has bits, else the third.
    fn choose(&mut self, mask: Value, then: Value, otherwise: Value) -> Value {
        let then = self.binary(Operation::And, mask, then);
        let otherwise = self.binary(Operation::AndNot, mask, otherwise);
        self.binary(Operation::Or, then, otherwise)
    }

    /// Returns a + b or a - b. Signs select the sum or the difference where possible. The result is
    /// exact, also for zeros.
    fn sum(&mut self, a: &Operand, b: &Operand, subtract: bool, k: usize) -> Value {
        let negative = b.negated != subtract;
        let [x, y] = [a, b].map(|x| self.magnitude(x, k));
        match (a.negated, negative) {
            (false, false) => self.binary(Operation::Add, x, y),
            (false, true) => self.binary(Operation::Subtract, x, y),
            (true, false) => self.binary(Operation::Subtract, y, x),
            (true, true) => {
                let x = self.signed(x, true);
                self.binary(Operation::Subtract, x, y)
            }
        }
    }

    fn multiply_add(&mut self, fused: &MultiplyAdd, k: usize) -> Value {
        let MultiplyAdd { negative_product, factors: [a, b], negative_addend, addend } = fused;
        let (addend, negative) = match addend {
            Addend::Value(c) => (self.magnitude(c, k), *negative_addend != c.negated),
            Addend::Product(c, d) => {
                let negative = *negative_addend != (c.negated != d.negated);
                let [c, d] = [c, d].map(|x| self.magnitude(x, k));
                (self.binary(Operation::Multiply, c, d), negative)
            }
        };
        let negated =
            Negated { product: *negative_product != (a.negated != b.negated), addend: negative };
        let [a, b] = [a, b].map(|x| self.magnitude(x, k));
        self.product_and_sum([a, b], addend, negated)
    }

    /// Returns (-) a b (+ or -) c, rounded once if the instruction set fuses products, else twice.
    fn product_and_sum(&mut self, [a, b]: [Value; 2], c: Value, negated: Negated) -> Value {
        let lanes = self.lanes(a);
        if self.fused {
            return self.values.operation(Operation::MultiplyAdd(negated), &[a, b, c], lanes);
        }
        let product = self.binary(Operation::Multiply, a, b);
        match (negated.product, negated.addend) {
            (false, false) => self.binary(Operation::Add, product, c),
            (false, true) => self.binary(Operation::Subtract, product, c),
            (true, false) => self.binary(Operation::Subtract, c, product),
            (true, true) => {
                let product = self.signed(product, true);
                self.binary(Operation::Subtract, product, c)
            }
        }
    }

    /// Returns scalars as the lanes of a vector.
    fn pack(&mut self, scalars: &[Value]) -> Value {
        let lanes = scalars.len() as u8;
        if lanes == 1 {
            return scalars[0];
        }
        if scalars.iter().all(|&x| x == scalars[0]) {
            return self.wide(scalars[0], lanes);
        }
        let bits: Option<Vec<u64>> =
            scalars.iter().map(|&x| self.values.bits(x).map(|bits| bits[0])).collect();
        if let Some(bits) = bits {
            return self.values.constants(bits, lanes);
        }
        let is_vector = usize::from(lanes) * size_of::<S>() >= 16;
        let definition = |k: usize| self.values.definitions[scalars[k] as usize];
        match definition(0) {
            Definition::Argument { array, first } if is_vector => {
                let next = |k: usize| Definition::Argument { array, first: first + k as u32 };
                if (0..scalars.len()).all(|k| definition(k) == next(k)) {
                    return self.values.value(definition(0), lanes);
                }
            }
            Definition::Lane(vector, 0) if self.lanes(vector) == lanes => {
                let next = |k: usize| Definition::Lane(vector, k as u8);
                if (0..scalars.len()).all(|k| definition(k) == next(k)) {
                    return vector;
                }
            }
            _ => {}
        }
        let (a, b) = scalars.split_at(scalars.len() / 2);
        let halves = [self.pack_half(a), self.pack_half(b)];
        self.values.operation(Operation::Join, &halves, lanes)
    }

    /// Returns scalars as half of a vector.
    fn pack_half(&mut self, scalars: &[Value]) -> Value {
        // Half of the shortest vector is not a vector: its scalars are joined with the other half.
        if scalars.len() == 2 && size_of::<S>() == 4 {
            return self.values.operation(Operation::Join, scalars, 2);
        }
        self.pack(scalars)
    }

    fn lane(&mut self, register: Value, lane: u8) -> Value {
        if self.lanes(register) == 1 {
            return register;
        }
        if let Some(bits) = self.values.bits(register) {
            let bits = vec![bits[usize::from(lane)]];
            return self.values.constants(bits, 1);
        }
        if let Definition::Argument { array, first } = self.values.definitions[register as usize] {
            let first = first + u32::from(lane);
            return self.values.value(Definition::Argument { array, first }, 1);
        }
        self.values.value(Definition::Lane(register, lane), 1)
    }

    /// Returns sine and cosine of each angle: all are reduced, then those that are too large are
    /// reduced again. Scalars share vectors.
    fn sines_and_cosines(&mut self, angles: &[Registers]) -> Vec<Registers> {
        let scalars = self.scalar == 1 && angles.iter().all(|x| self.lanes(x[0]) == 1);
        if !scalars || angles.len() == 1 || angles[0].len() > 1 {
            let all: Registers = angles.concat();
            let both = self.reduced_and_evaluated(&all);
            let part = |place: usize| {
                move |chunk: &[[Value; 2]]| chunk.iter().map(|both| both[place]).collect()
            };
            let chunks = both.chunks(angles[0].len());
            return chunks.flat_map(|chunk| [part(0)(chunk), part(1)(chunk)]).collect();
        }
        let shortest = 16 / size_of::<S>();
        let lanes = angles.len().next_power_of_two().clamp(shortest, self.native.into());
        // The last vector overlaps the one before, or repeats the last angle.
        let last = angles.len().saturating_sub(lanes);
        let starts: Vec<usize> =
            (0..angles.len()).step_by(lanes).map(|start| start.min(last)).collect();
        let vectors: Registers = starts
            .iter()
            .map(|start| {
                let at = |k: usize| angles[(start + k).min(angles.len() - 1)][0];
                let scalars: Vec<Value> = (0..lanes).map(at).collect();
                self.pack(&scalars)
            })
            .collect();
        let both = self.reduced_and_evaluated(&vectors);
        let mut results = Vec::with_capacity(2 * angles.len());
        for k in 0..angles.len() {
            let vector = k / lanes;
            for place in both[vector] {
                results.push(vec![self.lane(place, (k - starts[vector]) as u8)]);
            }
        }
        results
    }

    /// Returns sine and cosine of registers with equal lanes.
    fn reduced_and_evaluated(&mut self, angles: &[Value]) -> Vec<[Value; 2]> {
        let lanes = self.lanes(angles[0]);
        let steps = self.reduction.clone();
        let reduced: Vec<Reduced> = angles
            .iter()
            .map(|&angle| Reduced { angle, results: self.run(&steps, [angle, angle]) })
            .collect();
        let mut squares = None;
        for &angle in angles {
            squares = Some(match squares {
                None => self.binary(Operation::Multiply, angle, angle),
                Some(sum) => self.product_and_sum([angle, angle], sum, Negated::default()),
            });
        }
        let angle = trig_steps::limit::<S>();
        let limit = self.values.constants(vec![(angle * angle).bits(); lanes.into()], lanes);
        if let Some(squares) = squares {
            let check = FarCheck { squares, limit, angles: reduced.clone() };
            self.values.steps.push(Step::Check(check));
        }
        let steps = self.polynomials.clone();
        reduced.iter().map(|reduced| self.run(&steps, reduced.results)).collect()
    }

    /// Returns the results of recorded steps.
    fn run(&mut self, steps: &Steps, inputs: [Value; 2]) -> [Value; 2] {
        let lanes = self.lanes(inputs[0]);
        let mut values: Vec<Value> = Vec::with_capacity(steps.steps.len());
        for step in &steps.steps {
            let value = match *step {
                SineStep::Input(number) => inputs[number],
                SineStep::Constant(value) => self.constant(value, lanes),
                SineStep::Add(a, b) => self.binary(Operation::Add, values[a], values[b]),
                SineStep::Subtract(a, b) => self.binary(Operation::Subtract, values[a], values[b]),
                SineStep::Multiply(a, b) => self.binary(Operation::Multiply, values[a], values[b]),
                SineStep::MultiplyAdd(a, b, c) => {
                    self.product_and_sum([values[a], values[b]], values[c], Negated::default())
                }
                SineStep::FlipSign(a, b) => {
                    let bits = [values[b]];
                    let sign = self.values.operation(Operation::ShiftToSign, &bits, lanes);
                    self.binary(Operation::Xor, values[a], sign)
                }
            };
            values.push(value);
        }
        steps.results.map(|step| values[step])
    }
}
