//! MuJoCo's models (MJCF). The same robot gives the same numbers as its URDF. An element that would change the dynamics
//! and is not supported is refused, with its line.

use modyn_read::diagnostics::{Code, Diagnostics, Severity};
use modyn_read::{Base, Format, ReadOptions};
use modyn_runtime::Interpreter;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{JointFriction, LoopConstraintKind, Model};

fn read(text: &str) -> Result<Model, Diagnostics> {
    modyn_read::read_mjcf(text, "robot.xml", &ReadOptions::default()).map(|reading| reading.model)
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
        a.random_configuration(&mut uniform, &mut q).expect("sizes");
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
        modyn_read::JointFriction::None,
        modyn_read::JointFriction::Viscous,
        modyn_read::JointFriction::Smooth(0.1),
    ] {
        let options = ReadOptions { joint_friction: Some(friction), ..ReadOptions::default() };
        let ours = modyn_read::read_mjcf(ARM, "arm.xml", &options).expect("an MJCF").model;
        let theirs = modyn_read::read(ARM_URDF, "arm.urdf", &options).expect("a URDF").model;
        let names = |model: &Model| model.coordinate_names();
        assert_eq!(names(&ours), names(&theirs));
        for (a, b) in ours.moving_links().iter().zip(theirs.moving_links()) {
            assert_eq!(a.joint.joint_type, b.joint.joint_type);
            assert_eq!(a.joint.dynamics, b.joint.dynamics);
            let range = |limits: Option<modyn_runtime::model::Limits>| {
                limits
                    .map(|limits| [limits.lower, limits.upper].map(|x| (x.unwrap() * 1e12).round()))
            };
            assert_eq!(range(a.joint.limits), range(b.joint.limits));
        }
        // The body's frame is MuJoCo's frame, which is not at the elbow's anchor.
        let lower = ours.links().iter().find(|frame| frame.name == "lower").expect("its link");
        assert_eq!(lower.pose.translation, [-0.02, 0.0, -0.01]);
        assert_same_numbers(ours, theirs);
    }
}

/// The folder of the models.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/mjcf");

fn read_in_folder(text: &str) -> Result<modyn_read::Reading, Diagnostics> {
    let options = ReadOptions { folder: Some(FOLDER.into()), ..ReadOptions::default() };
    modyn_read::read_mjcf(text, "some/robot.xml", &options)
}

/// The models in `mjcf/` give MuJoCo's results, which `mjcf/golden.py` wrote.
#[test]
fn the_numbers_are_those_of_mujoco() {
    // MuJoCo computes the inertia of meshes by eigenvalues of less precision.
    for (text, golden, tolerance) in [
        (include_str!("mjcf/parts.xml"), include_str!("mjcf/parts.txt"), 1e-9),
        (ARM, include_str!("mjcf/arm.txt"), 1e-12),
        (include_str!("mjcf/rotations.xml"), include_str!("mjcf/rotations.txt"), 1e-12),
        (include_str!("mjcf/shapes.xml"), include_str!("mjcf/shapes.txt"), 1e-12),
        (include_str!("mjcf/fields.xml"), include_str!("mjcf/fields.txt"), 1e-12),
        (include_str!("mjcf/hulls.xml"), include_str!("mjcf/hulls.txt"), 1e-7),
        (include_str!("mjcf/springs.xml"), include_str!("mjcf/springs.txt"), 1e-12),
        (include_str!("mjcf/floating.xml"), include_str!("mjcf/floating.txt"), 1e-12),
        (include_str!("mjcf/spring_dampers.xml"), include_str!("mjcf/spring_dampers.txt"), 1e-11),
    ] {
        let mut robot = Interpreter::<f64>::new(read_in_folder(text).expect("an MJCF").model);
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
            let names = ["accelerations", "bias forces", "mass matrix"];
            for ((found, expected), name) in found.iter().zip([qdd, bias, matrix]).zip(names) {
                let size = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                for (a, b) in found.iter().zip(expected) {
                    assert!((a - b).abs() < tolerance * size, "{name}: {a} is not {b}: {golden}");
                }
            }
        }
    }
}

/// The other files of a model are named, so that programs can be compiled again if they change.
#[test]
fn files_that_a_model_names_are_known() {
    let reading = read_in_folder(include_str!("mjcf/parts.xml")).expect("an MJCF");
    let inside = |path: &std::path::PathBuf| {
        path.strip_prefix(FOLDER).ok().map(|path| path.display().to_string())
    };
    let mut files: Vec<_> = reading.files.iter().filter_map(inside).collect();
    files.sort_unstable();
    let names = ["classes.xml", "finger.msh", "gripper.xml", "more.xml", "open.obj", "wedge.stl"];
    assert_eq!(files, names.map(|name| format!("parts/{name}")));
}

