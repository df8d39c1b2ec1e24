//! The model that a description gives: merged bodies, order, frames; no description makes the reader panic.

#![allow(clippy::float_cmp)] // Numbers of the description must keep their value exactly.

use std::{fmt::Write, fs, path::Path};

use modyn_read::{
    Armature, Base, Mimic, ReadOptions, Reading, Rotor,
    diagnostics::{Code, Severity},
    read,
};
use modyn_runtime::{
    joint::JointType,
    model::{Inertial, JointDynamics, JointFriction, LoopConstraintKind, Model},
};
use proptest::prelude::*;

fn reading(text: &str) -> Reading {
    read(text, "test.urdf", &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn good_files() -> Vec<(String, String)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/good");
    let mut files: Vec<_> = fs::read_dir(path)
        .expect("folder")
        .map(|entry| entry.expect("entry").path())
        .map(|path| (path.display().to_string(), fs::read_to_string(path).expect("UTF-8")))
        .collect();
    files.sort();
    assert!(files.len() >= 20);
    files
}

fn joint(name: &str, kind: &str, parent: &str, child: &str) -> String {
    format!(
        "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/></joint>"
    )
}

fn link(name: &str) -> String {
    format!(
        "<link name='{name}'><inertial><mass value='1'/>\
         <inertia ixx='.1' ixy='0' ixz='0' iyy='.1' iyz='0' izz='.1'/></inertial></link>"
    )
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}

/// Returns the model of a file in `good/`.
fn good(name: &str, options: &ReadOptions) -> Model {
    let (_, text) = good_files().into_iter().find(|(file, _)| file.ends_with(name)).expect("file");
    read(&text, name, options).unwrap_or_else(|e| panic!("{e}")).model
}

/// Returns a pendulum: joint `j` from link `a` to link `b`.
fn pendulum() -> String {
    format!(
        "<robot name='r'>{}{}{}</robot>",
        link("a"),
        link("b"),
        joint("j", "continuous", "a", "b")
    )
}

/// A rod along x with a ball at its end, after two fixed joints; the first of them rotates the ball's frame.
#[test]
fn fixed_links_are_merged_into_the_link_that_carries_them() {
    const HALF_PI: &str = "1.5707963267948966";
    let model = reading(&format!(
        "<robot name='r'>
          <link name='base'><inertial><mass value='9'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>
          <link name='plinth'/>
          <joint name='bolt' type='fixed'><origin xyz='0 0 2'/><parent link='base'/><child link='plinth'/></joint>
          <joint name='hinge' type='revolute'><origin xyz='0 1 0' rpy='0 0 {HALF_PI}'/><parent link='plinth'/><child link='rod'/>
            <axis xyz='0 0 1'/><limit lower='-1' upper='2' velocity='3' effort='4'/></joint>
          <link name='rod'><inertial><origin xyz='0.5 0 0'/><mass value='2'/><inertia ixx='0.25' ixy='0' ixz='0' iyy='0.5' iyz='0' izz='0.5'/></inertial></link>
          <joint name='weld' type='fixed'><origin xyz='1 0 0' rpy='0 0 {HALF_PI}'/><parent link='rod'/><child link='flange'/></joint>
          <link name='flange'/>
          <joint name='glue' type='fixed'><origin xyz='0 1 0'/><parent link='flange'/><child link='ball'/></joint>
          <link name='ball'><inertial><origin xyz='0.5 0 0' rpy='0 0 {HALF_PI}'/><mass value='2'/><inertia ixx='0.25' ixy='0' ixz='0' iyy='0.25' iyz='0' izz='0.375'/></inertial></link>
        </robot>"
    ))
    .model;
    let [rod] = model.moving_links() else { panic!("one link moves") };
    assert_eq!((rod.name.as_str(), rod.parent), ("rod", None));
    assert_eq!((rod.joint.name.as_str(), rod.joint.joint_type), ("hinge", JointType::Revolute));
    assert!(close(&rod.joint.origin.translation, &[0.0, 1.0, 2.0]));
    assert!(close(&rod.joint.origin.rotation.concat(), &[0., -1., 0., 1., 0., 0., 0., 0., 1.]));
    let limits = rod.joint.limits.expect("limits");
    assert_eq!(
        (limits.lower, limits.upper, limits.velocity, limits.effort),
        (Some(-1.), Some(2.), Some(3.), Some(4.))
    );
    // The ball's frame is at [1 0 0] + Rz(90) [0 1 0] = [0 0 0], and its centre of mass is at Rz(90) [0.5 0 0] from there.
    // So the centres are at [0.5 0 0] and [0 0.5 0], and the common centre is at [0.25 0.25 0].
    assert_eq!(rod.inertial.mass, 4.0);
    assert!(close(&rod.inertial.center_of_mass, &[0.25, 0.25, 0.0]));
    // Each 2 kg body is displaced by [0.25 -0.25 0] or [-0.25 0.25 0]: 4 kg / 16 = 0.25 about x and y, twice that about
    // z, and ixy = -sum m x y = +0.25.
    let [xx, xy, xz, yy, yz, zz] = [0.5 + 0.25, 0.25, 0.0, 0.75 + 0.25, 0.0, 0.875 + 0.5];
    assert!(close(&rod.inertial.inertia, &[xx, xy, xz, yy, yz, zz]), "{:?}", rod.inertial);

    let frames: Vec<_> = model.links().iter().map(|f| (f.name.as_str(), f.moving_link)).collect();
    let expected = [
        ("base", None),
        ("plinth", None),
        ("rod", Some(0)),
        ("flange", Some(0)),
        ("ball", Some(0)),
    ];
    assert_eq!(frames, expected);
    let pose = |i: usize| &model.links()[i].pose;
    assert!(close(&pose(1).translation, &[0.0, 0.0, 2.0]));
    assert!(close(&pose(2).translation, &[0.0; 3]));
    assert!(close(&pose(3).translation, &[1.0, 0.0, 0.0]));
    assert!(close(&pose(4).translation, &[0.0; 3]));
    assert!(close(&pose(4).rotation[0], &[0.0, -1.0, 0.0]));
}

#[test]
fn roll_pitch_yaw_turns_about_x_then_y_then_z() {
    let text = format!(
        "<robot name='r'>{}{}{}</robot>",
        link("a"),
        link("b"),
        joint("j", "revolute", "a", "b")
    )
    .replace("<parent", "<origin rpy='0.1 0.2 0.3'/><parent");
    let rotation = reading(&text).model.moving_links()[0].joint.origin.rotation;
    let mut product = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let (x, y, z) = (0.1_f64.sin_cos(), 0.2_f64.sin_cos(), 0.3_f64.sin_cos());
    for factor in [
        [[z.1, -z.0, 0.0], [z.0, z.1, 0.0], [0.0, 0.0, 1.0]],
        [[y.1, 0.0, y.0], [0.0, 1.0, 0.0], [-y.0, 0.0, y.1]],
        [[1.0, 0.0, 0.0], [0.0, x.1, -x.0], [0.0, x.0, x.1]],
    ] {
        product = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..3).map(|k| product[i][k] * factor[k][j]).sum())
        });
    }
    assert!(close(&rotation.concat(), &product.concat()));
}

