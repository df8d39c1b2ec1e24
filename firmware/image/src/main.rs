//! Runs the compiled robots on a microcontroller, compares every result with the host's bit for bit, and measures the
//! instructions and the stack of each call.
//!
//! Exit codes: 0 success, 1 a result differs, 101 a panic, 102 a fault. The measuring code writes without formatting,
//! so that a panic in the image can only come from the robots.
#![no_std]
#![no_main]

mod arm7_c;
mod machine;
mod measure;

use core::hint::black_box;

use measure::Line;
use semihosting::process::exit;

#[cfg(not(feature = "f32"))]
use robots::double as robots_;
#[cfg(feature = "f32")]
use robots::single as robots_;

#[cfg(feature = "f32")]
type Float = f32;
#[cfg(feature = "f32")]
type Bits = u32;
#[cfg(not(feature = "f32"))]
type Float = f64;
#[cfg(not(feature = "f32"))]
type Bits = u64;

/// A state, and the bits of the host's results there.
struct Case<const N: usize> {
    q: [Bits; N],
    qd: [Bits; N],
    tau: [Bits; N],
    forward: [Bits; N],
    inverse: [Bits; N],
    mass: [[Bits; N]; N],
    solved: [Bits; N],
    numbers: [Bits; 2],
    place: [Bits; 3],
}

mod cases {
    use super::Case;

    #[cfg(feature = "f32")]
    include!(concat!(env!("OUT_DIR"), "/cases_f32.rs"));
    #[cfg(not(feature = "f32"))]
    include!(concat!(env!("OUT_DIR"), "/cases_f64.rs"));
}

fn numbers<const N: usize>(bits: &[Bits; N]) -> [Float; N] {
    bits.map(Float::from_bits)
}

fn bits<const N: usize>(numbers: [Float; N]) -> [Bits; N] {
    numbers.map(Float::to_bits)
}

/// The functions of a robot, each as a function of the image, with a function that runs it.
macro_rules! robot {
    ($name:ident, $robot:ident, $cases:ident) => {
        mod $name {
            use super::robots_::$name::$robot as Robot;
            use super::{Case, Float, bits, black_box, cases, measure, numbers};

            pub const N: usize = Robot::NV;
            type Vector = [Float; N];

            #[inline(never)]
            pub fn forward_dynamics(q: &Vector, qd: &Vector, tau: &Vector) -> Vector {
                Robot::forward_dynamics(q, qd, tau)
            }

            #[inline(never)]
            pub fn inverse_dynamics(q: &Vector, qd: &Vector, qdd: &Vector) -> Vector {
                Robot::inverse_dynamics(q, qd, qdd)
            }

            #[inline(never)]
            pub fn mass_matrix(q: &Vector) -> [Vector; N] {
                Robot::mass_matrix(q)
            }

            #[inline(never)]
            pub fn brge_solve(q: &Vector, rhs: &Vector) -> Vector {
                Robot::brge(q).solve(rhs)
            }

            #[inline(never)]
            pub fn brge_numbers(q: &Vector) -> [Float; 2] {
                let brge = Robot::brge(q);
                let [first, ..] = brge.condition_numbers();
                [brge.log_determinant(), first]
            }

            #[inline(never)]
            pub fn last_link_place(q: &Vector) -> [Float; 3] {
                let [.., last] = Robot::link_poses(q);
                last.translation
            }

            fn agrees(case: &Case<N>) -> bool {
                let (q, qd, tau) = (numbers(&case.q), numbers(&case.qd), numbers(&case.tau));
                bits(forward_dynamics(&q, &qd, &tau)) == case.forward
                    && bits(inverse_dynamics(&q, &qd, &tau)) == case.inverse
                    && mass_matrix(&q).map(bits) == case.mass
                    && bits(brge_solve(&q, &tau)) == case.solved
                    && bits(brge_numbers(&q)) == case.numbers
                    && bits(last_link_place(&q)) == case.place
            }

            /// Returns whether all results equal the host's, and prints the measurements.
            pub fn run() -> bool {
                let cases = black_box(&cases::$cases);
                // Every second state has angles far beyond the fast reduction.
                for (case, name) in cases.iter().zip(["", "_far"].into_iter().cycle()) {
                    let (q, qd, tau) = (numbers(&case.q), numbers(&case.qd), numbers(&case.tau));
                    let report = |function: &str, call: &mut dyn FnMut()| {
                        measure::report(stringify!($name), function, name, call);
                    };
                    report("forward_dynamics", &mut || {
                        black_box(forward_dynamics(black_box(&q), &qd, &tau));
                    });
                    report("inverse_dynamics", &mut || {
                        black_box(inverse_dynamics(black_box(&q), &qd, &tau));
                    });
                    report("mass_matrix", &mut || {
                        black_box(mass_matrix(black_box(&q)));
                    });
                    report("brge_solve", &mut || {
                        black_box(brge_solve(black_box(&q), &tau));
                    });
                    report("brge_numbers", &mut || {
                        black_box(brge_numbers(black_box(&q)));
                    });
                    report("last_link_place", &mut || {
                        black_box(last_link_place(black_box(&q)));
                    });
                }
                cases.iter().all(agrees)
            }
        }
    };
}

