//! The contracted Hessian of forward dynamics with closed loops and contacts: the compiler and the interpreter against
//! num-dual's numbers through the function itself, with random sets of active contacts and with redundant rows, and its
//! operations.

use modyn_codegen::graph::Graph;
use modyn_codegen::passes::{hessian, optimize, vjp};
use modyn_codegen::trace::{Parameters, Tracer};
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::constraints::{
    ConstrainedCotangent, ConstrainedOutputs, ResidualOutputs,
};
use modyn_runtime::equations::{self, ForwardInput};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{
    Contact, ContactKind, Link, LoopConstraint, LoopConstraintEnd, LoopConstraintKind, Model,
    ModuleTree,
};
use modyn_runtime::num_dual::HyperDual64;
use modyn_runtime::{ConstraintSettings, ContactTarget, Interpreter, Pose, Scalar, Twist, Wrench};
use modyn_tests::close::assert_close;
use modyn_tests::dual::{Tangent, along, along_velocity, constant, hessian_blocks};
use modyn_tests::floating::floated;
use modyn_tests::golden;
use modyn_tests::quantities::Quantities;
use modyn_tests::random::{self, Random, State};

/// A number with two directions.
type Twice = Tangent<Tangent<f64>>;

type Settings<S> = ConstraintSettings<S, Vec<ContactTarget<S>>>;

/// All arguments of the function.
struct Point {
    q: Vec<f64>,
    qd: Vec<f64>,
    tau: Vec<f64>,
    cotangent: Vec<f64>,
    wrench_cotangent: Vec<Wrench<f64>>,
    active: Vec<bool>,
    settings: Settings<f64>,
}

fn three(random: &mut Random) -> [f64; 3] {
    std::array::from_fn(|_| random.between(-1.0, 1.0))
}

/// Returns a rotation in general position.
fn rotation(random: &mut Random) -> [[f64; 3]; 3] {
    let [a, b, c]: [(f64, f64); 3] = three(random).map(|angle| (2.0 * angle).sin_cos());
    let z = [[a.1, -a.0, 0.0], [a.0, a.1, 0.0], [0.0, 0.0, 1.0]];
    let y = [[b.1, 0.0, b.0], [0.0, 1.0, 0.0], [-b.0, 0.0, b.1]];
    let x = [[1.0, 0.0, 0.0], [0.0, c.1, -c.0], [0.0, c.0, c.1]];
    let times = |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| {
        a.map(|row| std::array::from_fn(|j| (0..3).map(|k| row[k] * b[k][j]).sum()))
    };
    times(times(z, y), x)
}

fn pose(random: &mut Random) -> Pose<f64> {
    Pose { rotation: rotation(random), translation: three(random) }
}

/// Returns the model with these contacts, at frames in general position.
fn touching(model: &Model, contacts: &[(ContactKind, usize)], random: &mut Random) -> Model {
    let contact = |(k, &(kind, frame)): (usize, &(ContactKind, usize))| {
        let end = LoopConstraintEnd { link: frame, pose: pose(random) };
        Contact { name: format!("c{k}"), kind, end }
    };
    let contacts = contacts.iter().enumerate().map(contact).collect();
    model.clone().with_contacts(contacts).expect("good")
}

/// Returns arguments in general position; the weights of wrenches have this size.
fn point(model: &Model, seed: u64, active: Vec<bool>, wrenches: f64) -> Point {
    let State { q, qd, tau, .. } = random::state(seed, model);
    let random = &mut Random::new(seed);
    let target = |random: &mut Random| {
        let mut numbers = [0.0; 24];
        let pose = pose(random);
        numbers[..9].copy_from_slice(pose.rotation.as_flattened());
        numbers[9..12].copy_from_slice(&pose.translation);
        // The velocity, the tangential factor, the stabilization and the compliance.
        numbers[12..22].fill_with(|| random.between(0.1, 2.0));
        numbers[21] *= if random.chance(0.5) { 0.1 } else { 0.0 };
        ContactTarget::from_numbers(numbers)
    };
    let targets = model.contacts().iter().map(|_| target(random)).collect();
    let ConstraintSettings { tolerance, rounding, .. } = ConstraintSettings::<f64>::EXACT;
    let (alpha, beta) = (1.5, 2.5);
    let settings = ConstraintSettings { alpha, beta, tolerance, rounding, targets };
    let wrench = |random: &mut Random| {
        let force = three(random).map(|x| wrenches * x);
        let moment = three(random).map(|x| wrenches * x);
        Wrench { force: force.into(), moment: moment.into() }
    };
    Point {
        q,
        qd,
        tau,
        cotangent: (0..model.nv()).map(|_| random.between(-1.0, 1.0)).collect(),
        wrench_cotangent: (0..model.constraints()).map(|_| wrench(random)).collect(),
        active,
        settings,
    }
}

