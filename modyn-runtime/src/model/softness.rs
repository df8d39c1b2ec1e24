//! The softness of constraints.

use crate::Scalar;

/// The softness of a constraint: how its violation decays, and how much force its violation takes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Softness<S> {
    /// `MuJoCo`'s `solref`: the time constant (s) and the damping ratio; if the first number is
    /// negative, the negative stiffness and the negative damping.
    pub reference: [S; 2],
    /// `MuJoCo`'s `solimp`.
    pub impedance: Impedance<S>,
}

/// The impedance of a constraint as a function of its violation: `MuJoCo`'s `solimp`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Impedance<S> {
    /// The impedance without violation.
    pub least: S,
    /// The impedance from the violation `width` on.
    pub most: S,
    /// The violation at which the impedance stops growing, m or rad. At most 1e-15: the impedance is
    /// the mean of the two for all violations.
    pub width: S,
    /// The share of `width` at which the curve changes its direction.
    pub midpoint: S,
    /// The power of the curve; 0 acts as 1. `MuJoCo` also has powers between integers.
    pub power: u32,
}

impl<S: Copy> Softness<S> {
    /// Returns the softness with `f` applied to its numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> Softness<T> {
        let Impedance { least, most, width, midpoint, power } = self.impedance;
        Softness {
            reference: self.reference.map(f),
            impedance: Impedance {
                least: f(least),
                most: f(most),
                width: f(width),
                midpoint: f(midpoint),
                power,
            },
        }
    }
}

impl<S: Scalar> Softness<S> {
    /// `MuJoCo`'s default: the time constant 0.02 s with critical damping.
    #[must_use]
    pub fn standard() -> Self {
        let [least, most, width, midpoint] = [0.9, 0.95, 0.001, 0.5].map(S::from_f64);
        let impedance = Impedance { least, most, width, midpoint, power: 2 };
        Self { reference: [0.02, 1.0].map(S::from_f64), impedance }
    }
}
