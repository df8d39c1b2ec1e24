//! Batches give each state the result of the scalar function: at every SIMD level of this machine, for every remainder,
//! and bit for bit where products are not fused.

use modyn::{Robot, Scalar};
use modyn_tests::lanes::{alone, columns, numbers, on_every_level, slices, slices_mut, vectors};
use modyn_tests::plain::{Plain, number, plain};

macro_rules! robots {
    ($($Robot:ident = $file:literal $(, $key:ident = $choice:tt)*;)*) => {$(
        modyn::modyn! {
            $Robot = $file,
            functions = [
                random_configuration, forward_dynamics, inverse_dynamics, bias_forces, gravity_torques, mass_matrix,
                kinetic_energy, potential_energy, forward_dynamics_batch, inverse_dynamics_batch, bias_forces_batch,
                gravity_torques_batch, mass_matrix_batch, kinetic_energy_batch, potential_energy_batch
            ]
            $(, $key = $choice)*
        }
    )*};
}

robots! {
    Gripper = "../../../robots/gripper.urdf";
    Arm = "../../../robots/arm7.urdf", joint_friction = none, runtime_gravity = true, payload = ["link7"];
    Single = "../../../robots/arm7.urdf", joint_friction = none, scalar = f32;
    Zoo = "../../../robots/joint_zoo.urdf", joint_friction = none;
    FlyingSingle = "../../../robots/quadruped.urdf", base = floating, scalar = f32;
}

/// A robot whose function is long enough to be cut into chunks.
mod long {
    modyn::modyn! {
        pub Humanoid = "../../../robots/humanoid.urdf",
        functions = [forward_dynamics, forward_dynamics_batch]
    }
}

/// A robot with joints of all types that moves.
mod moved {
    modyn::modyn! {
        pub Zoo = "../../../robots/joint_zoo.urdf",
        joint_friction = none,
        functions = [random_configuration, integrate, forward_dynamics, forward_dynamics_batch]
    }
}

/// Robots whose functions return several arrays.
mod several {
    macro_rules! robots {
        ($($Robot:ident = $file:literal $(, $key:ident = $choice:tt)*;)*) => {$(
            modyn::modyn! {
                pub $Robot = $file,
                functions = [
                    mass_matrix, random_configuration, brge, brge_batch,
                    inverse_dynamics_derivatives, inverse_dynamics_derivatives_batch,
                    forward_dynamics_derivatives, forward_dynamics_derivatives_batch
                ]
                $(, $key = $choice)*
            }
        )*};
    }

    robots! {
        Arm = "../../../robots/arm7.urdf", joint_friction = none, runtime_gravity = true, payload = ["link7"];
        Mimic = "../../../robots/mimic_gripper.urdf", joint_friction = none;
        Single = "../../../robots/double_pendulum.urdf", scalar = f32;
    }
}

/// Robots with Hessians.
mod second_order {
    macro_rules! robots {
        ($($Robot:ident = $file:literal $(, $key:ident = $choice:tt)*;)*) => {$(
            modyn::modyn! {
                pub $Robot = $file,
                functions = [
                    random_configuration, inverse_dynamics_hessian, inverse_dynamics_hessian_batch,
                    forward_dynamics_hessian, forward_dynamics_hessian_batch
                ]
                $(, $key = $choice)*
            }
        )*};
    }

    robots! {
        Mimic = "../../../robots/mimic_gripper.urdf", joint_friction = viscous;
        Single = "../../../robots/double_pendulum.urdf", scalar = f32;
    }
}

/// A scalar of results.
trait Number: Scalar + PartialEq + Into<f64> {
    /// The largest difference between fused and unfused products, relative to the largest number of a result.
    const FUSED: f64;
}

impl Number for f64 {
    const FUSED: f64 = 1e-11;
}

impl Number for f32 {
    const FUSED: f64 = 5e-3;
}

#[track_caller]
fn same<T: Number, const N: usize>(found: &[[T; N]], expected: &[[T; N]], fused: bool, what: &str) {
    assert_eq!(found.len(), expected.len());
    for (state, (found, expected)) in found.iter().zip(expected).enumerate() {
        let numbers = |x: &[T; N]| x.map(Into::<f64>::into);
        let (found, expected) = (numbers(found), numbers(expected));
        let largest = expected.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        for (a, b) in found.iter().zip(&expected) {
            let within = if fused { (a - b).abs() <= T::FUSED * largest } else { a == b };
            assert!(within, "{what} of state {state}: {found:?} {expected:?}");
        }
    }
}

