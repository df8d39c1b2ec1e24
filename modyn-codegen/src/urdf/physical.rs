//! The physical checks of a model that was not read from a text.

use modyn_runtime::model::Model;

use super::build::{LARGEST, TOO_LARGE, TOO_LARGE_HELP, advice};
use super::felt;
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
        if !felt::is_known(link.joint.joint_type) {
            let kind = link.joint.joint_type.name();
            let message = format!("joints of type `{kind}` are not supported yet");
            let help = "use `modyn::Interpreter`";
            add(Severity::Error, Code::UnsupportedJointType, joint(), message, help);
        }
        if !link.joint.origin.translation.iter().all(|x| x.abs() < LARGEST) {
            let message = "its place is too far away to compute with".into();
            add(Severity::Error, Code::NotFinite, joint(), message, "give `origin` in m");
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
        }
    }
    // In a model that is broken otherwise, what is felt says nothing.
    if found.iter().all(|found| found.severity != Severity::Error) {
        for link in felt::unfelt(model.links()).into_iter().map(|i| &model.links()[i]) {
            let subject = Subject::Joint(link.joint.name.clone());
            let found_here = Diagnostic::error(Code::NoInertiaFelt, felt::message(&link.name));
            found.push(found_here.about(subject).with_help(felt::HELP));
        }
    }
    found
}
