//! `modyn simulate`: physics, tables, plots, the page.
#![cfg(feature = "command")]

use crate::common;

use std::path::Path;

use common::modyn;
use roxmltree::Document;
use serde_json::Value;

/// Returns the head and the rows of a table.
fn table(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let head = reader.headers().expect("a head").iter().map(String::from).collect();
    let row =
        |row: csv::StringRecord| row.iter().map(|cell| cell.parse().expect("a number")).collect();
    (head, reader.records().map(|record| row(record.expect("a row"))).collect())
}

fn column(head: &[String], name: &str) -> usize {
    head.iter().position(|found| found == name).unwrap_or_else(|| panic!("{name}: {head:?}"))
}

/// Returns the largest deviation of the total energy.
fn drift(text: &str) -> f64 {
    let (head, rows) = table(text);
    let [kinetic, potential, work, dissipated] =
        ["kinetic (J)", "potential (J)", "work (J)", "dissipated (J)"].map(|n| column(&head, n));
    let balance = |row: &Vec<f64>| row[kinetic] + row[potential] - row[work] + row[dissipated];
    let start = balance(&rows[0]);
    rows.iter().map(|row| (balance(row) - start).abs()).fold(0.0, f64::max)
}

#[test]
fn free_fall_keeps_energy_and_smaller_steps_keep_it_better() {
    for (robot, base) in [
        ("double_pendulum", "fixed"),
        ("arm7", "fixed"),
        ("joint_zoo", "fixed"),
        ("quadruped", "floating"),
    ] {
        let path = format!("robots/{robot}.urdf");
        let run = |step: &str| {
            let found = modyn(&[
                "simulate", &path, "--base", base, "--random", "3", "--time", "0.5", "--step", step,
            ]);
            assert_eq!(found.code, 0, "{robot}: {}", found.err);
            let (head, rows) = table(&found.out);
            let kinetic = column(&head, "kinetic (J)");
            let most = rows.iter().map(|row| row[kinetic]).fold(0.0, f64::max);
            assert!(most > 0.01, "{robot} does not move");
            drift(&found.out) / most
        };
        let (coarse, fine) = (run("0.002"), run("0.0005"));
        assert!(fine < 1e-6, "{robot}: {fine}");
        // The error is of fourth order, until rounding dominates.
        assert!(fine < coarse / 50.0 || fine < 1e-12, "{robot}: {coarse} {fine}");
    }
}

/// Steps by a tolerance keep to the motion of short fixed steps, closer by smaller tolerances, in fewer steps.
#[test]
fn steps_follow_a_tolerance() {
    for robot in ["double_pendulum", "joint_zoo", "arm7"] {
        let path = format!("robots/{robot}.urdf");
        let run = |by: [&str; 2]| {
            let of_all = ["simulate", &path, "--random", "3", "--time", "0.4", "--every", "0.2"];
            let found = modyn(&[&of_all[..], &by].concat());
            assert_eq!(found.code, 0, "{robot}: {}", found.err);
            let words: Vec<&str> = found.err.split_whitespace().collect();
            let at = words.iter().position(|word| *word == "steps;").expect("the number of steps");
            let steps: usize = words[at - 1].parse().expect("a number");
            let (head, rows) = table(&found.out);
            let states = column(&head, "kinetic (J)");
            assert_eq!(rows.len(), 3, "{robot}");
            (steps, rows.last().expect("a row")[..states].to_vec())
        };
        let (many, reference) = run(["--step", "0.0001"]);
        let error = |numbers: &[f64]| {
            let scaled =
                numbers.iter().zip(&reference).map(|(a, b)| (a - b).abs() / (1.0 + b.abs()));
            scaled.fold(0.0, f64::max)
        };
        let [(few, coarse), (more, fine)] = ["1e-4", "1e-10"].map(|t| run(["--tolerance", t]));
        assert!(few < more && more < many, "{robot}: {few} {more} {many}");
        assert!(error(&coarse) < 0.1, "{robot}: {}", error(&coarse));
        assert!(error(&fine) < 1e-6, "{robot}: {}", error(&fine));
        assert!(
            error(&fine) < 0.1 * error(&coarse),
            "{robot}: {} {}",
            error(&fine),
            error(&coarse)
        );
    }
}

#[test]
fn a_tolerance_that_cannot_be_kept_is_an_error() {
    let arguments = ["simulate", "robots/double_pendulum.urdf", "--random", "3", "--tolerance"];
    let found = modyn(&[&arguments[..], &["1e-30"]].concat());
    assert_eq!(found.code, 1, "{}", found.err);
    assert!(found.err.contains("the tolerance 1e-30 cannot be kept at 0.0000 s"), "{}", found.err);
    let found = modyn(&[&arguments[..], &["1e-6", "--limits"]].concat());
    assert_eq!(found.code, 2, "{}", found.err);
    let found = modyn(&[&arguments[..], &["0"]].concat());
    assert_eq!(found.code, 2, "{}", found.err);
}

#[test]
fn a_body_without_joints_falls_as_galilei_says() {
    let found = modyn(&["simulate", "robots/quadruped.urdf", "--base", "floating", "--time", "1"]);
    let (head, rows) = table(&found.out);
    let height = column(&head, "floating_base.z (m)");
    let last = rows.last().expect("a row");
    assert!((last[height] + 9.81 / 2.0).abs() < 1e-9, "{}", last[height]);
    assert_eq!(rows.len(), 51);
}

