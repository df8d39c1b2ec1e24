//! Checks and measures functions, as `../cpp/harness.hpp` does.

#[path = "cold.rs"]
mod cold;

use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

/// The number of states, from the first on, whose results are checked.
pub const CHECKED: usize = 64;

/// The arguments of a measurement.
pub struct Job {
    #[allow(dead_code)]
    pub robot: String,
    pub quantity: String,
    pub nv: usize,
    /// The joints, in the order of velocities.
    #[allow(dead_code)]
    pub joints: Vec<String>,
    nq: usize,
    repetitions: usize,
    states: Vec<f64>,
    reference: Vec<f64>,
}

/// Reads little-endian doubles.
fn numbers(path: &Path) -> Vec<f64> {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    bytes.as_chunks().0.iter().map(|&number| f64::from_le_bytes(number)).collect()
}

impl Job {
    /// Reads the files that [`write`](crate::states::write) has written.
    pub fn read(folder: &Path, robot: &str, quantity: &str, repetitions: &str) -> Self {
        let file = |extension: &str| folder.join(format!("{robot}.{extension}"));
        let text = std::fs::read_to_string(file("model")).expect("written by `states`");
        let mut words = text.split_whitespace();
        let mut size = || words.next().and_then(|word| word.parse().ok()).expect("a size");
        let (nq, nv) = (size(), size());
        Self {
            robot: robot.into(),
            quantity: quantity.into(),
            nq,
            nv,
            joints: words.map(String::from).collect(),
            repetitions: repetitions.parse().expect("a number of repetitions"),
            states: numbers(&file("states")),
            reference: numbers(&file(quantity)),
        }
    }

    /// Returns q, qd, tau, qdd of all states.
    pub fn states(&self) -> Vec<[Vec<f64>; 4]> {
        let (nq, nv) = (self.nq, self.nv);
        let state = |numbers: &[f64]| {
            let (q, rest) = numbers.split_at(nq);
            let vector = |k: usize| rest[k * nv..][..nv].to_vec();
            [q.to_vec(), vector(0), vector(1), vector(2)]
        };
        self.states.chunks_exact(nq + 3 * nv).map(state).collect()
    }

    /// Prints the largest error of the first results against the interpreter's, relative to the largest number of a
    /// result (or to 1).
    pub fn check(&self, results: impl Iterator<Item = Vec<f64>>) {
        let expected = self.reference.chunks_exact(self.reference.len() / CHECKED);
        let mut error = 0.0f64;
        for (result, expected) in results.zip(expected) {
            assert_eq!(result.len(), expected.len(), "a result's size");
            let scale = expected.iter().fold(1.0, |scale: f64, x| scale.max(x.abs()));
            for (x, y) in result.iter().zip(expected) {
                let this = (x - y).abs() / scale;
                error = if this.is_nan() { f64::INFINITY } else { error.max(this) };
            }
        }
        println!("error {error:e}");
        if error >= 1e-8 {
            std::process::exit(1);
        }
    }

    /// Prints the median time of a call, ns: a warm-up of at least 20 ms, then repetitions of at least 4 ms, each
    /// through all states as many times as that takes. Then prints the median time with empty caches.
    pub fn time<S>(&self, states: &[S], mut call: impl FnMut(&S)) {
        self.time_all(states.len(), || states.iter().for_each(|state| call(black_box(state))));
        if let Some([median, late, most]) =
            cold::cold(states.len(), |i| call(black_box(&states[i])))
        {
            println!("cold {median}\ncold_99 {late}\ncold_most {most}");
        }
    }

    /// Prints the median time for a function that computes this number of states in one call.
    pub fn time_all(&self, states: usize, mut pass: impl FnMut()) {
        let start = Instant::now();
        let mut passes = 0u32;
        while start.elapsed() < Duration::from_millis(20) {
            pass();
            passes += 1;
        }
        let one = start.elapsed().as_secs_f64() / f64::from(passes);
        let passes = (4e-3 / one).ceil().max(1.0) as u32;
        let mut times: Vec<f64> = (0..self.repetitions)
            .map(|_| {
                let start = Instant::now();
                (0..passes).for_each(|_| pass());
                let calls = f64::from(passes) * states as f64;
                start.elapsed().as_secs_f64() * 1e9 / calls
            })
            .collect();
        times.sort_by(f64::total_cmp);
        println!("ns {}", times[times.len() / 2]);
    }
}
