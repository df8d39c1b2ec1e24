//! The choices that a plan depends on: the user's, and the way that the programs run.

use super::bundle::Bundle;
use super::functions::Function;

/// The choices of a user that a plan depends on.
#[derive(Clone, Debug)]
pub struct Choices {
    /// The selected functions.
    pub functions: Vec<Function>,
    /// The bundles of functions.
    pub bundles: Vec<Bundle>,
    /// Whether equal limbs share one routine.
    pub share: bool,
    /// Whether gravity is an argument.
    pub runtime_gravity: bool,
    /// The links whose own inertia is an argument, as indices into the model's frames.
    pub runtime_inertia: Vec<usize>,
    /// The links with a payload that is an argument, as indices into the model's frames.
    pub payload: Vec<usize>,
}

impl Choices {
    /// Returns the choices with functions of one state in place of those of many, and without shared routines.
    #[must_use]
    pub fn of_one_state(mut self) -> Self {
        for function in &mut self.functions {
            *function = function.batched().unwrap_or(*function);
        }
        for bundle in &mut self.bundles {
            bundle.batch = false;
        }
        self.share = false;
        self
    }

    /// Returns the way equal limbs and columns are computed.
    pub(super) fn strategy(&self, execution: Execution) -> Strategy {
        match execution {
            Execution::Threads => Strategy::Threads,
            _ if self.share => Strategy::Routines,
            Execution::Scalar => Strategy::Scalar,
            Execution::Vectors => Strategy::Vectors,
        }
    }
}

/// The way that a back end runs programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Execution {
    /// One state at a time, on scalars.
    Scalar,
    /// One state at a time, packed into vectors on processors that have them; or many states, one in each lane.
    Vectors,
    /// Many states, one in each thread of a graphics processor.
    Threads,
}

/// The way equal limbs and columns of one state are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Strategy {
    /// One after the other.
    Scalar,
    /// By one routine, with a table of constants for each limb.
    Routines,
    /// Packed into vectors, on processors that have them.
    Vectors,
    /// One after another, one state in each thread of a graphics processor.
    Threads,
}