#[test]
fn friction_accounts_for_the_missing_energy() {
    let found = modyn(&[
        "simulate",
        "robots/mimic_gripper.urdf",
        "--joint-friction",
        "smooth=0.05",
        "--q",
        "0.5,0.5,0.5,0,0.01",
        "--time",
        "0.5",
    ]);
    assert_eq!(found.code, 0, "{}", found.err);
    let (head, rows) = table(&found.out);
    let dissipated = column(&head, "dissipated (J)");
    assert!(rows.windows(2).all(|pair| pair[1][dissipated] >= pair[0][dissipated] - 1e-12));
    assert!(rows.last().expect("a row")[dissipated] > 0.1);
    assert!(drift(&found.out) < 1e-6, "{}", drift(&found.out));
}

#[test]
fn torques_come_from_a_table_and_do_work() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("writes");
        path.to_string_lossy().into_owned()
    };
    let run = |path: &str| {
        modyn(&["simulate", "robots/double_pendulum.urdf", "--time", "0.5", "--torques", path])
    };
    let plain = run(&file("plain.csv", "0,0,0\n0.25, 0, 1\n# a remark\n1,0,4\n"));
    assert_eq!(plain.code, 0, "{}", plain.err);
    let (head, rows) = table(&plain.out);
    let [tau, work] = ["tau elbow (N m)", "work (J)"].map(|name| column(&head, name));
    let at = |time: f64| rows.iter().find(|row| (row[0] - time).abs() < 1e-9).expect("a row");
    assert!((at(0.24)[tau] - 0.96).abs() < 1e-9 && (at(0.5)[tau] - 2.0).abs() < 1e-9);
    assert!(at(0.5)[work] > 0.01);
    assert!(drift(&plain.out) < 1e-6, "{}", drift(&plain.out));
    // Named columns may be in any order, or be omitted.
    let named = run(&file("named.csv", "time,elbow\n0,0\n0.25,1\n1,4\n"));
    assert_eq!(named.out, plain.out, "{}", named.err);
    for (text, line) in [
        ("time,wrist\n0,1\n", ":1: "),
        ("0,1,1\n0,1,1\n", ":2: "),
        ("0,1\n", ":1: "),
        ("0,1,x\n", ":1: "),
        ("0,1,inf\n", ":1: "),
        ("time,elbow,elbow\n0,1,1\n", ":1: "),
        ("", ":1: "),
    ] {
        let bad = run(&file("bad.csv", text));
        assert_eq!(bad.code, 2, "{text}");
        assert!(bad.err.contains(&format!("bad.csv{line}")), "{text}: {}", bad.err);
    }
    assert_eq!(run("no such.csv").code, 2);
}

#[test]
fn arguments_are_checked() {
    let code =
        |more: &[&str]| modyn(&[&["simulate", "robots/gripper.urdf"][..], more].concat()).code;
    assert_eq!(code(&["--q", "1,2"]), 2);
    assert_eq!(code(&["--qd", "1,x,3,4"]), 2);
    assert_eq!(code(&["--time", "-1"]), 2);
    assert_eq!(code(&["--step", "0"]), 2);
    assert_eq!(code(&["--time", "1e9"]), 2);
    assert_eq!(code(&["--csv", "no/such/folder.csv"]), 2);
    assert_eq!(code(&["--time", "0.1", "--q", "-0.1,0,0,0", "--qd", "-1,0,0,0"]), 0);
    // The motion is too fast for the step: the command reports that.
    let wild = modyn(&[
        "simulate",
        "robots/arm6.urdf",
        "--qd",
        "1e8,1e8,1e8,1e8,1e8,1e8",
        "--step",
        "0.1",
        "--time",
        "20",
    ]);
    assert_eq!(wild.code, 1, "{}", wild.err);
    assert!(wild.err.contains("leaves all bounds"), "{}", wild.err);
}

const FEET: [&str; 8] = [
    "--contacts",
    "fl: point(front_left_foot)",
    "--contacts",
    "fr: point(front_right_foot)",
    "--contacts",
    "hl: point(hind_left_foot)",
    "--contacts",
    "hr: point(hind_right_foot)",
];

