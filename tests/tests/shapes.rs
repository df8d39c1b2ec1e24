//! A wrong length is an error that names the argument, never a panic.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Joint, Model, ModuleTree, MovingLink};
use modyn_runtime::spatial::Pose;
use modyn_runtime::{Interpreter, ModuleMismatch, ShapeError, UpdateError};
use modyn_tests::random::{Random, tree};

const LINKS: usize = 4;
const GOOD: [f64; LINKS] = [0.1; LINKS];
const BAD: [f64; 5] = [0.1; 5];
const WRONG: [usize; 3] = [0, 3, 5];

fn interpreter() -> Interpreter<f64> {
    Interpreter::new(tree(7, LINKS))
}

#[track_caller]
fn assert_shape<T: std::fmt::Debug>(
    result: Result<T, ShapeError>,
    parameter: &str,
    expected: usize,
    found: usize,
) {
    let error = result.expect_err("a wrong length");
    assert_eq!((error.parameter, error.expected, error.found), (parameter, expected, found));
    let message = error.to_string();
    for part in [format!("`{parameter}`"), expected.to_string(), found.to_string()] {
        assert!(message.contains(&part), "{message}");
    }
}

#[test]
fn vectors() {
    let mut r = interpreter();
    for found in WRONG {
        let bad = &BAD[..found];
        let mut out = GOOD;
        assert_shape(r.forward_dynamics(bad, &GOOD, &GOOD, &mut out), "q", LINKS, found);
        assert_shape(r.forward_dynamics(&GOOD, bad, &GOOD, &mut out), "qd", LINKS, found);
        assert_shape(r.forward_dynamics(&GOOD, &GOOD, bad, &mut out), "tau", LINKS, found);
        assert_shape(r.inverse_dynamics(bad, &GOOD, &GOOD, &mut out), "q", LINKS, found);
        assert_shape(r.inverse_dynamics(&GOOD, bad, &GOOD, &mut out), "qd", LINKS, found);
        assert_shape(r.inverse_dynamics(&GOOD, &GOOD, bad, &mut out), "qdd", LINKS, found);
        assert_shape(r.bias_forces(bad, &GOOD, &mut out), "q", LINKS, found);
        assert_shape(r.bias_forces(&GOOD, bad, &mut out), "qd", LINKS, found);
        assert_shape(r.gravity_torques(bad, &mut out), "q", LINKS, found);
        assert_shape(r.mass_matrix(bad, &mut [0.0; LINKS * LINKS]), "q", LINKS, found);
        assert_shape(r.kinetic_energy(bad, &GOOD), "q", LINKS, found);
        assert_shape(r.kinetic_energy(&GOOD, bad), "qd", LINKS, found);
        assert_shape(r.potential_energy(bad), "q", LINKS, found);
        assert_shape(r.brge(bad), "q", LINKS, found);
        assert_shape(r.denoc(bad), "q", LINKS, found);
        let mut poses = vec![Pose::identity(); r.model().links().len()];
        assert_shape(r.link_poses(bad, &mut poses), "q", LINKS, found);
        assert_eq!(out, GOOD, "nothing was written");
    }
}

#[test]
fn results() {
    let mut r = interpreter();
    for found in WRONG {
        let mut bad = vec![0.0; found];
        assert_shape(r.forward_dynamics(&GOOD, &GOOD, &GOOD, &mut bad), "qdd", LINKS, found);
        assert_shape(r.inverse_dynamics(&GOOD, &GOOD, &GOOD, &mut bad), "tau", LINKS, found);
        assert_shape(r.bias_forces(&GOOD, &GOOD, &mut bad), "tau", LINKS, found);
        assert_shape(r.gravity_torques(&GOOD, &mut bad), "tau", LINKS, found);
        assert_shape(r.mass_matrix(&GOOD, &mut bad), "columns", LINKS * LINKS, found);
        let frames = r.model().links().len();
        let mut poses = vec![Pose::identity(); frames + 1 + found];
        assert_shape(r.link_poses(&GOOD, &mut poses), "poses", frames, frames + 1 + found);
    }
}

#[test]
fn factorizations() {
    let r = interpreter();
    let mut brge = r.brge(&GOOD).expect("four numbers");
    for found in WRONG {
        assert_shape(brge.solve(&BAD[..found]), "rhs", LINKS, found);
        assert_shape(brge.solve_in_place(&mut BAD.to_vec()[..found]), "x", LINKS, found);
        let expected = ShapeError::new("q", LINKS, found);
        assert_eq!(brge.update(&r, &BAD[..found]), Err(UpdateError::Shape(expected)));
    }
}

