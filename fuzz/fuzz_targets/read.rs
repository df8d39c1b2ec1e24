//! Any text becomes a model, or errors that say what is wrong with it; nothing panics.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use modyn_codegen::diagnostics::{Code, Severity};
use modyn_codegen::{Base, Friction, Mimic, ReadOptions, Rotor, read};

fuzz_target!(|data: &[u8]| {
    let (text, choice) = modyn_fuzz::text(data);
    let flag = |bit: u8| choice >> bit & 1 == 1;
    let options = ReadOptions {
        base: if flag(0) { Base::Floating } else { Base::Fixed },
        mimic: [Mimic::Follow, Mimic::Follow, Mimic::Independent, Mimic::Refuse]
            [usize::from(choice >> 1 & 3)],
        unphysical_inertia: if flag(3) { Severity::Warning } else { Severity::Error },
        friction: flag(4).then_some(Friction::Smooth(0.1)),
        rotors: if flag(5) {
            vec![Rotor { joint: "a".into(), inertia: 0.1, gear_ratio: 9.0 }]
        } else {
            Vec::new()
        },
        gravity: flag(6).then_some([0.0; 3]),
        ..ReadOptions::default()
    };
    match read(&text, "fuzz.urdf", &options) {
        Ok(reading) => {
            assert!(reading.model.nq() > 0);
            assert!(reading.warnings.iter().all(|d| d.severity == Severity::Warning));
        }
        Err(errors) => {
            assert!(errors.has_errors());
            // What reading takes, the model must take.
            assert!(errors.iter().all(|d| d.code != Code::InvalidModel), "{errors}");
            // Every diagnostic can be shown, and points into the text.
            let lines = text.lines().count() + 1;
            assert!(errors.iter().all(|d| !d.to_string().is_empty()));
            assert!(
                errors.iter().filter_map(|d| d.position).all(|p| (1..=lines).contains(&p.line))
            );
        }
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    modyn_fuzz::mutate(data, size, max_size, seed)
});
