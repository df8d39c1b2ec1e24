//! `modyn compare`: compares machine code, or generated Rust that rustc compiles, with the interpreter.
#![cfg(feature = "command")]

use crate::common;

use common::{command, modyn, run};

#[test]
fn generated_code_agrees_with_the_interpreter() {
    // rustc compiles the small robot alone.
    for (robot, options, compilers) in [
        ("robots/gripper.urdf", &["--friction", "none"][..], 2),
        ("robots/joint_zoo.urdf", &["--friction", "smooth=0.1"], 1),
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
        let output = modyn(&["compare", &file.to_string_lossy(), "--friction", "none"]);
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
