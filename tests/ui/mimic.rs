modyn::modyn!("mimic.urdf");

fn main() {}
