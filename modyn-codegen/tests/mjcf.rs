//! MuJoCo's models (MJCF). The same robot gives the same numbers as its URDF. An element that would change the dynamics
//! and is not supported is refused, with its line.

use modyn_codegen::diagnostics::{Code, Diagnostics, Severity};
use modyn_codegen::{Base, Builder, Loop, LoopEnd, ReadOptions};
use modyn_runtime::Interpreter;
use modyn_runtime::model::{LoopConstraintKind, Model};

fn read(text: &str) -> Result<Model, Diagnostics> {
    modyn_codegen::read_mjcf(text, "robot.xml", &ReadOptions::default())
        .map(|reading| reading.model)
}

/// Compares accelerations, torques and mass matrices of two models at some states.
fn assert_same_numbers(a: Model, b: Model) {
    assert_eq!((a.nq(), a.nv()), (b.nq(), b.nv()));
    let (nq, n) = (a.nq(), a.nv());
    let mut seed = 1_u64;
    let mut uniform = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut a, mut b) = (Interpreter::<f64>::new(a), Interpreter::<f64>::new(b));
    for _ in 0..20 {
        let mut q = vec![0.0; nq];
        a.random(&mut uniform, &mut q).expect("sizes");
        let qd: Vec<f64> = (0..n).map(|_| 4.0 * uniform() - 2.0).collect();
        let tau: Vec<f64> = (0..n).map(|_| 4.0 * uniform() - 2.0).collect();
        let evaluate = |of: &mut Interpreter<f64>| {
            let (mut qdd, mut bias, mut matrix) = (vec![0.0; n], vec![0.0; n], vec![0.0; n * n]);
            of.forward_dynamics(&q, &qd, &tau, &mut qdd).expect("sizes");
            of.bias_forces(&q, &qd, &mut bias).expect("sizes");
            of.mass_matrix(&q, &mut matrix).expect("sizes");
            [qdd, bias, matrix]
        };
        for (a, b) in evaluate(&mut a).iter().zip(&evaluate(&mut b)) {
            let size = b.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            assert!(size > 0.0);
            for (x, y) in a.iter().zip(b) {
                assert!((x - y).abs() <= 1e-12 * size, "{x} is not {y}");
            }
        }
    }
}

/// An arm with revolute and prismatic joints. It has each element that can be written in several ways: angles in
/// degrees, classes, a frame, diagonal and full inertias, and joint anchors away from the body's frame.
const ARM: &str = include_str!("mjcf/arm.xml");

const ARM_URDF: &str = r#"<robot name="arm">
  <link name="world"/>
  <link name="upper"><inertial><origin xyz="0 0.01 0.1"/><mass value="2"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.011" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="world"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0.17453292519943295 0.3490658503988659 1.5707963267948966"/><axis xyz="0 0 1"/>
    <limit lower="-2.96705972839036" upper="2.96705972839036" effort="0" velocity="0"/>
    <dynamics damping="0.1" armature="0.2" friction="0.3"/></joint>
  <link name="plate"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="bolts" type="fixed"><parent link="upper"/><child link="plate"/><origin xyz="0.01 0 0"/></joint>
  <!-- The elbow's frame is at its anchor. -->
  <link name="lower"><inertial>
    <origin xyz="0.08 0 -0.01" rpy="1.5707963267948966 0 1.5707963267948966"/><mass value="1"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0.002" iyz="0.003"/></inertial></link>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.02 0 0.31"/><axis xyz="0 1 0"/>
    <dynamics damping="0.1" armature="0.2" friction="0.3"/></joint>
  <link name="hand"><inertial><origin xyz="0 0 0.03"/><mass value="0.5"/>
    <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="reach" type="prismatic"><parent link="lower"/><child link="hand"/>
    <origin xyz="0.18 0 -0.01"/><axis xyz="1 0 0"/>
    <limit lower="-0.1" upper="0.1" effort="0" velocity="0"/><dynamics damping="0.1" armature="0.01"/></joint>
</robot>"#;

