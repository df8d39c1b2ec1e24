//! Fused functions of random robots and of robots of the folder give the numbers of their functions, one at a time.

use modyn_codegen::plan::{Lowering, Shape};
use modyn_codegen::trace::{LinkFrame, Tracer};
use modyn_codegen::{Builder, Function, FusedFunction};
use modyn_jit::{CallError, CompileError, Compiled, InstructionSet, Options};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::Model;
use modyn_tests::conformance::robot;
use modyn_tests::random;

/// Functions of a state and joint vectors, in fused functions whose arguments machine code can have.
const FUSED: &[(&str, &[Function])] = &[
    (
        "state",
        &[
            Function::MassMatrix,
            Function::BiasForces,
            Function::CoriolisMatrix,
            Function::Jacobian,
            Function::JacobianTimeDerivative,
            Function::JacobianTimeDerivativeLocal,
            Function::LinkPose,
            Function::ForwardDynamics,
            Function::JacobianDotQd,
            Function::GravityTorques,
            Function::KineticEnergy,
            Function::PotentialEnergy,
            Function::CenterOfMass,
            Function::CenterOfMassJacobian,
            Function::CentroidalMomentumMatrix,
            Function::CentroidalMomentum,
            Function::LinkPoses,
            Function::LinkVelocity,
            Function::LinkVelocityLocal,
            Function::JacobianLocal,
            Function::JacobianDotQdLocal,
            Function::NormalizeConfiguration,
            Function::VelocityToQdot,
            Function::Brge,
        ],
    ),
    (
        "steps",
        &[
            // The members are not in the order of the table of functions, nor are their arguments.
            Function::StepSemiImplicit,
            Function::InverseDynamicsDerivatives,
            Function::ForwardDynamicsDerivatives,
            Function::StepSemiImplicitDerivatives,
            Function::LinkAcceleration,
            Function::LinkAccelerationLocal,
            Function::Regressor,
            Function::InverseDynamics,
            Function::StepRk4,
            Function::StepImplicitMidpoint,
        ],
    ),
    (
        "products",
        &[
            Function::ForwardDynamicsVjp,
            Function::InverseDynamicsVjp,
            Function::ForwardDynamicsHessian,
            Function::InverseDynamicsHessian,
        ],
    ),
    // Seven arrays of arguments.
    ("displaced", &[Function::ForwardDynamicsJvp, Function::StepRk4]),
    (
        "changes",
        &[
            Function::Difference,
            Function::DifferenceDerivatives,
            Function::Integrate,
            Function::IntegrateDerivatives,
        ],
    ),
    (
        "pushed",
        &[
            Function::InverseDynamicsExternalLocal,
            Function::ForwardDynamicsExternal,
            Function::ForwardDynamicsExternalLocal,
            Function::InverseDynamicsExternal,
        ],
    ),
];

/// Returns the fused functions for these links, and all functions in them.
fn fused(links: &[&str]) -> (Vec<FusedFunction>, Vec<Function>) {
    let fused = |(name, functions): &(&str, &[Function])| {
        let mut fused = FusedFunction::new(*name);
        for &function in *functions {
            fused = match function.row().by_link {
                true => links.iter().fold(fused, |fused, link| fused.of_link(function, *link)),
                false => fused.function(function),
            };
        }
        fused
    };
    let functions = FUSED.iter().flat_map(|(_, functions)| functions.iter().copied());
    (FUSED.iter().map(fused).collect(), functions.collect())
}

/// Returns the numbers of an argument.
fn argument(name: &str, shape: &Shape, model: &Model) -> Vec<f64> {
    let seed = name.bytes().fold(7, |seed, byte| 31 * seed + u64::from(byte));
    match name {
        "q" | "from" | "to" => random::state(seed, model).q,
        "dt" => vec![0.01],
        _ => {
            let mut random = random::Random::new(seed);
            (0..shape.len()).map(|_| random.between(-2.0, 2.0)).collect()
        }
    }
}

fn close(name: &str, found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{name}");
    let size = expected.iter().fold(1.0, |size: f64, x| size.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= 1e-9 * size, "{name}: {found} {expected}");
    }
}

