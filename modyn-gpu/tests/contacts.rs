//! Rollouts that hold contacts: a quadruped falls on its feet and stands, as the interpreter's constrained dynamics say.

use crate::common;
use modyn_runtime::equations::ForwardInput;
use modyn_runtime::equations::constraints::ConstrainedOutputs;

use modyn_codegen::{
    Base, Builder, Contact, ContactKind, Function, FusedFunction, LoopEnd, RolloutForces,
    RolloutOptions,
};
use modyn_gpu::{Gpu, Rollout, RolloutArguments};
use modyn_runtime::equations::TimeStepInput;
use modyn_runtime::equations::soft_constraints::StepInput;
use modyn_runtime::{
    ConstraintSettings, ContactSurface, ContactTarget, Interpreter, StepSettings,
    StepSolutionOutputs, Twist, Wrench,
};

use crate::conformance::robot;

const FEET: [&str; 4] =
    ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];
const DT: f32 = 0.002;
const STEPS: usize = 90;
const STIFF: f64 = 8.0;
const DAMPED: f64 = 0.1;

/// Springs and dampers hold the legs.
const FORCES: &str = "
fn forces(q: array<f32, 19>, qd: array<f32, 18>, u: array<f32, 12>, step: u32) -> array<f32, 18> {
    var coordinates = q;
    var rates = qd;
    var goals = u;
    var tau: array<f32, 18>;
    for (var j = 0; j < 12; j++) {
        tau[6 + j] = 8.0 * (goals[j] - coordinates[7 + j]) - 0.1 * rates[6 + j];
    }
    return tau;
}";

/// A foot below the ground may be in contact.
const CONTACTS: &str = "
fn active_contacts(q: array<f32, 19>, qd: array<f32, 18>, u: array<f32, 12>, step: u32) -> array<f32, 4> {
    let feet = quadruped_feet(q);
    let touches = vec4<f32>(feet[11], feet[23], feet[35], feet[47]) < vec4<f32>(0.0);
    return array<f32, 4>(f32(touches.x), f32(touches.y), f32(touches.z), f32(touches.w));
}";

fn quadruped() -> Builder {
    let contact = |link: &str| Contact {
        name: link.into(),
        kind: ContactKind::Point,
        end: LoopEnd { link: link.into(), xyz: [0.0; 3], rpy: [0.0; 3] },
    };
    let feet = FEET
        .iter()
        .fold(FusedFunction::new("feet"), |feet, link| feet.of_link(Function::LinkPose, *link));
    robot("quadruped")
        .base(Base::Floating)
        .contacts(FEET.map(contact))
        .functions([Function::ConstrainedForwardDynamics, Function::Integrate])
        .fused([feet])
}

/// Returns settings that stop a foot within a step.
fn settings() -> ConstraintSettings<f64, [ContactTarget<f64>; 4]> {
    let stop = 0.5 / f64::from(DT);
    let target = ContactTarget { alpha: stop, beta: 20.0, ..ContactTarget::<f64>::GROUND };
    let default = ConstraintSettings::<f64, [ContactTarget<f64>; 4]>::DEFAULT;
    ConstraintSettings { tolerance: 1e-8, rounding: 1e-5, targets: [target; 4], ..default }
}

