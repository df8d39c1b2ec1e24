//! Machine code of functions of contacts computes what the interpreter does: one state, and many with sets of active
//! contacts of their own.

use modyn_codegen::diagnostics::Code;
use modyn_codegen::plan::Kernels;
use modyn_codegen::{Base, Builder, ContactKind, Function};
use modyn_jit::{Compiled, InstructionSet, Options};
use modyn_runtime::equations::constraints::{
    ConstrainedCotangent, ConstrainedOutputs, ImpulseOutputs, ResidualOutputs,
};
use modyn_runtime::equations::{ForwardInput, State};
use modyn_runtime::model::{self, LoopConstraintEnd, Model};
use modyn_runtime::spatial::{Pose, Twist, Vector3, Wrench};
use modyn_runtime::{ConstraintSettings, ContactTarget, Interpreter};
use modyn_tests::conformance::contact;
use modyn_tests::quantities::Quantities;
use modyn_tests::random;

const FUNCTIONS: [Function; 3] =
    [Function::ConstrainedForwardDynamics, Function::ImpactDynamics, Function::ConstraintResidual];

type Settings = ConstraintSettings<f64, Vec<ContactTarget<f64>>>;

fn numbers(settings: &Settings) -> Vec<f64> {
    let contacts = settings.targets.iter().flat_map(ContactTarget::numbers);
    settings.numbers().into_iter().chain(contacts).collect()
}

/// The interpreter's numbers of a function.
fn expected(
    interpreter: &mut Interpreter,
    function: Function,
    state: &random::State,
    (active, settings): (&[bool], &Settings),
) -> Vec<f64> {
    let random::State { q, qd, tau, .. } = state;
    let count = active.len();
    let (mut qdd, mut wrenches) = (vec![0.0; qd.len()], vec![Wrench::zero(); count]);
    let (mut first, mut second) = (vec![Twist::zero(); count], vec![Twist::zero(); count]);
    let rank = match function {
        Function::ConstrainedForwardDynamics => {
            let into = ConstrainedOutputs {
                qdd: &mut qdd,
                wrenches: &mut wrenches,
                residuals: &mut first,
            };
            interpreter.constrained_forward_dynamics(
                ForwardInput { q, qd, tau },
                active,
                settings,
                into,
            )
        }
        Function::ImpactDynamics => interpreter.impact_dynamics(
            State { q, qd },
            active,
            settings,
            ImpulseOutputs { qd: &mut qdd, impulses: &mut wrenches },
        ),
        _ => {
            let into = ResidualOutputs { displacements: &mut first, velocities: &mut second };
            interpreter.constraint_residual(State { q, qd }, settings, into).expect("fits");
            let twists = first.iter().chain(&second);
            return twists.flat_map(Twist::components).collect();
        }
    };
    let residuals = first.iter().flat_map(Twist::components);
    let residuals: Vec<f64> = match function {
        Function::ConstrainedForwardDynamics => residuals.collect(),
        _ => Vec::new(),
    };
    let wrenches = wrenches.iter().flat_map(Wrench::components);
    qdd.into_iter().chain(wrenches).chain(residuals).chain([rank.expect("fits")]).collect()
}

#[test]
fn contacts_on_the_ground_and_on_moving_frames() {
    let path = format!("{}/../robots/quadruped.urdf", env!("CARGO_MANIFEST_DIR"));
    let builder = Builder::new().urdf(path).base(Base::Floating).functions(FUNCTIONS);
    let planning = builder
        .contacts([
            contact("left", ContactKind::Point, "front_left_foot", [0.0, 0.01, -0.02]),
            contact("sole", ContactKind::Surface, "hind_right_foot", [0.03, -0.01, 0.02]),
            contact("right", ContactKind::Point, "front_right_foot", [0.01, 0.0, -0.02]),
        ])
        .plan()
        .expect("good");
    let model = &planning.model;
    let rotation = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]];
    let moving = ContactTarget {
        pose: Pose { rotation, translation: [0.3, -0.2, 0.1] },
        velocity: Twist { angular: Vector3([0.1, -0.3, 0.2]), linear: Vector3([0.4, 0.1, -0.2]) },
        tangential: 0.7,
        compliance: 0.02,
        restitution: 0.4,
        ..ContactTarget::<f64>::GROUND
    };
    let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
        ConstraintSettings::<f64>::DEFAULT;
    let targets = vec![ContactTarget::<f64>::GROUND, moving, ContactTarget::<f64>::EXACT];
    let settings = ConstraintSettings { alpha, beta, tolerance, rounding, targets };
    let numbers = numbers(&settings);
    let mut interpreter = Interpreter::new(model.clone());

    let masks: Vec<[bool; 3]> = (0..8_u8).map(|i| [0, 1, 2].map(|bit| i >> bit & 1 == 1)).collect();
    let states: Vec<random::State> = (0..8).map(|seed| random::state(seed, model)).collect();
    for instruction_set in InstructionSet::available() {
        let mut options = Options::default();
        (options.instruction_set, options.batches) = (Some(instruction_set), true);
        let compiled = Compiled::<f64>::from_plan(&planning, options).expect("code");
        for function in FUNCTIONS {
            let call = compiled.function(function).expect("compiled");
            let names: Vec<&str> = call.arguments().iter().map(|(name, _)| *name).collect();
            let one = call.result().len();
            let (mut all, mut wanted) = (vec![Vec::new(); names.len()], Vec::new());
            for (state, mask) in states.iter().zip(&masks) {
                let arguments: Vec<Vec<f64>> = names
                    .iter()
                    .map(|name| match *name {
                        "q" => state.q.clone(),
                        "qd" => state.qd.clone(),
                        "tau" => state.tau.clone(),
                        "active" => mask.map(|active| f64::from(u8::from(active))).to_vec(),
                        _ => numbers.clone(),
                    })
                    .collect();
                let mut found = vec![f64::NAN; one];
                let given: Vec<&[f64]> = arguments.iter().map(Vec::as_slice).collect();
                call.one(&given, &mut found).expect("fits");
                let expected = expected(&mut interpreter, function, state, (mask, &settings));
                near(function, &found, &expected);
                all.iter_mut().zip(&arguments).for_each(|(all, own)| all.extend(own));
                wanted.extend(expected);
            }
            let mut found = vec![f64::NAN; wanted.len()];
            let given: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
            call.many(&given, &mut found).expect("fits");
            for (found, wanted) in found.chunks(one).zip(wanted.chunks(one)) {
                near(function, found, wanted);
            }
        }
    }
}

