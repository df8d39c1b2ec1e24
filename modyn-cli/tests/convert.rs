//! `modyn convert`: formats, notes and exit codes. The robots themselves are compared by the compiler's tests.

use crate::common;

use common::modyn;

#[test]
fn every_robot_becomes_a_urdf_and_an_mjcf_that_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    for robot in ["arm7", "humanoid", "four_bar", "mimic_gripper", "joint_zoo"] {
        for ending in ["urdf", "xml"] {
            let out = folder.path().join(format!("{robot}.{ending}"));
            let out = out.to_str().expect("UTF-8");
            let input = format!("robots/{robot}.urdf");
            let found = modyn(&["convert", &input, out]);
            // The loop of the four-bar linkage is a hinge.
            if (robot, ending) == ("four_bar", "xml") {
                assert_eq!(found.code, 1, "{}", found.err);
                assert!(found.err.contains("error[inexpressible]"), "{}", found.err);
                assert!(found.err.contains("is revolute, and MJCF has words for"), "{}", found.err);
                continue;
            }
            assert_eq!((found.code, &*found.out), (0, ""), "{}", found.err);
            let text = std::fs::read_to_string(out).expect("a text");
            assert!(text.contains("<!-- Written by modyn"), "{text}");
            for note in found.err.lines().filter_map(|line| line.strip_prefix("note: ")) {
                assert!(text.contains(note), "{note}\n{text}");
            }
            let checked = modyn(&["check", out]);
            assert_eq!(checked.code, 0, "{}", checked.out);
        }
    }
}

#[test]
fn the_format_is_that_of_the_ending_or_of_the_option() {
    let out = modyn(&["convert", "robots/arm7.urdf", "-", "--to", "mjcf"]);
    assert!(out.code == 0 && out.out.contains("<mujoco model=\"arm7\">"), "{}{}", out.out, out.err);
    let out = modyn(&["convert", "robots/arm7.urdf", "-"]);
    assert!(out.code == 2 && out.err.contains("add `--to urdf` or `--to mjcf`"), "{}", out.err);
    let out = modyn(&["convert", "modyn-read/tests/bad/cycle.urdf", "-", "--to", "urdf"]);
    assert!(out.code == 1 && out.err.contains("error[cycle]"), "{}", out.err);
    let gravity = ["--gravity", "[0, 0, -1.62]"];
    let out =
        modyn(&[&["convert", "robots/arm7.urdf", "-", "--to", "urdf"][..], &gravity].concat());
    let note = "note: The format has no gravity: read the robot with the option `gravity = [0, 0, -1.62]`.";
    assert!(out.code == 0 && out.err.contains(note), "{}", out.err);
}
