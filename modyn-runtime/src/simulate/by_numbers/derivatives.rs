//! Derivatives of a step by what it depends on.
//!
//! They follow from those of the impulses ([`GroundEquations::gradient`],
//! [`GroundEquations::change`]) and of the contact problem.

use alloc::{vec, vec::Vec};

use super::{
    ALPHA, BETA, BETA_OF_STOPS, Before, COMPLIANCE, FRICTION, GroundRobot, JointStop, RESTITUTION,
    StepImpulses,
};
use crate::scalar::Tangent;
use crate::solve::{
    Contact, Decide, GroundEquations, Stop, add_scaled, least_speed, normal_law, soften,
    velocity_range,
};
use crate::{ConstraintSettings, ContactTarget};

/// The gradients of a step with respect to what it depends on, to which those of one step are
/// added.
#[derive(Debug)]
pub struct StepGradient<'a, T> {
    /// By each number of the contact problem.
    pub problem: &'a mut [T],
    /// By each entry of the inverse of the mass matrix; empty if no stop acts.
    pub inverse: &'a mut Vec<T>,
    /// By the coordinates, through the stops.
    pub q: &'a mut [T],
    /// By the time step, through the least speeds and the stops.
    pub dt: &'a mut T,
    /// By the numbers of the settings, through the laws of contacts and stops.
    pub settings: &'a mut [T],
}

/// The changes of what a step depends on along several directions: for each number a row, with an
/// entry for each direction.
#[derive(Clone, Copy, Debug)]
pub struct StepChanges<'a, T> {
    /// Of the numbers of the contact problem.
    pub problem: &'a [T],
    /// Of the entries of the inverse of the mass matrix; not read if no stop acts.
    pub inverse: &'a [T],
    /// Of the coordinates.
    pub q: &'a [T],
    /// Of the time step.
    pub dt: &'a [T],
    /// Of the numbers of the settings.
    pub settings: &'a [T],
}

