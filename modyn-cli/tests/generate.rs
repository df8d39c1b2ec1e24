//! `modyn generate`: files, staleness, headers, options.
#![cfg(feature = "command")]

use crate::common;

use std::path::Path;
use std::process::Command;

use common::{modyn, root};

/// Returns the path of a file in a folder, as an argument.
fn at(folder: &Path, name: &str) -> String {
    folder.join(name).to_string_lossy().into_owned()
}

#[test]
fn a_file_is_written_and_known_to_be_stale() {
    let folder = tempfile::tempdir().expect("a folder");
    let (urdf, file) = (at(folder.path(), "arm.urdf"), at(folder.path(), "arm.rs"));
    let description = std::fs::read_to_string(root().join("robots/arm6.urdf")).expect("a robot");
    std::fs::write(&urdf, &description).expect("writes");
    let arguments =
        ["generate", &urdf, "-o", &file, "--self-contained", "--functions", "mass_matrix"];
    let with = |more: &[&str]| modyn(&[&arguments[..], more].concat()).code;
    assert_eq!(with(&["--check"]), 1, "there is none yet");
    assert_eq!(with(&[]), 0);
    assert_eq!(with(&["--check"]), 0);
    assert_eq!(with(&["--check", "--scalar", "f32"]), 1, "an option");
    std::fs::write(&urdf, format!("{description}<!-- more -->")).expect("writes");
    assert_eq!(with(&["--check"]), 1, "another description");
    assert_eq!(with(&[]), 0);
    assert_eq!(with(&["--check"]), 0);
    let text = std::fs::read_to_string(&file).expect("a file");
    std::fs::write(&file, text.replacen("0.", "1.", 1)).expect("writes");
    assert_eq!(with(&["--check"]), 1, "edited by hand");
}

#[test]
fn object_files_are_written_with_their_texts_and_known_to_be_stale() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| at(folder.path(), name);
    let generate = ["generate", "robots/double_pendulum.urdf", "--target", "object"];
    let run = |more: &[&str]| modyn(&[&generate[..], more].concat());
    let read = |name: &str| std::fs::read(file(name)).expect("a file");
    let arm = file("arm.o");
    assert_eq!(run(&["-o", &arm, "--check"]).code, 1, "there is none yet");
    let elf = ["--object-format", "elf", "-o", &arm];
    assert_eq!(run(&elf).code, 0);
    assert_eq!(run(&[&elf[..], &["--check"]].concat()).code, 0);
    assert!(read("arm.o").starts_with(b"\x7fELF"));
    let header = String::from_utf8(read("arm.h")).expect("text");
    assert!(header.contains("int double_pendulum_is_supported(void);"), "{header}");
    assert!(
        header.contains("void double_pendulum_forward_dynamics(const double q[2], "),
        "{header}"
    );
    let wrapper = String::from_utf8(read("arm.rs")).expect("text");
    assert!(wrapper.contains("pub struct DoublePendulum;"));
    let other = [&elf[..], &["--instruction-set", "avx2"]].concat();
    assert_eq!(run(&[&other[..], &["--check"]].concat()).code, 1, "another instruction set");
    assert_eq!(run(&other).code, 0);
    let header = String::from_utf8(read("arm.h")).expect("text");
    assert!(
        header.contains("Processors need AVX2 and FMA: without them the functions"),
        "{header}"
    );
    // Other formats, and static libraries.
    let starts: [(&str, &str, &[u8]); 3] = [
        ("mach-o", "arm.o", &[0xcf, 0xfa, 0xed, 0xfe]),
        ("coff", "arm.obj", &[0x64, 0x86]),
        ("coff", "arm.lib", b"!<arch>\n"),
    ];
    for (format, name, start) in starts {
        assert_eq!(run(&["--object-format", format, "-o", &file(name)]).code, 0);
        assert!(read(name).starts_with(start), "{format}");
    }
    // What does not fit is refused with a reason.
    let cases: [(&[&str], &str); 4] = [
        (&[], "`--target object` writes three files: name the first with `--output FILE.o`"),
        (&["-o", "arm.rs"], "`--target object` writes three files"),
        (&["-o", &arm, "--self-contained"], "needs the crate `modyn`"),
        (&["-o", &arm, "--c-functions", "arm"], "are C functions already"),
    ];
    for (more, message) in cases {
        let refused = run(more);
        assert!(refused.code == 2 && refused.err.contains(message), "{}", refused.err);
    }
    let refused = modyn(&["generate", "robots/arm6.urdf", "--instruction-set", "avx2"]);
    assert_eq!(refused.code, 2);
    assert!(
        refused.err.contains("`--instruction-set` is about `--target object`"),
        "{}",
        refused.err
    );
}

