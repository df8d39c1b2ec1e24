//! A chain of 100,000 links, on the stack of a test's thread: its memory is linear in the number of links.

use modyn_runtime::Interpreter;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Inertial, Joint, Link, Model, MovingLink};
use modyn_runtime::spatial::Pose;
use modyn_tests::close::assert_close;
use modyn_tests::counting::measure;
use modyn_tests::quantities::Quantities;
use modyn_tests::random::{State, chain, state};

const LINKS: usize = 100_000;

/// Computes the quantities of linear cost for a chain with this number of links, and returns the bytes that the
/// interpreter holds.
fn run(links: usize) -> isize {
    let model = chain(1, links);
    let frames = model.links().len();
    let State { q, qd, tau, .. } = state(1, &model);
    let (mut interpreter, allocated) = measure(|| Interpreter::<f64>::new(model));
    let rest = vec![0.0; links];
    let (mut qdd, mut back) = (rest.clone(), rest.clone());
    let (mut bias, mut at_rest, mut torques) = (rest.clone(), rest.clone(), rest.clone());
    let mut poses = vec![Pose::identity(); frames];

    let (energies, during) = measure(|| {
        interpreter.forward_dynamics(&q, &qd, &tau, &mut qdd)?;
        interpreter.inverse_dynamics(&q, &qd, &qdd, &mut back)?;
        interpreter.bias_forces(&q, &qd, &mut bias)?;
        interpreter.bias_forces(&q, &rest, &mut at_rest)?;
        interpreter.gravity_torques(&q, &mut torques)?;
        interpreter.link_poses(&q, &mut poses)?;
        Ok::<_, modyn_runtime::ShapeError>([
            interpreter.kinetic_energy(&q, &qd)?,
            interpreter.potential_energy(&q)?,
        ])
    });
    assert_eq!(during.calls, 0, "calls allocate nothing");
    let [kinetic, potential] = energies.expect("the lengths are right");

    assert!(qdd.iter().all(|x| x.is_finite()));
    // Forces add up along the chain, so the residual is small relative to them, not relative to `tau`.
    let scale = bias.iter().fold(0.0, |scale: f64, x| scale.max(x.abs()));
    let small = |x: &[f64]| -> Vec<f64> { x.iter().map(|x| x / scale).collect() };
    assert_close("inverse after forward dynamics", &small(&back), &small(&tau), 1e-10);
    assert_close("bias forces at rest", &at_rest, &torques, 1e-10);
    assert!(kinetic > 0.0 && kinetic.is_finite() && potential.is_finite());
    // The product of 100,000 rotations is still a rotation.
    let tip = poses.last().expect("a frame").rotation;
    let square: f64 = tip[0].iter().map(|x| x * x).sum();
    assert!((square - 1.0).abs() < 1e-10, "{square}");
    assert!(allocated.peak >= allocated.kept);
    allocated.peak
}

#[test]
fn memory_is_linear_in_the_links() {
    let (small, large) = (run(LINKS / 10), run(LINKS));
    assert!(small > 0 && large <= small * 11, "{small} bytes for a tenth of {large}");
}

/// Returns a row of links of 1 kg and 1 m along x, their centres of mass at mid-length, their hinges along y.
fn row(links: usize) -> Model {
    let link = |i: usize| MovingLink {
        name: format!("link{i}"),
        parent: i.checked_sub(1),
        joint: Joint::new(
            format!("joint{i}"),
            JointType::Revolute,
            [0.0, 1.0, 0.0],
            Pose { translation: [if i == 0 { 0.0 } else { 1.0 }, 0.0, 0.0], ..Pose::identity() },
        ),
        inertial: Inertial {
            mass: 1.0,
            center_of_mass: [0.5, 0.0, 0.0],
            inertia: [0.01, 0.0, 0.0, 0.1, 0.0, 0.1],
        },
    };
    let tip = Pose { translation: [1.0, 0.0, 0.0], ..Pose::identity() };
    let tip = Link {
        name: "tip".into(),
        moving_link: Some(links - 1),
        pose: tip,
        inertial: Inertial::default(),
    };
    Model::new("row", [0.0, 0.0, -10.0], (0..links).map(link).collect(), vec![tip])
        .expect("a chain")
}

#[test]
#[allow(clippy::cast_precision_loss)]
fn a_straight_chain_is_as_calculated() {
    let n = LINKS;
    let mut interpreter = Interpreter::<f64>::new(row(n));
    let rest = vec![0.0; n];
    // Joint i holds the weight of the n - i links after it at half their length.
    let holding: Vec<f64> =
        (0..n).map(|i| (n - i) as f64).map(|after| -10.0 * after * after / 2.0).collect();
    assert_close("gravity torques", &interpreter.gravity(&rest), &holding, 1e-12);
    assert_close("bias forces", &interpreter.bias(&rest, &rest), &holding, 1e-12);
    assert_eq!(interpreter.potential(&rest), 0.0);
    assert_eq!(interpreter.poses(&rest)[0].translation, [n as f64, 0.0, 0.0]);

    // The chain rotates as one body about its end at 1 rad/s, and it hangs from its end.
    let mut first = rest.clone();
    first[0] = 1.0;
    let inertia = (0..n).map(|i| 0.1 + (i as f64 + 0.5).powi(2)).sum::<f64>();
    assert_close("energy", &[interpreter.kinetic(&rest, &first)], &[inertia / 2.0], 1e-11);
    first[0] = std::f64::consts::FRAC_PI_2;
    let expected = -10.0 * (n as f64).powi(2) / 2.0;
    assert_close("hanging", &[interpreter.potential(&first)], &[expected], 1e-12);

    // The calculated torques hold the chain at rest, up to rounding: the last link's inertia is 1e-15 of the chain's.
    let qdd = interpreter.qdd(&rest, &rest, &holding);
    assert_close("accelerations", &qdd, &rest, 1e-5);
}
