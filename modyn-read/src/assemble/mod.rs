//! From a description to a model: the tree, merging of fixed joints, mimic joints, loops, contacts,
//! armatures.
//!
//! ```text
//! Description ─ armatures, actuators, loops and contacts of the options ─ mimics ─▶ leaders ─┐
//!              └ tree ─▶ order ─ bodies ─▶ moving links ─ check ──────────────────────────┴▶ Model
//! ```
//!
//! Each step reports all its errors and continues as far as possible.

mod actuators;
mod armatures;
mod base;
mod bodies;
mod contacts;
pub(crate) mod cycles;
mod keyframes;
mod loops;
mod mimics;
mod soft;
mod tree;

use modyn_runtime::model::{DEFAULT_GRAVITY, Inertial, Link, Model, Spring};

use crate::check::{self, Body};
use crate::description::{Description, Kind, Mimic, ReadOptions, SpringRecord};
use crate::diagnostics::{Code, Report, Subject};
use bodies::Assembly;

/// Returns the model; `None` with errors in the report.
pub fn assemble(
    mut description: Description,
    options: &ReadOptions,
    report: &mut Report<'_>,
) -> Option<Model> {
    armatures::apply(&mut description, options, report);
    actuators::apply(&mut description, options, report);
    let loops: Vec<_> =
        options.loops.iter().map(|option| loops::from_option(option, report)).collect();
    description.loops.extend(loops);
    description.contacts.extend(options.contacts.iter().map(contacts::from_option));
    for joint in description.joints.iter().filter(|joint| joint.kind != Kind::Fixed) {
        check::motion::check_dynamics(
            &joint.dynamics,
            Some(joint.dynamics_at),
            &joint.subject(),
            report,
        );
    }
    check::limits::check(&description, report);
    let leaders = mimics::leaders(&description, options.mimic, report);
    let tree = tree::build_tree(&description, report)?;
    let base = base::apply(&mut description, &tree, options.base, report);
    let description = &description;
    let mut assembly = bodies::merge(description, &tree, base, report);
    assembly.resolve_mimics(description, &leaders, options.mimic != Mimic::Independent);
    model(description, assembly, options, report)
}

/// Checks the bodies, and returns the model.
fn model(
    description: &Description,
    assembly: Assembly,
    options: &ReadOptions,
    report: &mut Report<'_>,
) -> Option<Model> {
    let Assembly { mut links, bodies, place } = assembly;
    if links.is_empty() {
        let help = "make a joint `revolute`, `continuous` or `prismatic`, or let the base float: `base = floating`";
        let message = "the robot has no moving joint";
        report.error(Code::NoMovingJoint, description.at, None, message, help);
    }
    let joints: Vec<Option<usize>> = bodies.iter().map(|body| body.joint).collect();
    let mut bodies: Vec<Body> = bodies.iter().map(|body| body.view(description)).collect();
    for (link, body) in links.iter_mut().zip(&mut bodies) {
        if !check::inertia::check(body, &link.inertial, options.unphysical_inertia, report) {
            // The error is reported. With a stand-in, the motions of the other bodies can be
            // checked.
            body.known = false;
            link.inertial = PLACEHOLDER_INERTIA;
        }
    }
    check::inertia::densities(&bodies, &links, report);
    let acts_in_steps = description.soft.as_ref().is_some_and(|soft| soft.joint_friction);
    check::motion::inactive_friction(&bodies, options.joint_friction, acts_in_steps, report);
    let carriers: Vec<_> = place.iter().map(|(carrier, _)| *carrier).collect();
    let loop_constraints = loops::loop_constraints(description, &carriers, report);
    let contacts = contacts::contacts(description, &carriers, report);
    let errors = report.errors();
    let frames = description.links.iter().zip(place).map(|(record, (link, pose))| Link {
        name: record.name.text.clone(),
        moving_link: link,
        pose,
        inertial: record.inertial.as_ref().map_or_else(Inertial::default, |record| record.inertial),
    });
    let springs = joints.iter().zip(0..).filter_map(|(joint, link)| {
        let SpringRecord { stiffness, reference } = description.joints[(*joint)?].spring.clone()?;
        Some(Spring { link, stiffness, reference })
    });
    let actuation = actuators::actuation(description, options, &joints, &links);
    let mut compensation = Vec::new();
    // The weight of a link that is fixed to the world has no effect.
    for &(link, factor) in
        description.compensated.iter().filter(|(link, _)| carriers[*link].is_some())
    {
        compensation.resize(description.links.len(), 0.0);
        compensation[link] = factor;
    }
    let gravity = options.gravity.or(description.gravity).unwrap_or(DEFAULT_GRAVITY);
    let assembled = Model::new(description.name.as_str(), gravity, links, frames.collect())
        .and_then(|model| model.with_joint_friction(options.joint_friction.unwrap_or_default()))
        .and_then(|model| model.with_springs(springs.collect()))
        .and_then(|model| model.with_gravity_compensation(compensation))
        .and_then(|model| {
            if errors > 0 { Ok(model) } else { model.with_loop_constraints(loop_constraints) }
        })
        .and_then(|model| if errors > 0 { Ok(model) } else { model.with_contacts(contacts) })
        .and_then(|model| if errors > 0 { Ok(model) } else { model.with_actuation(actuation) })
        .and_then(|model| {
            let soft = soft::constraints(description, options, &carriers, &model, report);
            if errors > 0 { Ok(model) } else { model.with_soft_constraints(soft) }
        })
        .and_then(|model| {
            let keyframes = keyframes::keyframes(description, &model);
            model.with_keyframes(keyframes)
        });
    let model = match assembled {
        Ok(model) => model,
        // Caused by an error that is already reported.
        Err(_) if errors > 0 => return None,
        Err(errors) => {
            // All of this was checked before. If a check is missing, the user is told here.
            for error in errors {
                let subject = Subject::Robot(description.name.clone());
                let at = description.at;
                let message = error.to_string();
                let help = "this is a fault of modyn: please report it with the file";
                report.error(Code::InvalidModel, at, Some(&subject), message, help);
            }
            return None;
        }
    };
    check::motion::check(&bodies, &model, report);
    (report.errors() == 0).then_some(model)
}

/// The inertia that replaces an unreadable one, so that the other bodies can be checked.
const PLACEHOLDER_INERTIA: Inertial =
    Inertial { mass: 1.0, center_of_mass: [0.0; 3], inertia: [1.0, 0.0, 0.0, 1.0, 0.0, 1.0] };
