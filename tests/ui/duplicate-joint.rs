modyn::modyn!("duplicate-joint.urdf");

fn main() {}
