//! Statements, operations and operands.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::{Printer, row_equations};
use crate::emit::FloatType;
use crate::program::{
    Addend, Execution, MultiplyAdd, Operand, Operation, Source, Value, argument_of,
};

impl Printer<'_> {
    pub(super) fn statement(&self, text: &mut String, s: usize, indent: &str) {
        let statement = &self.program.statements[s];
        // Where several results are bound, `_` replaces those that are not read.
        let names: Vec<String> = statement
            .used
            .iter()
            .enumerate()
            .map(|(place, used)| match used {
                true => self.name(Value { statement: s, place }),
                false => "_".into(),
            })
            .collect();
        let pattern = match &statement.operation {
            Operation::SinCos(angles) => {
                let pairs: Vec<String> =
                    names.chunks(2).map(|pair| format!("({})", pair.join(", "))).collect();
                if angles.len() == 1 { pairs.concat() } else { format!("[{}]", pairs.join(", ")) }
            }
            Operation::Unpack(_) => format!("[{}]", names.join(", ")),
            Operation::RowEquations(equations) => row_equations::pattern(equations, &names),
            Operation::Loops(_) => format!("[{}]", names.join(", ")),
            _ => names.concat(),
        };
        let value = self.operation(&statement.operation, statement.lanes);
        let _ = writeln!(text, "{indent}let {pattern} = {value};");
    }

    /// Returns the text of an operation on this number of lanes.
    pub(super) fn operation(&self, operation: &Operation, lanes: u8) -> String {
        let t = |operand| self.operand(operand);
        let kind = self.kind(lanes);
        let call = |function: &str, operands: &[Operand]| {
            format!("{kind}::{function}({})", self.all(operands))
        };
        match operation {
            Operation::Add(a, b) => format!("{} + {}", t(a), t(b)),
            Operation::Subtract(a, b) => format!("{} - {}", t(a), t(b)),
            Operation::Multiply(a, b) => format!("{} * {}", t(a), t(b)),
            Operation::MultiplyAdd(MultiplyAdd {
                negative_product,
                factors: [a, b],
                negative_addend,
                addend,
            }) => {
                let sign = |negative: &bool| if *negative { "-" } else { "" };
                let addend = match addend {
                    Addend::Value(addend) => t(addend),
                    Addend::Product(a, b) => format!("{} * {}", t(a), t(b)),
                };
                let product = sign(negative_product);
                let sum = sign(negative_addend);
                format!("{kind}::mul_add({product}{}, {}, {sum}{addend})", t(a), t(b))
            }
            Operation::Reciprocal(a) => call("recip", &[*a]),
            Operation::SinCos(angles) if angles.len() == 1 => call("sin_cos", angles),
            Operation::SinCos(angles) => format!("{kind}::sin_cos_all([{}])", self.all(angles)),
            Operation::Atan2(a, b) => call("atan2", &[*a, *b]),
            Operation::SquareRoot(a) => call("sqrt", &[*a]),
            Operation::Logarithm(a) => call("ln", &[*a]),
            Operation::Absolute(a) => call("abs", &[*a]),
            Operation::Maximum(a, b) => call("max", &[*a, *b]),
            Operation::Select(a, b, c) => call("select_nonnegative", &[*a, *b, *c]),
            Operation::Pack(lanes) => format!("{kind}::pack([{}])", self.all(lanes)),
            Operation::Constants(lanes) => {
                let lanes: Vec<String> = lanes.iter().map(|&lane| number(lane)).collect();
                format!("{kind}::constants([{}])", lanes.join(", "))
            }
            Operation::Unpack(a) => format!("{}::unpack({})", self.kind(a.lanes), t(a)),
            Operation::RowEquations(equations) => self.row_equations(equations),
            Operation::Loops(loops) => self.loops(loops),
        }
    }

    /// Returns the texts of operands, separated by commas.
    pub(super) fn all(&self, operands: &[Operand]) -> String {
        operands.iter().map(|operand| self.operand(operand)).collect::<Vec<_>>().join(", ")
    }

    /// Returns the text of an operand.
    pub(super) fn operand(&self, operand: &Operand) -> String {
        let text = match operand.source {
            Source::Constant(value) => constant(value, operand.lanes),
            Source::Argument(number) => self.argument(number),
            Source::Result(value) if value.statement < self.chunk_start.get() => {
                self.places()[&value].clone()
            }
            Source::Result(value) => self.name(value),
        };
        let sign = if operand.negated { "-" } else { "" };
        let constant = matches!(operand.source, Source::Constant(_));
        if constant || self.program.lanes_of(operand.source) == operand.lanes {
            format!("{sign}{text}")
        } else {
            format!("{}::broadcast({sign}{text})", self.kind(operand.lanes))
        }
    }

    /// Returns the text of a scalar argument.
    pub(super) fn argument(&self, number: usize) -> String {
        let lengths = self.parameters.iter().map(|parameter| parameter.shape.len());
        let place = argument_of(number, lengths);
        let (parameter, i) = place.expect("a program's arguments are the function's parameters");
        let parameter = &self.parameters[parameter];
        let name = parameter.entry(i);
        if parameter.constants.is_some() { format!("k(f64::from({name}))") } else { name }
    }

    /// Returns the name of a value.
    pub(super) fn name(&self, Value { statement: s, place }: Value) -> String {
        match &self.program.statements[s].operation {
            Operation::SinCos(angles) => {
                let function = if place % 2 == 0 { "s" } else { "c" };
                let angle =
                    if angles.len() == 1 { String::new() } else { format!("_{}", place / 2) };
                format!("{function}{s}{angle}")
            }
            Operation::Unpack(_) | Operation::RowEquations(_) | Operation::Loops(_) => {
                format!("x{s}_{place}")
            }
            _ => format!("x{s}"),
        }
    }

    /// Returns the texts of the values that earlier chunks compute.
    pub(super) fn places(&self) -> &BTreeMap<Value, String> {
        self.places.get_or_init(|| {
            let mut places = BTreeMap::new();
            for (k, chunk) in self.program.chunks.iter().enumerate() {
                for (group, values) in self.by_width(&chunk.live_out).iter().enumerate() {
                    for (i, &value) in values.iter().enumerate() {
                        let group = match self.program.execution {
                            Execution::Simd => format!(".{group}"),
                            _ => String::new(),
                        };
                        places.insert(value, format!("chunk{k}{group}[{i}]"));
                    }
                }
            }
            places
        })
    }
}

/// Returns a constant as an expression, the same in all lanes.
fn constant(value: f64, lanes: u8) -> String {
    let k = if lanes == 1 { "k".to_string() } else { format!("k{lanes}") };
    format!("{k}({})", number(value))
}

/// Returns a constant in double precision.
fn number(value: f64) -> String {
    // Numbers of descriptions are below 1e60 (`read/xml/numbers.rs`), but folding multiplies them
    // along a chain of any length. An overflow is printed as the infinity that it would be at run
    // time.
    literal(value, FloatType::F64)
}

/// Returns a constant as a literal of its type.
#[allow(clippy::cast_possible_truncation)]
pub fn literal(value: f64, float: FloatType) -> String {
    let single = value as f32;
    match float {
        FloatType::F64 if value.is_finite() => format!("{value:?}"),
        FloatType::F64 => format!("f64::from_bits({})", value.to_bits()),
        // A literal that exceeds the type's range would not compile.
        FloatType::F32 if single.is_finite() => format!("{single:?}"),
        FloatType::F32 => format!("f32::from_bits({})", single.to_bits()),
    }
}
