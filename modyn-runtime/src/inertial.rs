//! The inertia of a rigid link.

use core::{fmt, iter};

use crate::Scalar;
use crate::scalar::epsilon;
use crate::spatial::Pose;

/// The mass, centre of mass and rotational inertia of a rigid link.
///
/// ```
/// use modyn_runtime::Inertial;
///
/// // A ball of 1 kg with a radius of 0.1 m.
/// let moment = 0.4 * 0.1 * 0.1;
/// let ball = Inertial { mass: 1.0, center_of_mass: [0.0; 3], inertia: [moment, 0.0, 0.0, moment, 0.0, moment] };
/// assert_eq!(ball.defect(), None);
/// assert!(Inertial { mass: -1.0, ..ball }.defect().is_some());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inertial<S = f64> {
    /// The mass, kg.
    pub mass: S,
    /// The centre of mass in the link's frame, m.
    pub center_of_mass: [S; 3],
    /// The rotational inertia about the centre of mass in the link's axes, kg m^2:
    /// `[ixx, ixy, ixz, iyy, iyz, izz]`.
    pub inertia: [S; 6],
}

/// The inertia of no mass.
impl<S: Scalar> Default for Inertial<S> {
    fn default() -> Self {
        Self { mass: S::zero(), center_of_mass: [S::zero(); 3], inertia: [S::zero(); 6] }
    }
}

/// The number of inertial parameters of a rigid link.
pub const PARAMETERS_PER_LINK: usize = 10;

/// The names of the [parameters](Inertial::parameters) of a link.
#[allow(dead_code)] // Used by the model, which needs a heap.
pub const INERTIAL_PARAMETERS: [&str; PARAMETERS_PER_LINK] =
    ["m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];

/// The reason why no rigid body has an inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum InertialDefect<S = f64> {
    /// A number is NaN or infinite.
    NotFinite,
    /// The mass is negative, kg.
    NegativeMass(S),
    /// The rotational inertia is not zero, but the mass is.
    InertiaWithoutMass,
    /// The rotational inertia is not positive semidefinite. The principal moments in ascending
    /// order, kg m^2.
    NotPositiveSemidefinite([S; 3]),
    /// The largest principal moment exceeds the sum of the other two. The principal moments in
    /// ascending order, kg m^2.
    TriangleInequality([S; 3]),
}

impl<S: fmt::Display + fmt::LowerExp> fmt::Display for InertialDefect<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "a number is NaN or infinite"),
            Self::NegativeMass(mass) => write!(f, "the mass is negative ({mass} kg)"),
            Self::InertiaWithoutMass => {
                write!(f, "the mass is zero, but the rotational inertia is not")
            }
            Self::NotPositiveSemidefinite([a, b, c]) => write!(
                f,
                "the rotational inertia is not positive semidefinite (principal moments {a:.6e}, \
                 {b:.6e}, {c:.6e} kg m^2)"
            ),
            Self::TriangleInequality([a, b, c]) => write!(
                f,
                "the principal moments {a:.6e}, {b:.6e}, {c:.6e} kg m^2 break the triangle inequality \
                 ({c:.6e} > {a:.6e} + {b:.6e}), which no mass distribution does"
            ),
        }
    }
}

impl<S: fmt::Debug + fmt::Display + fmt::LowerExp> core::error::Error for InertialDefect<S> {}

/// The relative tolerance of the physical bounds, since numbers in descriptions are rounded.
const TRIANGLE_TOLERANCE: f64 = 1e-6;

/// The tolerance of the physical bounds in units of the scalar's precision, relative to the mass
/// times the squared distance of the centre of mass. Tools compute the inertia about the centre of
/// mass as a difference of two numbers that are at least as large, and a point mass keeps their
/// rounding. An inertia this small has no effect on a robot.
const ROUNDING: f64 = 8.0;

