//! A planned function: the arguments, the result and the programs that a printer receives.

use modyn_runtime::{OperationCount, Scalar};

use super::frames::{Frames, LinkProgram};
use super::functions::CForm;
use super::{Argument, Function, Record, Shape};
use crate::program::{InvalidProgram, Program};

/// The arguments of time steps that a rollout has numbers of for each step, each with the noun of its
/// numbers. The first of these among a step's arguments is the plan of the rollout.
pub const PLANNED: [(&str, &str); 2] = [("ctrl", "controls"), ("tau", "joint forces")];

/// The arguments of time steps that are results of the step before. In results they follow q and qd,
/// in this order.
pub const CARRIED: [&str; 2] = ["act", "warm_start"];

/// A function or a fused function, planned for a robot.
pub struct Planned {
    /// The function; `None` for a fused function and a user's function.
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
    /// The number of run-time parameters, which are the last argument; zero if the function does
    /// not depend on them.
    pub parameters: usize,
    /// The layout of the result.
    pub result: Shape,
    /// The programs.
    pub kernels: Kernels,
    /// The violation of a rule by the packed program, which the programs on scalars replace. `None`
    /// unless modyn has a fault.
    pub fault: Option<InvalidProgram>,
}

/// The programs of a function.
pub enum Kernels {
    /// Statements, of which some may be loops.
    Straight {
        /// The program without packs.
        scalar: Program,
        /// The same function on vectors, if that is profitable; the processor's features decide at
        /// run time.
        simd: Option<Program>,
    },
    /// The programs of a function of one link, with the indices of
    /// [`LinkProgram`](super::LinkProgram). A program that links share has the link's placement as
    /// a further argument.
    ByLink(Vec<Program>),
    /// The programs of the poses of all links, if some links share a program.
    Poses {
        /// The poses with the indices of [`LinkProgram`](super::LinkProgram).
        bodies: Program,
        /// The pose of a link with a shared program, from the pose of its body and the link's
        /// placement.
        placed: Program,
        /// The number of links with a shared program.
        rows: usize,
    },
}

impl Kernels {
    /// Returns straight-line code without a form on vectors.
    pub(super) fn of(scalar: Program) -> Self {
        Self::Straight { scalar, simd: None }
    }

    /// Returns straight-line code as two programs: without packs, and on vectors where that is
    /// profitable, else without packs. Returns `None` for loops and functions of links.
    #[must_use]
    pub fn straight(&self) -> Option<(&Program, &Program)> {
        match self {
            Self::Straight { scalar, simd } => Some((scalar, simd.as_ref().unwrap_or(scalar))),
            Self::ByLink(_) | Self::Poses { .. } => None,
        }
    }
}

impl Planned {
    /// Returns whether the function has a link as a further argument.
    #[must_use]
    pub fn is_by_link(&self) -> bool {
        matches!(self.kernels, Kernels::ByLink(_))
    }

    /// Returns the lengths of the arrays of arguments, the array of run-time parameters included if
    /// there is one.
    #[must_use]
    pub fn lengths(&self) -> Vec<usize> {
        let lengths = self.arguments.iter().map(|(_, shape)| shape.len());
        lengths.chain((self.parameters > 0).then_some(self.parameters)).collect()
    }

    /// Returns the result for these arguments, one after the other, by the evaluation of programs
    /// without packs: the reference for back ends. `link` is the link of a function of one link.
    ///
    /// # Panics
    ///
    /// If an argument that is read is missing, or there is no such link.
    #[must_use]
    pub fn evaluate<S: Scalar>(&self, frames: &Frames, link: usize, arguments: &[S]) -> Vec<S> {
        let placed = |program: &Program, arguments: &[S], placement: Option<usize>| {
            let placements = placement.and_then(|row| frames.placements().nth(row));
            let row = placements.iter().flatten().map(|&x| S::from_f64(x));
            program.evaluate(&arguments.iter().copied().chain(row).collect::<Vec<S>>())
        };
        match &self.kernels {
            Kernels::Straight { scalar, .. } => scalar.evaluate(arguments),
            Kernels::ByLink(programs) => {
                let LinkProgram { program, placement } = frames.programs()[link];
                placed(&programs[program], arguments, placement)
            }
            Kernels::Poses { bodies, placed: on_body, .. } => {
                let poses = bodies.evaluate(arguments);
                let pose = |link: &LinkProgram| {
                    let length = Shape::pose().len();
                    let pose = &poses[link.program * length..][..length];
                    match link.placement {
                        None => pose.to_vec(),
                        Some(_) => placed(on_body, pose, link.placement),
                    }
                };
                frames.programs().iter().flat_map(pose).collect()
            }
        }
    }

    /// Returns the name of the function that calls this function, a time step, in a loop; `None`
    /// for other functions.
    #[must_use]
    pub fn rollout(&self) -> Option<String> {
        match self.result {
            _ if self.function.is_none() => None,
            Shape::Record(Record::ResultsByField("Step" | "StepSolution" | "ActuatedStep"), _) => {
                Some(self.name.replacen("step", "rollout", 1))
            }
            _ => None,
        }
    }

    /// Returns the operations of one call on scalars; for a function of one link, the operations of
    /// the most expensive link.
    #[must_use]
    pub fn operations_per_call(&self) -> OperationCount {
        match &self.kernels {
            Kernels::Straight { scalar, .. } => scalar.operations_per_call(),
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
            Kernels::Straight { scalar, simd } => [Some(scalar), simd.as_ref()]
                .into_iter()
                .flatten()
                .map(Program::static_operations)
                .sum(),
            Kernels::ByLink(all) => all.iter().map(Program::static_operations).sum(),
            Kernels::Poses { bodies, placed, .. } => {
                bodies.static_operations() + placed.static_operations()
            }
        }
    }
}
