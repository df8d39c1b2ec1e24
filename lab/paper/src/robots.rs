//! The robots of the studies: robots of `robots/`, and chains and trees of any size.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Inertial, Joint, Link, Model, ModuleTree, MovingLink};
use modyn_runtime::spatial::Pose;

/// Returns the paper's gripper.
#[must_use]
pub fn gripper() -> Model {
    read(include_str!("../../../robots/gripper.urdf"), "gripper.urdf")
}

/// Returns the paper's biped, its supporting foot on the ground.
#[must_use]
pub fn biped() -> Model {
    read(include_str!("../../../robots/biped.urdf"), "biped.urdf")
}

/// The paper's modules of the biped, M1 and M2 of Fig. 7; without them it is one chain.
pub const BIPED_MODULES: [[&str; 3]; 2] =
    [["stance_shank", "stance_thigh", "trunk"], ["swing_thigh", "swing_shank", "swing_foot"]];

/// Returns these modules, for a model of the biped.
///
/// # Panics
///
/// If the model is another one.
#[must_use]
pub fn biped_modules(model: &Model) -> ModuleTree {
    ModuleTree::from_names(model, &BIPED_MODULES.map(Vec::from)).expect("links of the biped")
}

/// Returns a 7-joint arm.
#[must_use]
pub fn arm7() -> Model {
    read(include_str!("../../../robots/arm7.urdf"), "arm7.urdf")
}

fn read(text: &str, name: &str) -> Model {
    let reading = modyn_codegen::read(text, name, &Default::default());
    reading.unwrap_or_else(|errors| panic!("{errors}")).model
}

/// Returns a serial chain of revolute joints.
#[must_use]
pub fn chain(links: usize) -> Model {
    tree(links, |i| i.checked_sub(1))
}

/// Returns branches of equal length on one first link.
#[must_use]
pub fn palm(branches: usize, length: usize) -> Model {
    tree(1 + branches * length, |i| {
        i.checked_sub(1).map(|k| if k % length == 0 { 0 } else { i - 1 })
    })
}

/// Returns a binary tree, depth first, whose branches are chains with this number of links.
#[must_use]
pub fn binary(generations: u32, length: usize) -> Model {
    let mut parents = Vec::new();
    fork(generations, length, None, &mut parents);
    tree(parents.len(), |i| parents[i])
}

fn fork(
    generations: u32,
    length: usize,
    mut parent: Option<usize>,
    parents: &mut Vec<Option<usize>>,
) {
    for _ in 0..length {
        parents.push(parent);
        parent = Some(parents.len() - 1);
    }
    if generations > 1 {
        fork(generations - 1, length, parent, parents);
        fork(generations - 1, length, parent, parents);
    }
}

/// Returns a tree of revolute joints in general position: no angle, offset or component of an inertia is special, so
/// that operations are counted as in published counts.
///
/// # Panics
///
/// If a link does not come after its parent, depth first.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn tree(links: usize, parent: impl Fn(usize) -> Option<usize>) -> Model {
    let (links, frames): (Vec<_>, Vec<_>) = (0..links)
        .map(|i| {
            // Numbers that differ from link to link, similar to those of an arm: 0.3 m and 1 kg.
            let varied = |size: f64, k: u32| size * (1.0 + 0.3 * (i as f64 + f64::from(k)).sin());
            let (sin, cos) = varied(1.2, 0).sin_cos();
            let rotation = [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]];
            let translation = [varied(0.3, 1), varied(0.05, 2), varied(0.04, 3)];
            let origin = Pose { rotation, translation };
            let (x, y, z) = (varied(0.008, 4), varied(0.011, 5), varied(0.012, 6));
            let inertial = Inertial {
                mass: varied(1.0, 7),
                center_of_mass: [varied(0.15, 8), varied(0.02, 9), varied(0.01, 10)],
                inertia: [x, varied(0.001, 11), varied(0.001, 12), y, varied(0.001, 13), z],
            };
            let name = format!("joint{i}");
            let joint = Joint::new(name, JointType::Revolute, [0.0, 0.0, 1.0], origin);
            let name = format!("link{i}");
            let frame =
                Link { name: name.clone(), moving_link: Some(i), pose: Pose::identity(), inertial };
            (MovingLink { name, parent: parent(i), joint, inertial }, frame)
        })
        .unzip();
    Model::new("tree", modyn_runtime::model::DEFAULT_GRAVITY, links, frames)
        .unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// Returns the robot in another unit of mass: its accelerations are the same under torques in that unit.
