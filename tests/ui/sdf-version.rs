modyn::modyn!("sdf-version.sdf");

fn main() {}
