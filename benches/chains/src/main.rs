//! Measures forward dynamics for chains of increasing length, generated (4 to 112 joints) and interpreted (to 100,000
//! links). Writes a table (`tools/record` makes `docs/data/chains.tsv` from it) and a plot:
//!
//! `RUSTFLAGS="-C target-cpu=native" cargo run --release --manifest-path benches/chains/Cargo.toml -- FOLDER`

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use modyn_reproduce::complexity::seconds;
use modyn_reproduce::plot::{Axis, Chart, Line};
use modyn_reproduce::robots;

/// A measured chain.
struct Measured {
    n: usize,
    operations: usize,
    ns: f64,
}

/// Returns the median time of a call in ns, of 31 repetitions of about a millisecond over 64 states.
fn time<const N: usize>(function: impl Fn(&[f64; N], &[f64; N], &[f64; N]) -> [f64; N]) -> f64 {
    let numbers: Vec<f64> = robots::spread(N).take(64 * 3 * N).collect();
    let vectors: &[[f64; N]] = numbers.as_chunks().0;
    let pass = || {
        for state in vectors.as_chunks::<3>().0 {
            let [q, qd, tau] = black_box(state);
            black_box(function(q, qd, tau));
        }
    };
    let start = Instant::now();
    pass();
    let passes = (1e-3 / start.elapsed().as_secs_f64()).ceil().max(1.0) as u32;
    let mut times: Vec<f64> = (0..31)
        .map(|_| {
            let start = Instant::now();
            (0..passes).for_each(|_| pass());
            start.elapsed().as_secs_f64() * 1e9 / (64.0 * f64::from(passes))
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[15]
}

macro_rules! chains {
    ($($Chain:ident $n:literal $operations:literal;)*) => {
        fn generated() -> Vec<Measured> {
            vec![$(Measured {
                n: $n,
                operations: $operations,
                ns: time::<$n>(|q, qd, tau| $Chain::forward_dynamics(q, qd, tau)),
            }),*]
        }
    };
}

include!(concat!(env!("OUT_DIR"), "/chains.rs"));

fn main() {
    let folder = std::env::args().nth(1).unwrap_or(".".into());
    let generated = generated();
    let lengths = [4, 7, 14, 28, 56, 112, 1000, 10_000, 100_000];
    let interpreted: Vec<(f64, f64)> =
        lengths.iter().map(|&n| (n as f64, seconds(n) * 1e9)).collect();
    println!("| joints | operations | generated, ns | ns a joint | interpreted, ns | ns a link |");
    println!("|---|---|---|---|---|---|");
    for (i, (n, interpreted)) in interpreted.iter().enumerate() {
        let compiled =
            generated.get(i).map_or("| |".into(), |Measured { operations, ns, .. }| {
                format!("{operations} | {ns:.0} | {:.1}", ns / n)
            });
        println!("| {n} | {compiled} | {interpreted:.0} | {:.0} |", interpreted / n);
    }
    let line = generated.iter().map(|chain| (chain.n as f64, chain.ns));
    let chart = Chart {
        title: "Forward dynamics of a chain, one core",
        x: Axis::logarithmic("joints"),
        y: Axis::logarithmic("time (ns)"),
        lines: vec![Line::new("generated", line), Line::new("interpreted", interpreted)],
    };
    let path = Path::new(&folder).join("chains.svg");
    chart.write(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}
