macro_rules! forward {
    () => {
        modyn::modyn!("good.urdf", crate = $crate::modyn);
    };
}
forward!();
modyn::modyn!("good.urdf", joint_friction = smooth(0.0));
modyn::modyn!("good.urdf", rotors = ["elbow": (-1e-4, 100.0), "wrist": (1e-4, 100.0)]);

fn main() {}
