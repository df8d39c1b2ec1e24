//! The joint forces of actuators, and their activations after a step, by `MuJoCo`'s laws.
//!
//! The torque-speed line is the law of Isaac Lab 2.3.2's `DCMotor`. The delay is as in its
//! `DelayedPDActuator`.

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::model::{
    Activation, ActivationDynamics, Actuation, Actuator, AffineLaw, JointForceRange, Model,
    TendonJoint, TorqueSpeedLine, Transmission,
};
use crate::scalar::{at_least, at_most};

/// The least time constant of an activation, s: `MuJoCo`'s `mjMINVAL`.
const LEAST_TIME: f64 = 1e-15;

/// The state and the input of a robot's actuators.
#[derive(Clone, Copy, Debug)]
pub struct ActuatorInput<'a, S> {
    /// The coordinates.
    pub q: &'a [S],
    /// The velocities.
    pub qd: &'a [S],
    /// The controls.
    pub ctrl: &'a [S],
    /// The states of the actuators: the controls that do not act yet, and the activations.
    pub act: &'a [S],
    /// The time of the step, s.
    pub dt: S,
}

/// The results of [`actuate`].
#[derive(Debug)]
pub struct ActuatorOutputs<'a, S> {
    /// The joint forces, N m or N.
    pub tau: &'a mut [S],
    /// The states of the actuators after the step.
    pub act: &'a mut [S],
}

/// The memory of [`actuate`].
#[derive(Clone, Debug)]
pub struct ActuationWorkspace<S> {
    /// The control or the activation that is the input of each actuator.
    inputs: Vec<S>,
    /// The force of each actuator.
    forces: Vec<S>,
    /// The least and the largest force by the torque-speed line of each actuator that has one.
    line_ends: Vec<Option<[S; 2]>>,
    /// The force of the actuators on the joint of each moving link.
    joint_forces: Vec<S>,
}

impl<S: Scalar> ActuationWorkspace<S> {
    /// Returns the memory for a model.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let actuators = model.actuation().actuators.len();
        Self {
            inputs: vec![S::zero(); actuators],
            forces: vec![S::zero(); actuators],
            line_ends: vec![None; actuators],
            joint_forces: vec![S::zero(); model.moving_links().len()],
        }
    }
}

/// The length of a transmission, and its rate.
#[derive(Clone, Copy)]
struct Length<S> {
    length: S,
    velocity: S,
}

/// Computes the joint forces of the actuators, and their activations after the step.
pub fn actuate<S: Scalar>(
    model: &Model,
    input: ActuatorInput<'_, S>,
    workspace: &mut ActuationWorkspace<S>,
    outputs: ActuatorOutputs<'_, S>,
) {
    let ActuatorOutputs { tau, act: next } = outputs;
    let ActuationWorkspace { inputs, forces, line_ends, joint_forces } = workspace;
    let Actuation { actuators, tendons, joint_force_ranges } = model.actuation();
    let mut first_state = 0;
    for (k, (actuator, &ctrl)) in actuators.iter().zip(input.ctrl).enumerate() {
        let states = first_state..first_state + actuator.states();
        first_state = states.end;
        let Some(before) = input.act.get(states.clone()) else { break };
        let Some(after) = next.get_mut(states) else { break };
        let (waiting, activations) = before.split_at(actuator.delay);
        let control = clamped(delayed(ctrl, waiting, after), actuator.control_range);
        inputs[k] = match (&actuator.activation, activations) {
            (Some(activation), &[act]) => {
                let follows = actuator.enabled.then_some(control);
                let next_act = next_activation(activation, act, follows, input.dt);
                after[actuator.delay] = next_act;
                if activation.early { next_act } else { act }
            }
            _ => control,
        };
        if actuator.enabled {
            let length = actuator_length(model, actuator, input);
            forces[k] = unlimited_force(actuator, inputs[k], length);
            line_ends[k] = actuator.torque_speed_line.map(|line| line_at(line, length.velocity));
        } else {
            forces[k] = S::zero();
            line_ends[k] = None;
        }
    }
    for (index, tendon) in tendons.iter().enumerate() {
        if let Some(range) = tendon.force_range {
            limit_tendon(actuators, Transmission::Tendon(index), range, forces);
        }
    }
    joint_forces.fill(S::zero());
    for ((actuator, force), ends) in actuators.iter().zip(forces).zip(line_ends) {
        let on_line = ends.map_or(*force, |ends| within_line(*force, ends));
        *force = clamped(on_line, actuator.force_range);
        for TendonJoint { link, coefficient } in joints(model, actuator) {
            let moment = S::from_f64(actuator.gear * coefficient);
            joint_forces[link] = moment.mul_add(*force, joint_forces[link]);
        }
    }
    for &JointForceRange { link, range } in joint_force_ranges {
        joint_forces[link] = clamped(joint_forces[link], Some(range));
    }
    tau.fill(S::zero());
    for (link, &force) in joint_forces.iter().enumerate() {
        let velocities = model.v_range(link);
        if velocities.len() == 1 {
            // The force on a mimic joint acts on its leader.
            let tau = &mut tau[velocities.start];
            *tau = match model.mimic(link) {
                None => *tau + force,
                Some(mimic) => S::from_f64(mimic.multiplier).mul_add(force, *tau),
            };
        }
    }
}

