//! The table of options: the options in `docs/command.md`, and the table in the macro's
//! documentation.

use modyn_codegen::options::{Entries, OPTIONS, OptionRow};

use super::data::markdown;

/// Returns the first columns of the table of some options.
fn table(rows: impl Iterator<Item = &'static OptionRow>, columns: usize) -> String {
    let titles = ["option", "values", "default", "meaning", "example"];
    // A bar in a table's cell has a backslash.
    let escaped = |text: &str| text.replace('|', "\\|");
    let rows = rows.map(|row| {
        let form = if row.form == "links" { "[\"link\", ...]" } else { row.form };
        let mut cells = vec![
            format!("`{}`", row.name),
            format!("`{}`", escaped(form)),
            row.default.into(),
            row.docs.trim().into(),
            format!("`{}`", escaped(row.example)),
        ];
        cells.truncate(columns);
        cells
    });
    markdown(&titles[..columns].join(" | "), rows)
}

/// Returns the page's table.
pub(super) fn whole() -> String {
    table(OPTIONS.iter(), 5)
}

/// Returns the names of the options that only files have.
pub(super) fn of_files() -> String {
    let rows = OPTIONS.iter().filter(|row| row.entries == Entries::Files);
    rows.map(|row| format!("`{}`", row.name)).collect::<Vec<_>>().join(", ")
}

/// Returns the table of the options that the macro has.
pub(super) fn of_macro() -> String {
    table(OPTIONS.iter().filter(|row| row.entries == Entries::All), 4)
}
