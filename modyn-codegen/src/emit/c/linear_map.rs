//! Prints a linear map of columns as loops.

use std::fmt::Write as _;

use super::products::add_products;
use super::{Array, Printer, literal};
use crate::program::{LinearMap, MapMatrix};

/// Returns the arrays of a map's matrices.
pub(super) fn arrays(map: &LinearMap) -> impl Iterator<Item = Array> {
    let matrices = map.matrices().into_iter();
    matrices.map(|MapMatrix { name, columns, rows }| Array { name, len: columns * rows })
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
        add_products(text, block, &is_row, [&cleared, &added]);
        for (m, targets) in map.targets.iter().enumerate() {
            for (row, (first, stride)) in targets.iter().enumerate() {
                let _ = writeln!(text, "            out[{first} + {stride} * j] = sum{m}[{row}];");
            }
        }
        *text += "        }\n";
    }
    *text += "    }\n";
}
