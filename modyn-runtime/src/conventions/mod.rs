//! States to and from other libraries.
//!
//! Everything is in SI units and radians. The same throughout: angles and displacements of revolute
//! and prismatic joints, and the torques and forces along them. What differs is where rotations are
//! involved, and above all the floating joint, whose numbers here are
//!
//! - coordinates `[x, y, z, qx, qy, qz, qw]`: position of the link's origin in the joint's frame (of
//!   a floating base: the world) and unit quaternion from the link to it,
//! - velocities `[vx, vy, vz, wx, wy, wz]`: linear one of the link's origin and angular one, both in
//!   the link's own axes,
//! - accelerations: the rates of these numbers,
//! - forces `[fx, fy, fz, mx, my, mz]`: such that force times velocity is power.
//!
//! There is a module for each library, with functions that are called after the library's own names:
//! `to_...` from modyn's numbers to the library's, `from_...` back. All are generic over [`Scalar`],
//! so that they can be compiled and differentiated as well. Quaternions must have length one.
//!
//! ```
//! use modyn_runtime::conventions::mujoco;
//!
//! // Upside down (half a turn about x), the base moves along its own z axis: downwards.
//! let q = [0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0];
//! let qd = [0.0, 0.0, 2.0, 0.0, 0.0, 0.0];
//! assert_eq!(mujoco::to_qpos(q), [0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0]);
//! assert_eq!(mujoco::to_qvel(q, qd), [0.0, 0.0, -2.0, 0.0, 0.0, 0.0]);
//! ```

use crate::Scalar;
use crate::spatial::{Quaternion, Vector3};

/// A quaternion that ends with its real part, from one that starts with it.
///
/// ```
/// assert_eq!(modyn_runtime::conventions::xyzw_from_wxyz([1.0, 2.0, 3.0, 4.0]), [2.0, 3.0, 4.0, 1.0]);
/// ```
#[must_use]
pub fn xyzw_from_wxyz<T>([w, x, y, z]: [T; 4]) -> [T; 4] {
    [x, y, z, w]
}

/// A quaternion that starts with its real part, from one that ends with it.
///
/// ```
/// assert_eq!(modyn_runtime::conventions::wxyz_from_xyzw([1.0, 2.0, 3.0, 4.0]), [4.0, 1.0, 2.0, 3.0]);
/// ```
#[must_use]
pub fn wxyz_from_xyzw<T>([x, y, z, w]: [T; 4]) -> [T; 4] {
    [w, x, y, z]
}

/// The rotation matrix, by rows, of a unit quaternion `[x, y, z, w]`: what the quaternion turns
/// vectors by.
///
/// ```
/// use modyn_runtime::conventions::rotation_from_quaternion;
///
/// let half_a_turn_about_z = rotation_from_quaternion([0.0, 0.0, 1.0, 0.0]);
/// assert_eq!(half_a_turn_about_z, [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]);
/// ```
#[must_use]
pub fn rotation_from_quaternion<T: Scalar>(quaternion: [T; 4]) -> [[T; 3]; 3] {
    Quaternion::from_components(quaternion).matrix().0
}

/// The unit quaternion `[x, y, z, w]`, w >= 0, of a rotation matrix by rows.
///
/// Exact to rounding for every rotation: the largest of the four numbers is found first.
///
/// ```
/// use modyn_runtime::conventions::quaternion_from_rotation;
///
/// let a_third_of_a_turn = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// assert_eq!(quaternion_from_rotation(a_third_of_a_turn), [0.5, 0.5, 0.5, 0.5]);
/// ```
#[must_use]
pub fn quaternion_from_rotation<T: Scalar>(rotation: [[T; 3]; 3]) -> [T; 4] {
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = rotation;
    let one = T::one();
    let (sxy, sxz, syz) = (xy + yx, xz + zx, yz + zy);
    let (dx, dy, dz) = (zy - yz, xz - zx, yx - xy);
    // The quaternion times four times its first, second, third, fourth number.
    let by_x = [one + xx - yy - zz, sxy, sxz, dx];
    let by_y = [sxy, one - xx + yy - zz, syz, dy];
    let by_z = [sxz, syz, one - xx - yy + zz, dz];
    let by_w = [dx, dy, dz, one + xx + yy + zz];
    let either = |which: T, a: [T; 4], b: [T; 4]| -> [T; 4] {
        core::array::from_fn(|i| which.select_nonnegative(a[i], b[i]))
    };
    let by_xy = either(xx - yy, by_x, by_y);
    let by_zw = either(-(xx + yy), by_z, by_w);
    let largest_xy = (xx - yy).select_nonnegative(by_x[0], by_y[1]);
    let largest_zw = (-(xx + yy)).select_nonnegative(by_z[2], by_w[3]);
    let q = either(largest_xy - largest_zw, by_xy, by_zw);
    let [x, y, z, w] = q;
    let length = (x * x + y * y + z * z + w * w).sqrt();
    let scale = w.select_nonnegative(length, -length).recip();
    q.map(|number| number * scale)
}

