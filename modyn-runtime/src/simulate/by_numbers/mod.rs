//! Steps on the ground of a robot that is known at run time, and their derivatives, on plain
//! numbers.
//!
//! The numbers of a [`ContactProblem`](crate::ContactProblem) are those of its fields in their
//! order; rows and columns of matrices are those of the contacts, and `responses` has an entry for
//! each velocity in each row.
//!
//! A step with the impulses p of contacts and s of stops has the velocities
//!
//! ```text
//! qd' = qd + R^T p + W s,  u = A p + b + R s,  W = M^-1
//! ```
//!
//! where R are the responses, A the mobility, and b the velocities of the contacts less their least
//! speeds.

mod derivatives;
mod lanes;
mod memory;
#[cfg(test)]
mod tests;

pub use derivatives::{StepChanges, StepGradient};
pub use lanes::StepLanes;

use alloc::{vec, vec::Vec};

use super::impulses::{FreeMotion, Ground, Impulses, solve_step, velocity_range};
use crate::model::Model;
use crate::solve::{Contact, Decide, Effort, Residual, Stop};
use crate::{ConstraintSettings, ContactTarget};
use memory::{Arrays, NumbersMemory, Vectors};

/// A joint with one coordinate, which its limits stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointStop {
    /// The index of its coordinate.
    pub coordinate: usize,
    /// The index of its velocity.
    pub velocity: usize,
    /// The lowest and the highest coordinate, rad or m, infinite without a limit. Those of mimic
    /// joints count, too.
    pub range: [f64; 2],
}

/// A robot on the ground: the numbers of its contacts and velocities, and the stops of its joints.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundRobot {
    contacts: usize,
    velocities: usize,
    stops: Vec<JointStop>,
}

/// The state before a step: the coordinates, the time step (s), and the settings.
pub type Before<'a, T> = (&'a [T], T, &'a ConstraintSettings<T, Vec<ContactTarget<T>>>);

/// The impulses of a step: three of each contact, along the axes of its target, and one for each
/// velocity, of its stop.
pub type StepImpulses<'a, T> = (&'a [T], &'a [T]);

/// The first number of each field of a contact problem, and the number of all numbers.
#[derive(Clone, Copy)]
struct Places {
    heights: usize,
    before: usize,
    free: usize,
    mobility: usize,
    responses: usize,
    end: usize,
}

impl GroundRobot {
    /// Returns the model with its contacts, and the limits of its joints as stops if `joint_limits`
    /// is set.
    #[must_use]
    pub fn new(model: &Model, joint_limits: bool) -> Self {
        let links = 0..if joint_limits { model.links().len() } else { 0 };
        let stop = |link: usize| {
            let q = model.q_range(link);
            let v = model.v_range(link);
            let range = model.coordinate_range(link);
            let is_own = model.links()[link].joint.mimic.is_none() && v.len() == 1;
            let is_limited = range[0].is_finite() || range[1].is_finite();
            let stop = JointStop { coordinate: q.start, velocity: v.start, range };
            (is_own && is_limited).then_some(stop)
        };
        let stops = links.filter_map(stop).collect();
        Self { contacts: model.contacts().len(), velocities: model.nv(), stops }
    }

    /// Returns the robot without contacts: with joint stops alone.
    #[must_use]
    pub fn without_contacts(self) -> Self {
        Self { contacts: 0, ..self }
    }

    /// Returns the number of contacts.
    #[must_use]
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// Returns whether a joint has a stop.
    #[must_use]
    pub fn has_stops(&self) -> bool {
        !self.stops.is_empty()
    }

    /// Returns the number of numbers of the contact problem.
    #[must_use]
    pub fn problem_length(&self) -> usize {
        self.places().end
    }

    /// Returns the index of the first number of a contact's target among the numbers of the
    /// settings.
    #[must_use]
    pub fn first_number_of(contact: usize) -> usize {
        ConstraintSettings::<f64>::COUNT + contact * ContactTarget::<f64>::COUNT
    }

    fn places(&self) -> Places {
        let (contacts, rows) = (self.contacts, 3 * self.contacts);
        let heights = self.velocities;
        let before = heights + contacts;
        let free = before + rows;
        let mobility = free + rows;
        let responses = mobility + rows * rows;
        let end = responses + rows * self.velocities;
        Places { heights, before, free, mobility, responses, end }
    }

