//! Steps of a robot that touches the ground, and forces of a soft ground.

use super::impulses::{FreeMotion, JointStop, Residual, StepContact, apply_impulses};
use super::{State, add_scaled};
use crate::robot::Factorization;
use crate::spatial::{Pose, Vector3};
use crate::{Array, ConstraintSettings, ContactTarget, Robot, Scalar, functions};

/// The options of steps on the ground.
///
/// The ground under each contact is the target of the contact in [`ConstraintSettings`]: the xy plane of its pose, its
/// velocity, `beta`, `restitution` and `compliance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground<T = f64> {
    /// The coefficient of Coulomb friction.
    pub friction: T,
    /// The number of sweeps of the projected Gauss-Seidel method. [`GroundStep::residual`] says what they leave.
    pub sweeps: usize,
    /// Whether joints stop at the limits of the description. A joint beyond a limit returns at the rate `beta` of
    /// [`ConstraintSettings`].
    pub joint_limits: bool,
}

impl<T: Scalar> Ground<T> {
    /// Returns ground with this coefficient of friction, 50 sweeps and joint limits.
    #[must_use]
    pub fn with_friction(friction: T) -> Self {
        Self { friction, sweeps: 50, joint_limits: true }
    }
}

/// The state after a step on the ground.
pub struct GroundStep<R: Robot, T: Scalar = f64> {
    /// The state.
    pub state: State<R, T>,
    /// The force of the ground on each contact, mean over the step, N, in world axes.
    pub forces: R::PerContact<Vector3<T>>,
    /// The joint forces of the stops, mean over the step, N m or N.
    pub stops: R::V<T>,
    /// The velocities that the sweeps left wrong, m/s and rad/s. If it is too large, take more
    /// [`sweeps`](Ground::sweeps) or shorter steps.
    pub residual: Residual<T>,
}

impl<R: Robot, T: Scalar> State<R, T> {
    /// Returns the state after the time `dt` (s) under the joint forces `tau`, with all contacts of the robot as points
    /// that the ground can push but not pull, and with Coulomb friction.
    ///
    /// The method is semi-implicit Euler with impulses (Stewart and Trinkle 1996, "An implicit time-stepping scheme for
    /// rigid body dynamics with inelastic collisions and Coulomb friction"): free velocities, then projected Gauss-Seidel
    /// sweeps on the impulses of contacts and joint stops, then the step of the coordinates. It does not allocate, and its
    /// time does not depend on the state: the sweeps are a fixed number, and the result says what they leave. The origin
    /// of a contact's frame touches the ground, for surfaces too: a sole has a point at each corner. Closed loops are not
    /// closed. Impulses of stops take no part if
    /// [`joint_limits`](Ground::joint_limits) is false.
    ///
    /// ```
    /// use modyn_runtime::simulate::{Ground, State};
    /// use modyn_runtime::{ConstraintSettings, ContactTarget, Robot, functions};
    ///
    /// /// A millisecond on slippery ground.
    /// fn slide<R>(state: &State<R>, settings: &ConstraintSettings<f64, R::PerContact<ContactTarget<f64>>>) -> State<R>
    /// where
    ///     R: Robot + functions::Defaults + functions::Constraints + functions::ConstraintJacobian,
    /// {
    ///     let no_torques = state.qd;
    ///     state.step_on_ground(0.001, &no_torques, &Ground::with_friction(0.1), settings).state
    /// }
    /// ```
    #[must_use]
    pub fn step_on_ground(
        &self,
        dt: T,
        tau: &R::V<T>,
        ground: &Ground<T>,
        settings: &ConstraintSettings<T, R::PerContact<ContactTarget<T>>>,
    ) -> GroundStep<R, T>
    where
        R: functions::ForwardDynamics
            + functions::Brge
            + functions::Integrate
            + functions::ConstraintJacobian
            + functions::ConstraintResidual,
    {
        let zero = R::V::<T>::from_fn(|_| T::zero());
        let factors = R::brge(&self.q);
        let jacobian = R::constraint_jacobian(&self.q);
        let before = R::constraint_residual(&self.q, &self.qd, settings);
        let mut qd = add_scaled(&self.qd, dt, &R::forward_dynamics(&self.q, &self.qd, tau));

        // Loop constraints come first.
        let count = R::PerContact::<()>::LEN;
        let loops = R::PerConstraint::<()>::LEN - count;
        let columns = |contact: usize| jacobian.as_ref()[loops + contact].as_ref();
        let responses = R::PerContact::<[R::V<T>; 3]>::from_fn(|contact| {
            core::array::from_fn(|k| {
                factors.solve(&R::V::<T>::from_fn(|v| columns(contact)[v].linear[k]))
            })
        });
        let touches = R::PerContact::<StepContact<'_, T>>::from_fn(|contact| {
            let responses = responses.as_ref()[contact].each_ref().map(AsRef::as_ref);
            let displacement = before.displacements.as_ref()[loops + contact];
            let velocity = before.velocities.as_ref()[loops + contact];
            StepContact::new(
                &settings.contacts.as_ref()[contact],
                (columns(contact), responses),
                (displacement, velocity),
                FreeMotion { dt, velocities: qd.as_ref() },
                ground.friction,
            )
        });
        let inverse = if ground.joint_limits { Some(factors.inverse()) } else { None };
        let stops = R::PerVelocity::<JointStop<'_, T>>::from_fn(|entry| {
            let inverse = inverse.as_ref().map(AsRef::as_ref);
            let response = inverse.map_or(&[][..], |columns| columns[entry].as_ref());
            let unlimited = (T::zero(), [f64::NEG_INFINITY, f64::INFINITY]);
            let place = coordinate_of::<R>(entry).map_or(unlimited, |i| {
                (self.q.as_ref()[i], [R::LIMITS.lower[i], R::LIMITS.upper[i]])
            });
            JointStop::new((entry, response), place, settings.beta, dt)
        });
        let stops = if ground.joint_limits { stops.as_ref() } else { &[] };
        let mut impulses = R::PerContact::<Vector3<T>>::from_fn(|_| Vector3::zero());
        let mut stop_impulses = zero;
        let residual = apply_impulses(
            (touches.as_ref(), impulses.as_mut()),
            (stops, stop_impulses.as_mut()),
            ground.sweeps,
            qd.as_mut(),
        );
        let per_step = dt.recip();
        impulses.as_mut().iter_mut().for_each(|impulse| *impulse = impulse.scale(per_step));
        GroundStep {
            state: Self { q: R::integrate(&self.q, &add_scaled(&zero, dt, &qd)), qd },
            forces: impulses,
            stops: add_scaled(&zero, per_step, &stop_impulses),
            residual,
        }
    }
}