/// Returns the derivative of each actuator's force with respect to the rate of its length, as
/// `MuJoCo`'s `implicitfast` has it, after [`actuate`]: zero where a force is at an end of its range
/// or on its torque-speed line, where the sum of the forces on the actuator's tendon is at an end, and
/// where the force on its joint is. `None` for an actuator whose force does not depend on the rate.
pub(crate) fn velocity_gains<S: Scalar>(
    model: &Model,
    workspace: &ActuationWorkspace<S>,
) -> Vec<Option<S>> {
    let ActuationWorkspace { inputs, forces, line_ends, joint_forces } = workspace;
    let Actuation { actuators, tendons, joint_force_ranges } = model.actuation();
    let gain = |k: usize, actuator: &Actuator| {
        let input = inputs[k];
        let force = forces[k];
        let [gain, bias] = [actuator.gain, actuator.bias].map(|law| law.velocity);
        let mut derivative = S::from_f64(bias);
        if gain != 0.0 {
            derivative = S::from_f64(gain).mul_add(input, derivative);
        }
        derivative = within(derivative, force, actuator.force_range);
        if let Some(ends) = line_ends[k] {
            derivative = between(derivative, force, ends.map(Some));
        }
        match actuator.transmission {
            Transmission::Joint(link) => {
                let mut ranges = joint_force_ranges.iter().filter(|range| range.link == link);
                let range = ranges.next().map(|range| range.range);
                within(derivative, joint_forces[link], range)
            }
            Transmission::Tendon(tendon) => {
                let range = tendons[tendon].force_range.map(|range| {
                    // A sum that was scaled to an end of its range has a rounding error.
                    let [low, high] = range.map(|end| 1e-10 * end.abs());
                    [range[0] + low, range[1] - high]
                });
                let sum = sum_on(actuators, actuator.transmission, forces);
                within(derivative, sum, range)
            }
        }
    };
    let numbered = actuators.iter().enumerate();
    numbered.map(|(k, actuator)| depends_on_rate(actuator).then(|| gain(k, actuator))).collect()
}

/// Returns the derivative of a force that is within its range, and zero at the ends.
fn within<S: Scalar>(derivative: S, force: S, range: Option<[f64; 2]>) -> S {
    let Some(ends) = range else { return derivative };
    between(derivative, force, ends.map(|end| end.is_finite().then(|| S::from_f64(end))))
}

/// Returns the derivative of a force that is between these ends, and zero at the ends and beyond.
fn between<S: Scalar>(derivative: S, force: S, [low, high]: [Option<S>; 2]) -> S {
    let zero = S::zero();
    let above = low.map_or(derivative, |low| (low - force).select_nonnegative(zero, derivative));
    high.map_or(above, |high| (force - high).select_nonnegative(zero, above))
}

