modyn::modyn!("unknown-child.urdf");

fn main() {}
