//! Every option, each of its values.
#![deny(warnings)]

mod modyn_under_another_name {
    pub use modyn as renamed;
}

modyn::modyn! { "../good.urdf" }
modyn::modyn! {
    pub(crate) All = "../good.urdf",
    gravity = [0, -9.81, 1e-3f64],
    modules = [["arm"], ["hand"],],
    scalar = f32,
    base = fixed,
    mimic = refuse,
    unphysical_inertia = error,
    unsupported_forces = warn,
    crate = crate::modyn_under_another_name::renamed,
}
modyn::modyn!(Others = "../good.urdf", modules = links, scalar = f64, mimic = independent);
modyn::modyn!(r#Chains = "../good.urdf", modules = chains,);
modyn::modyn!(Mimicking = "../mimic.urdf", mimic = independent);
modyn::modyn!(Following = "../mimic.urdf", mimic = follow, joint_friction = none);
modyn::modyn!(
    Floating = "../floating.urdf",
    base = floating,
    runtime_gravity = true,
    runtime_inertia = ["hand"],
    payload = ["hand", "arm"],
    functions = all,
    joint_friction = smooth(1e-2),
    rotors = ["elbow": (1e-4, 100)],
);
modyn::modyn!(
    Touching = "../good.urdf",
    contacts = ["tip": point("hand"), "side": surface("arm", [0, 0.1, 0], [0, 0, 1.57],), "mid": point("arm", [1, 0, 0])],
    ground = plane([0, 0, -0.5], [0, 1e-1, 1], friction = 0.5),
);
modyn::modyn!(Level = "../good.urdf", contacts = ["tip": point("hand")], functions = [step], ground = plane);
modyn::modyn!(
    Actuated = "../good.urdf",
    functions = [actuate, step_actuated],
    actuators = [
        "elbow": motor,
        "sh*er": position(20, 0.5, effort = 3, saturation = 4, velocity = 10, delay = 2),
    ],
);
modyn::modyn!(Driven = "../good.urdf", functions = [actuate], actuators = ["*": velocity(1.5,)]);
modyn::modyn!(
    Fused = "../good.urdf",
    functions = [],
    fused = [state: (mass_matrix, jacobian("hand"), brge), "many": batch(bias_forces, link_pose(arm)),],
);
modyn::modyn!(Little = "../good.urdf", functions = [forward_dynamics], joint_friction = coulomb);
modyn::modyn!(More = "../good.urdf", functions = [default, regressor], joint_friction = viscous);
modyn::modyn!(Default = "../good.urdf", functions = default, payload = [], runtime_inertia = [], rotors = []);
modyn::modyn!(Unphysical = "../triangle-inequality.urdf", unphysical_inertia = warn);

/// A robot without constraints and actuators has all other functions.
fn has_all<R: modyn::functions::All + modyn::functions::Batches>() {}

fn main() {
    has_all::<Floating>();
    let all: f32 = All::forward_dynamics(&[0.0; 2], &[0.0; 2], &[0.0; 2])[0];
    assert!(all > 0.0 || all <= 0.0);
    assert_eq!((TwoLinks::MODULES.len(), Others::MODULES.len(), All::MODULES.len()), (1, 2, 2));
    assert_eq!((Chains::MODULES.len(), Mimicking::NV, Unphysical::NV), (1, 2, 1));
    assert_eq!((Following::NV, Floating::NV, Floating::NQ), (1, 8, 9));
    assert_eq!(Floating::ARMATURE[7], 1.0);
    assert_eq!(Floating::VELOCITY_NAMES[6..], ["shoulder", "elbow"]);
    let mut params = FloatingParams::DEFAULT;
    params.set_gravity([0.0, 0.0, -1.62]);
    let hand = params.inertia_of_hand();
    params.set_payload_of_arm(hand).expect("a rigid body");
    assert_eq!((params.payload_of_hand().mass, params.payload_of_arm()), (0.0, hand));
    assert_eq!(FloatingParams::<f64>::default().gravity()[2], -9.81);
    let _ = Floating::forward_dynamics_with(&params, &Floating::NEUTRAL, &[0.0; 8], &[0.0; 8]);
    let _ = (Little::forward_dynamics(&[0.0; 2], &[0.0; 2], &[0.0; 2]), Default::brge(&[0.0; 2]));
    assert_eq!(More::regressor(&[0.0; 2], &[0.0; 2], &[0.0; 2]).len(), More::PARAMETERS.len());
    assert_eq!((All::GRAVITY, Others::GRAVITY[2]), ([0.0, -9.81, 0.001], -9.81));
    let forces = Actuated::actuate(&[0.3, 0.0], &[0.4, 0.0], &[1.0, 2.5], 0.01, &[0.5, 0.2]);
    assert_eq!((forces.tau, forces.act), ([3.0, 2.5], [0.2, 1.0]));
    assert_eq!(Actuated::CONTROL_NAMES, ["shoulder", "elbow"]);
    assert_eq!(Actuated::ACTIVATION_NAMES, ["shoulder_before_2", "shoulder_before_1"]);
    assert_eq!(Driven::actuate(&[0.0; 2], &[0.5, 2.0], &[1.5, 1.0], 0.01, &[]).tau, [1.5, -1.5]);
    assert_eq!(Touching::CONTACT_NAMES, ["tip", "side", "mid"]);
    assert_eq!(TouchingContacts { tip: true, ..TouchingContacts::NONE }.to_array(), [true, false, false]);
    assert_eq!((TwoLinks::NAME, TwoLinksJoint::Elbow.name()), ("two links", "elbow"));
}
