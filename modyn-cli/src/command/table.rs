//! Tables as text.

use unicode_width::UnicodeWidthStr;

use crate::escape::shortened;

/// The width of a line, without the indentation of a section.
pub const WIDTH: usize = 98;

/// The minimal width of a column that is shortened to fit.
const LEAST: usize = 12;

/// Rows under a header, in columns of minimal width.
pub struct Table {
    rows: Vec<Vec<String>>,
    /// The first column that is aligned to the right.
    right: usize,
    /// Whether the last column has remarks, which are wrapped.
    remarks: bool,
}

impl Table {
    /// Returns a table with this header.
    pub fn new(head: &[&str]) -> Self {
        let head = head.iter().map(ToString::to_string).collect();
        Self { rows: vec![head], right: usize::MAX, remarks: false }
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

    /// Makes the last column a column of remarks.
    pub fn with_remarks(mut self) -> Self {
        self.remarks = true;
        self
    }

    /// Returns the table in lines of at most [`WIDTH`]. Remarks that do not fit continue below
    /// their row; the middle of long names is left out.
    pub fn fitted(mut self) -> String {
        let columns = self.rows[0].len();
        let mut remarks = Vec::new();
        if self.remarks {
            remarks = self.rows.iter_mut().map(|row| row.pop().unwrap_or_default()).collect();
        }
        let kept = columns - usize::from(self.remarks);
        loop {
            let widths: Vec<usize> = (0..kept).map(|column| self.width(column)).collect();
            let excess = (widths.iter().sum::<usize>() + 2 * kept).saturating_sub(WIDTH + 2);
            let widest = (0..kept.min(self.right)).max_by_key(|&column| widths[column]);
            let Some(widest) = widest.filter(|&column| excess > 0 && widths[column] > LEAST) else {
                break;
            };
            let most = widths[widest].saturating_sub(excess).max(LEAST).max(widths[widest] / 2);
            for row in &mut self.rows {
                row[widest] = shortened(&row[widest], most);
            }
        }
        let text = self.text();
        let used = (0..kept).map(|column| self.width(column) + 2).sum::<usize>();
        let room = WIDTH.saturating_sub(used);
        let mut out = String::new();
        for (line, remark) in
            text.lines().zip(remarks.iter().map(String::as_str).chain(std::iter::repeat("")))
        {
            if remark.width() <= room {
                out += format!("{line}{}{remark}", " ".repeat(used - line.width())).trim_end();
                out.push('\n');
            } else {
                out += line;
                out.push('\n');
                for part in wrapped(remark.split(' '), " ", WIDTH - 6) {
                    out += &format!("      {part}\n");
                }
            }
        }
        out
    }

    /// Returns the width of a column.
    fn width(&self, column: usize) -> usize {
        self.rows
            .iter()
            .filter_map(|row| row.get(column))
            .map(|cell| cell.width())
            .max()
            .unwrap_or(0)
    }

    /// Returns the table's lines.
    pub fn text(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(|column| self.width(column)).collect();
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

/// Returns the words in lines of at most `width`, separated by `between`.
pub fn wrapped<'a>(
    words: impl IntoIterator<Item = &'a str>,
    between: &str,
    width: usize,
) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words {
        match lines.last_mut() {
            Some(line) if line.width() + between.width() + word.width() <= width => {
                line.push_str(between);
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_fit() {
        let mut table = Table::new(&["a", "b", "remarks"]);
        let long = "x".repeat(70);
        table.row([long.clone(), "y".repeat(60), "a remark of several words ".repeat(8)]);
        table.row(["short".into(), "b".into(), "short".into()]);
        let text = table.with_remarks().fitted();
        assert!(text.lines().all(|line| line.width() <= WIDTH), "{text}");
        assert!(text.contains('…') && text.matches("several").count() == 8, "{text}");
        let mut table = Table::new(&["a", "remarks"]);
        table.row(["x".into(), "all of it fits".into()]);
        assert_eq!(table.with_remarks().fitted(), "a  remarks\nx  all of it fits\n");
    }

    #[test]
    fn columns_are_as_wide_as_they_look() {
        let mut table = Table::new(&["a", "n"]);
        table.row(["日本".into(), "1".into()]);
        table.row(["é".into(), "10".into()]);
        assert_eq!(table.right_aligned_from(1).text(), "a      n\n日本   1\né     10\n");
    }
}
