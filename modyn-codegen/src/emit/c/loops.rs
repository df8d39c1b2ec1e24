//! Prints loops over tables.

use std::fmt::Write as _;

use super::{Array as Parameter, Printer, literal};
use crate::program::{
    Array, Call, Column, Entry, Loop, Loops, Operand, Place, Program, Read, Step, Table,
    argument_of,
};

impl Printer {
    /// Prints the functions of a program's routines, and its tables.
    pub(super) fn routines_and_tables(&mut self, name: &str, program: &Program) {
        for (number, routine) in program.routines.iter().enumerate() {
            let constants = routine.constants;
            let reads = routine.program.arguments - constants;
            let arrays = [("table", constants), ("read", reads)];
            let nonempty = arrays.iter().filter(|(_, len)| *len > 0);
            let arrays: Vec<Parameter> =
                nonempty.map(|&(name, len)| Parameter { name: name.into(), len }).collect();
            let results = routine.program.results.len();
            let name = format!("{name}_routine{number}");
            self.function("static ", &name, &arrays, results, &routine.program);
        }
        for (number, table) in program.tables.iter().enumerate() {
            self.table(&format!("{name}_table{number}"), table);
        }
    }

    fn table(&mut self, name: &str, table: &Table) {
        let real = self.real();
        let float = self.float;
        let rows = table.rows.len();
        let constants = table.constants();
        let places = table.places();
        let mut print = |kind: &str, name: &str, count: usize, lines: Vec<String>| {
            let lines = lines.join(",\n");
            let _ = writeln!(
                self.source,
                "static const {kind} {name}[{rows}][{count}] = {{\n{lines}\n}};\n"
            );
        };
        let line = |numbers: Vec<String>| format!("    {{ {} }}", numbers.join(", "));
        if constants > 0 {
            let table_rows = table.rows.iter();
            let rows =
                table_rows.map(|row| row.constants.iter().map(|&x| literal(x, float)).collect());
            print(real, name, constants, rows.map(line).collect());
        }
        if places > 0 {
            let table_rows = table.rows.iter();
            let rows = table_rows.map(|row| row.places.iter().map(usize::to_string).collect());
            print(index_type(table), &format!("{name}_places"), places, rows.map(line).collect());
        }
    }
}

/// The statements of loops.
pub(super) struct LoopStatements<'a> {
    pub printer: &'a Printer,
    /// The name of the function.
    pub name: &'a str,
    /// The arguments of the function.
    pub given: &'a [Parameter],
    pub program: &'a Program,
    /// The name of the loops' arrays without their index.
    pub arrays: &'a str,
    /// The arrays.
    pub shapes: &'a [Array],
    /// Returns the text of an operand.
    pub operand: &'a dyn Fn(&Operand) -> String,
}

