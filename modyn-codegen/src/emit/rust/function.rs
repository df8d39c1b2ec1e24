//! Prints a program as straight-line Rust functions.
//!
//! Scopes become blocks, `let (live, ...) = { ... };`. Chunks become functions (`name_chunk0` and so on) that return the
//! values that later chunks read. The last chunk has the function's own name.

use std::cell::{Cell, OnceCell};
use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::{FloatType, Shape};
use crate::names::helper_type;
use crate::program::{
    Addend, Call, Chunk, MultiplyAdd, Operand, Operation, Program, Routine, Source, Target, Value,
};

/// A parameter, passed by reference.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub name: &'static str,
    pub shape: Shape,
    /// The type of the numbers of a table of constants; `None` for other parameters.
    constants: Option<&'static str>,
    /// Whether the parameter is the set of active contacts, for which public functions have a type.
    pub(super) contacts: bool,
}

impl Parameter {
    pub(super) fn new(name: &'static str, shape: Shape) -> Self {
        Self { name, shape, constants: None, contacts: false }
    }

    /// Returns the parameter, as the set of active contacts if `contacts`.
    pub(super) fn with_contacts(self, contacts: bool) -> Self {
        Self { contacts, ..self }
    }

    /// Returns a parameter of constants, in the type's own scalar.
    pub(super) fn constants(name: &'static str, shape: Shape, float: &'static str) -> Self {
        Self { name, shape, constants: Some(float), contacts: false }
    }

    /// Returns the name of entry `i` in the function. It differs from all temporaries: names of temporaries start with
    /// letters and a digit (`x1`, `s1_0`), names of parameters have letters only (and are not `k`, a function of
    /// constants).
    pub(super) fn entry(&self, i: usize) -> String {
        debug_assert!(self.name != "k" && !self.name.contains(|c: char| c.is_ascii_digit()));
        format!("{}_{i}", self.name)
    }

    /// Returns the parameter with its type over scalar `t`.
    pub(super) fn typed(&self, t: &str) -> String {
        format!("{}: &{}", self.name, self.shape.type_of(self.constants.unwrap_or(t)))
    }
}

/// A vector type of `V` with this number of lanes.
struct VectorType {
    lanes: u8,
    /// The name as a type parameter of functions, which compiles faster than a projection.
    name: &'static str,
    /// The name of the associated type of `V`.
    of: &'static str,
    /// The trait that the type implements.
    bound: &'static str,
}

/// The vector types of `V`.
const VECTORS: [VectorType; 4] = [
    VectorType { lanes: 1, name: "A", of: "One", bound: "Scalar" },
    VectorType { lanes: 2, name: "B", of: "Two", bound: "batch::Pack<A, 2>" },
    VectorType { lanes: 4, name: "C", of: "Four", bound: "batch::Pack<A, 4>" },
    VectorType { lanes: 8, name: "D", of: "Eight", bound: "batch::Pack<A, 8>" },
];

/// Returns the number of vector types among the type parameters of a function for [`Target::Simd`], before `V`.
pub(super) fn vector_types(program: &Program) -> usize {
    program.widths().len()
}

/// Returns the text of a private function `name` that computes `program`.
///
/// - [`Target::Scalar`]: generic over `T: Scalar`.
/// - [`Target::Batch`]: over `T: Lanes`. The function is always inlined into code that is compiled for the vector
///   instructions; chunks are outlined by the lanes. It returns nothing, and stores each entry of the `result` into
///   `outputs` as soon as it is computed: returned through the chunks, a matrix would be copied several times.
/// - [`Target::Simd`]: over vectors `V`, inlined in the same way.
pub(super) fn function(
    name: &str,
    parameters: &[Parameter],
    result: &Shape,
    program: &Program,
    float: FloatType,
) -> String {
    let (part, places) = (Cell::new(0), OnceCell::new());
    Printer { name, parameters, result, program, float, part, places }.function()
}

struct Printer<'a> {
    name: &'a str,
    parameters: &'a [Parameter],
    result: &'a Shape,
    program: &'a Program,
    /// The type of constants in tables.
    float: FloatType,
    /// The first statement of the chunk that is being printed.
    part: Cell<usize>,
    /// The texts of the values that earlier chunks compute.
    places: OnceCell<BTreeMap<Value, String>>,
}

