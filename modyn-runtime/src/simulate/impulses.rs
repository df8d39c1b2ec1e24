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

/// The velocities that are wrong after the sweeps: the largest corrections that another visit of a single contact or stop
/// would make. Both are zero if the impulses solve the equations of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual<T = f64> {
    /// The largest correction of a contact's velocity, m/s. Within the plane it is an upper bound of the correction.
    pub contacts: T,
    /// The largest correction of the velocity of a joint at a stop, rad/s or m/s.
    pub stops: T,
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
        let normal = self.normal;
        let pressed = self.pressed(velocities, *impulse);
        self.apply(normal.scale(pressed - normal.dot(*impulse)), velocities, impulse);
        let friction = self.friction(velocities, *impulse - normal.scale(pressed), pressed);
        self.apply(normal.scale(pressed) + friction - *impulse, velocities, impulse);
    }

    /// Returns the correction of the velocity that [`correct`](Self::correct) would make: the larger of those along the
    /// normal and within the plane, m/s.
    fn residual(&self, velocities: &[T], impulse: Vector3<T>) -> T {
        let (normal, [along, across]) = (self.normal, self.mobilities);
        let (before, pressed) = (normal.dot(impulse), self.pressed(velocities, impulse));
        let tangential = impulse - normal.scale(before);
        let change = self.friction(velocities, tangential, pressed) - tangential;
        let sliding = change.dot(change).sqrt() * across;
        ((pressed - before).abs() * (along + self.compliance)).max(sliding)
    }

    /// Returns the corrected impulse along the normal.
    fn pressed(&self, velocities: &[T], impulse: Vector3<T>) -> T {
        let (normal, [along, _]) = (self.normal, self.mobilities);
        let before = normal.dot(impulse);
        let missing =
            self.least_speed - normal.dot(self.velocity(velocities)) - self.compliance * before;
        let pressed = before + missing * (along + self.compliance).recip();
        pressed.select_nonnegative(pressed, T::zero())
    }

    /// Returns the corrected impulse within the plane, where it is `before`, beside the impulse `pressed` along the normal.
    fn friction(&self, velocities: &[T], before: Vector3<T>, pressed: T) -> Vector3<T> {
        let (normal, [_, across]) = (self.normal, self.mobilities);
        let slip = self.velocity(velocities);
        let slip = slip - normal.scale(normal.dot(slip));
        let friction = before - slip.scale(across.recip());
        let (length, most) = (friction.dot(friction).sqrt(), self.friction * pressed);
        // At length zero the first choice applies, so nothing is divided by zero.
        let sticks = most - length;
        let part = most * sticks.select_nonnegative(T::one(), length).recip();
        let part = sticks.select_nonnegative(T::one(), part);
        friction.scale(part)
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
        let next = self.next(velocities, *impulse);
        let change = next - *impulse;
        *impulse = next;
        for (velocity, &by_unit) in velocities.iter_mut().zip(self.response) {
            *velocity = *velocity + by_unit * change;
        }
    }

    /// Returns the correction of the velocity that [`correct`](Self::correct) would make, rad/s or m/s.
    fn residual(&self, velocities: &[T], impulse: T) -> T {
        (self.next(velocities, impulse) - impulse).abs() * self.response[self.entry]
    }

    /// Returns the corrected impulse.
    fn next(&self, velocities: &[T], impulse: T) -> T {
        let per_unit = self.response[self.entry].recip();
        let [up, down] =
            self.range.map(|bound| impulse + (bound - velocities[self.entry]) * per_unit);
        // At most one of the two is not zero, since the range is not empty.
        up.select_nonnegative(up, T::zero()) + (-down).select_nonnegative(down, T::zero())
    }
}

