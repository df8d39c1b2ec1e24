modyn::modyn!("good.urdf", fused = [control: (mass_matrix, jacobain("hand"))]);

modyn::modyn!("good.urdf", fused = [control: (mass_matrix, jacobian)]);

modyn::modyn!("good.urdf", fused = [control: (mass_matrix, mass_matrix)]);

modyn::modyn!("good.urdf", fused = [type: (mass_matrix)]);

modyn::modyn!("good.urdf", fused = [control: (jacobian("hnd"), impact_dynamics)]);

fn main() {}
