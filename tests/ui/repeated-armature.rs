modyn::modyn!("repeated-armature.urdf");

fn main() {}
