//! From a tree of links and joints to the links that move: what is fixed together becomes one.

use modyn_runtime::{
    joint::JointType,
    model::{Frame, Inertial, InertialDefect, Joint, Link, Model},
    spatial::Pose,
};

use super::{
    Mimic, ReadOptions, felt,
    parts::{JointPart, Kind, LinkPart, Parts},
    report::Report,
    tree::Tree,
};
use crate::error::{Code, Severity, Subject};

/// A moving body: a link that a joint moves, and all that is fixed to it.
struct Body {
    /// The moving link, then those fixed to it, as indices into the parts.
    links: Vec<usize>,
    /// The joint.
    joint: usize,
    /// Whether all figures of its inertia could be read.
    sound: bool,
}

/// The model; `None` with errors in the report.
pub fn build(
    parts: &Parts,
    tree: &Tree,
    options: &ReadOptions,
    report: &mut Report<'_>,
) -> Option<Model> {
    let mut links: Vec<Link> = Vec::new();
    let mut bodies: Vec<Body> = Vec::new();
    // By link of the description: the moving link that carries it, and its pose there.
    let mut place: Vec<(Option<usize>, Pose<f64>)> =
        vec![(None, Pose::identity()); parts.links.len()];
    for &link in &tree.order {
        let part = &parts.links[link];
        if let Some(joint) = tree.joint[link] {
            let JointPart { name, kind, origin, axis, limits, .. } = &parts.joints[joint];
            let (carrier, pose) = tree.parent[joint].map_or((None, Pose::identity()), |p| place[p]);
            let mut origin = pose.compose(origin);
            if !origin.translation.iter().all(|x| x.abs() < LARGEST) {
                let message = "its place is too far away to compute with";
                let help = "write `xyz` in m";
                report.error(
                    Code::NotFinite,
                    name.at,
                    Some(&parts.joints[joint].subject()),
                    message,
                    help,
                );
                origin = Pose::identity();
            }
            place[link] = match kind {
                Kind::Fixed => (carrier, origin),
                Kind::Moving(_) | Kind::Unknown => {
                    // An unknown type is an error already; the rest can be checked all the same.
                    let joint_type = match kind {
                        Kind::Moving(joint_type) => *joint_type,
                        _ => JointType::Revolute,
                    };
                    let name = name.text.into();
                    links.push(Link {
                        name: part.name.text.into(),
                        parent: carrier,
                        joint: Joint { name, joint_type, axis: *axis, origin, limits: *limits },
                        inertial: Inertial::default(),
                    });
                    bodies.push(Body { links: Vec::new(), joint, sound: true });
                    (Some(links.len() - 1), Pose::identity())
                }
            };
        }
        // What is fixed to the world moves nothing.
        let (Some(carrier), pose) = &place[link] else {
            continue;
        };
        let body = &mut bodies[*carrier];
        body.links.push(link);
        if let Some(own) = &part.inertial {
            let sum = &mut links[*carrier].inertial;
            *sum = sum.merged(&own.inertial.transformed(pose));
            body.sound &= own.sound;
        }
    }
    if parts.joints.iter().all(|joint| joint.kind == Kind::Fixed) {
        let help = "make a joint `revolute`, `continuous` or `prismatic`";
        report.error(Code::NoMovingJoint, parts.at, None, "no joint of the robot moves", help);
    }
    for (link, body) in links.iter().zip(&bodies).filter(|(_, body)| body.sound) {
        check_inertia(parts, &body.links, &link.inertial, options, report);
    }
    if options.mimic == Mimic::Independent {
        check_mimics(parts, report);
    }
    if report.errors() > 0 {
        return None;
    }
    for i in felt::unfelt(&links) {
        let joint = &parts.joints[bodies[i].joint];
        let (message, help) = (felt::message(&links[i].name), felt::HELP);
        report.error(Code::NoInertiaFelt, joint.name.at, Some(&joint.subject()), message, help);
    }
    if report.errors() > 0 {
        return None;
    }
    let frames = parts.links.iter().zip(place).map(|(part, (link, pose))| Frame {
        name: part.name.text.into(),
        link,
        pose,
    });
    match Model::new(parts.name, options.gravity, links, frames.collect()) {
        Ok(model) => Some(model),
        Err(errors) => {
            // All of this has been checked. Should a check be missing, the user hears of it here.
            for error in errors {
                let subject = Subject::Robot(parts.name.into());
                let help = "this is a fault of modyn: please report it with the file";
                report.error(Code::InvalidModel, parts.at, Some(&subject), error.to_string(), help);
            }
            None
        }
    }
}

