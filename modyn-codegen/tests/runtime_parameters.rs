//! Run-time parameters are inputs of the graphs: with their values, a graph computes the results of the robot that is
//! described with these values.

use modyn_codegen::passes::optimize;
use modyn_codegen::plan::COLUMN_LANES;
use modyn_codegen::trace::{Parameters, Tracer};
use modyn_codegen::{Base, Function, ReadOptions, read_urdf};
use modyn_runtime::equations::Motion;
use modyn_runtime::equations::constraints::ConstrainedInverseOutputs;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Inertial, Model, ModuleTree, Spring};
use modyn_runtime::spatial::Wrench;
use modyn_runtime::{ConstraintSettings, ContactTarget, Interpreter};

/// The links of the robot, in the order of its frames: a fixed base and three joints in general position; two links are
/// fixed to bodies, one of them twice removed.
const LINKS: [&str; 7] = ["base", "upper", "plate", "slider", "wrist", "tool", "grip"];

/// Returns a full inertia that depends on `k`.
fn inertial(k: usize) -> Inertial {
    let k = k as f64;
    Inertial {
        mass: 0.7 + 0.3 * k,
        center_of_mass: [0.05 - 0.02 * k, 0.03 * k, 0.11 - 0.04 * k],
        inertia: [0.02 + 0.01 * k, 0.001 * k, -0.002, 0.025 + 0.01 * k, 0.0015, 0.03 + 0.01 * k],
    }
}

/// Returns the inertias in the description: the grip has none.
fn described() -> [Inertial; LINKS.len()] {
    std::array::from_fn(|i| if i == 6 { Inertial::default() } else { inertial(i) })
}

/// Returns the robot with these inertias of its links, and with loads: links fixed to its links.
fn robot(own: &[Inertial; LINKS.len()], loads: &[(usize, Inertial)], gravity: [f64; 3]) -> Model {
    let link = |name: &str, inertial: &Inertial| {
        let Inertial { mass, center_of_mass: [x, y, z], inertia: [xx, xy, xz, yy, yz, zz] } =
            inertial;
        format!(
            "<link name='{name}'><inertial><origin xyz='{x} {y} {z}'/><mass value='{mass}'/>\
             <inertia ixx='{xx}' ixy='{xy}' ixz='{xz}' iyy='{yy}' iyz='{yz}' izz='{zz}'/></inertial></link>"
        )
    };
    let joint = |kind: &str, parent: &str, child: &str, place: &str| {
        format!(
            "<joint name='{child}_joint' type='{kind}'><parent link='{parent}'/><child link='{child}'/>\
             <origin {place}/><axis xyz='0.48 -0.6 0.64'/>\
             <limit lower='-9' upper='9' effort='9' velocity='9'/></joint>"
        )
    };
    let mut text = String::from("<robot name='r'>");
    for (name, inertial) in LINKS.iter().zip(own) {
        text += &link(name, inertial);
    }
    let place = "xyz='0.2 -0.1 0.3' rpy='0.4 -0.7 1.1'";
    for (kind, parent, child) in [
        ("revolute", "base", "upper"),
        ("fixed", "upper", "plate"),
        ("prismatic", "upper", "slider"),
        ("revolute", "plate", "wrist"),
        ("fixed", "wrist", "tool"),
        ("fixed", "tool", "grip"),
    ] {
        text += &joint(kind, parent, child, place);
    }
    for (i, load) in loads {
        let name = format!("load_{}", LINKS[*i]);
        text += &link(&name, load);
        text += &joint("fixed", LINKS[*i], &name, "");
    }
    let options = ReadOptions { gravity: Some(gravity), ..ReadOptions::default() };
    let model = read_urdf(&(text + "</robot>"), "r.urdf", &options).expect("a good robot").model;
    let spring = |link| Spring { link, stiffness: 3.0 + link as f64, reference: vec![0.4] };
    let model = model.with_springs(vec![spring(0), spring(2)]).expect("good springs");
    // Loads are not compensated.
    let mut factors = vec![0.0, 0.6, -0.3, 0.0, 1.2, 0.5, 0.8];
    factors.resize(model.links().len(), 0.0);
    model.with_gravity_compensation(factors).expect("a factor for each frame")
}

