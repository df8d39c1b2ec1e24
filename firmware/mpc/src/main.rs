//! Model predictive control of an arm on a microcontroller: the solver and the problem of `examples/optimal-control`. The
//! hand follows a moving pose; the instructions and the stack of a step of the controller are measured.
//!
//! Exit codes: 0 success, 1 the hand is far from its pose, 101 a panic, 102 a fault.
#![no_std]
#![no_main]

#[path = "../../image/src/machine.rs"]
mod machine;
#[path = "../../image/src/measure.rs"]
mod measure;

use core::hint::black_box;

use modyn::Scalar;
use modyn::simulate::State;
use mpc::following::Following;
use mpc::pose_error::pose_error;
use mpc::{Problem, Solver};
use semihosting::process::exit;

use measure::Line;

modyn::modyn! {
    Arm = "../../robots/arm7.urdf",
    joint_friction = none,
    functions = [
        gravity_torques, knot, step_semi_implicit, link_pose, jacobian, integrate, difference,
    ]
}

/// The number of steps of the horizon, of 20 ms.
const STEPS: usize = 30;
/// The posture at the beginning.
const START: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];

/// Returns the posture whose hand pose is followed, in a step of the controller.
fn posture(step: u32) -> [f64; 7] {
    let (sin, cos) = Scalar::sin_cos(0.01 * f64::from(step));
    let [a, b, c, d, e, f, g] = START;
    [a + 0.4 * sin, b + 0.2 - 0.2 * cos, c, d + 0.3 * sin, e, f - 0.2 * sin, g]
}

fn main() -> ! {
    measure::prepare();
    let mut problem = Following {
        link: ArmLink::GraspPoint,
        target: Arm::link_pose(&START, ArmLink::GraspPoint),
        posture: START,
        hold: Arm::gravity_torques(&START),
        torque_share: 0.8,
        dt: 0.02,
    };
    let mut state = State::<Arm>::at_rest(START);
    let mut solver = Solver::<Following<Arm>, 7, 7, STEPS>::new(&problem, &state, &problem.hold);
    let mut step = 0;
    let mut largest = 0.0;
    measure::report("mpc", "step", "", &mut || {
        problem.target = Arm::link_pose(&posture(step), ArmLink::GraspPoint);
        solver.advance();
        solver.restart(&problem, &state);
        black_box(solver.iterate(&problem));
        let u = solver.feedback(&problem, 0.0, &state);
        state = problem.step(0, &state, &u).next;
        step += 1;
        let pose = Arm::link_pose(&state.q, ArmLink::GraspPoint);
        let error = pose_error(&pose, &problem.target).iter().map(|e| e * e).sum::<f64>();
        largest = Scalar::max(largest, error);
    });
    let memory = size_of_val(&solver) as u32;
    Line::default().text("memory of the solver ").number(memory).print();
    // In m and rad: the pose moves at 0.2 m/s, and the hand follows it with a delay.
    let error = Scalar::sqrt(largest);
    Line::default().text("largest error, thousandths ").number((1e3 * error) as u32).print();
    let good = step > 100 && error < 0.1;
    Line::default()
        .text(if good { "the hand follows" } else { "the hand does not follow" })
        .print();
    exit(if good { 0 } else { 1 })
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(101)
}
