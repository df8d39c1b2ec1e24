//! Crates outside the workspace, as users have them: each is built by its own call of Cargo.
//!
//! All of them share one target folder, so that their dependencies are built once; the workspace's `Cargo.lock` beside
//! each one pins the versions. The slow ones are ignored unless `-- --include-ignored` is given, as `lab/check` does.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Instant;

const FIRMWARE: &str = "thumbv7em-none-eabihf";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace")
}

/// Returns the folder of a crate, with the workspace's versions.
fn user_crate(name: &str) -> PathBuf {
    let folder = root().join("tests/crates").join(name);
    pin(&folder);
    folder
}

fn pin(folder: &Path) {
    std::fs::copy(root().join("Cargo.lock"), folder.join("Cargo.lock")).expect("a lock file");
}

/// Runs Cargo in a folder as a user does: the variables of the outer Cargo are removed.
fn cargo(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO"));
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy();
        let kept = ["CARGO_HOME", "CARGO_INCREMENTAL"].contains(&&*name);
        if (name.starts_with("CARGO") && !kept) || name == "RUSTFLAGS" {
            command.env_remove(&*name);
        }
    }
    // trybuild's folder: one build of the compiler serves both.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../tests/trybuild");
    let arguments = arguments.split_whitespace();
    command.current_dir(folder).args(arguments).arg("--target-dir").arg(target);
    command.args(["--jobs", "2"]).env("CARGO_TERM_COLOR", "never");
    // Without debug information builds take half the time and little disk; the test of debug information sets it.
    command.env("CARGO_PROFILE_DEV_DEBUG", "0");
    command.output().expect("Cargo runs")
}

fn text(output: &Output) -> String {
    [&output.stdout[..], &output.stderr].map(String::from_utf8_lossy).concat()
}

/// Returns the output of a run that must succeed.
fn succeeds(folder: &Path, arguments: &str) -> String {
    let output = cargo(folder, arguments);
    assert!(output.status.success(), "cargo {arguments}: {}", text(&output));
    text(&output)
}

/// Returns the output of a run that must fail.
fn fails(folder: &Path, arguments: &str) -> String {
    let output = cargo(folder, arguments);
    assert!(!output.status.success(), "cargo {arguments}: {}", text(&output));
    text(&output)
}

/// Returns whether a tool's output lists `what`; false if the tool is not installed.
fn has(command: &str, arguments: &[&str], what: &str) -> bool {
    let output = Command::new(command).args(arguments).output();
    let found = output.is_ok_and(|output| {
        output.status.success() && String::from_utf8_lossy(&output.stdout).contains(what)
    });
    if !found {
        eprintln!("left out: there is no {what}");
    }
    found
}

#[test]
fn without_the_standard_library() {
    let folder = user_crate("no-std");
    succeeds(&folder, "build");
    if has("rustup", &["target", "list", "--installed"], FIRMWARE) {
        succeeds(&folder, &format!("build --target {FIRMWARE}"));
    }
}

#[test]
#[ignore = "slow: rustc, clippy and rustdoc on all functions"]
fn with_the_strictest_lints() {
    let folder = user_crate("strict");
    succeeds(&folder, "test");
    if has(env!("CARGO"), &["clippy", "--version"], "clippy") {
        succeeds(&folder, "clippy --all-targets");
    }
    let docs = succeeds(&folder, "doc --no-deps");
    // The warnings about the description are in the output as well: those of the build script, and those that begin
    // with the description's file.
    let of_rustdoc =
        |line: &str| line.starts_with("warning") && !line.starts_with("warning: user-strict@");
    assert!(!docs.lines().any(of_rustdoc), "{docs}");
}

#[test]
fn under_another_name() {
    succeeds(&user_crate("renamed"), "test");
}

#[test]
fn by_a_build_script() {
    let folder = user_crate("build-script");
    let output = succeeds(&folder, "test");
    // Cargo repeats the warnings of a build script that it does not run again.
    assert!(output.contains("odd.urdf:4:54: warning[axis-length]: joint `pivot`"), "{output}");
}

/// The example has a function of its own, a cost, with derivatives.
#[test]
fn the_example_with_a_build_script() {
    let folder = root().join("examples/build-script");
    pin(&folder);
    succeeds(&folder, "test");
}

/// The robots' machine code is in a static library, which this crate's tests link through the crate of the robots.
#[test]
#[ignore = "slow: the compiler and its back end, unoptimised"]
#[cfg(target_arch = "x86_64")]
fn in_object_files() {
    succeeds(&user_crate("object"), "test");
}

#[test]
#[ignore = "slow: debug information of a long text"]
fn the_largest_robot_with_debug_information() {
    let folder = user_crate("humanoid");
    // With debug information rustc is slow on long functions, or crashes.
    for profile in ["dev", "release"] {
        let arguments = format!("build --profile {profile} --config profile.{profile}.debug=true");
        succeeds(&folder, &format!("{arguments} -p modyn"));
        let start = Instant::now();
        succeeds(&folder, &arguments);
        // There is no limit, because machines differ. `--nocapture` shows the time.
        println!("cargo {arguments} of the humanoid: {:.1} s", start.elapsed().as_secs_f64());
    }
}

#[test]
#[ignore = "slow: link-time optimisation at four levels"]
#[cfg(unix)] // It links against the C library.
fn no_path_panics() {
    let folder = user_crate("no-panic");
    for level in ["3", "\"s\"", "1"] {
        succeeds(&folder, &format!("build --release --config profile.release.opt-level={level}"));
    }
    let output = fails(&folder, "build --release --features panics");
    assert!(output.contains("a_function_of_modyn_can_panic"), "{output}");
}

