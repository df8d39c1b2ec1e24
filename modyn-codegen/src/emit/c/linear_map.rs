//! Prints a linear map of columns as loops.

use std::fmt::Write as _;

use super::{Printer, literal};
use crate::program::{LinearMap, Operand};

/// Prints the statements that store the products of a map.
pub(super) fn print(
    text: &mut String,
    map: &LinearMap,
    printer: &Printer,
    operand: &dyn Fn(&Operand) -> String,
) {
    let (rows, terms, real) = (map.rows, map.terms(), printer.real());
    let zero = literal(0.0, printer.float);
    *text += "    {\n";
    let mut array = |name: &str, entries: &[Operand]| {
        let numbers: Vec<String> = entries.iter().map(operand).collect();
        let (count, numbers) = (entries.len(), numbers.join(", "));
        let _ = writeln!(text, "        const {real} {name}[{count}] = {{ {numbers} }};");
    };
    array("map", &map.map);
    for (m, matrix) in map.matrices.iter().enumerate() {
        array(&format!("columns{m}"), matrix);
    }
    let of_each =
        |one: &dyn Fn(usize) -> String| -> String { (0..map.matrices.len()).map(one).collect() };
    let sums = of_each(&|m| format!("        {real} sum{m}[{rows}];\n"));
    let is_row = format!("for (i = 0; i < {rows}; i++)");
    let cleared = of_each(&|m| format!(" sum{m}[i] = {zero};"));
    let added =
        of_each(&|m| format!(" sum{m}[i] += map[{rows} * k + i] * columns{m}[{terms} * j + k];"));
    let _ = writeln!(text, "{sums}        int i, j, k;");
    for block in &map.blocks {
        let _ = writeln!(
            text,
            "        for (j = {}; j < {}; j++) {{\n            {is_row} {{{cleared} }}",
            block.columns.start, block.columns.end
        );
        for terms in &block.terms {
            let _ = writeln!(
                text,
                "            for (k = {}; k < {}; k++) {{\n                {is_row} {{{added} }}\n            }}",
                terms.start, terms.end
            );
        }
        for (m, targets) in map.targets.iter().enumerate() {
            for (row, (first, stride)) in targets.iter().enumerate() {
                let _ = writeln!(text, "            out[{first} + {stride} * j] = sum{m}[{row}];");
            }
        }
        *text += "        }\n";
    }
    *text += "    }\n";
}
