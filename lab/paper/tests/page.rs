//! `docs/internals/equations.md` is complete and current: every equation has a row, and every name is defined in the file that it
//! links to.

use std::fs;
use std::path::{Path, PathBuf};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/internals")
}

fn page() -> String {
    fs::read_to_string(docs().join("equations.md")).expect("docs/internals/equations.md")
}

/// Returns the names in the page, each with the file that it links to: [`name`](file).
fn links(text: &str) -> Vec<(&str, &str)> {
    let parts = text.split("[`").skip(1);
    parts
        .filter_map(|part| {
            let (name, rest) = part.split_once("`](")?;
            Some((name, rest.split_once(')')?.0))
        })
        .collect()
}

#[test]
fn every_name_is_defined_in_the_linked_file() {
    let page = page();
    let links = links(&page);
    assert!(links.len() > 200, "{} links", links.len());
    let kinds = ["fn", "struct", "enum", "trait", "const", "type"];
    for (name, file) in links {
        let source =
            fs::read_to_string(docs().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        // The definition of the name, not of a longer name.
        let found = kinds.iter().any(|kind| {
            let wanted = format!("{kind} {name}");
            source.match_indices(&wanted).any(|(at, _)| {
                let after = source[at + wanted.len()..].chars().next();
                after.is_none_or(|c| !c.is_alphanumeric() && c != '_')
            })
        });
        assert!(found, "{file} has no `{name}`");
        // A name in a file of tests must be a test, not a helper.
        if file.contains("/tests/") {
            let (before, _) = source.split_once(&format!("fn {name}(")).expect("a function");
            let line =
                before.lines().rev().nth(usize::from(before.ends_with("    "))).unwrap_or("");
            assert!(line.trim() == "#[test]", "`{name}` of {file} is no test: {line}");
        }
    }
}

#[test]
fn every_equation_has_its_row_in_order() {
    let page = page();
    let rows: Vec<&str> = page
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.split_once(" |").map(|(first, _)| first))
        .filter(|first| first.starts_with('(') || *first == "Table 6")
        .collect();
    let body = (1..=69).map(|k| format!("({k})"));
    let appendix = (1..=22).map(|k| format!("(A.{k})"));
    let expected: Vec<String> = body.chain(appendix).chain(["Table 6".to_owned()]).collect();
    assert_eq!(rows, expected);
    for line in page.lines().filter(|line| line.starts_with("| (")) {
        let cells: Vec<&str> = line.split('|').collect();
        assert_eq!(cells.len(), 6, "{line}");
        assert!(
            !links(cells[3]).is_empty() && !links(cells[4]).is_empty(),
            "code and test: {line}"
        );
    }
}
