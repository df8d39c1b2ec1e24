//! Prints a program as C functions, one statement a line. Chunks become `static` functions (`name_chunk0` and so on) that
//! write the values that later chunks read into an array.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::{Array, FloatType, Printer, literal};
use crate::emit::support::Support;
use crate::program::{
    Addend, MultiplyAdd, Operand, Operation, Program, Source, Value, argument_of,
};

impl Printer {
    /// Prints the function of one program: its routines, its chunks, and the function itself.
    pub(in crate::emit) fn function(
        &mut self,
        linkage: &str,
        name: &str,
        given: &[Array],
        results: usize,
        program: &Program,
    ) {
        for (number, routine) in program.routines.iter().enumerate() {
            let constants = routine.tables[0].len();
            let arrays = [("table", constants), ("own", routine.own), ("common", routine.common)];
            let arrays = arrays.iter().filter(|(_, len)| *len > 0);
            let arrays: Vec<Array> =
                arrays.map(|&(name, len)| Array { name: name.into(), len }).collect();
            let results = routine.program.results.len();
            self.function(
                "static ",
                &format!("{name}_routine{number}"),
                &arrays,
                results,
                &routine.program,
            );
        }
        let last = program.chunks.len() - 1;
        for (k, chunk) in program.chunks.iter().enumerate() {
            let live_out = |k: usize| Array {
                name: format!("chunk{k}"),
                len: program.chunks[k].live_out.len(),
            };
            let body =
                Body { printer: &*self, name, given, program, first: chunk.statements.start };
            let mut text = String::new();
            let (linkage, name, arrays, out) = if k == last {
                for k in 0..last {
                    let live_in = program.chunks[k].live_in.iter().map(|&k| live_out(k));
                    let arrays: Vec<Array> =
                        given.iter().cloned().chain(live_in).chain([live_out(k)]).collect();
                    let names: Vec<&str> = arrays.iter().map(|array| array.name.as_str()).collect();
                    let (real, len) = (self.real(), live_out(k).len.max(1));
                    let _ = writeln!(text, "    {real} chunk{k}[{len}];");
                    let _ = writeln!(text, "    {name}_chunk{k}({});", names.join(", "));
                }
                (linkage, name.to_string(), given.to_vec(), results)
            } else {
                let live_in = chunk.live_in.iter().map(|&k| live_out(k));
                let arrays = given.iter().cloned().chain(live_in).collect();
                ("static ", format!("{name}_chunk{k}"), arrays, chunk.live_out.len())
            };
            let mut read = BTreeSet::new();
            for s in chunk.statements.clone() {
                body.statement(&mut text, s, &mut read);
            }
            let stored: Vec<String> = if k == last {
                program.results.iter().map(|result| body.operand(result, &mut read)).collect()
            } else {
                chunk.live_out.iter().map(|&value| body.value(value)).collect()
            };
            for (i, value) in stored.iter().enumerate() {
                let _ = writeln!(text, "    out[{i}] = {value};");
            }
            let mut unread = String::new();
            let calls = k == last && last > 0;
            let read = |name: &str| read.contains(name) || calls || name.starts_with("chunk");
            for array in arrays.iter().filter(|array| !read(&array.name)) {
                let _ = writeln!(unread, "    (void){};", array.name);
            }
            if stored.is_empty() {
                unread += "    (void)out;\n";
            }
            let head =
                format!("{linkage}void {name}({}{})", self.parameters(&arrays), self.output(out));
            let _ = writeln!(self.source, "{head}\n{{\n{unread}{text}}}\n");
            let statements = program.statements[chunk.statements.clone()].iter();
            self.support.extend(statements.filter_map(|s| Support::of(&s.operation)));
        }
    }
}

/// The statements of one function.
struct Body<'a> {
    printer: &'a Printer,
    name: &'a str,
    given: &'a [Array],
    program: &'a Program,
    /// The index of the chunk's first statement.
    first: usize,
}

