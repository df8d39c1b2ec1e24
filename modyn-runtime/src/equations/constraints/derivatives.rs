//! Derivatives of forward dynamics with contacts.
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
//! Inverse dynamics has a derivative in closed form. So have the accelerations of contacts, since a displacement along
//! a degree of freedom moves all bodies that it carries rigidly. Degree of freedom k gives the contact the velocity
//! S_k = (w_k, v_k). The parent of its body has the angular velocity W and the acceleration field E = A x + W x W x. The
//! contact moves relative to that parent with the velocity (w, v) and the acceleration (a, b), angular and linear. Then
//!
//! ```text
//! by q_k:  angular W x (w_k x w) + w_k x a,  linear E v_k + 2 W x (w_k x v) + w_k x b
//! by qd_k: angular V x w_k + w_k x w,        linear V x v_k + w_k x u + W x v_k + w_k x v
//! ```
//!
//! where V is the angular velocity of the body of k, and u the velocity of the contact relative to that body. The joint
//! forces of a wrench that is constant in world axes change for two reasons: the axes of descendant joints rotate with
//! q_k, and the point of the wrench moves relative to ancestor joints.

use alloc::{vec, vec::Vec};

use super::contact::ContactFrame;
use super::{ConstraintWorkspace, Settings, constrained_forward_dynamics};
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::equations::Workspace;
use crate::equations::brge::{self, UduLayout};
use crate::equations::derivatives::inverse_dynamics_derivatives;
use crate::equations::kinematics::links::column_along;
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

/// Memory for derivatives.
#[derive(Clone, Debug)]
pub(super) struct DerivativeWorkspace<S> {
    residuals: Vec<Twist<S>>,
    /// F with respect to q and qd, by columns.
    forces: [Vec<S>; 2],
    /// c with respect to q and qd, by rows.
    accelerations: [Vec<S>; 2],
    /// A^+, by columns.
    inverse: Vec<S>,
    /// Z, by rows.
    response: Vec<S>,
    /// L^T, by rows.
    gain: Vec<S>,
    path: Path<S>,
    /// The Jacobian of a contact.
    columns: Vec<Twist<S>>,
    multipliers: Vec<S>,
}

impl<S: Scalar> DerivativeWorkspace<S> {
    pub(super) fn new(model: &Mechanism<S>, rows: usize) -> Self {
        let n = model.nv;
        let numbers = |count| vec![S::zero(); count];
        let both = |count| [numbers(count), numbers(count)];
        Self {
            residuals: vec![Twist::zero(); model.constraints.len()],
            forces: both(n * n),
            accelerations: both(rows * n),
            inverse: numbers(rows * rows),
            response: numbers(rows * n),
            gain: numbers(rows * n),
            path: Path { joints: Vec::new(), bodies: Vec::new() },
            columns: vec![Twist::zero(); n],
            multipliers: numbers(rows),
        }
    }
}

/// A degree of freedom that moves a contact.
#[derive(Clone, Copy, Debug)]
struct PathJoint<S> {
    /// The index of the degree of freedom.
    dof: usize,
    /// The position of its body in [`Path::bodies`].
    body: usize,
    /// The velocity of the contact's frame at unit rate.
    twist: Twist<S>,
}

/// The motion of a body, in the axes of the contact's root.
#[derive(Clone, Copy, Debug)]
struct PathBody<S> {
    omega: Vector3<S>,
    alpha: Vector3<S>,
    /// The velocity of the body's point at the contact.
    velocity: Vector3<S>,
    acceleration: Vector3<S>,
}

/// The degrees of freedom and the bodies that move a contact, in the axes of the contact's root.
#[derive(Clone, Debug)]
struct Path<S> {
    joints: Vec<PathJoint<S>>,
    /// The bodies from the world to the contact.
    bodies: Vec<PathBody<S>>,
}

impl<S: Scalar> Path<S> {
    /// Computes the path of the contact whose frame was computed last, at the velocities `qd`. Expects the
    /// bodies' accelerations under gravity.
    fn fill(
        &mut self,
        model: &Mechanism<S>,
        frame: &ContactFrame<S>,
        origin: Vector3<S>,
        qd: &[S],
        workspace: &Workspace<S>,
    ) {
        let Self { joints, bodies } = self;
        let path = &workspace.kinematic_path;
        let rest = PathBody {
            omega: Vector3::zero(),
            alpha: Vector3::zero(),
            velocity: Vector3::zero(),
            acceleration: -frame.to_root(model.gravity),
        };
        joints.clear();
        bodies.clear();
        bodies.resize(path.len() + 1, rest);
        let mut point = origin;
        for (k, &i) in path.iter().enumerate().rev() {
            let (body, field, axes) = (&model.bodies[i], &workspace.fields[i], &workspace.axes[i]);
            bodies[k + 1].omega = axes.mul_vector(field.omega);
            bodies[k + 1].alpha = axes.mul_vector(field.alpha);
            bodies[k + 1].acceleration =
                axes.mul_vector(field.a + field.relative_acceleration(point));
            let at_joint = workspace.motions[i].point_to_parent(point);
            let in_front = k > 0 && body.elementary_joint.has_axis();
            let (axes, lever) = match in_front {
                true => (body.placement.rotate_axes(&workspace.axes[path[k - 1]]), at_joint),
                false => (*axes, point),
            };
            for dof in body.dofs.clone() {
                let twist = column_along(model.dofs[dof].component, &axes, lever);
                joints.push(PathJoint { dof, body: k + 1, twist });
            }
            point = body.placement.point_to_parent(at_joint);
        }
        for k in 1..bodies.len() {
            let own = joints.iter().filter(|joint| joint.body == k);
            let moves = own.map(|joint| joint.twist.linear.scale(model.dofs[joint.dof].rate(qd)));
            bodies[k].velocity = moves.fold(bodies[k - 1].velocity, |sum, v| sum + v);
        }
    }