    /// Finds the impulses of a step from those of the last step, which are zero at first, and the
    /// velocities after it. Returns what is wrong with them, and the work. `problem` returns a
    /// number of the contact problem; `inverse` sets the inverse of the mass matrix, which is asked
    /// for if a joint reaches a stop.
    pub fn solve<T: Decide>(
        &self,
        ground: &Ground<T>,
        before: Before<'_, T>,
        (problem, inverse): (impl Fn(usize) -> T, impl Fn(&mut [T])),
        impulses: (&mut [T], &mut [T]),
        velocities: &mut [T],
    ) -> (Residual<T>, Effort) {
        let found = (impulses, velocities);
        match (self.contacts, self.velocities) {
            (..=4, ..=20) => {
                let memory = Arrays::<_, 12, 20, 32> { inverse, velocities: self.velocities };
                self.solve_in(&memory, (ground, before), problem, found)
            }
            (..=8, ..=40) => {
                let memory = Arrays::<_, 24, 40, 64> { inverse, velocities: self.velocities };
                self.solve_in(&memory, (ground, before), problem, found)
            }
            (contacts, velocities) => {
                let memory = Vectors { inverse, contacts, velocities };
                self.solve_in(&memory, (ground, before), problem, found)
            }
        }
    }

    fn solve_in<T: Decide, M: NumbersMemory<T>>(
        &self,
        memory: &M,
        (ground, (q, dt, settings)): (&Ground<T>, Before<'_, T>),
        problem: impl Fn(usize) -> T,
        ((of_contacts, of_stops), velocities): ((&mut [T], &mut [T]), &mut [T]),
    ) -> (Residual<T>, Effort) {
        let at = self.places();
        let rows = 3 * self.contacts;
        let n = self.velocities;
        let fill = |numbers: &mut [T], first: usize, count: usize| {
            numbers[..count].iter_mut().zip(first..).for_each(|(x, i)| *x = problem(i));
        };
        let mut qd = memory.velocities();
        fill(qd.as_mut(), 0, n);
        let [mut heights, mut before, mut free] = [(); 3].map(|()| memory.contact_row());
        fill(heights.as_mut(), at.heights, self.contacts);
        fill(before.as_mut(), at.before, rows);
        fill(free.as_mut(), at.free, rows);
        let mut mobility = memory.contact_matrix();
        let mut responses = memory.responses();
        for row in 0..rows {
            fill(mobility.as_mut()[row].as_mut(), at.mobility + row * rows, rows);
            fill(responses.as_mut()[row].as_mut(), at.responses + row * n, n);
        }
        let motion = FreeMotion {
            dt,
            qd: &qd.as_ref()[..n],
            heights: &heights.as_ref()[..self.contacts],
            before: &before,
            free: &free,
            mobility: &mobility.as_ref()[..rows],
            responses: &responses.as_ref()[..rows],
        };
        let unlimited = [f64::NEG_INFINITY, f64::INFINITY].map(T::from_f64);
        let mut stops = vec![Stop::new(unlimited); if self.stops.is_empty() { 0 } else { n }];
        for stop in &self.stops {
            let range = velocity_range(q[stop.coordinate], stop.range, settings.beta, dt);
            stops[stop.velocity].range = range;
        }
        let mut impulses = Impulses { contacts: memory.contact_row(), stops: memory.velocities() };
        impulses.contacts.as_mut()[..rows].copy_from_slice(of_contacts);
        impulses.stops.as_mut()[..n].copy_from_slice(of_stops);
        let found = solve_step(
            memory,
            &motion,
            &settings.contacts,
            ground,
            (&mut vec![Contact::new(T::zero()); self.contacts], &mut stops, &mut vec![0; n]),
            &mut impulses,
            velocities,
        );
        of_contacts.copy_from_slice(&impulses.contacts.as_ref()[..rows]);
        of_stops.copy_from_slice(&impulses.stops.as_ref()[..n]);
        found
    }
}

// The indices of numbers of the settings, and of numbers of a target.
const BETA_OF_STOPS: usize = 1;
const ALPHA: usize = 19;
const BETA: usize = 20;
const COMPLIANCE: usize = 21;
const RESTITUTION: usize = 22;
const FRICTION: usize = 24;