/// Returns the index of a link among the robot's frames.
fn frame(model: &Model, link: usize) -> usize {
    model.link_index(LINKS[link]).expect("a link")
}

fn numbers(inertial: &Inertial) -> Vec<f64> {
    let Inertial { mass, center_of_mass, inertia } = inertial;
    [&[*mass][..], center_of_mass, inertia].concat()
}

fn assert_close(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (found, expected) in found.iter().zip(expected) {
        let error = (found - expected).abs() / expected.abs().max(1.0);
        assert!(error < 1e-11, "{what}: {found} instead of {expected}");
    }
}

const DEFAULT_GRAVITY: [f64; 3] = [0.3, -0.4, -9.7];

/// All combinations: gravity; own inertias of a body's link, of links that are fixed to bodies (also to the same one),
/// and of a link that never moves; payloads on links with and without a run-time inertia.
fn choices() -> Vec<(bool, Vec<usize>, Vec<usize>)> {
    let (own, payloads) = (
        [vec![], vec![1], vec![5], vec![4, 2], vec![6, 4, 5], vec![0]],
        [vec![], vec![2], vec![5, 3], vec![6, 0]],
    );
    let mut all = Vec::new();
    for gravity in [false, true] {
        for own in &own {
            all.extend(payloads.iter().map(|p| (gravity, own.clone(), p.clone())));
        }
    }
    all
}

#[test]
fn a_graph_with_parameters_is_that_of_a_description_with_their_values() {
    let model = robot(&described(), &[], DEFAULT_GRAVITY);
    let mechanism = Mechanism::new(&model);
    let (q, qd, x) = ([0.4, -0.3, 0.8], [0.7, 0.5, -1.2], [1.3, -0.6, 0.9]);
    for (with_gravity, inertias, payloads) in choices() {
        let what =
            format!("gravity: {with_gravity}, inertias: {inertias:?}, payloads: {payloads:?}");
        let frames = |links: &[usize]| links.iter().map(|&i| frame(&model, i)).collect::<Vec<_>>();
        let parameters =
            Parameters::new(&model, with_gravity, &frames(&inertias), &frames(&payloads));
        let gravity = if with_gravity { [-2.1, 3.3, 0.7] } else { DEFAULT_GRAVITY };
        let mut own = described();
        let mut values = if with_gravity { gravity.to_vec() } else { Vec::new() };
        for &i in &inertias {
            own[i] = inertial(i + 3);
            values.extend(numbers(&own[i]));
        }
        let loads: Vec<_> = payloads.iter().map(|&i| (i, inertial(9 - i))).collect();
        values.extend(loads.iter().flat_map(|(_, load)| numbers(load)));
        assert_eq!(parameters.len(), values.len(), "{what}");
        assert_eq!(parameters.is_empty(), values.is_empty(), "{what}");

        let tracer = Tracer::with_parameters(&mechanism, parameters);
        assert_eq!(tracer.parameters().len(), values.len(), "{what}");
        let changed = robot(&own, &loads, gravity);
        let mut expected = Interpreter::<f64>::new(changed);
        let (mut tau, mut qdd, mut mass) = ([0.0; 3], [0.0; 3], [0.0; 9]);
        expected.inverse_dynamics(&q, &qd, &x, &mut tau).expect("sizes");
        expected.forward_dynamics(&q, &qd, &x, &mut qdd).expect("sizes");
        expected.mass_matrix(&q, &mut mass).expect("sizes");
        let inputs = |joint: &[&[f64]]| [joint.concat(), values.clone()].concat();
        for tracer in [tracer.clone(), tracer.column_lanes(COLUMN_LANES)] {
            let found = optimize(tracer.inverse_dynamics()).evaluate(&inputs(&[&q, &qd, &x]));
            assert_close(&found, &tau, &format!("inverse dynamics, {what}"));
            let elimination = Elimination::new(&mechanism, &ModuleTree::links(&model));
            let found = optimize(tracer.forward_dynamics(&elimination));
            let found = found.evaluate(&inputs(&[&q, &qd, &x]));
            assert_close(&found, &qdd, &format!("forward dynamics, {what}"));
            let found = optimize(tracer.mass_matrix()).evaluate(&inputs(&[&q]));
            assert_close(&found, &mass, &format!("mass matrix, {what}"));
        }
        // Energies differ by constants where links that never move have mass.
        let potential = optimize(tracer.evaluation(Function::PotentialEnergy, &model, None));
        let difference = [q, [-0.9, 0.2, 0.1]].map(|q| potential.evaluate(&inputs(&[&q]))[0]);
        let energies = [q, [-0.9, 0.2, 0.1]].map(|q| expected.potential_energy(&q).expect("size"));
        let [found, expected] = [difference, energies].map(|[a, b]| a - b);
        assert_close(&[found], &[expected], &format!("potential energy, {what}"));
    }
}

