//! Physical identities that hold for every robot.

use std::f64::consts::FRAC_PI_2;
use std::iter::zip;
use std::ops::Range;

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{JointFriction, Model, ModuleTree, MovingLink};
use modyn_runtime::quantities::Function;
use modyn_runtime::spatial::{Vector3, Wrench};
use modyn_runtime::{Forces, Interpreter, ShapeError};
use modyn_tests::arguments::interpreted;
use modyn_tests::cases::{Robot, cases, robots, zoos};
use modyn_tests::close::{assert_close, difference};
use modyn_tests::dense::{dense, dot, identity, square, times};
use modyn_tests::naive::Naive;
use modyn_tests::quantities::{Quantities, numbers};
use modyn_tests::random::{
    self, Random, State, modules, normalize_configuration, springs_are_smooth, state,
};
use modyn_tests::tangent::{along, rates};
use nalgebra::{DVector, Matrix3};
use proptest::prelude::*;

/// The tolerance: constant rotations at each of 30 joints are rounded to 0, 1 or -1 within 1e-11.
const SNAPPED: f64 = 1e-9;

/// Returns the interpreter of a random robot, and a state.
fn set_up(robot: Robot) -> (Interpreter<f64>, State) {
    let model = robot.model();
    let state = state(robot.seed(), &model);
    (Interpreter::new(model), state)
}

/// Returns partitions into chains, into single links, and a random partition.
fn partitions(seed: u64, model: &Model) -> [ModuleTree; 3] {
    [ModuleTree::chains(model), ModuleTree::links(model), modules(seed, model)]
}

/// Returns `a + factor * b`.
fn plus(a: &[f64], factor: f64, b: &[f64]) -> Vec<f64> {
    zip(a, b).map(|(a, b)| a + factor * b).collect()
}

/// Returns the entries of qd that belong to the joints of these links; mimic joints have none.
fn own(model: &Model, links: Range<usize>) -> Range<usize> {
    let joints = |links: Range<usize>| {
        model.moving_links()[links]
            .iter()
            .map(|link| &link.joint)
            .filter(|joint| joint.mimic.is_none())
    };
    let start = joints(0..links.start).map(|joint| joint.joint_type.nv()).sum();
    start..start + joints(links).map(|joint| joint.joint_type.nv()).sum::<usize>()
}

/// Returns the number of massless bodies inside a joint.
fn inside(joint_type: JointType) -> usize {
    match joint_type {
        JointType::Universal => 1,
        JointType::Planar => 2,
        _ => 0,
    }
}

fn unit(n: usize, i: usize) -> Vec<f64> {
    (0..n).map(|j| if i == j { 1.0 } else { 0.0 }).collect()
}

