//! The actuators of the options and of the description, whose joints become links of the model.

use modyn_runtime::model::{
    Actuation, Actuator, AffineLaw, JointForceRange, Limits, MovingLink, TorqueSpeedLine,
    Transmission,
};
use rustc_hash::FxHashMap;

use crate::description::{
    ControlLaw, Description, JointActuator, JointRecord, Kind, MAX_NUMBER, Mimic, ReadOptions,
};
use crate::diagnostics::{Code, Diagnostic, Report, Severity, Subject, Suggestions, listed};
use crate::work::counted;

/// Replaces the actuators of the description by the options' actuators, if there are some. Errors of
/// an option have no place in the file.
pub fn apply(description: &mut Description, options: &ReadOptions, report: &mut Report<'_>) {
    if options.actuators.is_empty() {
        return;
    }
    let replaced = std::mem::take(&mut description.actuation);
    for keyframe in &mut description.keyframes {
        keyframe.ctrl.clear();
        keyframe.act.clear();
    }
    if !replaced.actuators.is_empty() {
        let names = replaced.actuators.iter().map(|actuator| actuator.name.as_str());
        let message =
            format!("the option `actuators` replaces {} of the file", listed("actuator", names));
        let help = "remove `<actuator>` from the file, or give the option an actuator for each \
                    joint that is to have one";
        report.add(Severity::Warning, Code::Option, description.at, None, message, help);
    }
    let mut near = Suggestions::new();
    let mut given: Vec<Option<&JointActuator>> = vec![None; description.joints.len()];
    for actuator in &options.actuators {
        if let Some([message, help]) = number_error(actuator) {
            push_error(&actuator.joint, message.into(), help.into(), report);
            continue;
        }
        let joints = joints_of(actuator, description, options.mimic);
        if joints.is_empty() {
            let [message, help] = target_error(actuator, description, &mut near);
            push_error(&actuator.joint, message, help, report);
        }
        for joint in joints {
            if given[joint].replace(actuator).is_some() {
                let name = &description.joints[joint].name.text;
                let message = "the options give it two actuators".into();
                let help = "keep one; the names of `actuators` must not share a joint".into();
                push_error(name, message, help, report);
            }
        }
    }
    let mut delays = 0_usize;
    for (joint, actuator) in given.into_iter().enumerate() {
        let Some(actuator) = actuator else { continue };
        let record = &mut description.joints[joint];
        let before = delays;
        delays = delays.saturating_add(actuator.delay);
        if before <= Actuation::MAX_DELAYS && delays > Actuation::MAX_DELAYS {
            let message = format!(
                "with its actuator the delays have {delays} steps together, more than {}",
                Actuation::MAX_DELAYS
            );
            let help = "write the number of steps before a control acts, such as `delay = 2`";
            push_error(&record.name.text, message, help.into(), report);
        }
        match of_joint(actuator, joint, record) {
            Ok(actuator) => description.actuation.actuators.push(actuator),
            Err([message, help]) => {
                push_error(&record.name.text, message.into(), help.into(), report);
            }
        }
        if actuator.effort.is_some() && record.actuator_forces.is_none() {
            let none = Limits { lower: None, upper: None, velocity: None, effort: None };
            let limits = record.limits.unwrap_or(none);
            record.limits = Some(Limits { effort: actuator.effort, ..limits });
        }
    }
}

fn push_error(joint: &str, message: String, help: String, report: &mut Report<'_>) {
    let diagnostic = Diagnostic::error(Code::Option, message).with_help(help);
    report.push(diagnostic.with_subject(Subject::Joint(joint.into())));
}

/// Returns the message and the help about the numbers of an actuator that are out of their range.
fn number_error(actuator: &JointActuator) -> Option<[&'static str; 2]> {
    let is_gain = |gain: f64| (0.0..MAX_NUMBER).contains(&gain);
    let has_gains = match actuator.law {
        ControlLaw::Position { kp, kd } => is_gain(kp) && is_gain(kd),
        ControlLaw::Velocity { kd } => is_gain(kd),
        ControlLaw::Motor => true,
    };
    let is_limit = |limit: Option<f64>| limit.is_none_or(|limit| limit > 0.0 && limit < MAX_NUMBER);
    let checks = [
        (
            has_gains,
            "a gain of its actuator is not a finite number of at least 0",
            "write kp in N m/rad (or N/m), and kd in N m s/rad (or N s/m)",
        ),
        (
            is_limit(actuator.effort),
            "the effort of its actuator is not a finite number above 0",
            "write the largest force in N m (or N)",
        ),
        (
            is_limit(actuator.saturation),
            "the saturation of its actuator is not a finite number above 0",
            "write the stall force in N m (or N)",
        ),
        (
            is_limit(actuator.velocity),
            "the velocity of its actuator is not a finite number above 0",
            "write the no-load speed in rad/s (or m/s)",
        ),
        (
            actuator.velocity.is_none() || actuator.saturation.is_some(),
            "its actuator has a no-load speed, `velocity`, and no stall force",
            "write the largest force at rest, `saturation = 30`, or remove `velocity`",
        ),
    ];
    let failed = checks.into_iter().find(|(is_sound, ..)| !is_sound)?;
    Some([failed.1, failed.2])
}

/// Returns whether a joint can have an actuator.
fn is_single(joint: &JointRecord) -> bool {
    matches!(joint.kind, Kind::Moving(kind) if kind.nv() == 1)
}

