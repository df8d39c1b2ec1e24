//! The step on the ground as a function of arrays, and its derivatives: the contact problem, the
//! impulses and the coordinates, each for all lanes before the next.
//!
//! The arrays are, in this order: `q`, `qd`, the impulses of contacts and of stops, and the
//! residual, which are the state; `tau`, `dt`, the settings, the gains and references of a
//! feedback, and the run-time parameters. The contact problem and the integration are programs.
//! `modyn_runtime::simulate::by_numbers` finds the impulses: in lanes where sweeps suffice, else
//! lane by lane.

use std::borrow::Cow;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;

use modyn_codegen::Function;
use modyn_codegen::plan::{Derivative, DerivativeMode, EntryFunction, Sizes};
use modyn_runtime::simulate::by_numbers::{GroundRobot, StepChanges, StepGradient, StepLanes};
use modyn_runtime::simulate::{Ground, HeightField, Residual};
use modyn_runtime::{ConstraintSettings, ContactTarget, SettingError};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::kernel::{ArrayShapes, Kernel, OwnCode, OwnKernel, StateFunction};
use super::signature::matrices;
use crate::checks::Check;
use crate::number::Number;
use crate::robot::{GroundKey, Robot};

// The arrays of arguments; the first five are also those of results.
const Q: usize = 0;
const QD: usize = 1;
const CONTACTS: usize = 2;
const STOPS: usize = 3;
const RESIDUAL: usize = 4;
const TAU: usize = 5;
const DT: usize = 6;
const SETTINGS: usize = 7;
/// The number of arrays of the state.
const STATE: usize = 5;
/// The arrays of the state that are no arguments of the contact problem.
const OWN: usize = 3;

/// The options of a step on the ground; `None` is the default: whether joints have stops, the
/// tolerance, the largest numbers of sweeps and of Newton steps, and the height field: its origin,
/// its spacing, its columns and its heights.
pub type GroundOptions =
    (Option<bool>, Option<f64>, Option<usize>, Option<usize>, Option<FieldNumbers>);

/// The origin, the spacing, the columns and the heights of a height field.
pub type FieldNumbers = ([f64; 2], [f64; 2], usize, Vec<f64>);

/// The programs, the options and the arguments of a step on the ground of a robot.
pub struct Step {
    parts: Parts<EntryFunction>,
    robot: GroundRobot,
    options: GroundOptions,
    /// The shapes of the arguments.
    inputs: Vec<Vec<usize>>,
    has_parameters: bool,
}

impl Step {
    /// Returns the step of a robot.
    pub fn new(robot: &Robot, options: GroundOptions, feedback: bool) -> Self {
        let sizes = Sizes::new(robot.model(), 0);
        let ground_robot = GroundRobot::new(robot.model(), options.0.unwrap_or(true));
        let Sizes { nq, nv, contacts, .. } = sizes;
        let settings = GroundRobot::first_number_of(contacts);
        let state = [vec![nq], vec![nv], vec![contacts, 3], vec![nv], vec![2]];
        let parameters = robot.parameter_count();
        let others = [vec![nv], Vec::new(), vec![settings]];
        let of_feedback =
            if feedback { vec![vec![nv, 2 * nv], vec![nq], vec![nv]] } else { Vec::new() };
        let parameters = (parameters > 0).then(|| vec![parameters]);
        let has_parameters = parameters.is_some();
        Self {
            parts: Parts::of_step(&sizes, &ground_robot, (options.4.is_some(), feedback)),
            robot: ground_robot,
            options,
            inputs: state.into_iter().chain(others).chain(of_feedback).chain(parameters).collect(),
            has_parameters,
        }
    }

    /// Returns the options of the solver in the scalar, and the height field.
    ///
    /// # Errors
    ///
    /// If an option is outside of its range, or a height is not finite.
    fn ground<S: Number>(
        &self,
    ) -> Result<(Ground<S>, Option<HeightField<'static, S>>), SettingError> {
        let (limits, tolerance, sweeps, steps, field) = &self.options;
        let default = Ground::<S>::default();
        let ground = Ground {
            joint_limits: limits.unwrap_or(default.joint_limits),
            tolerance: tolerance.map_or(default.tolerance, S::from_f64),
            sweeps: sweeps.unwrap_or(default.sweeps),
            newton_steps: steps.unwrap_or(default.newton_steps),
        };
        ground.check()?;
        let field = field.as_ref().map(|(origin, spacing, columns, heights)| {
            // In the scalar a number can be infinite, or zero.
            let [origin, spacing] = [origin, spacing].map(|pair| pair.map(S::from_f64));
            let heights: Vec<S> = heights.iter().map(|&height| S::from_f64(height)).collect();
            HeightField::new(origin, spacing, *columns, &heights)?;
            // The code of a function is never dropped.
            HeightField::new(origin, spacing, *columns, heights.leak())
        });
        Ok((ground, field.transpose()?))
    }

    /// Returns the contacts and the joint stops.
    pub fn robot(&self) -> &GroundRobot {
        &self.robot
    }

