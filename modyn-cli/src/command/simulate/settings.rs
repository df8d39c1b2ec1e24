//! The settings of a simulation.

use modyn_runtime::model::Keyframe;

use crate::contact_steps::Options;

/// The settings of the integration.
pub struct Settings<'a> {
    /// The time step, s.
    pub step: f64,
    /// The number of steps.
    pub steps: usize,
    /// The number of steps from one sample to the next.
    pub every: usize,
    /// The largest error of a step, relative to 1 + |x|; steps are then divided until they keep it.
    pub tolerance: Option<f64>,
    /// The ground, the joint limits and the actuators; with them steps are of first order.
    pub contacts: Options,
    /// The keyframe whose controls are held; `None` for controls that are zero.
    pub keyframe: Option<&'a Keyframe>,
}
