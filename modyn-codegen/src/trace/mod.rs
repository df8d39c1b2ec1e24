//! The equations run on expressions: one graph a quantity.

use modyn_runtime::Scalar;
use modyn_runtime::equations::brge::{self, Layout};
use modyn_runtime::equations::{
    Partition, Workspace, forward_dynamics, gravity, inverse_dynamics, kinematics, kinetic_energy,
    mass_matrix,
};
use modyn_runtime::model::prepare::Prepared;
use modyn_runtime::spatial::Pose;

use crate::expr::{Expr, Graph};

/// A robot on expressions, ready to be traced.
///
/// Each quantity's inputs are numbered group by group in the order of its parameters.
pub struct Tracer<'a> {
    model: &'a Prepared<f64>,
}

impl<'a> Tracer<'a> {
    /// Traces equations of `model`.
    #[must_use]
    pub fn new(model: &'a Prepared<f64>) -> Self {
        Self { model }
    }

    /// `groups` are the lengths of the inputs.
    fn trace_groups<const G: usize>(
        &self,
        lengths: [usize; G],
        equations: impl FnOnce(&Prepared<Expr>, [Vec<Expr>; G]) -> Vec<Expr>,
    ) -> Graph {
        Graph::trace(|| {
            let model = self.model.cast();
            let mut next = 0;
            let groups = lengths.map(|length| {
                let start = next;
                next += length;
                (start..next).map(Expr::input).collect()
            });
            equations(&model, groups)
        })
    }

    /// All inputs are joint vectors.
    fn trace<const G: usize>(
        &self,
        equations: impl FnOnce(&Prepared<Expr>, [Vec<Expr>; G]) -> Vec<Expr>,
    ) -> Graph {
        self.trace_groups([self.model.bodies.len(); G], equations)
    }

    fn workspace(&self, partition: &Partition) -> Workspace<Expr> {
        Workspace::new(self.model.bodies.len(), partition)
    }

    fn vector(&self) -> Vec<Expr> {
        vec![Expr::zero(); self.model.bodies.len()]
    }

    /// Accelerations from `q`, `qd`, `tau`, eliminated by these modules.
    #[must_use]
    pub fn forward_dynamics(&self, partition: &Partition) -> Graph {
        self.trace(|model, [q, qd, tau]| {
            let mut qdd = self.vector();
            let workspace = &mut self.workspace(partition);
            forward_dynamics::forward_dynamics(
                model,
                partition,
                (&q, &qd, &tau),
                workspace,
                &mut qdd,
            );
            qdd
        })
    }

    /// Torques from `q`, `qd`, `qdd`.
    #[must_use]
    pub fn inverse_dynamics(&self) -> Graph {
        self.trace(|model, [q, qd, qdd]| {
            let mut tau = self.vector();
            let workspace = &mut self.workspace(&Partition::empty());
            inverse_dynamics::inverse_dynamics(model, &q, &qd, Some(&qdd), workspace, &mut tau);
            tau
        })
    }

