//! The acceleration field of a rigid body.

use super::{Matrix3, RigidInertia, Vector3, Wrench};
use crate::Scalar;

/// The angular velocity and acceleration of a body, and the acceleration of its points: a + E r at
/// r, with E = alpha x + omega x omega x. All are classical, in the body's axes, about its origin.
#[derive(Clone, Copy, Debug)]
pub struct Field<S> {
    /// The angular velocity, rad/s.
    pub omega: Vector3<S>,
    /// The angular acceleration, rad/s^2.
    pub alpha: Vector3<S>,
    /// The classical acceleration of the origin, m/s^2.
    pub a: Vector3<S>,
    /// E.
    pub(crate) gradient: Matrix3<S>,
    /// E_zz - E_yy, E_xx - E_zz, E_yy - E_xx.
    pub(crate) differences: Vector3<S>,
}

impl<S: Scalar> Field<S> {
    /// Returns the field of a body at rest.
    #[must_use]
    pub fn zero() -> Self {
        let zero = Vector3::zero();
        Self { omega: zero, alpha: zero, a: zero, gradient: Matrix3::zero(), differences: zero }
    }

    /// Returns the field of a rotation about an origin that is not accelerated.
    #[must_use]
    pub fn rotating(omega: Vector3<S>, alpha: Vector3<S>) -> Self {
        let [x, y, z] = omega.0;
        let xx = x * x;
        let yy = y * y;
        let zz = z * z;
        let xy = x * y;
        let xz = x * z;
        let yz = y * z;
        Self {
            omega,
            alpha,
            a: Vector3::zero(),
            gradient: Matrix3([
                [-(yy + zz), xy - alpha[2], xz + alpha[1]],
                [xy + alpha[2], -(xx + zz), yz - alpha[0]],
                [xz - alpha[1], yz + alpha[0], -(xx + yy)],
            ]),
            differences: Vector3([zz - yy, xx - zz, yy - xx]),
        }
    }

    /// Returns the acceleration of the point at `r` relative to the origin's: E r.
    #[must_use]
    pub fn relative_acceleration(&self, r: Vector3<S>) -> Vector3<S> {
        self.gradient.mul_vector(r)
    }

    /// Returns the acceleration of the point at `z` on the z axis relative to the origin's.
    #[must_use]
    pub fn relative_acceleration_along_z(&self, z: S) -> Vector3<S> {
        self.gradient.column(2).scale(z)
    }

    /// Returns the wrench that gives a rigid body this motion: F = m a + E c, and N = c x a plus
    /// the axial vector of E S - (E S)^T.
    #[must_use]
    pub fn wrench(&self, body: &RigidInertia<S>) -> Wrench<S> {
        let e = &self.gradient.0;
        let d = self.differences;
        let s = &body.second_moment;
        let about_origin = Vector3([
            e[2][0] * s.xy - e[1][0] * s.xz + e[2][1] * s.yy - e[1][2] * s.zz + s.yz * d[0],
            e[0][1] * s.yz - e[2][1] * s.xy + e[0][2] * s.zz - e[2][0] * s.xx + s.xz * d[1],
            e[1][0] * s.xx - e[0][1] * s.yy + e[1][2] * s.xz - e[0][2] * s.yz + s.xy * d[2],
        ]);
        Wrench {
            moment: about_origin + body.first_moment.cross(self.a),
            force: self.a.scale(body.mass) + self.gradient.mul_vector(body.first_moment),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Field;
    use crate::spatial::{RigidInertia, Symmetric3, Vector3};

    #[test]
    fn the_wrench_is_that_of_the_points_of_the_body() {
        let points = [
            (0.7, Vector3([0.3, -0.2, 0.5])),
            (1.1, Vector3([-0.4, 0.6, 0.1])),
            (0.4, Vector3([0.2, 0.9, -0.8])),
        ];
        let omega = Vector3([0.5, -1.3, 0.8]);
        let alpha = Vector3([2.0, 0.3, -0.7]);
        let field = Field { a: Vector3([1.0, 2.0, -3.0]), ..Field::rotating(omega, alpha) };
        let mut body = RigidInertia::<f64>::zero();
        let mut force = Vector3::zero();
        let mut moment = Vector3::zero();
        for (m, r) in points {
            let second_moment = Symmetric3::from_fn(|i, j| m * r[i] * r[j]);
            body = body + RigidInertia { mass: m, first_moment: r.scale(m), second_moment };
            let acceleration = field.a + alpha.cross(r) + omega.cross(omega.cross(r));
            force += acceleration.scale(m);
            moment += r.cross(acceleration).scale(m);
        }
        let wrench = field.wrench(&body);
        for i in 0..3 {
            assert!((wrench.force[i] - force[i]).abs() < 1e-13);
            assert!((wrench.moment[i] - moment[i]).abs() < 1e-13);
        }
    }
}
