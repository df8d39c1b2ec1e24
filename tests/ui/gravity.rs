modyn::modyn!("good.urdf", gravity = [0.0, 0.0, 1e400]);

fn main() {}