/// Returns the accelerations, the wrenches, the gradients, the blocks of the Hessian and the rank.
fn interpreted(model: &Model, point: &Point) -> Vec<f64> {
    let Point { q, qd, tau, cotangent, wrench_cotangent, active, settings } = point;
    let weights = ConstrainedCotangent { qdd: cotangent, wrenches: wrench_cotangent };
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    interpreter.constrained_hessian([q, qd, tau], weights, active, settings)
}

fn tracer<'a>(model: &Model, mechanism: &'a Mechanism<f64>) -> Tracer<'a> {
    Tracer::with_parameters(mechanism, Parameters::new(model, true, &[], &[]))
}

/// Returns the same numbers of the generated function's graph, with gravity as an input.
fn compiled(model: &Model, point: &Point) -> Vec<f64> {
    let mechanism = Mechanism::new(model);
    let layout = UduLayout::new(&mechanism, &ModuleTree::chains(model));
    let graph = optimize(tracer(model, &mechanism).constrained_forward_dynamics_hessian(&layout));
    let Point { q, qd, tau, cotangent, wrench_cotangent, active, settings } = point;
    let weights: Vec<f64> = wrench_cotangent.iter().flat_map(Wrench::components).collect();
    let active: Vec<f64> = active.iter().map(|&active| f64::from(u8::from(active))).collect();
    let targets: Vec<f64> = settings.targets.iter().flat_map(ContactTarget::numbers).collect();
    let inputs = [
        &q[..],
        qd,
        tau,
        cotangent,
        &weights,
        &active,
        &settings.numbers(),
        &targets,
        &model.gravity(),
    ];
    graph.evaluate::<f64>(&inputs.concat())
}

/// Returns the second derivatives of the weighted results along entry `a`, then along entry `b`, of q, qd and tau.
fn second(
    interpreter: &mut Interpreter<HyperDual64>,
    point: &Point,
    settings: &Settings<HyperDual64>,
    [a, b]: [usize; 2],
) -> f64 {
    fn moved<S: Scalar>(
        model: &Model,
        [q, qd, tau]: &[Vec<S>; 3],
        (k, entry): (usize, usize),
    ) -> [Vec<Tangent<S>>; 3] {
        [
            if k == 0 { along_velocity(model, q, entry) } else { constant(q) },
            if k == 1 { along(qd, entry) } else { constant(qd) },
            if k == 2 { along(tau, entry) } else { constant(tau) },
        ]
    }
    let model = interpreter.model();
    let (n, constraints) = (model.nv(), model.constraints());
    let state = [point.q.clone(), point.qd.clone(), point.tau.clone()];
    let once = moved(model, &state, (a / n, a % n));
    let twice: [Vec<Twice>; 3] = moved(model, &once, (b / n, b % n));
    let [q, qd, tau] = twice.map(|vector| {
        let number = |t: Twice| HyperDual64::new(t.x.x, t.x.dx, t.dx.x, t.dx.dx);
        vector.into_iter().map(number).collect::<Vec<_>>()
    });
    let mut qdd = vec![HyperDual64::from(0.0); n];
    let (mut wrenches, mut residuals) =
        (vec![Wrench::zero(); constraints], vec![Twist::zero(); constraints]);
    let results =
        ConstrainedOutputs { qdd: &mut qdd, wrenches: &mut wrenches, residuals: &mut residuals };
    interpreter
        .constrained_forward_dynamics(
            ForwardInput { q: &q, qd: &qd, tau: &tau },
            &point.active,
            settings,
            results,
        )
        .expect("fits");
    let wrenches = wrenches.iter().flat_map(Wrench::components);
    let weights = point.wrench_cotangent.iter().flat_map(Wrench::components);
    let weights = point.cotangent.iter().copied().chain(weights);
    qdd.into_iter().chain(wrenches).zip(weights).map(|(x, w)| x.eps1eps2 * w).sum()
}

/// Returns the blocks of the Hessian by num-dual's numbers; the blocks that are not stored must be zero.
fn expected(model: &Model, point: &Point) -> Vec<f64> {
    let n = model.nv();
    let number = HyperDual64::from_f64;
    let contacts = point.settings.targets.iter();
    let contacts = contacts.map(|own| ContactTarget::from_numbers(own.numbers().map(number)));
    let settings = ConstraintSettings::from_numbers(
        point.settings.numbers().map(number),
        contacts.collect::<Vec<_>>(),
    );
    let mut interpreter = Interpreter::new(model.clone());
    let entry = |a, b| second(&mut interpreter, point, &settings, [a, b]);
    hessian_blocks(n, entry, 1e-8)
}