impl LoopStatements<'_> {
    /// Returns the statements that define the arrays and run the steps.
    pub(super) fn print(&self, loops: &Loops) -> String {
        let mut text = String::new();
        let printer = self.printer;
        let arrays = loops.arrays.iter().enumerate().filter(|(_, array)| !array.is_empty());
        for (array, shape) in arrays {
            let real = printer.real();
            let zero = literal(0.0, printer.float);
            let name = self.array(array);
            let (lengths, zero) = match shape.columns {
                1 => (format!("[{}]", shape.rows), format!("{{ {zero} }}")),
                columns => (format!("[{}][{columns}]", shape.rows), format!("{{ {{ {zero} }} }}")),
            };
            let _ = writeln!(text, "    {real} {name}{lengths} = {zero};");
        }
        for stored in &loops.stored {
            let value = (self.operand)(&stored.value);
            let _ = writeln!(text, "    {} = {value};", self.entry(&stored.entry));
        }
        self.steps(&mut text, &loops.steps, 0);
        text
    }

    fn steps(&self, text: &mut String, steps: &[Step], depth: usize) {
        for step in steps {
            match step {
                Step::Call(call) => self.call(text, call, depth),
                Step::Loop(inner) => self.iterations(text, inner, depth),
            }
        }
    }

    fn iterations(&self, text: &mut String, inner: &Loop, depth: usize) {
        let table = &self.program.tables[inner.table];
        let rows = table.rows.len();
        let indent = "    ".repeat(depth + 1);
        let i = format!("i{depth}");
        let name = format!("{}_table{}", self.name, inner.table);
        let order = match inner.reversed {
            false => format!("{i} = 0; {i} < {rows}; ++{i}"),
            true => format!("{i} = {rows} - 1; {i} >= 0; --{i}"),
        };
        let _ = writeln!(text, "{indent}for (int {order}) {{");
        let has_constants = inner.steps.iter().any(|step| match step {
            Step::Call(call) => self.program.routines[call.routine].constants > 0,
            Step::Loop(_) => false,
        });
        if has_constants {
            let real = self.printer.real();
            let _ = writeln!(text, "{indent}    const {real} *constants{depth} = {name}[{i}];");
        }
        if table.places() > 0 {
            let index = index_type(table);
            let _ =
                writeln!(text, "{indent}    const {index} *places{depth} = {name}_places[{i}];");
        }
        if let Some(end) = &inner.end {
            let zero = literal(0.0, self.printer.float);
            let _ = writeln!(text, "{indent}    if ({} >= {zero}) {{ break; }}", self.entry(end));
        }
        self.steps(text, &inner.steps, depth + 1);
        let _ = writeln!(text, "{indent}}}");
    }

    /// Prints the statements of a call: its numbers are read, the routine is called, and the
    /// results are stored.
    fn call(&self, text: &mut String, call: &Call, depth: usize) {
        let real = self.printer.real();
        let indent = "    ".repeat(depth + 1);
        let reads: Vec<String> = call.reads.iter().map(|read| self.read(read)).collect();
        let results = call.writes.len();
        let _ = writeln!(text, "{indent}{{\n{indent}    {real} results[{results}];");
        if !reads.is_empty() {
            let count = reads.len();
            let reads = reads.join(", ");
            let _ = writeln!(text, "{indent}    const {real} read[{count}] = {{ {reads} }};");
        }
        let has_constants = self.program.routines[call.routine].constants > 0;
        let constants = has_constants.then(|| format!("constants{}", depth - 1));
        let arguments: Vec<String> = constants
            .into_iter()
            .chain((!reads.is_empty()).then(|| "read".into()))
            .chain(["results".into()])
            .collect();
        let name = self.name;
        let arguments = arguments.join(", ");
        let _ = writeln!(text, "{indent}    {name}_routine{}({arguments});", call.routine);
        for (i, write) in call.writes.iter().enumerate() {
            let sign = if write.adds { "+" } else { "" };
            let entry = self.place(write.array, write.place);
            let _ = writeln!(text, "{indent}    {entry} {sign}= results[{i}];");
        }
        let _ = writeln!(text, "{indent}}}");
    }

    fn read(&self, read: &Read) -> String {
        match *read {
            Read::Argument(place) => {
                let argument = argument_of(place.index, self.given.iter().map(|array| array.len));
                let (argument, i) = argument.expect("an argument of the function");
                format!("{}[{}]", self.given[argument].name, index(i, place.row))
            }
            Read::Entry(array, place) => self.place(array, place),
        }
    }

    fn entry(&self, entry: &Entry) -> String {
        self.place(entry.array, Place::fixed(entry.index))
    }

    /// Returns the text of an entry of an array. Rows have an index of their own, so that compilers
    /// tell them from each other.
    fn place(&self, array: usize, place: Place) -> String {
        let name = self.array(array);
        let Array { columns, .. } = self.shapes[array];
        match place.row {
            _ if columns == 1 => format!("{name}[{}]", index(place.index, place.row)),
            None => format!("{name}[{}][{}]", place.index / columns, place.index % columns),
            Some(row) => format!("{name}[{}][{}]", row_index(row), place.index),
        }
    }

    fn array(&self, array: usize) -> String {
        format!("{}_{array}", self.arrays)
    }
}

/// Returns the text of an index after a place of a table.
fn index(index: usize, row: Option<Column>) -> String {
    match row {
        None => index.to_string(),
        Some(row) => format!("{} + {index}", row_index(row)),
    }
}

/// Returns the text of a place of a table.
fn row_index(row: Column) -> String {
    format!("places{}[{}]", row.depth, row.column)
}

/// Returns the type of the places of a table.
fn index_type(table: &Table) -> &'static str {
    // An `unsigned short` has at least 16 bits.
    if table.last_place() <= 65_535 { "unsigned short" } else { "unsigned long" }
}
