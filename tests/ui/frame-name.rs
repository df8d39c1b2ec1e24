modyn::modyn!("frame-name.sdf");

fn main() {}
