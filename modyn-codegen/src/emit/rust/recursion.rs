//! Prints a recursion as loops over tables of bodies.
//!
//! Entries of arrays are found with `get`: an index from a table can be out of bounds as far as rustc knows, and a test
//! that panics would remain in the code.

use std::fmt::Write as _;

use super::FloatType;
use super::function::{function, literal};
use super::parameter::Parameter;
use super::shape::Shape;
use crate::program::{Operand, Read, Recursion, Run, Source, Step, Sweep, Write};

/// Returns the text of a private function `name` that computes `recursion`, generic over `T: Scalar`. The parameters are the
/// joint vectors, then the run-time parameters.
pub(super) fn looped(
    name: &str,
    parameters: &[Parameter],
    recursion: &Recursion,
    float: FloatType,
) -> String {
    Printer { name, parameters, recursion, float }.function()
}

struct Printer<'a> {
    name: &'a str,
    parameters: &'a [Parameter],
    recursion: &'a Recursion,
    /// The type of constants in tables.
    float: FloatType,
}

impl Printer<'_> {
    fn function(&self) -> String {
        let Recursion { sweeps, world, steps, runs, results, record, .. } = self.recursion;
        let mut text = String::new();
        for (kind, steps) in steps.iter().enumerate() {
            let constants = runs.iter().find(|run| run.kind == kind).map_or(0, Run::constants);
            for (sweep, step) in steps.iter().enumerate() {
                self.step(&mut text, &self.step_name(kind, sweep), step, constants);
            }
        }
        for (number, run) in runs.iter().enumerate() {
            self.table(&mut text, number, run);
        }
        let inputs: Vec<String> = self.parameters.iter().map(|p| p.typed("T")).collect();
        let _ = writeln!(
            text,
            "fn {}<T: __modyn::Scalar>({}) -> [T; {results}] {{\n    let k = T::from_f64;\n    \
             let mut records = [[k(0.0); {record}]; {}];\n    let mut results = [k(0.0); {results}];",
            self.name,
            inputs.join(", "),
            self.recursion.records(),
        );
        for (s, &sweep) in sweeps.iter().enumerate() {
            for (slot, number) in &world[s] {
                let _ = writeln!(text, "    records[0][{slot}] = {};", self.number(number));
            }
            for (number, run) in self.recursion.in_order(sweep) {
                let order = if sweep == Sweep::Outward { "" } else { ".rev()" };
                let _ = writeln!(
                    text,
                    "    for (table, places) in {}.iter(){order} {{",
                    self.table_name(number)
                );
                self.body(&mut text, &self.step_name(run.kind, s), &steps[run.kind][s]);
                text += "    }\n";
            }
        }
        text += "    results\n}\n\n";
        text
    }

    /// Prints the function of a step.
    fn step(&self, text: &mut String, name: &str, step: &Step, constants: usize) {
        if step.is_shared {
            *text += "#[inline(never)]\n";
        }
        let parameters = [
            Parameter::constants("table", Shape::vector(constants), self.float.name()),
            Parameter::new("read", Shape::vector(step.reads.len())),
        ];
        let result = Shape::vector(step.writes.len());
        *text += &function(name, &parameters, &result, &step.program, self.float);
    }

    /// Prints the constants and the places of the bodies of a run.
    fn table(&self, text: &mut String, number: usize, run: &Run) {
        let (name, float) = (self.table_name(number), self.float.name());
        let (constants, bodies) = (run.constants(), run.bodies.len());
        let _ = writeln!(text, "static {name}: [([{float}; {constants}], [u16; 4]); {bodies}] = [");
        for (constants, places) in run.table.iter().zip(&run.bodies) {
            let row: Vec<String> = constants.iter().map(|&x| literal(x, self.float)).collect();
            let _ = writeln!(text, "    ([{}], {:?}),", row.join(", "), places.all());
        }
        *text += "];\n\n";
    }

    /// Prints the statements for one body: its numbers are read, its step is called, and the results are stored.
    fn body(&self, text: &mut String, name: &str, step: &Step) {
        *text += "        let [own, parent, at_q, at_v] = places.map(usize::from);\n";
        let (mut patterns, mut values) = (Vec::new(), Vec::new());
        let mut find = |pattern: String, value: String| {
            patterns.push(format!("Some({pattern})"));
            values.push(value);
        };
        let any = |is: fn(&Read) -> bool| step.reads.iter().any(is);
        if any(|read| matches!(read, Read::Own(_))) {
            find("of_own".into(), "records.get(own)".into());
        }
        if any(|read| matches!(read, Read::Parent(_))) {
            find("of_parent".into(), "records.get(parent)".into());
        }
        for (vector, parameter) in self.parameters.iter().take(3).enumerate() {
            let entries = step.reads.iter().filter_map(|read| match read {
                Read::Vector(of, entry) if *of == vector => Some(entry + 1),
                _ => None,
            });
            if let Some(count) = entries.max() {
                let names: Vec<String> = (0..count).map(|i| parameter.entry(i)).collect();
                let start = if vector == 0 { "at_q" } else { "at_v" };
                find(format!("&[{}]", names.join(", ")), entries_of(parameter.name, start, ""));
            }
        }
        if !values.is_empty() {
            let (patterns, values) = (patterns.join(", "), values.join(", "));
            let _ = writeln!(text, "        let ({patterns},) = ({values},) else {{ break }};");
        }
        let read = |read: &Read| match *read {
            Read::Vector(vector, entry) => self.parameters[vector].entry(entry),
            Read::Parameter(i) => self.parameter(i),
            Read::Own(slot) => format!("of_own[{slot}]"),
            Read::Parent(slot) => format!("of_parent[{slot}]"),
        };
        let read: Vec<String> = step.reads.iter().map(read).collect();
        let _ = writeln!(text, "        let x = {name}(table, &[{}]);", read.join(", "));
        let mut stores: [Vec<String>; 3] = Default::default();
        let mut count = 0;
        for (i, write) in step.writes.iter().enumerate() {
            match write {
                Write::Own(slot) => stores[0].push(format!("to[{slot}] = x[{i}];")),
                Write::AddToParent(slot) => {
                    stores[1].push(format!("to[{slot}] = to[{slot}] + x[{i}];"));
                }
                Write::Result(entry) => {
                    stores[2].push(format!("to[{entry}] = x[{i}];"));
                    count = count.max(entry + 1);
                }
            }
        }
        let places = [
            "records.get_mut(own)".into(),
            "records.get_mut(parent)".into(),
            entries_of("results", "at_v", &format!("_mut::<{count}>")),
        ];
        for (place, stores) in places.iter().zip(&stores).filter(|(_, stores)| !stores.is_empty()) {
            let _ = writeln!(
                text,
                "        if let Some(to) = {place} {{\n            {}\n        }}",
                stores.join("\n            ")
            );
        }
    }

    /// Returns the text of a number that the world sends.
    fn number(&self, number: &Operand) -> String {
        let sign = if number.negated { "-" } else { "" };
        match number.source {
            Source::Constant(value) => format!("{sign}k({})", literal(value, FloatType::F64)),
            Source::Argument(i) => format!("{sign}{}", self.parameter(i)),
            Source::Result(_) => unreachable!("the world computes nothing"),
        }
    }

    /// Returns the text of a run-time parameter.
    fn parameter(&self, i: usize) -> String {
        format!("{}[{i}]", self.parameters[3].name)
    }

    fn step_name(&self, kind: usize, sweep: usize) -> String {
        format!("{}_kind{kind}_sweep{sweep}", self.name)
    }

    fn table_name(&self, run: usize) -> String {
        format!("{}_TABLE_{run}", self.name.to_uppercase())
    }
}

/// Returns the text that finds entries of an array from an index on; `kind` ends the name of the function for that.
fn entries_of(array: &str, start: &str, kind: &str) -> String {
    let get = if kind.is_empty() { "get" } else { "get_mut" };
    format!("{array}.{get}({start}..).and_then(<[T]>::first_chunk{kind})")
}
