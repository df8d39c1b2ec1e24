//! The types of the constants of generated robots.

use core::fmt;

/// A kinematic module of a generated robot: a serial chain of links.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KinematicModule {
    /// The index of the parent module, whose last link carries this module; `None` for the base.
    pub parent: Option<usize>,
    /// The indices of the modules that this module's last link carries.
    pub children: &'static [usize],
    /// The names of the module's links, from the parent to the tip.
    pub links: &'static [&'static str],
    /// The names of the links' joints, in the same order.
    pub joints: &'static [&'static str],
    /// The module's first entry in velocity vectors; its other entries follow.
    pub first: usize,
    /// The number of the module's entries in velocity vectors.
    pub dofs: usize,
}

/// The centre of a shape that touches the ground in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeCenter {
    /// The index of the link that carries the shape.
    pub link: usize,
    /// The place in the link's frame, m.
    pub place: [f64; 3],
}

/// The limits of a robot's joints; infinite without a limit in the description. The position and
/// velocity limits of mimic joints are included as limits of their leaders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits<'a> {
    /// The lower position limits, rad or m, one for each entry of `q`.
    pub lower: &'a [f64],
    /// The upper position limits, rad or m, one for each entry of `q`.
    pub upper: &'a [f64],
    /// The velocity limits, rad/s or m/s, one for each entry of `qd`.
    pub velocity: &'a [f64],
    /// The effort limits, N m or N, one for each entry of `qd`.
    pub effort: &'a [f64],
}

/// The number of operations of a function. Changes of sign are not counted.
///
/// ```
/// use modyn_runtime::OperationCount;
///
/// let count = OperationCount { multiplications: 3, additions: 2, ..OperationCount::default() };
/// assert_eq!((count + count).total(), 10);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OperationCount {
    /// The number of multiplications.
    pub multiplications: usize,
    /// The number of additions and subtractions.
    pub additions: usize,
    /// The number of divisions.
    pub divisions: usize,
    /// The number of angles whose sine, cosine or both are computed.
    pub sin_cos: usize,
    /// The number of square roots, logarithms, absolute values, maxima and selections.
    pub others: usize,
}

impl OperationCount {
    /// Returns the number of multiplications, additions and divisions together.
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
