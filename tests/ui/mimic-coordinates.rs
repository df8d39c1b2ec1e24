modyn::modyn!("mimic-coordinates.urdf");

fn main() {}
