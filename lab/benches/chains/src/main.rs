//! Measures forward dynamics for chains of increasing length: generated as straight-line code and as loops (4 to 112 joints,
//! with warm and with cold caches), and interpreted (to 100,000 links). Writes a table (`lab/record` makes `docs/data/chains.tsv` from it) and a plot:
//!
//! `RUSTFLAGS="-C target-cpu=native" cargo run --release --manifest-path lab/benches/chains/Cargo.toml --bin chains -- FOLDER`

mod measure;

use std::path::Path;

use modyn_reproduce::complexity::seconds;
use modyn_reproduce::plot::{Axis, Chart, Line};
use modyn_reproduce::robots;

use measure::{Form, State, measured};

/// A measured chain: straight-line code, and loops.
struct Measured {
    n: usize,
    unrolled: Form,
    looped: Form,
}

/// Returns 64 states of a chain.
fn states<const N: usize>() -> Vec<State<N, N>> {
    let numbers: Vec<f64> = robots::spread(N).take(64 * 3 * N).collect();
    let vectors: &[[f64; N]] = numbers.as_chunks().0;
    vectors.as_chunks::<3>().0.iter().map(|&[q, qd, tau]| (q, qd, tau)).collect()
}

macro_rules! chains {
    ($($n:literal $Unrolled:ident $unrolled:literal $Looped:ident $looped:literal;)*) => {
        fn generated() -> Vec<Measured> {
            vec![$(Measured {
                n: $n,
                unrolled: measured($unrolled, &states::<$n>(), $Unrolled::forward_dynamics),
                looped: measured($looped, &states::<$n>(), $Looped::forward_dynamics),
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
    println!(
        "| joints | operations, unrolled | unrolled, ns | unrolled, ns a joint | unrolled, cold, ns | operations, looped | \
         looped, ns | looped, ns a joint | looped, cold, ns | interpreted, ns | ns a link |"
    );
    println!("|{}", "---|".repeat(11));
    for (i, (n, interpreted)) in interpreted.iter().enumerate() {
        let form = |Form { operations, warm, cold }: &Form| {
            format!("{operations} | {warm:.0} | {:.1} | {cold:.0}", warm / n)
        };
        let compiled = generated.get(i).map_or("| | | | | | |".into(), |chain| {
            format!("{} | {}", form(&chain.unrolled), form(&chain.looped))
        });
        println!("| {n} | {compiled} | {interpreted:.0} | {:.0} |", interpreted / n);
    }
    let line = |form: fn(&Measured) -> &Form| {
        generated.iter().map(move |chain| (chain.n as f64, form(chain).warm))
    };
    let chart = Chart {
        title: "Forward dynamics of a chain, one core",
        x: Axis::logarithmic("joints"),
        y: Axis::logarithmic("time (ns)"),
        lines: vec![
            Line::new("unrolled", line(|chain| &chain.unrolled)),
            Line::new("looped", line(|chain| &chain.looped)),
            Line::new("interpreted", interpreted),
        ],
    };
    let path = Path::new(&folder).join("chains.svg");
    chart.write(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}
