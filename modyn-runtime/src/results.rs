//! The results with several parts.

/// The derivatives of inverse dynamics: square matrices by columns, a column for each variable.
///
/// The derivative with respect to the accelerations is the mass matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseDynamicsDerivatives<M> {
    /// d tau / d q, in tangent space.
    pub dtau_dq: M,
    /// d tau / d qd.
    pub dtau_dqd: M,
}

/// The accelerations of forward dynamics and their derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardDynamicsDerivatives<V, M> {
    /// The joint accelerations.
    pub qdd: V,
    /// d qdd / d q, in tangent space.
    pub dqdd_dq: M,
    /// d qdd / d qd.
    pub dqdd_dqd: M,
    /// d qdd / d tau: the inverse of the mass matrix.
    pub dqdd_dtau: M,
}

/// The derivatives of the coordinates after a displacement: square matrices by columns, in tangent
/// space.
///
/// Displacements of rotations and poses are in the link's own axes. A displacement of `q` is in the
/// axes before the displacement, a displacement of the result in the axes after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegrateDerivatives<M> {
    /// The derivative with respect to the coordinates before the displacement.
    pub dq_dq: M,
    /// The derivative with respect to the displacement.
    pub dq_dv: M,
}

/// The derivatives of the displacement between coordinates: square matrices by columns, in tangent
/// space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DifferenceDerivatives<M> {
    /// The derivative with respect to the first coordinates.
    pub dv_dfrom: M,
    /// The derivative with respect to the last coordinates.
    pub dv_dto: M,
}

/// The momentum of the moving links about their centre of mass, its time derivative (the rate), and
/// the derivatives of both, in world axes. A matrix has a column for each entry of qd.
///
/// The derivatives of the momentum with respect to qd, and of the rate with respect to qdd, are the
/// centroidal momentum matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentroidalMomentumDerivatives<H, M> {
    /// The momentum, kg m^2/s and kg m/s.
    pub momentum: H,
    /// The time derivative of the momentum, N and N m.
    pub rate: H,
    /// The derivatives of the momentum with respect to q, in tangent space.
    pub dmomentum_dq: M,
    /// The derivatives of the rate with respect to q, in tangent space.
    pub drate_dq: M,
    /// The derivatives of the rate with respect to qd.
    pub drate_dqd: M,
}

/// The joint forces tau of inverse dynamics, and the gradients of cotangent^T tau.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseDynamicsVjp<V> {
    /// The joint forces, N m or N.
    pub tau: V,
    /// The gradient with respect to q, in tangent space.
    pub grad_q: V,
    /// The gradient with respect to qd.
    pub grad_qd: V,
    /// The gradient with respect to qdd: the product of the mass matrix and the cotangent.
    pub grad_qdd: V,
}

/// The joint forces of inverse dynamics, and their change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseDynamicsJvp<V> {
    /// The joint forces, N m or N.
    pub tau: V,
    /// The change of the joint forces.
    pub tangent_tau: V,
}

/// The accelerations qdd of forward dynamics, and the gradients of cotangent^T qdd.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardDynamicsVjp<V> {
    /// The joint accelerations, rad/s^2 or m/s^2.
    pub qdd: V,
    /// The gradient with respect to q, in tangent space.
    pub grad_q: V,
    /// The gradient with respect to qd.
    pub grad_qd: V,
    /// The gradient with respect to tau: the inverse of the mass matrix times the cotangent.
    pub grad_tau: V,
}

/// The joint forces tau of inverse dynamics, and the gradients and the Hessian of cotangent^T tau.
///
/// Matrices are square, by columns: `hess_q_qd[j][i]` is the second derivative with respect to
/// entry i of q and entry j of qd. The block of qd and qdd and the block of qdd and qdd are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseDynamicsHessian<V, M> {
    /// The joint forces, N m or N.
    pub tau: V,
    /// The gradient with respect to q, in tangent space.
    pub grad_q: V,
    /// The gradient with respect to qd.
    pub grad_qd: V,
    /// The gradient with respect to qdd: the product of the mass matrix and the cotangent.
    pub grad_qdd: V,
    /// The second derivatives with respect to q, in tangent space: symmetric.
    pub hess_q_q: M,
    /// The second derivatives with respect to q (rows) and qd (columns).
    pub hess_q_qd: M,
    /// The second derivatives with respect to qd: symmetric.
    pub hess_qd_qd: M,
    /// The second derivatives with respect to q (rows) and qdd (columns).
    pub hess_q_qdd: M,
}

