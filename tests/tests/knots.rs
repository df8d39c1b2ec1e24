//! Knots of optimal control against differences of the step and against the other derivatives, and their programs, on
//! scalars and packed, against the interpreter.

use modyn_codegen::plan::Planned;
use modyn_codegen::{Base, Builder, CodeForm, ContactKind, Planning};
use modyn_runtime::equations::constraints::ConstrainedOutputs;
use modyn_runtime::equations::{ForwardInput, TimeStepInput};
use modyn_runtime::model::Model;
use modyn_runtime::quantities::{Function, Shape};
use modyn_runtime::{
    ConstrainedKnotOutputs, ConstraintSettings, ContactTarget, Interpreter, KnotOutputs,
    StepOutputs, Twist, Wrench,
};
use modyn_tests::close::assert_close;
use modyn_tests::conformance::{contact, robot};
use modyn_tests::golden;
use modyn_tests::quantities::Quantities;
use modyn_tests::random::{self, State};

const LENGTHS: &str = "the lengths are right";
const DT: f64 = 0.03;

type Settings = ConstraintSettings<f64, [ContactTarget<f64>; 3]>;

/// A knot with its numbers in vectors.
struct Knot {
    qd: Vec<f64>,
    /// The derivatives of the velocities with respect to q, qd and tau.
    matrices: [Vec<f64>; 3],
    /// The blocks at quaternions.
    blocks: [Vec<f64>; 2],
}

impl Knot {
    fn new(model: &Model) -> Self {
        let n = model.nv();
        let blocks = 36 * model.quaternions().count();
        Self {
            qd: vec![f64::NAN; n],
            matrices: core::array::from_fn(|_| vec![f64::NAN; n * n]),
            blocks: core::array::from_fn(|_| vec![f64::NAN; blocks]),
        }
    }

    fn outputs(&mut self) -> KnotOutputs<'_, f64> {
        let [dqd_dq, dqd_dqd, dqd_dtau] = &mut self.matrices;
        let [dq_dq, dq_dv] = &mut self.blocks;
        KnotOutputs { qd: &mut self.qd, dqd_dq, dqd_dqd, dqd_dtau, dq_dq, dq_dv }
    }

    /// Returns the derivatives of the coordinates (the block-diagonal matrix of `blocks` and ones)
    /// times a vector.
    fn moved(&self, model: &Model, blocks: usize, x: &[f64]) -> Vec<f64> {
        let mut moved = x.to_vec();
        let mut next = self.blocks[blocks].chunks(36);
        for (i, link) in model.moving_links().iter().enumerate() {
            let place = model.v_range(i);
            let block = match (place.len(), link.joint.joint_type.nq()) {
                (6, 7) => 0,
                (3, 4) => 3,
                _ => continue,
            };
            let rows = next.next().expect("a block of each quaternion").chunks(6).skip(block);
            for (i, row) in place.clone().zip(rows) {
                moved[i] = row[block..].iter().zip(&x[place.clone()]).map(|(a, x)| a * x).sum();
            }
        }
        moved
    }

    /// Returns the columns of A, then of B.
    fn columns(&self, model: &Model) -> Vec<f64> {
        let n = model.nv();
        let column = |k: usize| {
            let column: Vec<f64> = (0..n).map(|i| self.matrices[k / n][n * i + k % n]).collect();
            let by: Vec<f64> = column.iter().map(|x| DT * x).collect();
            let mut moved = self.moved(model, 1, &by);
            if k < n {
                let unit: Vec<f64> = (0..n).map(|i| if i == k { 1.0 } else { 0.0 }).collect();
                let by_start = self.moved(model, 0, &unit);
                moved.iter_mut().zip(by_start).for_each(|(x, change)| *x += change);
            }
            [moved, column].concat()
        };
        (0..3 * n).flat_map(column).collect()
    }
}

/// Returns the difference of fourth order of `value` along entry `k` of q (in tangent space), qd and
/// tau.
fn slope(
    robot: &Interpreter,
    State { q, qd, tau, .. }: &State,
    k: usize,
    mut value: impl FnMut([&[f64]; 3]) -> Vec<f64>,
) -> Vec<f64> {
    let n = qd.len();
    let step = 1e-3;
    let [a, b, c, d] = [1.0, -1.0, 2.0, -2.0].map(|by| {
        let mut state = [q.clone(), qd.clone(), tau.clone()];
        if k < n {
            let along: Vec<f64> = (0..n).map(|i| if i == k { by * step } else { 0.0 }).collect();
            robot.integrate(q, &along, &mut state[0]).expect(LENGTHS);
        } else {
            state[k / n][k % n] += by * step;
        }
        value([&state[0], &state[1], &state[2]])
    });
    (0..a.len()).map(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * step)).collect()
}

