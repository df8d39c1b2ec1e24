//! The arguments of functions: their names, kinds and order.

use crate::plan::shape::{Shape, Sizes, shapes};

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
    /// A number for each degree of freedom: velocities, accelerations, joint forces, and changes of these or of
    /// coordinates.
    Velocities,
    /// A number for each degree of freedom of the coordinates, then one for each velocity.
    State,
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
    /// The set of active contacts.
    Contacts,
    /// The settings of constraints.
    Settings,
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
            | Self::Time
            | Self::Number
            | Self::Numbers(_)
            | Self::RandomNumbers
            | Self::Factors => BatchForm::Numbers,
            Self::Contacts => BatchForm::Sets,
            Self::Settings => BatchForm::Shared,
            Self::Wrenches | Self::ConstraintWrenches => BatchForm::None,
        }
    }
}

impl Argument {
    const fn new(name: &'static str, kind: ArgumentKind) -> Self {
        Self { name, kind }
    }

    /// Returns the layout.
    #[must_use]
    pub fn shape(&self, sizes: &Sizes) -> Shape {
        match self.kind {
            ArgumentKind::Coordinates => shapes::coordinates(sizes),
            ArgumentKind::Velocities | ArgumentKind::RandomNumbers => shapes::velocities(sizes),
            ArgumentKind::State => shapes::state(sizes),
            ArgumentKind::Time | ArgumentKind::Number => Shape::Scalar,
            ArgumentKind::Numbers(count) => Shape::vector(count),
            ArgumentKind::Wrenches => shapes::wrenches(sizes),
            ArgumentKind::ConstraintWrenches => shapes::constraint_wrenches(sizes),
            ArgumentKind::Contacts => shapes::contacts(sizes),
            ArgumentKind::Settings => shapes::settings(sizes),
            ArgumentKind::Factors => Shape::vector(sizes.factors),
        }
    }
}

pub(super) const Q: Argument = Argument::new("q", ArgumentKind::Coordinates);
pub(super) const QD: Argument = Argument::new("qd", ArgumentKind::Velocities);
pub(super) const QDD: Argument = Argument::new("qdd", ArgumentKind::Velocities);
pub(super) const TAU: Argument = Argument::new("tau", ArgumentKind::Velocities);
pub(super) const DQ: Argument = Argument::new("dq", ArgumentKind::Velocities);
pub(super) const DQD: Argument = Argument::new("dqd", ArgumentKind::Velocities);
pub(super) const DQDD: Argument = Argument::new("dqdd", ArgumentKind::Velocities);
pub(super) const DTAU: Argument = Argument::new("dtau", ArgumentKind::Velocities);
pub(super) const COTANGENT: Argument = Argument::new("cotangent", ArgumentKind::Velocities);
pub(super) const WRENCH_COTANGENT: Argument =
    Argument::new("wrench_cotangent", ArgumentKind::ConstraintWrenches);
pub(super) const DT: Argument = Argument::new("dt", ArgumentKind::Time);
pub(super) const COSTATE: Argument = Argument::new("costate", ArgumentKind::State);
pub(super) const V: Argument = Argument::new("v", ArgumentKind::Velocities);
pub(super) const FROM: Argument = Argument::new("from", ArgumentKind::Coordinates);
pub(super) const TO: Argument = Argument::new("to", ArgumentKind::Coordinates);
pub(super) const FORCES: Argument = Argument::new("forces", ArgumentKind::Wrenches);
pub(super) const SETTINGS: Argument = Argument::new("settings", ArgumentKind::Settings);
pub(super) const CONTACTS: Argument = Argument::new("contacts", ArgumentKind::Contacts);
pub(super) const UNIFORMS: Argument = Argument::new("uniforms", ArgumentKind::RandomNumbers);

/// The arguments of functions of the table, in the order that they have in every function.
pub const ARGUMENTS: &[Argument] = &[
    Q,
    QD,
    QDD,
    TAU,
    DQ,
    DQD,
    DQDD,
    DTAU,
    COTANGENT,
    WRENCH_COTANGENT,
    DT,
    COSTATE,
    V,
    FROM,
    TO,
    FORCES,
    CONTACTS,
    SETTINGS,
    UNIFORMS,
];

/// The factors of the mass matrix, an argument of the functions of the factors.
pub(in crate::plan) const FACTORS: Argument = Argument::new("factors", ArgumentKind::Factors);

/// The right-hand side of a linear equation, an argument of the functions of the factors.
pub(in crate::plan) const RHS: Argument = Argument::new("rhs", ArgumentKind::Velocities);
