//! Derivatives of accelerations and wrenches against differences: under external wrenches, of compliant contacts, and of
//! redundant contacts, whose wrenches are not unique.

use modyn_runtime::equations::constraints::ProjectionOutputs;
use modyn_runtime::equations::kinematics::Axes;
use modyn_runtime::equations::{self, Forces};

use super::*;

/// The accelerations and the wrenches.
fn value(model: &Model, state: &State, active: &[bool], settings: &Settings) -> Vec<f64> {
    let found = interpreted(model, state, active, settings);
    [found.qdd, found.wrenches.concat()].concat()
}

/// Returns differences of fourth order along entry `k` of q (in the tangent space), qd or tau.
fn slope(
    model: &Model,
    state: &State,
    (variable, k): (usize, usize),
    value: impl Fn(&State) -> Vec<f64>,
) -> Vec<f64> {
    let step = 1e-4;
    let [a, b, c, d] =
        [1.0, -1.0, 2.0, -2.0].map(|by| value(&moved(model, state, variable, k, by * step)));
    (0..a.len()).map(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * step)).collect()
}

/// Returns the derivatives of the accelerations and the wrenches by entry `k` of a variable, from the results of
/// [`derivatives`].
fn column(model: &Model, results: &[f64], (variable, k): (usize, usize)) -> Vec<f64> {
    let (nv, count) = (model.nv(), model.constraints());
    let (matrices, changes) = results[nv + 6 * count..].split_at(3 * nv * nv);
    let own = &matrices[(variable * nv + k) * nv..][..nv];
    let wrenches = (0..count).map(|c| &changes[6 * ((variable * count + c) * nv + k)..][..6]);
    own.iter().chain(wrenches.flatten()).copied().collect()
}

/// Compares accelerations and wrenches, each with the scale of its largest number.
fn assert_columns(nv: usize, found: &[f64], expected: &[f64], here: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len());
    for part in [0..nv, nv..found.len()] {
        let numbers = expected[part.clone()].iter().chain(&here[part.clone()]);
        let scale = numbers.fold(1.0_f64, |most, x| most.max(x.abs()));
        for (a, b) in found[part.clone()].iter().zip(&expected[part]) {
            assert!((a - b).abs() < 1e-6 * scale, "{what}: {a} instead of {b}, of {scale}");
        }
    }
}

fn in_axes(wrenches: &[Wrench<f64>], axes: Axes) -> Forces<'_, f64> {
    match axes {
        Axes::Link => Forces::InLinkAxes(wrenches),
        Axes::World => Forces::InWorldAxes(wrenches),
    }
}

/// Returns the state with the generalized forces of the wrenches added to tau, and their derivatives by q, by columns.
fn pushed(model: &Model, state: &State, forces: Forces<'_, f64>) -> (State, Vec<f64>) {
    let nv = model.nv();
    let (mut added, mut by_q) = (vec![0.0; nv], vec![0.0; nv * nv]);
    let mut interpreter = Interpreter::new(model.clone());
    interpreter.generalized_forces(&state.q, forces, &mut added, &mut by_q).expect("fits");
    let tau = state.tau.iter().zip(&added).map(|(a, b)| a + b).collect();
    (State { q: state.q.clone(), qd: state.qd.clone(), tau }, by_q)
}

/// Returns the derivatives by entry `k` of q with those by tau, times the derivatives of the generalized forces, added.
fn under_wrenches(model: &Model, results: &[f64], by_q: &[f64], k: usize) -> Vec<f64> {
    let nv = model.nv();
    let mut sum = column(model, results, (0, k));
    for (i, &push) in by_q[k * nv..][..nv].iter().enumerate() {
        sum.iter_mut().zip(column(model, results, (2, i))).for_each(|(x, by_tau)| {
            *x += push * by_tau;
        });
    }
    sum
}

/// Returns a floating tree with contacts, and a loop whose three rows are independent.
fn with_a_loop(random: &mut Random) -> Model {
    loop {
        let tree = random_tree(random, 8, 2, Base::Floating);
        let mut end = |link: &str| LoopConstraintEnd {
            link: tree.link_index(link).expect("a link"),
            pose: Pose {
                rotation: rows(&rotation(random.three(3.0))),
                translation: random.three(0.3),
            },
        };
        let ends = [end("8"), end("0")];
        let kind = LoopConstraintKind::Point;
        let pin = LoopConstraint { name: "pin".into(), kind, ends };
        let model = tree.clone().with_loop_constraints(vec![pin]).expect("good");
        let (state, active) = (state(&model, random), vec![false; model.contacts().len()]);
        if interpreted(&model, &state, &active, &exact(&model)).rank > 2.5 {
            return model;
        }
    }
}

