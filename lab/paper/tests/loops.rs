//! Closed loops (Conclusions of the paper: cut joints): compiled results equal interpreted ones, through the type's own
//! functions and the trait.

use modyn::equations::constraints::{ConstrainedOutputs, ProjectionOutputs, ResidualOutputs};
use modyn::equations::{self, ForwardInput};
use modyn::simulate::State;
use modyn::spatial::{Twist, Wrench};
use modyn::{ConstraintSettings, ContactTarget, Interpreter, Robot, functions};

modyn::modyn!("../../../robots/four_bar.urdf");
modyn::modyn!("mechanisms/rotated_four_bar.urdf");
modyn::modyn!("mechanisms/bennett.urdf");
modyn::modyn! {
    Bound = "../../../robots/arm6.urdf",
    functions = [constrained_forward_dynamics, constraint_residual, project_constraints],
    runtime_gravity = true,
    loops = [
        "hold": revolute("base_link", [0.4, 0.1, 0.5], [0.1, 0.2, 0.3], "tool", [0.0, 0.0, 0.1], axis = [0, 0, 2]),
    ]
}

fn numbers<const N: usize>(wrenches: &[Wrench<f64>; N]) -> Vec<f64> {
    wrenches.iter().flat_map(Wrench::components).collect()
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= 1e-9 * (1.0 + b.abs()), "{found:?} instead of {expected:?}");
    }
}

/// Returns the quantities of a robot at a state, one after the other, compiled and interpreted.
fn compared<R, const N: usize>(model: modyn::model::Model, [q, qd, tau]: [[f64; N]; 3])
where
    R: Robot<Q<f64> = [f64; N], V<f64> = [f64; N]> + functions::Constraints,
    R: Robot<
            Contacts = (),
            PerContact<ContactTarget<f64>> = [ContactTarget<f64>; 0],
            PerConstraint<Wrench<f64>> = [Wrench<f64>; 1],
            PerConstraint<Twist<f64>> = [Twist<f64>; 1],
        >,
{
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let mut interpreter = Interpreter::new(model);
    let (mut qdd, mut wrenches, mut residuals) = ([0.0; N], [Wrench::zero()], [Twist::zero()]);
    let into =
        ConstrainedOutputs { qdd: &mut qdd, wrenches: &mut wrenches, residuals: &mut residuals };
    let solve = Interpreter::constrained_forward_dynamics;
    let rank =
        solve(&mut interpreter, ForwardInput { q: &q, qd: &qd, tau: &tau }, &[], &settings, into)
            .expect("fits");
    let found = R::constrained_forward_dynamics(&q, &qd, &tau, (), &settings);
    assert_near(&found.qdd, &qdd);
    assert_near(&numbers(&found.wrenches), &numbers(&wrenches));
    assert_near(&found.residuals[0].components(), &residuals[0].components());
    assert_eq!(found.rank, rank);

    let (mut displacements, mut velocities) = ([Twist::zero()], [Twist::zero()]);
    interpreter
        .constraint_residual(
            equations::State { q: &q, qd: &qd },
            &settings,
            ResidualOutputs { displacements: &mut displacements, velocities: &mut velocities },
        )
        .expect("fits");
    let found = R::constraint_residual(&q, &qd, &settings);
    assert_near(&found.displacements[0].components(), &displacements[0].components());
    assert_near(&found.velocities[0].components(), &velocities[0].components());

    let (mut dq, mut dqd) = ([0.0; N], [0.0; N]);
    let into = ProjectionOutputs { step_q: &mut dq, step_qd: &mut dqd };
    let rank = interpreter
        .project_constraints(equations::State { q: &q, qd: &qd }, &[], &settings, into)
        .expect("fits");
    let found = R::project_constraints(&q, &qd, (), &settings);
    assert_near(&found.step_q, &dq);
    assert_near(&found.step_qd, &dqd);
    assert_eq!(found.rank, rank);
}

fn read(text: &str, options: &modyn_codegen::ReadOptions) -> modyn::model::Model {
    modyn_codegen::read(text, "robot.urdf", options)
        .unwrap_or_else(|errors| panic!("{errors}"))
        .model
}

#[test]
fn compiled_loops_are_interpreted_loops() {
    let model = read(include_str!("../../../robots/four_bar.urdf"), &Default::default());
    let states = [[0.3, 1.2, 2.0], [1.0, -2.0, 0.5], [0.2, 0.0, -0.1]];
    compared::<FourBar, 3>(model, states);
    assert_eq!(FourBar::LOOP_CONSTRAINT_NAMES, ["rocker_pin"]);
    assert_eq!(<FourBar as Robot>::LOOP_CONSTRAINT_NAMES, ["rocker_pin"]);

    let end = |link: &str, xyz, rpy| modyn_codegen::LoopEnd { link: link.into(), xyz, rpy };
    let closing = modyn_codegen::Loop {
        name: "hold".into(),
        kind: modyn_codegen::LoopConstraintKind::Revolute([0.0, 0.0, 1.0]),
        ends: [
            end("base_link", [0.4, 0.1, 0.5], [0.1, 0.2, 0.3]),
            end("tool", [0.0, 0.0, 0.1], [0.0; 3]),
        ],
    };
    let options = modyn_codegen::ReadOptions { loops: vec![closing], ..Default::default() };
    let model = read(include_str!("../../../robots/arm6.urdf"), &options);
    let states = [
        [0.3, -1.2, 1.5, 0.4, 0.9, -0.2],
        [0.5, -0.4, 0.3, -0.2, 0.1, 0.6],
        [1.0, 20.0, -5.0, 0.5, 0.3, -0.1],
    ];
    compared::<Bound, 6>(model, states);
}

