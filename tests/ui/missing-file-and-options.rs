modyn::modyn!(two_links = "no-such.urdf", gravity = [0.0, 0.0, 1e400]);

fn main() {}
