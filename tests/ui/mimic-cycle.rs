modyn::modyn!("mimic-cycle.urdf");

fn main() {}