/// A quadruped with limp legs falls from 0.3 m onto its feet, which stay near the ground.
#[test]
fn feet_stay_above_the_ground_and_impacts_take_energy() {
    let run = |more: &[&str]| {
        let q = "0,0,0.35,0,0,0,1,0,0.6,-1.2,0,0.6,-1.2,0,-0.6,1.2,0,-0.6,1.2";
        let start = ["simulate", "robots/quadruped.urdf", "--base", "floating", "--q", q];
        modyn(&[&start[..], &FEET, &["--time", "0.4", "--step", "0.0005"], more].concat())
    };
    let free = run(&[]);
    let landed = run(&["--ground", "plane(friction = 0.8)"]);
    assert_eq!((free.code, landed.code), (0, 0), "{}{}", free.err, landed.err);
    let (head, rows) = table(&landed.out);
    let [height, dissipated] = ["floating_base.z (m)", "dissipated (J)"].map(|n| column(&head, n));
    let last = rows.last().expect("a row");
    let (_, falling) = table(&free.out);
    assert!(last[height] > falling.last().expect("a row")[height] + 0.05, "{last:?}");
    assert!(last[dissipated] > 0.5, "{}", last[dissipated]);
    // Of 14 J kinetic energy; the method is of first order.
    assert!(drift(&landed.out) < 0.2, "{}", drift(&landed.out));
    let depth =
        landed.err.split("deepest contact is ").nth(1).and_then(|text| text.split(' ').next());
    let depth: f64 = depth.and_then(|text| text.parse().ok()).expect("a depth");
    // The feet hit the ground at 2.5 m/s.
    assert!(depth < 0.06, "{}", landed.err);
    assert!(!free.err.contains("deepest"), "{}", free.err);
    // The default is 1; without friction the feet slide apart.
    let level = "plane([1, 2, 0], [0, 0, 2], friction = 0.8)";
    assert_eq!(run(&["--ground", level]).out, landed.out);
    // The page draws the ground where it is, although the feet are a little below.
    let folder = tempfile::tempdir().expect("a folder");
    let page = folder.path().join("fall.html").to_string_lossy().into_owned();
    for (more, ground) in [(&["--ground", "plane"][..], serde_json::json!(0)), (&[], Value::Null)] {
        assert_eq!(run(&[more, &["--html", &page]].concat()).code, 0);
        let html = std::fs::read_to_string(&page).expect("a page");
        assert_eq!(common::page_data(&html)["ground"], ground);
    }
    for other in ["plane", "plane(friction = 0)"] {
        assert_ne!(run(&["--ground", other]).out, landed.out);
    }
}

/// A floating quadruped starts with its lowest foot on the ground, in any posture. Coordinates that are given take precedence.
#[test]
fn a_floating_robot_starts_on_the_ground() {
    let depth = |more: &[&str]| {
        let ground = ["--ground", "plane"];
        let start = ["simulate", "robots/quadruped.urdf", "--base", "floating"];
        let motion = modyn(
            &[&start[..], &ground, &FEET, &["--time", "1e-6", "--step", "1e-6"], more].concat(),
        );
        assert_eq!(motion.code, 0, "{}", motion.err);
        let (head, rows) = table(&motion.out);
        let depth = motion.err.split("deepest contact is ").nth(1).expect("a depth");
        let depth: f64 = depth.split(' ').next().expect("a number").parse().expect("a number");
        (rows[0][column(&head, "floating_base.z (m)")], depth)
    };
    // Both links of a leg are 0.16 m long.
    let (height, below) = depth(&[]);
    assert!((height - 0.32).abs() < 1e-9 && below < 1e-9, "{height} m, {below} m");
    let (height, below) = depth(&["--random", "3"]);
    assert!(height.abs() < 0.6 && below < 1e-9, "{height} m, {below} m");
    let (height, below) = depth(&["--q", "0,0,0.2,0,0,0,1,0,0,0,0,0,0,0,0,0,0,0,0"]);
    assert!((height - 0.2).abs() < 1e-12 && (below - 0.12).abs() < 1e-9, "{height} m, {below} m");
}

#[test]
fn joints_stop_at_their_limits_if_that_is_asked_for() {
    let run = |more: &[&str]| {
        let start = ["simulate", "robots/arm7.urdf", "--q", "0,0.5,0,-1.5,0,1,0", "--time", "1"];
        modyn(&[&start[..], more].concat())
    };
    let (free, stopped) = (run(&[]), run(&["--limits"]));
    assert_eq!((free.code, stopped.code), (0, 0), "{}{}", free.err, stopped.err);
    assert!(free.err.contains("beyond their limits, which are not enforced"), "{}", free.err);
    assert!(!stopped.err.contains("beyond"), "{}", stopped.err);
    let text = std::fs::read_to_string("../robots/arm7.urdf").expect("the arm");
    let description = Document::parse(&text).expect("a URDF");
    let joints = description.descendants().filter(|node| node.has_tag_name("joint"));
    let (head, rows) = table(&stopped.out);
    let mut compared = 0;
    for joint in joints {
        let Some(limit) = joint.children().find(|node| node.has_tag_name("limit")) else {
            continue;
        };
        let bound = |name| limit.attribute(name).and_then(|text| text.parse::<f64>().ok());
        let (Some(lower), Some(upper)) = (bound("lower"), bound("upper")) else { continue };
        let name = format!("{} (rad)", joint.attribute("name").expect("a name"));
        let at = column(&head, &name);
        // Limits give way a little.
        let range = lower - 0.15..upper + 0.15;
        assert!(rows.iter().all(|row| range.contains(&row[at])), "{name}");
        compared += 1;
    }
    assert!(compared > 5);
}

