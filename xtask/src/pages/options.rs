//! The table of options: `docs/options.md`, and the table in the macro's documentation.

use modyn_codegen::options::{Entries, OPTIONS, OptionRow};

use super::data::markdown;

/// Returns the first columns of the table of some options.
fn table(rows: impl Iterator<Item = &'static OptionRow>, columns: usize) -> String {
    let titles = ["option", "values", "default", "meaning", "example", "command line"];
    // A bar in a table's cell has a backslash.
    let escaped = |text: &str| text.replace('|', "\\|");
    let rows = rows.map(|row| {
        let form = if row.form == "links" { "[\"link\", ...]" } else { row.form };
        let long = row.name.replace('_', "-");
        let given = match (row.is_flag(), row.is_list()) {
            (true, _) => format!("`--{long}`"),
            (_, true) => format!("`--{long} ITEM`, several times"),
            _ => format!("`--{long} VALUE`"),
        };
        let mut cells = vec![
            format!("`{}`", row.name),
            format!("`{}`", escaped(form)),
            row.default.into(),
            row.docs.trim().into(),
            format!("`{}`", escaped(row.example)),
            given,
        ];
        cells.truncate(columns);
        cells
    });
    markdown(&titles[..columns], rows)
}

/// Returns the text of the page.
pub(super) fn page() -> String {
    let files = OPTIONS.iter().filter(|row| row.entries == Entries::Files);
    let files: Vec<String> = files.map(|row| format!("`{}`", row.name)).collect();
    format!(
        "# Options at each entry\n\n\
         Each option has one name at every entry: the macro (`modyn!(\"arm.urdf\", scalar = f32)`), the builder\n\
         (`Builder::new().scalar(FloatType::F32)`; `crate_` for `crate`, which is a keyword), the command line\n\
         (`--scalar f32`) and the first lines of generated files. Values have one syntax. On the command line outer\n\
         brackets and the quotes around plain names can be left out, and a flag has no value.\n\n\
         This page is made from the table in `modyn-codegen/src/options.rs`.\n\n{}\n\
         The macro does not have {}: it names the type as `pub(crate) Name = \"robot.urdf\"`, and writes no file.\n\n\
         The first lines of a file that `modyn generate` wrote say the options that it was made with. The\n\
         documentation of the generated type lists its scalar, functions, gravity, friction and run-time parameters;\n\
         its tables show the joints, links and modules that the other options lead to. C source is `Builder::generate_c` or `--target c`, and the\n\
         header of exported functions `Generated::c_header` or `--c-header`.\n",
        table(OPTIONS.iter(), 6),
        files.join(", "),
    )
}

/// Returns the table of the options that the macro has.
pub(super) fn of_macro() -> String {
    table(OPTIONS.iter().filter(|row| row.entries == Entries::All), 4)
}
