//! Derivatives with equal limbs, and with columns, packed into vectors are those of the interpreter, with fewer
//! operations.

use modyn_codegen::graph::{Graph, Node};
use modyn_codegen::passes::{Directional, Displacement, along_directions, optimize, vjp};
use modyn_codegen::plan::{COLUMN_LANES, Kernels, LIMB_LIMITS};
use modyn_codegen::trace::{LimbPacking, Tracer};
use modyn_codegen::{Base, ReadOptions};
use modyn_codegen::{Builder, Function, Planning};
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::kinematics::coordinates::normalize_configuration;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::{ForwardDerivatives, Interpreter};

fn read(text: &str, name: &str, base: Base) -> Model {
    let options = ReadOptions { base, ..ReadOptions::default() };
    modyn_codegen::read(text, name, &options).expect("a good robot").model
}

/// Three forked legs on a body, a tail, a waist after them, and two arms on the torso: limbs of several modules,
/// groups of different numbers of limbs, and a trunk on both sides of the groups.
fn centaur() -> String {
    let link = |name: &str, k: f64| {
        let (mass, x, i) = (0.5 + 0.1 * k, 0.02 * k, 0.02 + 0.003 * k);
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"{x} 0.02 0.1\"/><mass value=\"{mass}\"/>\
             <inertia ixx=\"{i}\" iyy=\"0.03\" izz=\"0.02\" ixy=\"0.001\" ixz=\"0\" iyz=\"0\"/>\
             </inertial></link>"
        )
    };
    let joint = |parent: &str, child: &str, kind: &str, axis: &str, k: f64| {
        let (x, roll) = (0.1 * k - 0.2, 0.3 * k);
        format!(
            "<joint name=\"to_{child}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"{x} 0.1 0.2\" rpy=\"{roll} 0.2 0\"/><axis xyz=\"{axis}\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>\
             <dynamics damping=\"{k}\" armature=\"0.0{k}\"/></joint>{}",
            link(child, k)
        )
    };
    let mut text = format!("<robot name=\"centaur\">{}", link("body", 9.0));
    for k in [1.0, 2.0, 3.0] {
        let [hip, knee, toe, heel] =
            ["hip", "knee", "toe", "heel"].map(|name| format!("{name}{k}"));
        text += &joint("body", &hip, "revolute", "1 0 0", k);
        text += &joint(&hip, &knee, "prismatic", "0 0.6 0.8", k);
        text += &joint(&knee, &toe, "revolute", "0 1 0", k);
        text += &joint(&knee, &heel, "revolute", "0 0 1", k + 1.0);
    }
    text += &joint("body", "tail", "prismatic", "0 1 0", 2.0);
    text += &joint("body", "waist", "revolute", "0 0 1", 4.0);
    for k in [1.0, 3.0] {
        let [upper, fore] = ["upper", "fore"].map(|name| format!("{name}{k}"));
        text += &joint("waist", &upper, "revolute", "1 0 0", k);
        text += &joint(&upper, &fore, "revolute", "0 1 0", k);
    }
    text + "</robot>"
}

fn robots() -> Vec<(&'static str, Model)> {
    let quadruped = include_str!("../../robots/quadruped.urdf");
    let humanoid = include_str!("../../robots/humanoid.urdf");
    vec![
        ("quadruped", read(quadruped, "quadruped", Base::Fixed)),
        ("quadruped, floating", read(quadruped, "quadruped", Base::Floating)),
        ("humanoid", read(humanoid, "humanoid", Base::Fixed)),
        ("humanoid, floating", read(humanoid, "humanoid", Base::Floating)),
        ("centaur", read(&centaur(), "centaur", Base::Fixed)),
        ("centaur, floating", read(&centaur(), "centaur", Base::Floating)),
    ]
}

/// Returns coordinates, then three joint vectors.
fn state(model: &Model, seed: f64) -> [Vec<f64>; 4] {
    let vector = |n: usize, k: f64| -> Vec<f64> {
        let numbers = 0_u32..u32::try_from(n).expect("few");
        numbers.map(|i| libm::sin(f64::from(i) * 0.7 + seed + k)).collect()
    };
    let mut q = vector(model.nq(), 0.0);
    normalize_configuration(&Mechanism::new(model), &mut q);
    let [a, b, c] = [1.0, 2.0, 3.0].map(|k| vector(model.nv(), k));
    [q, a, b, c]
}

