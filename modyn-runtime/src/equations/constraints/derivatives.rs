//! Derivatives of forward dynamics with loop constraints and contacts.
//!
//! F is the derivative of inverse dynamics minus J^T lambda, at constant accelerations and
//! wrenches. c is the derivative of the constrained accelerations, stabilization included, at
//! constant joint accelerations. The derivatives of M qdd = tau - h + J^T lambda and J qdd = gamma
//! are
//!
//! ```text
//! Z = J M^-1,  L^T = A^+ Z,  K = M^-1 - Z^T L^T,  A = J M^-1 J^T
//! d qdd = -K F - L c,  d lambda = L^T F - A^+ c,  d qdd / d tau = K,  d lambda / d tau = -L^T
//! ```
//!
//! Only A^+ is computed as a matrix: d lambda = A^+ (Z F - c) and d qdd = -M^-1 (F - J^T d lambda),
//! column by column. For the derivatives with respect to tau, F is minus the identity and c is
//! zero. With M = W Delta W^T and the rows Y of J W^-T, Z F is Y Delta^-1 W^-1 F, and d qdd is
//! -W^-T Delta^-1 (W^-1 F - Y^T d lambda).
//!
//! (Featherstone 2008, ch. 8; Carpentier, Budhiraja and Mansard 2021, "Proximal and sparse
//! resolution of constrained dynamic equations".)
//!
//! Inverse dynamics has a derivative in closed form. So have the accelerations of contacts and loop
//! constraints (`path`, `loop_derivatives`), since a displacement along a degree of freedom moves
//! all bodies that it carries rigidly.

use alloc::{vec, vec::Vec};

use super::contact::ContactFrame;
use super::derivative_terms::{
    ColumnSolution, DerivativeWorkspace, PlacedConstraint, Stabilization, add_force, add_to_rows,
    clear_rows,
};
use super::lanes::packed;
use super::loop_derivatives::add_loop;
use super::path::{PathBody, PathRoot};
use super::{
    ConstrainedOutputs, ConstraintInput, ConstraintWorkspace, ConstraintWorkspaces,
    constrained_forward_dynamics,
};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::derivatives::inverse_dynamics_derivatives;
use crate::equations::factorization::limb_coupling::{Factorizable, LimbAccess};
use crate::equations::factorization::{solve_lower_factor, solve_upper_factor};
use crate::equations::{ForwardInput, State, Workspace};
use crate::mechanism::Mechanism;
use crate::spatial::{Matrix3, Pose, Twist, Vector3, Wrench};

/// The results: accelerations, wrenches and their derivatives. Matrices are nv x nv, by columns.
/// Derivatives of wrenches have a wrench for each entry of the differentiation variable, constraint
/// by constraint.
#[derive(Debug)]
pub struct ConstrainedDerivatives<'a, S> {
    /// The joint accelerations.
    pub qdd: &'a mut [S],
    /// The wrench of each constraint.
    pub wrenches: &'a mut [Wrench<S>],
    /// The derivatives of the accelerations with respect to q, in tangent space.
    pub dqdd_dq: &'a mut [S],
    /// The derivatives of the accelerations with respect to qd.
    pub dqdd_dqd: &'a mut [S],
    /// The derivatives of the accelerations with respect to tau.
    pub dqdd_dtau: &'a mut [S],
    /// The derivatives of the wrenches with respect to q, in tangent space.
    pub dwrenches_dq: &'a mut [Wrench<S>],
    /// The derivatives of the wrenches with respect to qd.
    pub dwrenches_dqd: &'a mut [Wrench<S>],
    /// The derivatives of the wrenches with respect to tau.
    pub dwrenches_dtau: &'a mut [Wrench<S>],
}

