//! The laws of soft constraints: impedance, reference acceleration, and the force of a row or of a
//! contact.
//!
//! These are MuJoCo's laws, by its documentation ("Computation", section "Constraint model") and
//! with its parameters: a row with the Jacobian J has a reference acceleration a* and a
//! regularization R = (1 - d) A / d, where d is the impedance and A an approximation of J M^-1 J^T.
//! Its force follows from J qdd - a*. All forces together minimize a convex function.

use crate::Scalar;
use crate::scalar::{at_least, at_most};

/// The smallest and the largest impedance, as in MuJoCo.
const IMPEDANCES: [f64; 2] = [1e-4, 0.9999];

/// The impedance of rows with which a solver converges from any start.
const SOFT: f64 = 0.95;

/// The width below which the impedance does not depend on the violation, and the smallest denominator, as in
/// MuJoCo.
const LEAST: f64 = 1e-15;

/// The smallest coefficient of friction, as in MuJoCo.
const LEAST_FRICTION: f64 = 1e-5;

/// The impedance of a constraint as a function of its violation: MuJoCo's `solimp`.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// The power of the curve; 0 acts as 1. MuJoCo also has powers between integers.
    pub power: u32,
}

/// The softness of a constraint: how its violation decays, and how much force its violation takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness<S> {
    /// MuJoCo's `solref`: the time constant (s) and the damping ratio; if the first number is
    /// negative, the negative stiffness and the negative damping.
    pub reference: [S; 2],
    /// MuJoCo's `solimp`.
    pub impedance: Impedance<S>,
}

/// A row of a soft constraint at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftRow<S> {
    /// 1 / R, kg or kg m^2: the force for each unit of acceleration below the reference.
    pub weight: S,
    /// The reference acceleration, m/s^2 or rad/s^2.
    pub reference: S,
}

/// The position and velocity of a constraint row, and how easily it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowState<S> {
    /// The position minus the margin: negative where a contact or a limit is violated, m or rad.
    pub position: S,
    /// The velocity, m/s or rad/s.
    pub velocity: S,
    /// The approximation of J M^-1 J^T: MuJoCo's `invweight0`, 1/kg or 1/(kg m^2).
    pub mobility: S,
}

impl<S: Scalar> Impedance<S> {
    /// MuJoCo's default.
    #[must_use]
    pub fn standard() -> Self {
        let [least, most, width, midpoint] = [0.9, 0.95, 0.001, 0.5].map(S::from_f64);
        Self { least, most, width, midpoint, power: 2 }
    }

    /// Returns the impedance at a violation.
    #[must_use]
    pub fn at(&self, violation: S) -> S {
        let one = S::one();
        let [start, end, midpoint] = [self.least, self.most, self.midpoint].map(possible);
        let least_width = S::from_f64(LEAST);
        let x = at_most(violation.abs() / at_least(self.width, least_width), one);
        let exponent = self.power.max(1);
        let power = |x: S, exponent: u32| (0..exponent).fold(one, |product, _| product * x);
        // a x^p before the midpoint and 1 - b (1 - x)^p behind it: one line through the midpoint.
        let rising = |x: S, midpoint: S| power(x, exponent) / power(midpoint, exponent - 1);
        let low = rising(x, midpoint);
        let high = one - rising(one - x, one - midpoint);
        let share = (midpoint - x).select_nonnegative(low, high);
        let mean = S::from_f64(0.5);
        let share = (least_width - self.width).select_nonnegative(mean, share);
        start + share * (end - start)
    }

    /// Returns the factor of the weights of rows with this impedance that makes them as soft as rows
    /// with the impedance 0.95; at most 1.
    #[must_use]
    pub fn softening(&self) -> S {
        let one = S::one();
        let most = possible(self.most);
        at_most(S::from_f64(SOFT / (1.0 - SOFT)) * (one - most) / most, one)
    }
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
    /// MuJoCo's default: the time constant 0.02 s with critical damping.
    #[must_use]
    pub fn standard() -> Self {
        let reference = [0.02, 1.0].map(S::from_f64);
        Self { reference, impedance: Impedance::standard() }
    }

    /// Returns the stiffness (1/s^2) and the damping (1/s) of the reference acceleration for steps
    /// of the time `dt`: time constants below 2 `dt` are not stable, and raised to it.
    fn stiffness_and_damping(&self, dt: S) -> [S; 2] {
        let [first, second] = self.reference;
        let two = S::from_f64(2.0);
        let most = possible(self.impedance.most);
        let time_constant = at_least(first, two * dt);
        let least = S::from_f64(LEAST);
        let period = most * time_constant;
        let damping = two / at_least(period, least);
        let stiffness = at_least(period * second * period * second, least).recip();
        let [direct_stiffness, direct_damping] = [-first / (most * most), -second / most];
        [
            (-first).select_nonnegative(direct_stiffness, stiffness),
            (-first).select_nonnegative(direct_damping, damping),
        ]
    }

    /// Returns the row of a constraint for a step of the time `dt`.
    #[must_use]
    pub fn row(&self, state: &RowState<S>, dt: S) -> SoftRow<S> {
        let [stiffness, damping] = self.stiffness_and_damping(dt);
        let impedance = self.impedance.at(state.position);
        SoftRow {
            weight: impedance / ((S::one() - impedance) * state.mobility),
            reference: -(damping * state.velocity) - stiffness * impedance * state.position,
        }
    }