/// The accelerations qdd of forward dynamics, and the gradients and the Hessian of cotangent^T qdd.
///
/// Matrices are square, by columns: `hess_q_qd[j][i]` is the second derivative with respect to
/// entry i of q and entry j of qd. The block of qd and tau and the block of tau and tau are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardDynamicsHessian<V, M> {
    /// The joint accelerations, rad/s^2 or m/s^2.
    pub qdd: V,
    /// The gradient with respect to q, in tangent space.
    pub grad_q: V,
    /// The gradient with respect to qd.
    pub grad_qd: V,
    /// The gradient with respect to tau: the inverse of the mass matrix times the cotangent.
    pub grad_tau: V,
    /// The second derivatives with respect to q, in tangent space: symmetric.
    pub hess_q_q: M,
    /// The second derivatives with respect to q (rows) and qd (columns).
    pub hess_q_qd: M,
    /// The second derivatives with respect to qd: symmetric.
    pub hess_qd_qd: M,
    /// The second derivatives with respect to q (rows) and tau (columns).
    pub hess_q_tau: M,
}

/// The generalized forces of external wrenches, and their derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralizedForces<V, M> {
    /// The generalized forces J^T f, N m or N.
    pub tau: V,
    /// The derivative of the generalized forces with respect to q, in tangent space: a square
    /// matrix by columns.
    pub dtau_dq: M,
}

/// The accelerations of forward dynamics, and their change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardDynamicsJvp<V> {
    /// The joint accelerations, rad/s^2 or m/s^2.
    pub qdd: V,
    /// The change of the joint accelerations.
    pub tangent_qdd: V,
}

/// The state after a time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step<Q, V> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
}

/// The state after a time step, and its derivatives in tangent space.
///
/// A state has the entries of q, in tangent space, then the entries of qd.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepDerivatives<Q, V, A, B> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The derivative A with respect to the state before the step: 2 nv columns of 2 nv entries.
    pub a: A,
    /// The derivative B with respect to the joint forces: nv columns of 2 nv entries.
    pub b: B,
}

/// A knot of optimal control: the velocities after a semi-implicit step, and the derivatives of the
/// step in blocks.
///
/// Matrices are arrays of rows. The coordinates after the step are `integrate` of q and v, with
/// v = dt times [`qd`](Self::qd). Outside of the blocks, their derivatives are 1 on the diagonal
/// and 0 elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot<V, M, B> {
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// Their derivatives with respect to q before the step, in tangent space.
    pub dqd_dq: M,
    /// Their derivatives with respect to qd before the step.
    pub dqd_dqd: M,
    /// Their derivatives with respect to tau: a symmetric matrix.
    pub dqd_dtau: M,
    /// For each quaternion, the 6 x 6 derivatives of the coordinates after the step with respect to
    /// q before it, in tangent space. A spherical joint has rows and columns 3 to 5.
    pub dq_dq: B,
    /// For each quaternion, the 6 x 6 derivatives of the coordinates after the step with respect to
    /// v.
    pub dq_dv: B,
}

/// A knot of optimal control of a robot with closed loops or contacts. See [`Knot`] and
/// [`ConstrainedForwardDynamicsDerivatives`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstrainedKnot<V, W, M, B, D, T> {
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The wrench on each constraint's link, N and N m.
    pub wrenches: W,
    /// The derivatives of the velocities with respect to q before the step, in tangent space, by
    /// rows.
    pub dqd_dq: M,
    /// Their derivatives with respect to qd before the step.
    pub dqd_dqd: M,
    /// Their derivatives with respect to tau: a symmetric matrix.
    pub dqd_dtau: M,
    /// For each quaternion, the 6 x 6 derivatives of the coordinates after the step with respect to
    /// q before it, in tangent space, by rows.
    pub dq_dq: B,
    /// For each quaternion, the 6 x 6 derivatives of the coordinates after the step with respect to
    /// v.
    pub dq_dv: B,
    /// d wrench / d q of each constraint, in tangent space: an array of columns.
    pub dwrenches_dq: D,
    /// d wrench / d qd of each constraint.
    pub dwrenches_dqd: D,
    /// d wrench / d tau of each constraint.
    pub dwrenches_dtau: D,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

