//! One case for each error that a user can make through the macro. rustc compiles the cases itself, against the crate
//! `modyn` as Cargo has built it, so that nothing is built for them. `MODYN_UI=overwrite` renews the expected messages.

use std::ffi::OsString;
use std::fs::DirEntry;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};
use std::{env, fs, thread};

use modyn_codegen::diagnostics::Code;

/// The kinds of diagnostics that no input of the macro causes, and those that are only warnings.
const ELSEWHERE: &[Code] = &[
    Code::IllConditioned,
    Code::Output,
    Code::InvalidModel,
    Code::InvalidProgram,
    Code::TooLarge,
    Code::AxisLength,
    Code::InvertedLimits,
    Code::MimicMultiplier,
    Code::NotMjcf,
    Code::NotSdf,
    Code::Sdf,
    Code::Mjcf,
    Code::Include,
    Code::MissingLimit,
    Code::NegativeLimit,
    Code::EmptyRange,
    Code::ZeroLimit,
    Code::LimitUnit,
    Code::LengthUnit,
    Code::InactiveFriction,
    Code::MissingInertial,
    Code::ImplausibleMass,
    Code::XacroWarning,
    Code::Inexpressible,
];

/// Returns the folder of this package, where rustc runs: rustc then prints paths relative to it, as users see them.
fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the `.rs` files of a folder under `ui/`, by name.
fn cases(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry"));
    let mut cases: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    cases.retain(|case| case.extension().is_some_and(|extension| extension == "rs"));
    cases.sort();
    cases
}

/// Returns the compiled crate `modyn`, which Cargo has built for these tests. Builds of other features can be beside it: the
/// last one is that of this run, or has the same sources.
fn modyn() -> &'static Path {
    static ONCE: OnceLock<PathBuf> = OnceLock::new();
    ONCE.get_or_init(|| {
        let own = env::current_exe().expect("a path");
        let files = fs::read_dir(own.parent().expect("a folder")).expect("a folder");
        let files = files.map(|file| file.expect("an entry"));
        let is_modyn = |name: &str| name.starts_with("libmodyn-") && name.ends_with(".rlib");
        let built = files.filter(|file| is_modyn(&file.file_name().to_string_lossy()));
        let time =
            |file: &DirEntry| file.metadata().and_then(|data| data.modified()).expect("a time");
        built.max_by_key(time).expect("a library").path()
    })
}

/// Returns rustc's command for a case, as Cargo calls it.
fn rustc(case: &Path) -> Command {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let mut library = OsString::from("modyn=");
    library.push(modyn());
    let mut dependencies = OsString::from("dependency=");
    dependencies.push(modyn().parent().expect("a folder"));
    let mut command = Command::new(rustc);
    command
        .current_dir(folder())
        .env("CARGO_MANIFEST_DIR", folder())
        .args(["--edition=2024", "--color=never", "--extern"])
        .arg(library)
        .arg("-L")
        .arg(dependencies)
        .arg(case.strip_prefix(folder()).expect("a case of this package"));
    command
}

/// Returns rustc's messages without its closing remarks, and without line numbers of the library.
fn messages(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr);
    let remarks = ["error: aborting due to ", "For more information about ", "Some errors have "];
    let lines = text.lines().filter(|line| !remarks.iter().any(|start| line.starts_with(start)));
    let place = |line| match str::split_once(line, ".rs:") {
        Some((file, _)) if file.trim_start().starts_with("--> modyn-runtime/") => {
            format!("{file}.rs")
        }
        _ => line.to_owned(),
    };
    lines.map(place).collect::<Vec<_>>().join("\n").trim_end().to_owned() + "\n"
}

/// Runs `check` on all cases in parallel, and fails with all complaints.
fn check_all(cases: &[PathBuf], check: impl Fn(&Path) -> Result<(), String> + Sync) {
    assert!(!cases.is_empty());
    let (next, complaints) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            if let Err(complaint) = check(case) {
                complaints
                    .lock()
                    .expect("no panic")
                    .push(format!("{}: {complaint}", case.display()));
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    let complaints = complaints.into_inner().expect("no panic");
    assert!(complaints.is_empty(), "{}", complaints.join("\n\n"));
}

#[test]
fn errors_are_shown_as_expected() {
    let overwrite = env::var_os("MODYN_UI").is_some_and(|value| value == "overwrite");
    check_all(&cases(&folder().join("ui")), |case| {
        let output = rustc(case).args(["--emit=metadata", "-o", "-"]).output().expect("rustc runs");
        if output.status.success() {
            return Err("it compiles".into());
        }
        let (found, file) = (messages(&output), case.with_extension("stderr"));
        if overwrite {
            fs::write(file, found).expect("a file");
            return Ok(());
        }
        let expected = fs::read_to_string(file).unwrap_or_default();
        if expected == found {
            return Ok(());
        }
        Err(format!("expected\n{expected}\nfound\n{found}"))
    });
}

#[test]
fn good_cases_compile_and_run() {
    check_all(&cases(&folder().join("ui/pass")), |case| {
        let name = case.file_stem().expect("a name");
        let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let built = rustc(case).arg("-o").arg(&program).output().expect("rustc runs");
        // The macro may warn about descriptions; warnings of rustc are errors in these cases.
        if !built.status.success() {
            return Err(messages(&built));
        }
        let run = Command::new(&program).output().expect("it runs");
        if run.status.success() { Ok(()) } else { Err(messages(&run)) }
    });
}

#[test]
fn every_kind_of_error_has_a_case() {
    for code in Code::ALL.iter().filter(|code| !ELSEWHERE.contains(code)) {
        let expected = fs::read_to_string(folder().join(format!("ui/{code}.stderr")));
        let expected = expected.unwrap_or_else(|_| panic!("no case for {code}"));
        assert!(expected.contains(&format!(" [{code}]\n")), "{code}");
    }
}
