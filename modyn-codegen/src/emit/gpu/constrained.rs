//! A time step with closed loops and contacts: constrained accelerations, then a semi-implicit
//! Euler step.
//!
//! The user's function `active_contacts` proposes the active contacts. A contact that would pull is
//! released, and the accelerations are computed again.

use modyn_runtime::{ConstraintSettings, ContactTarget};

use super::{Dialect, GpuKernel};

/// What the lines of a step read.
pub(super) struct StepArguments<'a> {
    /// The name of the joint forces.
    pub forces: &'a str,
    /// The arguments of the user's function `active_contacts`.
    pub user: &'a [String],
    /// The further arguments of constrained forward dynamics.
    pub parameters: &'a [String],
}

/// The functions of the step, and the sizes of the robot.
pub(super) struct ConstrainedStep<'a> {
    /// The number of coordinates.
    pub nq: usize,
    /// The number of velocities.
    pub nv: usize,
    /// Constrained forward dynamics.
    pub dynamics: &'a GpuKernel,
    /// The coordinates after a displacement.
    pub integrate: &'a GpuKernel,
    /// The number of closed loops, whose wrenches come before the wrenches of contacts.
    pub loops: usize,
    /// The number of contacts.
    pub contacts: usize,
}

/// The number of settings before the settings of contacts, and the number of settings of a contact.
const SETTINGS: [usize; 2] = [ConstraintSettings::<f64>::COUNT, ContactTarget::<f64>::COUNT];

/// The places of the ground's normal in the settings of a contact: the third column of a rotation
/// by rows.
const NORMAL: [usize; 3] = [2, 5, 8];

/// The numbers of a wrench. The force comes first.
const WRENCH: usize = 6;

impl ConstrainedStep<'_> {
    /// Returns the lines that change `q` and `qd` by a step.
    pub fn lines(&self, dialect: &dyn Dialect, arguments: &StepArguments<'_>) -> Vec<String> {
        let Self { nq, nv, .. } = *self;
        let StepArguments { forces, user, parameters } = *arguments;
        let zeros = |n: usize| vec![dialect.literal(0.0); n];
        let mut lines = vec![dialect.array("qdd", &zeros(nv))];
        let mut arguments: Vec<String> = ["q", "qd", forces].map(String::from).into();
        let has_contacts = self.contacts > 0;
        if has_contacts {
            lines.push(dialect.call_into("proposed", self.contacts, "active_contacts", user));
            let proposed = (0..self.contacts).map(|c| format!("proposed[{c}]"));
            lines.push(dialect.array("held", &proposed.collect::<Vec<_>>()));
            lines.push(dialect.counting("sweep", "2u"));
            arguments.push("held".into());
        }
        arguments.push("settings".into());
        arguments.extend(parameters.iter().cloned());
        let name = &self.dynamics.name;
        let len = self.dynamics.result;
        let mut inner = vec![dialect.call_into("dynamics", len, name, &arguments)];
        inner.extend((0..nv).map(|j| format!("qdd[{j}] = dynamics[{j}];")));
        inner.extend((0..self.contacts).map(|c| {
            let product = |k: usize| {
                let force = nv + WRENCH * (self.loops + c) + k;
                let normal = SETTINGS[0] + SETTINGS[1] * c + NORMAL[k];
                format!("dynamics[{force}] * settings[{normal}]")
            };
            let push = [0, 1, 2].map(product).join(" + ");
            let kept =
                dialect.select(&format!("({push})"), &format!("held[{c}]"), &dialect.literal(0.0));
            format!("held[{c}] = {kept};")
        }));
        if has_contacts {
            lines.extend(inner.into_iter().map(|line| format!("    {line}")));
            lines.push("}".into());
        } else {
            lines.extend(inner);
        }
        lines.extend((0..nv).map(|j| format!("qd[{j}] = qd[{j}] + dt[0] * qdd[{j}];")));
        let moved: Vec<String> = (0..nv).map(|j| format!("dt[0] * qd[{j}]")).collect();
        lines.push(dialect.array("moved", &moved));
        let arguments = ["q", "moved"].map(String::from);
        lines.push(dialect.call_into("next", nq, &self.integrate.name, &arguments));
        lines.extend((0..nq).map(|j| format!("q[{j}] = next[{j}];")));
        lines
    }
}
