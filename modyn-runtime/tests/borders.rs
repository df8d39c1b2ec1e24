//! Batches of every length up to several vectors, in memory of exactly that length, on all vectors of the processor.
//! Under a sanitizer or valgrind the test shows that no other memory is accessed.
#![cfg(feature = "std")]

use modyn_runtime::batch::{Argument, Float, Inputs, Kernel, Lanes, Outputs, SimdLevel};
use modyn_runtime::batch::{
    FlaggedStates, force_level, run, run_each, run_each_flagged, run_flagged,
};

/// The sum and the product of two numbers.
struct Both;

impl<F: Float> Kernel<F, 2, 2> for Both {
    #[inline(always)]
    fn run<L: Lanes<Lane = F>>(&self, inputs: Inputs<'_, L, 2>, outputs: Outputs<'_, L, 2>) {
        let (a, b) = (inputs.get::<0>(), inputs.get::<1>());
        outputs.set::<0>(a + b);
        outputs.set::<1>(a * b);
    }
}

/// A number times one flag, plus another flag.
struct Flagged;

impl<F: Float> Kernel<F, 1, 1, 2> for Flagged {
    #[inline(always)]
    fn run<L: Lanes<Lane = F>>(&self, inputs: Inputs<'_, L, 1, 2>, outputs: Outputs<'_, L, 1>) {
        outputs.set::<0>(inputs.get::<0>() * inputs.flag::<0>() + inputs.flag::<1>());
    }
}

const FLAGGED: &[Argument] = &[
    Argument { name: "x", numbers: 1, coordinates: &["a"] },
    Argument { name: "flags", numbers: 2, coordinates: &["on", "more"] },
    Argument { name: "out", numbers: 1, coordinates: &["a"] },
];

const ARGUMENTS: &[Argument] = &[
    Argument { name: "x", numbers: 2, coordinates: &["a", "b"] },
    Argument { name: "out", numbers: 2, coordinates: &["a", "b"] },
];

/// Returns integers, so that no result is rounded.
fn numbers<F: Float>(count: usize, step: f64) -> Box<[F]> {
    (0_u8..100).cycle().take(count).map(|i| F::from_f64(f64::from(i) * step)).collect()
}

fn every_length<F: Float + PartialEq + std::fmt::Debug>() {
    for states in (0..70).chain([255, 512, 1031]) {
        let (a, b) = (numbers::<F>(states, 1.0), numbers::<F>(states, 2.0));
        let outputs = || [numbers::<F>(states, 0.0), numbers::<F>(states, 0.0)];
        let [mut sum, mut product] = outputs();
        run(&Both, ARGUMENTS, [&a, &b], [&mut sum, &mut product]).expect("as many of each");
        let expected = |i: usize| [a[i] + b[i], a[i] * b[i]];
        for i in 0..states {
            assert_eq!([sum[i], product[i]], expected(i), "state {i} of {states}");
        }
        let flat: Box<[F]> = a.iter().zip(&b).flat_map(|(&a, &b)| [a, b]).collect();
        let mut each = vec![[F::zero(); 2]; states].into_boxed_slice();
        run_each(&Both, ARGUMENTS, [&flat], &mut each, |x| [x]).expect("as many of each");
        assert!((0..states).all(|i| each[i] == expected(i)), "{states} states");
        // A result in two parts.
        run_each(&Both, ARGUMENTS, [&flat], &mut each, |x| {
            let (first, second) = x.split_at_mut(1);
            [second, first]
        })
        .expect("as many of each");
        assert!((0..states).all(|i| each[i] == [expected(i)[1], expected(i)[0]]));
        let sets: Box<[[bool; 2]]> = (0..states).map(|i| [i % 3 == 0, i % 5 < 2]).collect();
        let flags: [Box<[bool]>; 2] = [0, 1].map(|k| sets.iter().map(|set| set[k]).collect());
        let expected = |i: usize| {
            let one = |flag| if flag { F::one() } else { F::zero() };
            a[i] * one(sets[i][0]) + one(sets[i][1])
        };
        let [mut out, mut same] = outputs();
        let inputs = ([&*a], [&*flags[0], &*flags[1]]);
        run_flagged(&Flagged, FLAGGED, inputs, [&mut out]).expect("as many of each");
        assert!((0..states).all(|i| out[i] == expected(i)), "{states} states");
        let inputs =
            FlaggedStates { inputs: [&*a], sets: Some(&*sets), flags: |set: &[bool; 2]| *set };
        run_each_flagged(&Flagged, FLAGGED, inputs, &mut same, |x| [std::slice::from_mut(x)])
            .expect("as many of each");
        assert_eq!(out, same);
        #[cfg(feature = "rayon")]
        {
            let [mut first, mut second] = outputs();
            let outputs: [&mut [F]; 2] = [&mut first, &mut second];
            modyn_runtime::batch::run_parallel(&Both, ARGUMENTS, [&a, &b], outputs).expect("good");
            assert_eq!([first, second], [sum, product]);
        }
    }
}

#[test]
fn nothing_beyond_the_slices_is_touched() {
    let all =
        [SimdLevel::Single, SimdLevel::Sse2, SimdLevel::Avx2, SimdLevel::Avx512, SimdLevel::Neon];
    let tried = all.into_iter().filter(|&level| force_level(Some(level))).inspect(|_| {
        every_length::<f64>();
        every_length::<f32>();
    });
    assert!(tried.count() > 0);
    force_level(None);
}

#[test]
fn slices_of_other_lengths_are_refused() {
    let (a, b) = (numbers::<f64>(20, 1.0), numbers::<f64>(19, 1.0));
    let [mut x, mut y] = [numbers::<f64>(20, 0.0), numbers::<f64>(20, 0.0)];
    let error = run(&Both, ARGUMENTS, [&a, &b], [&mut x, &mut y]).expect_err("one is short");
    assert_eq!((error.states, error.expected), (19, 20));
    assert!(run(&Both, ARGUMENTS, [&b, &b], [&mut x, &mut y]).is_err());
    let (on, more) = ([true; 20], [false; 18]);
    let error = run_flagged(&Flagged, FLAGGED, ([&a], [&on, &more]), [&mut x]);
    let said = error.expect_err("a flag is short").to_string();
    assert_eq!(said, "`flags[1]` (more) holds 18 states, `x[0]` holds 20");
    let mut each = [[0.0; 2]; 9];
    let error = run_each(&Both, ARGUMENTS, [&a], &mut each, |x| [x]).expect_err("one is missing");
    assert_eq!((error.argument, error.states, error.expected), ("out", 9, 10));
}
