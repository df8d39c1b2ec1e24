modyn::modyn!(two_links = "good.urdf");
modyn::modyn!(r#type = "good.urdf");

fn main() {}