impl<V, W, M, B, D, T> ConstrainedKnot<V, W, M, B, D, T> {
    /// Returns the step and its derivatives, without the wrenches.
    #[must_use]
    pub fn knot(self) -> Knot<V, M, B> {
        let Self { qd, dqd_dq, dqd_dqd, dqd_dtau, dq_dq, dq_dv, .. } = self;
        Knot { qd, dqd_dq, dqd_dqd, dqd_dtau, dq_dq, dq_dv }
    }
}

/// The state after a time step, and the gradients and the Hessian of state_cotangent^T state, in
/// tangent space.
///
/// A state has the entries of q, in tangent space, then the entries of qd. Matrices are arrays of
/// columns: `hess_x_tau[j][i]` is the second derivative with respect to entry i of the state and
/// entry j of tau.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepHessian<Q, V, GradX, GradTau, HessXX, HessXTau, HessTauTau> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The gradient with respect to the state before the step: 2 nv entries.
    pub grad_x: GradX,
    /// The gradient with respect to tau: nv entries.
    pub grad_tau: GradTau,
    /// The second derivatives with respect to the state before the step: 2 nv columns of 2 nv
    /// entries, symmetric.
    pub hess_x_x: HessXX,
    /// The second derivatives with respect to the state before the step (rows) and tau (columns):
    /// nv columns of 2 nv entries.
    pub hess_x_tau: HessXTau,
    /// The second derivatives with respect to tau: nv columns of nv entries, symmetric; zero
    /// without spherical and floating joints.
    pub hess_tau_tau: HessTauTau,
}

/// The accelerations of a robot under its constraints, and the constraint wrenches.
///
/// Wrenches and residuals are arrays with an entry for each constraint. Loop constraints come
/// first, at the second frame's origin in the first frame's axes. Contacts follow, at the frame's
/// origin in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstrainedForwardDynamics<V, W, R, T> {
    /// The joint accelerations, rad/s^2 or m/s^2.
    pub qdd: V,
    /// The wrench on each constraint's second link, N and N m; the opposite wrench acts on the
    /// first link. A contact's wrench acts on its link and is zero if the contact is not active. If
    /// rows are redundant, the wrenches minimize the sum of force^2 + (moment / l)^2 over all
    /// constraints, with the characteristic length l of each.
    pub wrenches: W,
    /// The unmet part of each constraint's relative acceleration, rad/s^2 and m/s^2. It is within
    /// rounding of zero unless rows contradict each other. Then it minimizes the sum of linear^2 +
    /// (l angular)^2. The acceleration that a contact's compliance allows is not a part of it.
    pub residuals: R,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

/// The velocities after an impact, and the impulses of the constraints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactDynamics<V, W, T> {
    /// The velocities after the impact, rad/s or m/s.
    pub qd: V,
    /// The impulse on each constraint's second link, N m s and N s, in the axes and at the point of
    /// the constraint's wrench.
    pub impulses: W,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

/// The points of the shapes that can touch the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchingPoints<G, P> {
    /// The height of the shape above the ground at each point, m; negative in the ground.
    pub gaps: G,
    /// The places in the world, m: in the middle between the shape and the ground.
    pub positions: P,
    /// The velocity of the link at each place, along the x and y axes of the plane, then along its
    /// normal, m/s.
    pub velocities: P,
}

/// The joint forces of actuators, and their activations after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatorForces<V, A> {
    /// The joint forces, N m or N.
    pub tau: V,
    /// The activations after the step.
    pub act: A,
}

/// The state after a step with contacts, the forces in it, and how its solver ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSolution<Q, V, A, P, R, I> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The accelerations in the step, from which the next step starts, rad/s^2 or m/s^2.
    pub qdd: A,
    /// The force of each contact along the x and y axes of its plane, then along the normal, N.
    pub forces: P,
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's
    /// weight and the largest force. NaN if an argument is NaN.
    pub residual: R,
    /// The number of iterations of Newton's method.
    pub iterations: I,
}

/// The results of a step with contacts, and the derivatives of the state after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearizedStep<Q, V, A, P, Dx, Dtau, R, I> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The accelerations in the step, from which the next step starts, rad/s^2 or m/s^2.
    pub qdd: A,
    /// The force of each contact along the x and y axes of its plane, then along the normal, N.
    pub forces: P,
    /// The derivatives of the state after the step with respect to the state before, an array of
    /// columns. States are in tangent space.
    pub a: Dx,
    /// The derivatives of the state after the step with respect to `tau`, an array of columns.
    pub b: Dtau,
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's
    /// weight and the largest force. NaN if an argument is NaN.
    pub residual: R,
    /// The number of iterations of Newton's method.
    pub iterations: I,
}

