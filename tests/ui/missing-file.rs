modyn::modyn!("no-such.urdf");

fn main() {}