#[test]
fn modules_of_another_model_are_refused() {
    let (star, other) = (tree(7, 5), tree(8, 5));
    let foreign = ModuleTree::chains(&other);
    assert!(!foreign.fits(&star) && foreign.fits(&other));
    assert!(ModuleTree::links(&star).fits(&star) && ModuleTree::chains(&star).fits(&star));
    assert!(!ModuleTree::links(&tree(7, 6)).fits(&star));
    let error = Interpreter::<f64>::with_modules(star.clone(), foreign.clone()).map(drop);
    assert_eq!(error, Err(ModuleMismatch::default()));
    let error = Interpreter::<f64>::new(star.clone()).eliminating_by(&foreign).map(drop);
    assert_eq!(error, Err(ModuleMismatch::default()));
    // A factorization of another robot, and one with other modules.
    let interpreter = Interpreter::<f64>::new(star.clone());
    let mut brge = interpreter.brge(&[0.2; 5]).expect("five numbers");
    let links = ModuleTree::links(&star);
    let by_links = Interpreter::<f64>::with_modules(star, links).expect("its own modules");
    for stranger in [Interpreter::<f64>::new(other), by_links] {
        let error = brge.update(&stranger, &[0.1; 5]);
        assert_eq!(error, Err(UpdateError::Modules(ModuleMismatch::default())));
    }
    let expected = interpreter.brge(&[0.2; 5]).expect("five numbers");
    assert_eq!((brge.u(), brge.d()), (expected.u(), expected.d()));
}

/// Robots with the same numbers of coordinates and links but other joint types have another layout of the
/// factorization.
#[test]
fn factorizations_of_other_joints_are_refused() {
    let joints = [JointType::Spherical, JointType::Revolute];
    let models = [joints, [joints[1], joints[0]]].map(|types| chain(&types));
    let [first, second] = models.map(|model| {
        let links = ModuleTree::links(&model);
        Interpreter::<f64>::with_modules(model, links).expect("its own modules")
    });
    assert_eq!((first.model().nq(), first.modules()), (second.model().nq(), second.modules()));
    let mut q = [0.0, 0.6, 0.0, 0.8, 0.3];
    let mut brge = first.brge(&q).expect("five numbers");
    let before = brge.clone();
    let refused = Err(UpdateError::Modules(ModuleMismatch::default()));
    assert_eq!(brge.update(&second, &q), refused);
    assert_eq!(brge.inverse(), before.inverse(), "nothing was written");
    assert_eq!(brge.solve(&[1.0, 2.0, 3.0, 4.0]), before.solve(&[1.0, 2.0, 3.0, 4.0]));
    // A robot with other inertias has the same layout, so the memory can be used for it.
    let mut other = chain(&joints);
    other = Model::new("other", [0.0; 3], changed_mass(&other, 3.0), Vec::new()).expect("sound");
    let links = ModuleTree::links(&other);
    let other = Interpreter::<f64>::with_modules(other, links).expect("its own modules");
    q[4] = -0.4;
    assert_eq!(brge.update(&other, &q), Ok(()));
    assert_eq!(brge.inverse(), other.brge(&q).expect("five numbers").inverse());
}

/// Returns `model` with the mass of each link multiplied by a factor.
fn changed_mass(model: &Model, times: f64) -> Vec<MovingLink> {
    let mut links = model.moving_links().to_vec();
    links.iter_mut().for_each(|link| link.inertial.mass *= times);
    links
}

/// Returns a chain of joints of these types, in general position.
fn chain(types: &[JointType]) -> Model {
    let mut random = Random::new(5);
    let link = |(i, joint_type): (usize, &JointType)| {
        let origin = Pose { translation: [0.1, -0.2, 0.3], ..Pose::identity() };
        let joint = Joint::new(format!("j{i}"), *joint_type, [0.6, 0.0, -0.8], origin);
        MovingLink {
            name: format!("l{i}"),
            parent: i.checked_sub(1),
            joint,
            inertial: random.inertial(),
        }
    };
    let links = types.iter().enumerate().map(link).collect();
    Model::new("chain", [0.0; 3], links, Vec::new()).expect("sound parts")
}
