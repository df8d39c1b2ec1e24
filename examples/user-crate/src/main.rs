//! A double pendulum that swings freely, and the torques that hold it: `cargo run`.

use modyn::simulate::State;

modyn::modyn!(pub Pendulum = "robots/double_pendulum.urdf");

/// Returns the acceleration of each joint under the torques of its motors.
fn accelerations(q: &[f64; 2], qd: &[f64; 2], torques: &[f64; 2]) -> [f64; 2] {
    Pendulum::forward_dynamics(q, qd, torques)
}

fn main() {
    let (q, rest) = ([0.6, -0.3], [0.0; 2]);
    println!("let go, it accelerates by {:.3?} rad/s^2", accelerations(&q, &rest, &rest));
    println!("torques that hold it: {:.3?} N m", Pendulum::gravity_torques(&q));

    let mut state = State::<Pendulum, f64>::at_rest(q);
    for _ in 0..1000 {
        state = state.runge_kutta_4(0.001, |state| accelerations(&state.q, &state.qd, &rest));
    }
    println!("a second later it is at {:.3?} rad", state.q);
}

#[test]
fn gravity_torques_keep_it_up() {
    let q = [0.6, -0.3];
    let qdd = accelerations(&q, &[0.0; 2], &Pendulum::gravity_torques(&q));
    assert!(qdd.iter().all(|x| x.abs() < 1e-12), "{qdd:?}");
}
