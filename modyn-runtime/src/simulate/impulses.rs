//! Impulses of unilateral constraints: contacts with Coulomb friction, and joint stops.
//!
//! Each sweep visits every contact and every stop once and corrects its impulse. The correction holds the
//! other impulses at their latest values. The method is projected Gauss-Seidel (Jourdan, Alart and Jean 1998,
//! "A Gauss-Seidel like algorithm to solve frictional contact problems"). The velocities v = v_0 + M^-1 J^T p
//! are updated with each correction, so J M^-1 J^T is never stored. A correction divides by the diagonal of
//! that matrix:
//!
//! ```text
//! normal      p_n <- max(0, p_n - (n . u + c p_n - b) / (n^T A n + c))
//! tangential  p_t <- p_t - u_t / (tr A - n^T A n), shortened to the length friction p_n
//! ```
//!
//! with the velocity u of the contact relative to the ground, its 3 x 3 block A = J M^-1 J^T, the compliance c and the
//! least speed b along the normal n. The divisor of the tangential step is the trace of A within the plane, which bounds
//! its eigenvalues.

use crate::spatial::{Twist, Vector3};
use crate::{ContactTarget, Scalar};

/// A contact during a step.
#[derive(Clone, Copy, Debug)]
pub struct StepContact<'a, T> {
    /// The Jacobian of the contact's frame, a column for each velocity, in world axes.
    pub columns: &'a [Twist<T>],
    /// The changes of the velocities by unit impulses along x, y and z: M^-1 J^T.
    pub responses: [&'a [T]; 3],
    /// The normal of the ground, away from the ground.
    pub normal: Vector3<T>,
    /// The mobility n^T A n along the normal, and the trace of A within the plane, 1/kg; A is J M^-1 J^T.
    pub mobilities: [T; 2],
    /// The velocity of the ground at the contact, m/s.
    pub ground: Vector3<T>,
    /// The height of the contact's frame above the ground before the step, m.
    pub height: T,
    /// The least speed along the normal relative to the ground after the step, m/s.
    pub least_speed: T,
    /// The coefficient of friction.
    pub friction: T,
    /// The relative velocity that the contact allows per impulse, 1/kg.
    pub compliance: T,
}

/// A joint stop during a step: the range of one entry of the velocities.
#[derive(Clone, Copy, Debug)]
pub struct JointStop<'a, T> {
    /// The index of the velocity.
    pub entry: usize,
    /// The changes of the velocities by a unit impulse: a column of the inverse mass matrix.
    pub response: &'a [T],
    /// The lowest and the highest velocity after the step, rad/s or m/s; may be infinite.
    pub range: [T; 2],
}

/// The motion of a robot without the impulses of a step.
#[derive(Clone, Copy, Debug)]
pub struct FreeMotion<'a, T> {
    /// The time step, s.
    pub dt: T,
    /// The velocities after the step without impulses.
    pub velocities: &'a [T],
}

impl<'a, T: Scalar> StepContact<'a, T> {
    /// Returns a contact with the target `target`. `before` is the displacement of the contact's frame from the target
    /// and the rate of the displacement, both before the step: the residual of the constraint.
    #[must_use]
    pub fn new(
        target: &ContactTarget<T>,
        (columns, responses): (&'a [Twist<T>], [&'a [T]; 3]),
        before: (Twist<T>, Twist<T>),
        free: FreeMotion<'_, T>,
        friction: T,
    ) -> Self {
        let normal = Vector3(target.pose.rotation.map(|row| row[2]));
        let ground = target.velocity.linear;
        let height = normal.dot(before.0.linear);
        let before = normal.dot(before.1.linear);
        let after = normal.dot(velocity(columns, free.velocities) - ground);
        let least_speed = least_speed(target, height, (before, after), free.dt);
        let compliance = target.compliance;
        let block = responses.map(|response| velocity(columns, response));
        let along = (0..3).fold(T::zero(), |sum, k| sum + normal[k] * normal.dot(block[k]));
        let trace = (0..3).fold(T::zero(), |sum, k| sum + block[k][k]);
        let mobilities = [along, trace - along];
        Self {
            columns,
            responses,
            normal,
            mobilities,
            ground,
            height,
            least_speed,
            friction,
            compliance,
        }
    }
}

