//! Prints products of matrices as loops.

use std::fmt::Write as _;

use super::{Printer, literal};
use crate::program::{Operand, Products};

/// Prints the statements that replace matrices among the stored results by products.
pub(super) fn print(
    text: &mut String,
    products: &Products,
    printer: &Printer,
    operand: &dyn Fn(&Operand) -> String,
) {
    let (n, a, real) = (products.size, products.factor, printer.real());
    let zero = literal(0.0, printer.float);
    let matrices = || products.matrices.iter().enumerate();
    let of_each = |one: &dyn Fn(usize, usize) -> String| -> String {
        matrices().map(|(m, &first)| one(m, first)).collect()
    };
    let arrays = of_each(&|m, _| format!("        {real} b{m}[{n}], sum{m}[{n}];\n"));
    let _ = writeln!(text, "    {{\n        int i, j, k;\n{arrays}");
    for block in &products.blocks {
        let (columns, rows) = (&block.columns, &block.rows);
        let is_row = format!("for (i = {}; i < {}; i++)", rows.start, rows.end);
        let taken = of_each(&|m, first| {
            format!(" b{m}[i] = out[{first} + {n} * j + i]; sum{m}[i] = {zero};")
        });
        let added = of_each(&|m, _| format!(" sum{m}[i] += out[{a} + {n} * k + i] * b{m}[k];"));
        let stored = of_each(&|m, first| format!(" out[{first} + {n} * j + i] = sum{m}[i];"));
        let _ = writeln!(
            text,
            "        for (j = {}; j < {}; j++) {{\n            {is_row} {{{taken} }}",
            columns.start, columns.end
        );
        for terms in &block.terms {
            let _ = writeln!(
                text,
                "            for (k = {}; k < {}; k++) {{\n                {is_row} {{{added} }}\n            }}",
                terms.start, terms.end
            );
        }
        let _ = writeln!(text, "            {is_row} {{{stored} }}\n        }}");
    }
    *text += "    }\n";
    for (result, addend) in &products.addends {
        let _ = writeln!(text, "    out[{result}] += {};", operand(addend));
    }
}
