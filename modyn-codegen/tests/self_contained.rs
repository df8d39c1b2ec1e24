//! Files that depend on `core` alone, and files in version control that are compared with generated text.

use std::path::{Path, PathBuf};
use std::process::Command;

use modyn_codegen::{Builder, Contact, ContactKind, FloatType, Function, FusedFunction, LoopEnd};

fn robot(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots").join(name)
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Returns whether rustc accepts the file as a module of a crate with these attributes.
fn compiles(file: &Path, attributes: &str) -> bool {
    let root = file.with_extension("crate.rs");
    let module = file.file_stem().expect("a name").to_string_lossy();
    let text = format!(
        "//! A crate.\n#![no_std]\n{attributes}\n/// A robot.\n#[path = {file:?}]\npub mod {module};\n"
    );
    std::fs::write(&root, text).expect("writes");
    let rustc = std::env::var_os("RUSTC").unwrap_or("rustc".into());
    let arguments = [
        "--edition=2024",
        "--crate-type=lib",
        "--crate-name=robot",
        "--emit=metadata",
        "--out-dir",
    ];
    let mut command = Command::new(rustc);
    let output = command.args(arguments).arg(file.parent().expect("a folder")).arg(root).output();
    let output = output.expect("rustc runs");
    println!("{}", String::from_utf8_lossy(&output.stderr));
    output.status.success()
}

/// Links and joints whose identifiers are equal, and a robot whose name is a keyword, with all its types.
#[test]
fn names_that_are_numbered_cause_no_warning() {
    let folder = folder("numbered");
    let part = |name: &str, hinge: &str, parent: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0.1 0 0'/><mass value='1'/>\
             <inertia ixx='0.1' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'/></inertial></link>\
             <joint name='{hinge}' type='continuous'><parent link='{parent}'/><child link='{name}'/><axis xyz='0 1 0'/></joint>"
        )
    };
    for robot in ["clash", "Self", "self", "a_1"] {
        let parts = [
            part("left_hand", "lefta", "base"),
            part("left-hand", "left.a", "left_hand"),
            part("self", "left a", "base"),
            part("joint_1_2", "Self", "base"),
        ];
        let text = format!("<robot name='{robot}'><link name='base'/>{}</robot>", parts.concat());
        let file = folder.join(format!("robot_{}.rs", robot.to_lowercase()));
        let end = LoopEnd { link: "left_hand".into(), xyz: [0.0; 3], rpy: [0.0; 3] };
        let contact = Contact { name: "tip".into(), kind: ContactKind::Point, end };
        let builder = Builder::new().text(text, "robot.urdf").self_contained();
        let builder = builder.contacts([contact]).payload(["left_hand"]);
        let fused = FusedFunction::new("state")
            .function(Function::LinkPoses)
            .function(Function::MassMatrix);
        let functions =
            [Function::ForwardDynamics, Function::Brge, Function::LinkPoses, Function::MassMatrix];
        builder.functions(functions).fused([fused]).write(&file).expect("good");
        assert!(compiles(&file, "#![deny(warnings)]"), "{robot}");
    }
}

#[test]
fn a_file_needs_nothing_but_core() {
    let folder = folder("needs");
    // All functions of small robots, and all joint types.
    let robots = [
        ("joint_zoo", FloatType::F32, Function::DEFAULT),
        ("mimic_gripper", FloatType::F64, Function::ALL),
        ("four_bar", FloatType::F32, Function::ALL),
    ];
    for (name, float, functions) in robots {
        let builder = Builder::new().urdf(robot(&format!("{name}.urdf"))).scalar(float);
        let builder = builder.functions(functions.iter().copied()).self_contained();
        let link = builder.generate().expect("good").model.moving_links()[0].name.clone();
        let fused = FusedFunction::new("state")
            .of_link(Function::Jacobian, link)
            .function(Function::Brge)
            .function(Function::LinkPoses);
        let builder = builder.fused([fused]);
        let file = folder.join(format!("{name}.rs"));
        builder.write(&file).expect("good");
        let text = std::fs::read_to_string(&file).expect("written");
        for foreign in ["::modyn", "modyn_runtime::", "libm::", "feature =", "std::", "alloc::"] {
            assert!(!text.contains(foreign), "{foreign}");
        }
        syn::parse_file(&text).expect("Rust");
        assert!(compiles(&file, "#![forbid(unsafe_code)]\n#![deny(warnings, missing_docs)]"));
        // Payloads need further parts of the runtime.
        let link = builder.generate().expect("good").model.moving_links()[0].name.clone();
        let file = folder.join(format!("{name}_payload.rs"));
        builder
            .runtime_inertia([&link])
            .payload([link])
            .runtime_gravity()
            .write(&file)
            .expect("good");
        assert!(compiles(&file, "#![forbid(unsafe_code)]\n#![deny(warnings, missing_docs)]"));
    }
}