/// Compares the fused functions of a robot with their functions, with all instruction sets, for one state and for many.
fn agrees(model: &Model, links: &[&str], configure: impl Fn(Builder) -> Builder) {
    let (fused, functions) = fused(links);
    let builder = Builder::new().model(model.clone()).functions(functions).fused(fused);
    let planning = configure(builder).plan().expect("good");
    for instruction_set in InstructionSet::available() {
        let mut options = Options::default();
        (options.instruction_set, options.batches) = (Some(instruction_set), true);
        let compiled = Compiled::<f64>::from_plan(&planning, options).expect("code");
        assert!(compiled.fused_names().eq(FUSED.iter().map(|(name, _)| *name)));
        for (name, functions) in FUSED {
            let call = compiled.fused(name).expect("compiled");
            let given: Vec<(&str, Vec<f64>)> = (call.arguments().iter())
                .map(|(name, shape)| (*name, argument(name, shape, model)))
                .collect();
            let arguments: Vec<&[f64]> = given.iter().map(|(_, numbers)| &**numbers).collect();
            let mut found = vec![f64::NAN; call.result().len()];
            call.one(&arguments, &mut found).expect("fits");
            let states = 5;
            let repeated: Vec<Vec<f64>> = arguments.iter().map(|x| x.repeat(states)).collect();
            let repeated: Vec<&[f64]> = repeated.iter().map(Vec::as_slice).collect();
            let mut many = vec![f64::NAN; found.len() * states];
            call.many(&repeated, &mut many).expect("fits");
            many.chunks(found.len()).for_each(|state| close(name, state, &found));
            let Shape::Record(_, fields) = call.result() else { panic!("{:?}", call.result()) };
            let (mut fields, mut rest) = (fields.iter(), &*found);
            for &function in *functions {
                let one = compiled.function(function).expect("compiled");
                let own = one.arguments().iter().map(|(name, _)| {
                    let given = given.iter().find(|(given, _)| given == name);
                    &*given.unwrap_or_else(|| panic!("{name} of {function:?}")).1
                });
                let own: Vec<&[f64]> = own.collect();
                let of: Vec<Option<&str>> = match function.row().by_link {
                    true => links.iter().copied().map(Some).collect(),
                    false => vec![None],
                };
                for link in of {
                    let (field, shape) = fields.next().expect("a field");
                    let mut expected = vec![f64::NAN; shape.len()];
                    match link {
                        None => one.one(&own, &mut expected).expect("fits"),
                        Some(link) => {
                            let frame = model.link_index(link).expect("a link");
                            one.link(frame, &own, &mut expected).expect("fits");
                        }
                    }
                    let (result, after) = rest.split_at(shape.len());
                    close(&format!("{name}.{field} at {instruction_set:?}"), result, &expected);
                    rest = after;
                }
            }
            assert!(rest.is_empty() && fields.next().is_none());
        }
    }
}

/// The graphs that functions of one link have in fused functions give the numbers of the functions by themselves.
#[test]
fn graphs_in_fused_functions() {
    let mut compared = 0;
    for function in Function::ALL {
        let Some(in_fused) = Lowering::of(*function).in_fused else { continue };
        for seed in 0..5 {
            let model = random::general_zoo(seed, 6);
            let mechanism = Mechanism::new(&model);
            let bare = Mechanism { frames: Vec::new(), ..mechanism.clone() };
            let random::State { q, qd, qdd, .. } = random::state(seed, &model);
            let inputs = [q, qd, qdd].concat();
            for &frame in &mechanism.frames {
                let tracer = Tracer::with_link(&bare, LinkFrame::Known(frame));
                let alone = tracer.evaluation(*function, &model, None);
                let [found, expected] =
                    [in_fused(&tracer), alone].map(|graph| graph.evaluate(&inputs));
                close(function.name(), &found, &expected);
                compared += 1;
            }
        }
    }
    assert!(compared > 50, "{compared}");
}

fn link_names(model: &Model) -> Vec<&str> {
    model.links().iter().map(|link| link.name.as_str()).collect()
}

#[test]
fn random_robots() {
    for seed in random::seeds(1) {
        for model in [random::mixed_zoo(seed, 4), random::general_tree(seed, 5)] {
            agrees(&model, &link_names(&model), |builder| builder);
        }
    }
}

#[test]
fn run_time_parameters() {
    let model = random::general_zoo(3, 4);
    let links = link_names(&model);
    let moving: Vec<&str> = model.moving_links().iter().map(|link| link.name.as_str()).collect();
    agrees(&model, &links, |builder| {
        builder.runtime_gravity().runtime_inertia([moving[1]]).payload([moving[3]])
    });
}

/// Robots whose functions have equal limbs in the lanes of vectors.
#[test]
fn equal_limbs() {
    let model = robot("quadruped").plan().expect("good").model;
    agrees(&model, &["front_left_foot", "hind_right_shank", "trunk"], |builder| builder);
}

/// Equal and similar limbs: packed members beside members on scalars.
#[test]
fn random_limbs() {
    for seed in random::seeds(2) {
        let model = random::limbs(seed, 2 + (seed % 3) as usize);
        agrees(&model, &link_names(&model)[..2], |builder| builder);
    }
}

#[test]
fn wrong_fused_functions_name_the_error() {
    let builder = robot("arm6").functions([Function::MassMatrix]);
    let control = FusedFunction::new("control").function(Function::MassMatrix);
    let compiled = Compiled::<f64>::build(&builder.clone().fused([control]), Options::default());
    let compiled = compiled.expect("code");
    let error = compiled.fused("contrl").err().expect("not compiled");
    assert_eq!(error.to_string(), "`contrl` was not compiled; compiled were: mass_matrix, control");
    let error = compiled.fused("control").expect("compiled").one(&[], &mut []).expect_err("one");
    assert!(matches!(error, CallError::Arguments { function: "control", found: 0, .. }), "{error}");
    let many = [Function::ForwardDynamicsJvp, Function::Difference, Function::StepRk4];
    let many = many.into_iter().fold(FusedFunction::new("many"), FusedFunction::function);
    let error = Compiled::<f64>::build(&builder.fused([many]), Options::default());
    let error = error.expect_err("too many arguments");
    assert!(matches!(error, CompileError::Arguments { function: "many", arrays: 9 }), "{error}");
}
