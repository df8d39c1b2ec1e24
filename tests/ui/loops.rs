modyn::modyn!("good.urdf", loops = ["a": universal("base", [0, 0, 1], "hand", [0, 0, 0])]);

modyn::modyn!("good.urdf", loops = ["a": spherical("base", [0, 0, 1], "hand", [0, 0, 0], axis = [0, 0, 1])]);

modyn::modyn!("good.urdf", loops = ["a": revolute("base", "hand")]);

modyn::modyn!("good.urdf", loops = ["a": revolute("base", [0, 0, 1], "hand", [0, 0, 0], axes = [0, 0, 1])]);

modyn::modyn!("good.urdf", loops = ["a": prismatic("base", [0, 0, 1], "hnd", [0, 0, 0], axis = [0, 0, 0])]);

fn main() {}
