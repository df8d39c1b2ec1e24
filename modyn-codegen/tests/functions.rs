//! The pages have an entry for each function of the table.

use std::collections::BTreeSet;
use std::path::Path;

use modyn_codegen::Function;
use modyn_codegen::plan::{Shape, Sizes};

fn file(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn page() -> String {
    file("docs/functions.md").replace("\r\n", "\n")
}

/// Returns the part of `text` between two strings.
fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    let (_, rest) = text.split_once(start).unwrap_or_else(|| panic!("no {start:?}"));
    rest.split_once(end).unwrap_or_else(|| panic!("no {end:?}")).0
}

/// Returns the names in backquotes that are, or could be, names of functions.
fn names(text: &str) -> Vec<&str> {
    let quoted = text.split('`').skip(1).step_by(2);
    let name = |text: &&str| {
        text.bytes().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'_')
    };
    quoted.filter(name).collect()
}

fn sorted<'a>(names: impl IntoIterator<Item = &'a str>) -> BTreeSet<&'a str> {
    names.into_iter().collect()
}

fn named(functions: &[Function]) -> BTreeSet<&'static str> {
    sorted(functions.iter().map(|function| function.name()))
}

#[test]
fn the_default_functions_are_listed() {
    let page = page();
    let found =
        names(between(&page, "By default it has\n", "A call of a function that was not selected"));
    assert_eq!(found.len(), Function::DEFAULT.len(), "each once");
    assert_eq!(sorted(found), named(Function::DEFAULT));
}

/// The measured costs belong to functions that exist, the same functions for each robot.
#[test]
fn each_cost_is_of_a_function() {
    let table = file("docs/data/functions.tsv").replace("\r\n", "\n");
    let names_of = |robot: &str| {
        let rows = table.lines().filter(|row| row.starts_with(&format!("{robot}\t")));
        sorted(rows.flat_map(names))
    };
    let expected = names_of("arm7");
    assert!(expected.len() > 30, "{expected:?}");
    assert!(expected.is_subset(&named(Function::ALL)), "{expected:?}");
    for robot in ["quadruped", "humanoid"] {
        assert_eq!(names_of(robot), expected, "{robot}");
    }
}

/// Returns the text of a test module, with the modules in its folder; empty if there is no such module.
fn test_module(name: &str) -> String {
    let folders = [
        "tests/tests",
        "modyn-codegen/tests",
        "modyn-read/tests",
        "tests/fleet/tests",
        "lab/paper/tests",
        "modyn-python/tests",
    ];
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut text = String::new();
    for folder in folders.map(|folder| root.join(folder)) {
        let within = std::fs::read_dir(folder.join(name)).into_iter().flatten();
        let within = within.map(|entry| entry.expect("an entry").path());
        let own = ["rs", "py"].map(|ending| folder.join(format!("{name}.{ending}")));
        for file in within.chain(own) {
            text += &std::fs::read_to_string(file).unwrap_or_default();
        }
    }
    text
}

/// Each function of one state has a row on the page of quantities, and the row names a test that calls the function: it holds the
/// function against other software, or code that shares nothing with it.
#[test]
fn each_function_is_held_against_something_else() {
    let page = file("docs/internals/tests.md");
    let (rows, _) = page.split_once("\n\n| | | test |").expect("two tables");
    for function in Function::ALL.iter().filter(|function| function.batched().is_none()) {
        let name = function.name();
        let of_the_row = [name, name.trim_end_matches("_local")];
        let row = rows.lines().find(|row| of_the_row.iter().any(|name| names(row).contains(name)));
        let row = row.unwrap_or_else(|| panic!("`{name}` is not on the page"));
        let (_, tests) = row.trim_end_matches(" |").rsplit_once("| ").expect("columns");
        let called = [of_the_row[0], of_the_row[1], &format!("{function:?}")];
        let is_held = |test: &str| {
            let text = test_module(test);
            let mut words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
            words.any(|word| called.contains(&word))
        };
        assert!(names(tests).into_iter().any(is_held), "`{name}`: no test in {tests}");
    }
}

/// A function of many states computes the same as the function of one state.
#[test]
fn a_batch_has_its_functions_arguments() {
    for function in Function::ALL {
        let Some(one) = function.batched() else { continue };
        assert_eq!(function.name(), format!("{}_batch", one.name()));
        let names = |f: Function| f.row().arguments.iter().map(|a| a.name).collect::<Vec<_>>();
        assert_eq!(names(*function), names(one));
        assert!(!function.row().default);
    }
}

/// Arguments and results that are derivatives say of which kind they are, and with respect to what.
#[test]
fn derivatives_have_names_of_one_rule() {
    let variables = ["q", "qd", "qdd", "tau", "ctrl", "act", "x", "u", "v", "from", "to"];
    let mut derivatives = 0;
    for function in Function::ALL.iter().filter(|function| function.batched().is_none()) {
        let mut names: Vec<&str> = function.row().arguments.iter().map(|a| a.name).collect();
        if let Shape::Record(_, fields) = (function.row().result)(&Sizes::default()) {
            names.extend(fields.iter().map(|(name, _)| *name));
        }
        for name in names {
            let kinds: &[&str] = match name.split_once('_') {
                Some(("grad", _)) => &["_vjp", "_hessian"],
                Some(("hess", _)) => &["_hessian"],
                Some(("tangent", _)) => &["_jvp"],
                Some((_, by)) if by.strip_prefix('d').is_some_and(|x| variables.contains(&x)) => {
                    &["_derivatives", "knot", "generalized_forces", "generalized_forces_local"]
                }
                _ => {
                    let variable = name.strip_prefix('d').unwrap_or_default();
                    assert!(!variables.contains(&variable), "{function:?}: {name}");
                    continue;
                }
            };
            derivatives += 1;
            let named = function.name();
            assert!(kinds.iter().any(|kind| named.ends_with(kind)), "{named}: {name}");
        }
    }
    assert!(derivatives > 60, "{derivatives}");
}

/// The page for users of other libraries names functions that there are.
#[test]
fn other_libraries_functions_have_these_counterparts() {
    let page = file("docs/coming-from.md");
    let names: BTreeSet<&str> = page
        .split("`R::")
        .skip(1)
        .map(|rest| {
            rest.split(|c: char| !c.is_ascii_lowercase() && c != '_').next().unwrap_or_default()
        })
        .filter(|name| !name.is_empty())
        .collect();
    let all = named(Function::ALL);
    let unknown: Vec<&&str> = names.difference(&all).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
    assert!(names.len() > 30, "{names:?}");
}