/// Compares the compiler and the interpreter with num-dual's numbers. Returns the rank.
fn compare(name: &str, model: &Model, point: &Point) -> f64 {
    let expected = expected(model, point);
    let (interpreted, compiled) = (interpreted(model, point), compiled(model, point));
    let n = model.nv();
    let first = n + 6 * model.constraints();
    let blocks = first + 3 * n..first + 3 * n + 4 * n * n;
    for (who, found) in [("interpreter", &interpreted), ("compiler", &compiled)] {
        assert_close(&format!("{name}: {who}"), &found[blocks.clone()], &expected, 1e-7);
    }
    for part in [0..n, n..first, first..first + 3 * n, blocks.end..blocks.end + 1] {
        let found = &compiled[part.clone()];
        assert_close(&format!("{name}: {part:?}"), found, &interpreted[part], 1e-8);
    }
    assert_eq!(compiled.len(), interpreted.len());
    interpreted[blocks.end]
}

fn mask(bits: u64, contacts: usize) -> Vec<bool> {
    (0..contacts).map(|k| bits >> k & 1 == 1).collect()
}

use ContactKind::{Point as OfPoint, Surface};

#[test]
fn floating_robots_have_the_hessians_of_dual_numbers() {
    let mut ranks = Vec::new();
    for seed in 0..5 {
        let random = &mut Random::new(seed + 40);
        let tree = floated(&random::mixed_tree(seed, 4), random.inertial());
        let last = tree.links().len() - 1;
        let contacts: &[_] = match seed % 2 {
            0 => &[(OfPoint, last), (OfPoint, last - 2)],
            _ => &[(Surface, last), (OfPoint, 1)],
        };
        let model = touching(&tree, contacts, random);
        for bits in [3, seed % 3] {
            let point = point(&model, seed, mask(bits, 2), 1.0);
            ranks.push(compare(&format!("seed {seed}, contacts {bits:b}"), &model, &point));
        }
    }
    assert!(ranks.contains(&0.0) && ranks.contains(&9.0), "{ranks:?}");
}

#[test]
fn robots_of_all_joints_have_the_hessians_of_dual_numbers() {
    for seed in 0..4 {
        let random = &mut Random::new(seed + 80);
        let zoo = random::mixed_zoo(seed, 7);
        let model = touching(&zoo, &[(OfPoint, zoo.links().len() - 1)], random);
        let point = point(&model, seed, vec![true], 1.0);
        compare(&format!("joints, seed {seed}"), &model, &point);
    }
}

/// Contacts with more rows than the body that they are on can move: compliance makes them independent.
#[test]
fn contacts_with_compliance_share_a_body() {
    for seed in 0..2 {
        let random = &mut Random::new(seed + 120);
        let tree = floated(&random::mixed_tree(seed, 3), random.inertial());
        let last = tree.links().len() - 1;
        let model = touching(&tree, &[(OfPoint, last); 3], random);
        let mut point = point(&model, seed, vec![true; 3], 1.0);
        for (k, target) in (1..).zip(&mut point.settings.targets) {
            target.compliance = 0.1 * f64::from(k);
        }
        let rank = compare(&format!("redundant, seed {seed}"), &model, &point);
        assert!((rank - 9.0).abs() < 0.5, "{rank}");
    }
}

/// Returns the robot with a loop of this type between two of its links, an early one and a late one, at frames that are
/// anywhere.
fn looped(model: &Model, kind: LoopConstraintKind, random: &mut Random) -> Model {
    loop {
        let count = model.links().len();
        let frames = [random.below(count / 2), count - 1 - random.below(2)];
        let ends = frames.map(|frame| LoopConstraintEnd { link: frame, pose: pose(random) });
        let name = "loop".to_string();
        // Links that do not move relative to each other are refused.
        let looped = model.clone().with_loop_constraints(vec![LoopConstraint { name, kind, ends }]);
        if let Ok(model) = looped {
            return model;
        }
    }
}

#[test]
fn closed_loops_have_the_hessians_of_dual_numbers() {
    let mut compared = [0; 4];
    for seed in 0..12 {
        let random = &mut Random::new(seed + 200);
        let [axis, ..] = rotation(random);
        let kinds = [
            LoopConstraintKind::Point,
            LoopConstraintKind::Revolute(axis),
            LoopConstraintKind::Prismatic(axis),
            LoopConstraintKind::Rigid,
        ];
        let kind = seed as usize % 4;
        let tree = match seed / 4 % 2 {
            0 => floated(&random::chain(seed, 5), random.inertial()),
            _ => random::mixed_zoo(seed, 6),
        };
        let model = looped(&tree, kinds[kind], random);
        let model = match seed % 3 {
            0 => touching(&model, &[(OfPoint, tree.links().len() - 1)], random),
            _ => model,
        };
        let active = vec![true; model.contacts().len()];
        let point = point(&model, seed, active, 1.0);
        let rank = interpreted(&model, &point).pop().expect("the rank");
        if (rank - model.constraint_rows() as f64).abs() < 0.5 {
            compare(&format!("loop {kind}, seed {seed}"), &model, &point);
            compared[kind] += 1;
        }
    }
    assert!(compared.iter().all(|&count| count > 0), "{compared:?}");
}