/// An error about another file, or in it, has its place.
#[test]
fn errors_about_other_files_have_their_places() {
    let body = r#"<worldbody><body><joint/><geom size="1"/></body></worldbody>"#;
    let found = |text: &str| {
        let text = format!("<mujoco model=\"m\">\n{text}</mujoco>");
        let found = read_in_folder(&text).expect_err(&text).into_vec();
        let place = |one: &modyn_read::diagnostics::Diagnostic| {
            (one.code, one.file.clone().unwrap_or_default(), one.position.map(|at| at.line))
        };
        found.iter().filter(|one| one.severity == Severity::Error).map(place).collect::<Vec<_>>()
    };
    let main = || "some/robot.xml".to_owned();
    let other = |name: &str| format!("some/{name}");
    for (text, expected) in [
        (r#"<include/>"#, (Code::Include, main(), Some(2))),
        (r#"<include file="none.xml"/>"#, (Code::MissingFile, main(), Some(2))),
        (r#"<include file="/etc/passwd"/>"#, (Code::Include, main(), Some(2))),
        (
            r#"<include file="wrong/cycle.xml"/>"#,
            (Code::Include, other("wrong/cycle.xml"), Some(3)),
        ),
        (
            r#"<include file="wrong/number.xml"/>"#,
            (Code::BadNumber, other("wrong/number.xml"), Some(4)),
        ),
        (
            r#"<include file="./wrong/../wrong/open.xml"/>"#,
            (Code::MalformedXml, other("wrong/open.xml"), Some(2)),
        ),
        (
            r#"<asset><model name="m" file="none.xml"/></asset>"#,
            (Code::MissingFile, main(), Some(2)),
        ),
        (
            r#"<asset><model name="m" file="wrong/self.xml"/></asset>
            <worldbody><attach model="m" prefix="a"/></worldbody>"#,
            (Code::NotRead, other("wrong/self.xml"), Some(4)),
        ),
        (
            r#"<worldbody><attach model="m" prefix="a"/></worldbody>"#,
            (Code::NotRead, main(), Some(2)),
        ),
    ] {
        assert_eq!(found(&format!("{text}\n{body}")), [expected], "{text}");
    }
    let twice = format!(
        r#"{body}<include file="parts/more.xml"/><include file="parts/../parts/more.xml"/>"#
    );
    assert_eq!(found(&twice), [(Code::Include, main(), Some(2))]);
    // Without a folder, no file is read.
    let text = format!("<mujoco model=\"m\"><include file=\"parts/more.xml\"/>{body}</mujoco>");
    let errors = read(&text).expect_err("no folder").into_vec();
    assert_eq!((errors[0].code, errors.len()), (Code::Include, 1));
    assert!(errors[0].help.as_deref().is_some_and(|help| help.contains("ReadOptions::folder")));
}

/// A mesh that is missing is an error if a geom of a moving body has its mass from it, at the body, with the path.
#[test]
fn meshes_are_needed_for_inertia_alone() {
    let text = |geom: &str| {
        format!(
            r#"<mujoco model="m"><compiler meshdir="meshes"/><asset><mesh file="../none.stl"/></asset>
            <worldbody><geom type="mesh" mesh="none"/><body>
            <joint/><geom size="1"/>{geom}</body></worldbody></mujoco>"#
        )
    };
    read_in_folder(&text(r#"<geom type="mesh" mesh="none" mass="0"/>"#)).expect("weightless");
    read_in_folder(&text(r#"<geom type="mesh" mesh="none" group="6"/>"#))
        .expect("outside the groups");
    let found = read_in_folder(&text(r#"<geom type="mesh" mesh="none"/>"#))
        .expect_err("no mesh")
        .into_vec();
    let place = found[0].position.map(|at| at.line);
    assert_eq!((found.len(), found[0].code, place), (1, Code::MissingElement, Some(2)));
    let path = format!("{FOLDER}/none.stl");
    assert!(found[0].message.contains(&path), "{}", found[0].message);
}

/// A face of an OBJ file with more than 100 corners is left out, as in MuJoCo 4.0.0.
#[test]
fn faces_with_many_corners_are_left_out() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("many_corners");
    std::fs::create_dir_all(&folder).expect("a folder");
    let area = |corners: usize| {
        let mut obj = String::from("v 5 5 5\nv 6 5 5\nv 5 6 5\nv 5 5 6\n");
        for k in 0..corners {
            let (sin, cos) = (core::f64::consts::TAU * k as f64 / corners as f64).sin_cos();
            obj += &format!("v {cos:.6} {sin:.6} 0\n");
        }
        obj += "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf";
        (0..corners).for_each(|k| obj += &format!(" {}", k + 5));
        std::fs::write(folder.join("m.obj"), obj).expect("a mesh");
        let text = r#"<mujoco model="m"><asset><mesh file="m.obj" inertia="shell"/></asset><worldbody><body><joint/>
            <geom type="mesh" mesh="m" density="1"/></body></worldbody></mujoco>"#;
        let options = ReadOptions { folder: Some(folder.clone()), ..ReadOptions::default() };
        let reading = modyn_read::read_mjcf(text, "m.xml", &options).expect("an MJCF");
        reading.model.moving_links()[0].inertial.mass
    };
    let tetrahedron = 1.5 + 0.75_f64.sqrt();
    assert!((area(101) - tetrahedron).abs() < 1e-6, "{}", area(101));
    // The polygon of 100 corners in the unit circle.
    let polygon = 50.0 * (core::f64::consts::TAU / 100.0).sin();
    assert!((area(100) - tetrahedron - polygon).abs() < 1e-4, "{}", area(100));
}

/// The hull of a grid of points is a box, in every orientation and size; points in one plane have none.
#[test]
fn hulls_of_points_in_planes() {
    let text = |vertices: &str, mesh: &str, geom: &str| {
        format!(
            r#"<mujoco model="m"><asset><mesh name="m" vertex="{vertices}" {mesh}/></asset><worldbody><body>
            <joint/><geom pos="1 2 3" {geom}/></body></worldbody></mujoco>"#
        )
    };
    let inertial = |text: &str| read(text).expect(text).moving_links()[0].inertial;
    let numbers = |inertial: modyn_runtime::Inertial| {
        let mut all = vec![inertial.mass];
        all.extend(inertial.center_of_mass.iter().chain(&inertial.inertia));
        all
    };
    for scale in [1e-3, 0.7, 300.0] {
        for quaternion in ["1 0 0 0", "1 2 -3 4", "0.3 0.1 0.9 -0.2", "1 1e-9 0 0"] {
            // A grid, whose lines are not spaced evenly, turned by the geom.
            let ticks = [-1.0, -0.35, 0.1, 0.4, 1.0].map(|x| x * scale);
            let mut vertices = String::new();
            for (i, j, k) in (0..125).map(|n| (n % 5, n / 5 % 5, n / 25)) {
                vertices += &format!("{:e} {:e} {:e} ", ticks[i], 2.0 * ticks[j], 0.5 * ticks[k]);
            }
            let turned = format!(r#"quat="{quaternion}""#);
            let (a, b, c) = (scale, 2.0 * scale, 0.5 * scale);
            let cloud = text(&vertices, "", &format!(r#"type="mesh" mesh="m" {turned}"#));
            // The mesh itself is turned as well: by `refquat`, and back by the geom.
            let reference = text(&vertices, &format!("ref{turned}"), r#"type="mesh" mesh="m""#);
            let boxed = text("", "", &format!(r#"type="box" size="{a} {b} {c}" {turned}"#));
            let inverse: Vec<String> =
                quaternion
                    .split(' ')
                    .enumerate()
                    .map(|(i, x)| {
                        if i == 0 {
                            x.into()
                        } else {
                            format!("{:e}", -x.parse::<f64>().expect("x"))
                        }
                    })
                    .collect();
            let back = format!(r#"type="box" size="{a} {b} {c}" quat="{}""#, inverse.join(" "));
            for (found, expected) in [(cloud, boxed), (reference, text("", "", &back))] {
                let (found, expected) = (numbers(inertial(&found)), numbers(inertial(&expected)));
                for (part, size) in [(0..1, expected[0]), (1..4, 1.0), (4..10, expected[9].abs())] {
                    for i in part {
                        let off = (found[i] - expected[i]).abs();
                        assert!(off < 1e-9 * size, "{scale} {quaternion}: {found:?} {expected:?}");
                    }
                }
            }
        }
    }
    let flat = text("0 0 0 1 0 0 0 1 0 1 1 0 0.5 0.2 0", "", r#"type="mesh" mesh="m""#);
    let found = read(&flat).expect_err("flat").into_vec();
    assert_eq!((found.len(), found[0].code), (1, Code::MissingElement), "{found:?}");
    assert!(found[0].message.contains("all vertices in one plane"), "{}", found[0].message);
    let cut =
        text("0 0 0 1 0 0 0 1 0 0 0 1 1 1 1", r#"maxhullvert="4""#, r#"type="mesh" mesh="m""#);
    assert!(read(&cut).expect_err("cut").into_vec()[0].message.contains("maxhullvert"));
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
    let names: Vec<&str> =
        model.moving_links().iter().map(|link| link.joint.name.as_str()).collect();
    assert_eq!(names, ["body_1_joint", "body_1_joint_2", "ball"]);
    let on_earth = ReadOptions { gravity: Some([0.0, 0.0, -9.81]), ..ReadOptions::default() };
    let asked = modyn_read::read_mjcf(mjcf, "m.xml", &on_earth).expect("an MJCF").model;
    assert_eq!(asked.gravity(), [0.0, 0.0, -9.81]);
    let options = ReadOptions { gravity: Some([1.0, 2.0, 3.0]), ..ReadOptions::default() };
    assert_same_numbers(model, modyn_read::read(urdf, "m.urdf", &options).expect("a URDF").model);
}

#[test]
fn surprises_are_warnings_with_their_lines() {
    let text = r#"<mujoco model="m"><worldbody>
      <body name="light">
        <joint name="damped" axis="0 1 0" damping="0.5"/>
        <body name="heavy" pos="0 0 0.4"><joint name="turn" axis="1 0 0"/>
          <inertial pos="0 0 0.1" mass="2600" diaginertia="0.02 0.02 0.02"/></body></body></worldbody></mujoco>"#;
    let read = modyn_read::read_mjcf(text, "m.xml", &ReadOptions::default()).expect("an MJCF");
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
    let theirs = modyn_read::read(urdf, "m.urdf", &options).expect("a URDF").model;
    assert_same_numbers(model.expect("an MJCF"), theirs);
}

/// A fixed base is the body without its free joint. Keyframes lose the coordinates of the joint,
/// and a weld to the world has no effect.
#[test]
fn a_free_body_can_be_fixed() {
    let read = |joint: &str, rest: &str, base: Base| {
        let text = format!(
            r#"<mujoco model="m"><worldbody><body name="trunk" pos="0 0.5 1" euler="10 20 30">{joint}
               <geom size="0.2"/><body name="leg" pos="0 0 -0.3"><joint name="hip" axis="0 1 0"/><geom size="0.1" pos="0 0 -0.2"/>
               </body></body></worldbody>{rest}</mujoco>"#
        );
        let options = ReadOptions { base, ..ReadOptions::default() };
        Format::Mjcf.read(&text, "m.xml", &options)
    };
    let free = r#"<freejoint name="root"/>"#;
    let key = |qpos: &str| format!(r#"<keyframe><key name="home" qpos="{qpos}"/></keyframe>"#);
    let weld = r#"<equality><weld body1="trunk"/></equality>"#;
    let fixed = read(free, &(key("1 2 3 1 0 0 0 0.7") + weld), Base::Fixed).expect("a robot");
    assert_eq!(fixed.warnings, []);
    assert_eq!(fixed.model.keyframe("home").map(|home| &*home.q), Some(&[0.7][..]));
    let welded = read("", &key("0.7"), Base::Auto).expect("a robot").model;
    assert_same_numbers(fixed.model, welded);
    let found = read(free, "", Base::Floating).expect_err("refused").into_vec();
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(read(free, "", Base::Auto).expect("a robot").model.nv(), 7);
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
    let reading = modyn_read::read_mjcf(&text(""), "m.xml", &ReadOptions::default());
    let reading = reading.expect("an MJCF");
    let efforts = |model: &Model| -> Vec<Option<f64>> {
        model
            .moving_links()
            .iter()
            .map(|link| link.joint.limits.and_then(|own| own.effort))
            .collect()
    };
    assert_eq!(efforts(&reading.model), joints.map(|(_, effort)| effort));
    let first = &reading.model.moving_links()[0].joint;
    assert_eq!(first.joint_type, JointType::Continuous);
    assert!(reading.warnings.is_empty(), "{:?}", reading.warnings);
    let ranges = &reading.model.actuation().joint_force_ranges;
    let bounds: Vec<_> = ranges.iter().map(|joint| (joint.link, joint.range)).collect();
    let expected =
        [(0, 3.0, 3.0), (1, 1.0, 1.0), (2, 5.0, 5.0), (3, 9.0, 9.0), (4, 7.0, 7.0), (7, 3.0, 4.0)];
    assert_eq!(bounds, expected.map(|(link, low, high): (_, f64, _)| (link, [-low, high])));
    let not_automatic = read(&text("<compiler autolimits=\"false\"/>")).expect("an MJCF");
    assert!(efforts(&not_automatic).iter().all(Option::is_none));
}

/// Servo actuators are named once; motors are the joint forces themselves. Sites are frames, and what only programs need has
/// no warning.
#[test]
fn servo_actuators_are_named_and_sites_are_frames() {
    let text = r#"<mujoco model="m"><default><motor forcerange="-1 1"/><site size="0.1"/></default><worldbody>
      <site name="origin" pos="1 2 3"/>
      <body name="tip"><joint name="j"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <site name="tip" pos="0 0 1"/><site/><frame pos="0 1 0"><site name="heel"/></frame></body></worldbody>
      <actuator>
        <motor joint="j" forcerange="-1 1"/>
        <pid joint="j"/>
        <general joint="j" biastype="muscle"/></actuator>
      <sensor><jointpos joint="j"/></sensor><keyframe>
      <key qpos="1"/><key/></keyframe></mujoco>"#;
    let reading = modyn_read::read_mjcf(text, "m.xml", &ReadOptions::default());
    let reading = reading.expect("an MJCF");
    let found: Vec<_> = reading
        .warnings
        .iter()
        .map(|one| (one.code, one.position.map(|at| at.line), one.message.as_str()))
        .collect();
    let message = |name: &str| {
        format!(
            "the law of the actuator ({name}) does not act: the dynamics have the joint force as an argument"
        )
    };
    let muscle = "`<general>` with `gaintype=\"fixed\"`, `biastype=\"muscle\"`";
    let expected = [(7, message("`<pid>`")), (8, message(muscle))];
    let expected =
        expected.each_ref().map(|(line, message)| (Code::NotRead, Some(*line), message.as_str()));
    assert_eq!(found, expected);
    let help = reading.warnings[0].help.as_deref().unwrap_or_default();
    assert!(help.contains("ki * integral"), "{help}");
    assert_eq!(reading.model.control_names(), ["j"]);
    let frames: Vec<_> = reading
        .model
        .links()
        .iter()
        .map(|frame| (frame.name.as_str(), frame.moving_link, frame.pose.translation))
        .collect();
    let expected = [
        ("world", None, [0.0; 3]),
        ("tip", Some(0), [0.0; 3]),
        ("origin", None, [1.0, 2.0, 3.0]),
        ("tip_site", Some(0), [0.0, 0.0, 1.0]),
        ("heel", Some(0), [0.0, 1.0, 0.0]),
    ];
    assert_eq!(frames, expected);
}

/// Springs and compensated gravity act, unless the model says that springs do not.
#[test]
fn springs_and_compensated_gravity_are_read() {
    let text = |flag: &str| {
        format!(
            r#"<mujoco model="m"><option><flag {flag}/></option><worldbody>
            <body name="a" gravcomp="1"><joint name="j" stiffness="2" springref="90"/><geom size="1"/>
            <body name="b" pos="1 2 3"><joint name="k" type="slide" springref="0.5" stiffness="4 0 0"/><geom size="1"/>
            <body name="c" gravcomp="0.5"><joint name="l" type="ball" stiffness="3"/><geom size="1"/></body></body></body>
            <body gravcomp="1"/><body name="d" pos="1 2 3" quat="0 0 0 1"><freejoint/><geom size="1"/></body>
            <body name="e" pos="1 2 3" quat="0 0 0 1"><joint type="free" stiffness="5"/><geom size="1"/></body>
            </worldbody></mujoco>"#
        )
    };
    let read = |flag: &str| {
        let reading = modyn_read::read_mjcf(&text(flag), "m.xml", &ReadOptions::default());
        let reading = reading.expect("an MJCF");
        assert_eq!(reading.warnings.len(), 0, "{:?}", reading.warnings);
        reading.model
    };
    let model = read(r#"gravity="enable""#);
    let springs = model.springs().iter().map(|spring| {
        let joint = &model.moving_links()[spring.link].joint;
        (joint.joint_type, spring.stiffness, spring.reference.clone())
    });
    let expected = [
        (JointType::Continuous, 2.0, vec![std::f64::consts::FRAC_PI_2]),
        (JointType::Prismatic, 4.0, vec![0.5]),
        (JointType::Spherical, 3.0, vec![0.0, 0.0, 0.0, 1.0]),
        (JointType::Floating, 5.0, vec![1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 0.0]),
    ];
    assert_eq!(springs.collect::<Vec<_>>(), expected);
    let factors = model.links().iter().zip(model.gravity_compensation());
    let factors = factors.filter(|(_, factor)| **factor != 0.0);
    let factors: Vec<_> = factors.map(|(frame, factor)| (&*frame.name, *factor)).collect();
    assert_eq!(factors, [("a", 1.0), ("c", 0.5)]);
    assert!(read(r#"spring="disable""#).springs().is_empty());
}

/// The damping that follows from `springdamper` is that of `MuJoCo`, which `mjcf/golden.py` writes; `mjcf/spring_dampers.txt`
/// holds the stiffness against `MuJoCo`. Without springs, the damping remains.
#[test]
fn dampers_follow_from_time_constants() {
    let text = include_str!("mjcf/spring_dampers.xml");
    let without = text.replace("<option", "<option><flag spring=\"disable\"/></option><option");
    // A constraint does not count.
    let coupled = text.replace(
        "</worldbody>",
        r#"</worldbody><equality><joint joint1="last" joint2="slide"/></equality>"#,
    );
    for text in [text, &without, &coupled] {
        let model = read(text).expect("an MJCF");
        let damping = model.moving_links().iter().map(|link| link.joint.dynamics.damping);
        let damping: Vec<f64> = damping.filter(|damping| *damping != 0.0).collect();
        let expected = [
            2.471038296767137,
            28.114349824396506,
            1.1016387091323172,
            0.2260944151520347,
            0.4543534666213909,
            0.11758767760205989,
        ];
        assert_eq!(damping.len(), expected.len(), "{damping:?}");
        for (found, expected) in damping.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12 * expected, "{found} is not {expected}");
        }
        assert_eq!(model.springs().is_empty(), text == without);
    }
}

/// The largest force of a joint is that of its actuators, if each has a limit.
#[test]
fn ranges_of_actuators_are_effort_limits() {
    for (actuators, effort) in [
        (r#"<motor joint="j" gear="5" ctrlrange="-2 2"/>"#, Some(10.0)),
        (r#"<motor joint="j" gear="-5" ctrlrange="-2 2" forcerange="-1 1"/>"#, Some(5.0)),
        (r#"<position joint="j" kp="9" ctrlrange="-2 2" forcerange="-3 3"/>"#, Some(3.0)),
        (r#"<motor joint="j" forcerange="-3 3"/><motor joint="j" forcerange="-4 4"/>"#, Some(7.0)),
        (r#"<motor joint="j" forcerange="-3 3"/><motor joint="j"/>"#, None),
        (r#"<position joint="j" ctrlrange="-2 2"/>"#, None),
        (r#"<motor joint="j" forcerange="-3 3" forcelimited="false"/>"#, None),
        (r#"<motor joint="j" forcerange="-3 4"/>"#, None),
        // MuJoCo saves motors so; the numbers are its `qfrc_actuator` at a large control.
        (r#"<general joint="j" gear="5" ctrlrange="-2 2"/>"#, Some(10.0)),
        (r#"<general joint="j" gear="5" ctrlrange="-2 2" gainprm="-30 0 0"/>"#, Some(300.0)),
        (r#"<general joint="j" gaintype="affine" ctrlrange="-2 2"/>"#, None),
        (r#"<general joint="j" biastype="affine" ctrlrange="-2 2"/>"#, None),
        (r#"<general joint="j" dyntype="integrator" ctrlrange="-2 2"/>"#, None),
    ] {
        let found = |flag: &str| {
            let model = read(&format!(
                r#"<mujoco model="m"><option><flag {flag}/></option><worldbody><body><joint name="j"/><geom size="0.1"/></body>
                </worldbody><actuator>{actuators}</actuator></mujoco>"#
            ));
            model.expect(actuators).moving_links()[0].joint.limits.and_then(|limits| limits.effort)
        };
        assert_eq!(found(""), effort, "{actuators}");
        assert_eq!(found("actuation=\"disable\""), None, "{actuators}");
        let by_force = effort.filter(|_| actuators.contains("forcerange"));
        assert_eq!(found("clampctrl=\"disable\""), by_force, "{actuators}");
    }
}

/// Each law of an actuator that depends on the state is named, also of an actuator as MuJoCo saves
/// it.
#[test]
fn laws_of_actuators_are_named() {
    let warnings = |actuators: &str| {
        let text = format!(
            r#"<mujoco model="m"><worldbody><body><joint name="j"/><geom size="0.1"/>
            <body><joint name="ball" type="ball"/><geom size="0.1"/></body>
            <site name="s"/></body><site name="o"/></worldbody>
            <tendon><spatial name="t"><site site="s"/><site site="o"/></spatial></tendon>
            <actuator>{actuators}</actuator></mujoco>"#
        );
        let reading = modyn_read::read_mjcf(&text, "m.xml", &ReadOptions::default());
        reading.expect("an MJCF").warnings
    };
    for (element, attributes, law) in [
        ("orientation", "kp='1'", "log(q^-1 * target)"),
        ("pid", "kp='1'", "ki * integral"),
        ("muscle", "force='100' lengthrange='0 1'", "pulls without control"),
        ("dcmotor", "motorconst='1' resistance='2'", "back EMF"),
        ("plugin", "plugin='p'", "that of the plugin"),
        (
            "general",
            "dyntype='muscle' gaintype='muscle' biastype='muscle'",
            "pulls without control",
        ),
        ("general", "biastype='muscle'", "pulls without control"),
        ("general", "gaintype='user'", "of these types in MuJoCo"),
        ("general", "biastype='user'", "of these types in MuJoCo"),
        ("general", "gaintype='pid' biastype='affine'", "of these types in MuJoCo"),
        (
            "general",
            "dyntype='dcmotor' gaintype='dcmotor' biastype='dcmotor'",
            "of these types in MuJoCo",
        ),
    ] {
        let found = warnings(&format!("<{element} joint='j' {attributes}/>"));
        let [found] = &found[..] else { panic!("{element}: {found:?}") };
        assert!(found.to_string().contains(&format!("`<{element}>`")), "{found}");
        assert!(found.to_string().contains(law), "{found}");
    }
    assert_eq!(
        warnings(
            "<motor joint='j' gear='2'/><general joint='j' dyntype='filter' gainprm='2'/>
             <position joint='j' kp='1' dampratio='1'/><velocity joint='j'/><cylinder joint='j'/>
             <damper joint='j' kv='4' ctrlrange='0 2'/><intvelocity joint='j'/>
             <general joint='j' gaintype='affine' biastype='affine'/>"
        ),
        []
    );
    let [found] = &warnings("<adhesion body='b' ctrlrange='0 1'/>")[..] else {
        panic!("one warning")
    };
    assert!(found.message.contains("`<adhesion>`"), "{found}");
    let transmissions = [
        ("site='s'", "a site"),
        ("cranksite='s' slidersite='t' cranklength='1'", "a slider-crank"),
        ("tendon='t'", "a `<spatial>` tendon"),
        ("joint='ball'", "a ball or free joint"),
    ];
    for (target, kind) in transmissions {
        let messages = warnings(&format!("<velocity {target} kv='1'/><motor {target}/>"));
        let [warning] = &messages[..] else { panic!("{target}: {messages:?}") };
        assert!(warning.message.contains(&format!("actuators that move {kind}")), "{warning}");
    }
    let [found] = &warnings("<motor joint='j' delay='0.1'/>")[..] else { panic!("one warning") };
    assert!(found.message.contains("`delay`"), "{found}");
}

/// The switches of `<flag>`, whose effects are those of MuJoCo 4.0: the degrees of freedom, and the
/// forces at a velocity of 1.
#[test]
fn switches_change_what_is_read() {
    let model = |flag: &str| {
        let text = format!(
            r#"<mujoco model="m"><option density="1"><flag {flag}/></option><worldbody>
            <body name="a" gravcomp="1"><joint name="a" axis="0 1 0" damping="0.5" frictionloss="0.3" stiffness="2"/>
              <geom size="0.1" pos="0.2 0 0"/>
              <body name="b" pos="0.4 0 0"><joint name="b" axis="0 1 0" springdamper="1 1"/><geom size="0.1" pos="0.2 0 0"/>
            </body></body></worldbody>
            <equality><joint joint1="b" joint2="a" polycoef="0 2 0 0 0"/><connect body1="b" anchor="0 0 0"/></equality></mujoco>"#
        );
        let options = ReadOptions {
            joint_friction: Some(JointFriction::Coulomb),
            unsupported_forces: Severity::Warning,
            ..ReadOptions::default()
        };
        modyn_read::read_mjcf(&text, "m.xml", &options).expect("an MJCF")
    };
    let found = |flag: &str| {
        let reading = model(flag);
        let model = reading.model;
        let joint = &model.moving_links()[0].joint.dynamics;
        let is_follower = model.mimic(1).is_some();
        let is_damped = model.moving_links()[1].joint.dynamics.damping > 0.0;
        assert_eq!(model.loop_constraints().is_empty(), !is_follower, "{flag}");
        assert_eq!(is_damped, joint.damping > 0.0, "{flag}");
        // Gravity compensation and fluids are passive forces, as springs and dampers.
        let is_compensated = !model.gravity_compensation().is_empty();
        assert_eq!(is_compensated, !reading.warnings.is_empty(), "{flag}");
        (is_follower, joint.damping, joint.friction, model.springs().len(), is_compensated)
    };
    let all = (true, 0.5, 0.3, 2, true);
    assert_eq!(found("limit=\"disable\""), all);
    let off = |name: &str| format!("{name}=\"disable\"");
    assert_eq!(found(&off("equality")), (false, 0.5, 0.3, 2, true));
    assert_eq!(found(&off("constraint")), (false, 0.5, 0.0, 2, true));
    assert_eq!(found(&off("frictionloss")), (true, 0.5, 0.0, 2, true));
    assert_eq!(found(&off("damper")), (true, 0.0, 0.3, 2, true));
    assert_eq!(found(&off("spring")), (true, 0.5, 0.3, 0, true));
    assert_eq!(found(&(off("spring") + " " + &off("damper"))), (true, 0.0, 0.3, 0, false));
    assert_eq!(found(&off("passive")), (true, 0.0, 0.3, 0, false));
}

/// Words of MuJoCo 4.0 that cannot change the equations of motion.
#[test]
fn harmless_words_of_mujoco_4_are_read() {
    let model = |option: &str, class: &str, joint: &str, key: &str, body: &str, compiler: &str| {
        read(&format!(
            r#"<mujoco model="m"><compiler {compiler}/><option><flag {option}/></option><default>{class}</default><worldbody>
            <body name="a" {body}><joint name="a" {joint}/><geom size="0.1" pos="0.2 0 0" castshadow="false"/></body></worldbody>
            <keyframe><key name="home" qpos="0.1" {key}/></keyframe></mujoco>"#
        ))
    };
    let plain = model("", "", "", "", "", "").expect("an MJCF");
    for found in [
        model("speculative=\"enable\" ipc=\"disable\"", "", "", "", "", ""),
        model("", "<joint springyield='0'/>", "", "", "", ""),
        model("", "<texture builtin='flat' width='8' height='8'/>", "", "", "", ""),
        model("", "", "springyield='0'", "", "", ""),
        model("", "", "", "plastic=''", "", ""),
        model("", "", "", "", "fuse='true'", ""),
        model(
            "",
            "",
            "",
            "",
            "",
            "passthrough='textures' savecompiled='false' savecanonical='false'",
        ),
    ] {
        assert_eq!(found.expect("an MJCF"), plain);
    }
    let found = model("", "", "springyield='0.1'", "", "", "").expect_err("a spring that yields");
    assert!(found.to_string().contains("`springyield=\"0.1\"`"), "{found}");
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
        r#"<mujoco model="m"><compiler strippath="maybe"/><option apirate="short"/><asset><material rgba="red"/></asset>
        <worldbody><body sleep="never"><joint name="j" user="wide"/><geom size="0.1" contype="-1" rgba="red"/></body></worldbody>
        <actuator><muscle tausmooth="high" joint="j"/></actuator></mujoco>"#,
    )
    .expect("an MJCF");
}

/// Forces of fluids and tendons are refused, or left out with a warning if an option says so. The inertia of a tendon is no
/// force.
#[test]
fn unread_forces_are_refused_or_left_out() {
    let text = |armature: &str| {
        format!(
            r#"<mujoco model="m"><option density="1.2"/>
            <option density="0" viscosity="1e-5"/><option density="1" viscosity="2"/><worldbody><body>
            <joint name="a"/><geom size="1"/><site name="p" pos="1 0 0"/></body><site name="q"/></worldbody><tendon>
            <fixed stiffness="2" damping="1"><joint joint="a" coef="2"/></fixed>
            <spatial damping="3"><site site="p"/><site site="q"/></spatial>
            <spatial armature="{armature}"><site site="p"/><site site="q"/></spatial></tendon></mujoco>"#
        )
    };
    let read = |armature: &str, unsupported_forces| {
        let options = ReadOptions { unsupported_forces, ..ReadOptions::default() };
        modyn_read::read_mjcf(&text(armature), "m.xml", &options)
    };
    let lines = |found: &[modyn_read::diagnostics::Diagnostic]| -> Vec<_> {
        found.iter().map(|one| (one.severity, one.position.map_or(0, |at| at.line))).collect()
    };
    let found = read("0", Severity::Error).expect_err("forces").into_vec();
    assert_eq!(lines(&found), [1, 2, 2, 4, 5].map(|line| (Severity::Error, line)), "{found:?}");
    assert!(found[2].message.contains("(`density`, `viscosity`)"), "{}", found[2].message);
    let fixed = "forces of a tendon (`damping`, `stiffness`) act in `step` only";
    assert_eq!(
        [&*found[3].message, &found[4].message],
        [fixed, "forces of a tendon (`damping`) are not read"]
    );
    for one in &found {
        let help = one.help.as_deref().unwrap_or_default();
        assert!(help.contains("`unsupported_forces = warn`"), "{help}");
    }
    let reading = read("0", Severity::Warning).expect("warnings");
    let warnings = [1, 2, 2, 4, 5].map(|line| (Severity::Warning, line));
    assert_eq!(lines(&reading.warnings), warnings);
    assert_eq!(reading.model.nv(), 1);
    let found = read("0.5", Severity::Warning).expect_err("an inertia").into_vec();
    assert_eq!(
        lines(&found).iter().filter(|(severity, _)| *severity == Severity::Error).count(),
        1
    );
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
        (
            r#"<equality><tendon tendon1="t"/></equality>"#,
            Some(r#"<equality><tendon tendon1="t" active="false"/></equality>"#),
        ),
        (
            r#"<equality><distance geom1="g" geom2="h"/></equality>"#,
            Some(r#"<equality><distance geom1="g" geom2="h" active="false"/></equality>"#),
        ),
        (
            r#"<equality><conect body1="a"/></equality>"#,
            Some(r#"<equality><connect body1="a"/></equality>"#),
        ),
        (r#"<compiler angel="radian"/>"#, Some(r#"<compiler angle="radian"/>"#)),
        (
            r#"<tendon><fixed stiffness="1"><joint joint="j" coef="1"/></fixed></tendon>"#,
            Some(r#"<tendon><fixed stiffness="0"><joint joint="j" coef="1"/></fixed></tendon>"#),
        ),
        (
            r#"<default><tendon damping="1"/></default><tendon><fixed><joint joint="j" coef="1"/></fixed></tendon>"#,
            Some(r#"<default><tendon damping="1"/></default>"#),
        ),
        (r#"<option viscosity="1e-3"/>"#, Some(r#"<option viscosity="0"/>"#)),
        (r#"<default class="other"/>"#, Some(r#"<default class="main"/>"#)),
        (r"<default><default/></default>", Some(r#"<default><default class="a"/></default>"#)),
        (
            r#"<default><default class="a"><default class="a"><joint damping="1"/></default></default></default>"#,
            Some(
                r#"<default><default class="a"><default class="b"><joint damping="1"/></default></default></default>"#,
            ),
        ),
        (r#"<compiler eulerseq="xyzx"/>"#, Some(r#"<compiler eulerseq="xyz"/>"#)),
        (r#"<compiler eulerseq="xyw"/>"#, Some(r#"<compiler eulerseq="XYZ"/>"#)),
        (r#"<compiler autolimits="yes"/>"#, Some(r#"<compiler autolimits="true"/>"#)),
        (
            r#"<actuator><position joint="j" damping="1"/></actuator>"#,
            Some(r#"<actuator><position joint="j"/></actuator>"#),
        ),
        ("<deformable><flex/></deformable>", Some("<deformable><skin/></deformable>")),
    ] {
        assert_refused("", (bad, Code::NotRead, fixed), good);
    }
    let inertial = r#"<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>"#;
    let with_inertial =
        format!("<joint/><body><joint/>{inertial}<geom type=\"mesh\" mesh=\"m\"/></body>");
    for (bad, code, fixed) in [
        (r#"<joint class="nowhere"/>"#, Code::NotRead, r#"<joint class="main"/>"#),
        (
            r#"<joint springdamper="1 0"/>"#,
            Code::NegativeJointDynamics,
            r#"<joint springdamper="1 2"/>"#,
        ),
        (
            r#"<joint springdamper="1 1"/><body><joint axis="1 0 0" springdamper="0 0"/></body>"#,
            Code::NotRead,
            r#"<joint springdamper="0 0"/>"#,
        ),
        (
            r#"<joint/></body><body><joint type="free" frictionloss="2"/><geom size="1"/>"#,
            Code::NotRead,
            r#"<joint/></body><body><joint type="free" damping="2"/><geom size="1"/>"#,
        ),
        (r#"<joint damping="-2"/>"#, Code::NegativeJointDynamics, r#"<joint damping="2"/>"#),
        (r#"<joint damping="1 2"/>"#, Code::NotRead, r#"<joint damping="1"/>"#),
        (r#"<joint pos="0 0"/>"#, Code::NumberCount, r#"<joint pos="0 0 0"/>"#),
        (r#"<joint damping=""/>"#, Code::NumberCount, r#"<joint damping="0"/>"#),
        (r#"<joint limited="yes"/>"#, Code::NotRead, r#"<joint limited="false"/>"#),
        (r#"<joint axis="0 0 0"/>"#, Code::ZeroAxis, r#"<joint axis="0 0 1"/>"#),
        (r#"<joint pos="0 0 inf"/>"#, Code::NotFinite, r#"<joint pos="0 0 1"/>"#),
        (r#"<joint range="2 1"/>"#, Code::InvertedLimits, r#"<joint range="1 2"/>"#),
        (r#"<joint type="screw"/>"#, Code::NotRead, r#"<joint type="slide"/>"#),
        ("<joint/><composite/>", Code::NotRead, "<joint/>"),
        ("<joint/><plugin/>", Code::NotRead, "<joint/>"),
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
            r#"<joint/><body quat="1e200 1 0 0"/>"#,
            Code::NotFinite,
            r#"<joint/><body quat="1 1 0 0"/>"#,
        ),
        (
            r#"<joint/><body><joint name="k"/><inertial pos="0 0 1" mass="1" diaginertia="0 0 0"/></body>"#,
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
    assert_eq!(read("<robot/>").expect_err("a URDF").into_vec()[0].code, Code::NotMjcf);
}

/// A constraint between bodies closes a loop, between the points or frames that coincide as the model is drawn.
#[test]
fn constraints_between_bodies_are_loops() {
    let text = |constraint: &str| {
        format!(
            r#"<mujoco model="m"><worldbody><body name="a" pos="0 0 1" euler="0 0 90"><joint pos="1 1 1"/><geom size="1"/>
            <site name="s" pos="3 0 0"/><body name="b" pos="1 0 0"><joint ref="30"/><geom size="1"/>
            <site name="t" pos="0 3 0" euler="90 0 0"/></body></body>
            <body name="c" mocap="true" pos="5 0 0"/></worldbody><equality>{constraint}</equality></mujoco>"#
        )
    };
    let turned = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let same = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let inverse = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let point = LoopConstraintKind::Point;
    let rigid = LoopConstraintKind::Rigid;
    let o = [0.0; 3];
    for (constraint, kind, ends) in [
        (
            r#"<connect body1="b" body2="world" anchor="1 0 0"/>"#,
            point,
            [("b", [1.0, 0.0, 0.0], same), ("world", [0.0, 2.0, 1.0], same)],
        ),
        (
            r#"<connect body1="b" body2="c" anchor="0 0 0"/>"#,
            point,
            [("b", o, same), ("c", [-5.0, 1.0, 1.0], same)],
        ),
        (r#"<weld body1="b"/>"#, rigid, [("b", [-1.0, 0.0, -1.0], inverse), ("world", o, same)]),
        (
            r#"<weld body1="a" body2="b" relpose="1 2 3 1 0 0 1"/>"#,
            rigid,
            [("a", [1.0, 2.0, 3.0], turned), ("b", o, same)],
        ),
        (
            r#"<weld body1="a" body2="b" anchor="0 2 0" relpose="1 2 3 1 0 0 1" torquescale="0"/>"#,
            point,
            [("a", [-1.0, 2.0, 3.0], turned), ("b", [0.0, 2.0, 0.0], same)],
        ),
        (
            r#"<weld site1="s" site2="t"/>"#,
            rigid,
            [
                ("a", [3.0, 0.0, 0.0], same),
                ("b", [0.0, 3.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
            ],
        ),
    ] {
        let model = read(&text(constraint)).expect(constraint);
        let [found] = model.loop_constraints() else { panic!("{constraint}: no loop") };
        assert_eq!(found.kind, kind, "{constraint}");
        for (end, (link, position, rotation)) in found.ends.iter().zip(ends) {
            assert_eq!(model.links()[end.link].name, link, "{constraint}");
            let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
            let is_near = end.pose.translation.iter().zip(position).all(|(a, b)| near(*a, b))
                && end
                    .pose
                    .rotation
                    .iter()
                    .flatten()
                    .zip(rotation.iter().flatten())
                    .all(|(a, b)| near(*a, *b));
            assert!(is_near, "{constraint}: {:?}", end.pose);
        }
    }
    for none in [
        r#"<weld body1="b" active="false"/>"#,
        r#"<weld body1="c"/>"#,
        r#"<weld body1="b"/></equality><option><flag equality="disable"/></option><equality>"#,
        r#"<connect class="off" body1="b" anchor="0 0 0"/></equality><default><default class="off">
            <equality active="false"/></default></default><equality>"#,
    ] {
        assert!(read(&text(none)).expect(none).loop_constraints().is_empty(), "{none}");
    }
    for (wrong, code) in [
        (r#"<connect body1="bb" anchor="0 0 0"/>"#, Code::LoopLink),
        (r#"<weld site1="s" site2="b"/>"#, Code::LoopLink),
    ] {
        let found = read(&text(wrong)).expect_err(wrong).into_vec();
        assert_eq!((found.len(), found[0].code), (1, code), "{found:?}");
    }
}

/// A joint that follows another one linearly is a mimic joint, also if both are drawn at other coordinates than zero. A
/// joint with a constant coordinate does not move.
#[test]
fn joints_that_follow_joints() {
    let text = |constraints: &str| {
        format!(
            r#"<mujoco model="m"><compiler angle="radian"/><worldbody>
            <body><joint name="leader" ref="0.25"/><geom size="1"/>
            <body name="b" pos="1 0 0"><joint name="follower" axis="0 1 0" ref="0.5"/><geom size="1" pos="1 0 0"/></body>
            </body></worldbody><equality>{constraints}</equality></mujoco>"#
        )
    };
    let mimic = |constraint: &str| {
        let model = read(&text(constraint)).expect(constraint);
        model.moving_links()[1]
            .joint
            .mimic
            .map(|mimic| (mimic.leader, mimic.multiplier, mimic.offset))
    };
    // follower - 0.5 = 0.125 - 2 (leader - 0.25)
    let constraint = r#"<joint joint1="follower" joint2="leader" polycoef="0.125 -2 0 0 0"/>"#;
    assert_eq!(mimic(constraint), Some((0, -2.0, 1.125)));
    assert_eq!(mimic(r#"<joint joint1="follower" joint2="leader"/>"#), Some((0, 1.0, 0.25)));
    let fixed = read(&text(r#"<joint joint1="follower" polycoef="0.125"/>"#)).expect("one joint");
    assert_eq!(fixed.nv(), 1);
    let frame = &fixed.links()[fixed.link_index("b").expect("it is a frame")];
    // It is drawn at 0.5, and stays 0.125 from there.
    assert!((frame.pose.rotation[0][2] - 0.125_f64.sin()).abs() < 1e-15, "{:?}", frame.pose);
    for (wrong, code) in [
        (r#"<joint joint1="follow" joint2="leader"/>"#.to_owned(), Code::MimicTarget),
        (r#"<joint joint1="follower" joint2="lead"/>"#.to_owned(), Code::MimicTarget),
        (format!("{constraint}{constraint}"), Code::NotRead),
    ] {
        let found = read(&text(&wrong)).expect_err(&wrong).into_vec();
        assert_eq!((found.len(), found[0].code), (1, code), "{found:?}");
    }
}

/// A constraint of fixed tendons on two joints is a mimic joint, and on one joint it holds the joint.
#[test]
fn fixed_tendons_couple_joints() {
    let text = |constraint: &str| {
        format!(
            r#"<mujoco model="m"><compiler angle="radian"/><worldbody>
            <body><joint name="a" ref="0.25"/><geom size="1"/>
            <body pos="1 0 0"><joint name="b" axis="0 1 0" ref="0.5"/><geom size="1" pos="1 0 0"/>
            <body pos="1 0 0"><joint name="c" axis="0 1 0"/><geom size="1" pos="1 0 0"/></body></body>
            </body></worldbody>
            <tendon><fixed name="ab"><joint joint="b" coef="2"/><joint joint="a" coef="-3"/></fixed>
            <fixed name="a"><joint joint="a" coef="4"/></fixed><fixed name="b"><joint joint="b" coef="2"/></fixed>
            <fixed name="all"><joint joint="a" coef="1"/><joint joint="b" coef="1"/><joint joint="c" coef="1"/></fixed>
            <spatial name="s"><site site="p"/><site site="q"/></spatial></tendon>
            <equality>{constraint}</equality></mujoco>"#
        )
    };
    let mimic = |constraint: &str| {
        let model = read(&text(constraint)).expect(constraint);
        model.moving_links()[1]
            .joint
            .mimic
            .map(|mimic| (mimic.leader, mimic.multiplier, mimic.offset))
    };
    // 2 (b - 0.5) - 3 (a - 0.25) = 0.5
    let own = mimic(r#"<tendon tendon1="ab" polycoef="0.5"/>"#);
    assert_eq!(own, Some((0, 1.5, 0.25 + 0.5 - 1.5 * 0.25)));
    // 2 (b - 0.5) = 0.5 - 0.75 * 4 (a - 0.25)
    let two = mimic(r#"<tendon tendon1="b" tendon2="a" polycoef="0.5 -0.75 0 0 0"/>"#);
    assert_eq!(two, Some((0, -1.5, 0.25 + 0.5 + 1.5 * 0.25)));
    let held = read(&text(r#"<tendon tendon1="b" polycoef="0.5"/>"#)).expect("one joint");
    assert_eq!(held.nv(), 2);
    // A spring does nothing where the length of the tendon is held.
    let sprung = |constraint: &str| {
        read(&text(constraint).replace("name=\"ab\"", "name=\"ab\" stiffness=\"3\" damping=\"1\""))
    };
    assert_eq!(sprung(r#"<tendon tendon1="ab"/>"#).expect("held").nv(), 2);
    for free in
        [r#"<tendon tendon1="ab" active="false"/>"#, r#"<tendon tendon1="b" tendon2="ab"/>"#]
    {
        let found = sprung(free).expect_err(free).into_vec();
        assert_eq!((found.len(), found[0].code), (1, Code::NotRead), "{found:?}");
    }
    // Those of more joints and of higher degrees are soft.
    for (constraint, soft) in [
        (r#"<tendon tendon1="all"/>"#, 1),
        (r#"<tendon tendon1="a" tendon2="b" polycoef="0 1 1"/>"#, 1),
        (r#"<tendon tendon1="ab" tendon2="ab"/>"#, 0),
    ] {
        let model = read(&text(constraint)).expect(constraint);
        assert_eq!((model.nv(), model.soft_constraints().couplings.len()), (3, soft));
    }
    for wrong in [
        r#"<tendon tendon1="s"/>"#,
        r#"<tendon tendon1="none"/>"#,
        r#"<tendon tendon1="ab"/><joint joint1="b"/>"#,
    ] {
        let found = read(&text(wrong)).expect_err(wrong).into_vec();
        assert_eq!((found.len(), found[0].code), (1, Code::NotRead), "{found:?}");
    }
}

/// Keyframes are named coordinates: the links are where MuJoCo has them. Coordinates that a keyframe lacks are those in which
/// the model is drawn; those of joints that follow others or do not move have no effect.
#[test]
fn keyframes_are_named_coordinates() {
    let text = |keys: &str| {
        format!(
            r#"<mujoco model="m"><compiler angle="radian"/><worldbody>
            <body name="base" pos="1 2 3" quat="1 .2 .3 .4"><freejoint name="free"/><geom size=".2"/>
            <body name="upper" pos=".3 .1 0" euler=".2 .3 .4"><joint name="lead" ref=".25" axis="1 2 0"/><geom size=".1"/>
            <body name="ball" pos="0 .2 .1" euler="1 0 .5"><joint name="ball" type="ball" pos=".1 .2 0"/>
            <geom size=".1" pos=".1 0 0"/>
            <body name="slider" pos=".2 0 .1" euler="0 .3 0"><joint name="slide" type="slide" axis="0 1 1" ref=".1"/>
            <geom size=".1"/>
            <body name="tip" pos=".1 .1 .1"><joint name="follow" axis="0 1 0"/><geom size=".1" pos=".2 .1 0"/>
            <body name="end" pos=".1 .1 .1"><joint name="still" axis="0 1 1"/><geom size=".1" pos=".2 .1 0"/></body>
            </body></body></body></body></body></worldbody>
            <equality><joint joint1="follow" joint2="lead" polycoef="0 -2"/><joint joint1="still"/></equality>
            <keyframe>{keys}</keyframe></mujoco>"#
        )
    };
    let home = r#"<key name="home" qpos="-1 .5 2  .8 .1 -.2 .3  .7  .5 -.5 .5 .5  .3  -.9 0"/>"#;
    let model =
        read(&text(&format!(r#"{home}<key name="drawn"/><key time="2"/>"#))).expect("an MJCF");
    let names: Vec<&str> = model.keyframes().iter().map(|key| key.name.as_str()).collect();
    assert_eq!(names, ["home", "drawn", "key_2"]);
    let [drawn, last] = ["drawn", "key_2"].map(|name| &model.keyframe(name).expect(name).q);
    assert_eq!(drawn, last);
    assert_eq!(model.keyframe("other"), None);
    // By MuJoCo 4.0.0.
    for (key, link, expected) in [
        ("home", "base", [-1.0, 0.5, 2.0]),
        ("home", "slider", [-1.2601499671300904, 0.8512399060768763, 2.7227414006139297]),
        ("home", "end", [-1.4979122009921038, 0.6435055147622737, 2.794713211379836]),
        ("drawn", "base", [1.0, 2.0, 3.0]),
        ("drawn", "slider", [1.2743801661439351, 2.49259182887609, 3.1697722338520653]),
        ("drawn", "end", [1.5400506418078839, 2.613477641882264, 3.356335409678185]),
    ] {
        let q = &model.keyframe(key).expect("the keyframe").q;
        let frame = model.link_index(link).expect("the link");
        let mut robot = Interpreter::<f64>::new(model.clone());
        let mut poses = vec![modyn_runtime::Pose::identity(); model.links().len()];
        robot.link_poses(q, &mut poses).expect("sizes");
        for (found, expected) in poses[frame].translation.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{key} {link}: {:?}", poses[frame]);
        }
    }
    let short = r#"<key name="k" qpos="1 2 3"/>"#;
    for (wrong, code) in [
        (short.to_owned(), Code::NumberCount),
        (format!("{home}{home}"), Code::RepeatedElement),
        (r#"<key qpos="x"/>"#.into(), Code::BadNumber),
    ] {
        let found = read(&text(&wrong)).expect_err(&wrong).into_vec();
        assert_eq!((found.len(), found[0].code), (1, code), "{found:?}");
    }
    // Joints that follow or do not move have no velocity. A free joint's linear velocity is in body axes.
    let moving = home.replace("/>", r#" qvel="1 2 3 4 5 6  7  8 9 10  11  12 13"/>"#);
    let moving = read(&text(&moving)).expect("an MJCF");
    let home = moving.keyframe("home").expect("the keyframe");
    assert_eq!(home.qd[3..], [4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0]);
    // The quaternion (.8, .1, -.2, .3) of length sqrt(.78) rotates the body's axes into the world's.
    let [w, x, y, z] = [0.8, 0.1, -0.2, 0.3_f64].map(|part| part / 0.78_f64.sqrt());
    let column = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
    let along: f64 = column.iter().zip([1.0, 2.0, 3.0]).map(|(a, b)| a * b).sum();
    assert!((home.qd[2] - along).abs() < 1e-12, "{:?} {along}", home.qd);
    let short = home_with(r#"qvel="1 2 3""#);
    let errors = read(&text(&short)).expect_err("short").into_vec();
    assert_eq!((errors.len(), errors[0].code), (1, Code::NumberCount), "{errors:?}");
}

/// Returns a keyframe of this name with these attributes.
fn home_with(attributes: &str) -> String {
    format!(r#"<key name="home" {attributes}/>"#)
}

/// A keyframe has a control for each actuator that is read, in the order of the actuators.
#[test]
fn keyframes_have_controls() {
    let text = |other: &str, key: &str| {
        format!(
            r#"<mujoco model="m"><option timestep="0.004"/><worldbody><body><joint name="a"/><geom size="1"/>
            <body><joint name="b" axis="1 0 0"/><geom size="1"/></body></body></worldbody>
            <actuator><motor joint="a"/>{other}<general name="slow" joint="b" dyntype="filter" dynprm="0.1"/></actuator>
            <keyframe>{}</keyframe></mujoco>"#,
            home_with(key)
        )
    };
    let muscle = r#"<muscle joint="b" lengthrange="0 1"/>"#;
    let state = |other: &str, key: &str| {
        let model = read(&text(other, key)).expect("an MJCF");
        assert_eq!(model.time_step(), Some(0.004));
        let home = model.keyframe("home").expect("the keyframe");
        (home.ctrl.clone(), home.act.clone())
    };
    assert_eq!(state("", r#"ctrl="1 2" act="3""#), (vec![1.0, 2.0], vec![3.0]));
    assert_eq!(state(muscle, r#"ctrl="1 2 3""#), (vec![1.0, 3.0], vec![]));
    assert_eq!(state("", r#"ctrl="0 0""#), (vec![], vec![]));
    let options = ReadOptions::default();
    let unread = text(muscle, r#"ctrl="1 2 3" act="0.5 1""#);
    let warnings = modyn_read::read_mjcf(&unread, "m.xml", &options).expect("an MJCF").warnings;
    let message = "the activations of the keyframe are not read";
    assert!(warnings.iter().any(|one| one.message.starts_with(message)), "{warnings:?}");
    for wrong in [r#"ctrl="1""#, r#"ctrl="1 2 3""#, r#"act="1 2""#] {
        let errors = read(&text("", wrong)).expect_err(wrong).into_vec();
        assert_eq!((errors.len(), errors[0].code), (1, Code::NumberCount), "{errors:?}");
        assert!(errors[0].message.contains("of the keyframe `home` has"), "{errors:?}");
    }
    let still = text("", "").replace("0.004", "0");
    let errors = read(&still).expect_err("no time").into_vec();
    assert!(errors.len() == 1 && errors[0].message.contains("not above 0"), "{errors:?}");
    // The option replaces the actuators, and with them the controls.
    let actuators = vec![modyn_read::JointActuator::motor("a")];
    let options = ReadOptions { actuators, ..ReadOptions::default() };
    let replaced = modyn_read::read_mjcf(&text("", r#"ctrl="1 2""#), "m.xml", &options);
    let model = replaced.expect("an MJCF").model;
    assert_eq!(model.keyframe("home").map(|home| home.ctrl.len()), Some(0));
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
        .filter(|one| one.severity == Severity::Error || one.code == Code::KinematicsOnly)
        .map(|one| (one.code, one.position.map(|at| (at.line, at.column))))
        .collect();
    let expected = [
        (Code::BadNumber, Some((2, 54))),
        (Code::BadNumber, Some((2, 86))),
        (Code::BadNumber, Some((4, 33))),
        (Code::KinematicsOnly, Some((3, 24))),
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
    for (link, angle) in model.moving_links().iter().zip(angles) {
        let (sin, cos) = libm::sincos(angle * 0.5);
        let expected = modyn_runtime::conventions::rotation_from_quaternion([0.0, 0.0, sin, cos]);
        assert_eq!(link.joint.origin.rotation, expected, "{angle}");
    }
}
