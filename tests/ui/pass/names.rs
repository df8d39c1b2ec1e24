// Robots called as types that the generated text has for itself, or as what it mentions.
mod a {
    modyn::modyn!(pub ForwardDynamicsKernel = "../good.urdf", functions = all);
}
mod b {
    modyn::modyn!(pub ForwardDynamicsSimdTask = "../good.urdf", functions = all, crate = modyn);
}
mod c {
    modyn::modyn!(pub T = "../good.urdf", functions = all, runtime_gravity = true);
}
mod d {
    modyn::modyn!(pub Some = "../good.urdf", functions = all);
}
mod e {
    modyn::modyn!(pub V = "../good.urdf", functions = all);
}

fn main() {
    let zero = &[0.0, 0.0];
    assert_eq!(a::ForwardDynamicsKernel::NV, 2);
    let expected = a::ForwardDynamicsKernel::forward_dynamics(zero, zero, zero);
    assert_eq!(b::ForwardDynamicsSimdTask::forward_dynamics(zero, zero, zero), expected);
    assert_eq!(c::T::forward_dynamics(zero, zero, zero), expected);
    assert_eq!(d::Some::forward_dynamics(zero, zero, zero), expected);
    assert_eq!(e::V::forward_dynamics(zero, zero, zero), expected);
}