///
/// # Panics
///
/// Never for a finite factor.
#[must_use]
pub fn in_mass_unit(model: &Model, factor: f64) -> Model {
    let scaled = |inertial: &Inertial| Inertial {
        mass: inertial.mass * factor,
        center_of_mass: inertial.center_of_mass,
        inertia: inertial.inertia.map(|x| x * factor),
    };
    let links = model.moving_links().iter().cloned();
    let links = links.map(|link| MovingLink { inertial: scaled(&link.inertial), ..link }).collect();
    let frames = model.links().iter().cloned();
    let frames = frames.map(|frame| Link { inertial: scaled(&frame.inertial), ..frame }).collect();
    Model::new(model.name(), model.gravity(), links, frames).expect("only masses differ")
}

/// Returns modules of at most `length` links: the maximal chains, divided from their roots on.
///
/// # Panics
///
/// If `length` is 0.
#[must_use]
pub fn pieces(model: &Model, length: usize) -> ModuleTree {
    let name = |i: usize| model.moving_links()[i].name.as_str();
    let chains = ModuleTree::chains(model);
    let list: Vec<Vec<&str>> = (chains.modules().iter())
        .flat_map(|module| {
            let links: Vec<usize> = module.links.clone().collect();
            links.chunks(length).map(|c| c.iter().copied().map(name).collect()).collect::<Vec<_>>()
        })
        .collect();
    ModuleTree::from_names(model, &list).expect("pieces of chains")
}

/// Returns numbers spread evenly over -1..1, the same for each seed (Weyl's sequence).
#[allow(clippy::cast_precision_loss)]
pub fn spread(seed: usize) -> impl Iterator<Item = f64> {
    const STEP: f64 = 0.618_033_988_749_894_9;
    (1..).map(move |k| 2.0 * ((k + 31 * seed * seed + seed) as f64 * STEP).fract() - 1.0)
}

#[cfg(test)]
mod tests {
    use modyn_runtime::Interpreter;

    use super::{arm7, in_mass_unit, pieces};

    #[test]
    fn a_unit_of_mass_changes_forces_alone() {
        let (plain, scaled) = (arm7(), in_mass_unit(&arm7(), 8.0));
        let (q, qd) = ([0.3, -0.5, 0.7, -1.1, 0.2, 0.9, -0.4], [0.5; 7]);
        let [found, expected] = [scaled, plain].map(|model| {
            let mut interpreter = Interpreter::<f64>::new(model);
            let (mut qdd, mut tau) = ([0.0; 7], [0.0; 7]);
            interpreter.forward_dynamics(&q, &qd, &[0.0; 7], &mut qdd).expect("lengths");
            interpreter.bias_forces(&q, &qd, &mut tau).expect("lengths");
            (qdd, tau)
        });
        for i in 0..7 {
            assert!((found.0[i] - expected.0[i]).abs() < 1e-9);
            assert!((found.1[i] - 8.0 * expected.1[i]).abs() < 1e-9);
        }
    }

    #[test]
    fn pieces_are_of_that_length() {
        let lengths = |length: usize| -> Vec<usize> {
            pieces(&arm7(), length).modules().iter().map(|module| module.links.len()).collect()
        };
        assert_eq!(lengths(3), [3, 3, 1]);
        assert_eq!(lengths(7), [7]);
        assert_eq!(lengths(1), [1; 7]);
    }
}
