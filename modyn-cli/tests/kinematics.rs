//! Robots whose links have no inertia: kinematic functions, and refusals of dynamics that say why.
#![cfg(feature = "command")]

use crate::common;

use common::modyn;

const ROBOT: &str = "modyn-read/tests/good/kinematics_only.urdf";

#[test]
fn a_robot_without_inertia_has_kinematics() {
    let checked = modyn(&["check", ROBOT]);
    assert!(
        checked.code == 0 && checked.out.contains("warning[kinematics-only]"),
        "{}",
        checked.out
    );

    let inspected = modyn(&["inspect", ROBOT, "--json"]);
    assert_eq!(inspected.code, 0, "{}", inspected.err);
    let json = inspected.json();
    assert!(json["has_dynamics"] == false && json["condition_number"].is_null(), "{json}");
    let names: Vec<&str> = json["functions"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|f| f["name"].as_str())
        .collect();
    assert!(names.contains(&"jacobian") && names.contains(&"regressor"), "{names:?}");
    assert!(
        !names.contains(&"forward_dynamics") && !names.contains(&"center_of_mass"),
        "{names:?}"
    );
    let inspected = modyn(&["inspect", ROBOT, "--functions", "default"]);
    assert!(inspected.code == 0 && inspected.out.contains("has no dynamics"), "{}", inspected.err);

    let compared = modyn(&["compare", ROBOT]);
    assert!(
        compared.code == 0 && compared.out.contains("link_poses"),
        "{}{}",
        compared.out,
        compared.err
    );

    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("r.rs");
    let generated = modyn(&["generate", ROBOT, "-o", out.to_str().expect("UTF-8")]);
    assert_eq!(generated.code, 0, "{}", generated.err);
    let text = std::fs::read_to_string(out).expect("a text");
    assert!(
        text.contains("functions::Jacobian for") && !text.contains("functions::MassMatrix for")
    );
}

#[test]
fn dynamics_is_refused_by_name() {
    let named = ["generate", ROBOT, "-o", "-", "--functions", "[link_pose, mass_matrix]"];
    let simulated = ["simulate", ROBOT];
    let compared = ["compare", ROBOT, "--functions", "forward_dynamics"];
    for (arguments, message) in [
        (
            &named[..],
            "function `mass_matrix` needs inertia, and joints `shoulder`, `wrist` move none",
        ),
        (&simulated, "`simulate` needs dynamics, and joint `shoulder` moves no inertia"),
        (&compared, "function `forward_dynamics` needs inertia"),
    ] {
        let found = modyn(arguments);
        assert!(found.code != 0 && found.err.contains(message), "{arguments:?}: {}", found.err);
        assert!(found.err.contains("armature"), "{}", found.err);
    }
    let armature = r#"["shoulder": 1, "wrist": 1]"#;
    let simulated = modyn(&["simulate", ROBOT, "--time", "0.1", "--armature", armature]);
    assert_eq!(simulated.code, 0, "{}", simulated.err);
}