/// Children are in the order of their joints in the file, also after a fixed link, and for any order of the links.
#[test]
fn links_are_depth_first_in_the_order_of_the_joints() {
    let mut text = String::from("<robot name='r'>");
    for name in ["f", "e", "d", "c", "fix", "b", "a", "base"] {
        text += &link(name);
    }
    for (parent, child) in
        [("a", "c"), ("fix", "b"), ("base", "a"), ("b", "d"), ("a", "e"), ("base", "f")]
    {
        text += &joint(&format!("to_{child}"), "continuous", parent, child);
    }
    text += &joint("weld", "fixed", "base", "fix");
    text += "</robot>";
    let model = reading(&text).model;
    let names: Vec<_> = model.moving_links().iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["a", "c", "e", "f", "b", "d"]);
    let parents: Vec<_> = model.moving_links().iter().map(|l| l.parent).collect();
    assert_eq!(parents, [None, Some(0), Some(0), None, None, Some(4)]);
}

#[test]
fn defaults_are_those_of_urdf() {
    let text = format!(
        "<robot name='r'>{}{}{}</robot>",
        link("a"),
        link("b"),
        joint("j", "prismatic", "a", "b")
    )
    .replace("<parent", "<origin/><limit lower='-1'/><parent");
    let model = reading(&text).model;
    let joint = &model.moving_links()[0].joint;
    assert_eq!(joint.axis, [1.0, 0.0, 0.0]);
    assert_eq!(joint.origin.translation, [0.0; 3]);
    assert_eq!(joint.origin.rotation, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let limits = joint.limits.expect("limits");
    assert_eq!((limits.lower, limits.upper), (Some(-1.0), Some(0.0)));
    assert_eq!(model.gravity(), modyn_runtime::model::DEFAULT_GRAVITY);
    assert_eq!(model.name(), "r");
}

#[test]
fn gravity_must_be_finite() {
    let text = format!(
        "<robot name='r'>{}{}{}</robot>",
        link("a"),
        link("b"),
        joint("j", "continuous", "a", "b")
    );
    for bad in [f64::NAN, f64::INFINITY] {
        let options = ReadOptions { gravity: Some([0.0, bad, 0.0]), ..ReadOptions::default() };
        let errors = read(&text, "test.urdf", &options).expect_err("refused");
        assert_eq!(errors.iter().map(|d| d.code).collect::<Vec<_>>(), [Code::Gravity]);
    }
    let options = ReadOptions { gravity: Some([0.0; 3]), ..ReadOptions::default() };
    assert_eq!(read(&text, "test.urdf", &options).expect("read").model.gravity(), [0.0; 3]);
}

#[test]
fn joints_of_several_coordinates() {
    let model = good("/joint_types.urdf", &ReadOptions::default());
    let types: Vec<_> =
        model.moving_links().iter().map(|link| link.joint.joint_type.name()).collect();
    let expected =
        ["floating", "planar", "spherical", "universal", "universal", "universal", "revolute"];
    assert_eq!(types, expected);
    assert_eq!((model.nq(), model.nv()), (21, 19));
    let axes =
        |i: usize| (model.moving_links()[i].joint.axis, model.moving_links()[i].joint.second_axis);
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    assert_eq!([0, 2, 3, 5].map(axes), [(z, y), (z, y), (x, y), (x, y)]);
    assert!(close(&axes(1).0, &[0.0, 0.6, 0.8]));
    assert!(axes(4).0 == z && close(&axes(4).1, &[0.0, 0.6, 0.8]));
    let limits = model.moving_links()[1].joint.limits.expect("limits");
    assert_eq!((limits.lower, limits.upper), (None, None));
    assert_eq!((limits.effort, limits.velocity), (Some(3.0), Some(4.0)));
}

#[test]
fn mimics_follow_wherever_their_leaders_stand() {
    let model = good("/mimic.urdf", &ReadOptions::default());
    let own =
        |i: usize| model.moving_links()[i].joint.mimic.map(|m| (m.leader, m.multiplier, m.offset));
    assert_eq!([0, 1, 2, 3].map(own), [Some((3, -2.0, 0.5)), None, Some((0, 3.0, 0.0)), None]);
    assert_eq!(model.nq(), 2);
    let resolved = model.mimic(2).map(|m| (m.leader, m.multiplier, m.offset));
    assert_eq!(resolved, Some((3, -6.0, 1.5)));

    let options = ReadOptions { mimic: Mimic::Independent, ..ReadOptions::default() };
    let model = good("/mimic.urdf", &options);
    assert!(!model.has_mimics());
    assert_eq!(model.nq(), 4);
}

#[test]
fn joint_dynamics_are_those_of_the_file_or_of_the_options() {
    let dynamics = |armature, damping, friction| JointDynamics { armature, damping, friction };
    let read = |options: &ReadOptions| {
        let model = good("/joint_dynamics.urdf", options);
        model.moving_links().iter().map(|link| link.joint.dynamics).collect::<Vec<_>>()
    };
    let mut expected = [
        dynamics(0.0, 0.5, 0.25),
        dynamics(2.0, 0.0, 0.0),
        dynamics(8.0, 0.0, 0.0),
        JointDynamics::default(),
    ];
    assert_eq!(read(&ReadOptions::default()), expected);
    let rotor =
        |joint: &str, inertia, gear_ratio| Rotor { joint: joint.into(), inertia, gear_ratio };
    let rotors = vec![rotor("j0", 0.25, 2.0), rotor("j2", 0.0, 7.0)];
    (expected[0].armature, expected[2].armature) = (1.0, 0.0);
    assert_eq!(read(&ReadOptions { rotors, ..ReadOptions::default() }), expected);
    // The armature is the inertia after the gear.
    let armature = vec![Armature::new("j0", 1.0), Armature::new("j2", 0.0)];
    assert_eq!(read(&ReadOptions { armature, ..ReadOptions::default() }), expected);
}

/// The option `base` and a floating joint of the file.
#[test]
fn the_option_base_and_floating_joints() {
    let robot = |root: &str, kind: &str| {
        let joints = joint("root", "floating", root, "trunk") + &joint("hip", kind, "trunk", "leg");
        let links = format!("<link name='{root}'/>{}{}", link("trunk"), link("leg"));
        let placed = joints.replacen("</joint>", "<origin xyz='1 2 3'/></joint>", 1);
        format!("<robot name='r'>{links}{placed}</robot>")
    };
    let read_with = |text: &str, base: Base| {
        read(text, "r.urdf", &ReadOptions { base, ..ReadOptions::default() })
    };
    for root in ["world", "base"] {
        let text = robot(root, "continuous");
        assert_eq!(read_with(&text, Base::Auto).expect("a robot").model.nv(), 7);
        let fixed = read_with(&text, Base::Fixed).expect("a robot");
        assert_eq!((fixed.model.nv(), fixed.warnings.len()), (1, 0));
        assert_eq!(fixed.model.moving_links()[0].joint.origin.translation, [1.0, 2.0, 3.0]);
        let found = read_with(&text, Base::Floating).expect_err("refused").into_vec();
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].to_string().contains("joint `root`: `base = floating` is set"));
        // The help is followed.
        assert_eq!(read_with(&text, Base::default()).expect("a robot").model.nv(), 7);
    }
    // A body that floats on another moving body is no base.
    let carried =
        robot("base", "continuous").replace("'hip' type='continuous'", "'hip' type='floating'");
    assert_eq!(read_with(&carried, Base::Fixed).expect("a robot").model.nv(), 6);
    let links = link("base") + &link("arm") + &link("load");
    let joints = joint("a", "continuous", "base", "arm") + &joint("b", "floating", "arm", "load");
    let text = format!("<robot name='r'>{links}{joints}</robot>");
    assert_eq!(read_with(&text, Base::Fixed).expect("a robot").model.nv(), 7);
    assert_eq!(read_with(&text, Base::Floating).expect("a robot").model.nv(), 13);
}

