//! The joint forces of damping and friction.

use super::{Dof, Mechanism};
use crate::Scalar;

impl<S: Scalar> Mechanism<S> {
    /// Returns the force of damping and friction at `dof`, at the rates `qd`; `None` if neither
    /// acts.
    #[must_use]
    pub fn dissipation(&self, dof: &Dof<S>, qd: &[S]) -> Option<S> {
        let rate = dof.rate(qd);
        let viscous = dof.damping.map(|damping| damping * rate);
        let dry = dof.friction.map(|friction| match self.smooth {
            Some(w) => friction * (rate / (rate * rate + w * w).sqrt()),
            None => {
                let backwards = (-rate).select_nonnegative(S::zero(), friction);
                rate.select_nonnegative(backwards, -friction)
            }
        });
        match (viscous, dry) {
            (Some(viscous), Some(dry)) => Some(viscous + dry),
            (viscous, dry) => viscous.or(dry),
        }
    }

    /// Returns the derivative of [`dissipation`](Self::dissipation) with respect to the degree of
    /// freedom's rate. The derivative of Coulomb friction is 0, also at its jump.
    #[must_use]
    pub fn dissipation_slope(&self, dof: &Dof<S>, qd: &[S]) -> Option<S> {
        let smooth = dof.friction.zip(self.smooth).map(|(friction, w)| {
            let rate = dof.rate(qd);
            let square = w * w;
            let steep = (rate * rate + square).sqrt().recip();
            friction * square * (steep * steep * steep)
        });
        match (dof.damping, smooth) {
            (Some(damping), Some(smooth)) => Some(damping + smooth),
            (damping, smooth) => damping.or(smooth),
        }
    }
}