/// The Hessian has seven arrays of arguments: two of them are in registers that belong to the caller.
#[test]
fn hessians_of_an_arm_on_a_moving_frame() {
    let path = format!("{}/../robots/arm6.urdf", env!("CARGO_MANIFEST_DIR"));
    let function = Function::ConstrainedForwardDynamicsHessian;
    let builder = Builder::new().urdf(path).functions([function]);
    let planning = builder
        .contacts([contact("tip", ContactKind::Point, "tool", [0.1, 0.02, -0.03])])
        .runtime_gravity()
        .plan()
        .expect("good");
    let model = &planning.model;
    let target = ContactTarget { compliance: 0.02, ..ContactTarget::<f64>::GROUND };
    let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
        ConstraintSettings::<f64>::DEFAULT;
    let settings = ConstraintSettings { alpha, beta, tolerance, rounding, targets: vec![target] };
    let state = random::state(3, model);
    let (cotangent, weights) = (random::state(4, model).qd, [0.3, -0.2, 0.5, 1.1, -0.7, 0.4]);
    let expected = Interpreter::new(model.clone()).constrained_hessian(
        [&state.q, &state.qd, &state.tau],
        ConstrainedCotangent { qdd: &cotangent, wrenches: &[Wrench::from_components(weights)] },
        &[true],
        &settings,
    );

    let settings = numbers(&settings);
    for instruction_set in InstructionSet::available() {
        let mut options = Options::default();
        (options.instruction_set, options.batches) = (Some(instruction_set), true);
        let compiled = Compiled::<f64>::from_plan(&planning, options).expect("code");
        let call = compiled.function(function).expect("compiled");
        let given: [&[f64]; 7] =
            [&state.q, &state.qd, &state.tau, &cotangent, &weights, &[1.0], &settings];
        let mut found = vec![f64::NAN; expected.len()];
        call.one(&given, &mut found).expect("fits");
        near(function, &found, &expected);
        let states = 5;
        let repeated = given.map(|numbers| numbers.repeat(states));
        let mut found = vec![f64::NAN; states * expected.len()];
        call.many(&repeated.each_ref().map(Vec::as_slice), &mut found).expect("fits");
        found.chunks(expected.len()).for_each(|found| near(function, found, &expected));
    }
}

/// Returns the model with contacts on the last links of some limbs.
fn with_contacts(model: Model, random: &mut random::Random) -> Model {
    let is_parent = |i: usize| model.moving_links().iter().any(|link| link.parent == Some(i));
    let mut tips: Vec<usize> = (0..model.moving_links().len()).filter(|&i| !is_parent(i)).collect();
    while tips.len() > 3 {
        tips.swap_remove(random.below(tips.len()));
    }
    let frame =
        |link: &usize| model.links().iter().position(|frame| frame.moving_link == Some(*link));
    let contacts = tips.iter().map(|link| {
        let translation = std::array::from_fn(|_| random.between(-0.3, 0.3));
        let frame = frame(link).expect("a frame on each link");
        let kind = if random.chance(0.3) { ContactKind::Surface } else { ContactKind::Point };
        let end = LoopConstraintEnd { link: frame, pose: Pose { translation, ..Pose::identity() } };
        model::Contact { name: format!("contact{link}"), kind, end }
    });
    let contacts = contacts.collect();
    model.with_contacts(contacts).expect("contacts on moving links")
}

