//! NEON, aarch64's baseline: 2 `f64` or 4 `f32`, with fused multiply-add.
//!
//! Unsafe code: `load` and `store` use pointers, which is sound by their callers' contract. The
//! instructions exist wherever `level` returns `SimdLevel::Neon`, since the target has them.
#![allow(unsafe_code, unused_unsafe)]

use core::arch::aarch64::*;

use super::pair::Pair;
use super::simd::{backend, pack};
use super::vector::{vector, work};

vector! {
    F64x2: [f64; 2] in float64x2_t;
    vdupq_n_f64 vld1q_f64 vst1q_f64 vaddq_f64 vsubq_f64 vmulq_f64 vdivq_f64 vsqrtq_f64 vabsq_f64;
    mul_add(a, b, c) vfmaq_f64(c, a, b);
    max(a, b) vmaxnmq_f64(a, b);
    select(x, then, otherwise) vbslq_f64(vcgezq_f64(x), then, otherwise);
    below(x, limit) vminvq_u32(vreinterpretq_u32_u64(vcltq_f64(x, limit))) != 0;
    flip(x, by) vreinterpretq_f64_u64(veorq_u64(
        vreinterpretq_u64_f64(x), vshlq_n_u64::<63>(vreinterpretq_u64_f64(by))
    ));
}

vector! {
    F32x4: [f32; 4] in float32x4_t;
    vdupq_n_f32 vld1q_f32 vst1q_f32 vaddq_f32 vsubq_f32 vmulq_f32 vdivq_f32 vsqrtq_f32 vabsq_f32;
    mul_add(a, b, c) vfmaq_f32(c, a, b);
    max(a, b) vmaxnmq_f32(a, b);
    select(x, then, otherwise) vbslq_f32(vcgezq_f32(x), then, otherwise);
    below(x, limit) vminvq_u32(vcltq_f32(x, limit)) != 0;
    flip(x, by) vreinterpretq_f32_u32(veorq_u32(
        vreinterpretq_u32_f32(x), vshlq_n_u32::<31>(vreinterpretq_u32_f32(by))
    ));
}

work! {
    f64 on F64x2;
    f32 on F32x4;
}

pack! {
    F64x2: 2 of f64, [0 1] in [0 1];
    F32x4: 2 of f32, [0 1] in [0 1 0 1];
    F32x4: 4 of f32, [0 1 2 3] in [0 1 2 3];
}

backend! {
    f64 by run_simd_f64 on Doubles: f64, F64x2, Pair<F64x2>, Pair<Pair<F64x2>>;
    f32 by run_simd_f32 on Singles: f32, F32x4, F32x4, Pair<F32x4>;
}
