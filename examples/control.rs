//! A controller and an integrator that are written once for any robot. Computed torque moves a 7-joint arm to a
//! posture; then the arm swings freely, and the program prints its energy.
//!
//! `cargo run --release --example control`

use modyn::simulate::{Gains, Reference, State};

modyn::modyn!("robots/arm7.urdf", joint_friction = none);

const DT: f64 = 0.001;

fn main() {
    let goal = [0.4, -0.6, 0.2, -1.5, 0.3, 1.2, -0.5];
    let reference = Reference::<Arm7>::at_rest(goal);
    let gains = Gains { kp: 225.0, kd: 30.0 };
    let mut state = State::<Arm7>::at_rest(Arm7::NEUTRAL);
    println!("computed torque: time (s), distance to the goal (rad)");
    for step in 0..=1000 {
        if step % 200 == 0 {
            println!("  {:.1}  {:.2e}", DT * f64::from(step), distance(&state.q, &goal));
        }
        state = state.runge_kutta_4(DT, |state| {
            let tau = state.computed_torque(&reference, gains);
            Arm7::forward_dynamics(&state.q, &state.qd, &tau)
        });
    }

    println!("let go: time (s), change of energy (J)");
    let energy = |state: &State<Arm7>| {
        Arm7::kinetic_energy(&state.q, &state.qd) + Arm7::potential_energy(&state.q)
    };
    let start = energy(&state);
    for step in 0..=2000 {
        if step % 500 == 0 {
            println!("  {:.1}  {:+.1e}", DT * f64::from(step), energy(&state) - start);
        }
        state = state.runge_kutta_4(DT, |state| {
            Arm7::forward_dynamics(&state.q, &state.qd, &[0.0; Arm7::NV])
        });
    }
}

fn distance(a: &[f64; 7], b: &[f64; 7]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
