//! Impulses of a step on the ground: contacts with Coulomb friction, and joint stops.
//!
//! [`contact_problem`](crate::Robot::contact_problem) gives the motion of a step without contacts
//! and the effects of unit impulses. [`solve`](crate::solve) has the laws of the ground and of
//! stops, and finds the impulses. This module chooses the rows of a step. Stops take part only if a
//! joint would pass one, or if one acted in the last step.

use crate::ContactTarget;
use crate::scalar::{epsilon, larger};
use crate::setting_range::{MAX_ITERATIONS, SettingError, SettingPlace, SettingRange};
use crate::solve::{
    Contact, ContactMode, Decide, Effort, GroundEquations, Residual, Row, Stop, add_scaled,
    relative_velocity, soften,
};

pub use crate::solve::velocity_range;

/// The rounds after which all stops take part.
const MAX_ROUNDS: usize = 4;

/// The options of steps on the ground.
///
/// The ground under each contact is the target of the contact in
/// [`ConstraintSettings`](crate::ConstraintSettings): the xy plane of its pose, its velocity,
/// `alpha`, `beta`, `restitution`, `compliance` and `friction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground<T = f64> {
    /// Whether joints stop at the limits of the description. A joint beyond a limit returns at the
    /// rate `beta` of the settings.
    pub joint_limits: bool,
    /// The largest wrong velocity at which the solver ends, m/s and rad/s; above zero.
    pub tolerance: T,
    /// The largest number of sweeps over the contacts, at most 10,000. With stops there is at most
    /// one.
    pub sweeps: usize,
    /// The largest number of Newton steps after the sweeps, at most 10,000.
    pub newton_steps: usize,
}

impl<T: Copy + Into<f64>> Ground<T> {
    /// Checks that the options are within their ranges.
    ///
    /// # Errors
    ///
    /// The first option that is not.
    #[allow(clippy::cast_precision_loss)]
    pub fn check(&self) -> Result<(), SettingError> {
        let place = SettingPlace::Ground;
        let most = SettingRange::AtMost(MAX_ITERATIONS);
        SettingRange::Positive.check("tolerance", place, self.tolerance.into())?;
        most.check("sweeps", place, self.sweeps as f64)?;
        most.check("newton_steps", place, self.newton_steps as f64)
    }
}

impl<T: Decide> Default for Ground<T> {
    /// Returns joint limits, a tolerance of 1e-9 (8e-6 in `f32`), at most 8 sweeps and at most 40
    /// Newton steps.
    fn default() -> Self {
        let tolerance = T::from_f64(1e-9).max(T::from_f64(64.0) * epsilon());
        Self { joint_limits: true, tolerance, sweeps: 8, newton_steps: 40 }
    }
}

/// The motion of a step without contacts and stops, and the effects of impulses: a
/// [`ContactProblem`](crate::ContactProblem) in slices.
#[derive(Clone, Copy, Debug)]
pub struct FreeMotion<'a, T, C, V> {
    /// The time step, s.
    pub dt: T,
    /// The velocities after the step without impulses.
    pub qd: &'a [T],
    /// The height of each contact, m.
    pub heights: &'a [T],
    /// The velocity of each contact relative to its target before the step, in the directions of
    /// its rows, m/s.
    pub before: &'a C,
    /// The same after the step without impulses, m/s.
    pub free: &'a C,
    /// J M^-1 J^T, 1/kg.
    pub mobility: &'a [C],
    /// M^-1 J^T: for each row the change of the velocities by a unit impulse.
    pub responses: &'a [V],
}

/// The impulses of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impulses<C, V> {
    /// For each contact the impulses along its three rows, N s: the x and y axes of its target,
    /// then the normal.
    pub contacts: C,
    /// For each velocity the impulse of its stop, N m s or N s.
    pub stops: V,
}

/// The memory of a step, and the inverse of the mass matrix, which stops need: arrays for generated
/// robots, vectors for a robot that is known at run time.
pub trait StepMemory<T> {
    /// A number for each row of the contacts.
    type ContactRow: Row<T>;
    /// A [`ContactRow`](Self::ContactRow) for each row of the contacts.
    type ContactMatrix: AsMut<[Self::ContactRow]> + AsRef<[Self::ContactRow]>;
    /// A number for each row of the contacts and for each velocity.
    type GroundRow: Row<T>;
    /// A [`GroundRow`](Self::GroundRow) for each of its entries.
    type GroundMatrix: AsMut<[Self::GroundRow]> + AsRef<[Self::GroundRow]>;
    /// A number for each velocity.
    type Velocities: Row<T>;
    /// The inverse of the mass matrix: a column for each velocity.
    type Inverse: AsRef<[Self::Velocities]>;

