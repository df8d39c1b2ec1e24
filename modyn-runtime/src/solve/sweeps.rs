//! Sweeps over contacts and joint stops: each is solved exactly, with the impulses of the others
//! held.
//!
//! The method is that of Jourdan, Alart and Jean 1998, "A Gauss-Seidel like algorithm to solve
//! frictional contact problems". Feet of different legs are coupled weakly, through the trunk: then
//! three sweeps are typical. The points of one sole are coupled strongly, and sweeps converge
//! slowly.

use super::decide::Decide;
use super::ground::{GroundEquations, Row};
use crate::Scalar;
use crate::scalar::larger;

impl<S: Decide, R: Row<S>> GroundEquations<'_, S, R> {
    /// Sweeps until a sweep changes velocities by less than `tolerance`, until it makes little
    /// progress, or `most` times. Returns the number of sweeps and the change of the last one.
    #[inline(always)]
    pub(super) fn sweep(
        &mut self,
        p: &mut [S],
        u: &mut [S],
        (most, tolerance): (usize, S),
    ) -> (usize, S) {
        let mut last = S::zero();
        for sweep in 1..=most {
            let change = self.sweep_once(p, u);
            let slow = sweep > 1 && (last * S::from_f64(0.25)).all_at_most(change);
            if change.all_at_most(tolerance) || slow {
                return (sweep, change);
            }
            last = change;
        }
        (most, last)
    }
}

impl<S: Scalar, R: Row<S>> GroundEquations<'_, S, R> {
    /// Visits each stop and each contact once. Returns the largest change of a velocity.
    #[inline(always)]
    pub(super) fn sweep_once(&mut self, p: &mut [S], u: &mut [S]) -> S {
        let mut change = S::zero();
        let first = 3 * self.contacts.len();
        for (k, stop) in self.stops.iter().enumerate() {
            let row = first + k;
            let step = stop.solve(p[row], u[row]) - p[row];
            if (-step.abs()).is_known_nonnegative() {
                continue;
            }
            change = larger(change, step.abs() * stop.mobility);
            p[row] = p[row] + step;
            for (u, &a) in u.iter_mut().zip(self.a[row].as_ref()) {
                *u = a.mul_add(step, *u);
            }
        }
        for (c, contact) in self.contacts.iter_mut().enumerate() {
            let row = 3 * c;
            let before = [p[row], p[row + 1], p[row + 2]];
            let after = contact.solve(before, [u[row], u[row + 1], u[row + 2]]);
            let step = [after[0] - before[0], after[1] - before[1], after[2] - before[2]];
            let [across, along] = contact.mobilities();
            let moved = larger(step[0].abs(), step[1].abs()) * across;
            let moved = larger(moved, step[2].abs() * along);
            if (-moved).is_known_nonnegative() {
                continue;
            }
            change = larger(change, moved);
            p[row..row + 3].copy_from_slice(&after);
            let [x, y, z] = [0, 1, 2].map(|k| self.a[row + k].as_ref());
            for (u, ((&x, &y), &z)) in u.iter_mut().zip(x.iter().zip(y).zip(z)) {
                *u = z.mul_add(step[2], y.mul_add(step[1], x.mul_add(step[0], *u)));
            }
        }
        change
    }
}