/// Robots with joints of all types: the blocks are parts of A and B of `step_semi_implicit_derivatives`, and
/// the velocities are the same.
#[test]
fn knots_are_a_and_b_in_blocks() {
    let zoo = (0..12).map(|seed| random::mixed_zoo(seed, 2 + usize::try_from(seed % 6).unwrap()));
    for (seed, model) in zoo.chain([golden::model(&golden::urdf("panda"))]).enumerate() {
        let State { q, qd, tau, .. } = random::state(seed as u64, &model);
        let n = model.nv();
        let mut robot = Interpreter::new(model.clone());
        let mut knot = Knot::new(&model);
        let input = TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: DT };
        robot.knot(input, knot.outputs()).expect(LENGTHS);

        let mut next_q = q.clone();
        let mut step = [n, 4 * n * n, 2 * n * n].map(|length| vec![f64::NAN; length]);
        let [next_qd, a, b] = &mut step;
        let outputs = StepOutputs { q: &mut next_q, qd: next_qd, a, b };
        robot.step_semi_implicit_derivatives(input, outputs).expect(LENGTHS);
        let [next_qd, a, b] = step;
        assert_close("velocities", &knot.qd, &next_qd, 1e-13);
        assert_close("A and B", &knot.columns(&model), &[a, b].concat(), 1e-12);
    }
}

/// The derivatives of an arm's step by differences.
#[test]
fn knots_are_differences_of_the_step() {
    let model = golden::model(&golden::urdf("panda"));
    let state = random::state(5, &model);
    let mut robot = Interpreter::new(model.clone());
    let mut knot = Knot::new(&model);
    let input = TimeStepInput { q: &state.q, qd: &state.qd, tau: &state.tau, dt: DT };
    robot.knot(input, knot.outputs()).expect(LENGTHS);
    let exact = knot.columns(&model);
    let fixed = Interpreter::new(model.clone());
    for (k, column) in exact.chunks(2 * model.nv()).enumerate() {
        let slope = slope(&fixed, &state, k, |[q, qd, tau]| {
            let qdd = robot.qdd(q, qd, tau);
            let next: Vec<f64> = qd.iter().zip(&qdd).map(|(v, a)| v + DT * a).collect();
            q.iter().zip(&next).map(|(q, v)| q + DT * v).chain(next.iter().copied()).collect()
        });
        assert_close("column", column, &slope, 1e-7);
    }
}

/// A floating quadruped with a foot that is held at a point, one that is held as a surface, and one
/// that is not active: the derivatives of the state and of the wrenches by differences of
/// constrained forward dynamics.
#[test]
fn knots_with_contacts_are_differences_of_the_constrained_step() {
    let feet = [
        contact("point", ContactKind::Point, "front_left_foot", [0.0, 0.01, -0.02]),
        contact("open", ContactKind::Point, "front_right_foot", [0.01, 0.0, -0.03]),
        contact("surface", ContactKind::Surface, "hind_right_foot", [0.03, -0.01, 0.02]),
    ];
    let builder = robot("quadruped").base(Base::Floating).contacts(feet);
    let model = builder.functions([Function::Integrate]).generate().expect("good").model;
    let n = model.nv();
    let active = [true, false, true];
    let settings = Settings::DEFAULT;
    let state = random::state(3, &model);
    let mut robot = Interpreter::new(model.clone());
    let mut knot = Knot::new(&model);
    let mut wrenches = vec![Wrench::zero(); 3];
    let mut changes: [Vec<Wrench<f64>>; 3] = core::array::from_fn(|_| vec![Wrench::zero(); 3 * n]);
    let [dwrenches_dq, dwrenches_dqd, dwrenches_dtau] = &mut changes;
    let input = TimeStepInput { q: &state.q, qd: &state.qd, tau: &state.tau, dt: DT };
    let outputs = ConstrainedKnotOutputs {
        knot: knot.outputs(),
        wrenches: &mut wrenches,
        dwrenches_dq,
        dwrenches_dqd,
        dwrenches_dtau,
    };
    let rank = robot.constrained_knot(input, &active, &settings, outputs).expect(LENGTHS);
    assert_eq!(rank, 9.0);
    assert_eq!(wrenches[1], Wrench::zero());

    let fixed = Interpreter::new(model.clone());
    let mut step = |[q, qd, tau]: [&[f64]; 3]| {
        let mut qdd = vec![0.0; n];
        let mut wrenches = [Wrench::zero(); 3];
        let mut residuals = [Twist::zero(); 3];
        let outputs = ConstrainedOutputs {
            qdd: &mut qdd,
            wrenches: &mut wrenches,
            residuals: &mut residuals,
        };
        let input = ForwardInput { q, qd, tau };
        robot.constrained_forward_dynamics(input, &active, &settings, outputs).expect(LENGTHS);
        let next: Vec<f64> = qd.iter().zip(&qdd).map(|(v, a)| v + DT * a).collect();
        let by: Vec<f64> = next.iter().map(|v| DT * v).collect();
        let mut moved = q.to_vec();
        fixed.integrate(q, &by, &mut moved).expect(LENGTHS);
        (moved, next, wrenches)
    };
    let (next_q, next_qd, held) = step([&state.q, &state.qd, &state.tau]);
    assert_close("velocities", &knot.qd, &next_qd, 1e-13);
    assert_eq!(wrenches, held);
    for (k, column) in knot.columns(&model).chunks(2 * n).enumerate() {
        let slope = slope(&fixed, &state, k, |state| {
            let (moved, next, wrenches) = step(state);
            let mut by = vec![0.0; n];
            fixed.difference(&next_q, &moved, &mut by).expect(LENGTHS);
            by.into_iter().chain(next).chain(wrenches.iter().flat_map(Wrench::components)).collect()
        });
        let (of_state, of_wrenches) = slope.split_at(2 * n);
        assert_close("state", column, of_state, 1e-6);
        let of_feet = (0..3).map(|foot| &changes[k / n][foot * n + k % n]);
        let by_knot: Vec<f64> = of_feet.flat_map(Wrench::components).collect();
        assert_close("wrenches", &by_knot, of_wrenches, 1e-6);
    }
}

