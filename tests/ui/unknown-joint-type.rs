modyn::modyn!("unknown-joint-type.urdf");

fn main() {}