/// Returns the joints that an actuator of the options is for. A pattern is not for mimic joints.
fn joints_of(actuator: &JointActuator, description: &Description, mimic: Mimic) -> Vec<usize> {
    let pattern = actuator.joint.as_str();
    let follows = |joint: &JointRecord| joint.mimic.is_some() && mimic == Mimic::Follow;
    let is_meant = |joint: &JointRecord| {
        let name = joint.name.text.as_str();
        let is_matched = pattern.contains('*') && matches(pattern, name) && !follows(joint);
        is_single(joint) && (name == pattern || is_matched)
    };
    let joints = counted(description.joints.iter()).enumerate();
    joints.filter(|(_, joint)| is_meant(joint)).map(|(index, _)| index).collect()
}

/// Returns whether a name fits a pattern, in which each `*` stands for any text.
fn matches(pattern: &str, name: &str) -> bool {
    let Some((start, rest)) = pattern.split_once('*') else { return pattern == name };
    let Some(mut remaining) = name.strip_prefix(start) else { return false };
    let mut parts: Vec<&str> = rest.split('*').collect();
    let end = parts.pop().unwrap_or_default();
    for part in parts {
        let Some((_, after)) = remaining.split_once(part) else { return false };
        remaining = after;
    }
    remaining.ends_with(end)
}

/// Returns the message and the help about a name that no joint with an actuator has.
fn target_error(
    actuator: &JointActuator,
    description: &Description,
    near: &mut Suggestions,
) -> [String; 2] {
    let name = actuator.joint.as_str();
    let other = "name a joint that is revolute, continuous or prismatic, or several by `*`";
    let message = match description.joints.iter().find(|joint| joint.name.text == name) {
        Some(joint) if joint.kind == Kind::Fixed => {
            "the options give it an actuator, but it does not move"
        }
        Some(_) => "the options give it an actuator, but it has several degrees of freedom",
        None if name.contains('*') => {
            "the options give it an actuator, but no joint with one degree of freedom has such a name"
        }
        None => {
            let near = near.suggest(name, description.joint_names());
            let help = near.map_or_else(|| other.into(), |name| format!("did you mean `{name}`?"));
            return ["the options give it an actuator, but it does not exist".into(), help];
        }
    };
    [message.into(), other.into()]
}

/// Returns the actuator of a joint of the description, or the message and the help about limits of
/// the description that it needs.
fn of_joint(
    actuator: &JointActuator,
    joint: usize,
    record: &JointRecord,
) -> Result<Actuator, [&'static str; 2]> {
    let limits = record.limits;
    let effort = actuator.effort.or(limits.and_then(|limits| limits.effort));
    if effort == Some(0.0) {
        let help = "write the limit in the file, or `effort = 20` in the option";
        return Err(["its effort limit is 0, so its actuator has no force", help]);
    }
    let line = actuator.saturation.map(|stall_force| {
        let described = limits.and_then(|limits| limits.velocity);
        let speed = actuator.velocity.or(described.filter(|speed| *speed > 0.0));
        let message = "its actuator has a torque-speed line, and the joint no velocity limit";
        let help = "write the no-load speed, `velocity = 25`, beside `saturation`";
        let line = |no_load_speed| TorqueSpeedLine { stall_force, no_load_speed };
        speed.map(line).ok_or([message, help])
    });
    let constant = |constant| AffineLaw { constant, ..AffineLaw::default() };
    let [gain, bias] = match actuator.law {
        ControlLaw::Position { kp, kd } => {
            [constant(kp), AffineLaw { constant: 0.0, length: 0.0 - kp, velocity: 0.0 - kd }]
        }
        ControlLaw::Velocity { kd } => {
            [constant(kd), AffineLaw { constant: 0.0, length: 0.0, velocity: 0.0 - kd }]
        }
        ControlLaw::Motor => [constant(1.0), AffineLaw::default()],
    };
    Ok(Actuator {
        name: record.name.text.clone(),
        transmission: Transmission::Joint(joint),
        gear: 1.0,
        gain,
        bias,
        control_range: None,
        torque_speed_line: line.transpose()?,
        force_range: effort.map(|effort| [-effort, effort]),
        delay: actuator.delay,
        activation: None,
        enabled: true,
    })
}

/// Returns the actuators of the model. `joints` has the joint of the description of each link.
/// Actuators of the options are in the order of the links.
pub fn actuation(
    description: &Description,
    options: &ReadOptions,
    joints: &[Option<usize>],
    links: &[MovingLink],
) -> Actuation {
    let mut actuation = description.actuation.clone();
    let links_of_joints: FxHashMap<usize, usize> =
        joints.iter().enumerate().filter_map(|(link, joint)| Some(((*joint)?, link))).collect();
    // The model refuses a joint that none of its links has.
    let link = |joint: usize| links_of_joints.get(&joint).copied().unwrap_or(links.len());
    for tendon in &mut actuation.tendons {
        tendon.joints.iter_mut().for_each(|joint| joint.link = link(joint.link));
    }
    for actuator in &mut actuation.actuators {
        if let Transmission::Joint(joint) = &mut actuator.transmission {
            *joint = link(*joint);
        }
    }
    if !options.actuators.is_empty() {
        actuation.actuators.sort_by_key(|actuator| match actuator.transmission {
            Transmission::Joint(link) | Transmission::Tendon(link) => link,
        });
    }
    let ranges = joints.iter().zip(0..).filter_map(|(joint, link)| {
        let range = description.joints[(*joint)?].actuator_forces?;
        Some(JointForceRange { link, range })
    });
    actuation.joint_force_ranges = ranges.collect();
    actuation
}
