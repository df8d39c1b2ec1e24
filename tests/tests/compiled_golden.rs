//! Compiled robots against figures from other software, on a fixed base.

use std::iter::zip;

use modyn_tests::close::assert_close;
use modyn_tests::compiled::{Compiled, ROBOTS};
use modyn_tests::fleet::Source;
use modyn_tests::golden::{FIXED_BASE, Golden, Quantities};
use modyn_tests::values::{Inputs, Values};

/// Of the reference data's README.
const TOLERANCE: f64 = 1e-9;

/// Runs `check` at every state of every robot.
fn everywhere(check: impl Fn(&str, &Compiled, &Quantities, &Values<f64>)) {
    let mut states = 0;
    for name in FIXED_BASE {
        let robot = ROBOTS.iter().find(|robot| robot.spec.source == Source::Golden(name));
        let robot = robot.unwrap_or_else(|| panic!("{name} is not compiled"));
        for state in Golden::load(name).states {
            let vector = |name| state.vector(name);
            let inputs =
                Inputs { q: state.q(), qd: vector("v"), qdd: vector("a"), tau: vector("tau") };
            check(name, robot, &state, &(robot.double)(&inputs));
            states += 1;
        }
    }
    assert_eq!(states, 47, "the states of all robots");
}

#[test]
fn forward_dynamics() {
    everywhere(|name, _, state, values| {
        assert_close(name, &values.forward_dynamics, &state.vector("qdd"), TOLERANCE);
    });
}

#[test]
fn inverse_dynamics() {
    everywhere(|name, _, state, values| {
        assert_close(name, &values.inverse_dynamics, &state.vector("tau_rnea"), TOLERANCE);
    });
}

#[test]
fn bias_forces_and_gravity_torques() {
    everywhere(|name, _, state, values| {
        assert_close(name, &values.bias_forces, &state.vector("nle"), TOLERANCE);
        assert_close(name, &values.gravity_torques, &state.vector("gravity_tau"), TOLERANCE);
    });
}

#[test]
fn mass_matrix() {
    everywhere(|name, _, state, values| {
        assert_close(name, &values.mass_matrix, state.matrix("M").as_slice(), TOLERANCE);
    });
}

#[test]
fn energies() {
    everywhere(|name, _, state, values| {
        let expected = state.number("kinetic_energy");
        assert_close(name, &[values.kinetic_energy], &[expected], TOLERANCE);
        let expected = state.number("potential_energy");
        assert_close(name, &[values.potential_energy], &[expected], TOLERANCE);
    });
}

#[test]
fn frame_placements() {
    everywhere(|name, robot, state, values| {
        let links = robot.consts[0].link_names;
        assert_eq!(values.link_poses.len(), 12 * links.len(), "{name}");
        let frames = state.frames();
        assert!(!frames.is_empty(), "{name}");
        for expected in frames {
            let at = links.iter().position(|&link| link == expected.name);
            let at = at.unwrap_or_else(|| panic!("{name}: no link `{}`", expected.name));
            let found = &values.link_poses[12 * at..12 * (at + 1)];
            // The rotation and the translation have scales of their own.
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
        let inputs = Inputs { q: state.q(), qd: rest.clone(), qdd: rest, tau: excess };
        let factors = (robot.double)(&inputs).factors;
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
