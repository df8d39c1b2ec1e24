modyn::modyn!("triangle-inequality.urdf");

fn main() {}
