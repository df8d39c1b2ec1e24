//! A table of a function of robots: as straight-line code and as loops, with warm and with cold caches.

#[path = "measure.rs"]
pub mod measure;

use measure::State;
use modyn_reproduce::robots::spread;

/// Returns 64 states, from a function that makes coordinates of numbers between 0 and 1.
pub fn states<const NQ: usize, const NV: usize>(
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
    ($function:ident $($robot:literal $Unrolled:ident $unrolled:literal $Looped:ident $looped:literal;)*) => {
        fn main() {
            use robots::measure::{Form, measured};
            use robots::states;

            println!(
                "| robot | operations, unrolled | unrolled, ns | unrolled, cold, ns | operations, looped | looped, ns | \
                 looped, cold, ns |"
            );
            println!("|{}", "---|".repeat(7));
            $(
                let at = states(|next| $Unrolled::random_configuration(next));
                let form = |Form { operations, warm, cold }: Form| {
                    format!("{operations} | {warm:.0} | {cold:.0}")
                };
                let unrolled = form(measured($unrolled, &at, $Unrolled::$function));
                let looped = form(measured($looped, &at, $Looped::$function));
                println!("| {} | {unrolled} | {looped} |", $robot);
            )*
        }
    };
}
