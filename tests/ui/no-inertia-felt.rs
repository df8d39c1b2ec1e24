modyn::modyn!("no-inertia-felt.urdf");

fn main() {}
