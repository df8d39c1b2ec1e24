modyn::modyn!("loop-ends.urdf");

fn main() {}
