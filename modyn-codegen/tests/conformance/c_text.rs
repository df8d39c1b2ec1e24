//! The texts of generated C. `of_gcc` compares its numbers with those of programs.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::Command;

use modyn_codegen::{Base, Builder, CodeForm, Contact, ContactKind, Function, LoopEnd, Target};
use modyn_runtime::{ConstraintSettings, ContactTarget};

use crate::conformance::c::{STRICT, write};
use crate::conformance::{command, contact, folder, robot};

/// Compiles the C of `builder` in a folder; returns the folder and the header.
fn compiled(name: &str, builder: &Builder) -> (PathBuf, String) {
    let emitted = builder.clone().type_name("Ours").emit(Target::C).expect("good");
    let folder = folder(&format!("c_text_{name}"));
    assert_eq!(emitted.prefix, "ours");
    write(&emitted, &folder);
    let mut gcc = Command::new("gcc");
    gcc.args(STRICT).args(["-O2", "-c", "ours.c", "-o", "ours.o"]);
    command(gcc.current_dir(&folder));
    (folder, emitted.files[1].text.clone())
}

/// Returns a chain of joints in general position.
fn chain(joints: usize) -> Builder {
    let mut text = String::from("<robot name='chain'><link name='0'/>");
    for i in 1..=joints {
        let x = (0.7 * i as f64).sin();
        let _ = write!(
            text,
            "<joint name='{i}' type='continuous'><origin xyz='0.1 {x} 0.3' rpy='0.3 {x} -0.4'/>\
             <axis xyz='0.6 0.48 0.64'/><parent link='{}'/><child link='{i}'/></joint>\
             <link name='{i}'><inertial><origin xyz='{x} 0.1 0.2'/><mass value='{}'/>\
             <inertia ixx='1' iyy='1.1' izz='1.2' ixy='0.1' ixz='0' iyz='0.05'/></inertial></link>",
            i - 1,
            2.0 + x,
        );
    }
    Builder::new().urdf_text(text + "</robot>", "chain.urdf").functions([Function::ForwardDynamics])
}

/// A program that finds numbers by the names of the header, in C and in C++.
const BY_NAME: &str = r#"
#include <stdio.h>
#include <string.h>
#include "ours.h"

static void print(const double *numbers, size_t size) {
    size_t i;
    for (i = 0; i < size / sizeof *numbers; i++) printf("%.17g ", numbers[i]);
}

int main(void) {
    ours_step_settings_t settings = ours_default_step_settings;
    ours_constraint_settings_t constraints = ours_default_constraint_settings;
    ours_contact_target_t *target = &constraints.targets[OURS_CONTACT_RIGHT];
    settings.impratio = 2.0;
    settings.surfaces[OURS_SHAPE_LEFT].friction = 0.25;
    settings.surfaces[OURS_SHAPE_RIGHT].plane.translation[2] = -0.5;
    settings.surfaces[OURS_SHAPE_RIGHT].solimp[3] = 0.75;
    print((const double *)&settings, sizeof settings);
    target->pose.translation[1] = 1.0;
    target->pose.rotation[1][2] = 0.125;
    target->velocity.linear[0] = 2.0;
    target->compliance = 3.0;
    target->weight = 4.0;
    print((const double *)&constraints, sizeof constraints);
    printf("%d %d %d\n", OURS_Q_FRONT_LEFT_KNEE, OURS_V_FRONT_LEFT_KNEE, OURS_LINK_FRONT_LEFT_FOOT);
    if (strcmp(ours_v_names[OURS_V_FRONT_LEFT_KNEE], "front_left_knee")) return 1;
    if (strcmp(ours_contact_names[OURS_CONTACT_RIGHT], "right")) return 2;
    return OURS_CONTACT_LEFT;
}
"#;

/// Settings, coordinates and links have names in the header, without a word of a compiler.
#[test]
fn numbers_have_names() {
    let feet = [("left", "front_left_foot"), ("right", "hind_right_foot")];
    let feet = feet.map(|(name, link)| contact(name, ContactKind::Point, link, [0.0; 3]));
    let functions = [Function::Step, Function::ConstrainedForwardDynamics];
    let builder = robot("quadruped").base(Base::Floating).contacts(feet).functions(functions);
    let (folder, header) = compiled("by_name", &builder);
    for name in ["LINK_NAMES", "CONTACT_NAMES", "PARAMETERS`"] {
        assert!(!header.contains(name), "{name} is no name of C");
    }
    let model = builder.generate().expect("good").model;
    let place =
        |names: &[String], name: &str| names.iter().position(|x| x == name).expect(name) as f64;
    let mut settings = model.step_settings();
    settings.impratio = 2.0;
    settings.surfaces[0].friction = 0.25;
    settings.surfaces[1].plane.translation[2] = -0.5;
    settings.surfaces[1].solimp[3] = 0.75;
    let mut constraints = ConstraintSettings::<f64, [ContactTarget<f64>; 2]>::DEFAULT;
    let target = &mut constraints.targets[1];
    target.pose.rotation[1][2] = 0.125;
    target.pose.translation[1] = 1.0;
    target.velocity.linear.0[0] = 2.0;
    target.compliance = 3.0;
    target.weight = 4.0;
    let link = model.link_index("front_left_foot").expect("a link") as f64;
    let mut expected = settings.all_numbers();
    expected.extend(constraints.numbers());
    expected.extend(constraints.targets.iter().flat_map(ContactTarget::numbers));
    expected.push(place(&model.coordinate_names(), "front_left_knee"));
    expected.push(place(&model.velocity_names(), "front_left_knee"));
    expected.push(link);
    let strict = ["-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic"];
    for (compiler, standard, file) in [
        ("gcc", "-std=c99", "names.c"),
        ("gcc", "-std=c11", "names.c"),
        ("g++", "-std=c++17", "names.cpp"),
    ] {
        std::fs::write(folder.join(file), BY_NAME).expect("writes");
        let mut compile = Command::new(compiler);
        compile.arg(standard).args(strict).args([file, "ours.o", "-lm", "-o", "names"]);
        command(compile.current_dir(&folder));
        let printed = command(&mut Command::new(folder.join("names")));
        let numbers = printed.split_whitespace().map(|x| x.parse().expect("a number"));
        assert_eq!(numbers.collect::<Vec<f64>>(), expected, "{compiler} {standard}");
    }
}

