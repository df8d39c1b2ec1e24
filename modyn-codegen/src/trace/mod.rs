//! Tracing: the equations run on expressions, one graph for each quantity. The tracer is here; its
//! graphs are in the files of this folder, by groups of quantities.

mod composition;
mod constraint_hessians;
mod constraints;
mod coordinates;
mod derivatives;
mod dynamics;
mod entries;
mod evaluation;
mod factorization;
mod hessians;
mod kinematics;
mod knots;
mod limb_products;
pub(crate) mod limbs;
mod looped;
mod merge;
mod parameters;
mod products;
mod soft_steps;
mod step_hessians;
mod step_products;
mod steps;
mod tangent;
mod user;

use modyn_runtime::Scalar;
use modyn_runtime::mechanism::{BodyFrame, Mechanism, MergedMechanism};

use crate::graph::{Expr, ForeignExpr, Graph};

pub use entries::{EntryDerivatives, EntryForm, Gains, second_derivatives};
pub use evaluation::Solvers;
pub use limbs::{LimbLimits, LimbPacking};
pub use parameters::Parameters;
pub use soft_steps::{DerivativeForm, Drive, EliminationOf};
pub use step_products::StepProduct;
pub use tangent::{TangentGraphs, TangentInput};
pub use user::{UserGraphs, UserTraceError};

/// A robot on expressions, whose equations can be traced.
///
/// The inputs of a graph are numbered in the order of the quantity's parameters.
#[derive(Clone)]
pub struct Tracer<'a> {
    model: &'a Mechanism<f64>,
    parameters: Parameters,
    /// The limbs to merge.
    limbs: Option<&'a LimbPacking>,
    /// The number of derivative columns that are computed at a time.
    columns: usize,
    /// The single link that replaces the model's links.
    link: Option<LinkFrame>,
    /// The parts of functions that graphs leave to loops.
    loops: DenseLoops,
}

/// The dense parts of functions that graphs leave to loops, where a function has them.
#[derive(Clone, Copy, Debug, Default)]
pub struct DenseLoops {
    /// Equations of dependent constraint rows: the first input that is one of their results, after
    /// the arguments. The graph itself solves independent rows only.
    pub rows: Option<usize>,
    /// Products of matrices.
    pub products: bool,
}

/// A link on a body.
#[derive(Clone, Copy, Debug)]
pub enum LinkFrame {
    /// A link with a constant pose.
    Known(BodyFrame<f64>),
    /// A link on this body (or on the world) whose pose there is twelve further inputs: nine
    /// numbers of the rotation by rows, then three of the translation.
    On(Option<usize>),
}

impl LinkFrame {
    /// Returns the link; takes the inputs from `next` on that it needs.
    fn enter(self, next: &mut usize) -> BodyFrame<Expr> {
        match self {
            Self::Known(BodyFrame { body, pose }) => {
                BodyFrame { body, pose: pose.map(Expr::from_f64) }
            }
            Self::On(body) => BodyFrame { body, pose: kinematics::pose_input(next) },
        }
    }
}

impl<'a> Tracer<'a> {
    /// Returns the tracer of `model`, without run-time parameters.
    #[must_use]
    pub fn new(model: &'a Mechanism<f64>) -> Self {
        Self::with_parameters(model, Parameters::default())
    }

    /// Returns the tracer of `model`; `parameters` are further inputs, after all others.
    #[must_use]
    pub fn with_parameters(model: &'a Mechanism<f64>, parameters: Parameters) -> Self {
        Self {
            model,
            parameters,
            limbs: None,
            columns: 1,
            link: None,
            loops: DenseLoops::default(),
        }
    }

    /// Returns the tracer of `model`, which must have no links, with `link` as its single link.
    #[must_use]
    pub fn with_link(model: &'a Mechanism<f64>, link: LinkFrame) -> Self {
        Self { link: Some(link), ..Self::new(model) }
    }

    /// Returns the tracer with merged limbs. Links with run-time inertias cannot be merged.
    #[must_use]
    pub fn packed(&self, limbs: &'a LimbPacking) -> Self {
        let parameters = self.parameters.without_inertias();
        Self { limbs: Some(limbs), ..Self::with_parameters(self.model, parameters) }
    }