fn assert_close(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(1.0_f64, |largest, x| largest.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        let error = (found - expected).abs() / largest;
        assert!(error < tolerance, "{what}: {found} for {expected}, {error:e}");
    }
}

/// Six legs on a body, in six of eight lanes.
fn hexapod() -> String {
    let part = |parent: &str, child: &str, axis: &str, k: f64| {
        let (x, i) = (0.1 * k - 0.2, 0.02 + 0.004 * k);
        format!(
            "<joint name=\"to_{child}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"{x} 0.1 0.2\" rpy=\"{k} 0.2 0\"/><axis xyz=\"{axis}\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint><link name=\"{child}\"><inertial>\
             <origin xyz=\"0.1 {x} 0.1\"/><mass value=\"{k}\"/><inertia ixx=\"{i}\" iyy=\"0.04\" izz=\"0.03\" ixy=\"0.001\" \
             ixz=\"0\" iyz=\"0\"/></inertial></link>"
        )
    };
    let mut text = "<robot name=\"hexapod\"><link name=\"world\"/>".to_string();
    text += &part("world", "body", "0 0.6 0.8", 3.0);
    for k in [1.0, 2.0, 3.0, 4.0, 5.0, 6.0] {
        let [upper, lower] = ["upper", "lower"].map(|name| format!("{name}{k}"));
        text += &part("body", &upper, "1 0 0", k);
        text += &part(&upper, &lower, "0 1 0", 0.5 * k);
    }
    text + "</robot>"
}

/// The centaur with the knees and the tail as planar joints, and the hips with poses, whose coordinates are quaternions.
fn with_poses() -> String {
    let hip = |text: String, k: u32| {
        let name = format!("<joint name=\"to_hip{k}\" type=");
        text.replace(&format!("{name}\"revolute\""), &format!("{name}\"floating\""))
    };
    [1, 2, 3].into_iter().fold(centaur(), hip).replace("prismatic", "planar")
}

/// Three legs and two claws on one body: packs of four lanes and of two, all of which the body moves.
fn crab() -> String {
    let part = |parent: &str, child: &str, kind: &str, k: f64| {
        let (x, i) = (0.1 * k - 0.2, 0.02 + 0.004 * k);
        format!(
            "<joint name=\"to_{child}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"{x} 0.1 0.2\" rpy=\"{k} 0.2 0\"/><axis xyz=\"1 0 0\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>{}",
            link(child, x, i)
        )
    };
    fn link(name: &str, x: f64, i: f64) -> String {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0.1 {x} 0.1\"/><mass value=\"0.8\"/>\
             <inertia ixx=\"{i}\" iyy=\"0.04\" izz=\"0.03\" ixy=\"0.001\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        )
    }
    let mut text = format!("<robot name=\"crab\">{}", link("body", 0.1, 0.05));
    for k in [1.0, 2.0, 3.0] {
        let [upper, lower] = ["upper", "lower"].map(|name| format!("{name}{k}"));
        text += &part("body", &upper, "revolute", k);
        text += &part(&upper, &lower, "revolute", 0.5 * k);
    }
    text += &part("body", "left", "prismatic", 2.0);
    text += &part("body", "right", "prismatic", 3.0);
    text + "</robot>"
}

/// Hessians with equal limbs in lanes are those on scalars, which other tests compare with dual numbers.
#[test]
fn hessians_with_limbs_in_lanes_are_those_on_scalars() {
    let mut robots = robots();
    robots.push(("hexapod", read(&hexapod(), "hexapod", Base::Fixed)));
    robots.push(("poses", read(&with_poses(), "poses", Base::Fixed)));
    robots.push(("crab", read(&crab(), "crab", Base::Floating)));
    for (name, model) in robots {
        let mechanism = Mechanism::new(&model);
        let tracer = Tracer::new(&mechanism);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
        let hessians = |tracer: &Tracer<'_>| {
            [
                optimize(tracer.inverse_dynamics_hessian()),
                optimize(tracer.forward_dynamics_hessian(&layout)),
                optimize(tracer.step_semi_implicit_hessian(&layout)),
            ]
        };
        let scalar = hessians(&tracer);
        let candidates = LimbPacking::candidates(&mechanism, &LIMB_LIMITS, true);
        assert!(candidates[0].share_root_path(&mechanism), "{name}");
        // The condition under which composites are propagated together, and the plan packs limbs.
        for limbs in candidates.iter().filter(|limbs| limbs.share_root_path(&mechanism)) {
            let packed = hessians(&tracer.packed(limbs));
            for (k, (scalar, packed)) in scalar.iter().zip(&packed).enumerate() {
                let counts = [scalar, packed].map(|graph| graph.count().total());
                // Poses have many operations on single numbers.
                let fifths = if name == "poses" { 5 } else { 4 };
                assert!(
                    counts[1] * 5 < counts[0] * fifths,
                    "{name}, Hessian {k}: {counts:?} operations"
                );
                for seed in [0.0, 1.3] {
                    let [q, qd, x, weights] = state(&model, seed);
                    let inputs = match k {
                        // The time, and weights of the coordinates, too.
                        2 => [&q[..], &qd, &x, &[0.1], &weights, &qd].concat(),
                        _ => [q, qd, x, weights].concat(),
                    };
                    let expected = scalar.evaluate::<f64>(&inputs);
                    let found = packed.evaluate::<f64>(&inputs);
                    assert_close(&format!("{name}, Hessian {k}"), &found, &expected, 1e-10);
                }
            }
        }
    }
}

