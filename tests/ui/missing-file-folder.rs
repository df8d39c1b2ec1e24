// A folder is no file.
modyn::modyn!("../ui");

fn main() {}