    /// Returns the tracer with the derivative columns of this number of consecutive joints in
    /// lanes.
    #[must_use]
    pub fn column_lanes(&self, columns: usize) -> Self {
        Self { parameters: self.parameters.clone(), columns, ..Self::new(self.model) }
    }

    /// Returns the tracer whose graphs leave these parts to loops.
    #[must_use]
    pub fn with_loops(&self, loops: DenseLoops) -> Self {
        Self { loops, ..self.clone() }
    }

    /// Returns the robot.
    pub(crate) fn model(&self) -> &Mechanism<f64> {
        self.model
    }

    /// Returns the run-time parameters.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Traces `equations` over groups of inputs of these lengths.
    fn trace_groups<const G: usize>(
        &self,
        lengths: [usize; G],
        equations: impl FnOnce(&Mechanism<Expr>, [Vec<Expr>; G]) -> Vec<Expr>,
    ) -> Graph {
        Graph::trace(|| self.on_inputs(lengths, equations))
    }

    /// Traces equations that are not modyn's own over groups of inputs of these lengths.
    fn try_trace_groups<const G: usize>(
        &self,
        lengths: [usize; G],
        equations: impl FnOnce(&Mechanism<Expr>, [Vec<Expr>; G]) -> Vec<Expr>,
    ) -> Result<Graph, ForeignExpr> {
        Graph::try_trace(|| self.on_inputs(lengths, equations))
    }

    /// Runs equations on groups of inputs of these lengths, within a trace.
    fn on_inputs<const G: usize>(
        &self,
        lengths: [usize; G],
        equations: impl FnOnce(&Mechanism<Expr>, [Vec<Expr>; G]) -> Vec<Expr>,
    ) -> Vec<Expr> {
        let mut model = self.model.cast();
        let mut next = 0;
        let groups = lengths.map(|length| {
            let start = next;
            next += length;
            (start..next).map(Expr::input).collect()
        });
        model.frames.extend(self.link.map(|link| link.enter(&mut next)));
        self.parameters.enter(next, &mut model);
        equations(&model, groups)
    }

    /// Traces equations whose inputs are coordinates, then joint vectors.
    pub(super) fn trace<const G: usize>(
        &self,
        equations: impl FnOnce(&Mechanism<Expr>, [Vec<Expr>; G]) -> Vec<Expr>,
    ) -> Graph {
        let mut lengths = [self.model.nv; G];
        lengths[0] = self.model.nq;
        self.trace_groups(lengths, equations)
    }

    pub(super) fn vector(&self) -> Vec<Expr> {
        vec![Expr::zero(); self.model.nv]
    }

    /// Traces equations that support merged limbs. The outputs are `vectors` joint vectors, then
    /// matrices.
    fn trace_joints<const G: usize>(
        &self,
        vectors: usize,
        equations: impl FnOnce(&MergedMechanism<Expr>, [Vec<Expr>; G]) -> Vec<Expr>,
    ) -> Graph {
        let Some(limbs) = self.limbs else {
            return self.trace(|model, groups| equations(&self.with_column_lanes(model), groups));
        };
        let nv = self.model.nv;
        self.trace_lanes(limbs, |model, groups| {
            let n = model.nv();
            let computed = equations(model, groups);
            let (first, rest) = computed.split_at(vectors * n);
            let first = first.chunks(n).flat_map(|x| limbs.unpack_vector(x, nv));
            let rest = rest.chunks(n * n).flat_map(|x| limbs.unpack_matrix(x, nv));
            first.chain(rest).collect()
        })
    }

    /// Returns the robot with unmerged limbs.
    fn with_column_lanes(&self, model: &Mechanism<Expr>) -> MergedMechanism<Expr> {
        MergedMechanism::with_column_lanes(model.clone(), self.columns)
    }

    /// Traces equations that support merged limbs and unpack their lanes themselves.
    fn trace_lanes<const G: usize>(
        &self,
        limbs: &LimbPacking,
        equations: impl FnOnce(&MergedMechanism<Expr>, [Vec<Expr>; G]) -> Vec<Expr>,
    ) -> Graph {
        self.trace(|whole, groups| {
            let model = limbs.merged(self.model, whole.gravity);
            let mut place = 0..;
            let groups = groups.map(|group| match place.next() {
                Some(0) => limbs.coordinates(&group),
                _ => limbs.vector(&group),
            });
            equations(&model, groups)
        })
    }
}
