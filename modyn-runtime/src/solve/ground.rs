//! The impulses of contacts with friction and of joint stops.

use super::contact::Contact;
use super::decide::Decide;
use crate::Scalar;
use crate::scalar::{larger, positive};

/// Numbers with an entry for each row of a problem, or more: an array or a vector.
pub trait Row<S>: Clone + AsRef<[S]> + AsMut<[S]> {}

impl<S, R: Clone + AsRef<[S]> + AsMut<[S]>> Row<S> for R {}

/// A joint stop: one row of the equations, whose velocity stays within a range.
#[derive(Clone, Copy, Debug)]
pub struct Stop<S> {
    /// The lowest and the highest velocity, rad/s or m/s; may be infinite.
    pub range: [S; 2],
    /// The change of the velocity by a unit impulse. [`GroundEquations::solve`] sets it.
    pub(super) mobility: S,
}

impl<S: Scalar> Stop<S> {
    /// Returns a stop with this range of velocities.
    #[inline(always)]
    #[must_use]
    pub fn new(range: [S; 2]) -> Self {
        Self { range, mobility: S::zero() }
    }

    /// Returns the impulse that solves the equation of this stop, whose impulse is `p` and whose
    /// velocity is `u`.
    #[inline(always)]
    pub(super) fn solve(&self, p: S, u: S) -> S {
        let per_unit = self.mobility.recip();
        let [up, down] = self.range.map(|bound| p + (bound - u) * per_unit);
        // At most one of the two is not zero, since the range is not empty.
        positive(up) - positive(-down)
    }

    /// Returns the velocity that contradicts the law of a stop: zero at the solution.
    #[inline(always)]
    pub(super) fn residual(&self, p: S, u: S) -> S {
        (self.solve(p, u) - p).abs() * self.mobility
    }
}

impl<S: Decide> Stop<S> {
    /// Returns the velocity that is missing to the limit which acts; `None` if none acts.
    #[inline(always)]
    pub(super) fn missing(&self, p: S, u: S) -> Option<S> {
        let [up, down] = self.range.map(|bound| self.mobility * p + bound - u);
        let acts = |x: S| !x.all_at_most(S::zero());
        if acts(up) {
            Some(self.range[0] - u)
        } else if acts(-down) {
            Some(self.range[1] - u)
        } else {
            None
        }
    }
}

/// The velocities that are wrong with the impulses of a step: zero if the impulses satisfy the laws
/// of contacts and stops, NaN if a number of the step is NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual<T = f64> {
    /// The largest wrong velocity of a contact, m/s.
    pub contacts: T,
    /// The largest wrong velocity of a joint at a stop, rad/s or m/s.
    pub stops: T,
}

impl<T: Scalar> Residual<T> {
    /// Returns the larger velocities of two steps; NaN if one is NaN.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            contacts: larger(self.contacts, other.contacts),
            stops: larger(self.stops, other.stops),
        }
    }
}

/// Numbers of iterations of the solver: the largest allowed ones, or those of a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// The number of sweeps.
    pub sweeps: usize,
    /// The number of Newton steps.
    pub newton: usize,
}

/// The equations u = A p + b of impulses p and velocities u: three rows for each contact (two
/// directions in the plane, then the normal), then one for each stop.
///
/// A contact does not pull, and does not approach the ground: p_n >= 0, u_n >= 0, p_n u_n = 0. Its
/// friction is at most `friction` times p_n, and has this length against the velocity if it slips.
/// A stop pushes its velocity into its range.
#[derive(Debug)]
pub struct GroundEquations<'a, S, R> {
    /// The symmetric matrix A by rows, which may have further entries.
    pub a: &'a [R],
    /// The velocities without impulses. The least speed of a contact along its normal is
    /// subtracted.
    pub b: &'a R,
    /// The contacts.
    pub contacts: &'a mut [Contact<S>],
    /// The stops.
    pub stops: &'a mut [Stop<S>],
}

