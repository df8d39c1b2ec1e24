modyn::modyn!("missing-attribute.urdf");

fn main() {}
