//! Floating joints: any motion. The coordinates are a position in the parent frame and a unit
//! quaternion. The velocities are in the child frame, linear before angular.

use super::{ParentMotion, spherical};
use crate::Scalar;
use crate::spatial::{Field, Vector3};

/// Returns the motion of the child frame. `displacement` is the joint's, in the child's axes.
pub(super) fn accelerate<S: Scalar>(
    displacement: Vector3<S>,
    from_parent: ParentMotion<S>,
    rates: &[S],
    accelerations: Option<&[S]>,
) -> Field<S> {
    let parent = Field::rotating(from_parent.omega, from_parent.alpha);
    let field =
        spherical::accelerate(from_parent, &rates[3..], accelerations.map(|numbers| &numbers[3..]));
    // The rates are in axes that rotate with field.omega. They are relative to axes that rotate
    // with from_parent.omega.
    let velocity = Vector3([rates[0], rates[1], rates[2]]);
    let mut a = from_parent.a + parent.relative_acceleration(displacement);
    a += (from_parent.omega + field.omega).cross(velocity);
    if let Some(numbers) = accelerations {
        a += Vector3([numbers[0], numbers[1], numbers[2]]);
    }
    Field { a, ..field }
}
