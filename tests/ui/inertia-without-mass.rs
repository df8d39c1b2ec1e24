modyn::modyn!("inertia-without-mass.urdf");

fn main() {}