impl Body<'_> {
    /// Prints a statement; the names of the arrays that it reads are added to `read`.
    fn statement(&self, text: &mut String, s: usize, read: &mut BTreeSet<String>) {
        let (real, double) = (self.printer.real(), self.printer.float == FloatType::F64);
        let operation = &self.program.statements[s].operation;
        let mut t = |operand: &Operand| self.operand(operand, read);
        let f = |name: &str| if double { name.to_string() } else { format!("{name}f") };
        let value = match operation {
            Operation::Add(a, b) => format!("{} + {}", t(a), t(b)),
            Operation::Subtract(a, b) => format!("{} - {}", t(a), t(b)),
            Operation::Multiply(a, b) => format!("{} * {}", t(a), t(b)),
            Operation::MultiplyAdd(MultiplyAdd {
                negative_product,
                factors,
                negative_addend,
                addend,
            }) => {
                let product = format!("({} * {})", t(&factors[0]), t(&factors[1]));
                let addend = match addend {
                    Addend::Value(a) => t(a),
                    Addend::Product(a, b) => format!("({} * {})", t(a), t(b)),
                };
                match (negative_product, negative_addend) {
                    (false, false) => format!("{product} + {addend}"),
                    (false, true) => format!("{product} - {addend}"),
                    (true, false) => format!("{addend} - {product}"),
                    (true, true) => format!("-{product} - {addend}"),
                }
            }
            Operation::Reciprocal(a) => format!("{} / {}", literal(1.0, self.printer.float), t(a)),
            Operation::SinCos(angles) => {
                for (i, angle) in angles.iter().enumerate() {
                    let (angle, sine, cosine) =
                        (t(angle), self.local(s, 2 * i), self.local(s, 2 * i + 1));
                    let _ = writeln!(
                        text,
                        "    {real} {sine};\n    {real} {cosine};\n    modyn_sin_cos({angle}, &{sine}, &{cosine});"
                    );
                }
                return;
            }
            Operation::Atan2(a, b) => format!("modyn_atan2({}, {})", t(a), t(b)),
            Operation::SquareRoot(a) => format!("{}({})", f("sqrt"), t(a)),
            Operation::Logarithm(a) => format!("modyn_ln({})", t(a)),
            Operation::Absolute(a) => format!("{}({})", f("fabs"), t(a)),
            Operation::Maximum(a, b) => format!("modyn_maximum({}, {})", t(a), t(b)),
            Operation::Select(a, b, c) => {
                let zero = literal(0.0, self.printer.float);
                format!("({} >= {zero}) ? {} : {}", t(a), t(b), t(c))
            }
            Operation::Call(call) => {
                let (p, k) = (call.routine, call.repetition);
                let routine = &self.program.routines[p];
                let mut array = |name: &str, list: Vec<String>| {
                    let (name, len, list) = (format!("{name}{p}_{k}"), list.len(), list.join(", "));
                    let kind = if list.is_empty() { return None } else { format!("const {real}") };
                    let _ = writeln!(text, "    {kind} {name}[{len}] = {{ {list} }};");
                    Some(name)
                };
                let table = routine.tables[k].iter().map(|&x| literal(x, self.printer.float));
                let table = array("table", table.collect());
                let own = array("own", call.own.iter().map(&mut t).collect());
                let common = array("common", call.common.iter().map(&mut t).collect());
                let result = format!("p{p}_{k}");
                let _ = writeln!(
                    text,
                    "    {real} {result}[{}];",
                    routine.program.results.len().max(1)
                );
                let all: Vec<String> =
                    [table, own, common, Some(result)].into_iter().flatten().collect();
                let _ = writeln!(text, "    {}_routine{p}({});", self.name, all.join(", "));
                return;
            }
            Operation::Pack(_) | Operation::Constants(_) | Operation::Unpack(_) => {
                unreachable!("a program on scalars has no lanes")
            }
        };
        let _ = writeln!(text, "    const {real} x{s} = {value};");
    }

    fn operand(&self, operand: &Operand, read: &mut BTreeSet<String>) -> String {
        let text = match operand.source {
            Source::Constant(value) if value.is_sign_negative() => {
                format!("({})", literal(value, self.printer.float))
            }
            Source::Constant(value) => literal(value, self.printer.float),
            Source::Argument(number) => {
                let lengths = self.given.iter().map(|array| array.len);
                let (array, i) = argument_of(number, lengths).expect("arguments are counted");
                let name = &self.given[array].name;
                read.insert(name.clone());
                format!("{name}[{i}]")
            }
            Source::Result(value) => self.value(value),
        };
        if operand.negated { format!("(-{text})") } else { text }
    }

    /// Returns the text of a value: a local variable, or an entry of an earlier chunk's array.
    fn value(&self, value: Value) -> String {
        if value.statement >= self.first {
            return self.local(value.statement, value.place);
        }
        let place = self.program.place_of(value);
        let (chunk, i) = place.expect("a value that crosses a cut is named there");
        format!("chunk{chunk}[{i}]")
    }

    fn local(&self, s: usize, place: usize) -> String {
        match &self.program.statements[s].operation {
            Operation::SinCos(_) if place.is_multiple_of(2) => format!("s{s}_{}", place / 2),
            Operation::SinCos(_) => format!("c{s}_{}", place / 2),
            Operation::Call(call) => format!("p{}_{}[{place}]", call.routine, call.repetition),
            _ => format!("x{s}"),
        }
    }
}
