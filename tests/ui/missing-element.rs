modyn::modyn!("missing-element.urdf");

fn main() {}