/// Wrenches on all links, in both axes, on robots in general position: the interpreter's derivatives and the graphs' are
/// differences of constrained forward dynamics under the wrenches.
#[test]
fn derivatives_under_external_wrenches_are_those_of_differences() {
    let mut random = Random(51);
    let models = [
        quadruped(),
        random_tree(&mut random, 8, 1, Base::Fixed),
        random_tree(&mut random, 7, 2, Base::Floating),
        with_a_loop(&mut random),
    ];
    for (number, model) in models.into_iter().enumerate() {
        let (nv, count) = (model.nv(), model.constraints());
        let mechanism = Mechanism::new(&model);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
        let tracer = Tracer::new(&mechanism);
        let graph = optimize(
            tracer.column_lanes(COLUMN_LANES).constrained_forward_dynamics_derivatives(&layout),
        );
        for (axes, function) in [
            (Axes::Link, Function::GeneralizedForcesLocal),
            (Axes::World, Function::GeneralizedForces),
        ] {
            let pushes = optimize(tracer.evaluation(function, &model, None));
            let active: Vec<bool> = model.contacts().iter().map(|_| random.next() > -0.5).collect();
            let state = state(&model, &mut random);
            let settings = general(&model, &mut random, 0.01);
            let wrenches: Vec<Wrench<f64>> = (0..model.links().len())
                .map(|_| Wrench::from_components([0; 6].map(|_| 20.0 * random.next())))
                .collect();
            let value = |there: &State| {
                let (there, _) = pushed(&model, there, in_axes(&wrenches, axes));
                value(&model, &there, &active, &settings)
            };
            let here = value(&state);
            let free = super::derivatives::value(&model, &state, &active, &settings);
            let moved = here.iter().zip(&free).any(|(a, b)| (a - b).abs() > 1.0);
            assert!(moved, "the wrenches act");

            let (there, by_q) = pushed(&model, &state, in_axes(&wrenches, axes));
            let interpreted = derivatives(&model, &there, &active, &settings);
            let inputs = [state.q.clone(), components(&wrenches)].concat();
            let found = pushes.evaluate(&inputs);
            let tau: Vec<f64> = state.tau.iter().zip(&found).map(|(a, b)| a + b).collect();
            let inputs = [&*state.q, &state.qd, &tau, &switches(&active), &numbers(&settings)];
            let generated = graph.evaluate(&inputs.concat());
            assert_near(&interpreted[..nv + 6 * count], &here, 1e-10);
            for (what, results, by_q) in
                [("interpreted", &interpreted, &*by_q), ("generated", &generated, &found[nv..])]
            {
                for variable in 0..3 {
                    for k in 0..nv {
                        let expected = slope(&model, &state, (variable, k), value);
                        let found = match variable {
                            0 => under_wrenches(&model, results, by_q, k),
                            _ => column(&model, results, (variable, k)),
                        };
                        let what = format!(
                            "{what}, model {number}, {axes:?}, variable {variable}, entry {k}"
                        );
                        assert_columns(nv, &found, &expected, &here, &what);
                    }
                }
            }
        }
    }
}

/// With compliance all rows are independent, redundant or not, so wrenches are smooth.
#[test]
fn derivatives_of_compliant_contacts_are_those_of_differences() {
    let mut random = Random(52);
    let trees = [
        random_tree(&mut random, 7, 3, Base::Floating),
        random_tree(&mut random, 3, 2, Base::Fixed),
        redundant(&mut random),
        quadruped(),
    ];
    for model in trees {
        let mechanism = Mechanism::new(&model);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
        let tracer = Tracer::new(&mechanism).column_lanes(COLUMN_LANES);
        let graph = optimize(tracer.constrained_forward_dynamics_derivatives(&layout));
        for active in masks(&model, &mut random, 2) {
            let state = state(&model, &mut random);
            let settings = general(&model, &mut random, 0.05);
            let value = |there: &State| value(&model, there, &active, &settings);
            let here = value(&state);
            let found = derivatives(&model, &state, &active, &settings);
            let inputs =
                [&*state.q, &state.qd, &state.tau, &switches(&active), &numbers(&settings)];
            assert_near(&graph.evaluate(&inputs.concat()), &found, 1e-8);
            for variable in 0..3 {
                for k in 0..model.nv() {
                    let expected = slope(&model, &state, (variable, k), value);
                    let own = column(&model, &found, (variable, k));
                    let what = format!("{active:?}, variable {variable}, entry {k}");
                    assert_columns(model.nv(), &own, &expected, &here, &what);
                }
            }
        }
    }
}

