modyn::modyn!("indefinite-inertia.urdf");

fn main() {}