impl<S: Scalar> Inertial<S> {
    /// Returns the reason why no rigid body has this inertia; `None` if it is physical.
    ///
    /// The bounds are from Traversaro et al. 2016, "Identification of fully physical consistent
    /// inertial parameters". The tolerance is 1e-6 of the largest principal moment plus 8 units of
    /// the scalar's precision (2e-15 for `f64`) of m c^2, for the rounding of a centre of mass at
    /// distance c from the link's origin.
    #[must_use]
    pub fn defect(&self) -> Option<InertialDefect<S>>
    where
        S: PartialOrd,
    {
        let zero = S::zero();
        let mut numbers = iter::once(self.mass).chain(self.center_of_mass).chain(self.inertia);
        // The product of an infinite number and zero is NaN.
        if !numbers.all(|x| x * zero == zero) {
            return Some(InertialDefect::NotFinite);
        }
        if self.mass < zero {
            return Some(InertialDefect::NegativeMass(self.mass));
        }
        let massless = self.mass <= zero;
        if massless && self.inertia.iter().any(|&x| x != zero) {
            return Some(InertialDefect::InertiaWithoutMass);
        }
        let moments = self.principal_moments();
        let [x, y, z] = self.center_of_mass;
        let epsilon = S::from_f64(ROUNDING) * epsilon();
        let relative = S::from_f64(TRIANGLE_TOLERANCE) + epsilon;
        let slack = relative * moments[2].abs().max(moments[0].abs())
            + epsilon * self.mass * (x * x + y * y + z * z);
        if moments[0] < -slack {
            Some(InertialDefect::NotPositiveSemidefinite(moments))
        } else if moments[2] > moments[0] + moments[1] + slack {
            Some(InertialDefect::TriangleInequality(moments))
        } else {
            None
        }
    }

    /// Returns the principal moments of inertia about the centre of mass, kg m^2, in ascending
    /// order.
    #[must_use]
    pub fn principal_moments(&self) -> [S; 3]
    where
        S: PartialOrd,
    {
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        let mut full = [xx, xy, xz, xy, yy, yz, xz, yz, zz];
        crate::jacobi::diagonalize(&mut full, 3);
        let ascending = |a: S, b: S| if b < a { (b, a) } else { (a, b) };
        let (a, b) = ascending(full[0], full[4]);
        let (b, c) = ascending(b, full[8]);
        let (a, b) = ascending(a, b);
        [a, b, c]
    }

    /// Returns the inertia with `f` applied to its numbers.
    pub fn map<T>(&self, mut f: impl FnMut(S) -> T) -> Inertial<T> {
        Inertial {
            mass: f(self.mass),
            center_of_mass: self.center_of_mass.map(&mut f),
            inertia: self.inertia.map(&mut f),
        }
    }

    /// Returns the inertial parameters, in which the dynamics are linear:
    /// `[m, m cx, m cy, m cz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz]`, in kg, kg m and kg m^2. First moment
    /// and rotational inertia are about the link's origin (not the centre of mass), in the link's
    /// axes.
    #[must_use]
    pub fn parameters(&self) -> [S; PARAMETERS_PER_LINK] {
        let m = self.mass;
        let [x, y, z] = self.center_of_mass;
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        [
            m,
            m * x,
            m * y,
            m * z,
            xx + m * (y * y + z * z),
            xy - m * x * y,
            xz - m * x * z,
            yy + m * (x * x + z * z),
            yz - m * y * z,
            zz + m * (x * x + y * y),
        ]
    }

    /// Returns the inertia in a frame in which this inertia's frame has the pose `pose`.
    #[must_use]
    pub fn transformed(&self, pose: &Pose<S>) -> Self {
        let r = &pose.rotation;
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        let full = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let entry = |i: usize, j: usize| {
            let mut sum = S::zero();
            for (k, row) in full.iter().enumerate() {
                for (l, &x) in row.iter().enumerate() {
                    sum = sum + r[i][k] * x * r[j][l];
                }
            }
            sum
        };
        Self {
            mass: self.mass,
            center_of_mass: pose.transform_point(self.center_of_mass),
            inertia: [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)],
        }
    }

    /// Returns the inertia of both bodies together; both are in the same frame.
    #[must_use]
    pub fn merged(&self, other: &Self) -> Self
    where
        S: PartialEq,
    {
        let mass = self.mass + other.mass;
        if mass == S::zero() {
            let inertia = core::array::from_fn(|i| self.inertia[i] + other.inertia[i]);
            return Self { mass, center_of_mass: self.center_of_mass, inertia };
        }
        if other.mass == S::zero() && other.inertia == [S::zero(); 6] {
            return *self;
        }
        let center_of_mass: [S; 3] = core::array::from_fn(|i| {
            (self.mass * self.center_of_mass[i] + other.mass * other.center_of_mass[i]) / mass
        });
        let mut inertia = [S::zero(); 6];
        for body in [self, other] {
            let [x, y, z]: [S; 3] =
                core::array::from_fn(|i| body.center_of_mass[i] - center_of_mass[i]);
            let shift = [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y];
            for (sum, (&number, s)) in inertia.iter_mut().zip(body.inertia.iter().zip(shift)) {
                *sum = *sum + (number + body.mass * s);
            }
        }
        Self { mass, center_of_mass, inertia }
    }
}
