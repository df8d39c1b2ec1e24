//! Inverse and forward dynamics, the mass matrix, gravity, energy and momentum.

mod centroidal;
mod external;
mod forward_dynamics;
mod gravity;
pub(in crate::equations) mod gravity_compensation;
mod inverse_dynamics;
mod kinetic_energy;
mod mass_matrix;
pub(super) mod newton_euler;
mod one_body;
mod passive_forces;

pub use {
    centroidal::*, external::*, forward_dynamics::*, gravity::*, inverse_dynamics::*,
    kinetic_energy::*, mass_matrix::*, newton_euler::*, one_body::*,
};
