modyn::modyn!("no-link.urdf");

fn main() {}
