//! A program that uses few functions of its robots: unused functions cause no warnings.
#![forbid(unsafe_code)]
#![deny(warnings, missing_docs, clippy::pedantic)]

modyn::modyn!("../../../../robots/gripper.urdf");
modyn::modyn!(Private = "../../../../robots/gripper.urdf");
modyn::modyn!(
    Complete = "../../../../robots/mimic_gripper.urdf",
    functions = all,
    runtime_gravity = true,
    runtime_inertia = ["palm"],
    payload = ["palm"],
);

mod included {
    modyn::include_model!(gripper);
}

modyn::include_model!(arm7);

fn main() {
    println!("{:?}", Gripper::gravity_torques(&[0.0; 4]));
}