/// A robot whose Hessians have packs of two widths gets them in lanes, without a warning.
#[test]
fn hessians_with_packs_of_two_widths_are_planned() {
    let functions = [
        Function::InverseDynamicsHessian,
        Function::ForwardDynamicsHessian,
        Function::StepSemiImplicitHessian,
    ];
    let builder = Builder::new().urdf_text(crab(), "crab.urdf").base(Base::Floating);
    let Planning { plan, warnings, .. } = builder.functions(functions).plan().expect("good");
    assert!(plan.faults().next().is_none() && warnings.is_empty(), "{warnings:?}");
    for planned in &plan.functions {
        let Kernels::Straight { simd: Some(simd), .. } = &planned.kernels else {
            panic!("{}", planned.name)
        };
        assert_eq!(Vec::from_iter(simd.widths()), [1, 2, 4], "{}", planned.name);
    }
}

/// The numbers of four limbs x, in lanes, and of a trunk y: y x_k^2 of each limb, and their sum.
fn four_limbs() -> (Graph, [u32; 5]) {
    let mut graph = Graph::default();
    let inputs = [0, 1, 2, 3, 4].map(|k| graph.input(k));
    let [x @ .., y] = inputs;
    let lanes = graph.pack(&x);
    let squares = graph.make(Node::Mul(lanes, lanes));
    let products = graph.make(Node::Mul(squares, y));
    let each = [0, 1, 2, 3].map(|lane| graph.make(Node::ExtractLane(products, lane)));
    let sum = graph.pairwise_sum(&each);
    graph.outputs = [&each[..], &[sum]].concat();
    (graph, inputs)
}

/// Returns the displacements of each limb's number by 1 along a direction of its own.
fn displacements(graph: &mut Graph) -> Vec<Displacement> {
    let change = graph.constant(1.0);
    (0..4).map(|k| Displacement { input: k.into(), direction: k, change }).collect()
}

#[test]
fn directions_of_four_limbs_share_a_pack() {
    let (mut graph, _) = four_limbs();
    let displacements = displacements(&mut graph);
    let Directional { graph: all, changes } =
        along_directions(&graph, &displacements).expect("limbs that do not move each other");
    let point = [0.3, -0.7, 1.1, 0.4, 0.6];
    for lane in 0..4 {
        let change = |output: usize| -> f64 {
            let terms = changes[output].iter().filter(|(_, lanes)| lanes >> lane & 1 == 1);
            let lanes = terms.map(|&(pack, _)| {
                let mut of_lane = all.clone();
                let number = of_lane.make(Node::ExtractLane(all.outputs[pack], lane));
                of_lane.outputs = vec![number];
                of_lane.evaluate::<f64>(&point)[0]
            });
            lanes.sum()
        };
        let expected = 2.0 * point[4] * point[usize::from(lane)];
        for limb in 0..4 {
            let own = if limb == usize::from(lane) { expected } else { 0.0 };
            assert_close(&format!("limb {limb} along {lane}"), &[change(limb)], &[own], 1e-15);
        }
        assert_close(&format!("the sum along {lane}"), &[change(4)], &[expected], 1e-15);
    }
    // A product for each factor, and the sum of both, in lanes.
    assert!(all.nodes().len() < graph.nodes().len() + 12);
}

