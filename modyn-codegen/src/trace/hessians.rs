//! The graphs of contracted Hessians: of w^T tau of inverse dynamics, and of w^T qdd of forward
//! dynamics.
//!
//! The graph of a gradient, in reverse mode, is differentiated in forward mode along unit
//! displacements. Hessians of forward dynamics go through inverse dynamics ID, as its gradients do.
//! With the mass matrix M, mu = M^-1 w, the Hessian Phi of mu^T ID at constant mu, and B = Phi_{q
//! qdd} M^-1:
//!
//! ```text
//! H_{q q}   = B ID_q + (B ID_q)^T - Phi_{q q}        H_{q tau} = -B
//! H_{q qd}  = B ID_qd - Phi_{q qd}                   H_{qd tau} = H_{tau tau} = 0
//! H_{qd qd} = -Phi_{qd qd}
//! ```
//!
//! All products with M^-1 = U^-T D^-1 U^-1 keep the zeros of U and D, which the branches of a robot
//! have.
//!
//! With equal limbs in lanes, a displacement of a joint of each limb is a lane, too
//! (`passes/directions.rs`), and so are the products (`limb_products.rs`). Without equal limbs,
//! lanes are consecutive displacements and columns.
//!
//! The pose and the linear velocity of a floating base have no effect on the motion relative to
//! free fall. So forward dynamics is differentiated with its bases in neutral poses without linear
//! velocities, and the free fall is added.
//!
//! # Beside the generic Hessian
//!
//! [`TangentGraphs`](super::TangentGraphs) differentiates any graph twice. Operations on scalars of
//! its Hessians, divided by the operations of the Hessians here (in parentheses), for an arm of 7
//! joints, a quadruped and a humanoid, both with floating bases:
//!
//! | Hessian | arm | quadruped | humanoid |
//! |---|---|---|---|
//! | forward dynamics | 1.55 (12,052) | 2.40 (23,272) | 2.43 (145,564) |
//! | semi-implicit step | 1.55 (12,114) | 2.52 (46,450) | 2.62 (220,346) |
//! | constrained forward dynamics, four contacts | | 5.03 (116,048) | |
//! | inverse dynamics | 1.00 (7,538) | 1.00 (9,672) | 1.00 (62,690) |
//!
//! The Hessian of inverse dynamics has the same operations both ways, but here lanes share them:
//! 4,245 for the arm, 2,784 for the quadruped and 25,992 for the humanoid, 1.8 to 3.5 times fewer.

use std::collections::BTreeMap;
use std::ops::Range;

use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::{free_bases, free_fall_accelerations};
use modyn_runtime::equations::{State, Workspace};

use super::Tracer;
use super::composition::Composition;
use super::limb_products::LimbMatrices;
use super::products::WeightedInverseDynamics;
use crate::graph::dense::{ProductForm, ProductTarget};
use crate::graph::{Graph, Id};
use crate::passes::{Directional, Displacement, along_directions, jvp, optimize};

/// The variables of a Hessian. A variable has an entry for each velocity.
const Q: usize = 0;
const QD: usize = 1;
const QDD: usize = 2;

/// An entry of a variable.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    variable: usize,
    index: usize,
}

/// Returns all entries of a variable.
fn entries_of(variable: usize, nv: usize) -> impl Iterator<Item = Entry> {
    (0..nv).map(move |index| Entry { variable, index })
}

/// Second derivatives of a weighted sum, as far as they have been computed.
struct Hessian {
    /// The gradient.
    gradient: Graph,
    /// The changes of the gradient.
    changes: Graph,
    /// The outputs of `changes`: nv entries for each variable.
    outputs: Vec<Id>,
    /// The inputs of the gradient.
    point: Vec<Id>,
    nv: usize,
    /// The changes of gradient entries (second) along unit displacements (first).
    found: BTreeMap<(Entry, Entry), Id>,
}

impl Hessian {
    /// Returns the Hessian of a function of q and `vectors` joint vectors, without any entries yet.
    /// `gradient` is the graph that [`Tracer::gradient`] returns, and `point` are its inputs, q
    /// first.
    fn new(tracer: &Tracer<'_>, gradient: Graph, vectors: usize, point: Vec<Id>) -> Self {
        let gradient = optimize(gradient);
        let changes = jvp(&gradient, point.len(), tracer.state(vectors));
        let outputs = changes.outputs.clone();
        Self { gradient, changes, outputs, point, nv: tracer.model.nv, found: BTreeMap::new() }
    }

