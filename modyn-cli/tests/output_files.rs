//! Output files: inputs and files of others are kept, devices and pipes are written, and no file is half written.

use std::fs;
use std::path::Path;

use crate::common::modyn;

const ARM: &str = include_str!("../../robots/double_pendulum.urdf");

/// Returns a folder with the description `a.urdf`, and a function from names to paths.
fn folder() -> (tempfile::TempDir, impl Fn(&str) -> String) {
    let folder = tempfile::tempdir().expect("a folder");
    let root = folder.path().to_owned();
    let path = move |name: &str| root.join(name).to_string_lossy().into_owned();
    fs::write(path("a.urdf"), ARM).expect("a description");
    (folder, path)
}

#[test]
fn inputs_are_not_overwritten() {
    let (_folder, path) = folder();
    let robot = path("a.urdf");
    let motion = path("m.csv");
    assert_eq!(modyn(&["simulate", &robot, "--time", "0.1", "--csv", &motion]).code, 0);
    let written = fs::read(&motion).expect("a table");
    let overwriting: [&[&str]; 7] = [
        &["generate", &robot, "-o", &robot],
        &["generate", &robot, "--target", "c", "-o", &path("b.c"), "--c-header", &robot],
        &["view", &robot, "-o", &robot],
        &["view", &robot, "--motion", &motion, "-o", &motion],
        &["simulate", &robot, "--time", "0.1", "--csv", &robot],
        &["inspect", &robot, "--svg", &robot],
        &["convert", &robot, &robot],
    ];
    for arguments in overwriting {
        let output = modyn(arguments);
        assert_eq!(output.code, 2, "{arguments:?}: {}", output.err);
        assert_eq!(fs::read_to_string(&robot).expect("the description"), ARM, "{arguments:?}");
        assert_eq!(fs::read(&motion).expect("the motion"), written, "{arguments:?}");
    }
    let error = modyn(&["convert", &robot, &robot]).err;
    assert!(error.contains("it is an input, which would be overwritten"), "{error}");
}

#[test]
fn files_of_others_are_kept() {
    let (_folder, path) = folder();
    let robot = path("a.urdf");
    let mine = "a file of somebody else";
    for arguments in [
        &["convert", &*robot, &path("b.urdf")][..],
        &["simulate", &robot, "--time", "0.1", "--csv", &path("b.csv")],
        &["simulate", &robot, "--time", "0.1", "--plot", &path("b.svg")],
        &["simulate", &robot, "--time", "0.1", "--csv", &path("c.csv"), "--html", &path("b.html")],
        &["inspect", &robot, "--svg", &path("b.svg")],
        &["view", &robot, "-o", &path("b.html")],
    ] {
        let file = arguments[arguments.len() - 1];
        fs::write(file, mine).expect("a file");
        let output = modyn(arguments);
        assert_eq!(output.code, 2, "{arguments:?}: {}", output.err);
        assert!(output.err.contains("modyn did not write"), "{arguments:?}: {}", output.err);
        assert_eq!(fs::read_to_string(file).expect("the file"), mine, "{arguments:?}");
        // Nothing is half done, as the table beside a page.
        assert!(!Path::new(&path("c.csv")).exists());
        // As the help says, and then again over the file of modyn.
        fs::remove_file(file).expect("removed");
        for _ in 0..2 {
            assert_eq!(modyn(arguments).code, 0, "{arguments:?}");
        }
        fs::remove_file(file).expect("removed");
        let _ = fs::remove_file(path("c.csv"));
    }
    fs::write(path("main.rs"), mine).expect("a file");
    let kept = modyn(&["compare", &robot, "--rustc", "--keep", &path("")]);
    assert!(kept.code == 2 && kept.err.contains("modyn did not write"), "{}", kept.err);
    assert_eq!(fs::read_to_string(path("main.rs")).expect("the file"), mine);
    let header = "my own header";
    fs::write(path("arm.h"), header).expect("a file");
    let object = ["generate", &*robot, "--target", "object", "-o", &path("arm.o")];
    let output = modyn(&object);
    assert_eq!(output.code, 2);
    assert!(output.err.contains("modyn did not write the file that is there"), "{}", output.err);
    assert_eq!(fs::read_to_string(path("arm.h")).expect("the file"), header);
    assert!(!Path::new(&path("arm.o")).exists(), "all files are written, or none");
    // As the help says.
    fs::remove_file(path("arm.h")).expect("removed");
    for _ in 0..2 {
        assert_eq!(modyn(&object).code, 0);
    }
    fs::write(path("robot.rs"), "mod robot;").expect("a file");
    let output = modyn(&["generate", &robot, "-o", &path("robot.rs")]);
    assert_eq!(output.code, 2, "{}", output.err);
    assert!(output.err.contains("that modyn wrote"), "{}", output.err);
    // Generated files and empty ones are replaced.
    fs::write(path("empty.rs"), "").expect("a file");
    for more in [&[][..], &["--functions", "all"]] {
        for file in ["empty.rs", "other.c"] {
            let target = if file == "other.c" { "c" } else { "rust" };
            let arguments = ["generate", &robot, "--target", target, "-o", &path(file)];
            let output = modyn(&[&arguments[..], more].concat());
            assert_eq!(output.code, 0, "{file}: {}", output.err);
        }
    }
    assert!(fs::read_dir(path("")).expect("the folder").all(|entry| {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        !name.starts_with('.')
    }));
}