impl GroundRobot {
    /// Adds the gradients of the weighted velocities and impulses of a step that
    /// [`solve`](Self::solve) found, with `weights` of the velocities, of the impulses of contacts,
    /// and of those of stops.
    pub fn add_gradient<T: Decide>(
        &self,
        (q, dt, settings): Before<'_, T>,
        (problem, inverse): (impl Fn(usize) -> T, impl Fn(&mut [T])),
        (p, s): StepImpulses<'_, T>,
        [of_velocities, of_contacts, of_stops]: [&[T]; 3],
        gradient: StepGradient<'_, T>,
    ) {
        let at = self.places();
        let rows = 3 * self.contacts;
        let n = self.velocities;
        let mut solved = self.solved((q, dt, settings), (&problem, inverse), (p, s));
        let mut weights = vec![T::zero(); rows + solved.acting.len()];
        for (row, weight) in weights[..rows].iter_mut().enumerate() {
            let response = |v: usize| problem(at.responses + row * n + v);
            *weight = of_contacts[row] + dot(n, |v| (response(v), of_velocities[v]));
        }
        for (stop, weight) in solved.acting.iter().zip(&mut weights[rows..]) {
            let column = &solved.inverse[stop.velocity * n..][..n];
            *weight = of_stops[stop.velocity] + dot(n, |v| (column[v], of_velocities[v]));
        }
        let mut friction = vec![T::zero(); self.contacts];
        let all = solved.impulses.clone();
        let by_b = solved.equations(|equations, matrix| {
            equations.gradient(&all, &weights, &mut friction, matrix)
        });
        // The weights of the velocities, those through the stops included.
        let mut by_velocities = of_velocities.to_vec();
        for (stop, &by) in solved.acting.iter().zip(&by_b[rows..]) {
            by_velocities[stop.velocity] = by_velocities[stop.velocity] + by;
        }
        let StepGradient {
            problem: by_problem,
            inverse,
            q: by_q,
            dt: by_dt,
            settings: by_settings,
        } = gradient;
        let add = |place: &mut T, x: T| *place = *place + x;
        by_problem[..n].iter_mut().zip(&by_velocities).for_each(|(place, &x)| add(place, x));
        for c in 0..self.contacts {
            let own = Self::first_number_of(c);
            let z = 3 * c + 2;
            (0..3).for_each(|k| add(&mut by_problem[at.free + 3 * c + k], by_b[3 * c + k]));
            let by = self.least_speed_changes((dt, settings), c, &problem);
            let by = by.map(|slope| -(by_b[z] * slope));
            add(&mut by_problem[at.heights + c], by[0]);
            add(&mut by_problem[at.before + z], by[1]);
            add(by_dt, by[3]);
            let law = [ALPHA, BETA, COMPLIANCE, RESTITUTION];
            law.iter().zip(&by[4..]).for_each(|(at, &by)| add(&mut by_settings[own + at], by));
            add(&mut by_settings[own + COMPLIANCE], by_b[z] * p[z]);
            add(&mut by_settings[own + FRICTION], friction[c]);
        }
        for row in 0..rows {
            for column in 0..rows {
                add(&mut by_problem[at.mobility + row * rows + column], by_b[row] * p[column]);
            }
            let responses = &mut by_problem[at.responses + row * n..][..n];
            for (place, &by) in responses.iter_mut().zip(&by_velocities) {
                add(place, by * p[row]);
            }
            for stop in &solved.acting {
                add(&mut responses[stop.velocity], by_b[row] * s[stop.velocity]);
            }
        }
        if solved.acting.is_empty() {
            return;
        }
        inverse.resize(n * n, T::zero());
        for (stop, &by) in solved.acting.iter().zip(&by_b[rows..]) {
            let v = stop.velocity;
            let impulse = s[stop.velocity];
            for (place, &by) in inverse[v * n..][..n].iter_mut().zip(&by_velocities) {
                add(place, by * impulse);
            }
            let slopes = stop_changes((q, dt, settings.beta), stop, impulse);
            let [by_place, by_time, by_beta] = slopes.map(|slope| -(by * slope));
            add(&mut by_q[stop.coordinate], by_place);
            add(by_dt, by_time);
            add(&mut by_settings[BETA_OF_STOPS], by_beta);
        }
    }

