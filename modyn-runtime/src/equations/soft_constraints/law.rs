//! The laws of soft constraints: impedance, reference acceleration, and the force of a row or of a
//! contact.
//!
//! These are MuJoCo's laws, by its documentation ("Computation", section "Constraint model") and
//! with its parameters: a row with the Jacobian J has a reference acceleration a* and a
//! regularization R = (1 - d) A / d, where d is the impedance and A an approximation of J M^-1 J^T.
//! Its force follows from J qdd - a*. All forces together minimize a convex function.

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::model::{Cone, Impedance, Softness};
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

/// A row of a soft constraint at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftRow<S> {
    /// 1 / R, kg or kg m^2: the force for each unit of acceleration below the reference.
    pub weight: S,
    /// The reference acceleration, m/s^2 or rad/s^2.
    pub reference: S,
}

impl<S: Scalar> SoftRow<S> {
    /// Returns the row with the weight times `scale`.
    pub(super) fn scaled(&self, scale: S) -> Self {
        Self { weight: self.weight * scale, ..*self }
    }

    /// Returns the force at an acceleration of the row, which pushes and pulls, and minus its
    /// derivative.
    pub(super) fn response(&self, acceleration: S) -> [S; 2] {
        [-(self.weight * (acceleration - self.reference)), self.weight]
    }
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

impl<S: Scalar> Softness<S> {
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
        self.row_of_impedance(self.impedance.at(state.position), state, dt)
    }

    /// Returns a row with the impedance of the constraint to which it belongs.
    #[must_use]
    pub fn row_of_impedance(&self, impedance: S, state: &RowState<S>, dt: S) -> SoftRow<S> {
        let [stiffness, damping] = self.stiffness_and_damping(dt);
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

/// The law of a contact at a state. Components are along the normal, along two tangents, and the
/// rotations about the normal and about the tangents: the first one, three, four or six of these.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactLaw<S> {
    /// The cone.
    pub cone: Cone,
    /// The coefficient of friction of each component but the first.
    pub friction: Vec<S>,
    /// The ratio of the weights of the tangents to that of the normal: MuJoCo's `impratio`.
    pub ratio: S,
    /// The weight of the normal; zero for a contact that does not touch.
    pub weight: S,
    /// The reference acceleration of each component.
    pub reference: Vec<S>,
}

/// The force of each component, and minus its derivative by the accelerations: a symmetric positive
/// semi-definite matrix, by rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Response<S> {
    /// The forces, N and N m.
    pub force: Vec<S>,
    /// Minus the derivative, kg, kg m and kg m^2.
    pub stiffness: Vec<Vec<S>>,
}

impl<S: Scalar> ContactLaw<S> {
    /// Returns the law with the weight times `scale`.
    #[must_use]
    pub fn scaled(&self, scale: S) -> Self {
        Self { weight: self.weight * scale, ..self.clone() }
    }

    /// Returns the response to these accelerations of the contact.
    #[must_use]
    pub fn response(&self, acceleration: &[S]) -> Response<S> {
        let components = acceleration.iter().zip(&self.reference);
        let gap: Vec<S> = components.map(|(&a, &reference)| a - reference).collect();
        if self.friction.is_empty() {
            let active = gap[0].select_nonnegative(S::zero(), self.weight);
            return Response { force: vec![-(active * gap[0])], stiffness: vec![vec![active]] };
        }
        match self.cone {
            Cone::Pyramidal => self.pyramid(&gap),
            Cone::Elliptic => self.ellipse(&gap),
        }
    }

