modyn::modyn!("xacro.urdf");

fn main() {}
