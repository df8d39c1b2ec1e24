modyn::modyn!("malformed-xml.urdf");

fn main() {}