/// The changes of one scalar may be in packs of several widths.
#[test]
fn directions_of_packs_of_two_widths() {
    let (mut graph, [a, b, ..]) = four_limbs();
    let displacements = displacements(&mut graph);
    let two = graph.pack(&[a, b]);
    let cubes = graph.make(Node::Mul(two, two));
    let cubes = graph.make(Node::Mul(cubes, two));
    let cube = graph.make(Node::ExtractLane(cubes, 1));
    let square = graph.outputs[1];
    graph.outputs = vec![graph.make(Node::Add(square, cube))];
    let Directional { graph: mut all, changes } =
        along_directions(&graph, &displacements).expect("limbs that do not move each other");
    let terms: Vec<u32> = changes[0]
        .iter()
        .map(|&(pack, lanes)| {
            assert_eq!(lanes, 0b10);
            all.make(Node::ExtractLane(all.outputs[pack], 1))
        })
        .collect();
    all.outputs = vec![all.pairwise_sum(&terms)];
    let found = all.evaluate::<f64>(&[0.3, -0.7, 1.1, 0.4, 0.6]);
    // y x^2 + x^3.
    assert_close("the change", &found, &[2.0 * 0.6 * -0.7 + 3.0 * 0.49], 1e-15);
}

/// The gradient by a scalar that takes part in operations on packs of several widths.
#[test]
fn gradients_of_a_scalar_in_packs_of_two_widths() {
    let (mut graph, [a, b, _, _, y]) = four_limbs();
    let two = graph.pack(&[a, b]);
    let products = graph.make(Node::Mul(two, y));
    let each = [0, 1].map(|lane| graph.make(Node::ExtractLane(products, lane)));
    let sum = graph.pairwise_sum(&each);
    graph.outputs = vec![graph.outputs[4], sum];
    let gradient = vjp(&graph, 5, 4..5);
    let x = [0.3, -0.7, 1.1, 0.4, 0.6];
    let squares: f64 = x[..4].iter().map(|x| x * x).sum();
    let found = gradient.evaluate::<f64>(&[&x[..], &[2.0, 5.0]].concat());
    assert_close("the gradient", &found, &[2.0 * squares + 5.0 * (x[0] + x[1])], 1e-15);
}

#[test]
fn limbs_that_move_each_other_have_no_common_directions() {
    let (mut graph, [a, b, c, d, _]) = four_limbs();
    let moved = displacements(&mut graph);
    let lanes = [[a, b, c, d], [b, a, d, c]].map(|lanes| graph.pack(&lanes));
    let crossed = graph.make(Node::Mul(lanes[0], lanes[1]));
    graph.outputs = vec![graph.make(Node::ExtractLane(crossed, 2))];
    assert!(along_directions(&graph, &moved).is_none());
    // The halves of the pack of limbs are no packs of limbs, either.
    let (mut graph, [_, _, c, d, y]) = four_limbs();
    let moved = displacements(&mut graph);
    let half = graph.pack(&[c, d]);
    let product = graph.make(Node::Mul(half, y));
    graph.outputs = vec![graph.make(Node::ExtractLane(product, 0))];
    assert!(along_directions(&graph, &moved).is_none());
}

/// Returns the condition number of a symmetric matrix in the infinity norm, from the matrix and its inverse.
fn condition(matrix: &[f64], inverse: &[f64], n: usize) -> f64 {
    let norm = |matrix: &[f64]| {
        let sums = matrix.chunks(n).map(|column| column.iter().map(|x| x.abs()).sum::<f64>());
        sums.fold(0.0, f64::max)
    };
    norm(matrix) * norm(inverse)
}

