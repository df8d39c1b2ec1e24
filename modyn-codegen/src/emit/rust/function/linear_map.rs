//! The linear map of columns after the statements of a function, in loops.

use std::fmt::Write as _;

use super::Printer;
use super::products::{scalars, vectors};
use crate::program::{Execution, LinearMap, Operand};

impl Printer<'_> {
    /// Prints the end of a function, which returns the result with the products of a map; `value` is the result before.
    pub(super) fn linear_map(&self, text: &mut String, value: &str, map: &LinearMap) {
        let (rows, terms) = (map.rows, map.terms());
        let (number, zero) = match self.program.execution {
            Execution::Simd => {
                *text += "    use __modyn::{Scalar as _, batch::Pack as _};\n";
                ("V::Number", "V::number(V::One::zero())")
            }
            _ => ("T", "T::zero()"),
        };
        let _ = writeln!(text, "    let mut result = {value};");
        let matrices =
            map.matrices.iter().enumerate().map(|(m, of)| (format!("columns{m}"), of, terms));
        for (name, entries, height) in [("map".into(), &map.map, rows)].into_iter().chain(matrices)
        {
            let count = entries.len() / height;
            let columns: Vec<String> =
                entries.chunks(height).map(|column| self.numbers(column)).collect();
            let columns = columns.join(", ");
            let _ =
                writeln!(text, "    let {name}: [[{number}; {height}]; {count}] = [{columns}];");
        }
        let range = 0..map.matrices.len();
        let list = |one: &dyn Fn(usize) -> String| range.clone().map(one).collect::<Vec<_>>();
        let products = list(&|m| format!("product{m}"));
        for block in &map.blocks {
            let columns = list(&|m| format!("columns{m}[column]")).join(", ");
            let _ = writeln!(
                text,
                "    let mut column = {};\n    while column < {} {{\n        let b = [{columns}];",
                block.columns.start, block.columns.end
            );
            for product in &products {
                let _ = writeln!(text, "        let mut {product} = [{zero}; {rows}];");
            }
            match self.program.execution {
                Execution::Simd => {
                    for group in block.vectors(rows) {
                        vectors(text, block, group, ("map", &products));
                    }
                }
                _ => scalars(text, block, ("map", &products)),
            }
            for (product, targets) in products.iter().zip(&map.targets) {
                for (row, target) in targets.iter().enumerate() {
                    let place = self.column_place(*target);
                    let _ = writeln!(text, "        result{place} = {product}[{row}];");
                }
            }
            *text += "        column += 1;\n    }\n";
        }
        *text += "    result\n}\n\n";
    }

    /// Returns the array of these operands as numbers.
    fn numbers(&self, operands: &[Operand]) -> String {
        let numbers = operands.iter().map(|operand| match self.program.execution {
            Execution::Simd => format!("V::number({})", self.operand(operand)),
            _ => self.operand(operand),
        });
        format!("[{}]", numbers.collect::<Vec<_>>().join(", "))
    }

    /// Returns the path from the result to the number of a column: the first one, and the distance between those of consecutive
    /// columns.
    fn column_place(&self, (first, stride): (usize, usize)) -> String {
        let [zero, one] = [first, first + stride].map(|place| self.result.place(place));
        let same = zero.bytes().zip(one.bytes()).take_while(|(a, b)| a == b).count();
        format!("{}column{}", &zero[..same], &zero[same + 1..])
    }
}