/// Returns the derivative of `f` at 0 by central differences, with the first error term removed.
fn derivative(mut f: impl FnMut(f64) -> f64) -> f64 {
    let h = 1e-3;
    let mut slope = |h: f64| (f(h) - f(-h)) / (2.0 * h);
    let (near, far) = (slope(h), slope(2.0 * h));
    near + (near - far) / 3.0
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn mass_matrix_is_symmetric_positive_definite(robot in robots(30)) {
        let (mut interpreter, state) = set_up(robot);
        let mass_matrix = square(&interpreter.dense_mass_matrix(&state.q));
        prop_assert_eq!(&mass_matrix, &mass_matrix.transpose());
        prop_assert!(mass_matrix.cholesky().is_some());
    }

    #[test]
    fn mass_matrix_is_that_of_the_kinetic_energy(robot in robots(12)) {
        let (mut interpreter, State { q, .. }) = set_up(robot);
        let n = interpreter.model().nv();
        let mut energy = |qd: &[f64]| interpreter.kinetic(&q, qd);
        // T is quadratic in the velocities, so these differences are exact.
        let mut columns = vec![0.0; n * n];
        for (i, column) in columns.chunks_mut(n).enumerate() {
            for (j, entry) in column.iter_mut().enumerate() {
                let (a, b) = (unit(n, i), unit(n, j));
                *entry = energy(&plus(&a, 1.0, &b)) - energy(&a) - energy(&b);
            }
        }
        assert_close("second differences", &columns, &interpreter.dense_mass_matrix(&q), 1e-12);
    }

    #[test]
    fn factors_multiply_to_the_mass_matrix(robot in robots(30)) {
        let (interpreter, State { q, .. }) = set_up(robot);
        let model = interpreter.model().clone();
        for modules in partitions(robot.seed(), &model) {
            let mut interpreter = Interpreter::with_modules(model.clone(), modules).expect("its own modules");
            let (mass_matrix, brge) = (interpreter.dense_mass_matrix(&q), interpreter.factors(&q));
            let (u, d) = (square(&brge.u()), square(&brge.d()));
            let product = &u * &d * u.transpose();
            assert_close("U D U^T", product.as_slice(), &mass_matrix, 1e-11);

            let unity = identity(model.nv());
            let product = &u * square(&brge.u_inverse());
            let scale = u.amax().max(1.0) * square(&brge.u_inverse()).amax().max(1.0);
            assert_close("U U^-1", (product / scale).as_slice(), (square(&unity) / scale).as_slice(), 1e-11);
            let product = &d * square(&brge.d_inverse());
            assert_close("D D^-1", product.as_slice(), &unity, 1e-9);
        }
    }

    #[test]
    fn factors_have_the_modules_shape(robot in robots(30)) {
        let (interpreter, State { q, .. }) = set_up(robot);
        let model = interpreter.model().clone();
        for modules in partitions(robot.seed(), &model) {
            let interpreter = Interpreter::with_modules(model.clone(), modules.clone()).expect("its own modules");
            let brge = interpreter.factors(&q);
            let ranges = modules.modules().iter().map(|module| own(&model, module.links.clone()));
            let ranges: Vec<_> = ranges.collect();
            let module_of = |i: usize| {
                ranges.iter().position(|range| range.contains(&i)).expect("a module")
            };
            let (u, d) = (square(&brge.u()), square(&brge.d()));
            for i in 0..model.nv() {
                for j in 0..model.nv() {
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
            for (m, range) in ranges.iter().enumerate() {
                let (start, size) = (range.start, range.len());
                let expected = d.view((start, start), (size, size)).into_owned();
                let block = brge.pivot_block(m).expect("a module");
                prop_assert_eq!(block.as_slice(), expected.as_slice());
            }
            prop_assert_eq!(brge.pivot_block(modules.modules().len()), None);
        }
    }

    #[test]
    fn factors_solve_and_invert(robot in robots(30)) {
        let (interpreter, State { q, tau, .. }) = set_up(robot);
        let model = interpreter.model().clone();
        for modules in partitions(robot.seed(), &model) {
            let mut interpreter = Interpreter::with_modules(model.clone(), modules).expect("its own modules");
            let (mass_matrix, brge) = (interpreter.dense_mass_matrix(&q), interpreter.factors(&q));
            let x = brge.solve(&tau).expect("the length is right");
            // Backward error: the residual of the equations relative to their terms.
            let left = plus(&times(&mass_matrix, &x), -1.0, &tau);
            let scale = square(&mass_matrix).amax() * x.iter().fold(1.0, |a: f64, x| a.max(x.abs()));
            assert_close("solve", &left, &vec![0.0; tau.len()], 1e-12 * scale.max(1.0));

            let inverse = square(&brge.inverse());
            prop_assert_eq!(&inverse, &inverse.transpose(), "symmetric to the last bit");
            let blocks = square(&brge.d_inverse());
            prop_assert_eq!(&blocks, &blocks.transpose(), "symmetric to the last bit");
            let expected = square(&mass_matrix).cholesky().expect("positive definite").inverse();
            let condition = square(&mass_matrix).norm() * expected.norm();
            let tolerance = 1e-14 * condition + 1e-12;
            assert_close("inverse", inverse.as_slice(), expected.as_slice(), tolerance);
            let product = square(&brge.u_inverse()).transpose() * square(&brge.d_inverse())
                * square(&brge.u_inverse());
            assert_close("U^-T D^-1 U^-1", product.as_slice(), inverse.as_slice(), tolerance);
        }
    }

    #[test]
    fn updated_factors_are_fresh_ones(robot in robots(20)) {
        let (interpreter, State { q, .. }) = set_up(robot);
        let mut brge = interpreter.factors(&state(!robot.seed(), interpreter.model()).q);
        brge.update(&interpreter, &q).expect("the length is right");
        let fresh = interpreter.factors(&q);
        prop_assert_eq!(brge.u(), fresh.u());
        prop_assert_eq!(brge.d(), fresh.d());
        prop_assert_eq!(brge.d_inverse(), fresh.d_inverse());
    }

    #[test]
    fn log_determinant_is_choleskys(robot in robots(30)) {
        let (interpreter, State { q, .. }) = set_up(robot);
        let model = interpreter.model().clone();
        for modules in partitions(robot.seed(), &model) {
            let mut interpreter = Interpreter::with_modules(model.clone(), modules).expect("its own modules");
            let lower = square(&interpreter.dense_mass_matrix(&q)).cholesky().expect("positive definite").l();
            let expected: f64 = lower.diagonal().iter().map(|x| 2.0 * x.ln()).sum();
            let found = interpreter.factors(&q).log_determinant();
            assert_close("log-determinant", &[found], &[expected], 1e-9);
        }
    }

    #[test]
    fn condition_numbers_are_those_of_the_eigenvalues(robot in robots(30)) {
        let (interpreter, State { q, .. }) = set_up(robot);
        let brge = interpreter.factors(&q);
        for m in 0..interpreter.modules().modules().len() {
            let block = brge.pivot_block(m).expect("a module");
            // A module of mimic joints alone has no pivot block.
            if block.is_empty() {
                continue;
            }
            let eigenvalues = square(&block).symmetric_eigenvalues();
            let expected = eigenvalues.max() / eigenvalues.min();
            let found = brge.condition_number(m).expect("a module");
            let tolerance = 1e-12 + 1e-14 * expected;
            assert_close("condition number", &[found / expected], &[1.0], tolerance);
        }
        prop_assert_eq!(brge.condition_number(interpreter.modules().modules().len()), None);
    }

    #[test]
    fn inverse_dynamics_undoes_forward_dynamics(robot in robots(30)) {
        let (mut interpreter, State { q, qd, tau, qdd }) = set_up(robot);
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
    fn forward_dynamics_is_the_same_by_any_modules(robot in robots(30)) {
        let (mut interpreter, State { q, qd, tau, .. }) = set_up(robot);
        let expected = interpreter.qdd(&q, &qd, &tau);
        let model = interpreter.model().clone();
        for modules in partitions(robot.seed(), &model) {
            interpreter = interpreter.eliminating_by(&modules).expect("its own modules");
            assert_close("accelerations", &interpreter.qdd(&q, &qd, &tau), &expected, 1e-9);
        }
    }

    #[test]
    fn inverse_dynamics_is_linear_in_the_accelerations(robot in robots(30)) {
        let (mut interpreter, State { q, qd, qdd, .. }) = set_up(robot);
        let inertial = times(&interpreter.dense_mass_matrix(&q), &qdd);
        let expected = plus(&inertial, 1.0, &interpreter.bias(&q, &qd));
        assert_close("M qdd + h", &interpreter.tau(&q, &qd, &qdd), &expected, 1e-12);
    }

    #[test]
    fn bias_forces_at_rest_are_gravity_torques(robot in robots(30)) {
        let (mut interpreter, State { q, .. }) = set_up(robot);
        let bias = interpreter.bias(&q, &vec![0.0; interpreter.model().nv()]);
        assert_close("bias forces", &bias, &interpreter.gravity(&q), 1e-12);
    }

    #[test]
    fn gravity_torques_are_the_potential_energys_gradient(seed: u64, links in 1..=30usize) {
        let (mut interpreter, State { q, .. }) = set_up(Robot::Tree(seed, links));
        let model = interpreter.model().clone();
        let mut at = |i: usize, by: f64| interpreter.potential(&plus(&q, by, &unit(links, i)));
        let gradient: Vec<f64> = (0..links)
            .map(|i| match model.moving_links()[i].joint.joint_type {
                // V = a + b q or a + b cos q + c sin q: these differences are exact.
                JointType::Prismatic => (at(i, 1.0) - at(i, -1.0)) / 2.0,
                _ => (at(i, FRAC_PI_2) - at(i, -FRAC_PI_2)) / 2.0,
            })
            .collect();
        assert_close("gradient", &interpreter.gravity(&q), &gradient, 1e-11);
    }

    #[test]
    fn gravity_torques_are_the_gradient_along_velocities(robot in zoos(15)) {
        let (mut interpreter, State { q, .. }) = set_up(robot);
        let model = interpreter.model().clone();
        prop_assume!(springs_are_smooth(&model, &q));
        let gradient: Vec<f64> = (0..model.nv())
            .map(|i| {
                let qd = unit(model.nv(), i);
                derivative(|h| interpreter.potential(&along(&model, &q, h, &qd)))
            })
            .collect();
        assert_close("gradient", &interpreter.gravity(&q), &gradient, 1e-9);
    }

    #[test]
    fn power_balances(robot in robots(30)) {
        let (mut interpreter, State { q, qd, tau, .. }) = set_up(robot);
        let model = interpreter.model().clone();
        prop_assume!(springs_are_smooth(&model, &q));
        let qdd = interpreter.qdd(&q, &qd, &tau);
        // d(T + V)/dt: along the velocities at constant velocity, and by the accelerations.
        let stored = derivative(|h| {
            let q = along(&model, &q, h, &qd);
            interpreter.kinetic(&q, &qd) + interpreter.potential(&q)
        });
        let sped_up = dot(&qd, &times(&interpreter.dense_mass_matrix(&q), &qdd));
        let lost = dot(&qd, &Naive::new(&model, &q).dissipation(&qd));
        let (change, power) = (stored + sped_up, dot(&qd, &tau) - lost);
        let scale = power.abs() + stored.abs() + sped_up.abs() + interpreter.kinetic(&q, &qd);
        assert_close("d(T + V)/dt", &[change / scale], &[power / scale], 1e-7);
    }

    #[test]
    fn energy_is_conserved_in_free_fall(robot in robots(15)) {
        // Rotors stay; dissipation is left out.
        let model = robot.model().with_joint_friction(JointFriction::None).expect("sound");
        let State { mut q, mut qd, .. } = state(robot.seed(), &model);
        prop_assume!(springs_are_smooth(&model, &q));
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let mut falling = interpreter.clone();
        let free = vec![0.0; model.nv()];
        let mut total = |q: &[f64], qd: &[f64]| {
            (interpreter.kinetic(q, qd), interpreter.potential(q))
        };
        let (start, before) = (q.clone(), total(&q, &qd));
        let h = 1e-4;
        for _ in 0..50 {
            // The classical fourth-order Runge-Kutta method.
            let moved = |by: f64, rate: &[f64]| {
                let mut moved = plus(&q, by, rate);
                normalize_configuration(&model, &mut moved);
                moved
            };
            let mut slope =
                |q: &[f64], qd: &[f64]| (rates(&model, q, qd), falling.qdd(q, qd, &free));
            let a = slope(&q, &qd);
            let b = slope(&moved(h / 2.0, &a.0), &plus(&qd, h / 2.0, &a.1));
            let c = slope(&moved(h / 2.0, &b.0), &plus(&qd, h / 2.0, &b.1));
            let d = slope(&moved(h, &c.0), &plus(&qd, h, &c.1));
            for (weight, (v, acceleration)) in [(1.0, a), (2.0, b), (2.0, c), (1.0, d)] {
                q = plus(&q, h * weight / 6.0, &v);
                qd = plus(&qd, h * weight / 6.0, &acceleration);
            }
            normalize_configuration(&model, &mut q);
        }
        let after = total(&q, &qd);
        let scale = before.0 + before.1.abs() + after.0;
        let drift = (after.0 + after.1 - before.0 - before.1) / scale;
        prop_assert!(drift.abs() < 1e-8, "{}", drift);
        prop_assert!(difference(&q, &start) > 1e-7, "it moved");
    }

    #[test]
    fn denoc_matrices_give_the_mass_matrix(robot in robots(15)) {
        let (mut interpreter, State { q, qd, .. }) = set_up(robot);
        let denoc = interpreter.denoc(&q).expect("the length is right");
        let (mass, propagation) = (dense(&denoc.mass), dense(&denoc.propagation));
        let joints = dense(&denoc.joints);
        let n = propagation * joints;
        let rotors = Naive::new(interpreter.model(), &q).rotors();
        let mass_matrix = square(&interpreter.dense_mass_matrix(&q)) - &rotors;
        let product = n.transpose() * &mass * &n;
        assert_close("(N_l N_d)^T M (N_l N_d)", product.as_slice(), mass_matrix.as_slice(), 1e-12);
        assert_close("the same in the interpreter", &denoc.mass_matrix().entries, mass_matrix.as_slice(), 1e-12);
        // The paper's twist t = N qd, with its kinetic energy.
        let qd = DVector::from_vec(qd);
        let twist = n * &qd;
        let energy = 0.5 * ((mass * &twist).dot(&twist) + (rotors * &qd).dot(&qd));
        assert_close("energy", &[energy], &[interpreter.kinetic(&q, qd.as_slice())], 1e-12);
    }

    #[test]
    fn denoc_masses_are_as_written(robot in robots(15)) {
        let (mut interpreter, State { q, .. }) = set_up(robot);
        let mass = dense(&interpreter.denoc(&q).expect("the length is right").mass);
        let mut bodies = 0;
        for link in interpreter.model().moving_links() {
            let i = bodies + inside(link.joint.joint_type);
            let empty = mass.rows(6 * bodies, 6 * (i - bodies));
            prop_assert!(empty.iter().all(|&x| x == 0.0), "nothing inside joints");
            bodies = i + 1;
            // About the link's origin: [m, -m c x; m c x, I]. The part of I that depends on c cancels.
            let block = |row, column| mass.fixed_view::<3, 3>(6 * i + row, 6 * i + column);
            let expected = Matrix3::identity() * link.inertial.mass;
            assert_close("mass", block(0, 0).into_owned().as_slice(), expected.as_slice(), 1e-14);
            let (moment, first) = (block(3, 3), block(3, 0));
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
    fn single_precision_is_near_double(robot in robots(10)) {
        #[allow(clippy::cast_possible_truncation)]
        let single = |x: &[f64]| -> Vec<f32> { x.iter().map(|&x| x as f32).collect() };
        let double = |x: &[f32]| -> Vec<f64> { x.iter().copied().map(f64::from).collect() };
        let (mut interpreter, state) = set_up(robot);
        let mut coarse = Interpreter::<f32>::new(interpreter.model().clone());
        let [q, qd, qdd, tau] = [&state.q, &state.qd, &state.qdd, &state.tau].map(|x| single(x));
        let [dq, dqd, dqdd, dtau] = [&q, &qd, &qdd, &tau].map(|x| double(x));
        let close = |what, found: &[f32], expected: &[f64]| {
            assert_close(what, &double(found), expected, 1e-4);
        };
        close("torques", &coarse.tau(&q, &qd, &qdd), &interpreter.tau(&dq, &dqd, &dqdd));
        close("gravity", &coarse.gravity(&q), &interpreter.gravity(&dq));
        close("mass matrix", &coarse.dense_mass_matrix(&q), &interpreter.dense_mass_matrix(&dq));
        close("T", &[coarse.kinetic(&q, &qd)], &[interpreter.kinetic(&dq, &dqd)]);
        close("V", &[coarse.potential(&q)], &[interpreter.potential(&dq)]);
        for (found, expected) in zip(coarse.poses(&q), interpreter.poses(&dq)) {
            close("pose", &numbers(&found), &numbers(&expected));
        }
        // Backward error: the residual of the equations relative to their terms.
        let found = double(&coarse.qdd(&q, &qd, &tau));
        let back = interpreter.tau(&dq, &dqd, &found);
        let scale = square(&interpreter.dense_mass_matrix(&dq)).amax()
            * found.iter().fold(1.0, |a: f64, x| a.max(x.abs()));
        prop_assert!(difference(&back, &dtau) < 1e-4 * scale.max(1.0), "accelerations");
    }

    #[test]
    fn a_second_opinion_agrees(robot in robots(30)) {
        let (mut interpreter, State { q, qd, qdd, .. }) = set_up(robot);
        let model = interpreter.model().clone();
        let naive = Naive::new(&model, &q);
        for (found, expected) in zip(interpreter.poses(&q), naive.poses()) {
            assert_close("pose", &numbers(&found), &numbers(&expected), SNAPPED);
        }
        let close = |what, found: &[f64], expected: &[f64]| {
            assert_close(what, found, expected, SNAPPED);
        };
        close("mass matrix", &interpreter.dense_mass_matrix(&q), naive.mass_matrix().as_slice());
        close("torques", &interpreter.tau(&q, &qd, &qdd), &naive.inverse_dynamics(&qd, &qdd));
        let rest = vec![0.0; model.nv()];
        close("bias forces", &interpreter.bias(&q, &qd), &naive.inverse_dynamics(&qd, &rest));
        close("gravity", &interpreter.gravity(&q), &naive.inverse_dynamics(&rest, &rest));
        close("T", &[interpreter.kinetic(&q, &qd)], &[naive.kinetic_energy(&qd)]);
        close("V", &[interpreter.potential(&q)], &[naive.potential_energy()]);
        let inertia = interpreted(&mut interpreter, Function::CentroidalCompositeInertia, std::slice::from_ref(&q));
        close("I", &inertia, naive.centroidal_composite_inertia().as_slice());
    }

    #[test]
    fn forces_from_outside_act_as_a_second_opinion_has_it(robot in robots(20)) {
        let (mut interpreter, State { q, qd, qdd, tau }) = set_up(robot);
        let model = interpreter.model().clone();
        let naive = Naive::new(&model, &q);
        let wrenches = wrenches(robot.seed(), &model);
        // The same wrenches in world axes.
        let in_world_axes: Vec<_> = zip(&wrenches, interpreter.poses(&q))
            .map(|(wrench, pose)| Wrench {
                moment: Vector3(pose.rotate(wrench.moment.0)),
                force: Vector3(pose.rotate(wrench.force.0)),
            })
            .collect();
        for forces in [Forces::InLinkAxes, Forces::InWorldAxes].map(|axes| axes(&wrenches)) {
            let share = naive.external(forces);
            let expected = plus(&interpreter.tau(&q, &qd, &qdd), -1.0, &share);
            let found = interpreter.tau_under(&q, &qd, &qdd, forces);
            assert_close("torques", &found, &expected, SNAPPED);

            let expected = interpreter.qdd(&q, &qd, &plus(&tau, 1.0, &share));
            for modules in partitions(robot.seed(), &model) {
                interpreter = interpreter.eliminating_by(&modules).expect("its own modules");
                let found = interpreter.qdd_under(&q, &qd, &tau, forces);
                assert_close("accelerations", &found, &expected, 1e-8);
                let back = interpreter.tau_under(&q, &qd, &found, forces);
                let scale = naive.mass_matrix().amax()
                    * found.iter().fold(1.0, |a: f64, x| a.max(x.abs()));
                assert_close("torques again", &back, &tau, 1e-11 * scale.max(1.0));
            }
        }
        let [in_link, in_world] = [Forces::InLinkAxes(&wrenches), Forces::InWorldAxes(&in_world_axes)]
            .map(|forces| interpreter.qdd_under(&q, &qd, &tau, forces));
        assert_close("by any axes", &in_link, &in_world, 1e-9);

        let short = Forces::InWorldAxes(&wrenches[1..]);
        let (expected, found) = (wrenches.len(), wrenches.len() - 1);
        let refused = Err(ShapeError::new("forces", expected, found));
        let mut out = tau.clone();
        let result = interpreter.forward_dynamics_external(&q, &qd, &tau, short, &mut out);
        prop_assert_eq!(result, refused);
        let result = interpreter.inverse_dynamics_external(&q, &qd, &qdd, short, &mut out);
        prop_assert_eq!(result, refused);
    }

    #[test]
    fn coulomb_friction_is_against_the_motion(robot in zoos(15)) {
        let model = robot.model().with_joint_friction(JointFriction::Coulomb).expect("sound");
        let State { q, mut qd, qdd, .. } = state(robot.seed(), &model);
        qd[0] = 0.0;
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let expected = Naive::new(&model, &q).inverse_dynamics(&qd, &qdd);
        assert_close("torques", &interpreter.tau(&q, &qd, &qdd), &expected, SNAPPED);
    }

    #[test]
    fn no_call_depends_on_those_before(robot in robots(15)) {
        let (mut used, State { q, qd, qdd, tau }) = set_up(robot);
        let other = state(!robot.seed(), used.model()).q;
        let wrenches = wrenches(robot.seed(), used.model());
        let mut fresh = used.clone();
        let expected = fresh.qdd(&q, &qd, &tau);
        used.qdd(&other, &tau, &qd);
        used.dense_mass_matrix(&other);
        used.potential(&other);
        used.poses(&other);
        prop_assert_eq!(used.qdd(&q, &qd, &tau), expected);
        used.qdd_under(&other, &tau, &qd, Forces::InWorldAxes(&wrenches));
        used.kinetic(&other, &qdd);
        used.bias(&other, &qdd);
        prop_assert_eq!(used.dense_mass_matrix(&q), set_up(robot).0.dense_mass_matrix(&q));
        prop_assert_eq!(used.gravity(&q), set_up(robot).0.gravity(&q));
    }
}

/// Each axis of a chain is 44 degrees from that before it. Shifts of the frames along their axes, which grew by the reciprocal
/// of the cosine from joint to joint, lost eight digits of the last links' inertias.
#[test]
fn long_chains_of_small_tilts_keep_their_digits() {
    let chain = random::chain(5, 30);
    let links = chain.moving_links().iter().cloned().map(|mut link| {
        let (sin, cos) = 0.768_f64.sin_cos();
        link.joint.joint_type = JointType::Revolute;
        link.joint.axis = [0.0, 0.0, 1.0];
        link.joint.origin.rotation = [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]];
        link
    });
    let links: Vec<MovingLink> = links.collect();
    let frames = chain.links().to_vec();
    let model = Model::new("spiral", chain.gravity(), links, frames).expect("a good chain");
    let state = state(5, &model);
    let mut interpreter = Interpreter::new(model.clone());
    let n = model.nv();
    let mut found = vec![0.0; n * n];
    interpreter.mass_matrix(&state.q, &mut found).expect("lengths");
    let expected = Naive::new(&model, &state.q).mass_matrix();
    for i in 0..n {
        for j in 0..n {
            let scale = (expected[(i, i)] * expected[(j, j)]).sqrt();
            let error = (found[j * n + i] - expected[(i, j)]).abs() / scale;
            assert!(error < 1e-11, "entry {i}, {j}: {error:e}");
        }
    }
}

/// Returns one wrench for each frame.
fn wrenches(seed: u64, model: &Model) -> Vec<Wrench<f64>> {
    let mut random = Random::new(!seed);
    let mut vector = || Vector3(std::array::from_fn(|_| random.between(-5.0, 5.0)));
    model.links().iter().map(|_| Wrench { moment: vector(), force: vector() }).collect()
}