/// Returns the index of the coordinate of this entry of the velocities, `None` for the angular velocities of a quaternion.
///
/// The entry is the rate of the coordinate, except for the linear velocities of a planar or floating joint, which are in
/// the axes of the moved link. Such joints have no limits: their coordinates have infinite limits.
fn coordinate_of<R: Robot>(entry: usize) -> Option<usize> {
    let mut coordinate = entry;
    for &(_, quaternion) in R::QUATERNIONS {
        // Three velocities, four coordinates.
        if coordinate < quaternion {
            break;
        }
        if coordinate < quaternion + 3 {
            return None;
        }
        coordinate += 1;
    }
    Some(coordinate)
}

/// Returns the joint forces within the effort limits of the description, N m or N.
#[must_use]
pub fn limit_effort<R: Robot, T: Scalar>(tau: &R::V<T>) -> R::V<T> {
    R::V::<T>::from_fn(|i| {
        let (most, force) = (T::from_f64(R::LIMITS.effort[i]), tau.as_ref()[i]);
        let below = (most - force).select_nonnegative(force, most);
        (below + most).select_nonnegative(below, -most)
    })
}

/// A ground of springs and dampers, whose force is a function of a point's place and velocity.
///
/// It needs small steps: the damper alone has the time constant mass / `damping` with the mass that the point moves.
///
/// ```
/// use modyn_runtime::simulate::SpringGround;
/// use modyn_runtime::{Pose, Vector3};
///
/// let plane = Pose::<f64>::identity(); // the ground is at z = 0
/// let ground = SpringGround { plane, stiffness: 3000.0, damping: 20.0, friction: 0.8, slip: 0.01 };
/// // A point 2 mm in the ground, at rest: 6 N upwards. A point above the ground: no force.
/// let [x, y, z] = ground.force([0.1, 0.2, -0.002], Vector3([0.0; 3])).0;
/// assert!(x == 0.0 && y == 0.0 && (z - 6.0).abs() < 1e-12);
/// assert_eq!(ground.force([0.1, 0.2, 0.01], Vector3([0.0; 3])).0, [0.0; 3]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringGround<T = f64> {
    /// The place of the ground: its xy plane, with z as the normal.
    pub plane: Pose<T>,
    /// The force per depth, N/m.
    pub stiffness: T,
    /// The force per speed along the normal, N s/m.
    pub damping: T,
    /// The coefficient of friction.
    pub friction: T,
    /// The speed at which friction has 71 % of its full force, m/s.
    pub slip: T,
}

impl<T: Scalar> SpringGround<T> {
    /// Returns the force on a point at `position` (m) with `velocity` (m/s), N; all in world axes. The ground does not
    /// pull. Friction is friction times the normal force times v / sqrt(|v|^2 + slip^2) with the velocity v within the
    /// plane.
    #[must_use]
    pub fn force(&self, position: [T; 3], velocity: Vector3<T>) -> Vector3<T> {
        let Pose { rotation, translation } = self.plane;
        let normal = Vector3(rotation.map(|row| row[2]));
        let depth = normal.dot(Vector3(translation) - Vector3(position));
        let speed = normal.dot(velocity);
        let pressed = self.stiffness * depth - self.damping * speed;
        let pressed = pressed.select_nonnegative(pressed, T::zero());
        let pressed = depth.select_nonnegative(pressed, T::zero());
        let sliding = velocity - normal.scale(speed);
        let drag =
            self.friction * pressed * (sliding.dot(sliding) + self.slip * self.slip).sqrt().recip();
        normal.scale(pressed) - sliding.scale(drag)
    }
}
