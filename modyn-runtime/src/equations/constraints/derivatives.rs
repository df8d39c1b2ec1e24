//! Derivatives of forward dynamics with loop constraints and contacts.
//!
//! F is the derivative of inverse dynamics minus J^T lambda, at constant accelerations and wrenches. c is the derivative
//! of the constrained accelerations, stabilization included, at constant joint accelerations. The derivatives of
//! M qdd = tau - h + J^T lambda and J qdd = gamma are
//!
//! ```text
//! Z = J M^-1,  L^T = A^+ Z,  K = M^-1 - Z^T L^T,  A = J M^-1 J^T
//! d qdd = -K F - L c,  d lambda = L^T F - A^+ c,  d qdd / d tau = K,  d lambda / d tau = -L^T
//! ```
//!
//! (Featherstone 2008, ch. 8; Carpentier, Budhiraja and Mansard 2021, "Proximal and sparse resolution of constrained
//! dynamic equations".)
//!
//! Inverse dynamics has a derivative in closed form. So have the accelerations of contacts and loop constraints (`path`,
//! `loop_derivatives`), since a displacement along a degree of freedom moves all bodies that it carries rigidly.

use alloc::vec::Vec;

use super::contact::ContactFrame;
use super::derivative_terms::{
    DerivativeWorkspace, Stabilization, add_force, add_to_rows, clear_rows,
};
use super::loop_derivatives::of_loop;
use super::path::PathBody;
use super::{ConstraintWorkspace, Settings, constrained_forward_dynamics};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::Workspace;
use crate::equations::brge::{self, UduLayout};
use crate::equations::derivatives::inverse_dynamics_derivatives;
use crate::mechanism::{ConstrainedFrames, Mechanism};
use crate::spatial::{Matrix3, Pose, Twist, Vector3, Wrench};

