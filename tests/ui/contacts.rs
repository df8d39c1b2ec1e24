modyn::modyn!("good.urdf", contacts = ["tip": line("hand")]);

modyn::modyn!("good.urdf", contacts = ["tip": point()]);

modyn::modyn!("good.urdf", contacts = ["tip": surface("hand", [0, 0, 1], [0, 0, 0], [1, 2, 3])]);

modyn::modyn!("good.urdf", contacts = ["tip": point("hand", 0.1)]);

modyn::modyn!("good.urdf", contacts = point("hand"));

modyn::modyn!("good.urdf", contacts = ["tip": point("hnd"), "root": surface("base")]);

modyn::modyn!("good.urdf", contacts = ["tip": point("hand"), "tip": point("arm")]);

fn main() {}
