//! Inverse and forward dynamics, the mass matrix, gravity, energy and momentum.

mod centroidal;
mod external;
mod forward_dynamics;
mod gravity;
mod inverse_dynamics;
mod kinetic_energy;
mod mass_matrix;
pub(super) mod newton_euler;

pub(super) use inverse_dynamics::bias_in_free_fall;

pub use {
    centroidal::{centroidal_momentum, centroidal_momentum_matrix},
    external::Forces,
    forward_dynamics::{Elimination, forward_dynamics, recursive_forward_dynamics},
    gravity::{gravity_torques, potential_energy},
    inverse_dynamics::{inverse_dynamics, recursive_newton_euler},
    kinetic_energy::kinetic_energy,
    mass_matrix::mass_matrix,
};
