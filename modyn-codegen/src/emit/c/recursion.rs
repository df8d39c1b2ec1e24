//! Prints a recursion as loops over tables of bodies.

use std::fmt::Write as _;

use super::{Array, Printer, literal};
use crate::program::{Operand, Read, Recursion, Run, Source, Step, Sweep, Write};

impl Printer {
    /// Prints the function of a recursion; `given` are the joint vectors, then the run-time parameters.
    pub(super) fn recursion(&mut self, name: &str, given: &[Array], recursion: &Recursion) {
        let Recursion { sweeps, world, steps, runs, results, record, .. } = recursion;
        let real = self.real();
        let step_name = |kind: usize, sweep: usize| format!("{name}_kind{kind}_sweep{sweep}");
        for (kind, steps) in steps.iter().enumerate() {
            let constants = runs.iter().find(|run| run.kind == kind).map_or(0, Run::constants);
            for (sweep, Step { program, reads, writes, .. }) in steps.iter().enumerate() {
                let array = |name: &str, len: usize| Array { name: name.into(), len };
                let arrays = [array("table", constants), array("read", reads.len())];
                self.function("static ", &step_name(kind, sweep), &arrays, writes.len(), program);
            }
        }
        let mut text = String::new();
        for (number, run) in runs.iter().enumerate() {
            self.table(&format!("{name}_table{number}"), run);
        }
        let (parameters, out) = (self.parameters(given), self.output(*results));
        let _ = writeln!(
            text,
            "void {name}({parameters}{out})\n{{\n    {real} records[{}][{record}];\n    int i;\n    \
             for (i = 0; i < {record}; ++i)\n        records[0][i] = {};",
            recursion.records(),
            literal(0.0, self.float),
        );
        for (s, &sweep) in sweeps.iter().enumerate() {
            for (slot, number) in &world[s] {
                let number = self.sent_by_world(number, given);
                let _ = writeln!(text, "    records[0][{slot}] = {number};");
            }
            for (number, run) in recursion.in_order(sweep) {
                let (table, bodies) = (format!("{name}_table{number}"), run.bodies.len());
                let order = match sweep {
                    Sweep::Outward => format!("i = 0; i < {bodies}; ++i"),
                    Sweep::Inward => format!("i = {bodies} - 1; i >= 0; --i"),
                };
                let _ = writeln!(
                    text,
                    "    for ({order}) {{\n        const unsigned short *at = {table}_places[i];"
                );
                let step = &steps[run.kind][s];
                self.body(&mut text, (&step_name(run.kind, s), &table), given, step);
                text += "    }\n";
            }
        }
        let _ = writeln!(self.source, "{text}}}\n");
    }

    /// Prints the constants and the places of the bodies of a run.
    fn table(&mut self, name: &str, run: &Run) {
        let (bodies, constants) = (run.bodies.len(), run.constants().max(1));
        let (real, float) = (self.real(), self.float);
        let row = |row: &Vec<f64>| {
            let row: Vec<String> = row.iter().map(|&x| literal(x, float)).collect();
            format!("    {{ {} }}", if row.is_empty() { "0".into() } else { row.join(", ") })
        };
        let rows: Vec<String> = run.table.iter().map(row).collect();
        let places = run.bodies.iter().map(|body| {
            let [own, parent, q, v] = body.all();
            format!("    {{ {own}, {parent}, {q}, {v} }}")
        });
        let places: Vec<String> = places.collect();
        let _ = writeln!(
            self.source,
            "static const {real} {name}[{bodies}][{constants}] = {{\n{}\n}};\n\n\
             static const unsigned short {name}_places[{bodies}][4] = {{\n{}\n}};\n",
            rows.join(",\n"),
            places.join(",\n"),
        );
    }

    /// Prints the statements for one body: its numbers are read, its step is called, and the results are stored.
    fn body(&self, text: &mut String, (name, table): (&str, &str), given: &[Array], step: &Step) {
        let real = self.real();
        let read = |read: &Read| match *read {
            Read::Vector(0, entry) => format!("{}[at[2] + {entry}]", given[0].name),
            Read::Vector(vector, entry) => format!("{}[at[3] + {entry}]", given[vector].name),
            Read::Parameter(i) => format!("{}[{i}]", given[3].name),
            Read::Own(slot) => format!("records[at[0]][{slot}]"),
            Read::Parent(slot) => format!("records[at[1]][{slot}]"),
        };
        let reads: Vec<String> = step.reads.iter().map(read).collect();
        let (reads, writes) = (reads.join(", "), step.writes.len().max(1));
        let (count, zero) = (step.reads.len().max(1), literal(0.0, self.float));
        let reads = if reads.is_empty() { zero } else { reads };
        let _ = writeln!(
            text,
            "        const {real} read[{count}] = {{ {reads} }};\n        {real} x[{writes}];\n        \
             {name}({table}[i], read, x);"
        );
        for (i, write) in step.writes.iter().enumerate() {
            let _ = match write {
                Write::Own(slot) => writeln!(text, "        records[at[0]][{slot}] = x[{i}];"),
                Write::AddToParent(slot) => {
                    writeln!(text, "        records[at[1]][{slot}] += x[{i}];")
                }
                Write::Result(entry) => writeln!(text, "        out[at[3] + {entry}] = x[{i}];"),
            };
        }
    }

    /// Returns the text of a number that the world sends.
    fn sent_by_world(&self, number: &Operand, given: &[Array]) -> String {
        let text = match number.source {
            Source::Constant(value) => literal(value, self.float),
            Source::Argument(i) => format!("{}[{i}]", given[3].name),
            Source::Result(_) => unreachable!("the world computes nothing"),
        };
        if number.negated { format!("-{text}") } else { text }
    }
}