/// Whether a body made of these links can exist.
fn check_inertia(
    parts: &Parts,
    links: &[usize],
    whole: &Inertial,
    options: &ReadOptions,
    report: &mut Report<'_>,
) {
    // A mass below 0 is wrong wherever it hangs: in a sum it would go unseen. No option lets it
    // through, since the equations have no meaning with it.
    let mut negative = false;
    let with_inertial =
        |link: &usize| Some((&parts.links[*link], parts.links[*link].inertial.as_ref()?));
    for (link, own) in links.iter().filter_map(with_inertial) {
        if own.inertial.mass < 0.0 {
            negative = true;
            let message = format!("the mass is {} kg", own.inertial.mass);
            let help = "write a mass of at least 0";
            report.error(Code::NegativeMass, own.mass_at, Some(&link.subject()), message, help);
        }
    }
    let Some((&moving, fixed)) = links.split_first() else {
        return;
    };
    let moving = &parts.links[moving];
    let at =
        links.iter().find_map(with_inertial).map_or(moving.name.at, |(_, inertial)| inertial.at);
    let figures = [whole.mass].into_iter().chain(whole.center_of_mass).chain(whole.inertia);
    if !figures.clone().all(|x| x.abs() < LARGEST) {
        report.error(Code::NotFinite, at, Some(&moving.subject()), TOO_LARGE, TOO_LARGE_HELP);
        return;
    }
    let severity = options.unphysical_inertia;
    if negative {
        // The sum says nothing then; the parts that are to be repaired say for themselves.
        for (link, own) in links.iter().filter_map(with_inertial) {
            let Inertial { mass, .. } = own.inertial;
            let repaired = Inertial { mass: mass.abs(), ..own.inertial };
            if let Some(defect) = repaired.defect().filter(|_| mass < 0.0) {
                let (code, help) = advice(&defect);
                report.add(severity, code, own.at, Some(&link.subject()), defect.to_string(), help);
            }
        }
    } else if let Some(defect) = whole.defect() {
        let (code, help) = advice(&defect);
        let message = format!("{defect}{}", fixed_names(parts, fixed));
        report.add(severity, code, at, Some(&moving.subject()), message, help);
    }
}

/// Beyond this, products of figures could overflow.
pub const LARGEST: f64 = 1e60;
pub const TOO_LARGE: &str = "the figures of the inertia are too large to compute with";
pub const TOO_LARGE_HELP: &str = "write kg, m and kg m^2";

/// The kind of a defect, and what to do about it.
pub fn advice(defect: &InertialDefect) -> (Code, String) {
    let (code, help) = match defect {
        InertialDefect::NegativeMass(_) => {
            return (Code::NegativeMass, "write a mass of at least 0".into());
        }
        InertialDefect::InertiaWithoutMass => {
            (Code::InertiaWithoutMass, "write the mass, or zeros for the rotational inertia")
        }
        InertialDefect::NotPositiveSemidefinite(_) => (
            Code::IndefiniteInertia,
            "check the signs of ixy, ixz, iyz and whether the inertia is about the centre of mass",
        ),
        _ => (
            Code::TriangleInequality,
            "check ixx, iyy, izz and whether the inertia is about the centre of mass",
        ),
    };
    (code, format!("{help}; or take it as it is with the option `unphysical_inertia = warn`"))
}

fn fixed_names(parts: &Parts, fixed: &[usize]) -> String {
    let mut heavy = fixed
        .iter()
        .map(|&link| &parts.links[link])
        .filter(|link| link.inertial.is_some())
        .map(|link: &LinkPart| format!("`{}`", link.name.text));
    let names: Vec<String> = heavy.by_ref().take(10).collect();
    let more = if heavy.next().is_some() { ", ..." } else { "" };
    if names.is_empty() {
        String::new()
    } else {
        format!(" (together with what is fixed to it: {}{more})", names.join(", "))
    }
}

/// A mimic joint that is independent anyway may name whatever it likes, but it is worth a word.
fn check_mimics(parts: &Parts, report: &mut Report<'_>) {
    let names: rustc_hash::FxHashSet<&str> = parts.joints.iter().map(|j| j.name.text).collect();
    for joint in &parts.joints {
        if let Some(target) = joint.mimic.filter(|target| !names.contains(target.text)) {
            let message = format!("it mimics joint `{}`, which does not exist", target.text);
            let help = "name a joint, or remove `<mimic>`: the joint is independent here";
            report.add(
                Severity::Warning,
                Code::MimicTarget,
                target.at,
                Some(&joint.subject()),
                message,
                help,
            );
        }
    }
}
