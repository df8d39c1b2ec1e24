// An empty file.
modyn::modyn!("malformed-xml-empty.urdf");

fn main() {}
