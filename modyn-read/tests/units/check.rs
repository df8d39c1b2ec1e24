//! Checks of joints of a given model.

use modyn_read::diagnostics::{Code, Diagnostics, Severity};
use modyn_read::internals::check_model;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    DEFAULT_GRAVITY, Inertial, Joint, JointDynamics, Mimic, Model, MovingLink,
};
use modyn_runtime::spatial::Pose;

/// Returns the codes of two bodies on the world, the first changed by `change`.
fn codes(change: impl Fn(&mut MovingLink)) -> Vec<Code> {
    let body =
        Inertial { mass: 1.0, inertia: [1.0, 0.0, 0.0, 1.0, 0.0, 1.0], ..Inertial::default() };
    let link = |i: usize| MovingLink {
        name: format!("l{i}"),
        parent: None,
        joint: Joint::new(format!("j{i}"), JointType::Revolute, [0.0, 0.0, 1.0], Pose::identity()),
        inertial: body,
    };
    let mut links = vec![link(0), link(1)];
    change(&mut links[0]);
    let model = Model::new("r", DEFAULT_GRAVITY, links, Vec::new()).expect("valid");
    let warnings = check_model(&model, Severity::Error);
    let found = warnings.unwrap_or_else(Diagnostics::into_vec);
    found.iter().map(|found| found.code).collect()
}

#[test]
fn joints_are_checked_as_in_a_description() {
    let mimic = |multiplier, offset| Some(Mimic { leader: 1, multiplier, offset });
    assert_eq!(codes(|link| link.joint.mimic = mimic(-2.0, 1.0)), []);
    assert_eq!(codes(|link| link.joint.mimic = mimic(1e70, 0.0)), [Code::NotFinite]);
    assert_eq!(codes(|link| link.joint.mimic = mimic(1.0, -1e70)), [Code::NotFinite]);
    let damped = |damping| JointDynamics { damping, ..JointDynamics::default() };
    assert_eq!(codes(|link| link.joint.dynamics = damped(2.0)), []);
    assert_eq!(codes(|link| link.joint.dynamics = damped(1e70)), [Code::NotFinite]);
    assert_eq!(codes(|link| link.joint.joint_type = JointType::Floating), []);
    let tip = |joint_type| {
        codes(|link| (link.inertial, link.joint.joint_type) = (Inertial::default(), joint_type))
    };
    for joint_type in [JointType::Universal, JointType::Planar, JointType::Spherical] {
        assert_eq!(tip(joint_type), [Code::KinematicsOnly]);
    }
}