#[test]
fn the_same_arm_gives_the_same_numbers() {
    for friction in [
        modyn_codegen::Friction::None,
        modyn_codegen::Friction::Viscous,
        modyn_codegen::Friction::Smooth(0.1),
    ] {
        let options = ReadOptions { friction: Some(friction), ..ReadOptions::default() };
        let ours = modyn_codegen::read_mjcf(ARM, "arm.xml", &options).expect("an MJCF").model;
        let theirs = modyn_codegen::read(ARM_URDF, "arm.urdf", &options).expect("a URDF").model;
        let names = |model: &Model| model.coordinate_names();
        assert_eq!(names(&ours), names(&theirs));
        for (a, b) in ours.links().iter().zip(theirs.links()) {
            assert_eq!(a.joint.joint_type, b.joint.joint_type);
            assert_eq!(a.joint.dynamics, b.joint.dynamics);
            let range = |limits: Option<modyn_runtime::model::Limits>| {
                limits
                    .map(|limits| [limits.lower, limits.upper].map(|x| (x.unwrap() * 1e12).round()))
            };
            assert_eq!(range(a.joint.limits), range(b.joint.limits));
        }
        // The body's frame is MuJoCo's frame, which is not at the elbow's anchor.
        let lower = ours.frames().iter().find(|frame| frame.name == "lower").expect("its link");
        assert_eq!(lower.pose.translation, [-0.02, 0.0, -0.01]);
        assert_same_numbers(ours, theirs);
    }
}

/// The models in `mjcf/` give MuJoCo's results, which `mjcf/golden.py` wrote.
#[test]
fn the_numbers_are_those_of_mujoco() {
    for (text, golden) in [
        (ARM, include_str!("mjcf/arm.txt")),
        (include_str!("mjcf/rotations.xml"), include_str!("mjcf/rotations.txt")),
        (include_str!("mjcf/shapes.xml"), include_str!("mjcf/shapes.txt")),
        (include_str!("mjcf/fields.xml"), include_str!("mjcf/fields.txt")),
    ] {
        let mut robot = Interpreter::<f64>::new(read(text).expect("an MJCF"));
        let lines: Vec<Vec<f64>> = golden
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(' ').map(|text| text.parse().expect("a number")).collect())
            .collect();
        assert_eq!(lines.len(), 3 * 6);
        for state in lines.chunks(6) {
            let [q, qd, tau, qdd, bias, matrix] = state else { unreachable!("six lines") };
            let mut found = [qdd, bias, matrix].map(|expected| vec![0.0; expected.len()]);
            robot.forward_dynamics(q, qd, tau, &mut found[0]).expect("sizes");
            robot.bias_forces(q, qd, &mut found[1]).expect("sizes");
            robot.mass_matrix(q, &mut found[2]).expect("sizes");
            for (found, expected) in found.iter().zip([qdd, bias, matrix]) {
                let size = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                for (a, b) in found.iter().zip(expected) {
                    assert!((a - b).abs() < 1e-12 * size, "{a} is not {b}: {golden}");
                }
            }
        }
    }
}

#[test]
fn several_joints_of_a_body_and_balls() {
    let mjcf = r#"<mujoco model="m"><compiler angle="radian"/><option gravity="1 2 3"/><worldbody>
      <body pos="0.1 0.2 0.3"><inertial pos="0 0 0.1" mass="1" diaginertia="0.1 0.2 0.15"/>
        <joint type="slide" axis="1 0 0"/><joint axis="0 1 0" pos="0 0 0.5"/>
        <body name="bob" pos="0 0 0.4"><inertial pos="0.1 0 0" mass="1" diaginertia="0.1 0.2 0.15"/>
          <joint name="ball" type="ball"/></body></body></worldbody></mujoco>"#;
    let urdf = r#"<robot name="m"><link name="w"/><link name="cart"/><link name="arm">
        <inertial><origin xyz="0 0 -0.4"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <link name="bob"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
        <inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="x" type="prismatic"><parent link="w"/><child link="cart"/><origin xyz="0.1 0.2 0.3"/>
        <axis xyz="1 0 0"/><limit effort="0" velocity="0" lower="-1" upper="1"/></joint>
      <joint name="y" type="continuous"><parent link="cart"/><child link="arm"/><origin xyz="0 0 0.5"/>
        <axis xyz="0 1 0"/></joint>
      <joint name="ball" type="spherical"><parent link="arm"/><child link="bob"/><origin xyz="0 0 -0.1"/></joint>
      </robot>"#;
    let model = read(mjcf).expect("an MJCF");
    assert_eq!(model.gravity(), [1.0, 2.0, 3.0]);
    let names: Vec<&str> = model.links().iter().map(|link| link.joint.name.as_str()).collect();
    assert_eq!(names, ["body_1_joint", "body_1_joint_2", "ball"]);
    let on_earth = ReadOptions { gravity: Some([0.0, 0.0, -9.81]), ..ReadOptions::default() };
    let asked = modyn_codegen::read_mjcf(mjcf, "m.xml", &on_earth).expect("an MJCF").model;
    assert_eq!(asked.gravity(), [0.0, 0.0, -9.81]);
    let options = ReadOptions { gravity: Some([1.0, 2.0, 3.0]), ..ReadOptions::default() };
    assert_same_numbers(
        model,
        modyn_codegen::read(urdf, "m.urdf", &options).expect("a URDF").model,
    );
}