    /// Returns zeros.
    fn contact_row(&self) -> Self::ContactRow;
    /// Returns zeros.
    fn contact_matrix(&self) -> Self::ContactMatrix;
    /// Returns zeros.
    fn ground_row(&self) -> Self::GroundRow;
    /// Returns zeros.
    fn ground_matrix(&self) -> Self::GroundMatrix;
    /// Returns the inverse of the mass matrix.
    fn inverse(&self) -> Self::Inverse;
}

/// Finds the impulses of a step from those of the last step, which are zero at first, and the
/// velocities after it. Returns what is wrong with them, and the work.
///
/// `contacts` has a contact for each target, whose friction this sets. `stops` has a stop with its
/// range for each velocity; none at all if joints have no stops. `order` is memory with an entry
/// for each velocity.
#[inline(always)]
pub fn solve_step<T: Decide, M: StepMemory<T>>(
    memory: &M,
    motion: &FreeMotion<'_, T, M::ContactRow, M::Velocities>,
    targets: &[ContactTarget<T>],
    ground: &Ground<T>,
    (contacts, stops, order): (&mut [Contact<T>], &mut [Stop<T>], &mut [usize]),
    impulses: &mut Impulses<M::ContactRow, M::Velocities>,
    velocities: &mut [T],
) -> (Residual<T>, Effort) {
    let most = (Effort { sweeps: ground.sweeps, newton: ground.newton_steps }, ground.tolerance);
    let b = velocities_of_contacts(memory, motion, targets, contacts);
    let impulses_of_stops = impulses.stops.as_ref().iter().take(stops.len());
    let held = impulses_of_stops.fold(T::zero(), |most, impulse| larger(most, impulse.abs()));
    let mut found = (Residual { contacts: T::zero(), stops: T::zero() }, Effort::default());
    let stopped = !held.all_at_most(T::zero());
    if !stopped {
        let compliant = targets.iter().any(|target| !target.compliance.all_at_most(T::zero()));
        let mut softened = None;
        if compliant {
            let mut matrix = memory.contact_matrix();
            copy_rows(motion.mobility, matrix.as_mut());
            soften(targets, matrix.as_mut());
            softened = Some(matrix);
        }
        let a = softened.as_ref().map_or(motion.mobility, AsRef::as_ref);
        let mut equations = GroundEquations { a, b: &b, contacts, stops: &mut [] };
        found = equations.solve(&mut impulses.contacts, || memory.contact_matrix(), most);
        velocities.copy_from_slice(motion.qd);
        add_responses(motion.responses, impulses.contacts.as_ref(), velocities);
        let tolerance = ground.tolerance;
        if !stops.iter().zip(&*velocities).any(|(stop, v)| passes(stop, *v, tolerance)) {
            impulses.stops.as_mut().fill(T::zero());
            return found;
        }
    }
    let stopped = stop_joints(
        memory,
        motion,
        (targets, b.as_ref()),
        most,
        (contacts, stops, order),
        impulses,
        velocities,
    );
    (
        stopped.0,
        Effort {
            sweeps: found.1.sweeps + stopped.1.sweeps,
            newton: found.1.newton + stopped.1.newton,
        },
    )
}

/// Returns the velocities of the contacts without impulses, less the least speed along the normal.
/// Sets the friction of the contacts.
#[inline(always)]
fn velocities_of_contacts<T: Decide, M: StepMemory<T>>(
    memory: &M,
    motion: &FreeMotion<'_, T, M::ContactRow, M::Velocities>,
    targets: &[ContactTarget<T>],
    contacts: &mut [Contact<T>],
) -> M::ContactRow {
    let mut b = memory.contact_row();
    let before = motion.before.as_ref();
    let free = motion.free.as_ref();
    for (c, (b, target)) in b.as_mut().chunks_exact_mut(3).zip(targets).enumerate() {
        let [x, y, z] = [0, 1, 2].map(|k| 3 * c + k);
        contacts[c] = Contact::new(target.friction);
        let of = [motion.heights[c], before[z], motion.dt];
        b.copy_from_slice(&relative_velocity([free[x], free[y], free[z]], of, target));
    }
    b
}

