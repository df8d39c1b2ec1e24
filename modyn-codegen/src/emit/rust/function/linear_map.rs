//! The linear map of columns after the statements of a function, in loops.

use std::fmt::Write as _;

use super::Printer;
use super::products::{scalars, vectors};
use crate::program::{Execution, LinearMap};

impl Printer<'_> {
    /// Prints the end of a function, which returns the result with the products of a map whose entries are stored; `value` is the result
    /// before.
    pub(super) fn linear_map(&self, text: &mut String, value: &str, map: &LinearMap) {
        let rows = map.rows;
        if self.program.execution == Execution::Simd {
            *text += "    use __modyn::{Scalar as _, batch::Pack as _};\n";
        }
        let zero = self.zero();
        let _ = writeln!(text, "    let mut result = {value};");
        let range = 0..map.targets.len();
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
                    let place = self.column_place(*target, map.columns());
                    let _ = writeln!(text, "        result{place} = {product}[{row}];");
                }
            }
            *text += "        column += 1;\n    }\n";
        }
        *text += "    result\n}\n\n";
    }

    /// Returns the path from the result to the number of a `column` of this many: its places are the first one, and the distance between
    /// those of consecutive columns.
    fn column_place(&self, (first, stride): (usize, usize), columns: usize) -> String {
        let zero = self.result.place(first);
        if columns == 1 {
            return zero;
        }
        // The paths of columns 0 and 1 differ by that digit alone.
        let one = self.result.place(first + stride);
        let same = zero.bytes().zip(one.bytes()).take_while(|(a, b)| a == b).count();
        format!("{}column{}", &zero[..same], &zero[same + 1..])
    }
}