/// The results: accelerations, wrenches and their derivatives. Matrices are nv x nv, by columns. Derivatives of
/// wrenches have a wrench for each entry of the differentiation variable, constraint by constraint.
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
    /// Returns results that are written to these vectors: the accelerations and wrenches, and the derivatives of both with
    /// respect to q, qd and tau.
    #[must_use]
    pub fn new(
        (qdd, wrenches): (&'a mut [S], &'a mut [Wrench<S>]),
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
/// [`constrained_forward_dynamics`](super::constrained_forward_dynamics), and their derivatives with respect to
/// q (in tangent space), qd and tau. Returns the number of independent rows.
///
/// Wrenches and their derivatives are in the axes of [`constrained_forward_dynamics`](super::constrained_forward_dynamics):
/// a derivative is that of the components. The rank is assumed constant; redundant rows get the derivatives of smallest
/// norm.
pub fn constrained_forward_dynamics_derivatives<S: Scalar, C: AsRef<[ContactTarget<S>]>>(
    model: &Mechanism<S>,
    layout: &UduLayout,
    state: (&[S], &[S], &[S]),
    (active, settings): Settings<'_, S, C>,
    (workspace, memory): (&mut Workspace<S>, &mut ConstraintWorkspace<S>),
    outputs: ConstrainedDerivatives<'_, S>,
) -> S {
    let (rows, n) = (memory.rows, model.nv.max(1));
    let taken = memory.derivatives.take();
    let mut own = taken.unwrap_or_else(|| DerivativeWorkspace::new(model, rows));
    let ConstrainedDerivatives { qdd, wrenches, .. } = outputs;
    let (q, qd, _) = state;
    let results = (&mut *qdd, wrenches, &mut *own.residuals);
    let rank = constrained_forward_dynamics(
        model,
        layout,
        state,
        (active, settings),
        (workspace, memory),
        results,
    );
    own.multipliers.copy_from_slice(&memory.right_hand_sides[0]);
    let [dq, dqd] = &mut own.forces;
    inverse_dynamics_derivatives(model, (q, qd, qdd), workspace, dq, dqd);
    let mut row = 0;
    let mut targets = settings.contacts.as_ref().iter();
    for constraint in &model.constraints {
        match constraint.contact.then(|| targets.next()).flatten() {
            Some(target) => {
                of_contact(model, (constraint, target, row), (q, qd), workspace, &mut own)
            }
            None => {
                let rates = Stabilization { alpha: settings.alpha, beta: settings.beta };
                of_loop(model, (constraint, rates, row), (q, qd, qdd), workspace, &mut own);
            }
        }
        row += constraint.rows.len();
    }
    invert(layout, memory, &mut own);

    let mut multipliers = core::mem::take(&mut own.multipliers);
    let DerivativeWorkspace { forces, accelerations, inverse, response, gain, .. } = &own;
    let ConstrainedDerivatives { dqdd_dq, dqdd_dqd, dqdd_dtau, .. } = outputs;
    let ConstrainedDerivatives { dwrenches_dq, dwrenches_dqd, dwrenches_dtau, .. } = outputs;
    brge::inverse(layout, &memory.factors, dqdd_dtau);
    for j in 0..model.nv {
        for i in 0..=j {
            let products = (0..rows).map(|r| response[r * n + i] * gain[r * n + j]);
            let shared = products.fold(dqdd_dtau[j * n + i], |sum, x| sum - x);
            (dqdd_dtau[j * n + i], dqdd_dtau[i * n + j]) = (shared, shared);
        }
    }
    let variables = [(dqdd_dq, dwrenches_dq), (dqdd_dqd, dwrenches_dqd)];
    for ((force, acceleration), (dqdd, dwrenches)) in
        forces.iter().zip(accelerations).zip(variables)
    {
        for (j, column) in dqdd.chunks_mut(n).enumerate() {
            let force = &force[j * n..][..model.nv];
            let change = |r: usize| acceleration[r * n + j];
            for (i, entry) in column.iter_mut().enumerate() {
                let moved = sum((0..model.nv).map(|k| dqdd_dtau[k * n + i] * force[k]));
                let pushed = sum((0..rows).map(|r| gain[r * n + i] * change(r)));
                *entry = -(moved + pushed);
            }
            for (r, multiplier) in multipliers.iter_mut().enumerate() {
                let moved = sum((0..model.nv).map(|k| gain[r * n + k] * force[k]));
                *multiplier = moved - sum((0..rows).map(|s| inverse[s * rows + r] * change(s)));
            }
            wrenches_of(model, memory, &multipliers, (j, dwrenches));
        }
    }
    for j in 0..model.nv {
        (0..rows).for_each(|r| multipliers[r] = -gain[r * n + j]);
        wrenches_of(model, memory, &multipliers, (j, dwrenches_dtau));
    }
    own.multipliers = multipliers;
    memory.derivatives = Some(own);
    rank
}

fn sum<S: Scalar>(products: impl Iterator<Item = S>) -> S {
    products.reduce(|sum, x| sum + x).unwrap_or(S::zero())
}

/// Writes the wrenches of these multipliers to column `j` of each constraint.
fn wrenches_of<S: Scalar>(
    model: &Mechanism<S>,
    memory: &ConstraintWorkspace<S>,
    multipliers: &[S],
    (j, wrenches): (usize, &mut [Wrench<S>]),
) {
    memory.by_constraint(model, multipliers, |c, constraint, sum| {
        let moment = sum.angular.scale(constraint.length);
        wrenches[c * model.nv + j] = Wrench { moment, force: sum.linear };
    });
}

/// Computes A^+, Z and L^T.
fn invert<S: Scalar>(
    layout: &UduLayout,
    memory: &mut ConstraintWorkspace<S>,
    own: &mut DerivativeWorkspace<S>,
) {
    let rows = memory.rows;
    let n = memory.force.len().max(1);
    memory.factorization.inverse(&mut own.inverse);
    memory.force.fill(S::zero());
    for (r, row) in own.response.chunks_mut(n).enumerate().take(rows) {
        memory.right_hand_sides[1].fill(S::zero());
        memory.right_hand_sides[1][r] = S::one();
        memory.respond(layout, 1, row);
    }
    for (r, row) in own.gain.chunks_mut(n).enumerate().take(rows) {
        for (i, entry) in row.iter_mut().enumerate() {
            *entry = sum((0..rows).map(|s| own.inverse[s * rows + r] * own.response[s * n + i]));
        }
    }
}

/// Adds a contact's part to F, and sets the contact's rows of c, which begin at `row`.
fn of_contact<S: Scalar>(
    model: &Mechanism<S>,
    (constraint, target, row): (&ConstrainedFrames<S>, &ContactTarget<S>, usize),
    (q, qd): (&[S], &[S]),
    workspace: &mut Workspace<S>,
    own: &mut DerivativeWorkspace<S>,
) {
    let DerivativeWorkspace { forces, accelerations, paths, columns, multipliers, .. } = own;
    let [_, path] = paths;
    let end = constraint.ends[1];
    let frame = ContactFrame::new(model, end, q, workspace, columns);
    let world = PathBody { acceleration: -frame.to_root(model.gravity), ..PathBody::at_rest() };
    let origin = Vector3(end.pose.translation);
    path.fill(model, (world, None), origin, qd, (workspace, &workspace.fields));

    let components = constraint.along_rows(multipliers[row..].iter().copied());
    let moment = components.angular.scale(constraint.length);
    let wrench = Wrench { moment, force: components.linear };
    path.forces_under(wrench, |change, force, coordinate| {
        add_force(model, change, (force, coordinate), &mut forces[0]);
    });

    clear_rows(model, (constraint, row), accelerations);
    let rates = Stabilization { alpha: target.alpha, beta: target.beta };
    for joint in &path.joints {
        let [velocity, acceleration] = path.by_coordinate(joint);
        let moved = displaced(&frame, target, constraint.holds_rotation(), joint.twist);
        let changes = [
            rates.constrained(acceleration, velocity) + moved.scale(rates.beta * rates.beta),
            rates.constrained(path.by_rate(joint), joint.twist),
        ];
        add_to_rows(model, (constraint, row), joint, changes, |own| *own, accelerations);
    }
}

/// Returns the derivative of the displacement from the target for a unit displacement along `twist`, in the
/// root's axes.
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
        let own = frame.axes();
        let change =
            |k: usize| frame.to_root(axes.column(k)).cross(twist.angular.cross(own.column(k)));
        let about = normal.dot(change(0) + change(1)) * S::from_f64(0.5);
        angular = change(2) + normal.scale(share * about);
    }
    Twist { angular, linear }
}
