//! One contact with Coulomb friction.
//!
//! The velocity of the contact is u = B p + c, with its impulse p, its 3 x 3 mobility B and the
//! velocity c by all other impulses. The third direction is the normal n. With b = B_tn, S = B_tt -
//! b b^T / B_nn and s = c_t - b c_n / B_nn the solution is
//!
//! ```text
//! open    p = 0                                            if c_n >= 0
//! stick   S p_t = -s,        p_n = -(c_n + b . p_t) / B_nn   if |p_t| <= mu p_n
//! slip    (S + k) p_t = -s,  p_n as before, with the slip k > 0 at which |p_t| = mu p_n: then u_t = -k p_t
//! ```
//!
//! A slip exists whenever c_n < 0: mu p_n - |p_t| is negative at k = 0, and positive for large k.
//! mu p_n / |p_t| - 1 is nearly linear in k, as in trust regions, so Newton's method on k takes few
//! steps. The slip of the last visit is the first guess.
//!
//! These functions have no closures: those would not be compiled for the instructions of lanes.
//!
//! A direction in which the robot cannot move, such as that out of the plane of a planar robot,
//! makes S singular. So each visit adds a small multiple of the change of p_t to u_t, which is zero
//! at the solution.

use super::decide::Decide;
use crate::Scalar;
use crate::scalar::{epsilon, larger, positive};

/// The Newton steps on the slip in one visit.
const SLIP_STEPS: usize = 2;

/// The state of a contact after a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ContactMode {
    /// The ground does not push.
    #[default]
    Open,
    /// The contact does not move within the plane.
    Stick,
    /// The contact moves within the plane.
    Slip,
}

/// The law that a contact has to satisfy, by the natural map of `newton`.
pub(super) enum Law<S> {
    /// No impulse.
    Open,
    /// No velocity.
    Stick,
    /// No velocity along the normal, and friction against the slip.
    Slip(Slip<S>),
}

/// The friction of a contact that slips: a_t (p_t - mu (p_n - u_n / a_n) e) = 0, with e the
/// direction of p_t - u_t / a_t.
pub(super) struct Slip<S> {
    /// e.
    pub direction: [S; 2],
    /// p_n - u_n / a_n.
    pub pressed: S,
    /// The largest friction: mu times this.
    pub limit: S,
    /// The derivative of the two equations with respect to u_t, by rows; with respect to p_t it is
    /// a_t times one minus this.
    pub turn: [[S; 2]; 2],
    /// The derivative with respect to u_n; with respect to p_n it is -a_n times this.
    pub push: [S; 2],
}

/// A contact with friction: three rows of the equations.
#[derive(Clone, Copy, Debug)]
pub struct Contact<S> {
    /// The coefficient of friction, not negative.
    pub friction: S,
    /// B by rows: xx, xy, xz, yy, yz, zz.
    block: [S; 6],
    /// 1 / B_nn; zero if the robot cannot move along the normal.
    normal: S,
    /// S with the addition that keeps it regular: xx, xy, yy; then 1 / its determinant.
    tangential: [S; 4],
    /// The addition to S.
    proximal: S,
    /// The mean mobility within the plane, and its reciprocal.
    scale: [S; 2],
    /// The slip k of the last visit; zero if it did not slip.
    slip: S,
}

impl<S: Scalar> Contact<S> {
    /// Returns a contact with this coefficient of friction.
    #[inline(always)]
    #[must_use]
    pub fn new(friction: S) -> Self {
        let zero = S::zero();
        Self {
            friction,
            block: [zero; 6],
            normal: zero,
            tangential: [zero; 4],
            proximal: zero,
            scale: [zero; 2],
            slip: zero,
        }
    }

    /// Sets the mobility: xx, xy, xz, yy, yz, zz.
    #[inline(always)]
    pub(super) fn set_block(&mut self, block: [S; 6]) {
        let [xx, xy, xz, yy, yz, zz] = block;
        let least = floor::<S>();
        let immobile = least * (xx + yy + zz) - zz;
        let one = S::one();
        let normal =
            immobile.select_nonnegative(S::zero(), immobile.select_nonnegative(one, zz).recip());
        let (bx, by) = (xz * normal, yz * normal);
        // Never zero: a contact that cannot move at all has the mobility 1.
        let mean = (xx + yy) * S::from_f64(0.5);
        let still = least * zz - mean;
        let mean = still.select_nonnegative((-zz).select_nonnegative(one, zz), mean);
        let proximal = least * mean;
        let (sxx, sxy, syy) = (xx - xz * bx + proximal, xy - xz * by, yy - yz * by + proximal);
        // At least that of the addition, where rounding would leave less.
        let determinant = (sxx * syy - sxy * sxy).max(proximal * proximal);
        self.block = block;
        self.normal = normal;
        self.tangential = [sxx, sxy, syy, determinant.recip()];
        self.proximal = proximal;
        self.scale = [mean, mean.recip()];
        self.slip = S::zero();
    }

