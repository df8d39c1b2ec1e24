modyn::modyn!("several-roots.urdf");

fn main() {}
