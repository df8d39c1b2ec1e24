//! Measures forward dynamics of robots, as straight-line code and as loops, with warm and with cold caches. Writes a table
//! (`lab/record` makes `docs/data/cold.tsv` from it):
//!
//! `RUSTFLAGS="-C target-cpu=native" cargo run --release --manifest-path lab/benches/chains/Cargo.toml --bin cold`

#[path = "../measure.rs"]
mod measure;

use measure::{Form, State, measured};
use modyn_reproduce::robots::spread;

/// Returns 64 states, from a function that makes coordinates of numbers between 0 and 1.
fn states<const NQ: usize, const NV: usize>(
    coordinates: impl Fn(&mut dyn FnMut() -> f64) -> [f64; NQ],
) -> Vec<State<NQ, NV>> {
    let mut numbers = spread(NV);
    let mut next = || numbers.next().unwrap_or_default();
    (0..64)
        .map(|_| {
            let q = coordinates(&mut || next().rem_euclid(1.0));
            let [qd, tau] = std::array::from_fn(|_| std::array::from_fn(|_| next()));
            (q, qd, tau)
        })
        .collect()
}

macro_rules! robots {
    ($($robot:literal $Fast:ident $fast:literal $Small:ident $small:literal;)*) => {
        fn main() {
            println!(
                "| robot | operations, fast | fast, ns | fast, cold, ns | operations, small | small, ns | small, cold, ns |"
            );
            println!("|{}", "---|".repeat(7));
            $(
                let at = states(|next| $Fast::random(next));
                let form = |Form { operations, warm, cold }: Form| {
                    format!("{operations} | {warm:.0} | {cold:.0}")
                };
                let fast = form(measured($fast, &at, $Fast::forward_dynamics));
                let small = form(measured($small, &at, $Small::forward_dynamics));
                println!("| {} | {fast} | {small} |", $robot);
            )*
        }
    };
}

include!(concat!(env!("OUT_DIR"), "/robots.rs"));