#[test]
fn the_default_values_are_those_of_the_description() {
    let model = robot(&described(), &[], DEFAULT_GRAVITY);
    for (with_gravity, inertias, payloads) in choices() {
        let frames = |links: &[usize]| links.iter().map(|&i| frame(&model, i)).collect::<Vec<_>>();
        let parameters =
            Parameters::new(&model, with_gravity, &frames(&inertias), &frames(&payloads));
        let values = parameters.described(DEFAULT_GRAVITY);
        assert_eq!(values.len(), parameters.len());
        let start = if with_gravity { 3 } else { 0 };
        assert_eq!(values[..start], DEFAULT_GRAVITY[..start]);
        for (k, &i) in inertias.iter().enumerate() {
            let at = parameters.inertial(k);
            assert_eq!(at, start + 10 * k);
            assert_close(&values[at..at + 10], &numbers(&described()[i]), LINKS[i]);
        }
        let loads = parameters.inertial(inertias.len());
        assert_eq!(values[loads..], vec![0.0; 10 * payloads.len()]);
    }
}

/// The inertia at a joint without descendants is its entry of the mass matrix.
#[test]
fn only_joints_without_other_inertia_are_checked() {
    let model = robot(&described(), &[], DEFAULT_GRAVITY);
    let mechanism = Mechanism::new(&model);
    let pivots = |own: &[usize], payloads: &[usize]| {
        let frames = |links: &[usize]| links.iter().map(|&i| frame(&model, i)).collect::<Vec<_>>();
        let parameters = Parameters::new(&model, true, &frames(own), &frames(payloads));
        Tracer::with_parameters(&mechanism, parameters).inertia_pivots()
    };
    // Coordinates stand depth first: the order of the joints in the tree.
    let entry = |link: &str| {
        let moving = model.moving_links().iter().position(|l| l.name == link).expect("moves");
        model.v_range(moving).start
    };
    let (wrist, slider) = (entry("wrist"), entry("slider"));
    // The wrist carries the tool and the grip, the plate is on the upper arm, which carries all other bodies.
    for own in [vec![], vec![4], vec![5], vec![4, 6], vec![1, 2], vec![0]] {
        assert!(pivots(&own, &[3]).is_none(), "{own:?}");
    }
    for own in [vec![4, 5], vec![5, 4, 6], vec![4, 5, 1]] {
        let (entries, graph) = pivots(&own, &[6]).expect("the wrist has no other inertia");
        assert_eq!(entries, [wrist]);
        let graph = optimize(graph);
        let mut inertias = described();
        let mut values = [&[f64::EPSILON], &DEFAULT_GRAVITY[..]].concat();
        for &i in &own {
            inertias[i] = inertial(i + 2);
            values.extend(numbers(&inertias[i]));
        }
        let load = inertial(8);
        let full = [values.clone(), numbers(&load)].concat();
        let changed = robot(&inertias, &[(6, load)], DEFAULT_GRAVITY);
        let mut mass = [0.0; 9];
        let mut interpreter = Interpreter::<f64>::new(changed);
        interpreter.mass_matrix(&[0.1, 0.2, 0.3], &mut mass).expect("sizes");
        assert_close(&graph.evaluate(&full), &[mass[4 * wrist]], "the wrist's inertia");
        let none = [&values[..4], &vec![0.0; 10 * (own.len() + 1)]].concat();
        assert_eq!(graph.evaluate(&none), [0.0]);
    }
    // A prismatic joint needs mass, a revolute one an inertia about its axis.
    let (entries, graph) = pivots(&[3, 5, 4], &[]).expect("both have no other inertia");
    let mut both = [wrist, slider];
    both.sort_unstable();
    assert_eq!(entries, both);
    let mut values = vec![0.0; 34];
    values[0] = f64::EPSILON;
    values[4] = 2.5;
    let found = optimize(graph).evaluate(&values);
    for (entry, pivot) in entries.iter().zip(found) {
        assert_close(&[pivot], &[if *entry == slider { 2.5 } else { 0.0 }], "a point mass");
    }
}

