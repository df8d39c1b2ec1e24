modyn::modyn!("repeated-element.urdf");

fn main() {}
