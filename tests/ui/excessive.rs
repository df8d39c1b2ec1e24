modyn::modyn!("excessive.urdf");

fn main() {}
