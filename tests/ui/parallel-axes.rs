modyn::modyn!("parallel-axes.urdf");

fn main() {}