/// A follower is four times as fast as its leader, so a quarter of its velocity limit is the
/// leader's.
#[test]
fn followers_limit_the_velocity_of_their_leader() {
    let joint = |name: &str, velocity: &str, rest: &str| {
        let limit = format!("<limit lower='0' upper='0.04' effort='9' {velocity}/>{rest}");
        joint(name, "prismatic", "palm", &format!("{name}_finger"))
            .replace("</joint>", &format!("{limit}</joint>"))
    };
    let limit = |velocities: [&str; 2], multiplier: f64| {
        let mimic = format!("<mimic joint='left' multiplier='{multiplier}'/>");
        let links = link("palm") + &link("left_finger") + &link("right_finger");
        let joints = joint("left", velocities[0], "") + &joint("right", velocities[1], &mimic);
        let model = reading(&format!("<robot name='r'>{links}{joints}</robot>")).model;
        let [leader, follower] = [0, 1].map(|link| model.velocity_limit(link));
        assert_eq!(leader, follower);
        leader
    };
    let one = "velocity='1'";
    assert_eq!(limit([one, one], 4.0), 0.25);
    assert_eq!(limit([one, one], -4.0), 0.25);
    assert_eq!(limit([one, one], 0.5), 1.0);
    assert_eq!(limit([one, ""], 4.0), 1.0);
    assert_eq!(limit(["", one], 2.0), 0.5);
    assert_eq!(limit(["", ""], 2.0), f64::INFINITY);
    assert_eq!(limit([one, one], 0.0), 1.0);
}

