//! The equations run on expressions: one graph a quantity.

mod constraints;
mod coordinates;
mod derivatives;
mod kinematics;
mod limbs;
mod parameters;
mod regressor;

use modyn_runtime::Scalar;
use modyn_runtime::equations::brge::{self, UduLayout};
use modyn_runtime::equations::dynamics::{
    Elimination, forward_dynamics, gravity_torques, inverse_dynamics, kinetic_energy, mass_matrix,
    potential_energy, recursive_forward_dynamics, recursive_newton_euler,
};
use modyn_runtime::equations::kinematics::{Axes, link_poses};
use modyn_runtime::equations::{Forces, Workspace};
use modyn_runtime::mechanism::{BodyFrame, Mechanism, MergedMechanism};
use modyn_runtime::spatial::{Pose, Wrench};

use crate::graph::{Expr, Graph};

pub use limbs::LimbPacking;
pub use parameters::Parameters;

fn in_axes(forces: &[Wrench<Expr>], axes: Axes) -> Forces<'_, Expr> {
    match axes {
        Axes::Link => Forces::InLinkAxes(forces),
        Axes::World => Forces::InWorldAxes(forces),
    }
}

/// A robot on expressions, ready to be traced.
///
/// Each quantity's inputs are numbered group by group in the order of its parameters.
#[derive(Clone)]
pub struct Tracer<'a> {
    model: &'a Mechanism<f64>,
    parameters: Parameters,
    /// Equal limbs that are computed side by side.
    limbs: Option<&'a LimbPacking>,
    /// How many columns of derivatives are.
    columns: usize,
    /// The one link of a model that has none.
    link: Option<LinkFrame>,
}

/// A link that is fixed to a body.
#[derive(Clone, Copy, Debug)]
pub enum LinkFrame {
    /// Where it is known.
    Known(BodyFrame<f64>),
    /// On this body, or on the world; its pose there is twelve further inputs: nine numbers of the rotation
    /// by rows, then three of the translation.
    On(Option<usize>),
}

impl LinkFrame {
    /// The link, with inputs from `next` on, of which it takes those that it needs.
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
    /// Traces equations of `model`, of which everything is known.
    #[must_use]
    pub fn new(model: &'a Mechanism<f64>) -> Self {
        Self::with_parameters(model, Parameters::default())
    }

    /// Traces equations of `model`; `parameters` are further inputs, behind all others.
    #[must_use]
    pub fn with_parameters(model: &'a Mechanism<f64>, parameters: Parameters) -> Self {
        Self { model, parameters, limbs: None, columns: 1, link: None }
    }

    /// Traces equations of `model`, which has no links, with this one in their place.
    #[must_use]
    pub fn with_link(model: &'a Mechanism<f64>, link: LinkFrame) -> Self {
        Self { link: Some(link), ..Self::new(model) }
    }

    /// The same with equal limbs side by side. What is known of single links at run time only can't be.
    #[must_use]
    pub fn packed(&self, limbs: &'a LimbPacking) -> Self {
        let parameters = self.parameters.without_inertias();
        Self { model: self.model, parameters, limbs: Some(limbs), columns: 1, link: None }
    }

    /// The same with columns of derivatives side by side, of joints one behind the other.
    #[must_use]
    pub fn column_lanes(&self) -> Self {
        Self { parameters: self.parameters.clone(), columns: 4, ..Self::new(self.model) }
    }

    /// The robot.
    pub(crate) fn model(&self) -> &Mechanism<f64> {
        self.model
    }

    /// What of the model is an input.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// `groups` are the lengths of the inputs.
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

    /// The inputs are coordinates, then vectors of velocities or the like.
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

    /// The same, for what equal limbs can be computed side by side: so many joint vectors, then matrices.
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

    /// The robot with its limbs as they are.
    fn with_column_lanes(&self, model: &Mechanism<Expr>) -> MergedMechanism<Expr> {
        MergedMechanism::with_column_lanes(model.clone(), self.columns)
    }

    /// The same, for equations of equal limbs side by side that take their lanes apart.
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

    /// Accelerations from `q`, `qd`, `tau`, eliminated by these modules.
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

