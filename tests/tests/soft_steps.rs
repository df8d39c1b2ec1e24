//! Steps with soft constraints against MuJoCo: see the reference data's README.

use modyn_codegen::diagnostics::{Code, Severity};
use modyn_codegen::plan::{Choices, Kernels, Plan};
use modyn_codegen::program::Execution;
use modyn_codegen::{Base, Mimic, ReadOptions, read};
use modyn_runtime::equations::TimeStepInput;
use modyn_runtime::equations::soft_constraints::{
    JointParameters, SoftModel, StepInput, StopParameters,
};
use modyn_runtime::model::{
    Cone, Contact, ContactComponents, ContactKind, ContactShape, Impedance, JointDynamics,
    JointFriction, JointSoftness, LoopConstraintEnd, Model, ModuleTree, SoftConstraints, Softness,
    TouchingShape,
};
use modyn_runtime::quantities::Function;
use modyn_runtime::spatial::{Matrix3, Pose, Twist, Vector3};
use modyn_runtime::{ContactSurface, Interpreter, StepSettings, StepSolutionOutputs};
use modyn_tests::arguments::{arguments, interpreted};
use modyn_tests::golden::{Golden, PLANAR_LOOP, SPATIAL_LOOPS};
use modyn_tests::random::{Random, general_zoo, state, with_tendons};
use serde_json::Value;

/// Of the largest velocity; the rest is MuJoCo's own tolerance.
const TOLERANCE: f64 = 1e-8;

/// Of the largest derivative.
const GRADIENT_TOLERANCE: f64 = 1e-9;

pub fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().expect("a list");
    values.iter().map(|x| x.as_f64().expect("a number")).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

pub fn text(value: &Value) -> &str {
    value.as_str().expect("a text")
}

pub fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