#[test]
fn c_is_written_with_its_header_and_known_to_be_stale() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, header) = (at(folder.path(), "arm.c"), at(folder.path(), "arm.h"));
    let arguments = ["generate", "robots/arm6.urdf", "--target", "c"];
    let arguments = [&arguments[..], &["--functions", "mass_matrix"]].concat();
    let with = |more: &[&str]| modyn(&[&arguments[..], more].concat());
    assert_eq!(with(&["-o", &file, "--check"]).code, 1, "there is none yet");
    assert_eq!(with(&["-o", &file]).code, 0);
    assert_eq!(with(&["-o", &file, "--check"]).code, 0);
    let read = |path: &str| std::fs::read_to_string(path).expect("written");
    assert!(read(&file).contains("#include \"arm.h\""));
    assert!(read(&header).contains("arm6_mass_matrix(const double q[6], double out[36]);"));
    std::fs::write(&header, "").expect("writes");
    assert_eq!(with(&["-o", &file, "--check"]).code, 1, "the header");
    for wrong in [&["-o", "arm.rs"][..], &[], &["-o", &file, "--c-functions", "arm"]] {
        let found = with(wrong);
        assert!(found.code > 0 && found.err.contains("error"), "{wrong:?}: {}", found.err);
    }
}

#[test]
fn a_build_script_would_write_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = at(folder.path(), "gripper.rs");
    let options = |robot: &str, extra: &[&str]| {
        let common = [
            "generate",
            robot,
            "-o",
            &file,
            "--scalar",
            "f32",
            "--joint-friction",
            "smooth=0.01",
            "--gravity",
            "0,0,-1.62",
            "--modules",
            "links",
            "--runtime-gravity",
            "--type-name",
            "Hand",
            "--visibility",
            "pub(crate)",
            "--crate",
            "::other",
            "--functions",
            "default,regressor",
            "--unphysical-inertia",
            "warn",
            "--mimic",
            "independent",
            "--c-functions",
            "hand",
        ];
        modyn(&[&common[..], extra].concat())
    };
    let extra = [
        "--base",
        "floating",
        "--runtime-inertia",
        "front_left_foot",
        "--payload",
        "trunk",
        "--rotors",
        "front_left_knee: (0.0001, 100)",
        "--loops",
        "rod: revolute(trunk, [0.1, 0, -0.2], front_left_foot, [0, 0, 0], [0, 0, 1.5], axis = [0, 2, 0])",
    ];
    let found = options("robots/quadruped.urdf", &extra);
    assert_eq!(found.code, 0, "{}", found.err);
    let builder = modyn_codegen::Builder::new()
        .file(root().join("robots/quadruped.urdf").canonicalize().expect("a robot"))
        .scalar(modyn_codegen::FloatType::F32)
        .base(modyn_codegen::Base::Floating)
        .rotors([modyn_codegen::Rotor::new("front_left_knee", 0.0001, 100.0)])
        .loops([modyn_codegen::Loop {
            name: "rod".into(),
            kind: modyn_codegen::LoopConstraintKind::Revolute([0.0, 2.0, 0.0]),
            ends: [("trunk", [0.1, 0.0, -0.2], 0.0), ("front_left_foot", [0.0; 3], 1.5)].map(
                |(link, xyz, yaw)| modyn_codegen::LoopEnd {
                    link: link.into(),
                    xyz,
                    rpy: [0.0, 0.0, yaw],
                },
            ),
        }])
        .joint_friction(modyn_codegen::JointFriction::Smooth(0.01))
        .gravity([0.0, 0.0, -1.62])
        .modules(modyn_codegen::ModuleChoice::Links)
        .runtime_inertia(["front_left_foot"])
        .payload(["trunk"])
        .runtime_gravity()
        .type_name("Hand")
        .visibility("pub(crate)")
        .crate_("::other")
        .functions(
            modyn_codegen::Function::DEFAULT
                .iter()
                .copied()
                .chain([modyn_codegen::Function::Regressor]),
        )
        .unphysical_inertia(modyn_codegen::diagnostics::Severity::Warning)
        .mimic(modyn_codegen::Mimic::Independent)
        .c_functions("hand");
    assert!(!builder.is_stale(&file).expect("good"));
}

#[test]
fn without_a_file_the_text_goes_to_standard_output() {
    let found = modyn(&["generate", "robots/gripper.urdf", "--functions", "mass_matrix"]);
    assert_eq!(found.code, 0);
    assert!(found.out.contains("pub struct Gripper;"));
    assert!(
        found.out.contains("pub fn mass_matrix") && !found.out.contains("fn forward_dynamics(q")
    );
}