/// Evaluates a function for one state without vectors.
macro_rules! alone {
    ($Robot:ident, $T:ty, $function:ident $(, $argument:expr)+) => {
        number(<$Robot as Robot>::$function::<Plain<$T>>($(&plain(&$argument)),+))
    };
}

/// Compares all batch functions, with columns and with arrays of states, with the function of one state.
macro_rules! robot {
    ($Robot:ident, $T:ty) => {{
        const NV: usize = $Robot::NV;
        type Name = $Robot;
        // The widest vectors have 16 lanes.
        for states in (0..=33).chain([100, 1000]) {
            let mut uniform = numbers();
            let q: Vec<_> = (0..states)
                .map(|_| Name::random_configuration(|| (0.5 + 0.5 * uniform()) as $T))
                .collect();
            let qd: Vec<[$T; NV]> = vectors(states, 2.0);
            let tau: Vec<[$T; NV]> = vectors(states, 5.0);
            let (qs, qds, taus) = (columns(&q), columns(&qd), columns(&tau));
            let (qs, qds, taus) = (slices(&qs), slices(&qds), slices(&taus));
            let all = || (0..states);
            let zero = vec![0.0 as $T; states];
            let vector = || -> [Vec<$T>; NV] { std::array::from_fn(|_| zero.clone()) };
            let back = |columns: [Vec<$T>; NV]| -> Vec<[$T; NV]> {
                all().map(|i| std::array::from_fn(|j| columns[j][i])).collect()
            };
            on_every_level(|fused| {
                let mut each = vec![[0.0; NV]; states];

                let expected: Vec<_> = all()
                    .map(|i| alone!(Name, $T, forward_dynamics, q[i], qd[i], tau[i]))
                    .collect();
                let mut found = vector();
                Name::forward_dynamics_batch(qs, qds, taus, slices_mut(&mut found)).expect("sizes");
                same(&back(found), &expected, fused, "forward dynamics");
                Name::forward_dynamics_each(&q, &qd, &tau, &mut each).expect("sizes");
                same(&each, &expected, fused, "forward dynamics");

                let expected: Vec<_> = all()
                    .map(|i| alone!(Name, $T, inverse_dynamics, q[i], qd[i], tau[i]))
                    .collect();
                let mut found = vector();
                Name::inverse_dynamics_batch(qs, qds, taus, slices_mut(&mut found)).expect("sizes");
                same(&back(found), &expected, fused, "inverse dynamics");
                Name::inverse_dynamics_each(&q, &qd, &tau, &mut each).expect("sizes");
                same(&each, &expected, fused, "inverse dynamics");

                let expected: Vec<_> =
                    all().map(|i| alone!(Name, $T, bias_forces, q[i], qd[i])).collect();
                let mut found = vector();
                Name::bias_forces_batch(qs, qds, slices_mut(&mut found)).expect("sizes");
                same(&back(found), &expected, fused, "bias forces");
                Name::bias_forces_each(&q, &qd, &mut each).expect("sizes");
                same(&each, &expected, fused, "bias forces");

                let expected: Vec<_> =
                    all().map(|i| alone!(Name, $T, gravity_torques, q[i])).collect();
                let mut found = vector();
                Name::gravity_torques_batch(qs, slices_mut(&mut found)).expect("sizes");
                same(&back(found), &expected, fused, "gravity torques");
                Name::gravity_torques_each(&q, &mut each).expect("sizes");
                same(&each, &expected, fused, "gravity torques");

                let expected: Vec<_> = all()
                    .map(|i| <Name as Robot>::mass_matrix::<Plain<$T>>(&plain(&q[i])).map(number))
                    .collect();
                let mut found: [[Vec<$T>; NV]; NV] = std::array::from_fn(|_| vector());
                Name::mass_matrix_batch(qs, found.each_mut().map(slices_mut)).expect("sizes");
                let mut matrices = vec![[[0.0; NV]; NV]; states];
                Name::mass_matrix_each(&q, &mut matrices).expect("sizes");
                for (j, column) in found.into_iter().enumerate() {
                    let expected: Vec<[$T; NV]> = expected.iter().map(|m| m[j]).collect();
                    let each: Vec<[$T; NV]> = matrices.iter().map(|m| m[j]).collect();
                    same(&back(column), &expected, fused, "the mass matrix");
                    same(&each, &expected, fused, "the mass matrix");
                }

                let expected: Vec<_> =
                    all().map(|i| [Name::kinetic_energy(&q[i], &qd[i])]).collect();
                let mut found = vec![0.0; states];
                Name::kinetic_energy_batch(qs, qds, &mut found).expect("sizes");
                same(found.as_chunks().0, &expected, fused, "kinetic energy");
                Name::kinetic_energy_each(&q, &qd, &mut found).expect("sizes");
                same(found.as_chunks().0, &expected, fused, "kinetic energy");

                let expected: Vec<_> = all().map(|i| [Name::potential_energy(&q[i])]).collect();
                Name::potential_energy_batch(qs, &mut found).expect("sizes");
                same(found.as_chunks().0, &expected, fused, "potential energy");
                Name::potential_energy_each(&q, &mut found).expect("sizes");
                same(found.as_chunks().0, &expected, fused, "potential energy");
            });
        }
    }};
}