/// Returns whether the force of an actuator depends on the rate of its length.
pub(crate) fn depends_on_rate(actuator: &Actuator) -> bool {
    let laws = [actuator.gain, actuator.bias];
    actuator.enabled && actuator.gear != 0.0 && laws.iter().any(|law| law.velocity != 0.0)
}

/// Returns the derivative of an actuator's length with respect to the coordinates: entries of qd, each
/// once, with their factors.
pub(crate) fn moments(model: &Model, actuator: &Actuator) -> Vec<(usize, f64)> {
    let mut moments: Vec<(usize, f64)> = Vec::new();
    for TendonJoint { link, coefficient } in joints(model, actuator) {
        let multiplier = model.mimic(link).map_or(1.0, |mimic| mimic.multiplier);
        let moment = actuator.gear * coefficient * multiplier;
        let dof = model.v_range(link).start;
        match moments.iter_mut().find(|(other, _)| *other == dof) {
            Some((_, sum)) => *sum += moment,
            None => moments.push((dof, moment)),
        }
    }
    moments
}

/// Returns the joints that an actuator moves, each with the length of the transmission per unit of
/// the joint's coordinate.
fn joints<'a>(model: &'a Model, actuator: &Actuator) -> impl Iterator<Item = TendonJoint> + 'a {
    let (single, several) = match actuator.transmission {
        Transmission::Joint(link) => (Some(TendonJoint { link, coefficient: 1.0 }), &[][..]),
        Transmission::Tendon(tendon) => (None, &model.actuation().tendons[tendon].joints[..]),
    };
    single.into_iter().chain(several.iter().copied())
}

/// Returns the length of an actuator, and its rate.
fn actuator_length<S: Scalar>(
    model: &Model,
    actuator: &Actuator,
    input: ActuatorInput<'_, S>,
) -> Length<S> {
    let offset = match actuator.transmission {
        Transmission::Joint(_) => 0.0,
        Transmission::Tendon(tendon) => actuator.gear * model.actuation().tendons[tendon].offset,
    };
    let mut sum = Length { length: S::from_f64(offset), velocity: S::zero() };
    for TendonJoint { link, coefficient } in joints(model, actuator) {
        let mut coordinate = input.q[model.q_range(link).start];
        let mut rate = input.qd[model.v_range(link).start];
        if let Some(mimic) = model.mimic(link) {
            let multiplier = S::from_f64(mimic.multiplier);
            coordinate = multiplier.mul_add(coordinate, S::from_f64(mimic.offset));
            rate = multiplier * rate;
        }
        let factor = S::from_f64(actuator.gear * coefficient);
        sum.length = factor.mul_add(coordinate, sum.length);
        sum.velocity = factor.mul_add(rate, sum.velocity);
    }
    sum
}

/// Returns the force of an actuator before it is clamped.
fn unlimited_force<S: Scalar>(actuator: &Actuator, signal: S, length: Length<S>) -> S {
    let bias = affine(&actuator.bias, length);
    affine(&actuator.gain, length).mul_add(signal, bias)
}

/// Returns the control that acts now, the first of the controls that do not act yet, or this control
/// if there are none; and appends this control to the controls that do not act yet after the step.
fn delayed<S: Scalar>(ctrl: S, waiting: &[S], next: &mut [S]) -> S {
    let Some((&acting, rest)) = waiting.split_first() else { return ctrl };
    next[..rest.len()].copy_from_slice(rest);
    next[rest.len()] = ctrl;
    acting
}

/// Returns the least and the largest force of a torque-speed line at this speed.
fn line_at<S: Scalar>(line: TorqueSpeedLine, speed: S) -> [S; 2] {
    let stall = S::from_f64(line.stall_force);
    let slope = S::from_f64(-line.stall_force / line.no_load_speed);
    [slope.mul_add(speed, -stall), slope.mul_add(speed, stall)]
}

/// Returns the force clamped to a torque-speed line; NaN if the force is, or if the speed is.
fn within_line<S: Scalar>(force: S, [low, high]: [S; 2]) -> S {
    let clamped = at_most(at_least(force, low), high);
    let square = high * high;
    square.select_nonnegative(clamped, square)
}

