modyn::modyn!("duplicate-link.urdf");

fn main() {}
