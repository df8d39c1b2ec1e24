modyn::modyn!("mimic-target.urdf");

fn main() {}