    /// Sets the changes of the velocities, of the impulses of contacts and of those of stops of a
    /// step that [`solve`](Self::solve) found: for each number a row, with an entry for each
    /// direction of `changes`.
    pub fn changes<T: Decide>(
        &self,
        (q, dt, settings): Before<'_, T>,
        (problem, inverse): (impl Fn(usize) -> T, impl Fn(&mut [T])),
        (p, s): StepImpulses<'_, T>,
        changes: &StepChanges<'_, T>,
        [velocities, of_contacts, of_stops]: [&mut [T]; 3],
    ) {
        let at = self.places();
        let rows = 3 * self.contacts;
        let n = self.velocities;
        let directions = changes.dt.len();
        let span = |first: usize, count: usize| first * directions..(first + count) * directions;
        let of_problem = |number: usize| &changes.problem[span(number, 1)];
        let mut solved = self.solved((q, dt, settings), (&problem, inverse), (p, s));
        // With the present impulses.
        velocities.copy_from_slice(&changes.problem[span(0, n)]);
        for (row, &p) in p.iter().enumerate() {
            add_scaled(velocities, p, &changes.problem[span(at.responses + row * n, n)]);
        }
        for stop in &solved.acting {
            add_scaled(velocities, s[stop.velocity], &changes.inverse[span(stop.velocity * n, n)]);
        }
        let mut all = vec![T::zero(); span(0, rows + solved.acting.len()).end];
        for (row, faster) in all[span(0, rows)].chunks_mut(directions).enumerate() {
            faster.copy_from_slice(of_problem(at.free + row));
            for (column, &p) in p.iter().enumerate() {
                add_scaled(faster, p, of_problem(at.mobility + row * rows + column));
            }
            for stop in &solved.acting {
                let v = stop.velocity;
                add_scaled(faster, s[v], of_problem(at.responses + row * n + v));
            }
        }
        let mut friction = Vec::with_capacity(span(0, self.contacts).end);
        for c in 0..self.contacts {
            let z = 3 * c + 2;
            let own = |number| &changes.settings[span(Self::first_number_of(c) + number, 1)];
            let of = [
                of_problem(at.heights + c),
                of_problem(at.before + z),
                of_problem(at.free + z),
                changes.dt,
                own(ALPHA),
                own(BETA),
                own(COMPLIANCE),
                own(RESTITUTION),
            ];
            let faster = &mut all[span(z, 1)];
            add_scaled(faster, p[z], own(COMPLIANCE));
            for (by, of) in self.least_speed_changes((dt, settings), c, &problem).iter().zip(of) {
                add_scaled(faster, -*by, of);
            }
            friction.extend_from_slice(own(FRICTION));
        }
        for (stop, faster) in
            solved.acting.iter().zip(all[span(0, rows).end..].chunks_mut(directions))
        {
            faster.copy_from_slice(&velocities[span(stop.velocity, 1)]);
            let of = [stop.coordinate, BETA_OF_STOPS].map(|number| span(number, 1));
            let of = [&changes.q[of[0].clone()], changes.dt, &changes.settings[of[1].clone()]];
            let by = stop_changes((q, dt, settings.beta), stop, s[stop.velocity]);
            by.iter().zip(of).for_each(|(by, of)| add_scaled(faster, -*by, of));
        }
        let impulses = solved.impulses.clone();
        solved.equations(|own, matrix| own.change(&impulses, (&mut all, &friction), matrix));
        of_contacts.copy_from_slice(&all[span(0, rows)]);
        of_stops.fill(T::zero());
        for (stop, more) in solved.acting.iter().zip(all[span(0, rows).end..].chunks(directions)) {
            of_stops[span(stop.velocity, 1)].copy_from_slice(more);
            let column = &solved.inverse[stop.velocity * n..][..n];
            for (velocity, &by) in velocities.chunks_mut(directions).zip(column) {
                add_scaled(velocity, by, more);
            }
        }
        for (row, more) in all[span(0, rows)].chunks(directions).enumerate() {
            for (v, velocity) in velocities.chunks_mut(directions).enumerate() {
                add_scaled(velocity, problem(at.responses + row * n + v), more);
            }
        }
    }

    /// Returns the equations that the impulses of a step satisfy.
    fn solved<T: Decide>(
        &self,
        (q, dt, settings): Before<'_, T>,
        (problem, inverse): (&impl Fn(usize) -> T, impl Fn(&mut [T])),
        (p, s): StepImpulses<'_, T>,
    ) -> Solved<T> {
        let at = self.places();
        let rows = 3 * self.contacts;
        let n = self.velocities;
        let acts = |stop: &&JointStop| !s[stop.velocity].abs().all_at_most(T::zero());
        let acting: Vec<JointStop> = self.stops.iter().filter(acts).copied().collect();
        let mut w = Vec::new();
        if !acting.is_empty() {
            w.resize(n * n, T::zero());
            inverse(&mut w);
        }
        let response = |row: usize, v: usize| problem(at.responses + row * n + v);
        let mut matrix = Vec::with_capacity(rows + acting.len());
        let mut b = Vec::new();
        let mut impulses = p.to_vec();
        for row in 0..rows {
            let target = &settings.contacts[row / 3];
            let own = |column: usize| problem(at.mobility + row * rows + column);
            let mut line: Vec<T> = (0..rows).map(own).collect();
            let mut velocity = problem(at.free + row);
            if row % 3 == 2 {
                let of = self.speeds(dt, row / 3, problem);
                velocity = velocity - least_speed(of, normal_law(target));
            }
            line.extend(acting.iter().map(|stop| response(row, stop.velocity)));
            matrix.push(line);
            b.push(velocity);
        }
        soften(&settings.contacts, &mut matrix);
        let mut stops = Vec::new();
        for stop in &acting {
            let v = stop.velocity;
            let of_contacts = (0..rows).map(|row| response(row, v));
            let of_stops = acting.iter().map(|other| w[v * n + other.velocity]);
            matrix.push(of_contacts.chain(of_stops).collect());
            b.push(problem(v));
            impulses.push(s[v]);
            let range = velocity_range(q[stop.coordinate], stop.range, settings.beta, dt);
            stops.push(Stop::new(range));
        }
        let contacts = settings.contacts.iter().map(|target| Contact::new(target.friction));
        Solved { matrix, b, contacts: contacts.collect(), stops, impulses, acting, inverse: w }
    }

