//! The instruction sets that machine code is made for.

/// The vector instructions that machine code is made for. Those of one architecture are in order,
/// the smallest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum InstructionSet {
    /// SSE2, which every x86-64 processor has: 16 registers of 16 bytes, products and sums rounded
    /// separately.
    Sse2,
    /// AVX2 and FMA: 16 registers of 32 bytes, products fused with sums.
    Avx2,
    /// AVX-512 (F, DQ and VL): 32 registers; 32 bytes of each are used for one state, 64 for many.
    Avx512,
    /// NEON, which every aarch64 processor has: 32 registers of 16 bytes, products fused with sums.
    Neon,
}

impl InstructionSet {
    /// All instruction sets.
    pub const ALL: [Self; 4] = [Self::Sse2, Self::Avx2, Self::Avx512, Self::Neon];

    /// Returns the largest instruction set that this processor has; `None` if machine code is not
    /// made for this system: it is made for x86-64, and for aarch64 except on Windows.
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
        #[cfg(all(target_arch = "aarch64", target_endian = "little", not(windows)))]
        {
            Some(Self::Neon)
        }
        #[cfg(not(any(
            target_arch = "x86_64",
            all(target_arch = "aarch64", target_endian = "little", not(windows))
        )))]
        None
    }

    /// Returns whether this processor has these instructions.
    #[must_use]
    pub fn is_available(self) -> bool {
        Self::detect()
            .is_some_and(|best| self.architecture() == best.architecture() && self <= best)
    }

    /// Returns the instruction sets of this processor, the smallest first.
    pub fn available() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|set| set.is_available())
    }

    /// Returns the architecture, as [`std::env::consts::ARCH`] names it: `x86_64` or `aarch64`.
    #[must_use]
    pub const fn architecture(self) -> &'static str {
        match self {
            Self::Sse2 | Self::Avx2 | Self::Avx512 => "x86_64",
            Self::Neon => "aarch64",
        }
    }

    /// Returns whether products are fused with sums, and rounded once.
    #[must_use]
    pub fn fuses(self) -> bool {
        self != Self::Sse2
    }

    /// Returns the instructions in words; empty for those that every processor of the architecture
    /// has.
    #[cfg(feature = "object")]
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Sse2 | Self::Neon => "",
            Self::Avx2 => "AVX2 and FMA",
            Self::Avx512 => "AVX-512 (F, DQ and VL) and FMA",
        }
    }

    /// Returns the names of the instructions in rustc (`target_feature`), besides those that every
    /// processor of the architecture has.
    #[cfg(feature = "object")]
    pub(crate) fn features(self) -> &'static [&'static str] {
        match self {
            Self::Sse2 | Self::Neon => &[],
            Self::Avx2 => &["avx2", "fma"],
            Self::Avx512 => &["avx512f", "avx512dq", "avx512vl", "fma"],
        }
    }

    /// Returns the vector registers, in the order in which free ones are taken.
    pub(crate) fn registers(self) -> &'static [u8] {
        const REGISTERS: [u8; 32] = [
            0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23,
            24, 25, 26, 27, 28, 29, 30, 31,
        ];
        // Functions keep v8 to v15 for their caller, if they need these.
        const CALLERS_LAST: [u8; 32] = [
            0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31,
            8, 9, 10, 11, 12, 13, 14, 15,
        ];
        match self {
            Self::Sse2 | Self::Avx2 => &REGISTERS[..16],
            Self::Avx512 => &REGISTERS,
            Self::Neon => &CALLERS_LAST,
        }
    }

    /// Returns whether code for one state uses the vectors of programs, for numbers of this size:
    /// registers have four numbers, or there are enough registers for two a vector.
    pub(crate) fn packs(self, size: usize) -> bool {
        self.vector(false) >= 4 * size || self == Self::Neon
    }

    /// Returns the size of a vector in bytes: for one state, or for many.
    pub(crate) fn vector(self, batch: bool) -> usize {
        match self {
            Self::Sse2 | Self::Neon => 16,
            Self::Avx512 if batch => 64,
            Self::Avx2 | Self::Avx512 => 32,
        }
    }
}
