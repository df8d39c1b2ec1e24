//! The parts that the targets share. An input is the text of a description followed by one byte, which selects options.

mod mutate;
pub mod vocabulary;

use modyn_codegen::diagnostics::{Code, Diagnostics, Severity};
use modyn_codegen::{
    Base, Builder, Function, Ground, JointActuator, JointFriction, Mimic, ReadOptions, Reading,
    Rotor, joints_without_inertia,
};

pub use mutate::mutate;

/// Returns the text of an input, and the byte that selects options.
#[must_use]
pub fn text(data: &[u8]) -> (String, u8) {
    let (choice, text) = data.split_last().unwrap_or((&0, &[]));
    (String::from_utf8_lossy(text).into_owned(), *choice)
}

/// Returns the options of reading that the bits of `choice` select.
#[must_use]
pub fn read_options(choice: u8) -> ReadOptions {
    let flag = |bit: u8| choice >> bit & 1 == 1;
    ReadOptions {
        base: [Base::Auto, Base::Floating, Base::Fixed][usize::from(choice) % 3],
        mimic: [Mimic::Follow, Mimic::Follow, Mimic::Independent, Mimic::Refuse]
            [usize::from(choice >> 1 & 3)],
        unphysical_inertia: if flag(3) { Severity::Warning } else { Severity::Error },
        joint_friction: flag(4).then_some(JointFriction::Smooth(0.1)),
        ground: flag(7).then(Ground::default),
        actuators: if flag(6) {
            vec![JointActuator::position("*", 20.0, 0.5).with_delay(2)]
        } else {
            Vec::new()
        },
        rotors: if flag(5) {
            vec![Rotor { joint: "a".into(), inertia: 0.1, gear_ratio: 9.0 }]
        } else {
            Vec::new()
        },
        gravity: flag(6).then_some([0.0; 3]),
        ..ReadOptions::default()
    }
}

/// Checks the result of reading `text`.
///
/// # Panics
///
/// Panics if a model cannot move, if a success has errors or a failure has none, if the model refuses what reading
/// accepted, or if a diagnostic is empty or points beyond the text.
pub fn check(text: &str, result: &Result<Reading, Diagnostics>) {
    match result {
        Ok(reading) => {
            assert!(reading.model.nq() > 0);
            assert!(reading.warnings.iter().all(|d| d.severity == Severity::Warning));
        }
        Err(errors) => {
            assert!(errors.has_errors());
            assert!(errors.iter().all(|d| d.code != Code::InvalidModel), "{errors}");
            let lines = text.lines().count() + 1;
            assert!(errors.iter().all(|d| !d.to_string().is_empty()));
            assert!(
                errors.iter().filter_map(|d| d.position).all(|p| (1..=lines).contains(&p.line))
            );
        }
    }
}

/// Compiles a few functions of a model that was read: poses if the robot has no inertia, else dynamics.
///
/// # Panics
///
/// Panics if the model does not compile, if the text is no Rust, or if a constant is not a number.
pub fn compile(reading: Reading) {
    let functions = match joints_without_inertia(&reading.model).is_empty() {
        true => [Function::InverseDynamics, Function::ForwardDynamics],
        false => [Function::LinkPose, Function::Jacobian],
    };
    let generated = Builder::new()
        .model(reading.model)
        .unphysical_inertia(Severity::Warning)
        .functions(functions)
        .generate()
        .expect("a model that was read compiles");
    syn::parse_file(&generated.text).expect("Rust");
    assert!(!generated.text.contains("NaN"), "a constant is not a number");
}

/// Returns the result of a function in a thread whose stack has this many bytes.
///
/// # Panics
///
/// If the thread cannot be started, or the function panics. If its stack is too small, the process
/// ends.
pub fn with_stack<T: Send>(bytes: usize, run: impl FnOnce() -> T + Send) -> T {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(bytes).spawn_scoped(scope, run);
        thread.expect("a thread").join().expect("no panic")
    })
}