/// The results of a step under the controls of actuators, and the derivatives of the state after
/// it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearizedActuatedStep<Q, V, C, A, P, Dx, Du, R, I> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The activations after the step.
    pub act: C,
    /// The accelerations in the step, from which the next step starts, rad/s^2 or m/s^2.
    pub qdd: A,
    /// The force of each contact along the x and y axes of its plane, then along the normal, N.
    pub forces: P,
    /// The derivatives of the state after the step with respect to the state before, an array of
    /// columns. A state has the entries of q, in tangent space, of qd, then the activations.
    pub a: Dx,
    /// The derivatives of the state after the step with respect to the controls, an array of
    /// columns.
    pub b: Du,
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's
    /// weight and the largest force. NaN if an argument is NaN.
    pub residual: R,
    /// The number of iterations of Newton's method.
    pub iterations: I,
}

/// The state after a step under the controls of actuators, the forces in it, and how its solver
/// ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatedStep<Q, V, C, A, P, R, I> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The activations after the step.
    pub act: C,
    /// The accelerations in the step, from which the next step starts, rad/s^2 or m/s^2.
    pub qdd: A,
    /// The force of each contact along the x and y axes of its plane, then along the normal, N.
    pub forces: P,
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's
    /// weight and the largest force. NaN if an argument is NaN.
    pub residual: R,
    /// The number of iterations of Newton's method.
    pub iterations: I,
}

/// The joint forces of accelerations, and the wrenches of the contacts that carry the floating
/// bases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstrainedInverseDynamics<V, W, T> {
    /// The joint forces, N m or N. The joint forces of a floating base are the wrench on it that no
    /// contact can carry: zero within rounding if the contacts suffice.
    pub tau: V,
    /// The wrench on each contact's link at its frame's origin in world axes, N and N m. The
    /// wrenches of loop constraints, which come first, are zero.
    pub wrenches: W,
    /// The number of independent directions in which the contacts carry the bases, an integer.
    pub rank: T,
}

/// The operational-space inertia of the constraints and its inverse: square matrices, arrays of
/// columns, with a row for each constraint row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperationalSpaceInertia<R, T> {
    /// The Delassus matrix: J M^-1 J^T with the mass matrix M, and the compliance of contacts, 1/kg
    /// (rotations 1/(kg m^2)).
    pub delassus: R,
    /// The pseudo-inverse of `delassus`, kg (rotations kg m^2).
    pub inertia: R,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

/// The accelerations and the wrenches of a robot with contacts, and their derivatives.
///
/// Matrices are arrays of columns. The derivative of a constraint's wrench is an array of columns,
/// one for each entry of the differentiation variable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstrainedForwardDynamicsDerivatives<V, W, M, D, T> {
    /// The accelerations, rad/s^2 or m/s^2.
    pub qdd: V,
    /// The wrench on each constraint's link, N and N m, in the axes of
    /// [`ConstrainedForwardDynamics::wrenches`]. Its derivatives are the derivatives of its
    /// components.
    pub wrenches: W,
    /// d qdd / d q, in tangent space.
    pub dqdd_dq: M,
    /// d qdd / d qd.
    pub dqdd_dqd: M,
    /// d qdd / d tau: symmetric; its rank is nv minus the rank of the constraints.
    pub dqdd_dtau: M,
    /// d wrench / d q of each constraint, in tangent space.
    pub dwrenches_dq: D,
    /// d wrench / d qd of each constraint.
    pub dwrenches_dqd: D,
    /// d wrench / d tau of each constraint.
    pub dwrenches_dtau: D,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

/// The accelerations and the wrenches of a robot with closed loops or contacts, and the derivatives
/// of their weighted sum: first derivatives, then the blocks of the Hessian.
///
/// Matrices are arrays of columns. The block of two variables has a row for each entry of the first
/// and a column for each entry of the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstrainedForwardDynamicsHessian<V, W, M, T> {
    /// The accelerations, rad/s^2 or m/s^2.
    pub qdd: V,
    /// The wrench on each loop constraint's second link, in the first frame's axes, and on each
    /// contact's link, in world axes, N and N m.
    pub wrenches: W,
    /// The gradient with respect to q, in tangent space.
    pub grad_q: V,
    /// The gradient with respect to qd.
    pub grad_qd: V,
    /// The gradient with respect to tau.
    pub grad_tau: V,
    /// The second derivatives with respect to q and q, in tangent space: symmetric.
    pub hess_q_q: M,
    /// The second derivatives with respect to q and qd.
    pub hess_q_qd: M,
    /// The second derivatives with respect to qd and qd: symmetric.
    pub hess_qd_qd: M,
    /// The second derivatives with respect to q and tau.
    pub hess_q_tau: M,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

