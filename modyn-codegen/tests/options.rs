//! The table of options: the builder takes each of them, and the first lines of generated files say it.

use std::path::Path;

use modyn_codegen::Builder;
use modyn_codegen::options::{OPTIONS, OptionRow, Value};

/// The value of the row's example.
fn example(row: &OptionRow) -> Value {
    let text = row.is_text() && !row.is_list();
    if text { Value::text(row.example) } else { Value::parse(row.example).expect(row.name) }
}

/// The first lines of the file that a builder writes.
fn head(builder: &Builder) -> String {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("options_of_files");
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("robot.rs");
    builder.write(&file).unwrap_or_else(|errors| panic!("{errors}"));
    let text = std::fs::read_to_string(&file).expect("a file");
    let lines = text.lines().take_while(|line| line.starts_with("//"));
    lines.map(|line| line.to_owned() + "\n").collect()
}

/// An arm that fits the examples.
const ARM: &str = r#"<robot name="arm">
    <link name="base"><inertial><origin xyz="0 0 0.1"/><mass value="3"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="shoulder" type="continuous">
        <parent link="base"/><child link="upper_arm"/><axis xyz="0 1 0"/>
        <dynamics damping="0.1" friction="0.1"/>
    </joint>
    <link name="upper_arm"><inertial><origin xyz="0.1 0 0.2"/><mass value="2"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="elbow" type="continuous">
        <parent link="upper_arm"/><child link="forearm"/><origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>
    </joint>
    <link name="forearm"><inertial><origin xyz="0 0.1 0.2"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="wrist" type="continuous">
        <parent link="forearm"/><child link="hand"/><origin xyz="0 0 0.4"/><axis xyz="1 0 0"/>
    </joint>
    <link name="hand"><inertial><origin xyz="0 0.1 0.1"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
"#;

/// The parts of a crank with a rod, for loops.
const CRANK: &str = r#"
    <joint name="turn" type="continuous">
        <parent link="base"/><child link="crank"/><origin xyz="1 0 0"/><axis xyz="0 1 0"/>
    </joint>
    <link name="crank"><inertial><origin xyz="0.2 0 0.1"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="push" type="continuous">
        <parent link="base"/><child link="rod"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    </joint>
    <link name="rod"><inertial><origin xyz="0.2 0 0.1"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
"#;

#[test]
fn a_generated_file_says_each_option() {
    for row in OPTIONS {
        let crank = if row.name == "loops" { CRANK } else { "" };
        let robot = format!("{ARM}{crank}</robot>");
        let plain = Builder::new().urdf_text(robot, "arm.urdf");
        let call = format!(".{}(", row.method);
        let without = head(&plain);
        assert!(!without.contains(&call), "{}: {without}", row.name);
        let with = head(&plain.set(row.name, &example(row)).expect(row.name));
        assert!(with.contains(&call), "{}: {with}", row.name);
    }
}

#[test]
fn a_value_of_another_form_is_refused() {
    for row in OPTIONS {
        let wrong = Value::parse("no(such, value)").expect("a value");
        let fault = Builder::new().set(row.name, &wrong).expect_err(row.name);
        assert!(fault.message.len() > 10, "{}: {}", row.name, fault.message);
    }
    let fault = Builder::new().set("colour", &Value::text("red")).expect_err("no such option");
    assert!(fault.message.contains("there are: gravity, base, "), "{}", fault.message);
}

/// Options and values by their earlier names are refused, and the message says the present names.
#[test]
fn earlier_names_lead_to_the_present_ones() {
    for (option, value, now) in [
        ("friction", "none", "`joint_friction`"),
        ("share", "true", "`share_limbs`"),
        ("unread_forces", "warn", "`unsupported_forces`"),
        ("bundles", "a: (mass_matrix)", "`fused`"),
        ("code", "fast", "`fast` is named `unrolled` now"),
        ("code", "small", "`small` is named `looped` now"),
        ("base", "described", "`described` is named `auto` now"),
    ] {
        let given = Value::parse(value).expect("a value");
        let fault = Builder::new().set(option, &given).expect_err(option);
        assert!(fault.message.contains(now), "{option} = {value}: {}", fault.message);
    }
    // Only options and values that had these words.
    let mimic = Builder::new().set("mimic", &Value::parse("described").expect("a value"));
    let message = mimic.expect_err("no such word").message;
    assert_eq!(message, "expected `follow` or `independent` or `refuse`");
}
