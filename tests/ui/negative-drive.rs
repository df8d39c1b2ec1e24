modyn::modyn!("negative-drive.urdf");

fn main() {}
