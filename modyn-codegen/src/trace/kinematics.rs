//! Kinematic quantities: of one link, `frame` its index in the model's frames, and of all together.
//!
//! A pose is nine numbers of the rotation by rows, then three of the translation; a twist or a
//! momentum is three angular numbers, then three linear ones; columns stand one after another.

use modyn_runtime::equations::kinematics::{self, Axes};
use modyn_runtime::equations::{Workspace, dynamics};
use modyn_runtime::spatial::{Momentum, Pose, Twist, Vector3};

use super::Tracer;
use crate::graph::{Expr, Graph};

/// The twelve numbers of a pose.
pub(super) fn numbers(pose: &Pose<Expr>) -> Vec<Expr> {
    [pose.rotation.concat(), pose.translation.to_vec()].concat()
}

/// The pose of which the next twelve inputs are the numbers.
pub(super) fn pose_input(next: &mut usize) -> Pose<Expr> {
    let mut input = || {
        *next += 1;
        Expr::input(*next - 1)
    };
    let rotation = std::array::from_fn(|_| std::array::from_fn(|_| input()));
    Pose { rotation, translation: std::array::from_fn(|_| input()) }
}

impl Tracer<'_> {
    /// The pose in the world of a link from that of its body and its own on the body.
    #[must_use]
    pub fn placed_pose() -> Graph {
        Graph::trace(|| {
            let mut next = 0;
            let [body, own] = std::array::from_fn(|_| pose_input(&mut next));
            numbers(&body.compose(&own))
        })
    }

    /// The pose of a link from `q`.
    #[must_use]
    pub fn link_pose(&self, frame: usize) -> Graph {
        self.trace(|model, [q]| numbers(&kinematics::link_pose(model, frame, &q)))
    }

    /// The velocity of a link from `q`, `qd`.
    #[must_use]
    pub fn link_velocity(&self, frame: usize, axes: Axes) -> Graph {
        self.trace(|model, [q, qd]| {
            let workspace = &mut Workspace::new(model);
            let velocity = kinematics::link_velocity(model, frame, (&q, &qd), axes, workspace);
            velocity.components().to_vec()
        })
    }

    /// The acceleration of a link from `q`, `qd`, `qdd`.
    #[must_use]
    pub fn link_acceleration(&self, frame: usize, axes: Axes) -> Graph {
        self.trace(|model, [q, qd, qdd]| {
            let (motion, workspace) = ((&*q, &*qd, &*qdd), &mut Workspace::new(model));
            let acceleration = kinematics::link_acceleration(model, frame, motion, axes, workspace);
            acceleration.components().to_vec()
        })
    }

    /// The Jacobian of a link from `q`.
    #[must_use]
    pub fn jacobian(&self, frame: usize, axes: Axes) -> Graph {
        self.trace(|model, [q]| {
            let mut columns = vec![Twist::zero(); model.nv];
            let workspace = &mut Workspace::new(model);
            kinematics::jacobian(model, frame, &q, axes, workspace, &mut columns);
            columns.iter().flat_map(Twist::components).collect()
        })
    }

    /// The rate of a link's Jacobian times `qd`, from `q`, `qd`.
    #[must_use]
    pub fn bias_acceleration(&self, frame: usize, axes: Axes) -> Graph {
        self.trace(|model, [q, qd]| {
            let workspace = &mut Workspace::new(model);
            let rate = kinematics::bias_acceleration(model, frame, (&q, &qd), axes, workspace);
            rate.components().to_vec()
        })
    }

    /// The centre of mass from `q`.
    #[must_use]
    pub fn center_of_mass(&self) -> Graph {
        self.trace(|model, [q]| {
            let workspace = &mut Workspace::new(model);
            kinematics::center_of_mass(model, &q, workspace).0.to_vec()
        })
    }

    /// The Jacobian of the centre of mass from `q`.
    #[must_use]
    pub fn center_of_mass_jacobian(&self) -> Graph {
        self.trace(|model, [q]| {
            let mut columns = vec![Vector3::zero(); model.nv];
            let workspace = &mut Workspace::new(model);
            kinematics::center_of_mass_jacobian(model, &q, workspace, &mut columns);
            columns.iter().flat_map(|column| column.0).collect()
        })
    }

    /// The centroidal momentum matrix from `q`.
    #[must_use]
    pub fn centroidal_momentum_matrix(&self) -> Graph {
        self.trace(|model, [q]| {
            let mut columns = vec![Momentum::zero(); model.nv];
            let workspace = &mut Workspace::new(model);
            dynamics::centroidal_momentum_matrix(model, &q, workspace, &mut columns);
            columns.iter().flat_map(Momentum::components).collect()
        })
    }

    /// The momentum about the centre of mass from `q`, `qd`.
    #[must_use]
    pub fn centroidal_momentum(&self) -> Graph {
        self.trace(|model, [q, qd]| {
            let workspace = &mut Workspace::new(model);
            dynamics::centroidal_momentum(model, (&q, &qd), workspace).components().to_vec()
        })
    }
}