impl<'a, S> ConstrainedDerivatives<'a, S> {
    /// Returns results that are written to these vectors: the accelerations and wrenches, and the
    /// derivatives of both with respect to q, qd and tau.
    #[must_use]
    pub fn new(
        qdd: &'a mut [S],
        wrenches: &'a mut [Wrench<S>],
        [dqdd_dq, dqdd_dqd, dqdd_dtau]: &'a mut [Vec<S>; 3],
        [dwrenches_dq, dwrenches_dqd, dwrenches_dtau]: &'a mut [Vec<Wrench<S>>; 3],
    ) -> Self {
        Self {
            qdd,
            wrenches,
            dqdd_dq,
            dqdd_dqd,
            dqdd_dtau,
            dwrenches_dq,
            dwrenches_dqd,
            dwrenches_dtau,
        }
    }
}

/// Computes the accelerations and the wrenches of
/// [`constrained_forward_dynamics`](super::constrained_forward_dynamics), and their derivatives
/// with respect to q (in tangent space), qd and tau. Returns the number of independent rows.
///
/// Wrenches and their derivatives are in the axes of
/// [`constrained_forward_dynamics`](super::constrained_forward_dynamics): a derivative is the
/// derivative of the components. The rank is assumed constant; redundant rows get the derivatives
/// of smallest norm.
///
/// The columns of the derivatives are computed several at a time where the scalars have lanes.
pub fn constrained_forward_dynamics_derivatives<
    S: Scalar,
    T: Factorizable<S>,
    C: AsRef<[ContactTarget<S>]>,
>(
    tree: &T,
    layout: &T::Layout,
    input: ForwardInput<'_, S>,
    constraints: ConstraintInput<'_, S, C>,
    mut workspaces: ConstraintWorkspaces<'_, S>,
    mut outputs: ConstrainedDerivatives<'_, S>,
) -> S {
    let model = tree.mechanism();
    let n = model.nv.max(1);
    let ColumnEquations { mut terms, rank } =
        ColumnEquations::new(tree, layout, input, constraints, workspaces.reborrow(), &mut outputs);
    let memory = workspaces.memory;
    let DerivativeWorkspace { forces, accelerations, inverse, solution, .. } = &mut terms;
    let [f_q, f_qd] = forces;
    let [c_q, c_qd] = accelerations;
    let ConstrainedDerivatives { dqdd_dq, dqdd_dqd, dqdd_dtau, .. } = outputs;
    let ConstrainedDerivatives { dwrenches_dq, dwrenches_dqd, dwrenches_dtau, .. } = outputs;
    let solver = Columns { tree, layout, memory, inverse };
    let f_by_q = |i, j| f_q[j * n + i];
    let c_by_q = |r, j| c_q[r * n + j];
    let f_by_qd = |i, j| f_qd[j * n + i];
    let c_by_qd = |r, j| c_qd[r * n + j];
    let by_q = ColumnOutputs { dmultipliers: &mut [], dqdd: dqdd_dq, dwrenches: dwrenches_dq };
    let by_qd = ColumnOutputs { dmultipliers: &mut [], dqdd: dqdd_dqd, dwrenches: dwrenches_dqd };
    let by_tau =
        ColumnOutputs { dmultipliers: &mut [], dqdd: dqdd_dtau, dwrenches: dwrenches_dtau };
    solver.solve(f_by_q, c_by_q, solution, by_q);
    solver.solve(f_by_qd, c_by_qd, solution, by_qd);
    solver.solve_forces(solution, by_tau);
    memory.derivatives = Some(terms);
    rank
}

/// The equations of the columns of the derivatives.
struct ColumnEquations<S> {
    /// F, c and A^+.
    terms: DerivativeWorkspace<S>,
    /// The number of independent rows.
    rank: S,
}