/// Returns the matrices of all states, by columns, from one slice for each entry.
fn matrices<T: Copy, const N: usize, const NN: usize>(
    columns: &[[Vec<T>; N]; N],
    states: usize,
) -> Vec<[T; NN]> {
    (0..states).map(|i| std::array::from_fn(|j| columns[j / N][j % N][i])).collect()
}

/// Compares batch functions whose results are several arrays with the function of one state.
macro_rules! several {
    ($Robot:ident, $T:ty) => {{
        type Name = several::$Robot;
        type Factors = <Name as Robot>::UduFactorization<$T>;
        const NV: usize = Name::NV;
        const NN: usize = NV * NV;
        const ZERO: [[$T; NV]; NV] = [[0.0; NV]; NV];
        let flat = |matrix: &[[$T; NV]; NV]| -> [$T; NN] {
            matrix.as_flattened().try_into().expect("a square")
        };
        let unwrap = |matrix: [[Plain<$T>; NV]; NV]| flat(&matrix.map(number));
        for states in [0, 1, 7, 16, 17, 33, 100] {
            let mut uniform = numbers();
            let q: Vec<_> = (0..states)
                .map(|_| Name::random_configuration(|| (0.5 + 0.5 * uniform()) as $T))
                .collect();
            let qd: Vec<[$T; NV]> = vectors(states, 2.0);
            let x: Vec<[$T; NV]> = vectors(states, 5.0);
            let (qs, qds, xs) = (columns(&q), columns(&qd), columns(&x));
            let (qs, qds, xs) = (slices(&qs), slices(&qds), slices(&xs));
            let zero = vec![0.0 as $T; states];
            let vector = || -> [Vec<$T>; NV] { std::array::from_fn(|_| zero.clone()) };
            let matrix = || -> [[Vec<$T>; NV]; NV] { std::array::from_fn(|_| vector()) };
            let plains = |i: usize| (plain(&q[i]), plain(&qd[i]), plain(&x[i]));
            on_every_level(|fused| {
                let compare = |what: &str, found: Vec<[$T; NN]>, expected: Vec<[$T; NN]>| {
                    same(&found, &expected, fused, what);
                };
                let one = |i| {
                    let (q, qd, x) = plains(i);
                    <Name as Robot>::inverse_dynamics_derivatives(&q, &qd, &x)
                };
                let dq: Vec<_> = (0..states).map(|i| unwrap(one(i).dtau_dq)).collect();
                let dqd: Vec<_> = (0..states).map(|i| unwrap(one(i).dtau_dqd)).collect();
                let mut found = [matrix(), matrix()];
                let [a, b] = found.each_mut().map(|m| m.each_mut().map(slices_mut));
                Name::inverse_dynamics_derivatives_batch(qs, qds, xs, a, b).expect("sizes");
                compare("d tau / dq", matrices(&found[0], states), dq.clone());
                compare("d tau / dqd", matrices(&found[1], states), dqd.clone());
                let empty = modyn::InverseDynamicsDerivatives { dtau_dq: ZERO, dtau_dqd: ZERO };
                let mut each = vec![empty; states];
                Name::inverse_dynamics_derivatives_each(&q, &qd, &x, &mut each).expect("sizes");
                compare("d tau / dq", each.iter().map(|one| flat(&one.dtau_dq)).collect(), dq);
                compare("d tau / dqd", each.iter().map(|one| flat(&one.dtau_dqd)).collect(), dqd);

                let one = |i| {
                    let (q, qd, x) = plains(i);
                    <Name as Robot>::forward_dynamics_derivatives(&q, &qd, &x)
                };
                let qdd: Vec<_> = (0..states).map(|i| number(one(i).qdd)).collect();
                let dq: Vec<_> = (0..states).map(|i| unwrap(one(i).dqdd_dq)).collect();
                let dqd: Vec<_> = (0..states).map(|i| unwrap(one(i).dqdd_dqd)).collect();
                let dtau: Vec<_> = (0..states).map(|i| unwrap(one(i).dqdd_dtau)).collect();
                let (mut first, mut found) = (vector(), [matrix(), matrix(), matrix()]);
                let [a, b, c] = found.each_mut().map(|m| m.each_mut().map(slices_mut));
                let out = slices_mut(&mut first);
                Name::forward_dynamics_derivatives_batch(qs, qds, xs, out, a, b, c).expect("sizes");
                let back: Vec<[$T; NV]> =
                    (0..states).map(|i| std::array::from_fn(|j| first[j][i])).collect();
                same(&back, &qdd, fused, "accelerations");
                compare("d qdd / dq", matrices(&found[0], states), dq.clone());
                compare("d qdd / dqd", matrices(&found[1], states), dqd.clone());
                compare("d qdd / dtau", matrices(&found[2], states), dtau.clone());
                let empty = modyn::ForwardDynamicsDerivatives {
                    qdd: [0.0; NV],
                    dqdd_dq: ZERO,
                    dqdd_dqd: ZERO,
                    dqdd_dtau: ZERO,
                };
                let mut each = vec![empty; states];
                Name::forward_dynamics_derivatives_each(&q, &qd, &x, &mut each).expect("sizes");
                let back: Vec<[$T; NV]> = each.iter().map(|one| one.qdd).collect();
                same(&back, &qdd, fused, "accelerations");
                compare("d qdd / dq", each.iter().map(|one| flat(&one.dqdd_dq)).collect(), dq);
                compare("d qdd / dqd", each.iter().map(|one| flat(&one.dqdd_dqd)).collect(), dqd);
                compare(
                    "d qdd / dtau",
                    each.iter().map(|one| flat(&one.dqdd_dtau)).collect(),
                    dtau,
                );

                let factors: Vec<_> = (0..states)
                    .map(|i| number(*<Name as Robot>::brge(&plains(i).0).factors()))
                    .collect();
                let mut found: [Vec<$T>; Factors::FACTORS] = std::array::from_fn(|_| zero.clone());
                Name::brge_batch(qs, slices_mut(&mut found)).expect("sizes");
                let back: Vec<[$T; Factors::FACTORS]> =
                    (0..states).map(|i| std::array::from_fn(|j| found[j][i])).collect();
                same(&back, &factors, fused, "factors");
                let mut each = vec![Factors::from_factors([0.0; Factors::FACTORS]); states];
                Name::brge_each(&q, &mut each).expect("sizes");
                let found: Vec<_> = each.iter().map(|one| *one.factors()).collect();
                same(&found, &factors, fused, "factors");
                // The factors of a batch solve like the factors of one state.
                for (state, factors) in each.iter().enumerate() {
                    let (mass, solved) = (Name::mass_matrix(&q[state]), factors.solve(&x[state]));
                    let back: [$T; NV] =
                        std::array::from_fn(|i| (0..NV).map(|j| mass[j][i] * solved[j]).sum());
                    same(&[back], &[x[state]], true, "I I^-1 tau");
                }
            });
        }
    }};
}

