//! Functions that machine code calls: the reduction of large angles, arctangents and logarithms.
//!
//! Unsafe code: the functions read and write through pointers. Only machine code calls them, which
//! `generate` makes; it passes pointers to `lanes` numbers each. They point into the function's own
//! stack frame, where nothing else refers to, except the pointer to the angles, which may also
//! point to the arguments or constants, where nobody writes. The functions do not unwind: a panic
//! in them would end the process, and they have none.
#![allow(unsafe_code)]

use modyn_runtime::trig_steps;

use crate::real::Real;

/// The calling convention of machine code: System V's on x86-64, on every system, and C's
/// elsewhere.
#[cfg(target_arch = "x86_64")]
type HelperFunction<S> = extern "sysv64" fn(*mut S, *mut S, *const S, u32);
#[cfg(not(target_arch = "x86_64"))]
type HelperFunction<S> = extern "C" fn(*mut S, *mut S, *const S, u32);

/// A function that machine code calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Helper {
    /// Reduces each angle that is too large, and leaves the other reductions unchanged.
    Reduce,
    /// Writes the angle from the x axis to each point.
    Atan2,
    /// Writes the natural logarithm of each number.
    Logarithm,
}

/// The way that machine code calls helpers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Linkage {
    /// At their addresses in this process.
    Addresses(Helpers),
    /// By their distances, which are filled in when all code has its place.
    #[cfg_attr(not(feature = "object"), allow(dead_code))]
    Relative,
}

/// The addresses of the functions for one type of numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Helpers {
    pub reduce: u64,
    pub atan2: u64,
    pub logarithm: u64,
}

impl Helpers {
    /// Returns the address of a function.
    pub fn address(&self, helper: Helper) -> u64 {
        match helper {
            Helper::Reduce => self.reduce,
            Helper::Atan2 => self.atan2,
            Helper::Logarithm => self.logarithm,
        }
    }

    pub fn new<S: Real>() -> Self {
        let address = |helper: HelperFunction<S>| helper as usize as u64;
        Self {
            reduce: address(reduce::<S>),
            atan2: address(atan2::<S>),
            logarithm: address(logarithm::<S>),
        }
    }
}

macro_rules! helpers {
    ($abi:literal) => {
        extern $abi fn reduce<S: Real>(reduced: *mut S, turns: *mut S, angles: *const S, lanes: u32) {
            for lane in 0..lanes as usize {
                // SAFETY: see the header.
                let angle = unsafe { angles.add(lane).read_unaligned() };
                // `<` is false for NaN.
                let is_near = modyn_runtime::Scalar::abs(angle) < trig_steps::limit();
                if !is_near {
                    let far = trig_steps::reduce_far(angle);
                    // SAFETY: as above.
                    unsafe {
                        reduced.add(lane).write_unaligned(far[0]);
                        turns.add(lane).write_unaligned(far[1]);
                    }
                }
            }
        }

        extern $abi fn atan2<S: Real>(result: *mut S, y: *mut S, x: *const S, lanes: u32) {
            for lane in 0..lanes as usize {
                // SAFETY: see the header.
                unsafe {
                    let (y, x) = (y.add(lane).read_unaligned(), x.add(lane).read_unaligned());
                    result.add(lane).write_unaligned(modyn_runtime::Scalar::atan2(y, x));
                }
            }
        }

        extern $abi fn logarithm<S: Real>(result: *mut S, x: *mut S, _: *const S, lanes: u32) {
            for lane in 0..lanes as usize {
                // SAFETY: see the header.
                unsafe {
                    let x = x.add(lane).read_unaligned();
                    result.add(lane).write_unaligned(modyn_runtime::Scalar::ln(x));
                }
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
helpers!("sysv64");
#[cfg(not(target_arch = "x86_64"))]
helpers!("C");
