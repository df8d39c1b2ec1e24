//! A C compiler accepts the header of the functions for C without a diagnostic.

use std::path::{Path, PathBuf};
use std::process::Command;

use modyn_codegen::{Builder, FloatType, Function};

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c_header");
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// A robot whose names end comments, start comments, and become the same identifier.
const HOSTILE: &str = r#"<robot name='a*/ int x; /* ??/ \'><link name='b*/'/><link name='int'/>
    <joint name='j' type='continuous'><parent link='b*/'/><child link='int'/></joint>
    <link name='/*x'/><joint name='k' type='fixed'><parent link='int'/><child link='/*x'/></joint>
    <link name='x'/><joint name='l' type='fixed'><parent link='int'/><child link='x'/></joint>
    <link name='X'/><joint name='m' type='fixed'><parent link='int'/><child link='X'/></joint>
    <link name='1 é \&#10;y'/><joint name='n' type='fixed'><parent link='int'/><child link='1 é \&#10;y'/></joint>
    </robot>"#;

fn header(builder: Builder) -> String {
    let all = Function::ALL.iter().copied();
    let builder = builder.functions(all).self_contained().c_functions("rob");
    let generated = builder.generate().unwrap_or_else(|errors| panic!("{errors}"));
    generated.c_header.expect("functions for C")
}

/// Returns a C program that takes the address of each function, with plain pointers, and calls one.
fn program(header: &str, number: &str) -> String {
    let mut text = String::from("#include \"rob.h\"\n#include \"rob.h\"\n");
    let mut declared = 0;
    for line in header.lines().filter(|line| line.ends_with(");")) {
        let (returned, rest) = line.split_once(" rob_").expect("a function");
        let (name, arguments) = rest.split_once('(').expect("arguments");
        let arguments = arguments.trim_end_matches(");").split(", ").map(|argument| {
            let (before, _) = argument.split_once('[').unwrap_or((argument, ""));
            match before.split(' ').collect::<Vec<_>>()[..] {
                ["const", kind, _] => format!("const {kind} *"),
                ["size_t", _] => "size_t".into(),
                [kind, _] => format!("{kind} *"),
                _ => panic!("{argument}"),
            }
        });
        let arguments = arguments.collect::<Vec<_>>().join(", ");
        text += &format!("{returned} (*const f_{name})({arguments}) = rob_{name};\n");
        declared += 1;
    }
    assert!(declared > 25, "{declared} functions");
    text + &format!(
        "{number} energy(void) {{\n    {number} q[ROB_NQ] = {{0}}, qd[ROB_NV] = {{0}};\n    rob_pose_t pose;\n    \
         const {number} *given = q;\n    \
         enum rob_link link = (enum rob_link)(ROB_LINKS - 1);\n    \
         if (!rob_link_pose(given, link, &pose)) return pose.rotation[0][1];\n    \
         return rob_kinetic_energy(given, qd);\n}}\n"
    )
}

#[test]
fn compilers_take_it_without_a_word() {
    let compiler = std::env::var_os("CC").unwrap_or("cc".into());
    if Command::new(&compiler).arg("--version").output().is_err() {
        eprintln!("left out: there is no C compiler ({})", compiler.display());
        return;
    }
    let robot = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots").join(name);
    let arm = Builder::new().urdf(robot("joint_zoo.urdf"));
    let bar = Builder::new().urdf(robot("four_bar.urdf")).scalar(FloatType::F32);
    let massive = HOSTILE.replace(
        "<link name='int'/>",
        "<link name='int'><inertial><mass value='1'/>\
         <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>",
    );
    let odd = Builder::new().urdf_text(massive, "odd.urdf");
    let folder = folder();
    for (builder, number) in [(arm, "double"), (bar, "float"), (odd, "double")] {
        let header = header(builder);
        std::fs::write(folder.join("rob.h"), &header).expect("writes");
        std::fs::write(folder.join("main.c"), program(&header, number)).expect("writes");
        for standard in ["c99", "c11", "c17"] {
            let mut command = Command::new(&compiler);
            command.current_dir(&folder).arg(format!("-std={standard}"));
            command.args(["-pedantic", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "main.c"]);
            let output = command.output().expect("runs");
            let errors = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{standard}: {errors}\n{header}");
        }
        let mut cpp = Command::new("c++");
        cpp.current_dir(&folder).args(["-std=c++17", "-pedantic", "-Wall", "-Wextra", "-Werror"]);
        cpp.args(["-fsyntax-only", "-x", "c++", "-include", "rob.h", "/dev/null"]);
        if let Ok(output) = cpp.output() {
            let errors = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "C++: {errors}\n{header}");
        }
    }
}

/// The header includes no file that its functions do not need, and links are named.
#[test]
fn links_are_an_enum_and_nothing_unused_is_included() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/gripper.urdf");
    let builder = Builder::new().urdf(path).self_contained().c_functions("rob");
    let of = |function| {
        let generated = builder.clone().functions([function]).generate().expect("good");
        generated.c_header.expect("functions for C")
    };
    let (dynamics, pose) = (of(Function::ForwardDynamics), of(Function::LinkPose));
    assert!(!dynamics.contains("#include"), "{dynamics}");
    assert_eq!(pose.matches("#include").count(), 2);
    assert!(dynamics.contains("enum rob_link {\n    ROB_LINK_"), "{dynamics}");
    assert!(builder.clone().functions([]).generate().expect("good").c_header.is_some());
}
