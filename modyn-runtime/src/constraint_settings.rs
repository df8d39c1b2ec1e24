//! What functions about constraints are told: stabilization, ranks, the targets of contacts and which are active.

use crate::spatial::{Pose, Twist, Vector3};

/// How constraints are stabilized, which of their rows count as independent, and the targets of contacts.
///
/// A constraint whose frames are displaced by phi obeys phi'' = -2 alpha phi' - beta^2 phi (Baumgarte 1972).
/// Alpha = beta is the fastest return without oscillation, by half in 1.7 / beta; zeros keep the
/// displacement that an integrator's errors have caused.
///
/// A row of the constraints depends on others where they leave it a mobility (inverse inertia, 1/kg) of at
/// most `tolerance` times the mobility of its constraint's relative motion, plus `rounding` times the
/// row's own. Rotations count times the constraint's characteristic length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintSettings<T, C = [ContactTarget<T>; 0]> {
    /// Damping of the displacements of loop constraints, 1/s.
    pub alpha: T,
    /// Stiffness of the displacements of loop constraints, 1/s.
    pub beta: T,
    /// The mobility of a dependent row as a share of its constraint's mobility in all six directions: the
    /// square of the error, as an angle, that axes and joints of the mechanism may have.
    pub tolerance: T,
    /// The share of a row's own mobility that rounding may leave of it.
    pub rounding: T,
    /// An array with the target of each contact, whether the contact is active or not.
    pub contacts: C,
}

/// The place in the world that a contact holds on to, and how.
///
/// The displacement of the contact's frame from the target has a normal part along the z axis of `pose`: the height
/// of the frame's origin over the plane and, for a surface, the tilt of its normal. The rest (the displacement within
/// the plane, the rotation about the normal) counts as much as `tangential` says. Velocities count in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactTarget<T> {
    /// A frame in the world: the xy plane of this frame is the ground under the contact, its z axis the normal.
    pub pose: Pose<T>,
    /// The velocity of the ground at the contact in world axes, rad/s and m/s.
    pub velocity: Twist<T>,
    /// The share of the tangential displacement that is stabilized: 0 on a plane, 1 in a frame.
    pub tangential: T,
    /// Damping of the displacement, 1/s.
    pub alpha: T,
    /// Stiffness of the displacement, 1/s.
    pub beta: T,
    /// The acceleration that a force in the contact allows, 1/kg (that of a moment: times the square of the
    /// characteristic length); 0 for a rigid contact. With compliance, redundant contacts share their forces by it.
    pub compliance: T,
    /// The share of the speed along the normal that is left after an impact, in the other direction.
    pub restitution: T,
    /// The share of the load that inverse dynamics gives to the contact, relative to other contacts' weights.
    pub weight: T,
}

macro_rules! settings {
    ($float:ty, $tolerance:literal, $rounding:literal, $in_words:literal) => {
        impl ContactTarget<$float> {
            /// The plane z = 0 of the world at rest, rigid, with alpha = beta = 20/s, no restitution and weight 1.
            pub const GROUND: Self = Self {
                pose: Pose {
                    rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                    translation: [0.0; 3],
                },
                velocity: Twist { angular: Vector3([0.0; 3]), linear: Vector3([0.0; 3]) },
                tangential: 0.0,
                alpha: 20.0,
                beta: 20.0,
                compliance: 0.0,
                restitution: 0.0,
                weight: 1.0,
            };

            /// A contact at rest where it is: nothing pulls it anywhere.
            pub const EXACT: Self = Self { alpha: 0.0, beta: 0.0, ..Self::GROUND };
        }

        impl Default for ContactTarget<$float> {
            fn default() -> Self {
                Self::GROUND
            }
        }

        impl<const N: usize> ConstraintSettings<$float, [ContactTarget<$float>; N]> {
            #[doc = $in_words]
            pub const DEFAULT: Self = Self {
                alpha: 20.0,
                beta: 20.0,
                tolerance: $tolerance,
                rounding: $rounding,
                contacts: [ContactTarget::<$float>::GROUND; N],
            };

            /// Constraints of accelerations alone: for mechanisms whose constraints are met exactly.
            pub const EXACT: Self = Self {
                alpha: 0.0,
                beta: 0.0,
                contacts: [ContactTarget::<$float>::EXACT; N],
                ..Self::DEFAULT
            };
        }

        impl<const N: usize> Default for ConstraintSettings<$float, [ContactTarget<$float>; N]> {
            fn default() -> Self {
                Self::DEFAULT
            }
        }
    };
}

settings!(
    f64,
    1e-10,
    1e-10,
    "alpha = beta = 20/s, axes that are off by 1e-5 rad, the square root of the precision, and the ground at z = 0."
);
settings!(
    f32,
    1e-8,
    1e-5,
    "alpha = beta = 20/s, axes that are off by 1e-4 rad, a hundred times the precision, and the ground at z = 0."
);

/// Which contacts of a robot are active: each generated robot with contacts has such a type, with a member for each
/// contact. A robot without contacts has `()`.
pub trait ContactSet: Copy {
    /// No contact is active.
    const NONE: Self;
    /// All contacts are active.
    const ALL: Self;
}

impl ContactSet for () {
    const NONE: Self = ();
    const ALL: Self = ();
}
