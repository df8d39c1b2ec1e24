//! Stretched legs: constraints that lose rank through geometry. Each foot moves its leg, but not along it.

use super::*;
use modyn_runtime::equations::constraints::{
    ConstrainedInverseOutputs, ImpulseOutputs, OperationalSpaceInertiaOutputs, ProjectionOutputs,
};
use modyn_runtime::equations::{self, Motion};

/// A quadruped that lies on a frame of its trunk, with a point at each foot.
pub fn lying_quadruped() -> Model {
    let mut contacts = quadruped().contacts().to_vec();
    let end = LoopConstraintEnd {
        link: quadruped().link_index("trunk").expect("a link"),
        pose: Pose {
            rotation: rows(&rotation([0.3, -0.4, 0.2])),
            translation: [0.03, 0.02, -0.05],
        },
    };
    let kind = ContactKind::Surface;
    contacts.push(modyn_runtime::model::Contact { name: "belly".into(), kind, end });
    quadruped().with_contacts(contacts).expect("good")
}

/// Returns a state at rest whose knees are bent by these angles; the trunk and the hips are anywhere.
pub fn with_knees(model: &Model, bends: [f64; 4], random: &mut Random) -> State {
    let mut state = state(model, random);
    state.qd.fill(0.0);
    for (leg, bend) in bends.into_iter().enumerate() {
        state.q[7 + 3 * leg..][..3].copy_from_slice(&[random.next(), random.next(), bend]);
    }
    state
}

/// A leg in general position with a sole: a spherical hip, a knee about any axis, and an ankle with two axes. The three
/// centres are on one line if the knee's angle is zero.
fn leg(base: Base) -> Model {
    let link = |name: &str, x: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='{x} 0.1 -0.05' rpy='0.3 {x} 1'/><mass value='{}'/>\
             <inertia ixx='0.021' iyy='0.03' izz='0.025' ixy='0.002' ixz='-0.001' iyz='0.003'/></inertial></link>",
            2.0 + x
        )
    };
    let joint = |name: &str, kind: &str, [parent, child]: [&str; 2], inside: &str| {
        format!(
            "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{inside}</joint>"
        )
    };
    // The thigh and the shank are along (0.36, 0.48, -0.8).
    let text = [
        "<robot name='leg'>".into(),
        link("pelvis", 0.2),
        joint("hip", "spherical", ["pelvis", "thigh"], "<origin xyz='0.1 -0.2 0.05'/>"),
        link("thigh", 0.15),
        joint(
            "knee",
            "continuous",
            ["thigh", "shank"],
            "<origin xyz='0.18 0.24 -0.4'/><axis xyz='0.8 -0.6 0'/>",
        ),
        link("shank", 0.1),
        joint(
            "ankle",
            "universal",
            ["shank", "foot"],
            "<origin xyz='0.144 0.192 -0.32'/><axis xyz='0.6 0 0.8'/><axis2 xyz='0 0.8 -0.6'/>",
        ),
        link("foot", 0.05),
        "</robot>".into(),
    ];
    let at = [[0.07, -0.03, -0.06], [0.5, -0.2, 0.9]];
    let mut contacts = vec![contact("sole", ContactKind::Surface, "foot", at)];
    if base == Base::Floating {
        let at = [[-0.1, 0.05, 0.2], [0.2, 0.7, -0.4]];
        contacts.push(contact("seat", ContactKind::Surface, "pelvis", at));
    }
    model_of(&text.concat(), base, contacts)
}

fn assert_finite(numbers: &[f64]) {
    assert!(numbers.iter().all(|x| x.is_finite()), "{numbers:?}");
}

