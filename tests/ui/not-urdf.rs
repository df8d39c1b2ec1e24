modyn::modyn!("not-urdf.urdf");

fn main() {}