impl<S: Scalar> ColumnEquations<S> {
    /// Computes the accelerations and the wrenches of `outputs`, and the equations of the columns
    /// of their derivatives.
    fn new<T: Factorizable<S>, C: AsRef<[ContactTarget<S>]>>(
        tree: &T,
        layout: &T::Layout,
        input: ForwardInput<'_, S>,
        constraints: ConstraintInput<'_, S, C>,
        mut workspaces: ConstraintWorkspaces<'_, S>,
        outputs: &mut ConstrainedDerivatives<'_, S>,
    ) -> Self {
        let model = tree.mechanism();
        let rows = workspaces.memory.rows;
        let taken = workspaces.memory.derivatives.take();
        let mut terms = taken.unwrap_or_else(|| DerivativeWorkspace::new(model, rows));
        let ConstrainedDerivatives { qdd, wrenches, .. } = outputs;
        let residuals = &mut terms.residuals;
        let rank = constrained_forward_dynamics(
            tree,
            layout,
            input,
            constraints,
            workspaces.reborrow(),
            ConstrainedOutputs { qdd, wrenches, residuals },
        );
        let ConstraintWorkspaces { workspace, memory } = workspaces;
        terms.multipliers.copy_from_slice(&memory.right_hand_sides[0]);
        let [dq, dqd] = &mut terms.forces;
        let state = input.state();
        let motion = state.with_accelerations(qdd);
        inverse_dynamics_derivatives(tree, motion, workspace, dq, dqd);
        let settings = constraints.settings;
        let mut row = 0;
        let mut targets = settings.targets.as_ref().iter();
        for constraint in &model.constraints {
            let placed = PlacedConstraint { constraint, row };
            match constraint.contact.then(|| targets.next()).flatten() {
                Some(target) => {
                    add_contact(model, placed, target, state, workspace, &mut terms);
                }
                None => {
                    let rates = Stabilization { alpha: settings.alpha, beta: settings.beta };
                    add_loop(model, placed, rates, motion, workspace, &mut terms);
                }
            }
            row += constraint.rows.len();
        }
        memory.factorization.inverse(tree, &mut terms.inverse);
        Self { terms, rank }
    }
}

/// The linear map from columns of -F and -c to columns of the derivatives.
#[derive(Clone, Debug)]
pub struct ColumnMap<S> {
    /// For each entry of a column of -F, then of -c: its part of the accelerations, then of each
    /// constraint's wrench.
    pub map: Vec<S>,
    /// The columns of -F, with the columns of -c below them, with respect to q and qd.
    pub columns: [Vec<S>; 2],
    /// The number of independent rows.
    pub rank: S,
}

impl<S: Scalar> ColumnMap<S> {
    /// Computes the results of [`constrained_forward_dynamics_derivatives`] except the derivatives
    /// with respect to q and qd: these are the products of the map with the columns.
    pub fn new<T: Factorizable<S>, C: AsRef<[ContactTarget<S>]>>(
        tree: &T,
        layout: &T::Layout,
        input: ForwardInput<'_, S>,
        constraints: ConstraintInput<'_, S, C>,
        mut workspaces: ConstraintWorkspaces<'_, S>,
        mut outputs: ConstrainedDerivatives<'_, S>,
    ) -> Self {
        let model = tree.mechanism();
        let n = model.nv;
        let count = model.constraints.len();
        let ColumnEquations { mut terms, rank } = ColumnEquations::new(
            tree,
            layout,
            input,
            constraints,
            workspaces.reborrow(),
            &mut outputs,
        );
        let memory = workspaces.memory;
        let rows = memory.rows;
        let ConstrainedDerivatives { dqdd_dtau, dwrenches_dtau, .. } = outputs;
        let DerivativeWorkspace { forces, accelerations, inverse, solution, .. } = &mut terms;
        let mut multipliers = vec![S::zero(); rows * n];
        let solver = Columns { tree, layout, memory, inverse };
        let by_tau = ColumnOutputs {
            dmultipliers: &mut multipliers,
            dqdd: dqdd_dtau,
            dwrenches: dwrenches_dtau,
        };
        solver.solve_forces(solution, by_tau);
        let mut map = Vec::with_capacity((n + rows) * (n + 6 * count));
        for j in 0..n {
            map.extend_from_slice(&dqdd_dtau[j * n..][..n]);
            let of_column = (0..count).map(|c| &dwrenches_dtau[c * n + j]);
            map.extend(of_column.flat_map(Wrench::components));
        }
        let mut changes = vec![Wrench::zero(); count];
        for (r, column) in inverse.chunks(rows.max(1)).enumerate() {
            map.extend((0..n).map(|j| -multipliers[j * rows + r]));
            memory.wrenches_of(model, column, &mut changes);
            map.extend(changes.iter().flat_map(Wrench::components));
        }
        let columns = [0, 1].map(|variable| {
            let f = &forces[variable];
            let c = &accelerations[variable];
            let column = |j: usize| {
                let f_entries = f[j * n..][..n].iter().map(|&x| -x);
                f_entries.chain((0..rows).map(move |r| -c[r * n + j]))
            };
            (0..n).flat_map(column).collect()
        });
        Self { map, columns, rank }
    }
}