/// The hinge that closes a planar linkage in general position has three rows that depend on others. The accelerations do not
/// depend on how such rows share the load.
#[test]
fn planar_loops_have_redundant_rows() {
    let model = golden::model(&golden::urdf(golden::PLANAR_LOOP));
    assert_eq!((model.loop_constraints().len(), model.constraint_rows()), (1, 5));
    for seed in 0..4 {
        let point = point(&model, seed, Vec::new(), 0.0);
        let rank = compare(&format!("planar, seed {seed}"), &model, &point);
        assert!((rank - 2.0).abs() < 0.5, "{rank}");
    }
}

/// Three points of a body at rest on their targets, without compliance, and a foot of another body on a moving target.
#[test]
fn rigid_contacts_share_a_body() {
    for seed in 0..3 {
        let random = &mut Random::new(seed + 160);
        let tree = floated(&random::chain(seed, 5), random.inertial());
        let on_base = |frame: &Link| frame.moving_link == Some(0);
        let base = tree.links().iter().position(on_base).expect("a frame of the base");
        let feet =
            [(OfPoint, base), (OfPoint, base), (OfPoint, base), (OfPoint, tree.links().len() - 1)];
        let model = touching(&tree, &feet, random);
        let mut point = point(&model, seed, vec![true; 4], 0.0);
        point.qd[..6].fill(0.0);
        for target in &mut point.settings.targets[..3] {
            let at_origin = Pose { translation: [0.0; 3], ..target.pose };
            let (alpha, beta, tangential) = (0.7, 1.3, 1.0);
            *target = ContactTarget {
                alpha,
                beta,
                tangential,
                pose: at_origin,
                ..ContactTarget::<f64>::GROUND
            };
        }
        let zeros = || vec![Twist::zero(); 4];
        let (mut places, mut velocities) = (zeros(), zeros());
        Interpreter::<f64>::new(model.clone())
            .constraint_residual(
                equations::State { q: &point.q, qd: &point.qd },
                &point.settings,
                ResidualOutputs { displacements: &mut places, velocities: &mut velocities },
            )
            .expect("fits");
        for (target, place) in point.settings.targets[..3].iter_mut().zip(&places) {
            target.pose.translation = place.linear.0;
        }
        let rank = compare(&format!("shared, seed {seed}"), &model, &point);
        assert!((rank - 9.0).abs() < 0.5, "{rank}");
    }
}

/// The operations of a robot's Hessian, and of the same by differentiation of the function's graph.
#[test]
fn counts_are_as_frozen() {
    let count = |robot: &str, feet: &[&str]| {
        let path = format!("{}/../robots/{robot}.urdf", env!("CARGO_MANIFEST_DIR"));
        let model = golden::model(std::path::Path::new(&path));
        let model = floated(&model, modyn_runtime::model::Inertial::default());
        let frames = feet.iter().map(|foot| (OfPoint, model.link_index(foot).expect("a link")));
        let random = &mut Random::new(1);
        let model = touching(&model, &frames.collect::<Vec<_>>(), random);
        let mechanism = Mechanism::new(&model);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
        let tracer = Tracer::new(&mechanism);
        let total = |graph: &Graph| graph.count().total();
        let value = optimize(tracer.constrained_forward_dynamics(&layout));
        let first = optimize(tracer.constrained_forward_dynamics_derivatives(&layout));
        let found = optimize(tracer.constrained_forward_dynamics_hessian(&layout));
        // The gradient by reverse mode, then its changes by forward mode, by all entries of the coordinates.
        let variables = model.nq() + 2 * model.nv();
        let inputs = variables + feet.len() + 4 + 24 * feet.len();
        let gradient = vjp(&value, inputs, 0..variables);
        let by_differentiation = (feet.len() == 1)
            .then(|| hessian(&gradient, inputs + value.outputs.len(), usize::MAX))
            .flatten()
            .map_or(0, |graph| total(&graph));
        [total(&value), total(&first), total(&found), by_differentiation]
    };
    let feet = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];
    let found = [1, 2, 4].map(|k| count("quadruped", &feet[..k]));
    assert_eq!(
        found,
        [[3662, 27375, 55345, 133343], [4905, 38223, 71877, 0], [9351, 70762, 116086, 0]],
        "\nA count that falls is to be entered; one that rises is a regression."
    );
    assert!(found[0][2] < found[0][3], "differentiation of the function's graph takes more");
}
