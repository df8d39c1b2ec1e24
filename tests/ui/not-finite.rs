modyn::modyn!("not-finite.urdf");

fn main() {}
