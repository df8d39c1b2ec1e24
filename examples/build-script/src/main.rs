//! A robot that is compiled by the build script: `cargo run`.

modyn::include_model!(pendulum);

fn main() {
    let (q, qd, qdd) = ([0.6, -0.3], [0.0; 2], [1.0, 0.0]);
    println!("torques of a motion: {:.3?} N m", Pendulum::inverse_dynamics(&q, &qd, &qdd));
}

#[test]
fn at_rest_only_gravity_is_left() {
    let (q, zero) = ([0.6, -0.3], [0.0; 2]);
    let (torques, gravity) =
        (Pendulum::inverse_dynamics(&q, &zero, &zero), Pendulum::gravity_torques(&q));
    assert!(torques.iter().zip(gravity).all(|(a, b)| (a - b).abs() < 1e-12), "{torques:?}");
}
