//! Functions without machine code: their programs, evaluated operation by operation.

use modyn_codegen::plan::{Frames, Kernels, LinkCode, Plan, Planned, Shape};
use modyn_codegen::program::Program;
use modyn_codegen::trace::Parameters;
use modyn_runtime::Inertial;
use modyn_runtime::model::Model;

use crate::change::Change;
use crate::number::Number;

/// A function whose programs are evaluated.
pub struct Evaluated<S> {
    programs: Programs<S>,
    parameters: Parameters,
    /// The numbers of the parameters, if the function depends on them.
    numbers: Vec<S>,
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
        let numbers = match planned.parameters {
            0 => Vec::new(),
            _ => plan.parameters.described(gravity),
        };
        let numbers = numbers.into_iter().map(S::from_f64).collect();
        Self { programs, parameters: plan.parameters.clone(), numbers }
    }

    /// Applies a change of the robot's run-time parameters, a valid one.
    ///
    /// # Errors
    ///
    /// If the robot does not have the parameter.
    pub fn apply(&mut self, change: &Change, model: &Model) -> Result<(), String> {
        let frame = |link: &str| model.frame_index(link).unwrap_or(usize::MAX);
        let (place, new) = match change {
            Change::Gravity(gravity) => (self.parameters.gravity.then_some(0), gravity.to_vec()),
            Change::Inertia(link, inertial) => {
                let mut own = self.parameters.inertias.iter();
                let place = own.position(|(other, _)| *other == frame(link));
                (place.map(|k| self.parameters.inertial(k)), numbers(inertial))
            }
            Change::Payload(link, inertial) => {
                let mut payloads = self.parameters.payloads.iter();
                let place = payloads.position(|other| *other == frame(link));
                let first = self.parameters.inertias.len();
                (place.map(|k| self.parameters.inertial(first + k)), numbers(inertial))
            }
        };
        let place = place.ok_or_else(|| change.missing())?;
        if let Some(numbers) = self.numbers.get_mut(place..place + new.len()) {
            for (number, new) in numbers.iter_mut().zip(new) {
                *number = S::from_f64(new);
            }
        }
        Ok(())
    }

    /// Computes the result of one state; `link` is that of a function of one link.
    pub fn one(&self, link: usize, arguments: &[&[S]], result: &mut [S]) {
        let mut numbers = arguments.concat();
        numbers.extend_from_slice(&self.numbers);
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

fn numbers(Inertial { mass, center_of_mass, inertia }: &Inertial) -> Vec<f64> {
    [*mass].into_iter().chain(*center_of_mass).chain(*inertia).collect()
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
