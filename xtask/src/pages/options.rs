//! The table of options: the options in `docs/command.md`, and the table in the macro's
//! documentation.

use modyn_codegen::options::{Entries, OPTIONS, OptionRow};

use super::data::markdown;

/// The options that another page describes: the table has the first sentence, and a link.
const GUIDES: [(&str, &str); 8] = [
    ("loops", "contacts.md#closed-loops"),
    ("contacts", "contacts.md#contacts"),
    ("ground", "contacts.md#collision-shapes"),
    ("actuators", "contacts.md#actuators-of-a-urdf"),
    ("functions", "functions.md"),
    ("fused", "functions.md#fused-functions"),
    ("share_limbs", "performance.md#equal-limbs"),
    ("code", "performance.md#straight-line-code-or-loops"),
];

/// Returns what the page says about an option.
fn on_the_page(row: &OptionRow) -> String {
    let docs = row.docs.trim();
    match GUIDES.iter().find(|(name, _)| *name == row.name) {
        Some((_, page)) => {
            let first =
                docs.split_once(". ").map_or(docs.trim_end_matches('.'), |(first, _)| first);
            format!("{first} ([more]({page})).")
        }
        None => docs.into(),
    }
}

/// Returns a table of some options.
fn table(rows: impl Iterator<Item = &'static OptionRow>, docs: fn(&OptionRow) -> String) -> String {
    // A bar in a table's cell has a backslash.
    let rows = rows.map(|row| {
        let form = if row.form == "links" { "[\"link\", ...]" } else { row.form };
        let form = format!("`{}`", form.replace('|', "\\|"));
        [format!("`{}`", row.name), form, row.default.into(), docs(row)]
    });
    markdown("option | values | default | meaning", rows)
}

/// Returns the page's table.
pub(super) fn whole() -> String {
    table(OPTIONS.iter(), on_the_page)
}

/// Returns the names of the options that only files have.
pub(super) fn of_files() -> String {
    let rows = OPTIONS.iter().filter(|row| row.entries == Entries::Files);
    rows.map(|row| format!("`{}`", row.name)).collect::<Vec<_>>().join(", ")
}

/// Returns the table of the options that the macro has.
pub(super) fn of_macro() -> String {
    let rows = OPTIONS.iter().filter(|row| row.entries == Entries::All);
    table(rows, |row| row.docs.trim().into())
}
