modyn::modyn!("cycle.urdf");

fn main() {}
