//! The velocities that the ground and joint stops allow after a step.

use super::ground::Row;
use crate::Scalar;
use crate::constraint_settings::ContactTarget;
use crate::scalar::positive;

/// Returns the range of the velocity after a step of `dt` seconds of a joint at the coordinate `at`
/// within `limits`, rad or m; limits may be infinite.
///
/// A joint within its limits may reach them. A joint beyond a limit returns at `beta` (1/s) times
/// its distance.
#[inline(always)]
#[must_use]
pub fn velocity_range<T: Scalar>(at: T, limits: [f64; 2], beta: T, dt: T) -> [T; 2] {
    let (below, above) = (T::from_f64(limits[0]) - at, T::from_f64(limits[1]) - at);
    [
        below * (-below).select_nonnegative(dt.recip(), return_rate(beta, dt)),
        above * above.select_nonnegative(dt.recip(), return_rate(beta, dt)),
    ]
}

/// A speed towards the ground that no contact reaches, m/s.
const UNREACHED: f64 = 1e6;

/// Returns the least speed of a contact along its normal after a step, m/s, without an impulse.
///
/// `height` is the height above the ground before the step, m. `before` is the speed along the
/// normal, and `free` the speed after the step without impulses, m/s; the step takes `dt` seconds.
/// A contact that would pass the ground leaves it with `restitution` times its speed, unless that
/// is below 0.01 m/s.
///
/// A rigid contact above the ground may reach it. A rigid contact in the ground leaves it at `beta`
/// times its depth. A contact with `compliance` is free above the ground, and accelerates by -2
/// alpha v - beta^2 h at least in the ground; the impulse's own effect is in [`soften`].
#[inline(always)]
pub(crate) fn least_speed<T: Scalar>(
    [height, before, free, dt]: [T; 4],
    [alpha, beta, compliance, restitution]: [T; 4],
) -> T {
    let gain = height.select_nonnegative(dt.recip(), return_rate(beta, dt));
    let rigid = -(height * gain);
    // A step damps at most the whole speed, and undoes at most the whole depth.
    let kept = T::one() - T::from_f64(2.0) * alpha * dt;
    let kept = before * positive(kept);
    let pushed = kept - height * return_rate(beta * beta * dt, dt);
    let compliant = height.select_nonnegative(T::from_f64(-UNREACHED), pushed);
    let least = (-compliance).select_nonnegative(rigid, compliant);
    let rebound = -(restitution * before);
    // NaN selects the number that it is in.
    let faster = (least - rebound).select_nonnegative(least, rebound);
    let bounced = (T::from_f64(0.01) - rebound).select_nonnegative(least, faster);
    (least - free).select_nonnegative(bounced, least)
}

/// Returns the velocity of a contact after the step without impulses, m/s, less the least speed
/// along its normal. `motion` are the height and the speed along the normal before the step, and
/// the time step.
#[inline(always)]
pub(crate) fn relative_velocity<T: Scalar>(
    [x, y, z]: [T; 3],
    [height, before, dt]: [T; 3],
    target: &ContactTarget<T>,
) -> [T; 3] {
    let least = least_speed([height, before, z, dt], normal_law(target));
    [x, y, z - least]
}

/// Returns the numbers of [`least_speed`] that belong to a target.
#[inline(always)]
pub(crate) fn normal_law<T: Scalar>(target: &ContactTarget<T>) -> [T; 4] {
    [target.alpha, target.beta, target.compliance, target.restitution]
}

impl<T: Scalar> ContactTarget<T> {
    /// Returns this target with a compliant contact that moves as MuJoCo's with `solref` =
    /// (`time_constant`, `damping_ratio`), in s and without unit, and with `solimp` whose impedance
    /// is `impedance` at all depths.
    ///
    /// `mobility` is the inverse of the mass that the contact moves along its normal, 1/kg: MuJoCo
    /// takes `body_invweight0`, an entry of the diagonal of
    /// [`contact_problem`](crate::Robot::contact_problem)'s `mobility` serves as well. Friction
    /// stays rigid, as with a large `impratio`.
    ///
    /// ```
    /// use modyn_runtime::ContactTarget;
    ///
    /// let ground = ContactTarget::<f64>::GROUND.compliant([0.02, 1.0], 0.9, 0.1);
    /// assert!((ground.alpha - 1.0 / (0.9 * 0.02)).abs() < 1e-12);
    /// // 3 kg sink by compliance times force / beta^2.
    /// let depth = ground.compliance * 3.0 * 9.81 / (ground.beta * ground.beta);
    /// assert!((depth - 1.177e-4).abs() < 1e-7);
    /// ```
    ///
    /// Source: MuJoCo's documentation, "Computation", solver parameters.
    #[must_use]
    pub fn compliant(
        self,
        [time_constant, damping_ratio]: [T; 2],
        impedance: T,
        mobility: T,
    ) -> Self {
        Self {
            alpha: (impedance * time_constant).recip(),
            beta: (impedance.sqrt() * time_constant * damping_ratio).recip(),
            compliance: mobility * (T::one() - impedance) * impedance.recip(),
            ..self
        }
    }
}

/// Adds the change of the velocities by an impulse, from that by a unit impulse.
#[inline(always)]
pub(crate) fn add_scaled<T: Scalar>(velocities: &mut [T], impulse: T, response: &[T]) {
    for (velocity, &by_unit) in velocities.iter_mut().zip(response) {
        *velocity = by_unit.mul_add(impulse, *velocity);
    }
}

/// Adds the compliance of contacts along their normals.
pub(crate) fn soften<T: Scalar, R: Row<T>>(targets: &[ContactTarget<T>], matrix: &mut [R]) {
    for (c, target) in targets.iter().enumerate() {
        let row = 3 * c + 2;
        let entry = &mut matrix[row].as_mut()[row];
        *entry = *entry + target.compliance;
    }
}

/// Returns the speed per depth at which a step of `dt` seconds resolves a violation: `beta`, at
/// most 1 / `dt`.
#[inline(always)]
fn return_rate<T: Scalar>(beta: T, dt: T) -> T {
    let per_step = dt.recip();
    (beta - per_step).select_nonnegative(per_step, beta)
}
