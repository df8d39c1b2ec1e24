//! NaN in an argument reaches the results that depend on it: in every function of the table, by the interpreter.

use modyn_runtime::Interpreter;
use modyn_runtime::model::{Contact, ContactKind, LoopConstraintEnd, Model};
use modyn_runtime::quantities::{ArgumentKind, Function, Sizes};
use modyn_runtime::spatial::Pose;
use modyn_tests::arguments::{arguments, interpreted};
use modyn_tests::random::{State, general_zoo, state};

/// Returns the results with number `k` of argument `at` in place of the argument's.
fn with(
    robot: &mut Interpreter<f64>,
    function: Function,
    given: &[Vec<f64>],
    ((at, k), number): ((usize, usize), f64),
) -> Vec<f64> {
    let mut given = given.to_vec();
    given[at][k] = number;
    interpreted(robot, function, &given)
}

/// Checks a function: a number whose change changes results makes some of them NaN where it is NaN. Returns how many numbers do.
fn check(model: &Model, function: Function, state: &State) -> usize {
    let mut robot = Interpreter::new(model.clone());
    let given = arguments(function, model, state);
    let before = interpreted(&mut robot, function, &given);
    let mut effective = 0;
    for (at, own) in function.row().arguments.iter().enumerate() {
        // A set has members, and no numbers.
        if own.kind == ArgumentKind::ActiveContacts {
            continue;
        }
        for k in 0..given[at].len() {
            // The tolerance and the rounding choose rows, and enter no sum; `ConstraintSettings::check` refuses NaN.
            if own.kind == ArgumentKind::Settings && (2..4).contains(&k) {
                continue;
            }
            // The tolerance of steps decides when the solver ends.
            if own.kind == ArgumentKind::StepSettings && k == 0 {
                continue;
            }
            let number = given[at][k];
            let change = 1e-2 + 1e-2 * number.abs();
            let moved = with(&mut robot, function, &given, ((at, k), number + change));
            if moved == before {
                continue;
            }
            effective += 1;
            let found = with(&mut robot, function, &given, ((at, k), f64::NAN));
            assert!(
                found.iter().any(|x| x.is_nan()),
                "{}: `{}`: {}[{k}] is NaN, and no result is: {found:?}",
                model.name(),
                function.name(),
                own.name
            );
        }
    }
    effective
}

/// Returns a random mechanism with all joint types, a point and a sole in contact.
fn touching(seed: u64) -> Model {
    let model = general_zoo(seed, 3);
    let contact = |(frame, kind)| Contact {
        name: format!("contact{frame}"),
        kind,
        end: LoopConstraintEnd { link: frame, pose: Pose::identity() },
    };
    let kinds = [(1, ContactKind::Point), (2, ContactKind::Surface)];
    model.with_contacts(kinds.map(contact).to_vec()).expect("two links")
}

#[test]
fn nan_reaches_the_results_of_every_function() {
    let mut without = Vec::new();
    for &function in Function::ALL {
        let has_arguments = !function.row().arguments.is_empty();
        if function.batched().is_none() && has_arguments && function != Function::Brge {
            let model = touching(3);
            // Actuators have tests of their own.
            if !function.fits(&Sizes::new(&model, 0)) {
                continue;
            }
            if check(&model, function, &state(5, &model)) == 0 {
                without.push(function.name());
            }
        }
    }
    assert_eq!(without, [""; 0], "no number of these functions has an effect");
}
