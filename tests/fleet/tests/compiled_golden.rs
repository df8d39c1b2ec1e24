//! Compiled robots compared with reference data of other software.

use std::collections::BTreeSet;
use std::iter::zip;

use modyn_fleet::ROBOTS;
use modyn_runtime::quantities::{Function, Sizes};
use modyn_tests::close::assert_close;
use modyn_tests::compiled::{Compiled, Consts};
use modyn_tests::fleet::Source;
use modyn_tests::golden::{FIXED_BASE, FLOATING_BASE, Golden, Quantities};
use modyn_tests::random::State;
use modyn_tests::values::{Values, fields, of_state};

/// The tolerance that the reference data's README gives.
const TOLERANCE: f64 = 1e-9;

/// Runs `check` at every state of every robot.
fn everywhere(check: impl Fn(&str, &Compiled, &Quantities, &Values<f64>)) {
    let mut found = BTreeSet::new();
    for robot in ROBOTS.iter() {
        let Source::Golden(name) = robot.spec.source else { continue };
        let name = if robot.spec.floating { format!("{name}_ff") } else { name.into() };
        // Not every robot that floats here has such data.
        if robot.spec.floating && !FLOATING_BASE.contains(&&*name) {
            continue;
        }
        let model = robot.spec.model();
        for state in Golden::load(&name).states {
            let vector = |name| state.vector(name);
            let inputs =
                State { q: state.q(), qd: vector("v"), qdd: vector("a"), tau: vector("tau") };
            check(&robot.name(), robot, &state, &(robot.double)(&of_state(&model, &inputs)));
        }
        found.insert(name);
    }
    if cfg!(feature = "whole") {
        let expected = FIXED_BASE.into_iter().chain(FLOATING_BASE).map(String::from);
        assert_eq!(found, expected.collect());
    } else {
        assert!(found.len() >= 6, "{found:?}");
    }
}

#[test]
fn forward_dynamics() {
    everywhere(|name, _, state, values| {
        assert_close(name, values.of(Function::ForwardDynamics), &state.vector("qdd"), TOLERANCE);
    });
}

#[test]
fn inverse_dynamics() {
    everywhere(|name, _, state, values| {
        assert_close(
            name,
            values.of(Function::InverseDynamics),
            &state.vector("tau_rnea"),
            TOLERANCE,
        );
    });
}

#[test]
fn bias_forces_and_gravity_torques() {
    everywhere(|name, _, state, values| {
        assert_close(name, values.of(Function::BiasForces), &state.vector("nle"), TOLERANCE);
        assert_close(
            name,
            values.of(Function::GravityTorques),
            &state.vector("gravity_tau"),
            TOLERANCE,
        );
    });
}

#[test]
fn mass_matrix() {
    everywhere(|name, _, state, values| {
        assert_close(
            name,
            values.of(Function::MassMatrix),
            state.matrix("M").as_slice(),
            TOLERANCE,
        );
    });
}

#[test]
fn energies() {
    everywhere(|name, _, state, values| {
        let expected = state.number("kinetic_energy");
        assert_close(name, values.of(Function::KineticEnergy), &[expected], TOLERANCE);
        let expected = state.number("potential_energy");
        assert_close(name, values.of(Function::PotentialEnergy), &[expected], TOLERANCE);
    });
}

#[test]
fn frame_placements() {
    everywhere(|name, robot, state, values| {
        let links = robot.consts[0].link_names;
        let poses = values.of(Function::LinkPoses);
        assert_eq!(poses.len(), 12 * links.len(), "{name}");
        let frames = state.frames();
        assert!(!frames.is_empty(), "{name}");
        for expected in frames {
            let at = links.iter().position(|&link| link == expected.name);
            let at = at.unwrap_or_else(|| panic!("{name}: no link `{}`", expected.name));
            let found = &poses[12 * at..12 * (at + 1)];
            // The rotation and the translation have different scales.
            assert_close(&expected.name, &found[..9], &expected.numbers[..9], TOLERANCE);
            assert_close(&expected.name, &found[9..], &expected.numbers[9..], TOLERANCE);
        }
    });
}

