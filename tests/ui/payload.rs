modyn::modyn!("good.urdf", payload = ["base", "hands", "arm", "arm"]);

fn main() {}
