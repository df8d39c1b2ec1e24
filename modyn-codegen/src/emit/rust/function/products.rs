//! The products of matrices after the statements of a function, in loops.

use std::fmt::Write as _;
use std::ops::Range;

use super::Printer;
use crate::emit::rust::shape::Shape;
use crate::program::{Execution, ProductBlock, Products, ROW_LANES};

impl Printer<'_> {
    /// Prints the end of a function, which returns the result with products in place of matrices; `value` is the result before. Entries of
    /// `result` are read and assigned to, and never borrowed: rustc would copy a borrowed result to its place.
    pub(super) fn products(&self, text: &mut String, value: &str, products: &Products) {
        let matrix = |first| format!("result{}", self.result.matrix(first));
        let matrices: Vec<String> =
            products.products.iter().map(|product| matrix(product.first)).collect();
        let a = matrix(products.factor);
        if self.program.execution == Execution::Simd {
            *text += "    use __modyn::{Scalar as _, batch::Pack as _};\n";
        }
        let _ = writeln!(text, "    let mut result = {value};");
        for block in &products.blocks {
            let columns = &block.columns;
            let factors: Vec<String> = matrices.iter().map(|b| format!("{b}[column]")).collect();
            let _ = writeln!(
                text,
                "    let mut column = {};\n    while column < {} {{\n        let b = [{}];",
                columns.start,
                columns.end,
                factors.join(", ")
            );
            match self.program.execution {
                Execution::Simd => {
                    for group in block.vectors(products.size) {
                        vectors(text, block, group, (&a, &factors));
                    }
                }
                _ => scalars(text, block, (&a, &factors)),
            }
            *text += "        column += 1;\n    }\n";
        }
        for (result, addend) in &products.addends {
            let place = format!("result{}", self.result.place(*result));
            let sum = match self.program.execution {
                Execution::Simd => {
                    format!("V::number(V::one({place}) + {})", self.operand(addend))
                }
                _ => format!("{place} + {}", self.operand(addend)),
            };
            let _ = writeln!(text, "    {place} = {sum};");
        }
        for matrix in products.transposed().map(matrix) {
            let sum = match self.program.execution {
                Execution::Simd => {
                    format!(
                        "V::number(V::one({matrix}[column][row]) + V::one({matrix}[row][column]))"
                    )
                }
                _ => format!("{matrix}[column][row] + {matrix}[row][column]"),
            };
            let _ = writeln!(
                text,
                "    let mut column = 0;\n    while column < {} {{\n        let mut row = 0;\n        while row <= column {{\n            \
                 let sum = {sum};\n            {matrix}[column][row] = sum;\n            {matrix}[row][column] = sum;\n            \
                 row += 1;\n        }}\n        column += 1;\n    }}",
                products.size
            );
        }
        *text += "    result\n}\n\n";
    }
}

/// Prints the sums of a block's rows, one row after another.
pub(super) fn scalars(text: &mut String, block: &ProductBlock, (a, columns): (&str, &[String])) {
    let Range { start, end } = block.rows;
    let _ = writeln!(
        text,
        "        let mut row = {start};\n        while row < {end} {{\n            let mut sums = [T::zero(); {}];",
        columns.len()
    );
    for Range { start, end } in &block.terms {
        let _ = writeln!(
            text,
            "            let mut term = {start};\n            while term < {end} {{"
        );
        for m in 0..columns.len() {
            let _ = writeln!(
                text,
                "                sums[{m}] = {a}[term][row].mul_add(b[{m}][term], sums[{m}]);"
            );
        }
        *text += "                term += 1;\n            }\n";
    }
    for (m, column) in columns.iter().enumerate() {
        let _ = writeln!(text, "            {column}[row] = sums[{m}];");
    }
    *text += "            row += 1;\n        }\n";
}

/// Prints the sums of vectors of rows: the first row, and the number of vectors.
pub(super) fn vectors(
    text: &mut String,
    block: &ProductBlock,
    (first, vectors): (usize, usize),
    (a, columns): (&str, &[String]),
) {
    let list =
        |of: &dyn Fn(usize) -> String, count| (0..count).map(of).collect::<Vec<_>>().join(", ");
    let count = columns.len();
    let factors = list(&|m| format!("V::Four::broadcast(V::one(b[{m}][term]))"), count);
    let rows = list(&|lane| format!("V::one({a}[term][row + {lane}])"), ROW_LANES);
    let _ = writeln!(text, "        let mut sums = [[V::Four::zero(); {vectors}]; {count}];");
    for Range { start, end } in &block.terms {
        let _ = writeln!(
            text,
            "        let mut term = {start};\n        while term < {end} {{\n            let factors = [{factors}];\n            \
             let (mut row, mut r) = ({first}, 0);\n            while r < {vectors} {{\n                \
             let a = V::Four::pack([{rows}]);"
        );
        for m in 0..count {
            let _ = writeln!(
                text,
                "                sums[{m}][r] = a.mul_add(factors[{m}], sums[{m}][r]);"
            );
        }
        let _ = writeln!(
            text,
            "                (row, r) = (row + {ROW_LANES}, r + 1);\n            }}\n            term += 1;\n        }}"
        );
    }
    let _ = writeln!(
        text,
        "        let (mut row, mut r) = ({first}, 0);\n        while r < {vectors} {{"
    );
    for (m, column) in columns.iter().enumerate() {
        let names = list(&|lane| format!("x{lane}"), ROW_LANES);
        let places = list(&|lane| format!("{column}[row + {lane}]"), ROW_LANES);
        let numbers = list(&|lane| format!("V::number(x{lane})"), ROW_LANES);
        let _ = writeln!(
            text,
            "            let [{names}] = sums[{m}][r].unpack();\n            [{places}] = [{numbers}];"
        );
    }
    let _ = writeln!(text, "            (row, r) = (row + {ROW_LANES}, r + 1);\n        }}");
}

impl Shape {
    /// Returns the path from a value to the matrix whose first scalar is `first`.
    fn matrix(&self, first: usize) -> String {
        self.place(first).trim_end_matches("[0]").into()
    }

    /// Returns the path from a value to its scalar `i`.
    pub(super) fn place(&self, i: usize) -> String {
        match self {
            Self::Scalar => String::new(),
            Self::Array(of, _) => format!("[{}]{}", i / of.len(), of.place(i % of.len())),
            Self::Struct { fields, .. } => {
                let mut first = 0;
                let starts = fields.iter().map(|(name, field)| {
                    first += field.len();
                    (*name, field, first - field.len())
                });
                let within = starts.take_while(|(.., start)| *start <= i).last();
                within.map_or_else(String::new, |(name, field, start)| {
                    // The field of a tuple has no name.
                    let name = if name.is_empty() { "0" } else { name };
                    format!(".{name}{}", field.place(i - start))
                })
            }
        }
    }
}