/// Returns the folder of a new crate that depends on `modyn` only.
fn new_crate(name: &str, source: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // The file can be there from an earlier run.
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("src")).expect("a folder");
    let manifest = format!(
        "[package]\nname = {name:?}\nedition = \"2024\"\n\
         [dependencies]\nmodyn = {{ path = {:?} }}\n[workspace]\n",
        root()
    );
    std::fs::write(folder.join("Cargo.toml"), manifest).expect("a file");
    std::fs::write(folder.join("src/lib.rs"), source).expect("a file");
    pin(&folder);
    folder
}

const PENDULUM: &str = include_str!("../crates/renamed/robots/my-pendulum.urdf");

#[test]
fn the_crate_follows_its_description() {
    let folder = new_crate("user-rebuilt", "modyn::modyn!(pub Robot = \"robot.urdf\");\n");
    let missing = fails(&folder, "build");
    assert!(missing.contains("tried `src/robot.urdf`, `robot.urdf`"), "{missing}");
    // The description is written, changed, made invalid, and replaced by a file beside the source.
    let file = folder.join("robot.urdf");
    let write = |file: &Path, text: &str| {
        // Some file systems store times in whole seconds.
        std::thread::sleep(std::time::Duration::from_millis(1100));
        std::fs::write(file, text).expect("a file");
    };
    write(&file, PENDULUM);
    succeeds(&folder, "build");
    let rebuilt = || {
        let output = cargo(&folder, "build --verbose");
        (output.status.success(), text(&output))
    };
    let (_, output) = rebuilt();
    assert!(output.contains("Fresh user-rebuilt"), "{output}");
    write(&file, &PENDULUM.replace("0 1 0", "0 2 0"));
    let (good, output) = rebuilt();
    assert!(good && output.contains("robot.urdf:4:54: warning[axis-length]"), "{output}");
    // Cargo repeats the macro's messages, as it repeats warnings.
    let (good, output) = rebuilt();
    assert!(good && output.contains("Fresh user-rebuilt"), "{output}");
    assert!(output.contains("robot.urdf:4:54: warning[axis-length]"), "{output}");
    write(&file, &PENDULUM.replace("value=\"1\"", "value=\"-1\""));
    let (good, output) = rebuilt();
    assert!(!good && output.contains("robot.urdf:8:"), "{output}");
    write(&folder.join("src/robot.urdf"), PENDULUM);
    let (good, output) = rebuilt();
    assert!(good, "{output}");
}

#[test]
fn doc_tests_find_the_description_by_the_folder_of_the_crate() {
    let source = "//! ```\n//! modyn::modyn!(\"robot.urdf\");\n//! assert_eq!(MyPendulum::NV, 1);\n//! ```\n\
                  //! ```compile_fail\n//! modyn::modyn!(\"none.urdf\");\n//! ```\n";
    let folder = new_crate("user-documented", source);
    std::fs::write(folder.join("robot.urdf"), PENDULUM).expect("a file");
    let output = succeeds(&folder, "test --doc");
    assert_eq!(output.matches("1 passed; 0 failed").count(), 2, "{output}");
}

#[test]
fn a_member_of_a_workspace() {
    let source = "modyn::modyn!(\"robot.urdf\");\nmodyn::modyn!(Shared = \"../robot.urdf\");\n";
    let folder = new_crate("user-workspace", "");
    let member = folder.join("member");
    std::fs::create_dir_all(member.join("src")).expect("a folder");
    let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).expect("a file");
    let write = |path: &str, text: &str| std::fs::write(folder.join(path), text).expect("a file");
    write(
        "member/Cargo.toml",
        &manifest.replace("user-workspace", "member").replace("[workspace]", ""),
    );
    write("member/src/lib.rs", source);
    write("member/src/robot.urdf", PENDULUM);
    write("robot.urdf", PENDULUM);
    write("Cargo.toml", "[workspace]\nmembers = [\"member\"]\nresolver = \"3\"\n");
    succeeds(&folder, "build");
    succeeds(&member, "build");
}

/// Returns the text of a page's first block of code in `language` after `mark`.
fn block<'a>(page: &'a str, mark: &str, language: &str) -> &'a str {
    let (_, rest) = page.split_once(mark).unwrap_or_else(|| panic!("no {mark}"));
    let (_, rest) = rest.split_once(&format!("```{language}\n")).expect("a block of code");
    rest.split_once("```").expect("the end of a block").0
}

fn page(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).expect("a page")
}

#[test]
fn the_first_program_prints_the_output_in_the_readme() {
    let readme = page("README.md");
    let folder = new_crate("reach", "");
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("a file");
    std::fs::create_dir_all(folder.join("robots")).expect("a folder");
    write("robots/arm7.urdf", &page("robots/arm7.urdf"));
    write("src/main.rs", block(&readme, "`src/main.rs`", "rust"));
    let printed = succeeds(&folder, "run");
    let expected = block(&readme, "`cargo run --release` prints", "text");
    // The last line is a time.
    let (expected, time) = expected.split_once("forward dynamics:").expect("a time");
    assert!(printed.contains(expected) && time.ends_with(" ns\n"), "{printed}");
}

#[test]
fn the_program_of_the_start_page_runs() {
    let start = page("docs/start.md");
    let folder = new_crate("swing", "");
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("a file");
    write("pendulum.urdf", block(&start, "`pendulum.urdf`", "xml"));
    write("src/main.rs", block(&start, "`src/main.rs`", "rust,ignore"));
    let printed = succeeds(&folder, "run");
    assert!(printed.contains("torque that holds it: 1.1758 N m"), "{printed}");
}
