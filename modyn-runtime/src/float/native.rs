//! Operations with instructions on some processors, but without a function in `core`.

pub(super) use crate::lanes::{run_simd_f32, run_simd_f64};

macro_rules! mul_add {
    ($name:ident, $float:ident) => {
        /// Returns a * b + c: fused if there is an instruction, never by a call of a slow function.
        #[inline]
        pub(super) fn $name(a: $float, b: $float, c: $float) -> $float {
            #[cfg(all(feature = "std", any(target_feature = "fma", target_arch = "aarch64")))]
            let fused = $float::mul_add(a, b, c);
            #[cfg(not(all(
                feature = "std",
                any(target_feature = "fma", target_arch = "aarch64")
            )))]
            let fused = a * b + c;
            fused
        }
    };
}

mul_add!(mul_add_f64, f64);
mul_add!(mul_add_f32, f32);

macro_rules! sqrt {
    ($name:ident, $float:ident, $libm:path) => {
        /// Returns the square root, which is correctly rounded: `root` computes the same without an instruction.
        #[inline]
        pub(super) fn $name(x: $float) -> $float {
            // libm uses an instruction if there is one, but on x86 the one that is slow among AVX instructions.
            #[cfg(feature = "std")]
            let root = $float::sqrt(x);
            #[cfg(not(feature = "std"))]
            let root = $libm(x);
            root
        }
    };
}

sqrt!(sqrt_f64, f64, libm::sqrt);
sqrt!(sqrt_f32, f32, libm::sqrtf);
