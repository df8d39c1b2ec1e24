//! The generated code gives the interpreter's results.

use std::iter::zip;

use modyn_fleet::ROBOTS;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Friction, JointDynamics, Model, ModuleTree};
use modyn_tests::close::{assert_close, difference};
use modyn_tests::compiled::{Compiled, Own};
use modyn_tests::dense::{identity, square, times};
use modyn_tests::fleet::{Division, Source};
use modyn_tests::random::state;
use modyn_tests::values::{Inputs, Values, double, interpreted, pairs};

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
    fn inputs<T: modyn_runtime::Scalar>(&self) -> impl Iterator<Item = Inputs<T>> {
        (0..STATES).map(|seed| Inputs::from(&state(seed, &self.model)))
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
    let links = |subject: &Subject| subject.model.links().len();
    assert_eq!(random.iter().map(links).min(), Some(1));
    assert_eq!(random.iter().map(links).max(), Some(30));
    for joint_type in [JointType::Revolute, JointType::Continuous, JointType::Prismatic] {
        let is_so =
            |s: &&Subject| s.model.links().iter().any(|link| link.joint.joint_type == joint_type);
        assert!(random.iter().filter(is_so).count() >= 8, "{joint_type:?}");
    }
    let count = |is_so: &dyn Fn(&Subject) -> bool| random.iter().filter(|s| is_so(s)).count();
    assert!(count(&|s| s.model.children().iter().any(|c| c.len() > 1)) >= 4, "branches");
    assert!(count(&|s| s.model.links().iter().filter(|l| l.parent.is_none()).count() > 1) >= 3);
    assert!(count(&|s| s.model.frames().len() > links(s) + 1) >= 4, "fixed links");
    assert!(count(&|s| s.modules != ModuleTree::links(&s.model)) >= 6, "modules of many links");
    assert!(count(&|s| s.modules != ModuleTree::chains(&s.model)) >= 6, "divided chains");
    assert!(count(&|s| matches!(s.robot.spec.division, Division::List(_))) >= 4, "lists");
    assert!(count(&|s| matches!(s.robot.own, Own::Single(_))) >= 4, "single precision");

    let all: Vec<Subject> = subjects().filter(|s| s.robot.spec.all).collect();
    for joint_type in JointType::ALL {
        let is_so = |s: &Subject| s.model.links().iter().any(|l| l.joint.joint_type == joint_type);
        assert!(all.iter().any(is_so), "{joint_type:?}");
    }
    let count = |is_so: &dyn Fn(&Subject) -> bool| all.iter().filter(|s| is_so(s)).count();
    let has = |s: &Subject, is_so: fn(&JointDynamics) -> bool| {
        s.model.links().iter().any(|link| is_so(&link.joint.dynamics))
    };
    assert!(count(&|s| s.model.has_mimics()) >= 3, "mimics");
    assert!(count(&|s| has(s, |dynamics| dynamics.armature > 0.0)) >= 3, "rotors");
    assert!(count(&|s| s.model.friction() == Friction::Coulomb) >= 1, "Coulomb friction");
    assert!(count(&|s| matches!(s.model.friction(), Friction::Smooth(_))) >= 2, "friction");
    assert!(count(&|s| s.robot.spec.floating) >= 1, "floating bases");
    assert!(count(&|s| matches!(s.robot.own, Own::Single(_))) >= 1, "single precision");
}

#[test]
fn every_quantity_is_the_interpreters() {
    for subject in subjects() {
        let Subject { robot, model, modules } = &subject;
        for inputs in subject.inputs() {
            let found = (robot.double)(&inputs);
            let expected = interpreted(model, modules, &inputs, robot.spec.all);
            for (quantity, found, expected) in pairs(&found, &expected) {
                let what = format!("{}: {quantity}", robot.name());
                assert_close(&what, &found, &expected, TOLERANCE);
            }
        }
    }
}

