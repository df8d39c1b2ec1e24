//! What holds of every robot, whatever its figures.

use std::f64::consts::FRAC_PI_2;
use std::iter::zip;

use modyn_runtime::Interpreter;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_tests::cases::cases;
use modyn_tests::close::{assert_close, difference};
use modyn_tests::dense::{dense, dot, identity, square, times};
use modyn_tests::naive::Naive;
use modyn_tests::quantities::{Quantities, numbers};
use modyn_tests::random::{State, modules, state, tree};
use nalgebra::{DVector, Matrix3};
use proptest::prelude::*;

/// Entries of constant rotations are taken for 0, 1 or -1 within 1e-11, at each of 30 joints.
const SNAPPED: f64 = 1e-9;

/// A random robot on the interpreter, and a state of it.
fn robot(seed: u64, links: usize) -> (Interpreter<f64>, State) {
    let model = tree(seed, links);
    let state = state(seed, &model);
    (Interpreter::new(model), state)
}

/// Chains, single links, and something between.
fn partitions(seed: u64, model: &Model) -> [ModuleTree; 3] {
    [ModuleTree::chains(model), ModuleTree::links(model), modules(seed, model)]
}

/// `a` and that many times `b`.
fn plus(a: &[f64], factor: f64, b: &[f64]) -> Vec<f64> {
    zip(a, b).map(|(a, b)| a + factor * b).collect()
}

fn unit(n: usize, i: usize) -> Vec<f64> {
    (0..n).map(|j| if i == j { 1.0 } else { 0.0 }).collect()
}