    /// Torques from `q`, `qd`, `qdd`.
    #[must_use]
    pub fn inverse_dynamics(&self) -> Graph {
        self.trace_joints(1, |model, [q, qd, qdd]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            let (motion, workspace) = ((&*q, &*qd, Some(&*qdd)), &mut Workspace::new(model));
            recursive_newton_euler(model, motion, workspace, &mut tau);
            tau
        })
    }

    /// Accelerations from `q`, `qd`, `tau` and six numbers (moment, force) a link of the
    /// description.
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

    /// Torques from `q`, `qd`, `qdd` and six numbers a link of the description.
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

    fn with_forces(
        &self,
        equations: impl FnOnce(&Mechanism<Expr>, [&[Expr]; 3], &[Wrench<Expr>]) -> Vec<Expr>,
    ) -> Graph {
        let (nq, nv) = (self.model.nq, self.model.nv);
        self.trace_groups([nq, nv, nv, 6 * self.model.frames.len()], |model, [q, a, b, forces]| {
            let wrench = |six: &[Expr]| Wrench::from_components(std::array::from_fn(|i| six[i]));
            let forces: Vec<_> = forces.chunks(6).map(wrench).collect();
            equations(model, [&q, &a, &b], &forces)
        })
    }

    /// Bias forces from `q`, `qd`.
    #[must_use]
    pub fn bias_forces(&self) -> Graph {
        self.trace_joints(1, |model, [q, qd]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            let (motion, workspace) = ((&*q, &*qd, None), &mut Workspace::new(model));
            recursive_newton_euler(model, motion, workspace, &mut tau);
            tau
        })
    }

    /// Gravity torques from `q`.
    #[must_use]
    pub fn gravity_torques(&self) -> Graph {
        self.trace_joints(1, |model, [q]| {
            let mut tau = vec![Expr::zero(); model.nv()];
            gravity_torques(model, &q, &mut Workspace::new(model), &mut tau);
            tau
        })
    }

    /// The mass matrix from `q`, column by column.
    #[must_use]
    pub fn mass_matrix(&self) -> Graph {
        self.trace_joints(0, |model, [q]| {
            let mut columns = vec![Expr::zero(); model.nv() * model.nv()];
            let workspace = &mut Workspace::new(model);
            mass_matrix(model, &q, workspace, &mut columns);
            columns
        })
    }

    /// The poses of all frames from `q`: each nine numbers of the rotation by rows, then three of
    /// the translation.
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

    /// Kinetic energy from `q`, `qd`.
    #[must_use]
    pub fn kinetic_energy(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let workspace = &mut Workspace::new(model);
            vec![kinetic_energy(model, &q, &qd, workspace)]
        })
    }

    /// Potential energy from `q`.
    #[must_use]
    pub fn potential_energy(&self) -> Graph {
        self.trace(|model, [q]| vec![potential_energy(model, &q, &mut Workspace::new(model))])
    }

    /// The packed factors of U D U^T from `q`.
    #[must_use]
    pub fn brge(&self, layout: &UduLayout) -> Graph {
        self.trace(|model, [q]| {
            let mut factors = vec![Expr::zero(); layout.size()];
            let workspace = &mut Workspace::new(model);
            brge::factorize(model, layout, &q, workspace, &mut factors);
            factors
        })
    }

    /// A full matrix, column by column, from the packed factors of U D U^T.
    fn matrix(&self, layout: &UduLayout, fill: impl FnOnce(&[Expr], &mut [Expr])) -> Graph {
        let n = self.model.nv;
        self.trace_groups([layout.size()], |_, [factors]| {
            let mut columns = vec![Expr::zero(); n * n];
            fill(&factors, &mut columns);
            columns
        })
    }

    /// U from the packed factors.
    #[must_use]
    pub fn u(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::upper(layout, &factors[layout.u()], columns))
    }

    /// D from the packed factors.
    #[must_use]
    pub fn d(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::diagonal(layout, factors, columns))
    }

    /// U^-1 from the packed factors.
    #[must_use]
    pub fn u_inverse(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| {
            brge::upper_inverse(layout, &factors[layout.u()], columns);
        })
    }

    /// D^-1 from the packed factors.
    #[must_use]
    pub fn d_inverse(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::diagonal_inverse(layout, factors, columns))
    }

    /// The inverse from the packed factors.
    #[must_use]
    pub fn inverse(&self, layout: &UduLayout) -> Graph {
        self.matrix(layout, |factors, columns| brge::inverse(layout, factors, columns))
    }

    /// The solution from the packed factors and `rhs`.
    #[must_use]
    pub fn solve(&self, layout: &UduLayout) -> Graph {
        self.trace_groups([layout.size(), self.model.nv], |_, [factors, mut x]| {
            brge::solve(layout, &factors, &mut x);
            x
        })
    }

    /// The logarithm of the determinant from the packed factors.
    #[must_use]
    pub fn log_determinant(&self, layout: &UduLayout) -> Graph {
        self.trace_groups([layout.size()], |_, [factors]| {
            vec![brge::log_determinant(layout, &factors)]
        })
    }
}