#[test]
#[cfg(unix)]
fn devices_pipes_and_links_are_written() {
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    let (_folder, path) = folder();
    let robot = path("a.urdf");
    // A full device is not read.
    if Path::new("/dev/full").exists() {
        assert_eq!(modyn(&["generate", &robot, "-o", "/dev/full"]).code, 2);
    }
    let expected = modyn(&["generate", &robot]).out;
    for arguments in [&["generate", &*robot, "-o", "-"][..], &["simulate", &robot, "--csv", "-"]] {
        let output = modyn(arguments);
        assert_eq!(output.code, 0, "{}", output.err);
        assert!(!output.out.is_empty() && (arguments[0] != "generate" || output.out == expected));
    }
    let convert = |out: &str| assert_eq!(modyn(&["convert", &robot, out, "--to", "urdf"]).code, 0);
    // A link stays a link, and a file keeps its permissions.
    symlink(path("real.urdf"), path("link.urdf")).expect("a link");
    convert(&path("real.urdf"));
    fs::set_permissions(path("real.urdf"), fs::Permissions::from_mode(0o640)).expect("set");
    fs::write(path("real.urdf"), "").expect("a file");
    convert(&path("link.urdf"));
    assert!(fs::symlink_metadata(path("link.urdf")).expect("the link").is_symlink());
    let real = fs::metadata(path("real.urdf")).expect("the file");
    assert!(real.len() > 100 && real.permissions().mode() & 0o777 == 0o640);
}

#[test]
fn names_cannot_control_terminals() {
    let (_folder, path) = folder();
    let name = "a\u{9b}2J\u{202e}b";
    fs::write(path("c1.urdf"), ARM.replacen("double_pendulum", name, 1)).expect("a description");
    for arguments in [
        &["convert", &*path("c1.urdf"), "-", "--to", "urdf"][..],
        &["inspect", &path("c1.urdf"), "--json"],
        &["check", &path("c1.urdf"), "--json"],
        &["view", &path("c1.urdf"), "-o", "-"],
        &["simulate", &path("c1.urdf"), "--time", "0.1", "--plot", "-"],
        &["inspect", &path("c1.urdf"), "--svg", "-"],
    ] {
        let output = modyn(arguments);
        assert_eq!(output.code, 0, "{}", output.err);
        assert!(!output.out.contains(['\u{9b}', '\u{202e}']), "{arguments:?}");
    }
    let converted = modyn(&["convert", &path("c1.urdf"), "-", "--to", "urdf"]).out;
    assert!(converted.contains("a&#155;2J&#8238;b"), "{converted}");
}