/// Corrects the impulses of contacts (N s, in world axes) and joint stops (N m s or N s) in `sweeps` sweeps, and
/// adds the resulting changes to `velocities`. On entry, `velocities` must include the effect of the given
/// impulses. Returns what is still wrong.
pub fn apply_impulses<T: Scalar>(
    (touches, impulses): (&[StepContact<'_, T>], &mut [Vector3<T>]),
    (stops, stop_impulses): (&[JointStop<'_, T>], &mut [T]),
    sweeps: usize,
    velocities: &mut [T],
) -> Residual<T> {
    for _ in 0..sweeps {
        for (stop, impulse) in stops.iter().zip(&mut *stop_impulses) {
            stop.correct(velocities, impulse);
        }
        for (touch, impulse) in touches.iter().zip(&mut *impulses) {
            touch.correct(velocities, impulse);
        }
    }
    let of_contacts =
        touches.iter().zip(&*impulses).map(|(touch, impulse)| touch.residual(velocities, *impulse));
    let of_stops = stops
        .iter()
        .zip(&*stop_impulses)
        .map(|(stop, impulse)| stop.residual(velocities, *impulse));
    Residual {
        contacts: of_contacts.fold(T::zero(), Scalar::max),
        stops: of_stops.fold(T::zero(), Scalar::max),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of joints at their lower stops that move on; each joint pushes its neighbours on.
    #[test]
    fn the_residual_of_stops_falls_with_the_sweeps() {
        const N: usize = 12;
        // The inverse mass matrix of masses between springs: its condition is that of a fine mesh.
        let inverse: [[f64; N]; N] = core::array::from_fn(|i| {
            core::array::from_fn(|j| match i.abs_diff(j) {
                0 => 2.0,
                1 => -1.0,
                _ => 0.0,
            })
        });
        let solve = |sweeps: usize| {
            let stops: [JointStop<'_, f64>; N] = core::array::from_fn(|i| {
                JointStop::new((i, &inverse[i]), (0.0, [0.0, f64::INFINITY]), 20.0, 0.001)
            });
            let (mut velocities, mut impulses) = ([-1.0; N], [0.0; N]);
            let found =
                apply_impulses((&[], &mut []), (&stops, &mut impulses), sweeps, &mut velocities);
            assert_eq!(found.contacts, 0.0);
            // An impulse without a velocity, or a velocity beyond the limit: what complementarity forbids.
            let wrong = velocities.iter().zip(impulses).map(|(&velocity, impulse)| {
                assert!(impulse >= 0.0);
                velocity.min(2.0 * impulse).abs()
            });
            let wrong = wrong.fold(0.0, f64::max);
            assert!((found.stops - wrong).abs() < 1e-12, "{} is not {wrong}", found.stops);
            found.stops
        };
        let residuals = [0, 1, 5, 50, 500].map(solve);
        assert!(residuals[0] == 1.0 && residuals.is_sorted_by(|a, b| a > b), "{residuals:?}");
        assert!(residuals[3] > 0.01 && residuals[4] < 1e-6, "{residuals:?}");
    }

    /// A mass of 2 kg slides on the ground: after one visit of its only contact, nothing is wrong.
    #[test]
    fn the_residual_of_a_contact_is_its_wrong_velocity() {
        let columns: [Twist<f64>; 3] = core::array::from_fn(|k| Twist {
            angular: Vector3::zero(),
            linear: Vector3(core::array::from_fn(|i| if i == k { 1.0 } else { 0.0 })),
        });
        let responses: [[f64; 3]; 3] =
            core::array::from_fn(|k| core::array::from_fn(|i| if i == k { 0.5 } else { 0.0 }));
        let mut velocities = [1.0, 0.0, -0.3];
        let free = velocities;
        let contact = StepContact::new(
            &ContactTarget::<f64>::GROUND,
            (&columns, responses.each_ref().map(|response| &response[..])),
            (Twist::zero(), Twist::zero()),
            FreeMotion { dt: 0.001, velocities: &free },
            0.8,
        );
        let mut solve = |sweeps| {
            let mut impulses = [Vector3::zero()];
            velocities = free;
            apply_impulses((&[contact], &mut impulses), (&[], &mut []), sweeps, &mut velocities)
        };
        // Friction of 0.8 times the normal impulse of 0.6 N s slows the block by 0.24 m/s; the bound is twice that.
        assert!((solve(0).contacts - 0.48).abs() < 1e-12, "{:?}", solve(0));
        assert!(solve(1).contacts < 1e-12, "{:?}", solve(1));
        assert_eq!(solve(1).stops, 0.0);
    }
}