    /// Returns the reference acceleration of a direction that has no position, such as one of
    /// friction.
    #[must_use]
    pub fn damped(&self, velocity: S, dt: S) -> S {
        let [_, damping] = self.stiffness_and_damping(dt);
        -(damping * velocity)
    }
}

/// The cone of a contact's forces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cone {
    /// Four edges: MuJoCo's default.
    #[default]
    Pyramidal,
    /// A circular cone.
    Elliptic,
}

/// The law of a contact with friction at a state. Components are along the normal and along two
/// tangents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw<S> {
    /// The cone.
    pub cone: Cone,
    /// The coefficient of friction.
    pub friction: S,
    /// The ratio of the weights of the tangents to that of the normal: MuJoCo's `impratio`.
    pub ratio: S,
    /// The weight of the normal; zero for a contact that does not touch.
    pub weight: S,
    /// The reference accelerations.
    pub reference: [S; 3],
}

/// A force, and minus its derivative by the acceleration: a symmetric positive semi-definite
/// matrix, by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response<S> {
    /// The force, N.
    pub force: [S; 3],
    /// Minus the derivative, kg.
    pub stiffness: [[S; 3]; 3],
}

impl<S: Scalar> ContactLaw<S> {
    /// Returns the law with the weight times `scale`.
    #[must_use]
    pub fn scaled(&self, scale: S) -> Self {
        Self { weight: self.weight * scale, ..*self }
    }

    /// Returns the force at this acceleration of the contact.
    #[must_use]
    pub fn response(&self, acceleration: [S; 3]) -> Response<S> {
        let gap = core::array::from_fn(|k| acceleration[k] - self.reference[k]);
        match self.cone {
            Cone::Pyramidal => self.pyramid(gap),
            Cone::Elliptic => self.ellipse(gap),
        }
    }

    /// The force of four edges n + mu t, n - mu t for each tangent t, each of which can push alone.
    fn pyramid(&self, gap: [S; 3]) -> Response<S> {
        let (zero, one) = (S::zero(), S::one());
        // All edges have the weight of the first: its mobility is (1 + mu^2) times that of the
        // normal, and the regularization is scaled by 2 mu^2 / ratio.
        let square = self.friction * self.friction;
        let scale = S::from_f64(2.0) * square * (one + square) / self.ratio;
        let weight = self.weight / scale;
        let mut response = Response { force: [zero; 3], stiffness: [[zero; 3]; 3] };
        for tangent in [1, 2] {
            for share in [self.friction, -self.friction] {
                let edge = gap[0] + share * gap[tangent];
                let active = edge.select_nonnegative(zero, weight);
                let force = -(active * edge);
                let mut direction = [zero; 3];
                (direction[0], direction[tangent]) = (one, share);
                for i in [0, tangent] {
                    response.force[i] = response.force[i] + direction[i] * force;
                    for j in [0, tangent] {
                        response.stiffness[i][j] =
                            response.stiffness[i][j] + active * direction[i] * direction[j];
                    }
                }
            }
        }
        response
    }

    /// The force of a circular cone. In coordinates in which the regularization is the same in all
    /// directions, the force is the projection of the unconstrained one onto the cone.
    fn ellipse(&self, gap: [S; 3]) -> Response<S> {
        let (zero, one) = (S::zero(), S::one());
        let mu = self.friction;
        let slip = (gap[1] * gap[1] + gap[2] * gap[2] + S::from_f64(1e-36)).sqrt();
        let direction = [gap[1] / slip, gap[2] / slip];
        let regular = mu * mu / self.ratio;
        // The distance to the polar cone, and to the cone itself, each times a positive number.
        let outside = gap[0] - mu * slip;
        let inside = regular * gap[0] + mu * slip;
        let sliding = self.weight / (one + regular);
        let normal = -(sliding * outside);
        let drag = -(sliding * mu * outside / slip);
        let along = sliding * mu * mu - drag;
        let cross = -(sliding * mu);
        let tangential = self.weight * self.ratio;
        // Sticks, slides, or is open.
        let choose = |sticks: S, slides: S| {
            (-inside).select_nonnegative(sticks, outside.select_nonnegative(zero, slides))
        };
        let force = [
            choose(-(self.weight * gap[0]), normal),
            choose(-(tangential * gap[1]), -(normal * mu * direction[0])),
            choose(-(tangential * gap[2]), -(normal * mu * direction[1])),
        ];
        let diagonal =
            |k: usize| choose(tangential, drag + along * direction[k - 1] * direction[k - 1]);
        let with_normal = |k: usize| choose(zero, cross * direction[k - 1]);
        let mixed = choose(zero, along * direction[0] * direction[1]);
        let stiffness = [
            [choose(self.weight, sliding), with_normal(1), with_normal(2)],
            [with_normal(1), diagonal(1), mixed],
            [with_normal(2), mixed, diagonal(2)],
        ];
        Response { force, stiffness }
    }
}

/// Returns the coefficient of friction, at least the smallest one.
pub(super) fn friction<S: Scalar>(coefficient: S) -> S {
    at_least(coefficient, S::from_f64(LEAST_FRICTION))
}

/// Returns the impedance within the range of impedances.
fn possible<S: Scalar>(impedance: S) -> S {
    let [least, most] = IMPEDANCES.map(S::from_f64);
    at_most(at_least(impedance, least), most)
}
