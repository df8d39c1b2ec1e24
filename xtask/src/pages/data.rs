//! The files of `docs/data`, and tables in Markdown.

use std::fmt::Write as _;

use super::read;

/// A file of `docs/data`: lines `# key: value`, a line with the columns' titles, and rows; cells
/// end with tabs.
pub(super) struct Data {
    name: String,
    notes: Vec<(String, String)>,
    pub(super) titles: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Data {
    pub(super) fn load(name: &str) -> Self {
        let text = read(&format!("docs/data/{name}.tsv"));
        let note = |line: &str| {
            let (key, value) = line.strip_prefix("# ")?.split_once(": ")?;
            Some((key.to_owned(), value.to_owned()))
        };
        let cells = |line: &str| line.split('\t').map(String::from).collect::<Vec<_>>();
        let mut lines = text.lines().filter(|line| !line.starts_with('#')).map(cells);
        let titles = lines.next().unwrap_or_else(|| panic!("{name} is empty"));
        let rows: Vec<Vec<String>> = lines.collect();
        assert!(!rows.is_empty(), "{name} has no rows");
        for row in &rows {
            assert_eq!(row.len(), titles.len(), "{name}: {row:?}");
        }
        Self { name: name.into(), notes: text.lines().filter_map(note).collect(), titles, rows }
    }

    pub(super) fn column(&self, title: &str) -> usize {
        let found = self.titles.iter().position(|one| one == title);
        found.unwrap_or_else(|| panic!("{} has no column {title:?}", self.name))
    }

    /// Returns the cell of column `title` in the row whose first cells are `key`.
    pub(super) fn find(&self, key: &[&str], title: &str) -> Option<&str> {
        let row =
            self.rows.iter().find(|row| row.iter().zip(key).all(|(cell, key)| cell == key))?;
        Some(&row[self.column(title)])
    }

    /// Returns the cell that `find` finds, which must exist.
    pub(super) fn cell(&self, key: &[&str], title: &str) -> &str {
        self.find(key, title).unwrap_or_else(|| panic!("{}: no {key:?}", self.name))
    }

    pub(super) fn number(&self, key: &[&str], title: &str) -> f64 {
        let cell = self.cell(key, title).trim_end_matches('*');
        cell.parse().unwrap_or_else(|_| panic!("{}: {cell:?} of {key:?}", self.name))
    }

    pub(super) fn note(&self, key: &str) -> &str {
        let found = self.notes.iter().find(|(one, _)| one == key);
        &found.unwrap_or_else(|| panic!("{} does not state its {key}", self.name)).1
    }

    /// Returns a paragraph that says how the table was computed, or how and when it was measured.
    pub(super) fn source(&self) -> String {
        let command = self.note("command");
        if !self.notes.iter().any(|(key, _)| key == "date") {
            return format!(
                "\nComputed by `{command}`; the numbers are the same on every machine.\n"
            );
        }
        let note = self.notes.iter().find(|(key, _)| key == "note");
        let note = note.map_or(String::new(), |(_, note)| format!(" ({note})"));
        let [date, commit] = ["date", "commit"].map(|key| self.note(key));
        format!("\nMeasured on {date} at commit `{commit}` by `{command}`{note}.\n")
    }

    /// Returns the table with its source.
    pub(super) fn shown(&self) -> String {
        table(&self.titles.join(" | "), &self.rows) + &self.source()
    }
}

/// Returns a table in Markdown. The titles are one text, as in the table.
pub(super) fn markdown<R>(titles: &str, rows: impl IntoIterator<Item = R>) -> String
where
    R: AsRef<[String]>,
{
    let mut text = format!("| {titles} |\n|{}\n", "---|".repeat(titles.split(" | ").count()));
    for row in rows {
        let _ = writeln!(text, "| {} |", row.as_ref().join(" | "));
    }
    text
}

/// Returns a table in Markdown whose empty cells are one space.
pub(super) fn table<R: AsRef<[String]>>(titles: &str, rows: impl IntoIterator<Item = R>) -> String {
    markdown(titles, rows).replace("|  |", "| |").replace("|  |", "| |")
}
