modyn::modyn!("frame-cycle.sdf");

fn main() {}
