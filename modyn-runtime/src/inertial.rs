//! The inertia of a rigid link, as a description states it.

use core::{fmt, iter};

use crate::spatial::Pose;

/// Mass, centre of mass and rotational inertia of a rigid link.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inertial {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the link's frame, m.
    pub center_of_mass: [f64; 3],
    /// Rotational inertia about the centre of mass in the link's axes, kg m^2:
    /// `[ixx, ixy, ixz, iyy, iyz, izz]`.
    pub inertia: [f64; 6],
}

/// How many numbers the inertia of a rigid link is.
pub const PARAMETERS_PER_LINK: usize = 10;

/// What the [parameters](Inertial::parameters) of a link are called.
#[allow(dead_code)] // For the model, which needs a heap.
pub const INERTIAL_PARAMETERS: [&str; PARAMETERS_PER_LINK] =
    ["m", "mcx", "mcy", "mcz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"];

/// Why an inertia is not that of any rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum InertialDefect {
    /// A figure is NaN or infinite.
    NotFinite,
    /// The mass is negative.
    NegativeMass(f64),
    /// There is rotational inertia but no mass.
    InertiaWithoutMass,
    /// The rotational inertia is not positive semidefinite; its principal moments, ascending.
    NotPositiveSemidefinite([f64; 3]),
    /// The largest principal moment exceeds the sum of the two others; ascending.
    TriangleInequality([f64; 3]),
}

impl fmt::Display for InertialDefect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "a figure is NaN or infinite"),
            Self::NegativeMass(mass) => write!(f, "the mass is negative ({mass} kg)"),
            Self::InertiaWithoutMass => {
                write!(f, "the mass is zero, but the rotational inertia is not")
            }
            Self::NotPositiveSemidefinite([a, b, c]) => write!(
                f,
                "the rotational inertia is not positive semidefinite (principal moments {a:.6e}, {b:.6e}, {c:.6e} kg m^2)"
            ),
            Self::TriangleInequality([a, b, c]) => write!(
                f,
                "the principal moments {a:.6e}, {b:.6e}, {c:.6e} kg m^2 break the triangle inequality \
                 ({c:.6e} > {a:.6e} + {b:.6e}), which no mass distribution does"
            ),
        }
    }
}

/// Relative slack of the tests for being physical: figures in descriptions are rounded.
const SLACK: f64 = 1e-6;

