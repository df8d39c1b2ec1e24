//! Runs the command in tests.

#![allow(dead_code)] // Each test file uses some of these functions.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// The result of a run of the command.
pub struct Output {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl Output {
    /// Returns standard output as JSON.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {}{}", self.out, self.err))
    }
}

/// Returns the root folder of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns the command, with the repository's root as the working folder.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_modyn"));
    command.args(arguments).current_dir(root()).env_remove("CLICOLOR_FORCE");
    command
}

/// Runs the command.
pub fn run(mut command: Command) -> Output {
    let output = command.output().expect("the command runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    let code = output.status.code().expect("an exit code");
    Output { code, out: text(output.stdout), err: text(output.stderr) }
}

/// Runs `modyn` with these arguments.
pub fn modyn(arguments: &[&str]) -> Output {
    run(command(arguments))
}

/// Returns the descriptions in a folder of the reader's tests, with the options that they declare.
pub fn descriptions(folder: &str) -> Vec<(String, Vec<String>)> {
    let place = format!("modyn-read/tests/{folder}");
    let mut all: Vec<_> = std::fs::read_dir(root().join(&place))
        .expect("a folder")
        .map(|entry| {
            let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
            let path = format!("{place}/{name}");
            let text = std::fs::read_to_string(root().join(&path)).expect("UTF-8");
            let options = text.split("<!-- OPTIONS ").nth(1).and_then(|t| t.split(" -->").next());
            let flags = options.into_iter().flat_map(|options| options.split(", ")).map(|option| {
                let (name, value) = option.split_once(" = ").expect("an option");
                format!("--{}={value}", name.replace('_', "-"))
            });
            (path, flags.collect())
        })
        .collect();
    all.sort();
    assert!(all.len() >= 20, "{folder}");
    all
}

/// Compares a text with a file of this crate; with the variable `UPDATE_SNAPSHOTS`, writes that file instead.
pub fn assert_snapshot(name: &str, found: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots").join(name);
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(&path, found).expect("a snapshot is written");
    }
    let expected = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
    assert_eq!(found, expected, "{name} is not as it was; UPDATE_SNAPSHOTS=1 takes it as it is");
}

/// Returns the data in a page of the viewer.
pub fn page_data(html: &str) -> Value {
    let mark = "<script type=\"application/json\" id=\"data\">";
    let data = html.split(mark).nth(1).and_then(|rest| rest.split("</script>").next());
    serde_json::from_str(data.expect("the data")).expect("JSON")
}
