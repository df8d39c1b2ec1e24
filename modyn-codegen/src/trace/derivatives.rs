//! The graphs of the derivatives of inverse and forward dynamics.

use modyn_runtime::Scalar;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::derivatives::{self, ForwardDerivatives};
use modyn_runtime::equations::factorization::{MergedUduLayout, cross_limb};
use modyn_runtime::equations::{ForwardInput, Motion, Workspace};
use modyn_runtime::mechanism::MergedMechanism;

use super::Tracer;
use crate::graph::dense::{ProductForm, ProductTarget};
use crate::graph::{Expr, Graph};

impl Tracer<'_> {
    /// Returns the graph of the derivatives of the joint forces: by q, then by qd, by columns.
    /// Inputs: `q`, `qd`, `qdd`.
    #[must_use]
    pub fn inverse_dynamics_derivatives(&self) -> Graph {
        self.trace_joints(0, |model, [q, qd, qdd]| {
            let mut dq = square(model);
            let mut dqd = square(model);
            let motion = Motion { q: &q, qd: &qd, qdd: &qdd };
            let workspace = &mut Workspace::new(model);
            let derive = derivatives::inverse_dynamics_derivatives;
            derive(model, motion, workspace, &mut dq, &mut dqd);
            [dq, dqd].concat()
        })
    }

    /// Returns the graph of the accelerations and their derivatives by q, qd and tau, by columns.
    /// Inputs: `q`, `qd`, `tau`. The mass matrix is factorized with `layout`.
    #[must_use]
    pub fn forward_dynamics_derivatives(&self, layout: &UduLayout) -> Graph {
        if self.loops.products {
            return self.forward_dynamics_derivatives_by_products(layout);
        }
        let Some(limbs) = self.limbs else {
            return self.trace(|model, state| {
                let model = &self.with_column_lanes(model);
                let layout = &MergedUduLayout::new(model, layout.clone());
                derive(model, layout, state, &mut Workspace::new(model)).concat()
            });
        };
        self.trace_lanes(limbs, |model, state| {
            let layout = MergedUduLayout::by_modules(model, limbs.partition(layout.partition()));
            let workspace = &mut Workspace::new(model);
            let [qdd, dq, dqd, dtau] = derive(model, &layout, state, workspace);
            let [q, qd, tau] = [&dq, &dqd, &dtau].map(|x| cross_limb(model, &layout, workspace, x));
            let matrices = [
                limbs.unpack_coupled(&dq, &q),
                limbs.unpack_coupled(&dqd, &qd),
                limbs.unpack_symmetric(&dtau, &tau),
            ];
            [limbs.unpack_vector(&qdd, self.model.nv), matrices.concat()].concat()
        })
    }

    /// Leaves the derivatives by q and qd to products with the inverse of the mass matrix, which are
    /// added to the derivatives of free fall.
    fn forward_dynamics_derivatives_by_products(&self, layout: &UduLayout) -> Graph {
        let n = self.model.nv;
        let mut graph = match self.limbs {
            None => self.trace(|model, state| {
                let model = &self.with_column_lanes(model);
                let layout = &MergedUduLayout::new(model, layout.clone());
                let ([qdd, dq, dqd, dtau], free_fall) =
                    derive_factors(model, layout, state, &mut Workspace::new(model));
                [qdd, free_fall.concat(), dtau.clone(), dtau, dq, dqd].concat()
            }),
            Some(limbs) => self.trace_lanes(limbs, |model, state| {
                let modules = limbs.partition(layout.partition());
                let layout = MergedUduLayout::by_modules(model, modules);
                let workspace = &mut Workspace::new(model);
                let ([qdd, dq, dqd, dtau], free_fall) =
                    derive_factors(model, &layout, state, workspace);
                let tau = cross_limb(model, &layout, workspace, &dtau);
                // Derivatives of inverse dynamics and of free fall are zero between limbs.
                let sparse = |x: Vec<Expr>| limbs.unpack_matrix(&x, n);
                let [fall_dq, fall_dqd] = free_fall.map(sparse);
                let dtau = limbs.unpack_symmetric(&dtau, &tau);
                let qdd = limbs.unpack_vector(&qdd, n);
                [qdd, fall_dq, fall_dqd, dtau.clone(), dtau, sparse(dq), sparse(dqd)].concat()
            }),
        };
        let targets =
            [0, 1].map(|matrix| vec![ProductTarget::square(n + matrix * n * n, n)]).to_vec();
        let form = ProductForm { rows: n, terms: n, results: n + 3 * n * n, targets };
        graph.dense.products = Some(form);
        graph
    }
}

/// Returns the accelerations and their derivatives from `q`, `qd`, `tau`.
fn derive(
    model: &MergedMechanism<Expr>,
    layout: &MergedUduLayout,
    [q, qd, tau]: [Vec<Expr>; 3],
    workspace: &mut Workspace<Expr>,
) -> [Vec<Expr>; 4] {
    results(model, |outputs| {
        let input = ForwardInput { q: &q, qd: &qd, tau: &tau };
        derivatives::forward_dynamics_derivatives(model, layout, input, workspace, outputs);
    })
}

/// Returns the accelerations, the matrices that the inverse of the mass matrix multiplies in
/// derivatives by `q` and `qd`, that inverse, and the derivatives of free fall by `q` and `qd`.
fn derive_factors(
    model: &MergedMechanism<Expr>,
    layout: &MergedUduLayout,
    [q, qd, tau]: [Vec<Expr>; 3],
    workspace: &mut Workspace<Expr>,
) -> ([Vec<Expr>; 4], [Vec<Expr>; 2]) {
    let mut free_fall = [square(model), square(model)];
    let results = results(model, |mut outputs| {
        let input = ForwardInput { q: &q, qd: &qd, tau: &tau };
        derivatives::forward_dynamics_factors(model, layout, input, workspace, &mut outputs);
        let [dq, dqd] = &mut free_fall;
        derivatives::add_free_fall(model, &qd, workspace, outputs.qdd, dq, dqd);
    });
    (results, free_fall)
}

/// Returns the accelerations and the three matrices that `compute` writes.
fn results(
    model: &MergedMechanism<Expr>,
    compute: impl FnOnce(ForwardDerivatives<'_, Expr>),
) -> [Vec<Expr>; 4] {
    let mut qdd = vec![Expr::zero(); model.nv()];
    let mut dq = square(model);
    let mut dqd = square(model);
    let mut dtau = square(model);
    compute(ForwardDerivatives {
        qdd: &mut qdd,
        dqdd_dq: &mut dq,
        dqdd_dqd: &mut dqd,
        dqdd_dtau: &mut dtau,
    });
    [qdd, dq, dqd, dtau]
}

/// Returns memory for an nv x nv matrix.
fn square(model: &MergedMechanism<Expr>) -> Vec<Expr> {
    vec![Expr::zero(); model.nv() * model.nv()]
}
