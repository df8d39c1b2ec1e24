//! Tracing: the equations run on expressions, one graph for each quantity.

mod constraints;
mod coordinates;
mod derivatives;
mod entries;
mod hessians;
mod kinematics;
mod limbs;
mod parameters;
mod products;
mod regressor;
mod step_hessians;
mod steps;

use modyn_runtime::Scalar;
use modyn_runtime::equations::brge::{self, UduLayout};
use modyn_runtime::equations::derivatives::generalized_forces;
use modyn_runtime::equations::dynamics::{
    Elimination, forward_dynamics, gravity_torques, inverse_dynamics, kinetic_energy, mass_matrix,
    potential_energy, recursive_forward_dynamics, recursive_newton_euler,
};
use modyn_runtime::equations::kinematics::{Axes, link_poses};
use modyn_runtime::equations::{Forces, Workspace};
use modyn_runtime::mechanism::{BodyFrame, Mechanism, MergedMechanism};
use modyn_runtime::spatial::{Pose, Wrench};

use crate::graph::{Expr, Graph};

pub use entries::EntryDerivatives;
pub use limbs::LimbPacking;
pub use parameters::Parameters;

fn in_axes(forces: &[Wrench<Expr>], axes: Axes) -> Forces<'_, Expr> {
    match axes {
        Axes::Link => Forces::InLinkAxes(forces),
        Axes::World => Forces::InWorldAxes(forces),
    }
}

/// Returns the wrenches with these numbers, six each.
fn wrenches(numbers: &[Expr]) -> Vec<Wrench<Expr>> {
    let wrench = |six: &[Expr]| Wrench::from_components(std::array::from_fn(|i| six[i]));
    numbers.chunks(6).map(wrench).collect()
}

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
}