/// The rotation of modyn's coordinates: from the link's axes to the joint's.
fn attitude<T: Scalar>(q: [T; 7]) -> Quaternion<T> {
    Quaternion::from_components(quaternion(q))
}

/// The quaternion of modyn's coordinates.
fn quaternion<T>([_, _, _, x, y, z, w]: [T; 7]) -> [T; 4] {
    [x, y, z, w]
}

fn halves<T>([a, b, c, d, e, f]: [T; 6]) -> [Vector3<T>; 2] {
    [Vector3([a, b, c]), Vector3([d, e, f])]
}

fn joined<T>(Vector3([a, b, c]): Vector3<T>, Vector3([d, e, f]): Vector3<T>) -> [T; 6] {
    [a, b, c, d, e, f]
}

/// Pinocchio: the free-flyer is the same as modyn's floating joint, number by number, so is the
/// spherical joint; what differs is the unbounded revolute joint (a continuous one in URDF) and the
/// planar one.
///
/// Source: [the free-flyer's documentation](https://docs.ros.org/en/jazzy/p/pinocchio/generated/function_namespacepinocchio_1aa5005bfe0ffbbdc62952c3c432e4eab7.html):
/// coordinates translation and quaternion x, y, z, w from child to parent; velocities linear and
/// angular in the child's frame, after Featherstone; and `joint-revolute-unbounded.hpp`.
pub mod pinocchio {
    use super::Scalar;

    /// The two coordinates of an unbounded revolute joint, (cos, sin), from the angle in rad.
    #[must_use]
    pub fn cos_sin_from_angle<T: Scalar>(angle: T) -> [T; 2] {
        let (sin, cos) = angle.sin_cos();
        [cos, sin]
    }

    /// The angle in rad, in [-pi, pi], from the two coordinates of an unbounded revolute joint.
    ///
    /// ```
    /// use modyn_runtime::conventions::pinocchio::{angle_from_cos_sin, cos_sin_from_angle};
    ///
    /// assert!((angle_from_cos_sin(cos_sin_from_angle(2.5_f64)) - 2.5).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn angle_from_cos_sin<T: Scalar>([cos, sin]: [T; 2]) -> T {
        sin.atan2(cos)
    }
}

/// MuJoCo: a free joint has `qpos` = position and quaternion w, x, y, z; `qvel` = linear velocity of
/// the body's origin in world axes and angular velocity in the body's; `qacc` the rates of these,
/// so the linear part is the classical acceleration; `qfrc_...` force in world axes and moment in
/// the body's. A ball joint: the quaternion w, x, y, z; angular velocity as modyn's.
///
/// A free joint stands at the top level only, so the joint's frame is the world.
///
/// Sources: MuJoCo's documentation on
/// [floating objects](https://mujoco.readthedocs.io/en/latest/overview.html#floating-objects) and its
/// maintainers in [issue 691](https://github.com/google-deepmind/mujoco/issues/691).
pub mod mujoco {
    use super::{Scalar, attitude, halves, joined, quaternion, wxyz_from_xyzw, xyzw_from_wxyz};

    /// `qpos` of a free joint.
    #[must_use]
    pub fn to_qpos<T: Scalar>(q: [T; 7]) -> [T; 7] {
        let ([x, y, z, ..], [qw, qx, qy, qz]) = (q, wxyz_from_xyzw(quaternion(q)));
        [x, y, z, qw, qx, qy, qz]
    }

