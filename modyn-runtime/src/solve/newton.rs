//! Damped Newton steps on the equations of all contacts and joint stops.
//!
//! The equations are the natural map of Alart and Curnier 1991, "A mixed formulation for frictional
//! contact problems prone to Newton like solution methods": with the mobilities a_n and a_t of a
//! contact,
//!
//! ```text
//! open    p = 0                      if a_n p_n <= u_n
//! normal  u_n = 0                    else
//! stick   u_t = 0                    if |p_t - u_t / a_t| <= mu (p_n - u_n / a_n)
//! slip    p_t = mu (p_n - u_n / a_n) e  else, with e the direction of p_t - u_t / a_t
//! ```
//!
//! and for a stop u = its limit, or p = 0. A proximal term eps a (p - p_last) on active rows keeps
//! the matrix regular where rows are redundant. It vanishes at the solution. A step that raises the
//! sum of the squared residuals much is taken back: then a few sweeps lead on, and eps grows.

use super::contact::Law;
use super::decide::Decide;
use super::ground::{GroundEquations, Row};
use super::laws::add_scaled;
use crate::scalar::{epsilon, larger};

/// The factor by which a step may raise the merit. The merit rises before it falls where contacts
/// are redundant: with a small factor the steps that lead to the solution are taken back.
const ACCEPTED: f64 = 1e6;
/// The first proximal term.
const START: f64 = 0.01;
/// The least and the largest proximal term after a step that was taken back, and its growth.
const RETRY: f64 = 0.01;
const MAX_EPS: f64 = 10.0;
const GROWTH: f64 = 10.0;
/// The factor of the proximal term after a step that was not.
const DECAY: f64 = 0.3;
/// The sweeps after a step that was taken back.
const SWEEPS: usize = 4;

/// Returns the least proximal term.
pub(super) fn least_eps<S: Decide>() -> S {
    S::from_f64(1e-9).max(S::from_f64(64.0) * epsilon())
}

/// The sum of the squared residuals, each divided by its mobility, and the largest residual, m/s.
pub(super) struct Merit<S> {
    sum: S,
    worst: S,
}

impl<S: Decide> Merit<S> {
    #[inline]
    fn add(&mut self, residuals: &[S], per_mobility: S) {
        for &residual in residuals {
            self.sum = self.sum + residual * residual * per_mobility;
            self.worst = larger(self.worst, residual.abs());
        }
    }
}

/// The memory of the steps.
pub(super) struct Steps<'a, S, R> {
    /// The derivatives of the active rows, and the negative residuals.
    pub matrix: &'a mut [R],
    pub right: R,
    /// For each row, 1 if it is active, else 0.
    pub active: R,
    /// The proximal term.
    pub eps: S,
}