/// A link on a body.
#[derive(Clone, Copy, Debug)]
pub enum LinkFrame {
    /// A link with a constant pose.
    Known(BodyFrame<f64>),
    /// A link on this body (or on the world) whose pose there is twelve further inputs: nine numbers of the rotation by
    /// rows, then three of the translation.
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
        Self { model, parameters, limbs: None, columns: 1, link: None }
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
        Self { model: self.model, parameters, limbs: Some(limbs), columns: 1, link: None }
    }

    /// Returns the tracer with derivative columns of consecutive joints in lanes.
    #[must_use]
    pub fn column_lanes(&self) -> Self {
        Self { parameters: self.parameters.clone(), columns: 4, ..Self::new(self.model) }
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

    /// Traces `equations`; `groups` are the lengths of the groups of inputs.
    fn trace_groups<const G: usize>(
        &self,
        lengths: [usize; G],
        equations: impl FnOnce(&Mechanism<Expr>, [Vec<Expr>; G]) -> Vec<Expr>,
    ) -> Graph {
        Graph::trace(|| {
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
        })
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

    /// Traces equations that support merged limbs. The outputs are `vectors` joint vectors, then matrices.
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

    /// Returns the graph of the accelerations, with this solver. Inputs: `q`, `qd`, `tau`.
    #[must_use]
    pub fn forward_dynamics(&self, elimination: &Elimination) -> Graph {
        let Elimination::Recursive(partition) = elimination else {
            return self.trace(|model, [q, qd, tau]| {
                let mut qdd = self.vector();
                let (state, workspace) = ((&*q, &*qd, &*tau), &mut Workspace::new(model));
                forward_dynamics(model, elimination, state, None, workspace, &mut qdd);
                qdd
            });
        };
        self.trace_joints(1, |model, [q, qd, tau]| {
            let mut qdd = vec![Expr::zero(); model.nv()];
            let (state, workspace) = ((&*q, &*qd, &*tau), &mut Workspace::new(model));
            recursive_forward_dynamics(model, partition, state, workspace, &mut qdd);
            qdd
        })
    }

    /// Returns the graph of the joint forces. Inputs: `q`, `qd`, `qdd`.
    #[must_use]
    pub fn inverse_dynamics(&self) -> Graph {
        self.trace_joints(1, |model, [q, qd, qdd]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            let (motion, workspace) = ((&*q, &*qd, Some(&*qdd)), &mut Workspace::new(model));
            recursive_newton_euler(model, motion, workspace, &mut tau);
            tau
        })
    }

    /// Returns the graph of the accelerations under external wrenches. Inputs: `q`, `qd`, `tau`, and six numbers (moment,
    /// force) for each link of the description.
    #[must_use]
    pub fn forward_dynamics_external(&self, elimination: &Elimination, axes: Axes) -> Graph {
        self.with_forces(|model, [q, qd, tau], forces| {
            let mut qdd = self.vector();
            let (state, workspace) = ((q, qd, tau), &mut Workspace::new(model));
            let solve = forward_dynamics;
            solve(model, elimination, state, Some(in_axes(forces, axes)), workspace, &mut qdd);
            qdd
        })
    }

    /// Returns the graph of the joint forces under external wrenches. Inputs: `q`, `qd`, `qdd`, and six numbers for each
    /// link of the description.
    #[must_use]
    pub fn inverse_dynamics_external(&self, axes: Axes) -> Graph {
        self.with_forces(|model, [q, qd, qdd], forces| {
            let mut tau = self.vector();
            let (motion, workspace) = ((q, qd, Some(qdd)), &mut Workspace::new(model));
            let forces = Some(in_axes(forces, axes));
            inverse_dynamics(model, motion, forces, workspace, &mut tau);
            tau
        })
    }

    /// Returns the graph of the generalized forces of external wrenches, and of their derivatives by q, by columns. Inputs:
    /// `q`, and six numbers (moment, force) for each link of the description.
    #[must_use]
    pub fn generalized_forces(&self, axes: Axes) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, 6 * self.model.frames.len()], |model, [q, forces]| {
            let (forces, workspace) = (wrenches(&forces), &mut Workspace::new(model));
            let (mut tau, mut dq) = (self.vector(), vec![Expr::zero(); nv * nv]);
            let motion = (&*q, in_axes(&forces, axes));
            generalized_forces(model, motion, workspace, (&mut tau, &mut dq));
            [tau, dq].concat()
        })
    }

    fn with_forces(
        &self,
        equations: impl FnOnce(&Mechanism<Expr>, [&[Expr]; 3], &[Wrench<Expr>]) -> Vec<Expr>,
    ) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, 6 * self.model.frames.len()], |model, [q, a, b, forces]| {
            equations(model, [&q, &a, &b], &wrenches(&forces))
        })
    }

    /// Returns the graph of the bias forces. Inputs: `q`, `qd`.
    #[must_use]
    pub fn bias_forces(&self) -> Graph {
        self.trace_joints(1, |model, [q, qd]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            let (motion, workspace) = ((&*q, &*qd, None), &mut Workspace::new(model));
            recursive_newton_euler(model, motion, workspace, &mut tau);
            tau
        })
    }

    /// Returns the graph of the gravity torques. Inputs: `q`.
    #[must_use]
    pub fn gravity_torques(&self) -> Graph {
        self.trace_joints(1, |model, [q]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            gravity_torques(model, &q, &mut Workspace::new(model), &mut tau);
            tau
        })
    }

    /// Returns the graph of the mass matrix by columns. Inputs: `q`.
    #[must_use]
    pub fn mass_matrix(&self) -> Graph {
        self.trace_joints(0, |model, [q]| {
            let mut columns = vec![Expr::zero(); model.nv() * model.nv()];
            let workspace = &mut Workspace::new(model);
            mass_matrix(model, &q, workspace, &mut columns);
            columns
        })
    }

    /// Returns the graph of the poses of all frames: each nine numbers of the rotation by rows, then three of the
    /// translation. Inputs: `q`.
    #[must_use]
    pub fn link_poses(&self) -> Graph {
        self.trace(|model, [q]| {
            let workspace = &mut Workspace::new(model);
            let mut bodies = vec![Pose::identity(); model.bodies.len()];
            let mut poses = vec![Pose::identity(); model.frames.len()];
            link_poses(model, &q, workspace, &mut bodies, &mut poses);
            poses.iter().flat_map(kinematics::numbers).collect()
        })
    }

    /// Returns the graph of the kinetic energy. Inputs: `q`, `qd`.
    #[must_use]
    pub fn kinetic_energy(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let workspace = &mut Workspace::new(model);
            vec![kinetic_energy(model, &q, &qd, workspace)]
        })
    }

    /// Returns the graph of the potential energy. Inputs: `q`.
    #[must_use]
    pub fn potential_energy(&self) -> Graph {
        self.trace(|model, [q]| vec![potential_energy(model, &q, &mut Workspace::new(model))])
    }

    /// Returns the graph of the packed factors of U D U^T. Inputs: `q`.
    #[must_use]
    pub fn brge(&self, layout: &UduLayout) -> Graph {
        self.trace(|model, [q]| {
            let mut factors = vec![Expr::zero(); layout.size()];
            let workspace = &mut Workspace::new(model);
            brge::factorize(model, layout, &q, workspace, &mut factors);
            factors
        })
    }

    /// Returns the graph of a full matrix by columns. Inputs: the packed factors.
    fn matrix(&self, layout: &UduLayout, fill: impl FnOnce(&[Expr], &mut [Expr])) -> Graph {
        let n = self.model.nv;
        self.trace_groups([layout.size()], |_, [factors]| {
            let mut columns = vec![Expr::zero(); n * n];
            fill(&factors, &mut columns);
            columns
        })
    }

    /// Returns the graph of U. Inputs: the packed factors.
    #[must_use]
    pub fn u(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::upper(layout, &factors[layout.u()], columns))
    }

    /// Returns the graph of D. Inputs: the packed factors.
    #[must_use]
    pub fn d(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::diagonal(layout, factors, columns))
    }

    /// Returns the graph of U^-1. Inputs: the packed factors.
    #[must_use]
    pub fn u_inverse(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| {
            brge::upper_inverse(layout, &factors[layout.u()], columns);
        })
    }

    /// Returns the graph of D^-1. Inputs: the packed factors.
    #[must_use]
    pub fn d_inverse(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::diagonal_inverse(layout, factors, columns))
    }

    /// Returns the graph of the inverse of the mass matrix. Inputs: the packed factors.
    #[must_use]
    pub fn inverse(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::inverse(layout, factors, columns))
    }

    /// Returns the graph of the solution. Inputs: the packed factors and `rhs`.
    #[must_use]
    pub fn solve(&self, layout: &UduLayout) -> Graph {
        self.trace_groups([layout.size(), self.model.nv], |_, [factors, mut x]| {
            brge::solve(layout, &factors, &mut x);
            x
        })
    }

    /// Returns the graph of the logarithm of the determinant. Inputs: the packed factors.
    #[must_use]
    pub fn log_determinant(&self, layout: &UduLayout) -> Graph {
        self.trace_groups([layout.size()], |_, [factors]| {
            vec![brge::log_determinant(layout, &factors)]
        })
    }
}