    /// Returns the derivatives of the velocity and of the acceleration of the contact's frame with respect to a
    /// joint's coordinate.
    fn by_coordinate(&self, joint: &PathJoint<S>) -> [Twist<S>; 2] {
        let (front, last) = (&self.bodies[joint.body - 1], &self.bodies[self.bodies.len() - 1]);
        let Twist { angular, linear } = joint.twist;
        let big = front.omega;
        let omega = last.omega - big;
        let velocity = last.velocity - front.velocity;
        let rotated = big.cross(velocity);
        let alpha = last.alpha - front.alpha - big.cross(omega);
        let acceleration = last.acceleration - front.acceleration - (rotated + rotated);
        let (rotated_omega, rotated_velocity) = (angular.cross(omega), angular.cross(velocity));
        let coriolis = big.cross(rotated_velocity);
        let first = Twist { angular: rotated_omega, linear: big.cross(linear) + rotated_velocity };
        let second = Twist {
            angular: big.cross(rotated_omega) + angular.cross(alpha),
            linear: front.alpha.cross(linear)
                + big.cross(big.cross(linear))
                + (coriolis + coriolis)
                + angular.cross(acceleration),
        };
        [first, second]
    }

    /// Returns the derivative of the acceleration of the contact's frame with respect to a joint's velocity.
    fn by_rate(&self, joint: &PathJoint<S>) -> Twist<S> {
        let (front, own) = (&self.bodies[joint.body - 1], &self.bodies[joint.body]);
        let last = &self.bodies[self.bodies.len() - 1];
        let Twist { angular, linear } = joint.twist;
        let behind = (last.velocity - own.velocity) + (last.velocity - front.velocity);
        Twist {
            angular: own.omega.cross(angular) + angular.cross(last.omega - front.omega),
            linear: (own.omega + front.omega).cross(linear) + angular.cross(behind),
        }
    }
}

/// Computes the accelerations and the wrenches of
/// [`constrained_forward_dynamics`](super::constrained_forward_dynamics), and their derivatives with respect to
/// q (in tangent space), qd and tau. Returns the number of independent rows.
///
/// Wrenches and their derivatives are in world axes. The rank is assumed constant; redundant rows get the
/// derivatives of smallest norm. The model must not have loop constraints.
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
    for (constraint, target) in model.constraints.iter().zip(settings.contacts.as_ref()) {
        of_contact(model, (constraint, target, row), (q, qd), workspace, &mut own);
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
    let n = model.nv.max(1);
    let DerivativeWorkspace { forces, accelerations, path, columns, multipliers, .. } = own;
    let end = constraint.ends[1];
    let frame = ContactFrame::new(model, end, q, workspace, columns);
    path.fill(model, &frame, Vector3(end.pose.translation), qd, workspace);

    let wrench = constraint.along_rows(multipliers[row..].iter().copied());
    let (moment, force) = (wrench.angular.scale(constraint.length), wrench.linear);
    for a in &path.joints {
        let dof = &model.dofs[a.dof];
        let Twist { angular, linear } = a.twist;
        let (rotated, moved) = (linear.cross(force) + angular.cross(moment), linear.cross(force));
        for b in &path.joints {
            let other = &model.dofs[b.dof];
            // The joint force at `a` changes with a displacement along `b`, and at `b` with one along `a`.
            if b.body <= a.body {
                let entry = b.twist.angular.dot(rotated);
                let entry = dof.scale(other.scale(entry));
                let sum = &mut forces[0][other.v * n + dof.v];
                *sum = *sum - entry;
            }
            if b.body < a.body {
                let entry = b.twist.angular.dot(moved);
                let entry = dof.scale(other.scale(entry));
                let sum = &mut forces[0][dof.v * n + other.v];
                *sum = *sum - entry;
            }
        }
    }

    let [by_q, by_qd] = accelerations;
    for k in 0..constraint.rows.len() {
        by_q[(row + k) * n..][..model.nv].fill(S::zero());
        by_qd[(row + k) * n..][..model.nv].fill(S::zero());
    }
    let two_alpha = target.alpha + target.alpha;
    let beta_squared = target.beta * target.beta;
    for joint in &path.joints {
        let dof = &model.dofs[joint.dof];
        let [velocity, acceleration] = path.by_coordinate(joint);
        let moved = displaced(&frame, target, constraint.holds_rotation(), joint.twist);
        let q_part = acceleration + velocity.scale(two_alpha) + moved.scale(beta_squared);
        let qd_part = path.by_rate(joint) + joint.twist.scale(two_alpha);
        for (k, own_row) in constraint.rows.iter().enumerate() {
            let at = (row + k) * n + dof.v;
            let component = |twist| dof.scale(own_row.scaled_component(twist, constraint.length));
            by_q[at] = by_q[at] + component(q_part);
            by_qd[at] = by_qd[at] + component(qd_part);
        }
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
