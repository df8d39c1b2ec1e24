//! An inertia is refused at run time if and only if a description with this inertia is refused, or has kinematics alone.

use modyn_codegen::diagnostics::Code;
use modyn_codegen::{Builder, joints_without_inertia};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Joint, Link, Model, MovingLink};
use modyn_runtime::{Inertial, Interpreter, Pose};

/// A source of pseudo-random small numbers.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        usize::try_from(self.0 >> 40).unwrap_or(0) % n
    }

    /// Returns one of few directions, so that some axes are parallel; they are oblique, so that rounding errors occur.
    fn axis(&mut self) -> [f64; 3] {
        let (a, b) = (1.0 / 3.0, 2.0 / 3.0);
        [[b, -a, b], [a, b, b], [0.6, 0.0, -0.8]][self.below(3)]
    }

    /// Returns no mass, a point mass, a rod along an axis, or a full body.
    fn inertial(&mut self) -> Inertial {
        let on_axis = self.axis().map(|x| x * 0.2);
        let center_of_mass = [[0.0; 3], on_axis, [0.11, 0.07, -0.13]][self.below(3)];
        let [x, y, z] = self.axis();
        let rod = [1.0 - x * x, -x * y, -x * z, 1.0 - y * y, -y * z, 1.0 - z * z];
        match self.below(4) {
            0 => Inertial::default(),
            1 => Inertial { mass: 1.5, center_of_mass, inertia: [0.0; 6] },
            2 => Inertial { mass: 1.5, center_of_mass, inertia: rod.map(|i| 0.1 * i) },
            _ => Inertial { mass: 1.5, center_of_mass, inertia: [0.1, 0.0, 0.0, 0.2, 0.0, 0.15] },
        }
    }
}

/// Returns a tree with these inertias of its links.
fn tree(seed: u64, inertias: &[Inertial]) -> Model {
    let mut dice = Dice(seed);
    let types =
        [JointType::Revolute, JointType::Revolute, JointType::Prismatic, JointType::Spherical];
    let links = inertias.iter().enumerate().map(|(i, inertial)| {
        let translation = [[0.0; 3], dice.axis().map(|x| x * 0.5)][dice.below(2)];
        let origin = Pose { translation, ..Pose::identity() };
        let joint_type = types[dice.below(4)];
        let joint = Joint::new(format!("joint{i}"), joint_type, dice.axis(), origin);
        MovingLink {
            name: format!("link{i}"),
            parent: i.checked_sub(1),
            joint,
            inertial: *inertial,
        }
    });
    let links: Vec<MovingLink> = links.collect();
    let frame = |(i, link): (usize, &MovingLink)| Link {
        name: link.name.clone(),
        moving_link: Some(i),
        pose: Pose::identity(),
        inertial: link.inertial,
    };
    let frames = links.iter().enumerate().map(frame).collect();
    Model::new("tree", [0.0, 0.0, -9.81], links, frames).expect("sound parts")
}

#[test]
fn at_run_time_as_in_a_description() {
    let full = Inertial {
        mass: 2.0,
        center_of_mass: [0.1, 0.2, 0.3],
        inertia: [0.3, 0.01, 0.02, 0.4, 0.03, 0.35],
    };
    let (mut taken, mut refused) = (0, 0);
    for seed in 0..400 {
        let mut dice = Dice(seed + 1000);
        let count = 1 + dice.below(4);
        let inertias: Vec<Inertial> = (0..count).map(|_| dice.inertial()).collect();
        let model = tree(seed, &inertias);
        let builder = Builder::new().model(model).functions([]);
        let described = match builder.generate() {
            Ok(found) => found.warnings.iter().all(|one| one.code != Code::KinematicsOnly),
            Err(errors) => {
                assert!(errors.iter().all(|error| error.code == Code::SingularJoint), "{errors}");
                false
            }
        };
        // From a robot with full inertias, one link after the other.
        let mut interpreter = Interpreter::<f64>::new(tree(seed, &vec![full; count]));
        let set: Result<Vec<()>, _> =
            (0..count).map(|i| interpreter.set_inertial(i, &inertias[i])).collect();
        assert_eq!(set.is_ok(), described, "seed {seed}: {inertias:?}: {set:?}");
        // A model has the joints that the check of descriptions finds.
        let model = tree(seed, &inertias);
        let found = Interpreter::<f64>::new(model.clone()).joint_without_inertia();
        let massless = |&joint: &usize| inertias[joint] == Inertial::default();
        let expected = joints_without_inertia(&model);
        assert_eq!(found, expected.iter().copied().find(massless), "seed {seed}: {inertias:?}");
        *(if described { &mut taken } else { &mut refused }) += 1;
    }
    assert!(taken > 50 && refused > 50, "{taken} taken, {refused} refused");
}
