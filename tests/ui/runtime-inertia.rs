modyn::modyn!("good.urdf", runtime_inertia = ["base", "hands", "arm", "arm"]);

fn main() {}
