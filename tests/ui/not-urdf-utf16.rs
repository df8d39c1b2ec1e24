// "Unicode" as some editors save it.
modyn::modyn!("not-urdf-utf16.urdf");

fn main() {}