impl Printer<'_> {
    fn function(&self) -> String {
        let mut text = String::new();
        for (number, routine) in self.program.routines.iter().enumerate() {
            self.routine(&mut text, number, routine);
        }
        let parts = &self.program.chunks;
        for (k, chunk) in parts.iter().enumerate() {
            self.part.set(chunk.statements.start);
            if k + 1 == parts.len() {
                self.entry_chunk(&mut text, chunk, &parts[..k]);
            } else {
                self.chunk(&mut text, k, chunk);
            }
        }
        text
    }

    /// Prints the last chunk, which has the function's name, calls the other chunks, and returns the result.
    fn entry_chunk(&self, text: &mut String, chunk: &Chunk, others: &[Chunk]) {
        let target = self.program.target;
        let (bounds, returned) = match target {
            Target::Scalar => ("T: __modyn::Scalar".into(), self.result.type_of("T")),
            Target::Batch => ("T: __modyn::batch::Lanes".into(), "()".into()),
            Target::Simd => {
                let of = self.vectors().map(|kind| format!("{} = {}", kind.of, kind.name));
                let of = of.collect::<Vec<_>>().join(", ");
                let bounds =
                    format!("{}, V: __modyn::batch::SimdBackend<{of}>", self.vector_bounds());
                (bounds, self.result.type_of("V::Number"))
            }
        };
        if target != Target::Scalar {
            *text += "#[inline(always)]\n";
        }
        *text += &head(self.name, &bounds, &self.inputs(), &returned);
        self.prelude(text);
        *text += &self.stores(&self.program.first_stores);
        self.call_parts(text, others);
        self.scopes(text, chunk);
        let results = self.program.results.iter().map(|result| match target {
            Target::Simd => format!("V::number({})", self.operand(result)),
            Target::Scalar | Target::Batch => self.operand(result),
        });
        let value = match target {
            Target::Batch => String::new(),
            Target::Scalar | Target::Simd => self.result.value(&results.collect::<Vec<_>>()),
        };
        let _ = writeln!(text, "    {value}\n}}\n");
    }

    /// Prints another chunk, which returns the values that later chunks read.
    fn chunk(&self, text: &mut String, k: usize, chunk: &Chunk) {
        let name = format!("{}_chunk{k}", self.name);
        let handed = chunk.live_in.iter().map(|&part| {
            format!("chunk{part}: &{}", self.types(&self.program.chunks[part].live_out))
        });
        let inputs: Vec<String> = self.inputs().into_iter().chain(handed).collect();
        let returned = self.types(&chunk.live_out);
        let end = match self.program.target {
            Target::Scalar => {
                *text += &head(&name, "T: __modyn::Scalar", &inputs, &returned);
                "}"
            }
            Target::Batch | Target::Simd => {
                *text += &self.outlined_head(&name, &inputs, &returned);
                "}\n}"
            }
        };
        self.prelude(text);
        self.scopes(text, chunk);
        let _ = writeln!(text, "    {}\n{end}\n", self.list(&chunk.live_out));
    }

    /// Returns the start of a chunk that lanes outline: a type that holds the arguments, and its function.
    fn outlined_head(&self, name: &str, inputs: &[String], returned: &str) -> String {
        let in_field = |input: &String| input.replace('&', "&'a ").replace("'_", "'a");
        let mut fields: Vec<String> = inputs.iter().map(in_field).collect();
        let names: Vec<&str> = inputs.iter().filter_map(|i| i.split(':').next()).collect();
        let kind = helper_type(name);
        let (bounds, own) = match self.program.target {
            Target::Simd => (self.vector_bounds(), self.vector_names()),
            Target::Scalar | Target::Batch => ("T: __modyn::batch::Lanes".into(), "T".into()),
        };
        fields.push(format!("of: ::core::marker::PhantomData<({own},)>"));
        format!(
            "struct {kind}<'a, {bounds}> {{ {} }}\n\
             impl<{bounds}> __modyn::batch::Chunk for {kind}<'_, {own}> {{\n\
             type Output = {returned};\n\
             #[inline(always)]\nfn run(self) -> {returned} {{\n    let Self {{ {}, .. }} = self;\n",
            fields.join(", "),
            names.join(", "),
        )
    }

    /// Returns the parameters with their types.
    fn inputs(&self) -> Vec<String> {
        let scalar = self.kind(1);
        let mut inputs: Vec<String> = self.parameters.iter().map(|p| p.typed(scalar)).collect();
        if self.program.target == Target::Batch {
            let count = self.result.len();
            inputs.push(format!("outputs: &__modyn::batch::Outputs<'_, T, {count}>"));
        }
        inputs
    }

    /// Prints the start of a function's body: the functions of constants, and the names of the arguments.
    fn prelude(&self, text: &mut String) {
        for VectorType { lanes, name, .. } in self.vectors() {
            let (lanes, kind) = match (self.program.target, *lanes) {
                (Target::Simd, 1) => (String::new(), *name),
                (Target::Simd, lanes) => (lanes.to_string(), *name),
                (Target::Scalar | Target::Batch, _) => (String::new(), "T"),
            };
            let _ = writeln!(text, "    let k{lanes} = {kind}::from_f64;");
        }
        for parameter in self.parameters {
            let _ = writeln!(text, "    {}", unpacked(parameter));
        }
    }

    /// Prints the calls of the earlier chunks, in the last chunk.
    fn call_parts(&self, text: &mut String, parts: &[Chunk]) {
        for (k, chunk) in parts.iter().enumerate() {
            let mut arguments: Vec<String> =
                self.parameters.iter().map(|p| p.name.to_string()).collect();
            if self.program.target == Target::Batch {
                arguments.push("outputs".into());
            }
            let scalar = self.program.target == Target::Scalar;
            let name = |part: &usize| match scalar {
                true => format!("&chunk{part}"),
                false => format!("chunk{part}: &chunk{part}"),
            };
            arguments.extend(chunk.live_in.iter().map(name));
            let (name, arguments) = (format!("{}_chunk{k}", self.name), arguments.join(", "));
            let (by, own) = match self.program.target {
                Target::Simd => ("V", self.vector_names()),
                Target::Scalar | Target::Batch => ("T", "T".into()),
            };
            let call = if scalar {
                format!("{name}({arguments})")
            } else {
                let part = format!("{}::<'_, {own}>", helper_type(&name));
                format!("{by}::outlined({part} {{ {arguments}, of: ::core::marker::PhantomData }})")
            };
            let _ = writeln!(text, "    let chunk{k} = {call};");
        }
    }

    /// Prints the statements of a chunk, in blocks if there are several scopes.
    fn scopes(&self, text: &mut String, chunk: &Chunk) {
        let statements = |text: &mut String, scope: &crate::program::Scope, indent: &str| {
            for s in scope.statements.clone() {
                self.statement(text, s, indent);
                *text += &self.stores(&self.program.statements[s].stores);
            }
        };
        if let [scope] = &*chunk.scopes {
            return statements(text, scope, "    ");
        }
        for scope in &chunk.scopes {
            let live = scope.live_out.iter().map(|&value| format!("{}, ", self.name(value)));
            let live: String = live.collect();
            let _ = writeln!(text, "    let ({live}) = {{");
            statements(text, scope, "        ");
            let _ = writeln!(text, "        ({live})\n    }};");
        }
    }

    /// Returns the statements that store results.
    fn stores(&self, results: &[usize]) -> String {
        let stored = |&i: &usize| {
            format!("outputs.set::<{i}>({});\n", self.operand(&self.program.results[i]))
        };
        results.iter().map(stored).collect()
    }

    fn statement(&self, text: &mut String, s: usize, indent: &str) {
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
            Operation::Call(call) => {
                if call.repetition == 0 && !call.common.is_empty() {
                    let _ = writeln!(text, "{indent}let common = &[{}];", self.all(&call.common));
                }
                format!("[{}]", names.join(", "))
            }
            _ => names.concat(),
        };
        let value = self.operation(&statement.operation, statement.lanes);
        let _ = writeln!(text, "{indent}let {pattern} = {value};");
    }

    /// Returns the text of an operation on this number of lanes.
    fn operation(&self, operation: &Operation, lanes: u8) -> String {
        let (t, kind) = (|operand| self.operand(operand), self.kind(lanes));
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
                let (product, sum) = (sign(negative_product), sign(negative_addend));
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
            Operation::Call(Call { routine, repetition, own, common }) => {
                let name = self.routine_name(*routine);
                let tables = &self.program.routines[*routine].tables;
                let table = (!tables[*repetition].is_empty())
                    .then(|| format!("&{}", table_name(&name, *repetition)));
                let own = (!own.is_empty()).then(|| format!("&[{}]", self.all(own)));
                let common = (!common.is_empty()).then(|| "common".to_string());
                let arguments: Vec<String> = [table, own, common].into_iter().flatten().collect();
                format!("{name}({})", arguments.join(", "))
            }
        }
    }

    /// Prints a routine's function and its tables of constants.
    fn routine(&self, text: &mut String, number: usize, routine: &Routine) {
        let (name, float) = (self.routine_name(number), self.float.name());
        let constants = routine.tables[0].len();
        let mut parameters = Vec::new();
        if constants > 0 {
            for (repetition, table) in routine.tables.iter().enumerate() {
                let row: Vec<String> = table.iter().map(|&x| literal(x, self.float)).collect();
                let (table, row) = (table_name(&name, repetition), row.join(", "));
                let _ = writeln!(text, "static {table}: [{float}; {constants}] = [{row}];\n");
            }
            parameters.push(Parameter::constants("table", Shape::vector(constants), float));
        }
        for (name, count) in [("own", routine.own), ("common", routine.common)] {
            if count > 0 {
                parameters.push(Parameter::new(name, Shape::vector(count)));
            }
        }
        if routine.tables.len() > 1 {
            *text += "#[inline(never)]\n";
        }
        let result = Shape::vector(routine.program.results.len());
        *text += &function(&name, &parameters, &result, &routine.program, self.float);
    }

    fn routine_name(&self, number: usize) -> String {
        format!("{}_routine{number}", self.name)
    }

    /// Returns the texts of operands, separated by commas.
    fn all(&self, operands: &[Operand]) -> String {
        operands.iter().map(|operand| self.operand(operand)).collect::<Vec<_>>().join(", ")
    }

    /// Returns the text of an operand.
    fn operand(&self, operand: &Operand) -> String {
        let text = match operand.source {
            Source::Constant(value) => constant(value, operand.lanes),
            Source::Argument(number) => self.argument(number),
            Source::Result(value) if value.statement < self.part.get() => {
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
    fn argument(&self, number: usize) -> String {
        let mut rest = number;
        for parameter in self.parameters {
            if rest < parameter.shape.len() {
                let name = parameter.entry(rest);
                let is_constant = parameter.constants.is_some();
                return if is_constant { format!("k(f64::from({name}))") } else { name };
            }
            rest -= parameter.shape.len();
        }
        unreachable!("a program's arguments are the function's parameters")
    }

    /// Returns the name of a value.
    fn name(&self, Value { statement: s, place }: Value) -> String {
        match &self.program.statements[s].operation {
            Operation::SinCos(angles) => {
                let function = if place % 2 == 0 { "s" } else { "c" };
                let angle =
                    if angles.len() == 1 { String::new() } else { format!("_{}", place / 2) };
                format!("{function}{s}{angle}")
            }
            Operation::Unpack(_) => format!("x{s}_{place}"),
            Operation::Call(call) => format!("p{}_{}_{place}", call.routine, call.repetition),
            _ => format!("x{s}"),
        }
    }

    /// Returns the texts of the values that earlier chunks compute.
    fn places(&self) -> &BTreeMap<Value, String> {
        self.places.get_or_init(|| {
            let mut places = BTreeMap::new();
            for (k, chunk) in self.program.chunks.iter().enumerate() {
                for (group, values) in self.by_width(&chunk.live_out).iter().enumerate() {
                    for (i, &value) in values.iter().enumerate() {
                        let group = match self.program.target {
                            Target::Simd => format!(".{group}"),
                            Target::Scalar | Target::Batch => String::new(),
                        };
                        places.insert(value, format!("chunk{k}{group}[{i}]"));
                    }
                }
            }
            places
        })
    }

    /// Returns values grouped by their lanes, as in [`VECTORS`].
    fn by_width(&self, values: &[Value]) -> [Vec<Value>; VECTORS.len()] {
        VECTORS.each_ref().map(|kind| {
            let of_kind =
                |value: &&Value| self.program.statements[value.statement].lanes == kind.lanes;
            values.iter().filter(of_kind).copied().collect()
        })
    }

    /// Returns the values that a chunk returns, as an expression.
    fn list(&self, values: &[Value]) -> String {
        let lists = self.by_width(values).map(|values| {
            let names: Vec<String> = values.iter().map(|&value| self.name(value)).collect();
            format!("[{}]", names.join(", "))
        });
        match self.program.target {
            Target::Simd => format!("({})", lists.join(", ")),
            Target::Scalar | Target::Batch => lists[0].clone(),
        }
    }

    /// Returns the type of the values that a chunk returns.
    fn types(&self, values: &[Value]) -> String {
        if self.program.target != Target::Simd {
            return format!("[T; {}]", values.len());
        }
        let groups = self.by_width(values);
        let types = VECTORS.iter().zip(&groups).map(|(kind, values)| {
            // An empty array has no values of a type that the function does not mention.
            let kind = if values.is_empty() { "A" } else { kind.name };
            format!("[{kind}; {}]", values.len())
        });
        format!("({})", types.collect::<Vec<_>>().join(", "))
    }

    /// Returns the type for this number of lanes.
    fn kind(&self, lanes: u8) -> &'static str {
        let vector = VECTORS.iter().find(|kind| kind.lanes == lanes);
        match (self.program.target, vector) {
            (Target::Simd, Some(vector)) => vector.name,
            _ => "T",
        }
    }

    /// Returns the vector types that the function mentions, scalars included.
    fn vectors(&self) -> impl Iterator<Item = &'static VectorType> {
        let widths = self.program.widths();
        VECTORS.iter().filter(move |kind| widths.contains(&kind.lanes))
    }

    /// Returns the type parameters of these types, with bounds.
    fn vector_bounds(&self) -> String {
        let bounded = self.vectors().map(|kind| format!("{}: __modyn::{}", kind.name, kind.bound));
        bounded.collect::<Vec<_>>().join(", ")
    }

    /// Returns the names of these types.
    fn vector_names(&self) -> String {
        self.vectors().map(|kind| kind.name).collect::<Vec<_>>().join(", ")
    }
}

