//! The instruction sets that machine code is made for.

/// The vector instructions of x86-64 that machine code is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum InstructionSet {
    /// SSE2, which every x86-64 processor has: 16 registers of 16 bytes, products and sums rounded separately.
    Sse2,
    /// AVX2 and FMA: 16 registers of 32 bytes, products fused with sums.
    Avx2,
    /// AVX-512 (F, DQ and VL): 32 registers; 32 bytes of each are used for one state, 64 for many.
    Avx512,
}

impl InstructionSet {
    /// All instruction sets, the smallest first.
    pub const ALL: [Self; 3] = [Self::Sse2, Self::Avx2, Self::Avx512];

    /// Returns the largest instruction set that this processor has; `None` if it is not an x86-64 processor.
    #[must_use]
    pub fn detect() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        {
            use std::is_x86_feature_detected as has;
            if has!("avx512f") && has!("avx512dq") && has!("avx512vl") && has!("fma") {
                return Some(Self::Avx512);
            }
            let avx2 = has!("avx2") && has!("fma");
            Some(if avx2 { Self::Avx2 } else { Self::Sse2 })
        }
        #[cfg(not(target_arch = "x86_64"))]
        None
    }

    /// Returns whether products are fused with sums, and rounded once.
    #[must_use]
    pub fn fuses(self) -> bool {
        self != Self::Sse2
    }

    /// Returns the instructions in words; empty for those that every x86-64 processor has.
    #[cfg(feature = "object")]
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Sse2 => "",
            Self::Avx2 => "AVX2 and FMA",
            Self::Avx512 => "AVX-512 (F, DQ and VL) and FMA",
        }
    }

    /// Returns the names of the instructions in rustc (`target_feature`), besides those that every x86-64 processor has.
    #[cfg(feature = "object")]
    pub(crate) fn features(self) -> &'static [&'static str] {
        match self {
            Self::Sse2 => &[],
            Self::Avx2 => &["avx2", "fma"],
            Self::Avx512 => &["avx512f", "avx512dq", "avx512vl", "fma"],
        }
    }

    /// Returns the number of vector registers.
    pub(crate) fn registers(self) -> u8 {
        if self == Self::Avx512 { 32 } else { 16 }
    }

    /// Returns the size of a vector in bytes: for one state, or for many.
    pub(crate) fn vector(self, batch: bool) -> usize {
        match self {
            Self::Sse2 => 16,
            Self::Avx512 if batch => 64,
            Self::Avx2 | Self::Avx512 => 32,
        }
    }
}
