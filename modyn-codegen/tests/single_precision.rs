//! The number of digits that forward dynamics keeps in single precision, for every robot of `robots/`.

use modyn_codegen::plan::partition::{ChosenPartition, choose};
use modyn_codegen::trace::Tracer;
use modyn_codegen::{Base, ReadOptions, read};
use modyn_codegen::{Builder, FloatType, condition_number, diagnostics::Code};
use modyn_runtime::equations::kinematics::coordinates;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Contact, ContactKind, LoopConstraintEnd, Model};
use modyn_runtime::quantities::Function;
use modyn_runtime::spatial::Pose;
use modyn_runtime::{ContactSurface, Interpreter, Scalar, StepSettings};

fn text(name: &str) -> String {
    let path = format!("{}/../robots/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).expect("a robot")
}

fn model(name: &str) -> Model {
    read(&text(name), name, &ReadOptions::default()).expect("good").model
}

/// Returns the largest error of an acceleration over 200 states, relative to the largest acceleration of the same
/// state. Both precisions have the same inputs, rounded to `f32`.
fn error(model: &Model) -> f64 {
    let mechanism = Mechanism::new(model);
    let tracer = Tracer::new(&mechanism);
    let ChosenPartition { graph, .. } = choose(model, &mechanism, &tracer);
    let mut number = 0.3_f64;
    let mut uniform = || {
        number = (number + 0.618_033_988_749_894_9).fract();
        number
    };
    let mut worst = 0.0_f64;
    for _ in 0..200 {
        let mut inputs = vec![0.0; model.nq()];
        coordinates::random(&mechanism, &mut uniform, &mut inputs);
        inputs.extend((0..model.nv()).map(|_| 4.0 * uniform() - 2.0));
        inputs.extend((0..model.nv()).map(|_| 20.0 * uniform() - 10.0));
        let inputs: Vec<f32> = inputs.iter().map(|&x| x as f32).collect();
        let single = graph.evaluate(&inputs);
        let double = graph.evaluate(&inputs.iter().map(|&x| f64::from(x)).collect::<Vec<_>>());
        let largest = double.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        let pairs = single.iter().zip(&double);
        worst = pairs.fold(worst, |worst, (s, d)| worst.max((f64::from(*s) - d).abs() / largest));
    }
    worst
}

/// The file of the table in docs/firmware.md. With the variable `UPDATE_SNAPSHOTS`, the test writes it.
const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/data/single-precision.tsv");

/// The errors are below their bounds, and the file has them to within a tenth.
#[test]
fn forward_dynamics_keeps_its_digits() {
    let bounds = [
        ("double_pendulum", 2e-6),
        ("gripper", 2e-6),
        ("mimic_gripper", 2e-6),
        ("joint_zoo", 2e-6),
        ("arm6", 2e-6),
        ("arm7", 1e-5),
        ("quadruped", 2e-5),
        ("humanoid", 5e-6),
    ];
    let mut failures = Vec::new();
    let mut rows = vec!["robot\tcondition number\tfound\tbound".to_owned()];
    for (name, bound) in bounds {
        let model = model(name);
        let (found, condition) = (error(&model), condition_number(&model).expect("small"));
        rows.push(format!("`{name}`\t{condition:.0}\t{found:.1e}\t{bound:.0e}"));
        if found > bound {
            failures.push(name);
        }
        let builder = Builder::new().model(model).scalar(FloatType::F32).functions([]);
        let warnings = builder.generate().expect("good").warnings;
        assert!(warnings.iter().all(|w| w.code != Code::IllConditioned), "{name}");
    }
    assert!(failures.is_empty(), "{failures:?}");

    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        let head = "# command: UPDATE_SNAPSHOTS=1 cargo test -p modyn-codegen single_precision::\n";
        std::fs::write(DATA, head.to_owned() + &rows.join("\n") + "\n").expect("writes");
    }
    let text = std::fs::read_to_string(DATA).expect("the data").replace("\r\n", "\n");
    let data: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(data.len(), rows.len(), "{rows:#?}");
    let split = |row: &str| -> (Vec<String>, Option<f64>) {
        let mut cells: Vec<String> = row.split('\t').map(String::from).collect();
        let found = cells.remove(2).parse().ok();
        (cells, found)
    };
    for (row, stored) in rows.iter().zip(data) {
        let ((own, found), (cells, expected)) = (split(row), split(stored));
        let close = match (found, expected) {
            (Some(found), Some(expected)) => (found - expected).abs() <= 0.1 * expected,
            (found, expected) => found == expected,
        };
        assert!(own == cells && close, "{stored:?} in the file, {row:?} found");
    }
}

/// Returns a light link between two parallel joints that are `offset` m apart, and a heavy link of one metre. The two
/// joints cause nearly the same motion.
fn light_between(offset: f64) -> String {
    let link = |name: &str, x: f64, mass: f64, inertia: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='{x} 0 0'/><mass value='{mass}'/><inertia \
             ixx='{inertia}' iyy='{inertia}' izz='{inertia}' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str, x: f64| {
        format!(
            "<joint name='{name}' type='continuous'><origin xyz='{x} 0 0'/><parent link='{parent}'/>\
             <child link='{child}'/><axis xyz='0 0 1'/></joint>"
        )
    };
    let joints = [joint("j", "world", "light", 0.0), joint("k", "light", "heavy", offset)].concat();
    let links = [link("light", 0.0, 1e-3, 1e-8), link("heavy", 1.0, 1.0, 1e-3)].concat();
    format!("<robot name='light'><link name='world'/>{joints}{links}</robot>")
}

