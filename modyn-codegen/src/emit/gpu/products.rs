//! Prints products of matrices as loops of a thread.

use std::fmt::Write as _;
use std::ops::Range;

use super::{Dialect, Kernel, ThreadArray};
use crate::program::{ProductMatrix, Products};
use crate::trace::Target;

/// Returns the arrays of the matrices, into which chunks store entries.
pub(super) fn arrays(products: &Products) -> Vec<ThreadArray> {
    let array = |ProductMatrix { name, columns, rows }: ProductMatrix| ThreadArray {
        name,
        len: columns * rows,
        is_written: true,
    };
    products.arrays().into_iter().map(array).collect()
}

/// Prints the statements that add products of matrices to the stored results, or store them in their place.
pub(super) fn print(
    text: &mut String,
    dialect: &dyn Dialect,
    kernel: &Kernel<'_>,
    products: &Products,
) {
    let (rows, terms) = (products.rows, products.terms);
    let matrices = 0..products.targets.len();
    let sum = |m: usize| format!("product{m}");
    for m in matrices.clone() {
        let array = ThreadArray { name: sum(m), len: rows, is_written: true };
        let _ = writeln!(text, "    {}", dialect.zeros(&array));
    }
    let from = |start: usize, counter: &str| match start {
        0 => counter.to_string(),
        _ => format!("({start}u + {counter})"),
    };
    let over = |counter: &str, Range { start, end }: &Range<usize>| {
        dialect.counting(counter, &format!("{}u", end.saturating_sub(*start)))
    };
    for block in &products.blocks {
        let (i, j) = (from(block.rows.start, "i"), from(block.columns.start, "j"));
        let of_rows = over("i", &block.rows);
        let _ = writeln!(text, "    {}", over("j", &block.columns));
        let zero = dialect.literal(0.0);
        let cleared = matrices.clone().map(|m| format!(" {}[{i}] = {zero};", sum(m)));
        let _ = writeln!(text, "        {of_rows}{} }}", cleared.collect::<String>());
        for range in &block.terms {
            let k = from(range.start, "k");
            let a = format!("a[{rows}u * {k} + {i}]");
            let added = matrices.clone().map(|m| {
                let (b, own) = (format!("b{m}[{terms}u * {j} + {k}]"), format!("{}[{i}]", sum(m)));
                format!(" {own} = {};", dialect.multiply_add(&a, &b, &own))
            });
            let _ = writeln!(
                text,
                "        {}\n            {of_rows}{} }}\n        }}",
                over("k", range),
                added.collect::<String>()
            );
        }
        for (m, targets) in products.targets.iter().enumerate() {
            for target in targets {
                let (own, Target { first, by_row, by_column, .. }) =
                    (target.rows_of(block), target);
                if own.is_empty() {
                    continue;
                }
                let first = first + by_row * (own.start - target.rows.start);
                let index = format!("{first}u + {by_column}u * {j} + {by_row}u * i");
                let place = dialect.result(&kernel.description, &index);
                let sign = match products.replaces(block, target, &kernel.program.results) {
                    true => "=",
                    false => "+=",
                };
                let number = format!("{}[{}]", sum(m), from(own.start, "i"));
                let _ = writeln!(text, "        {} {place} {sign} {number}; }}", over("i", &own));
            }
        }
        *text += "    }\n";
    }
}
