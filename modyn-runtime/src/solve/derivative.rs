//! Derivatives of the impulses that solve the equations.
//!
//! The impulses p satisfy r(p, u) = 0 with u = A p + b, where r are the equations of `newton`. A
//! change of A, b and the friction mu changes them by dp:
//!
//! ```text
//! J dp = -(r_u (dA p + db) + r_mu dmu),  J = r_p + r_u A
//! ```
//!
//! Where a contact changes from one law to another, p has a derivative on each side. The one of the
//! law that holds with the numbers of p is taken. The proximal term of `newton` stays in J, so
//! redundant rows share a change.

use super::contact::Law;
use super::decide::Decide;
use super::ground::{GroundEquations, Row};
use super::newton::{Steps, least_eps};

impl<S: Decide, R: Row<S>> GroundEquations<'_, S, R> {
    /// Replaces the changes dA p + db of the velocities along several directions by the changes of
    /// the impulses `p`, which solve the equations. `changes` has a row for each row of the
    /// equations, and `friction`, the changes of the friction, one for each contact: with an entry
    /// for each direction. `matrix` is memory with as many rows as `a`.
    pub fn change(&mut self, p: &R, (changes, friction): (&mut [S], &[S]), matrix: &mut [R]) {
        let rows = self.rows();
        let directions = changes.len() / rows.max(1);
        changes.iter_mut().for_each(|change| *change = -*change);
        let (mut steps, u) = self.linear(p, matrix);
        steps.factorize(rows);
        for (c, contact) in self.contacts.iter().enumerate() {
            if let Law::Slip(slip) = contact.law(three(p, c), three(&u, c)) {
                let pressed = contact.mobilities()[0] * slip.pressed;
                let own = &mut changes[3 * c * directions..];
                let (x, rest) = own.split_at_mut(directions);
                let (y, z) = rest.split_at_mut(directions);
                let friction = &friction[c * directions..];
                for (((x, y), &z), &mu) in x.iter_mut().zip(y).zip(&*z).zip(friction) {
                    let of = |k: usize| {
                        let turned = slip.turn[k][0] * *x + slip.turn[k][1] * *y;
                        turned + slip.push[k] * z + slip.direction[k] * (pressed * mu)
                    };
                    (*x, *y) = (of(0), of(1));
                }
            }
        }
        steps.substitute(changes, rows, directions);
    }

    /// Returns the gradient of the sum of the impulses `p`, which solve the equations, times
    /// `weights`: with respect to b, and in `friction` with respect to the friction of each
    /// contact. That with respect to A is the gradient by b times p^T. `matrix` is memory with as
    /// many rows as `a`.
    #[must_use]
    pub fn gradient(&mut self, p: &R, weights: &R, friction: &mut [S], matrix: &mut [R]) -> R {
        let (mut steps, u) = self.linear(p, matrix);
        let rows = self.rows();
        let active = steps.active.as_ref();
        for row in (0..rows).filter(|&row| Steps::<S, R>::is_active(active, row)) {
            let (upper, lower) = steps.matrix.split_at_mut(row);
            let own = lower[0].as_mut();
            for (column, other) in upper.iter_mut().enumerate() {
                if Steps::<S, R>::is_active(active, column) {
                    core::mem::swap(&mut own[column], &mut other.as_mut()[row]);
                }
            }
        }
        steps.factorize(rows);
        let mut multipliers = weights.clone();
        steps.substitute(multipliers.as_mut(), rows, 1);
        let l = multipliers.as_ref();
        let mut gradient = zeros(p);
        let by_b = gradient.as_mut();
        for row in 0..rows {
            by_b[row] = -l[row];
        }
        for (c, contact) in self.contacts.iter().enumerate() {
            let (x, y, z) = (3 * c, 3 * c + 1, 3 * c + 2);
            friction[c] = S::zero();
            if let Law::Slip(slip) = contact.law(three(p, c), three(&u, c)) {
                let along = |row: [S; 2]| row[0] * l[x] + row[1] * l[y];
                let across = contact.mobilities()[0];
                friction[c] = across * slip.pressed * along(slip.direction);
                // `turn` is symmetric.
                (by_b[x], by_b[y]) = (-along(slip.turn[0]), -along(slip.turn[1]));
                by_b[z] = by_b[z] - along(slip.push);
            }
        }
        gradient
    }

    /// Returns J for the active rows, and the velocities of the impulses.
    fn linear<'m>(&mut self, p: &R, matrix: &'m mut [R]) -> (Steps<'m, S, R>, R) {
        self.prepare();
        let u = self.velocities(p.as_ref());
        let (right, active) = (zeros(p), zeros(p));
        let mut steps = Steps { matrix, right, active, eps: least_eps() };
        self.linearize(p.as_ref(), u.as_ref(), &mut steps);
        (steps, u)
    }
}

/// Returns as many zeros.
fn zeros<S: Decide, R: Row<S>>(like: &R) -> R {
    let mut zeros = like.clone();
    zeros.as_mut().fill(S::zero());
    zeros
}

/// Returns the three numbers of a contact.
fn three<S: Copy, R: AsRef<[S]>>(numbers: &R, contact: usize) -> [S; 3] {
    let numbers = numbers.as_ref();
    [0, 1, 2].map(|k| numbers[3 * contact + k])
}
