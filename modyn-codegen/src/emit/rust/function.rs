//! Prints a program as straight-line Rust functions.
//!
//! Scopes become blocks, `let (live, ...) = { ... };`. Chunks become functions (`name_chunk0` and
//! so on) that return the values that later chunks read. The last chunk has the function's own
//! name.

mod loops;
pub(crate) mod operations;
mod products;
mod row_equations;
mod vectors;

use std::cell::{Cell, OnceCell};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::FloatType;
use super::parameter::{Parameter, unpacked};
use super::shape::Shape;
use crate::names::helper_type;
use crate::program::{
    Chunk, Execution, Operand, ProductMatrix, Products, Program, Scope, Value, is_zero,
};
use vectors::VectorType;

pub(super) use operations::literal;

/// Returns the number of vector types among the type parameters of a function for
/// [`Execution::Simd`], before `V`.
pub(super) fn vector_types(program: &Program) -> usize {
    program.widths().len()
}

/// Returns the text of a private function `name` that computes `program`.
///
/// - [`Execution::Scalar`]: generic over `T: Scalar`.
/// - [`Execution::Batch`]: over `T: Lanes`. The function is always inlined into code that is
///   compiled for the vector instructions; chunks are outlined by the lanes. It returns nothing,
///   and stores each entry of the `result` into `outputs` as soon as it is computed: returned
///   through the chunks, a matrix would be copied several times.
/// - [`Execution::Simd`]: over vectors `V`, inlined in the same way.
pub(super) fn function(
    name: &str,
    parameters: &[Parameter],
    result: &Shape,
    program: &Program,
    float: FloatType,
) -> String {
    let chunk_start = Cell::new(0);
    let places = OnceCell::new();
    let replaced = OnceCell::new();
    Printer { name, parameters, result, program, float, chunk_start, places, replaced }.function()
}

struct Printer<'a> {
    name: &'a str,
    parameters: &'a [Parameter],
    result: &'a Shape,
    program: &'a Program,
    /// The type of constants in tables.
    float: FloatType,
    /// The first statement of the chunk that is being printed.
    chunk_start: Cell<usize>,
    /// The texts of the values that earlier chunks compute.
    places: OnceCell<BTreeMap<Value, String>>,
    /// The results that products replace.
    replaced: OnceCell<BTreeSet<usize>>,
}