#[test]
fn a_robot_that_single_precision_does_not_carry_is_warned_of() {
    let warned = |offset: f64, float: FloatType| {
        let builder = Builder::new().urdf_text(light_between(offset), "a.urdf").scalar(float);
        let generated = builder.functions([]).generate().expect("good");
        let warned = generated.warnings.iter().any(|w| w.code == Code::IllConditioned);
        // The type's documentation contains the warning, too.
        assert_eq!(warned, generated.text.contains("ill-conditioned"));
        warned
    };
    assert!(warned(1e-3, FloatType::F32));
    assert!(!warned(1e-3, FloatType::F64));
    assert!(!warned(0.3, FloatType::F32));
    // The estimate is an upper bound of the loss, which is often much smaller.
    for offset in [1e-3, 1e-2, 0.3] {
        let reading = read(&light_between(offset), "a.urdf", &ReadOptions::default());
        let model = reading.expect("good").model;
        let (found, condition) = (error(&model), condition_number(&model).expect("small"));
        assert!(found < (1e-6 * condition).min(1e-4), "{offset} {condition:e} {found:e}");
    }
}

/// Returns the result of a step, whose arguments are q, qd, tau, dt, the accelerations to start from and the
/// settings.
pub fn step<S: Scalar>(robot: &mut Interpreter<S>, given: &[Vec<f64>]) -> Vec<f64>
where
    f64: From<S>,
{
    let given: Vec<Vec<S>> =
        given.iter().map(|numbers| numbers.iter().map(|&x| S::from_f64(x)).collect()).collect();
    let given: Vec<&[S]> = given.iter().map(Vec::as_slice).collect();
    let length = (Function::Step.row().result)(&robot.sizes()).len();
    let mut result = vec![S::zero(); length];
    robot.evaluate(Function::Step, &given, 0, &mut result).expect("lengths");
    result.into_iter().map(f64::from).collect()
}

/// The solver of a step reaches the default tolerance of `f32`, and 1e-3 under stiff laws, before it starts again with soft laws: a
/// quadruped falls on four feet.
#[test]
fn steps_reach_the_default_tolerance() {
    let options = ReadOptions { base: Base::Floating, ..ReadOptions::default() };
    let model = read(&text("quadruped"), "quadruped", &options).expect("good").model;
    let foot = |link: &str| {
        let frame = model.link_index(link).expect("a foot");
        let end = LoopConstraintEnd { link: frame, pose: Pose::identity() };
        Contact { name: link.into(), kind: ContactKind::Point, end }
    };
    let feet = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];
    let model = model.clone().with_contacts(feet.map(foot).into()).expect("links that move");
    let [nq, nv] = [model.nq(), model.nv()];
    let mut single = Interpreter::<f32>::new(model.clone());
    let mut double = Interpreter::<f64>::new(model.clone());
    let default = f64::from(StepSettings::<f32, [ContactSurface<f32>; 0]>::DEFAULT.tolerance);
    let mut number = 0.3_f64;
    let mut uniform = || {
        number = (number + 0.618_033_988_749_894_9).fract();
        number
    };
    let normal = ContactSurface::<f64>::GROUND;
    let stiff = ContactSurface { solimp: [0.999, 0.9999, 0.001, 0.5], ..normal };
    for (surface, tolerance, most, error) in
        [(normal, default, 6.0, 1e-4), (stiff, 1e-3, 12.0, 2e-2)]
    {
        let surfaces = [surface; 4].into_iter().flat_map(|surface| surface.numbers());
        let settings: Vec<f64> = [tolerance, 1.0, 0.0].into_iter().chain(surfaces).collect();
        let mut touching = 0;
        for _ in 0..8 {
            let mut q = vec![0.0; nq];
            double.neutral(&mut q).expect("lengths");
            q[2] = 0.3 + 0.2 * uniform();
            q[7..].iter_mut().for_each(|x| *x += 0.6 * uniform() - 0.3);
            let mut qd: Vec<f64> = (0..nv).map(|_| 4.0 * uniform() - 2.0).collect();
            let mut warm_start = vec![0.0; nv];
            for _ in 0..100 {
                let joint = |k: usize| if k < 6 { 0.0 } else { -5.0 * q[k + 1] - 0.05 * qd[k] };
                let tau = (0..nv).map(joint).collect();
                let given = [q.clone(), qd.clone(), tau, vec![0.002], warm_start, settings.clone()];
                // Both precisions have the same inputs.
                let given =
                    given.map(|numbers| numbers.iter().map(|&x| f64::from(x as f32)).collect());
                let result = step(&mut single, &given);
                let (forces, ends) = result[nq + 2 * nv..].split_at(12);
                let [residual, iterations] = [ends[0], ends[1]];
                assert!(residual <= tolerance && iterations <= most, "{iterations}: {residual:e}");
                if forces.iter().any(|force| *force != 0.0) {
                    touching += 1;
                    let expected = step(&mut double, &given);
                    let velocities = nq..nq + nv;
                    let largest = expected[velocities.clone()]
                        .iter()
                        .fold(1.0, |most: f64, x| most.max(x.abs()));
                    for (a, b) in result[velocities.clone()].iter().zip(&expected[velocities]) {
                        assert!((a - b).abs() <= error * largest, "{a} {b} {residual:e}");
                    }
                }
                q = result[..nq].to_vec();
                qd = result[nq..nq + nv].to_vec();
                warm_start = result[nq + nv..nq + 2 * nv].to_vec();
            }
        }
        assert!(touching > 200, "{touching}");
    }
}