/// Numbers of all functions with constraints are finite, and of those that solve for motions the rank is this one.
fn assert_all_finite(model: &Model, state: &State, settings: &Settings, rank: f64) {
    let mut interpreter = Interpreter::new(model.clone());
    let (nv, count, rows) = (model.nv(), model.constraints(), model.constraint_rows());
    let active = vec![true; model.contacts().len()];
    let (mut a, mut b) = (vec![0.0; nv], vec![0.0; nv]);
    let mut wrenches = vec![Wrench::zero(); count];
    let motion = equations::State { q: &state.q, qd: &state.qd };
    let into = ImpulseOutputs { qd: &mut a, impulses: &mut wrenches };
    let found = interpreter.impact_dynamics(motion, &active, settings, into).expect("fits");
    assert_eq!(found, rank);
    assert_finite(&[a.clone(), components(&wrenches)].concat());
    let into = ProjectionOutputs { step_q: &mut a, step_qd: &mut b };
    interpreter.project_constraints(motion, &active, settings, into).expect("fits");
    assert_finite(&[a.clone(), b].concat());
    let motion = Motion { q: &state.q, qd: &state.qd, qdd: &state.tau };
    let into = ConstrainedInverseOutputs { tau: &mut a, wrenches: &mut wrenches };
    interpreter.constrained_inverse_dynamics(motion, &active, settings, into).expect("fits");
    assert_finite(&[a, components(&wrenches)].concat());
    let mut delassus = vec![0.0; rows * rows];
    let mut inertia = vec![0.0; rows * rows];
    let into = OperationalSpaceInertiaOutputs { delassus: &mut delassus, inertia: &mut inertia };
    let found =
        interpreter.operational_space_inertia(&state.q, &active, settings, into).expect("fits");
    assert_eq!(found, rank);
    assert_finite(&[delassus, inertia].concat());
}

/// The accelerations, the wrenches and the rank are those of the dense solution, of the interpreter and of this graph. The
/// derivatives are finite, and those by tau are differences of the dense solution, which is linear in tau.
fn check(
    model: &Model,
    state: &State,
    settings: &Settings,
    rank: usize,
    graphs: &[&modyn_codegen::graph::Graph],
    tolerance: f64,
) {
    let active = vec![true; model.contacts().len()];
    let expected = dense(model, state, &active, settings);
    #[allow(clippy::cast_precision_loss)]
    let rank = rank as f64;
    assert_eq!(expected.rank, rank);
    let found = interpreted(model, state, &active, settings);
    assert_finite(&[found.qdd.clone(), found.wrenches.concat()].concat());
    assert_same(&found, &expected, tolerance);
    let (nv, count) = (model.nv(), model.constraints());
    let inputs = [&*state.q, &state.qd, &state.tau, &switches(&active), &numbers(settings)];
    for graph in graphs {
        let found = graph.evaluate(&inputs.concat());
        let wrenches = found[nv..][..6 * count].chunks(6);
        let wrenches = wrenches.map(|w| std::array::from_fn(|k| w[k])).collect();
        let rank = found[found.len() - 1];
        assert_same(&Solution { qdd: found[..nv].into(), wrenches, rank }, &expected, tolerance);
    }
    assert_all_finite(model, state, settings, rank);

    let found = derivatives(model, state, &active, settings);
    assert_finite(&found);
    let at = |variable: usize| nv + 6 * count + variable * nv * nv;
    let by_tau = &found[at(2)..at(3)];
    let changes = &found[at(3) + 2 * 6 * count * nv..][..6 * count * nv];
    for k in 0..nv {
        let moved = moved(model, state, 2, k, 1.0);
        let there = dense(model, &moved, &active, settings);
        let slope: Vec<f64> = there.qdd.iter().zip(&expected.qdd).map(|(b, a)| b - a).collect();
        let rounding = tolerance * largest(&expected.qdd);
        let near = |x: f64, y: f64, scale: f64| {
            assert!((x - y).abs() < tolerance * scale + rounding, "{k}: {x} instead of {y}");
        };
        by_tau[k * nv..][..nv].iter().zip(&slope).for_each(|(&x, &y)| near(x, y, largest(&slope)));
        let rounding = tolerance * largest(&expected.wrenches.concat());
        for c in 0..count {
            for i in 0..6 {
                let slope = there.wrenches[c][i] - expected.wrenches[c][i];
                let found = changes[6 * (c * nv + k) + i];
                assert!(
                    (found - slope).abs() < tolerance * slope.abs() + rounding,
                    "wrench {c} by torque {k}: {found} instead of {slope}"
                );
            }
        }
    }
}

fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(1.0, |most, x| x.abs().max(most))
}

fn compliant(model: &Model, compliance: f64) -> Settings {
    let mut settings = exact(model);
    settings.targets.iter_mut().for_each(|target| target.compliance = compliance);
    settings
}

/// A foot of a stretched leg has two independent rows of three. Of rigid contacts, a knee that is bent by 1e-7 rad counts as
/// stretched, and a knee that is bent by 1 mrad does not: its row has a millionth of the mobility.
#[test]
fn feet_of_stretched_legs() {
    let (model, mut random) = (lying_quadruped(), Random(41));
    let mechanism = Mechanism::new(&model);
    let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
    let limbs = LimbPacking::find(&mechanism, &LIMB_LIMITS).expect("four legs");
    let tracer = Tracer::new(&mechanism);
    let scalar = optimize(tracer.constrained_forward_dynamics(&layout));
    let packed = optimize(tracer.packed(&limbs).constrained_forward_dynamics(&layout));
    let graphs = [&scalar, &packed];
    for (bends, stretched, tolerance) in [
        ([0.0; 4], 4, 1e-9),
        ([0.0, 0.8, -1.1, 0.0], 2, 1e-9),
        ([-0.7, 0.0, 0.9, 1.2], 1, 1e-9),
        ([1e-7, 0.0, -1e-7, 0.6], 3, 1e-5),
        ([1e-3, 0.0, 0.5, -1e-3], 1, 1e-6),
        ([0.01, -0.01, 0.02, 0.0], 1, 1e-7),
    ] {
        let state = with_knees(&model, bends, &mut random);
        check(&model, &state, &exact(&model), 18 - stretched, &graphs, tolerance);
        check(&model, &state, &compliant(&model, 1e-2), 18, &graphs, 1e-9);
    }
}

/// Rows contradict each other: the targets ask for accelerations along stretched legs. The accelerations minimize the
/// squared residuals.
#[test]
fn stretched_legs_whose_targets_move() {
    let (model, mut random) = (lying_quadruped(), Random(42));
    for bends in [[0.0; 4], [0.0, 0.8, -1.1, 0.0], [-0.7, 0.0, 0.9, 1.2]] {
        let mut state = with_knees(&model, bends, &mut random);
        state.qd = random.vector(model.nv(), 2.0);
        let stretched = bends.iter().filter(|&&bend| bend == 0.0).count();
        check(&model, &state, &general(&model, &mut random, 0.0), 18 - stretched, &[], 1e-8);
        check(&model, &state, &general(&model, &mut random, 0.02), 18, &[], 1e-8);
    }
}

/// The wrench along the line through hip and ankle moves no joint of a stretched leg.
#[test]
fn a_sole_of_a_stretched_leg_in_general_position() {
    let mut random = Random(43);
    for base in [Base::Fixed, Base::Floating] {
        let model = leg(base);
        let mechanism = Mechanism::new(&model);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
        let graph = optimize(Tracer::new(&mechanism).constrained_forward_dynamics(&layout));
        let knee = model.nq() - 3;
        let all = model.constraint_rows();
        for (bend, lost, tolerance) in [(0.0, 1, 1e-9), (0.02, 0, 1e-6), (0.2, 0, 1e-7)] {
            let mut state = state(&model, &mut random);
            state.q[knee] = bend;
            check(&model, &state, &compliant(&model, 1e-2), all, &[&graph], 1e-9);
            state.qd.fill(0.0);
            check(&model, &state, &exact(&model), all - lost, &[&graph], tolerance);
        }
    }
}
