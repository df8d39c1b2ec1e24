modyn::modyn!("loop-link.urdf");

fn main() {}
