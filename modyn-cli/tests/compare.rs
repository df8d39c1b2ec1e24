//! `modyn compare`: compares machine code, or generated Rust that rustc compiles, with the interpreter.
#![cfg(feature = "command")]

use crate::common;

use common::{command, modyn, run};

#[test]
fn generated_code_agrees_with_the_interpreter() {
    // rustc compiles the small robot alone.
    for (robot, options, compilers) in [
        ("robots/gripper.urdf", &["--joint-friction", "none"][..], 2),
        ("robots/joint_zoo.urdf", &["--joint-friction", "smooth=0.1"], 1),
        ("robots/quadruped.urdf", &["--base", "floating", "--modules", "links"], 1),
    ] {
        let arguments = ["compare", robot, "--json", "--states", "20"];
        let functions = ["--functions", "default,inverse_dynamics_derivatives"];
        for (compiler, rustc) in
            [("machine code", &[][..]), ("rustc", &["--rustc"])].into_iter().take(compilers)
        {
            let found = modyn(&[&arguments[..], &functions, options, rustc].concat());
            assert_eq!(found.code, 0, "{robot}: {}{}", found.out, found.err);
            let json = found.json();
            assert_eq!(json["agrees"], true);
            assert!(json["compiler"].as_str().is_some_and(|name| name.starts_with(compiler)));
            let functions = json["functions"].as_array().expect("functions");
            assert_eq!(functions.len(), if rustc.is_empty() { 12 } else { 13 }, "{functions:?}");
            for one in functions {
                assert!(one["difference"].as_f64().is_some_and(|x| x < 1e-9), "{one}");
                assert!(one["compiled_ns"].as_f64().is_some_and(|x| x > 0.0), "{one}");
            }
        }
    }
}

/// Forces that are zero by cancellation have other rounding in each program.
#[test]
fn two_zeros_agree() {
    let part = |link: &str, joint: &str, parent: &str, axis: &str| {
        format!(
            "<link name='{link}'><inertial><mass value='1'/><inertia ixx='0.1' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.1'/>\
             </inertial></link><joint name='{joint}' type='continuous'><parent link='{parent}'/><child link='{link}'/>{axis}</joint>"
        )
    };
    for axes in [["<axis xyz='0 0 1'/>", ""], ["<axis xyz='0 0 1'/>", "<axis xyz='0 1 0'/>"]] {
        let parts = [part("a", "ja", "base", axes[0]), part("b", "jb", "a", axes[1])];
        let text = format!("<robot name='r'><link name='base'/>{}</robot>", parts.concat());
        let file = std::env::temp_dir().join(format!("modyn-zeros-{}.urdf", std::process::id()));
        std::fs::write(&file, text).expect("a file");
        let output = modyn(&["compare", &file.to_string_lossy(), "--joint-friction", "none"]);
        let _ = std::fs::remove_file(&file);
        assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    }
}

#[test]
fn a_difference_is_an_answer_of_its_own() {
    let arguments =
        ["compare", "robots/gripper.urdf", "--functions", "forward_dynamics", "--tolerance", "0"];
    let found = modyn(&arguments);
    assert_eq!(found.code, 1, "{}", found.err);
    assert!(found.out.contains("DIFFERS") && found.out.contains("1 of 1 differ"), "{}", found.out);
}

#[test]
fn kept_files_can_be_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let kept = folder.path().join("kept");
    let found = modyn(&[
        "compare",
        "robots/gripper.urdf",
        "--functions",
        "mass_matrix",
        "--rustc",
        "--keep",
        &kept.to_string_lossy(),
    ]);
    assert_eq!(found.code, 0, "{}", found.err);
    assert!(kept.join("main.rs").is_file() && kept.join("robot.rs").is_file());
    assert!(found.out.contains("mass_matrix") && found.out.contains("all agree"), "{}", found.out);
}

#[test]
fn without_rustc_the_error_names_the_missing_program() {
    let mut without = command(&["compare", "robots/gripper.urdf", "--rustc"]);
    without.env("RUSTC", "no such rustc");
    let found = run(without);
    assert_eq!(found.code, 2);
    assert!(found.err.contains("rustup.rs") && found.err.contains("RUSTC"), "{}", found.err);
    for (function, rustc) in [("jacobian", &[][..]), ("jacobian", &["--rustc"]), ("brge", &[])] {
        let arguments = ["compare", "robots/gripper.urdf", "--functions", function];
        let found = modyn(&[&arguments[..], rustc].concat());
        assert_eq!(found.code, 2);
        assert!(found.err.contains("forward_dynamics, "), "{}", found.err);
    }
    assert_eq!(modyn(&["compare", "modyn-read/tests/bad/cycle.urdf"]).code, 1);
}