impl<S: Scalar, R: Row<S>> GroundEquations<'_, S, R> {
    /// Returns the number of rows.
    #[inline(always)]
    #[must_use]
    pub fn rows(&self) -> usize {
        3 * self.contacts.len() + self.stops.len()
    }

    /// Returns the velocities of these impulses.
    #[inline(always)]
    pub(super) fn velocities(&self, p: &[S]) -> R {
        let mut velocities = self.b.clone();
        let u = velocities.as_mut();
        for (&p, row) in p[..self.rows()].iter().zip(self.a) {
            for (u, &a) in u.iter_mut().zip(row.as_ref()) {
                *u = a.mul_add(p, *u);
            }
        }
        velocities
    }

    /// Sets the blocks of contacts and the mobilities of stops.
    #[inline(always)]
    pub(super) fn prepare(&mut self) {
        let a = self.a;
        for (c, contact) in self.contacts.iter_mut().enumerate() {
            let [x, y, z] = [3 * c, 3 * c + 1, 3 * c + 2];
            let [rx, ry, rz] = [a[x].as_ref(), a[y].as_ref(), a[z].as_ref()];
            contact.set_block([rx[x], rx[y], rx[z], ry[y], ry[z], rz[z]]);
        }
        let first = 3 * self.contacts.len();
        for (k, stop) in self.stops.iter_mut().enumerate() {
            stop.mobility = a[first + k].as_ref()[first + k];
        }
    }

    /// Sweeps this many times over all contacts from the impulses `p` on. Returns the largest
    /// velocity that is wrong at contacts.
    #[cfg(feature = "alloc")]
    pub(crate) fn sweep_times(&mut self, p: &mut [S], times: usize) -> S {
        self.prepare();
        let mut velocities = self.velocities(p);
        let u = velocities.as_mut();
        for _ in 0..times {
            self.sweep_once(p, u);
        }
        self.finish(p, u).contacts
    }

    /// Returns what is wrong with the impulses `p`, whose velocities are `u`. If this is NaN, the
    /// impulses become NaN: a motion must not go on without them.
    #[inline(always)]
    pub(super) fn finish(&self, p: &mut [S], u: &[S]) -> Residual<S> {
        let residual = self.residual(p, u);
        let wrong = residual.contacts + residual.stops;
        for p in &mut p[..self.rows()] {
            *p = wrong.select_nonnegative(*p, wrong);
        }
        residual
    }

    /// Returns what is wrong with the impulses `p`, whose velocities are `u`.
    #[inline(always)]
    fn residual(&self, p: &[S], u: &[S]) -> Residual<S> {
        // No closures: they would not be compiled for the instructions of lanes.
        let mut worst = Residual { contacts: S::zero(), stops: S::zero() };
        for (c, contact) in self.contacts.iter().enumerate() {
            let [x, y, z] = [3 * c, 3 * c + 1, 3 * c + 2];
            let residual = contact.residual([p[x], p[y], p[z]], [u[x], u[y], u[z]]);
            worst.contacts = larger(worst.contacts, residual);
        }
        let first = 3 * self.contacts.len();
        for (k, stop) in self.stops.iter().enumerate() {
            worst.stops = larger(worst.stops, stop.residual(p[first + k], u[first + k]));
        }
        // Zero, unless an impulse is no finite number.
        let mut sound = S::zero();
        for &p in &p[..self.rows()] {
            sound = sound + p * S::zero();
        }
        Residual { contacts: worst.contacts + sound, stops: worst.stops + sound }
    }
}

impl<S: Decide, R: Row<S>> GroundEquations<'_, S, R> {
    /// Solves the equations from the impulses `p` on, in sweeps and, where these do not suffice, by
    /// Newton steps. `matrix` returns memory with as many rows as `a`. Returns what is still wrong,
    /// m/s and rad/s, and the work.
    ///
    /// There are at most `most.sweeps` sweeps, with stops at most one, since stops are coupled
    /// strongly. Neither method allocates. The scalar must be a single number.
    #[inline(always)]
    pub fn solve<M: AsMut<[R]>>(
        &mut self,
        p: &mut R,
        matrix: impl FnOnce() -> M,
        (most, tolerance): (Effort, S),
    ) -> (Residual<S>, Effort) {
        self.prepare();
        let mut u = self.velocities(p.as_ref());
        let sweeps = if self.stops.is_empty() { most.sweeps } else { most.sweeps.min(1) };
        let (sweeps, change) = self.sweep(p.as_mut(), u.as_mut(), (sweeps, tolerance));
        let mut newton = 0;
        // Nothing leads on from NaN.
        if !change.all_at_most(tolerance) && change.all_nonnegative() && most.newton > 0 {
            newton = self.newton(p, &mut u, matrix().as_mut(), (most.newton, tolerance));
        }
        (self.finish(p.as_mut(), u.as_ref()), Effort { sweeps, newton })
    }

    /// Sweeps from the impulses `p` on, in lanes: without stops and without Newton steps. Returns
    /// the velocities that are wrong at contacts in each lane.
    #[cfg(feature = "alloc")]
    #[inline(always)]
    pub(crate) fn sweep_lanes(&mut self, p: &mut R, (most, tolerance): (usize, S)) -> S {
        self.prepare();
        let mut u = self.velocities(p.as_ref());
        self.sweep(p.as_mut(), u.as_mut(), (most, tolerance));
        self.finish(p.as_mut(), u.as_ref()).contacts
    }
}
