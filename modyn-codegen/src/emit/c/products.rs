//! Prints products of matrices as loops.

use std::fmt::Write as _;
use std::ops::Range;

use super::{Printer, literal};
use crate::program::{Operand, ProductBlock, Products};

/// Prints the statements that replace matrices among the stored results by products.
pub(super) fn print(
    text: &mut String,
    products: &Products,
    printer: &Printer,
    operand: &dyn Fn(&Operand) -> String,
) {
    let (n, a, real) = (products.size, products.factor, printer.real());
    let zero = literal(0.0, printer.float);
    let firsts = || products.products.iter().map(|product| product.first).enumerate();
    let of_each = |one: &dyn Fn(usize, usize) -> String| -> String {
        firsts().map(|(m, first)| one(m, first)).collect()
    };
    let arrays = of_each(&|m, _| format!("        {real} b{m}[{n}], sum{m}[{n}];\n"));
    let _ = writeln!(text, "    {{\n        int i, j, k;\n{arrays}");
    for block in &products.blocks {
        let rows = &block.rows;
        let is_row = format!("for (i = {}; i < {}; i++)", rows.start, rows.end);
        let taken = of_each(&|m, first| {
            format!(" b{m}[i] = out[{first} + {n} * j + i]; sum{m}[i] = {zero};")
        });
        let added = of_each(&|m, _| format!(" sum{m}[i] += out[{a} + {n} * k + i] * b{m}[k];"));
        let stored = of_each(&|m, first| format!(" out[{first} + {n} * j + i] = sum{m}[i];"));
        add_products(text, block, &is_row, [&taken, &added]);
        let _ = writeln!(text, "            {is_row} {{{stored} }}\n        }}");
    }
    *text += "    }\n";
    for (result, addend) in &products.addends {
        let _ = writeln!(text, "    out[{result}] += {};", operand(addend));
    }
    for first in products.transposed() {
        let _ = writeln!(
            text,
            "    {{\n        int i, j;\n        for (j = 0; j < {n}; j++) {{\n            for (i = 0; i <= j; i++) {{\n                \
             const {real} sum = out[{first} + {n} * j + i] + out[{first} + {n} * i + j];\n                \
             out[{first} + {n} * j + i] = sum;\n                out[{first} + {n} * i + j] = sum;\n            \
             }}\n        }}\n    }}"
        );
    }
}

/// Prints the start of the loop over the columns `j` of a block: what comes before the sums, for each row, then the loops over the terms `k`
/// that add to the sums.
pub(super) fn add_products(
    text: &mut String,
    block: &ProductBlock,
    is_row: &str,
    [before, added]: [&str; 2],
) {
    let Range { start, end } = block.columns;
    let _ = writeln!(
        text,
        "        for (j = {start}; j < {end}; j++) {{\n            {is_row} {{{before} }}"
    );
    for Range { start, end } in &block.terms {
        let _ = writeln!(
            text,
            "            for (k = {start}; k < {end}; k++) {{\n                {is_row} {{{added} }}\n            }}"
        );
    }
}
