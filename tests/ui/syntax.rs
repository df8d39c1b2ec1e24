modyn::modyn!();
modyn::modyn!(good);
modyn::modyn!(good.urdf);
modyn::modyn!(pub "good.urdf");
modyn::modyn!(Robot: "good.urdf");
modyn::modyn!(b"good.urdf");
modyn::modyn!(concat!("good", ".urdf"));

fn main() {}