/// The file alone compiles with `rustc --crate-type lib`, whose default edition is 2015.
#[test]
fn a_file_compiles_in_every_edition() {
    let folder = folder("editions");
    let builder =
        Builder::new().urdf(robot("mimic_gripper.urdf")).type_name("Option").c_functions("zoo");
    let fused =
        FusedFunction::new("state").function(Function::LinkPoses).function(Function::MassMatrix);
    let builder = builder.functions(Function::ALL.iter().copied()).self_contained();
    let builder = builder.fused([fused]);
    let link = builder.generate().expect("good").model.moving_links()[0].name.clone();
    let file = folder.join("zoo.rs");
    builder.payload([link]).runtime_gravity().write(&file).expect("good");
    let rustc = std::env::var_os("RUSTC").unwrap_or("rustc".into());
    for edition in ["", "--edition=2018", "--edition=2024"] {
        let mut command = Command::new(&rustc);
        command.args(Some(edition).filter(|edition| !edition.is_empty()));
        command.args(["--crate-type=lib", "--emit=metadata", "-Dwarnings", "--out-dir"]);
        let output = command.arg(&folder).arg(&file).output().expect("rustc runs");
        assert!(output.status.success(), "{edition}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn functions_for_c_compile_where_their_names_may_stand() {
    let file = folder("c").join("arm.rs");
    let builder = Builder::new().urdf(robot("gripper.urdf")).self_contained().c_functions("grip");
    builder.functions(Function::ALL.iter().copied()).write(&file).expect("good");
    let text = std::fs::read_to_string(&file).expect("written");
    assert!(text.contains(
        "pub extern \"C\" fn grip_forward_dynamics(q: &[f64; 4], qd: &[f64; 4], tau: &[f64; 4], out: &mut [f64; 4]) {"
    ));
    assert!(text.contains("fn grip_kinetic_energy(q: &[f64; 4], qd: &[f64; 4]) -> f64 {"));
    assert!(compiles(&file, "#![deny(warnings, missing_docs, unsafe_code)]"));
    let file = folder("c_loops").join("bar.rs");
    let builder = Builder::new().urdf(robot("four_bar.urdf")).self_contained().c_functions("bar");
    builder.write(&file).expect("good");
    let text = std::fs::read_to_string(&file).expect("written");
    assert!(text.contains(
        "fn bar_constrained_forward_dynamics(q: &[f64; 3], qd: &[f64; 3], tau: &[f64; 3], settings: &[f64; 4], out: &mut [f64; 16])"
    ));
    assert!(compiles(&file, "#![deny(warnings, missing_docs, unsafe_code)]"));
    for name in ["", "4", "a b", "a\n"] {
        assert!(Builder::new().urdf(robot("gripper.urdf")).c_functions(name).generate().is_err());
    }
}

#[test]
fn a_file_says_how_it_was_made_and_knows_when_it_is_stale() {
    let folder = folder("stale");
    let (urdf, file) = (folder.join("gripper.urdf"), folder.join("gripper.rs"));
    let description = std::fs::read_to_string(robot("gripper.urdf")).expect("a robot");
    std::fs::write(&urdf, &description).expect("writes");
    let _ = std::fs::remove_file(&file);
    let builder = Builder::new().urdf(&urdf).scalar(FloatType::F32).self_contained();
    let builder = builder.functions([Function::ForwardDynamics]);
    assert!(builder.is_stale(&file).expect("good"), "there is none yet");
    builder.write(&file).expect("good");
    assert!(!builder.is_stale(&file).expect("good"));

    let text = std::fs::read_to_string(&file).expect("written");
    let head =
        text.lines().take_while(|line| line.starts_with("//")).collect::<Vec<_>>().join("\n");
    assert!(head.contains(env!("CARGO_PKG_VERSION")) && head.contains(".scalar(FloatType::F32)"));
    assert!(
        head.contains(".urdf(\"gripper.urdf\")") && head.contains(".self_contained()"),
        "{head}"
    );
    assert!(!text.contains(&*folder.to_string_lossy()), "no path of this machine");

    // Line ends of the checkout do not matter; any other difference does.
    std::fs::write(&file, text.replace('\n', "\r\n")).expect("writes");
    assert!(!builder.is_stale(&file).expect("good"));
    std::fs::write(&file, text.replacen("0.", "1.", 1)).expect("writes");
    assert!(builder.is_stale(&file).expect("good"), "edited by hand");
    builder.write(&file).expect("good");
    assert!(builder.clone().scalar(FloatType::F64).is_stale(&file).expect("good"), "an option");
    std::fs::write(&urdf, format!("{description}<!-- more -->")).expect("writes");
    assert!(builder.is_stale(&file).expect("good"), "another description");
    assert!(builder.write(folder.join("no/such/folder.rs")).is_err());
}