/// Returns a floating trunk on two legs with flat soles, the first of which has this inertia.
fn walker(leg: &Inertial) -> Interpreter<f64> {
    let link = |name: &str, own: &Inertial| {
        let Inertial { mass, center_of_mass: [x, y, z], inertia: [xx, xy, xz, yy, yz, zz] } = own;
        format!(
            "<link name='{name}'><inertial><origin xyz='{x} {y} {z}'/><mass value='{mass}'/>\
             <inertia ixx='{xx}' ixy='{xy}' ixz='{xz}' iyy='{yy}' iyz='{yz}' izz='{zz}'/></inertial></link>"
        )
    };
    let hip = |leg: &str, y: f64| {
        format!(
            "<joint name='{leg}_hip' type='continuous'><parent link='trunk'/><child link='{leg}'/>\
             <origin xyz='0 {y} -0.1'/><axis xyz='0 1 0'/></joint>\
             <contact_frame name='{leg}_sole' type='surface' link='{leg}' xyz='0.02 0 -0.5'/>"
        )
    };
    let links = [("trunk", &inertial(2)), ("left", leg), ("right", &inertial(1))];
    let links = links.map(|(name, own)| link(name, own)).concat();
    let text =
        format!("<robot name='walker'>{links}{}{}</robot>", hip("left", 0.1), hip("right", -0.1));
    let options = ReadOptions { base: Base::Floating, ..ReadOptions::default() };
    Interpreter::new(read_urdf(&text, "walker.urdf", &options).expect("a good robot").model)
}

/// Returns the wrenches of both soles that carry the walker in a state.
fn carrying(walker: &mut Interpreter<f64>) -> Vec<[f64; 6]> {
    let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
        ConstraintSettings::<f64>::DEFAULT;
    let targets = vec![ContactTarget::<f64>::GROUND; 2];
    let settings = ConstraintSettings { alpha, beta, tolerance, rounding, targets };
    let q = [0.1, -0.2, 0.6, 0.0, 0.0, 0.28, 0.96, 0.3, -0.2];
    let (qd, qdd) = ([0.0; 8], [0.3, -0.2, 0.4, 0.1, 0.2, -0.3, 0.5, -0.6]);
    let (mut tau, mut wrenches) = ([0.0; 8], [Wrench::zero(); 2]);
    let found = ConstrainedInverseOutputs { tau: &mut tau, wrenches: &mut wrenches };
    walker
        .constrained_inverse_dynamics(
            Motion { q: &q, qd: &qd, qdd: &qdd },
            &[true; 2],
            &settings,
            found,
        )
        .expect("the lengths fit");
    let numbers = |w: &Wrench<f64>| w.components();
    wrenches.iter().map(numbers).collect()
}

/// The characteristic length of a contact is that of the description. So redundant contacts share a load in another way
/// after an inertia is set than in the robot that is described with it, unless both have one radius of gyration.
#[test]
fn lengths_of_contacts_follow_the_description() {
    let difference = |a: &[[f64; 6]], b: &[[f64; 6]]| {
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let (light, wide) = (inertial(1), inertial(4));
    let heavy =
        Inertial { mass: 3.0 * light.mass, inertia: light.inertia.map(|x| 3.0 * x), ..light };
    for (own, is_same) in [(heavy, true), (wide, false)] {
        let mut set = walker(&light);
        let left = set.model().link_index("left").expect("a link");
        set.set_inertial(left, &own).expect("physical");
        let (set, described) = (carrying(&mut set), carrying(&mut walker(&own)));
        let found = difference(&set, &described);
        assert!(if is_same { found < 1e-10 } else { found > 1e-4 }, "{found}");
        // The soles together carry the same force.
        let force = |all: &[[f64; 6]]| [0, 1, 2].map(|k| all.iter().map(|w| w[k]).sum::<f64>());
        for (a, b) in force(&set).iter().zip(force(&described)) {
            assert!((a - b).abs() < 1e-10, "{a} is not {b}");
        }
    }
}
