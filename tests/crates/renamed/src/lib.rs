//! A crate of an older edition that depends on `modyn` under another name. Its description is in a folder beside
//! `Cargo.toml`.
//!
//! ```
//! dynamics::modyn!("robots/my-pendulum.urdf", crate = ::dynamics);
//! assert_eq!(MyPendulum::JOINT_NAMES, user_renamed::MyPendulum::JOINT_NAMES);
//! ```
#![deny(warnings)]

dynamics::modyn!("robots/my-pendulum.urdf", crate = ::dynamics);

pub mod inner {
    use dynamics as short;

    short::modyn!(pub Inner = "robots/my-pendulum.urdf", crate = short);
}

#[test]
fn the_nalgebra_calls_are_there() {
    let q = Default::default();
    let tau = dynamics::Nalgebra::<MyPendulum>::gravity_torques::<1, 1>(&q);
    assert_eq!(tau[0], inner::Inner::gravity_torques(&[0.0])[0]);
}
