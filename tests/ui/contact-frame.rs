modyn::modyn!("contact-frame.urdf");

fn main() {}
