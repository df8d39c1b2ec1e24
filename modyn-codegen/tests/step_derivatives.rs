//! The derivatives of steps in closed form against the derivatives of one step of Newton's method from
//! the solution, which the interpreter has; on scalars and in lanes.

use modyn_codegen::options::Value;
use modyn_codegen::plan::Kernels;
use modyn_codegen::{Builder, Function};
use modyn_runtime::Interpreter;
use modyn_runtime::quantities::Shape;

use crate::general_position::mechanisms::Random;

/// A robot that falls on a tilted floor with shapes of all kinds, and reaches the limits of its joints.
/// `base` is the joint of its first body, `further` are further elements.
fn scene(options: &str, base: &str, further: &str) -> String {
    format!(
        "<mujoco><option {options}/><compiler autolimits='true'/>\
           <default><geom friction='0.7 0.01 0.002' density='700'/>\
             <joint damping='0.3' frictionloss='0.05' armature='0.01' range='-20 25'/></default>\
           <worldbody><geom type='plane' size='5 5 1' euler='8 -5 0'/>\
             <body name='trunk' pos='0 0 0.4' euler='5 10 20'>{base}\
               <geom type='box' size='0.2 0.1 0.05' pos='0.02 0.01 0' euler='3 4 5'/>\
               <body name='thigh' pos='0.2 0.1 0' euler='0 20 0'><joint name='hip' axis='1 0.2 0'/>\
                 <geom type='capsule' size='0.03 0.1' pos='0 0 -0.12' condim='4'/>\
                 <body name='shank' pos='0 0 -0.25'><joint name='knee' axis='0.1 1 0'/>\
                   <geom type='sphere' size='0.05' pos='0.01 0 -0.15' condim='6'/></body></body>\
               <body name='arm' pos='-0.2 -0.1 0'><joint name='shoulder' type='ball' range='0 40'/>\
                 <geom type='cylinder' size='0.04 0.1' pos='0 0 -0.1' condim='1'/>\
                 <body name='slide' pos='0 0 -0.2'>\
                   <joint name='slide' type='slide' axis='0 0.3 1' range='-0.05 0.06' stiffness='20'/>\
                   <geom type='ellipsoid' size='0.05 0.04 0.08'/></body></body></body></worldbody>\
           {further}</mujoco>"
    )
}

/// What a comparison had.
struct Comparison {
    /// The number of components of forces of the ground that are not zero, in all states.
    acting: usize,
    /// The largest derivative.
    largest: f64,
    /// Whether there was a program with lanes.
    has_lanes: bool,
}

/// Compares the derivatives in states near the floor.
fn compare(builder: &Builder, function: Function) -> Comparison {
    let planning = builder.clone().functions([function]).plan().expect("good");
    let [planned] = &planning.plan.functions[..] else { panic!("one function") };
    let Kernels::Straight { scalar, simd } = &planned.kernels else { panic!("straight") };
    let model = &planning.model;
    let mut robot = Interpreter::<f64>::new(model.clone());
    let mut random = Random(7);
    let mut next = || random.next();
    let mut acting = 0;
    let mut largest = 0.0_f64;
    for _ in 0..3 {
        let mut q = vec![0.0; model.nq()];
        robot.neutral(&mut q).expect("lengths");
        let mut moves: Vec<f64> = (0..model.nv()).map(|_| 0.5 * next()).collect();
        if model.nq() > model.nv() + 1 {
            // The height of the trunk, in which the floor is reached.
            moves[2] = 0.12 + 0.05 * next();
        }
        let start = q.clone();
        robot.integrate(&start, &moves, &mut q).expect("lengths");
        let velocities: Vec<f64> = (0..model.nv()).map(|_| next()).collect();
        let mut settings = model.step_settings();
        settings.tolerance = 1e-13;
        settings.coulomb = 0.7;
        let sizes = &planning.plan.sizes;
        let mut vector =
            |count: usize, size: f64| -> Vec<f64> { (0..count).map(|_| size * next()).collect() };
        let given: Vec<Vec<f64>> = function
            .row()
            .arguments
            .iter()
            .map(|argument| {
                let length = argument.shape(sizes).len();
                match argument.name {
                    "q" => q.clone(),
                    "qd" => velocities.clone(),
                    "dt" => vec![0.004],
                    "warm_start" => vec![0.0; length],
                    "step_settings" => settings.all_numbers(),
                    "act" => vector(length, 0.3),
                    _ => vector(length, 2.0),
                }
            })
            .collect();
        let shape = (function.row().result)(sizes);
        let mut expected = vec![0.0; shape.len()];
        let slices: Vec<&[f64]> = given.iter().map(Vec::as_slice).collect();
        robot.evaluate(function, &slices, 0, &mut expected).expect("lengths");
        let Shape::Record(_, fields) = &shape else { panic!("a record") };
        for program in [Some(scalar), simd.as_ref()].into_iter().flatten() {
            let result = program.evaluate(&given.concat());
            let mut place = 0;
            for (name, field) in fields {
                let range = place..place + field.len();
                place = range.end;
                let scale = expected[range.clone()].iter().fold(1.0_f64, |a, x| a.max(x.abs()));
                for k in range.clone().filter(|_| *name != "iterations") {
                    let error = (result[k] - expected[k]).abs() / scale;
                    assert!(error < 1e-9, "{name} {}: {error:e}", k - range.start);
                }
                match *name {
                    "forces" => acting += expected[range].iter().filter(|x| **x != 0.0).count(),
                    "a" | "grad_x" | "tangent_x" => largest = largest.max(scale),
                    _ => {}
                }
            }
            assert_eq!(place, result.len());
        }
    }
    Comparison { acting, largest, has_lanes: simd.is_some() }
}

