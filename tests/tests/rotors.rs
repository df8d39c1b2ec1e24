//! Rotors and momentum. A rotor's inertia at its joint (the armature) has no direction in the model and no part in the
//! momentum: the dynamics keep the momentum of the links. A rotor that is described as a link has its part.

use modyn_codegen::{ReadOptions, read};
use modyn_runtime::Interpreter;
use modyn_runtime::model::{Inertial, Model};
use modyn_runtime::spatial::Momentum;
use modyn_tests::close::assert_close;
use modyn_tests::dual::{Tangent, along_velocity, constant};
use modyn_tests::floating::floated;
use modyn_tests::random::{general_zoo, state};

/// Without external forces, the momentum about the centre of mass of a floating robot changes by its weight alone, however
/// its joints are driven: a rotor takes up energy, but no momentum.
#[test]
fn the_dynamics_keep_the_momentum_without_rotors() {
    let base = Inertial {
        mass: 3.0,
        center_of_mass: [0.1, -0.05, 0.02],
        inertia: [0.12, 0.01, -0.02, 0.15, 0.005, 0.11],
    };
    let mut driven = 0;
    for seed in 0..6 {
        // Compensated weights are forces from outside.
        let model = floated(&general_zoo(seed, 7), base)
            .with_gravity([1.0, -2.0, -9.0])
            .and_then(|model| model.with_gravity_compensation(Vec::new()));
        let model = model.expect("finite");
        driven += model.moving_links().iter().filter(|l| l.joint.dynamics.armature > 0.0).count();
        let at = state(seed, &model);
        let mut tau = at.tau.clone();
        tau[..6].fill(0.0);
        let mut qdd = vec![0.0; model.nv()];
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        interpreter.forward_dynamics(&at.q, &at.qd, &tau, &mut qdd).expect("fits");

        // The state with its derivatives by time.
        let mut q = constant(&at.q);
        for (k, &rate) in at.qd.iter().enumerate() {
            let along = along_velocity(&model, &at.q, k);
            q.iter_mut().zip(along).for_each(|(q, along)| q.dx += rate * along.dx);
        }
        let qd: Vec<Tangent<f64>> =
            at.qd.iter().zip(&qdd).map(|(&x, &dx)| Tangent { x, dx }).collect();
        let mut interpreter = Interpreter::<Tangent<f64>>::new(model.clone());
        let momentum = interpreter.centroidal_momentum(&q, &qd).expect("fits");
        let rates = momentum.components().into_iter().map(|x: Tangent<f64>| x.dx);
        let mass: f64 = model.moving_links().iter().map(|link| link.inertial.mass).sum();
        let weight = model.gravity().map(|g| mass * g);
        let expected = [weight, [0.0; 3]].concat();
        assert_close(&format!("seed {seed}"), &rates.collect::<Vec<_>>(), &expected, 1e-8);
    }
    assert!(driven > 6, "{driven}");
}

/// A floating body with an arm, and the arm's rotor on the body if `ratio` is given: a link that turns `ratio` times as far
/// as the arm, about an axis of its own.
fn geared(ratio: Option<f64>) -> Model {
    let link = |name: &str, mass: f64, inertia: [f64; 3]| {
        let [x, y, z] = inertia;
        format!(
            "<link name='{name}'><inertial><mass value='{mass}'/>\
             <inertia ixx='{x}' iyy='{y}' izz='{z}' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let joint = |name: &str, child: &str, rest: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='body'/><child link='{child}'/>{rest}</joint>"
        )
    };
    let mut text = link("body", 2.0, [0.1, 0.2, 0.15]) + &link("arm", 0.5, [0.02, 0.03, 0.01]);
    text += &joint("shoulder", "arm", "<origin xyz='0.1 0 0.2'/><axis xyz='0 1 0'/>");
    if let Some(ratio) = ratio {
        // The axis of the rotor is its axis of symmetry, through its centre of mass.
        text += &link("rotor", 0.1, [2e-4, 1e-4, 1e-4]);
        let mimic = format!(
            "<origin xyz='0 0.05 0' rpy='0 0 0.7'/><axis xyz='1 0 0'/><mimic joint='shoulder' multiplier='{ratio}'/>"
        );
        text += &joint("motor", "rotor", &mimic);
    }
    let options = ReadOptions { base: modyn_codegen::Base::Floating, ..ReadOptions::default() };
    let text = format!("<robot name='geared'>{text}</robot>");
    read(&text, "geared.urdf", &options).unwrap_or_else(|errors| panic!("{errors}")).model
}

#[test]
fn a_rotor_that_is_a_link_has_its_momentum() {
    const RATIO: f64 = 50.0;
    const INERTIA: f64 = 2e-4;
    let q = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.4];
    let of = |ratio| {
        let model = geared(ratio);
        assert_eq!((model.nq(), model.nv()), (8, 7));
        let mut interpreter = Interpreter::<f64>::new(model);
        let mut columns = [Momentum::zero(); 7];
        interpreter.centroidal_momentum_matrix(&q, &mut columns).expect("fits");
        let mut mass = [0.0; 49];
        interpreter.mass_matrix(&q, &mut mass).expect("fits");
        (columns[6].angular.0, mass[48])
    };
    let ((forth, inertia), (back, same), (_, without)) =
        (of(Some(RATIO)), of(Some(-RATIO)), of(None));
    let spin: Vec<f64> = forth.iter().zip(back).map(|(a, b)| 0.5 * (a - b)).collect();
    let (sin, cos) = f64::sin_cos(0.7);
    let expected = [cos, sin, 0.0].map(|along| INERTIA * RATIO * along);
    assert_close("momentum at unit rate", &spin, &expected, 1e-12);
    let armature = INERTIA * RATIO * RATIO;
    assert_close("inertia", &[inertia, same], &[without + armature; 2], 1e-12);
}