    /// A floating joint's coordinates from `qpos`.
    #[must_use]
    pub fn from_qpos<T: Scalar>([x, y, z, qw, qx, qy, qz]: [T; 7]) -> [T; 7] {
        let [qx, qy, qz, qw] = xyzw_from_wxyz([qw, qx, qy, qz]);
        [x, y, z, qx, qy, qz, qw]
    }

    /// `qvel` of a free joint at the coordinates `q` (modyn's, as everywhere here).
    #[must_use]
    pub fn to_qvel<T: Scalar>(q: [T; 7], qd: [T; 6]) -> [T; 6] {
        let [linear, angular] = halves(qd);
        joined(attitude(q).rotate(linear), angular)
    }

    /// A floating joint's velocities from `qvel`.
    #[must_use]
    pub fn from_qvel<T: Scalar>(q: [T; 7], qvel: [T; 6]) -> [T; 6] {
        let [linear, angular] = halves(qvel);
        joined(attitude(q).conjugate().rotate(linear), angular)
    }

    /// `qacc` of a free joint.
    #[must_use]
    pub fn to_qacc<T: Scalar>(q: [T; 7], qd: [T; 6], qdd: [T; 6]) -> [T; 6] {
        let ([v, omega], [rate, angular]) = (halves(qd), halves(qdd));
        joined(attitude(q).rotate(rate + omega.cross(v)), angular)
    }

    /// A floating joint's accelerations from `qacc`; `qd` are modyn's velocities.
    #[must_use]
    pub fn from_qacc<T: Scalar>(q: [T; 7], qd: [T; 6], qacc: [T; 6]) -> [T; 6] {
        let ([v, omega], [linear, angular]) = (halves(qd), halves(qacc));
        joined(attitude(q).conjugate().rotate(linear) - omega.cross(v), angular)
    }

    /// `qfrc_...` of a free joint.
    #[must_use]
    pub fn to_qfrc<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
        to_qvel(q, tau)
    }

    /// A floating joint's forces from `qfrc_...`.
    #[must_use]
    pub fn from_qfrc<T: Scalar>(q: [T; 7], qfrc: [T; 6]) -> [T; 6] {
        from_qvel(q, qfrc)
    }
}

/// Drake: a quaternion floating joint has `q` = quaternion w, x, y, z and position; `v` = angular
/// velocity and linear velocity of the body's origin, both in world axes (those of the joint's frame
/// F); `vdot` the rates of these, so the classical acceleration; `tau` moment and force, in world
/// axes.
///
/// Source: Drake's
/// [`QuaternionFloatingJoint`](https://github.com/RobotLocomotion/drake/blob/master/multibody/tree/quaternion_floating_joint.h):
/// `q_FM`, `p_FM`, and `w_FM`, `v_FM`, expressed in F.
pub mod drake {
    use super::{Scalar, attitude, halves, joined, quaternion, wxyz_from_xyzw, xyzw_from_wxyz};

    /// `q` of a quaternion floating joint.
    #[must_use]
    pub fn to_q<T: Scalar>(q: [T; 7]) -> [T; 7] {
        let ([x, y, z, ..], [qw, qx, qy, qz]) = (q, wxyz_from_xyzw(quaternion(q)));
        [qw, qx, qy, qz, x, y, z]
    }

    /// A floating joint's coordinates from Drake's `q`.
    #[must_use]
    pub fn from_q<T: Scalar>([qw, qx, qy, qz, x, y, z]: [T; 7]) -> [T; 7] {
        let [qx, qy, qz, qw] = xyzw_from_wxyz([qw, qx, qy, qz]);
        [x, y, z, qx, qy, qz, qw]
    }

    /// `v` of a quaternion floating joint at the coordinates `q` (modyn's, as everywhere here).
    #[must_use]
    pub fn to_v<T: Scalar>(q: [T; 7], qd: [T; 6]) -> [T; 6] {
        let [linear, angular] = halves(qd).map(|part| attitude(q).rotate(part));
        joined(angular, linear)
    }

    /// A floating joint's velocities from `v`.
    #[must_use]
    pub fn from_v<T: Scalar>(q: [T; 7], v: [T; 6]) -> [T; 6] {
        let [angular, linear] = halves(v).map(|part| attitude(q).conjugate().rotate(part));
        joined(linear, angular)
    }