#[test]
fn results_of_several_arrays() {
    several!(Arm, f64);
    several!(Mimic, f64);
    several!(Single, f32);
}

/// Compares batches of Hessians with the functions of one state.
macro_rules! hessians {
    ($Robot:ident, $T:ty) => {{
        type Name = second_order::$Robot;
        const NV: usize = Name::NV;
        const N: usize = 4 * (NV + NV * NV);
        const ZERO: [[$T; NV]; NV] = [[0.0; NV]; NV];
        // All numbers of a result, in the order of its fields.
        let flat = |vectors: [[$T; NV]; 4], matrices: [[[$T; NV]; NV]; 4]| -> [$T; N] {
            let matrices = matrices.as_flattened().as_flattened();
            [vectors.as_flattened(), matrices].concat().try_into().expect("all numbers")
        };
        for states in [0, 1, 7, 17, 40] {
            let mut uniform = numbers();
            let q: Vec<_> =
                (0..states).map(|_| Name::random_configuration(|| (0.5 + 0.5 * uniform()) as $T)).collect();
            let [qd, x, w] = [2.0, 5.0, 3.0].map(|size| -> Vec<[$T; NV]> { vectors(states, size) });
            let (qs, qds, xs, ws) = (columns(&q), columns(&qd), columns(&x), columns(&w));
            let (qs, qds, xs, ws) = (slices(&qs), slices(&qds), slices(&xs), slices(&ws));
            let vector = || -> [Vec<$T>; NV] { std::array::from_fn(|_| vec![0.0; states]) };
            let matrix = || -> [[Vec<$T>; NV]; NV] { std::array::from_fn(|_| vector()) };
            on_every_level(|fused| {
                macro_rules! compare {
                    ($Result:ident, $one:ident, $batch:ident, $each:ident, $value:ident, $last:ident, $mixed:ident) => {{
                        let expected: Vec<[$T; N]> = (0..states)
                            .map(|i| {
                                let (q, qd, x, w) =
                                    (plain(&q[i]), plain(&qd[i]), plain(&x[i]), plain(&w[i]));
                                let one = <Name as Robot>::$one::<Plain<$T>>(&q, &qd, &x, &w);
                                let matrices = [one.hess_q_q, one.hess_q_qd, one.hess_qd_qd, one.$mixed];
                                flat(
                                    [one.$value, one.grad_q, one.grad_qd, one.$last].map(number),
                                    matrices.map(|matrix| matrix.map(number)),
                                )
                            })
                            .collect();
                        let empty = modyn::$Result {
                            $value: [0.0; NV],
                            grad_q: [0.0; NV],
                            grad_qd: [0.0; NV],
                            $last: [0.0; NV],
                            hess_q_q: ZERO,
                            hess_q_qd: ZERO,
                            hess_qd_qd: ZERO,
                            $mixed: ZERO,
                        };
                        let mut each = vec![empty; states];
                        Name::$each(&q, &qd, &x, &w, &mut each).expect("sizes");
                        let found: Vec<[$T; N]> = each
                            .iter()
                            .map(|one| {
                                let matrices = [one.hess_q_q, one.hess_q_qd, one.hess_qd_qd, one.$mixed];
                                flat([one.$value, one.grad_q, one.grad_qd, one.$last], matrices)
                            })
                            .collect();
                        same(&found, &expected, fused, stringify!($each));
                        let (mut first, mut rest) = ([0; 4].map(|_| vector()), [0; 4].map(|_| matrix()));
                        let [a, b, c, d] = first.each_mut().map(slices_mut);
                        let [e, f, g, h] = rest.each_mut().map(|m| m.each_mut().map(slices_mut));
                        Name::$batch(qs, qds, xs, ws, a, b, c, d, e, f, g, h).expect("sizes");
                        let all: Vec<&Vec<$T>> =
                            first.as_flattened().iter().chain(rest.as_flattened().as_flattened()).collect();
                        let found: Vec<[$T; N]> =
                            (0..states).map(|i| std::array::from_fn(|k| all[k][i])).collect();
                        same(&found, &expected, fused, stringify!($batch));
                    }};
                }
                compare!(
                    InverseDynamicsHessian, inverse_dynamics_hessian, inverse_dynamics_hessian_batch,
                    inverse_dynamics_hessian_each, tau, grad_qdd, hess_q_qdd
                );
                compare!(
                    ForwardDynamicsHessian, forward_dynamics_hessian, forward_dynamics_hessian_batch,
                    forward_dynamics_hessian_each, qdd, grad_tau, hess_q_tau
                );
            });
        }
    }};
}

