modyn::modyn!("good.urdf", modules = [["arm", "arm"], ["leg"]]);

fn main() {}