    /// `vdot` of a quaternion floating joint.
    #[must_use]
    pub fn to_vdot<T: Scalar>(q: [T; 7], qd: [T; 6], qdd: [T; 6]) -> [T; 6] {
        let ([v, omega], [rate, angular]) = (halves(qd), halves(qdd));
        // omega's own rate is the same in both axes: omega x omega is zero.
        to_v(q, joined(rate + omega.cross(v), angular))
    }

    /// A floating joint's accelerations from `vdot`; `qd` are modyn's velocities.
    #[must_use]
    pub fn from_vdot<T: Scalar>(q: [T; 7], qd: [T; 6], vdot: [T; 6]) -> [T; 6] {
        let ([v, omega], [linear, angular]) = (halves(qd), halves(from_v(q, vdot)));
        joined(linear - omega.cross(v), angular)
    }

    /// `tau` of a quaternion floating joint: moment and force.
    #[must_use]
    pub fn to_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
        to_v(q, tau)
    }

    /// A floating joint's forces from Drake's `tau`.
    #[must_use]
    pub fn from_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
        from_v(q, tau)
    }
}

/// RBDL: a floating base is a `TranslationXYZ` and a `Spherical` joint. `Q` has the position and x,
/// y, z of the quaternion in the joint's six places, w after the coordinates of all joints; `QDot`
/// linear velocity in world axes and angular velocity in the body's; `QDDot` the rates of these, so
/// the linear part is the classical acceleration; `Tau` force in world axes and moment in the body's.
/// A spherical joint alone: the same quaternion, w at the end; angular velocity as modyn's.
///
/// Source: [`rbdl/Joint.h`](https://github.com/rbdl/rbdl/blob/master/include/rbdl/Joint.h), "Joint
/// Singularities" and "Floating-Base Joint", and `rbdl/Quaternion.h`, whose `toMatrix` turns vectors
/// of the world into the body's axes: so the quaternion is that from the body to the world.
pub mod rbdl {
    use super::{Scalar, mujoco};

    /// The six numbers of `Q` in a floating base's own places, and the w that stands behind the
    /// coordinates of all joints: at `Model::multdof3_w_index` of the spherical joint's body.
    #[must_use]
    pub fn to_q<T: Scalar>([x, y, z, qx, qy, qz, qw]: [T; 7]) -> ([T; 6], T) {
        ([x, y, z, qx, qy, qz], qw)
    }

    /// A floating joint's coordinates from `Q`: the six numbers in its own places, and w.
    #[must_use]
    pub fn from_q<T: Scalar>([x, y, z, qx, qy, qz]: [T; 6], qw: T) -> [T; 7] {
        [x, y, z, qx, qy, qz, qw]
    }

    /// `QDot` of a floating base at the coordinates `q` (modyn's, as everywhere here).
    #[must_use]
    pub fn to_qdot<T: Scalar>(q: [T; 7], qd: [T; 6]) -> [T; 6] {
        mujoco::to_qvel(q, qd)
    }

    /// A floating joint's velocities from `QDot`.
    #[must_use]
    pub fn from_qdot<T: Scalar>(q: [T; 7], qdot: [T; 6]) -> [T; 6] {
        mujoco::from_qvel(q, qdot)
    }

    /// `QDDot` of a floating base.
    #[must_use]
    pub fn to_qddot<T: Scalar>(q: [T; 7], qd: [T; 6], qdd: [T; 6]) -> [T; 6] {
        mujoco::to_qacc(q, qd, qdd)
    }

    /// A floating joint's accelerations from `QDDot`; `qd` are modyn's velocities.
    #[must_use]
    pub fn from_qddot<T: Scalar>(q: [T; 7], qd: [T; 6], qddot: [T; 6]) -> [T; 6] {
        mujoco::from_qacc(q, qd, qddot)
    }

