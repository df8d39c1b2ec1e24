//! Derivatives of forward dynamics with closed loops and contacts: on random robots with loops of all types, in general
//! position, against dual numbers; on closed mechanisms with redundant rows, along motions that keep them closed; and
//! against Pinocchio.

use modyn_runtime::equations::ForwardInput;
use modyn_runtime::equations::constraints::ConstrainedOutputs;
use modyn_runtime::model::{
    Contact, ContactKind, LoopConstraint, LoopConstraintEnd, LoopConstraintKind, Model,
};
use modyn_runtime::spatial::{Pose, Twist, Vector3, Wrench};
use modyn_runtime::{
    ConstrainedDerivatives, ConstraintSettings, ContactTarget, Interpreter, Scalar,
};
use modyn_tests::close::assert_close;
use modyn_tests::dual::{Tangent, along, along_velocity, constant};
use modyn_tests::golden::{Golden, PLANAR_LOOP, SPATIAL_LOOPS};
use modyn_tests::random::{Random, general_zoo, mixed_zoo, state};
use nalgebra::{DMatrix, DVector};

type Settings<S> = ConstraintSettings<S, Vec<ContactTarget<S>>>;

/// The accelerations and the wrenches, and their derivatives by q, qd and tau: a column for each entry.
struct Derivatives {
    value: Vec<f64>,
    columns: [Vec<Vec<f64>>; 3],
    rank: f64,
}

fn derivatives(
    model: &Model,
    [q, qd, tau]: [&[f64]; 3],
    active: &[bool],
    settings: &Settings<f64>,
) -> Derivatives {
    let (n, count) = (model.nv(), model.constraints());
    let (mut qdd, mut wrenches) = (vec![0.0; n], vec![Wrench::zero(); count]);
    let mut matrices = [0; 3].map(|_| vec![0.0; n * n]);
    let mut changes = [0; 3].map(|_| vec![Wrench::zero(); n * count]);
    let outputs = ConstrainedDerivatives::new(&mut qdd, &mut wrenches, &mut matrices, &mut changes);
    let mut interpreter = Interpreter::new(model.clone());
    let rank = interpreter.constrained_forward_dynamics_derivatives(
        ForwardInput { q, qd, tau },
        active,
        settings,
        outputs,
    );
    let column = |variable: usize, k: usize| {
        let own = (0..count).flat_map(|c| changes[variable][c * n + k].components());
        matrices[variable][k * n..][..n].iter().copied().chain(own).collect()
    };
    let columns = [0, 1, 2].map(|variable| (0..n).map(|k| column(variable, k)).collect());
    let value = qdd.iter().copied().chain(wrenches.iter().flat_map(Wrench::components));
    Derivatives { value: value.collect(), columns, rank: rank.expect("fits") }
}

/// The accelerations and the wrenches in any scalar.
fn value<S: Scalar>(
    model: &Model,
    [q, qd, tau]: [&[S]; 3],
    active: &[bool],
    settings: &Settings<S>,
) -> Vec<S> {
    let count = model.constraints();
    let (mut qdd, mut wrenches) = (vec![S::zero(); model.nv()], vec![Wrench::zero(); count]);
    let mut residuals = vec![Twist::zero(); count];
    let into =
        ConstrainedOutputs { qdd: &mut qdd, wrenches: &mut wrenches, residuals: &mut residuals };
    let mut interpreter = Interpreter::new(model.clone());
    interpreter
        .constrained_forward_dynamics(ForwardInput { q, qd, tau }, active, settings, into)
        .expect("fits");
    qdd.into_iter().chain(wrenches.iter().flat_map(Wrench::components)).collect()
}

fn assert_near(found: &[f64], expected: &[f64], scale: f64, tolerance: f64, what: &str) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= tolerance * scale, "{what}: {a} instead of {b}, of {scale}");
    }
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(1.0, |most, x| x.abs().max(most))
}

fn pose(random: &mut Random) -> Pose<f64> {
    let mut number = || random.between(-1.0, 1.0);
    let q: [f64; 4] = std::array::from_fn(|_| number());
    let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z, w] = q.map(|x| x / size);
    let rotation = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    Pose { rotation, translation: std::array::from_fn(|_| 0.3 * number()) }
}

/// Returns targets anywhere, moving, stabilized and compliant, and loops that are stabilized.
fn settings(model: &Model, random: &mut Random) -> Settings<f64> {
    let mut targets = Vec::new();
    for _ in model.contacts() {
        let mut three = |size: f64| Vector3([0; 3].map(|_| random.between(-size, size)));
        let velocity = Twist { angular: three(1.0), linear: three(1.0) };
        targets.push(ContactTarget {
            pose: pose(random),
            velocity,
            tangential: 0.3,
            alpha: 3.0,
            beta: 5.0,
            ..ContactTarget::<f64>::GROUND
        });
    }
    let ConstraintSettings { tolerance, rounding, .. } = ConstraintSettings::<f64>::DEFAULT;
    ConstraintSettings { alpha: 2.0, beta: 4.0, tolerance, rounding, targets }
}

fn in_tangents(settings: &Settings<f64>) -> Settings<Tangent<f64>> {
    let number = |x: f64| constant(&[x])[0];
    let target = |t: &ContactTarget<f64>| ContactTarget::from_numbers(t.numbers().map(number));
    let targets = settings.targets.iter().map(target).collect();
    ConstraintSettings::from_numbers(settings.numbers().map(number), targets)
}

