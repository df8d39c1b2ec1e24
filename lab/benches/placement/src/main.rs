//! Measures how much the time of a call depends on the addresses of its stack frame, its result and its arguments. A processor
//! that compares the lower 12 bits of addresses first delays a load after a store at a multiple of 4,096 bytes from it.
//!
//! Each function runs at [`PLACEMENTS`] placements. The row has the least time of the best placement, of the worst one, and their
//! ratio; the machine code of modyn-jit and rustc's code are rows of their own.
//!
//! `cargo run --release --manifest-path lab/benches/placement/Cargo.toml`

mod place;

use std::hint::black_box;
use std::time::{Duration, Instant};

use modyn_codegen::{Builder, Function};
use modyn_jit::{Compiled, Options};
use place::{PLACEMENTS, Placement, at, candidates, deeper};

modyn::modyn! { Panda = "../../../../tests/golden/panda.urdf", joint_friction = none, functions = [
    forward_dynamics, forward_dynamics_derivatives
] }
modyn::modyn! { G1 = "../../../../tests/golden/g1.urdf", joint_friction = none, functions = [
    forward_dynamics_derivatives
] }

/// Each placement is measured this often, in turn with the others, so that other load of the machine meets all of them.
const ROUNDS: usize = 8;
const ROUND: Duration = Duration::from_millis(10);

/// The time between two readings of the clock is about this long.
const CALLS_TIME: Duration = Duration::from_micros(20);

/// Returns the least time of a call in this round, ns.
fn time(call: &mut dyn FnMut()) -> f64 {
    let first = Instant::now();
    call();
    call();
    let calls = (2 * CALLS_TIME.as_nanos() / first.elapsed().as_nanos().max(1)).clamp(1, 1000);
    let mut best = f64::MAX;
    let start = Instant::now();
    while start.elapsed() < ROUND {
        let first = Instant::now();
        for _ in 0..calls {
            call();
        }
        best = best.min(first.elapsed().as_nanos() as f64 / calls as f64);
    }
    best
}

/// Prints a row. `call` prepares one placement and hands the calls to its second argument.
fn row(name: &str, mut measured: impl FnMut(Placement, &mut dyn FnMut(&mut dyn FnMut()))) {
    let mut best = [f64::MAX; PLACEMENTS];
    for _ in 0..ROUNDS {
        for (k, best) in best.iter_mut().enumerate() {
            let placement = Placement::new(k);
            measured(placement, &mut |call| {
                deeper(placement.depth, &mut || *best = best.min(time(call)));
            });
        }
    }
    let least = best.iter().copied().fold(f64::MAX, f64::min);
    let most = best.iter().copied().fold(0.0, f64::max);
    println!("| {name} | {least:.0} | {most:.0} | {:.2} |", most / least);
    if std::env::args().any(|argument| argument == "--all") {
        println!("{best:.0?}");
    }
}

/// Returns numbers between -1 and 1, the same on every machine: a linear congruential generator.
fn numbers(count: usize) -> Vec<f64> {
    let mut seed = 1_u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

/// Measures machine code of modyn-jit.
fn machine_code(
    name: &str,
    text: &str,
    function: Function,
) -> Result<(), Box<dyn std::error::Error>> {
    let builder = Builder::new().urdf_text(text, name).functions([function]);
    let robot = Compiled::<f64>::build(&builder, Options::default())?;
    let call = robot.function(function)?;
    let n = robot.model().nv();
    let results = call.result().len();
    let given = numbers(3 * n);
    let mut failed = false;
    row(&format!("{name}, `{}`, modyn-jit", function.name()), |placement, measure| {
        let mut memory = vec![0.0; candidates::<f64>() + 3 * n];
        let first = at(&memory, placement.arguments);
        memory[first..first + 3 * n].copy_from_slice(&given);
        let arguments: Vec<&[f64]> = memory[first..first + 3 * n].chunks(n).collect();
        let mut memory = vec![0.0; candidates::<f64>() + results];
        let first = at(&memory, placement.results);
        let result = &mut memory[first..first + results];
        measure(&mut || failed |= call.one(black_box(&arguments), black_box(result)).is_err());
    });
    if failed { Err("a call failed".into()) } else { Ok(()) }
}

/// Returns the number of results from which one is chosen by its address.
fn count<T>(_: &T) -> usize {
    candidates::<T>()
}

/// Measures rustc's code: `$call` of arguments and results in vectors of them, of which those nearest to the wanted addresses
/// are used.
macro_rules! rust_code {
    ($name:literal, $Robot:ident::$function:ident) => {
        row($name, |placement, measure| {
            const N: usize = $Robot::NV;
            let numbers = numbers(3 * N);
            let state: [[f64; N]; 3] =
                std::array::from_fn(|i| std::array::from_fn(|j| numbers[N * i + j]));
            let arguments = vec![state; candidates::<[[f64; N]; 3]>()];
            let [q, qd, tau] = &arguments[at(&arguments, placement.arguments)];
            let one = $Robot::$function(q, qd, tau);
            let mut results = vec![one.clone(); count(&one)];
            let first = at(&results, placement.results);
            let result = &mut results[first];
            measure(&mut || {
                *black_box(&mut *result) =
                    $Robot::$function(black_box(q), black_box(qd), black_box(tau))
            });
        });
    };
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let panda = include_str!("../../../../tests/golden/panda.urdf");
    let g1 = include_str!("../../../../tests/golden/g1.urdf");
    println!("| function | best, ns | worst, ns | ratio |\n|---|---|---|---|");
    machine_code("Panda", panda, Function::ForwardDynamics)?;
    machine_code("Panda", panda, Function::ForwardDynamicsDerivatives)?;
    machine_code("G1", g1, Function::ForwardDynamicsDerivatives)?;
    rust_code!("Panda, `forward_dynamics`, rustc", Panda::forward_dynamics);
    rust_code!("Panda, `forward_dynamics_derivatives`, rustc", Panda::forward_dynamics_derivatives);
    rust_code!("G1, `forward_dynamics_derivatives`, rustc", G1::forward_dynamics_derivatives);
    Ok(())
}
