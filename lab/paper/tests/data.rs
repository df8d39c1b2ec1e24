//! The tables of the documentation that this crate computes: each file of `docs/data` has the computed numbers.
//!
//! The numbers are the same on every machine. With the variable `UPDATE_SNAPSHOTS` the files are written;
//! `cargo xtask pages --check` compares the pages with them.

use std::path::Path;

#[test]
fn tables_of_the_documentation_are_the_computed_ones() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/data");
    for (name, table) in modyn_reproduce::tables() {
        let (file, computed) = (folder.join(format!("{name}.tsv")), table.data());
        if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
            std::fs::write(&file, computed).expect("writes");
            continue;
        }
        let text = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{name}: {error}"));
        for (line, (found, computed)) in text.lines().zip(computed.lines()).enumerate() {
            assert_eq!(found, computed, "{name}, line {}", line + 1);
        }
        assert_eq!(text.lines().count(), computed.lines().count(), "{name}");
    }
}
