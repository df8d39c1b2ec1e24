//! The cost of the tests, as far as it can be counted: each file of tests is part of a binary, there are few binaries, and Cargo
//! builds the compiler in few configurations. `.ci/run` counts the builds of all workspaces.

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

/// Returns how often a command of Cargo builds a library, in different configurations: with other features, profiles or
/// processors.
fn builds(library: &str, command: &str) -> usize {
    let output = Command::new(env!("CARGO"))
        .args(command.split(' '))
        .args(["--offline", "--unit-graph", "-Zunstable-options"])
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        // The graph is an unstable option of Cargo.
        .env("RUSTC_BOOTSTRAP", "1")
        .output()
        .expect("Cargo runs");
    let graph: Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)));
    let units = graph["units"].as_array().expect("a list").iter();
    let is_build = |unit: &&Value| {
        unit["target"]["name"] == library && (unit["mode"] == "build" || unit["mode"] == "test")
    };
    units.filter(is_build).count()
}

/// The reader and the compiler of the macro, of build scripts and of tests are built once, and have no unit tests, which
/// would be another build.
#[test]
fn the_reader_and_the_compiler_are_built_once() {
    for command in [
        "test --workspace",
        "test --workspace --features modyn-fleet/whole",
        "test -p modyn-tests",
        "test -p modyn-jit",
        "test -p modyn-cli",
        "test -p modyn-codegen",
        "build --release --example gripper",
    ] {
        assert_eq!(builds("modyn_codegen", command), 1, "cargo {command}");
        assert_eq!(builds("modyn_read", command), 1, "cargo {command}");
    }
    assert_eq!(builds("modyn_read", "test -p modyn-read"), 1);
    // Without such a build, a unit test would never run.
    let sources = |package: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join(package).join("src");
    let mut folders = vec![sources("../modyn-codegen"), sources("../modyn-read")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let text = fs::read_to_string(&path).expect("a file");
                assert!(!text.contains("#[test]"), "{}: tests are in tests/units", path.display());
                files += 1;
            }
        }
    }
    assert!(files > 100, "{files}");
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
