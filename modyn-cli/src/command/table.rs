//! Tables as text.

use unicode_width::UnicodeWidthStr;

/// Rows under a header, in columns of minimal width.
pub struct Table {
    rows: Vec<Vec<String>>,
    /// The first column that is aligned to the right.
    right: usize,
}

impl Table {
    /// Returns a table with this header.
    pub fn new(head: &[&str]) -> Self {
        let head = head.iter().map(ToString::to_string).collect();
        Self { rows: vec![head], right: usize::MAX }
    }

    /// Adds a row.
    pub fn row<const N: usize>(&mut self, row: [String; N]) {
        self.rows.push(row.into());
    }

    /// Aligns the columns from `column` on to the right, as for numbers.
    pub fn right_aligned_from(mut self, column: usize) -> Self {
        self.right = column;
        self
    }

    /// Returns the table's lines.
    pub fn text(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            self.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.width()).max()
        };
        let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
        let mut out = String::new();
        for row in &self.rows {
            let mut line = String::new();
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                let space = " ".repeat(width - cell.width());
                let (before, after) =
                    if column < self.right { ("", &*space) } else { (&*space, "") };
                line += &format!("{before}{cell}{after}  ");
            }
            out += line.trim_end();
            out.push('\n');
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_they_look() {
        let mut table = Table::new(&["a", "n"]);
        table.row(["日本".into(), "1".into()]);
        table.row(["é".into(), "10".into()]);
        assert_eq!(table.right_aligned_from(1).text(), "a      n\n日本   1\né     10\n");
    }
}