/// The functions with derivatives of a step.
const DERIVATIVES: [Function; 3] =
    [Function::StepDerivatives, Function::StepVjp, Function::StepJvp];

/// Compares each function with derivatives of a step.
fn of_scene(text: &str) -> [Comparison; 3] {
    DERIVATIVES.map(|function| compare(&Builder::new().mjcf_text(text, "scene.xml"), function))
}

#[test]
fn derivatives_of_steps_are_the_derivatives_of_newtons_method() {
    let cones = ["cone='elliptic' impratio='3'", "cone='pyramidal' integrator='implicitfast'"];
    for options in cones {
        for Comparison { acting, largest, .. } in of_scene(&scene(options, "<freejoint/>", "")) {
            assert!(acting > 12 && largest > 10.0, "{options}: {acting} {largest}");
        }
    }
    let fixed = of_scene(&scene(cones[0], "<joint type='slide' axis='0 0 1'/>", ""));
    assert!(fixed.iter().all(|function| function.acting > 5), "{}", fixed[0].acting);
}

#[test]
fn derivatives_of_steps_have_lanes() {
    let feet = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];
    let option = |builder: Builder, name: &str, value: &str| {
        builder.set(name, &Value::parse(value).expect("a value")).expect("an option")
    };
    let quadruped = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/quadruped.urdf");
    let builder = option(Builder::new().urdf(quadruped), "base", "floating");
    let points: Vec<String> =
        feet.iter().map(|link| format!("{link:?}: point({link:?})")).collect();
    let builder = option(builder, "contacts", &format!("[{}]", points.join(", ")));
    for function in DERIVATIVES {
        let Comparison { acting, has_lanes, .. } = compare(&builder, function);
        assert!(acting > 10 && has_lanes, "{acting} {has_lanes}");
    }
}

#[test]
fn robots_without_the_closed_form_have_derivatives_of_steps() {
    let loops = "<equality><connect body1='shank' body2='slide' anchor='0 0 -0.1'/></equality>";
    for Comparison { acting, .. } in of_scene(&scene("cone='elliptic'", "<freejoint/>", loops)) {
        assert!(acting > 5, "{acting}");
    }
}

#[test]
fn derivatives_of_steps_under_controls_have_activations() {
    let actuators = "<actuator><position joint='hip' kp='30' kv='2' timeconst='0.02'/> \
        <motor joint='knee' gear='3' ctrlrange='-1 1'/>\
        <general joint='slide' dyntype='filter' dynprm='0.05' gaintype='affine' gainprm='4 1 -0.5' \
          biastype='affine' biasprm='0.1 -20 -1'/></actuator>";
    for integrator in ["Euler", "implicitfast"] {
        let options = format!("cone='elliptic' integrator='{integrator}'");
        let text = scene(&options, "<freejoint/>", actuators);
        let builder = Builder::new().mjcf_text(text, "scene.xml");
        for function in [
            Function::StepActuatedDerivatives,
            Function::StepActuatedVjp,
            Function::StepActuatedJvp,
        ] {
            let Comparison { acting, largest, .. } = compare(&builder, function);
            assert!(acting > 12 && largest > 10.0, "{integrator}: {acting} {largest}");
        }
    }
}