/// A function that the comparison does not have, beside one that it has.
#[test]
fn functions_that_are_not_compared_are_named() {
    let compare = |functions: &str| {
        modyn(&["compare", "robots/gripper.urdf", "--states", "2", "--functions", functions])
    };
    let output = compare("forward_dynamics,brge");
    assert_eq!(output.code, 0, "{}", output.err);
    assert!(output.err.contains("not compared: brge; `--rustc` also"), "{}", output.err);
    assert_eq!(compare("forward_dynamics").err, "");
}

/// A ball and a bar with a servo, above a floor.
const SCENE: &str = r#"<mujoco model="bar"><option cone="elliptic" timestep="0.004"/><worldbody>
    <geom type="plane" size="0 0 1"/>
    <body name="ball" pos="0.2 0.1 0.12"><freejoint/><geom name="ball" size="0.1" mass="0.7"/>
      <body name="bar" pos="0.1 0 0.12" euler="0 40 10">
        <joint name="hinge" axis="0.1 1 0.2" range="-80 80" damping="0.02"/>
        <geom name="bar" type="capsule" size="0.03" fromto="0 0 0 0.4 0.05 0"/>
      </body></body></worldbody>
    <actuator><position joint="hinge" kp="5" kv="0.1"/></actuator>
    <keyframe><key qpos="0.2 0.1 0.1 0.9 0.1 -0.2 0.3 0.4"/></keyframe></mujoco>"#;

/// Also by an integrator of MuJoCo that modyn does not have, and with a shape of the world that is no plane.
#[test]
#[ignore = "needs a Python with MuJoCo"]
fn steps_of_a_scene_are_those_of_mujoco() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml").to_string_lossy().into_owned();
    let run = |text: &str, more: &[&str]| {
        std::fs::write(&path, text).expect("written");
        modyn(&[&["compare", &path, "--mujoco", "--states", "20", "--json"], more].concat())
    };
    let rows = |output: &common::Output| {
        let json = output.json();
        let rows = json["rows"].as_array().expect("rows");
        rows.iter().map(|row| row["largest"].as_f64().expect("a number")).collect::<Vec<f64>>()
    };
    let output = run(SCENE, &[]);
    assert_eq!(output.code, 0, "{}{}", output.out, output.err);
    let json = output.json();
    assert!(json["contacts"].as_u64() > Some(20) && json["timestep"] == 0.004, "{json}");
    // MuJoCo's own solver ends at its tolerance.
    assert!(rows(&output).iter().all(|largest| *largest < 1e-4), "{json}");
    // Each of the four rows has all states.
    assert_eq!(output.out.matches("\"states\": 20").count(), 4, "{json}");
    // The classical Runge-Kutta method differs in the rows that have it.
    let runge_kutta = run(&SCENE.replace("<option", r#"<option integrator="RK4""#), &[]);
    let largest = rows(&runge_kutta);
    assert!(runge_kutta.code == 0 && largest[1] > 1e-4 && largest[0] < 1e-8, "{largest:?}");
    assert!(runge_kutta.out.contains("in place of which modyn has Euler"), "{}", runge_kutta.out);
    // Other gravity is a difference.
    let lighter = run(SCENE, &["--gravity", "0,0,-9.8"]);
    assert!(lighter.code == 1 && lighter.json()["agrees"] == false, "{}", lighter.out);
    // Contacts with other shapes do not count, and are named.
    let table =
        r#"<geom name="table" type="box" size="0.5 0.5 0.02" pos="0 0 0.01"/><body name="ball""#;
    let touching = run(&SCENE.replace(r#"<body name="ball""#, table), &[]);
    assert!(touching.out.contains("`ball` with `table`"), "{}{}", touching.out, touching.err);
    let left_out = touching.json()["rows"][0]["left_out"].as_u64();
    assert!(left_out > Some(0), "{}", touching.out);
    let refused = run(&SCENE.replace("hinge\" kp", "none\" kp"), &[]);
    assert_eq!(refused.code, 1, "{}", refused.err);
}

/// Without MuJoCo the error says what to install.
#[test]
fn without_mujoco_the_error_names_what_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml").to_string_lossy().into_owned();
    std::fs::write(&path, SCENE).expect("written");
    let missing = modyn(&["compare", &path, "--mujoco", "--python", "no such python"]);
    assert_eq!(missing.code, 2, "{}", missing.err);
    for part in ["`no such python` cannot be run", "pip install mujoco", "--python PATH"] {
        assert!(missing.err.contains(part), "{part}: {}", missing.err);
    }
    let urdf = modyn(&["compare", "robots/arm7.urdf", "--mujoco"]);
    assert!(urdf.code == 2 && urdf.err.contains("needs the file of an MJCF"), "{}", urdf.err);
    let alone = modyn(&["compare", "robots/arm7.urdf", "--python", "python3"]);
    assert!(alone.code == 2 && alone.err.contains("--mujoco"), "{}", alone.err);
}
