//! The graphs of kinematic quantities: of one link (`link` is its index in the model's links),
//! and of all links.
//!
//! A pose is nine numbers of the rotation by rows, then three of the translation. A twist or a
//! momentum is three linear, then three angular components. Columns follow each other.

use modyn_runtime::equations::{State, Workspace, kinematics};
use modyn_runtime::spatial::Pose;

use super::Tracer;
use crate::graph::{Expr, Graph};

/// Returns the twelve numbers of a pose.
pub(super) fn numbers(pose: &Pose<Expr>) -> Vec<Expr> {
    [pose.rotation.concat(), pose.translation.to_vec()].concat()
}

/// Returns the pose whose numbers are the next twelve inputs.
pub(super) fn pose_input(next: &mut usize) -> Pose<Expr> {
    let mut input = || {
        *next += 1;
        Expr::input(*next - 1)
    };
    let rotation = std::array::from_fn(|_| std::array::from_fn(|_| input()));
    Pose { rotation, translation: std::array::from_fn(|_| input()) }
}

impl Tracer<'_> {
    /// Returns the graph of a link's pose in the world. Inputs: the pose of its body, and the
    /// link's pose on the body.
    #[must_use]
    pub fn placed_pose() -> Graph {
        Graph::trace(|| {
            let mut next = 0;
            let [body, placement] = std::array::from_fn(|_| pose_input(&mut next));
            numbers(&body.compose(&placement))
        })
    }

    /// Returns the graph of the poses of all links: each nine numbers of the rotation by rows,
    /// then three of the translation. Inputs: `q`.
    #[must_use]
    pub fn link_poses(&self) -> Graph {
        self.trace(|model, [q]| {
            let workspace = &mut Workspace::new(model);
            let mut bodies = vec![Pose::identity(); model.bodies.len()];
            let mut poses = vec![Pose::identity(); model.frames.len()];
            kinematics::link_poses(model, &q, workspace, &mut bodies, &mut poses);
            poses.iter().flat_map(numbers).collect()
        })
    }

    /// Returns the graph of a link's pose by the axes of the bodies in the world. Inputs: `q`.
    #[must_use]
    pub fn link_pose_from_world(&self, frame: usize) -> Graph {
        self.trace(|model, [q]| {
            let workspace = &mut Workspace::new(model);
            numbers(&kinematics::link_pose_from_world(model, frame, &q, workspace))
        })
    }

    /// Returns the graph of a link's acceleration in world axes by the accelerations of the bodies.
    /// Inputs: `q`, `qd`, `qdd`.
    #[must_use]
    pub fn link_acceleration_from_world(&self, frame: usize) -> Graph {
        self.trace(|model, [q, qd, qdd]| {
            let state = State { q: &q, qd: &qd };
            let workspace = &mut Workspace::new(model);
            let acceleration = kinematics::link_acceleration_from_world;
            acceleration(model, frame, state, Some(&qdd), workspace).components().to_vec()
        })
    }

    /// Returns the graph of a link's bias acceleration in world axes by the accelerations of the
    /// bodies. Inputs: `q`, `qd`.
    #[must_use]
    pub fn jacobian_dot_qd_from_world(&self, frame: usize) -> Graph {
        self.trace(|model, [q, qd]| {
            let state = State { q: &q, qd: &qd };
            let workspace = &mut Workspace::new(model);
            let acceleration = kinematics::link_acceleration_from_world;
            acceleration(model, frame, state, None, workspace).components().to_vec()
        })
    }
}
