//! Steps on the ground of a robot that is known at run time, and their derivatives, on plain numbers.
//!
//! The numbers of a [`ContactProblem`](crate::ContactProblem) are those of its fields in their order; rows and columns of matrices
//! are those of the contacts, and `responses` has an entry for each velocity in each row.
//!
//! A step with the impulses p of contacts and s of stops has the velocities
//!
//! ```text
//! qd' = qd + R^T p + W s,  u = A p + b + R s,  W = M^-1
//! ```
//!
//! where R are the responses, A the mobility, and b the velocities of the contacts less their least speeds. The derivatives follow
//! from those of p and s ([`GroundEquations::gradient`], [`GroundEquations::change`]).

use alloc::{vec, vec::Vec};

use super::impulses::{
    FreeMotion, Ground, Impulses, StepMemory, add_scaled, least_speed, solve_step, velocity_range,
};
use crate::lanes::{BatchTask, Float, Lanes, MAX_LANES};
use crate::model::Model;
use crate::scalar::Tangent;
use crate::solve::{Contact, Decide, Effort, GroundEquations, Residual, Stop};
use crate::{ConstraintSettings, ContactTarget};

/// A joint with one coordinate, which its limits stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointStop {
    /// The index of its coordinate.
    pub coordinate: usize,
    /// The index of its velocity.
    pub velocity: usize,
    /// The lowest and the highest coordinate, rad or m, infinite without a limit. Those of mimic joints count, too.
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

/// The impulses of a step: three of each contact, along the axes of its target, and one for each velocity, of its stop.
pub type StepImpulses<'a, T> = (&'a [T], &'a [T]);

/// What the steps of several states depend on, a state in each lane: each slice has a row of lanes for each number.
#[derive(Clone, Copy, Debug)]
pub struct StepLanes<'a, T> {
    /// The number of states.
    pub lanes: usize,
    /// The coordinates.
    pub q: &'a [T],
    /// The time steps, s.
    pub dt: &'a [T],
    /// The numbers of the settings.
    pub settings: &'a [T],
    /// The numbers of the contact problem.
    pub problem: &'a [T],
    /// The impulses of the stops in the last step.
    pub stops: &'a [T],
}

/// The gradients of a step with respect to what it depends on, to which those of one step are added.
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

