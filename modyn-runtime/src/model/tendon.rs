//! Fixed tendons and couplings of joints, as steps with soft constraints have them.

use alloc::{string::String, vec::Vec};

use super::{Softness, TendonJoint};

/// A sum of joint coordinates with factors, m or rad.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointSum {
    /// The joints, each with its factor.
    pub joints: Vec<TendonJoint>,
    /// The sum at zero coordinates.
    pub offset: f64,
}

/// A tendon whose length is a sum of joint coordinates, with its limits, friction, spring and
/// damper: `MuJoCo`'s `<fixed>`. It acts in steps with soft constraints, and in no other function.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SoftTendon {
    /// The name.
    pub name: String,
    /// The length.
    pub length: JointSum,
    /// The least and the largest length; `None` without limits.
    pub range: Option<[f64; 2]>,
    /// The distance from which on a limit acts.
    pub margin: f64,
    /// The softness of the limits.
    pub limit: Softness<f64>,
    /// The dry friction, at least 0: N, or N m for a sum of angles.
    pub dry_friction: f64,
    /// The softness of dry friction.
    pub friction: Softness<f64>,
    /// The spring and the damper.
    pub spring: TendonSpring,
}

/// The spring and the damper of a tendon.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TendonSpring {
    /// The stiffness, at least 0: N/m, or N m/rad.
    pub stiffness: f64,
    /// The least and the largest length at which the spring exerts no force.
    pub rest: [f64; 2],
    /// The damping, at least 0: N s/m, or N m s/rad.
    pub damping: f64,
}

/// A soft coupling of two sums of joint coordinates: the first sum is a polynomial of the second
/// one. It acts in steps with soft constraints, and in no other function.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SoftCoupling {
    /// The name.
    pub name: String,
    /// The first and the second sum; without joints, the second one is zero.
    pub sums: [JointSum; 2],
    /// The coefficients of the polynomial, from degree 0 to degree 4.
    pub polynomial: [f64; 5],
    /// The softness.
    pub softness: Softness<f64>,
}
