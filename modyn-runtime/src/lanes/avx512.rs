//! AVX-512 (F and VL): 8 `f64` or 16 `f32`, with fused multiply-add.
//!
//! Unsafe code: these instructions may only run on a processor that has them, which the compiler
//! cannot check. The processor has them wherever values of these types exist. The types cannot be
//! named outside of `lanes`. Inside, only the two functions that `work!` defines here use them,
//! which `dispatch` calls for `SimdLevel::Avx512` only. (Generic functions receive the types from
//! these two functions.)
#![allow(unsafe_code)]

use core::arch::x86_64::*;

use super::vector::{vector, work};

vector! {
    F64x8: [f64; 8] in __m512d, "avx512f,avx512vl";
    _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd
    _mm512_sqrt_pd _mm512_abs_pd;
    mul_add(a, b, c) _mm512_fmadd_pd(a, b, c);
    // If one operand is NaN, the instruction returns the second one.
    max(a, b) _mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_UNORD_Q>(b, b), _mm512_max_pd(a, b), a);
    select(x, then, otherwise) _mm512_mask_blend_pd(
        _mm512_cmp_pd_mask::<_CMP_GE_OQ>(x, _mm512_setzero_pd()), otherwise, then
    );
    below(x, limit) _mm512_cmp_pd_mask::<_CMP_LT_OQ>(x, limit) == 0xff;
    flip(x, by) _mm512_castsi512_pd(_mm512_xor_si512(
        _mm512_castpd_si512(x), _mm512_slli_epi64::<63>(_mm512_castpd_si512(by))
    ));
}

vector! {
    F32x16: [f32; 16] in __m512, "avx512f,avx512vl";
    _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps
    _mm512_sqrt_ps _mm512_abs_ps;
    mul_add(a, b, c) _mm512_fmadd_ps(a, b, c);
    max(a, b) _mm512_mask_blend_ps(_mm512_cmp_ps_mask::<_CMP_UNORD_Q>(b, b), _mm512_max_ps(a, b), a);
    select(x, then, otherwise) _mm512_mask_blend_ps(
        _mm512_cmp_ps_mask::<_CMP_GE_OQ>(x, _mm512_setzero_ps()), otherwise, then
    );
    below(x, limit) _mm512_cmp_ps_mask::<_CMP_LT_OQ>(x, limit) == 0xffff;
    flip(x, by) _mm512_castsi512_ps(_mm512_xor_si512(
        _mm512_castps_si512(x), _mm512_slli_epi32::<31>(_mm512_castps_si512(by))
    ));
}

work! {
    f64 on F64x8, "avx512f,avx512vl";
    f32 on F32x16, "avx512f,avx512vl";
}
