macro_rules! forward {
    () => {
        modyn::modyn!("good.urdf", crate = $crate::modyn);
    };
}
forward!();

fn main() {}