    /// Computes the changes of some entries of the gradient along unit displacements of one joint
    /// of each limb, of which each is a lane. Returns whether that is possible: each displacement
    /// changes its own limb and the trunk alone.
    fn differentiate_limbs(
        &mut self,
        tracer: &Tracer<'_>,
        all: &mut Composition,
        displacements: &[Option<(Entry, Vec<Entry>)>],
    ) -> bool {
        let nq = tracer.model.nq;
        // On numbers of its own: among the composition's, the accelerations are functions of q.
        let mut subgraph = Composition::new();
        let inputs = subgraph.inputs(self.point.len());
        let mut point = inputs.clone();
        for (own_input, given) in point.iter_mut().zip(&self.point) {
            if let Some(value) = all.graph.value(*given) {
                *own_input = subgraph.constant(value);
            }
        }
        let parameters: Vec<Id> = point[point.len() - tracer.parameters.len()..].to_vec();
        let rates = tracer.velocity_to_qdot();
        let mut moved = Vec::new();
        for (direction, displacement) in (0..).zip(displacements) {
            let Some((Entry { variable, index }, _)) = *displacement else { continue };
            let one = subgraph.constant(1.0);
            if variable != Q {
                let input = nq + (variable - 1) * self.nv + index;
                moved.push(Displacement { input, direction, change: one });
                continue;
            }
            let unit = subgraph.graph.unit_vector(self.nv, index);
            let dq = subgraph.add(&rates, &[&point[..nq], &unit, &parameters]);
            let entries = dq.iter().enumerate();
            let changes = entries.filter(|&(_, &change)| subgraph.graph.value(change) != Some(0.0));
            moved.extend(changes.map(|(input, &change)| Displacement { input, direction, change }));
        }
        let mut entries: Vec<Entry> = Vec::new();
        for entry in displacements.iter().flatten().flat_map(|(_, entries)| entries) {
            if !entries.contains(entry) {
                entries.push(*entry);
            }
        }
        let outputs = subgraph.add(&self.gradient, &[&point]);
        subgraph.graph.outputs =
            entries.iter().map(|entry| outputs[entry.variable * self.nv + entry.index]).collect();
        let Some(Directional { graph, changes }) = along_directions(&subgraph.graph, &moved) else {
            return false;
        };
        let packs = all.add(&graph, &[&self.point]);
        for (lane, displacement) in displacements.iter().enumerate() {
            let Some((along, wanted)) = displacement else { continue };
            for (entry, terms) in entries.iter().zip(&changes).filter(|(e, _)| wanted.contains(e)) {
                let along_lane = terms.iter().filter(|&&(_, lanes)| lanes >> lane & 1 == 1);
                let terms: Vec<Id> =
                    along_lane.map(|&(pack, _)| all.lane(packs[pack], lane)).collect();
                if !terms.is_empty() {
                    let change = all.graph.pairwise_sum(&terms);
                    self.found.insert((*along, *entry), change);
                }
            }
        }
        true
    }

    /// Computes the changes of some entries of the gradient along unit displacements, each in a
    /// lane.
    fn differentiate(
        &mut self,
        tracer: &Tracer<'_>,
        all: &mut Composition,
        displacements: &[(Entry, Vec<Entry>)],
    ) {
        let nq = tracer.model.nq;
        let nv = self.nv;
        let zero = all.constant(0.0);
        let one = all.constant(1.0);
        let of_outputs = (0..self.outputs.len()).map(|entry| {
            let is_along = |(along, _): &(Entry, _)| entry == along.variable * nv + along.index;
            let lanes =
                displacements.iter().map(|one_of| if is_along(one_of) { one } else { zero });
            all.pack(&lanes.collect::<Vec<_>>())
        });
        let change: Vec<Id> = of_outputs.collect();
        let rates = tracer.velocity_to_qdot();
        let rest = vec![all.constant(0.0); tracer.parameters.len()];
        let dq = all.add(&rates, &[&self.point[..nq], &change[..nv], &rest]);
        let mut entries: Vec<Entry> = Vec::new();
        for entry in displacements.iter().flat_map(|(_, entries)| entries) {
            if !entries.contains(entry) {
                entries.push(*entry);
            }
        }
        let output = |entry: &Entry| self.outputs[entry.variable * nv + entry.index];
        self.changes.outputs = entries.iter().map(output).collect();
        let changes = all.add(&self.changes, &[&self.point, &dq, &change[nv..]]);
        for (lane, (along, entries_of_lane)) in displacements.iter().enumerate() {
            for (entry, &change) in
                entries.iter().zip(&changes).filter(|(e, _)| entries_of_lane.contains(e))
            {
                self.found.insert((*along, *entry), all.lane(change, lane));
            }
        }
    }