/// Returns the number of an affine law. Terms with the factor zero are left out, so that a length
/// that is not finite has no effect on a law without it.
fn affine<S: Scalar>(law: &AffineLaw, at: Length<S>) -> S {
    let AffineLaw { constant, length, velocity } = *law;
    let mut sum = S::from_f64(constant);
    for (factor, number) in [(length, at.length), (velocity, at.velocity)] {
        if factor != 0.0 {
            sum = S::from_f64(factor).mul_add(number, sum);
        }
    }
    sum
}

/// Scales the forces of the actuators on a tendon such that their sum is in a range, which contains
/// zero.
fn limit_tendon<S: Scalar>(
    actuators: &[Actuator],
    tendon: Transmission,
    [low, high]: [f64; 2],
    forces: &mut [S],
) {
    let sum = sum_on(actuators, tendon, forces);
    let factor = share(-sum, -low) * share(sum, high);
    for (actuator, force) in actuators.iter().zip(forces) {
        if actuator.transmission == tendon {
            *force = factor * *force;
        }
    }
}

/// Returns the sum of the forces of the actuators on a tendon.
fn sum_on<S: Scalar>(actuators: &[Actuator], tendon: Transmission, forces: &[S]) -> S {
    let forces = actuators.iter().zip(forces);
    let on_tendon = forces.filter(|(actuator, _)| actuator.transmission == tendon);
    on_tendon.fold(S::zero(), |sum, (_, &force)| sum + force)
}

/// Returns the factor that scales a sum above the bound, which is not negative, to the bound.
fn share<S: Scalar>(sum: S, bound: f64) -> S {
    if bound == 0.0 {
        return (-sum).select_nonnegative(S::one(), S::zero());
    }
    let bound = S::from_f64(bound);
    bound / at_least(sum, bound)
}

/// Returns an activation after a step; the control is `None` if the actuator does not act.
fn next_activation<S: Scalar>(activation: &Activation, act: S, control: Option<S>, dt: S) -> S {
    let next = match (activation.dynamics, control) {
        (_, None) => act,
        (ActivationDynamics::Integrator, Some(control)) => dt.mul_add(control, act),
        (ActivationDynamics::Filter(time), Some(control)) => {
            let rate = (control - act) / S::from_f64(time.max(LEAST_TIME));
            dt.mul_add(rate, act)
        }
        (ActivationDynamics::ExactFilter(time), Some(control)) => {
            let share = approached(dt / S::from_f64(time.max(LEAST_TIME)));
            share.mul_add(control - act, act)
        }
    };
    clamped(next, activation.range)
}

/// Returns 1 - exp(-x) of a number that is not negative: the share of the distance to its control
/// that an activation moves in x time constants.
///
/// The Taylor series of exp(y) - 1 at y = -x / 512 is doubled nine times, by exp(2 y) - 1 = (exp(y)
/// - 1) (exp(y) + 1). Each doubling makes the relative error smaller.
fn approached<S: Scalar>(x: S) -> S {
    // Beyond, the result is 1 in double precision.
    const MOST: f64 = 40.0;
    const DOUBLINGS: i32 = 9;
    let y = at_most(x, S::from_f64(MOST)) * S::from_f64(-1.0 / f64::from(1 << DOUBLINGS));
    let series = (2..=10)
        .rev()
        .fold(S::one(), |sum, k| (y * S::from_f64(1.0 / f64::from(k))).mul_add(sum, S::one()));
    let difference = (0..DOUBLINGS).fold(y * series, |less, _| less * (less + S::from_f64(2.0)));
    -difference
}

/// Returns the number clamped to a range; NaN for NaN.
fn clamped<S: Scalar>(number: S, range: Option<[f64; 2]>) -> S {
    let Some([low, high]) = range else { return number };
    let mut clamped = number;
    if low.is_finite() {
        clamped = at_least(clamped, S::from_f64(low));
    }
    if high.is_finite() {
        clamped = at_most(clamped, S::from_f64(high));
    }
    clamped
}
