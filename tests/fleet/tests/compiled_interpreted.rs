//! The generated code gives the interpreter's results.

use std::iter::zip;

use modyn_fleet::ROBOTS;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{JointDynamics, JointFriction, Model, ModuleTree};
use modyn_runtime::quantities::{Function, Sizes};
use modyn_tests::close::{assert_close, difference};
use modyn_tests::compiled::{Compiled, Own};
use modyn_tests::dense::{identity, square, times};
use modyn_tests::fleet::{Division, Source};
use modyn_tests::random::{State, state};
use modyn_tests::values::{Values, double, interpreted, of_single_state, of_state, pairs};

/// The tolerance. Constant folding, the normalization of signs and factored products change the rounding; nothing else
/// differs.
const TOLERANCE: f64 = 1e-11;

/// The relative tolerance of single precision after many steps.
const SINGLE: f64 = 2e-5;

const STATES: u64 = 4;

struct Subject {
    robot: &'static Compiled,
    model: Model,
    modules: ModuleTree,
}

impl Subject {
    fn states(&self) -> impl Iterator<Item = State> {
        (0..STATES).map(|seed| state(seed, &self.model))
    }

    fn sizes(&self) -> Sizes {
        Sizes::new(&self.model, 0)
    }
}

fn subjects() -> impl Iterator<Item = Subject> {
    ROBOTS.iter().map(|robot| {
        let model = robot.spec.model();
        let modules = robot.spec.modules(&model);
        Subject { robot, model, modules }
    })
}

/// Returns the condition number of a symmetric positive definite matrix, which may be empty.
fn condition(columns: &[f64]) -> f64 {
    if columns.is_empty() {
        return 1.0;
    }
    let eigenvalues = square(columns).symmetric_eigenvalues();
    eigenvalues.max() / eigenvalues.min()
}

#[test]
#[cfg_attr(not(feature = "whole"), ignore = "of the whole fleet")]
fn the_fleet_is_various() {
    let is_random = |source| matches!(source, Source::Random(..) | Source::Zoo(..));
    let random: Vec<Subject> = subjects().filter(|s| is_random(s.robot.spec.source)).collect();
    assert!(random.len() >= 16);
    let links = |subject: &Subject| subject.model.moving_links().len();
    assert_eq!(random.iter().map(links).min(), Some(1));
    assert_eq!(random.iter().map(links).max(), Some(30));
    for joint_type in [JointType::Revolute, JointType::Continuous, JointType::Prismatic] {
        let is_so = |s: &&Subject| {
            s.model.moving_links().iter().any(|link| link.joint.joint_type == joint_type)
        };
        assert!(random.iter().filter(is_so).count() >= 8, "{joint_type:?}");
    }
    let count = |is_so: &dyn Fn(&Subject) -> bool| random.iter().filter(|s| is_so(s)).count();
    assert!(count(&|s| s.model.children().iter().any(|c| c.len() > 1)) >= 4, "branches");
    assert!(
        count(&|s| s.model.moving_links().iter().filter(|l| l.parent.is_none()).count() > 1) >= 3
    );
    assert!(count(&|s| s.model.links().len() > links(s) + 1) >= 4, "fixed links");
    assert!(count(&|s| s.modules != ModuleTree::links(&s.model)) >= 6, "modules of many links");
    assert!(count(&|s| s.modules != ModuleTree::chains(&s.model)) >= 6, "divided chains");
    assert!(count(&|s| matches!(s.robot.spec.division, Division::List(_))) >= 4, "lists");
    assert!(count(&|s| matches!(s.robot.own, Own::Single(_))) >= 4, "single precision");

    let all: Vec<Subject> = subjects().filter(|s| s.robot.spec.all).collect();
    for joint_type in JointType::ALL {
        let is_so =
            |s: &Subject| s.model.moving_links().iter().any(|l| l.joint.joint_type == joint_type);
        assert!(all.iter().any(is_so), "{joint_type:?}");
    }
    let count = |is_so: &dyn Fn(&Subject) -> bool| all.iter().filter(|s| is_so(s)).count();
    let has = |s: &Subject, is_so: fn(&JointDynamics) -> bool| {
        s.model.moving_links().iter().any(|link| is_so(&link.joint.dynamics))
    };
    assert!(count(&|s| s.model.has_mimics()) >= 3, "mimics");
    assert!(count(&|s| has(s, |dynamics| dynamics.armature > 0.0)) >= 3, "rotors");
    assert!(
        count(&|s| s.model.joint_friction() == JointFriction::Coulomb) >= 1,
        "Coulomb friction"
    );
    assert!(
        count(&|s| matches!(s.model.joint_friction(), JointFriction::Smooth(_))) >= 2,
        "friction"
    );
    assert!(count(&|s| s.robot.spec.floating) >= 1, "floating bases");
    assert!(count(&|s| matches!(s.robot.own, Own::Single(_))) >= 1, "single precision");
}