/// Returns the state after the steps in double precision, and the heights of the feet.
fn expected(q: &[f64], goals: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut interpreter = Interpreter::<f64>::new(quadruped().plan().expect("good").model);
    let frames = FEET.map(|foot| interpreter.model().link_index(foot).expect("a foot"));
    let settings = settings();
    let (mut q, mut qd) = (q.to_vec(), vec![0.0; 18]);
    let mut heights = vec![];
    for _ in 0..STEPS {
        heights = frames
            .iter()
            .map(|&foot| interpreter.link_pose(&q, foot).expect("lengths").translation[2])
            .collect();
        let mut held: Vec<bool> = heights.iter().map(|height| *height < 0.0).collect();
        let mut tau = vec![0.0; 18];
        for j in 0..12 {
            tau[6 + j] = STIFF * (goals[j] - q[7 + j]) - DAMPED * qd[6 + j];
        }
        let mut qdd = vec![0.0; 18];
        for _ in 0..2 {
            let (mut wrenches, mut residuals) = ([Wrench::zero(); 4], [Twist::zero(); 4]);
            let outputs = ConstrainedOutputs {
                qdd: &mut qdd,
                wrenches: &mut wrenches,
                residuals: &mut residuals,
            };
            interpreter
                .constrained_forward_dynamics(
                    ForwardInput { q: &q, qd: &qd, tau: &tau },
                    &held,
                    &settings,
                    outputs,
                )
                .expect("lengths");
            for (held, wrench) in held.iter_mut().zip(&wrenches) {
                *held &= wrench.force.0[2] >= 0.0;
            }
        }
        let dt = f64::from(DT);
        qd.iter_mut().zip(&qdd).for_each(|(x, a)| *x += dt * a);
        let moved: Vec<f64> = qd.iter().map(|x| dt * x).collect();
        let mut next = vec![0.0; 19];
        interpreter.integrate(&q, &moved, &mut next).expect("lengths");
        q = next;
    }
    (q, heights)
}

#[test]
fn a_quadruped_lands_and_stands() {
    let gpu = Gpu::new().expect("a processor");
    let forces = RolloutForces { text: FORCES.into(), controls: 12 };
    let options = RolloutOptions {
        forces: Some(forces),
        active_contacts: Some(CONTACTS.into()),
        ..RolloutOptions::default()
    };
    let rollout = Rollout::new(&gpu, &quadruped(), &options).expect("kernels");
    assert_eq!(
        rollout.source().rollouts[0].settings,
        ConstraintSettings::<f64>::COUNT + 4 * ContactTarget::<f64>::COUNT
    );
    let goals = [0.05, 0.7, -1.45].repeat(4);
    // Three heights, and a tilt: some feet land before others.
    let start = |height: f64| {
        let (s, c) = 0.02_f64.sin_cos();
        [&[0.1, -0.2, height, s, 0.0, 0.0, c][..], &goals].concat()
    };
    let starts: Vec<Vec<f64>> = [0.25, 0.255, 0.26].map(start).into();
    let q = gpu.upload(&common::columns(&starts), 3).expect("room");
    let qd = gpu.upload(&[0.0; 54], 3).expect("room");
    let controls: Vec<f32> =
        goals.repeat(STEPS).iter().flat_map(|goal| [*goal as f32; 3]).collect();
    let controls = gpu.upload(&controls, 3).expect("room");
    let all = settings();
    let numbers = all.numbers().into_iter().chain(all.targets.iter().flat_map(|c| c.numbers()));
    let numbers: Vec<f32> = numbers.map(|x| x as f32).collect();
    let numbers = gpu.upload(&numbers, 1).expect("room");
    let arguments = RolloutArguments {
        step: Function::ConstrainedForwardDynamics,
        settings: Some(&numbers),
        ..RolloutArguments::new(&q, &qd, &controls, DT)
    };
    let found = rollout.run(&arguments).expect("it runs").state.read().expect("numbers");
    for (i, start) in starts.iter().enumerate() {
        let (state, heights) = expected(start, &goals);
        assert!(heights.iter().all(|height| height.abs() < 5e-3), "{heights:?}");
        for (j, x) in state.iter().enumerate() {
            let error = (f64::from(found[3 * j + i]) - x).abs();
            assert!(error < 3e-3, "rollout {i}, number {j}: {} and {x}", found[3 * j + i]);
        }
    }
    // Settings of another length are refused, and the default ones are those of the interpreter.
    let short = RolloutArguments { settings: Some(&q), ..arguments };
    let error = rollout.run(&short).expect_err("too few").to_string();
    assert!(error.contains("takes 100 numbers a state as `settings`, not 19"), "{error}");
    assert!(rollout.run(&RolloutArguments { settings: None, ..arguments }).is_ok());
}

