//! The products of matrices after the statements of a function, in loops.

use std::cmp::Ordering;
use std::fmt::Write as _;
use std::ops::Range;

use super::Printer;
use crate::emit::rust::shape::Shape;
use crate::graph::dense::ProductTarget;
use crate::program::{Execution, Operand, ProductBlock, Products, ROW_LANES};

impl Printer<'_> {
    /// Prints the end of a function: the products, and its result, which is `value` before. Entries
    /// of `result` are read and assigned to, and never borrowed: rustc would copy a borrowed result
    /// to its place.
    pub(super) fn products(&self, text: &mut String, value: &str, products: &Products) {
        let execution = self.program.execution;
        let is_one = !execution.has_many_states();
        if execution == Execution::Simd {
            *text += "    use __modyn::{Scalar as _, batch::Pack as _};\n";
        }
        if is_one {
            let _ = writeln!(text, "    let mut result = {value};");
        }
        let matrix = |first| format!("result{}", self.result.matrix(first));
        let all = products.targets.iter().enumerate();
        // A, the columns of each B, and the columns of the products.
        let (a, columns, sums): (String, Vec<String>, Vec<String>) = match products.in_place {
            Some(a) => {
                let column = |(_, targets): (usize, &Vec<ProductTarget>)| {
                    format!("{}[column]", matrix(targets[0].first))
                };
                let columns: Vec<String> = all.map(column).collect();
                (matrix(a), columns.clone(), columns)
            }
            None => {
                let columns = all.clone().map(|(m, _)| format!("&b{m}[column]")).collect();
                let sums: Vec<String> = all.map(|(m, _)| format!("product{m}")).collect();
                for sum in &sums {
                    let zero = self.zero();
                    let rows = products.rows;
                    let _ = writeln!(text, "    let mut {sum} = [{zero}; {rows}];");
                }
                ("a".into(), columns, sums)
            }
        };
        for block in &products.blocks {
            let _ = writeln!(
                text,
                "    let mut column = {};\n    while column < {} {{\n        let b = [{}];",
                block.columns.start,
                block.columns.end,
                columns.join(", ")
            );
            if execution == Execution::Simd {
                for (first, width) in block.vectors(products.rows) {
                    vectors(text, block, first, width, &a, &sums);
                }
            } else {
                rows(text, block, &a, &sums);
            }
            if products.in_place.is_none() {
                for (sum, targets) in sums.iter().zip(&products.targets) {
                    for target in targets {
                        self.add_product(text, products, block, sum, target);
                    }
                }
            }
            *text += "        column += 1;\n    }\n";
        }
        let [first, last] = products.addends(&self.program.results);
        self.add_numbers(text, &first);
        for matrix in products.transposed().map(matrix) {
            let entries = [format!("{matrix}[column][row]"), format!("{matrix}[row][column]")];
            let sum = self.sum(&entries[0], &self.one(&entries[1]));
            let _ = writeln!(
                text,
                "    let mut column = 0;\n    while column < {} {{\n        let mut row = \
                 0;\n        while row <= column {{\n            \
                 let sum = {sum};\n            {} = sum;\n            {} = sum;\n            row \
                 += 1;\n        }}\n        \
                 column += 1;\n    }}",
                products.rows, entries[0], entries[1]
            );
        }
        self.add_numbers(text, &last);
        *text += if is_one { "    result\n}\n\n" } else { "}\n\n" };
    }

    /// Prints the sums of results with numbers.
    fn add_numbers(&self, text: &mut String, numbers: &[(usize, Operand)]) {
        for (result, number) in numbers {
            let place = format!("result{}", self.result.place(*result));
            let _ = writeln!(text, "    {place} = {};", self.sum(&place, &self.operand(number)));
        }
    }

    /// Prints the sums of a product's column with results, or stores it in their place.
    fn add_product(
        &self,
        text: &mut String,
        products: &Products,
        block: &ProductBlock,
        product: &str,
        target: &ProductTarget,
    ) {
        let number = format!("{product}[row]");
        let replaces = products.replaces(block, target, &self.program.results);
        let mut print = |Range { start, end }: Range<usize>, statement: String| {
            let _ = writeln!(
                text,
                "        let mut row = {start};\n        while row < {end} {{\n            \
                 {statement};\n            row += 1;\n        }}"
            );
        };
        let rows = target.rows_of(block);
        if self.program.execution.has_many_states() {
            let ProductTarget { first, by_row, by_column, rows: Range { start, .. } } = target;
            let row = if *start == 0 { "row".into() } else { format!("(row - {start})") };
            let name = if replaces { "set_at" } else { "add_at" };
            let place = format!("{first} + {by_column} * column + {by_row} * {row}");
            return print(rows, format!("outputs.{name}({place}, {number})"));
        }
        for rows in self.result.arrays_of(target, rows) {
            let indices = self.result.place_in_loops(target, &rows, products.columns());
            let place = format!("result{indices}");
            let sum = if replaces { number.clone() } else { self.sum(&place, &self.one(&number)) };
            print(rows, format!("{place} = {sum}"));
        }
    }

    /// Returns a number of the result as an operand.
    fn one(&self, number: &str) -> String {
        match self.program.execution {
            Execution::Simd => format!("V::one({number})"),
            _ => number.into(),
        }
    }

    /// Returns the sum of a number of the result and an operand, as a number of the result.
    fn sum(&self, number: &str, operand: &str) -> String {
        let sum = format!("{} + {operand}", self.one(number));
        match self.program.execution {
            Execution::Simd => format!("V::number({sum})"),
            _ => sum,
        }
    }
}

