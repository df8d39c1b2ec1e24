//! The joints of a robot in the state vectors of MuJoCo.

use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::conventions::{mujoco, wxyz_from_xyzw, xyzw_from_wxyz};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::Model;

use crate::command::outcome::Failure;

/// A joint of MuJoCo's model.
#[derive(Clone, Debug)]
pub struct TheirJoint {
    /// The name; empty without one.
    pub name: String,
    /// MuJoCo's number of the type: 0 free, 1 ball, 2 slide, 3 hinge.
    pub kind: u64,
    /// The first entries in `qpos` and in `qvel`.
    pub qpos: usize,
    pub qvel: usize,
}

/// The joints of a robot with their places in `qpos` and `qvel`.
pub struct Joints<'a> {
    model: &'a Model,
    /// For each link, the first entries of its joint in `qpos` and `qvel`; `None` for a mimic joint
    /// that MuJoCo's model does not have.
    places: Vec<Option<[usize; 2]>>,
    /// The lengths of `qpos` and `qvel`.
    sizes: [usize; 2],
}

/// Returns MuJoCo's number of a joint's type; `None` for a type that it does not have.
fn kind_of(joint_type: JointType) -> Option<u64> {
    match joint_type {
        JointType::Floating => Some(0),
        JointType::Spherical => Some(1),
        JointType::Prismatic => Some(2),
        JointType::Revolute | JointType::Continuous => Some(3),
        _ => None,
    }
}

impl<'a> Joints<'a> {
    /// Finds the joints of a robot by their names; joints without a name are matched in the order of
    /// the file.
    pub fn find(
        model: &'a Model,
        mut theirs: Vec<TheirJoint>,
        sizes: [usize; 2],
    ) -> Result<Self, Failure> {
        let mut places = Vec::new();
        for (i, link) in model.moving_links().iter().enumerate() {
            let joint = &link.joint;
            let kind = kind_of(joint.joint_type);
            let named = theirs.iter().position(|their| their.name == joint.name);
            let next = || theirs.iter().position(|their| their.name.is_empty());
            match named.or_else(next).filter(|&at| Some(theirs[at].kind) == kind) {
                Some(at) => {
                    let their = theirs.remove(at);
                    places.push(Some([their.qpos, their.qvel]));
                }
                None if model.mimic(i).is_some() => places.push(None),
                None => return Err(differ("MuJoCo's model", "modyn's", &joint.name)),
            }
        }
        match theirs.first() {
            Some(their) => Err(differ("modyn's robot", "MuJoCo's", &their.name)),
            None => Ok(Self { model, places, sizes }),
        }
    }

    /// Returns modyn's coordinates of `qpos`. Mimic joints are where their leaders put them.
    pub fn coordinates(&self, qpos: &[f64]) -> Vec<f64> {
        let mut q = vec![0.0; self.model.nq()];
        for (link, place) in self.places.iter().enumerate() {
            let Some([at, _]) = place.filter(|_| self.model.mimic(link).is_none()) else {
                continue;
            };
            let range = self.model.q_range(link);
            let joint_q = &mut q[range.clone()];
            match (self.model.moving_links()[link].joint.joint_type, &qpos[at..at + range.len()]) {
                (JointType::Floating, &[x, y, z, a, b, c, d]) => {
                    joint_q.copy_from_slice(&mujoco::from_qpos([x, y, z, a, b, c, d]));
                }
                (JointType::Spherical, &[a, b, c, d]) => {
                    joint_q.copy_from_slice(&xyzw_from_wxyz([a, b, c, d]));
                }
                (_, numbers) => joint_q.copy_from_slice(numbers),
            }
        }
        q
    }

    /// Returns `qpos` of modyn's coordinates.
    pub fn qpos(&self, q: &[f64]) -> Vec<f64> {
        let mut qpos = vec![0.0; self.sizes[0]];
        for (link, place) in self.places.iter().enumerate() {
            let Some([at, _]) = *place else { continue };
            let joint_q = &q[self.model.q_range(link)];
            let their = &mut qpos[at..at + joint_q.len()];
            match (self.model.moving_links()[link].joint.joint_type, joint_q) {
                (JointType::Floating, &[x, y, z, a, b, c, d]) => {
                    their.copy_from_slice(&mujoco::to_qpos([x, y, z, a, b, c, d]));
                }
                (JointType::Spherical, &[a, b, c, d]) => {
                    their.copy_from_slice(&wxyz_from_xyzw([a, b, c, d]));
                }
                (_, numbers) => {
                    let mimic = self.model.mimic(link);
                    let [factor, offset] = mimic.map_or([1.0, 0.0], |m| [m.multiplier, m.offset]);
                    their.iter_mut().zip(numbers).for_each(|(x, q)| *x = factor * q + offset);
                }
            }
        }
        qpos
    }

    /// Returns `qvel` of modyn's coordinates and velocities.
    pub fn qvel(&self, q: &[f64], qd: &[f64]) -> Vec<f64> {
        let mut qvel = vec![0.0; self.sizes[1]];
        for (link, place) in self.places.iter().enumerate() {
            let Some([_, at]) = *place else { continue };
            let joint_qd = &qd[self.model.v_range(link)];
            let their = &mut qvel[at..at + joint_qd.len()];
            match (&q[self.model.q_range(link)], joint_qd) {
                (&[x, y, z, a, b, c, d], &[vx, vy, vz, wx, wy, wz]) => {
                    let q = [x, y, z, a, b, c, d];
                    their.copy_from_slice(&mujoco::to_qvel(q, [vx, vy, vz, wx, wy, wz]));
                }
                (_, numbers) => {
                    let factor = self.model.mimic(link).map_or(1.0, |mimic| mimic.multiplier);
                    their.iter_mut().zip(numbers).for_each(|(x, v)| *x = factor * v);
                }
            }
        }
        qvel
    }
}

/// Returns the failure of two models of which one lacks a joint of the other one.
fn differ(without: &str, owner: &str, joint: &str) -> Failure {
    let joint = sanitize_for_display(joint);
    Failure::usage(format!(
        "error: {without} has no joint like {owner} joint `{joint}`: give the joints of the MJCF names"
    ))
}
