//! The table of functions, against everything that must have a place for each: the page, the trait, the interpreter.

use std::fmt::Write as _;
use std::path::Path;

use modyn_codegen::Function;

fn file(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

const BEGIN: &str = "<!-- The table of functions; `functions_page` writes it. -->\n";
const END: &str = "<!-- End of the table. -->\n";

/// The table as the page has it.
fn table() -> String {
    let mut text = String::from(
        "| function | arguments | result | default | `_with` parameters | batch |\n|---|---|---|---|---|---|\n",
    );
    let one = Function::ALL.iter().filter(|function| function.batched().is_none());
    for function in one {
        let row = function.row();
        let arguments: Vec<String> =
            row.arguments.iter().map(|a| format!("`{}`", a.name)).collect();
        let of = |yes: bool| if yes { "yes" } else { "" };
        let default = match (row.default, row.of_loops) {
            (true, true) => "with loops",
            (default, _) => of(default),
        };
        let batch = Function::ALL.iter().any(|other| other.batched() == Some(*function));
        let docs = row.docs.replace('\n', " ");
        let _ = writeln!(
            text,
            "| `{}` | {} | {docs} | {default} | {} | {} |",
            function.name(),
            arguments.join(", "),
            of(row.depends_on_parameters),
            of(batch)
        );
    }
    text
}

/// With the variable `UPDATE_SNAPSHOTS`, it is written.
#[test]
fn the_page_has_the_table() {
    let page = file("docs/functions.md");
    let (before, rest) = page.split_once(BEGIN).expect("the table's beginning");
    let (found, after) = rest.split_once(END).expect("the table's end");
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/functions.md");
        std::fs::write(path, [before, BEGIN, &table(), END, after].concat()).expect("writes");
        return;
    }
    assert_eq!(found, table());
}

/// The trait has each function of one state, and with parameters where these matter.
#[test]
fn the_trait_has_each_function() {
    let text = file("modyn-runtime/src/robot.rs");
    for function in Function::ALL.iter().filter(|function| function.batched().is_none()) {
        let name = function.name();
        assert!(text.contains(&format!("fn {name}<")), "{name}");
        let with = text.contains(&format!("fn {name}_with<"));
        assert_eq!(with, function.depends_on_parameters(), "{name}");
    }
}

/// So has the interpreter; wrenches in either axes are one argument of it.
#[test]
fn the_interpreter_has_each_function() {
    let files = ["closures", "coordinates", "derivatives", "kinematics", "mod", "regressor"];
    let text: String =
        files.map(|name| file(&format!("modyn-runtime/src/interpreter/{name}.rs"))).concat();
    for function in Function::ALL.iter().filter(|function| function.batched().is_none()) {
        let name = function.name().trim_end_matches("_world");
        assert!(
            text.contains(&format!("pub fn {name}(")) || text.contains(&format!("pub fn {name}<")),
            "{name}"
        );
    }
}

/// A batch computes what the function of one state does.
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