impl<S: Decide, R: Row<S>> GroundEquations<'_, S, R> {
    /// Takes at most `most` steps from the impulses `p`, whose velocities are `u`, until no
    /// residual is above `tolerance`. Leaves the best impulses and their velocities. Returns the
    /// number of steps. The scalar must be a single number.
    #[inline(never)]
    pub(super) fn newton(
        &mut self,
        p: &mut R,
        u: &mut R,
        matrix: &mut [R],
        (most, tolerance): (usize, S),
    ) -> usize {
        let least = least_eps();
        let (right, active) = (p.clone(), p.clone());
        let mut steps = Steps { matrix, right, active, eps: S::from_f64(START).max(least) };
        let (mut last, mut best) = ((p.clone(), u.clone()), (p.clone(), u.clone()));
        // No merit yet.
        let (mut accepted, mut least_worst) = (None, None);
        let mut retried = false;
        let mut taken = 0;
        loop {
            let merit = self.linearize(p.as_ref(), u.as_ref(), &mut steps);
            let better = least_worst.is_none_or(|least: S| !least.all_at_most(merit.worst));
            if better && merit.worst.all_nonnegative() {
                least_worst = Some(merit.worst);
                best = (p.clone(), u.clone());
            }
            if merit.worst.all_at_most(tolerance) || taken == most {
                (*p, *u) = best;
                return taken;
            }
            taken += 1;
            let limit = accepted.map(|merit: S| merit * S::from_f64(ACCEPTED));
            let refused = match limit {
                Some(limit) => !merit.sum.all_at_most(limit),
                // NaN.
                None => !merit.sum.all_nonnegative(),
            };
            if refused {
                (*p, *u) = last.clone();
                accepted = None;
                self.sweep(p.as_mut(), u.as_mut(), (SWEEPS, tolerance));
                last = (p.clone(), u.clone());
                let larger = (steps.eps * S::from_f64(GROWTH)).max(S::from_f64(RETRY));
                let most = S::from_f64(MAX_EPS);
                steps.eps = (larger - most).select_nonnegative(most, larger);
                retried = true;
                continue;
            }
            if !retried {
                steps.eps = (steps.eps * S::from_f64(DECAY)).max(least);
            }
            retried = false;
            accepted = Some(merit.sum);
            last = (p.clone(), u.clone());
            steps.clear(p.as_mut(), self.rows());
            steps.factorize(self.rows());
            let mut step = steps.right.clone();
            steps.substitute(step.as_mut(), self.rows(), 1);
            add_scaled(&mut p.as_mut()[..self.rows()], S::one(), step.as_ref());
            *u = self.velocities(p.as_ref());
        }
    }

    /// Fills in the active rows and their right-hand sides.
    #[inline(always)]
    pub(super) fn linearize(&self, p: &[S], u: &[S], steps: &mut Steps<'_, S, R>) -> Merit<S> {
        let Steps { matrix, right, active, eps } = steps;
        let (right, active, eps) = (right.as_mut(), active.as_mut(), *eps);
        let (zero, one) = (S::zero(), S::one());
        let mut merit = Merit { sum: zero, worst: zero };
        for (c, contact) in self.contacts.iter().enumerate() {
            let (x, y, z) = (3 * c, 3 * c + 1, 3 * c + 2);
            let [across, along] = contact.mobilities();
            let law = contact.law([p[x], p[y], p[z]], [u[x], u[y], u[z]]);
            let open = matches!(law, Law::Open);
            active[x..=z].fill(if open { zero } else { one });
            if open {
                if contact.is_mobile() {
                    merit.add(&[p[x] * along, p[y] * along, p[z] * along], along.recip());
                }
                continue;
            }
            let (per_along, per_across) = (along.recip(), across.recip());
            let own = eps * across;
            merit.add(&[u[z]], per_along);
            if let Law::Slip(slip) = law {
                let [rx, ry, rz] = [x, y, z].map(|row| self.a[row].as_ref());
                for k in 0..2 {
                    let row = x + k;
                    let residual = across * (p[row] - slip.limit * slip.direction[k]);
                    merit.add(&[residual], per_across);
                    let (turn, push) = (slip.turn[k], slip.push[k]);
                    let entries = matrix[row].as_mut();
                    for (entry, ((&x, &y), &z)) in entries.iter_mut().zip(rx.iter().zip(ry).zip(rz))
                    {
                        *entry = turn[0] * x + turn[1] * y + push * z;
                    }
                    entries[x] = entries[x] - across * turn[0];
                    entries[y] = entries[y] - across * turn[1];
                    entries[z] = entries[z] - push * along;
                    entries[row] = entries[row] + across + own;
                    right[row] = -residual;
                }
            } else {
                merit.add(&[u[x], u[y]], per_across);
                for row in [x, y] {
                    matrix[row].clone_from(&self.a[row]);
                    let entries = matrix[row].as_mut();
                    entries[row] = entries[row] + own;
                    right[row] = -u[row];
                }
            }
            matrix[z].clone_from(&self.a[z]);
            let entries = matrix[z].as_mut();
            entries[z] = entries[z] + eps * along;
            right[z] = -u[z];
        }
        for (k, stop) in self.stops.iter().enumerate() {
            let row = 3 * self.contacts.len() + k;
            let missing = stop.missing(p[row], u[row]);
            active[row] = if missing.is_some() { one } else { zero };
            let Some(missing) = missing else {
                merit.add(&[p[row] * stop.mobility], stop.mobility.recip());
                continue;
            };
            merit.add(&[missing], stop.mobility.recip());
            matrix[row].clone_from(&self.a[row]);
            let entries = matrix[row].as_mut();
            entries[row] = entries[row] + eps * stop.mobility;
            right[row] = missing;
        }
        merit
    }
}