    /// Returns the mean mobility within the plane and the mobility along the normal, 1/kg.
    #[inline(always)]
    pub(super) fn mobilities(&self) -> [S; 2] {
        [self.scale[0], self.block[5]]
    }

    /// Returns the impulse that solves the equations of this contact, whose impulse is `p` and
    /// whose velocity is `u`.
    #[inline(always)]
    pub(super) fn solve(&mut self, p: [S; 3], u: [S; 3]) -> [S; 3] {
        let [xx, xy, xz, yy, yz, zz] = self.block;
        let zero = S::zero();
        let cn = u[2] - xz * p[0] - yz * p[1] - zz * p[2];
        // Open, or without effect along the normal.
        let pushed = (-self.normal).select_nonnegative(zero, (-cn).max(zero));
        let open = -pushed;
        if open.is_known_nonnegative() {
            self.slip = zero;
            return [zero; 3];
        }
        let cx = u[0] - (xx + self.proximal) * p[0] - xy * p[1] - xz * p[2];
        let cy = u[1] - xy * p[0] - (yy + self.proximal) * p[1] - yz * p[2];
        let [sxx, sxy, syy, inverse] = self.tangential;
        let alone = pushed * self.normal;
        let (sx, sy) = (cx + xz * alone, cy + yz * alone);
        let (px, py) = ((sxy * sy - syy * sx) * inverse, (sxy * sx - sxx * sy) * inverse);
        let pn = self.pressed(alone, [px, py]);
        let limit = self.friction * pn;
        // Negative if it slips.
        let sticks = pn.select_nonnegative(limit * limit - (px * px + py * py), pn);
        let stuck = [px, py, pn];
        let mut found = stuck;
        if sticks.is_known_nonnegative() {
            self.slip = zero;
        } else {
            let slid = self.slide([sx, sy], alone);
            self.slip = sticks.select_nonnegative(zero, self.slip);
            self.slip = open.select_nonnegative(zero, self.slip);
            found = [
                sticks.select_nonnegative(stuck[0], slid[0]),
                sticks.select_nonnegative(stuck[1], slid[1]),
                sticks.select_nonnegative(stuck[2], slid[2]),
            ];
        }
        [
            open.select_nonnegative(zero, found[0]),
            open.select_nonnegative(zero, found[1]),
            open.select_nonnegative(zero, found[2]),
        ]
    }

    /// Returns p_n of p_t.
    #[inline(always)]
    fn pressed(&self, alone: S, [px, py]: [S; 2]) -> S {
        alone - (self.block[2] * px + self.block[4] * py) * self.normal
    }

    /// Returns p_t = -(S + k)^-1 s with the slip k, and -(S + k)^-1 p_t, its derivative by k.
    #[inline(always)]
    fn tangential_impulse(&self, k: S, [sx, sy]: [S; 2]) -> [[S; 2]; 2] {
        let [sxx, sxy, syy, _] = self.tangential;
        let (a, b) = (sxx + k, syy + k);
        let inverse = (a * b - sxy * sxy).recip();
        let (px, py) = ((sxy * sy - b * sx) * inverse, (sxy * sx - a * sy) * inverse);
        let (dx, dy) = ((sxy * py - b * px) * inverse, (sxy * px - a * py) * inverse);
        [[px, py], [dx, dy]]
    }

