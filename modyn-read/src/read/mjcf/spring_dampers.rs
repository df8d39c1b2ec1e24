//! Stiffness and damping of joints whose `springdamper` gives a time constant and a damping ratio.

use std::collections::HashMap;

use modyn_runtime::model::{Actuation, Inertial, JointFriction, Model};
use modyn_runtime::{Interpreter, Portable};

use super::bodies::Bodies;
use super::settings::LEAST;
use crate::assemble::assemble;
use crate::description::{KeyframeRecord, Located, Mimic, ReadOptions};
use crate::diagnostics::{Code, Report, Severity};

/// The largest number of joints with `springdamper`: each takes one evaluation of the forward
/// dynamics.
pub const MAX_SPRING_DAMPERS: usize = 1_000;

/// The largest number of accelerations that are computed: all joints have one for each joint with
/// `springdamper`.
pub const MAX_ACCELERATIONS: usize = 10_000_000;

impl Bodies<'_, '_, '_> {
    /// Sets stiffness and damping of the joints with `springdamper`, by the inertia that opposes
    /// each in the pose in which the model is drawn. Constraints of `<equality>` do not count.
    pub fn spring_dampers(&mut self) {
        if self.spring_dampers.is_empty() || self.report.errors() > 0 {
            return;
        }
        let first = self.description.joints[self.spring_dampers[0].0].name.at;
        if self.spring_dampers.len() > MAX_SPRING_DAMPERS {
            return self.refuse_many(first);
        }
        let Some(model) = self.free_model() else { return self.refuse_spring_damper(first) };
        let has_inertia =
            model.moving_links().iter().any(|link| link.inertial != Inertial::default());
        let q = model.keyframes().first().map(|drawn| drawn.q.clone()).unwrap_or_default();
        if self.spring_dampers.len() * model.moving_links().len() > MAX_ACCELERATIONS {
            return self.refuse_many(first);
        }
        let records = model.moving_links().iter().enumerate();
        let places: HashMap<_, _> =
            records.map(|(link, record)| (record.joint.name.as_str(), link)).collect();
        let link_of =
            |joint: usize| places.get(&*self.description.joints[joint].name.text).copied();
        let links: Vec<Option<usize>> =
            self.spring_dampers.iter().map(|(joint, _)| link_of(*joint)).collect();
        let ranges: Vec<_> =
            links.iter().map(|link| link.map(|link| model.v_range(link))).collect();
        let n = model.nv();
        // The numbers become part of generated text, which must be the same on every host.
        let q: Vec<Portable> = q.into_iter().map(Portable).collect();
        let still = vec![Portable(0.0); n];
        let mut tau = still.clone();
        let mut acceleration = still.clone();
        let mut robot = Interpreter::<Portable>::new(model);
        for (i, range) in ranges.into_iter().enumerate() {
            let (joint, [time, ratio]) = self.spring_dampers[i];
            let Some(range) = range else { continue };
            let count = range.len() as f64;
            let mut inverse = 0.0;
            for k in range {
                tau[k] = Portable(1.0);
                if robot.forward_dynamics(&q, &still, &tau, &mut acceleration).is_ok() {
                    inverse += acceleration[k].0;
                }
                tau[k] = Portable(0.0);
            }
            if !inverse.is_finite() {
                // A robot without inertia has no dynamics.
                if has_inertia {
                    self.refuse_spring_damper(first);
                }
                return;
            }
            let inertia = count / inverse.max(LEAST);
            let record = &mut self.description.joints[joint];
            if self.models[0].settings.flags.dampers {
                record.dynamics.damping = 2.0 * inertia / time.max(LEAST);
            }
            if let Some(spring) = &mut record.spring {
                spring.stiffness = inertia / (time * time * ratio * ratio).max(LEAST);
            }
        }
    }

    fn refuse_many(&mut self, at: usize) {
        let message = format!(
            "more than {MAX_SPRING_DAMPERS} joints have a `springdamper`, or fewer in a robot of more than \
             {MAX_ACCELERATIONS} joints for all of them"
        );
        let help = "write `stiffness` and `damping`, as `mj_saveLastXML` does";
        self.report.error(Code::NotRead, at, None, message, help);
    }

    fn refuse_spring_damper(&mut self, at: usize) {
        let message = "the inertia that opposes a joint with `springdamper` is not known";
        let help = "repair the other errors. If there are none, a joint moves no inertia where no \
                    constraint of `<equality>` \
                    holds it: write `stiffness` and `damping` in place of `springdamper`";
        self.report.error(Code::NotRead, at, None, message, help);
    }

    /// Returns the model without gravity, springs and constraints, whose keyframe is the pose in
    /// which it is drawn.
    pub fn free_model(&self) -> Option<Model> {
        let mut description = self.description.clone();
        description.compensated.clear();
        description.actuation = Actuation::default();
        for joint in &mut description.joints {
            joint.spring = None;
        }
        let name = Located { text: String::new(), at: description.at };
        let coordinates = self.drawn_coordinates();
        description.keyframes = vec![KeyframeRecord {
            name,
            coordinates,
            velocities: Vec::new(),
            ctrl: Vec::new(),
            act: Vec::new(),
        }];
        let options = ReadOptions {
            gravity: Some([0.0; 3]),
            mimic: Mimic::Follow,
            unphysical_inertia: Severity::Warning,
            joint_friction: Some(JointFriction::None),
            ..ReadOptions::default()
        };
        assemble(description, &options, &mut Report::without_file())
    }
}
