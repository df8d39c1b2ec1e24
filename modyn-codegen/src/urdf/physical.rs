//! The physical checks of a model that was not read from a text.

use modyn_runtime::model::Model;

use super::build::{IMPLAUSIBLE_HELP, LARGEST, TOO_LARGE, TOO_LARGE_HELP, advice, implausible};
use super::joint::{DRIVE_HELP, DRIVE_TOO_LARGE, drive_is_finite};
use super::{felt, mimics};
use crate::error::{Code, Diagnostic, Severity, Subject};

/// All that is wrong or odd, as in a description, but without a place.
pub fn check(model: &Model, unphysical_inertia: Severity) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut add = |severity, code, subject, message: String, help: &str| {
        let diagnostic = Diagnostic::new(severity, code, message).about(subject);
        found.push(diagnostic.with_help(help));
    };
    for link in model.links() {
        let joint = || Subject::Joint(link.joint.name.clone());
        let body = || Subject::Link(link.name.clone());
        let inertial = &link.inertial;
        if !link.joint.origin.translation.iter().all(|x| x.abs() < LARGEST) {
            let message = "its place is too far away to compute with".into();
            add(Severity::Error, Code::NotFinite, joint(), message, "give `origin` in m");
        }
        if !drive_is_finite(&link.joint.drive) {
            let (message, help) = (DRIVE_TOO_LARGE.into(), DRIVE_HELP);
            add(Severity::Error, Code::NotFinite, joint(), message, help);
        }
        let figures =
            [inertial.mass].into_iter().chain(inertial.center_of_mass).chain(inertial.inertia);
        if !figures.clone().all(|x| x.abs() < LARGEST) {
            add(Severity::Error, Code::NotFinite, body(), TOO_LARGE.into(), TOO_LARGE_HELP);
        } else if let Some(defect) = inertial.defect() {
            let (code, help) = advice(&defect);
            let severity =
                if code == Code::NegativeMass { Severity::Error } else { unphysical_inertia };
            add(severity, code, body(), defect.to_string(), &help);
        } else if let Some(message) = implausible(inertial) {
            add(Severity::Warning, Code::ImplausibleMass, body(), message, IMPLAUSIBLE_HELP);
        }
    }
    for link in mimics::too_large(model).map(|i| &model.links()[i]) {
        let subject = Subject::Joint(link.joint.name.clone());
        let (message, help) = (mimics::TOO_LARGE.into(), "give the multiplier as a ratio");
        add(Severity::Error, Code::NotFinite, subject, message, help);
    }
    // In a model that is broken otherwise, what is felt says nothing.
    if found.iter().all(|found| found.severity != Severity::Error) {
        for link in felt::unfelt(model).into_iter().map(|i| &model.links()[i]) {
            let subject = Subject::Joint(link.joint.name.clone());
            let found_here = Diagnostic::error(Code::NoInertiaFelt, felt::message(&link.name));
            found.push(found_here.about(subject).with_help(felt::HELP));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use modyn_runtime::joint::JointType;
    use modyn_runtime::model::{DEFAULT_GRAVITY, Inertial, Joint, JointDynamics, Link, Mimic};
    use modyn_runtime::spatial::Pose;

    use super::*;

    /// Two bodies on the world, the first changed.
    fn codes(change: impl Fn(&mut Link)) -> Vec<Code> {
        let body =
            Inertial { mass: 1.0, inertia: [1.0, 0.0, 0.0, 1.0, 0.0, 1.0], ..Inertial::default() };
        let link = |i: usize| Link {
            name: format!("l{i}"),
            parent: None,
            joint: Joint::new(
                format!("j{i}"),
                JointType::Revolute,
                [0.0, 0.0, 1.0],
                Pose::identity(),
            ),
            inertial: body,
        };
        let mut links = vec![link(0), link(1)];
        change(&mut links[0]);
        let model = Model::new("r", DEFAULT_GRAVITY, links, Vec::new()).expect("valid");
        check(&model, Severity::Error).iter().map(|found| found.code).collect()
    }

    #[test]
    fn joints_are_checked_as_in_a_description() {
        let mimic = |multiplier, offset| Some(Mimic { leader: 1, multiplier, offset });
        assert_eq!(codes(|link| link.joint.mimic = mimic(-2.0, 1.0)), []);
        assert_eq!(codes(|link| link.joint.mimic = mimic(1e70, 0.0)), [Code::NotFinite]);
        assert_eq!(codes(|link| link.joint.mimic = mimic(1.0, -1e70)), [Code::NotFinite]);
        let damped = |damping| JointDynamics { damping, ..JointDynamics::default() };
        assert_eq!(codes(|link| link.joint.drive = damped(2.0)), []);
        assert_eq!(codes(|link| link.joint.drive = damped(1e70)), [Code::NotFinite]);
        assert_eq!(codes(|link| link.joint.joint_type = JointType::Floating), []);
        let tip = |joint_type| {
            codes(|link| (link.inertial, link.joint.joint_type) = (Inertial::default(), joint_type))
        };
        for joint_type in [JointType::Universal, JointType::Planar, JointType::Spherical] {
            assert_eq!(tip(joint_type), [Code::NoInertiaFelt]);
        }
    }
}
