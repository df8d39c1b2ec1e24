//! Lengths that are sums of joint coordinates, and the tendons and couplings that have them.

use alloc::vec::Vec;

use super::stops::StopParameters;
use crate::Scalar;
use crate::equations::TimeStepInput;
use crate::model::Softness;

/// A sum of joint coordinates with factors.
#[derive(Clone, Debug, PartialEq)]
pub struct Length<S> {
    /// The coordinates, each once, with their factors.
    pub terms: Vec<LengthTerm<S>>,
    /// The length at zero coordinates, m or rad.
    pub offset: S,
}

/// A coordinate of a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthTerm<S> {
    /// The entry of q.
    pub coordinate: usize,
    /// The entry of qd.
    pub dof: usize,
    /// The length per unit of the coordinate.
    pub factor: S,
}

/// A tendon whose length is a sum of joint coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct TendonParameters<S> {
    /// The length.
    pub length: Length<S>,
    /// The limits and the dry friction.
    pub stops: StopParameters<S>,
    /// The spring; `None` without stiffness.
    pub spring: Option<SpringParameters<S>>,
    /// The damping, N s/m or N m s/rad; `None` without damping.
    pub damping: Option<S>,
}

/// The spring of a tendon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringParameters<S> {
    /// The stiffness, N/m or N m/rad.
    pub stiffness: S,
    /// The least and the largest length at which the spring exerts no force.
    pub rest: [S; 2],
}

/// A soft coupling: the first length is a polynomial of the second one.
#[derive(Clone, Debug, PartialEq)]
pub struct CouplingParameters<S> {
    /// The lengths.
    pub lengths: [Length<S>; 2],
    /// The coefficients of the polynomial, from degree 0 to degree 4.
    pub polynomial: [S; 5],
    /// The sum of the mobilities of both lengths.
    pub mobility: S,
    /// The softness.
    pub softness: Softness<S>,
}

/// An entry of a constraint row.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowEntry<S> {
    /// The entry of qd.
    pub dof: usize,
    /// The rate of the row per unit of this velocity.
    pub factor: S,
}

/// A length at a state.
pub(super) struct LengthState<S> {
    pub length: S,
    /// The rate of the length.
    pub rate: S,
    /// The derivative of the length.
    pub entries: Vec<RowEntry<S>>,
}

impl<S: Scalar> Length<S> {
    /// Returns the length at a state.
    pub(super) fn at(&self, input: TimeStepInput<'_, S>) -> LengthState<S> {
        let entries = self.entries();
        let length = self
            .terms
            .iter()
            .fold(self.offset, |length, term| length + term.factor * input.q[term.coordinate]);
        LengthState { length, rate: rate(&entries, input.qd), entries }
    }
}

impl<S: Copy> Length<S> {
    /// Returns the derivative of the length.
    pub(super) fn entries(&self) -> Vec<RowEntry<S>> {
        let entry = |&LengthTerm { dof, factor, .. }: &LengthTerm<S>| RowEntry { dof, factor };
        self.terms.iter().map(entry).collect()
    }
}

/// Returns the rate of a row at these velocities.
fn rate<S: Scalar>(entries: &[RowEntry<S>], qd: &[S]) -> S {
    entries.iter().fold(S::zero(), |rate, entry| rate + entry.factor * qd[entry.dof])
}

impl<S: Scalar> TendonParameters<S> {
    /// Adds the joint forces of the spring and of the damper.
    pub(super) fn add_passive_forces(&self, input: TimeStepInput<'_, S>, tau: &mut [S]) {
        let zero = S::zero();
        let LengthState { length, rate, entries } = self.length.at(input);
        let spring = self.spring.map(|SpringParameters { stiffness, rest: [low, high] }| {
            let [above, below] = [length - high, low - length];
            let pulled = above.select_nonnegative(above, zero);
            stiffness * below.select_nonnegative(-below, pulled)
        });
        let damper = self.damping.map(|damping| damping * rate);
        let forces = spring.into_iter().chain(damper);
        let Some(force) = forces.reduce(|spring, damper| spring + damper) else { return };
        for RowEntry { dof, factor } in entries {
            tau[dof] = tau[dof] - factor * force;
        }
    }
}

impl<S: Scalar> CouplingParameters<S> {
    /// Returns the difference between the first length and the polynomial of the second one.
    pub(super) fn at(&self, input: TimeStepInput<'_, S>) -> LengthState<S> {
        let [first, second] = self.lengths.each_ref().map(|length| length.at(input));
        let [c0, c1, c2, c3, c4] = self.polynomial;
        let x = second.length;
        let times = |number: f64, x: S| S::from_f64(number) * x;
        let value = c0 + x * (c1 + x * (c2 + x * (c3 + x * c4)));
        let slope = c1 + x * (times(2.0, c2) + x * (times(3.0, c3) + x * times(4.0, c4)));
        let mut entries = first.entries;
        for RowEntry { dof, factor } in second.entries {
            let factor = -(slope * factor);
            match entries.iter_mut().find(|entry| entry.dof == dof) {
                Some(entry) => entry.factor = entry.factor + factor,
                None => entries.push(RowEntry { dof, factor }),
            }
        }
        LengthState { length: first.length - value, rate: rate(&entries, input.qd), entries }
    }
}

impl<S: Copy> Length<S> {
    /// Returns the length with `f` applied to its numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> Length<T> {
        let term = |&LengthTerm { coordinate, dof, factor }: &LengthTerm<S>| LengthTerm {
            coordinate,
            dof,
            factor: f(factor),
        };
        Length { terms: self.terms.iter().map(term).collect(), offset: f(self.offset) }
    }
}

impl<S: Copy> TendonParameters<S> {
    /// Returns the parameters with `f` applied to their numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> TendonParameters<T> {
        let spring = |SpringParameters { stiffness, rest }: SpringParameters<S>| SpringParameters {
            stiffness: f(stiffness),
            rest: rest.map(f),
        };
        TendonParameters {
            length: self.length.map(f),
            stops: self.stops.map(f),
            spring: self.spring.map(spring),
            damping: self.damping.map(f),
        }
    }
}

impl<S: Copy> CouplingParameters<S> {
    /// Returns the parameters with `f` applied to their numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> CouplingParameters<T> {
        CouplingParameters {
            lengths: self.lengths.each_ref().map(|length| length.map(f)),
            polynomial: self.polynomial.map(f),
            mobility: f(self.mobility),
            softness: self.softness.map(f),
        }
    }
}