/// Calls `check` with the results of each robot in each state, and the interpreter's results.
fn everywhere(check: impl Fn(&Subject, &Values<f64>, &Values<f64>)) {
    for subject in subjects() {
        let Subject { robot, model, modules } = &subject;
        for state in subject.states() {
            let arguments = of_state(model, &state);
            let expected = interpreted(model, modules, &arguments, robot.spec.all);
            check(&subject, &(robot.double)(&arguments), &expected);
        }
    }
}

#[test]
fn every_quantity_is_the_interpreters() {
    everywhere(|subject, found, expected| {
        for (quantity, found, expected) in pairs(found, expected, &subject.sizes()) {
            let what = format!("{}: {quantity}", subject.robot.name());
            assert_close(&what, &found, &expected, TOLERANCE);
        }
    });
}

#[test]
fn condition_numbers_are_the_interpreters() {
    everywhere(|Subject { robot, modules, .. }, found, expected| {
        let (found, expected) = (&found.factors, &expected.factors.condition_numbers);
        assert_eq!(found.condition_numbers.len(), modules.modules().len(), "{}", robot.name());
        assert_eq!(expected.len(), modules.modules().len(), "{}", robot.name());
        for (m, (&found, &expected)) in zip(&found.condition_numbers, expected).enumerate() {
            // Rounding changes the smallest eigenvalue by the largest eigenvalue times epsilon.
            let tolerance = 1e-13 * expected;
            let relative = (found - expected).abs() / expected;
            assert!(
                expected >= 1.0 && relative <= tolerance.max(TOLERANCE),
                "{}, module {m}: {found:e}, not {expected:e}",
                robot.name()
            );
        }
        // The condition numbers equal those of the pivot blocks.
        for (block, &found) in zip(&found.pivot_blocks, &found.condition_numbers) {
            let expected = condition(block);
            let relative = (found - expected).abs() / expected;
            assert!(relative <= 1e-9 + 1e-13 * expected, "{}: {found:e}", robot.name());
        }
    });
}

#[test]
fn factors_are_the_mass_matrix() {
    everywhere(|Subject { robot, model, .. }, values, _| {
        let (name, factors) = (robot.name(), &values.factors);
        let mass_matrix = values.of(Function::MassMatrix);
        let [u, d, m] = [&factors.u, &factors.d, mass_matrix].map(square);
        let product = &u * &d * u.transpose();
        assert_close(&name, product.as_slice(), m.as_slice(), TOLERANCE);
        let n = model.nv();
        let unit = identity(n);
        let inverse = square(&factors.u_inverse) * &u;
        assert_close(&name, inverse.as_slice(), &unit, 1e-9);
        // D consists of the pivot blocks; all other entries are zero.
        let mut blocks = vec![0.0; unit.len()];
        for (module, block) in zip(robot.consts[0].modules, &factors.pivot_blocks) {
            let size = module.dofs;
            assert_eq!(block.len(), size * size, "{name}");
            for (k, &entry) in block.iter().enumerate() {
                let (column, row) = (module.first + k / size, module.first + k % size);
                blocks[column * n + row] = entry;
            }
        }
        assert_eq!(blocks, factors.d, "{name}");
    });
}

#[test]
fn a_types_own_functions_are_the_traits() {
    for subject in subjects() {
        let robot = subject.robot;
        for state in subject.states() {
            let arguments = of_single_state(&subject.model, &state);
            let is_same = match robot.own {
                Own::Double(own) => own(&arguments) == (robot.double)(&arguments),
                Own::Single(own) => own(&arguments) == (robot.single)(&arguments),
            };
            assert!(is_same, "{}", robot.name());
        }
    }
}