#[test]
fn hessians() {
    hessians!(Mimic, f64);
    hessians!(Single, f32);
}

#[test]
fn revolute_joints() {
    robot!(Gripper, f64);
    robot!(Arm, f64);
}

#[test]
fn single_precision() {
    robot!(Single, f32);
    robot!(FlyingSingle, f32);
}

#[test]
fn other_joints() {
    robot!(Zoo, f64);
}

#[test]
fn long_texts() {
    use long::Humanoid;
    const N: usize = Humanoid::NV;
    let [q, qd, tau]: [Vec<[f64; N]>; 3] = [3.0, 2.0, 5.0].map(|size| vectors(37, size));
    let expected: Vec<_> =
        (0..37).map(|i| alone!(Humanoid, f64, forward_dynamics, q[i], qd[i], tau[i])).collect();
    on_every_level(|fused| {
        let mut found = vec![[0.0; N]; 37];
        Humanoid::forward_dynamics_each(&q, &qd, &tau, &mut found).expect("sizes");
        same(&found, &expected, fused, "forward dynamics");
    });
}

#[test]
fn rollouts() {
    use modyn::simulate::State;
    use modyn::simulate::rollout::{Instant, rollout};
    use moved::Zoo;
    const N: usize = Zoo::NV;
    // Two blocks and a part of one.
    const MOTIONS: usize = 131;
    let [places, speeds, plans]: [Vec<[f64; N]>; 3] =
        [0.4, 1.0, 5.0].map(|size| vectors(MOTIONS, size));
    let starts: Vec<State<Zoo>> = (places.iter().zip(&speeds))
        .map(|(place, &qd)| {
            let mut uniforms = place.iter().map(|x| x + 0.5);
            State {
                q: Zoo::random_configuration(|| uniforms.next().expect("a number for each entry")),
                qd,
            }
        })
        .collect();
    // A plan with a feedback.
    let forces = |at: Instant, state: &State<Zoo>| -> [f64; N] {
        std::array::from_fn(|j| plans[at.motion][(j + at.step) % N] - 0.3 * state.qd[j])
    };
    let (mut motions, mut visited) = (starts.clone(), vec![Vec::new(); MOTIONS]);
    let visit = |at: Instant, tau: &[f64; N], state: &State<Zoo>| {
        visited[at.motion].push((at.step, *tau, state.clone()));
    };
    rollout(&mut motions, 7, 0.005, forces, Zoo::forward_dynamics_each, visit).expect("sizes");
    let close = |found: &[f64], expected: &[f64]| {
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() <= 1e-9 * (1.0 + b.abs()), "{a}, not {b}");
        }
    };
    for (i, start) in starts.iter().enumerate() {
        let mut state = start.clone();
        assert_eq!(visited[i].len(), 7);
        for (step, (own, applied, after)) in visited[i].iter().enumerate() {
            assert_eq!(*own, step);
            let tau = forces(Instant { motion: i, step }, &state);
            state = state
                .semi_implicit_euler(0.005, |now| Zoo::forward_dynamics(&now.q, &now.qd, &tau));
            close(applied, &tau);
            close(&after.q, &state.q);
            close(&after.qd, &state.qd);
        }
        assert_eq!(motions[i].q, visited[i][6].2.q);
        assert_ne!(motions[i].qd, start.qd);
    }
    let refused = rollout(&mut motions, 1, 0.005, forces, |_, _, _, _| Err("no"), |_, _, _| {});
    assert_eq!(refused, Err("no"));
}

