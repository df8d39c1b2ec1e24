//! States and SIMD levels of the tests of batches.

use std::sync::{Mutex, MutexGuard, PoisonError};

use modyn_runtime::Scalar;
use modyn_runtime::batch::{SimdLevel, force_level};

/// Locks the SIMD level, which belongs to the process, so that one test at a time changes it.
pub fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Calls `f` at every available SIMD level; the argument is whether products are fused there.
///
/// # Panics
/// If a level of this machine cannot be chosen.
pub fn on_every_level(mut f: impl FnMut(bool)) {
    let _alone = alone();
    for level in
        [SimdLevel::Single, SimdLevel::Sse2, SimdLevel::Avx2, SimdLevel::Avx512, SimdLevel::Neon]
    {
        assert_eq!(force_level(Some(level)), is_there(level), "{level:?}");
        if is_there(level) {
            f(!matches!(level, SimdLevel::Single | SimdLevel::Sse2)
                || cfg!(target_feature = "fma"));
        } else {
            eprintln!("left out: {level:?}");
        }
    }
    assert!(force_level(None));
}

/// Returns whether this processor has a level, and no higher level is compiled in.
#[cfg(target_arch = "x86_64")]
fn is_there(level: SimdLevel) -> bool {
    let avx2 = cfg!(all(target_feature = "avx2", target_feature = "fma"));
    let avx512 = cfg!(all(target_feature = "avx512f", target_feature = "avx512vl"));
    match level {
        SimdLevel::Sse2 => !avx2 && !avx512,
        SimdLevel::Avx2 => {
            is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") && !avx512
        }
        SimdLevel::Avx512 => {
            is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl")
        }
        _ => false,
    }
}

/// Returns whether the program is compiled for a level.
#[cfg(not(target_arch = "x86_64"))]
fn is_there(level: SimdLevel) -> bool {
    let neon = cfg!(all(target_arch = "aarch64", target_feature = "neon"));
    level == if neon { SimdLevel::Neon } else { SimdLevel::Single }
}

/// Returns numbers in -1..1.
pub fn numbers() -> impl FnMut() -> f64 {
    let mut state = 7u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Returns a vector of numbers in -size..size for each state.
#[must_use]
pub fn vectors<T: Scalar, const N: usize>(states: usize, size: f64) -> Vec<[T; N]> {
    let mut number = numbers();
    (0..states).map(|_| std::array::from_fn(|_| T::from_f64(size * number()))).collect()
}

/// Returns one column for each coordinate, with a number for each state.
#[must_use]
pub fn columns<T: Copy, const N: usize>(states: &[[T; N]]) -> [Vec<T>; N] {
    std::array::from_fn(|j| states.iter().map(|state| state[j]).collect())
}

/// Returns the columns as slices.
#[must_use]
pub fn slices<T, const N: usize>(columns: &[Vec<T>; N]) -> [&[T]; N] {
    columns.each_ref().map(|column| &column[..])
}

/// Returns the columns as mutable slices.
#[must_use]
pub fn slices_mut<T, const N: usize>(columns: &mut [Vec<T>; N]) -> [&mut [T]; N] {
    columns.each_mut().map(|column| &mut column[..])
}
