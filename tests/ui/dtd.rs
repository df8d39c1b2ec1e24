modyn::modyn!("dtd.urdf");

fn main() {}