/// Redundant rigid contacts at rest on their targets, on a robot whose other joints move. The derivatives of accelerations
/// are differences. Wrenches are not unique: their derivatives are the differences without the part that moves nothing,
/// which is to say the derivatives of smallest norm.
#[test]
fn derivatives_of_redundant_contacts_have_the_smallest_norm() {
    let mut random = Random(53);
    let model = redundant(&mut random);
    let mechanism = Mechanism::new(&model);
    let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
    let tracer = Tracer::new(&mechanism);
    let graph = optimize(tracer.constrained_forward_dynamics_derivatives(&layout));
    let (nv, count) = (model.nv(), model.constraints());
    let (mut checked, mut differ) = (0, 0.0_f64);
    for active in masks(&model, &mut random, 14) {
        let mut state = state(&model, &mut random);
        let mut settings = exact(&model);
        settings.targets.iter_mut().for_each(|target| target.alpha = 3.0);
        let mut interpreter = Interpreter::new(model.clone());
        // The active contacts are at rest.
        let (mut dq, mut dqd) = (vec![0.0; nv], vec![0.0; nv]);
        let into = ProjectionOutputs { step_q: &mut dq, step_qd: &mut dqd };
        let motion = equations::State { q: &state.q, qd: &state.qd };
        interpreter.project_constraints(motion, &active, &settings, into).expect("fits");
        state.qd.iter_mut().zip(&dqd).for_each(|(v, d)| *v += d);

        let expected = dense(&model, &state, &active, &settings);
        let (jacobian, kept) = dense_rows(&model, &mut interpreter, &state, &active);
        let on = kept.iter().filter(|row| active[row.0]).count();
        if expected.rank > on as f64 - 0.5 {
            continue;
        }
        checked += 1;
        let value = |there: &State| value(&model, there, &active, &settings);
        let here = value(&state);
        assert_same(&interpreted(&model, &state, &active, &settings), &expected, 1e-8);
        let found = derivatives(&model, &state, &active, &settings);
        let inputs = [&*state.q, &state.qd, &state.tau, &switches(&active), &numbers(&settings)];
        assert_near(&graph.evaluate(&inputs.concat()), &found, 1e-7);

        // The wrenches that move the robot: the range of J M^-1 J^T in units of force.
        let jacobian = scaled(&jacobian, &kept);
        let masses = dense_masses(&model, &mut interpreter, &state.q);
        let response = masses.cholesky().expect("positive").solve(&jacobian.transpose());
        let eigen = (&jacobian * response).symmetric_eigen();
        let most = eigen.eigenvalues.max();
        let mut range = DMatrix::zeros(kept.len(), kept.len());
        for (vector, _) in eigen
            .eigenvectors
            .column_iter()
            .zip(&eigen.eigenvalues)
            .filter(|(_, x)| **x > 1e-9 * most)
        {
            range += vector * vector.transpose();
        }
        let forces = |wrenches: &[f64]| {
            let force = kept.iter().map(|&(c, k, length)| wrenches[6 * c + k] / length);
            DVector::from_iterator(kept.len(), force)
        };
        for variable in 0..3 {
            for k in 0..nv {
                let own = column(&model, &found, (variable, k));
                let slope = slope(&model, &state, (variable, k), value);
                let what = format!("{active:?}, variable {variable}, entry {k}");
                assert_columns(nv, &own[..nv], &slope[..nv], &here[..nv], &what);
                let [own, slope] = [&own[nv..], &slope[nv..]].map(forces);
                let scale = slope.amax().max(forces(&here[nv..]).amax()).max(1.0);
                let smallest = &range * &slope;
                assert!((&own - &smallest).amax() < 1e-6 * scale, "{what}: {own} {smallest}");
                differ = differ.max((&own - &slope).amax() / scale);
            }
        }
    }
    assert!(checked > 5, "{checked} of {count} contacts");
    // The test is not empty: the shares of redundant contacts change with q.
    assert!(differ > 1e-3, "{differ}");
}