/// Columns of the derivatives.
struct ColumnOutputs<'a, S> {
    /// d lambda, if the list is not empty.
    dmultipliers: &'a mut [S],
    /// d qdd.
    dqdd: &'a mut [S],
    /// The wrenches of d lambda.
    dwrenches: &'a mut [Wrench<S>],
}

/// A factorized robot, which solves for columns of derivatives.
struct Columns<'a, S: Scalar, T: Factorizable<S>> {
    tree: &'a T,
    layout: &'a T::Layout,
    memory: &'a ConstraintWorkspace<S>,
    /// A^+, by columns.
    inverse: &'a [S],
}

impl<S: Scalar, T: Factorizable<S>> Columns<'_, S, T> {
    /// Computes the derivatives with respect to tau.
    fn solve_forces(&self, solution: &mut ColumnSolution<S>, outputs: ColumnOutputs<'_, S>) {
        let n = self.tree.mechanism().nv;
        let minus_one = |i, j| if i == j { -S::one() } else { S::zero() };
        let ColumnOutputs { dmultipliers, dqdd, dwrenches } = outputs;
        let outputs = ColumnOutputs { dmultipliers, dqdd: &mut *dqdd, dwrenches };
        self.solve(minus_one, |_, _| S::zero(), solution, outputs);
        // The matrix is symmetric: the entries above its diagonal suffice.
        for j in 0..n {
            (0..j).for_each(|i| dqdd[i * n + j] = dqdd[j * n + i]);
        }
    }

    /// Computes columns of the derivatives. `f` and `c` return an entry of F and c, by its row and
    /// its column.
    fn solve(
        &self,
        f: impl Fn(usize, usize) -> S,
        c: impl Fn(usize, usize) -> S,
        ColumnSolution { x, change, multipliers }: &mut ColumnSolution<S>,
        ColumnOutputs { dmultipliers, dqdd, dwrenches }: ColumnOutputs<'_, S>,
    ) {
        let Self { tree, memory, .. } = *self;
        let model = tree.mechanism();
        let n = tree.mechanism().nv;
        let count = tree.column_lanes();
        for first in (0..n).step_by(count) {
            let columns = first..n.min(first + count);
            let pack = |entry: &dyn Fn(usize) -> S| packed(tree, columns.clone(), entry);
            (0..n).for_each(|i| x[i] = pack(&|j| f(i, j)));
            (0..memory.rows).for_each(|r| change[r] = pack(&|j| c(r, j)));
            self.solve_column(x, change, multipliers);
            for (lane, j) in columns.clone().enumerate() {
                (0..n).for_each(|i| dqdd[j * n + i] = tree.extract_lane(x[i], lane));
                let rows = dmultipliers.chunks_mut(memory.rows.max(1)).nth(j);
                for (entry, &pack) in rows.into_iter().flatten().zip(&*multipliers) {
                    *entry = tree.extract_lane(pack, lane);
                }
            }
            memory.by_constraint(model, multipliers, |index, constraint, sum| {
                let moment = sum.angular.scale(constraint.length);
                for (lane, j) in columns.clone().enumerate() {
                    let lanes_of = |v: Vector3<S>| Vector3(v.0.map(|x| tree.extract_lane(x, lane)));
                    dwrenches[index * n + j] =
                        Wrench { moment: lanes_of(moment), force: lanes_of(sum.linear) };
                }
            });
        }
    }

    /// Replaces a column x of F by d qdd, and computes d lambda; `change` is the column of c.
    fn solve_column(&self, x: &mut [S], change: &mut [S], multipliers: &mut [S]) {
        let Self { layout, memory, inverse, .. } = *self;
        let n = x.len();
        let rows = memory.rows;
        let factors = &memory.factors;
        let reciprocals = &factors[layout.layout().reciprocals()];
        let row = |r: usize| {
            let row = &memory.reduced[r * n..][..n];
            let support = &memory.supports[memory.owner[r]];
            support.entries.iter().map(|&k| (k, row[k]))
        };
        solve_upper_factor(layout, factors, x);
        for (r, change) in change.iter_mut().enumerate() {
            let response = sum(row(r).map(|(k, y)| y * (x[k] * reciprocals[k])));
            *change = response - *change;
        }
        for (r, multiplier) in multipliers.iter_mut().enumerate() {
            let products = inverse[r * rows..][..rows].iter().zip(&*change);
            *multiplier = sum(products.map(|(&a, &b)| a * b));
            row(r).for_each(|(k, y)| x[k] = x[k] - y * *multiplier);
        }
        x.iter_mut().zip(reciprocals).for_each(|(x, &reciprocal)| *x = -(*x * reciprocal));
        solve_lower_factor(layout.layout(), factors, x);
    }
}