#[test]
fn derivatives_side_by_side_are_the_interpreters() {
    for (name, model) in robots() {
        let mechanism = Mechanism::new(&model);
        let tracer = Tracer::new(&mechanism);
        let candidates = LimbPacking::candidates(&mechanism, &LIMB_LIMITS, true);
        assert_eq!(candidates.len(), if name.starts_with("humanoid") { 2 } else { 1 }, "{name}");
        assert!(candidates.iter().all(|limbs| limbs.share_root_path(&mechanism)), "{name}");
        let mut tracers: Vec<Tracer> =
            candidates.iter().map(|limbs| tracer.packed(limbs)).collect();
        tracers.push(tracer.column_lanes(COLUMN_LANES));
        let layouts = [ModuleTree::chains(&model), ModuleTree::links(&model)]
            .map(|modules| UduLayout::new(&mechanism, &modules));
        let inverse: Vec<Graph> =
            tracers.iter().map(|t| optimize(t.inverse_dynamics_derivatives())).collect();
        let forward = tracers.iter().flat_map(|tracer| {
            layouts.iter().map(|layout| optimize(tracer.forward_dynamics_derivatives(layout)))
        });
        let forward: Vec<Graph> = forward.collect();
        let mut interpreter = Interpreter::new(model.clone());
        let n = model.nv();
        for seed in [0.0, 1.3, 4.1] {
            let [q, qd, qdd, tau] = state(&model, seed);
            let mut expected = vec![0.0; 2 * n * n];
            let (dq, dqd) = expected.split_at_mut(n * n);
            interpreter.inverse_dynamics_derivatives(&q, &qd, &qdd, dq, dqd).expect("lengths");
            for graph in &inverse {
                let found = graph.evaluate(&[&*q, &*qd, &*qdd].concat());
                assert_close(&format!("{name}, inverse dynamics"), &found, &expected, 1e-11);
            }

            let mut expected = vec![0.0; n + 3 * n * n];
            let (accelerations, rest) = expected.split_at_mut(n);
            let (dqdd_dq, rest) = rest.split_at_mut(n * n);
            let (dqdd_dqd, dqdd_dtau) = rest.split_at_mut(n * n);
            let outputs = ForwardDerivatives { qdd: accelerations, dqdd_dq, dqdd_dqd, dqdd_dtau };
            interpreter.forward_dynamics_derivatives(&q, &qd, &tau, outputs).expect("lengths");
            let mut matrix = vec![0.0; n * n];
            interpreter.mass_matrix(&q, &mut matrix).expect("lengths");
            let condition = condition(&matrix, &expected[n + 2 * n * n..], n);
            for graph in &forward {
                let found = graph.evaluate(&[&*q, &*qd, &*tau].concat());
                let parts =
                    [0..n, n..n + n * n, n + n * n..n + 2 * n * n, n + 2 * n * n..found.len()];
                for part in parts {
                    let (found, expected) = (&found[part.clone()], &expected[part]);
                    let tolerance = 1e-15 * condition.max(1e4);
                    assert_close(&format!("{name}, forward"), found, expected, tolerance);
                }
                let inverse = &found[n + 2 * n * n..];
                for i in 0..n {
                    for j in 0..i {
                        let (a, b) = (inverse[i * n + j], inverse[j * n + i]);
                        assert_eq!(a.to_bits(), b.to_bits(), "{name}: symmetric");
                    }
                }
            }
        }
    }
}

/// Legs on one branch and equal arms on another: their results are not propagated together.
#[test]
fn limbs_on_two_branches_share_no_root_path() {
    let part = |parent: &str, child: &str, kind: &str, axis: &str| {
        format!(
            "<joint name=\"to_{child}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <origin xyz=\"0.1 0.2 0.3\"/><axis xyz=\"{axis}\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint><link name=\"{child}\"><inertial>\
             <origin xyz=\"0.1 0.02 0.1\"/><mass value=\"1\"/>\
             <inertia ixx=\"0.03\" iyy=\"0.03\" izz=\"0.02\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        )
    };
    let mut text = "<robot name=\"two\"><link name=\"world\"/>".to_string();
    text += &part("world", "trunk", "revolute", "0 0 1");
    for (branch, kind) in [("front", "revolute"), ("back", "prismatic")] {
        text += &part("trunk", branch, kind, "1 0 0");
        for k in [1, 2] {
            let [upper, lower] = ["upper", "lower"].map(|name| format!("{branch}_{name}{k}"));
            text += &part(branch, &upper, "revolute", "1 0 0");
            text += &part(&upper, &lower, "revolute", "0 1 0");
        }
    }
    text += "</robot>";
    let model = read(&text, "two branches", Base::Fixed);
    let mechanism = Mechanism::new(&model);
    let joined = LimbPacking::joined(&mechanism, &LIMB_LIMITS).expect("limbs that can join");
    assert!(!joined.share_root_path(&mechanism));
    // They are therefore packed for torques, but not where columns are propagated.
    let joins = |function| {
        let builder = Builder::new().urdf_text(&text, "two.urdf").functions([function]);
        builder.generate().expect("a good robot").text.contains("Pack<A, 4>")
    };
    assert!(joins(Function::InverseDynamics));
    for function in [
        Function::MassMatrix,
        Function::InverseDynamicsDerivatives,
        Function::ForwardDynamicsDerivatives,
    ] {
        assert!(!joins(function), "{}", function.name());
    }
}
