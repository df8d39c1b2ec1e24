//! Limits and dry friction of joints and tendons.

use crate::model::Softness;

/// The parameters of the limits and of the dry friction of a joint's coordinate or of a tendon's
/// length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopParameters<S> {
    /// The least and the largest coordinate or length, rad or m.
    pub range: [Option<S>; 2],
    /// Whether both limits can act at once, since the range is narrower than twice the margin.
    pub narrow: bool,
    /// The distance from which on a limit acts, rad or m.
    pub margin: S,
    /// The mobility, 1/(kg m^2) or 1/kg: MuJoCo's `dof_invweight0` or `tendon_invweight0`.
    pub mobility: S,
    /// The softness of the limits.
    pub limit: Softness<S>,
    /// The dry friction, N m or N; `None` without friction.
    pub dry_friction: Option<S>,
    /// The softness of dry friction.
    pub friction: Softness<S>,
}

impl<S: Copy> StopParameters<S> {
    /// Returns the parameters with `f` applied to their numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> StopParameters<T> {
        StopParameters {
            range: self.range.map(|end| end.map(f)),
            narrow: self.narrow,
            margin: f(self.margin),
            mobility: f(self.mobility),
            limit: self.limit.map(f),
            dry_friction: self.dry_friction.map(f),
            friction: self.friction.map(f),
        }
    }

    /// Returns the softness of each kind of row.
    pub(super) fn softness(&self) -> impl Iterator<Item = Softness<S>> {
        let has_limits = self.range.iter().any(Option::is_some);
        let limit = has_limits.then_some(self.limit);
        limit.into_iter().chain(self.dry_friction.map(|_| self.friction))
    }
}
