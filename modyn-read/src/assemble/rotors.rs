//! The rotors in the options.

use crate::description::{Description, Kind, MAX_NUMBER, Rotor};
use crate::diagnostics::{Code, Diagnostic, Report, Subject, Suggestions};

/// Sets the armatures of joints. Errors of an option have no place in the file.
pub fn apply(description: &mut Description, rotors: &[Rotor], report: &mut Report<'_>) {
    let mut armatures = Vec::new();
    let names = description.joints_by_name();
    let mut near = Suggestions::new();
    let mut given = vec![false; description.joints.len()];
    for rotor in rotors {
        let mut error = |message: String, help: &str| {
            let diagnostic = Diagnostic::error(Code::Option, message).with_help(help);
            report.push(diagnostic.with_subject(Subject::Joint(rotor.joint.clone())));
        };
        let armature = rotor.gear_ratio * rotor.gear_ratio * rotor.inertia;
        let good = rotor.inertia >= 0.0 && armature < MAX_NUMBER;
        if !good {
            let message = format!(
                "inertia {} and gear ratio {} are not those of a rotor",
                rotor.inertia, rotor.gear_ratio
            );
            error(message, "give kg m^2 (or kg) of at least 0, and a finite ratio");
        }
        let Some(&j) = names.get(rotor.joint.as_str()) else {
            let near = near.suggest(&rotor.joint, description.joint_names());
            let help = near.map_or_else(
                || "name a joint of the description that moves".into(),
                |name| format!("did you mean `{name}`?"),
            );
            error("the options give it a rotor, but it does not exist".into(), &help);
            continue;
        };
        if description.joints[j].kind == Kind::Fixed {
            let help = "name a joint that moves, or remove the rotor";
            error("the options give it a rotor, but it does not move".into(), help);
        }
        if std::mem::replace(&mut given[j], true) {
            error(
                "the options give it two rotors".into(),
                "keep one, with the sum of the inertias",
            );
        }
        if good {
            armatures.push((j, armature));
        }
    }
    for (j, armature) in armatures {
        description.joints[j].dynamics.armature = armature;
    }
}
