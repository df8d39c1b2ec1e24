modyn::modyn!("unsupported-joint-type.urdf");

fn main() {}