/// [`solve_step`] with the stops that acted in the last step and, in rounds, those that joints
/// would pass.
#[inline(never)]
fn stop_joints<T: Decide, M: StepMemory<T>>(
    memory: &M,
    motion: &FreeMotion<'_, T, M::ContactRow, M::Velocities>,
    (targets, of_contacts): (&[ContactTarget<T>], &[T]),
    most: (Effort, T),
    (contacts, stops, order): (&mut [Contact<T>], &mut [Stop<T>], &mut [usize]),
    impulses: &mut Impulses<M::ContactRow, M::Velocities>,
    velocities: &mut [T],
) -> (Residual<T>, Effort) {
    let memory_of_inverse = memory.inverse();
    let inverse = memory_of_inverse.as_ref();
    let rows = 3 * targets.len();
    let mut a = memory.ground_matrix();
    let mut b = memory.ground_row();
    let mut p = memory.ground_row();
    let matrix = a.as_mut();
    copy_rows(motion.mobility, matrix);
    soften(targets, matrix);
    b.as_mut()[..rows].copy_from_slice(&of_contacts[..rows]);
    p.as_mut()[..rows].copy_from_slice(&impulses.contacts.as_ref()[..rows]);
    // The stops that take part are moved to the front of `stops`; `order` has the velocity of each.
    order.iter_mut().enumerate().for_each(|(entry, at)| *at = entry);
    let mut count = 0;
    let mut total = (Residual { contacts: T::zero(), stops: T::zero() }, Effort::default());
    for round in 0..=MAX_ROUNDS {
        let before = count;
        for k in before..stops.len() {
            let entry = order[k];
            let impulse = impulses.stops.as_ref()[entry];
            let takes_part = match round {
                0 => !impulse.abs().all_at_most(T::zero()),
                MAX_ROUNDS => is_limited(&stops[k]),
                _ => passes(&stops[k], velocities[entry], most.1),
            };
            if !takes_part {
                continue;
            }
            order.swap(count, k);
            stops.swap(count, k);
            let row = rows + count;
            for (r, response) in motion.responses.iter().enumerate() {
                let effect = response.as_ref()[entry];
                matrix[r].as_mut()[row] = effect;
                matrix[row].as_mut()[r] = effect;
            }
            for other in 0..=count {
                let effect = inverse[entry].as_ref()[order[other]];
                matrix[rows + other].as_mut()[row] = effect;
                matrix[row].as_mut()[rows + other] = effect;
            }
            b.as_mut()[row] = motion.qd[entry];
            p.as_mut()[row] = impulse;
            count += 1;
        }
        if count == before && round > 0 {
            break;
        }
        let (acting, _) = stops.split_at_mut(count);
        let mut equations = GroundEquations { a: &*matrix, b: &b, contacts, stops: acting };
        let (residual, effort) = equations.solve(&mut p, || memory.ground_matrix(), most);
        total.0 = residual;
        total.1 = Effort {
            sweeps: total.1.sweeps + effort.sweeps,
            newton: total.1.newton + effort.newton,
        };
        velocities.copy_from_slice(motion.qd);
        add_responses(motion.responses, &p.as_ref()[..rows], velocities);
        for (&entry, &impulse) in order[..count].iter().zip(&p.as_ref()[rows..]) {
            add_scaled(velocities, impulse, inverse[entry].as_ref());
        }
    }
    impulses.contacts.as_mut()[..rows].copy_from_slice(&p.as_ref()[..rows]);
    impulses.stops.as_mut().fill(T::zero());
    for (&entry, &impulse) in order[..count].iter().zip(&p.as_ref()[rows..]) {
        impulses.stops.as_mut()[entry] = impulse;
    }
    total
}

/// Returns the state of each contact with these impulses of a step.
#[must_use]
pub fn contact_mode<T: Decide>(friction: T, impulse: [T; 3]) -> ContactMode {
    Contact::new(friction).mode(impulse)
}

/// Returns whether the velocity is outside of the range of a stop.
#[inline]
fn passes<T: Decide>(stop: &Stop<T>, velocity: T, tolerance: T) -> bool {
    let [least, most] = stop.range;
    !(least - tolerance).all_at_most(velocity) || !velocity.all_at_most(most + tolerance)
}

/// Returns whether a stop has a limit.
fn is_limited<T: Decide>(stop: &Stop<T>) -> bool {
    let [least, most] = stop.range;
    let huge = T::from_f64(1e30);
    (-huge).all_at_most(least) || most.all_at_most(huge)
}

/// Copies the entries of rows into rows that may be longer.
fn copy_rows<T: Decide, A: Row<T>, B: Row<T>>(from: &[A], to: &mut [B]) {
    for (from, to) in from.iter().zip(to) {
        let from = from.as_ref();
        to.as_mut()[..from.len()].copy_from_slice(from);
    }
}

/// Adds the responses to these impulses. Most contacts of a robot that moves have none.
#[inline(always)]
fn add_responses<T: Decide, V: Row<T>>(responses: &[V], impulses: &[T], velocities: &mut [T]) {
    for (response, &impulse) in responses.iter().zip(impulses) {
        if !impulse.abs().all_at_most(T::zero()) {
            add_scaled(velocities, impulse, response.as_ref());
        }
    }
}