    /// Returns the key of the step, or of a derivative of it.
    pub fn key(&self, derivative: Option<&Derivative>) -> GroundKey {
        let (limits, tolerance, sweeps, steps, field) = &self.options;
        let mut hasher = DefaultHasher::new();
        if let Some((origin, spacing, columns, heights)) = field {
            let numbers = origin.iter().chain(spacing).chain(heights);
            numbers.for_each(|number| number.to_bits().hash(&mut hasher));
            columns.hash(&mut hasher);
        }
        let numbers = [
            limits.map(u64::from),
            tolerance.map(f64::to_bits),
            sweeps.map(|count| count as u64),
            steps.map(|count| count as u64),
            field.as_ref().map(|_| hasher.finish()),
        ];
        let derivatives = derivative.cloned().into_iter().collect();
        let problem = EntryFunction { derivatives, ..self.parts.problem.clone() };
        (problem, numbers.map(|number| number.unwrap_or(u64::MAX)))
    }

    /// Returns the shapes of the arrays.
    ///
    /// # Errors
    ///
    /// If a derivative varies an array that there is not.
    pub fn shapes(&self, derivative: Option<&Derivative>) -> Result<ArrayShapes, String> {
        let mut inputs = self.inputs.clone();
        let mut outputs = self.inputs[..STATE].to_vec();
        if let Some(Derivative { mode, variables }) = derivative {
            let count = inputs.len();
            let is_sorted = variables.is_sorted_by(|a, b| a < b);
            if !is_sorted || variables.last().is_none_or(|&last| last >= count) {
                return Err(format!("{variables:?} must be ascending indices of {count} arrays"));
            }
            let varying: Vec<Vec<usize>> = variables.iter().map(|&k| inputs[k].clone()).collect();
            match mode {
                DerivativeMode::Forward => inputs.extend(varying),
                DerivativeMode::Reverse => inputs.extend(std::mem::replace(&mut outputs, varying)),
                DerivativeMode::Matrix => outputs = matrices(&outputs, &varying),
            }
        }
        let checks = vec![(DT, "dt", Check::TimeStep), (SETTINGS, "settings", Check::Settings)];
        Ok(ArrayShapes::new(inputs, outputs).with_checks(checks))
    }

    /// Returns the step, or a derivative of it, whose programs `compiled` compiles.
    ///
    /// # Errors
    ///
    /// Those of `compiled`; if an option is outside of its range, or a height is not finite.
    pub fn compile<S: Number>(
        &self,
        derivative: Option<&Derivative>,
        mut compiled: impl FnMut(&EntryFunction) -> PyResult<&'static StateFunction<S>>,
    ) -> PyResult<GroundFunction<S>> {
        let wrong = |error: SettingError| PyValueError::new_err(error.to_string());
        let (ground, field) = self.ground::<S>().map_err(wrong)?;
        let parameters = self.has_parameters.then(|| self.inputs.len() - 1);
        let of = |derivative: &Derivative| {
            let Derivative { mode, variables } = derivative;
            // Matrices are changes along each number.
            let of_parts = match mode {
                DerivativeMode::Matrix => DerivativeMode::Forward,
                other => *other,
            };
            let parts =
                self.parts.derivative(of_parts, variables, parameters).map(&mut compiled)?;
            let mode = *mode;
            let variables = variables.clone();
            let parameters = parameters.filter(|own| variables.contains(own));
            Ok::<_, PyErr>(GroundDerivative { mode, variables, parameters, parts })
        };
        let derivative = derivative.map(of).transpose()?;
        Ok(GroundFunction {
            parts: self.parts.map(compiled)?,
            field,
            robot: self.robot.clone(),
            ground,
            lengths: self.inputs.iter().map(|shape| shape.iter().product()).collect(),
            has_parameters: self.has_parameters,
            derivative,
        })
    }
}

/// The programs of a step, or of a derivative of it.
struct Parts<T> {
    /// The contact problem.
    problem: T,
    /// The coordinates after a displacement.
    integrate: T,
    /// The inverse of the mass matrix, for joint stops; `None` if no joint has a limit.
    inverse: Option<T>,
    /// The places of the contacts, for a height field; `None` without one.
    places: Option<T>,
}

impl<T> Parts<T> {
    /// Returns the results of a function of each part.
    fn map<'a, O, E>(&'a self, mut of: impl FnMut(&'a T) -> Result<O, E>) -> Result<Parts<O>, E> {
        let problem = of(&self.problem)?;
        let integrate = of(&self.integrate)?;
        let inverse = self.inverse.as_ref().map(&mut of).transpose()?;
        Ok(Parts { problem, integrate, inverse, places: self.places.as_ref().map(of).transpose()? })
    }
}

impl<S: Number> Parts<Kernel<'_, S>> {
    fn lanes(&self) -> usize {
        self.problem.lanes().min(self.integrate.lanes())
    }

    fn cost(&self) -> usize {
        self.problem.cost() + self.integrate.cost()
    }
}

