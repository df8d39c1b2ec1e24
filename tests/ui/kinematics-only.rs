modyn::modyn!("kinematics-only.urdf", functions = [forward_dynamics, link_pose]);

fn main() {}
