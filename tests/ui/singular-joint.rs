modyn::modyn!("singular-joint.urdf");

fn main() {}