/// The elements by which ROS, Gazebo and Drake change the dynamics of a URDF.
#[test]
fn extensions_with_a_meaning_are_read() {
    let links = link("base") + &link("arm") + &link("hand");
    let joints = joint("shoulder", "continuous", "base", "arm")
        + &joint("wrist", "continuous", "arm", "hand");
    let robot = |extensions: &str| {
        let found = reading(&format!("<robot name='r'>{links}{joints}{extensions}</robot>"));
        assert_eq!(found.warnings, [], "{extensions}");
        found.model
    };
    let armature = |rotor: &str| {
        let transmission = format!("<transmission><joint name='wrist'/>{rotor}</transmission>");
        robot(&transmission).moving_links()[1].joint.dynamics.armature
    };
    // With `panda_arm.urdf` of RobotLocomotion/models, whose rotors are of this form, Drake 1.51.1
    // and modyn have equal mass matrices; `sdf/extensions.urdf` compares all numbers.
    let drakes = "<drake:rotor_inertia value='0.0001'/><drake:gear_ratio value='100'/>";
    assert!(close(&[armature(&format!("<actuator name='a'>{drakes}</actuator>"))], &[1.0]));
    let alone = "<actuator name='a'><drake:rotor_inertia value='0.5'/></actuator>";
    assert!(close(&[armature(alone)], &[0.5]));
    let ros = "<actuator name='a'><mechanicalReduction>-20</mechanicalReduction><motorInertia>0.01</motorInertia></actuator>";
    assert!(close(&[armature(ros)], &[4.0]));
    assert!(close(&[armature("<motorInertia>0.25</motorInertia>")], &[0.25]));
    assert!(close(&[armature("<mechanicalReduction>7</mechanicalReduction>")], &[0.0]));

    let spring = "<gazebo reference='wrist'><springReference>0.3</springReference><springStiffness value='5'/></gazebo>";
    let model = robot(spring);
    let [spring] = model.springs() else { panic!("one spring") };
    assert_eq!((spring.link, spring.stiffness, &spring.reference[..]), (1, 5.0, &[0.3][..]));

    for switch in ["<gravity>0</gravity>", "<turnGravityOff>true</turnGravityOff>"] {
        let without = |link: &str| robot(&format!("<gazebo reference='{link}'>{switch}</gazebo>"));
        assert_eq!(without("hand").gravity_compensation(), [0.0, 0.0, 1.0], "{switch}");
        assert_eq!(without("base"), robot(""), "{switch}");
    }

    let constraint = "<drake:ball_constraint><drake:ball_constraint_body_A name='base'/><drake:ball_constraint_body_B name='hand'/>
        <drake:ball_constraint_p_AP value='1 2 3'/><drake:ball_constraint_p_BQ value='4 5 6'/></drake:ball_constraint>";
    let model = robot(constraint);
    let [constraint] = model.loop_constraints() else { panic!("one constraint") };
    let points = constraint.ends.each_ref().map(|end| (end.link, end.pose.translation));
    assert_eq!(points, [(0, [1.0, 2.0, 3.0]), (2, [4.0, 5.0, 6.0])]);
    assert_eq!(constraint.kind, LoopConstraintKind::Point);
}