    /// Returns the entry (a, b) of the Hessian. Displacements of one rotation or pose do not
    /// commute: the second derivative along geodesics is the symmetric part.
    fn entry(&self, all: &mut Composition, a: Entry, b: Entry) -> Id {
        match (self.found.get(&(a, b)), self.found.get(&(b, a))) {
            (Some(&x), Some(&y)) if a != b => {
                let sum = all.sum(x, y);
                let half = all.constant(0.5);
                all.product(half, sum)
            }
            (Some(&x), _) | (_, Some(&x)) => x,
            (None, None) => all.constant(0.0),
        }
    }

    /// Returns the entries of two variables by columns.
    fn block(&self, all: &mut Composition, rows: usize, columns: usize) -> Vec<Id> {
        let pairs = entries_of(columns, self.nv)
            .flat_map(|column| entries_of(rows, self.nv).map(move |row| [row, column]));
        pairs.map(|[row, column]| self.entry(all, row, column)).collect()
    }
}

/// A state in which the pose and the linear velocity of each free base are constants.
pub(super) struct NeutralBases {
    q: Vec<Id>,
    qd: Vec<Id>,
    /// For each entry of qd, whether q and qd are constant there.
    constant: Vec<[bool; 2]>,
}

impl NeutralBases {
    /// Returns whether an entry of q or qd is a variable.
    fn varies(&self, entry: Entry) -> bool {
        !self.constant[entry.index][entry.variable]
    }
}

/// The accelerations at a state.
pub(super) struct Motion {
    q: Vec<Id>,
    qd: Vec<Id>,
    parameters: Vec<Id>,
    neutral: NeutralBases,
    /// The factors of the mass matrix.
    factors: Vec<Id>,
    /// The accelerations relative to free fall, with the bases neutral.
    relative: Vec<Id>,
    /// The accelerations.
    pub(super) qdd: Vec<Id>,
}

/// The gradients of a weighted sum of the accelerations, and the terms and factors of its Hessian,
/// by columns.
struct HessianFactors {
    /// The gradients by q (in tangent space) and qd.
    gradients: Vec<Id>,
    /// The gradient by tau.
    by_tau: Vec<Id>,
    /// The second derivatives of mu^T ID by q and q, q and qd, qd and qd.
    phi: [Vec<Id>; 3],
    /// The same of free fall.
    fall: [Vec<Id>; 3],
    /// U^-1 and D^-1.
    u: Vec<Id>,
    d: Vec<Id>,
    /// W and B.
    w: Vec<Id>,
    b: Vec<Id>,
    /// ID_q and ID_qd.
    by_state: [Vec<Id>; 2],
}

/// The derivatives of a weighted sum of the accelerations.
pub(super) struct ForwardHessian {
    /// The gradients by q (in tangent space) and qd.
    pub(super) gradients: Vec<Id>,
    /// The gradient by tau.
    pub(super) by_tau: Vec<Id>,
    /// The second derivatives by q and q, q and qd, qd and qd, by columns.
    pub(super) blocks: [Vec<Id>; 3],
    /// The second derivatives by q and tau.
    pub(super) by_q_tau: Vec<Id>,
    /// U^-1 and D^-1.
    u: Vec<Id>,
    d: Vec<Id>,
    /// U^-1 ID_q and U^-1 ID_qd.
    reduced: [Vec<Id>; 2],
}

