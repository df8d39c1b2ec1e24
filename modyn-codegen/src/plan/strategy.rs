//! The execution of programs: as the back end supports it, and for equal limbs and columns of one state.

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

impl Execution {
    /// Returns the way equal limbs and columns are computed; `share` has one routine for equal limbs.
    pub(super) fn strategy(self, share: bool) -> Strategy {
        match self {
            Self::Threads => Strategy::Threads,
            _ if share => Strategy::Routines,
            Self::Scalar => Strategy::Scalar,
            Self::Vectors => Strategy::Vectors,
        }
    }

    /// Returns the form of the code of recursions: graphics processors run straight-line code alone.
    pub(super) fn code_form(self, chosen: CodeForm) -> CodeForm {
        if self == Self::Threads { CodeForm::Fast } else { chosen }
    }
}

/// The form of the code of recursions over the bodies: forward and inverse dynamics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CodeForm {
    /// Loops where straight-line code would be too long for the instruction cache of a processor.
    #[default]
    Auto,
    /// Straight-line code: the fewest operations.
    Fast,
    /// Loops over the bodies with tables of constants: the shortest code.
    Small,
}

/// The way equal limbs and columns of one state are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// One after the other.
    Scalar,
    /// By one routine, with a table of constants for each limb.
    Routines,
    /// Packed into vectors, on processors that have them.
    Vectors,
    /// One after another, one state in each thread of a graphics processor.
    Threads,
}
