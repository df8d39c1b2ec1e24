modyn::modyn!("zero-axis.urdf");

fn main() {}