    /// Bias forces from `q`, `qd`.
    #[must_use]
    pub fn bias_forces(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let mut tau = self.vector();
            let workspace = &mut self.workspace(&Partition::empty());
            inverse_dynamics::inverse_dynamics(model, &q, &qd, None, workspace, &mut tau);
            tau
        })
    }

    /// Gravity torques from `q`.
    #[must_use]
    pub fn gravity_torques(&self) -> Graph {
        self.trace(|model, [q]| {
            let mut tau = self.vector();
            gravity::gravity_torques(model, &q, &mut self.workspace(&Partition::empty()), &mut tau);
            tau
        })
    }

    /// The mass matrix from `q`, column by column.
    #[must_use]
    pub fn mass_matrix(&self) -> Graph {
        self.trace(|model, [q]| {
            let mut columns = vec![Expr::zero(); q.len() * q.len()];
            let workspace = &mut self.workspace(&Partition::empty());
            mass_matrix::mass_matrix(model, &q, workspace, &mut columns);
            columns
        })
    }

    /// The poses of all frames from `q`: each nine numbers of the rotation by rows, then three of
    /// the translation.
    #[must_use]
    pub fn link_poses(&self) -> Graph {
        self.trace(|model, [q]| {
            let workspace = &mut self.workspace(&Partition::empty());
            let mut bodies = vec![Pose::identity(); model.bodies.len()];
            let mut poses = vec![Pose::identity(); model.frames.len()];
            kinematics::link_poses(model, &q, workspace, &mut bodies, &mut poses);
            let numbers = |pose: &Pose<Expr>| [pose.rotation.concat(), pose.translation.to_vec()];
            poses.iter().flat_map(numbers).flatten().collect()
        })
    }

    /// Kinetic energy from `q`, `qd`.
    #[must_use]
    pub fn kinetic_energy(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let workspace = &mut self.workspace(&Partition::empty());
            vec![kinetic_energy::kinetic_energy(model, &q, &qd, workspace)]
        })
    }

    /// Potential energy from `q`.
    #[must_use]
    pub fn potential_energy(&self) -> Graph {
        self.trace(|model, [q]| {
            vec![gravity::potential_energy(model, &q, &mut self.workspace(&Partition::empty()))]
        })
    }

    /// The packed factors of U D U^T from `q`.
    #[must_use]
    pub fn brge(&self, layout: &Layout) -> Graph {
        self.trace(|model, [q]| {
            let mut factors = vec![Expr::zero(); layout.size()];
            let workspace = &mut self.workspace(layout.partition());
            brge::factorize(model, layout, &q, workspace, &mut factors);
            factors
        })
    }

    /// A full matrix, column by column, from the packed factors of U D U^T.
    fn matrix(&self, layout: &Layout, fill: impl FnOnce(&[Expr], &mut [Expr])) -> Graph {
        let n = self.model.bodies.len();
        self.trace_groups([layout.size()], |_, [factors]| {
            let mut columns = vec![Expr::zero(); n * n];
            fill(&factors, &mut columns);
            columns
        })
    }

    /// U from the packed factors.
    #[must_use]
    pub fn u(&self, layout: &Layout) -> Graph {
        self.matrix(layout, |factors, columns| brge::upper(layout, &factors[layout.u()], columns))
    }

    /// D from the packed factors.
    #[must_use]
    pub fn d(&self, layout: &Layout) -> Graph {
        self.matrix(layout, |factors, columns| brge::diagonal(layout, factors, columns))
    }

    /// U^-1 from the packed factors.
    #[must_use]
    pub fn u_inverse(&self, layout: &Layout) -> Graph {
        self.matrix(layout, |factors, columns| {
            brge::upper_inverse(layout, &factors[layout.u()], columns);
        })
    }

    /// D^-1 from the packed factors.
    #[must_use]
    pub fn d_inverse(&self, layout: &Layout) -> Graph {
        self.matrix(layout, |factors, columns| brge::diagonal_inverse(layout, factors, columns))
    }

    /// The inverse from the packed factors.
    #[must_use]
    pub fn inverse(&self, layout: &Layout) -> Graph {
        self.matrix(layout, |factors, columns| brge::inverse(layout, factors, columns))
    }

    /// The solution from the packed factors and `rhs`.
    #[must_use]
    pub fn solve(&self, layout: &Layout) -> Graph {
        self.trace_groups([layout.size(), self.model.bodies.len()], |_, [factors, mut x]| {
            brge::solve(layout, &factors, &mut x);
            x
        })
    }

    /// The logarithm of the determinant from the packed factors.
    #[must_use]
    pub fn log_determinant(&self, layout: &Layout) -> Graph {
        self.trace_groups([layout.size()], |_, [factors]| {
            vec![brge::log_determinant(layout, &factors)]
        })
    }
}