/// Calls `check` with the results of each robot in each state in single and in double precision.
fn in_both_precisions(mut check: impl FnMut(&Subject, &State, &Values<f32>, &Values<f64>)) {
    for subject in subjects() {
        for state in subject.states() {
            let arguments = of_single_state(&subject.model, &state);
            let (single, double) = (subject.robot.single, subject.robot.double);
            check(&subject, &state, &single(&arguments), &double(&arguments));
        }
    }
}

/// Returns whether a result says how a solver ended, which is another way in single precision.
fn is_of_solver(quantity: &str) -> bool {
    [".residual", ".iterations"].iter().any(|end| quantity.ends_with(end))
}

/// Where no equations are solved, single precision equals double precision up to rounding.
#[test]
fn single_precision_is_near_double_precision() {
    in_both_precisions(|subject, _, single, exact| {
        let condition = condition(exact.of(Function::MassMatrix));
        for (quantity, found, expected) in pairs(single, exact, &subject.sizes()) {
            let function = quantity.split('.').next().unwrap_or_default();
            if SOLVED.contains(&function) || is_of_solver(&quantity) {
                continue;
            }
            let name = subject.robot.name();
            let what = format!("{name} of condition number {condition:e}: {quantity}");
            assert_close(&what, &double(&found), &expected, SINGLE);
        }
    });
}

/// The quantities that depend on an inverse, and so on the condition number of the mass matrix.
const SOLVED: [&str; 18] = [
    "step",
    "step_derivatives",
    "forward_dynamics",
    "forward_dynamics_external_local",
    "forward_dynamics_external",
    "forward_dynamics_derivatives",
    "forward_dynamics_hessian",
    "forward_dynamics_jvp",
    "forward_dynamics_vjp",
    "brge",
    "u",
    "d",
    "pivot_block",
    "u_inverse",
    "d_inverse",
    "solve",
    "inverse",
    "log_determinant",
];

/// Solutions in single precision satisfy their equations at any condition number, and are near those in double
/// precision where the condition number is small.
#[test]
fn single_precision_solves() {
    let mut well_conditioned = 0;
    in_both_precisions(|subject, state, single, exact| {
        let name = subject.robot.name();
        let m = exact.of(Function::MassMatrix);
        let norm = square(m).norm();
        let residual = |what: &str, x: &[f32], rhs: &[f64]| {
            let x = double(x);
            let scale = norm * x.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
            let scale = rhs.iter().fold(scale, |a, x| a.max(x.abs()));
            let off = difference(&times(m, &x), rhs)
                * rhs.iter().fold(1.0, |a: f64, x| a.max(x.abs()))
                / scale;
            assert!(off <= SINGLE, "{name}: {what} is off by {off:e}");
        };
        let tau: Vec<f64> = state.tau.iter().map(|&x| f64::from(x as f32)).collect();
        residual("solve", &single.factors.solve, &tau);
        let bias = exact.of(Function::BiasForces);
        let excess: Vec<f64> = zip(&tau, bias).map(|(tau, bias)| tau - bias).collect();
        residual("forward dynamics", single.of(Function::ForwardDynamics), &excess);
        let [u, d] = [&single.factors.u, &single.factors.d].map(|x| square(&double(x)));
        let product = &u * &d * u.transpose();
        let off = (product - square(m)).norm() / norm;
        assert!(off <= SINGLE, "{name}: U D U^T is off by {off:e}");

        let condition = condition(m);
        if condition > 1e3 {
            return;
        }
        well_conditioned += 1;
        let quantities = pairs(single, exact, &subject.sizes());
        for (quantity, found, expected) in quantities.into_iter().filter(|x| !is_of_solver(&x.0)) {
            let what = format!("{name}: {quantity}");
            assert_close(&what, &double(&found), &expected, 1e-6 * condition.max(20.0));
        }
    });
    assert!(
        well_conditioned >= if cfg!(feature = "whole") { 30 } else { 20 },
        "{well_conditioned}"
    );
}