const FEET: [&str; 4] = ["front_left", "front_right", "hind_left", "hind_right"];

/// Returns a floating quadruped with a contact at each foot.
fn quadruped() -> Builder {
    let foot = |foot: &str| {
        contact(foot, ContactKind::Point, &format!("{foot}_foot"), [0.01, -0.02, 0.03])
    };
    robot("quadruped").base(Base::Floating).contacts(FEET.map(foot))
}

/// Returns the arguments of a knot in general position; of a robot with contacts, with these active
/// ones.
fn arguments(planning: &Planning, active: &[f64]) -> Vec<Vec<f64>> {
    let [nq, nv] = [planning.model.nq(), planning.model.nv()];
    let numbers = |count: usize, seed: f64| -> Vec<f64> {
        (0..count).map(|i| (seed * (i as f64 + 1.3)).sin()).collect()
    };
    let robot = Interpreter::<f64>::new(planning.model.clone());
    let mut q = numbers(nq, 1.7);
    robot.normalize_configuration(&mut q).expect("fits");
    let mut all = vec![q, numbers(nv, 2.3), numbers(nv, 0.7), vec![0.02]];
    if !active.is_empty() {
        let mut settings = ConstraintSettings::<f64>::DEFAULT.numbers().to_vec();
        for k in 0..active.len() {
            let alpha = 3.0 + k as f64;
            settings.extend(ContactTarget { alpha, ..ContactTarget::default() }.numbers());
        }
        all.extend([active.to_vec(), settings]);
    }
    all
}

/// Compares results of a layout, each field with the scale of its largest number.
fn compare(shape: &Shape, results: &[f64], expected: &[f64], what: &str) {
    let Shape::Record(_, fields) = shape else { panic!("a record") };
    let mut first = 0;
    for (name, field) in fields {
        let place = first..first + field.len();
        first = place.end;
        let scale = expected[place.clone()].iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (a, b) in results[place.clone()].iter().zip(&expected[place]) {
            assert!((a - b).abs() < 1e-10 * scale, "{what}, {name}: {a} instead of {b}");
        }
    }
    assert_eq!(first, results.len());
}

/// Returns the results of the programs of a function: on scalars, and packed.
fn results(planned: &Planned, arguments: &[Vec<f64>]) -> [Vec<f64>; 2] {
    let (scalar, packed) = planned.kernels.straight().expect("a program for each");
    [scalar, packed].map(|program| program.evaluate(&arguments.concat()))
}

#[test]
fn programs_are_the_interpreters() {
    let active = [1.0, 0.0, 1.0, 1.0];
    for (builder, function, active) in [
        (robot("arm7"), Function::Knot, &[][..]),
        (robot("quadruped").base(Base::Floating), Function::Knot, &[]),
        (quadruped(), Function::ConstrainedKnot, &active),
    ] {
        for code in [CodeForm::Auto, CodeForm::Unrolled] {
            let planning = builder.clone().functions([function]).code(code).plan().expect("good");
            let [planned] = &*planning.plan.functions else { panic!("one function") };
            let arguments = arguments(&planning, active);
            let mut expected = vec![f64::NAN; planned.result.len()];
            let mut robot = Interpreter::new(planning.model.clone());
            let slices: Vec<&[f64]> = arguments.iter().map(Vec::as_slice).collect();
            robot.evaluate(function, &slices, 0, &mut expected).expect("fits");
            for found in results(planned, &arguments) {
                let what = format!("{} of {}, {code:?}", function.name(), planning.model.name());
                compare(&planned.result, &found, &expected, &what);
            }
        }
    }
}
