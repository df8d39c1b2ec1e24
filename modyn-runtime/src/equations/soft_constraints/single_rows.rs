//! Constraint rows along joint coordinates at a state: limits and dry friction of joints and tendons,
//! and couplings.

use alloc::{vec, vec::Vec};

use super::law::RowState;
use super::lengths::{CouplingParameters, LengthState, RowEntry};
use super::rows::SoftModel;
use super::stops::StopParameters;
use crate::Scalar;
use crate::equations::TimeStepInput;
use crate::scalar::{at_least, at_most};

/// A row along joint coordinates at a state.
#[derive(Clone, Debug)]
pub(super) struct SingleRow<S> {
    /// The entries of qd, each with its factor. A row with several entries couples limbs.
    pub entries: Vec<RowEntry<S>>,
    /// The sign of the row: -1 for an upper limit, else 1.
    sign: S,
    weight: S,
    reference: S,
    kind: RowKind<S>,
}

/// The directions and sizes of a row's force.
#[derive(Clone, Copy, Debug)]
enum RowKind<S> {
    /// A limit only pushes.
    Limit,
    /// Dry friction has a largest force.
    Friction(S),
    /// A coupling pushes and pulls.
    Coupling,
}

/// Returns the rows of joints with one degree of freedom, of tendons and of couplings.
pub(super) fn single_rows<S: Scalar>(
    soft: &SoftModel<S>,
    input: TimeStepInput<'_, S>,
) -> Vec<SingleRow<S>> {
    let mut rows = Vec::new();
    for (dof, parameters) in soft.joints.iter().enumerate() {
        let Some(parameters) = parameters else { continue };
        let joint = LengthState {
            length: input.q[parameters.coordinate],
            rate: input.qd[dof],
            entries: vec![RowEntry { dof, factor: S::one() }],
        };
        stop_rows(&joint, &parameters.stops, input.dt, &mut rows);
    }
    for tendon in &soft.tendons {
        stop_rows(&tendon.length.at(input), &tendon.stops, input.dt, &mut rows);
    }
    rows.extend(soft.couplings.iter().map(|coupling| coupling_row(coupling, input)));
    rows
}

/// Adds the rows of limits, then the row of dry friction.
fn stop_rows<S: Scalar>(
    state: &LengthState<S>,
    parameters: &StopParameters<S>,
    dt: S,
    rows: &mut Vec<SingleRow<S>>,
) {
    let StopParameters { range: [low, high], margin, mobility, .. } = *parameters;
    let velocity = state.rate;
    let one = S::one();
    let [below, above] = [low.map(|low| state.length - low), high.map(|high| high - state.length)];
    let stops = match (below, above) {
        (Some(below), Some(above)) if !parameters.narrow => {
            let lower_is_nearer = above - below;
            let sign = lower_is_nearer.select_nonnegative(one, -one);
            [Some((sign, lower_is_nearer.select_nonnegative(below, above))), None]
        }
        _ => [below.map(|below| (one, below)), above.map(|above| (-one, above))],
    };
    for (sign, distance) in stops.into_iter().flatten() {
        let position = distance - margin;
        let state_of_row = RowState { position, velocity: sign * velocity, mobility };
        let row = parameters.limit.row(&state_of_row, dt);
        rows.push(SingleRow {
            entries: state.entries.clone(),
            sign,
            weight: position.select_nonnegative(S::zero(), row.weight),
            reference: position.select_nonnegative(S::zero(), row.reference),
            kind: RowKind::Limit,
        });
    }
    if let Some(most) = parameters.dry_friction {
        let state_of_row = RowState { position: S::zero(), velocity, mobility };
        let row = parameters.friction.row(&state_of_row, dt);
        rows.push(SingleRow {
            entries: state.entries.clone(),
            sign: S::one(),
            weight: row.weight,
            reference: parameters.friction.damped(velocity, dt),
            kind: RowKind::Friction(most),
        });
    }
}

/// Returns the force of the limits and of the dry friction of a joint along its coordinate, at this
/// coordinate, velocity and acceleration.
pub(super) fn stop_force<S: Scalar>(
    parameters: &StopParameters<S>,
    [length, rate, acceleration]: [S; 3],
    dt: S,
) -> S {
    let joint = LengthState { length, rate, entries: vec![RowEntry { dof: 0, factor: S::one() }] };
    let mut rows = Vec::new();
    stop_rows(&joint, parameters, dt, &mut rows);
    let mut force = [S::zero()];
    for row in rows {
        let [along_row, _] = row.response(row.acceleration(&[acceleration]));
        row.add_force(along_row, &mut force);
    }
    force[0]
}

/// Returns the row of a coupling.
fn coupling_row<S: Scalar>(
    coupling: &CouplingParameters<S>,
    input: TimeStepInput<'_, S>,
) -> SingleRow<S> {
    let state = coupling.at(input);
    let state_of_row =
        RowState { position: state.length, velocity: state.rate, mobility: coupling.mobility };
    let row = coupling.softness.row(&state_of_row, input.dt);
    SingleRow {
        entries: state.entries,
        sign: S::one(),
        weight: row.weight,
        reference: row.reference,
        kind: RowKind::Coupling,
    }
}

impl<S: Scalar> SingleRow<S> {
    /// Returns the weight of a limit; zero for other rows.
    pub fn weight_of_limit(&self) -> S {
        match self.kind {
            RowKind::Limit => self.weight,
            RowKind::Friction(_) | RowKind::Coupling => S::zero(),
        }
    }

    /// Returns the row with the weight times `scale`.
    pub fn scaled(&self, scale: S) -> Self {
        Self { weight: self.weight * scale, ..self.clone() }
    }

    /// Returns the acceleration of the row under these accelerations of the joints.
    pub fn acceleration(&self, accelerations: &[S]) -> S {
        let products = self.entries.iter().map(|entry| entry.factor * accelerations[entry.dof]);
        self.sign * products.reduce(|sum, product| sum + product).unwrap_or_else(S::zero)
    }

    /// Adds the joint forces of a force along the row.
    pub fn add_force(&self, force: S, tau: &mut [S]) {
        for &RowEntry { dof, factor } in &self.entries {
            tau[dof] = tau[dof] + factor * (self.sign * force);
        }
    }

    /// Returns the force at an acceleration of the row, and minus its derivative.
    pub fn response(&self, acceleration: S) -> [S; 2] {
        let zero = S::zero();
        let force = -(self.weight * (acceleration - self.reference));
        match self.kind {
            RowKind::Limit => {
                [force.select_nonnegative(force, zero), force.select_nonnegative(self.weight, zero)]
            }
            RowKind::Friction(most) => {
                let within = (most - force.abs()).select_nonnegative(self.weight, zero);
                [at_least(at_most(force, most), -most), within]
            }
            RowKind::Coupling => [force, self.weight],
        }
    }
}