#[test]
fn surprises_are_warnings_with_their_lines() {
    let text = r#"<mujoco model="m"><worldbody>
      <body name="light">
        <joint name="damped" axis="0 1 0" damping="0.5"/>
        <body name="heavy" pos="0 0 0.4"><joint name="turn" axis="1 0 0"/>
          <inertial pos="0 0 0.1" mass="2600" diaginertia="0.02 0.02 0.02"/></body></body></worldbody></mujoco>"#;
    let read = modyn_codegen::read_mjcf(text, "m.xml", &ReadOptions::default()).expect("an MJCF");
    let found: Vec<_> =
        read.warnings.iter().map(|one| (one.code, one.position.map(|at| at.line))).collect();
    for expected in [
        (Code::MissingInertial, Some(3)),
        (Code::InactiveFriction, Some(3)),
        (Code::ImplausibleMass, Some(5)),
    ] {
        assert!(found.contains(&expected), "{expected:?}: {:?}", read.warnings);
    }
}

#[test]
fn a_free_body_is_a_floating_base() {
    let inertial = r#"<inertial pos="0.1 0 0" mass="3" diaginertia="0.1 0.2 0.15"/>"#;
    let model = read(&format!(
        r#"<mujoco model="m"><worldbody><body name="trunk" pos="0 0 1"><freejoint name="root"/>{inertial}</body>
           </worldbody></mujoco>"#
    ));
    let urdf = r#"<robot name="m"><link name="trunk"><inertial><origin xyz="0.1 0 0"/><mass value="3"/>
        <inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;
    let options = ReadOptions { base: Base::Floating, ..ReadOptions::default() };
    let theirs = modyn_codegen::read(urdf, "m.urdf", &options).expect("a URDF").model;
    assert_same_numbers(model.expect("an MJCF"), theirs);
}

