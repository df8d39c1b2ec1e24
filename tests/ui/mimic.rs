modyn::modyn!("mimic.urdf", mimic = refuse);

fn main() {}
