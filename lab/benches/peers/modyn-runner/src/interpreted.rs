//! modyn's interpreter: one of the programs, and the reference for the results of all others.

use std::ops::Range;

use modyn::model::Model;
use modyn::quantities::{Function, Record, Shape};
use modyn::{ConstraintSettings, ContactTarget, Interpreter};

use crate::measure::Job;
use crate::{robots, states};

/// Returns settings without stabilization.
pub fn settings(contacts: usize) -> ConstraintSettings<f64, Vec<ContactTarget<f64>>> {
    let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
        ConstraintSettings::<f64>::EXACT;
    let targets = vec![ContactTarget::<f64>::EXACT; contacts];
    ConstraintSettings { alpha, beta, tolerance, rounding, targets }
}

/// A quantity of a robot, all of whose contacts are active.
pub struct Quantity {
    interpreter: Interpreter<f64>,
    function: Function,
    /// The active contacts and the settings, as numbers.
    active: Vec<f64>,
    settings: Vec<f64>,
    /// All numbers of the result.
    result: Vec<f64>,
    /// The places of the numbers that all programs compute: the result that is one array, or the
    /// accelerations and their derivatives.
    compared: Vec<Range<usize>>,
}

impl Quantity {
    /// Returns the quantity of this name.
    pub fn new(model: Model, name: &str) -> Self {
        let interpreter = Interpreter::<f64>::new(model);
        let function = *Function::ALL.iter().find(|one| one.name() == name).expect("a quantity");
        let shape = (function.row().result)(&interpreter.sizes());
        let count = interpreter.model().contacts().len();
        let settings = settings(count);
        let targets = settings.targets.iter().flat_map(ContactTarget::numbers);
        Self {
            compared: compared(&shape),
            result: vec![0.0; shape.len()],
            active: vec![1.0; count],
            settings: settings.numbers().into_iter().chain(targets).collect(),
            interpreter,
            function,
        }
    }

    /// Computes the quantity at q, qd, tau, qdd; matrices by columns.
    pub fn compute(&mut self, [q, qd, tau, qdd]: [&[f64]; 4]) -> impl Iterator<Item = f64> {
        let numbers = |name: &str| match name {
            "q" => q,
            "qd" => qd,
            "tau" => tau,
            "qdd" => qdd,
            "active" => &self.active,
            _ => &self.settings,
        };
        let row = self.function.row();
        let arguments: Vec<&[f64]> =
            row.arguments.iter().map(|argument| numbers(argument.name)).collect();
        self.interpreter.evaluate(self.function, &arguments, 0, &mut self.result).expect("sizes");
        self.compared.iter().flat_map(|range| self.result[range.clone()].iter().copied())
    }
}

/// Returns the places of the numbers that all programs compute.
fn compared(shape: &Shape) -> Vec<Range<usize>> {
    let Shape::Record(Record::ResultsByType(_) | Record::ResultsByField(_), fields) = shape else {
        return vec![0..shape.len()];
    };
    let mut next = 0;
    let ranges = fields.iter().map(|(name, field)| {
        next += field.len();
        (*name, next - field.len()..next)
    });
    ranges
        .filter(|(name, _)| ["qdd", "dqdd_dq", "dqdd_dqd", "dqdd_dtau"].contains(name))
        .map(|(_, range)| range)
        .collect()
}

/// Measures the interpreter.
pub fn measure(job: &Job) {
    let robots = robots::all();
    let robot = robots.iter().find(|robot| robot.name == job.robot).expect("a robot");
    let mut quantity = Quantity::new(states::model(robot), &job.quantity);
    let states: Vec<[Vec<f64>; 4]> = job.states();
    let mut results = |state: &[Vec<f64>; 4]| -> Vec<f64> {
        quantity.compute(state.each_ref().map(Vec::as_slice)).collect()
    };
    job.check(states.iter().map(&mut results));
    job.time(&states, |state| {
        std::hint::black_box(results(state));
    });
}
