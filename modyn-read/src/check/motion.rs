//! Checks whether joints can move: armatures, damping, ratios of mimic joints, and the inertia that
//! each joint moves.
//!
//! Damping and friction act only with the option `joint_friction`: in many files they are
//! placeholders, and the dynamics of other libraries leave them out.

use modyn_runtime::model::{Inertial, JointDynamics, JointFriction, Model};

use super::{Body, LinkView, inertia, singular};
use crate::description::MAX_NUMBER;
use crate::diagnostics::{Code, Place, Report, Severity, Subject, listed};

/// Reports armature, damping or friction that is too large to compute with.
pub fn check_dynamics(
    dynamics: &JointDynamics,
    at: Option<usize>,
    joint: &Subject,
    report: &mut Report<'_>,
) {
    if ![dynamics.armature, dynamics.damping, dynamics.friction]
        .iter()
        .all(|x| x.abs() < MAX_NUMBER)
    {
        let message = "its armature, damping or friction is too large to compute with";
        let help = "write kg m^2 (or kg), N m s/rad (or N s/m) and N m (or N)";
        report.error(Code::NotFinite, at, Some(joint), message, help);
    }
}

/// Warns of damping and friction if no option says whether they act. `acts_in_steps` says whether steps with
/// contacts have them in any case.
pub fn inactive_friction(
    bodies: &[Body],
    chosen: Option<JointFriction>,
    acts_in_steps: bool,
    report: &mut Report<'_>,
) {
    if chosen.is_some() {
        return;
    }
    let joints = || bodies.iter().filter_map(|body| body.joint.as_ref());
    let places: Vec<Place> = joints()
        .filter(|joint| joint.dynamics.damping > 0.0 || joint.dynamics.friction > 0.0)
        .map(|joint| (joint.dynamics_at, Some(joint.subject())))
        .collect();
    let damps = joints().any(|joint| joint.dynamics.damping > 0.0);
    let rubs = joints().any(|joint| joint.dynamics.friction > 0.0);
    let what = match (damps, rubs) {
        (true, false) => "its damping does not act",
        (false, _) => "its friction does not act",
        (true, true) => "its damping and friction do not act",
    };
    let message = if acts_in_steps { format!("{what} but in `step`") } else { what.to_owned() };
    let help = "set the option `joint_friction` to `viscous`, `coulomb` or `smooth` if they are to act, else to `none`";
    report.warn_once(Code::InactiveFriction, &places, &message, help);
}

/// Reports joints that move no inertia, and mimic joints whose ratio is too large to compute with;
/// warns of moving links without inertia. Joints that move no inertia only because their links have
/// none are a warning: the robot has kinematic functions. `bodies` has one body for each
/// of the model's links. Joints that depend on an unreadable body are not checked.
pub fn check(bodies: &[Body], model: &Model, report: &mut Report<'_>) {
    for joint in too_large(model).filter_map(|i| bodies[i].joint.as_ref()) {
        let message = "its coordinate is too large a multiple of its leader's to compute with";
        let help = "write `multiplier` as a ratio, and `offset` in rad or m";
        report.error(Code::NotFinite, joint.mimic_at, Some(&joint.subject()), message, help);
    }
    let judged = is_determined(bodies, model);
    let mut singular = singular::singular_joints(model);
    singular.retain(|&i| judged[i]);
    inertia::warn_of_missing(bodies, &singular, report);
    if singular.iter().all(|&i| is_massless(&model.moving_links()[i].inertial)) {
        warn_of_kinematics_only(&singular, bodies, report);
        return;
    }
    let code = Code::SingularJoint;
    for body in singular.into_iter().map(|i| &bodies[i]) {
        let Some(link) = body.links.first() else { continue };
        if let Some(joint) = &body.joint {
            let message = format!(
                "no inertia opposes its motion while the joints after it are free (it carries link `{}`), so its \
                 acceleration is undefined",
                link.name
            );
            let help = "give the link a mass (and, if it rotates, a rotational inertia), give the joint an armature \
                        by the option `armature`, or make the joint `fixed`";
            report.error(code, joint.at, Some(&joint.subject()), message, help);
        } else {
            let message = "the base floats, but no inertia opposes its motion while the joints are free, so its \
                           acceleration is undefined";
            let help = "give the link, or one that is fixed to it, a mass and a rotational inertia, or let the base \
                        be fixed: `base = fixed`";
            report.error(code, link.at, Some(&link.subject()), message, help);
        }
    }
}

/// Returns whether an inertia is zero.
fn is_massless(inertial: &Inertial) -> bool {
    inertial.mass == 0.0 && inertial.inertia == [0.0; 6]
}

/// Warns, once, of joints that move no inertia because their links have none.
fn warn_of_kinematics_only(singular: &[usize], bodies: &[Body], report: &mut Report<'_>) {
    let singular = || singular.iter().map(|&i| &bodies[i]);
    let Some(first) = singular().next() else { return };
    let links = singular().filter_map(|body| Some(body.links.first()?.name));
    let (have, these) = if links.clone().count() == 1 {
        ("has", "this link")
    } else {
        ("have", "each of these links")
    };
    let message = format!(
        "it moves no inertia, since {} {have} none: the robot has kinematic functions, and no dynamics",
        listed("link", links),
    );
    let joint = singular().find_map(|body| body.joint.as_ref());
    let armature = joint.map_or(String::new(), |joint| {
        format!(
            ", or give each joint an armature by the option `armature`: `[\"{}\": 1, ...]`",
            joint.name
        )
    });
    let help = format!("for dynamics write the `<inertial>` of {these}{armature}");
    let (at, subject) = match &first.joint {
        Some(joint) => (joint.at, Some(joint.subject())),
        None => (
            first.links.first().and_then(|link| link.at),
            first.links.first().map(LinkView::subject),
        ),
    };
    report.add(Severity::Warning, Code::KinematicsOnly, at, subject.as_ref(), message, help);
}

/// Returns, for each joint, whether its motion depends on readable numbers only: on the numbers of
/// the bodies that it carries, and of all joints that follow it.
fn is_determined(bodies: &[Body], model: &Model) -> Vec<bool> {
    let mut judged: Vec<bool> = bodies.iter().map(|body| body.known).collect();
    if judged.iter().all(|&known| known) {
        return judged;
    }
    for leader in (0..bodies.len()).filter_map(|i| Some(model.mimic(i)?.leader)) {
        judged[leader] = false;
    }
    // Children come after their parents.
    for (i, link) in model.moving_links().iter().enumerate().rev() {
        if let (false, Some(parent)) = (judged[i], link.parent) {
            judged[parent] = false;
        }
    }
    judged
}

/// Returns the links, as indices, whose mimic joints have a ratio that is too large to compute
/// with. The ratios of a chain of mimic joints are multiplied.
fn too_large(model: &Model) -> impl Iterator<Item = usize> {
    let large = |i: &usize| {
        let mimic = model.mimic(*i);
        mimic.is_some_and(|m| !(m.multiplier.abs() < MAX_NUMBER && m.offset.abs() < MAX_NUMBER))
    };
    (0..model.moving_links().len()).filter(large)
}
