//! The arm's functions in C, measured and compared like those in Rust.
//!
//! This file has unsafe code: calls of C functions, which `build.rs` compiles from the text that modyn writes. Each
//! declaration is the header's (`arm7.h`): each pointer is to as many numbers as the array behind the reference has. The
//! functions write to their last argument alone, which no other argument overlaps, and keep no pointer.

use core::hint::black_box;

use crate::{Case, Float, arm7, bits, cases, measure, numbers};

const N: usize = arm7::N;
type Vector = [Float; N];

unsafe extern "C" {
    fn arm7_forward_dynamics(q: *const Float, qd: *const Float, tau: *const Float, out: *mut Float);
    fn arm7_inverse_dynamics(q: *const Float, qd: *const Float, qdd: *const Float, out: *mut Float);
    fn arm7_mass_matrix(q: *const Float, out: *mut Float);
}

#[inline(never)]
pub fn forward_dynamics(q: &Vector, qd: &Vector, tau: &Vector, out: &mut Vector) {
    // SAFETY: as the file's documentation says.
    unsafe { arm7_forward_dynamics(q.as_ptr(), qd.as_ptr(), tau.as_ptr(), out.as_mut_ptr()) }
}

#[inline(never)]
pub fn inverse_dynamics(q: &Vector, qd: &Vector, qdd: &Vector, out: &mut Vector) {
    // SAFETY: as the file's documentation says.
    unsafe { arm7_inverse_dynamics(q.as_ptr(), qd.as_ptr(), qdd.as_ptr(), out.as_mut_ptr()) }
}

#[inline(never)]
pub fn mass_matrix(q: &Vector, out: &mut [Vector; N]) {
    // SAFETY: as the file's documentation says; the columns lie one after the other.
    unsafe { arm7_mass_matrix(q.as_ptr(), out.as_mut_ptr().cast()) }
}

/// Returns whether all results are the host's; prints the measurements.
pub fn run() -> bool {
    let cases = black_box(&cases::ARM7);
    let (mut vector, mut matrix) = ([0.0; N], [[0.0; N]; N]);
    // Every second state has angles far beyond the fast reduction.
    for (case, state) in cases.iter().zip(["", "_far"].into_iter().cycle()) {
        let (q, qd, tau) = (numbers(&case.q), numbers(&case.qd), numbers(&case.tau));
        measure::report("arm7_c", "forward_dynamics", state, &mut || {
            forward_dynamics(black_box(&q), &qd, &tau, black_box(&mut vector));
        });
        measure::report("arm7_c", "inverse_dynamics", state, &mut || {
            inverse_dynamics(black_box(&q), &qd, &tau, black_box(&mut vector));
        });
        measure::report("arm7_c", "mass_matrix", state, &mut || {
            mass_matrix(black_box(&q), black_box(&mut matrix));
        });
    }
    cases.iter().all(|case: &Case<N>| {
        let (q, qd, tau) = (numbers(&case.q), numbers(&case.qd), numbers(&case.tau));
        let (mut forward, mut inverse, mut mass) = ([0.0; N], [0.0; N], [[0.0; N]; N]);
        forward_dynamics(&q, &qd, &tau, &mut forward);
        inverse_dynamics(&q, &qd, &tau, &mut inverse);
        mass_matrix(&q, &mut mass);
        bits(forward) == case.forward
            && bits(inverse) == case.inverse
            && mass.map(bits) == case.mass
    })
}