/// Returns parameters that differ from those of the description.
macro_rules! parameters_of {
    ($params:ident) => {{
        let mut params = $params::DEFAULT;
        params.set_gravity([1.0, -2.0, 3.0]);
        let inertia = [0.02, 0.001, 0.0, 0.03, 0.0, 0.04];
        let load = modyn::Inertial { mass: 1.5, center_of_mass: [0.1, 0.2, 0.3], inertia };
        params.set_payload_of_link7(load).expect("a rigid body");
        params
    }};
}

#[test]
fn parameters() {
    const STATES: usize = 19;
    let [q, qd, tau]: [Vec<[f64; 7]>; 3] = [3.0, 2.0, 5.0].map(|size| vectors(STATES, size));
    let params = parameters_of!(ArmParams);
    let expected = |i: usize| {
        let [q, qd, tau] = [q[i], qd[i], tau[i]].map(|x| plain(&x));
        number(<Arm as Robot>::forward_dynamics_with(&params.map(Plain), &q, &qd, &tau))
    };
    let expected: Vec<_> = (0..STATES).map(expected).collect();
    on_every_level(|fused| {
        let mut each = vec![[0.0; 7]; STATES];
        Arm::forward_dynamics_each_with(&params, &q, &qd, &tau, &mut each).expect("sizes");
        same(&each, &expected, fused, "forward dynamics");
        let (q, qd, tau) = (columns(&q), columns(&qd), columns(&tau));
        let mut found = columns(&[[0.0; 7]; STATES]);
        let out = slices_mut(&mut found);
        Arm::forward_dynamics_batch_with(&params, slices(&q), slices(&qd), slices(&tau), out)
            .expect("sizes");
        let found: Vec<_> = (0..STATES).map(|i| std::array::from_fn(|j| found[j][i])).collect();
        same(&found, &expected, fused, "forward dynamics");
    });
}

