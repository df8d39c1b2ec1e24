//! Prints products of matrices as loops.

use std::fmt::Write as _;
use std::ops::Range;

use super::{Array, Printer, literal};
use crate::graph::dense::ProductTarget;
use crate::program::{Operand, ProductMatrix, Products};

/// Returns the arrays of the matrices.
pub(super) fn arrays(products: &Products) -> impl Iterator<Item = Array> {
    let arrays = products.arrays().into_iter();
    arrays.map(|ProductMatrix { name, columns, rows }| Array { name, len: columns * rows })
}

/// Prints the statements that add products to the stored results.
pub(super) fn print(
    text: &mut String,
    products: &Products,
    results: &[Operand],
    printer: &Printer,
    operand: &dyn Fn(&Operand) -> String,
) {
    let n = products.rows;
    let terms = products.terms;
    let real = printer.real();
    let zero = literal(0.0, printer.float);
    let first = |m: usize| products.targets[m][0].first;
    let of_each = |one: &dyn Fn(usize) -> String| -> String {
        (0..products.targets.len()).map(one).collect()
    };
    let sums = of_each(&|m| format!("        {real} sum{m}[{n}];\n"));
    // Columns of matrices in place are copied before they are replaced.
    let (columns, started, added) = match products.in_place {
        Some(a) => (
            of_each(&|m| format!("        {real} b{m}[{n}];\n")),
            of_each(&|m| {
                format!(" b{m}[i] = out[{} + {n} * j + i]; sum{m}[i] = {zero};", first(m))
            }),
            of_each(&|m| format!(" sum{m}[i] += out[{a} + {n} * k + i] * b{m}[k];")),
        ),
        None => (
            String::new(),
            of_each(&|m| format!(" sum{m}[i] = {zero};")),
            of_each(&|m| format!(" sum{m}[i] += a[{n} * k + i] * b{m}[{terms} * j + k];")),
        ),
    };
    let _ = writeln!(text, "    {{\n{columns}{sums}        int i, j, k;");
    let over = |rows: &Range<usize>| format!("for (i = {}; i < {}; i++)", rows.start, rows.end);
    for block in &products.blocks {
        let Range { start, end } = &block.columns;
        let is_row = over(&block.rows);
        let _ = writeln!(
            text,
            "        for (j = {start}; j < {end}; j++) {{\n            {is_row} {{{started} }}"
        );
        for Range { start, end } in &block.terms {
            let _ = writeln!(
                text,
                "            for (k = {start}; k < {end}; k++) {{\n                {is_row} \
                 {{{added} }}\n            }}"
            );
        }
        for (m, targets) in products.targets.iter().enumerate() {
            let (sign, targets) = match products.in_place {
                Some(_) => ("", &targets[..1]),
                None => ("+", &targets[..]),
            };
            for target in targets {
                let ProductTarget { first, by_row, by_column, rows } = target;
                let row =
                    if rows.start == 0 { "i".into() } else { format!("(i - {})", rows.start) };
                let rows = target.rows_of(block);
                if !rows.is_empty() {
                    let _ = writeln!(
                        text,
                        "            {} {{ out[{first} + {by_column} * j + {by_row} * {row}] {sign}= sum{m}[i]; }}",
                        over(&rows)
                    );
                }
            }
        }
        *text += "        }\n";
    }
    *text += "    }\n";
    let add = |text: &mut String, numbers: &[(usize, Operand)]| {
        for (result, number) in numbers {
            let _ = writeln!(text, "    out[{result}] += {};", operand(number));
        }
    };
    let [before, after] = products.addends(results);
    add(text, &before);
    for first in products.transposed() {
        let _ = writeln!(
            text,
            "    {{\n        int i, j;\n        for (j = 0; j < {n}; j++) {{\n            for (i = \
             0; i <= j; i++) {{\n                \
             const {real} sum = out[{first} + {n} * j + i] + out[{first} + {n} * i + j];\n                \
             out[{first} + {n} * j + i] = sum;\n                out[{first} + {n} * i + j] = sum;\n            \
             }}\n        }}\n    }}"
        );
    }
    add(text, &after);
}