/// The instructions of loops take as many bytes for 112 joints as for 14.
#[test]
fn the_instructions_of_loops_do_not_grow_with_the_robot() {
    let bytes = |joints: usize, code: CodeForm| -> usize {
        let name = format!("chain{joints}_{code:?}");
        let (folder, _) = compiled(&name, &chain(joints).code(code));
        let sizes = command(Command::new("size").args(["-A", "ours.o"]).current_dir(&folder));
        let lines = sizes.lines().filter(|line| line.starts_with(".text"));
        let sizes = lines.filter_map(|line| line.split_whitespace().nth(1)?.parse::<usize>().ok());
        sizes.sum()
    };
    let [short, long] = [14, 112].map(|joints| bytes(joints, CodeForm::Looped));
    assert!(short.abs_diff(long) < 64 && long < MAX_LOOP, "{short} {long}");
    assert!(bytes(14, CodeForm::Unrolled) > 5 * short);
}

/// The largest number of bytes of forward dynamics of a chain in loops, with its own sine and cosine, by gcc.
const MAX_LOOP: usize = 9000;

/// The set of active contacts is an array of numbers, and the settings are a struct.
#[test]
fn contacts_are_arguments() {
    let point = |name: &str, link: &str| Contact {
        name: name.into(),
        kind: ContactKind::Point,
        end: LoopEnd { link: link.into(), xyz: [0.1; 3], rpy: [0.0; 3] },
    };
    let builder = robot("quadruped").base(Base::Floating);
    let feet = [point("left", "front_left_foot"), point("right", "hind_right_foot")];
    let builder = builder.functions([Function::ConstrainedForwardDynamics]).contacts(feet);
    let header = &builder.emit(Target::C).expect("good").files[1].text;
    let declared = "const double active[2], const quadruped_constraint_settings_t *settings, \
                    quadruped_constrained_forward_dynamics_t *out";
    assert!(header.contains(declared), "{header}");
}

#[test]
fn run_time_parameters_compile_and_have_their_defaults() {
    let builder = robot("gripper").runtime_gravity();
    let links = builder.generate().expect("good").model.moving_links().to_vec();
    let [replaced, loaded] = [1, 2].map(|link: usize| links[link].name.clone());
    let builder = builder.runtime_inertia([replaced]).payload([loaded]);
    let (folder, header) = compiled("parameters", &builder);
    assert!(header.contains("extern const double ours_default_parameters[23];"));
    assert!(header.contains(
        "void ours_gravity_torques_with(const double q[4], const double params[23], double out[4]);"
    ));
    // Gravity, the inertia of the description, and no payload.
    let source = std::fs::read_to_string(folder.join("ours.c")).expect("the source");
    let (_, defaults) = source.split_once("ours_default_parameters[23] = { ").expect("defaults");
    let defaults = defaults.split_once(" };").expect("an end").0.split(", ");
    let defaults: Vec<f64> = defaults.map(|x| x.parse().expect("a number")).collect();
    let own = builder.generate().expect("good").model;
    let own =
        own.links().iter().find(|frame| frame.moving_link == Some(1)).expect("a link").inertial;
    assert_eq!(defaults[..3], [0.0, 0.0, -9.81]);
    assert_eq!(defaults[3], own.mass);
    assert_eq!(defaults[4..7], own.center_of_mass);
    assert_eq!(defaults[7..13], own.inertia);
    assert_eq!(defaults[13..], [0.0; 10]);
    assert!(header.contains("void ours_gravity_torques(const double q[4], double out[4]);"));
    assert!(header.contains("void ours_brge_solve(const double factors["));
}

/// The description's names become parts of identifiers and nothing else.
#[test]
fn names_cannot_break_out() {
    let text = r#"<robot name="a */ #error b"><link name="w */ x"/>
        <joint name="j" type="continuous"><parent link="w */ x"/><child link="int"/></joint>
        <link name="int"><inertial><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;
    let builder = Builder::new().urdf_text(text, "a.urdf");
    let (_, header) = compiled("names", &builder);
    let links = "OURS_LINK_W_X = 0, /* `w * / x` */\n    OURS_LINK_INT = 1 /* `int` */\n";
    assert!(header.contains(links), "{header}");
    assert_eq!(builder.emit(Target::C).expect("good").prefix, "aerror_b");
}