#[test]
fn a_header_for_c_is_written_and_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, header) = (at(folder.path(), "arm.rs"), at(folder.path(), "arm.h"));
    let arguments = [
        "generate",
        "robots/arm6.urdf",
        "-o",
        &file,
        "--c-header",
        &header,
        "--self-contained",
        "--scalar",
        "f32",
        "--functions",
        "forward_dynamics",
    ];
    let check = || modyn(&[&arguments[..], &["--check"]].concat());
    assert_eq!(check().code, 1);
    let found = modyn(&arguments);
    assert_eq!(found.code, 0, "{}", found.err);
    let text = std::fs::read_to_string(&header).expect("a header");
    for wanted in [
        "#ifndef ARM6_H",
        "void arm6_forward_dynamics(const float q[ARM6_AT_LEAST(6)]",
        "#define ARM6_NV 6",
    ] {
        assert!(text.contains(wanted), "{text}");
    }
    assert_eq!(check().code, 0);
    std::fs::write(&header, text.replace("void", "int")).expect("writes");
    let stale = check();
    assert_eq!(stale.code, 1);
    assert!(stale.err.contains("arm.rs is up to date") && stale.err.contains("arm.h is stale"));
}

#[test]
fn the_written_code_compiles() {
    for (robot, options) in
        [("gripper", &[][..]), ("quadruped", &["--share-limbs", "--scalar", "f32"])]
    {
        let folder = tempfile::tempdir().expect("a folder");
        let file = at(folder.path(), "arm.rs");
        let robot = format!("robots/{robot}.urdf");
        let common = ["generate", &robot, "-o", &file, "--self-contained"];
        let found = modyn(&[&common[..], options].concat());
        assert_eq!(found.code, 0, "{}", found.err);
        let crate_root = at(folder.path(), "lib.rs");
        let text = "//! A robot.\n#![no_std]\n#![forbid(unsafe_code)]\n#![deny(warnings)]\n/// An arm.\npub mod arm;\n";
        std::fs::write(&crate_root, text).expect("writes");
        let rustc = std::env::var_os("RUSTC").unwrap_or("rustc".into());
        let arguments = ["--edition=2024", "--crate-type=lib", "--emit=metadata", "--out-dir"];
        let status =
            Command::new(rustc).args(arguments).arg(folder.path()).arg(crate_root).status();
        assert!(status.expect("rustc runs").success());
    }
}

#[test]
fn shared_legs_are_once_in_the_text() {
    let text = |options: &[&str]| {
        let common = ["generate", "robots/quadruped.urdf", "--functions", "forward_dynamics"];
        let found = modyn(&[&common[..], options].concat());
        assert_eq!(found.code, 0, "{}", found.err);
        found.out
    };
    let (alone, shared) =
        (text(&["--self-contained"]), text(&["--self-contained", "--share-limbs"]));
    let products = |text: &str| text.matches("mul_add(").count();
    assert!(2 * products(&shared) < products(&alone));
}