impl Printer<'_> {
    fn function(&self) -> String {
        let mut text = String::new();
        for (number, routine) in self.program.routines.iter().enumerate() {
            self.routine(&mut text, number, routine);
        }
        for (number, table) in self.program.tables.iter().enumerate() {
            self.table(&mut text, number, table);
        }
        let chunks = &self.program.chunks;
        for (k, chunk) in chunks.iter().enumerate() {
            self.chunk_start.set(chunk.statements.start);
            if k + 1 == chunks.len() {
                self.entry_chunk(&mut text, chunk, &chunks[..k]);
            } else {
                self.chunk(&mut text, k, chunk);
            }
        }
        text
    }

    /// Prints the last chunk, which has the function's name, calls the other chunks, and returns
    /// the result.
    fn entry_chunk(&self, text: &mut String, chunk: &Chunk, others: &[Chunk]) {
        let execution = self.program.execution;
        let (bounds, returned) = match execution {
            Execution::Scalar => ("T: __modyn::Scalar".into(), self.result.type_of("T")),
            Execution::Batch | Execution::Threads => {
                ("T: __modyn::batch::Lanes".into(), "()".into())
            }
            Execution::Simd => (self.backend_bounds(), self.result.type_of("V::Number")),
        };
        if execution != Execution::Scalar {
            *text += "#[inline(always)]\n";
        }
        *text += &head(self.name, &bounds, &self.inputs(), &returned);
        self.prelude(text);
        for ProductMatrix { name, columns, rows } in self.arrays() {
            let zero = self.zero();
            let _ = writeln!(text, "    let mut {name} = [[{zero}; {rows}]; {columns}];");
        }
        *text += &self.stores(&self.program.first_stores);
        self.call_chunks(text, others);
        self.scopes(text, chunk);
        let products = self.program.products.as_ref();
        let before = products.map(|products| products.before(&self.program.results));
        let operands = before.as_ref().unwrap_or(&self.program.results).iter();
        let results = operands.map(|result| self.number(result));
        let value = match execution {
            Execution::Batch => String::new(),
            _ => self.result.value(&results.collect::<Vec<_>>()),
        };
        if let Some(products) = products {
            return self.products(text, &value, products);
        }
        let _ = writeln!(text, "    {value}\n}}\n");
    }

    /// Returns the arrays of the program's products, into which statements store at once.
    fn arrays(&self) -> Vec<ProductMatrix> {
        self.program.products.iter().flat_map(Products::arrays).collect()
    }

    /// Returns zero as a number of the result.
    fn zero(&self) -> &'static str {
        match self.program.execution {
            Execution::Simd => "V::number(V::One::zero())",
            _ => "T::zero()",
        }
    }

    /// Returns the type of the result's numbers.
    fn number_type(&self) -> &'static str {
        match self.program.execution {
            Execution::Simd => "V::Number",
            _ => "T",
        }
    }

    /// Returns an operand as a number of the result.
    fn number(&self, operand: &Operand) -> String {
        match self.program.execution {
            Execution::Simd => format!("V::number({})", self.operand(operand)),
            _ => self.operand(operand),
        }
    }

    /// Prints another chunk, which returns the values that later chunks read.
    fn chunk(&self, text: &mut String, k: usize, chunk: &Chunk) {
        let name = format!("{}_chunk{k}", self.name);
        let live_in = chunk.live_in.iter().map(|&earlier| {
            format!("chunk{earlier}: &{}", self.types(&self.program.chunks[earlier].live_out))
        });
        let number = self.number_type();
        let matrices = self.arrays().into_iter().map(|ProductMatrix { name, columns, rows }| {
            format!("{name}: &mut [[{number}; {rows}]; {columns}]")
        });
        let inputs: Vec<String> =
            self.inputs().into_iter().chain(live_in).chain(matrices).collect();
        let returned = self.types(&chunk.live_out);
        let end = match self.program.execution {
            Execution::Scalar => {
                *text += &head(&name, "T: __modyn::Scalar", &inputs, &returned);
                "}"
            }
            _ => {
                *text += &self.outlined_head(&name, &inputs, &returned);
                "}\n}"
            }
        };
        self.prelude(text);
        self.scopes(text, chunk);
        let _ = writeln!(text, "    {}\n{end}\n", self.list(&chunk.live_out));
    }

    /// Returns the start of a chunk that lanes outline: a type that holds the arguments, and its
    /// function.
    fn outlined_head(&self, name: &str, inputs: &[String], returned: &str) -> String {
        let in_field = |input: &String| input.replace('&', "&'a ").replace("'_", "'a");
        let mut fields: Vec<String> = inputs.iter().map(in_field).collect();
        let names: Vec<&str> = inputs.iter().filter_map(|i| i.split(':').next()).collect();
        let kind = helper_type(name);
        let (bounds, generics) = match self.program.execution {
            Execution::Simd => (self.backend_bounds(), format!("{}, V", self.vector_names())),
            _ => ("T: __modyn::batch::Lanes".into(), "T".into()),
        };
        fields.push(format!("of: ::core::marker::PhantomData<({generics},)>"));
        format!(
            "struct {kind}<'a, {bounds}> {{ {} }}\n\
             impl<{bounds}> __modyn::batch::Chunk for {kind}<'_, {generics}> {{\n\
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
        if self.program.execution == Execution::Batch {
            let count = self.result.len();
            inputs.push(format!("outputs: &__modyn::batch::Outputs<'_, T, {count}>"));
        }
        inputs
    }

    /// Prints the start of a function's body: the functions of constants, and the names of the
    /// arguments.
    fn prelude(&self, text: &mut String) {
        for VectorType { lanes, name, .. } in self.vectors() {
            let (lanes, kind) = match (self.program.execution, *lanes) {
                (Execution::Simd, 1) => (String::new(), *name),
                (Execution::Simd, lanes) => (lanes.to_string(), *name),
                (_, _) => (String::new(), "T"),
            };
            let _ = writeln!(text, "    let k{lanes} = {kind}::from_f64;");
        }
        for parameter in self.parameters {
            let _ = writeln!(text, "    {}", unpacked(parameter));
        }
    }

    /// Prints the calls of the earlier chunks, in the last chunk.
    fn call_chunks(&self, text: &mut String, chunks: &[Chunk]) {
        for (k, chunk) in chunks.iter().enumerate() {
            let mut arguments: Vec<String> =
                self.parameters.iter().map(|p| p.name.to_string()).collect();
            if self.program.execution == Execution::Batch {
                arguments.push("outputs".into());
            }
            let scalar = self.program.execution == Execution::Scalar;
            let name = |earlier: &usize| match scalar {
                true => format!("&chunk{earlier}"),
                false => format!("chunk{earlier}: &chunk{earlier}"),
            };
            arguments.extend(chunk.live_in.iter().map(name));
            arguments.extend(self.arrays().into_iter().map(
                |ProductMatrix { name, .. }| match scalar {
                    true => format!("&mut {name}"),
                    false => format!("{name}: &mut {name}"),
                },
            ));
            let name = format!("{}_chunk{k}", self.name);
            let arguments = arguments.join(", ");
            let (by, generics) = match self.program.execution {
                Execution::Simd => ("V", format!("{}, V", self.vector_names())),
                _ => ("T", "T".into()),
            };
            let call = if scalar {
                format!("{name}({arguments})")
            } else {
                let kind = format!("{}::<'_, {generics}>", helper_type(&name));
                format!("{by}::outlined({kind} {{ {arguments}, of: ::core::marker::PhantomData }})")
            };
            let _ = writeln!(text, "    let chunk{k} = {call};");
        }
    }

    /// Prints the statements of a chunk, in blocks if there are several scopes.
    fn scopes(&self, text: &mut String, chunk: &Chunk) {
        let statements = |text: &mut String, scope: &Scope, indent: &str| {
            for s in scope.statements.clone() {
                self.statement(text, s, indent);
                *text += &self.stores(&self.program.statements[s].stores);
            }
        };
        if let [scope] = &*chunk.scopes {
            return statements(text, scope, "    ");
        }
        for scope in &chunk.scopes {
            let names = scope.live_out.iter().map(|&value| format!("{}, ", self.name(value)));
            let live: String = names.collect();
            let _ = writeln!(text, "    let ({live}) = {{");
            statements(text, scope, "        ");
            let _ = writeln!(text, "        ({live})\n    }};");
        }
    }

    /// Returns the statements that store these numbers.
    fn stores(&self, numbers: &[usize]) -> String {
        let products = self.program.products.as_ref();
        let replaced = self.replaced.get_or_init(|| {
            let replaced = products.map(|products| products.replaced(&self.program.results));
            replaced.unwrap_or_default()
        });
        let stored = |&i: &usize| {
            let operand = self.program.stored(i);
            if let Some(result) = self.program.stored_result(i) {
                if replaced.contains(&result) {
                    return String::new();
                }
                return format!("outputs.set::<{result}>({});\n", self.operand(operand));
            }
            match products.and_then(|products| products.place(i)) {
                // The arrays are filled with zeros.
                Some((ProductMatrix { name, rows, .. }, index)) if !is_zero(operand) => {
                    let column = index / rows;
                    let row = index % rows;
                    format!("{name}[{column}][{row}] = {};\n", self.number(operand))
                }
                _ => String::new(),
            }
        };
        numbers.iter().map(stored).collect()
    }
}

/// Returns the start of a function's text.
fn head(name: &str, bound: &str, inputs: &[String], returned: &str) -> String {
    format!("fn {name}<{bound}>({}) -> {returned} {{\n", inputs.join(", "))
}
