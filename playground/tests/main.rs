//! Requests of the page, answered as in a browser.

use modyn_codegen::Builder;
use modyn_playground::{Motion, MotionOptions, Session};
use modyn_runtime::Interpreter;
use modyn_runtime::equations::State;
use modyn_runtime::equations::constraints::ResidualOutputs;
use modyn_runtime::model::Model;
use serde_json::{Value, json};

/// Returns the answer to a request.
fn ask(session: &mut Session, request: &Value, bytes: &[u8]) -> Value {
    serde_json::from_str(&session.answer(&request.to_string(), bytes)).expect("JSON")
}

/// Returns a session that has read a description, and the answer.
fn read(name: &str, text: &str, options: &Value) -> (Session, Value) {
    let mut session = Session::default();
    ask(&mut session, &json!({ "do": "put", "file": name }), text.as_bytes());
    let request = json!({ "do": "read", "file": name, "options": options });
    let answer = ask(&mut session, &request, &[]);
    (session, answer)
}

/// Returns a robot of the repository.
fn robot(name: &str) -> String {
    let path = format!("{}/../robots/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).expect("a robot")
}

/// Returns the model of a description whose root link floats, with these contacts.
fn floating(text: &str, contacts: Vec<modyn_codegen::Contact>) -> Model {
    let base = modyn_codegen::Base::Floating;
    let options = modyn_codegen::ReadOptions { base, contacts, ..Default::default() };
    modyn_codegen::read(text, "robot.urdf", &options).expect("a robot").model
}

#[test]
fn operations_and_texts_are_those_of_the_builder() {
    let text = robot("gripper");
    let (mut session, answer) = read("gripper.urdf", &text, &json!({}));
    assert_eq!((&answer["usable"], &answer["robot"]["nv"]), (&json!(true), &json!(4)));
    let names = ["mass_matrix", "forward_dynamics"]
        .map(|name| modyn_codegen::Function::from_name(name).expect("a function"));
    let builder = Builder::new().text(&*text, "gripper.urdf").functions(names);
    let generated = builder.generate().expect("compiled");
    assert_eq!(generated.operations.len(), 2);
    for (name, count) in generated.operations {
        let cost = ask(&mut session, &json!({ "do": "cost", "function": name }), &[]);
        assert_eq!(cost["total"], count.total(), "{name}");
        assert_eq!(cost["sin_cos"], count.sin_cos, "{name}");
    }
    let functions = "mass_matrix, forward_dynamics";
    let request = json!({ "do": "text", "target": "rust", "functions": functions });
    let texts = ask(&mut session, &request, &[]);
    assert_eq!(texts["files"][0]["text"], generated.text);
    let modules = ask(&mut session, &json!({ "do": "modules" }), &[]);
    assert!(modules["svg"].as_str().is_some_and(|svg| svg.starts_with("<svg")), "{modules}");
}

#[test]
fn errors_have_their_lines_and_other_requests_messages() {
    let text = robot("arm7");
    // The first mass is that of the base, which is fixed.
    let (at, mass) = text.match_indices("<mass value=\"").nth(1).expect("a mass");
    let text = format!("{}-{}", &text[..at + mass.len()], &text[at + mass.len()..]);
    let line = 1 + text[..at].matches('\n').count();
    let (mut session, answer) = read("arm.urdf", &text, &json!({}));
    assert_eq!(
        (&answer["usable"], &answer["diagnostics"][0]["line"]),
        (&json!(false), &json!(line))
    );
    let report = answer["report"].as_str().expect("a text");
    assert!(report.contains(&format!("arm.urdf:{line}:")), "{report}");
    assert!(
        report.contains(
            "
arm.urdf: refused, "
        ),
        "{report}"
    );
    for (request, message) in [
        (json!(null), "no text `do`"),
        (json!({ "do": "fly" }), "no request `fly`"),
        (json!({ "do": "read", "file": "leg.urdf" }), "no file `leg.urdf`"),
        (json!({ "do": "cost", "function": "mass_matrix" }), "no robot has been read"),
        (json!({ "do": "scene" }), "no robot has been read"),
        (json!({ "do": "step", "dt": 0.001 }), "has not been started"),
        (json!({ "do": "step", "dt": -1 }), "no time step"),
        (json!({ "do": "read", "file": "arm.urdf", "options": { "base": "flying" } }), "`base`"),
    ] {
        let answer = ask(&mut session, &request, &[]);
        let error = answer["error"].as_str().unwrap_or_default();
        assert!(error.contains(message), "{request}: {answer}");
    }
    let (mut session, _) = read("arm.urdf", &robot("arm7"), &json!({}));
    let short = ask(&mut session, &json!({ "do": "start", "q": [0, 0] }), &[]);
    assert!(short["error"].is_string(), "{short}");
    let bad = ask(&mut session, &json!({ "do": "cost", "function": "fly" }), &[]);
    assert!(bad["error"].is_string(), "{bad}");
    let bad = json!({ "do": "text", "target": "fortran", "functions": "mass_matrix" });
    assert!(ask(&mut session, &bad, &[])["error"].is_string());
}

#[test]
fn the_feet_of_a_floating_robot_touch_the_ground() {
    let (mut session, answer) =
        read("quadruped.urdf", &robot("quadruped"), &json!({ "base": "floating" }));
    let contacts = answer["robot"]["chosen_contacts"].as_str().expect("a text");
    let feet = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"];
    let expected = feet.map(|foot| format!("\"{foot}\": point(\"{foot}\")"));
    assert_eq!(contacts, expected.join(", "));
    // It stands where its joints are held, after it was put in the ground.
    let mut q = vec![0.0; 19];
    (q[2], q[6]) = (-1.0, 1.0);
    let start = json!({ "do": "start", "q": q, "friction": 0.8, "limits": true, "hold": true });
    let placed = ask(&mut session, &start, &[]);
    assert!(placed["q"][2].as_f64() > Some(0.2), "{placed}");
    let moved = ask(&mut session, &json!({ "do": "step", "dt": 0.001, "count": 300 }), &[]);
    let forces = moved["forces"].as_array().expect("forces");
    let upwards = forces.iter().skip(5).step_by(6).filter_map(Value::as_f64).sum::<f64>();
    let weight = answer["robot"]["mass"].as_f64().expect("a mass") * 9.81;
    assert!((upwards / weight - 1.0).abs() < 0.05, "{upwards} N instead of {weight} N");
}

#[test]
fn a_free_robot_falls_and_a_pendulum_keeps_its_energy() {
    let model = floating(&robot("humanoid"), Vec::new());
    let mut q = vec![0.0; model.nq()];
    Interpreter::<f64>::new(model.clone()).neutral(&mut q).expect("the length");
    let mut motion = Motion::new(&model, &q, MotionOptions::default()).expect("a motion");
    let (steps, dt) = (20, 0.001);
    for _ in 0..steps {
        motion.step(dt).expect("a step");
    }
    // The sum of the velocities after each step.
    let fall = 9.81 * dt * dt * f64::from(steps * (steps + 1)) / 2.0;
    assert!((motion.q[2] + fall).abs() < 1e-9, "{:?}", motion.q);

    let text = robot("double_pendulum");
    let model = modyn_codegen::read(&text, "p.urdf", &Default::default()).expect("a robot").model;
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let mut energy = |motion: &Motion| {
        let potential = interpreter.potential_energy(&motion.q).expect("the length");
        potential + interpreter.kinetic_energy(&motion.q, &motion.qd).expect("the length")
    };
    let mut motion = Motion::new(&model, &[0.9, -0.7], MotionOptions::default()).expect("a motion");
    let (before, mut kinetic) = (energy(&motion), 0.0_f64);
    for _ in 0..10_000 {
        motion.step(1e-4).expect("a step");
        kinetic = kinetic.max(motion.qd.iter().map(|rate| rate.abs()).sum());
    }
    assert!(
        kinetic > 1.0 && (energy(&motion) - before).abs() < 2e-3,
        "{} {before}",
        energy(&motion)
    );
}

#[test]
fn joints_that_are_held_stay_and_loops_stay_closed() {
    let model = modyn_codegen::read(&robot("arm7"), "a.urdf", &Default::default());
    let model = model.expect("a robot").model;
    let q = [0.3, 0.5, 0.2, -1.6, 0.1, 2.0, 0.4];
    let options = MotionOptions { hold: true, limits: true, ..MotionOptions::default() };
    let mut motion = Motion::new(&model, &q, options).expect("a motion");
    for _ in 0..500 {
        motion.step(0.001).expect("a step");
    }
    let away = motion.q.iter().zip(q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(away < 1e-6, "{away}");

    let model = modyn_codegen::read(&robot("four_bar"), "f.urdf", &Default::default());
    let model = model.expect("a robot").model;
    let q = modyn_cli::loops::closed_start(&model).expect("closed");
    let mut motion = Motion::new(&model, &q, MotionOptions::default()).expect("a motion");
    for _ in 0..500 {
        motion.step(0.001).expect("a step");
    }
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let twists = || vec![modyn_runtime::spatial::Twist::zero(); model.constraints()];
    let (mut apart, mut velocities) = (twists(), twists());
    let settings = modyn_cli::loops::settings_of(&model);
    let found = interpreter.constraint_residual(
        State { q: &motion.q, qd: &motion.qd },
        &settings,
        ResidualOutputs { displacements: &mut apart, velocities: &mut velocities },
    );
    found.expect("the lengths");
    let gap = apart[0].components().iter().map(|x| x.abs()).fold(0.0, f64::max);
    let moved = motion.q.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(gap < 2e-3 && moved > 0.1, "{gap} m apart after {moved} rad");
}
