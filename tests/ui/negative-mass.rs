modyn::modyn!("negative-mass.urdf");

fn main() {}