impl Parts<EntryFunction> {
    /// Returns the programs of a step of a robot with these sizes.
    fn of_step(sizes: &Sizes, robot: &GroundRobot, (has_field, feedback): (bool, bool)) -> Self {
        let nq = sizes.nq;
        let nv = sizes.nv;
        let part = |function, places: Range<usize>| EntryFunction {
            function,
            link: None,
            results: vec![places.collect()],
            feedback: false,
            cost: false,
            derivatives: Vec::new(),
        };
        // Of the derivatives of forward dynamics that by the joint forces, after the accelerations
        // and two other matrices.
        let by_forces = nv + 2 * nv * nv..nv + 3 * nv * nv;
        let inverse = || part(Function::ForwardDynamicsDerivatives, by_forces);
        Self {
            problem: EntryFunction {
                feedback,
                ..part(Function::ContactProblem, 0..robot.problem_length())
            },
            integrate: part(Function::Integrate, 0..nq),
            inverse: robot.has_stops().then(inverse),
            places: has_field.then(|| EntryFunction {
                // Twists of loop constraints come first. The linear part is the last.
                results: vec![
                    (sizes.constraints - sizes.contacts..sizes.constraints)
                        .flat_map(|twist| 6 * twist + 3..6 * twist + 6)
                        .collect(),
                ],
                ..part(Function::ConstraintResidual, 0..0)
            }),
        }
    }

    /// Returns the derivatives of the programs for that of a step by these arguments. `parameters`
    /// is the index of the run-time parameters among the arguments of the step.
    fn derivative(
        &self,
        mode: DerivativeMode,
        variables: &[usize],
        parameters: Option<usize>,
    ) -> Self {
        let with = |part: &EntryFunction, variables: Vec<usize>| EntryFunction {
            derivatives: vec![Derivative { mode, variables }],
            ..part.clone()
        };
        let given = parameters.filter(|own| variables.contains(own));
        Self {
            problem: with(
                &self.problem,
                varying_in_problem(variables)
                    .map(|k| if k < CONTACTS { k } else { k - OWN })
                    .collect(),
            ),
            integrate: with(&self.integrate, vec![0, 1]),
            // The arguments are q, qd, tau and the parameters.
            inverse: self
                .inverse
                .as_ref()
                .map(|part| with(part, [0].into_iter().chain(given.map(|_| 3)).collect())),
            // The plane below a contact is held.
            places: None,
        }
    }
}

/// Returns the arguments of a step that vary in the contact problem, if these of the step do; `q`
/// and `qd` always vary.
fn varying_in_problem(variables: &[usize]) -> impl Iterator<Item = usize> {
    [Q, QD].into_iter().chain(variables.iter().copied().filter(|&k| k >= STATE))
}

/// A step on the ground, or a derivative of one.
pub struct GroundFunction<S: Number + 'static> {
    /// The programs of the step.
    parts: Parts<&'static StateFunction<S>>,
    /// The contacts and the joint stops.
    robot: GroundRobot,
    /// The options of the step.
    ground: Ground<S>,
    /// The heights of the ground, which set the planes of the contacts.
    field: Option<HeightField<'static, S>>,
    /// The numbers of each argument of the step.
    lengths: Vec<usize>,
    /// Whether the last argument are the run-time parameters.
    has_parameters: bool,
    /// The derivative.
    derivative: Option<GroundDerivative<S>>,
}

impl<S: Number> GroundFunction<S> {
    /// Returns the number of all numbers that vary.
    fn directions(&self, derivative: &GroundDerivative<S>) -> usize {
        derivative.variables.iter().map(|&k| self.lengths[k]).sum()
    }

    /// Sets the numbers of settings to zero that a height field sets.
    fn without_planes(&self, settings: &mut Rows<S>) {
        if self.field.is_some() {
            let lanes = settings.lanes;
            for contact in 0..self.lengths[CONTACTS] / 3 {
                settings.numbers[GroundRobot::first_number_of(contact) * lanes..][..POSE * lanes]
                    .fill(S::zero());
            }
        }
    }
}

/// A derivative of a step.
struct GroundDerivative<S: Number + 'static> {
    mode: DerivativeMode,
    /// The arguments that vary, by their indices, in ascending order.
    variables: Vec<usize>,
    /// The index of the run-time parameters, if they vary.
    parameters: Option<usize>,
    /// The derivatives of the programs.
    parts: Parts<&'static StateFunction<S>>,
}

/// A step on the ground, ready to be called.
struct ReadyGround<'a, S: Number + 'static> {
    function: &'a GroundFunction<S>,
    parts: Parts<Kernel<'a, S>>,
    derivative: Option<(&'a GroundDerivative<S>, Parts<Kernel<'a, S>>)>,
}

impl<S: Number> OwnCode<S> for GroundFunction<S> {
    fn ready(&self) -> Result<Box<dyn OwnKernel<S> + '_>, String> {
        let with_parts = self.derivative.as_ref().map(|derivative| {
            derivative.parts.map(|part| part.kernel()).map(|parts| (derivative, parts))
        });
        let derivative = with_parts.transpose()?;
        let parts = self.parts.map(|part| part.kernel())?;
        Ok(Box::new(ReadyGround { function: self, parts, derivative }))
    }
}

/// Numbers in lanes: a row of lanes for each number.
struct Rows<S> {
    numbers: Vec<S>,
    lanes: usize,
}

impl<S: Number> Rows<S> {
    fn zeros(count: usize, lanes: usize) -> Self {
        Self { numbers: vec![S::zero(); count * lanes], lanes }
    }