impl<S: Decide, R: Row<S>> Steps<'_, S, R> {
    #[inline]
    pub(super) fn is_active(active: &[S], row: usize) -> bool {
        !active[row].all_at_most(S::zero())
    }

    /// Sets the impulses of the rows that are not active to zero. Their effect on the others
    /// becomes a part of the right-hand sides.
    #[inline(always)]
    fn clear(&mut self, p: &mut [S], rows: usize) {
        let Self { matrix, right, active, .. } = self;
        let (right, active) = (right.as_mut(), active.as_ref());
        for other in (0..rows).filter(|&row| !Self::is_active(active, row)) {
            if (-p[other].abs()).all_nonnegative() {
                continue;
            }
            for row in (0..rows).filter(|&row| Self::is_active(active, row)) {
                right[row] = right[row] + matrix[row].as_ref()[other] * p[other];
            }
            p[other] = S::zero();
        }
    }

    /// Replaces the matrix of the active rows by its triangular factors, by Gaussian elimination
    /// without exchanges; the diagonal by its reciprocals.
    #[inline(always)]
    pub(super) fn factorize(&mut self, rows: usize) {
        let (matrix, active) = (&mut *self.matrix, self.active.as_ref());
        for pivot in (0..rows).filter(|&row| Self::is_active(active, row)) {
            let (upper, lower) = matrix[..rows].split_at_mut(pivot + 1);
            let own = &mut upper[pivot].as_mut()[pivot..rows];
            let reciprocal = own[0].recip();
            for (k, row) in lower.iter_mut().enumerate() {
                let below = pivot + 1 + k;
                if !Self::is_active(active, below) {
                    continue;
                }
                let (first, entries) = row.as_mut()[pivot..rows].split_at_mut(1);
                let factor = -(first[0] * reciprocal);
                for (entry, &other) in entries.iter_mut().zip(&own[1..]) {
                    *entry = factor.mul_add(other, *entry);
                }
                first[0] = factor;
            }
            own[0] = reciprocal;
        }
    }

    /// Replaces right-hand sides, `count` of them in each row, by their solutions, by the factors
    /// of `factorize`. Rows that are not active become zero.
    #[inline(always)]
    pub(super) fn substitute(&self, right: &mut [S], rows: usize, count: usize) {
        let (matrix, active) = (&*self.matrix, self.active.as_ref());
        for (row, entries) in matrix.iter().enumerate().take(rows) {
            let (before, own) = right.split_at_mut(row * count);
            let own = &mut own[..count];
            if !Self::is_active(active, row) {
                own.fill(S::zero());
                continue;
            }
            for pivot in (0..row).filter(|&pivot| Self::is_active(active, pivot)) {
                let factor = entries.as_ref()[pivot];
                add_scaled(own, factor, &before[pivot * count..][..count]);
            }
        }
        for row in (0..rows).rev().filter(|&row| Self::is_active(active, row)) {
            let (before, after) = right.split_at_mut((row + 1) * count);
            let own = &mut before[row * count..];
            let entries = matrix[row].as_ref();
            for later in (row + 1..rows).filter(|&later| Self::is_active(active, later)) {
                add_scaled(own, -entries[later], &after[(later - row - 1) * count..][..count]);
            }
            own.iter_mut().for_each(|x| *x = *x * entries[row]);
        }
    }
}
