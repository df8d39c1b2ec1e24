modyn::modyn!("no-moving-joint.urdf");

fn main() {}
