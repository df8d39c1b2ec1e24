modyn::modyn!("sdf.urdf");

fn main() {}