#[test]
fn factorization_inverts_and_solves() {
    everywhere(|name, robot, state, values| {
        let expected = state.matrix("dqdd_dtau");
        assert_close(name, &values.factors.inverse, expected.as_slice(), TOLERANCE);
        let excess: Vec<f64> =
            zip(state.vector("tau"), state.vector("nle")).map(|(tau, bias)| tau - bias).collect();
        let rest = vec![0.0; excess.len()];
        let inputs = State { q: state.q(), qd: rest.clone(), qdd: rest, tau: excess };
        let factors = (robot.double)(&of_state(&robot.spec.model(), &inputs)).factors;
        assert_close(name, &factors.solve, &state.vector("qdd"), TOLERANCE);
    });
}

#[test]
fn factorization_has_the_determinant() {
    everywhere(|name, _, state, values| {
        let factor = state.matrix("M").cholesky().expect("a positive definite matrix");
        let expected: f64 = factor.l().diagonal().iter().map(|x| 2.0 * x.ln()).sum();
        assert_close(name, &[values.factors.log_determinant], &[expected], TOLERANCE);
    });
}

#[test]
fn center_of_mass() {
    everywhere(|name, _, state, values| {
        assert_close(name, values.of(Function::CenterOfMass), &state.position("com"), TOLERANCE);
    });
}

#[test]
fn centroidal_momentum_and_regressor() {
    let mut compared = [0, 0];
    let counts = std::cell::RefCell::new(&mut compared);
    everywhere(|name, robot, state, values| {
        if !robot.spec.all {
            return;
        }
        let momentum = state.centroidal_momentum();
        assert_close(name, values.of(Function::CentroidalMomentum), &momentum, TOLERANCE);
        let matrix = state.centroidal_momentum_matrix();
        let found = values.of(Function::CentroidalMomentumMatrix);
        assert_close(name, found, matrix.as_slice(), TOLERANCE);
        counts.borrow_mut()[0] += 1;
        if let Some(regressor) = state.regressor() {
            assert_close(name, values.of(Function::Regressor), regressor.as_slice(), TOLERANCE);
            counts.borrow_mut()[1] += 1;
        }
    });
    assert!(compared.iter().all(|&states| states > 0), "{compared:?}");
}

#[test]
fn jacobians() {
    everywhere(|name, robot, state, values| {
        let Consts { link_names, nv, .. } = robot.consts[0];
        for expected in state.frames() {
            let at = link_names.iter().position(|&link| link == expected.name);
            let at = at.unwrap_or_else(|| panic!("{name}: no link `{}`", expected.name));
            let found = &values.of(Function::Jacobian)[6 * nv * at..6 * nv * (at + 1)];
            for (column, found) in found.chunks(6).enumerate() {
                let column = expected.jacobian.column(column);
                let column: Vec<f64> = column.iter().copied().collect();
                assert_close(&expected.name, found, &column, TOLERANCE);
            }
        }
    });
}

#[test]
fn derivatives() {
    everywhere(|name, robot, state, values| {
        if !robot.spec.all {
            return;
        }
        let sizes = Sizes::new(&robot.spec.model(), 0);
        let of = |function| {
            let all = fields(function, &sizes, values.of(function));
            all.into_iter().map(|(_, numbers)| numbers)
        };
        let found = of(Function::InverseDynamicsDerivatives)
            .chain(of(Function::ForwardDynamicsDerivatives).skip(1));
        let names = ["dtau_dq", "dtau_dv", "dqdd_dq", "dqdd_dv", "dqdd_dtau"];
        for (found, expected) in zip(found, names) {
            let what = format!("{name}: {expected}");
            assert_close(&what, &found, state.matrix(expected).as_slice(), TOLERANCE);
        }
    });
}
