//! The arguments of functions: their names, layouts and order.

use crate::plan::shape::{Shape, Sizes, shapes};

/// An argument of a function.
#[derive(Clone, Copy)]
pub struct Argument {
    /// The name.
    pub name: &'static str,
    /// The layout.
    pub shape: fn(&Sizes) -> Shape,
}

const fn argument(name: &'static str, shape: fn(&Sizes) -> Shape) -> Argument {
    Argument { name, shape }
}

pub(super) const Q: Argument = argument("q", shapes::coordinates);
pub(super) const QD: Argument = argument("qd", shapes::velocities);
pub(super) const QDD: Argument = argument("qdd", shapes::velocities);
pub(super) const TAU: Argument = argument("tau", shapes::velocities);
pub(super) const DQ: Argument = argument("dq", shapes::velocities);
pub(super) const DQD: Argument = argument("dqd", shapes::velocities);
pub(super) const DQDD: Argument = argument("dqdd", shapes::velocities);
pub(super) const DTAU: Argument = argument("dtau", shapes::velocities);
pub(super) const COTANGENT: Argument = argument("cotangent", shapes::velocities);
pub(super) const DT: Argument = argument("dt", shapes::scalar);
pub(super) const COSTATE: Argument = argument("costate", shapes::state);
pub(super) const V: Argument = argument("v", shapes::velocities);
pub(super) const FROM: Argument = argument("from", shapes::coordinates);
pub(super) const TO: Argument = argument("to", shapes::coordinates);
pub(super) const FORCES: Argument = argument("forces", shapes::wrenches);
pub(super) const SETTINGS: Argument = argument("settings", shapes::settings);
pub(super) const CONTACTS: Argument = argument("contacts", shapes::contacts);
pub(super) const UNIFORMS: Argument = argument("uniforms", shapes::velocities);

/// All arguments, in the order that they have in every function.
pub(in crate::plan) const ARGUMENTS: &[Argument] = &[
    Q, QD, QDD, TAU, DQ, DQD, DQDD, DTAU, COTANGENT, DT, COSTATE, V, FROM, TO, FORCES, CONTACTS,
    SETTINGS, UNIFORMS,
];