/// Equal and similar limbs with contacts: packed programs of all functions of contacts compute what those on scalars do.
#[test]
fn random_limbs() {
    let (seeds, mut compared) = (random::seeds(8), 0);
    for seed in seeds.clone() {
        let mut random = random::Random::new(seed);
        let model = with_contacts(random::limbs(seed, 4 + 2 * (seed % 4) as usize), &mut random);
        let functions = Function::ALL.iter().copied();
        let functions = functions.filter(|one| one.row().of_constraints && one.batched().is_none());
        let planning = match Builder::new().model(model).functions(functions).plan() {
            Ok(planning) => planning,
            // Some of many seeds: the Hessian of several surfaces would be too long.
            Err(errors) if errors.iter().all(|error| error.code == Code::TooLarge) => continue,
            Err(errors) => panic!("{errors}"),
        };
        let model = &planning.model;
        assert_eq!(planning.plan.faults().next(), None, "{}", model.name());
        let state = random::state(seed, model);
        let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
            ConstraintSettings::<f64>::DEFAULT;
        let targets = vec![ContactTarget::<f64>::EXACT; model.contacts().len()];
        let settings = numbers(&ConstraintSettings { alpha, beta, tolerance, rounding, targets });
        for planned in &planning.plan.functions {
            let Kernels::Straight { scalar, simd: Some(simd) } = &planned.kernels else { continue };
            let arguments = planned.arguments.iter().flat_map(|(own, shape)| match own.name {
                "q" => state.q.clone(),
                "qd" => state.qd.clone(),
                "settings" => settings.clone(),
                "active" => vec![1.0; shape.len()],
                _ => (0..shape.len()).map(|_| random.between(-2.0, 2.0)).collect(),
            });
            let arguments: Vec<f64> = arguments.collect();
            let [expected, found] = [scalar, simd].map(|program| program.evaluate(&arguments));
            near(planned.function.expect("of the table"), &found, &expected);
            compared += 1;
        }
    }
    println!("{seeds:?}: {compared} packed functions");
    assert!(compared > 0);
}

fn near(function: Function, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{function:?}");
    let size = expected.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-8 * size, "{function:?}: {found} {expected}");
    }
}

/// A leg whose light shank is nearly stretched; its foot and its knee are held. In each order of the contacts it is locked, although the
/// row along the leg is small after the other rows of the foot.
#[test]
fn a_leg_whose_foot_and_knee_are_held_is_locked() {
    let link = |name: &str, mass: f64, moment: f64, center: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0 0 {center}'/><mass value='{mass}'/>
             <inertia ixx='{moment}' iyy='{moment}' izz='{moment}' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let joint = |name: &str, ends: [&str; 2], place: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='{}'/><child link='{}'/>{place}<axis xyz='0 1 0'/></joint>",
            ends[0], ends[1]
        )
    };
    let text = [
        "<robot name='leg'><link name='base'/>".into(),
        link("thigh", 1.0, 0.1, -0.4),
        link("shank", 0.0008, 4e-5, -0.3),
        joint("hip", ["base", "thigh"], "<origin rpy='0.3 0.2 0.1'/>"),
        joint("knee", ["thigh", "shank"], "<origin xyz='0 0 -0.5'/>"),
        "</robot>".into(),
    ];
    let held = [
        contact("foot", ContactKind::Point, "shank", [0.0, 0.0, -0.6]),
        contact("knee", ContactKind::Point, "thigh", [0.0, 0.0, -0.5]),
    ];
    let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
        ConstraintSettings::<f64>::EXACT;
    let targets = vec![ContactTarget::<f64>::EXACT; 2];
    let settings = numbers(&ConstraintSettings { alpha, beta, tolerance, rounding, targets });
    let function = Function::ConstrainedForwardDynamics;
    for order in [[0, 1], [1, 0]] {
        let builder = Builder::new().urdf_text(text.concat(), "leg.urdf").functions([function]);
        let planning = builder.contacts(order.map(|k| held[k].clone())).plan().expect("good");
        for instruction_set in InstructionSet::available() {
            let mut options = Options::default();
            (options.instruction_set, options.batches) = (Some(instruction_set), true);
            let compiled = Compiled::<f64>::from_plan(&planning, options).expect("code");
            let call = compiled.function(function).expect("compiled");
            for bend in [0.0, 1e-5, 1e-4, 1e-3, 1.5e-3, 3e-3, 0.1] {
                let given: [&[f64]; 5] =
                    [&[0.4, bend], &[0.0; 2], &[1.0, -2.0], &[1.0; 2], &settings];
                let mut found = vec![f64::NAN; call.result().len()];
                call.one(&given, &mut found).expect("fits");
                let rank = found[found.len() - 1];
                // Free accelerations are 5 and 5e4 rad/s^2.
                let is_locked = found[0].abs() < 1e-9 && found[1].abs() < 1e-5;
                assert!(
                    is_locked && rank == 2.0,
                    "{order:?}, {bend}: {:?}, rank {rank}",
                    &found[..2]
                );
            }
        }
    }
}
