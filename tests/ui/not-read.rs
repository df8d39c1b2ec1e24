modyn::modyn!("not-read.urdf");

fn main() {}