/// Returns the state after the steps of the solver in double precision, and the forces of the last step.
fn expected_by_solver(start: &[f64], goals: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let builder = quadruped().functions([Function::Step]);
    let mut interpreter = Interpreter::<f64>::new(builder.plan().expect("good").model);
    let settings = StepSettings::<f64, [ContactSurface<f64>; 4]>::DEFAULT;
    let mut q = start.to_vec();
    let mut qd = vec![0.0; 18];
    let mut qdd = vec![0.0; 18];
    let mut forces = vec![0.0; 12];
    for _ in 0..STEPS {
        let mut tau = vec![0.0; 18];
        for j in 0..12 {
            tau[6 + j] = STIFF * (goals[j] - q[7 + j]) - DAMPED * qd[6 + j];
        }
        let warm_start = qdd.clone();
        let dt = f64::from(DT);
        let step = TimeStepInput { q: &q, qd: &qd, tau: &tau, dt };
        let input = StepInput { step, warm_start: &warm_start };
        let mut next_q = q.clone();
        let mut next_qd = qd.clone();
        let [mut residual, mut iterations] = [0.0; 2];
        let outputs = StepSolutionOutputs {
            q: &mut next_q,
            qd: &mut next_qd,
            qdd: &mut qdd,
            forces: &mut forces,
            residual: &mut residual,
            iterations: &mut iterations,
        };
        interpreter.step(input, &settings, outputs).expect("lengths");
        assert!(residual <= settings.tolerance && iterations < 12.0, "{residual} {iterations}");
        q = next_q;
        qd = next_qd;
    }
    (q, forces)
}

/// The same quadruped under soft constraints: each step starts from the accelerations of the last.
#[test]
fn a_quadruped_lands_by_soft_constraints() {
    let gpu = Gpu::new().expect("a processor");
    let forces = RolloutForces { text: FORCES.into(), controls: 12 };
    let options = RolloutOptions { forces: Some(forces), ..RolloutOptions::default() };
    let builder = quadruped().functions([Function::Step]);
    let rollout = Rollout::new(&gpu, &builder, &options).expect("kernels");
    let goals = [0.05, 0.7, -1.45].repeat(4);
    let starts: Vec<Vec<f64>> = [0.25, 0.26, 0.27]
        .map(|height| {
            [&[0.1, -0.2, height, 0.02_f64.sin(), 0.0, 0.0, 0.02_f64.cos()][..], &goals].concat()
        })
        .into();
    let q = gpu.upload(&common::columns(&starts), 3).expect("room");
    let qd = gpu.upload(&[0.0; 54], 3).expect("room");
    let controls: Vec<f32> =
        goals.repeat(STEPS).iter().flat_map(|goal| [*goal as f32; 3]).collect();
    let controls = gpu.upload(&controls, 3).expect("room");
    let step = Function::Step;
    let arguments = RolloutArguments { step, ..RolloutArguments::new(&q, &qd, &controls, DT) };
    let last = rollout.run(&arguments).expect("it runs").state.read().expect("numbers");
    for (i, start) in starts.iter().enumerate() {
        let (state, forces) = expected_by_solver(start, &goals);
        assert!(forces.iter().filter(|force| **force != 0.0).count() > 6, "{forces:?}");
        for (j, x) in state.iter().enumerate() {
            let error = (f64::from(last[3 * j + i]) - x).abs();
            assert!(error < 3e-4, "rollout {i}, number {j}: {} and {x}", last[3 * j + i]);
        }
    }
    // The default settings are those of the interpreter; others have as many numbers.
    let count = rollout.source().rollouts[0].settings;
    assert_eq!(count, StepSettings::<f64>::COUNT + 4 * ContactSurface::<f64>::COUNT);
    let short = RolloutArguments { settings: Some(&q), ..arguments };
    let error = rollout.run(&short).expect_err("too few").to_string();
    assert!(error.contains(&format!("takes {count} numbers a state as `settings`")), "{error}");
}
