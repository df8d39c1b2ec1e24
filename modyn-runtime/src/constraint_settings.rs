//! The arguments of constrained dynamics: stabilization, ranks, and the targets and the set of
//! active contacts.

use crate::spatial::{Pose, Twist, Vector3};

/// The stabilization of constraints, the limits below which rows count as dependent, and the
/// targets of contacts.
///
/// A constraint whose frames are displaced by phi obeys phi'' = -2 alpha phi' - beta^2 phi
/// (Baumgarte 1972). alpha = beta gives the fastest return without oscillation; the displacement
/// halves in 1.7 / beta. With zeros the displacement by an integrator's errors remains.
///
/// The mobility of a row is an inverse inertia, 1/kg. A row depends on others if the mobility that
/// they leave to it is at most a threshold. The threshold is `tolerance` times the mobility of the
/// constraint's relative motion, plus `rounding` times the row's own mobility. Rotations are
/// multiplied by the constraint's characteristic length.
///
/// ```
/// use modyn_runtime::ConstraintSettings;
///
/// let stiff = ConstraintSettings { alpha: 100.0, beta: 100.0, ..ConstraintSettings::<f64>::DEFAULT };
/// assert_eq!(stiff.tolerance, 1e-10);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstraintSettings<T, C = [ContactTarget<T>; 0]> {
    /// The damping of the displacements of loop constraints, 1/s.
    pub alpha: T,
    /// The stiffness of the displacements of loop constraints, 1/s.
    pub beta: T,
    /// The mobility of a dependent row relative to its constraint's mobility in all six directions:
    /// the squared angular error of the mechanism's axes, rad^2.
    pub tolerance: T,
    /// The part of a row's own mobility that rounding may leave.
    pub rounding: T,
    /// The target of each contact, active or not: an array.
    pub targets: C,
}

/// The frame in the world that a contact holds its link's frame to, and the properties of the
/// contact.
///
/// The displacement of the contact's frame from the target has a normal and a tangential part. The
/// normal part is the height of the frame's origin above the xy plane of `pose` and, for a surface,
/// the tilt between the two z axes. The tangential part is the displacement within the plane and,
/// for a surface, the rotation about the normal. The tangential part is multiplied by `tangential`;
/// relative velocities count in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactTarget<T> {
    /// The pose of the target in the world: its xy plane is the ground under the contact, its z
    /// axis the normal.
    pub pose: Pose<T>,
    /// The velocity of the ground at the contact in world axes, m/s and rad/s.
    pub velocity: Twist<T>,
    /// The factor of the tangential displacement: 0 for a plane, 1 for a frame.
    pub tangential: T,
    /// The damping of the displacement, 1/s.
    pub alpha: T,
    /// The stiffness of the displacement, 1/s.
    pub beta: T,
    /// The relative acceleration that the contact allows per force, 1/kg; per moment the value is
    /// divided by the squared characteristic length. A rigid contact has 0. Redundant contacts with
    /// compliance share the load by it.
    pub compliance: T,
    /// The coefficient of restitution along the normal: the speed after an impact divided by the
    /// speed before.
    pub restitution: T,
    /// The weight of the contact in the distribution of the load by inverse dynamics, relative to
    /// the other contacts' weights.
    pub weight: T,
}

impl<T: Copy, C> ConstraintSettings<T, C> {
    /// The number of settings before the targets of contacts.
    pub const COUNT: usize = 4;

    /// Returns the settings from alpha, beta, tolerance and rounding.
    #[must_use]
    pub fn from_numbers([alpha, beta, tolerance, rounding]: [T; 4], targets: C) -> Self {
        Self { alpha, beta, tolerance, rounding, targets }
    }

    /// Returns alpha, beta, tolerance and rounding. In an array of all settings, the numbers of the
    /// targets follow them.
    #[must_use]
    pub fn numbers(&self) -> [T; 4] {
        [self.alpha, self.beta, self.tolerance, self.rounding]
    }
}

impl<T: Copy> ContactTarget<T> {
    /// The number of numbers of a target.
    pub const COUNT: usize = 24;

    /// Returns the target from its numbers: the rotation by rows, the translation, the velocity
    /// (linear, then angular), tangential, alpha, beta, compliance, restitution and weight.
    ///
    /// ```
    /// use modyn_runtime::ContactTarget;
    ///
    /// let target = ContactTarget::from_numbers(core::array::from_fn(|k| k as f64));
    /// assert_eq!(target.pose.rotation[1], [3.0, 4.0, 5.0]);
    /// assert_eq!((target.velocity.linear.0, target.weight), ([12.0, 13.0, 14.0], 23.0));
    /// ```
    #[must_use]
    pub fn from_numbers(numbers: [T; 24]) -> Self {
        let three = |from: usize| [numbers[from], numbers[from + 1], numbers[from + 2]];
        Self {
            pose: Pose { rotation: [three(0), three(3), three(6)], translation: three(9) },
            velocity: Twist { linear: Vector3(three(12)), angular: Vector3(three(15)) },
            tangential: numbers[18],
            alpha: numbers[19],
            beta: numbers[20],
            compliance: numbers[21],
            restitution: numbers[22],
            weight: numbers[23],
        }
    }

    /// Returns the numbers of the target, in the order of [`from_numbers`](Self::from_numbers).
    #[must_use]
    pub fn numbers(&self) -> [T; 24] {
        let Self { pose, velocity, tangential, alpha, beta, compliance, .. } = self;
        let Self { restitution, weight, .. } = self;
        let pose = pose.rotation.iter().flatten().chain(&pose.translation);
        let velocity = velocity.linear.0.iter().chain(&velocity.angular.0);
        let others = [tangential, alpha, beta, compliance, restitution, weight];
        let mut numbers = [*weight; 24];
        for (number, value) in numbers.iter_mut().zip(pose.chain(velocity).chain(others)) {
            *number = *value;
        }
        numbers
    }
}

macro_rules! settings {
    ($float:ty, $tolerance:literal, $rounding:literal, $in_words:literal) => {
        impl ContactTarget<$float> {
            /// The plane z = 0 of the world, at rest and rigid; alpha = beta = 20/s, no
            /// restitution, weight 1.
            pub const GROUND: Self = Self {
                pose: Pose {
                    rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                    translation: [0.0; 3],
                },
                velocity: Twist { linear: Vector3([0.0; 3]), angular: Vector3([0.0; 3]) },
                tangential: 0.0,
                alpha: 20.0,
                beta: 20.0,
                compliance: 0.0,
                restitution: 0.0,
                weight: 1.0,
            };

            /// A contact at rest at its present place: [`GROUND`](Self::GROUND) without
            /// stabilization.
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
                targets: [ContactTarget::<$float>::GROUND; N],
            };

            /// No stabilization, for mechanisms whose constraints are satisfied exactly.
            pub const EXACT: Self = Self {
                alpha: 0.0,
                beta: 0.0,
                targets: [ContactTarget::<$float>::EXACT; N],
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

/// A set of active contacts of a robot. Each generated robot with contacts has a type with a member
/// for each contact; a robot without contacts has `()`.
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
