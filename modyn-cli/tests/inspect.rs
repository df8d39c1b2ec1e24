//! `modyn inspect`: displayed text, JSON, the picture.
#![cfg(feature = "command")]

use crate::common;

use std::collections::BTreeMap;

use common::{assert_snapshot, modyn, root};
use roxmltree::Document;

#[test]
fn a_robot_is_shown() {
    let found = modyn(&["inspect", "robots/gripper.urdf"]);
    assert_eq!(found.code, 0, "{}", found.err);
    assert_snapshot("gripper.txt", &found.out);
}

/// Lines fit a terminal with any names. The costs of functions are shown with `--functions` only.
#[test]
fn lines_fit_a_hundred_columns() {
    for (robot, base) in [("humanoid", "floating"), ("arm7", "fixed"), ("mimic_gripper", "fixed")] {
        let path = format!("robots/{robot}.urdf");
        let plain = modyn(&["inspect", &path, "--base", base, "--joint-friction", "none"]).out;
        let with = modyn(&[
            "inspect",
            &path,
            "--base",
            base,
            "--joint-friction",
            "none",
            "--functions",
            "default",
        ])
        .out;
        assert!(
            !plain.contains("forward_dynamics") && with.contains("forward_dynamics"),
            "{plain}"
        );
        assert!(plain.starts_with(&format!("{robot}: ")), "{plain}");
        for line in with.lines() {
            assert!(line.chars().count() <= 100, "{line}");
        }
    }
}

#[test]
fn actuators_are_shown() {
    let actuators =
        ["left_slide: position(20, 0.5, effort = 3, saturation = 4, velocity = 2, delay = 2)"];
    let start = ["inspect", "robots/mimic_gripper.urdf", "--joint-friction", "none", "--actuators"];
    let text = modyn(&[&start[..], &actuators].concat()).out;
    let law = "20 ctrl - 20 x - 0.5 v; within -3 to 3; at most 4 (1 - v / 2); 2 steps late";
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words(&text).contains(law), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    let json = modyn(&[&start[..], &actuators, &["--json"]].concat()).json();
    let actuator = &json["actuators"][0];
    assert_eq!(
        (&actuator["moves"], &actuator["gain"]),
        (&"left_slide".into(), &[20.0, 0.0, 0.0][..].into())
    );
    assert_eq!(
        (actuator["no_load_speed"].as_f64(), actuator["delay"].as_u64()),
        (Some(2.0), Some(2))
    );
    let scene = "modyn-read/tests/good/extensions.urdf";
    assert!(!modyn(&["inspect", scene]).out.contains("Actuators"));
}

#[test]
fn json_and_terminal_have_the_same_content() {
    let found = modyn(&["inspect", "--json", "robots/mimic_gripper.urdf"]).json();
    assert_eq!(found["usable"], true);
    assert_eq!(found["nv"], 5);
    assert_eq!(found["coordinates"].as_array().map(Vec::len), Some(5));
    let follower = &found["joints"][5];
    assert_eq!(follower["mimic"]["joint"], "left_slide");
    assert_eq!(follower["q"], found["joints"][4]["q"]);
    assert_eq!(found["modules"][1]["parent"], 0);
    assert_eq!(found["modules"][0]["children"], serde_json::json!([1, 2]));
    let functions = found["functions"].as_array().expect("functions");
    let forward = functions.iter().find(|one| one["name"] == "forward_dynamics").expect("it");
    assert!(forward["operations"].as_u64() > Some(50));
    assert!(forward["estimated_code_bytes"].as_f64() > Some(1000.0));
    assert!((found["mass"].as_f64().expect("a mass") - 5.0).abs() < 1e-12);
}

/// The output says whether damping and friction act; with the option set, there is no warning.
#[test]
fn friction_that_does_not_act_is_said_to() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rubbing.urdf");
    let text = std::fs::read_to_string(root().join("robots/gripper.urdf")).expect("a robot");
    let dynamics = "<dynamics damping=\"0.7\" friction=\"0.2\"/></joint>";
    std::fs::write(&path, text.replacen("</joint>", dynamics, 1)).expect("written");
    let path = path.to_string_lossy();
    let shown = |friction: &[&str]| modyn(&[&["inspect", &*path], friction].concat()).out;
    let by_default = shown(&[]);
    let inactive = "damping 0.7 (does not act), friction 0.2 (does not act)";
    assert!(by_default.contains(inactive), "{by_default}");
    assert!(by_default.contains("warning[inactive-friction]"), "{by_default}");
    let chosen = shown(&["--joint-friction", "none"]);
    assert!(chosen.contains(inactive) && !chosen.contains("inactive-friction"), "{chosen}");
    let viscous = shown(&["--joint-friction", "viscous"]);
    assert!(viscous.contains("damping 0.7, friction 0.2 (does not act)"), "{viscous}");
    let coulomb = shown(&["--joint-friction", "coulomb"]);
    assert!(!coulomb.contains("does not act"), "{coulomb}");
    let json = modyn(&["inspect", "--json", &path, "--joint-friction", "viscous"]).json();
    let rubbing =
        json["joints"].as_array().expect("joints").iter().find(|one| one["damping"] == 0.7);
    let rubbing = rubbing.expect("the joint");
    assert_eq!(
        (&rubbing["damping_acts"], &rubbing["friction_acts"]),
        (&true.into(), &false.into())
    );
}

