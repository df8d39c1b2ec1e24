modyn::modyn!("sdf-model.sdf");

fn main() {}