/// Prints the sums of a block's rows, some at a time. The last ones may be among those before them.
fn rows(text: &mut String, block: &ProductBlock, a: &str, products: &[String]) {
    let Range { start, end } = block.rows;
    let count = products.len();
    let at_a_time = (end - start).min(ROW_LANES);
    let last = end - at_a_time;
    let _ = writeln!(
        text,
        "        let mut next = {start};\n        while next < {end} {{\n            \
         let row = if next < {last} {{ next }} else {{ {last} }};\n            \
         let mut sums = [[T::zero(); {at_a_time}]; {count}];"
    );
    for Range { start, end } in &block.terms {
        let _ = writeln!(
            text,
            "            let mut term = {start};\n            while term < {end} {{\n                \
             let mut r = 0;\n                while r < {at_a_time} {{\n                    let a = {a}[term][row + r];"
        );
        for m in 0..count {
            let _ = writeln!(
                text,
                "                    sums[{m}][r] = a.mul_add(b[{m}][term], sums[{m}][r]);"
            );
        }
        *text += "                    r += 1;\n                }\n                term += 1;\n            }\n";
    }
    let _ = writeln!(text, "            let mut r = 0;\n            while r < {at_a_time} {{");
    for (m, product) in products.iter().enumerate() {
        let _ = writeln!(text, "                {product}[row + r] = sums[{m}][r];");
    }
    let _ = writeln!(
        text,
        "                r += 1;\n            }}\n            next += {at_a_time};\n        }}"
    );
}

/// Prints the sums of vectors of rows: the first row, and the number of vectors.
fn vectors(
    text: &mut String,
    block: &ProductBlock,
    first: usize,
    vectors: usize,
    a: &str,
    products: &[String],
) {
    let list =
        |text: &dyn Fn(usize) -> String, count| (0..count).map(text).collect::<Vec<_>>().join(", ");
    let count = products.len();
    let factors = list(&|m| format!("V::Four::broadcast(V::one(b[{m}][term]))"), count);
    let rows = list(&|lane| format!("V::one({a}[term][row + {lane}])"), ROW_LANES);
    let _ = writeln!(text, "        let mut sums = [[V::Four::zero(); {vectors}]; {count}];");
    for Range { start, end } in &block.terms {
        let _ = writeln!(
            text,
            "        let mut term = {start};\n        while term < {end} {{\n            let \
             factors = [{factors}];\n            \
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
    for (m, product) in products.iter().enumerate() {
        let names = list(&|lane| format!("x{lane}"), ROW_LANES);
        let places = list(&|lane| format!("{product}[row + {lane}]"), ROW_LANES);
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

    /// Returns the names and the indices on the path from a value to its scalar `i`: every second
    /// one is an index.
    fn steps(&self, i: usize) -> Vec<String> {
        self.place(i).split(['[', ']']).map(Into::into).collect()
    }

    /// Returns the rows of a target in ranges, each of which is in one array.
    fn arrays_of(&self, target: &ProductTarget, rows: Range<usize>) -> Vec<Range<usize>> {
        let mut ranges: Vec<Range<usize>> = Vec::new();
        for row in rows {
            let follows = |range: &Range<usize>| {
                let [a, b] = [range.start, row].map(|row| self.steps(target.result(row, 0)));
                let mut other = a.iter().zip(&b).filter(|(a, b)| a != b);
                let index = |step: &String| step.parse::<usize>().ok();
                let differs = other.next().and_then(|(a, b)| index(b)?.checked_sub(index(a)?));
                a.len() == b.len() && other.next().is_none() && differs == Some(row - range.start)
            };
            match ranges.last_mut() {
                Some(range) if follows(range) => range.end += 1,
                _ => ranges.push(row..row + 1),
            }
        }
        ranges
    }

    /// Returns the path from a value to the scalar of a target in `row`, one of `rows` in one
    /// array, and `column`, which are variables; a product has this many columns.
    fn place_in_loops(
        &self,
        target: &ProductTarget,
        rows: &Range<usize>,
        columns: usize,
    ) -> String {
        let first = self.steps(target.result(rows.start, 0));
        let mut path = first.clone();
        let mut vary = |variable: &str, next: Vec<String>, start: usize| {
            for ((step, before), next) in path.iter_mut().zip(&first).zip(&next) {
                if let Some(index) = before.parse::<usize>().ok().filter(|_| before != next) {
                    *step = match index.cmp(&start) {
                        Ordering::Equal => variable.into(),
                        Ordering::Greater => format!("{variable} + {}", index - start),
                        Ordering::Less => format!("{variable} - {}", start - index),
                    };
                }
            }
        };
        if columns > 1 {
            vary("column", self.steps(target.result(rows.start, 1)), 0);
        }
        if rows.len() > 1 {
            vary("row", self.steps(target.result(rows.start + 1, 0)), rows.start);
        }
        let bracket = |(k, step): (usize, String)| match k % 2 {
            0 => step,
            _ => format!("[{step}]"),
        };
        path.into_iter().enumerate().map(bracket).collect()
    }

    /// Returns the path from a value to its scalar `i`.
    fn place(&self, i: usize) -> String {
        match self {
            Self::Scalar => String::new(),
            Self::Array(element, _) => {
                format!("[{}]{}", i / element.len(), element.place(i % element.len()))
            }
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
