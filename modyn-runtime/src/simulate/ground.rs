//! Forces of a soft ground, and joint forces within their limits.

use crate::scalar::{at_least, at_most, positive};
use crate::spatial::{Pose, Vector3};
use crate::{Array, Robot, Scalar};

/// Returns the joint forces within the effort limits of the description, N m or N.
#[must_use]
pub fn limit_effort<R: Robot, T: Scalar>(tau: &R::V<T>) -> R::V<T> {
    R::V::<T>::from_fn(|i| {
        let most = T::from_f64(R::LIMITS.effort[i]);
        // NaN stays NaN.
        at_least(at_most(tau.as_ref()[i], most), -most)
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
        let pressure = positive(self.stiffness * depth - self.damping * speed);
        let pressed = (-depth).select_nonnegative(T::zero(), pressure);
        let sliding = velocity - normal.scale(speed);
        let drag =
            self.friction * pressed * (sliding.dot(sliding) + self.slip * self.slip).sqrt().recip();
        normal.scale(pressed) - sliding.scale(drag)
    }
}