impl<T: Scalar> StepContact<'_, T> {
    /// Returns the velocity of the contact relative to the ground, in world axes.
    #[must_use]
    pub fn velocity(&self, velocities: &[T]) -> Vector3<T> {
        velocity(self.columns, velocities) - self.ground
    }

    /// Corrects the impulse, and the velocities with it.
    fn correct(&self, velocities: &mut [T], impulse: &mut Vector3<T>) {
        let (normal, [along, across]) = (self.normal, self.mobilities);
        let before = normal.dot(*impulse);
        let missing =
            self.least_speed - normal.dot(self.velocity(velocities)) - self.compliance * before;
        let pressed = before + missing * (along + self.compliance).recip();
        let pressed = pressed.select_nonnegative(pressed, T::zero());
        self.apply(normal.scale(pressed - before), velocities, impulse);

        let slip = self.velocity(velocities);
        let slip = slip - normal.scale(normal.dot(slip));
        let friction = *impulse - normal.scale(pressed) - slip.scale(across.recip());
        let (length, most) = (friction.dot(friction).sqrt(), self.friction * pressed);
        // At length zero the first choice applies, so nothing is divided by zero.
        let sticks = most - length;
        let part = most * sticks.select_nonnegative(T::one(), length).recip();
        let part = sticks.select_nonnegative(T::one(), part);
        let friction = friction.scale(part);
        self.apply(normal.scale(pressed) + friction - *impulse, velocities, impulse);
    }

    fn apply(&self, change: Vector3<T>, velocities: &mut [T], impulse: &mut Vector3<T>) {
        *impulse += change;
        for (k, response) in self.responses.iter().enumerate() {
            for (velocity, &by_unit) in velocities.iter_mut().zip(*response) {
                *velocity = *velocity + by_unit * change[k];
            }
        }
    }
}

impl<'a, T: Scalar> JointStop<'a, T> {
    /// Returns the stop of a joint at the coordinate `at` within `limits`, rad or m; limits may be infinite.
    ///
    /// A joint within its limits may reach them. A joint beyond a limit returns at `beta` (1/s) times its distance.
    #[must_use]
    pub fn new(
        (entry, response): (usize, &'a [T]),
        (at, limits): (T, [f64; 2]),
        beta: T,
        dt: T,
    ) -> Self {
        let [below, above] = limits.map(|limit| T::from_f64(limit) - at);
        let range = [
            below * (-below).select_nonnegative(dt.recip(), return_rate(beta, dt)),
            above * above.select_nonnegative(dt.recip(), return_rate(beta, dt)),
        ];
        Self { entry, response, range }
    }

    /// Corrects the impulse, and the velocities with it.
    fn correct(&self, velocities: &mut [T], impulse: &mut T) {
        let per_unit = self.response[self.entry].recip();
        let [up, down] =
            self.range.map(|bound| *impulse + (bound - velocities[self.entry]) * per_unit);
        // At most one of the two is not zero, since the range is not empty.
        let next =
            up.select_nonnegative(up, T::zero()) + (-down).select_nonnegative(down, T::zero());
        let change = next - *impulse;
        *impulse = next;
        for (velocity, &by_unit) in velocities.iter_mut().zip(self.response) {
            *velocity = *velocity + by_unit * change;
        }
    }
}

/// Corrects the impulses of contacts (N s, in world axes) and joint stops (N m s or N s) in `sweeps` sweeps, and
/// adds the resulting changes to `velocities`. On entry, `velocities` must include the effect of the given
/// impulses.
pub fn apply_impulses<T: Scalar>(
    (touches, impulses): (&[StepContact<'_, T>], &mut [Vector3<T>]),
    (stops, stop_impulses): (&[JointStop<'_, T>], &mut [T]),
    sweeps: usize,
    velocities: &mut [T],
) {
    for _ in 0..sweeps {
        for (stop, impulse) in stops.iter().zip(&mut *stop_impulses) {
            stop.correct(velocities, impulse);
        }
        for (touch, impulse) in touches.iter().zip(&mut *impulses) {
            touch.correct(velocities, impulse);
        }
    }
}

/// Returns the speed per depth at which a step of `dt` seconds resolves a violation: `beta`, at most 1 / `dt`.
fn return_rate<T: Scalar>(beta: T, dt: T) -> T {
    let per_step = dt.recip();
    (per_step - beta).select_nonnegative(beta, per_step)
}

/// Returns the velocity of a contact's frame with this Jacobian in world axes, m/s.
fn velocity<T: Scalar>(columns: &[Twist<T>], velocities: &[T]) -> Vector3<T> {
    let moves = columns.iter().zip(velocities).map(|(column, &v)| column.linear.scale(v));
    moves.fold(Vector3::zero(), |sum, velocity| sum + velocity)
}

/// Returns the least speed of a contact along its normal after a step of `dt` seconds, m/s.
///
/// `height` is the height above the ground before the step, m. `before` is the speed along the normal, and `free` the
/// speed after the step without impulses, m/s. A contact above the ground may reach it. A contact in the ground leaves it
/// at `beta` times its depth. A contact that would pass the ground leaves it with `restitution` times its speed, unless
/// that is below 0.01 m/s.
fn least_speed<T: Scalar>(
    target: &ContactTarget<T>,
    height: T,
    (before, free): (T, T),
    dt: T,
) -> T {
    let gain = height.select_nonnegative(dt.recip(), return_rate(target.beta, dt));
    let least = -(height * gain);
    let rebound = -(target.restitution * before);
    let faster = rebound - least;
    let bounced = faster.select_nonnegative(rebound, least);
    let bounces = rebound - T::from_f64(0.01);
    let bounced = bounces.select_nonnegative(bounced, least);
    (least - free).select_nonnegative(bounced, least)
}
