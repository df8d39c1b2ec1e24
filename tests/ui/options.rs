modyn::modyn! {
    "good.urdf",
    gravity = [0.0, 9.81],
    gravity = [0.0, 0.0, 0.0],
    modules = chain,
    scalar = "f32",
    base = floating,
    mimic independent,
    unphysical_inertia = ignore,
    colour = red,
    crate = 7,
}
modyn::modyn!("good.urdf", gravity = [0.0, down, 1.0]);
modyn::modyn!("good.urdf", scalar = f32 base = fixed);
modyn::modyn!("good.urdf",, scalar = f32);

fn main() {}