/// Returns the name of the constants of one repetition.
fn table_name(routine: &str, repetition: usize) -> String {
    format!("{}_TABLE_{repetition}", routine.to_uppercase())
}

/// Returns the start of a function's text.
fn head(name: &str, bound: &str, inputs: &[String], returned: &str) -> String {
    format!("fn {name}<{bound}>({}) -> {returned} {{\n", inputs.join(", "))
}

/// Returns a constant as an expression, the same in all lanes.
fn constant(value: f64, lanes: u8) -> String {
    let k = if lanes == 1 { "k".to_string() } else { format!("k{lanes}") };
    format!("{k}({})", number(value))
}

/// Returns a constant in double precision.
fn number(value: f64) -> String {
    // Numbers of descriptions are below 1e60 (`read/xml/numbers.rs`), but folding multiplies them along a chain of any
    // length. An overflow is printed as the infinity that it would be at run time.
    literal(value, FloatType::F64)
}

/// Returns a constant as a literal of its type.
#[allow(clippy::cast_possible_truncation)]
pub(super) fn literal(value: f64, float: FloatType) -> String {
    let single = value as f32;
    match float {
        FloatType::F64 if value.is_finite() => format!("{value:?}"),
        FloatType::F64 => format!("f64::from_bits({})", value.to_bits()),
        // A literal that exceeds the type's range would not compile.
        FloatType::F32 if single.is_finite() => format!("{single:?}"),
        FloatType::F32 => format!("f32::from_bits({})", single.to_bits()),
    }
}

/// Returns the statement that names a parameter's entries.
pub(super) fn unpacked(parameter: &Parameter) -> String {
    let Parameter { name, shape, .. } = parameter;
    let names: Vec<String> = (0..shape.len()).map(|i| parameter.entry(i)).collect();
    format!("let {} = *{name};", shape.value(&names))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_literals_of_their_type() {
        assert_eq!(literal(0.1, FloatType::F64), "0.1");
        assert_eq!(literal(0.1, FloatType::F32), "0.1");
        assert_eq!(literal(-1e50, FloatType::F64), "-1e50");
        assert_eq!(literal(-1e50, FloatType::F32), "f32::from_bits(4286578688)");
        assert_eq!(literal(f64::INFINITY, FloatType::F64), "f64::from_bits(9218868437227405312)");
    }
}
