//! `modyn check`: exit codes, displayed text, JSON.
#![cfg(feature = "command")]

use crate::common;

use common::{assert_snapshot, command, descriptions, modyn, run};

/// Returns whether the command expands a file first: the cases of URDF hold for the text itself.
fn is_xacro(path: &str) -> bool {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    std::fs::read_to_string(folder.join(path)).is_ok_and(|text| text.contains("<xacro:"))
}

#[test]
fn every_bad_file_is_refused_with_its_line_and_a_caret() {
    for (path, flags) in descriptions("bad").into_iter().filter(|(path, _)| !is_xacro(path)) {
        let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
        let found = modyn(&[&["check", &path][..], &flags].concat());
        assert_eq!(found.code, 1, "{path}: {}{}", found.out, found.err);
        assert!(found.out.contains("error["), "{}", found.out);
        assert!(
            found.out.contains(&format!("{path}:")) && found.out.contains('^'),
            "{}",
            found.out
        );
        assert!(found.out.trim_end().lines().last().is_some_and(|l| l.contains("refused")));
        assert!(found.err.is_empty(), "{}", found.err);

        let json = modyn(&[&["check", &path, "--json"][..], &flags].concat());
        assert_eq!(json.code, 1, "{path}");
        let json = json.json();
        assert_eq!(json[0]["usable"], false);
        let all = json[0]["diagnostics"].as_array().expect("diagnostics");
        assert!(all.iter().any(|one| one["severity"] == "error"));
        for one in all {
            assert!(one["line"].as_u64().is_some_and(|line| line > 0), "{path}: {one}");
            assert!(one["help"].as_str().is_some_and(|help| !help.is_empty()), "{path}: {one}");
        }
    }
}

#[test]
fn every_good_file_is_usable() {
    let mut warned = 0;
    for (path, flags) in descriptions("good").into_iter().filter(|(path, _)| !is_xacro(path)) {
        let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
        let found = modyn(&[&["check", &path][..], &flags].concat());
        assert_eq!(found.code, 0, "{path}: {}{}", found.out, found.err);
        let warns = found.out.contains("warning[");
        let denied = modyn(&[&["check", "--deny-warnings", &path][..], &flags].concat());
        assert_eq!(denied.code, i32::from(warns), "{path}");
        warned += i32::from(warns);
    }
    assert!(warned > 0);
}

#[test]
fn all_that_is_wrong_is_shown() {
    let found = modyn(&["check", "modyn-read/tests/bad/everything_at_once.urdf"]);
    assert_snapshot("everything_at_once.txt", &found.out);
}

#[test]
fn several_files_have_an_answer_each() {
    let found = modyn(&["check", "--json", "robots/arm6.urdf", "modyn-read/tests/bad/cycle.urdf"]);
    assert_eq!(found.code, 1);
    let json = found.json();
    assert_eq!(json[0]["usable"], true);
    assert_eq!(json[1]["usable"], false);
}

#[test]
fn unreadable_and_refused_descriptions_have_different_exit_codes() {
    let missing = modyn(&["check", "robots/no_such.urdf"]);
    assert_eq!(missing.code, 2);
    assert!(missing.out.contains("error[missing-file]"), "{}", missing.out);
    assert_eq!(modyn(&["check", "robots"]).code, 2);
    assert_eq!(modyn(&["check"]).code, 2);
    assert_eq!(modyn(&["check", "robots/arm6.urdf", "--base", "flying"]).code, 2);
    assert_eq!(modyn(&["check", "robots/arm6.urdf", "--gravity", "1,2"]).code, 2);
    let armature = modyn(&["check", "robots/arm6.urdf", "--armature", "nobody: 1"]);
    assert_eq!(armature.code, 1);
    assert!(armature.out.contains("nobody"), "{}", armature.out);
}

