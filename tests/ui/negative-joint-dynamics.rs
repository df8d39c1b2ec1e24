modyn::modyn!("negative-joint-dynamics.urdf");

fn main() {}
