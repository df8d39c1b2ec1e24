//! The products of matrices after the statements of a function, in loops.

use std::fmt::Write as _;

use super::Printer;
use crate::emit::rust::shape::Shape;
use crate::program::{Execution, ProductBlock, Products, ROW_LANES};

impl Printer<'_> {
    /// Prints the end of a function, which returns the result with products in place of matrices; `value` is the result before. Entries of
    /// `result` are read and assigned to, and never borrowed: rustc would copy a borrowed result to its place.
    pub(super) fn products(&self, text: &mut String, value: &str, products: &Products) {
        let a = format!("result{}", self.result.matrix(products.factor));
        let matrices = products.matrices.iter().map(|&first| self.result.matrix(first));
        let matrices: Vec<String> = matrices.map(|matrix| format!("result{matrix}")).collect();
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
            let (place, addend) = (self.result.place(*result), self.operand(addend));
            let sum = match self.program.execution {
                Execution::Simd => format!("V::number(V::one(result{place}) + {addend})"),
                _ => format!("result{place} + {addend}"),
            };
            let _ = writeln!(text, "    result{place} = {sum};");
        }
        *text += "    result\n}\n\n";
    }
}

/// Prints the sums of a block's rows, one row after another.
fn scalars(text: &mut String, block: &ProductBlock, (a, columns): (&str, &[String])) {
    let (rows, count) = (&block.rows, columns.len());
    let _ = writeln!(
        text,
        "        let mut row = {};\n        while row < {} {{\n            let mut sums = [T::zero(); {count}];",
        rows.start, rows.end
    );
    for terms in &block.terms {
        let _ = writeln!(
            text,
            "            let mut k = {};\n            while k < {} {{",
            terms.start, terms.end
        );
        for m in 0..count {
            let _ = writeln!(
                text,
                "                sums[{m}] = {a}[k][row].mul_add(b[{m}][k], sums[{m}]);"
            );
        }
        *text += "                k += 1;\n            }\n";
    }
    for (m, column) in columns.iter().enumerate() {
        let _ = writeln!(text, "            {column}[row] = sums[{m}];");
    }
    *text += "            row += 1;\n        }\n";
}

/// Prints the sums of vectors of rows: the first row, and the number of vectors.
fn vectors(
    text: &mut String,
    block: &ProductBlock,
    (first, vectors): (usize, usize),
    (a, columns): (&str, &[String]),
) {
    let count = columns.len();
    let lanes =
        |of: &dyn Fn(usize) -> String| (0..ROW_LANES).map(of).collect::<Vec<_>>().join(", ");
    let _ = writeln!(text, "        let mut sums = [[V::Four::zero(); {vectors}]; {count}];");
    let of_rows = format!(
        "            let mut r = 0;\n            while r < {vectors} {{\n                let row = {first} + {ROW_LANES} * r;\n"
    );
    for terms in &block.terms {
        let factors = (0..count).map(|m| format!("V::Four::broadcast(V::one(b[{m}][k]))"));
        let factors: Vec<String> = factors.collect();
        let row = lanes(&|lane| format!("V::one({a}[k][row + {lane}])"));
        let _ = writeln!(
            text,
            "        let mut k = {};\n        while k < {} {{\n            let factors = [{}];\n{of_rows}                \
             let a = V::Four::pack([{row}]);",
            terms.start,
            terms.end,
            factors.join(", "),
        );
        for m in 0..count {
            let _ = writeln!(
                text,
                "                sums[{m}][r] = a.mul_add(factors[{m}], sums[{m}][r]);"
            );
        }
        *text += "                r += 1;\n            }\n            k += 1;\n        }\n";
    }
    *text += &of_rows;
    for (m, column) in columns.iter().enumerate() {
        let names = lanes(&|lane| format!("x{lane}"));
        let places = lanes(&|lane| format!("{column}[row + {lane}]"));
        let numbers = lanes(&|lane| format!("V::number(x{lane})"));
        let _ = writeln!(
            text,
            "                let [{names}] = sums[{m}][r].unpack();\n                [{places}] = [{numbers}];"
        );
    }
    *text += "                r += 1;\n            }\n";
}

impl Shape {
    /// Returns the path from a value to the matrix whose first scalar is `first`.
    fn matrix(&self, first: usize) -> String {
        self.place(first).trim_end_matches("[0]").into()
    }

    /// Returns the path from a value to its scalar `i`.
    fn place(&self, i: usize) -> String {
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
                    format!(".{name}{}", field.place(i - start))
                })
            }
        }
    }
}