/// Returns the robot with loops of these types between two pairs of links, and two contacts. The frames of a loop are
/// anywhere: they do not coincide.
fn constrained(model: &Model, kinds: &[LoopConstraintKind], random: &mut Random) -> Model {
    let end = |random: &mut Random| LoopConstraintEnd {
        link: random.below(model.links().len()),
        pose: pose(random),
    };
    let mut robot = model.clone();
    while robot.loop_constraints().len() < kinds.len() {
        let mut loops = robot.loop_constraints().to_vec();
        let (name, kind) = (format!("loop{}", loops.len()), kinds[loops.len()]);
        loops.push(LoopConstraint { name, kind, ends: [end(random), end(random)] });
        // Links that do not move relative to each other are refused.
        robot = model.clone().with_loop_constraints(loops).unwrap_or(robot);
    }
    while robot.contacts().len() < 2 {
        let mut contacts = robot.contacts().to_vec();
        let kind = [ContactKind::Point, ContactKind::Surface][contacts.len()];
        contacts.push(Contact {
            name: format!("contact{}", contacts.len()),
            kind,
            end: end(random),
        });
        robot = robot.clone().with_contacts(contacts).unwrap_or(robot);
    }
    robot
}

/// Compares all derivatives with those of dual numbers; returns whether no row is redundant. Then wrenches are compared,
/// too.
fn near_dual_numbers(model: &Model, seed: u64, active: &[bool], settings: &Settings<f64>) -> bool {
    let at = state(seed, model);
    let state = [&at.q[..], &at.qd[..], &at.tau[..]];
    let found = derivatives(model, state, active, settings);
    let (n, rows) = (model.nv(), model.constraint_rows());
    let inactive = model.contacts().iter().zip(active).filter(|(_, on)| !**on);
    let inactive: usize = inactive.map(|(contact, _)| contact.kind.rows()).sum();
    let independent = (found.rank - (rows - inactive) as f64).abs() < 0.5;
    if !independent {
        return false;
    }
    let tangents = in_tangents(settings);
    let [q, qd, tau] = state.map(constant);
    for variable in 0..3 {
        for k in 0..n {
            let varied = match variable {
                0 => [along_velocity(model, state[0], k), qd.clone(), tau.clone()],
                1 => [q.clone(), along(state[1], k), tau.clone()],
                _ => [q.clone(), qd.clone(), along(state[2], k)],
            };
            let varied = varied.each_ref().map(|x| &x[..]);
            let expected = value(model, varied, active, &tangents);
            let values: Vec<f64> = expected.iter().map(|x| x.x).collect();
            let changes: Vec<f64> = expected.iter().map(|x| x.dx).collect();
            let what = format!("seed {seed}, {active:?}, variable {variable}, entry {k}");
            assert_near(&found.value, &values, largest(&values), 1e-9, &what);
            let own = &found.columns[variable][k];
            let scale = largest(&changes).max(largest(&values));
            assert_near(own, &changes, scale, 1e-8, &what);
        }
    }
    true
}

#[test]
fn loops_and_contacts_in_general_position_as_dual_numbers() {
    let axis = |random: &mut Random| {
        let Pose { rotation, .. } = pose(random);
        rotation[1]
    };
    let mut checked = 0;
    for seed in 0..12 {
        let random = &mut Random::new(seed + 50);
        let kinds = [
            LoopConstraintKind::Point,
            LoopConstraintKind::Revolute(axis(random)),
            LoopConstraintKind::Prismatic(axis(random)),
            LoopConstraintKind::Rigid,
        ];
        let robot = if seed % 2 == 0 { general_zoo(seed, 9) } else { mixed_zoo(seed, 9) };
        let first = (seed % 4) as usize;
        let kinds = match seed % 3 {
            0 => vec![kinds[first]],
            _ => vec![kinds[first], kinds[(first + 1 + seed as usize / 4) % 4]],
        };
        let model = constrained(&robot, &kinds, random);
        let settings = settings(&model, random);
        for active in [[false; 2], [true, false], [false, true], [true; 2]] {
            checked += usize::from(near_dual_numbers(&model, seed, &active, &settings));
        }
    }
    assert!(checked > 15, "{checked}");
}

/// Pinocchio's derivatives depend on the axes of its constraints in directions that open the loop. Along motions that
/// keep it closed they do not, and by torques they never do.
#[test]
fn closed_loops_as_pinocchio() {
    let mut matrices = 0;
    for name in SPATIAL_LOOPS.into_iter().chain([PLANAR_LOOP]) {
        let golden = Golden::load(name);
        let n = golden.model.nv();
        let ConstraintSettings { tolerance, rounding, .. } = ConstraintSettings::<f64>::EXACT;
        let settings =
            ConstraintSettings { alpha: 0.0, beta: 0.0, tolerance, rounding, targets: Vec::new() };
        for state in &golden.states {
            let [q, qd, tau] = [state.q(), state.vector("v"), state.vector("tau")];
            let found = derivatives(&golden.model, [&q, &qd, &tau], &[], &settings);
            assert_close(name, &found.value[..n], &state.vector("qdd"), 1e-9);
            assert_eq!(found.rank, state.number("rank"), "{name}");
            let [dq, dqd, dtau] =
                found.columns.map(|columns| DMatrix::from_fn(n, n, |i, j| columns[j][i]));
            let [along_q, along_v] =
                ["along_q", "along_v"].map(|name| DVector::from(state.vector(name)));
            let along = dq * &along_q + dqd * &along_v;
            assert_close(name, along.as_slice(), &state.vector("along_qdd"), 1e-7);
            if name != "loop_fixed" {
                continue;
            }
            matrices += 1;
            let of = |name| state.matrix(name);
            let expected = of("dqdd_dq") * &along_q + of("dqdd_dv") * &along_v;
            assert_close(name, along.as_slice(), expected.as_slice(), 1e-8);
            assert_close(name, dtau.as_slice(), of("dqdd_dtau").as_slice(), 1e-8);
        }
    }
    assert_eq!(matrices, 4);
}
