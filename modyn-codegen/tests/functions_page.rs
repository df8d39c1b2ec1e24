//! `docs/functions.md` lists the functions that the compiler has, and the default ones.

use std::collections::BTreeSet;
use std::path::Path;

use modyn_codegen::Function;

fn page() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/functions.md");
    std::fs::read_to_string(path).expect("the page").replace("\r\n", "\n")
}

/// The part of `text` between two strings.
fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    let (_, rest) = text.split_once(start).unwrap_or_else(|| panic!("no {start:?}"));
    rest.split_once(end).unwrap_or_else(|| panic!("no {end:?}")).0
}

/// The names in backquotes that are functions' or could be.
fn names(text: &str) -> Vec<&str> {
    let quoted = text.split('`').skip(1).step_by(2);
    let name = |text: &&str| text.bytes().all(|c| c.is_ascii_lowercase() || c == b'_');
    quoted.filter(name).collect()
}

fn sorted<'a>(names: impl IntoIterator<Item = &'a str>) -> BTreeSet<&'a str> {
    names.into_iter().collect()
}

fn named(functions: &[Function]) -> BTreeSet<&'static str> {
    sorted(functions.iter().map(|function| function.name()))
}

#[test]
fn all_functions_are_listed() {
    let page = page();
    let found = names(between(&page, "## All functions\n", "`cargo test"));
    assert_eq!(found.len(), Function::ALL.len(), "each once");
    assert_eq!(sorted(found), named(Function::ALL));
}

#[test]
fn the_default_functions_are_listed() {
    let page = page();
    let found = names(between(&page, "By default it has\n", "A call of another one"));
    assert_eq!(found.len(), Function::DEFAULT.len(), "each once");
    assert_eq!(sorted(found), named(Function::DEFAULT));
}

/// Each function has a row for each robot of the table, or is named as having none.
#[test]
fn each_function_has_its_costs_or_is_said_to_have_none() {
    let page = page();
    let without = sorted(names(between(&page, "Not in the table are", "The last takes")));
    let table = between(&page, "| robot | function |", "Generic functions");
    for robot in ["arm7", "quadruped", "humanoid"] {
        let rows = table.lines().filter(|row| row.starts_with(&format!("| {robot} |")));
        let found = sorted(rows.flat_map(names));
        let expected = Function::ALL.iter().filter(|function| !function.is_of_loops());
        let expected = expected.map(|function| function.name());
        assert_eq!(found, sorted(expected.filter(|name| !without.contains(name))), "{robot}");
    }
}