impl Tracer<'_> {
    /// Returns, for each entry of qd, the entries of the same rotation or pose; the entry alone for
    /// all other joints.
    pub(super) fn groups(&self) -> Vec<Range<usize>> {
        let mut groups: Vec<Range<usize>> = (0..self.model.nv).map(|v| v..v + 1).collect();
        for block in &self.model.coordinates {
            let group = block.v..block.v + block.velocities();
            groups[group.clone()].fill(group);
        }
        groups
    }

    /// Returns the graph of the joint forces, of the weighted gradients by `q` (in tangent space),
    /// `qd` and `qdd`, and of the Hessian's blocks (q, q), (q, qd), (qd, qd) and (q, qdd), by
    /// columns. Inputs: `q`, `qd`, `qdd` and the weights.
    #[must_use]
    pub fn inverse_dynamics_hessian(&self) -> Graph {
        let WeightedInverseDynamics { mut all, tau, gradient, point, gradients } =
            self.weighted_inverse_dynamics();
        let mut hessian = Hessian::new(self, gradient, 2, point);
        self.second_derivatives(&mut all, &mut hessian, |_| true);
        let places = [(Q, Q), (Q, QD), (QD, QD), (Q, QDD)];
        let blocks = places.map(|(rows, columns)| hessian.block(&mut all, rows, columns));
        all.with_outputs(&[&tau, &gradients, &blocks.concat()])
    }

    /// Computes the second derivatives of inverse dynamics by the entries for which `varies` holds,
    /// and by all of qdd.
    fn second_derivatives(
        &self,
        all: &mut Composition,
        hessian: &mut Hessian,
        varies: impl Fn(Entry) -> bool,
    ) {
        let nv = self.model.nv;
        let groups = self.groups();
        let by_q = |j: usize| {
            // The rows of descendants take fewer operations than the rows of ancestors.
            let in_groups =
                entries_of(Q, nv).filter(|row| row.index >= j || groups[j].contains(&row.index));
            let of_state = in_groups.chain(entries_of(QD, nv)).filter(|&row| varies(row));
            let rows = of_state.chain(entries_of(QDD, nv));
            let column = Entry { variable: Q, index: j };
            varies(column).then(|| (column, rows.collect::<Vec<Entry>>()))
        };
        let by_qd = |j: usize| {
            let rows = entries_of(QD, nv).skip(j).filter(|&row| varies(row));
            let column = Entry { variable: QD, index: j };
            varies(column).then(|| (column, rows.collect::<Vec<Entry>>()))
        };
        for velocities in self.column_groups() {
            let each = [
                velocities.iter().map(|&j| by_q(j?)).collect::<Vec<_>>(),
                velocities.iter().map(|&j| by_qd(j?)).collect(),
            ];
            for displacements in each.iter().filter(|all| all.iter().any(Option::is_some)) {
                if self.limbs.is_none() {
                    let displacements: Vec<_> = displacements.iter().flatten().cloned().collect();
                    hessian.differentiate(self, all, &displacements);
                } else if velocities.len() == 1
                    || !hessian.differentiate_limbs(self, all, displacements)
                {
                    for one in displacements.iter().flatten() {
                        hessian.differentiate(self, all, std::slice::from_ref(one));
                    }
                }
            }
        }
    }

    /// Returns the entries of qd whose displacements share the lanes of one pack: the entries of
    /// equal limbs, else of consecutive joints of a chain.
    pub(super) fn column_groups(&self) -> Vec<Vec<Option<usize>>> {
        if let Some(limbs) = self.limbs {
            return limbs.velocities().map(|(lanes, _)| lanes.to_vec()).collect();
        }
        let body = |v: usize| self.model.dofs.iter().find(|dof| dof.v == v).map(|dof| dof.body);
        let parent = |body: Option<usize>| body.and_then(|body| self.model.bodies[body].parent);
        let follows = |v: usize| {
            let front = body(v - 1);
            let back = body(v);
            front == back || (front.is_some() && parent(back) == front)
        };
        let mut groups: Vec<Vec<Option<usize>>> = Vec::new();
        for v in 0..self.model.nv {
            match groups.last_mut() {
                Some(group) if group.len() < self.columns && follows(v) => group.push(Some(v)),
                _ => groups.push(vec![Some(v)]),
            }
        }
        groups
    }

    /// Returns the graph of the accelerations, of their weighted gradients by `q` (in tangent
    /// space), `qd` and `tau`, and of the Hessian's blocks (q, q), (q, qd), (qd, qd) and (q, tau),
    /// by columns. Inputs: `q`, `qd`, `tau` and the weights. The mass matrix is factorized with
    /// `layout`.
    #[must_use]
    pub fn forward_dynamics_hessian(&self, layout: &UduLayout) -> Graph {
        if self.loops.products {
            return self.forward_dynamics_hessian_by_products(layout);
        }
        let (mut all, motion, weights) = self.weighted_motion(layout);
        let hessian = self.weighted_accelerations(&mut all, layout, &motion, &weights);
        let ForwardHessian { gradients, by_tau, blocks, by_q_tau, .. } = hessian;
        all.with_outputs(&[&motion.qdd, &gradients, &by_tau, &blocks.concat(), &by_q_tau])
    }

    /// Returns a graph with the inputs `q`, `qd`, `tau`, the weights and the parameters, its
    /// accelerations, and the weights.
    fn weighted_motion(&self, layout: &UduLayout) -> (Composition, Motion, Vec<Id>) {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let mut all = Composition::new();
        let [q, qd, tau, weights] = [nq, nv, nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let motion = self.motion(&mut all, layout, [&q, &qd, &tau, &parameters]);
        (all, motion, weights)
    }

    /// Computes the accelerations at the inputs `q`, `qd`, `tau` and the parameters.
    pub(super) fn motion(
        &self,
        all: &mut Composition,
        layout: &UduLayout,
        [q, qd, tau, parameters]: [&[Id]; 4],
    ) -> Motion {
        let neutral = self.with_neutral_bases(all, q, qd);
        let factors = all.add(&self.brge(layout), &[&neutral.q, parameters]);
        let bias = all.add(&self.bias_forces(), &[&neutral.q, &neutral.qd, parameters]);
        let solve = self.solve(layout);
        let unmet = all.difference(tau, &bias);
        let relative = all.add(&solve, &[&factors, &unmet]);
        let free_fall = self.free_fall();
        let qdd = all.add(&free_fall, &[q, qd, parameters]);
        let neutral_fall = all.add(&free_fall, &[&neutral.q, &neutral.qd, parameters]);
        let relative_to_fall = all.difference(&qdd, &neutral_fall);
        let qdd = all.sums(&relative, &relative_to_fall);
        let [q, qd, parameters] = [q, qd, parameters].map(<[Id]>::to_vec);
        Motion { q, qd, parameters, neutral, factors, relative, qdd }
    }

    /// Computes the gradients and the Hessian of the accelerations' sum with these weights.
    pub(super) fn weighted_accelerations(
        &self,
        all: &mut Composition,
        layout: &UduLayout,
        motion: &Motion,
        weights: &[Id],
    ) -> ForwardHessian {
        let nv = self.model.nv;
        let HessianFactors { gradients, by_tau, phi, fall, u, d, w, b, by_state } =
            self.hessian_factors(all, layout, motion, weights);
        let [(by_q, u_by_q), (by_qd, u_by_qd)] = by_state.map(|columns| {
            let columns = self.multiply(all, &u, &columns);
            (self.multiply(all, &w, &columns), columns)
        });
        let by_q = all.sums(&by_q, &transposed(&by_q, nv));
        let none = vec![all.constant(0.0); nv * nv];
        let through_qdd = [by_q, by_qd, none];
        let blocks = std::array::from_fn(|k| {
            let through_velocity = all.difference(&through_qdd[k], &phi[k]);
            all.sums(&through_velocity, &fall[k])
        });
        let by_q_tau = all.negated(&b);
        let reduced = [u_by_q, u_by_qd];
        ForwardHessian { gradients, by_tau, blocks, by_q_tau, u, d, reduced }
    }

    /// Computes the gradients of the accelerations' sum with these weights, and the terms and
    /// factors of its Hessian.
    fn hessian_factors(
        &self,
        all: &mut Composition,
        layout: &UduLayout,
        motion: &Motion,
        weights: &[Id],
    ) -> HessianFactors {
        let nv = self.model.nv;
        let Motion { q, qd, parameters, neutral, factors, relative, .. } = motion;
        let by_tau = all.add(&self.solve(layout), &[factors, weights]);
        let gradient = self.gradient(&self.free_fall(), 1);
        let point = [&q[..], qd, weights, parameters].concat();
        let of_fall = all.add(&gradient, &[&point]);
        let mut fall = Hessian::new(self, gradient, 1, point);
        self.second_derivatives_of_free_fall(all, &mut fall);

        let gradient = self.gradient(&optimize(self.inverse_dynamics()), 2);
        let point = [&neutral.q[..], &neutral.qd, relative, &by_tau, parameters].concat();
        let gradients = all.add(&gradient, &[&point]);
        let zero = all.constant(0.0);
        let all_gradients = gradients[..2 * nv].iter().enumerate();
        let varying = all_gradients.map(|(k, &x)| {
            if neutral.varies(Entry { variable: k / nv, index: k % nv }) { x } else { zero }
        });
        let gradients = all.difference(&of_fall, &varying.collect::<Vec<_>>());
        let mut phi = Hessian::new(self, gradient, 2, point);
        self.second_derivatives(all, &mut phi, |entry| neutral.varies(entry));

        // B = W U^-1 with W = Phi_{q qdd} U^-T D^-1.
        let u = all.add(&self.u_inverse(layout), &[factors]);
        let d = all.add(&self.d_inverse(layout), &[factors]);
        let w = phi.block(all, Q, QDD);
        let left = self.multiply(all, &w, &transposed(&u, nv));
        let w = self.multiply(all, &left, &d);
        let b = self.multiply(all, &w, &u);
        let graph = self.inverse_dynamics_derivatives();
        let derivatives = all.add(&graph, &[&neutral.q, &neutral.qd, relative, parameters]);
        let by_state = [Q, QD].map(|variable| {
            let columns = derivatives[variable * nv * nv..][..nv * nv].iter().enumerate();
            let varies = |k: usize| neutral.varies(Entry { variable, index: k / nv });
            columns.map(|(k, &entry)| if varies(k) { entry } else { zero }).collect()
        });
        let [phi, fall] = [&mut phi, &mut fall].map(|hessian| {
            [(Q, Q), (Q, QD), (QD, QD)].map(|(rows, columns)| hessian.block(all, rows, columns))
        });
        HessianFactors { gradients, by_tau, phi, fall, u, d, w, b, by_state }
    }

    /// Leaves the products with B to loops.
    fn forward_dynamics_hessian_by_products(&self, layout: &UduLayout) -> Graph {
        let n = self.model.nv;
        let (mut all, motion, weights) = self.weighted_motion(layout);
        let HessianFactors { gradients, by_tau, phi, fall, b, by_state, .. } =
            self.hessian_factors(&mut all, layout, &motion, &weights);
        let bias: [Vec<Id>; 3] = std::array::from_fn(|k| all.difference(&fall[k], &phi[k]));
        let by_q_tau = all.negated(&b);
        let [by_q, by_qd] = by_state.map(|columns| all.negated(&columns));
        let results = [motion.qdd, gradients, by_tau, bias.concat(), by_q_tau.clone()].concat();
        let of_qq = ProductTarget::square(4 * n, n);
        let of_qqd = ProductTarget::square(4 * n + n * n, n);
        let targets = vec![vec![of_qq.clone(), of_qq.transposed()], vec![of_qqd]];
        let form = ProductForm { rows: n, terms: n, results: results.len(), targets };
        let mut graph = all.with_outputs(&[&results, &by_q_tau, &by_q, &by_qd]);
        graph.dense.products = Some(form);
        graph
    }

    /// Returns the product of two square matrices, by columns; equal limbs, else consecutive
    /// columns, share the lanes of a pack.
    fn multiply(&self, all: &mut Composition, a: &[Id], b: &[Id]) -> Vec<Id> {
        if let Some(limbs) = self.limbs {
            return LimbMatrices::new(limbs, self.model.nv).multiply(all, a, b);
        }
        all.multiply_columns(a, b, self.model.nv, self.columns)
    }

    /// Computes rows of the derivatives of the accelerations by q (in tangent space), qd and tau:
    /// for each variable nv columns of these rows.
    pub(super) fn acceleration_rows(
        &self,
        all: &mut Composition,
        motion: &Motion,
        hessian: &ForwardHessian,
        rows: Range<usize>,
    ) -> [Vec<Id>; 3] {
        let nv = self.model.nv;
        let height = rows.len();
        let ForwardHessian { u, d, reduced: [u_by_q, u_by_qd], .. } = hessian;
        let zero = all.constant(0.0);
        let mut transposed = transposed(u, nv);
        for (k, entry) in transposed.iter_mut().enumerate() {
            *entry = if rows.contains(&(k % nv)) { *entry } else { zero };
        }
        let solve = self.multiply(all, &transposed, d);
        let [by_q, by_qd, by_tau] = [u_by_q, u_by_qd, u].map(|x| {
            let relative = self.multiply(all, &solve, x);
            let columns = relative.chunks(nv).map(|column| &column[rows.clone()]);
            columns.collect::<Vec<_>>().concat()
        });
        let [mut by_q, mut by_qd] = [by_q, by_qd].map(|x| all.negated(&x));
        // Free fall.
        let inputs = self.model.nq + nv + self.parameters.len();
        let changes = jvp(&self.free_fall(), inputs, self.state(1));
        for base in free_bases(self.model) {
            let entries: Vec<usize> = self.model.dofs_of(base).iter().map(|dof| dof.v).collect();
            if !entries.contains(&rows.start) {
                continue;
            }
            for (variable, columns) in [(Q, &mut by_q), (QD, &mut by_qd)] {
                for &j in &entries {
                    let mut change = vec![zero; 2 * nv];
                    change[variable * nv + j] = all.constant(1.0);
                    let (dq, dqd) = change.split_at(nv);
                    let rates = self.velocity_to_qdot();
                    let dq = all.add(&rates, &[&motion.q, dq, &motion.parameters]);
                    let state = [&motion.q[..], &motion.qd, &motion.parameters, &dq, dqd];
                    let change = all.add(&changes, &state);
                    let column = &mut columns[j * height..][..height];
                    let sums = all.sums(column, &change[rows.clone()]);
                    column.copy_from_slice(&sums);
                }
            }
        }
        [by_q, by_qd, by_tau]
    }

    /// Returns the state with each free base in the neutral pose and without linear velocity.
    fn with_neutral_bases(&self, all: &mut Composition, q: &[Id], qd: &[Id]) -> NeutralBases {
        let mut neutral = NeutralBases {
            q: q.to_vec(),
            qd: qd.to_vec(),
            constant: vec![[false; 2]; self.model.nv],
        };
        let [zero, one] = [0.0, 1.0].map(|x| all.constant(x));
        for base in free_bases(self.model) {
            // Three coordinates of the position, four of the quaternion; linear velocities come
            // before angular ones.
            let at = self.model.bodies[base].q;
            let v = self.model.dofs_of(base)[0].v;
            neutral.q[at..at + 6].fill(zero);
            neutral.q[at + 6] = one;
            neutral.qd[v..v + 3].fill(zero);
            neutral.constant[v..v + 3].fill([true, true]);
            neutral.constant[v + 3..v + 6].fill([true, false]);
        }
        neutral
    }

    /// Returns the graph of the accelerations of free fall: g - omega x v for each free base, zero
    /// for all other entries. Inputs: `q`, `qd`.
    fn free_fall(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let mut qdd = self.vector();
            free_fall_accelerations(
                model,
                State { q: &q, qd: &qd },
                &mut Workspace::new(model),
                &mut qdd,
            );
            qdd
        })
    }

    /// Computes the second derivatives of free fall, which only the entries of the free bases have.
    fn second_derivatives_of_free_fall(&self, all: &mut Composition, fall: &mut Hessian) {
        for base in free_bases(self.model) {
            let entries = self.model.dofs_of(base).iter().map(|dof| dof.v);
            for j in entries.clone() {
                for variable in [Q, QD] {
                    let rows = entries.clone().map(|index| Entry { variable, index }).collect();
                    fall.differentiate(self, all, &[(Entry { variable, index: j }, rows)]);
                }
            }
        }
    }
}

/// Returns the transpose of a square matrix of `n` columns.
fn transposed(columns: &[Id], n: usize) -> Vec<Id> {
    (0..n * n).map(|k| columns[k % n * n + k / n]).collect()
}