/// The changes of what a step depends on.
#[derive(Clone, Copy, Debug)]
pub struct StepChange<'a, T> {
    /// Of each number of the contact problem.
    pub problem: &'a [T],
    /// Of each entry of the inverse of the mass matrix; not read if no stop acts.
    pub inverse: &'a [T],
    /// Of the coordinates.
    pub q: &'a [T],
    /// Of the time step.
    pub dt: T,
    /// Of the numbers of the settings.
    pub settings: &'a [T],
}

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
    /// Returns the model with its contacts, and the limits of its joints as stops if `joint_limits` is set.
    #[must_use]
    pub fn new(model: &Model, joint_limits: bool) -> Self {
        let links = 0..if joint_limits { model.links().len() } else { 0 };
        let stop = |link: usize| {
            let (q, v) = (model.q_range(link), model.v_range(link));
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

    /// Finds the impulses of a step from those of the last step, which are zero at first, and the velocities after it. Returns what
    /// is wrong with them, and the work. `problem` returns a number of the contact problem; `inverse` sets the inverse of the mass
    /// matrix, which is asked for if a joint reaches a stop.
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

    /// Sweeps over the contacts of several states at once, a state in each lane, from these impulses on, and sets the velocities after
    /// the step. Sets for each lane the residual of its contacts if it is solved: within the tolerance, and no stop acts. The others
    /// are left to [`solve`](Self::solve), with the impulses of the sweeps.
    pub fn solve_lanes<F: Float>(
        &self,
        ground: &Ground<F>,
        numbers: &StepLanes<'_, F>,
        (impulses, velocities): (&mut [F], &mut [F]),
        solved: &mut [Option<F>],
    ) {
        solved.fill(None);
        let robot = self;
        match (self.contacts, self.velocities) {
            (..=4, ..=20) => F::dispatch(LaneSweeps::<_, 4, 12, 20> {
                robot,
                ground,
                numbers,
                impulses,
                velocities,
                solved,
            }),
            (..=8, ..=40) => F::dispatch(LaneSweeps::<_, 8, 24, 40> {
                robot,
                ground,
                numbers,
                impulses,
                velocities,
                solved,
            }),
            _ => {}
        }
    }

    fn solve_in<T: Decide, M: NumbersMemory<T>>(
        &self,
        memory: &M,
        (ground, (q, dt, settings)): (&Ground<T>, Before<'_, T>),
        problem: impl Fn(usize) -> T,
        ((of_contacts, of_stops), velocities): ((&mut [T], &mut [T]), &mut [T]),
    ) -> (Residual<T>, Effort) {
        let (at, rows, n) = (self.places(), 3 * self.contacts, self.velocities);
        let fill = |numbers: &mut [T], first: usize, count: usize| {
            numbers[..count].iter_mut().zip(first..).for_each(|(x, i)| *x = problem(i));
        };
        let mut qd = memory.velocities();
        fill(qd.as_mut(), 0, n);
        let [mut heights, mut before, mut free] = [(); 3].map(|()| memory.contact_row());
        fill(heights.as_mut(), at.heights, self.contacts);
        fill(before.as_mut(), at.before, rows);
        fill(free.as_mut(), at.free, rows);
        let (mut mobility, mut responses) = (memory.contact_matrix(), memory.responses());
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

    /// Adds the gradients of the weighted velocities and impulses of a step that [`solve`](Self::solve) found, with `weights` of the
    /// velocities, of the impulses of contacts, and of those of stops.
    pub fn add_gradient<T: Decide>(
        &self,
        (q, dt, settings): Before<'_, T>,
        (problem, inverse): (impl Fn(usize) -> T, impl Fn(&mut [T])),
        (p, s): StepImpulses<'_, T>,
        [of_velocities, of_contacts, of_stops]: [&[T]; 3],
        gradient: StepGradient<'_, T>,
    ) {
        let (at, rows, n) = (self.places(), 3 * self.contacts, self.velocities);
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
            let own = by_settings_of_contact(c);
            let z = 3 * c + 2;
            (0..3).for_each(|k| add(&mut by_problem[at.free + 3 * c + k], by_b[3 * c + k]));
            let by = self.least_speed_changes((dt, settings), c, &problem);
            let by = by.map(|slope| -(by_b[z] * slope));
            add(&mut by_problem[at.heights + c], by[0]);
            add(&mut by_problem[at.before + z], by[1]);
            add(by_dt, by[3]);
            add(&mut by_settings[own + BETA], by[4]);
            add(&mut by_settings[own + RESTITUTION], by[5]);
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
            let (v, impulse) = (stop.velocity, s[stop.velocity]);
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

    /// Writes the changes of the velocities, of the impulses of contacts and of those of stops of a step that [`solve`](Self::solve)
    /// found.
    pub fn change<T: Decide>(
        &self,
        (q, dt, settings): Before<'_, T>,
        (problem, inverse): (impl Fn(usize) -> T, impl Fn(&mut [T])),
        (p, s): StepImpulses<'_, T>,
        change: StepChange<'_, T>,
        [qd, of_contacts, of_stops]: [&mut [T]; 3],
    ) {
        let (at, rows, n) = (self.places(), 3 * self.contacts, self.velocities);
        let mut solved = self.solved((q, dt, settings), (&problem, inverse), (p, s));
        // With the present impulses.
        qd.copy_from_slice(&change.problem[..n]);
        for (row, &p) in p.iter().enumerate() {
            add_scaled(qd, p, &change.problem[at.responses + row * n..][..n]);
        }
        for stop in &solved.acting {
            let v = stop.velocity;
            add_scaled(qd, s[v], &change.inverse[v * n..][..n]);
        }
        let mut faster = vec![T::zero(); rows + solved.acting.len()];
        for (row, faster) in faster[..rows].iter_mut().enumerate() {
            let own = |column: usize| change.problem[at.mobility + row * rows + column];
            *faster = change.problem[at.free + row] + dot(rows, |column| (own(column), p[column]));
            for stop in &solved.acting {
                let v = stop.velocity;
                *faster = *faster + change.problem[at.responses + row * n + v] * s[v];
            }
        }
        let mut friction = vec![T::zero(); self.contacts];
        for (c, friction) in friction.iter_mut().enumerate() {
            let own = &change.settings[by_settings_of_contact(c)..];
            let z = 3 * c + 2;
            let by = self.least_speed_changes((dt, settings), c, &problem);
            let of = [
                change.problem[at.heights + c],
                change.problem[at.before + z],
                change.problem[at.free + z],
                change.dt,
                own[BETA],
                own[RESTITUTION],
            ];
            faster[z] = faster[z] + own[COMPLIANCE] * p[z] - dot(6, |k| (by[k], of[k]));
            *friction = own[FRICTION];
        }
        for (stop, faster) in solved.acting.iter().zip(&mut faster[rows..]) {
            let by = stop_changes((q, dt, settings.beta), stop, s[stop.velocity]);
            let of = [change.q[stop.coordinate], change.dt, change.settings[BETA_OF_STOPS]];
            *faster = qd[stop.velocity] - dot(3, |k| (by[k], of[k]));
        }
        let all = solved.impulses.clone();
        let found = solved
            .equations(|equations, matrix| equations.change(&all, (&faster, &friction), matrix));
        for (row, &more) in found[..rows].iter().enumerate() {
            let response = |v: usize| problem(at.responses + row * n + v);
            qd.iter_mut().enumerate().for_each(|(v, x)| *x = *x + response(v) * more);
        }
        of_contacts.copy_from_slice(&found[..rows]);
        of_stops.fill(T::zero());
        for (stop, &more) in solved.acting.iter().zip(&found[rows..]) {
            add_scaled(qd, more, &solved.inverse[stop.velocity * n..][..n]);
            of_stops[stop.velocity] = more;
        }
    }

    /// Returns the equations that the impulses of a step satisfy.
    fn solved<T: Decide>(
        &self,
        (q, dt, settings): Before<'_, T>,
        (problem, inverse): (&impl Fn(usize) -> T, impl Fn(&mut [T])),
        (p, s): StepImpulses<'_, T>,
    ) -> Solved<T> {
        let (at, rows, n) = (self.places(), 3 * self.contacts, self.velocities);
        let acts = |stop: &&JointStop| !s[stop.velocity].abs().all_at_most(T::zero());
        let acting: Vec<JointStop> = self.stops.iter().filter(acts).copied().collect();
        let mut w = Vec::new();
        if !acting.is_empty() {
            w.resize(n * n, T::zero());
            inverse(&mut w);
        }
        let response = |row: usize, v: usize| problem(at.responses + row * n + v);
        let mut matrix = Vec::with_capacity(rows + acting.len());
        let (mut b, mut impulses) = (Vec::new(), p.to_vec());
        for row in 0..rows {
            let target = &settings.contacts[row / 3];
            let own = |column: usize| problem(at.mobility + row * rows + column);
            let mut line: Vec<T> = (0..rows).map(own).collect();
            let mut velocity = problem(at.free + row);
            if row % 3 == 2 {
                line[row] = line[row] + target.compliance;
                let of = self.speeds(dt, row / 3, problem);
                velocity = velocity - least_speed(of, target.beta, target.restitution);
            }
            line.extend(acting.iter().map(|stop| response(row, stop.velocity)));
            matrix.push(line);
            b.push(velocity);
        }
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

    /// Returns the height of a contact, its speeds along the normal before the step and without impulses, and the time step.
    fn speeds<T: Decide>(&self, dt: T, contact: usize, problem: &impl Fn(usize) -> T) -> [T; 4] {
        let (at, z) = (self.places(), 3 * contact + 2);
        [problem(at.heights + contact), problem(at.before + z), problem(at.free + z), dt]
    }

    /// Returns the derivatives of the least speed of a contact by [`speeds`](Self::speeds), `beta` and the restitution.
    fn least_speed_changes<T: Decide>(
        &self,
        (dt, settings): (T, &ConstraintSettings<T, Vec<ContactTarget<T>>>),
        contact: usize,
        problem: &impl Fn(usize) -> T,
    ) -> [T; 6] {
        let ContactTarget { beta, restitution, .. } = settings.contacts[contact];
        let [height, before, free, dt] = self.speeds(dt, contact, problem);
        derivatives([height, before, free, dt, beta, restitution], |[a, b, c, d, beta, e]| {
            least_speed([a, b, c, d], beta, e)
        })
    }
}

/// The first number of a contact among the settings.
fn by_settings_of_contact(contact: usize) -> usize {
    ConstraintSettings::<f64>::COUNT + contact * ContactTarget::<f64>::COUNT
}

// The places among the settings, and among those of a contact.
const BETA_OF_STOPS: usize = 1;
const BETA: usize = 20;
const COMPLIANCE: usize = 21;
const RESTITUTION: usize = 22;
const FRICTION: usize = 24;

/// The equations of a step with their solution, the stops that act, and the inverse of the mass matrix, if one acts.
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

/// Returns the derivatives of the velocity at which a stop holds its joint, by the coordinate, the time step and `beta`.
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

/// [`GroundRobot::solve_lanes`] of a robot with at most as many contacts, rows of contacts, and velocities.
struct LaneSweeps<'a, F, const CONTACTS: usize, const ROWS: usize, const VELOCITIES: usize> {
    robot: &'a GroundRobot,
    ground: &'a Ground<F>,
    numbers: &'a StepLanes<'a, F>,
    impulses: &'a mut [F],
    velocities: &'a mut [F],
    solved: &'a mut [Option<F>],
}

impl<F: Float, const CONTACTS: usize, const ROWS: usize, const VELOCITIES: usize> BatchTask<F>
    for LaneSweeps<'_, F, CONTACTS, ROWS, VELOCITIES>
{
    #[inline(always)]
    fn run<L: Lanes<Lane = F>>(self) {
        let Self { robot, ground, numbers, impulses, velocities, solved } = self;
        let lanes = numbers.lanes;
        let (at, rows, n) = (robot.places(), 3 * robot.contacts, robot.velocities);
        let tolerance = L::splat(ground.tolerance);
        let mut first = 0;
        while first + L::LANES <= lanes {
            // No closure: it would not be compiled for the instructions of lanes.
            macro_rules! get {
                ($numbers:expr, $row:expr) => {
                    L::read(&$numbers[($row) * lanes + first..])
                };
            }
            let dt = get!(numbers.dt, 0);
            let mut contacts = [Contact::new(L::zero()); CONTACTS];
            let mut b = [L::zero(); ROWS];
            let mut a = [[L::zero(); ROWS]; ROWS];
            let mut row = 0;
            while row < rows {
                let mut column = 0;
                while column < rows {
                    a[row][column] = get!(numbers.problem, at.mobility + row * rows + column);
                    column += 1;
                }
                b[row] = get!(numbers.problem, at.free + row);
                if row % 3 == 2 {
                    let c = row / 3;
                    let own = by_settings_of_contact(c);
                    contacts[c] = Contact::new(get!(numbers.settings, own + FRICTION));
                    a[row][row] = a[row][row] + get!(numbers.settings, own + COMPLIANCE);
                    let height = get!(numbers.problem, at.heights + c);
                    let before = get!(numbers.problem, at.before + row);
                    let least = least_speed(
                        [height, before, b[row], dt],
                        get!(numbers.settings, own + BETA),
                        get!(numbers.settings, own + RESTITUTION),
                    );
                    b[row] = b[row] - least;
                }
                row += 1;
            }
            let mut p = [L::zero(); ROWS];
            let mut row = 0;
            while row < rows {
                p[row] = get!(impulses, row);
                row += 1;
            }
            let mut equations = GroundEquations {
                a: &a[..rows],
                b: &b,
                contacts: &mut contacts[..robot.contacts],
                stops: &mut [],
            };
            let residual = equations.sweep_lanes(&mut p, (ground.sweeps, tolerance));
            let mut qd = [L::zero(); VELOCITIES];
            let mut v = 0;
            while v < n {
                qd[v] = get!(numbers.problem, v);
                let mut row = 0;
                while row < rows {
                    let response = get!(numbers.problem, at.responses + row * n + v);
                    qd[v] = response.mul_add(p[row], qd[v]);
                    row += 1;
                }
                v += 1;
            }
            // The largest of what is beyond a stop, and of the impulses of stops: none may be above zero.
            let mut stopped = L::zero();
            let beta = get!(numbers.settings, BETA_OF_STOPS);
            let mut k = 0;
            while k < robot.stops.len() {
                let stop = &robot.stops[k];
                let range = velocity_range(get!(numbers.q, stop.coordinate), stop.range, beta, dt);
                let speed = qd[stop.velocity];
                stopped =
                    stopped.max(range[0] - tolerance - speed).max(speed - range[1] - tolerance);
                stopped = stopped.max(get!(numbers.stops, stop.velocity).abs());
                k += 1;
            }
            let mut row = 0;
            while row < rows {
                p[row].write(&mut impulses[row * lanes + first..]);
                row += 1;
            }
            let mut v = 0;
            while v < n {
                qd[v].write(&mut velocities[v * lanes + first..]);
                v += 1;
            }
            let [mut wrong, mut beyond] = [[F::zero(); MAX_LANES]; 2];
            residual.write(&mut wrong);
            stopped.write(&mut beyond);
            let mut lane = 0;
            while lane < L::LANES {
                let is_solved = wrong[lane].all_at_most(ground.tolerance)
                    && beyond[lane].all_at_most(F::zero());
                solved[first + lane] = if is_solved { Some(wrong[lane]) } else { None };
                lane += 1;
            }
            first += L::LANES;
        }
    }
}

/// The memory of a step on plain numbers.
trait NumbersMemory<T>: StepMemory<T> {
    /// Numbers for each velocity, for each row of the contacts.
    type Responses: AsMut<[Self::Velocities]> + AsRef<[Self::Velocities]>;

    /// Returns zeros.
    fn velocities(&self) -> Self::Velocities;
    /// Returns zeros.
    fn responses(&self) -> Self::Responses;
}

/// The memory of a robot with at most as many rows of contacts, velocities, and both together.
struct Arrays<F, const ROWS: usize, const VELOCITIES: usize, const BOTH: usize> {
    inverse: F,
    velocities: usize,
}

impl<T: Decide, F: Fn(&mut [T]), const ROWS: usize, const VELOCITIES: usize, const BOTH: usize>
    StepMemory<T> for Arrays<F, ROWS, VELOCITIES, BOTH>
{
    type ContactRow = [T; ROWS];
    type ContactMatrix = [[T; ROWS]; ROWS];
    type GroundRow = [T; BOTH];
    type GroundMatrix = [[T; BOTH]; BOTH];
    type Velocities = [T; VELOCITIES];
    type Inverse = [[T; VELOCITIES]; VELOCITIES];

    fn contact_row(&self) -> [T; ROWS] {
        [T::zero(); ROWS]
    }

    fn contact_matrix(&self) -> [[T; ROWS]; ROWS] {
        [[T::zero(); ROWS]; ROWS]
    }

    fn ground_row(&self) -> [T; BOTH] {
        [T::zero(); BOTH]
    }

    fn ground_matrix(&self) -> [[T; BOTH]; BOTH] {
        [[T::zero(); BOTH]; BOTH]
    }

    fn inverse(&self) -> [[T; VELOCITIES]; VELOCITIES] {
        let n = self.velocities;
        let mut numbers = vec![T::zero(); n * n];
        (self.inverse)(&mut numbers);
        let mut columns = [[T::zero(); VELOCITIES]; VELOCITIES];
        for (column, own) in columns.iter_mut().zip(numbers.chunks_exact(n.max(1))) {
            column[..n].copy_from_slice(own);
        }
        columns
    }
}

impl<T: Decide, F: Fn(&mut [T]), const ROWS: usize, const VELOCITIES: usize, const BOTH: usize>
    NumbersMemory<T> for Arrays<F, ROWS, VELOCITIES, BOTH>
{
    type Responses = [[T; VELOCITIES]; ROWS];

    fn velocities(&self) -> [T; VELOCITIES] {
        [T::zero(); VELOCITIES]
    }

    fn responses(&self) -> [[T; VELOCITIES]; ROWS] {
        [[T::zero(); VELOCITIES]; ROWS]
    }
}

/// The memory of a robot of any size.
struct Vectors<F> {
    inverse: F,
    contacts: usize,
    velocities: usize,
}

impl<T: Decide, F: Fn(&mut [T])> StepMemory<T> for Vectors<F> {
    type ContactRow = Vec<T>;
    type ContactMatrix = Vec<Vec<T>>;
    type GroundRow = Vec<T>;
    type GroundMatrix = Vec<Vec<T>>;
    type Velocities = Vec<T>;
    type Inverse = Vec<Vec<T>>;

    fn contact_row(&self) -> Vec<T> {
        vec![T::zero(); 3 * self.contacts]
    }

    fn contact_matrix(&self) -> Vec<Vec<T>> {
        vec![self.contact_row(); 3 * self.contacts]
    }

    fn ground_row(&self) -> Vec<T> {
        vec![T::zero(); 3 * self.contacts + self.velocities]
    }

    fn ground_matrix(&self) -> Vec<Vec<T>> {
        let row = self.ground_row();
        vec![row.clone(); row.len()]
    }

    fn inverse(&self) -> Vec<Vec<T>> {
        let n = self.velocities;
        let mut numbers = vec![T::zero(); n * n];
        (self.inverse)(&mut numbers);
        numbers.chunks(n.max(1)).map(<[T]>::to_vec).collect()
    }
}

impl<T: Decide, F: Fn(&mut [T])> NumbersMemory<T> for Vectors<F> {
    type Responses = Vec<Vec<T>>;

    fn velocities(&self) -> Vec<T> {
        vec![T::zero(); self.velocities]
    }

    fn responses(&self) -> Vec<Vec<T>> {
        vec![self.velocities(); 3 * self.contacts]
    }
}