    /// Returns the numbers of a lane.
    fn lane(&self, lane: usize) -> Vec<S> {
        lane_of(&self.numbers, lane, self.lanes)
    }

    /// Returns the rows of some lanes.
    fn of_lanes(&self, lanes: &Range<usize>) -> Cow<'_, [S]> {
        if lanes.len() == self.lanes {
            return Cow::Borrowed(&self.numbers);
        }
        let rows = self.numbers.chunks_exact(self.lanes);
        rows.flat_map(|row| &row[lanes.clone()]).copied().collect()
    }

    /// Sets some lanes to the first lanes of rows of `width` lanes.
    fn set(&mut self, lanes: &Range<usize>, numbers: &[S], width: usize) {
        let first = lanes.start.min(self.numbers.len());
        copy_rows((numbers, width), (&mut self.numbers[first..], self.lanes), lanes.len());
    }

    /// Sets a lane.
    fn set_lane(&mut self, lane: usize, numbers: &[S]) {
        self.set(&(lane..lane + 1), numbers, 1);
    }

    /// Appends the rows of some lanes, each with zeros up to `width` lanes.
    fn append(&self, lanes: &Range<usize>, width: usize, rows: &mut Vec<S>) {
        let end = rows.len();
        rows.resize(end + self.numbers.len() / self.lanes * width, S::zero());
        let first = lanes.start.min(self.numbers.len());
        copy_rows((&self.numbers[first..], self.lanes), (&mut rows[end..], width), lanes.len());
    }
}

/// Copies the first `count` numbers of each row to a row of another width.
fn copy_rows<S: Copy>((from, width): (&[S], usize), to: (&mut [S], usize), count: usize) {
    // The lanes of processors: without calls of `memcpy`.
    match count {
        2 => copy_numbers::<S, 2>((from, width), to),
        4 => copy_numbers::<S, 4>((from, width), to),
        8 => copy_numbers::<S, 8>((from, width), to),
        _ => to.0.chunks_mut(to.1).zip(from.chunks(width)).for_each(|(to, from)| {
            to[..count].copy_from_slice(&from[..count]);
        }),
    }
}

/// [`copy_rows`] of a number of lanes that the compiler knows.
fn copy_numbers<S: Copy, const COUNT: usize>(
    (from, width): (&[S], usize),
    (to, own): (&mut [S], usize),
) {
    for (to, from) in to.chunks_mut(own).zip(from.chunks(width)) {
        if let (Some(to), Some(from)) = (to.first_chunk_mut::<COUNT>(), from.first_chunk::<COUNT>())
        {
            *to = *from;
        }
    }
}

/// The velocities after a step, the impulses, and the displacement of the coordinates; or their
/// changes.
struct After<S> {
    velocities: Rows<S>,
    contacts: Rows<S>,
    stops: Rows<S>,
    displacement: Rows<S>,
}

/// A step that is solved: its contact problem, its results, and the residual of these.
struct Solved<S> {
    problem: Rows<S>,
    after: After<S>,
    residual: Rows<S>,
}

impl<S: Number> OwnKernel<S> for ReadyGround<'_, S> {
    fn cost(&self) -> usize {
        let of_derivative = self.derivative.as_ref().map_or(0, |(derivative, parts)| {
            let times = match derivative.mode {
                DerivativeMode::Matrix => self.function.directions(derivative),
                DerivativeMode::Forward | DerivativeMode::Reverse => 1,
            };
            times * parts.cost()
        });
        // Some thousand instructions find the impulses.
        1000 + self.parts.cost() + of_derivative
    }

    fn lanes(&self) -> usize {
        match &self.derivative {
            // The lanes are directions.
            Some((GroundDerivative { mode: DerivativeMode::Matrix, .. }, _)) => 1,
            Some((_, parts)) => self.parts.lanes().min(parts.lanes()),
            None => self.parts.lanes(),
        }
    }

    fn run(&self, numbers: &[S], result: &mut [S], lanes: usize) {
        let on_field = self.on_field(numbers, lanes);
        let numbers = on_field.as_deref().unwrap_or(numbers);
        let given = Given { numbers, lengths: &self.function.lengths, lanes };
        let Some((derivative, parts)) = &self.derivative else {
            return self.value(&given, &self.solve(&given), result);
        };
        let own = (*derivative, parts);
        match derivative.mode {
            DerivativeMode::Forward => self.forward(&given, &self.solve(&given), own, result),
            DerivativeMode::Reverse => self.reverse(&given, &self.solve(&given), own, result),
            DerivativeMode::Matrix => self.matrices(&given, &self.solve(&given), own, result),
        }
    }
}