#[test]
fn parameters_of_several_arrays() {
    use several::{Arm, ArmParams};
    const STATES: usize = 19;
    let [q, qd, tau]: [Vec<[f64; 7]>; 3] = [3.0, 2.0, 5.0].map(|size| vectors(STATES, size));
    let params = parameters_of!(ArmParams);
    let expected = |i: usize| {
        let [q, qd, tau] = [q[i], qd[i], tau[i]].map(|x| plain(&x));
        <Arm as Robot>::forward_dynamics_derivatives_with(&params.map(Plain), &q, &qd, &tau)
    };
    let expected: Vec<[f64; 49]> = (0..STATES)
        .map(|i| expected(i).dqdd_dq.map(number).as_flattened().try_into().expect("a square"))
        .collect();
    on_every_level(|fused| {
        let zero = [[0.0; 7]; 7];
        let empty = modyn::ForwardDynamicsDerivatives {
            qdd: [0.0; 7],
            dqdd_dq: zero,
            dqdd_dqd: zero,
            dqdd_dtau: zero,
        };
        let mut each = vec![empty; STATES];
        Arm::forward_dynamics_derivatives_each_with(&params, &q, &qd, &tau, &mut each)
            .expect("sizes");
        let found: Vec<[f64; 49]> = each
            .iter()
            .map(|one| one.dqdd_dq.as_flattened().try_into().expect("a square"))
            .collect();
        same(&found, &expected, fused, "d qdd / dq");
    });
}

/// Huge angles and NaN in one state change no other state.
#[test]
fn states_do_not_disturb_each_other() {
    const STATES: usize = 32;
    let [q, qd, tau]: [Vec<[f64; 7]>; 3] = [3.0, 2.0, 5.0].map(|size| vectors(STATES, size));
    let forward = |q: &Vec<[f64; 7]>| {
        let mut qdd = vec![[0.0; 7]; STATES];
        Arm::forward_dynamics_each(q, &qd, &tau, &mut qdd).expect("sizes");
        qdd
    };
    on_every_level(|fused| {
        let good = forward(&q);
        for odd in [f64::NAN, f64::INFINITY, 1e9, -3e5] {
            for state in [0, 3, 17, 31] {
                let mut q = q.clone();
                q[state][2] = odd;
                let found = forward(&q);
                let expected = alone!(Arm, f64, forward_dynamics, q[state], qd[state], tau[state]);
                for i in 0..STATES {
                    if i != state {
                        assert_eq!(found[i], good[i], "beside {odd}");
                    } else if odd.is_finite() {
                        same(&[found[i]], &[expected], fused, "a huge angle");
                    } else {
                        assert!(found[i].iter().any(|x| x.is_nan()));
                    }
                }
            }
        }
    });
}

/// Huge angles and NaN in one state change no other state's derivatives.
#[test]
fn derivatives_do_not_disturb_each_other() {
    use several::Arm;
    const STATES: usize = 17;
    let [q, qd, tau]: [Vec<[f64; 7]>; 3] = [3.0, 2.0, 5.0].map(|size| vectors(STATES, size));
    let derivatives = |q: &Vec<[f64; 7]>| {
        let zero = [[0.0; 7]; 7];
        let mut found =
            vec![modyn::InverseDynamicsDerivatives { dtau_dq: zero, dtau_dqd: zero }; STATES];
        Arm::inverse_dynamics_derivatives_each(q, &qd, &tau, &mut found).expect("sizes");
        found
    };
    on_every_level(|_| {
        let good = derivatives(&q);
        for state in [0, 3, 16] {
            let mut q = q.clone();
            q[state][2] = f64::NAN;
            let found = derivatives(&q);
            assert!(found[state].dtau_dq.as_flattened().iter().any(|x| x.is_nan()));
            for i in (0..STATES).filter(|&i| i != state) {
                assert_eq!(found[i], good[i]);
            }
        }
    });
}

