modyn::modyn!("bad-number.urdf");

fn main() {}