    /// Returns the impulse of a contact that slips, and stores its slip. `s` and `alone` are s and
    /// -c_n / B_nn.
    #[inline(always)]
    fn slide(&mut self, [sx, sy]: [S; 2], alone: S) -> [S; 3] {
        let [_, _, xz, _, yz, zz] = self.block;
        let [sxx, _, syy, _] = self.tangential;
        let one = S::one();
        // Without friction the slip is infinite; its direction is that of little friction.
        let friction = self.friction.max(S::from_f64(1e-6));
        // The first guess is that of an isotropic block.
        let least = S::from_f64(1e-3) * (sxx + syy);
        let length = (sx * sx + sy * sy).sqrt();
        let guess = length * (friction * alone).recip() - S::from_f64(0.5) * (sxx + syy);
        let mut k = (-self.slip).select_nonnegative(guess.max(least), self.slip);
        for _ in 0..SLIP_STEPS {
            // d p_t / dk = -(S + k)^-1 p_t.
            let [[px, py], [dx, dy]] = self.tangential_impulse(k, [sx, sy]);
            let (pn, dn) = (self.pressed(alone, [px, py]), -(xz * dx + yz * dy) * self.normal);
            let square = px * px + py * py;
            // f = mu p_n - |p_t|, and its derivative of mu p_n / |p_t| - 1 times |p_t|.
            let f = friction * pn - square.sqrt();
            let rate = friction * (dn - pn * (px * dx + py * dy) / square);
            let next = k - f / rate;
            // A step that leads nowhere is one towards more slip.
            let forward = (-rate).select_nonnegative(k + k, next);
            k = forward.max(k * S::from_f64(0.1));
        }
        self.slip = k;
        let [[px, py], _] = self.tangential_impulse(k, [sx, sy]);
        // Exactly on the cone, and exactly at rest along the normal.
        let per_length =
            (px * px + py * py).max(S::from_f64(f64::from(f32::MIN_POSITIVE))).sqrt().recip();
        let (ex, ey) = (px * per_length, py * per_length);
        let divisor = zz + self.friction * (xz * ex + yz * ey);
        let wedged = S::from_f64(1e-3) * zz - divisor;
        let exact = alone * zz * wedged.select_nonnegative(one, divisor).recip();
        let pn = wedged.select_nonnegative(self.pressed(alone, [px, py]).max(S::zero()), exact);
        let limit = self.friction * pn;
        [limit * ex, limit * ey, pn]
    }

    /// Returns the velocity of the contact with impulse `p` and velocity `u` that contradicts the
    /// laws of contacts, m/s: zero at a solution, NaN if a number is NaN.
    #[inline(always)]
    pub(super) fn residual(&self, p: [S; 3], u: [S; 3]) -> S {
        let [mean, per_mean] = self.scale;
        let along = p[2] - positive(p[2] - u[2] * self.normal);
        let wanted = [p[0] - u[0] * per_mean, p[1] - u[1] * per_mean];
        let length = norm(wanted);
        let limit = self.friction * positive(p[2]);
        // At length zero the first choice applies, so nothing is divided by zero.
        let inside = limit - length;
        let part = inside
            .select_nonnegative(S::one(), limit / inside.select_nonnegative(S::one(), length));
        let across = norm([p[0] - part * wanted[0], p[1] - part * wanted[1]]) * mean;
        let worst = larger(along.abs() * self.block[5], across);
        (-self.normal).select_nonnegative(S::zero(), worst)
    }
}

impl<S: Decide> Contact<S> {
    /// Returns whether the robot can move along the normal. Else the contact takes no part.
    #[inline(always)]
    pub(super) fn is_mobile(&self) -> bool {
        !self.normal.all_at_most(S::zero())
    }

    /// Returns the law that a contact with impulse `p` and velocity `u` has to satisfy.
    #[inline(always)]
    pub(super) fn law(&self, p: [S; 3], u: [S; 3]) -> Law<S> {
        let [across, along] = self.mobilities();
        let scaled = along * p[2] - u[2];
        if scaled.all_at_most(S::zero()) || !self.is_mobile() {
            return Law::Open;
        }
        let (per_along, per_across) = (along.recip(), across.recip());
        let pressed = scaled * per_along;
        let limit = self.friction * pressed;
        let (x, y) = (p[0] - u[0] * per_across, p[1] - u[1] * per_across);
        let square = x * x + y * y;
        if square.all_at_most(limit * limit) {
            return Law::Stick;
        }
        let per_length = square.sqrt().recip();
        let direction = [x * per_length, y * per_length];
        let (part, normal) = (limit * per_length, across * self.friction * per_along);
        // The change of the direction by that of its argument.
        let turn = [0, 1].map(|k: usize| {
            [0, 1].map(|l| {
                let unit = if k == l { S::one() } else { S::zero() };
                part * (unit - direction[k] * direction[l])
            })
        });
        let push = direction.map(|e| normal * e);
        Law::Slip(Slip { direction, pressed, limit, turn, push })
    }

    /// Returns the state of a contact with impulse `p`.
    #[inline(always)]
    #[must_use]
    pub fn mode(&self, p: [S; 3]) -> ContactMode {
        let limit = self.friction * p[2] * S::from_f64(1.0 - 1e-6);
        if p[2].all_at_most(S::zero()) {
            ContactMode::Open
        } else if !norm([p[0], p[1]]).all_at_most(limit) || limit.all_at_most(S::zero()) {
            ContactMode::Slip
        } else {
            ContactMode::Stick
        }
    }
}

#[inline(always)]
fn norm<S: Scalar>([x, y]: [S; 2]) -> S {
    (x * x + y * y).sqrt()
}

/// Returns the part of a mobility that counts as none.
#[inline(always)]
fn floor<S: Scalar>() -> S {
    S::from_f64(1e-10).max(S::from_f64(16.0) * epsilon())
}