/// A step that satisfies the constraints, and the change of the velocities that keeps them
/// satisfied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintProjection<V, T> {
    /// The displacement, in tangent space, from coordinates that nearly satisfy the constraints.
    pub step_q: V,
    /// The change of the velocities.
    pub step_qd: V,
    /// The number of independent constraint rows, an integer.
    pub rank: T,
}

/// The violation of the constraints: arrays with an entry for each constraint.
///
/// The entry of a loop constraint is the motion of its second frame relative to its first, in the
/// first frame's axes. The entry of a contact, active or not, is the motion of its frame relative
/// to its target, in world axes. Components along free directions are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintResidual<D> {
    /// The displacements, m; a rotation is its axis times the sine of its angle.
    pub displacements: D,
    /// The velocities, m/s and rad/s.
    pub velocities: D,
}

/// The results of a step with contacts, and the gradients of state_cotangent^T state after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepVjp<Q, V, A, P, GradX, GradTau, R, I> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The accelerations in the step, from which the next step starts, rad/s^2 or m/s^2.
    pub qdd: A,
    /// The force of each contact along the x and y axes of its plane, then along the normal, N.
    pub forces: P,
    /// The gradient with respect to the state before the step: the entries of q, in tangent space,
    /// then the entries of qd.
    pub grad_x: GradX,
    /// The gradient with respect to `tau`.
    pub grad_tau: GradTau,
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's
    /// weight and the largest force. NaN if an argument is NaN.
    pub residual: R,
    /// The number of iterations of Newton's method.
    pub iterations: I,
}

/// The results of a step with contacts, and the change of the state after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepJvp<Q, V, A, P, TangentX, R, I> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The accelerations in the step, from which the next step starts, rad/s^2 or m/s^2.
    pub qdd: A,
    /// The force of each contact along the x and y axes of its plane, then along the normal, N.
    pub forces: P,
    /// The change of the state after the step: the entries of q, in tangent space, then the entries
    /// of qd.
    pub tangent_x: TangentX,
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's
    /// weight and the largest force. NaN if an argument is NaN.
    pub residual: R,
    /// The number of iterations of Newton's method.
    pub iterations: I,
}

/// The results of a step under the controls of actuators, and the gradients of state_cotangent^T
/// state + act_cotangent^T act after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatedStepVjp<Q, V, C, A, P, GradX, GradCtrl, R, I> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The activations after the step.
    pub act: C,
    /// The accelerations in the step, from which the next step starts, rad/s^2 or m/s^2.
    pub qdd: A,
    /// The force of each contact along the x and y axes of its plane, then along the normal, N.
    pub forces: P,
    /// The gradient with respect to the state before the step: the entries of q, in tangent space,
    /// the entries of qd, then the activations.
    pub grad_x: GradX,
    /// The gradient with respect to the controls.
    pub grad_ctrl: GradCtrl,
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's
    /// weight and the largest force. NaN if an argument is NaN.
    pub residual: R,
    /// The number of iterations of Newton's method.
    pub iterations: I,
}

/// The results of a step under the controls of actuators, and the change of the state after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatedStepJvp<Q, V, C, A, P, TangentX, R, I> {
    /// The coordinates after the step.
    pub q: Q,
    /// The velocities after the step, rad/s or m/s.
    pub qd: V,
    /// The activations after the step.
    pub act: C,
    /// The accelerations in the step, from which the next step starts, rad/s^2 or m/s^2.
    pub qdd: A,
    /// The force of each contact along the x and y axes of its plane, then along the normal, N.
    pub forces: P,
    /// The change of the state after the step: the entries of q, in tangent space, the entries of
    /// qd, then the activations.
    pub tangent_x: TangentX,
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's
    /// weight and the largest force. NaN if an argument is NaN.
    pub residual: R,
    /// The number of iterations of Newton's method.
    pub iterations: I,
}
