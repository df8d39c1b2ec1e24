//! The common parts of the tests: robots, states, and programs run on numbers that fuse products with sums.

#![allow(dead_code)] // Each test uses a part.

pub use modyn_tests::random;

use std::ops::{Add, Div, Mul, Neg, Sub};

use modyn_codegen::program::Program;
use modyn_codegen::{Builder, Function, Planning, ReadOptions, read};
use modyn_jit::{InstructionSet, Real};
use modyn_runtime::Scalar;
use modyn_runtime::model::Model;
use modyn_runtime::steps::{self, Step, Steps};

/// The robots of the folder `robots`.
pub const ROBOTS: [&str; 11] = [
    "double_pendulum",
    "gripper",
    "mimic_gripper",
    "five_bar",
    "arm6",
    "joint_zoo",
    "biped",
    "four_bar",
    "arm7",
    "quadruped",
    "humanoid",
];

/// Returns a robot of the folder `robots`.
pub fn robot(name: &str) -> Model {
    let path = format!("{}/../robots/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a robot");
    read(&text, name, &ReadOptions::default()).expect("good").model
}

/// Returns the programs of some functions of a robot; those about loops only if it has loops.
pub fn plan(name: &str, functions: &[Function]) -> Planning {
    let builder = Builder::new().model(robot(name));
    builder.functions(functions.iter().copied()).plan().expect("good")
}

/// Random numbers.
pub fn numbers<F: Fuse>(seed: u64, count: usize, scale: f64) -> Vec<F> {
    let mut random = random::Random::new(seed);
    (0..count).map(|_| F::from_f64(random.between(-scale, scale))).collect()
}

/// Returns numbers as several arrays.
pub fn split<'a, F>(mut numbers: &'a [F], lengths: &[usize]) -> Vec<&'a [F]> {
    let next = |&length: &usize| {
        let (first, rest) = numbers.split_at(length);
        numbers = rest;
        first
    };
    lengths.iter().map(next).collect()
}

/// Returns the instruction sets of this processor.
pub fn instruction_sets() -> impl Iterator<Item = InstructionSet> {
    InstructionSet::ALL.into_iter().filter(|instruction_set| instruction_set.is_available())
}

/// Returns the instruction sets of x86-64, which this processor may lack.
pub fn sets_of_x86_64() -> impl Iterator<Item = InstructionSet> {
    InstructionSet::ALL.into_iter().filter(|set| set.architecture() == "x86_64")
}

/// Returns whether code for one state uses vectors.
pub fn has_vectors<F>(instruction_set: InstructionSet) -> bool {
    instruction_set.fuses() || size_of::<F>() == 4
}

/// Returns the programs that an instruction set runs for one state; `None` for functions of a link.
pub fn program(planning: &Planning, function: Function, vectors: bool) -> Option<&Program> {
    let planned = planning.plan.functions.iter().find(|p| p.function == Some(function))?;
    planned.kernels.straight().map(|(scalar, simd)| if vectors { simd } else { scalar })
}

/// A number that fuses products with sums, whatever the tests were compiled for.
#[derive(Clone, Copy, Debug)]
pub struct Fused<F>(pub F);

/// The operations of a float that `Fused` needs.
pub trait Fuse: Real {
    fn fused(self, a: Self, b: Self) -> Self;
    fn low_bit(self) -> bool;
    fn of_bits(bits: u64) -> Self;
}

impl Fuse for f64 {
    fn fused(self, a: Self, b: Self) -> Self {
        f64::mul_add(self, a, b)
    }

    fn of_bits(bits: u64) -> Self {
        Self::from_bits(bits)
    }

    fn low_bit(self) -> bool {
        self.to_bits() & 1 == 1
    }
}

impl Fuse for f32 {
    fn fused(self, a: Self, b: Self) -> Self {
        f32::mul_add(self, a, b)
    }

    fn of_bits(bits: u64) -> Self {
        Self::from_bits(bits as u32)
    }

    fn low_bit(self) -> bool {
        self.to_bits() & 1 == 1
    }
}

macro_rules! operator {
    ($($operator:ident $function:ident,)*) => {$(
        impl<F: Fuse> $operator for Fused<F> {
            type Output = Self;

            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    )*};
}

operator!(Add add, Sub sub, Mul mul, Div div,);

impl<F: Fuse> Neg for Fused<F> {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<F: Fuse> Scalar for Fused<F> {
    fn from_f64(value: f64) -> Self {
        Self(F::from_f64(value))
    }

    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(self.0.fused(factor.0, term.0))
    }

    fn sin_cos(self) -> (Self, Self) {
        let near = self.0.abs() < steps::limit();
        let reduced = if near {
            run(&Steps::reduction::<F>(), [self; 2])
        } else {
            steps::reduce_far(self.0).map(Self)
        };
        let [sine, cosine] = run(&Steps::polynomials::<F>(), reduced);
        (sine, cosine)
    }

    fn atan2(self, x: Self) -> Self {
        Self(self.0.atan2(x.0))
    }

    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    fn ln(self) -> Self {
        Self(self.0.ln())
    }

    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        Self(self.0.select_nonnegative(then.0, otherwise.0))
    }
}

fn run<F: Fuse>(steps: &Steps, inputs: [Fused<F>; 2]) -> [Fused<F>; 2] {
    let mut values: Vec<Fused<F>> = Vec::new();
    for step in &steps.steps {
        values.push(match *step {
            Step::Input(number) => inputs[number],
            Step::Constant(value) => Fused::from_f64(value),
            Step::Add(a, b) => values[a] + values[b],
            Step::Subtract(a, b) => values[a] - values[b],
            Step::Multiply(a, b) => values[a] * values[b],
            Step::MultiplyAdd(a, b, c) => values[a].mul_add(values[b], values[c]),
            Step::FlipSign(a, b) if values[b].0.low_bit() => -values[a],
            Step::FlipSign(a, _) => values[a],
        });
    }
    steps.results.map(|step| values[step])
}

/// Returns a program's results with the instruction set's rounding.
pub fn evaluate<F: Fuse>(
    program: &Program,
    instruction_set: InstructionSet,
    arguments: &[F],
) -> Vec<F> {
    if instruction_set.fuses() {
        let arguments: Vec<Fused<F>> = arguments.iter().copied().map(Fused).collect();
        program.evaluate(&arguments).into_iter().map(|x| x.0).collect()
    } else {
        program.evaluate(arguments)
    }
}

/// Returns whether two numbers have the same bits; every NaN equals every other.
pub fn is_same<F: Real>(a: F, b: F) -> bool {
    let nan = |x: F| x.partial_cmp(&x).is_none();
    a.bits() == b.bits() || nan(a) && nan(b)
}
