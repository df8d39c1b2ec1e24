//! Floating joints: any motion, by a position in front of the joint, a unit quaternion, and the
//! velocities behind the joint, linear before angular.

use super::{ParentMotion, spherical};
use crate::Scalar;
use crate::spatial::{Field, Vector3};

/// `displacement` is the joint's, in the axes behind it.
pub(super) fn accelerate<S: Scalar>(
    displacement: Vector3<S>,
    carried: ParentMotion<S>,
    rates: &[S],
    accelerations: Option<&[S]>,
) -> Field<S> {
    let in_front = Field::rotating(carried.omega, carried.alpha);
    let field = spherical::accelerate(carried, &rates[3..], accelerations.map(|own| &own[3..]));
    // The rates are in axes that turn with field.omega, of a motion relative to axes that turn
    // with carried.omega.
    let velocity = Vector3([rates[0], rates[1], rates[2]]);
    let mut a = carried.a + in_front.relative_acceleration(displacement);
    a += (carried.omega + field.omega).cross(velocity);
    if let Some(own) = accelerations {
        a += Vector3([own[0], own[1], own[2]]);
    }
    Field { a, ..field }
}
