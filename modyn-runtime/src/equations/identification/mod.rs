//! Identification: inverse dynamics as a linear function of the inertial parameters.

mod base_parameters;
mod regressor;

pub use {base_parameters::*, regressor::*};