/// Slack relative to the mass times the squared distance of its centre: tools compute the inertia about
/// the centre of mass as a difference of two figures that are at least as large, and a point mass then keeps
/// what rounding left of them. So much as an inertia it does not change any robot.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl Inertial {
    /// Why this is no rigid body's inertia; `None` if it is one.
    ///
    /// The bounds are those of Traversaro et al. 2016, "Identification of fully physical
    /// consistent inertial parameters", with a slack of 1e-6 of the largest principal moment, and of
    /// 2e-15 m c^2 for what rounding leaves where a centre of mass is c from the link's origin.
    #[must_use]
    pub fn defect(&self) -> Option<InertialDefect> {
        let mut figures = iter::once(self.mass).chain(self.center_of_mass).chain(self.inertia);
        if !figures.all(f64::is_finite) {
            return Some(InertialDefect::NotFinite);
        }
        if self.mass < 0.0 {
            return Some(InertialDefect::NegativeMass(self.mass));
        }
        if self.mass == 0.0 && self.inertia.iter().any(|&x| x != 0.0) {
            return Some(InertialDefect::InertiaWithoutMass);
        }
        let moments = self.principal_moments();
        let [x, y, z] = self.center_of_mass;
        let slack = SLACK * moments[2].abs().max(moments[0].abs())
            + ROUNDING * self.mass * (x * x + y * y + z * z);
        if moments[0] < -slack {
            Some(InertialDefect::NotPositiveSemidefinite(moments))
        } else if moments[2] > moments[0] + moments[1] + slack {
            Some(InertialDefect::TriangleInequality(moments))
        } else {
            None
        }
    }

    /// The principal moments of inertia about the centre of mass, kg m^2, ascending.
    #[must_use]
    pub fn principal_moments(&self) -> [f64; 3] {
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        let mut full = [xx, xy, xz, xy, yy, yz, xz, yz, zz];
        crate::jacobi::diagonalize(&mut full, 3);
        let mut moments = [full[0], full[4], full[8]];
        moments.sort_unstable_by(f64::total_cmp);
        moments
    }

    /// The parameters that the dynamics are linear in: `[m, m cx, m cy, m cz, Ixx, Ixy, Ixz, Iyy,
    /// Iyz, Izz]`, in kg, kg m and kg m^2. The first moment and the rotational inertia are about the
    /// link's origin (not the centre of mass), in its axes.
    #[must_use]
    pub fn parameters(&self) -> [f64; PARAMETERS_PER_LINK] {
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

    /// The same body seen from a frame in which this one stands at `pose`.
    #[must_use]
    pub fn transformed(&self, pose: &Pose<f64>) -> Self {
        let r = &pose.rotation;
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        let full = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let entry = |i: usize, j: usize| {
            let mut sum = 0.0;
            for (k, row) in full.iter().enumerate() {
                for (l, x) in row.iter().enumerate() {
                    sum += r[i][k] * x * r[j][l];
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

    /// The two bodies, in the same frame, as one.
    #[must_use]
    pub fn merged(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            let mut inertia = self.inertia;
            inertia.iter_mut().zip(other.inertia).for_each(|(a, b)| *a += b);
            return Self { mass, center_of_mass: self.center_of_mass, inertia };
        }
        if other.mass == 0.0 && other.inertia == [0.0; 6] {
            return *self;
        }
        let mut center_of_mass = [0.0; 3];
        for (i, c) in center_of_mass.iter_mut().enumerate() {
            *c = (self.mass * self.center_of_mass[i] + other.mass * other.center_of_mass[i]) / mass;
        }
        let mut inertia = [0.0; 6];
        for body in [self, other] {
            let [x, y, z]: [f64; 3] =
                core::array::from_fn(|i| body.center_of_mass[i] - center_of_mass[i]);
            let shift = [y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y];
            for (sum, (own, s)) in inertia.iter_mut().zip(body.inertia.iter().zip(shift)) {
                *sum += own + body.mass * s;
            }
        }
        Self { mass, center_of_mass, inertia }
    }
}

/// An inertia that a rigid body can have, to be given to a robot at run time.
///
/// ```
/// use modyn_runtime::{Inertial, InertialDefect, Payload};
///
/// let cup = Inertial { mass: 0.3, center_of_mass: [0.0, 0.0, 0.05], ..Inertial::default() };
/// assert!(Payload::new(cup).is_ok());
/// let nonsense = Inertial { mass: -1.0, ..cup };
/// assert_eq!(Payload::new(nonsense), Err(InertialDefect::NegativeMass(-1.0)));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Payload(Inertial);

impl Payload {
    /// No mass.
    pub const NONE: Self =
        Self(Inertial { mass: 0.0, center_of_mass: [0.0; 3], inertia: [0.0; 6] });

    /// From mass, centre of mass and inertia in the link's frame.
    ///
    /// # Errors
    ///
    /// If no rigid body has such an inertia, or a figure is not finite.
    pub fn new(inertial: Inertial) -> Result<Self, InertialDefect> {
        inertial.defect().map_or(Ok(Self(inertial)), Err)
    }

    /// What a description says, which has been checked when it was read.
    #[doc(hidden)]
    #[must_use]
    pub const fn as_described(inertial: Inertial) -> Self {
        Self(inertial)
    }

    /// Its figures.
    #[must_use]
    pub const fn inertial(&self) -> Inertial {
        self.0
    }
}

impl core::convert::TryFrom<Inertial> for Payload {
    type Error = InertialDefect;
    fn try_from(inertial: Inertial) -> Result<Self, InertialDefect> {
        Self::new(inertial)
    }
}
