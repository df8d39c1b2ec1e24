//! The page of a generated type: a usage example, the options, methods before constants, mimic joints, offsets of
//! joints, parents of links.

use modyn_codegen::{Builder, Function};

/// A floating base, a joint with a mimic joint on it, and a link that is fixed to the mimic joint's link.
const URDF: &str = r#"<robot name="hand">
    <link name="world"/>
    <joint name="base" type="floating"><parent link="world"/><child link="palm"/></joint>
    <link name="palm"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
    <joint name="finger" type="continuous"><parent link="palm"/><child link="phalanx"/></joint>
    <link name="phalanx"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
    <joint name="tendon" type="continuous">
        <parent link="phalanx"/><child link="tip"/><mimic joint="finger" multiplier="0.5" offset="0.25"/>
    </joint>
    <link name="tip"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
    <joint name="glue" type="fixed"><parent link="tip"/><child link="nail"/></joint>
    <link name="nail"/>
</robot>"#;

fn text(builder: &Builder) -> String {
    builder.clone().urdf_text(URDF, "hand.urdf").generate().expect("a good robot").text
}

/// The documentation of the type.
fn page(builder: &Builder) -> String {
    let text = text(builder);
    let lines = text.lines().take_while(|line| line.starts_with("///"));
    lines.map(|line| line.trim_start_matches("///").trim_start().to_owned() + "\n").collect()
}

fn place(text: &str, part: &str) -> usize {
    text.find(part).unwrap_or_else(|| panic!("no {part:?} in\n{text}"))
}

#[test]
fn it_starts_with_an_example_and_the_joints() {
    let page = page(&Builder::new());
    assert!(page.starts_with("Dynamics of the robot `hand`, compiled by modyn: 3 moving joints"));
    let example = "let q = Hand::NEUTRAL;\nlet qd = [0.0; Hand::NV];\nlet tau = [0.0; Hand::NV];\n\
                   let qdd = Hand::forward_dynamics(&q, &qd, &tau);\n\
                   let pose = Hand::link_pose(&q, HandLink::Tip);\n";
    assert!(place(&page, example) < place(&page, "# Joints"), "{page}");
    for row in [
        "| 0 | `base` | floating | 0..7 | 0..6 | `palm` | the base |",
        "| 1 | `finger` | continuous | 7 | 6 | `phalanx` | `palm` |",
        "| 2 | `tendon` | continuous, mimics `finger`: 0.5 q + 0.25 | 7 | 6 | `tip` | `phalanx` |",
    ] {
        assert!(page.contains(row), "{page}");
    }
}

#[test]
fn it_lists_the_options() {
    let plain = page(&Builder::new());
    for option in ["- `scalar = f64`", "- `functions = default`", "- `gravity = [0.0, 0.0, -9.81]`"]
    {
        assert!(plain.contains(option), "{plain}");
    }
    let changed = Builder::new()
        .functions([Function::MassMatrix, Function::Jacobian])
        .runtime_gravity()
        .payload(["nail"])
        .share_limbs();
    let page = page(&changed);
    for option in [
        "- `functions = [mass_matrix, jacobian]`",
        "- `runtime_gravity = true`",
        "- `payload`: `nail`",
        "- `share_limbs = true`",
    ] {
        assert!(page.contains(option), "{page}");
    }
    assert!(page.contains("let mass_matrix = Hand::mass_matrix(&q);"), "{page}");
    assert!(page.contains("let jacobian = Hand::jacobian(&q, HandLink::Tip);"), "{page}");
}

#[test]
fn methods_come_before_constants() {
    let text = text(&Builder::new());
    assert!(place(&text, "pub fn forward_dynamics(") < place(&text, "pub const NAME:"));
}

#[test]
fn parents_of_links_are_the_moving_links_that_carry_them() {
    let text = text(&Builder::new());
    let (_, rest) = text.split_once("pub const LINK_PARENTS").expect("a constant");
    let (_, list) = rest.split_once(" = [").expect("a list");
    let parents = list.split_once("];").expect("its end").0.replace("::core::option::Option::", "");
    // world, palm, phalanx, tip, nail
    assert_eq!(parents, "None, None, Some(1), Some(2), Some(3)");
}

/// The type of a robot has a constant for each keyframe, and the embedded model has them.
#[test]
fn keyframes_are_constants() {
    let text = r#"<mujoco model="m"><option timestep="0.004"/>
        <worldbody><body><joint name="j"/><geom size="1"/></body></worldbody>
        <actuator><motor joint="j"/></actuator><keyframe>
        <key name="home" qpos="0.5" qvel="0.25" ctrl="3"/><key name="Home" qpos="1"/><key name="neutral"/>
        <key name="to the left" qpos="2"/>
        <key name="limits" qpos="3"/></keyframe></mujoco>"#;
    let builder =
        Builder::new().mjcf_text(text, "m.xml").functions([Function::MassMatrix]).embed_model();
    let code = builder.generate().expect("a robot").text;
    for line in [
        "pub const HOME: [f64; 1] = [0.5];",
        "pub const HOME_QD: [f64; 1] = [0.25];",
        "pub const HOME_CTRL: [f64; 1] = [3.0];",
        "pub const TIME_STEP: f64 = 0.004;",
        "pub const HOME_KEYFRAME: [f64; 1] = [1.0];",
        "pub const NEUTRAL_KEYFRAME: [f64; 1] = [0.0];",
        "pub const TO_THE_LEFT: [f64; 1] = [2.0];",
        "pub const LIMITS_KEYFRAME: [f64; 1] = [3.0];",
        r#"pub const KEYFRAMES: [(&'static str, [f64; 1]); 5] = [("home", Self::HOME), ("Home", Self::HOME_KEYFRAME), "#,
        r#"Keyframe { name: "home".into(), q: [0.5].into(), qd: [0.25].into(), ctrl: [3.0].into(), act: [].into() }"#,
        "time_step: Some(0.004)",
    ] {
        assert!(code.contains(line), "{line}: {code}");
    }
}
