//! Links on the same body share the code of their functions.
//!
//! The first links of a body have programs of their own, into which their poses on the body are
//! folded as constants. All further links of the body share one program, with the pose on the body
//! as an argument: a row of a table. Each further link therefore adds a row and a call, whatever
//! the function computes.
//!
//! `link_poses` places further links on the poses of their bodies.

use modyn_runtime::mechanism::{BodyFrame, Mechanism};
use modyn_runtime::spatial::Pose;

use super::Shape;
use crate::graph::Graph;
use crate::trace::{LinkFrame, Tracer};

/// The largest number of links of one body that have programs of their own.
pub(crate) const MAX_OWN_FUNCTIONS: usize = 8;

/// The program that a link has for a function of one link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinkProgram {
    /// The index of the program: first the programs of single links, then the programs of bodies
    /// whose further links share one.
    pub program: usize,
    /// The row of the table of placements, for a program that links share.
    pub placement: Option<usize>,
}

/// The links of a robot, grouped by their programs.
pub struct Frames {
    /// The robot without its links; a program's link is added to it.
    bare: Mechanism<f64>,
    frames: Vec<BodyFrame<f64>>,
    programs: Vec<LinkProgram>,
    /// The bodies with a shared program.
    shared: Vec<Option<usize>>,
}

impl Frames {
    /// The number of scalars of a placement: nine of a rotation by rows, then three of a
    /// translation.
    pub const PLACEMENT: usize = 12;

    pub(super) fn new(mechanism: &Mechanism<f64>) -> Self {
        // For each body, the world first.
        let mut counts = vec![0; mechanism.bodies.len() + 1];
        let mut programs = Vec::new();
        let mut shared = Vec::new();
        let mut known_count = 0;
        let mut rows = 0;
        for frame in &mechanism.frames {
            let count = &mut counts[frame.body.map_or(0, |body| body + 1)];
            *count += 1;
            if *count == MAX_OWN_FUNCTIONS + 1 {
                shared.push(frame.body);
            }
            programs.push(if *count <= MAX_OWN_FUNCTIONS {
                known_count += 1;
                LinkProgram { program: known_count - 1, placement: None }
            } else {
                rows += 1;
                let place = shared.iter().position(|&other| other == frame.body);
                LinkProgram { program: place.unwrap_or_default(), placement: Some(rows - 1) }
            });
        }
        for link in programs.iter_mut().filter(|link| link.placement.is_some()) {
            link.program += known_count;
        }
        let bare = Mechanism { frames: Vec::new(), ..mechanism.clone() };
        Self { bare, frames: mechanism.frames.clone(), programs, shared }
    }

    /// Returns the robot without its links.
    pub(super) fn mechanism_without_links(&self) -> &Mechanism<f64> {
        &self.bare
    }

    /// Returns the program of each link of the description.
    #[must_use]
    pub fn programs(&self) -> &[LinkProgram] {
        &self.programs
    }

    /// Returns whether any links share a program.
    #[must_use]
    pub fn any_shared(&self) -> bool {
        !self.shared.is_empty()
    }

    /// Returns the indices of the links with programs of their own.
    pub fn links_with_own_program(&self) -> impl Iterator<Item = usize> {
        (0..self.programs.len()).filter(|&link| self.programs[link].placement.is_none())
    }

    /// Returns the number of programs of a function of one link.
    pub(super) fn program_count(&self) -> usize {
        self.links_with_own_program().count() + self.shared.len()
    }

    /// Returns the number of links that share a program with others.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.programs.iter().filter(|link| link.placement.is_some()).count()
    }

    /// Returns the table of placements: the pose on its body of each link with a shared program.
    pub fn placements(&self) -> impl Iterator<Item = [f64; Self::PLACEMENT]> {
        let placed = self.frames.iter().zip(&self.programs);
        let shared = placed.filter(|(_, link)| link.placement.is_some());
        shared.map(|(BodyFrame { pose, .. }, _)| {
            let mut numbers = pose.rotation.iter().flatten().chain(&pose.translation);
            std::array::from_fn(|_| *numbers.next().expect("twelve"))
        })
    }

    /// Returns the layout of the results of the first program of `poses`.
    #[must_use]
    pub fn poses_of_bodies(&self) -> Shape {
        Shape::pose().array(self.programs.len() - self.rows() + self.shared.len())
    }

    /// Returns the graphs of `trace` on tracers with one link: first for links of their own, then
    /// for shared ones.
    pub(super) fn kernels(&self, trace: impl Fn(&Tracer<'_>) -> Graph) -> Vec<Graph> {
        let known = self.links_with_own_program().map(|link| LinkFrame::Known(self.frames[link]));
        let all = known.chain(self.shared.iter().copied().map(LinkFrame::On));
        all.map(|frame| trace(&Tracer::with_link(&self.bare, frame))).collect()
    }

    /// Returns the graph of `trace` on a tracer with this link, by its index among the links of the
    /// description.
    pub(super) fn of_link(&self, link: usize, trace: impl Fn(&Tracer<'_>) -> Graph) -> Graph {
        trace(&Tracer::with_link(&self.bare, LinkFrame::Known(self.frames[link])))
    }

    /// Returns two graphs: the poses of links with programs of their own and of bodies with a
    /// shared program; and the pose of a link with a shared program, from the pose of its body.
    pub(super) fn poses(&self) -> [Graph; 2] {
        let known = self.links_with_own_program().map(|link| self.frames[link]);
        let bodies = self.shared.iter().map(|&body| BodyFrame { body, pose: Pose::identity() });
        let model = Mechanism { frames: known.chain(bodies).collect(), ..self.bare.clone() };
        [Tracer::new(&model).link_poses(), Tracer::placed_pose()]
    }
}