/// The limits of joint forces are those of MuJoCo's `jnt_actfrcrange` where `jnt_actfrclimited` is true.
#[test]
fn ranges_of_joint_forces_are_effort_limits() {
    let joints = [
        (r#"<joint actuatorfrcrange="-3 3"/>"#, Some(3.0)),
        // From the classes: that of the joint, of its body, of the class around it, and of all joints.
        (r#"<joint class="weak"/>"#, Some(1.0)),
        ("<joint/>", Some(5.0)),
        (r#"<joint class="strong" type="slide"/>"#, Some(9.0)),
        (r#"<joint class="main"/>"#, Some(7.0)),
        (r#"<joint actuatorfrcrange="-3 3" actuatorfrclimited="false"/>"#, None),
        (r#"<joint actuatorfrcrange="0 0"/>"#, None),
        // Not the same in both directions.
        (r#"<joint actuatorfrcrange="-3 4"/>"#, None),
        // MuJoCo limits no forces of balls.
        (r#"<joint type="ball"/>"#, None),
    ];
    let inertial = r#"<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>"#;
    let bodies: String = joints
        .iter()
        .map(|(joint, _)| format!("\n<body childclass=\"arm\">{joint}{inertial}</body>"))
        .collect();
    let classes = r#"<default><joint actuatorfrcrange="-7 7"/><default class="arm"><joint actuatorfrcrange="-5 5"/>
        <default class="weak"><joint actuatorfrcrange="-1 1"/></default></default>
        <default class="strong"><joint actuatorfrcrange="-9 9"/><default class="loose"/></default></default>"#;
    let text = |compiler: &str| {
        format!("<mujoco model=\"m\">{compiler}{classes}<worldbody>{bodies}</worldbody></mujoco>")
    };
    let reading = modyn_codegen::read_mjcf(&text(""), "m.xml", &ReadOptions::default());
    let reading = reading.expect("an MJCF");
    let efforts = |model: &Model| -> Vec<Option<f64>> {
        model.links().iter().map(|link| link.joint.limits.and_then(|own| own.effort)).collect()
    };
    assert_eq!(efforts(&reading.model), joints.map(|(_, effort)| effort));
    let first = &reading.model.links()[0].joint;
    assert_eq!(first.joint_type, modyn_runtime::joint::JointType::Continuous);
    let found: Vec<_> =
        reading.warnings.iter().map(|one| (one.code, one.position.map(|at| at.line))).collect();
    assert_eq!(found, [(Code::NotRead, Some(11))], "{:?}", reading.warnings);
    let not_automatic = read(&text("<compiler autolimits=\"false\"/>")).expect("an MJCF");
    assert!(efforts(&not_automatic).iter().all(Option::is_none));
}

/// What MuJoCo has besides the equations of motion is named once, with the number of its elements.
#[test]
fn unread_elements_are_named() {
    let text = r#"<mujoco model="m"><default><motor forcerange="-1 1"/><site size="0.1"/></default><worldbody>
      <site name="origin"/>
      <body><joint name="j"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <site name="tip"/><frame><site name="heel"/></frame></body></worldbody>
      <actuator>
        <motor joint="j" forcerange="-1 1"/>
        <position joint="j" kp="high"/></actuator>
      <sensor><jointpos joint="j"/></sensor>
      <keyframe><key qpos="1"/></keyframe></mujoco>"#;
    let reading = modyn_codegen::read_mjcf(text, "m.xml", &ReadOptions::default());
    let warnings = reading.expect("an MJCF").warnings;
    let found: Vec<_> = warnings
        .iter()
        .map(|one| (one.code, one.position.map(|at| at.line), one.message.as_str()))
        .collect();
    let actuators =
        "the actuator is not read, nor is its range of forces; the same holds for line 7";
    let sites = "the site is not read; the same holds for 2 others: line 4, line 4";
    assert_eq!(
        found,
        [
            (Code::NotRead, Some(2), sites),
            (Code::NotRead, Some(6), actuators),
            (Code::NotRead, Some(9), "the keyframe is not read"),
        ]
    );
}

/// MuJoCo moves the frame of a free body without children to its principal axes of inertia, if it is told to.
#[test]
fn aligned_free_bodies_are_refused() {
    let inertial = r#"<inertial pos="0.1 0 0" mass="3" diaginertia="0.1 0.2 0.15"/>"#;
    let text = |align: &str, child: &str| {
        format!(
            "<mujoco model=\"m\"><worldbody><body>\n<freejoint align=\"{align}\"/>{inertial}{child}</body></worldbody></mujoco>"
        )
    };
    let found = read(&text("true", "")).expect_err("aligned").into_vec();
    let help = found[0].help.as_deref().unwrap_or_default();
    assert_eq!((found[0].code, found[0].position.map(|at| at.line)), (Code::NotRead, Some(2)));
    assert!(help.contains("`align=\"false\"`"), "{help}");
    let child = format!("<frame><body><joint/>{inertial}</body></frame>");
    for (align, child) in [("false", ""), ("auto", ""), ("true", &*child)] {
        read(&text(align, child)).expect("as in MuJoCo");
    }
}

/// Attributes that only concern parts that are not read are not judged.
#[test]
fn attributes_that_are_not_read_are_not_judged() {
    read(
        r#"<mujoco model="m"><compiler strippath="maybe"/><option timestep="short"/><asset><material rgba="red"/></asset>
        <worldbody><body sleep="never"><joint margin="wide"/><geom size="0.1" contype="-1" rgba="red"/></body></worldbody>
        <actuator><position kp="high"/></actuator></mujoco>"#,
    )
    .expect("an MJCF");
}

/// Asserts that a piece of the text is refused with this code, at line 2, where the piece is, and that the error is gone
/// once its help was followed.
fn assert_refused(before: &str, (bad, code, fixed): (&str, Code, Option<&str>), after: &str) {
    let text = |piece: &str| format!("<mujoco model=\"m\">{before}\n{piece}\n{after}</mujoco>");
    let mut found = read(&text(bad)).expect_err(bad).into_vec();
    found.retain(|one| one.severity == Severity::Error);
    let lines: Vec<_> =
        found.iter().map(|one| (one.code, one.position.map(|at| at.line))).collect();
    assert_eq!(lines, [(code, Some(2))], "{bad}: {found:?}");
    assert!(found[0].help.as_deref().is_some_and(|help| !help.is_empty()), "{bad}");
    if let Some(fixed) = fixed {
        read(&text(fixed)).expect(fixed);
    }
}

#[test]
fn unsupported_elements_are_refused() {
    let good = r#"<worldbody><body name="a"><joint name="j"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>"#;
    read(&format!("<mujoco model=\"m\">{good}</mujoco>")).expect("the good part");
    for (bad, fixed) in [
        // The help asks for the contents of another file.
        (r#"<include file="/etc/passwd"/>"#, None),
        (r#"<asset><model name="other" file="/etc/passwd"/></asset>"#, None),
        (
            r#"<equality><joint joint1="j"/></equality>"#,
            Some(r#"<equality><joint joint1="j" active="false"/></equality>"#),
        ),
        (
            r#"<tendon><fixed stiffness="1"><joint joint="j" coef="1"/></fixed></tendon>"#,
            Some("<tendon/>"),
        ),
        (r#"<default><tendon damping="1"/></default>"#, Some("<default/>")),
        (r#"<option viscosity="1e-3"/>"#, Some(r#"<option viscosity="0"/>"#)),
        (r#"<option><flag gravity="disable"/></option>"#, Some(r#"<option gravity="0 0 0"/>"#)),
        (r#"<compiler settotalmass="3"/>"#, Some("<compiler/>")),
        (r#"<compiler balanceinertia="true"/>"#, Some(r#"<compiler balanceinertia="false"/>"#)),
        (r#"<default class="other"/>"#, Some(r#"<default class="main"/>"#)),
        (r"<default><default/></default>", Some(r#"<default><default class="a"/></default>"#)),
        (r#"<compiler eulerseq="xyzx"/>"#, Some(r#"<compiler eulerseq="xyz"/>"#)),
        (r#"<compiler eulerseq="xyw"/>"#, Some(r#"<compiler eulerseq="XYZ"/>"#)),
        (r#"<compiler autolimits="yes"/>"#, Some(r#"<compiler autolimits="true"/>"#)),
        (r#"<compiler inertiagrouprange="0 1"/>"#, Some("<compiler/>")),
        (
            r#"<actuator><position joint="j" damping="1"/></actuator>"#,
            Some(r#"<actuator><position joint="j"/></actuator>"#),
        ),
        ("<deformable/>", Some("")),
    ] {
        assert_refused("", (bad, Code::NotRead, fixed), good);
    }
    let inertial = r#"<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>"#;
    let with_inertial =
        format!("<joint/><body><joint/>{inertial}<geom type=\"mesh\" mesh=\"m\"/></body>");
    for (bad, code, fixed) in [
        (r#"<joint class="nowhere"/>"#, Code::NotRead, r#"<joint class="main"/>"#),
        (r#"<joint stiffness="2"/>"#, Code::NotRead, "<joint/>"),
        (
            r#"<joint type="ball" damping="2"/>"#,
            Code::NotRead,
            r#"<joint type="ball" damping="0"/>"#,
        ),
        (r#"<joint damping="-2"/>"#, Code::NegativeJointDynamics, r#"<joint damping="2"/>"#),
        (r#"<joint damping="1 2"/>"#, Code::NumberCount, r#"<joint damping="1"/>"#),
        (r#"<joint pos="0 0"/>"#, Code::NumberCount, r#"<joint pos="0 0 0"/>"#),
        (r#"<joint damping=""/>"#, Code::NumberCount, r#"<joint damping="0"/>"#),
        (r#"<joint limited="yes"/>"#, Code::NotRead, r#"<joint limited="false"/>"#),
        (r#"<joint axis="0 0 0"/>"#, Code::ZeroAxis, r#"<joint axis="0 0 1"/>"#),
        (r#"<joint pos="0 0 inf"/>"#, Code::NotFinite, r#"<joint pos="0 0 1"/>"#),
        (r#"<joint range="2 1"/>"#, Code::InvertedLimits, r#"<joint range="1 2"/>"#),
        ("<joint/><composite/>", Code::NotRead, "<joint/>"),
        (r#"<joint/><replicate count="2"><geom size="1"/></replicate>"#, Code::NotRead, "<joint/>"),
        (
            "<joint/><frame><joint/></frame>",
            Code::NotRead,
            r#"<joint axis="1 0 0"/><frame><body><joint/><geom size="1"/></body></frame>"#,
        ),
        (r#"<joint/><body gravcomp="1"/>"#, Code::NotRead, r#"<joint/><body gravcomp="0"/>"#),
        (r#"<joint/><body mocap="true"/>"#, Code::NotRead, "<joint/><body/>"),
        (
            r#"<joint/><body><joint/><geom type="mesh" mesh="m"/></body>"#,
            Code::MissingElement,
            &with_inertial,
        ),
        (
            r#"<joint/><body><joint/><geom size="1"/><geom type="mesh" mesh="m"/></body>"#,
            Code::MissingElement,
            r#"<joint/><body><joint/><geom size="1"/><geom type="mesh" mesh="m" mass="0"/></body>"#,
        ),
        (
            r#"<joint/><body><joint/><geom type="hfield" hfield="h"/></body>"#,
            Code::MissingElement,
            &with_inertial,
        ),
        (
            r#"<joint/><body><joint/><geom size="0"/></body>"#,
            Code::MissingElement,
            r#"<joint/><body><joint/><geom size="1"/></body>"#,
        ),
        (
            r#"<joint/><body quat="1e200 1e200 0 0"/>"#,
            Code::NotFinite,
            r#"<joint/><body quat="1 1 0 0"/>"#,
        ),
        (
            r#"<joint/><geom size="1" shellinertia="true"/>"#,
            Code::NotRead,
            r#"<joint/><geom size="1" shellinertia="false"/>"#,
        ),
        (
            r#"<joint/><body><joint name="k"/></body>"#,
            Code::SingularJoint,
            r#"<joint/><body><joint name="k"/><geom size="1"/></body>"#,
        ),
        (
            r#"<joint name="k"/><joint name="k" axis="1 0 0"/>"#,
            Code::DuplicateJoint,
            r#"<joint name="k"/><body><joint name="l" axis="1 0 0"/><geom size="1"/></body>"#,
        ),
    ] {
        let before = format!("<worldbody><body name=\"a\">{inertial}");
        assert_refused(&before, (bad, code, Some(fixed)), "</body></worldbody>");
    }
    // mjcf-rs reports no line.
    let bad = r#"<joint type="screw"/>"#;
    let text =
        format!("<mujoco model=\"m\"><worldbody><body>{inertial}{bad}</body></worldbody></mujoco>");
    assert_eq!(read(&text).expect_err(bad).into_vec()[0].code, Code::Mjcf);
    assert_eq!(read("<robot/>").expect_err("a URDF").into_vec()[0].code, Code::NotMjcf);
}

/// The help for a constraint between bodies names the option that closes the loop.
#[test]
fn loops_stand_in_for_constraints() {
    let text = |constraint: &str| {
        format!(
            r#"<mujoco model="m"><worldbody><body name="a"><joint/><geom size="1"/>
            <body name="b" pos="1 0 0"><joint/><geom size="1"/></body></body></worldbody>
            <equality>{constraint}</equality></mujoco>"#
        )
    };
    for (constraint, kind) in [
        (r#"<connect body1="b" body2="world" anchor="1 0 0"/>"#, LoopConstraintKind::Point),
        (r#"<weld body1="b" body2="world"/>"#, LoopConstraintKind::Rigid),
    ] {
        let found = read(&text(constraint)).expect_err("a constraint").into_vec();
        let name = &constraint[1..constraint.find(' ').expect("a name")];
        let message = format!("the constraint `<{name}>` of `<equality>` is not read");
        assert_eq!((found[0].message.as_str(), found.len()), (message.as_str(), 1));
        let help = found[0].help.as_deref().unwrap_or_default();
        assert!(help.contains("`loops`"), "{help}");
        let end = |link: &str, x| LoopEnd { link: link.into(), xyz: [x, 0.0, 0.0], rpy: [0.0; 3] };
        let closed = Loop { name: "loop".into(), kind, ends: [end("b", 1.0), end("world", 2.0)] };
        let options = ReadOptions { loops: vec![closed], ..ReadOptions::default() };
        let reading = modyn_codegen::read_mjcf(&text(""), "m.xml", &options).expect("a loop");
        assert_eq!(reading.model.loop_constraints().len(), 1);
    }
    let joint = read(&text(r#"<joint joint1="a_joint"/>"#)).expect_err("a constraint").into_vec();
    assert_eq!(joint[0].message, "the constraint `<joint>` of `<equality>` is not read");
}

/// A number that cannot be read is reported at its line, and so are joints without inertia elsewhere. The body with
/// that number is not checked for inertia.
#[test]
fn a_bad_number_hides_nothing_else() {
    let text = r#"<mujoco model="m"><worldbody>
        <body name="a"><joint name="first" axis="0 0 x"/><inertial pos="0 0 0" mass="1,5" diaginertia="1 1 1"/></body>
        <body name="b"><joint name="second"/><geom type="sphere" size="0.1" mass="0"/></body>
        <body name="c" pos="0 0 é"><joint name="third"/></body>
    </worldbody></mujoco>"#;
    let found = read(text).expect_err("bad numbers").into_vec();
    let places: Vec<_> = found
        .iter()
        .filter(|one| one.severity == Severity::Error)
        .map(|one| (one.code, one.position.map(|at| (at.line, at.column))))
        .collect();
    let expected = [
        (Code::BadNumber, Some((2, 54))),
        (Code::BadNumber, Some((2, 86))),
        (Code::SingularJoint, Some((3, 24))),
        (Code::BadNumber, Some((4, 33))),
    ];
    assert_eq!(places, expected, "{found:#?}");
}

#[test]
fn depth_ends_in_a_refusal_and_not_on_the_stack() {
    let nested = |depth: usize| {
        let body = r#"<body><joint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>"#;
        let bodies = body.repeat(depth) + &"</body>".repeat(depth);
        read(&format!("<mujoco model=\"m\"><worldbody>{bodies}</worldbody></mujoco>"))
    };
    assert_eq!(nested(95).expect("not too deep").nv(), 95);
    assert_eq!(nested(50_000).expect_err("too deep").into_vec()[0].code, Code::NotRead);
}

/// Texts with parts deleted, moved or exchanged are read or refused; the reader does not panic.
#[test]
fn no_mutation_panics() {
    let models = [ARM, include_str!("mjcf/rotations.xml"), include_str!("mjcf/shapes.xml")];
    let fragments: Vec<&str> = models
        .iter()
        .flat_map(|text| text.split_inclusive(['"', ' ', '>', '<']))
        .chain(["1e999", "-0", "nan", "zyxzyx", "class=\"light\" ", "<body>", "</body>", "1e200 "])
        .collect();
    let mut seed = 7_u64;
    let mut below = |end: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as usize % end
    };
    let mut usable = 0;
    for i in 0..3000 {
        let mut tokens: Vec<&str> = models[i % 3].split_inclusive(['"', ' ', '>', '<']).collect();
        for _ in 0..=below(3) {
            let at = below(tokens.len());
            match below(3) {
                0 => tokens[at] = fragments[below(fragments.len())],
                1 => drop(tokens.remove(at)),
                _ => tokens.insert(at, fragments[below(fragments.len())]),
            }
        }
        usable += usize::from(read(&tokens.concat()).is_ok());
    }
    assert!(usable > 100, "only {usable} reach the end");
}

/// Rotations become constants of the generated text. Their sines are those of libm, which are the same on every host,
/// and not those of the system.
#[test]
fn rotations_are_the_same_on_every_host() {
    let angles: Vec<f64> = (0..2000).map(|i| 0.001 + 0.0015 * f64::from(i)).collect();
    let body = |(i, angle): (usize, &f64)| {
        format!(
            "<body name='b{i}' axisangle='0 0 1 {angle:?}'><joint name='j{i}' type='hinge' axis='0 1 0'/>\
             <geom type='sphere' size='0.1' mass='1'/></body>"
        )
    };
    let bodies: String = angles.iter().enumerate().map(body).collect();
    let text = format!(
        "<mujoco model='m'><compiler angle='radian'/><worldbody>{bodies}</worldbody></mujoco>"
    );
    let model = read(&text).expect("good");
    for (link, angle) in model.links().iter().zip(angles) {
        let (sin, cos) = libm::sincos(angle * 0.5);
        let expected = modyn_runtime::conventions::rotation_from_quaternion([0.0, 0.0, sin, cos]);
        assert_eq!(link.joint.origin.rotation, expected, "{angle}");
    }
}

/// A model that is given as text compiles as the same model in a file.
#[test]
fn texts_compile_as_files_do() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/mjcf/arm.xml");
    let generated = |builder: Builder| {
        let generated = builder.type_name("Arm").generate().expect("an arm");
        generated.operations
    };
    let from_text = generated(Builder::new().mjcf_text(ARM, "arm.xml"));
    assert!(!from_text.is_empty());
    assert_eq!(from_text, generated(Builder::new().mjcf(path)));
}
