//! Compares functions of many states in lanes: the runtime's vectors (newtypes of `core::arch`), arrays with plain
//! loops, and one state after the other. A feature selects the variant; `run` builds and measures all of them.

#[cfg(any(feature = "loops4", feature = "loops8", feature = "loops16"))]
mod loops;
#[cfg(feature = "plain")]
#[path = "../../peers/modyn-runner/src/scalar_only.rs"]
mod plain;

use std::hint::black_box;
use std::time::{Duration, Instant};

#[cfg(feature = "vectors")]
modyn::modyn! {
    Arm = "../../../../robots/arm7.urdf",
    functions = [forward_dynamics_batch, inverse_dynamics_batch]
}
#[cfg(not(feature = "vectors"))]
modyn::modyn! { Arm = "../../../../robots/arm7.urdf", functions = [forward_dynamics, inverse_dynamics] }

const N: usize = Arm::NV;
/// A multiple of all numbers of lanes; columns do not begin at multiples of 4,096 bytes.
const STATES: usize = 1008;

/// The numbers of all states for each coordinate, and the same numbers state by state.
#[allow(dead_code)] // Each variant uses one of the two.
struct Numbers {
    columns: [Vec<f64>; N],
    states: Vec<[f64; N]>,
}

impl Numbers {
    /// Returns numbers of at most this magnitude, the same on every machine: a linear congruential generator.
    fn new(size: f64) -> Self {
        let mut seed = 1u64;
        let mut next = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            size * ((seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0)
        };
        let columns: [Vec<f64>; N] = std::array::from_fn(|_| (0..STATES).map(|_| next()).collect());
        let states = (0..STATES).map(|i| std::array::from_fn(|j| columns[j][i])).collect();
        Self { columns, states }
    }
}

/// Prints the minimal time of many calls, ns for each state.
fn time(name: &str, mut f: impl FnMut()) {
    let (start, mut best) = (Instant::now(), Duration::MAX);
    while start.elapsed() < Duration::from_millis(1500) {
        let call = Instant::now();
        f();
        best = best.min(call.elapsed());
    }
    println!("{name} {:.1}", best.as_nanos() as f64 / STATES as f64);
}

#[cfg(feature = "vectors")]
fn contenders([q, qd, x, y]: &mut [Numbers; 4]) {
    let [q, qd, x] = [q, qd, x].map(|numbers| numbers.columns.each_ref().map(|c| &c[..]));
    time("forward", || {
        let out = y.columns.each_mut().map(|column| &mut column[..]);
        Arm::forward_dynamics_batch(q, qd, x, black_box(out)).expect("sizes");
    });
    time("inverse", || {
        let out = y.columns.each_mut().map(|column| &mut column[..]);
        Arm::inverse_dynamics_batch(q, qd, x, black_box(out)).expect("sizes");
    });
}

#[cfg(feature = "one")]
fn contenders([q, qd, x, y]: &mut [Numbers; 4]) {
    for (name, f) in [
        ("forward", Arm::forward_dynamics as fn(&_, &_, &_) -> _),
        ("inverse", Arm::inverse_dynamics),
    ] {
        time(name, || {
            for i in 0..STATES {
                y.states[i] = f(&q.states[i], &qd.states[i], &x.states[i]);
            }
            black_box(&mut y.states);
        });
    }
}

#[cfg(feature = "plain")]
fn contenders([q, qd, x, y]: &mut [Numbers; 4]) {
    use modyn::Robot;
    use plain::ScalarOnly;
    for (name, f) in [
        (
            "forward",
            <Arm as Robot>::forward_dynamics::<ScalarOnly> as fn(&_, &_, &_) -> [ScalarOnly; N],
        ),
        ("inverse", <Arm as Robot>::inverse_dynamics::<ScalarOnly>),
    ] {
        time(name, || {
            for i in 0..STATES {
                let [q, qd, x] =
                    [q.states[i], qd.states[i], x.states[i]].map(|s| s.map(ScalarOnly));
                y.states[i] = f(&q, &qd, &x).map(|number| number.0);
            }
            black_box(&mut y.states);
        });
    }
}

#[cfg(any(feature = "loops4", feature = "loops8", feature = "loops16"))]
fn contenders([q, qd, x, y]: &mut [Numbers; 4]) {
    use loops::Loop;
    use modyn::Robot;
    const LANES: usize = match () {
        () if cfg!(feature = "loops4") => 4,
        () if cfg!(feature = "loops8") => 8,
        () => 16,
    };
    for (name, f) in [
        (
            "forward",
            <Arm as Robot>::forward_dynamics::<Loop<LANES>> as fn(&_, &_, &_) -> [Loop<LANES>; N],
        ),
        ("inverse", <Arm as Robot>::inverse_dynamics::<Loop<LANES>>),
    ] {
        time(name, || {
            for at in (0..STATES).step_by(LANES) {
                let load = |numbers: &Numbers| {
                    numbers.columns.each_ref().map(|column| {
                        Loop::<LANES>(column[at..at + LANES].try_into().expect("as many"))
                    })
                };
                let results = f(&load(q), &load(qd), &load(x));
                for (column, result) in y.columns.iter_mut().zip(results) {
                    column[at..at + LANES].copy_from_slice(&result.0);
                }
            }
            black_box(&mut y.columns);
        });
    }
}

#[cfg(not(any(
    feature = "vectors",
    feature = "one",
    feature = "plain",
    feature = "loops4",
    feature = "loops8",
    feature = "loops16"
)))]
fn contenders(_: &mut [Numbers; 4]) {
    time("forward", || ());
    time("inverse", || ());
}

fn main() {
    contenders(&mut black_box([3.0, 2.0, 5.0, 0.0].map(Numbers::new)));
}
