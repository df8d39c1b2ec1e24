//! The types of the arguments and results of a robot's functions, by the kinds and layouts of the
//! table.

use crate::quantities::{layouts, table};

/// The type of an argument of this kind.
macro_rules! kind_type {
    (Coordinates) => { &Self::Q<T> };
    (Velocities) => { &Self::V<T> };
    (State) => { &Self::PerState<T> };
    (Controls) => { &Self::PerControl<T> };
    (Activations) => { &Self::PerActivation<T> };
    (Time) => { T };
    (Wrenches) => { &Self::PerLink<Wrench<T>> };
    (ConstraintWrenches) => { &Self::PerConstraint<Wrench<T>> };
    (ContactVectors) => { &Self::PerContact<Vector3<T>> };
    (Contacts) => { Self::Contacts };
    (Settings) => { &Settings<Self, T> };
    (StepSettings) => { &StepSettings<T, Self::PerTouchingShape<ContactSurface<T>>> };
    (RandomNumbers) => { impl FnMut() -> T };
}

/// Declares the macro that returns the type of an argument.
macro_rules! declare_argument_type {
    ($($name:ident $kind:ident,)*) => {
        /// The type of an argument.
        macro_rules! argument_type {
            $(($name) => { kind_type!($kind) };)*
        }
    };
}

table::arguments!(declare_argument_type);

/// Declares the macro that returns the type of a result of this layout.
macro_rules! declare_result_type {
    ($($name:ident ($($type:tt)*) |$sizes:pat_param| $layout:expr;)*) => {
        /// The type of a result of this layout.
        macro_rules! result_type {
            $(($name) => { $($type)* };)*
        }
    };
}

layouts::layouts!(declare_result_type);
