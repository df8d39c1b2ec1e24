//! What generated robots say of themselves, and results that have parts.

use core::fmt;

/// A kinematic module of a generated robot: links in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KinematicModule {
    /// The module whose last link it leaves, as an index; `None` for the base.
    pub parent: Option<usize>,
    /// The modules that leave its last link.
    pub children: &'static [usize],
    /// Its links from the inside out.
    pub links: &'static [&'static str],
    /// Their joints, in the same order.
    pub joints: &'static [&'static str],
    /// Where its first entry stands in velocity vectors; the others follow.
    pub first: usize,
    /// How many entries it has there.
    pub dofs: usize,
}

/// The derivatives of the inverse dynamics: square matrices by columns, a column for each entry
/// of what is derived by.
///
/// The derivative by the accelerations is the mass matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseDynamicsDerivatives<M> {
    /// d tau / d q, in tangent space.
    pub dq: M,
    /// d tau / d qd.
    pub dqd: M,
}

/// The derivatives of the forward dynamics, and the accelerations at which they are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardDynamicsDerivatives<V, M> {
    /// The accelerations.
    pub qdd: V,
    /// d qdd / d q, in tangent space.
    pub dq: M,
    /// d qdd / d qd.
    pub dqd: M,
    /// d qdd / d tau: the inverse of the mass matrix.
    pub dtau: M,
}

/// How closed loops are kept closed, and which of their rows count as redundant.
///
/// Where the frames of a closure are apart by phi, it is held by phi'' = -2 alpha phi' - beta^2 phi
/// (Baumgarte 1972). Alpha = beta is the fastest return without swinging, by half in 1.7 / beta; zeros
/// leave apart what an integrator's errors took apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosureSettings<T> {
    /// Damping of what parts, 1/s.
    pub alpha: T,
    /// Its stiffness, 1/s.
    pub beta: T,
    /// Below which share of the diagonal's sum, over rows of its kind (rotations or displacements), a row
    /// of the constraints follows from others.
    pub tolerance: T,
}

impl ClosureSettings<f64> {
    /// alpha = beta = 20/s, and the square root of the precision.
    pub const DEFAULT: Self = Self { alpha: 20.0, beta: 20.0, tolerance: 1e-8 };

    /// Constraints of accelerations alone: for what is exactly closed.
    pub const EXACT: Self = Self { alpha: 0.0, beta: 0.0, ..Self::DEFAULT };
}

impl ClosureSettings<f32> {
    /// alpha = beta = 20/s, and the square root of the precision.
    pub const DEFAULT: Self = Self { alpha: 20.0, beta: 20.0, tolerance: 3e-4 };

    /// Constraints of accelerations alone: for what is exactly closed.
    pub const EXACT: Self = Self { alpha: 0.0, beta: 0.0, ..Self::DEFAULT };
}

impl Default for ClosureSettings<f64> {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Default for ClosureSettings<f32> {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The accelerations of a robot whose loops are closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstrainedForwardDynamics<V, W> {
    /// The accelerations.
    pub qdd: V,
    /// For each closure what holds it: the wrench on the second link at the second frame's origin,
    /// in the first frame's axes. The first link feels the opposite there.
    pub forces: W,
}

/// A step that closes loops, and the change of velocities that keeps them closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosingStep<V> {
    /// The displacement, from coordinates whose loops are nearly closed.
    pub dq: V,
    /// The change of the velocities.
    pub dqd: V,
}

/// How far closures are apart: for each the motion of the second frame against the first, in the
/// first one's axes, without what is free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosureErrors<D> {
    /// Displacements, m; rotations by their axes times the sines of their angles.
    pub displacements: D,
    /// Velocities, m/s and rad/s.
    pub velocities: D,
}

/// The limits of a robot's joints, infinite where the description states none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits<'a> {
    /// Smallest coordinates, rad or m; one for each entry of `q`.
    pub lower: &'a [f64],
    /// Largest coordinates, rad or m.
    pub upper: &'a [f64],
    /// Largest speeds, rad/s or m/s; one for each entry of `qd`.
    pub velocity: &'a [f64],
    /// Largest efforts, N m or N.
    pub effort: &'a [f64],
}

/// How many operations a function takes; changes of sign are free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OperationCount {
    /// Multiplications.
    pub multiplications: usize,
    /// Additions and subtractions.
    pub additions: usize,
    /// Divisions.
    pub divisions: usize,
    /// Angles whose sine, cosine or both are taken.
    pub sin_cos: usize,
    /// Square roots and logarithms, absolute values, maxima and selections.
    pub others: usize,
}

impl OperationCount {
    /// Multiplications, additions and divisions together.
    #[must_use]
    pub const fn total(&self) -> usize {
        self.multiplications + self.additions + self.divisions
    }
}

impl core::iter::Sum for OperationCount {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), |sum, count| sum + count)
    }
}

impl core::ops::Add for OperationCount {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            multiplications: self.multiplications + other.multiplications,
            additions: self.additions + other.additions,
            divisions: self.divisions + other.divisions,
            sin_cos: self.sin_cos + other.sin_cos,
            others: self.others + other.others,
        }
    }
}

impl fmt::Display for OperationCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { multiplications, additions, divisions, sin_cos, .. } = self;
        write!(
            f,
            "{} operations ({multiplications} multiplications, {additions} additions, \
             {divisions} divisions) and {sin_cos} sin/cos",
            self.total()
        )
    }
}