#[test]
fn wrong_lengths() {
    let good = [0.0; 6];
    let (q, bad) = ([&good[..]; 7], [0.0; 5]);
    let message = |error: modyn::BatchError| error.to_string();
    let mut out: [Vec<f64>; 7] = std::array::from_fn(|_| vec![1.0; 6]);
    let mut tau = q;
    tau[3] = &bad;
    let error = Arm::forward_dynamics_batch(q, q, tau, slices_mut(&mut out)).expect_err("a length");
    assert_eq!((error.argument, error.states, error.expected), ("tau", 5, 6));
    assert_eq!(
        message(error),
        format!("`tau[3]` ({}) holds 5 states, `q[0]` holds 6", Arm::VELOCITY_NAMES[3])
    );
    assert!(out.iter().flatten().all(|&x| x == 1.0), "nothing was written");
    out[6].push(1.0);
    let error = Arm::forward_dynamics_batch(q, q, q, slices_mut(&mut out)).expect_err("a length");
    assert_eq!((error.argument, error.coordinate.expect("one").0), ("qdd", 6));

    let mut matrix: [[Vec<f64>; 7]; 7] =
        std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; 6]));
    matrix[2][1].pop();
    let error = Arm::mass_matrix_batch(q, matrix.each_mut().map(slices_mut)).expect_err("a length");
    assert!(message(error).starts_with("`mass_matrix[2][1]` ("), "{error}");

    let error = Arm::kinetic_energy_batch(q, q, &mut [0.0; 7]).expect_err("a length");
    assert_eq!(message(error), "`kinetic_energy` holds 7 states, `q[0]` holds 6");
    let (six, five) = ([[0.0; 7]; 6], [[0.0; 7]; 5]);
    let error = Arm::bias_forces_each(&six, &five, &mut six.clone()).expect_err("a length");
    assert_eq!(message(error), "`qd` holds 5 states, `q` holds 6");
    let error = Arm::bias_forces_each(&six, &six, &mut five.clone()).expect_err("a length");
    assert_eq!(message(error), "`bias_forces` holds 5 states, `q` holds 6");
}

#[test]
fn wrong_lengths_of_several_arrays() {
    use several::{Arm, ArmUduFactorization};
    const FACTORS: usize = ArmUduFactorization::<f64>::FACTORS;
    let good = [0.0; 6];
    let q = [&good[..]; 7];
    let mut dq: [[Vec<f64>; 7]; 7] = std::array::from_fn(|_| std::array::from_fn(|_| vec![1.0; 6]));
    let mut dqd = dq.clone();
    dqd[2][1].pop();
    let [a, b] = [&mut dq, &mut dqd].map(|matrix| matrix.each_mut().map(slices_mut));
    let error = Arm::inverse_dynamics_derivatives_batch(q, q, q, a, b).expect_err("a length");
    assert_eq!((error.argument, error.states, error.expected), ("dtau_dqd", 5, 6));
    let expected =
        format!("`dtau_dqd[2][1]` ({}) holds 5 states, `q[0]` holds 6", Arm::VELOCITY_NAMES[1]);
    assert_eq!(error.to_string(), expected);
    assert!(dq.iter().flatten().flatten().all(|&x| x == 1.0), "nothing was written");

    let mut factors: [Vec<f64>; FACTORS] = std::array::from_fn(|_| vec![0.0; 6]);
    factors[9].push(0.0);
    let error = Arm::brge_batch(q, slices_mut(&mut factors)).expect_err("a length");
    assert_eq!(error.to_string(), "`factors[9]` holds 7 states, `q[0]` holds 6");

    let zero = [[0.0; 7]; 7];
    let mut five = [modyn::InverseDynamicsDerivatives { dtau_dq: zero, dtau_dqd: zero }; 5];
    let six = [[0.0; 7]; 6];
    let error =
        Arm::inverse_dynamics_derivatives_each(&six, &six, &six, &mut five).expect_err("a length");
    assert_eq!(error.to_string(), "`derivatives` holds 5 states, `q` holds 6");
    let mut seven = [ArmUduFactorization::from_factors([0.0; FACTORS]); 7];
    let error = Arm::brge_each(&six, &mut seven).expect_err("a length");
    assert_eq!(error.to_string(), "`brge` holds 7 states, `q` holds 6");
}

/// Batches on all cores give the same numbers.
#[test]
fn in_parallel() {
    let _alone = alone();
    for states in [0, 5, 511, 512, 2050] {
        let [q, qd, tau]: [Vec<[f64; 7]>; 3] = [3.0, 2.0, 5.0].map(|size| vectors(states, size));
        let (q, qd, tau) = (columns(&q), columns(&qd), columns(&tau));
        let (q, qd, tau) = (slices(&q), slices(&qd), slices(&tau));
        let mut found: [[Vec<f64>; 7]; 2] =
            std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; states]));
        let [one, all] = &mut found;
        Arm::forward_dynamics_batch(q, qd, tau, slices_mut(one)).expect("sizes");
        Arm::forward_dynamics_batch_par(q, qd, tau, slices_mut(all)).expect("sizes");
        assert!(one == all, "{states} states");

        let mut found: [[Vec<f64>; several::ArmUduFactorization::<f64>::FACTORS]; 2] =
            std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; states]));
        let [one, all] = &mut found;
        several::Arm::brge_batch(q, slices_mut(one)).expect("sizes");
        several::Arm::brge_batch_par(q, slices_mut(all)).expect("sizes");
        assert!(one == all, "{states} states");
    }
}