/// Returns the robot of a file with its contacts, and the damping of its joints.
fn robot(file: &Value) -> Model {
    let name = text(&file["robot"]);
    let path = format!("{}/../robots/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
    let description = std::fs::read_to_string(path).expect("a robot");
    let options = ReadOptions { base: Base::Floating, ..ReadOptions::default() };
    let model = read(&description, name, &options).expect("good").model;
    let damping = numbers(&file["damping"]);
    let mut links = model.moving_links().to_vec();
    for (link, damping) in links.iter_mut().skip(1).zip(damping) {
        link.joint.dynamics = JointDynamics { damping, ..link.joint.dynamics };
    }
    let names: Vec<&str> = links.iter().skip(1).map(|link| &*link.joint.name).collect();
    assert_eq!(names, list(&file["joints"]).iter().map(text).collect::<Vec<_>>());
    let contacts = list(&file["contacts"]).iter().map(|contact| {
        let link = text(&contact["link"]);
        let frame = model.links().iter().position(|frame| frame.name == link);
        let position = <[f64; 3]>::try_from(numbers(&contact["position"])).expect("three");
        let pose = Pose { translation: position, ..Pose::identity() };
        let end = LoopConstraintEnd { link: frame.expect("a link"), pose };
        Contact { name: text(&contact["name"]).into(), kind: ContactKind::Point, end }
    });
    Model::new(name, [0.0, 0.0, -9.81], links, model.links().to_vec())
        .and_then(|model| model.with_joint_friction(JointFriction::Viscous))
        .and_then(|model| model.with_contacts(contacts.collect()))
        .expect("a robot")
}

/// Returns the surface of each contact.
fn surfaces(file: &Value) -> Vec<ContactSurface<f64>> {
    let rows = list(&file["floor"]["rotation"]).iter().map(numbers);
    let normal = Vector3(rows.map(|row| row[2]).collect::<Vec<f64>>().try_into().expect("three"));
    // The first tangent, in the edges of a pyramid, is the y axis within the plane.
    let y = Vector3([0.0, 1.0, 0.0]);
    let tangent = y - normal.scale(normal.dot(y));
    let tangent = tangent.scale(tangent.dot(tangent).sqrt().recip());
    let axes = [tangent, normal.cross(tangent), normal];
    let plane = Pose {
        rotation: Matrix3::from_columns(|k| axes[k]).0,
        translation: numbers(&file["floor"]["translation"]).try_into().expect("three"),
    };
    let surface = |contact: &Value| ContactSurface {
        plane,
        radius: number(&file["radius"]),
        friction: number(&contact["friction"]),
        ..ContactSurface::<f64>::GROUND
    };
    list(&file["contacts"]).iter().map(surface).collect()
}

/// Returns the laws of a file, with the mobilities of MuJoCo.
fn soft_model(file: &Value, cone: Cone, robot: &mut Interpreter<f64>) -> SoftModel<f64> {
    let soft = SoftModel::of(robot.model());
    let mut contacts = soft.contacts.clone();
    for (contact, expected) in contacts.iter_mut().zip(list(&file["contacts"])) {
        contact.mobility = number(&expected["mobility"]);
    }
    let [dry_friction, mobility] = ["dry_friction", "mobility"].map(|name| numbers(&file[name]));
    let joint = |(k, range): (usize, &Value)| JointParameters {
        coordinate: 7 + k,
        stops: StopParameters {
            range: <[f64; 2]>::try_from(numbers(range)).expect("two").map(Some),
            narrow: false,
            margin: 0.0,
            mobility: mobility[k],
            limit: Softness::standard(),
            dry_friction: Some(dry_friction[k]),
            friction: Softness::standard(),
        },
    };
    let joints = list(&file["range"]).iter().enumerate().map(joint).map(Some);
    let joints = [None; 6].into_iter().chain(joints).collect();
    SoftModel { cone, weight: 1.0, contacts, joints, ..soft }
}

fn data() -> Value {
    let path = format!("{}/golden/soft_steps.json", env!("CARGO_MANIFEST_DIR"));
    let data = std::fs::read_to_string(path).expect("the reference data");
    serde_json::from_str(&data).expect("good")
}

#[test]
fn steps_are_those_of_mujoco() {
    let (mut compared, mut touching, mut most) = (0, 0, 0.0_f64);
    for file in list(&data()) {
        let model = robot(file);
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let surfaces = surfaces(file);
        for state in list(&file["states"]) {
            let cone = match text(&state["cone"]) {
                "pyramidal" => Cone::Pyramidal,
                _ => Cone::Elliptic,
            };
            let soft = soft_model(file, cone, &mut interpreter);
            interpreter.set_soft_model(soft);
            let settings = StepSettings {
                tolerance: 1e-12,
                impratio: number(&file["ratio"]),
                coulomb: 0.0,
                surfaces: &*surfaces,
            };
            let [q, qd, tau] = ["q", "qd", "tau"].map(|name| numbers(&state[name]));
            let tau = [&[0.0; 6][..], &tau].concat();
            let warm_start = vec![0.0; qd.len()];
            let dt = number(&file["step"]);
            let step = TimeStepInput { q: &q, qd: &qd, tau: &tau, dt };
            let input = StepInput { step, warm_start: &warm_start };
            let mut found = [vec![0.0; q.len()], vec![0.0; qd.len()]];
            let mut qdd = warm_start.clone();
            let mut forces = vec![0.0; 3 * surfaces.len()];
            let [mut residual, mut iterations] = [0.0; 2];
            let [next_q, next_qd] = &mut found;
            let outputs = StepSolutionOutputs {
                q: next_q,
                qd: next_qd,
                qdd: &mut qdd,
                forces: &mut forces,
                residual: &mut residual,
                iterations: &mut iterations,
            };
            interpreter.step(input, &settings, outputs).expect("lengths");
            assert!(residual <= settings.tolerance, "{iterations}: {residual}");
            let expected = ["next_q", "next_qd"].map(|name| numbers(&state[name]));
            let largest = expected[1].iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            let what = format!("{} {compared}, {} contacts", file["robot"], state["contacts"]);
            for (found, expected) in found.concat().iter().zip(expected.concat()) {
                let error = (found - expected).abs() / largest;
                assert!(error <= TOLERANCE, "{what}, {cone:?}: {found} {expected}, {error:e}");
            }
            compared += 1;
            touching += forces.chunks(3).filter(|force| force[2] > 0.0).count();
            most = most.max(iterations);
        }
    }
    assert!(compared == 32 && touching > 30 && most < 20.0, "{compared} {touching} {most}");
}

/// The mobilities of the interpreter are MuJoCo's, for robots whose neutral configuration is MuJoCo's reference.
#[test]
fn mobilities_are_those_of_mujoco() {
    for file in list(&data()) {
        let mut interpreter = Interpreter::<f64>::new(robot(file));
        let expected = soft_model(file, Cone::Elliptic, &mut interpreter);
        let computed = SoftModel::of(interpreter.model());
        let contacts = |model: &SoftModel<f64>| -> Vec<f64> {
            model.contacts.iter().map(|contact| contact.mobility).collect()
        };
        let joints = |model: &SoftModel<f64>| -> Vec<f64> {
            model.joints.iter().flatten().map(|joint| joint.stops.mobility).collect()
        };
        for mobilities in [contacts, joints] {
            let theirs = mobilities(&expected);
            let ours = mobilities(&computed);
            assert_eq!(theirs.len(), ours.len());
            for (a, b) in theirs.iter().zip(&ours) {
                assert!((a - b).abs() <= 1e-9 * a, "{}: {a} {b}", file["robot"]);
            }
        }
    }
}

/// Returns a random mechanism of many joint types, some of them mimic joints, with up to four contacts.
fn touching(seed: u64) -> Model {
    let model = general_zoo(seed, 1 + seed as usize % 4);
    let moving =
        (0..model.links().len()).filter(|&frame| model.links()[frame].moving_link.is_some());
    let contact = |frame| Contact {
        name: format!("contact{frame}"),
        kind: ContactKind::Point,
        end: LoopConstraintEnd { link: frame, pose: Pose::identity() },
    };
    let contacts = moving.take(4).map(contact).collect();
    model.with_contacts(contacts).expect("links that move")
}

/// Returns the random robots of MJCF over a plane in a file of reference data, with their states.
fn floors(file: &str) -> Vec<(Model, Value)> {
    let robots = records(file).into_iter().map(|record| (floor(text(&record["mjcf"])), record));
    robots.collect()
}

/// Returns the records of a file of reference data: each has the text of a robot, and its states.
pub fn records(file: &str) -> Vec<Value> {
    let data = std::fs::read_to_string(format!("{}/golden/{file}", env!("CARGO_MANIFEST_DIR")));
    let data: Value = serde_json::from_str(&data.expect("the reference data")).expect("good");
    list(&data).to_vec()
}

/// Returns a robot of MJCF over a plane.
pub fn floor(mjcf: &str) -> Model {
    // The forces of tendons act in steps, and so do all couplings.
    let options = ReadOptions {
        unsupported_forces: Severity::Warning,
        mimic: Mimic::Independent,
        ..ReadOptions::default()
    };
    let reading = read(mjcf, "floor.xml", &options).expect("good");
    // The other functions have no friction, no tendons and no couplings of a high degree.
    let others = reading.warnings.iter().filter(|warning| {
        warning.code != Code::InactiveFriction && !warning.message.contains("in `step` only")
    });
    assert_eq!(others.count(), 0, "{:?}", reading.warnings);
    reading.model
}

/// Random robots of MJCF over a plane in general position. The description has shapes, components, cones,
/// limits and friction of all kinds, loops, tendons, couplings, and the settings of all of these.
#[test]
fn steps_on_a_floor_are_those_of_mujoco() {
    for (k, (model, file)) in floors("floors.json").iter().enumerate() {
        let mut robot = Interpreter::<f64>::new(model.clone());
        for state in list(&file["states"]) {
            let [q, qd, tau] = ["q", "qd", "tau"].map(|name| numbers(&state[name]));
            let dt = vec![number(&file["step"])];
            let given = [q, qd, tau, dt, vec![0.0; model.nv()], tight_settings(model)];
            let found = interpreted(&mut robot, Function::Step, &given);
            let expected = ["next_q", "next_qd"].map(|name| numbers(&state[name]));
            compare(&format!("{k}: {state}"), &found, &expected);
        }
    }
}

/// The robots have only slides and hinges, so a change of coordinates is a vector of the tangent space.
#[test]
fn derivatives_on_a_floor_are_those_of_mjx() {
    for (k, (model, file)) in floors("gradients.json").iter().enumerate() {
        let mut robot = Interpreter::<f64>::new(model.clone());
        for (state, expected) in list(&file["states"]).iter().enumerate() {
            let [q, qd, tau] = ["q", "qd", "tau"].map(|name| numbers(&expected[name]));
            let dt = vec![number(&file["step"])];
            let given = [q, qd, tau, dt, vec![0.0; model.nv()], tight_settings(model)];
            let results = interpreted(&mut robot, Function::StepDerivatives, &given);
            // The residual and the number of iterations are behind the matrices.
            let end = results.len() - 2;
            let rows = 2 * model.nv();
            let [before_a, before_b] = [3, 1].map(|blocks| end - rows * blocks * model.nv());
            for (name, start) in
                [("dq", before_a), ("dqd", before_a + rows * model.nv()), ("dtau", before_b)]
            {
                let matrix: Vec<Vec<f64>> = list(&expected[name]).iter().map(numbers).collect();
                let largest = matrix.concat().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
                for (column, row) in (0..model.nv()).flat_map(|c| (0..rows).map(move |r| (c, r))) {
                    let [found, expected] =
                        [results[start + rows * column + row], matrix[row][column]];
                    let error = (found - expected).abs() / largest;
                    assert!(
                        error <= GRADIENT_TOLERANCE,
                        "{k}, {state}, {name} {row} {column}: {found} {expected}"
                    );
                }
            }
        }
    }
}

/// The same robots with actuators of all kinds and with further free bodies, by each integrator.
#[test]
fn steps_under_controls_are_those_of_mujoco() {
    for (k, (model, file)) in floors("actuated.json").iter().enumerate() {
        let mut robot = Interpreter::<f64>::new(model.clone());
        for state in list(&file["states"]) {
            let [q, qd, ctrl, act, applied] =
                ["q", "qd", "ctrl", "act", "applied"].map(|name| numbers(&state[name]));
            let dt = vec![number(&file["step"])];
            let zeros = vec![0.0; model.nv()];
            let given = [q, qd, ctrl, dt, act, applied, zeros, tight_settings(model)];
            let results = interpreted(&mut robot, Function::StepActuated, &given);
            let expected = ["next_q", "next_qd", "next_act"].map(|name| numbers(&state[name]));
            compare(&format!("{k}: {state}"), &results, &expected);
        }
    }
}

/// Returns the settings of a step by the description, with a small tolerance.
fn tight_settings(model: &Model) -> Vec<f64> {
    StepSettings { tolerance: 1e-13, ..model.step_settings() }.all_numbers()
}

/// Compares the first results of a step with the expected ones, of which the second are the
/// velocities.
fn compare(state: &str, results: &[f64], expected: &[Vec<f64>]) {
    let largest = expected[1].iter().fold(1.0, |most: f64, x| most.max(x.abs()));
    for (result, expected) in results.iter().zip(expected.concat()) {
        let error = (result - expected).abs() / largest;
        assert!(error <= TOLERANCE, "{state}: {result} {expected}, {error:e}");
    }
}

/// Returns a shape of one of the six kinds, with random sizes; points have this number.
fn random_shape(kind: usize, points: usize, random: &mut Random) -> ContactShape<f64> {
    let mut size = || random.between(0.05, 0.2);
    match kind % 6 {
        0 => ContactShape::Point,
        1 => ContactShape::Segment(size()),
        2 => ContactShape::Cuboid([size(), size(), size()]),
        3 => ContactShape::Cylinder([size(), size()]),
        4 => ContactShape::Ellipsoid([size(), size(), size()]),
        _ => ContactShape::Points((0..points).map(|_| [size(), -size(), size()]).collect()),
    }
}

/// Returns a random mechanism with shapes of all kinds, cones of both kinds, and contacts of all components.
fn shaped(seed: u64) -> Model {
    let model = general_zoo(seed, 1 + seed as usize % 4);
    let moving =
        (0..model.links().len()).filter(|&frame| model.links()[frame].moving_link.is_some());
    let mut random = Random::new(seed);
    let shapes = moving.take(4).enumerate().map(|(k, frame)| {
        let shape = random_shape(seed as usize + k, 5, &mut random);
        let translation = [0.0; 3].map(|_| random.between(-0.1, 0.1));
        TouchingShape {
            name: format!("shape{frame}"),
            end: LoopConstraintEnd {
                link: frame,
                pose: Pose { rotation: random.any_rotation(), translation },
            },
            shape,
            components: [1, 3, 4, 6]
                .map(|n| ContactComponents::from_count(n).expect("a number of MuJoCo's"))
                [(seed as usize + k / 2) % 4],
            surface: ContactSurface::<f64>::GROUND,
            power: 1 + k as u32 % 3,
        }
    });
    let cone = if seed.is_multiple_of(2) { Cone::Pyramidal } else { Cone::Elliptic };
    let soft = SoftConstraints { cone, shapes: shapes.collect(), ..SoftConstraints::default() };
    model.with_soft_constraints(soft).expect("links that move")
}

/// The accelerations and the forces are in equilibrium, by the mass matrix and by Jacobians, which the step does not use; forces
/// are within the cone, and contacts that do not touch have none. Robots with mimic joints are among these.
#[test]
fn forces_and_accelerations_are_in_equilibrium() {
    let [mut open, mut pushing, mut mimic] = [0; 3];
    for seed in 0..60 {
        let model = touching(seed).with_joint_friction(JointFriction::None).expect("no friction");
        mimic += usize::from(model.has_mimics());
        let (nq, nv) = (model.nq(), model.nv());
        let mut robot = Interpreter::<f64>::new(model.clone());
        // Without limits, whose forces are no results.
        let soft = SoftModel::of(robot.model());
        robot.set_soft_model(SoftModel { joints: vec![None; nv], ..soft });
        for k in 0..5 {
            let mut given = arguments(Function::Step, &model, &state(100 * seed + k, &model));
            set(&mut given, TOLERANCE_OF_FORCES, 1e-12);
            let found = interpreted(&mut robot, Function::Step, &given);
            let [q, qd, tau] = [&given[0], &given[1], &given[2]];
            let qdd = &found[nq + nv..nq + 2 * nv];
            let mut inertial = vec![0.0; nv];
            robot.inverse_dynamics(q, qd, qdd, &mut inertial).expect("lengths");
            let mut applied = tau.clone();
            let surfaces = given[5][StepSettings::<f64>::COUNT..].as_chunks().0.iter();
            let forces = found[nq + 2 * nv..].as_chunks::<3>().0;
            for ((contact, surface), force) in model.contacts().iter().zip(surfaces).zip(forces) {
                let surface = ContactSurface::from_numbers(*surface);
                let axes = Matrix3(surface.plane.rotation);
                let normal = axes.column(2);
                let pose = robot.link_pose(q, contact.end.link).expect("a link");
                let height = Vector3(pose.translation) - Vector3(surface.plane.translation);
                let gap = normal.dot(height) - surface.radius;
                let [x, y, push] = *force;
                if gap >= surface.margin {
                    assert_eq!(*force, [0.0; 3], "{seed} {k}");
                    open += 1;
                    continue;
                }
                pushing += usize::from(push > 0.0);
                let slack = 1e-9 * (1.0 + push.abs());
                assert!(x.abs() + y.abs() <= surface.friction * push + slack, "{seed} {k}");
                let lever = normal.scale(-(surface.radius + 0.5 * gap));
                let force = axes.mul_vector(Vector3(*force));
                let mut columns = vec![Twist::zero(); nv];
                robot.jacobian(q, contact.end.link, &mut columns).expect("lengths");
                for (applied, column) in applied.iter_mut().zip(&columns) {
                    *applied += column.linear.dot(force) + column.angular.dot(lever.cross(force));
                }
            }
            let largest = applied
                .iter()
                .chain(forces.as_flattened())
                .fold(1.0, |most: f64, x| most.max(x.abs()));
            for (a, b) in inertial.iter().zip(&applied) {
                assert!((a - b).abs() <= 1e-8 * largest, "{seed} {k}: {a} {b}");
            }
        }
    }
    assert!(open > 100 && pushing > 100 && mimic > 1, "{open} {pushing} {mimic}");
}

/// A body that flies free of the link that carries its floating joint keeps its velocity in the world.
#[test]
fn floating_joints_beyond_the_base_keep_their_velocity() {
    let urdf = r#"<robot name="flight"><link name="world"/>
        <link name="arm"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <link name="body"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="turn" type="continuous"><parent link="world"/><child link="arm"/><axis xyz="0 0 1"/></joint>
        <joint name="fly" type="floating"><parent link="arm"/><child link="body"/></joint></robot>"#;
    let options = ReadOptions { base: Base::Fixed, ..ReadOptions::default() };
    let model = read(urdf, "flight.urdf", &options).expect("good").model;
    let model = model.with_gravity([0.0; 3]).expect("none");
    let mut robot = Interpreter::<f64>::new(model.clone());
    let body = model.link_index("body").expect("a link");
    let mut state =
        [vec![0.3, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0], vec![0.0, 1.0, -2.0, 0.5, 0.7, -0.4, 1.1]];
    let velocity = |robot: &mut Interpreter<f64>, state: &[Vec<f64>; 2]| {
        robot.link_velocity(&state[0], &state[1], body).expect("a link").linear.0
    };
    let before = velocity(&mut robot, &state);
    let zeros = vec![0.0; model.nv()];
    let settings = StepSettings::<f64>::DEFAULT.numbers().to_vec();
    for _ in 0..200 {
        let [q, qd] = state;
        let given = [q, qd, zeros.clone(), vec![0.01], zeros.clone(), settings.clone()];
        let found = interpreted(&mut robot, Function::Step, &given);
        let [nq, nv] = [model.nq(), model.nv()];
        state = [found[..nq].to_vec(), found[nq..nq + nv].to_vec()];
    }
    let after = velocity(&mut robot, &state);
    for (a, b) in before.iter().zip(after) {
        assert!((a - b).abs() < 1e-9, "{before:?} {after:?}");
    }
}

/// A quadruped that falls on its feet gains no energy, and comes to rest.
#[test]
fn contacts_take_energy() {
    let files = data();
    let model = robot(&list(&files)[0]);
    let [nq, nv] = [model.nq(), model.nv()];
    let mut robot = Interpreter::<f64>::new(model.clone());
    let floor = Pose { translation: [0.0, 0.0, -0.5], ..Pose::identity() };
    let surface = ContactSurface::<f64> { plane: floor, ..ContactSurface::default() };
    let settings =
        [&StepSettings::<f64>::DEFAULT.numbers()[..], &surface.numbers().repeat(4)].concat();
    let energy = |robot: &mut Interpreter<f64>, q: &[f64], qd: &[f64]| {
        let kinetic = robot.kinetic_energy(q, qd).expect("lengths");
        kinetic + robot.potential_energy(q).expect("lengths")
    };
    let mut q = vec![0.0; nq];
    robot.neutral(&mut q).expect("a length");
    let mut qd = vec![0.0; nv];
    let first = energy(&mut robot, &q, &qd);
    let mut most = first;
    let mut warm_start = vec![0.0; nv];
    for _ in 0..1_500 {
        // Springs and dampers hold the joints.
        let hold = |k: usize| if k < 6 { 0.0 } else { -20.0 * q[k + 1] - 0.2 * qd[k] };
        let tau = (0..nv).map(hold).collect();
        let given = [q, qd, tau, vec![0.002], warm_start, settings.clone()];
        let results = interpreted(&mut robot, Function::Step, &given);
        q = results[..nq].to_vec();
        qd = results[nq..nq + nv].to_vec();
        warm_start = results[nq + nv..nq + 2 * nv].to_vec();
        most = most.max(energy(&mut robot, &q, &qd));
    }
    let last = energy(&mut robot, &q, &qd);
    assert!(most < first + 1e-3 * (first - last), "{first} {most} {last}");
    assert!(last < first - 1.0 && qd.iter().all(|v| v.abs() < 1e-2), "{first} {last} {qd:?}");
}

/// Returns the mechanisms in general position with closed loops.
fn closed(seed: u64) -> Model {
    let names = SPATIAL_LOOPS.into_iter().chain([PLANAR_LOOP]);
    Golden::load(names.cycle().nth(seed as usize).expect("endless")).model
}

#[test]
fn programs_compute_the_steps_of_the_interpreter() {
    let mut iterations = 0.0;
    let robots = (0..40).map(|seed| (seed, touching(seed)));
    let robots = robots.chain((40..100).map(|seed| (seed, shaped(seed))));
    let robots = robots.chain((100..104).map(|seed| (seed, closed(seed))));
    let tied = |seed: u64| match seed % 3 {
        0 => closed(seed),
        1 => touching(seed),
        _ => shaped(seed),
    };
    let tied = (104..140).map(|seed| (seed, with_tendons(tied(seed), seed)));
    for (seed, model) in robots.chain(tied) {
        let choices = Choices { functions: vec![Function::Step], ..Choices::default() };
        let modules = ModuleTree::chains(&model);
        let plan = Plan::new(&model, &modules, &choices, Execution::Scalar);
        let plan = plan.unwrap_or_else(|_| panic!("the robot is small"));
        let mut robot = Interpreter::<f64>::new(model.clone());
        for k in 0..5 {
            let mut given = arguments(Function::Step, &model, &state(100 * seed + k, &model));
            set(&mut given, TOLERANCE_OF_FORCES, 1e-12);
            let expected = interpreted(&mut robot, Function::Step, &given);
            let found = plan.functions[0].evaluate(&plan.frames, 0, &given.concat());
            let largest = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            for (found, expected) in found.iter().zip(&expected) {
                let error = (found - expected).abs();
                assert!(error <= 1e-9 * largest, "{seed} {k}: {found} {expected}");
            }
            iterations += expected[expected.len() - 1];
        }
    }
    assert!(iterations > 300.0, "{iterations}: the solver iterates");
}

/// Equal limbs are in the lanes of vectors; the arms and the legs of a humanoid are on different bodies, and so are
/// joints without limits.
#[test]
fn programs_on_vectors_compute_the_steps_of_programs_on_scalars() {
    let mut compared = 0;
    for file in list(&data()) {
        let model = robot(file);
        let choices = Choices { functions: vec![Function::Step], ..Choices::default() };
        let modules = ModuleTree::chains(&model);
        let plan = Plan::new(&model, &modules, &choices, Execution::Simd);
        let plan = plan.unwrap_or_else(|_| panic!("the robot is small"));
        let Kernels::Straight { scalar, simd: Some(simd) } = &plan.functions[0].kernels else {
            panic!("{} has no program on vectors", model.name())
        };
        assert!(5 * simd.static_operations().total() < 4 * scalar.static_operations().total());
        for k in 0..20 {
            let mut given = arguments(Function::Step, &model, &state(k, &model));
            set(&mut given, TOLERANCE_OF_FORCES, 1e-12);
            let [expected, found] = [scalar, simd].map(|program| program.evaluate(&given.concat()));
            let largest = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            for (found, expected) in found.iter().zip(&expected) {
                let error = (found - expected).abs();
                assert!(error <= 1e-9 * largest, "{} {k}: {found} {expected}", model.name());
            }
            compared += 1;
        }
    }
    assert_eq!(compared, 40);
}

/// Shapes of equal limbs are in the lanes of vectors. One limb has a shape fewer than the others, and the joints have a softness of
/// their own.
#[test]
fn shapes_on_vectors_compute_the_steps_of_the_interpreter() {
    let mut pushing = 0;
    for (kind, file) in (0..12).zip(list(&data()).iter().cycle()) {
        let bare = robot(file).with_contacts(Vec::new()).expect("no contacts");
        let mut random = Random::new(kind);
        let mut shape = |name: String, frame: usize| {
            let shape = random_shape(kind as usize, 3, &mut random);
            let pose = Pose { rotation: random.any_rotation(), translation: [0.0; 3] };
            TouchingShape {
                name,
                end: LoopConstraintEnd { link: frame, pose },
                shape,
                components: [1, 3, 4, 6]
                    .map(|n| ContactComponents::from_count(n).expect("a number of MuJoCo's"))
                    [kind as usize % 4],
                surface: ContactSurface::<f64>::GROUND,
                power: 2,
            }
        };
        let ends = list(&file["contacts"]).iter().map(|contact| text(&contact["link"]));
        let mut frames: Vec<usize> =
            ends.map(|link| bare.link_index(link).expect("a link")).collect();
        frames.dedup();
        let mut shapes: Vec<TouchingShape> =
            frames.iter().map(|&frame| shape(format!("shape{frame}"), frame)).collect();
        shapes.push(shape("second".into(), frames[0]));
        shapes.push(shape("trunk".into(), 0));
        let soften = |joint: usize| {
            let standard = Softness::<f64>::standard();
            let limit = Softness { reference: [0.02 + 0.001 * joint as f64, 1.0], ..standard };
            JointSoftness { joint, margin: 0.01 * joint as f64, limit, friction: standard }
        };
        let soft = SoftConstraints {
            cone: if kind % 2 == 0 { Cone::Elliptic } else { Cone::Pyramidal },
            shapes,
            joints: (1..bare.moving_links().len()).map(soften).collect(),
            ..SoftConstraints::default()
        };
        let model = bare.with_soft_constraints(soft).expect("links that move");
        let choices = Choices { functions: vec![Function::Step], ..Choices::default() };
        let modules = ModuleTree::chains(&model);
        let plan = Plan::new(&model, &modules, &choices, Execution::Simd);
        let plan = plan.unwrap_or_else(|_| panic!("the robot is small"));
        let Kernels::Straight { simd: Some(simd), .. } = &plan.functions[0].kernels else {
            panic!("{} has no program on vectors", model.name())
        };
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        for k in 0..5 {
            let mut given = arguments(Function::Step, &model, &state(100 * kind + k, &model));
            set(&mut given, TOLERANCE_OF_FORCES, 1e-12);
            let expected = interpreted(&mut interpreter, Function::Step, &given);
            let computed = simd.evaluate(&given.concat());
            let largest = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            for (a, b) in computed.iter().zip(&expected) {
                assert!((a - b).abs() <= 1e-9 * largest, "{} {kind} {k}: {a} {b}", model.name());
            }
            let forces = &expected[model.nq() + 2 * model.nv()..expected.len() - 2];
            pushing += forces.chunks(3).filter(|force| force[2] > 0.0).count();
        }
    }
    assert!(pushing > 50, "{pushing}");
}

/// The places of settings, and of numbers of a surface.
const TOLERANCE_OF_FORCES: usize = 0;
const IMPRATIO: usize = 1;
const FRICTION: usize = 13;
const LEAST_IMPEDANCE: usize = 19;
const LARGEST_IMPEDANCE: usize = 20;

fn set(given: &mut [Vec<f64>], setting: usize, number: f64) {
    given.last_mut().expect("the settings are last")[setting] = number;
}

fn set_surfaces(given: &mut [Vec<f64>], place: usize, number: f64) {
    let settings = given.last_mut().expect("the settings are last");
    for surface in settings[StepSettings::<f64>::COUNT..].chunks_mut(ContactSurface::<f64>::COUNT) {
        surface[place] = number;
    }
}

/// Nearly rigid contacts, with friction a hundred times stiffer: the solver starts again with soft laws.
#[test]
fn stiff_laws_are_solved() {
    let mut most = 0.0_f64;
    for seed in 0..150 {
        let model = touching(seed);
        let mut robot = Interpreter::<f64>::new(model.clone());
        for k in 0..4 {
            let mut given = arguments(Function::Step, &model, &state(1000 * seed + k, &model));
            set(&mut given, IMPRATIO, 100.0);
            set_surfaces(&mut given, FRICTION, 0.3);
            set_surfaces(&mut given, LEAST_IMPEDANCE, 0.999);
            set_surfaces(&mut given, LARGEST_IMPEDANCE, 0.999);
            let found = interpreted(&mut robot, Function::Step, &given);
            let [residual, iterations] = [found[found.len() - 2], found[found.len() - 1]];
            assert!(residual <= 1e-8, "{seed} {k}: {residual:e} after {iterations}");
            most = most.max(iterations);
        }
    }
    assert!((13.0..40.0).contains(&most), "{most}");
}

/// Values of MuJoCo's `getimpedance`, by its documentation's formula.
#[test]
fn impedances_have_borders() {
    let standard = Softness::<f64>::standard().impedance;
    assert_eq!(standard.at(0.0), 0.9);
    assert_eq!(standard.at(-0.001), 0.95);
    assert_eq!(standard.at(0.0005), 0.925);
    // No width: the mean. No power: a line.
    assert!((Impedance { width: 0.0, ..standard }.at(0.3) - 0.925).abs() < 1e-15);
    assert!((Impedance { power: 0, ..standard }.at(0.00025) - 0.9125).abs() < 1e-15);
}
