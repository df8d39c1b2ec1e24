//! Steps of a robot that touches the ground, and forces of a soft ground.

use super::impulses::{
    FreeMotion, Ground, Impulses, StepMemory, contact_mode, solve_step, velocity_range,
};
use super::{State, add_scaled};
use crate::robot::{Factorization, Settings};
use crate::scalar::{at_least, at_most, positive};
use crate::solve::{Contact, ContactMode, Decide, Effort, Residual, Stop};
use crate::spatial::{Matrix3, Pose, Vector3};
use crate::{Array, Robot, Scalar, functions};

/// The impulses of a step of robot `R`.
pub type GroundImpulses<R, T = f64> = Impulses<<R as Robot>::PerContactRow<T>, <R as Robot>::V<T>>;

/// The state after a step on the ground.
pub struct GroundStep<R: Robot, T: Scalar = f64> {
    /// The state.
    pub state: State<R, T>,
    /// The force of the ground on each contact, mean over the step, N, in world axes.
    pub forces: R::PerContact<Vector3<T>>,
    /// The joint forces of the stops, mean over the step, N m or N.
    pub stops: R::V<T>,
    /// The state of each contact.
    pub modes: R::PerContact<ContactMode>,
    /// The impulses, from which the solver of the next step starts.
    pub impulses: GroundImpulses<R, T>,
    /// The velocities that are wrong with these impulses, m/s and rad/s. They are below the
    /// tolerance of [`Ground`], unless the solver reached its limits or no impulse can satisfy the
    /// laws of contacts.
    pub residual: Residual<T>,
    /// The sweeps and Newton steps that the solver took.
    pub effort: Effort,
}

impl<R: Robot, T: Decide> State<R, T> {
    /// Returns the state after the time `dt` (s) under the joint forces `tau`, with all contacts of
    /// the robot as points that the ground can push but not pull, with Coulomb friction, and with
    /// stops at the limits of the joints.
    ///
    /// The method is semi-implicit Euler with impulses (Stewart and Trinkle 1996, "An implicit
    /// time-stepping scheme for rigid body dynamics with inelastic collisions and Coulomb
    /// friction"): the impulses of contacts and joint stops satisfy their laws with the velocities
    /// after the step, which then move the coordinates. The laws are solved by
    /// [`solve`](crate::solve), to the tolerance of `ground`. The step does not allocate, and the
    /// solver has a largest number of iterations; contacts and stops that do not act cost little.
    /// [`GroundStep::step_on_ground`] starts the solver with the impulses of the last step, which
    /// is faster.
    ///
    /// The origin of a contact's frame touches the ground, for surfaces too: a sole has a point at
    /// each corner. Closed loops are not closed.
    ///
    /// ```
    /// use modyn_runtime::simulate::{Ground, State};
    /// use modyn_runtime::{ConstraintSettings, ContactTarget, Robot, functions};
    ///
    /// /// A second of steps of a millisecond.
    /// fn slide<R>(state: &State<R>, settings: &ConstraintSettings<f64, R::PerContact<ContactTarget<f64>>>) -> State<R>
    /// where
    ///     R: Robot + functions::Defaults + functions::ContactProblem,
    /// {
    ///     let (no_torques, ground) = (state.qd, Ground::default());
    ///     let mut step = state.step_on_ground(0.001, &no_torques, &ground, settings);
    ///     for _ in 1..1000 {
    ///         step = step.step_on_ground(0.001, &no_torques, &ground, settings);
    ///     }
    ///     step.state
    /// }
    /// ```
    #[must_use]
    pub fn step_on_ground(
        &self,
        dt: T,
        tau: &R::V<T>,
        ground: &Ground<T>,
        settings: &Settings<R, T>,
    ) -> GroundStep<R, T>
    where
        R: functions::ContactProblem + functions::Brge + functions::Integrate,
    {
        let impulses = Impulses {
            contacts: R::PerContactRow::<T>::from_fn(|_| T::zero()),
            stops: R::V::<T>::from_fn(|_| T::zero()),
        };
        self.step_from(impulses, (dt, tau), ground, settings)
    }

    fn step_from(
        &self,
        mut impulses: GroundImpulses<R, T>,
        (dt, tau): (T, &R::V<T>),
        ground: &Ground<T>,
        settings: &Settings<R, T>,
    ) -> GroundStep<R, T>
    where
        R: functions::ContactProblem + functions::Brge + functions::Integrate,
    {
        let problem = R::contact_problem(&self.q, &self.qd, tau, dt, settings);
        let rows = |vectors: &R::PerContact<Vector3<T>>| {
            R::PerContactRow::<T>::from_fn(|row| vectors.as_ref()[row / 3][row % 3])
        };
        let motion = FreeMotion {
            dt,
            qd: problem.qd.as_ref(),
            heights: problem.heights.as_ref(),
            before: &rows(&problem.before),
            free: &rows(&problem.free),
            mobility: problem.mobility.as_ref(),
            responses: problem.responses.as_ref(),
        };
        let mut stops = R::PerVelocity::<Stop<T>>::from_fn(|_| {
            Stop::new([f64::NEG_INFINITY, f64::INFINITY].map(T::from_f64))
        });
        let stops = if ground.joint_limits {
            for (entry, coordinate) in coordinates::<R>() {
                let limits = [R::LIMITS.lower[coordinate], R::LIMITS.upper[coordinate]];
                let at = self.q.as_ref()[coordinate];
                stops.as_mut()[entry].range = velocity_range(at, limits, settings.beta, dt);
            }
            stops.as_mut()
        } else {
            &mut []
        };
        let mut contacts = R::PerContact::<Contact<T>>::from_fn(|_| Contact::new(T::zero()));
        let mut order = R::PerVelocity::<usize>::from_fn(|_| 0);
        let targets = settings.contacts.as_ref();
        let mut qd = problem.qd;
        let (residual, effort) = solve_step(
            &Arrays::<R, T> { q: &self.q },
            &motion,
            targets,
            ground,
            (contacts.as_mut(), stops, order.as_mut()),
            &mut impulses,
            qd.as_mut(),
        );
        let (zero, per_step) = (R::V::<T>::from_fn(|_| T::zero()), dt.recip());
        let of = |contact: usize| {
            Vector3([0, 1, 2].map(|k| impulses.contacts.as_ref()[3 * contact + k]))
        };
        GroundStep {
            state: Self { q: R::integrate(&self.q, &add_scaled(&zero, dt, &qd)), qd },
            forces: R::PerContact::from_fn(|contact| {
                let axes = Matrix3(targets[contact].pose.rotation);
                axes.mul_vector(of(contact)).scale(per_step)
            }),
            stops: add_scaled(&zero, per_step, &impulses.stops),
            modes: R::PerContact::from_fn(|contact| {
                contact_mode(targets[contact].friction, of(contact).0)
            }),
            impulses,
            residual,
            effort,
        }
    }
}

