//! SSE2, x86-64's baseline: 2 `f64` or 4 `f32`. Products are rounded before they are added, as in
//! scalars.
//!
//! Unsafe code: `load` and `store` use pointers, which is sound by their callers' contract. Every
//! x86-64 processor has the instructions.
#![allow(unsafe_code, unused_unsafe)]

use core::arch::x86_64::*;

use super::vector::{vector, work};

/// Returns the absolute values.
#[inline]
fn abs_pd(x: __m128d) -> __m128d {
    // SAFETY: every x86-64 processor has the instruction.
    unsafe { _mm_andnot_pd(_mm_set1_pd(-0.0), x) }
}

/// Returns the absolute values.
#[inline]
fn abs_ps(x: __m128) -> __m128 {
    // SAFETY: every x86-64 processor has the instruction.
    unsafe { _mm_andnot_ps(_mm_set1_ps(-0.0), x) }
}

/// Returns `then` where `mask` is set, bit by bit; else `otherwise`.
#[inline]
fn blend_pd(otherwise: __m128d, then: __m128d, mask: __m128d) -> __m128d {
    // SAFETY: every x86-64 processor has the instructions.
    unsafe { _mm_or_pd(_mm_and_pd(mask, then), _mm_andnot_pd(mask, otherwise)) }
}

/// Returns `then` where `mask` is set, bit by bit; else `otherwise`.
#[inline]
fn blend_ps(otherwise: __m128, then: __m128, mask: __m128) -> __m128 {
    // SAFETY: every x86-64 processor has the instructions.
    unsafe { _mm_or_ps(_mm_and_ps(mask, then), _mm_andnot_ps(mask, otherwise)) }
}

vector! {
    F64x2: [f64; 2] in __m128d;
    _mm_set1_pd _mm_loadu_pd _mm_storeu_pd _mm_add_pd _mm_sub_pd _mm_mul_pd _mm_div_pd _mm_sqrt_pd abs_pd;
    mul_add(a, b, c) _mm_add_pd(_mm_mul_pd(a, b), c);
    // If one operand is NaN, the instruction returns the second one.
    max(a, b) blend_pd(_mm_max_pd(a, b), a, _mm_cmpunord_pd(b, b));
    select(x, then, otherwise) blend_pd(otherwise, then, _mm_cmpge_pd(x, _mm_setzero_pd()));
    below(x, limit) _mm_movemask_pd(_mm_cmplt_pd(x, limit)) == 0x3;
    flip(x, by) _mm_xor_pd(x, _mm_castsi128_pd(_mm_slli_epi64::<63>(_mm_castpd_si128(by))));
}

vector! {
    F32x4: [f32; 4] in __m128;
    _mm_set1_ps _mm_loadu_ps _mm_storeu_ps _mm_add_ps _mm_sub_ps _mm_mul_ps _mm_div_ps _mm_sqrt_ps abs_ps;
    mul_add(a, b, c) _mm_add_ps(_mm_mul_ps(a, b), c);
    max(a, b) blend_ps(_mm_max_ps(a, b), a, _mm_cmpunord_ps(b, b));
    select(x, then, otherwise) blend_ps(otherwise, then, _mm_cmpge_ps(x, _mm_setzero_ps()));
    below(x, limit) _mm_movemask_ps(_mm_cmplt_ps(x, limit)) == 0xf;
    flip(x, by) _mm_xor_ps(x, _mm_castsi128_ps(_mm_slli_epi32::<31>(_mm_castps_si128(by))));
}

work! {
    f64 on F64x2;
    f32 on F32x4;
}
