//! MuJoCo's models (MJCF): the same robot gives the same numbers as its URDF, and what would change the dynamics but
//! is not read is refused where it stands.

use modyn_codegen::error::{Code, Diagnostics};
use modyn_codegen::mjcf;
use modyn_codegen::urdf::{self, Base, ReadOptions};
use modyn_runtime::Interpreter;
use modyn_runtime::model::Model;

fn read(text: &str) -> Result<Model, Diagnostics> {
    mjcf::read(text, "robot.xml", &ReadOptions::default()).map(|reading| reading.model)
}

/// The largest differences of accelerations, torques and mass matrix at some states.
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

/// An arm of hinges and a slide, with everything that is written in several ways: angles in degrees, classes,
/// a frame, inertias by diagonal and in full, anchors beside the body's frame.
const ARM: &str = r#"<mujoco model="arm">
  <compiler angle="degree" eulerseq="XYZ"/>
  <option gravity="0 0 -9.81"/>
  <default>
    <joint damping="0.1" armature="0.01"/>
    <default class="strong"><joint armature="0.2" frictionloss="0.3"/></default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <frame pos="0 0 0.1">
      <body name="upper" pos="0 0 0.2" euler="0 0 90">
        <inertial pos="0 0.01 0.1" mass="2" diaginertia="0.02 0.03 0.011"/>
        <joint name="shoulder" class="strong" axis="0 0 2" range="-170 170"/>
        <geom type="box" size="1 1 1"/>
        <body name="plate" pos="0.01 0 0"><inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/></body>
        <body name="lower" pos="0 0 0.3" childclass="strong">
          <inertial pos="0.1 0 0" quat="0.5 0.5 0.5 0.5" mass="1" fullinertia="0.02 0.03 0.04 0.001 0.002 0.003"/>
          <joint name="elbow" axis="0 1 0" pos="0.02 0 0.01"/>
          <body name="hand" pos="0.2 0 0">
            <inertial pos="0 0 0.03" mass="0.5" diaginertia="1e-3 1e-3 1e-3"/>
            <joint name="reach" class="main" type="slide" axis="1 0 0" range="-0.1 0.1"/>
          </body>
        </body>
      </body>
    </frame>
  </worldbody>
  <actuator><motor joint="shoulder"/></actuator>
</mujoco>"#;

const ARM_URDF: &str = r#"<robot name="arm">
  <link name="world"/>
  <link name="upper"><inertial><origin xyz="0 0.01 0.1"/><mass value="2"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.011" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="world"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0 0 1.5707963267948966"/><axis xyz="0 0 1"/>
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
    for friction in [urdf::Friction::None, urdf::Friction::Viscous, urdf::Friction::Smooth(0.1)] {
        let options = ReadOptions { friction, ..ReadOptions::default() };
        let ours = mjcf::read(ARM, "arm.xml", &options).expect("an MJCF").model;
        let theirs = urdf::read(ARM_URDF, "arm.urdf", &options).expect("a URDF").model;
        let names = |model: &Model| model.coordinate_names();
        assert_eq!(names(&ours), names(&theirs));
        for (a, b) in ours.links().iter().zip(theirs.links()) {
            assert_eq!(a.joint.joint_type, b.joint.joint_type);
            assert_eq!(a.joint.drive, b.joint.drive);
            let range = |limits: Option<modyn_runtime::model::Limits>| {
                limits
                    .map(|limits| [limits.lower, limits.upper].map(|x| (x.unwrap() * 1e12).round()))
            };
            assert_eq!(range(a.joint.limits), range(b.joint.limits));
        }
        // A body's frame is where MuJoCo has it, beside the elbow's anchor.
        let lower = ours.frames().iter().find(|frame| frame.name == "lower").expect("its link");
        assert_eq!(lower.pose.translation, [-0.02, 0.0, -0.01]);
        assert_same_numbers(ours, theirs);
    }
}

