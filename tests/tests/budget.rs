//! The cost of the tests, as far as it can be counted: each file of tests is part of a binary, and there are few binaries.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Each binary of tests links the compiler, which takes seconds.
const MAX_BINARIES: usize = 25;

/// Returns the paths of the sources of all targets of the workspace that `cargo test` builds and runs.
fn tested() -> Vec<PathBuf> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--format-version=1"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("Cargo runs");
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("a list");
    let targets =
        packages.iter().flat_map(|package| package["targets"].as_array().expect("a list"));
    let tested = targets.filter(|target| target["test"] == true);
    tested.map(|target| target["src_path"].as_str().expect("a path").into()).collect()
}

#[test]
fn there_are_few_binaries_of_tests() {
    let tested = tested();
    assert!(tested.len() > 5 && tested.len() <= MAX_BINARIES, "{}: {tested:#?}", tested.len());
}

/// Cargo finds no tests by itself here: a file without a `mod` line would never run.
#[test]
fn each_file_of_tests_is_part_of_a_binary() {
    let is_main = |path: &PathBuf| {
        path.ends_with("main.rs") && path.components().any(|part| part.as_os_str() == "tests")
    };
    let mains = tested().into_iter().filter(is_main);
    let mut files = 0;
    for main in mains {
        let text = fs::read_to_string(&main).expect("a file");
        let folder: &Path = main.parent().expect("a folder");
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let is_module = path.extension().is_some_and(|end| end == "rs") && path != main
                || path.join("mod.rs").exists();
            let name = path.file_stem().expect("a name").to_string_lossy();
            assert!(!is_module || text.contains(&format!("mod {name};\n")), "{}", path.display());
            files += usize::from(is_module);
        }
    }
    assert!(files > 80, "{files}");
}
