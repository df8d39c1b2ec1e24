modyn::modyn!("unknown-parent.urdf");

fn main() {}