/// The derivative of `f` at 0 by central differences, with the first error term removed.
fn derivative(mut f: impl FnMut(f64) -> f64) -> f64 {
    let h = 1e-3;
    let mut slope = |h: f64| (f(h) - f(-h)) / (2.0 * h);
    let (near, far) = (slope(h), slope(2.0 * h));
    near + (near - far) / 3.0
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn mass_matrix_is_symmetric_positive_definite(seed: u64, links in 1..=30usize) {
        let (mut interpreter, state) = robot(seed, links);
        let gim = square(&interpreter.gim(&state.q));
        prop_assert_eq!(&gim, &gim.transpose());
        prop_assert!(gim.cholesky().is_some());
    }

    #[test]
    fn mass_matrix_is_that_of_the_kinetic_energy(seed: u64, links in 1..=12usize) {
        let (mut interpreter, State { q, .. }) = robot(seed, links);
        let mut energy = |qd: &[f64]| interpreter.kinetic(&q, qd);
        // T is quadratic in the velocities, so these differences are exact.
        let mut columns = vec![0.0; links * links];
        for (i, column) in columns.chunks_mut(links).enumerate() {
            for (j, entry) in column.iter_mut().enumerate() {
                let (a, b) = (unit(links, i), unit(links, j));
                *entry = energy(&plus(&a, 1.0, &b)) - energy(&a) - energy(&b);
            }
        }
        assert_close("second differences", &columns, &interpreter.gim(&q), 1e-12);
    }

    #[test]
    fn factors_multiply_to_the_mass_matrix(seed: u64, links in 1..=30usize) {
        let (interpreter, State { q, .. }) = robot(seed, links);
        let model = interpreter.model().clone();
        for modules in partitions(seed, &model) {
            let mut interpreter = Interpreter::with_modules(model.clone(), modules).expect("its own modules");
            let (gim, brge) = (interpreter.gim(&q), interpreter.factors(&q));
            let (u, d) = (square(&brge.u()), square(&brge.d()));
            let product = &u * &d * u.transpose();
            assert_close("U D U^T", product.as_slice(), &gim, 1e-11);

            let unity = identity(links);
            let product = &u * square(&brge.u_inverse());
            let scale = u.amax().max(1.0) * square(&brge.u_inverse()).amax().max(1.0);
            assert_close("U U^-1", (product / scale).as_slice(), (square(&unity) / scale).as_slice(), 1e-11);
            let product = &d * square(&brge.d_inverse());
            assert_close("D D^-1", product.as_slice(), &unity, 1e-9);
        }
    }

    #[test]
    fn factors_have_the_modules_shape(seed: u64, links in 1..=30usize) {
        let (interpreter, State { q, .. }) = robot(seed, links);
        let model = interpreter.model().clone();
        for modules in partitions(seed, &model) {
            let interpreter = Interpreter::with_modules(model.clone(), modules.clone()).expect("its own modules");
            let brge = interpreter.factors(&q);
            let module_of = |i: usize| {
                modules.modules().iter().position(|m| m.links.contains(&i)).expect("a module")
            };
            let (u, d) = (square(&brge.u()), square(&brge.d()));
            for i in 0..links {
                for j in 0..links {
                    let (a, b) = (module_of(i), module_of(j));
                    if a == b {
                        prop_assert_eq!(u[(i, j)], f64::from(u8::from(i == j)));
                    } else {
                        prop_assert_eq!(d[(i, j)], 0.0);
                        if a > b {
                            prop_assert_eq!(u[(i, j)], 0.0);
                        }
                    }
                }
            }
            for (m, module) in modules.modules().iter().enumerate() {
                let (start, size) = (module.links.start, module.links.len());
                let expected = d.view((start, start), (size, size)).into_owned();
                let block = brge.pivot_block(m).expect("a module");
                prop_assert_eq!(block.as_slice(), expected.as_slice());
            }
            prop_assert_eq!(brge.pivot_block(modules.modules().len()), None);
        }
    }

    #[test]
    fn factors_solve_and_invert(seed: u64, links in 1..=30usize) {
        let (interpreter, State { q, tau, .. }) = robot(seed, links);
        let model = interpreter.model().clone();
        for modules in partitions(seed, &model) {
            let mut interpreter = Interpreter::with_modules(model.clone(), modules).expect("its own modules");
            let (gim, brge) = (interpreter.gim(&q), interpreter.factors(&q));
            let x = brge.solve(&tau).expect("the length is right");
            // Backward: what is left of the equations, against the terms in them.
            let left = plus(&times(&gim, &x), -1.0, &tau);
            let scale = square(&gim).amax() * x.iter().fold(1.0, |a: f64, x| a.max(x.abs()));
            assert_close("solve", &left, &vec![0.0; links], 1e-12 * scale.max(1.0));

            let inverse = square(&brge.inverse());
            prop_assert_eq!(&inverse, &inverse.transpose(), "symmetric to the last bit");
            let blocks = square(&brge.d_inverse());
            prop_assert_eq!(&blocks, &blocks.transpose(), "symmetric to the last bit");
            let expected = square(&gim).cholesky().expect("positive definite").inverse();
            let condition = square(&gim).norm() * expected.norm();
            let tolerance = 1e-14 * condition + 1e-12;
            assert_close("inverse", inverse.as_slice(), expected.as_slice(), tolerance);
            let product = square(&brge.u_inverse()).transpose() * square(&brge.d_inverse())
                * square(&brge.u_inverse());
            assert_close("U^-T D^-1 U^-1", product.as_slice(), inverse.as_slice(), tolerance);
        }
    }

    #[test]
    fn updated_factors_are_fresh_ones(seed: u64, links in 1..=20usize) {
        let (interpreter, State { q, qd, .. }) = robot(seed, links);
        let mut brge = interpreter.factors(&qd);
        brge.update(&interpreter, &q).expect("the length is right");
        let fresh = interpreter.factors(&q);
        prop_assert_eq!(brge.u(), fresh.u());
        prop_assert_eq!(brge.d(), fresh.d());
        prop_assert_eq!(brge.d_inverse(), fresh.d_inverse());
    }

    #[test]
    fn log_determinant_is_choleskys(seed: u64, links in 1..=30usize) {
        let (interpreter, State { q, .. }) = robot(seed, links);
        let model = interpreter.model().clone();
        for modules in partitions(seed, &model) {
            let mut interpreter = Interpreter::with_modules(model.clone(), modules).expect("its own modules");
            let lower = square(&interpreter.gim(&q)).cholesky().expect("positive definite").l();
            let expected: f64 = lower.diagonal().iter().map(|x| 2.0 * x.ln()).sum();
            let found = interpreter.factors(&q).log_determinant();
            assert_close("log-determinant", &[found], &[expected], 1e-9);
        }
    }

    #[test]
    fn condition_numbers_are_those_of_the_eigenvalues(seed: u64, links in 1..=30usize) {
        let (interpreter, State { q, .. }) = robot(seed, links);
        let brge = interpreter.factors(&q);
        for m in 0..interpreter.modules().modules().len() {
            let eigenvalues = square(&brge.pivot_block(m).expect("a module")).symmetric_eigenvalues();
            let expected = eigenvalues.max() / eigenvalues.min();
            let found = brge.condition_number(m).expect("a module");
            let tolerance = 1e-12 + 1e-14 * expected;
            assert_close("condition number", &[found / expected], &[1.0], tolerance);
        }
        prop_assert_eq!(brge.condition_number(links), None);
    }

    #[test]
    fn inverse_dynamics_undoes_forward_dynamics(seed: u64, links in 1..=30usize) {
        let (mut interpreter, State { q, qd, tau, qdd }) = robot(seed, links);
        let found = interpreter.qdd(&q, &qd, &tau);
        let back = interpreter.tau(&q, &qd, &found);
        let terms = interpreter.bias(&q, &qd);
        let scale = terms.iter().chain(&tau).fold(1.0, |a: f64, x| a.max(x.abs()));
        assert_close("torques", &back, &tau, 1e-11 * scale);

        let torques = interpreter.tau(&q, &qd, &qdd);
        let found = interpreter.qdd(&q, &qd, &torques);
        assert_close("accelerations", &found, &qdd, 1e-8);
    }

    #[test]
    fn forward_dynamics_is_the_same_by_any_modules(seed: u64, links in 1..=30usize) {
        let (mut interpreter, State { q, qd, tau, .. }) = robot(seed, links);
        let expected = interpreter.qdd(&q, &qd, &tau);
        let model = interpreter.model().clone();
        for modules in partitions(seed, &model) {
            interpreter = interpreter.eliminating_by(&modules).expect("its own modules");
            assert_close("accelerations", &interpreter.qdd(&q, &qd, &tau), &expected, 1e-9);
        }
    }

    #[test]
    fn inverse_dynamics_is_linear_in_the_accelerations(seed: u64, links in 1..=30usize) {
        let (mut interpreter, State { q, qd, qdd, .. }) = robot(seed, links);
        let inertial = times(&interpreter.gim(&q), &qdd);
        let expected = plus(&inertial, 1.0, &interpreter.bias(&q, &qd));
        assert_close("M qdd + h", &interpreter.tau(&q, &qd, &qdd), &expected, 1e-12);
    }

    #[test]
    fn bias_forces_at_rest_are_gravity_torques(seed: u64, links in 1..=30usize) {
        let (mut interpreter, State { q, .. }) = robot(seed, links);
        let bias = interpreter.bias(&q, &vec![0.0; links]);
        assert_close("bias forces", &bias, &interpreter.gravity(&q), 1e-12);
    }

    #[test]
    fn gravity_torques_are_the_potential_energys_gradient(seed: u64, links in 1..=30usize) {
        let (mut interpreter, State { q, .. }) = robot(seed, links);
        let model = interpreter.model().clone();
        let mut at = |i: usize, by: f64| interpreter.potential(&plus(&q, by, &unit(links, i)));
        let gradient: Vec<f64> = (0..links)
            .map(|i| match model.links()[i].joint.joint_type {
                // V = a + b q or a + b cos q + c sin q: these differences are exact.
                JointType::Prismatic => (at(i, 1.0) - at(i, -1.0)) / 2.0,
                _ => (at(i, FRAC_PI_2) - at(i, -FRAC_PI_2)) / 2.0,
            })
            .collect();
        assert_close("gradient", &interpreter.gravity(&q), &gradient, 1e-11);
    }

    #[test]
    fn power_balances(seed: u64, links in 1..=30usize) {
        let (mut interpreter, State { q, qd, tau, .. }) = robot(seed, links);
        let qdd = interpreter.qdd(&q, &qd, &tau);
        // dT/dt: along the velocities with them kept, and by the accelerations.
        let along = derivative(|h| interpreter.kinetic(&plus(&q, h, &qd), &qd));
        let change = along + dot(&qd, &times(&interpreter.gim(&q), &qdd));
        let power = dot(&qd, &tau) - dot(&qd, &interpreter.gravity(&q));
        let scale = power.abs() + along.abs() + interpreter.kinetic(&q, &qd);
        assert_close("dT/dt", &[change / scale], &[power / scale], 1e-7);
    }

    #[test]
    fn energy_is_conserved_in_free_fall(seed: u64, links in 1..=15usize) {
        let (mut interpreter, State { mut q, mut qd, .. }) = robot(seed, links);
        let mut falling = interpreter.clone();
        let free = vec![0.0; links];
        let mut total = |q: &[f64], qd: &[f64]| {
            (interpreter.kinetic(q, qd), interpreter.potential(q))
        };
        let (start, before) = (q.clone(), total(&q, &qd));
        let h = 1e-4;
        for _ in 0..50 {
            // Runge and Kutta's fourth order.
            let mut slope = |q: &[f64], qd: &[f64]| (qd.to_vec(), falling.qdd(q, qd, &free));
            let a = slope(&q, &qd);
            let b = slope(&plus(&q, h / 2.0, &a.0), &plus(&qd, h / 2.0, &a.1));
            let c = slope(&plus(&q, h / 2.0, &b.0), &plus(&qd, h / 2.0, &b.1));
            let d = slope(&plus(&q, h, &c.0), &plus(&qd, h, &c.1));
            for (weight, (v, acceleration)) in [(1.0, a), (2.0, b), (2.0, c), (1.0, d)] {
                q = plus(&q, h * weight / 6.0, &v);
                qd = plus(&qd, h * weight / 6.0, &acceleration);
            }
        }
        let after = total(&q, &qd);
        let scale = before.0 + before.1.abs() + after.0;
        let drift = (after.0 + after.1 - before.0 - before.1) / scale;
        prop_assert!(drift.abs() < 1e-8, "{}", drift);
        prop_assert!(difference(&q, &start) > 1e-7, "it moved");
    }

    #[test]
    fn denoc_matrices_give_the_mass_matrix(seed: u64, links in 1..=15usize) {
        let (mut interpreter, State { q, qd, .. }) = robot(seed, links);
        let denoc = interpreter.denoc(&q).expect("the length is right");
        let (mass, propagation) = (dense(&denoc.mass), dense(&denoc.propagation));
        let joints = dense(&denoc.joints);
        let n = propagation * joints;
        let gim = interpreter.gim(&q);
        let product = n.transpose() * &mass * &n;
        assert_close("(N_l N_d)^T M (N_l N_d)", product.as_slice(), &gim, 1e-12);
        assert_close("the same in the interpreter", &denoc.gim().entries, &gim, 1e-12);
        // The paper's twist t = N qd, with its kinetic energy.
        let twist = n * DVector::from_column_slice(&qd);
        let energy = 0.5 * (twist.transpose() * mass * &twist)[(0, 0)];
        assert_close("energy", &[energy], &[interpreter.kinetic(&q, &qd)], 1e-12);
    }

    #[test]
    fn denoc_masses_are_as_written(seed: u64, links in 1..=15usize) {
        let (mut interpreter, State { q, .. }) = robot(seed, links);
        let mass = dense(&interpreter.denoc(&q).expect("the length is right").mass);
        for (i, link) in interpreter.model().links().iter().enumerate() {
            // About the link's origin: [I, m c x; -m c x, m]. What c contributes to I drops out.
            let block = |row, column| mass.fixed_view::<3, 3>(6 * i + row, 6 * i + column);
            let expected = Matrix3::identity() * link.inertial.mass;
            assert_close("mass", block(3, 3).into_owned().as_slice(), expected.as_slice(), 1e-14);
            let (moment, first) = (block(0, 0), block(0, 3));
            let own = moment - first * first.transpose() / link.inertial.mass;
            let [xx, xy, xz, yy, yz, zz] = link.inertial.inertia;
            let written = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
            let [mut found, mut expected] = [own, written].map(|inertia| {
                let moments: [f64; 3] = inertia.symmetric_eigenvalues().into();
                moments
            });
            found.sort_by(f64::total_cmp);
            expected.sort_by(f64::total_cmp);
            assert_close("principal moments", &found, &expected, 1e-9);
        }
    }

    #[test]
    fn single_precision_is_near_double(seed: u64, links in 1..=10usize) {
        #[allow(clippy::cast_possible_truncation)]
        let single = |x: &[f64]| -> Vec<f32> { x.iter().map(|&x| x as f32).collect() };
        let double = |x: &[f32]| -> Vec<f64> { x.iter().copied().map(f64::from).collect() };
        let (mut interpreter, state) = robot(seed, links);
        let mut coarse = Interpreter::<f32>::new(interpreter.model().clone());
        let [q, qd, qdd, tau] = [&state.q, &state.qd, &state.qdd, &state.tau].map(|x| single(x));
        let [dq, dqd, dqdd, dtau] = [&q, &qd, &qdd, &tau].map(|x| double(x));
        let close = |what, found: &[f32], expected: &[f64]| {
            assert_close(what, &double(found), expected, 1e-4);
        };
        close("torques", &coarse.tau(&q, &qd, &qdd), &interpreter.tau(&dq, &dqd, &dqdd));
        close("gravity", &coarse.gravity(&q), &interpreter.gravity(&dq));
        close("GIM", &coarse.gim(&q), &interpreter.gim(&dq));
        close("T", &[coarse.kinetic(&q, &qd)], &[interpreter.kinetic(&dq, &dqd)]);
        close("V", &[coarse.potential(&q)], &[interpreter.potential(&dq)]);
        for (found, expected) in zip(coarse.poses(&q), interpreter.poses(&dq)) {
            close("pose", &numbers(&found), &numbers(&expected));
        }
        // Accelerations by what they leave of the equations, against the terms in them.
        let found = double(&coarse.qdd(&q, &qd, &tau));
        let back = interpreter.tau(&dq, &dqd, &found);
        let scale = square(&interpreter.gim(&dq)).amax()
            * found.iter().fold(1.0, |a: f64, x| a.max(x.abs()));
        prop_assert!(difference(&back, &dtau) < 1e-4 * scale.max(1.0), "accelerations");
    }

    #[test]
    fn a_second_opinion_agrees(seed: u64, links in 1..=30usize) {
        let (mut interpreter, State { q, qd, qdd, .. }) = robot(seed, links);
        let model = interpreter.model().clone();
        let naive = Naive::new(&model, &q);
        for (found, expected) in zip(interpreter.poses(&q), naive.poses()) {
            assert_close("pose", &numbers(&found), &numbers(&expected), SNAPPED);
        }
        let close = |what, found: &[f64], expected: &[f64]| {
            assert_close(what, found, expected, SNAPPED);
        };
        close("GIM", &interpreter.gim(&q), naive.mass_matrix().as_slice());
        close("torques", &interpreter.tau(&q, &qd, &qdd), &naive.inverse_dynamics(&qd, &qdd));
        let rest = vec![0.0; links];
        close("bias forces", &interpreter.bias(&q, &qd), &naive.inverse_dynamics(&qd, &rest));
        close("gravity", &interpreter.gravity(&q), &naive.inverse_dynamics(&rest, &rest));
        close("T", &[interpreter.kinetic(&q, &qd)], &[naive.kinetic_energy(&qd)]);
        close("V", &[interpreter.potential(&q)], &[naive.potential_energy()]);
    }

    #[test]
    fn no_call_depends_on_those_before(seed: u64, links in 1..=15usize) {
        let (mut used, State { q, qd, tau, .. }) = robot(seed, links);
        let mut fresh = used.clone();
        let expected = fresh.qdd(&q, &qd, &tau);
        used.qdd(&qd, &tau, &q);
        used.gim(&tau);
        used.potential(&qd);
        used.poses(&tau);
        prop_assert_eq!(used.qdd(&q, &qd, &tau), expected);
        used.kinetic(&tau, &q);
        used.bias(&tau, &q);
        prop_assert_eq!(used.gim(&q), Interpreter::new(tree(seed, links)).gim(&q));
        prop_assert_eq!(used.gravity(&q), Interpreter::new(tree(seed, links)).gravity(&q));
    }
}
