//! Actuators: how controls become joint forces.

use alloc::{format, string::String, vec::Vec};

use super::Model;

/// The actuators of a robot, the tendons that they pull, and the ranges of joint forces.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Actuation {
    /// The actuators, in the order of the controls.
    pub actuators: Vec<Actuator>,
    /// The fixed tendons.
    pub tendons: Vec<FixedTendon>,
    /// The ranges of the sums of actuator forces on joints.
    pub joint_force_ranges: Vec<JointForceRange>,
}

/// An actuator: its force is `gain` times its input plus `bias`, within `force_range`.
///
/// The input is the control, within `control_range`, or the activation. Gain and bias are affine
/// functions of the length of the transmission and its rate. The law is `MuJoCo`'s, apart from the
/// torque-speed line and the delay.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Actuator {
    /// The name.
    pub name: String,
    /// The joint or the tendon that the actuator moves.
    pub transmission: Transmission,
    /// The gear ratio: the actuator's length is `gear` times the joint's coordinate or the tendon's
    /// length, and its force acts `gear` times.
    pub gear: f64,
    /// The force per unit of input.
    pub gain: AffineLaw,
    /// The force without input.
    pub bias: AffineLaw,
    /// The range to which the control is clamped.
    pub control_range: Option<[f64; 2]>,
    /// The torque-speed line, to which the force is clamped before its range.
    #[cfg_attr(feature = "serde", serde(default))]
    pub torque_speed_line: Option<TorqueSpeedLine>,
    /// The range to which the force is clamped.
    pub force_range: Option<[f64; 2]>,
    /// The number of steps before a control acts; of all actuators together at most
    /// [`Actuation::MAX_DELAYS`]. The controls that do not act yet are states of the actuator, before
    /// its activation.
    #[cfg_attr(feature = "serde", serde(default))]
    pub delay: usize,
    /// The activation, which is then the input; `None`: the control is the input.
    pub activation: Option<Activation>,
    /// Whether the actuator acts. The activation of an actuator that does not act stays.
    pub enabled: bool,
}

/// The forces that a motor can have at a speed: a line from the stall force at rest to zero at the
/// no-load speed, and beyond.
///
/// At the rate v of its length, the force is at most `stall_force * (1 - v / no_load_speed)`, and at
/// least `stall_force * (-1 - v / no_load_speed)`. So beyond the no-load speed, the motor brakes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TorqueSpeedLine {
    /// The largest force at rest, N m or N: above zero.
    pub stall_force: f64,
    /// The speed at which the largest force is zero, rad/s or m/s: above zero.
    pub no_load_speed: f64,
}

/// A number that is an affine function of an actuator's length and its rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AffineLaw {
    /// The number at length zero and at rest.
    pub constant: f64,
    /// The factor of the length.
    pub length: f64,
    /// The factor of the length's rate.
    pub velocity: f64,
}

/// The part of the robot that an actuator moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Transmission {
    /// The joint of a moving link, which has one degree of freedom: an index into
    /// [`Model::moving_links`].
    Joint(usize),
    /// A tendon: an index into [`Actuation::tendons`].
    Tendon(usize),
}

/// A state of an actuator, which follows its control.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Activation {
    /// How the activation follows the control.
    pub dynamics: ActivationDynamics,
    /// The range to which the activation is clamped after a step.
    pub range: Option<[f64; 2]>,
    /// Whether the force follows from the activation after the step: `MuJoCo`'s `actearly`.
    pub early: bool,
}

/// How an activation follows its control.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ActivationDynamics {
    /// The rate of the activation is the control.
    Integrator,
    /// The activation approaches the control with this time constant (s), in Euler steps.
    Filter(f64),
    /// The activation approaches the control with this time constant (s), exactly.
    ExactFilter(f64),
}

/// A tendon whose length is a sum of multiples of joint coordinates.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FixedTendon {
    /// The name.
    pub name: String,
    /// The joints, each with its coefficient.
    pub joints: Vec<TendonJoint>,
    /// The length at coordinates zero.
    pub offset: f64,
    /// The range of the sum of actuator forces on the tendon, which contains zero. A sum outside
    /// scales the forces.
    pub force_range: Option<[f64; 2]>,
}

/// A joint of a fixed tendon.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TendonJoint {
    /// The moving link of the joint, which has one degree of freedom: an index into
    /// [`Model::moving_links`].
    pub link: usize,
    /// The tendon's length per unit of the joint's coordinate.
    pub coefficient: f64,
}

/// The range of the sum of actuator forces on a joint: `MuJoCo`'s `actuatorfrcrange`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointForceRange {
    /// The moving link of the joint, which has one degree of freedom: an index into
    /// [`Model::moving_links`].
    pub link: usize,
    /// The lowest and the highest force, N m or N.
    pub range: [f64; 2],
}

impl Actuator {
    /// Returns the number of the actuator's states: the controls that do not act yet, and the
    /// activation.
    #[must_use]
    pub fn states(&self) -> usize {
        self.delay + usize::from(self.activation.is_some())
    }
}

impl Actuation {
    /// The largest sum of the delays of all actuators, in steps. Generated code moves each control
    /// that waits by an operation of its own.
    pub const MAX_DELAYS: usize = 2000;

    /// Returns the number of the states of all actuators: of the entries of `act`.
    #[must_use]
    pub fn states(&self) -> usize {
        self.actuators.iter().map(Actuator::states).sum()
    }
}

impl Model {
    /// Returns the actuators, their tendons, and the ranges of joint forces.
    #[must_use]
    pub fn actuation(&self) -> &Actuation {
        &self.actuation
    }

    /// Returns the names of the controls: of the actuators.
    #[must_use]
    pub fn control_names(&self) -> Vec<&str> {
        self.actuation.actuators.iter().map(|actuator| actuator.name.as_str()).collect()
    }

    /// Returns the names of the entries of `act`: for each actuator, of the controls that do not act
    /// yet (`hip_before_2`, `hip_before_1` of the actuator `hip` with a delay of two steps), then of
    /// its activation (`hip`).
    #[must_use]
    pub fn activation_names(&self) -> Vec<String> {
        let names = self.actuation.actuators.iter().flat_map(|actuator| {
            let before = |steps| format!("{}_before_{steps}", actuator.name);
            let activation = actuator.activation.map(|_| actuator.name.clone());
            (1..=actuator.delay).rev().map(before).chain(activation)
        });
        names.collect()
    }
}
