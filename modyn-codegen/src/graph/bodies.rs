//! The graphs of a recursion over bodies: one for each kind of bodies.

use modyn_runtime::equations::dynamics::Sweep;

use super::Graph;

/// The graphs of a recursion over the bodies of a robot.
pub struct BodyGraphs {
    /// The sweeps, with the number of numbers that a body receives in each.
    pub sweeps: &'static [(Sweep, usize)],
    /// The numbers that the world sends in each sweep. Inputs: the run-time parameters.
    pub world: Vec<Graph>,
    /// The kinds of bodies.
    pub kinds: Vec<BodyKind>,
    /// The bodies, parents before children.
    pub bodies: Vec<LoopedBody>,
    /// The number of run-time parameters.
    pub parameters: usize,
}

/// Bodies with the same equations.
pub struct BodyKind {
    /// The equations. Inputs: the body's entries of the three joint vectors, the run-time
    /// parameters, the numbers received in each sweep, the constants. Outputs: the numbers that the
    /// body keeps in each sweep, the numbers sent in each sweep, the body's entries of the result.
    pub graph: Graph,
    /// The number of entries of q, and of the other joint vectors and the result.
    pub entries: [usize; 2],
    /// The number of numbers that the body keeps in each sweep.
    pub kept: Vec<usize>,
    /// The number of numbers sent in each sweep.
    pub sent: Vec<usize>,
    /// The constants of each body.
    pub table: Vec<Vec<f64>>,
}

/// A body of a recursion.
#[derive(Clone, Copy, Debug)]
pub struct LoopedBody {
    /// The index of the body's kind.
    pub kind: usize,
    /// The index of the body's constants in the table of its kind.
    pub row: usize,
    /// The parent; `None` for the world.
    pub parent: Option<usize>,
    /// The index of the body's first entry of q, and the index of its first entry of the other
    /// joint vectors.
    pub starts: [usize; 2],
}
