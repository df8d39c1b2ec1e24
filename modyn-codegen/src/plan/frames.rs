//! Links that are fixed to one body share the code of their functions.
//!
//! The first few links of a body have programs of their own, in which their placements are folded. All others of the
//! body share one program, to which their placement on the body is an argument: a row of a table. So the code grows by
//! a row and a call for each further link, whatever the functions compute.

use modyn_runtime::mechanism::{BodyFrame, Mechanism};
use modyn_runtime::spatial::Pose;

use super::Shape;
use crate::graph::Graph;
use crate::trace::{LinkFrame, Tracer};

/// Most links of one body that have programs of their own.
pub(crate) const MAX_OWN_FUNCTIONS: usize = 8;

/// The program of a link among those of a function of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkCode {
    /// A program of its own.
    Own,
    /// The program of all further links on its body.
    Shared {
        /// The index of the body among those that have such a program.
        body: usize,
        /// The row of the table of placements.
        row: usize,
    },
}

/// The links of a robot, by the programs that they have.
pub struct Frames {
    /// The robot without its links, to which the one of a program is added.
    bare: Mechanism<f64>,
    frames: Vec<BodyFrame<f64>>,
    codes: Vec<LinkCode>,
    /// The bodies with links that share a program.
    shared: Vec<Option<usize>>,
}

impl Frames {
    /// The number of scalars of a placement: nine of a rotation by rows, then three of a translation.
    pub const PLACEMENT: usize = 12;

    pub(super) fn new(mechanism: &Mechanism<f64>) -> Self {
        // By body, the world first.
        let mut counts = vec![0; mechanism.bodies.len() + 1];
        let (mut codes, mut shared, mut rows) = (Vec::new(), Vec::new(), 0);
        for frame in &mechanism.frames {
            let count = &mut counts[frame.body.map_or(0, |body| body + 1)];
            *count += 1;
            if *count == MAX_OWN_FUNCTIONS + 1 {
                shared.push(frame.body);
            }
            codes.push(if *count <= MAX_OWN_FUNCTIONS {
                LinkCode::Own
            } else {
                rows += 1;
                let place = shared.iter().position(|&other| other == frame.body);
                LinkCode::Shared { body: place.unwrap_or_default(), row: rows - 1 }
            });
        }
        let bare = Mechanism { frames: Vec::new(), ..mechanism.clone() };
        Self { bare, frames: mechanism.frames.clone(), codes, shared }
    }

    /// The robot without its links.
    pub(super) fn mechanism_without_links(&self) -> &Mechanism<f64> {
        &self.bare
    }

    /// For each link of the description which program it has.
    #[must_use]
    pub fn codes(&self) -> &[LinkCode] {
        &self.codes
    }

    /// Whether links share programs.
    #[must_use]
    pub fn any_shared(&self) -> bool {
        !self.shared.is_empty()
    }

    /// The links with programs of their own, each by its index.
    pub fn links_with_own_program(&self) -> impl Iterator<Item = usize> {
        (0..self.codes.len()).filter(|&link| self.codes[link] == LinkCode::Own)
    }

    /// The number of links that share a program.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.codes.iter().filter(|code| **code != LinkCode::Own).count()
    }

    /// The table of placements: the pose on its body of each link that shares a program.
    pub fn placements(&self) -> impl Iterator<Item = [f64; Self::PLACEMENT]> {
        let shared =
            self.frames.iter().zip(&self.codes).filter(|(_, code)| **code != LinkCode::Own);
        shared.map(|(BodyFrame { pose, .. }, _)| {
            let mut numbers = pose.rotation.iter().flatten().chain(&pose.translation);
            std::array::from_fn(|_| *numbers.next().expect("twelve"))
        })
    }

    /// The layout of the poses that `poses` traces first.
    #[must_use]
    pub fn poses_of_bodies(&self) -> Shape {
        Shape::pose().array(self.codes.len() - self.rows() + self.shared.len())
    }

    /// The graphs of `trace` on tracers that have one link: first those of single links, then those that links share.
    pub(super) fn kernels(&self, trace: impl Fn(&Tracer<'_>) -> Graph) -> Vec<Graph> {
        let own = self.links_with_own_program().map(|link| LinkFrame::Known(self.frames[link]));
        let all = own.chain(self.shared.iter().copied().map(LinkFrame::On));
        all.map(|frame| trace(&Tracer::with_link(&self.bare, frame))).collect()
    }

    /// The poses of the links with programs of their own and of the bodies with links that share one, and the pose of
    /// such a link from that of its body.
    pub(super) fn poses(&self) -> [Graph; 2] {
        let own = self.links_with_own_program().map(|link| self.frames[link]);
        let bodies = self.shared.iter().map(|&body| BodyFrame { body, pose: Pose::identity() });
        let model = Mechanism { frames: own.chain(bodies).collect(), ..self.bare.clone() };
        [Tracer::new(&model).link_poses(), Tracer::placed_pose()]
    }
}
