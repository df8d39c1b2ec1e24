//! The arguments of functions: their names, kinds and order.

use super::shape::{Shape, Sizes, shapes};
use super::table;

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
    Contacts,
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
            Self::Contacts => BatchForm::Sets,
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
            ArgumentKind::Contacts => shapes::contacts(sizes),
            ArgumentKind::Settings => shapes::settings(sizes),
            ArgumentKind::StepSettings => shapes::step_settings(sizes),
            ArgumentKind::Factors => Shape::vector(sizes.factors),
        }
    }
}

/// Declares the arguments of the table in the order that they have in every function.
macro_rules! declare_arguments {
    ($($name:ident $kind:ident,)*) => {
        /// The arguments of functions of the table, in the order that they have in every function.
        pub const ARGUMENTS: &[Argument] =
            &[$(Argument { name: stringify!($name), kind: ArgumentKind::$kind }),*];
    };
}

table::arguments!(declare_arguments);

/// Returns the argument of this name.
pub(super) const fn argument(name: &str) -> Argument {
    let mut i = 0;
    while i < ARGUMENTS.len() {
        if same(ARGUMENTS[i].name, name) {
            return ARGUMENTS[i];
        }
        i += 1;
    }
    panic!("the table of arguments has no argument of this name")
}

/// Returns whether two names are equal.
pub(super) const fn same(a: &str, b: &str) -> bool {
    let a = a.as_bytes();
    let b = b.as_bytes();
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}
