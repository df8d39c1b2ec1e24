modyn::modyn!("mjcf.urdf");

fn main() {}