#[test]
fn a_refused_description_is_json_too() {
    let found = modyn(&["inspect", "--json", "modyn-read/tests/bad/negative_mass.urdf"]);
    assert_eq!(found.code, 1);
    assert_eq!(found.json()["diagnostics"][0]["code"], "negative-mass");
    let plain = modyn(&["inspect", "modyn-read/tests/bad/negative_mass.urdf"]);
    assert_eq!((plain.code, &*plain.out), (1, ""));
    assert!(plain.err.contains("error[negative-mass]"), "{}", plain.err);
}

#[test]
fn loops_are_shown_with_their_reason() {
    let derivatives = ["--functions", "forward_dynamics_derivatives"];
    let of = |robot: &[&str]| modyn(&[&["inspect"], robot, &derivatives].concat()).out;
    let shown = of(&["robots/humanoid.urdf", "--base", "floating"]);
    let words = shown.split_whitespace().collect::<Vec<_>>().join(" ");
    let wanted = "forward_dynamics_derivatives has products of matrices in loops, since they have 37940 multiplications";
    assert!(words.contains(wanted), "{words}");
    assert!(!of(&["robots/arm6.urdf"]).contains("loops"));
}

#[test]
fn the_picture_shows_modules_and_sparsity() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("gripper.svg");
    let found = modyn(&[
        "inspect",
        "robots/gripper.urdf",
        "--functions",
        "mass_matrix",
        "--svg",
        &path.to_string_lossy(),
    ]);
    assert_eq!(found.code, 0, "{}", found.err);
    let text = std::fs::read_to_string(path).expect("a picture");
    let svg = Document::parse(&text).expect("XML");
    let texts: Vec<&str> =
        svg.descendants().filter(|node| node.is_text()).filter_map(|node| node.text()).collect();
    for wanted in ["gripper", "base", "link11", "to link22", "U", "D"] {
        assert!(texts.contains(&wanted), "{wanted}: {texts:?}");
    }
    // The paper's gripper: fingers 2 and 3 share no joint, and U is zero below its blocks.
    let counts: Vec<&&str> = texts.iter().filter(|text| text.contains("are not zero")).collect();
    let expected = [12, 7, 6].map(|count| format!("{count} of 16 entries are not zero"));
    assert!(counts.iter().zip(&expected).all(|(a, b)| **a == b), "{counts:?}");
    assert_eq!(counts.len(), 3);
}

/// The README contains the picture that the command draws.
#[test]
fn the_readmes_picture_equals_the_drawn_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("humanoid.svg").to_string_lossy().into_owned();
    let robot = "robots/humanoid.urdf";
    let found = modyn(&["inspect", robot, "--functions", "mass_matrix", "--svg", &path]);
    assert_eq!(found.code, 0, "{}", found.err);
    let [drawn, shown] = [path.into(), root().join("docs/humanoid.svg")]
        .map(|path| std::fs::read_to_string(path).expect("a picture").replace("\r\n", "\n"));
    assert!(drawn == shown, "modyn inspect {robot} --svg docs/humanoid.svg");
}

