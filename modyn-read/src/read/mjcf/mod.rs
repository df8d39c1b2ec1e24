//! Reads the XML of a `MuJoCo` model (MJCF) to a [`Description`].
//!
//! ```text
//! files ─ models, element ─▶ elements ─ check by table ─▶ bodies, joints, geoms, meshes ─▶ links and joints
//! ```
//!
//! `table` has all elements and attributes: which are read, which have no effect on the equations
//! of motion, and which are refused.

mod actuator_law;
mod actuators;
mod bodies;
mod check;
mod classes;
mod contact_law;
mod element;
mod equality;
mod forces;
mod geoms;
mod ignored;
mod inert_actuators;
mod inertia;
mod item;
mod joints;
mod keyframes;
mod mesh;
mod models;
mod pose;
mod settings;
mod spring_dampers;
pub(crate) mod table;
mod tendons;
mod touching;

use crate::check::gravity_error;
use crate::description::{Base, Description, ReadOptions};
use crate::diagnostics::{Code, Report};

/// Returns the description; `None` with errors in the report.
pub fn describe(text: &str, options: &ReadOptions, report: &mut Report<'_>) -> Option<Description> {
    let shown = report.file_name(0).unwrap_or_default().to_owned();
    let sources = models::read(text, options, &shown, report)?;
    let root = &sources[0].root;
    if root.name != "mujoco" {
        let message = format!("the root element is `<{}>`", root.name);
        let help = "an MJCF is one element `<mujoco model=\"...\">`";
        report.error(Code::NotMjcf, root.at, None, message, help);
        return None;
    }
    if options.base == Base::Floating {
        let message = "`base = floating` is for URDF, which cannot say so";
        let help = "write `<freejoint/>` in the body that floats";
        report.error(Code::Option, root.at, None, message, help);
    }
    let mut bodies = bodies::Bodies::read(&sources, options, report);
    bodies.keyframes();
    bodies.spring_dampers();
    bodies.actuators();
    if options.base == Base::Fixed {
        bodies.fix_base();
    }
    bodies.equality(options.mimic);
    bodies.hold_transmissions();
    bodies.fluids(options.unsupported_forces);
    bodies.tendons(options);
    bodies.hold_tendons();
    bodies.soft_constraints(options);
    let mut description = bodies.description;
    let error = description.gravity.and_then(gravity_error).filter(|_| options.gravity.is_none());
    if let Some(error) = error {
        report.error(error.code, root.at, None, error.message, error.help.unwrap_or_default());
        description.gravity = None;
    }
    Some(description)
}