#[test]
fn options_that_are_wrong_are_usage_and_refused_models_are_not() {
    let code = |arguments: &[&str]| {
        modyn(&[&["generate", "robots/gripper.urdf"][..], arguments].concat()).code
    };
    assert_eq!(code(&["--functions", "fly"]), 2);
    assert_eq!(code(&["--payload", "nobody"]), 2);
    assert_eq!(code(&["--runtime-inertia", "nobody"]), 2);
    assert_eq!(code(&["--type-name", "my arm"]), 2);
    assert_eq!(code(&["--modules", r#"[["nobody"]]"#]), 2);
    assert_eq!(code(&["--check"]), 2, "without a file");
    assert_eq!(code(&["--c-header", "a.h"]), 2, "without a file");
    assert_eq!(code(&["-o", "no/such/folder/arm.rs"]), 2);
    assert_eq!(modyn(&["generate", "no_such.urdf"]).code, 2);
    assert_eq!(modyn(&["generate", "modyn-read/tests/bad/cycle.urdf"]).code, 1);
    // Diagnostics name the file as the user did.
    let found = modyn(&["generate", "modyn-read/tests/bad/cycle.urdf"]);
    assert!(found.err.contains("--> modyn-read/tests/bad/cycle.urdf:"), "{}", found.err);
}

#[test]
fn kernels_for_graphics_processors() {
    let shown = modyn(&["generate", "robots/arm6.urdf", "--target", "wgsl"]);
    assert_eq!(shown.code, 0, "{}", shown.err);
    assert!(shown.out.contains("fn arm6_forward_dynamics(@builtin(global_invocation_id)"));
    let refused = modyn(&["generate", "robots/arm6.urdf", "--target", "cuda", "--self-contained"]);
    assert_eq!(refused.code, 2);
    assert!(refused.err.contains("`--self-contained` is about Rust, not `--target cuda`"));
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("arm.cu").display().to_string();
    let write = ["generate", "robots/arm6.urdf", "--target", "cuda", "-o", &file];
    assert_eq!(modyn(&write).code, 0);
    let check =
        |robot| modyn(&["generate", robot, "--target", "cuda", "-o", &file, "--check"]).code;
    assert_eq!((check("robots/arm6.urdf"), check("robots/gripper.urdf")), (0, 1));
}

#[test]
fn rollouts_for_graphics_processors() {
    let folder = tempfile::tempdir().expect("a folder");
    let cost = at(folder.path(), "cost.wgsl");
    let text = "fn cost(q: array<f32, 6>, qd: array<f32, 6>, u: array<f32, 6>, step: u32) -> f32 { return q[0]; }";
    std::fs::write(&cost, text).expect("writes");
    let generate = |more: &[&str]| {
        let arguments = ["generate", "robots/arm6.urdf", "--functions", "step_semi_implicit"];
        modyn(&[&arguments, more].concat())
    };
    let shown = generate(&["--target", "wgsl", "--rollout", "--cost", &cost]);
    assert_eq!(shown.code, 0, "{}", shown.err);
    assert!(
        shown.out.contains("fn arm6_rollout_semi_implicit(@builtin") && shown.out.contains(text)
    );
    let shown = generate(&["--target", "cuda", "--rollout"]);
    assert!(shown.out.contains("arm6_rollout_semi_implicit(const double *__restrict__ start_q"));
    let refused = generate(&["--target", "c", "--rollout"]);
    assert_eq!(refused.code, 2);
    assert!(refused.err.contains("`--rollout` is about"), "{}", refused.err);
    let refused = generate(&["--target", "wgsl", "--rollout", "--cost", "none.wgsl"]);
    assert_eq!(refused.code, 2);
    assert!(refused.err.contains("cannot read none.wgsl"), "{}", refused.err);
    let refused = modyn(&["generate", "robots/arm6.urdf", "--target", "wgsl", "--rollout"]);
    assert_eq!(refused.code, 2);
    assert!(refused.err.contains("step_semi_implicit"), "{}", refused.err);
}

/// CasADi, which differentiates all functions, says why it leaves out the solver of a step; other
/// languages have it.
#[test]
fn languages_have_the_solver_of_a_step() {
    let functions = ["--functions", "[mass_matrix, step, regressor]"];
    let generate = |target: &str| {
        let robot = ["generate", "robots/double_pendulum.urdf", "--target", target];
        modyn(&[&robot[..], &functions].concat())
    };
    for (target, text) in [
        ("rust", "pub fn step("),
        ("cuda", " double_pendulum_step("),
        ("wgsl", "fn double_pendulum_step("),
    ] {
        let shown = generate(target);
        assert!(shown.out.contains(text), "{target}: {}", shown.err);
        assert!(!shown.err.contains("`step`"), "{target}: {}", shown.err);
    }
    let warned = generate("casadi");
    assert_eq!(warned.code, 0, "{}", warned.err);
    for text in [
        "`step` has no form for CasADi, and is left out",
        "a loop whose end depends on values",
        "`regressor` has no form for CasADi, and is left out",
        "by `jacobian` or `gradient`",
    ] {
        assert!(warned.err.contains(text), "{text}: {}", warned.err);
    }
    assert!(warned.out.contains("mass_matrix") && !warned.out.contains("_step("));
}

#[test]
fn functions_for_casadi() {
    let generate = ["generate", "robots/double_pendulum.urdf", "--target", "casadi"];
    let with = |arguments: &[&str]| modyn(&[&generate[..], arguments].concat());
    let shown = with(&["--functions", "forward_dynamics"]);
    assert_eq!(shown.code, 0, "{}", shown.err);
    for name in ["", "jac_", "fwd1_", "adj1_", "jac_adj1_"] {
        let name = format!("int {name}double_pendulum_forward_dynamics(const casadi_real** arg");
        assert!(shown.out.contains(&name), "{name}");
    }
    let refused = with(&["--self-contained"]);
    assert_eq!(refused.code, 2);
    assert!(refused.err.contains("`--self-contained` is about Rust, not `--target casadi`"));
    let refused = with(&["--scalar", "f32"]);
    assert_eq!(refused.code, 2, "{}", refused.err);
    assert!(refused.err.contains("double precision"), "{}", refused.err);
    let warned = with(&["--functions", "[mass_matrix, regressor]"]);
    assert_eq!(warned.code, 0);
    assert!(warned.err.contains("`regressor` has no form for CasADi"), "{}", warned.err);
}