    /// `Tau` of a floating base.
    #[must_use]
    pub fn to_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
        mujoco::to_qfrc(q, tau)
    }

    /// A floating joint's forces from `Tau`.
    #[must_use]
    pub fn from_tau<T: Scalar>(q: [T; 7], tau: [T; 6]) -> [T; 6] {
        mujoco::from_qfrc(q, tau)
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;

    fn close<const N: usize>(found: [f64; N], expected: [f64; N], within: f64) {
        for i in 0..N {
            assert!((found[i] - expected[i]).abs() <= within, "{found:?} instead of {expected:?}");
        }
    }

    fn dot(a: [f64; 6], b: [f64; 6]) -> f64 {
        core::array::from_fn::<f64, 6, _>(|i| a[i] * b[i]).iter().sum()
    }

    /// A smooth motion in the joint's frame, which is the world: the coordinates at time `t`.
    fn motion(t: f64) -> [f64; 7] {
        let (s, c) = t.sin_cos();
        let [x, y, z, w] = [0.4 * s, 0.3 + 0.2 * c, 0.5 * t, 0.8 - 0.3 * s];
        let length = Scalar::sqrt(x * x + y * y + z * z + w * w);
        let [x, y, z, w] = [x, y, z, w].map(|number| number / length);
        [s + t, 2.0 * c, t * t - s, x, y, z, w]
    }

    /// The rate of something at `t`.
    fn rate<const N: usize>(t: f64, of: impl Fn(f64) -> [f64; N]) -> [f64; N] {
        let h = 1e-4;
        let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| of(t + k * h));
        core::array::from_fn(|i| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * h))
    }

    /// The angular velocity in world axes by the rotation matrix alone: R' = [omega x] R.
    fn angular(t: f64) -> [f64; 3] {
        let rotation = |t| rotation_from_quaternion(quaternion(motion(t)));
        let r = rotation(t);
        let rates: [[f64; 3]; 3] = core::array::from_fn(|row| rate(t, |t| rotation(t)[row]));
        let entry = |i: usize, j: usize| (0..3).map(|k| rates[i][k] * r[j][k]).sum();
        [entry(2, 1), entry(0, 2), entry(1, 0)]
    }

    /// Linear and angular velocity in world axes.
    fn velocities(t: f64) -> [Vector3<f64>; 2] {
        let [x, y, z, ..] = rate(t, motion);
        [Vector3([x, y, z]), Vector3(angular(t))]
    }

    /// modyn's velocities.
    fn qd(t: f64) -> [f64; 6] {
        let [linear, angular] =
            velocities(t).map(|part| attitude(motion(t)).conjugate().rotate(part));
        joined(linear, angular)
    }

    #[test]
    fn velocities_and_accelerations_are_rates() {
        for t in [-1.0, 0.2, 1.7] {
            let (q, qd, qdd) = (motion(t), qd(t), rate(t, qd));
            let [linear, turning] = velocities(t);
            close(drake::to_v(q, qd), joined(turning, linear), 1e-10);
            close(
                drake::to_vdot(q, qd, qdd),
                rate(t, |t| drake::to_v(motion(t), self::qd(t))),
                1e-6,
            );
            close(mujoco::to_qvel(q, qd), joined(linear, halves(qd)[1]), 1e-10);
            let along = |t| mujoco::to_qvel(motion(t), self::qd(t));
            close(mujoco::to_qacc(q, qd, qdd), rate(t, along), 1e-6);
            close(rbdl::to_qdot(q, qd), joined(linear, halves(qd)[1]), 1e-10);
            let along = |t| rbdl::to_qdot(motion(t), self::qd(t));
            close(rbdl::to_qddot(q, qd, qdd), rate(t, along), 1e-6);
            // The body's angular velocity by the quaternion's rate: 2 conj(q) q'.
            let ([x, y, z, w], [_, _, _, dx, dy, dz, dw]) = (quaternion(q), rate(t, motion));
            let omega = [
                w * dx - x * dw - (y * dz - z * dy),
                w * dy - y * dw - (z * dx - x * dz),
                w * dz - z * dw - (x * dy - y * dx),
            ];
            close(halves(qd)[1].0, omega.map(|number| 2.0 * number), 1e-10);
        }
    }

    #[test]
    fn there_and_back() {
        for t in [-1.0, 0.2, 1.7] {
            let (q, qd) = (motion(t), qd(t));
            let x = [1.0, -2.0, 3.0, 0.5, 0.7, -1.1];
            assert_eq!(mujoco::from_qpos(mujoco::to_qpos(q)), q);
            assert_eq!(drake::from_q(drake::to_q(q)), q);
            let (six, w) = rbdl::to_q(q);
            assert_eq!(rbdl::from_q(six, w), q);
            for back in [
                mujoco::from_qvel(q, mujoco::to_qvel(q, x)),
                mujoco::from_qacc(q, qd, mujoco::to_qacc(q, qd, x)),
                mujoco::from_qfrc(q, mujoco::to_qfrc(q, x)),
                drake::from_v(q, drake::to_v(q, x)),
                drake::from_vdot(q, qd, drake::to_vdot(q, qd, x)),
                drake::from_tau(q, drake::to_tau(q, x)),
                rbdl::from_qdot(q, rbdl::to_qdot(q, x)),
                rbdl::from_qddot(q, qd, rbdl::to_qddot(q, qd, x)),
                rbdl::from_tau(q, rbdl::to_tau(q, x)),
            ] {
                close(back, x, 1e-14);
            }
        }
    }

    #[test]
    fn power_is_the_same() {
        for t in [-1.0, 0.2, 1.7] {
            let (q, qd, tau) = (motion(t), qd(t), [1.0, -2.0, 3.0, 0.5, 0.7, -1.1]);
            let power = dot(tau, qd);
            for found in [
                dot(mujoco::to_qfrc(q, tau), mujoco::to_qvel(q, qd)),
                dot(drake::to_tau(q, tau), drake::to_v(q, qd)),
                dot(rbdl::to_tau(q, tau), rbdl::to_qdot(q, qd)),
            ] {
                assert!((found - power).abs() < 1e-14, "{found} {power}");
            }
        }
    }

    /// Each number in each place.
    #[test]
    fn orders() {
        let q = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        assert_eq!(mujoco::to_qpos(q), [1.0, 2.0, 3.0, 7.0, 4.0, 5.0, 6.0]);
        assert_eq!(drake::to_q(q), [7.0, 4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
        assert_eq!(rbdl::to_q(q), ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 7.0));
    }

    #[test]
    fn quaternions_come_back_from_their_rotations() {
        let numbers = [-1.0, -0.6, -1e-5, -1e-9, 0.0, 1e-9, 1e-5, 0.6, 1.0];
        for i in 1..numbers.len().pow(4) {
            let digit = |place: u32| numbers[i / numbers.len().pow(place) % numbers.len()];
            let q = [digit(0), digit(1), digit(2), digit(3)];
            let length = Scalar::sqrt(q.iter().map(|x| x * x).sum::<f64>());
            if length == 0.0 {
                continue;
            }
            let q = q.map(|x| x / length);
            let found = quaternion_from_rotation(rotation_from_quaternion(q));
            assert!(found[3] >= 0.0);
            let opposite: f64 = (0..4).map(|i| found[i] * q[i]).sum();
            close(found, q.map(|x| if opposite < 0.0 { -x } else { x }), 1e-15);
        }
    }

    #[test]
    fn rotations_turn_by_the_right_hand() {
        // Sixty degrees about each axis.
        let (s, c) = (PI / 6.0).sin_cos();
        let (sin, cos) = (PI / 3.0).sin_cos();
        for axis in 0..3 {
            let mut q = [0.0, 0.0, 0.0, c];
            q[axis] = s;
            let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
            let mut v = [0.0; 3];
            v[next] = 1.0;
            let mut expected = [0.0; 3];
            (expected[next], expected[last]) = (cos, sin);
            let turn = Quaternion::from_components(q);
            close(turn.rotate(Vector3(v)).0, expected, 1e-15);
            close(turn.matrix().mul_vector(Vector3(v)).0, expected, 1e-15);
            close(turn.conjugate().rotate(Vector3(expected)).0, v, 1e-15);
        }
    }

    #[test]
    fn angles_come_back_from_their_pairs() {
        for angle in [-3.1, -2.0, -0.5, 0.0, 1.0, 2.5, 3.1] {
            let found = pinocchio::angle_from_cos_sin(pinocchio::cos_sin_from_angle(angle));
            assert!((found - angle).abs() < 1e-15);
        }
        assert_eq!(pinocchio::cos_sin_from_angle(0.0), [1.0, 0.0]);
    }
}
