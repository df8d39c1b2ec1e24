//! The armatures in the options: given as they are, or by rotors.

use crate::description::{Description, Kind, MAX_NUMBER, ReadOptions};
use crate::diagnostics::{Code, Diagnostic, Report, Subject, Suggestions};

/// An armature of the options `armature` and `rotors`.
struct Given<'o> {
    joint: &'o str,
    armature: f64,
    /// The error of its numbers and the remedy.
    defect: Option<(String, &'static str)>,
}

/// Sets the armatures of joints. Errors of an option have no place in the file.
pub fn apply(description: &mut Description, options: &ReadOptions, report: &mut Report<'_>) {
    let mut armatures = Vec::new();
    let names = description.joints_by_name();
    let mut near = Suggestions::new();
    let mut given = vec![false; description.joints.len()];
    for Given { joint, armature, defect } in all(options) {
        let mut error = |message: String, help: &str| {
            let diagnostic = Diagnostic::error(Code::Option, message).with_help(help);
            report.push(diagnostic.with_subject(Subject::Joint(joint.into())));
        };
        let good = defect.is_none();
        if let Some((message, help)) = defect {
            error(message, help);
        }
        let Some(&j) = names.get(joint) else {
            let near = near.suggest(joint, description.joint_names());
            let help = near.map_or_else(
                || "name a joint of the description that moves".into(),
                |name| format!("did you mean `{name}`?"),
            );
            error("the options give it an armature, but it does not exist".into(), &help);
            continue;
        };
        if description.joints[j].kind == Kind::Fixed {
            let help = "name a joint that moves, or remove the armature";
            error("the options give it an armature, but it does not move".into(), help);
        }
        if std::mem::replace(&mut given[j], true) {
            let help = "keep one, with the sum of the inertias";
            error("the options `armature` and `rotors` give it two armatures".into(), help);
        }
        if good {
            armatures.push((j, armature));
        }
    }
    for (j, armature) in armatures {
        description.joints[j].dynamics.armature = armature;
    }
}

/// Returns the armatures of both options.
fn all(options: &ReadOptions) -> impl Iterator<Item = Given<'_>> {
    let is_good = |armature: f64| (0.0..MAX_NUMBER).contains(&armature);
    let direct = options.armature.iter().map(move |given| {
        let message = || format!("{:?} is not an armature", given.inertia);
        let defect =
            (!is_good(given.inertia)).then(|| (message(), "give kg m^2 (or kg) of at least 0"));
        Given { joint: &given.joint, armature: given.inertia, defect }
    });
    let rotors = options.rotors.iter().map(move |rotor| {
        let armature = rotor.gear_ratio * rotor.gear_ratio * rotor.inertia;
        let message = || {
            let ratio = rotor.gear_ratio;
            format!("inertia {} and gear ratio {ratio} are not those of a rotor", rotor.inertia)
        };
        let defect = (!is_good(armature) || rotor.inertia < 0.0)
            .then(|| (message(), "give kg m^2 (or kg) of at least 0, and a finite ratio"));
        Given { joint: &rotor.joint, armature, defect }
    });
    direct.chain(rotors)
}
