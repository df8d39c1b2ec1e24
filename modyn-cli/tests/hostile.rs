//! Names may contain any characters, and they are escaped in every output.
#![cfg(feature = "command")]

use crate::common;

use common::{command, run};
use roxmltree::Document;

/// A robot with hostile names.
const ROBOT: &str =
    "<robot name='&lt;script&gt;alert(1)&lt;/script&gt;&#x9b;31m &amp;amp; __MOTION__'>
  <link name='base'/>
  <joint name='=HYPERLINK(\"x\"),\"&#10;' type='continuous'>
    <parent link='base'/><child link=']]&gt;&lt;b&gt;\u{202e}&#x9d;0;x&#x9c;'/><axis xyz='0 1 0'/>
  </joint>
  <link name=']]&gt;&lt;b&gt;\u{202e}&#x9d;0;x&#x9c;'>
    <inertial>
      <origin xyz='0 0 -0.5'/><mass value='1'/>
      <inertia ixx='0.1' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'/>
    </inertial>
  </link>
</robot>";

/// Runs the command on the robot, with colours as in a terminal.
fn modyn(arguments: &[&str]) -> (String, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.urdf");
    std::fs::write(&path, ROBOT).expect("writes");
    let mut command = command(arguments);
    command.arg(&path).env("CLICOLOR_FORCE", "1").env_remove("NO_COLOR");
    let found = run(command);
    assert_eq!(found.code, 0, "{arguments:?}: {}", found.err);
    (found.out, found.err)
}

/// Returns whether the text contains no escape sequence of a terminal except colours.
fn is_tame(text: &str) -> bool {
    let mut rest = text;
    while let Some(at) = rest.find('\u{1b}') {
        rest = &rest[at + 1..];
        let Some(parameters) = rest.strip_prefix('[') else { return false };
        let end = parameters.find(|c: char| !c.is_ascii_digit() && c != ';');
        if end.and_then(|end| parameters[end..].chars().next()) != Some('m') {
            return false;
        }
    }
    let allowed = |c: char| matches!(c, '\n' | '\u{1b}') || !c.is_control();
    text.chars().all(|c| allowed(c) && c != '\u{202e}') && !text.contains("\u{1b}[31m ")
}

#[test]
fn a_terminal_is_not_commanded() {
    let base: &[&str] = &["--base", "fixed"];
    for arguments in [&["check"][..], &["inspect"], &["compare", "--functions", "mass_matrix"]] {
        let (out, err) = modyn(&[arguments, base].concat());
        assert!(is_tame(&out) && is_tame(&err), "{out:?}{err:?}");
        assert!(out.contains('\u{fffd}') || arguments == ["check"], "{out}");
    }
    assert!(!is_tame("\u{1b}]0;x") && !is_tame("\u{7}") && is_tame("\u{1b}[1mx\u{1b}[0m\n"));
    // Error messages contain the names, too.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.urdf");
    std::fs::write(&path, ROBOT.replace("mass value='1'", "mass value='-1'")).expect("writes");
    let mut bad = command(&["check"]);
    bad.arg(&path).env("CLICOLOR_FORCE", "1");
    let found = run(bad);
    assert!(found.code == 1 && found.out.contains("negative-mass") && is_tame(&found.out));
    // So does the quoted line of a file that is not XML.
    std::fs::write(&path, ROBOT.replace("<mass", "\u{1b}]0;x\u{7}<<mass")).expect("writes");
    let mut bad = command(&["check"]);
    bad.arg(&path).env("CLICOLOR_FORCE", "1");
    let found = run(bad);
    assert!(found.code == 1 && found.out.contains("malformed-xml"), "{}", found.out);
    assert!(found.out.contains("0;x") && is_tame(&found.out), "{:?}", found.out);
}

#[test]
fn written_files_are_well_formed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("a file");
    modyn(&["inspect", "--svg", &path("a.svg")]);
    modyn(&[
        "simulate",
        "--time",
        "0.1",
        "--html",
        &path("a.html"),
        "--plot",
        &path("b.svg"),
        "--csv",
        &path("a.csv"),
    ]);
    modyn(&["generate", "-o", &path("a.rs"), "--self-contained", "--c-header", &path("a.h")]);
    for name in ["a.svg", "b.svg"] {
        let text = read(name);
        let svg = Document::parse(&text).expect("XML");
        assert!(
            svg.descendants().all(|node| !node.has_tag_name("script") && !node.has_tag_name("b"))
        );
        assert!(text.contains("&lt;script&gt;"), "{name}");
    }
    let html = read("a.html");
    // The page's own two scripts, and no others.
    assert_eq!(html.matches("<script").count(), 2);
    assert_eq!(html.matches("</script").count(), 2);
    assert!(html.contains("<title>&lt;script&gt;alert(1)"));
    let table = read("a.csv");
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let head = reader.headers().expect("a head").clone();
    assert!(head.iter().all(|cell| !cell.starts_with('=') && !cell.contains('\n')), "{head:?}");
    assert!(reader.records().all(|row| row.expect("a row").len() == head.len()));
    let (json, _) = modyn(&["inspect", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["joints"][0]["name"], "=HYPERLINK(\"x\"),\"\n");
    for name in ["a.rs", "a.h"] {
        assert!(is_tame(&read(name)), "{name}");
    }
}
