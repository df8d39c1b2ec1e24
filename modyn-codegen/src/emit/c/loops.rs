//! The routines and tables of loops, and their syntax.

use std::fmt::Write as _;

use super::function::C;
use super::{Array as Parameter, Printer, literal};
use crate::emit::statements::{Around, Iterations, RoutineCall};
use crate::program::{Array, Program, Table};

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

impl C<'_> {
    /// Returns the statement that defines an array of zeros.
    pub(super) fn array_of_zeros(&self, name: &str, shape: Array) -> String {
        let real = self.printer.real();
        let zero = literal(0.0, self.printer.float);
        let (lengths, zero) = match shape.columns {
            1 => (format!("[{}]", shape.rows), format!("{{ {zero} }}")),
            columns => (format!("[{}][{columns}]", shape.rows), format!("{{ {{ {zero} }} }}")),
        };
        format!("{real} {name}{lengths} = {zero};")
    }

    /// Returns the lines around the steps of a loop.
    pub(super) fn around_steps(&self, iterations: &Iterations<'_>) -> Around {
        let Iterations { depth, number, table, reversed, has_constants, ref end } = *iterations;
        let rows = table.rows.len();
        let i = format!("i{depth}");
        let name = format!("{}_table{number}", self.name);
        let order = match reversed {
            false => format!("{i} = 0; {i} < {rows}; ++{i}"),
            true => format!("{i} = {rows} - 1; {i} >= 0; --{i}"),
        };
        let mut before = vec![format!("for (int {order}) {{")];
        if has_constants {
            let real = self.printer.real();
            before.push(format!("    const {real} *constants{depth} = {name}[{i}];"));
        }
        if table.places() > 0 {
            let index = index_type(table);
            before.push(format!("    const {index} *places{depth} = {name}_places[{i}];"));
        }
        let zero = literal(0.0, self.printer.float);
        before.extend(end.iter().map(|end| format!("    if ({end} >= {zero}) {{ break; }}")));
        Around { before, after: vec!["}".into()] }
    }

    /// Returns the lines around the stores of a routine's results.
    pub(super) fn around_stores(&self, call: &RoutineCall) -> Around {
        let RoutineCall { routine, constants, reads, results } = call;
        let real = self.printer.real();
        let mut before = vec!["{".into(), format!("    {real} results[{results}];")];
        if !reads.is_empty() {
            let count = reads.len();
            let reads = reads.join(", ");
            before.push(format!("    const {real} read[{count}] = {{ {reads} }};"));
        }
        let constants = constants.map(|depth| format!("constants{depth}"));
        let read = (!reads.is_empty()).then(|| "read".into());
        let arguments: Vec<String> =
            constants.into_iter().chain(read).chain(["results".into()]).collect();
        before.push(format!("    {}_routine{routine}({});", self.name, arguments.join(", ")));
        Around { before, after: vec!["}".into()] }
    }
}

/// Returns the type of the places of a table.
fn index_type(table: &Table) -> &'static str {
    // An `unsigned short` has at least 16 bits.
    if table.last_place() <= 65_535 { "unsigned short" } else { "unsigned long" }
}