impl<R: Robot, T: Decide> GroundStep<R, T> {
    /// Returns the step after this one: [`State::step_on_ground`], with the impulses of this step
    /// as the first guess.
    #[must_use]
    pub fn step_on_ground(
        &self,
        dt: T,
        tau: &R::V<T>,
        ground: &Ground<T>,
        settings: &Settings<R, T>,
    ) -> Self
    where
        R: functions::ContactProblem + functions::Brge + functions::Integrate,
    {
        self.state.step_from(self.impulses, (dt, tau), ground, settings)
    }
}

/// The memory of a step of a generated robot at the coordinates `q`.
struct Arrays<'a, R: Robot, T: Scalar> {
    q: &'a R::Q<T>,
}

impl<R: Robot + functions::Brge, T: Decide> StepMemory<T> for Arrays<'_, R, T> {
    type ContactRow = R::PerContactRow<T>;
    type ContactMatrix = R::PerContactRow<R::PerContactRow<T>>;
    type GroundRow = R::PerGroundRow<T>;
    type GroundMatrix = R::PerGroundRow<R::PerGroundRow<T>>;
    type Velocities = R::V<T>;
    type Inverse = R::M<T>;

    fn contact_row(&self) -> Self::ContactRow {
        Array::from_fn(|_| T::zero())
    }

    fn contact_matrix(&self) -> Self::ContactMatrix {
        let row = self.contact_row();
        Array::from_fn(|_| row)
    }

    fn ground_row(&self) -> Self::GroundRow {
        Array::from_fn(|_| T::zero())
    }

    fn ground_matrix(&self) -> Self::GroundMatrix {
        let row = self.ground_row();
        Array::from_fn(|_| row)
    }

    fn inverse(&self) -> R::M<T> {
        R::brge(self.q).inverse()
    }
}

/// Returns the entries of the velocities with the index of their coordinates, without the angular
/// velocities of quaternions.
///
/// The entry is the rate of the coordinate, except for the linear velocities of a planar or
/// floating joint, which are in the axes of the moved link. Such joints have no limits: their
/// coordinates have infinite limits.
fn coordinates<R: Robot>() -> impl Iterator<Item = (usize, usize)> {
    let mut quaternions = R::QUATERNIONS.iter();
    let mut next = quaternions.next();
    let (mut entry, mut coordinate) = (0, 0);
    core::iter::from_fn(move || {
        // Three velocities, four coordinates.
        while next.is_some_and(|&(_, quaternion)| coordinate == quaternion) {
            (entry, coordinate, next) = (entry + 3, coordinate + 4, quaternions.next());
        }
        let found = (entry < R::NV).then_some((entry, coordinate));
        (entry, coordinate) = (entry + 1, coordinate + 1);
        found
    })
}

/// Returns the joint forces within the effort limits of the description, N m or N.
#[must_use]
pub fn limit_effort<R: Robot, T: Scalar>(tau: &R::V<T>) -> R::V<T> {
    R::V::<T>::from_fn(|i| {
        let (most, force) = (T::from_f64(R::LIMITS.effort[i]), tau.as_ref()[i]);
        // NaN stays NaN.
        at_least(at_most(force, most), -most)
    })
}

/// A ground of springs and dampers, whose force is a function of a point's place and velocity.
///
/// It needs small steps: the damper alone has the time constant mass / `damping` with the mass that
/// the point moves.
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
    /// Returns the force on a point at `position` (m) with `velocity` (m/s), N; all in world axes.
    /// The ground does not pull. Friction is friction times the normal force times v / sqrt(|v|^2 +
    /// slip^2) with the velocity v within the plane.
    #[must_use]
    pub fn force(&self, position: [T; 3], velocity: Vector3<T>) -> Vector3<T> {
        let Pose { rotation, translation } = self.plane;
        let normal = Vector3(rotation.map(|row| row[2]));
        let depth = normal.dot(Vector3(translation) - Vector3(position));
        let speed = normal.dot(velocity);
        let pressed = self.stiffness * depth - self.damping * speed;
        let pressed = (-depth).select_nonnegative(T::zero(), positive(pressed));
        let sliding = velocity - normal.scale(speed);
        let drag =
            self.friction * pressed * (sliding.dot(sliding) + self.slip * self.slip).sqrt().recip();
        normal.scale(pressed) - sliding.scale(drag)
    }
}