fn sum<S: Scalar>(products: impl Iterator<Item = S>) -> S {
    products.reduce(|sum, x| sum + x).unwrap_or(S::zero())
}

/// Adds a contact's part to F, and sets the contact's rows of c.
fn add_contact<S: Scalar>(
    model: &Mechanism<S>,
    placed: PlacedConstraint<'_, S>,
    target: &ContactTarget<S>,
    State { q, qd }: State<'_, S>,
    workspace: &mut Workspace<S>,
    terms: &mut DerivativeWorkspace<S>,
) {
    let PlacedConstraint { constraint, row } = placed;
    let DerivativeWorkspace { forces, accelerations, paths, columns, multipliers, .. } = terms;
    let [_, path] = paths;
    let end = constraint.ends[1];
    let frame = ContactFrame::new(model, end, q, workspace, columns);
    let body = PathBody { acceleration: -frame.to_root(model.gravity), ..PathBody::at_rest() };
    let world = PathRoot { body, axes: None };
    let origin = Vector3(end.pose.translation);
    path.fill(model, world, origin, qd, workspace, &workspace.fields);

    let components = constraint.along_rows(multipliers[row..].iter().copied());
    let moment = components.angular.scale(constraint.length);
    let wrench = Wrench { moment, force: components.linear };
    path.forces_under(wrench, |change, force, coordinate| {
        add_force(model, change, force, coordinate, &mut forces[0]);
    });

    clear_rows(model, placed, accelerations);
    let rates = Stabilization { alpha: target.alpha, beta: target.beta };
    for joint in &path.joints {
        let [velocity, acceleration] = path.by_coordinate(joint);
        let moved = displaced(&frame, target, constraint.holds_rotation(), joint.twist);
        let changes = [
            rates.constrained(acceleration, velocity) + moved.scale(rates.beta * rates.beta),
            rates.constrained(path.by_rate(joint), joint.twist),
        ];
        add_to_rows(model, placed, joint, changes, |row| *row, accelerations);
    }
}

/// Returns the derivative of the displacement from the target for a unit displacement along
/// `twist`, in the root's axes.
fn displaced<S: Scalar>(
    frame: &ContactFrame<S>,
    target: &ContactTarget<S>,
    surface: bool,
    twist: Twist<S>,
) -> Twist<S> {
    let Pose { rotation, .. } = target.pose;
    let axes = Matrix3(rotation);
    let normal = frame.to_root(axes.column(2));
    let share = target.tangential;
    let rest = S::one() - share;
    let linear = twist.linear.scale(share) + normal.scale(rest * normal.dot(twist.linear));
    let mut angular = Vector3::zero();
    if surface {
        let frame_axes = frame.axes();
        let change = |k: usize| {
            frame.to_root(axes.column(k)).cross(twist.angular.cross(frame_axes.column(k)))
        };
        let about = normal.dot(change(0) + change(1)) * S::from_f64(0.5);
        angular = change(2) + normal.scale(share * about);
    }
    Twist { angular, linear }
}