    /// The force of the edges n + mu t, n - mu t for each component t with friction, each of which
    /// can push alone.
    fn pyramid(&self, gap: &[S]) -> Response<S> {
        let (zero, one) = (S::zero(), S::one());
        // All edges have the weight of the first: its mobility is (1 + mu^2) times that of the
        // normal, and the regularization is scaled by 2 mu^2 / ratio.
        let square = self.friction[0] * self.friction[0];
        let scale = S::from_f64(2.0) * square * (one + square) / self.ratio;
        let weight = self.weight / scale;
        let n = gap.len();
        let mut response = Response { force: vec![zero; n], stiffness: vec![vec![zero; n]; n] };
        for (k, &friction) in self.friction.iter().enumerate() {
            for share in [friction, -friction] {
                let component = k + 1;
                let edge = gap[0] + share * gap[component];
                let active = edge.select_nonnegative(zero, weight);
                let force = -(active * edge);
                for (i, along) in [(0, one), (component, share)] {
                    response.force[i] = response.force[i] + along * force;
                    for (j, across) in [(0, one), (component, share)] {
                        let entry = &mut response.stiffness[i][j];
                        *entry = *entry + active * along * across;
                    }
                }
            }
        }
        response
    }

    /// The force of an elliptic cone. In coordinates in which the regularization is the same in all
    /// directions, the force is the projection of the unconstrained one onto the cone.
    fn ellipse(&self, gap: &[S]) -> Response<S> {
        let (zero, one) = (S::zero(), S::one());
        let mu = self.friction[0];
        // Each component in the unit of the first tangent.
        let shares: Vec<S> = self.friction.iter().map(|&friction| friction / mu).collect();
        let scaled: Vec<S> = shares.iter().zip(&gap[1..]).map(|(&x, &gap)| x * gap).collect();
        let square = scaled.iter().fold(S::from_f64(1e-36), |sum, &x| sum + x * x);
        let slip = square.sqrt();
        let direction: Vec<S> = scaled.iter().map(|&x| x / slip).collect();
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
        let tangents = || 0..scaled.len();
        let mut force = vec![choose(-(self.weight * gap[0]), normal)];
        force.extend(tangents().map(|k| {
            let slides = -(normal * mu * direction[k]);
            shares[k] * choose(-(tangential * scaled[k]), slides)
        }));
        let with_normal: Vec<S> =
            tangents().map(|k| shares[k] * choose(zero, cross * direction[k])).collect();
        let mut first = vec![choose(self.weight, sliding)];
        first.extend(&with_normal);
        let mut stiffness = vec![first];
        stiffness.extend(tangents().map(|i| {
            let entry = |j: usize| {
                let mixed = along * direction[i] * direction[j];
                let entry = match i == j {
                    true => choose(tangential, drag + mixed),
                    false => choose(zero, mixed),
                };
                shares[i] * shares[j] * entry
            };
            [with_normal[i]].into_iter().chain(tangents().map(entry)).collect()
        }));
        Response { force, stiffness }
    }
}

/// The speed along the normal at which a contact slides without force by a cone.
pub(super) struct Separation<S> {
    /// The speed, m/s.
    pub speed: S,
    /// Its derivative by the rate of each component but the normal.
    pub by_rate: Vec<S>,
}

/// Returns the separation of a contact whose components but the normal have these rates.
pub(super) fn separation<S: Scalar>(cone: Cone, friction: &[S], rates: &[S]) -> Separation<S> {
    let zero = S::zero();
    let scaled = || friction.iter().zip(rates).map(|(&friction, &rate)| friction * rate);
    match cone {
        Cone::Elliptic => {
            let square = scaled().fold(S::from_f64(1e-36), |sum, x| sum + x * x);
            let speed = square.sqrt();
            let by_rate = friction.iter().zip(scaled()).map(|(&mu, x)| mu * x / speed);
            Separation { speed, by_rate: by_rate.collect() }
        }
        // The edge that moves most towards the plane.
        Cone::Pyramidal => {
            let speed = scaled().fold(zero, |speed, x| larger(speed, x.abs()));
            let by_rate = friction.iter().zip(scaled()).map(|(&mu, x)| {
                let along = x.select_nonnegative(mu, -mu);
                (x.abs() - speed).select_nonnegative(along, zero)
            });
            Separation { speed, by_rate: by_rate.collect() }
        }
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

/// Returns the larger of two numbers that are not negative; unlike [`Scalar::max`], NaN if one is
/// NaN.
#[inline(always)]
pub(super) fn larger<S: Scalar>(a: S, b: S) -> S {
    let sum = a + b;
    sum.select_nonnegative(a.max(b), sum)
}
