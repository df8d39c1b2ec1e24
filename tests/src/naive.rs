//! The same mechanics a second time, as a textbook has them: world axes, dense Jacobians, the
//! model as it was written. Slow, and sharing nothing with modyn's equations.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::Model;
use modyn_runtime::spatial::Pose;
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Matrix3xX, Rotation3, Unit, Vector3};

/// A robot at a position.
pub struct Naive<'a> {
    model: &'a Model,
    rotations: Vec<Matrix3<f64>>,
    origins: Vec<Vector3<f64>>,
}

/// A link's Jacobians at its centre of mass.
struct Jacobian {
    angular: Matrix3xX<f64>,
    linear: Matrix3xX<f64>,
}

fn matrix(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

impl<'a> Naive<'a> {
    /// Puts the links of `model` where `q` has them.
    #[must_use]
    pub fn new(model: &'a Model, q: &[f64]) -> Self {
        let (mut rotations, mut origins) = (Vec::new(), Vec::new());
        for (link, &q) in model.links().iter().zip(q) {
            let (parent_rotation, parent_origin) = link
                .parent
                .map_or((Matrix3::identity(), Vector3::zeros()), |p| (rotations[p], origins[p]));
            let axis = Vector3::from(link.joint.axis);
            let at_joint = parent_rotation * matrix(link.joint.origin.rotation);
            let origin =
                parent_origin + parent_rotation * Vector3::from(link.joint.origin.translation);
            if link.joint.joint_type == JointType::Prismatic {
                rotations.push(at_joint);
                origins.push(origin + at_joint * axis * q);
            } else {
                let turn = Rotation3::from_axis_angle(&Unit::new_normalize(axis), q);
                rotations.push(at_joint * turn.matrix());
                origins.push(origin);
            }
        }
        Self { model, rotations, origins }
    }

    fn axis(&self, i: usize) -> Vector3<f64> {
        self.rotations[i] * Vector3::from(self.model.links()[i].joint.axis)
    }

    fn is_prismatic(&self, i: usize) -> bool {
        self.model.links()[i].joint.joint_type == JointType::Prismatic
    }

    fn center(&self, i: usize) -> Vector3<f64> {
        let center = self.model.links()[i].inertial.center_of_mass;
        self.origins[i] + self.rotations[i] * Vector3::from(center)
    }

    fn mass(&self, i: usize) -> f64 {
        self.model.links()[i].inertial.mass
    }

    /// About the centre of mass, in world axes.
    fn inertia(&self, i: usize) -> Matrix3<f64> {
        let [xx, xy, xz, yy, yz, zz] = self.model.links()[i].inertial.inertia;
        let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        self.rotations[i] * own * self.rotations[i].transpose()
    }

    fn jacobian(&self, i: usize) -> Jacobian {
        let n = self.model.nv();
        let (mut angular, mut linear) = (Matrix3xX::zeros(n), Matrix3xX::zeros(n));
        let mut at = Some(i);
        while let Some(j) = at {
            let axis = self.axis(j);
            if self.is_prismatic(j) {
                linear.set_column(j, &axis);
            } else {
                angular.set_column(j, &axis);
                linear.set_column(j, &axis.cross(&(self.center(i) - self.origins[j])));
            }
            at = self.model.links()[j].parent;
        }
        Jacobian { angular, linear }
    }

    fn links(&self) -> std::ops::Range<usize> {
        0..self.model.links().len()
    }

    /// The poses of all frames.
    #[must_use]
    pub fn poses(&self) -> Vec<Pose<f64>> {
        let pose = |rotation: Matrix3<f64>, origin: Vector3<f64>| {
            let rotation = Rotation3::from_matrix_unchecked(rotation);
            Isometry3::from_parts(origin.into(), rotation.into()).to_homogeneous()
        };
        let frames = self.model.frames().iter().map(|frame| {
            let own = pose(matrix(frame.pose.rotation), frame.pose.translation.into());
            let world = frame.link.map_or(own, |i| pose(self.rotations[i], self.origins[i]) * own);
            Pose {
                rotation: std::array::from_fn(|i| std::array::from_fn(|j| world[(i, j)])),
                translation: std::array::from_fn(|i| world[(i, 3)]),
            }
        });
        frames.collect()
    }

    /// The GIM, as the sum of J^T M J over the links.
    #[must_use]
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.model.nv(), self.model.nv());
        for i in self.links() {
            let Jacobian { angular, linear } = self.jacobian(i);
            sum += linear.transpose() * &linear * self.mass(i);
            sum += angular.transpose() * self.inertia(i) * &angular;
        }
        sum
    }

    /// The kinetic energy, link by link.
    #[must_use]
    pub fn kinetic_energy(&self, qd: &[f64]) -> f64 {
        let qd = DVector::from_column_slice(qd);
        let energy = |i| {
            let Jacobian { angular, linear } = self.jacobian(i);
            let (omega, v) = (angular * &qd, linear * &qd);
            0.5 * (self.mass(i) * v.dot(&v) + omega.dot(&(self.inertia(i) * omega)))
        };
        self.links().map(energy).sum()
    }

    /// The potential energy, link by link.
    #[must_use]
    pub fn potential_energy(&self) -> f64 {
        let gravity = Vector3::from(self.model.gravity());
        self.links().map(|i| -self.mass(i) * gravity.dot(&self.center(i))).sum()
    }

    /// The joint torques of a motion: each link's Newton and Euler, projected by its Jacobians.
    #[must_use]
    pub fn inverse_dynamics(&self, qd: &[f64], qdd: &[f64]) -> Vec<f64> {
        let gravity = Vector3::from(self.model.gravity());
        let mut tau = DVector::zeros(qd.len());
        // Angular velocity, angular acceleration, acceleration of the origin.
        let mut motions: Vec<[Vector3<f64>; 3]> = Vec::new();
        for (i, link) in self.model.links().iter().enumerate() {
            let (parent, origin) =
                link.parent.map_or(([Vector3::zeros(); 3], Vector3::zeros()), |p| {
                    (motions[p], self.origins[p])
                });
            let [mut omega, mut alpha, mut a] = parent;
            let arm = self.origins[i] - origin;
            a += alpha.cross(&arm) + omega.cross(&omega.cross(&arm));
            let (rate, change) = (self.axis(i) * qd[i], self.axis(i) * qdd[i]);
            if self.is_prismatic(i) {
                a += change + 2.0 * omega.cross(&rate);
            } else {
                alpha += change + omega.cross(&rate);
                omega += rate;
            }
            motions.push([omega, alpha, a]);
            let arm = self.center(i) - self.origins[i];
            let center = a + alpha.cross(&arm) + omega.cross(&omega.cross(&arm));
            let inertia = self.inertia(i);
            let force = (center - gravity) * self.mass(i);
            let moment = inertia * alpha + omega.cross(&(inertia * omega));
            let Jacobian { angular, linear } = self.jacobian(i);
            tau += linear.transpose() * force + angular.transpose() * moment;
        }
        tau.as_slice().to_vec()
    }
}
