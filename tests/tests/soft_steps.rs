//! Steps with soft constraints against MuJoCo: see the reference data's README.

use modyn_codegen::{Base, ReadOptions, read};
use modyn_runtime::Interpreter;
use modyn_runtime::equations::soft_constraints::{
    Cone, ContactParameters, JointParameters, SoftParameters, SoftStep, Softness, StepInput,
};
use modyn_runtime::model::{
    Contact, ContactKind, Friction, JointDynamics, LoopConstraintEnd, Model,
};
use modyn_runtime::spatial::{Matrix3, Pose, Vector3};
use serde_json::Value;

/// Of the largest velocity; the rest is MuJoCo's own tolerance.
const TOLERANCE: f64 = 1e-8;

/// The largest mismatch of forces, N.
const RESIDUAL: f64 = 1e-8;

fn numbers(value: &Value) -> Vec<f64> {
    let values = value.as_array().expect("a list");
    values.iter().map(|x| x.as_f64().expect("a number")).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn text(value: &Value) -> &str {
    value.as_str().expect("a text")
}

fn list(value: &Value) -> &[Value] {
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
    let mut links = model.links().to_vec();
    for (link, damping) in links.iter_mut().skip(1).zip(damping) {
        link.joint.dynamics = JointDynamics { damping, ..link.joint.dynamics };
    }
    let names: Vec<&str> = links.iter().skip(1).map(|link| &*link.joint.name).collect();
    assert_eq!(names, list(&file["joints"]).iter().map(text).collect::<Vec<_>>());
    let contacts = list(&file["contacts"]).iter().map(|contact| {
        let link = text(&contact["link"]);
        let frame = model.frames().iter().position(|frame| frame.name == link);
        let position = <[f64; 3]>::try_from(numbers(&contact["position"])).expect("three");
        let pose = Pose { translation: position, ..Pose::identity() };
        let end = LoopConstraintEnd { frame: frame.expect("a link"), pose };
        Contact { name: text(&contact["name"]).into(), kind: ContactKind::Point, end }
    });
    Model::new(name, [0.0, 0.0, -9.81], links, model.frames().to_vec())
        .and_then(|model| model.with_friction(Friction::Viscous))
        .and_then(|model| model.with_contacts(contacts.collect()))
        .expect("a robot")
}

fn parameters(file: &Value, cone: Cone) -> SoftParameters<f64> {
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
    let contact = |contact: &Value| ContactParameters {
        plane,
        radius: number(&file["radius"]),
        friction: number(&contact["friction"]),
        margin: 0.0,
        mobility: number(&contact["mobility"]),
        softness: Softness::standard(),
    };
    let [dry_friction, mobility] = ["dry_friction", "mobility"].map(|name| numbers(&file[name]));
    let joint = |(k, range): (usize, &Value)| JointParameters {
        coordinate: 7 + k,
        range: <[f64; 2]>::try_from(numbers(range)).expect("two").map(Some),
        margin: 0.0,
        mobility: mobility[k],
        limit: Softness::standard(),
        dry_friction: Some(dry_friction[k]),
        friction: Softness::standard(),
    };
    let joints = list(&file["range"]).iter().enumerate().map(joint).map(Some);
    SoftParameters {
        tolerance: RESIDUAL,
        cone,
        ratio: number(&file["ratio"]),
        contacts: list(&file["contacts"]).iter().map(contact).collect(),
        joints: [None; 6].into_iter().chain(joints).collect(),
    }
}

#[test]
fn steps_are_those_of_mujoco() {
    let path = format!("{}/golden/soft_steps.json", env!("CARGO_MANIFEST_DIR"));
    let data = std::fs::read_to_string(path).expect("the reference data");
    let data: Value = serde_json::from_str(&data).expect("good");
    let (mut compared, mut touching, mut most) = (0, 0, 0);
    for file in list(&data) {
        let mut interpreter = Interpreter::<f64>::new(robot(file));
        for state in list(&file["states"]) {
            let cone = match text(&state["cone"]) {
                "pyramidal" => Cone::Pyramidal,
                _ => Cone::Elliptic,
            };
            let [q, qd, tau] = ["q", "qd", "tau"].map(|name| numbers(&state[name]));
            let tau = [&[0.0; 6][..], &tau].concat();
            let warm = vec![0.0; qd.len()];
            let dt = number(&file["step"]);
            let input = StepInput { q: &q, qd: &qd, tau: &tau, warm: &warm, dt };
            let parameters = parameters(file, cone);
            let step = interpreter.soft_step(input, &parameters).expect("lengths");
            let SoftStep { solution, residual, iterations } = step.expect("no mimic joints");
            let [next_q, next_qd] = ["next_q", "next_qd"].map(|name| numbers(&state[name]));
            let largest = next_qd.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            assert!(residual <= RESIDUAL, "{iterations}: {residual}");
            let what = format!("{} {compared}, {} contacts", file["robot"], state["contacts"]);
            for (found, expected) in
                solution.qd.iter().zip(&next_qd).chain(solution.q.iter().zip(&next_q))
            {
                let error = (found - expected).abs() / largest;
                assert!(error <= TOLERANCE, "{what}, {cone:?}: {found} {expected}, {error:e}");
            }
            compared += 1;
            touching += solution.forces.iter().filter(|force| force[0] > 0.0).count();
            most = most.max(iterations as usize);
        }
    }
    assert!(compared == 32 && touching > 30 && most < 20, "{compared} {touching} {most}");
}
