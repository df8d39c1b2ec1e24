modyn::modyn!("several-parents.urdf");

fn main() {}
