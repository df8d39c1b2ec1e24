//! The velocities that the ground and joint stops allow after a step.

use super::ground::Row;
use crate::Scalar;
use crate::constraint_settings::ContactTarget;

/// Returns the range of the velocity after a step of `dt` seconds of a joint at the coordinate `at` within `limits`, rad or m;
/// limits may be infinite.
///
/// A joint within its limits may reach them. A joint beyond a limit returns at `beta` (1/s) times its distance.
#[inline(always)]
#[must_use]
pub fn velocity_range<T: Scalar>(at: T, limits: [f64; 2], beta: T, dt: T) -> [T; 2] {
    let (below, above) = (T::from_f64(limits[0]) - at, T::from_f64(limits[1]) - at);
    [
        below * (-below).select_nonnegative(dt.recip(), return_rate(beta, dt)),
        above * above.select_nonnegative(dt.recip(), return_rate(beta, dt)),
    ]
}

/// Returns the least speed of a contact along its normal after a step, m/s.
///
/// `height` is the height above the ground before the step, m. `before` is the speed along the normal, and `free` the
/// speed after the step without impulses, m/s; the step takes `dt` seconds. A contact above the ground may reach it. A contact in the
/// ground leaves it at `beta` times its depth. A contact that would pass the ground leaves it with `restitution` times its speed,
/// unless that is below 0.01 m/s.
#[inline(always)]
pub(crate) fn least_speed<T: Scalar>(
    [height, before, free, dt]: [T; 4],
    beta: T,
    restitution: T,
) -> T {
    let gain = height.select_nonnegative(dt.recip(), return_rate(beta, dt));
    let least = -(height * gain);
    let rebound = -(restitution * before);
    let faster = rebound - least;
    let bounced = faster.select_nonnegative(rebound, least);
    let bounces = rebound - T::from_f64(0.01);
    let bounced = bounces.select_nonnegative(bounced, least);
    (least - free).select_nonnegative(bounced, least)
}

/// Returns the velocity of a contact after the step without impulses, m/s, less the least speed along its normal. `motion` are the height
/// and the speed along the normal before the step, and the time step.
#[inline(always)]
pub(crate) fn relative_velocity<T: Scalar>(
    [x, y, z]: [T; 3],
    [height, before, dt]: [T; 3],
    target: &ContactTarget<T>,
) -> [T; 3] {
    let least = least_speed([height, before, z, dt], target.beta, target.restitution);
    [x, y, z - least]
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

/// Returns the speed per depth at which a step of `dt` seconds resolves a violation: `beta`, at most 1 / `dt`.
#[inline(always)]
fn return_rate<T: Scalar>(beta: T, dt: T) -> T {
    let per_step = dt.recip();
    (per_step - beta).select_nonnegative(beta, per_step)
}