#[test]
fn condition_numbers_are_the_interpreters() {
    for subject in subjects() {
        let Subject { robot, model, modules } = &subject;
        for inputs in subject.inputs() {
            let found = (robot.double)(&inputs).factors;
            let expected =
                interpreted(model, modules, &inputs, robot.spec.all).factors.condition_numbers;
            assert_eq!(found.condition_numbers.len(), modules.modules().len(), "{}", robot.name());
            assert_eq!(expected.len(), modules.modules().len(), "{}", robot.name());
            for (m, (&found, &expected)) in zip(&found.condition_numbers, &expected).enumerate() {
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
        }
    }
}

#[test]
fn factors_are_the_mass_matrix() {
    for subject in subjects() {
        let name = subject.robot.name();
        for inputs in subject.inputs() {
            let values = (subject.robot.double)(&inputs);
            let factors = &values.factors;
            let [u, d, m] = [&factors.u, &factors.d, &values.mass_matrix].map(|x| square(x));
            let product = &u * &d * u.transpose();
            assert_close(&name, product.as_slice(), m.as_slice(), TOLERANCE);
            let n = inputs.qd.len();
            let unit = identity(n);
            let inverse = square(&factors.u_inverse) * &u;
            assert_close(&name, inverse.as_slice(), &unit, 1e-9);
            // D consists of the pivot blocks; all other entries are zero.
            let mut blocks = vec![0.0; unit.len()];
            for (module, block) in zip(subject.robot.consts[0].modules, &factors.pivot_blocks) {
                let size = module.dofs;
                assert_eq!(block.len(), size * size, "{name}");
                for (k, &entry) in block.iter().enumerate() {
                    let (column, row) = (module.first + k / size, module.first + k % size);
                    blocks[column * n + row] = entry;
                }
            }
            assert_eq!(blocks, factors.d, "{name}");
        }
    }
}

#[test]
fn a_types_own_functions_are_the_traits() {
    for subject in subjects() {
        let (robot, name) = (subject.robot, subject.robot.name());
        match robot.own {
            Own::Double(own) => {
                let same = |inputs: Inputs<f64>| own(&inputs) == (robot.double)(&inputs);
                assert!(subject.inputs().all(same), "{name}");
            }
            Own::Single(own) => {
                let same = |inputs: Inputs<f32>| own(&inputs) == (robot.single)(&inputs);
                assert!(subject.inputs().all(same), "{name}");
            }
        }
    }
}

/// Where no equations are solved, single precision equals double precision up to rounding.
#[test]
fn single_precision_is_near_double_precision() {
    for subject in subjects() {
        for inputs in subject.inputs::<f32>() {
            let (single, exact) = both(subject.robot, &inputs);
            for (quantity, found, expected) in pairs(&single, &exact) {
                if SOLVED.contains(&quantity) {
                    continue;
                }
                let what = format!("{}: {quantity}", subject.robot.name());
                assert_close(&what, &double(&found), &expected, SINGLE);
            }
        }
    }
}

/// The quantities that depend on an inverse, and so on the condition number of the mass matrix.
const SOLVED: [&str; 15] = [
    "forward_dynamics",
    "forward_dynamics_external",
    "forward_dynamics_external_world",
    "forward_dynamics_derivatives.qdd",
    "forward_dynamics_derivatives.dq",
    "forward_dynamics_derivatives.dqd",
    "forward_dynamics_derivatives.dtau",
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
    for subject in subjects() {
        let name = subject.robot.name();
        for inputs in subject.inputs::<f32>() {
            let (single, exact) = both(subject.robot, &inputs);
            let m = &exact.mass_matrix;
            let norm = square(m).norm();
            let residual = |what: &str, x: &[f64], rhs: &[f64]| {
                let scale = norm * x.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
                let scale = rhs.iter().fold(scale, |a, x| a.max(x.abs()));
                let off = difference(&times(m, x), rhs)
                    * rhs.iter().fold(1.0, |a: f64, x| a.max(x.abs()))
                    / scale;
                assert!(off <= SINGLE, "{name}: {what} is off by {off:e}");
            };
            let tau = double(&inputs.tau);
            residual("solve", &double(&single.factors.solve), &tau);
            let excess: Vec<f64> =
                zip(&tau, &exact.bias_forces).map(|(tau, bias)| tau - bias).collect();
            residual("forward dynamics", &double(&single.forward_dynamics), &excess);
            let [u, d] = [&single.factors.u, &single.factors.d].map(|x| square(&double(x)));
            let product = &u * &d * u.transpose();
            let off = (product - square(m)).norm() / norm;
            assert!(off <= SINGLE, "{name}: U D U^T is off by {off:e}");

            let condition = condition(m);
            if condition > 1e3 {
                continue;
            }
            well_conditioned += 1;
            for (quantity, found, expected) in pairs(&single, &exact) {
                let what = format!("{name}: {quantity}");
                assert_close(&what, &double(&found), &expected, 1e-6 * condition.max(20.0));
            }
        }
    }
    assert!(
        well_conditioned >= if cfg!(feature = "whole") { 30 } else { 20 },
        "{well_conditioned}"
    );
}

fn both(robot: &Compiled, inputs: &Inputs<f32>) -> (Values<f32>, Values<f64>) {
    ((robot.single)(inputs), (robot.double)(&inputs.double()))
}
