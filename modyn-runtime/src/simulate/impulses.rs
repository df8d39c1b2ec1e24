//! Impulses of unilateral constraints: contacts with Coulomb friction, and joint stops.
//!
//! Each sweep visits every contact and every stop once and corrects its impulse, with the other impulses as they are at
//! that moment (projected Gauss-Seidel; Jourdan, Alart and Jean 1998, "A Gauss-Seidel like algorithm to solve frictional
//! contact problems"). The velocities v = v_0 + I^-1 J^T p are updated with each correction, so J I^-1 J^T is never
//! stored. A correction divides by the diagonal of that matrix:
//!
//! ```text
//! normal      p_n <- max(0, p_n - (n . u + c p_n - b) / (n^T A n + c))
//! tangential  p_t <- p_t - u_t / (tr A - n^T A n), shortened to the length friction p_n
//! ```
//!
//! with the velocity u of the contact relative to the ground, its 3 x 3 block A = J I^-1 J^T, the compliance c and the
//! least speed b along the normal n. The divisor of the tangential step is the trace of A within the plane, which bounds
//! its eigenvalues.

use crate::spatial::{Twist, Vector3};
use crate::{ContactTarget, Scalar};

/// A contact during a step.
#[derive(Clone, Copy, Debug)]
pub struct Touch<'a, T> {
    /// The Jacobian of the contact's frame, a column for each velocity, in world axes.
    pub columns: &'a [Twist<T>],
    /// The changes of the velocities by unit impulses along x, y and z: I^-1 J^T.
    pub responses: [&'a [T]; 3],
    /// The normal of the ground, away from the ground.
    pub normal: Vector3<T>,
    /// The velocity of the ground at the contact, m/s.
    pub ground: Vector3<T>,
    /// The least speed along the normal relative to the ground after the step, m/s.
    pub least_speed: T,
    /// The coefficient of friction.
    pub friction: T,
    /// The relative velocity that the contact allows per impulse, 1/kg.
    pub compliance: T,
}

/// A joint stop during a step: the range of one entry of the velocities.
#[derive(Clone, Copy, Debug)]
pub struct Stop<'a, T> {
    /// The index of the velocity.
    pub entry: usize,
    /// The changes of the velocities by a unit impulse: a column of the inverse mass matrix.
    pub response: &'a [T],
    /// The lowest and the highest velocity after the step, rad/s or m/s; may be infinite.
    pub range: [T; 2],
}

impl<'a, T: Scalar> Touch<'a, T> {
    /// Returns a contact with the plane, the velocity and the compliance of this target. Its least speed is zero.
    #[must_use]
    pub fn new(
        target: &ContactTarget<T>,
        columns: &'a [Twist<T>],
        responses: [&'a [T]; 3],
        friction: T,
    ) -> Self {
        Self {
            columns,
            responses,
            normal: Vector3(target.pose.rotation.map(|row| row[2])),
            ground: target.velocity.linear,
            least_speed: T::zero(),
            friction,
            compliance: target.compliance,
        }
    }
}

impl<T: Scalar> Touch<'_, T> {
    /// Returns the velocity of the contact relative to the ground, in world axes.
    #[must_use]
    pub fn velocity(&self, velocities: &[T]) -> Vector3<T> {
        let moves = self.columns.iter().zip(velocities).map(|(column, &v)| column.linear.scale(v));
        moves.fold(-self.ground, |sum, velocity| sum + velocity)
    }

    /// Corrects the impulse, and the velocities with it.
    fn correct(&self, velocities: &mut [T], impulse: &mut Vector3<T>) {
        let block: [Vector3<T>; 3] = self.responses.map(|response| {
            let moves =
                self.columns.iter().zip(response).map(|(column, &v)| column.linear.scale(v));
            moves.fold(Vector3::zero(), |sum, velocity| sum + velocity)
        });
        let normal = self.normal;
        let along = (0..3).fold(T::zero(), |sum, k| sum + normal[k] * normal.dot(block[k]));
        let trace = (0..3).fold(T::zero(), |sum, k| sum + block[k][k]);

        let before = normal.dot(*impulse);
        let missing =
            self.least_speed - normal.dot(self.velocity(velocities)) - self.compliance * before;
        let pressed = before + missing * (along + self.compliance).recip();
        let pressed = pressed.select_nonnegative(pressed, T::zero());
        self.apply(normal.scale(pressed - before), velocities, impulse);

        let slip = self.velocity(velocities);
        let slip = slip - normal.scale(normal.dot(slip));
        let held = *impulse - normal.scale(pressed) - slip.scale((trace - along).recip());
        let (length, most) = (held.dot(held).sqrt(), self.friction * pressed);
        // At length zero the first choice applies, so nothing is divided by zero.
        let sticks = most - length;
        let part = most * sticks.select_nonnegative(T::one(), length).recip();
        let part = sticks.select_nonnegative(T::one(), part);
        let held = held.scale(part);
        self.apply(normal.scale(pressed) + held - *impulse, velocities, impulse);
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

impl<T: Scalar> Stop<'_, T> {
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

/// Adds the velocity changes of the impulses of contacts (N s, in world axes) and joint stops (N m s or N s) to
/// `velocities`, by this number of sweeps from these impulses on, whose changes the velocities must include.
pub fn apply_impulses<T: Scalar>(
    (touches, impulses): (&[Touch<'_, T>], &mut [Vector3<T>]),
    (stops, stop_impulses): (&[Stop<'_, T>], &mut [T]),
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

/// Returns the least speed of a contact along its normal after a step of `dt` seconds, m/s.
///
/// `height` is the height above the ground before the step, `before` the speed along the normal, and `free` the speed
/// after the step without impulses. A contact above the ground may reach it. A contact in the ground leaves it at `beta`
/// times its depth. A contact that would pass the ground leaves it with `restitution` times its speed, unless that is
/// below 0.01 m/s.
pub fn least_speed<T: Scalar>(
    (height, before, free): (T, T, T),
    (beta, restitution): (T, T),
    dt: T,
) -> T {
    let per_step = dt.recip();
    // The smaller of the two.
    let gain = (per_step - beta).select_nonnegative(beta, per_step);
    let least = -(height * height.select_nonnegative(per_step, gain));
    let rebound = -(restitution * before);
    let faster = rebound - least;
    let bounced = faster.select_nonnegative(rebound, least);
    let bounces = rebound - T::from_f64(0.01);
    let bounced = bounces.select_nonnegative(bounced, least);
    (least - free).select_nonnegative(bounced, least)
}