#[test]
fn bad_options_are_errors_without_a_place() {
    let rotor =
        |joint: &str, inertia, gear_ratio| Rotor { joint: joint.into(), inertia, gear_ratio };
    let refused = |text: &str, options: ReadOptions| {
        let errors = read(text, "test.urdf", &options).expect_err("refused");
        let plain = |d: &modyn_read::diagnostics::Diagnostic| {
            d.code == Code::Option && d.position.is_none() && d.help.is_some()
        };
        assert!(errors.iter().all(plain), "{errors}");
        errors.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let fixed = pendulum()
        .replace("</robot>", &format!("{}{}</robot>", link("c"), joint("weld", "fixed", "b", "c")));
    for (bad, text) in [
        (
            rotor("jj", 1.0, 1.0),
            "joint `jj`: the options give it an armature, but it does not exist\n  help: did you mean `j`?",
        ),
        (
            rotor("weld", 1.0, 1.0),
            "joint `weld`: the options give it an armature, but it does not move",
        ),
        (rotor("j", -1.0, 1.0), "joint `j`: inertia -1 and gear ratio 1 are not those of a rotor"),
        (rotor("j", f64::NAN, 1.0), "inertia NaN"),
        (rotor("j", 0.0, f64::INFINITY), "gear ratio inf"),
        (rotor("j", 1.0, 1e40), "gear ratio 1000"),
    ] {
        let options = ReadOptions { rotors: vec![bad], ..ReadOptions::default() };
        let errors = refused(&fixed, options);
        assert!(errors.len() == 1 && errors[0].contains(text), "{errors:?}");
    }
    for (bad, text) in [
        (Armature::new("jj", 1.0), "the options give it an armature, but it does not exist"),
        (Armature::new("j", -1.0), "joint `j`: -1.0 is not an armature"),
        (Armature::new("j", f64::NAN), "NaN is not an armature"),
        (Armature::new("j", 1e80), "1e80 is not an armature"),
    ] {
        let options = ReadOptions { armature: vec![bad], ..ReadOptions::default() };
        let errors = refused(&fixed, options);
        assert!(errors.len() == 1 && errors[0].contains(text), "{errors:?}");
    }
    let both = ReadOptions {
        armature: vec![Armature::new("j", 1.0)],
        rotors: vec![rotor("j", 1.0, 1.0)],
        ..ReadOptions::default()
    };
    let errors = refused(&fixed, both);
    assert!(errors.len() == 1 && errors[0].contains("two armatures"), "{errors:?}");
    // All errors are reported at once, in linear time.
    let rotors = (0..50_000).map(|i| rotor(&format!("x{i}"), -1.0, 1.0)).collect();
    let options = ReadOptions {
        rotors,
        joint_friction: Some(JointFriction::Smooth(0.0)),
        ..ReadOptions::default()
    };
    assert_eq!(refused(&fixed, options).len(), 100_001);
    let rotors = vec![rotor("j", 1.0, 1.0); 2];
    let errors = refused(&fixed, ReadOptions { rotors, ..ReadOptions::default() });
    assert!(errors.len() == 1 && errors[0].contains("two armatures"), "{errors:?}");
}

#[test]
fn friction_is_the_models() {
    let read_with = |friction| {
        let friction = Some(friction);
        read(
            &pendulum(),
            "test.urdf",
            &ReadOptions { joint_friction: friction, ..ReadOptions::default() },
        )
    };
    for good in [
        JointFriction::None,
        JointFriction::Viscous,
        JointFriction::Coulomb,
        JointFriction::Smooth(0.5),
    ] {
        assert_eq!(read_with(good).expect("good").model.joint_friction(), good);
    }
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let errors = read_with(JointFriction::Smooth(bad)).expect_err("refused");
        assert_eq!(errors.iter().map(|d| d.code).collect::<Vec<_>>(), [Code::Option]);
    }
}

