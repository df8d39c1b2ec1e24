//! A planned function: the arguments, the result and the programs that a printer receives.

use modyn_runtime::OperationCount;

use super::functions::CForm;
use super::{Argument, Function, Record, Shape};
use crate::program::{InvalidProgram, Program, Recursion};

/// A function or a bundle of functions, planned for a robot.
pub struct Planned {
    /// The function; `None` for a bundle and a user's function.
    pub function: Option<Function>,
    /// The name.
    pub name: &'static str,
    /// The name of the function of one state, if this is its form for many states.
    pub batch_of: Option<&'static str>,
    /// The documentation, in lines.
    pub docs: &'static str,
    /// The documentation of each field of the result, if the result is a type of the robot's own.
    pub fields: Vec<&'static str>,
    /// The forms that C can call.
    pub c_form: CForm,
    /// The arguments, with their layouts.
    pub arguments: Vec<(Argument, Shape)>,
    /// The number of run-time parameters, which are the last argument; zero if the function does not depend on them.
    pub parameters: usize,
    /// The layout of the result.
    pub result: Shape,
    /// The programs.
    pub kernels: Kernels,
    /// The violation of a rule by the packed program, which the programs on scalars replace. `None` unless modyn has a fault.
    pub fault: Option<InvalidProgram>,
}

/// The programs of a function.
pub enum Kernels {
    /// One program.
    One(Program),
    /// Loops over the bodies.
    Looped(Recursion),
    /// A program on scalars and a program on vectors; the processor's features decide at run time.
    Dispatched {
        /// The program on scalars.
        scalar: Program,
        /// The program on vectors.
        simd: Program,
    },
    /// The programs of a function of one link: one for each link with a program of its own, in the order of
    /// [`Frames::links_with_own_program`](super::Frames::links_with_own_program), then one for each body with a shared program. Shared programs have the
    /// link's placement as a further argument.
    ByLink(Vec<Program>),
    /// The programs of the poses of all links, if some links share a program.
    Poses {
        /// The poses in the order of [`Frames::links_with_own_program`](super::Frames::links_with_own_program), then of the bodies with a shared program.
        bodies: Program,
        /// The pose of a link with a shared program, from the pose of its body and the link's placement.
        placed: Program,
        /// The number of links with a shared program.
        rows: usize,
    },
}

impl Planned {
    /// Returns whether the function computes the state after a time step, from `q`, `qd`, `tau` and `dt`.
    #[must_use]
    pub fn is_step(&self) -> bool {
        self.function.is_some() && matches!(self.result, Shape::Record(Record::Each("Step"), _))
    }

    /// Returns the operations of one call on scalars; for a function of one link, those of the most expensive link.
    #[must_use]
    pub fn operations_per_call(&self) -> OperationCount {
        match &self.kernels {
            Kernels::One(program) | Kernels::Dispatched { scalar: program, .. } => {
                program.operations_per_call()
            }
            Kernels::Looped(recursion) => recursion.operations_per_call(),
            Kernels::ByLink(all) => {
                let counts = all.iter().map(Program::operations_per_call);
                counts.max_by_key(OperationCount::total).unwrap_or_default()
            }
            Kernels::Poses { bodies, placed, rows } => {
                let placed = std::iter::repeat_n(placed.operations_per_call(), *rows);
                placed.chain([bodies.operations_per_call()]).sum()
            }
        }
    }

    /// Returns the operations of all programs.
    #[must_use]
    pub fn static_operations(&self) -> OperationCount {
        match &self.kernels {
            Kernels::One(program) => program.static_operations(),
            Kernels::Looped(recursion) => recursion.static_operations(),
            Kernels::Dispatched { scalar, simd } => {
                scalar.static_operations() + simd.static_operations()
            }
            Kernels::ByLink(all) => all.iter().map(Program::static_operations).sum(),
            Kernels::Poses { bodies, placed, .. } => {
                bodies.static_operations() + placed.static_operations()
            }
        }
    }
}
