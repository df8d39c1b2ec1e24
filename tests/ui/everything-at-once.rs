modyn::modyn!("everything-at-once.urdf");

fn main() {}