/// Returns coordinates and velocities that close the loops, from others near them.
fn closed<R, const N: usize>(q: [f64; N], qd: [f64; N]) -> [[f64; N]; 2]
where
    R: Robot<Q<f64> = [f64; N], V<f64> = [f64; N]> + functions::Defaults + functions::Constraints,
    R: Robot<Contacts = (), PerContact<ContactTarget<f64>> = [ContactTarget<f64>; 0]>,
{
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let q = (0..20).fold(q, |q, _| {
        R::integrate::<f64>(&q, &R::project_constraints(&q, &qd, (), &settings).step_q)
    });
    let change = R::project_constraints(&q, &qd, (), &settings).step_qd;
    [q, std::array::from_fn(|i| qd[i] + change[i])]
}

#[allow(clippy::cast_possible_truncation)]
fn single<const N: usize>(x: &[f64; N]) -> [f32; N] {
    x.map(|x| x as f32)
}

#[test]
fn compiled_linkages_do_not_depend_on_their_axes() {
    let [q, qd] = closed::<FourBar, 3>([1.2, -0.6, 2.0], [3.0, 0.0, 0.0]);
    let tau = [0.1, 0.2, -0.3];
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let expected = FourBar::constrained_forward_dynamics(&q, &qd, &tau, (), &settings);
    let found = RotatedFourBar::constrained_forward_dynamics(&q, &qd, &tau, (), &settings);
    assert_near(&found.qdd, &expected.qdd);
    assert_eq!((found.rank, expected.rank), (2.0, 2.0));
    let settings = ConstraintSettings::<f32>::DEFAULT;
    let (q, qd, tau) = (single(&q), single(&qd), single(&tau));
    let found =
        <RotatedFourBar as Robot>::constrained_forward_dynamics(&q, &qd, &tau, (), &settings);
    for (a, b) in found.qdd.iter().zip(&expected.qdd) {
        assert!((f64::from(*a) - b).abs() < 1e-3 * (1.0 + b.abs()), "{found:?}");
    }
    assert_eq!(found.rank, 2.0);
}

#[test]
fn a_compiled_bennett_linkage_moves() {
    let near = [1.1 + 0.02, 2.798_542_182_184_737_4, -1.1];
    let [q, qd] = closed::<Bennett, 3>(near, [2.0, -0.5, -2.0]);
    let missed = Bennett::constraint_residual(&q, &qd, &ConstraintSettings::<f64>::DEFAULT);
    let all = [missed.displacements[0].components(), missed.velocities[0].components()].concat();
    assert!(all.iter().all(|x| x.abs() < 1e-13), "{missed:?}");
    assert!(qd[0].abs() > 0.1, "{qd:?}");
    let model = read(include_str!("mechanisms/bennett.urdf"), &Default::default());
    compared::<Bennett, 3>(model, [q, qd, [0.3, 0.1, -0.2]]);
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let tau = [0.3, 0.1, -0.2];
    let found = Bennett::constrained_forward_dynamics(&q, &qd, &tau, (), &settings);
    assert_eq!(found.rank, 2.0);
    assert!(found.residuals[0].components().iter().all(|x| x.abs() < 1e-9), "{found:?}");
    let settings = ConstraintSettings::<f32>::DEFAULT;
    let (q, qd, tau) = (single(&q), single(&qd), single(&tau));
    let again = <Bennett as Robot>::constrained_forward_dynamics(&q, &qd, &tau, (), &settings);
    assert_eq!(again.rank, 2.0);
    for (a, b) in again.qdd.iter().zip(&found.qdd) {
        assert!((f64::from(*a) - b).abs() < 1e-3 * (1.0 + b.abs()), "{again:?}");
    }
}

/// The crank moves freely for a second, by the Runge-Kutta method on generated code alone.
#[test]
fn a_compiled_four_bar_linkage_keeps_its_energy() {
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let (mut q, qd) = ([1.2, -0.6, 2.0], [0.0; 3]);
    for _ in 0..20 {
        let step = FourBar::project_constraints(&q, &qd, (), &settings).step_q;
        q = FourBar::integrate(&q, &step);
    }
    let gap = |q: &[f64; 3]| {
        let found = FourBar::constraint_residual(q, &[0.0; 3], &settings).displacements[0];
        found.components().into_iter().fold(0.0_f64, |most, x| most.max(x.abs()))
    };
    assert!(gap(&q) < 1e-14, "{}", gap(&q));
    let energy =
        |q: &[f64; 3], qd: &[f64; 3]| FourBar::kinetic_energy(q, qd) + FourBar::potential_energy(q);
    let before = energy(&q, &qd);
    let mut state = State::<FourBar>::at_rest(q);
    for _ in 0..1000 {
        state = state.runge_kutta_4(1e-3, |State { q, qd }| {
            FourBar::constrained_forward_dynamics(q, qd, &[0.0; 3], (), &settings).qdd
        });
    }
    let State { q, qd } = state;
    assert!((energy(&q, &qd) - before).abs() < 1e-6, "{} {before}", energy(&q, &qd));
    assert!(gap(&q) < 1e-8 && FourBar::kinetic_energy(&q, &qd) > 1e-3);
}
