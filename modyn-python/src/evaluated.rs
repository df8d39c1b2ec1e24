//! Functions without machine code: their programs, evaluated operation by operation.

use modyn_codegen::plan::{Frames, Kernels, LinkCode, Plan, Planned, Shape};
use modyn_codegen::program::Program;
use modyn_runtime::model::Model;

use crate::change::Change;
use crate::number::Number;
use crate::parameters::ParameterNumbers;

/// A function whose programs are evaluated.
pub struct Evaluated<S> {
    programs: Programs<S>,
    parameters: ParameterNumbers<S>,
}

enum Programs<S> {
    One(Program),
    /// The programs of a function of one link; each link has the index of its program, and its placement if other links share
    /// the program.
    ByLink(Vec<Program>, Vec<Link<S>>),
    /// The program of poses, and the program of the pose of a link from that of its body and the link's placement.
    Poses(Program, Program, Vec<Link<S>>),
}

/// The index of a link's program or pose, and the link's placement if other links share it.
type Link<S> = (usize, Option<[S; Frames::PLACEMENT]>);

impl<S: Number> Evaluated<S> {
    /// Returns the programs of a planned function.
    pub fn new(planned: Planned, plan: &Plan, gravity: [f64; 3]) -> Self {
        let links = || links(&plan.frames);
        let programs = match planned.kernels {
            Kernels::One(program) | Kernels::Dispatched { scalar: program, .. } => {
                Programs::One(program)
            }
            Kernels::Looped(_) => unreachable!("plans of one state have no loops"),
            Kernels::ByLink(programs) => Programs::ByLink(programs, links()),
            Kernels::Poses { bodies, placed, .. } => Programs::Poses(bodies, placed, links()),
        };
        let parameters = ParameterNumbers::new(plan, gravity, planned.parameters > 0);
        Self { programs, parameters }
    }

    /// Applies a change of the robot's run-time parameters, a valid one.
    ///
    /// # Errors
    ///
    /// If the robot does not have the parameter.
    pub fn apply(&mut self, change: &Change, model: &Model) -> Result<(), String> {
        self.parameters.apply(change, model)
    }

    /// Computes the result of one state; `link` is that of a function of one link.
    pub fn one(&self, link: usize, arguments: &[&[S]], result: &mut [S]) {
        let mut numbers = arguments.concat();
        numbers.extend_from_slice(self.parameters.as_slice());
        let numbers = match &self.programs {
            Programs::One(program) => program.evaluate(&numbers),
            Programs::ByLink(programs, links) => {
                let (program, placement) = &links[link];
                numbers.extend(placement.iter().flatten());
                programs[*program].evaluate(&numbers)
            }
            Programs::Poses(bodies, placed, links) => {
                let poses = bodies.evaluate(&numbers);
                let length = Shape::pose().len();
                let pose = |(own, placement): &Link<S>| {
                    let body = &poses[own * length..][..length];
                    match placement {
                        None => body.to_vec(),
                        Some(placement) => placed.evaluate(&[body, placement].concat()),
                    }
                };
                links.iter().flat_map(pose).collect()
            }
        };
        result.copy_from_slice(&numbers);
    }
}

/// Returns the program and the placement of each link.
fn links<S: Number>(frames: &Frames) -> Vec<Link<S>> {
    let placements: Vec<_> = frames.placements().map(|row| row.map(S::from_f64)).collect();
    let own = frames.links_with_own_program().count();
    let mut next = 0;
    let link = |code: &LinkCode| match *code {
        LinkCode::Own => {
            next += 1;
            (next - 1, None)
        }
        LinkCode::Shared { body, row } => (own + body, Some(placements[row])),
    };
    frames.codes().iter().map(link).collect()
}