    /// Returns the height of a contact, its speeds along the normal before the step and without
    /// impulses, and the time step.
    fn speeds<T: Decide>(&self, dt: T, contact: usize, problem: &impl Fn(usize) -> T) -> [T; 4] {
        let at = self.places();
        let z = 3 * contact + 2;
        [problem(at.heights + contact), problem(at.before + z), problem(at.free + z), dt]
    }

    /// Returns the derivatives of the least speed of a contact by [`speeds`](Self::speeds) and
    /// [`normal_law`].
    fn least_speed_changes<T: Decide>(
        &self,
        (dt, settings): (T, &ConstraintSettings<T, Vec<ContactTarget<T>>>),
        contact: usize,
        problem: &impl Fn(usize) -> T,
    ) -> [T; 8] {
        let [height, before, free, dt] = self.speeds(dt, contact, problem);
        let [alpha, beta, compliance, restitution] = normal_law(&settings.contacts[contact]);
        derivatives(
            [height, before, free, dt, alpha, beta, compliance, restitution],
            |[height, before, free, dt, alpha, beta, compliance, restitution]| {
                least_speed([height, before, free, dt], [alpha, beta, compliance, restitution])
            },
        )
    }
}

/// The equations of a step with their solution, the stops that act, and the inverse of the mass
/// matrix, if one acts.
struct Solved<T> {
    matrix: Vec<Vec<T>>,
    b: Vec<T>,
    contacts: Vec<Contact<T>>,
    stops: Vec<Stop<T>>,
    impulses: Vec<T>,
    acting: Vec<JointStop>,
    inverse: Vec<T>,
}

impl<T: Decide> Solved<T> {
    /// Calls `work` with the equations and memory for a matrix.
    fn equations<O>(
        &mut self,
        work: impl FnOnce(&mut GroundEquations<'_, T, Vec<T>>, &mut [Vec<T>]) -> O,
    ) -> O {
        let Self { matrix, b, contacts, stops, .. } = self;
        let mut memory = matrix.clone();
        work(&mut GroundEquations { a: matrix, b, contacts, stops }, &mut memory)
    }
}

/// Returns the derivatives of the velocity at which a stop holds its joint, by the coordinate, the
/// time step and `beta`.
fn stop_changes<T: Decide>((q, dt, beta): (&[T], T, T), stop: &JointStop, impulse: T) -> [T; 3] {
    // The impulse at the lower limit is positive.
    let side = usize::from(impulse.all_at_most(T::zero()));
    derivatives([q[stop.coordinate], dt, beta], |[at, dt, beta]| {
        velocity_range(at, stop.range, beta, dt)[side]
    })
}

/// Returns the derivatives of a function by each of its arguments.
fn derivatives<T: Decide, const N: usize>(
    at: [T; N],
    function: impl Fn([Tangent<T>; N]) -> Tangent<T>,
) -> [T; N] {
    core::array::from_fn(|k| {
        let mut arguments = at.map(Tangent::constant);
        arguments[k].dx = T::one();
        function(arguments).dx
    })
}

/// Returns the sum of as many products.
fn dot<T: Decide>(count: usize, pair: impl Fn(usize) -> (T, T)) -> T {
    (0..count).map(pair).fold(T::zero(), |sum, (a, b)| a.mul_add(b, sum))
}