robot!(gripper, Gripper, GRIPPER);
robot!(arm7, Arm7, ARM7);
robot!(leg, Leg, LEG);
robot!(legs, Quadruped, LEGS);
robot!(legs_shared, Quadruped, LEGS_SHARED);

/// The same robot over `modyn-runtime` gives the same results.
fn ordinary_agrees() -> bool {
    black_box(&cases::ARM7).iter().all(|case| {
        let (q, qd, tau) = (numbers(&case.q), numbers(&case.qd), numbers(&case.tau));
        bits(robots_::ordinary::Arm7::forward_dynamics(&q, &qd, &tau)) == case.forward
    })
}

/// A robot with run-time parameters accepts them in its own scalar, and refuses an inertia that no rigid body has.
fn loaded_agrees() -> bool {
    use robots_::loaded::{Arm7, Arm7Params};

    black_box(&cases::ARM7).iter().all(|case| {
        let (q, qd, tau) = (numbers(&case.q), numbers(&case.qd), numbers(&case.tau));
        let mut params = black_box(Arm7Params::DEFAULT);
        let described = Arm7::forward_dynamics_with(&params, &q, &qd, &tau);
        let own = params.inertia_of_link7();
        let mut nonsense = own;
        nonsense.mass = black_box(-1.0);
        params.set_gravity(black_box([0.5, -0.25, -1.62]));
        let set = params.set_payload_of_hand(black_box(own)).is_ok()
            && params.set_inertia_of_link7(black_box(own)).is_ok()
            && params.set_payload_of_hand(nonsense).is_err();
        let loaded = Arm7::forward_dynamics_with(&params, &q, &qd, &tau);
        set && bits(loaded) != bits(described)
    })
}

fn main() -> ! {
    #[cfg(feature = "fail")]
    fail();
    measure::prepare();
    let robots =
        [gripper::run(), arm7::run(), leg::run(), legs::run(), legs_shared::run(), arm7_c::run()];
    let good = robots.iter().all(|&good| good) && ordinary_agrees() && loaded_agrees();
    Line::default()
        .text(if good { "all agree" } else { "a result differs from the host's" })
        .print();
    exit(if good { 0 } else { 1 })
}

/// Fails in the way that the command line names, to show that each failure is noticed.
#[cfg(feature = "fail")]
fn fail() {
    let mut buffer = [core::mem::MaybeUninit::uninit(); 64];
    let command = semihosting::sys::arm_compat::sys_get_cmdline_uninit(&mut buffer);
    let command: &[u8] = command.as_deref().unwrap_or_default();
    let asked = |way: &[u8]| command.windows(way.len()).any(|part| part == way);
    if asked(b"panic") {
        panic!("as asked");
    } else if asked(b"fault") {
        machine::fault();
    } else if asked(b"hang") {
        loop {
            core::hint::spin_loop();
        }
    } else if asked(b"wrong") {
        let case = &cases::ARM7[0];
        let mut expected = case.forward;
        expected[3] ^= 1;
        let (q, qd, tau) = (numbers(&case.q), numbers(&case.qd), numbers(&case.tau));
        let agrees = bits(arm7::forward_dynamics(&q, &qd, &tau)) == expected;
        exit(if agrees { 0 } else { 1 });
    }
    exit(2)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(101)
}
