//! The vectors of AVX2 and their halves.
//!
//! Unsafe code: these types exist only where the processor has AVX2 and FMA, see the folder's
//! header.
#![allow(unsafe_code)]

use core::arch::x86_64::*;

use crate::lanes::vector::vector;

/// Returns the absolute values.
#[inline]
#[target_feature(enable = "avx2")]
fn abs_pd(x: __m256d) -> __m256d {
    _mm256_andnot_pd(_mm256_set1_pd(-0.0), x)
}

/// Returns the absolute values.
#[inline]
#[target_feature(enable = "avx2")]
fn abs_ps(x: __m256) -> __m256 {
    _mm256_andnot_ps(_mm256_set1_ps(-0.0), x)
}

vector! {
    F64x4: [f64; 4] in __m256d, "avx2,fma";
    _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd
    _mm256_sqrt_pd abs_pd;
    mul_add(a, b, c) _mm256_fmadd_pd(a, b, c);
    // If one operand is NaN, the instruction returns the second one.
    max(a, b) _mm256_blendv_pd(_mm256_max_pd(a, b), a, _mm256_cmp_pd::<_CMP_UNORD_Q>(b, b));
    select(x, then, otherwise) _mm256_blendv_pd(
        otherwise, then, _mm256_cmp_pd::<_CMP_GE_OQ>(x, _mm256_setzero_pd())
    );
    below(x, limit) _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(x, limit)) == 0xf;
    flip(x, by) _mm256_xor_pd(
        x, _mm256_castsi256_pd(_mm256_slli_epi64::<63>(_mm256_castpd_si256(by)))
    );
}

vector! {
    F32x8: [f32; 8] in __m256, "avx2,fma";
    _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps
    _mm256_sqrt_ps abs_ps;
    mul_add(a, b, c) _mm256_fmadd_ps(a, b, c);
    max(a, b) _mm256_blendv_ps(_mm256_max_ps(a, b), a, _mm256_cmp_ps::<_CMP_UNORD_Q>(b, b));
    select(x, then, otherwise) _mm256_blendv_ps(
        otherwise, then, _mm256_cmp_ps::<_CMP_GE_OQ>(x, _mm256_setzero_ps())
    );
    below(x, limit) _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(x, limit)) == 0xff;
    flip(x, by) _mm256_xor_ps(
        x, _mm256_castsi256_ps(_mm256_slli_epi32::<31>(_mm256_castps_si256(by)))
    );
}

// Half vectors.

/// Returns the absolute values.
#[inline]
#[target_feature(enable = "avx2")]
fn abs_half_pd(x: __m128d) -> __m128d {
    _mm_andnot_pd(_mm_set1_pd(-0.0), x)
}

/// Returns the absolute values.
#[inline]
#[target_feature(enable = "avx2")]
fn abs_half_ps(x: __m128) -> __m128 {
    _mm_andnot_ps(_mm_set1_ps(-0.0), x)
}

vector! {
    F64x2: [f64; 2] in __m128d, "avx2,fma";
    _mm_set1_pd _mm_loadu_pd _mm_storeu_pd _mm_add_pd _mm_sub_pd _mm_mul_pd _mm_div_pd _mm_sqrt_pd abs_half_pd;
    mul_add(a, b, c) _mm_fmadd_pd(a, b, c);
    max(a, b) _mm_blendv_pd(_mm_max_pd(a, b), a, _mm_cmpunord_pd(b, b));
    select(x, then, otherwise) _mm_blendv_pd(otherwise, then, _mm_cmpge_pd(x, _mm_setzero_pd()));
    below(x, limit) _mm_movemask_pd(_mm_cmplt_pd(x, limit)) == 0x3;
    flip(x, by) _mm_xor_pd(x, _mm_castsi128_pd(_mm_slli_epi64::<63>(_mm_castpd_si128(by))));
}

vector! {
    F32x4: [f32; 4] in __m128, "avx2,fma";
    _mm_set1_ps _mm_loadu_ps _mm_storeu_ps _mm_add_ps _mm_sub_ps _mm_mul_ps _mm_div_ps _mm_sqrt_ps abs_half_ps;
    mul_add(a, b, c) _mm_fmadd_ps(a, b, c);
    max(a, b) _mm_blendv_ps(_mm_max_ps(a, b), a, _mm_cmpunord_ps(b, b));
    select(x, then, otherwise) _mm_blendv_ps(otherwise, then, _mm_cmpge_ps(x, _mm_setzero_ps()));
    below(x, limit) _mm_movemask_ps(_mm_cmplt_ps(x, limit)) == 0xf;
    flip(x, by) _mm_xor_ps(x, _mm_castsi128_ps(_mm_slli_epi32::<31>(_mm_castps_si128(by))));
}
