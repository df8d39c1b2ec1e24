modyn::modyn!("good.urdf", bundles = [control: (mass_matrix, jacobain("hand"))]);

modyn::modyn!("good.urdf", bundles = [control: (mass_matrix, jacobian)]);

modyn::modyn!("good.urdf", bundles = [control: (mass_matrix, mass_matrix)]);

modyn::modyn!("good.urdf", bundles = [type: (mass_matrix)]);

modyn::modyn!("good.urdf", bundles = [control: (jacobian("hnd"), impact_dynamics)]);

fn main() {}