#[test]
fn a_base_that_floats_is_a_link_that_moves() {
    let options = ReadOptions { base: Base::Floating, ..ReadOptions::default() };
    let model = good("/floating_base.urdf", &options);
    let [base, arm] = model.moving_links() else { panic!("two links move") };
    assert_eq!((base.name.as_str(), base.parent), ("base", None));
    assert_eq!(base.joint.joint_type, JointType::Floating);
    // The arm's joint already has the name.
    assert_eq!(base.joint.name, "floating_base_1");
    assert_eq!((arm.joint.name.as_str(), arm.parent), ("floating_base", Some(0)));
    // The trunk is fixed to the base, 1 m higher.
    assert_eq!((base.inertial.mass, base.inertial.center_of_mass), (1.0, [0.0, 0.0, 1.0]));
    assert_eq!(arm.joint.origin.translation, [0.0, 0.0, 1.0]);
    let frames: Vec<_> = model.links().iter().map(|f| (f.name.as_str(), f.moving_link)).collect();
    assert_eq!(frames, [("base", Some(0)), ("trunk", Some(0)), ("arm", Some(1))]);
    assert_eq!((model.nq(), model.nv()), (8, 7));

    let free = good("/free_body.urdf", &options);
    assert_eq!(free.coordinate_names()[0], "floating_base.x");
    let fixed = good("/floating_base.urdf", &ReadOptions::default());
    assert_eq!((fixed.nq(), fixed.links()[1].moving_link), (1, None));
}

#[test]
fn frames_have_the_inertia_of_their_own_link() {
    let options = ReadOptions { base: Base::Floating, ..ReadOptions::default() };
    for options in [ReadOptions::default(), options] {
        let model = good("/floating_base.urdf", &options);
        let own: Vec<_> = model.links().iter().map(|link| link.inertial).collect();
        let inertia = [0.1, 0.0, 0.0, 0.1, 0.0, 0.1];
        let body = Inertial { mass: 1.0, center_of_mass: [0.0; 3], inertia };
        assert_eq!(own, [Inertial::default(), body, body]);
    }
}

/// Neither the call stack nor a quadratic loop limits the length, on one line or on many. The first joint still moves
/// the inertia at the chain's end.
#[test]
#[ignore = "slow: long chains in an unoptimized reader"]
fn a_chain_of_100_000_joints() {
    const N: usize = 100_000;
    let mut text = String::from("<robot name='r'>");
    for i in 0..=N {
        text += &link(&format!("l{i}"));
    }
    for i in (0..N).rev() {
        let kind = if i % 3 == 2 { "fixed" } else { "revolute" };
        let axis = ["0 0 1", "0 1 0"][i % 2];
        write!(
            text,
            "<joint name='j{i}' type='{kind}'><origin xyz='0.5 0 0.1' rpy='0.1 0 0'/><parent link='l{i}'/>\
             <child link='l{}'/><axis xyz='{axis}'/></joint>",
            i + 1
        )
        .expect("a string");
    }
    text += "</robot>";
    let model = reading(&text).model;
    assert_eq!((model.nq(), model.links().len()), (66_667, N + 1));

    // A cycle of the same length.
    let closed = text.replace("<child link='l100000'/>", "<child link='l0'/>");
    let errors = read(&closed, "test.urdf", &ReadOptions::default()).expect_err("refused");
    assert!(errors.iter().any(|d| d.code == Code::Cycle));
}

/// Each joint follows the next one, or all of them form a cycle.
#[test]
#[ignore = "slow: long chains in an unoptimized reader"]
fn a_chain_of_100_000_mimics() {
    const N: usize = 100_000;
    let mut text = String::from("<robot name='r'>");
    for i in 0..=N {
        text += &link(&format!("l{i}"));
    }
    for i in 0..N {
        write!(
            text,
            "<joint name='j{i}' type='revolute'><parent link='l{}'/><child link='l{}'/>\
             <mimic joint='j{}' multiplier='-1' offset='1'/></joint>",
            if i % 2 == 0 { i } else { 0 },
            i + 1,
            i + 1
        )
        .expect("a string");
    }
    text += "</robot>";
    let end = format!("<mimic joint='j{N}' multiplier='-1' offset='1'/>");
    let model = reading(&text.replace(&end, "")).model;
    assert_eq!((model.moving_links().len(), model.nq()), (N, 1));
    let first = model.moving_links().iter().position(|link| link.joint.name == "j0").expect("j0");
    let mimic = model.mimic(first).expect("follows");
    assert_eq!((mimic.multiplier, mimic.offset), (-1.0, 1.0));

    let closed = text.replace(&end, "<mimic joint='j0'/>");
    let errors = read(&closed, "test.urdf", &ReadOptions::default()).expect_err("refused");
    assert_eq!(errors.iter().map(|d| d.code).collect::<Vec<_>>(), [Code::MimicCycle]);
}

