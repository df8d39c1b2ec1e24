use modyn::{Robot, functions};

modyn::modyn!(pub Arm = "good.urdf", functions = [forward_dynamics, link_pose]);

/// By the type itself: the import of `Robot` changes nothing.
fn by_type() {
    let _: [f64; 2] = Arm::gravity_torques(&[0.1, 0.2]);
    let _ = Arm::jacobian(&[0.1, 0.2], ArmLink::ALL[0]);
    let _ = Arm::mass_matrix_batch([&[0.1]], [[&mut [0.0]]]);
    let _ = Arm::project_constraints(&[0.1, 0.2], &[0.3, 0.4], (), &modyn::ConstraintSettings::<f64>::DEFAULT);
}

/// Through the trait.
fn by_trait() {
    let _ = <Arm as Robot>::difference(&[0.1, 0.2], &[0.3, 0.4]);
}

/// Code for any robot must ask for what it calls.
fn any<R: Robot>(q: &R::Q<f64>, qd: &R::V<f64>) {
    R::kinetic_energy(q, qd);
}

fn energetic<R: Robot + functions::KineticEnergy>(q: &R::Q<f64>, qd: &R::V<f64>) {
    R::kinetic_energy(q, qd);
}

fn main() {
    energetic::<Arm>(&[0.1, 0.2], &[0.3, 0.4]);
    Arm::forward_dynamics(&[0.1, 0.2], &[0.3, 0.4], &[0.5, 0.6]);
}
