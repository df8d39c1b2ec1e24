// "Unicode" as some editors save it.
modyn::modyn!("not-text.urdf");

fn main() {}