#[test]
fn a_chain_of_20_000_joints_of_all_types() {
    const N: usize = 20_000;
    let mut text = String::from("<robot name='r'>");
    for i in 0..=N {
        text += &link(&format!("l{i}"));
    }
    for i in 0..N {
        let kind = ["universal", "planar", "spherical", "floating", "revolute"][i % 5];
        text += &joint(&format!("j{i}"), kind, &format!("l{i}"), &format!("l{}", i + 1))
            .replace("<parent", "<origin xyz='0.1 0.2 0.3'/><axis xyz='0 0 1'/><parent");
    }
    text += "</robot>";
    let model = reading(&text).model;
    assert_eq!((model.moving_links().len(), model.nv()), (N, N / 5 * 15));
}

/// urdf-rs reads the same numbers from the same text: an independent implementation.
#[test]
fn numbers_equal_those_of_urdf_rs() {
    let mut compared = 0;
    // urdf-rs has no floating base.
    let is_plain =
        |(_, text): &(String, String)| !text.contains("base = ") && !text.contains("<xacro:");
    for (file, text) in good_files().into_iter().filter(is_plain) {
        let follows = !text.contains("mimic = independent");
        let options = ReadOptions {
            mimic: if follows { Mimic::Follow } else { Mimic::Independent },
            unphysical_inertia: Severity::Warning,
            ..ReadOptions::default()
        };
        let Ok(reading) = read(&text, &file, &options) else { panic!("{file}") };
        // urdf-rs refuses some files because of elements that the dynamics does not need.
        let Ok(robot) = urdf_rs::read_from_string(&text) else { continue };
        // A link that the file does not describe has no record there.
        if file.ends_with("drakes_world.urdf") {
            continue;
        }
        assert_eq!(
            reading.model.links().iter().map(|f| &f.name).collect::<Vec<_>>(),
            robot.links.iter().map(|l| &l.name).collect::<Vec<_>>(),
            "{file}"
        );
        for link in reading.model.moving_links() {
            let joint = robot.joints.iter().find(|j| j.name == link.joint.name).expect("joint");
            let found = link.joint.dynamics;
            let written = joint.dynamics.as_ref().map_or([0.0; 2], |d| [d.damping, d.friction]);
            assert_eq!([found.damping, found.friction], written, "{file}");
            let mimic = link.joint.mimic.map(|mimic| {
                let leader = reading.model.moving_links()[mimic.leader].joint.name.clone();
                (leader, mimic.multiplier, mimic.offset)
            });
            let witness = joint.mimic.as_ref().filter(|_| follows).map(|mimic| {
                let (multiplier, offset) = (mimic.multiplier, mimic.offset);
                (mimic.joint.clone(), multiplier.unwrap_or(1.0), offset.unwrap_or(0.0))
            });
            assert_eq!(mimic, witness, "{file}");
            let turns_any_way =
                matches!(link.joint.joint_type, JointType::Spherical | JointType::Floating);
            let length = joint.axis.xyz.iter().map(|x| x * x).sum::<f64>().sqrt();
            let axis = joint.axis.xyz.map(|x| x / length);
            assert!(turns_any_way || close(&link.joint.axis, &axis), "{file}");
            let moves = |name: &str| {
                robot
                    .joints
                    .iter()
                    .any(|j| j.child.link == name && j.joint_type != urdf_rs::JointType::Fixed)
            };
            if moves(&joint.parent.link) {
                assert!(close(&link.joint.origin.translation, &*joint.origin.xyz), "{file}");
            }
            // Bodies without fixed links have the numbers of the file.
            if !robot.joints.iter().any(|j| j.parent.link == link.name && !moves(&j.child.link)) {
                let own = robot.links.iter().find(|l| l.name == link.name).expect("link");
                assert!(close(&[link.inertial.mass], &[own.inertial.mass.value]), "{file}");
                assert!(close(&link.inertial.center_of_mass, &*own.inertial.origin.xyz), "{file}");
                compared += 1;
            }
        }
    }
    assert!(compared >= 15, "only {compared} bodies were compared");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Files with lines and bytes deleted, repeated, exchanged and inserted.
    #[test]
    fn no_text_makes_it_panic(
        file in any::<prop::sample::Index>(),
        edits in prop::collection::vec((0..6_u8, any::<prop::sample::Index>(), any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let files = good_files();
        let mut text = file.get(&files).1.clone().into_bytes();
        for (kind, a, b, byte) in edits {
            if text.is_empty() {
                break;
            }
            let (i, j) = (a.index(text.len()), b.index(text.len()));
            match kind {
                0 => text[i] = byte,
                1 => drop(text.remove(i)),
                2 => text.swap(i, j),
                3 => text.truncate(i),
                4 => {
                    // Whole lines change, which keeps most of the document well-formed.
                    let mut lines: Vec<&[u8]> = text.split(|&b| b == b'\n').collect();
                    let (i, j) = (a.index(lines.len()), b.index(lines.len()));
                    match byte % 3 {
                        0 => lines.swap(i, j),
                        1 => lines[i] = lines[j],
                        _ => drop(lines.remove(i)),
                    }
                    text = lines.join(&b'\n');
                }
                _ => {
                    // A number or a name in quotes is replaced by another one.
                    let Some(open) = text[i..].iter().position(|&b| b == b'"').map(|k| i + k + 1) else { continue };
                    let Some(close) = text[open..].iter().position(|&b| b == b'"').map(|k| open + k) else { continue };
                    let words: [&[u8]; 12] = [
                        b"", b"0", b"-1", b"1e308", b"nan", b"base", b"arm", b"0 0 1e-300",
                        b"shoulder", b"wrist", b"universal", b"1e50",
                    ];
                    text.splice(open..close, words[byte as usize % words.len()].iter().copied());
                }
            }
        }
        let text = String::from_utf8_lossy(&text);
        for (mimic, base) in [
            (Mimic::Follow, Base::Floating),
            (Mimic::Follow, Base::Fixed),
            (Mimic::Refuse, Base::Fixed),
            (Mimic::Independent, Base::Fixed),
        ] {
            let options =
                ReadOptions { mimic, base, unphysical_inertia: Severity::Warning, ..ReadOptions::default() };
            match read(&text, "test.urdf", &options) {
                Ok(reading) => prop_assert!(reading.model.nq() > 0),
                Err(errors) => {
                    prop_assert!(errors.has_errors());
                    prop_assert!(errors.iter().all(|d| d.code != Code::InvalidModel), "{errors}");
                }
            }
        }
    }
}

/// Files in memory are found by the ends of their paths, the longest first, and nothing is read from the disk.
#[test]
fn files_in_memory_are_found_by_their_names() {
    let mesh = |size: f64| {
        let vertices = [[0.0, 0.0, 0.0], [size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]];
        let lines = vertices.map(|[x, y, z]| format!("v {x} {y} {z}\n"));
        (lines.concat() + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n").into_bytes()
    };
    let visual = |file: &str| {
        format!("<visual><geometry><mesh filename=\"{file}\"/></geometry></visual></robot>")
    };
    let text = |file: &str| {
        let all = pendulum();
        let (before, after) = all.rsplit_once("</link>").expect("a link");
        format!("{before}{}</link>{after}", visual(file).trim_end_matches("</robot>"))
    };
    let files = [("left/hand.obj", 1.0), ("pkg/right/hand.obj", 2.0), ("foot.obj", 3.0)];
    let files = files.map(|(path, size)| (path.into(), mesh(size)));
    let options = ReadOptions {
        folder: Some("elsewhere".into()),
        files: modyn_read::FileStore::in_memory(files),
        shapes: true,
        ..ReadOptions::default()
    };
    let extent = |file: &str| -> Option<f64> {
        let reading = modyn_read::read(&text(file), "r.urdf", &options).expect("a robot");
        let shape = reading.shapes.of_frames.iter().flatten().next()?;
        let modyn_read::Geometry::Mesh(mesh) = &shape.geometry else { panic!("{shape:?}") };
        Some(mesh.vertices[1][0])
    };
    for (file, expected) in [
        ("hand.obj", Some(1.0)),
        ("package://pkg/right/hand.obj", Some(2.0)),
        ("../other/right/hand.obj", Some(2.0)),
        ("package://unknown/meshes/foot.obj", Some(3.0)),
        ("file:///foot.obj", Some(3.0)),
        ("arm.obj", None),
        ("Cargo.toml", None),
    ] {
        assert_eq!(extent(file), expected, "{file}");
    }
}

/// Files that include themselves by other names end, with an error.
#[test]
fn files_in_memory_that_include_themselves_are_refused() {
    let cases = [
        (
            "r.xml",
            "<mujoco><include file=\"a.xml\"/></mujoco>",
            "a.xml",
            "<mujoco><include file=\"x/a.xml\"/></mujoco>",
        ),
        (
            "r.sdf",
            "<sdf version='1.9'><model name='m'><include><uri>a.sdf</uri></include></model></sdf>",
            "a.sdf",
            "<sdf version='1.9'><model name='m'><include><uri>x/a.sdf</uri></include></model></sdf>",
        ),
        (
            "r.xacro",
            "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:include filename='a.xacro'/></robot>",
            "a.xacro",
            "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:include filename='x/a.xacro'/></robot>",
        ),
    ];
    for (main, text, name, included) in cases {
        let file = (name.into(), included.as_bytes().to_vec());
        let files = modyn_read::FileStore::in_memory([file]);
        let options = ReadOptions { folder: Some("".into()), files, ..ReadOptions::default() };
        let found = modyn_read::read(text, main, &options).expect_err("refused").to_string();
        let reasons = ["included twice", "includes itself", "more than"];
        assert!(reasons.iter().any(|reason| found.contains(reason)), "{found}");
    }
}
