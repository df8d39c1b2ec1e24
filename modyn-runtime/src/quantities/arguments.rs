//! The arguments of functions: their names, kinds and order.

use super::shape::{Shape, Sizes};
use super::shapes;

/// An argument of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Argument {
    /// The name.
    pub name: &'static str,
    /// The meaning of its numbers.
    pub kind: ArgumentKind,
}

/// The meaning of an argument's numbers, which their layout follows from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArgumentKind {
    /// Coordinates, in which the quaternions have length 1.
    Coordinates,
    /// A number for each degree of freedom: velocities, accelerations, joint forces, and changes of
    /// these or of coordinates.
    Velocities,
    /// A number for each degree of freedom of the coordinates, then one for each velocity.
    State,
    /// A control for each actuator.
    Controls,
    /// A state for each actuator that has one.
    Activations,
    /// A time, s.
    Time,
    /// A number.
    Number,
    /// This many numbers.
    Numbers(usize),
    /// A wrench on each link.
    Wrenches,
    /// A wrench for each constraint.
    ConstraintWrenches,
    /// A vector for each contact.
    ContactVectors,
    /// The set of active contacts.
    ActiveContacts,
    /// The settings of constraints.
    Settings,
    /// The settings of steps.
    StepSettings,
    /// Random numbers, one for each degree of freedom.
    RandomNumbers,
    /// The factors of the mass matrix.
    Factors,
}

/// The form of an argument in functions of many states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BatchForm {
    /// Numbers for each state.
    Numbers,
    /// A set for each state, whose members are in it or not.
    Sets,
    /// Numbers that all states share.
    Shared,
    /// None: functions with such an argument have no form for many states.
    None,
}

impl ArgumentKind {
    /// Returns the form in functions of many states.
    #[must_use]
    pub const fn batch_form(self) -> BatchForm {
        match self {
            Self::Coordinates
            | Self::Velocities
            | Self::State
            | Self::Controls
            | Self::Activations
            | Self::Time
            | Self::Number
            | Self::Numbers(_)
            | Self::ContactVectors
            | Self::RandomNumbers
            | Self::Factors => BatchForm::Numbers,
            Self::ActiveContacts => BatchForm::Sets,
            Self::Settings | Self::StepSettings => BatchForm::Shared,
            Self::Wrenches | Self::ConstraintWrenches => BatchForm::None,
        }
    }
}

impl Argument {
    /// Returns the layout.
    #[must_use]
    pub fn shape(&self, sizes: &Sizes) -> Shape {
        match self.kind {
            ArgumentKind::Coordinates => shapes::coordinates(sizes),
            ArgumentKind::Velocities | ArgumentKind::RandomNumbers => shapes::velocities(sizes),
            ArgumentKind::State => shapes::state(sizes),
            ArgumentKind::Controls => shapes::controls(sizes),
            ArgumentKind::Activations => shapes::activations(sizes),
            ArgumentKind::Time | ArgumentKind::Number => Shape::Scalar,
            ArgumentKind::Numbers(count) => Shape::vector(count),
            ArgumentKind::Wrenches => shapes::wrenches(sizes),
            ArgumentKind::ConstraintWrenches => shapes::constraint_wrenches(sizes),
            ArgumentKind::ContactVectors => shapes::contact_vectors(sizes),
            ArgumentKind::ActiveContacts => shapes::active_contacts(sizes),
            ArgumentKind::Settings => shapes::settings(sizes),
            ArgumentKind::StepSettings => shapes::step_settings(sizes),
            ArgumentKind::Factors => Shape::vector(sizes.factors),
        }
    }
}

// The arguments by name, for the rows of the table.
pub(super) const Q: Argument = Argument { name: "q", kind: ArgumentKind::Coordinates };
pub(super) const QD: Argument = Argument { name: "qd", kind: ArgumentKind::Velocities };
pub(super) const QDD: Argument = Argument { name: "qdd", kind: ArgumentKind::Velocities };
pub(super) const TAU: Argument = Argument { name: "tau", kind: ArgumentKind::Velocities };
pub(super) const TANGENT_Q: Argument =
    Argument { name: "tangent_q", kind: ArgumentKind::Velocities };
pub(super) const TANGENT_QD: Argument =
    Argument { name: "tangent_qd", kind: ArgumentKind::Velocities };
pub(super) const TANGENT_QDD: Argument =
    Argument { name: "tangent_qdd", kind: ArgumentKind::Velocities };
pub(super) const TANGENT_TAU: Argument =
    Argument { name: "tangent_tau", kind: ArgumentKind::Velocities };
pub(super) const TANGENT_CTRL: Argument =
    Argument { name: "tangent_ctrl", kind: ArgumentKind::Controls };
pub(super) const TANGENT_ACT: Argument =
    Argument { name: "tangent_act", kind: ArgumentKind::Activations };
pub(super) const COTANGENT: Argument =
    Argument { name: "cotangent", kind: ArgumentKind::Velocities };
pub(super) const WRENCH_COTANGENT: Argument =
    Argument { name: "wrench_cotangent", kind: ArgumentKind::ConstraintWrenches };
pub(super) const CTRL: Argument = Argument { name: "ctrl", kind: ArgumentKind::Controls };
pub(super) const DT: Argument = Argument { name: "dt", kind: ArgumentKind::Time };
pub(super) const STATE_COTANGENT: Argument =
    Argument { name: "state_cotangent", kind: ArgumentKind::State };
pub(super) const ACT_COTANGENT: Argument =
    Argument { name: "act_cotangent", kind: ArgumentKind::Activations };
pub(super) const V: Argument = Argument { name: "v", kind: ArgumentKind::Velocities };
pub(super) const FROM: Argument = Argument { name: "from", kind: ArgumentKind::Coordinates };
pub(super) const TO: Argument = Argument { name: "to", kind: ArgumentKind::Coordinates };
pub(super) const FORCES: Argument = Argument { name: "forces", kind: ArgumentKind::Wrenches };
pub(super) const IMPULSES: Argument =
    Argument { name: "impulses", kind: ArgumentKind::ContactVectors };
pub(super) const ACTIVE: Argument = Argument { name: "active", kind: ArgumentKind::ActiveContacts };
pub(super) const SETTINGS: Argument = Argument { name: "settings", kind: ArgumentKind::Settings };
pub(super) const ACT: Argument = Argument { name: "act", kind: ArgumentKind::Activations };
pub(super) const APPLIED: Argument = Argument { name: "applied", kind: ArgumentKind::Velocities };
pub(super) const WARM_START: Argument =
    Argument { name: "warm_start", kind: ArgumentKind::Velocities };
pub(super) const STEP_SETTINGS: Argument =
    Argument { name: "step_settings", kind: ArgumentKind::StepSettings };
pub(super) const UNIFORMS: Argument =
    Argument { name: "uniforms", kind: ArgumentKind::RandomNumbers };

/// The arguments of functions of the table, in the order that they have in every function.
pub const ARGUMENTS: &[Argument] = &[
    Q,
    QD,
    QDD,
    TAU,
    TANGENT_Q,
    TANGENT_QD,
    TANGENT_QDD,
    TANGENT_TAU,
    COTANGENT,
    WRENCH_COTANGENT,
    CTRL,
    TANGENT_CTRL,
    DT,
    STATE_COTANGENT,
    V,
    FROM,
    TO,
    FORCES,
    IMPULSES,
    ACTIVE,
    SETTINGS,
    ACT,
    TANGENT_ACT,
    ACT_COTANGENT,
    APPLIED,
    WARM_START,
    STEP_SETTINGS,
    UNIFORMS,
];