/// What `MuJoCo` 4.0.0 computes for the arm (`qfrc_bias` and `mj_fullM`, without its damping and friction).
#[test]
fn the_numbers_are_those_of_mujoco() {
    let mut arm = Interpreter::<f64>::new(read(ARM).expect("an MJCF"));
    let (q, qd, tau) = ([0.3, -0.7, 0.05], [0.4, -1.1, 0.6], [1.0, -2.0, 3.0]);
    let (mut bias, mut matrix, mut qdd) = ([0.0; 3], [0.0; 9], [0.0; 3]);
    arm.bias_forces(&q, &qd, &mut bias).expect("sizes");
    arm.mass_matrix(&q, &mut matrix).expect("sizes");
    arm.forward_dynamics(&q, &qd, &tau, &mut qdd).expect("sizes");
    let close = |a: &[f64], b: &[f64]| {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-13), "{a:?} is not {b:?}");
    };
    close(&bias, &[0.020_761_610_904_452_13, -1.617_043_813_201_301, 3.009_538_670_470_527_6]);
    let [a, b] = [0.273_845_323_192_002_05, 0.002_053_277_561_759_876];
    close(&matrix, &[a, b, 0.0, b, 0.254_15, 0.01, 0.0, 0.01, 0.51]);
    close(&qdd, &[3.587_400_040_724_548_3, -1.536_243_581_683_075_7, 0.011_419_147_737_849_501]);
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
    let options = ReadOptions { gravity: [1.0, 2.0, 3.0], ..ReadOptions::default() };
    assert_same_numbers(model, urdf::read(urdf, "m.urdf", &options).expect("a URDF").model);
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
    let theirs = urdf::read(urdf, "m.urdf", &options).expect("a URDF").model;
    assert_same_numbers(model.expect("an MJCF"), theirs);
}

/// What stands where is refused, for this reason, at the line 2 that it stands in.
fn assert_refused(before: &str, bad: &str, after: &str, code: Code) {
    let text = format!("<mujoco model=\"m\">{before}\n{bad}\n{after}</mujoco>");
    let found = read(&text).expect_err(bad).into_vec();
    let lines: Vec<_> =
        found.iter().map(|one| (one.code, one.position.map(|at| at.line))).collect();
    assert_eq!(lines, [(code, Some(2))], "{bad}: {found:?}");
}

#[test]
fn what_would_go_unread_is_refused() {
    let good = r#"<worldbody><body name="a"><joint name="j"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>"#;
    read(&format!("<mujoco model=\"m\">{good}</mujoco>")).expect("the good part");
    for bad in [
        r#"<include file="/etc/passwd"/>"#,
        r#"<asset><model name="other" file="/etc/passwd"/></asset>"#,
        r#"<equality><joint joint1="j"/></equality>"#,
        r#"<tendon><fixed><joint joint="j" coef="1"/></fixed></tendon>"#,
        r#"<option viscosity="1e-3"/>"#,
        r#"<option><flag gravity="disable"/></option>"#,
        r#"<compiler settotalmass="3"/>"#,
        r#"<compiler balanceinertia="true"/>"#,
        r#"<compiler inertiafromgeom="true"/>"#,
        r#"<default class="other"/>"#,
        r#"<deformable/>"#,
    ] {
        assert_refused("", bad, good, Code::NotRead);
    }
    let inertial = r#"<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>"#;
    for (bad, code) in [
        (r#"<joint class="nowhere"/>"#, Code::NotRead),
        (r#"<joint stiffness="2"/>"#, Code::NotRead),
        (r#"<joint ref="2"/>"#, Code::NotRead),
        (r#"<joint type="ball" damping="2"/>"#, Code::NotRead),
        (r#"<joint damping="-2"/>"#, Code::NegativeDrive),
        (r#"<joint axis="0 0 0"/>"#, Code::ZeroAxis),
        (r#"<joint pos="0 0 inf"/>"#, Code::NotFinite),
        (r#"<joint range="2 1"/>"#, Code::InvertedLimits),
        (r#"<joint/><composite/>"#, Code::NotRead),
        (r#"<joint/><replicate count="2"><geom size="1"/></replicate>"#, Code::NotRead),
        (r#"<joint/><frame><joint/></frame>"#, Code::NotRead),
        (r#"<joint/><body gravcomp="1"/>"#, Code::NotRead),
        (r#"<joint/><body><joint/><geom size="0.1"/></body>"#, Code::MissingElement),
        (r#"<joint/><body><joint name="k"/></body>"#, Code::NoInertiaFelt),
        (r#"<joint name="k"/><joint name="k" axis="1 0 0"/>"#, Code::DuplicateJoint),
    ] {
        let before = format!("<worldbody><body name=\"a\">{inertial}");
        assert_refused(&before, bad, "</body></worldbody>", code);
    }
    // mjcf-rs does not say where.
    for bad in [r#"<joint pos="0 0"/>"#, r#"<joint axis="0 0 x"/>"#, r#"<joint type="screw"/>"#] {
        let text = format!(
            "<mujoco model=\"m\"><worldbody><body>{inertial}{bad}</body></worldbody></mujoco>"
        );
        assert_eq!(read(&text).expect_err(bad).into_vec()[0].code, Code::Mjcf);
    }
    assert_eq!(read("<robot/>").expect_err("a URDF").into_vec()[0].code, Code::NotUrdf);
    assert!(!mjcf::is_mjcf(good) && mjcf::is_mjcf("<mujoco/>") && !mjcf::is_mjcf("<mujoco>"));
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
