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
    crate = crate::modyn_under_another_name::renamed,
}
modyn::modyn!(Others = "../good.urdf", modules = links, scalar = f64, mimic = independent);
modyn::modyn!(r#Chains = "../good.urdf", modules = chains,);
modyn::modyn!(Mimicking = "../mimic.urdf", mimic = independent);
modyn::modyn!(Unphysical = "../triangle-inequality.urdf", unphysical_inertia = warn);

fn main() {
    let all: f32 = All::forward_dynamics(&[0.0; 2], &[0.0; 2], &[0.0; 2])[0];
    assert!(all > 0.0 || all <= 0.0);
    assert_eq!((TwoLinks::MODULES.len(), Others::MODULES.len(), All::MODULES.len()), (1, 2, 2));
    assert_eq!((Chains::MODULES.len(), Mimicking::NV, Unphysical::NV), (1, 2, 1));
    assert_eq!((All::GRAVITY, Others::GRAVITY[2]), ([0.0, -9.81, 0.001], -9.81));
    assert_eq!((TwoLinks::NAME, TwoLinksJoint::Elbow.name()), ("two links", "elbow"));
}
