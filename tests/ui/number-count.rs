modyn::modyn!("number-count.urdf");

fn main() {}