/// The fingers of the gripper move as one. The limit of the second stops both, unless it contradicts that of the first.
#[test]
fn joints_stop_at_the_limits_of_joints_that_mimic_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string("../robots/mimic_gripper.urdf").expect("the gripper");
    let (before, after) = text.split_once("<joint name=\"right_slide\"").expect("the finger");
    let run = |limits: &str, multiplier: &str, more: &[&str]| {
        let joint = after.replacen("lower=\"0\" upper=\"0.04\"", limits, 1).replacen(
            "multiplier=\"1\"",
            &format!("multiplier=\"{multiplier}\""),
            1,
        );
        assert_ne!(joint, after);
        let path = folder.path().join("gripper.urdf");
        std::fs::write(&path, format!("{before}<joint name=\"right_slide\"{joint}"))
            .expect("writes");
        let path = path.to_string_lossy().into_owned();
        let start = ["simulate", &path, "--time", "1", "--qd", "0,0,0,0,0.1"];
        let found = modyn(&[&start[..], more].concat());
        assert_eq!(found.code, 0, "{}", found.err);
        let (head, rows) = table(&found.out);
        let finger = column(&head, "left_slide (m)");
        (rows.iter().map(|row| row[finger]).fold(0.0, f64::max), found.err)
    };
    let half = "lower=\"-0.05\" upper=\"0.05\"";
    let (reach, _) = run(half, "2", &["--limits"]);
    assert!((0.025..0.026).contains(&reach), "{reach} m");
    let (reach, err) = run(half, "2", &[]);
    assert!(reach > 0.05, "{reach} m");
    assert!(err.contains("not enforced: left_slide, right_slide"), "{err}");
    let (reach, err) = run("lower=\"0.01\" upper=\"0.04\"", "-1", &["--limits"]);
    assert!((0.04..0.041).contains(&reach), "{reach} m");
    assert!(err.contains("contradict their leaders', and are not enforced: right_slide"), "{err}");
}

#[test]
fn efforts_beyond_the_limits_are_reduced() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("torques.csv").to_string_lossy().into_owned();
    std::fs::write(&path, "0,1e4,-1e4,0,0,0,0\n").expect("writes");
    let run = |more: &[&str]| {
        let start = ["simulate", "robots/arm6.urdf", "--time", "0.01", "--torques", &path];
        let found = modyn(&[&start[..], more].concat());
        let (_, rows) = table(&found.out);
        let last = rows.last().expect("a row").clone();
        [last[13], last[14]]
    };
    assert_eq!(run(&["--limits"]), [150.0, -150.0]);
    assert_eq!(run(&[]), [1e4, -1e4]);
}

#[test]
fn ground_that_nothing_touches_is_refused() {
    let floating = ["simulate", "robots/quadruped.urdf", "--base", "floating"];
    let none = modyn(&[&floating[..], &["--ground", "plane"]].concat());
    assert_eq!(none.code, 2);
    assert!(none.err.contains("--contacts"), "{}", none.err);
    for wrong in ["-1", "plane(friction = -1)", "plane([0, 0, 0])", "wall", "plane(rough = 1)"] {
        let refused = modyn(&[&floating[..], &FEET, &["--ground", wrong]].concat());
        assert_ne!(refused.code, 0, "{wrong}");
        let why = ["expected `plane`", "the friction of the ground"];
        assert!(why.iter().any(|why| refused.err.contains(why)), "{}", refused.err);
    }
    // Loops stay closed in steps with joint limits.
    let closed = modyn(&[
        "simulate",
        "robots/four_bar.urdf",
        "--limits",
        "--time",
        "0.5",
        "--q",
        "1.2,-0.6,2",
    ]);
    assert_eq!(closed.code, 0, "{}", closed.err);
}

