modyn::modyn!("sdf.sdf");

fn main() {}