impl<S: Number> ReadyGround<'_, S> {
    /// Returns the arguments with the planes of the height field below the contacts as their
    /// targets.
    fn on_field(&self, numbers: &[S], lanes: usize) -> Option<Vec<S>> {
        let function = self.function;
        let kernel = self.parts.places.as_ref()?;
        let field = function.field.as_ref()?;
        let lengths = &function.lengths;
        let given = Given { numbers, lengths, lanes };
        let contacts = lengths[CONTACTS] / 3;
        // Displacements from the world's origin are places.
        let origin = ContactTarget { tangential: S::one(), ..S::GROUND };
        let targets = std::iter::repeat_n(origin.numbers(), contacts).flatten();
        let settings = S::SETTINGS.numbers().into_iter().chain(targets);
        let settings = settings.flat_map(|number| std::iter::repeat_n(number, lanes));
        let still = std::iter::repeat_n(S::zero(), lengths[QD] * lanes);
        let arguments: Vec<S> =
            given.rows(Q).iter().copied().chain(still).chain(settings).collect();
        let mut places = Rows::zeros(3 * contacts, lanes);
        kernel.run(&arguments, &mut places.numbers, lanes);
        let mut numbers = numbers.to_vec();
        let first: usize = lengths[..SETTINGS].iter().sum();
        for contact in 0..contacts {
            let own = first + GroundRobot::first_number_of(contact);
            for lane in 0..lanes {
                let place = |k: usize| places.numbers[(3 * contact + k) * lanes + lane];
                let plane = field.plane([place(0), place(1)]);
                let pose = plane.rotation.iter().flatten().chain(&plane.translation);
                pose.zip(own..).for_each(|(&x, row)| numbers[row * lanes + lane] = x);
            }
        }
        Some(numbers)
    }

    /// Finds the impulses and the velocities.
    fn solve(&self, given: &Given<'_, S>) -> Solved<S> {
        let function = self.function;
        let lanes = given.lanes;
        let [nv, contacts] = [QD, CONTACTS].map(|k| function.lengths[k]);
        let mut problem = Rows::zeros(function.robot.problem_length(), lanes);
        self.parts.problem.run(&given.of_problem(), &mut problem.numbers, lanes);
        let [mut velocities, mut displacement] = [(); 2].map(|()| Rows::zeros(nv, lanes));
        let mut of_contacts = Rows::zeros(contacts, lanes);
        let mut of_stops = Rows::zeros(nv, lanes);
        let mut residual = Rows::zeros(2, lanes);
        of_contacts.numbers.copy_from_slice(given.rows(CONTACTS));
        of_stops.numbers.copy_from_slice(given.rows(STOPS));
        let mut solved = vec![None; lanes];
        if lanes > 1 {
            let numbers = StepLanes {
                lanes,
                q: given.rows(Q),
                dt: given.rows(DT),
                settings: given.rows(SETTINGS),
                problem: &problem.numbers,
                stops: &of_stops.numbers,
            };
            let found = (&mut *of_contacts.numbers, &mut *velocities.numbers);
            function.robot.solve_lanes(&function.ground, &numbers, found, &mut solved);
        }
        let mut qd = vec![S::zero(); nv];
        for (lane, solved) in solved.into_iter().enumerate() {
            let last = given.lane(RESIDUAL, lane);
            let after = |wrong: Residual<S>| {
                let most = Residual { contacts: last[0], stops: last[1] }.max(wrong);
                [most.contacts, most.stops]
            };
            if let Some(wrong) = solved {
                let wrong = Residual { contacts: wrong, stops: S::zero() };
                residual.set_lane(lane, &after(wrong));
                continue;
            }
            let (q, dt, settings) = given.before(lane);
            let [mut p, mut s] = [&of_contacts, &of_stops].map(|rows| rows.lane(lane));
            let (wrong, _) = function.robot.solve(
                &function.ground,
                (&q, dt, &settings),
                (
                    |i| problem.numbers[i * lanes + lane],
                    |inverse: &mut [S]| self.inverse(given, lane, inverse),
                ),
                (&mut p, &mut s),
                &mut qd,
            );
            velocities.set_lane(lane, &qd);
            of_contacts.set_lane(lane, &p);
            of_stops.set_lane(lane, &s);
            residual.set_lane(lane, &after(wrong));
        }
        for (places, qd) in
            displacement.numbers.chunks_mut(lanes).zip(velocities.numbers.chunks(lanes))
        {
            for ((place, &v), &dt) in places.iter_mut().zip(qd).zip(given.rows(DT)) {
                *place = v * dt;
            }
        }
        let after = After { velocities, contacts: of_contacts, stops: of_stops, displacement };
        Solved { problem, after, residual }
    }

    /// Returns the contact problem and the inverse of the mass matrix of a lane.
    fn of_lane<'a>(
        &'a self,
        given: &'a Given<'a, S>,
        solved: &'a Solved<S>,
        lane: usize,
    ) -> (impl Fn(usize) -> S + 'a, impl Fn(&mut [S]) + 'a) {
        let problem = move |i: usize| solved.problem.numbers[i * given.lanes + lane];
        (problem, move |inverse: &mut [S]| self.inverse(given, lane, inverse))
    }

    /// Sets the inverse of the mass matrix of a lane.
    fn inverse(&self, given: &Given<'_, S>, lane: usize, inverse: &mut [S]) {
        if let Some(kernel) = &self.parts.inverse {
            kernel.run(&self.of_inverse(given, lane), inverse, 1);
        }
    }

    /// Returns the arguments of the inverse of the mass matrix of a lane: q, qd, tau and the
    /// parameters.
    fn of_inverse(&self, given: &Given<'_, S>, lane: usize) -> Vec<S> {
        let parameters = self.function.has_parameters.then(|| given.lengths.len() - 1);
        let all = [Q, QD, TAU].into_iter().chain(parameters);
        all.flat_map(|k| given.lane(k, lane)).collect()
    }

    /// Writes the state after the step.
    fn value(&self, given: &Given<'_, S>, solved: &Solved<S>, result: &mut [S]) {
        let nq = self.function.lengths[Q] * given.lanes;
        let (q, rest) = result.split_at_mut(nq);
        let displaced = [&given.numbers[..nq], &solved.after.displacement.numbers].concat();
        self.parts.integrate.run(&displaced, q, given.lanes);
        let parts = [
            &solved.after.velocities,
            &solved.after.contacts,
            &solved.after.stops,
            &solved.residual,
        ];
        rest.iter_mut()
            .zip(parts.into_iter().flat_map(|rows| &rows.numbers))
            .for_each(|(place, &x)| *place = x);
    }

    /// Writes the gradients of the weighted state by the variables.
    fn reverse(
        &self,
        given: &Given<'_, S>,
        solved: &Solved<S>,
        (derivative, parts): (&GroundDerivative<S>, &Parts<Kernel<'_, S>>),
        result: &mut [S],
    ) {
        let function = self.function;
        let lanes = given.lanes;
        let lengths = &function.lengths;
        let [nq, nv] = [Q, QD].map(|k| lengths[k]);
        let weights = Given {
            numbers: &given.numbers[lengths.iter().sum::<usize>() * lanes..],
            lengths: &lengths[..STATE],
            lanes,
        };
        // Through the coordinates.
        let displaced =
            [&given.numbers[..nq * lanes], &solved.after.displacement.numbers, weights.rows(Q)]
                .concat();
        let mut by_displaced = Rows::zeros(nq + nv, lanes);
        parts.integrate.run(&displaced, &mut by_displaced.numbers, lanes);
        let by_displaced = Given { numbers: &by_displaced.numbers, lengths: &[nq, nv], lanes };
        // By each argument of the step, and each number of the contact problem.
        let mut gradients: Vec<Rows<S>> =
            lengths.iter().map(|&length| Rows::zeros(length, lanes)).collect();
        gradients[Q].numbers.copy_from_slice(by_displaced.rows(Q));
        let mut by_problem = Rows::zeros(function.robot.problem_length(), lanes);
        for lane in 0..lanes {
            let (q, dt, settings) = given.before(lane);
            let of = |rows: &Rows<S>| rows.lane(lane);
            let p = of(&solved.after.contacts);
            let s = of(&solved.after.stops);
            let moved = by_displaced.lane(QD, lane);
            let mut of_velocities = weights.lane(QD, lane);
            for (weight, &by) in of_velocities.iter_mut().zip(&moved) {
                *weight = *weight + dt * by;
            }
            let qd = of(&solved.after.velocities);
            let mut by_dt = qd.iter().zip(&moved).fold(S::zero(), |sum, (&v, &by)| sum + v * by);
            let mut problem = vec![S::zero(); function.robot.problem_length()];
            let mut inverse = Vec::new();
            let mut by_settings = vec![S::zero(); lengths[SETTINGS]];
            let mut by_q = vec![S::zero(); nq];
            function.robot.add_gradient(
                (&q, dt, &settings),
                self.of_lane(given, solved, lane),
                (&p, &s),
                [&of_velocities, &weights.lane(CONTACTS, lane), &weights.lane(STOPS, lane)],
                StepGradient {
                    problem: &mut problem,
                    inverse: &mut inverse,
                    q: &mut by_q,
                    dt: &mut by_dt,
                    settings: &mut by_settings,
                },
            );
            let mut add = |array: usize, numbers: &[S]| {
                let places = gradients[array].numbers.iter_mut().skip(lane).step_by(lanes);
                places.zip(numbers).for_each(|(place, &x)| *place = *place + x);
            };
            if let Some(kernel) = parts.inverse.as_ref().filter(|_| !inverse.is_empty()) {
                let arguments = [self.of_inverse(given, lane), inverse].concat();
                let count = derivative.parameters.map_or(0, |own| lengths[own]);
                let mut found = vec![S::zero(); nq + count];
                kernel.run(&arguments, &mut found, 1);
                add(Q, &found[..nq]);
                derivative.parameters.iter().for_each(|&own| add(own, &found[nq..]));
            }
            add(Q, &by_q);
            add(DT, &[by_dt]);
            add(SETTINGS, &by_settings);
            by_problem.set_lane(lane, &problem);
        }
        // Through the contact problem.
        let arguments = [&*given.of_problem(), &by_problem.numbers].concat();
        let count = varying_in_problem(&derivative.variables).map(|k| lengths[k]).sum();
        let mut found = Rows::zeros(count, lanes);
        parts.problem.run(&arguments, &mut found.numbers, lanes);
        let mut rest = &*found.numbers;
        for k in varying_in_problem(&derivative.variables) {
            let own;
            (own, rest) = rest.split_at(lengths[k] * lanes);
            gradients[k].numbers.iter_mut().zip(own).for_each(|(place, &x)| *place = *place + x);
        }
        self.function.without_planes(&mut gradients[SETTINGS]);
        let all = derivative.variables.iter().flat_map(|&k| &gradients[k].numbers);
        result.iter_mut().zip(all).for_each(|(place, &x)| *place = x);
    }

    /// Writes the derivatives of each array of the state of one lane by each variable.
    fn matrices(
        &self,
        given: &Given<'_, S>,
        solved: &Solved<S>,
        (derivative, parts): (&GroundDerivative<S>, &Parts<Kernel<'_, S>>),
        result: &mut [S],
    ) {
        let function = self.function;
        let lengths = &self.function.lengths;
        let lanes = parts.lanes();
        let directions = function.directions(derivative);
        if directions == 0 {
            return;
        }
        let groups = || (0..directions).step_by(lanes).map(|k| k..directions.min(k + lanes));
        // The change of each argument: one, along one direction.
        let mut changes: Vec<Rows<S>> =
            lengths.iter().map(|&length| Rows::zeros(length, directions)).collect();
        let mut first = 0;
        for &k in &derivative.variables {
            for (number, row) in changes[k].numbers.chunks_exact_mut(directions).enumerate() {
                row[first + number] = S::one();
            }
            first += lengths[k];
        }
        function.without_planes(&mut changes[SETTINGS]);
        let mut problem = Rows::zeros(function.robot.problem_length(), directions);
        let mut own = Rows::zeros(function.robot.problem_length(), lanes);
        let at = in_lanes(&given.of_problem(), lanes);
        for group in groups() {
            let mut arguments = at.clone();
            for k in varying_in_problem(&derivative.variables) {
                changes[k].append(&group, lanes, &mut arguments);
            }
            parts.problem.run(&arguments, &mut own.numbers, lanes);
            problem.set(&group, &own.numbers, lanes);
        }
        let nq = lengths[Q];
        let after = self.changes(given, solved, (derivative, parts), (&changes, &problem));
        let mut state: Vec<Rows<S>> =
            lengths[..STATE].iter().map(|&length| Rows::zeros(length, directions)).collect();
        let at = in_lanes(&[given.rows(Q), &solved.after.displacement.numbers].concat(), lanes);
        let mut own = Rows::zeros(nq, lanes);
        for group in groups() {
            let mut arguments = at.clone();
            for rows in [&changes[Q], &after.displacement] {
                rows.append(&group, lanes, &mut arguments);
            }
            parts.integrate.run(&arguments, &mut own.numbers, lanes);
            state[Q].set(&group, &own.numbers, lanes);
        }
        // The residual does not change.
        (state[QD], state[CONTACTS], state[STOPS]) =
            (after.velocities, after.contacts, after.stops);
        // The matrices follow each other, by rows.
        let mut places = result.iter_mut();
        for rows in &state {
            let mut first = 0;
            for columns in derivative.variables.iter().map(|&k| lengths[k]) {
                let own = rows.numbers.chunks_exact(directions);
                let own = own.flat_map(|row| &row[first..first + columns]);
                own.zip(places.by_ref()).for_each(|(&x, place)| *place = x);
                first += columns;
            }
        }
    }

    /// Writes the changes of the state under changes of the variables.
    fn forward(
        &self,
        given: &Given<'_, S>,
        solved: &Solved<S>,
        (derivative, parts): (&GroundDerivative<S>, &Parts<Kernel<'_, S>>),
        result: &mut [S],
    ) {
        let function = self.function;
        let lanes = given.lanes;
        let lengths = &function.lengths;
        let nq = lengths[Q];
        // The change of each argument of the step.
        let mut rest = &given.numbers[lengths.iter().sum::<usize>() * lanes..];
        let mut changes: Vec<Rows<S>> =
            lengths.iter().map(|&length| Rows::zeros(length, lanes)).collect();
        for &k in &derivative.variables {
            let own;
            (own, rest) = rest.split_at(lengths[k] * lanes);
            changes[k].numbers.copy_from_slice(own);
        }
        function.without_planes(&mut changes[SETTINGS]);
        let mut arguments = given.of_problem();
        varying_in_problem(&derivative.variables)
            .for_each(|k| arguments.extend_from_slice(&changes[k].numbers));
        let mut problem = Rows::zeros(function.robot.problem_length(), lanes);
        parts.problem.run(&arguments, &mut problem.numbers, lanes);
        let after = self.changes(given, solved, (derivative, parts), (&changes, &problem));
        let displaced = [
            &given.numbers[..nq * lanes],
            &solved.after.displacement.numbers,
            &changes[Q].numbers,
            &after.displacement.numbers,
        ]
        .concat();
        let (q, rest) = result.split_at_mut(nq * lanes);
        parts.integrate.run(&displaced, q, lanes);
        let all = [&after.velocities, &after.contacts, &after.stops];
        let mut places = rest.iter_mut();
        let own = all.into_iter().flat_map(|rows| &rows.numbers);
        own.zip(places.by_ref()).for_each(|(&x, place)| *place = x);
        // The residual does not change.
        places.for_each(|place| *place = S::zero());
    }

    /// Returns the changes of what a step finds under changes of its arguments and of the numbers
    /// of the contact problem. Each has rows of as many directions for each lane of `given`.
    fn changes(
        &self,
        given: &Given<'_, S>,
        solved: &Solved<S>,
        (derivative, parts): (&GroundDerivative<S>, &Parts<Kernel<'_, S>>),
        (changes, problem): (&[Rows<S>], &Rows<S>),
    ) -> After<S> {
        let lengths = &self.function.lengths;
        let [nv, contacts] = [QD, CONTACTS].map(|k| lengths[k]);
        let width = problem.lanes;
        let directions = width / given.lanes;
        let rows = |count| Rows::zeros(count, width);
        let mut after = After {
            velocities: rows(nv),
            contacts: rows(contacts),
            stops: rows(nv),
            displacement: rows(nv),
        };
        for lane in 0..given.lanes {
            let own = lane * directions..(lane + 1) * directions;
            let (q, dt, settings) = given.before(lane);
            let p = solved.after.contacts.lane(lane);
            let s = solved.after.stops.lane(lane);
            let mut inverse = Rows::zeros(0, directions);
            let acts = s.iter().any(|x| x.abs() > S::zero());
            if let Some(kernel) = parts.inverse.as_ref().filter(|_| acts) {
                inverse = Rows::zeros(nv * nv, directions);
                let mut column = vec![S::zero(); nv * nv];
                for (direction, k) in own.clone().enumerate() {
                    let parameters = derivative.parameters.map(|own| changes[own].lane(k));
                    let along = [changes[Q].lane(k), parameters.unwrap_or_default()].concat();
                    // Along others, it does not change.
                    if along.iter().any(|x| x.abs() > S::zero()) {
                        let arguments = [self.of_inverse(given, lane), along].concat();
                        kernel.run(&arguments, &mut column, 1);
                        inverse.set_lane(direction, &column);
                    }
                }
            }
            let ddt = changes[DT].of_lanes(&own);
            let step = StepChanges {
                problem: &problem.of_lanes(&own),
                inverse: &inverse.numbers,
                q: &changes[Q].of_lanes(&own),
                dt: &ddt,
                settings: &changes[SETTINGS].of_lanes(&own),
            };
            let [mut velocities, mut of_contacts, mut stops] =
                [nv, contacts, nv].map(|count| vec![S::zero(); count * directions]);
            self.function.robot.changes(
                (&q, dt, &settings),
                self.of_lane(given, solved, lane),
                (&p, &s),
                &step,
                [&mut velocities, &mut of_contacts, &mut stops],
            );
            after.velocities.set(&own, &velocities, directions);
            after.contacts.set(&own, &of_contacts, directions);
            after.stops.set(&own, &stops, directions);
            let before = solved.after.velocities.lane(lane);
            for (row, &v) in velocities.chunks_exact_mut(directions).zip(&before) {
                row.iter_mut().zip(&*ddt).for_each(|(x, &ddt)| *x = *x * dt + v * ddt);
            }
            after.displacement.set(&own, &velocities, directions);
        }
        after
    }
}

/// The numbers of a pose, the first ones of a target.
const POSE: usize = 12;

/// The arguments of a step in lanes.
struct Given<'a, S> {
    numbers: &'a [S],
    lengths: &'a [usize],
    lanes: usize,
}

impl<S: Number> Given<'_, S> {
    /// Returns the rows of an array.
    fn rows(&self, array: usize) -> &[S] {
        let first: usize = self.lengths[..array].iter().sum();
        &self.numbers[first * self.lanes..][..self.lengths[array] * self.lanes]
    }

    /// Returns the numbers of an array in a lane.
    fn lane(&self, array: usize, lane: usize) -> Vec<S> {
        lane_of(self.rows(array), lane, self.lanes)
    }

    /// Returns the arguments of the contact problem: those of the step without impulses and
    /// residual.
    fn of_problem(&self) -> Vec<S> {
        let count = |lengths: &[usize]| lengths.iter().sum::<usize>() * self.lanes;
        let state = count(&self.lengths[..CONTACTS]);
        let all = count(self.lengths);
        [&self.numbers[..state], &self.numbers[count(&self.lengths[..STATE])..all]].concat()
    }

    /// Returns the coordinates, the time step and the settings of a lane.
    fn before(&self, lane: usize) -> (Vec<S>, S, ConstraintSettings<S, Vec<ContactTarget<S>>>) {
        let numbers = self.lane(SETTINGS, lane);
        let (first, contacts) = numbers.split_at(4);
        let contacts = contacts.as_chunks::<25>().0.iter();
        let contacts = contacts.map(|numbers| ContactTarget::from_numbers(*numbers)).collect();
        let first = [first[0], first[1], first[2], first[3]];
        let settings = ConstraintSettings::from_numbers(first, contacts);
        (self.lane(Q, lane), self.rows(DT)[lane], settings)
    }
}

/// Returns the numbers of a lane.
fn lane_of<S: Copy>(rows: &[S], lane: usize, lanes: usize) -> Vec<S> {
    rows.chunks_exact(lanes).map(|row| row[lane]).collect()
}

/// Returns the same numbers in each of the lanes.
fn in_lanes<S: Copy>(numbers: &[S], lanes: usize) -> Vec<S> {
    numbers.iter().flat_map(|&x| std::iter::repeat_n(x, lanes)).collect()
}