/// A limp quadruped falls onto the collision shapes of its trunk, its legs and its feet, and lies still.
#[test]
fn collision_shapes_of_a_urdf_come_to_rest_on_the_ground() {
    let mut text =
        std::fs::read_to_string(common::root().join("robots/quadruped.urdf")).expect("a robot");
    let shape = |place: &str, geometry: &str| {
        format!("<collision><origin {place}/><geometry><{geometry}/></geometry></collision>")
    };
    for leg in ["front_left", "front_right", "hind_left", "hind_right"] {
        let capsule = r#"capsule radius="0.015" length="0.16""#;
        for (link, place, geometry) in [
            ("thigh", r#"xyz="0 0 -0.08""#, capsule),
            ("shank", r#"xyz="0 0 -0.08""#, capsule),
            ("foot", "", r#"sphere radius="0.02""#),
        ] {
            let start = format!(r#"<link name="{leg}_{link}">"#);
            assert!(text.contains(&start), "{start}");
            text = text.replace(&start, &(start.clone() + &shape(place, geometry)));
        }
    }
    let trunk = r#"<link name="trunk">"#;
    text = text.replace(trunk, &(trunk.to_owned() + &shape("", r#"box size="0.4 0.2 0.06""#)));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("limp.urdf").to_string_lossy().into_owned();
    std::fs::write(&path, text).expect("written");
    let ground = "plane([0, 0, 0.5], [0, 0, 1])";
    let run = |more: &[&str]| {
        let start =
            ["simulate", &path, "--base", "floating", "--joint-friction", "viscous", "--time", "2"];
        modyn(&[&start[..], more].concat())
    };
    let motion = run(&["--ground", ground]);
    assert_eq!(motion.code, 0, "{}", motion.err);
    let (head, rows) = table(&motion.out);
    let height = |row: &[f64]| row[column(&head, "floating_base.z (m)")];
    // The legs are 0.32 m long, and the feet have a radius of 0.02 m.
    assert!((height(&rows[0]) - 0.84).abs() < 1e-9, "{:?}", rows[0]);
    let last = rows.last().expect("a row");
    assert!((0.52..0.6).contains(&height(last)), "{last:?}");
    let kinetic = last[column(&head, "kinetic (J)")];
    assert!(kinetic < 1e-4, "{kinetic} J");
    // Without ground the robot falls, and points of contacts replace the shapes.
    let (_, falling) = table(&run(&[]).out);
    assert!(height(falling.last().expect("a row")) < -10.0);
    let point = ["--contacts", "toe: point(front_left_foot)", "--ground", ground];
    assert_ne!(run(&point).out, motion.out);
}

/// The controls of actuators are zero: the servos pull the joints towards zero.
#[test]
fn actuators_of_the_option_act() {
    let start =
        ["simulate", "robots/double_pendulum.urdf", "--joint-friction", "none", "--q", "0.9,-0.7"];
    let end = |more: &[&str]| {
        let run = modyn(&[&start[..], &["--time", "3"], more].concat());
        assert_eq!(run.code, 0, "{}", run.err);
        let (head, rows) = table(&run.out);
        let last = rows.last().expect("a row").clone();
        (head, last)
    };
    let (head, held) = end(&["--actuators", "*: position(40, 1)"]);
    let joints: Vec<usize> = (0..head.len()).filter(|&k| head[k].ends_with("(rad)")).collect();
    assert_eq!(joints.len(), 2, "{head:?}");
    assert!(joints.iter().all(|&joint| held[joint].abs() < 0.05), "{held:?}");
    let (_, weak) = end(&["--actuators", "*: position(40, 1, effort = 0.01)"]);
    assert!(joints.iter().any(|&joint| weak[joint].abs() > 0.1), "{weak:?}");
    let adaptive = ["--actuators", "*: motor", "--tolerance", "1e-6"];
    assert_eq!(modyn(&[&start[..], &adaptive].concat()).code, 2);
}

const SCENE: &str = r#"<mujoco model="ball"><worldbody><geom type="plane" size="0 0 1" pos="0 0 0.2"/>
  <body pos="0.3 -0.2 0.45"><freejoint name="free"/><geom type="sphere" size="0.1" mass="2"/>
    <body pos="0 0 0.2"><joint name="hinge" axis="0 1 0" range="-20 20"/><geom type="sphere" size="0.05" pos="0.03 0 0.1" mass="0.5"/>
    </body></body></worldbody></mujoco>"#;

/// The actuators of a scene act with controls that are zero: a servo holds its joint against gravity, by the integrator of the
/// description.
#[test]
fn actuators_of_a_scene_have_zero_controls() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let servo = "<actuator><position joint=\"hinge\" kp=\"4000\" kv=\"400\"/></actuator>";
    let actuated = SCENE
        .replace("<worldbody>", "<option integrator=\"implicitfast\"/><worldbody>")
        .replace("</mujoco>", &format!("{servo}</mujoco>"));
    let angle = |text: &str| {
        std::fs::write(path("scene.xml"), text).expect("written");
        let table_path = path("scene.csv");
        let motion = modyn(&["simulate", &path("scene.xml"), "--time", "1", "--csv", &table_path]);
        assert_eq!(motion.code, 0, "{}", motion.err);
        let (head, rows) = table(&std::fs::read_to_string(table_path).expect("a table"));
        rows.iter().map(|row| row[column(&head, "hinge (rad)")].abs()).fold(0.0, f64::max)
    };
    let [free, held] = [SCENE, &actuated].map(angle);
    assert!(free > 0.1 && held < 0.05, "{free} {held}");
}

/// The motion starts in the keyframe that the user names, whose controls are held. The step is the MJCF's time step.
#[test]
fn a_scene_starts_in_a_keyframe() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let rest = r#"<actuator><position joint="hinge" kp="4000" kv="400"/></actuator><keyframe>
        <key name="home" qpos="0.5 0 0.9 1 0 0 0 0.1" qvel="0 2 0 0 0 0 0" ctrl="0.2"/>
        <key name="still"/></keyframe></mujoco>"#;
    // The servo holds the joint in the air and on the ground.
    let option = r#"<option timestep="0.005" integrator="implicitfast"/><worldbody>"#;
    let text = SCENE.replace("<worldbody>", option).replace("</mujoco>", rest);
    let airborne = text.replace(r#"<geom type="plane" size="0 0 1" pos="0 0 0.2"/>"#, "");
    assert!(airborne.len() < text.len());
    for (text, is_airborne) in [(text, false), (airborne, true)] {
        std::fs::write(path("scene.xml"), text).expect("written");
        let run = |more: &[&str]| {
            let arguments = ["simulate", &path("scene.xml"), "--time", "0.5", "--every", "0.1"];
            modyn(&[&arguments[..], more].concat())
        };
        let motion = run(&["--key", "home"]);
        assert_eq!(motion.code, 0, "{}", motion.err);
        assert!(motion.err.contains("0.5 s in 100 steps"), "{}", motion.err);
        let (head, rows) = table(&motion.out);
        let number = |row: usize, name: &str| rows[row][column(&head, name)];
        let [start, end] = [0, rows.len() - 1];
        assert!((number(start, "free.x (m)") - 0.5).abs() < 1e-12, "{rows:?}");
        assert!((number(start, "hinge (rad)") - 0.1).abs() < 1e-12, "{rows:?}");
        assert!((number(end, "hinge (rad)") - 0.2).abs() < 0.02, "{rows:?}");
        assert!(number(end, "free.y (m)") > 0.5, "{rows:?}");
        assert_eq!(number(end, "free.z (m)") < -0.1, is_airborne, "{rows:?}");
        let named = run(&["--key", "house"]);
        assert!(named.code == 2 && named.err.contains("there are: home, still"), "{}", named.err);
    }
    let none = modyn(&["simulate", "robots/arm7.urdf", "--key", "home"]);
    assert!(none.code == 2 && none.err.contains("`--q` and `--qd`"), "{}", none.err);
}

/// The shapes of an MJCF touch its floor, and its joint limits act, without an option.
#[test]
fn a_scene_moves_on_its_floor() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(path("ball.xml"), SCENE).expect("written");
    let run =
        |more: &[&str]| modyn(&[&["simulate", &path("ball.xml"), "--time", "1"], more].concat());
    let motion = run(&["--csv", &path("ball.csv"), "--html", &path("ball.html")]);
    assert_eq!(motion.code, 0, "{}", motion.err);
    let (head, rows) = table(&std::fs::read_to_string(path("ball.csv")).expect("a table"));
    let last = rows.last().expect("a row");
    // The ball rests on the floor, 0.2 m high, which gives way a little.
    assert!((last[column(&head, "free.z (m)")] - 0.3).abs() < 2e-3, "{last:?}");
    let limit = 20_f64.to_radians() + 0.06;
    assert!(rows.iter().all(|row| row[column(&head, "hinge (rad)")].abs() < limit));
    assert!((rows[0][column(&head, "free.z (m)")] - 0.3).abs() < 1e-9, "{:?}", rows[0]);
    assert!(last[column(&head, "dissipated (J)")] > 0.05, "{last:?}");
    assert!(motion.err.contains("contacts, joint limits and friction take"), "{}", motion.err);
    // The page has the ground, and the force where the ball touches it.
    let data = common::page_data(&std::fs::read_to_string(path("ball.html")).expect("a page"));
    assert_eq!(data["ground"].as_f64(), Some(0.2));
    let forces = data["motions"][0]["forces"].as_array().and_then(|all| all.last());
    let forces: Vec<f64> =
        serde_json::from_value(forces.expect("forces").clone()).expect("numbers");
    assert!((forces[2] - 0.2).abs() < 2e-3 && forces[5] > 5.0, "{forces:?}");
    let more = run(&["--ground", "plane"]);
    assert!(more.code == 2 && more.err.contains("leave the option out"), "{}", more.err);
    let adaptive = run(&["--tolerance", "1e-6"]);
    assert!(adaptive.err.contains("does not touch its floor"), "{}", adaptive.err);
}

#[test]
fn the_page_has_the_robot_and_its_motion() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let found = modyn(&[
        "simulate",
        "robots/double_pendulum.urdf",
        "--q",
        "1,0.5",
        "--time",
        "1",
        "--html",
        &path("p.html"),
        "--plot",
        &path("p.svg"),
        "--csv",
        &path("p.csv"),
    ]);
    assert_eq!((found.code, &*found.out), (0, ""), "{}", found.err);
    let read = |name: &str| std::fs::read_to_string(Path::new(&path(name))).expect("a file");
    let html = read("p.html");
    assert!(html.contains("<title>double_pendulum</title>"));
    let data = common::page_data(&html);
    assert_eq!(data["robots"][0]["bodies"].as_array().map(Vec::len), Some(2));
    let motion = &data["motions"][0];
    assert_eq!((&motion["forces"], &data["ground"]), (&Value::Null, &Value::Null));
    let (head, rows) = table(&read("p.csv"));
    assert_eq!(rows.len(), 51);
    let columns = ["shoulder (rad)", "elbow (rad)"].map(|name| column(&head, name));
    for (i, row) in rows.iter().enumerate() {
        let shown = [&motion["times"][i], &motion["q"][i][0], &motion["q"][i][1]];
        let shown = shown.map(|x| x.as_f64().expect("a number"));
        for (x, y) in shown.iter().zip([row[0], row[columns[0]], row[columns[1]]]) {
            assert!((x - y).abs() < 1e-5 * (1.0 + y.abs()), "row {i}: {x} {y}");
        }
    }

    let svg = read("p.svg");
    let svg = Document::parse(&svg).expect("XML");
    let texts: Vec<&str> =
        svg.descendants().filter_map(|node| node.text()).map(str::trim).collect();
    for wanted in
        ["coordinates (rad)", "velocities (rad/s)", "energies (J)", "time (s)", "shoulder", "elbow"]
    {
        assert!(texts.contains(&wanted), "{wanted}: {texts:?}");
    }
    // A panel for each coordinate and velocity, and one of the energies; each curve ends where its panel does.
    let number = |text: Option<&str>| text.expect("an attribute").parse::<f64>().expect("a number");
    let panels =
        svg.descendants().filter(|node| node.has_tag_name("rect") && node.has_attribute("x"));
    let right: Vec<f64> =
        panels.map(|node| number(node.attribute("x")) + number(node.attribute("width"))).collect();
    assert_eq!(right.len(), 5);
    let curves: Vec<&str> = svg
        .descendants()
        .filter(|node| node.attribute("stroke-width") == Some("2"))
        .filter_map(|node| node.attribute("d"))
        .collect();
    assert_eq!(curves.len(), 4 + 3);
    for curve in curves {
        let end = number(curve.rsplit(' ').nth(1));
        assert!(right.iter().any(|right| (right - end).abs() < 0.1), "{end} of {right:?}");
    }
    assert_eq!(table(&read("p.csv")).1.len(), 51);
}

#[test]
fn every_joint_type_can_be_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let svg = folder.path().join("a.svg").to_string_lossy().into_owned();
    // A robot that does not move, and a robot that moves without bound.
    for (qd, bounded) in
        [("0,0", true), ("1e-200,0", true), ("1e60,-1e60", false), ("1e140,1e140", false)]
    {
        let robot =
            ["simulate", "robots/double_pendulum.urdf", "--gravity", "0,0,0", "--plot", &svg];
        let found = modyn(&[&robot[..], &["--time", "0.002", "--qd", qd]].concat());
        assert!(found.code == 0 || !bounded && found.code == 1, "{qd}: {}", found.err);
        if found.code == 0 {
            let text = std::fs::read_to_string(&svg).expect("plots");
            assert!(text.len() < 100_000 && Document::parse(&text).is_ok(), "{qd}");
        }
    }
}

#[test]
fn loops_stay_closed() {
    let start = ["--q", "1.2,-0.6,2.0", "--time", "1", "--every", "0.1"];
    let found = modyn(&[&["simulate", "robots/four_bar.urdf"], &start[..]].concat());
    assert_eq!(found.code, 0, "{}", found.err);
    assert!(drift(&found.out) < 1e-6, "{}", drift(&found.out));
    let (head, rows) = table(&found.out);
    let [crank, pin, rocker] = ["crank_pivot (rad)", "crank_pin (rad)", "rocker_pivot (rad)"]
        .map(|name| column(&head, name));
    for row in &rows {
        let (a, b, c) = (row[crank], row[crank] + row[pin], row[rocker]);
        let x = 0.2 * a.cos() + 0.5 * b.cos() - 0.5 - 0.4 * c.cos();
        let z = 0.2 * a.sin() + 0.5 * b.sin() - 0.4 * c.sin();
        assert!(x.hypot(z) < 1e-8, "{x} {z}");
    }
    assert!((rows[0][crank] - rows[rows.len() - 1][crank]).abs() > 0.1);
    // A linkage that is stretched out has no rank to move.
    let found = modyn(&["simulate", "robots/four_bar.urdf"]);
    assert_eq!(found.code, 1);
    assert!(found.err.contains("joint `rocker_pin`"), "{}", found.err);
}

/// A parallelogram that swings a table: flat where its angle is a right angle, as in mujoco#2172.
const PARALLELOGRAM: &str = r#"<mujoco model="swing_table">
  <compiler angle="radian"/>
  <worldbody>
    <body name="left"><joint name="left" axis="0 1 0"/><inertial pos="0 0 0.2" mass="1" diaginertia="0.02 0.02 0.001"/>
      <body name="table" pos="0 0 0.4"><joint name="table" axis="0 1 0"/>
        <inertial pos="0.3 0 0.05" mass="2" diaginertia="0.01 0.05 0.05"/></body>
    </body>
    <body name="right" pos="0.6 0 0"><joint name="right" axis="0 1 0"/>
      <inertial pos="0 0 0.15" mass="0.8" diaginertia="0.015 0.015 0.001"/></body>
  </worldbody>
  <equality><connect body1="table" body2="right" anchor="0.6 0 0"/></equality>
</mujoco>"#;

/// Returns the angle of the parallelogram, whose one equation of motion is I a = g sin(angle).
fn parallelogram_angle(time: f64) -> f64 {
    let inertia = (0.02 + 0.2 * 0.2) + (0.015 + 0.8 * 0.15 * 0.15) + 2.0 * 0.4 * 0.4;
    let weight = 9.81 * (1.0 * 0.2 + 0.8 * 0.15 + 2.0 * 0.4);
    let rates = |[angle, rate]: [f64; 2]| [rate, weight * angle.sin() / inertia];
    let plus = |a: [f64; 2], factor: f64, b: [f64; 2]| [a[0] + factor * b[0], a[1] + factor * b[1]];
    let (mut state, steps) = ([0.5, 1.3], 20_000);
    let dt = time / f64::from(steps);
    for _ in 0..steps {
        let first = rates(state);
        let second = rates(plus(state, dt / 2.0, first));
        let third = rates(plus(state, dt / 2.0, second));
        let last = rates(plus(state, dt, third));
        let ends = plus(state, dt / 6.0, plus(first, 1.0, last));
        state = plus(ends, dt / 3.0, plus(second, 1.0, third));
    }
    state[0]
}

/// Runs a linkage, with further arguments.
fn run_linkage(text: &str, more: &[&str]) -> common::Output {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("linkage.xml");
    std::fs::write(&path, text).expect("writes");
    modyn(&[&["simulate", &*path.to_string_lossy()], more].concat())
}

/// In its flat posture the parallelogram has another assembly, in which the sides cross. It stays in its own by any steps.
#[test]
fn a_parallelogram_swings_through_its_flat_posture() {
    let start = ["--q", "0.5,-0.5,0.5", "--qd", "1.3,-1.3,1.3"];
    let assert_right = |more: &[&str]| {
        let found = run_linkage(PARALLELOGRAM, &[&start[..], more].concat());
        assert_eq!(found.code, 0, "{more:?}: {}", found.err);
        let singular = "singular posture, in which the rank of their constraints falls from 2 to 1";
        assert!(found.err.contains(singular), "{more:?}: {}", found.err);
        assert!(drift(&found.out) < 1e-5, "{more:?}: {}", drift(&found.out));
        let (head, rows) = table(&found.out);
        let sides = ["left (rad)", "table (rad)", "right (rad)"].map(|name| column(&head, name));
        for row in &rows {
            let angle = parallelogram_angle(row[0]);
            for (side, sign) in sides.into_iter().zip([1.0, -1.0, 1.0]) {
                let off = (row[side] - sign * angle).abs();
                assert!(off < 1e-5, "{more:?} at {} s: {off:e}", row[0]);
            }
        }
    };
    for [step, time] in [["0.002", "4"], ["0.001", "4"], ["0.0003", "2"], ["0.00002", "0.35"]] {
        assert_right(&["--step", step, "--time", time, "--every", "0.05"]);
    }
    assert_right(&["--tolerance", "1e-8", "--time", "4", "--every", "0.05"]);
    // A tolerance below what rounding allows near the posture: the message names it, and its advice works.
    let strict = ["--time", "4", "--every", "0.05", "--tolerance"];
    let found = run_linkage(PARALLELOGRAM, &[&start[..], &strict, &["1e-13"]].concat());
    assert_eq!(found.code, 1, "{}", found.err);
    assert!(found.err.contains("falls from 2 to 1"), "{}", found.err);
    let (_, advice) = found.err.split_once("take `--tolerance ").expect("advice");
    let (tolerance, _) = advice.split_once('`').expect("a number");
    assert_right(&[&strict[..], &[tolerance]].concat());
}

/// A linkage without symmetry whose shortest and longest sides are together as long as the others: it is flat where all angles are
/// zero. It keeps its energy, its closed loop and its assembly.
#[test]
fn a_linkage_in_general_position_swings_through_its_flat_posture() {
    let linkage = r#"<mujoco model="change_point">
      <compiler angle="radian"/>
      <worldbody>
        <body name="crank"><joint name="crank" axis="0 -1 0"/>
          <inertial pos="0.13 0 0.02" mass="1.1" diaginertia="0.01 0.012 0.011"/>
          <body name="coupler" pos="0.3 0 0"><joint name="coupler" axis="0 -1 0"/>
            <inertial pos="0.2 0 -0.03" mass="0.7" diaginertia="0.01 0.02 0.015"/></body>
        </body>
        <body name="rocker" pos="0.6 0 0"><joint name="rocker" axis="0 -1 0"/>
          <inertial pos="0.09 0 0.01" mass="0.5" diaginertia="0.004 0.005 0.003"/></body>
      </worldbody>
      <equality><connect body1="coupler" body2="rocker" anchor="0.5 0 0"/></equality>
    </mujoco>"#;
    // The triangle of the coupler, the rocker and the line from the crank's tip to the rocker's pivot.
    let crank = 0.5_f64;
    let (x, z) = (0.6 - 0.3 * crank.cos(), -0.3 * crank.sin());
    let at_tip = ((0.25 + x * x + z * z - 0.04) / x.hypot(z)).acos();
    let coupler = z.atan2(x) + at_tip;
    let rocker = (0.5 * coupler.sin() - z).atan2(0.5 * coupler.cos() - x);
    let start = [crank, coupler - crank, rocker].map(|x| x.to_string()).join(",");
    for steps in [["--step", "0.001"], ["--step", "0.0002"], ["--tolerance", "1e-8"]] {
        let more = ["--q", &start, "--qd", "-2,0,0", "--time", "1", "--every", "0.01"];
        let found = run_linkage(linkage, &[&more[..], &steps].concat());
        assert_eq!(found.code, 0, "{steps:?}: {}", found.err);
        assert!(drift(&found.out) < 1e-5, "{steps:?}: {}", drift(&found.out));
        let (head, rows) = table(&found.out);
        let columns =
            ["crank (rad)", "coupler (rad)", "rocker (rad)"].map(|name| column(&head, name));
        let first = rows[0][columns[1]].sin() * (rows[0][columns[2]] / 2.0).sin();
        let mut sides = [0, 0];
        for row in &rows {
            let [a, b, c] = columns.map(|column| row[column]);
            let x = 0.3 * a.cos() + 0.5 * (a + b).cos() - 0.6 - 0.2 * c.cos();
            let z = 0.3 * a.sin() + 0.5 * (a + b).sin() - 0.2 * c.sin();
            assert!(x.hypot(z) < 1e-7, "{steps:?} at {} s: {x} {z}", row[0]);
            // The rocker turns around. In each flat posture coupler and crank pass each other; in the other assembly they would turn
            // back.
            let side = b.sin() * (c / 2.0).sin();
            assert!(side * first > -1e-9, "{steps:?} at {} s: {b} {c}", row[0]);
            sides[usize::from((c / 2.0).sin() > 0.0)] += 1;
        }
        assert!(sides.iter().all(|&rows| rows > 5), "{steps:?}: {sides:?}");
    }
}