#[test]
fn modules_are_the_users_choice() {
    let modules = |choice: &str| {
        let found = modyn(&["inspect", "--json", "robots/gripper.urdf", "--modules", choice]);
        (
            found.code,
            if found.code == 0 { found.json()["modules"].as_array().map(Vec::len) } else { None },
        )
    };
    assert_eq!(modules("chains"), (0, Some(3)));
    assert_eq!(modules("links"), (0, Some(4)));
    assert_eq!(modules(r#"[["link11"], ["link12"], ["link22"], ["link13"]]"#), (0, Some(4)));
    assert_eq!(modules(r#"[["link11"]]"#), (2, None));
    assert_eq!(modules("link11"), (2, None));
}

#[test]
fn probable_mistakes_are_warnings() {
    let link = |name: &str, mass: f64, center: f64, inertia: f64| {
        format!(
            "<joint name='j{name}' type='continuous'><parent link='base'/><child link='{name}'/>\
             <origin xyz='0.1 0 0.2'/></joint><link name='{name}'><inertial><origin xyz='{center} 0 0'/>\
             <mass value='{mass}'/><inertia ixx='{inertia}' iyy='{inertia}' izz='{inertia}' ixy='0' ixz='0' \
             iyz='0'/></inertial></link>"
        )
    };
    let urdf = format!(
        "<robot name='odd'><link name='base'/>{}{}{}{}{}</robot>",
        link("plain", 1.0, 0.1, 0.01),
        link("far", 1.0, 50.0, 0.01),
        link("wide", 1.0, 0.1, 100.0),
        link("tiny", 1.0, 0.1, 1e-12),
        link("light", 1e-7, 0.1, 1e-9),
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("odd.urdf");
    std::fs::write(&path, urdf).expect("writes");
    let path = path.to_string_lossy();
    let found = modyn(&["inspect", "--json", "--functions", "mass_matrix", &path]).json();
    let advice = found["advice"].as_array().expect("advice");
    let about = |name: &str| {
        let mine = advice.iter().filter(|one| one["link"] == name);
        mine.map(|one| one["message"].to_string()).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(about("plain"), "");
    for (name, what) in [
        ("far", "in metres?"),
        ("wide", "in kg m^2?"),
        ("tiny", "tiny"),
        ("light", "in kilograms?"),
    ] {
        assert!(about(name).contains(what), "{name}: {}", about(name));
    }
    // The robots of this repository have no findings.
    for robot in ["arm6", "arm7", "gripper", "quadruped", "mimic_gripper"] {
        let path = format!("robots/{robot}.urdf");
        let found = modyn(&["inspect", "--json", "--functions", "mass_matrix", &path]).json();
        let links: Vec<_> = found["advice"].as_array().expect("advice").iter().collect();
        assert!(links.is_empty(), "{robot}: {links:?}");
    }
}

#[test]
fn a_robot_too_large_for_code_is_inspected_all_the_same() {
    let mut urdf = String::from("<robot name='chain'><link name='0'/>");
    for i in 1..=200 {
        urdf += &format!(
            "<joint name='{i}' type='continuous'><parent link='{}'/><child link='{i}'/><origin xyz='0 0 1'/>\
             <axis xyz='1 0 0'/></joint><link name='{i}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' \
             ixy='0' ixz='0' iyz='0'/></inertial></link>",
            i - 1
        );
    }
    urdf += "</robot>";
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("chain.urdf");
    std::fs::write(&path, urdf).expect("writes");
    let path = path.to_string_lossy();
    let found = modyn(&["inspect", "--json", &path]);
    assert_eq!(found.code, 0, "{}", found.err);
    assert_eq!(found.json()["not_compiled"][0]["code"], "too-large");
    assert_eq!(modyn(&["generate", &path]).code, 1);
}

/// The estimate has the order of magnitude of the measured size in `docs/data/functions.tsv`; batches have no estimate.
#[test]
fn code_is_estimated_within_a_factor_of_two_and_a_half() {
    let table = std::fs::read_to_string(root().join("docs/data/functions.tsv")).expect("a table");
    let mut measured: BTreeMap<String, Vec<(String, f64)>> = BTreeMap::new();
    for row in table.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let [robot, function, _, _, _, kilobytes] = row.split('\t').collect::<Vec<_>>()[..] else {
            panic!("{row}")
        };
        let bytes = 1000.0 * kilobytes.parse::<f64>().expect("a number");
        if bytes >= 2000.0 && !function.ends_with("_batch`") {
            let row = (function.trim_matches('`').to_string(), bytes);
            measured.entry(robot.into()).or_default().push(row);
        }
    }
    assert_eq!(measured.len(), 3, "{measured:?}");
    for (robot, rows) in measured {
        let found = modyn(&["inspect", "--json", &format!("robots/{robot}.urdf")]).json();
        for (function, bytes) in rows {
            let functions = found["functions"].as_array().expect("functions");
            let one = functions.iter().find(|one| one["name"] == *function).expect("a function");
            let ratio = one["estimated_code_bytes"].as_f64().expect("an estimate") / bytes;
            assert!((0.4..=2.5).contains(&ratio), "{robot} {function}: {ratio}");
        }
    }
}
