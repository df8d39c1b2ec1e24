//! The checks of a model: physical inertias, joints that move inertia, numbers in a range that can
//! be computed with. The checks are the same for a description and for a model that was built in
//! code, which has no places.

mod conditioning;
pub mod inertia;
pub mod limits;
pub mod motion;
mod options;
pub(crate) mod singular;

pub use conditioning::warning as conditioning_warning;
pub use conditioning::{MAX_CONDITION_F32, condition_number};
use modyn_runtime::model::{Inertial, JointDynamics, Model};
use modyn_runtime::spatial::Pose;
pub use options::gravity_error;
pub(crate) use options::{friction_error, ground_error};
pub use singular::singular_joints as joints_without_inertia;

use crate::description::MAX_NUMBER;
use crate::diagnostics::{Code, Diagnostic, Diagnostics, Report, Severity, Subject};

/// A moving body, with its places in a description.
pub struct Body<'d> {
    /// The joint that moves it; `None` for a base that floats.
    pub joint: Option<JointView<'d>>,
    /// The moving link, then the links that are fixed to it.
    pub links: Vec<LinkView<'d>>,
    /// Whether its inertia and its joint could be read, so that its motion can be checked.
    pub known: bool,
}

impl<'d> Body<'d> {
    /// Returns the links that have an inertia, with their inertias.
    fn inertials(&self) -> impl Iterator<Item = (&LinkView<'d>, &InertialView)> {
        self.links.iter().filter_map(|link| Some((link, link.inertial.as_ref()?)))
    }
}

/// The joint of a body.
pub struct JointView<'d> {
    pub name: &'d str,
    pub at: Option<usize>,
    pub mimic_at: Option<usize>,
    pub dynamics: JointDynamics,
    pub dynamics_at: Option<usize>,
}

impl JointView<'_> {
    fn subject(&self) -> Subject {
        Subject::Joint(self.name.into())
    }
}

/// A link of a body.
pub struct LinkView<'d> {
    pub name: &'d str,
    pub at: Option<usize>,
    /// The inertia; `None` if the description has none.
    pub inertial: Option<InertialView>,
    /// Whether the link was added by the reader, and is massless on purpose.
    pub auxiliary: bool,
}

impl LinkView<'_> {
    fn subject(&self) -> Subject {
        Subject::Link(self.name.into())
    }
}

/// The inertia of a link, in the link's frame.
pub struct InertialView {
    pub inertial: Inertial,
    pub at: Option<usize>,
    pub mass_at: Option<usize>,
    /// Whether all its numbers could be read.
    pub sound: bool,
}

/// Checks that a joint's frame is not too far away; `false` with an error in the report.
pub fn is_near(
    origin: &Pose<f64>,
    at: Option<usize>,
    joint: &Subject,
    report: &mut Report<'_>,
) -> bool {
    let near = origin.translation.iter().all(|x| x.abs() < MAX_NUMBER);
    if !near {
        let message = "its origin is too far away to compute with";
        report.error(Code::NotFinite, at, Some(joint), message, "write `xyz` in m");
    }
    near
}

/// Checks a model that was built in code as a description is checked, and returns the warnings.
pub fn check_model(model: &Model, unphysical: Severity) -> Result<Vec<Diagnostic>, Diagnostics> {
    let mut report = Report::without_file();
    let bodies: Vec<Body> = model
        .moving_links()
        .iter()
        .map(|link| {
            let dynamics = link.joint.dynamics;
            let inertial = link.inertial;
            let joint = JointView {
                name: &link.joint.name,
                at: None,
                mimic_at: None,
                dynamics,
                dynamics_at: None,
            };
            let inertial = InertialView { inertial, at: None, mass_at: None, sound: true };
            let links = vec![LinkView {
                name: &link.name,
                at: None,
                inertial: Some(inertial),
                auxiliary: false,
            }];
            Body { joint: Some(joint), links, known: true }
        })
        .collect();
    for (link, body) in model.moving_links().iter().zip(&bodies) {
        let joint = Subject::Joint(link.joint.name.clone());
        is_near(&link.joint.origin, None, &joint, &mut report);
        motion::check_dynamics(&link.joint.dynamics, None, &joint, &mut report);
        inertia::check(body, &link.inertial, unphysical, &mut report);
    }
    inertia::densities(&bodies, model.moving_links(), &mut report);
    // With other errors the pivots have no meaning.
    if report.errors() == 0 {
        motion::check(&bodies, model, &mut report);
    }
    let reported = report.finish().into_iter().chain(gravity_error(model.gravity()));
    let diagnostics =
        Diagnostics::new(reported.chain(friction_error(model.joint_friction())).collect());
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok(diagnostics.into_vec()) }
}
