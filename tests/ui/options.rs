modyn::modyn! {
    "good.urdf",
    gravity = [0.0, 9.81],
    gravity = [0.0, 0.0, 0.0],
    modules = chain,
    scalar = "f32",
    base = flying,
    mimic independent,
    unphysical_inertia = ignore,
    joint_friction = smooth,
    rotors = ["elbow": 1e-4],
    payload = [7],
    functions = [default, forward_kinematics],
    colour = red,
    gravty = runtime,
    crate = 7,
}
modyn::modyn!("good.urdf", gravity = [0.0, down, 1.0]);
modyn::modyn!("good.urdf", gravity = later);
modyn::modyn!("good.urdf", scalar = f32 base = fixed);
modyn::modyn!("good.urdf",, scalar = f32);
modyn::modyn!("good.urdf", joint_friction = sticky);
modyn::modyn!("good.urdf", friction = none);
modyn::modyn!("good.urdf", joint_friction = smooth(slow));
modyn::modyn!("good.urdf", rotors = ["elbow"]);
modyn::modyn!("good.urdf", functions = "all");
modyn::modyn!("good.urdf", functions = [mas_matrix]);
modyn::modyn!("good.urdf", actuators = ["elbow": position(20)]);
modyn::modyn!("good.urdf", actuators = ["elbow": servo(20, 1)]);
modyn::modyn!("good.urdf", actuators = ["elbow": motor(delay = 1.5)]);
modyn::modyn!("good.urdf", actuators = ["elbow": motor(speed = 1)]);
modyn::modyn!("good.urdf", actuators = ["elbow": velocity(-1), "shoulders": motor]);

fn main() {}
