//! AVX2 and FMA: 4 `f64` or 8 `f32`, with fused multiply-add.
//!
//! Unsafe code: these instructions may only run on a processor that has them, which the compiler
//! cannot check. The processor has them wherever values of this folder's types exist. The types
//! cannot be named outside of `lanes`. Inside, only the four functions that `work!` and `vectors!`
//! define here use them. `lanes` calls these for `SimdLevel::Avx2`, for `SimdLevel::Avx512`, whose
//! processors have AVX2 and FMA, too, and in programs compiled for both. (Generic functions receive
//! the types from these four functions.)
#![allow(unsafe_code)]

mod fused;
mod registers;

use super::pair::Pair;
use super::simd::{backend, pack};
use super::vector::work;
use fused::{F32x1, F64x1};
use registers::{F32x4, F32x8, F64x2, F64x4};

work! {
    f64 on F64x4, "avx2,fma";
    f32 on F32x8, "avx2,fma";
}

pack! {
    F64x2: 2 of F64x1, [0 1] in [0 1];
    F64x4: 4 of F64x1, [0 1 2 3] in [0 1 2 3];
    F32x4: 2 of F32x1, [0 1] in [0 1 0 1];
    F32x4: 4 of F32x1, [0 1 2 3] in [0 1 2 3];
    F32x8: 8 of F32x1, [0 1 2 3 4 5 6 7] in [0 1 2 3 4 5 6 7];
}

backend! {
    f64 by run_simd_f64 on Doubles "avx2,fma": F64x1, F64x2, F64x4, Pair<F64x4>;
    f32 by run_simd_f32 on Singles "avx2,fma": F32x1, F32x4, F32x4, F32x8;
}
