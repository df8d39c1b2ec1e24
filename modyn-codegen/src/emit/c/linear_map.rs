//! Prints a linear map of columns as loops.

use std::fmt::Write as _;

use super::{Array, Printer, literal};
use crate::program::LinearMap;

/// Returns the arrays of a map's matrices.
pub(super) fn arrays(map: &LinearMap) -> impl Iterator<Item = Array> {
    let array = |(name, [columns, rows]): (String, [usize; 2])| Array { name, len: columns * rows };
    map.matrices().into_iter().map(array)
}

/// Returns the place of an entry of a map.
pub(super) fn place(map: &LinearMap, entry: usize) -> String {
    let (name, index) = map.place(entry);
    format!("{name}[{index}]")
}

/// Prints the statements that store the products of a map whose entries are stored.
pub(super) fn print(text: &mut String, map: &LinearMap, printer: &Printer) {
    let (rows, terms, real) = (map.rows, map.terms, printer.real());
    let zero = literal(0.0, printer.float);
    *text += "    {\n";
    let of_each =
        |one: &dyn Fn(usize) -> String| -> String { (0..map.targets.len()).map(one).collect() };
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
