//! The settings of steps with contacts.

use crate::spatial::Pose;

/// The settings of [`step`](crate::Robot::step). Names and defaults are MuJoCo's. `C` is an array
/// with the surface of each contact, or a slice.
///
/// ```
/// use modyn_runtime::{ContactSurface, StepSettings};
///
/// let ice = ContactSurface { friction: 0.05, ..ContactSurface::<f64>::GROUND };
/// let settings = StepSettings::<f64, [_; 4]> { surfaces: [ice; 4], ..Default::default() };
/// assert_eq!(settings.impratio, 1.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSettings<T, C = [ContactSurface<T>; 0]> {
    /// The largest mismatch between the forces and their laws at which the solver ends, divided by
    /// the sum of the robot's weight and the largest force.
    pub tolerance: T,
    /// How many times stiffer friction is than the normal direction.
    pub impratio: T,
    /// The share of Coulomb's law in sliding, from 0 (MuJoCo's law) to 1. By MuJoCo's law a sliding
    /// contact separates at the speed of its slip times the friction; this share of that speed, by the
    /// slip before the step, is subtracted.
    pub coulomb: T,
    /// The surface under each shape that touches the ground: an array.
    pub surfaces: C,
}

/// The surfaces of a contact: a plane, and the rounding of the shape that touches it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ContactSurface<T> {
    /// The pose of the plane in the world. Its z axis is the normal.
    pub plane: Pose<T>,
    /// The radius of a sphere or a capsule, or of a shape's round edges, m; zero for a point.
    pub radius: T,
    /// The coefficient of sliding friction.
    pub friction: T,
    /// The moment about the normal divided by the normal force, m: for contacts of at least four
    /// components.
    pub torsional_friction: T,
    /// The moment about a tangent divided by the normal force, m: for contacts of six components.
    pub rolling_friction: T,
    /// The distance from which on the contact acts, m.
    pub margin: T,
    /// How a violation decays: the time constant (s) and the damping ratio; if the first number is
    /// negative, minus the stiffness and minus the damping.
    pub solref: [T; 2],
    /// The impedance: at the surface and at the depth `width`, from 0 to 1; the width, m; the share
    /// of the width at which the curve between them, of two parabolas, changes its direction.
    pub solimp: [T; 4],
}

impl<T: Copy, C> StepSettings<T, C> {
    /// The number of settings before the surfaces of contacts.
    pub const COUNT: usize = 3;

    /// Returns the settings from the tolerance, `impratio` and `coulomb`.
    #[must_use]
    pub fn from_numbers([tolerance, impratio, coulomb]: [T; 3], surfaces: C) -> Self {
        Self { tolerance, impratio, coulomb, surfaces }
    }

    /// Returns the tolerance, `impratio` and `coulomb`. In an array of all settings, the numbers of
    /// the surfaces follow.
    #[must_use]
    pub fn numbers(&self) -> [T; 3] {
        [self.tolerance, self.impratio, self.coulomb]
    }
}

impl<T: Copy> ContactSurface<T> {
    /// The number of numbers of a surface.
    pub const COUNT: usize = 23;

    /// Returns the surface from its numbers: the rotation of the plane by rows, its translation,
    /// the radius, the three coefficients of friction, the margin, `solref` and `solimp`.
    ///
    /// ```
    /// use modyn_runtime::ContactSurface;
    ///
    /// let surface = ContactSurface::from_numbers(core::array::from_fn(|k| k as f64));
    /// assert_eq!(surface.plane.translation, [9.0, 10.0, 11.0]);
    /// assert_eq!((surface.friction, surface.solimp), (13.0, [19.0, 20.0, 21.0, 22.0]));
    /// ```
    #[must_use]
    pub fn from_numbers(numbers: [T; 23]) -> Self {
        let three = |first: usize| [numbers[first], numbers[first + 1], numbers[first + 2]];
        Self {
            plane: Pose { rotation: [three(0), three(3), three(6)], translation: three(9) },
            radius: numbers[12],
            friction: numbers[13],
            torsional_friction: numbers[14],
            rolling_friction: numbers[15],
            margin: numbers[16],
            solref: [numbers[17], numbers[18]],
            solimp: [numbers[19], numbers[20], numbers[21], numbers[22]],
        }
    }

    /// Returns the numbers of the surface, in the order of [`from_numbers`](Self::from_numbers).
    #[must_use]
    pub fn numbers(&self) -> [T; 23] {
        let Self { plane, radius, friction, margin, solref, solimp, .. } = self;
        let [torsional, rolling] = [self.torsional_friction, self.rolling_friction];
        let [[a, b, c], [d, e, f], [g, h, i]] = plane.rotation;
        let [x, y, z] = plane.translation;
        let [first, second] = *solref;
        let [least, most, width, middle] = *solimp;
        [
            a, b, c, d, e, f, g, h, i, x, y, z, *radius, *friction, torsional, rolling, *margin,
            first, second, least, most, width, middle,
        ]
    }
}

macro_rules! defaults {
    ($float:ty, $tolerance:literal, $impedance:literal) => {
        impl ContactSurface<$float> {
            /// No rounding, and the plane z = 0 of the world, with MuJoCo's default friction and softness.
            pub const GROUND: Self = Self {
                plane: Pose {
                    rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                    translation: [0.0; 3],
                },
                radius: 0.0,
                friction: 1.0,
                torsional_friction: 0.005,
                rolling_friction: 0.0001,
                margin: 0.0,
                solref: [0.02, 1.0],
                solimp: [0.9, 0.95, 0.001, 0.5],
            };
        }

        impl Default for ContactSurface<$float> {
            fn default() -> Self {
                Self::GROUND
            }
        }

        impl<C: AsMut<[ContactSurface<$float>]>> StepSettings<$float, C> {
            /// Returns the settings with nearly rigid contacts for all time steps: a contact's motion
            /// into the plane, or along it if it sticks, ends within a step, and sliding follows
            /// Coulomb's law. A violation decays by a sixteenth per step.
            #[must_use]
            pub fn rigid(mut self) -> Self {
                self.coulomb = 1.0;
                for surface in self.surfaces.as_mut() {
                    // A time constant below two time steps acts as two time steps.
                    surface.solref = [1e-6, 2.0];
                    surface.solimp = [$impedance, $impedance, 0.001, 0.5];
                }
                self
            }
        }

        impl<const N: usize> StepSettings<$float, [ContactSurface<$float>; N]> {
            /// The plane z = 0 of the world, `impratio` 1, MuJoCo's law, and a tolerance that the
            /// number type reaches.
            pub const DEFAULT: Self = Self {
                tolerance: $tolerance,
                impratio: 1.0,
                coulomb: 0.0,
                surfaces: [ContactSurface::<$float>::GROUND; N],
            };
        }

        impl<const N: usize> Default for StepSettings<$float, [ContactSurface<$float>; N]> {
            fn default() -> Self {
                Self::DEFAULT
            }
        }
    };
}

defaults!(f64, 1e-8, 0.999);
defaults!(f32, 1e-4, 0.99);