#[test]
fn a_description_may_come_through_a_pipe() {
    let mut piped = command(&["check", "-"]);
    let file = std::fs::File::open(common::root().join("robots/gripper.urdf")).expect("a robot");
    piped.stdin(file);
    let found = run(piped);
    assert_eq!((found.code, &*found.out), (0, "standard input: usable\n"));
}

#[test]
fn a_line_of_a_million_characters_is_not_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("long.urdf");
    let text = format!(
        "<robot name='a'><link name='b'/>{}<link name='b'/></robot>",
        " ".repeat(1_000_000)
    );
    std::fs::write(&path, text).expect("writes");
    let found = modyn(&["check", &path.to_string_lossy()]);
    assert_eq!(found.code, 1);
    assert!(found.out.len() < 10_000 && found.out.contains(":1:100003"), "{}", found.out);
}

/// A collection is a table of all descriptions in a folder: parts of others, and robots in which nothing moves, are told apart.
#[test]
fn collections_are_tables() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    };
    let link = r#"<link name="a"/><joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>"#;
    let inertial = r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"#;
    write(
        "arm.urdf",
        &format!(r#"<robot name="r">{link}<link name="b">{inertial}</link></robot>"#),
    );
    let negative = inertial.replace("mass value=\"1\"", "mass value=\"-1\"");
    write(
        "bad.urdf",
        &format!(r#"<robot name="r">{link}<link name="b">{negative}</link></robot>"#),
    );
    write("arms/one.xml", r#"<mujoco model="m"><include file="../parts/body.xml"/></mujoco>"#);
    write(
        "parts/body.xml",
        r#"<mujoco><worldbody><body><joint class="c"/><geom size="1"/></body></worldbody></mujoco>"#,
    );
    write(
        "arms/two.xml",
        r#"<mujoco model="m"><default><default class="c"/></default><include file="../parts/body.xml"/></mujoco>"#,
    );
    write("parts/other.xml", "<mujocoinclude><body/></mujocoinclude>");
    write(
        "still.xml",
        r#"<mujoco model="m"><worldbody><body><geom size="1"/></body></worldbody></mujoco>"#,
    );
    write("package.xml", "<package/>");
    // The files of YARP configure programs.
    write("wrapper.xml", r#"<robot name="r"><device name="d" type="motor"/></robot>"#);
    write(".hidden/bad.urdf", "<robot/>");
    write("notes.txt", "<robot/>");
    let path = folder.path().display().to_string();
    let found = modyn(&["check", "--collection", "--json", &path]);
    assert_eq!(found.code, 1, "{}", found.err);
    let json = found.json();
    let verdicts: Vec<(String, String)> = json["files"]
        .as_array()
        .expect("files")
        .iter()
        .map(|file| {
            let text = |key: &str| file[key].as_str().expect("a text").to_owned();
            (text("file")[path.len() + 1..].replace('\\', "/"), text("verdict"))
        })
        .collect();
    let expected = [
        ("arm.urdf", "accepted"),
        ("arms/one.xml", "refused"),
        ("arms/two.xml", "accepted"),
        ("bad.urdf", "refused"),
        ("parts/body.xml", "part"),
        ("parts/other.xml", "part"),
        ("still.xml", "static"),
    ]
    .map(|(file, verdict)| (file.to_owned(), verdict.to_owned()));
    assert_eq!(verdicts, expected);
    assert_eq!(json["totals"]["mjcf"]["accepted"], 1);
    assert_eq!(json["totals"]["urdf"]["refused"], 1);
    let text = modyn(&["check", "--collection", &path]);
    assert_eq!(text.code, 1);
    assert!(text.out.contains("negative-mass: link `b`: "), "{}", text.out);
    assert!(text.out.contains("mjcf           1       1        1     2"), "{}", text.out);
    assert!(text.out.ends_with("2 other files are no descriptions.\n"), "{}", text.out);
    assert_eq!(modyn(&["check", "--collection", "robots/arm6.urdf"]).code, 2);
}
