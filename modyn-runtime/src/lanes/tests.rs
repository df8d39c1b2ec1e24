//! Every operation in every lane is compared with the scalar's: bit by bit where products are not
//! fused.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::vec::Vec;

use super::{BatchTask, Float, Lanes, SimdLevel, force_level};
use crate::Scalar;
use crate::scalar::near_pi;

/// Allows one test at a time, since the level is global to the process.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the results of all operations on these numbers.
#[inline(always)]
fn operations<S: Scalar>([a, b, c]: [S; 3]) -> [S; 20] {
    let (sin, cos) = a.sin_cos();
    let [(s0, c0), (s1, c1)] = S::sin_cos_all([b, c]);
    [
        a + b,
        a - b,
        a * b,
        a / b,
        -a,
        a.recip(),
        a.abs(),
        a.sqrt(),
        a.ln(),
        a.atan2(b),
        a.max(b),
        a.select_nonnegative(b, c),
        S::zero() + S::one(),
        a.mul_add(b, c),
        sin,
        cos,
        s0,
        c0,
        s1,
        c1,
    ]
}

/// The index of the first operation with a product in a sum. Earlier ones equal the scalar's on all
/// levels.
const PRODUCT: usize = 13;

/// The indices of the sines: of one angle, and of several.
const SINES: [usize; 3] = [14, 16, 18];

/// Runs the operations on slices that hold the lanes of all vectors.
struct All<'a, F> {
    numbers: [&'a [F]; 3],
    results: &'a mut Vec<[F; 20]>,
}

impl<F: Float> BatchTask<F> for All<'_, F> {
    #[inline(always)]
    #[allow(unsafe_code)] // Loads and stores.
    fn run<L: Lanes<Lane = F>>(self) {
        let count = self.numbers[0].len();
        let mut at = 0;
        while at + L::LANES <= count {
            // SAFETY: there are `count` numbers in each slice.
            let loaded = self.numbers.map(|x| unsafe { L::load(x[at..].as_ptr()) });
            let vectors = operations(loaded).map(|x| {
                let mut lanes = [F::zero(); 16];
                // SAFETY: no vector has more lanes.
                unsafe { x.store(lanes.as_mut_ptr()) }
                lanes
            });
            for lane in 0..L::LANES {
                self.results.push(vectors.map(|lanes| lanes[lane]));
            }
            at += L::LANES;
        }
    }
}

/// Compares all levels with scalars. With `fused`, products in sums are rounded once.
fn check<F: Float + Into<f64>>(
    bits: fn(F) -> u64,
    fused: fn(F, F, F) -> F,
    odd: &[F],
    tolerance: f64,
) {
    let ordinary = (1..60u32).map(|i| F::from_f64(f64::from(i) * 0.37 - 9.0));
    let values: Vec<F> = ordinary.chain(odd.iter().copied()).collect();
    let [mut a, mut b, mut c] = [Vec::new(), Vec::new(), Vec::new()];
    for (i, x) in values.iter().enumerate() {
        for (j, y) in values.iter().enumerate() {
            a.push(*x);
            b.push(*y);
            c.push(values[(i * 7 + j * 3) % values.len()]);
        }
    }
    while a.len() % 16 != 0 {
        for x in [&mut a, &mut b, &mut c] {
            x.push(F::one());
        }
    }
    let _alone = alone();
    for level in
        [SimdLevel::Single, SimdLevel::Sse2, SimdLevel::Avx2, SimdLevel::Avx512, SimdLevel::Neon]
    {
        if !force_level(Some(level)) {
            continue;
        }
        let mut results = Vec::new();
        F::dispatch(All { numbers: [&a, &b, &c], results: &mut results });
        assert_eq!(results.len(), a.len());
        let fuses = !matches!(level, SimdLevel::Single | SimdLevel::Sse2);
        for (i, vector) in results.iter().enumerate() {
            let mut expected = operations([a[i], b[i], c[i]]);
            if fuses {
                expected[PRODUCT] = fused(a[i], b[i], c[i]);
            }
            for (k, (&x, &y)) in vector.iter().zip(&expected).enumerate() {
                let p: f64 = x.into();
                let q: f64 = y.into();
                // Zeros of both signs are equally large, so either may be the maximum.
                let same = bits(x) == bits(y) || (p.is_nan() && q.is_nan()) || (k == 10 && p == q);
                let close = fuses && k > PRODUCT && (p - q).abs() <= tolerance * (1.0 + q.abs());
                assert!(same || close, "{level:?} {k} {i}: {p:e} {q:e}");
            }
        }
    }
    assert!(force_level(None));
}

#[test]
fn lanes_compute_as_scalars_do() {
    let odd = [
        0.0,
        -0.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e9,
        -3e5,
        262_144.0,
        1e-310,
        1e300,
    ];
    check::<f64>(f64::to_bits, f64::mul_add, &odd, 1e-15);
    let odd =
        [0.0, -0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e6, -5e3, 4096.0, 1e-40, 1e30];
    check::<f32>(|x| x.to_bits().into(), f32::mul_add, &odd, 1e-6);
}

/// Compares sines next to multiples of pi on every level, with fused products and without.
fn check_sines<F: Float + Into<f64>>(angles: &[(f64, f64)], tolerance: f64) {
    let numbers: Vec<F> = angles.iter().flat_map(|&(x, _)| [x, -x]).map(F::from_f64).collect();
    assert_eq!(numbers.len() % 16, 0, "whole vectors");
    let _alone = alone();
    for level in
        [SimdLevel::Single, SimdLevel::Sse2, SimdLevel::Avx2, SimdLevel::Avx512, SimdLevel::Neon]
    {
        if !force_level(Some(level)) {
            continue;
        }
        let mut results = Vec::new();
        F::dispatch(All { numbers: [&numbers; 3], results: &mut results });
        assert_eq!(results.len(), numbers.len());
        for (i, vector) in results.iter().enumerate() {
            let (x, sine) = angles[i / 2];
            let expected = if i % 2 == 0 { sine } else { -sine };
            for k in SINES {
                let number: f64 = vector[k].into();
                let error = ((number - expected) / expected).abs();
                assert!(error <= tolerance, "{level:?}: {x:e}: {number:e} {expected:e}");
            }
        }
    }
    assert!(force_level(None));
}

#[test]
fn sines_near_multiples_of_pi_keep_their_digits() {
    check_sines::<f64>(&near_pi::F64, 3.5e-16);
    check_sines::<f32>(&near_pi::F32, 2e-7);
}
