//! Arguments of every function of the table of quantities, and its results by the interpreter.

use modyn_runtime::model::Model;
use modyn_runtime::quantities::{Argument, ArgumentKind, Function, Sizes};
use modyn_runtime::{ConstraintSettings, ContactTarget, Interpreter, Scalar};

use crate::random::{Random, State};

/// Returns numbers for the arguments of a function: those of `state` where it has them, else random ones. All contacts
/// are active if the first velocity is positive, else every second one, with the default settings and a target at rest in
/// general position.
///
/// # Panics
///
/// If the state is not one of the model.
#[must_use]
pub fn arguments(function: Function, model: &Model, state: &State) -> Vec<Vec<f64>> {
    let sizes = Sizes::new(model, 0);
    let numbers = |Argument { name, kind }: &Argument, length: usize| -> Vec<f64> {
        let mut random = Random::new(
            name.bytes().fold(0, |seed: u64, byte| seed.wrapping_mul(31).wrapping_add(byte.into())),
        );
        let mut several =
            |from: f64, to: f64| (0..length).map(|_| random.between(from, to)).collect();
        match (*name, kind) {
            // Quaternions that are longer than 1.
            ("q", _) if function == Function::NormalizeConfiguration => {
                state.q.iter().map(|x| 2.0 * x).collect()
            }
            ("q" | "from", _) => state.q.clone(),
            ("qd", _) => state.qd.clone(),
            ("qdd", _) => state.qdd.clone(),
            ("tau", _) => state.tau.clone(),
            (_, ArgumentKind::Coordinates) => {
                let mut q = vec![0.0; length];
                let uniform = || random.between(0.0, 1.0);
                Interpreter::new(model.clone())
                    .random_configuration(uniform, &mut q)
                    .expect("nq numbers");
                q
            }
            (_, ArgumentKind::Time) => vec![1.0 / 128.0],
            (_, ArgumentKind::RandomNumbers) => several(0.0, 1.0),
            (_, ArgumentKind::ActiveContacts) => {
                let all = state.qd.first().is_some_and(|&first| first > 0.0);
                (0..length).map(|contact| f64::from(u8::from(all || contact % 2 == 0))).collect()
            }
            (_, ArgumentKind::Settings) => {
                let targets = (0..sizes.contacts).flat_map(|_| {
                    let target = ContactTarget::<f64>::GROUND;
                    let mut numbers = target.numbers();
                    numbers[9..18].fill_with(|| random.between(-0.1, 0.1));
                    numbers
                });
                let settings = ConstraintSettings::<f64>::DEFAULT.numbers();
                settings.into_iter().chain(targets).collect()
            }
            (_, ArgumentKind::StepSettings) => random.step_settings(sizes.touching_shapes),
            (_, ArgumentKind::Wrenches | ArgumentKind::ConstraintWrenches) => several(-4.0, 4.0),
            _ => several(-1.0, 1.0),
        }
    };
    let row = function.row();
    row.arguments.iter().map(|own| numbers(own, own.shape(&sizes).len())).collect()
}

/// Returns the results of a function by the interpreter; for a function of one link, those of all links, one after the other.
///
/// # Panics
///
/// If the arguments do not fit.
pub fn interpreted<T: Scalar>(
    robot: &mut Interpreter<T>,
    function: Function,
    arguments: &[Vec<T>],
) -> Vec<T> {
    let row = function.row();
    let links = if row.by_link { robot.model().links().len() } else { 1 };
    let arguments: Vec<&[T]> = arguments.iter().map(Vec::as_slice).collect();
    let length = (row.result)(&robot.sizes()).len();
    let of_link = |link| {
        let mut result = vec![T::zero(); length];
        robot.evaluate(function, &arguments, link, &mut result).expect("the lengths are right");
        result
    };
    (0..links).flat_map(of_link).collect()
}
