//! The same mechanics by the textbook: world axes, dense Jacobians, and the model as it was written. It is slow, and
//! shares no code with modyn's equations.

use modyn_runtime::equations::Forces;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{JointFriction, Model, Spring};
use modyn_runtime::spatial::{Pose, Wrench};
use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix3, Matrix3xX, Quaternion, Rotation3, Unit, UnitQuaternion,
    Vector3,
};

/// A robot in one configuration.
pub struct Naive<'a> {
    model: &'a Model,
    rotations: Vec<Matrix3<f64>>,
    origins: Vec<Vector3<f64>>,
    /// For each link, the motions that its joint allows.
    motions: Vec<Vec<Motion>>,
    /// For each link, the coordinates of its joint.
    coordinates: Vec<Vec<f64>>,
}

/// One motion that a joint allows, at unit velocity, in world axes.
struct Motion {
    /// The entry of qd, and the ratio of the motion's velocity to that entry.
    v: usize,
    ratio: f64,
    /// The angular velocity, and the velocity of the link's origin.
    angular: Vector3<f64>,
    linear: Vector3<f64>,
    /// The number of the joint's motions that move these two axes.
    carried_by: usize,
}

/// The Jacobians of a point of a link.
struct Jacobian {
    angular: Matrix3xX<f64>,
    linear: Matrix3xX<f64>,
}

/// The entries of q and qd that belong to a joint.
#[derive(Clone, Copy)]
struct Place {
    q: usize,
    v: usize,
    /// The ratio of the joint's coordinate to q's entry, and the offset.
    ratio: f64,
    offset: f64,
}

fn matrix(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

fn rotation_about(axis: Vector3<f64>, angle: f64) -> Matrix3<f64> {
    *Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle).matrix()
}

/// Returns the rotation of a quaternion x, y, z, w.
fn attitude(q: &[f64]) -> Matrix3<f64> {
    let quaternion = Quaternion::new(q[3], q[0], q[1], q[2]);
    *UnitQuaternion::new_unchecked(quaternion).to_rotation_matrix().matrix()
}

/// Returns two axes of the plane normal to `axis`, and the normal.
fn plane(axis: Vector3<f64>) -> Matrix3<f64> {
    let smallest = Rotation3::rotation_between(&Vector3::z(), &axis);
    *smallest.unwrap_or_else(|| Rotation3::new(Vector3::x() * std::f64::consts::PI)).matrix()
}

/// Returns the entries of the joint of link `i`, through all joints that it follows.
fn place(model: &Model, i: usize) -> Place {
    let links = model.moving_links();
    if let Some(mimic) = links[i].joint.mimic {
        let Place { q, v, ratio, offset } = place(model, mimic.leader);
        let (ratio, offset) = (mimic.multiplier * ratio, mimic.multiplier * offset + mimic.offset);
        return Place { q, v, ratio, offset };
    }
    let before = || links[..i].iter().map(|link| &link.joint).filter(|joint| joint.mimic.is_none());
    let q = before().map(|joint| joint.joint_type.nq()).sum();
    let v = before().map(|joint| joint.joint_type.nv()).sum();
    Place { q, v, ratio: 1.0, offset: 0.0 }
}

impl<'a> Naive<'a> {
    /// Returns the robot at coordinates `q`.
    #[must_use]
    pub fn new(model: &'a Model, q: &[f64]) -> Self {
        let (rotations, origins, motions) = (Vec::new(), Vec::new(), Vec::new());
        let coordinates = Vec::new();
        let mut naive = Self { model, rotations, origins, motions, coordinates };
        for i in naive.links() {
            naive.add(i, q);
        }
        naive
    }

    /// Adds link `i` at coordinates `q`; its parent has been added before.
    fn add(&mut self, i: usize, q: &[f64]) {
        let link = &self.model.moving_links()[i];
        let joint = &link.joint;
        let Place { q: start, v: first, ratio, offset } = place(self.model, i);
        let q: Vec<f64> =
            q[start..start + joint.joint_type.nq()].iter().map(|q| ratio * q + offset).collect();
        let (rotation, origin) = self.pose_of(link.parent);
        let at_joint = rotation * matrix(joint.origin.rotation);
        let origin = origin + rotation * Vector3::from(joint.origin.translation);
        let axis = Vector3::from(joint.axis);
        let second = Vector3::from(joint.second_axis);
        let zero = Vector3::zeros();
        let mut displacement = zero;
        let mut rotated = at_joint;
        // The angular and the linear velocity, and the number of motions before.
        let mut motions = Vec::new();
        match joint.joint_type {
            JointType::Prismatic => {
                displacement = at_joint * axis * q[0];
                motions.push((zero, at_joint * axis, 0));
            }
            JointType::Universal => {
                let between = at_joint * rotation_about(axis, q[0]);
                rotated = between * rotation_about(second, q[1]);
                motions = vec![(at_joint * axis, zero, 0), (between * second, zero, 1)];
            }
            JointType::Planar => {
                let plane = at_joint * plane(axis);
                let [x, y, normal] = [0, 1, 2].map(|k| plane.column(k).into_owned());
                displacement = x * q[0] + y * q[1];
                rotated = at_joint * rotation_about(axis, q[2]);
                motions = vec![(zero, x, 0), (zero, y, 0), (normal, zero, 0)];
            }
            JointType::Spherical => {
                rotated = at_joint * attitude(&q);
                motions.extend(rotated.column_iter().map(|axis| (axis.into_owned(), zero, 3)));
            }
            JointType::Floating => {
                displacement = at_joint * Vector3::new(q[0], q[1], q[2]);
                rotated = at_joint * attitude(&q[3..]);
                motions.extend(rotated.column_iter().map(|axis| (zero, axis.into_owned(), 6)));
                motions.extend(rotated.column_iter().map(|axis| (axis.into_owned(), zero, 6)));
            }
            _ => {
                rotated = at_joint * rotation_about(axis, q[0]);
                motions.push((at_joint * axis, zero, 0));
            }
        }
        self.rotations.push(rotated);
        self.origins.push(origin + displacement);
        let motions = motions.into_iter().enumerate();
        let motions = motions.map(|(k, (angular, linear, carried_by))| Motion {
            v: first + k,
            ratio,
            angular,
            linear,
            carried_by,
        });
        self.motions.push(motions.collect());
        self.coordinates.push(q);
    }

    /// Returns the pose of a link, or of the world.
    fn pose_of(&self, link: Option<usize>) -> (Matrix3<f64>, Vector3<f64>) {
        link.map_or((Matrix3::identity(), Vector3::zeros()), |i| {
            (self.rotations[i], self.origins[i])
        })
    }

    fn center(&self, i: usize) -> Vector3<f64> {
        let center = self.model.moving_links()[i].inertial.center_of_mass;
        self.origins[i] + self.rotations[i] * Vector3::from(center)
    }

    fn mass(&self, i: usize) -> f64 {
        self.model.moving_links()[i].inertial.mass
    }

    /// Returns the inertia about the centre of mass, in world axes.
    fn inertia(&self, i: usize) -> Matrix3<f64> {
        let [xx, xy, xz, yy, yz, zz] = self.model.moving_links()[i].inertial.inertia;
        let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        self.rotations[i] * own * self.rotations[i].transpose()
    }

    /// Returns the Jacobians of the point of link `i` that is at `point` in the world.
    fn jacobian(&self, i: usize, point: Vector3<f64>) -> Jacobian {
        let n = self.model.nv();
        let (mut angular, mut linear) = (Matrix3xX::zeros(n), Matrix3xX::zeros(n));
        let mut at = Some(i);
        while let Some(j) = at {
            for motion in &self.motions[j] {
                let velocity = motion.linear + motion.angular.cross(&(point - self.origins[j]));
                let (mut angular_column, mut linear_column) =
                    (angular.column_mut(motion.v), linear.column_mut(motion.v));
                angular_column += motion.angular * motion.ratio;
                linear_column += velocity * motion.ratio;
            }
            at = self.model.moving_links()[j].parent;
        }
        Jacobian { angular, linear }
    }

    fn links(&self) -> std::ops::Range<usize> {
        0..self.model.moving_links().len()
    }

    /// Returns the poses of all frames.
    #[must_use]
    pub fn poses(&self) -> Vec<Pose<f64>> {
        let pose = |rotation: Matrix3<f64>, origin: Vector3<f64>| {
            let rotation = Rotation3::from_matrix_unchecked(rotation);
            Isometry3::from_parts(origin.into(), rotation.into()).to_homogeneous()
        };
        let frames = self.model.links().iter().map(|link| {
            let own = pose(matrix(link.pose.rotation), link.pose.translation.into());
            let world =
                link.moving_link.map_or(own, |i| pose(self.rotations[i], self.origins[i]) * own);
            Pose {
                rotation: std::array::from_fn(|i| std::array::from_fn(|j| world[(i, j)])),
                translation: std::array::from_fn(|i| world[(i, 3)]),
            }
        });
        frames.collect()
    }

    /// Returns the mass matrix: the sum of J^T M J over the links, and the rotors' part.
    #[must_use]
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        let mut sum = self.rotors();
        for i in self.links() {
            let Jacobian { angular, linear } = self.jacobian(i, self.center(i));
            sum += linear.transpose() * &linear * self.mass(i);
            sum += angular.transpose() * self.inertia(i) * &angular;
        }
        sum
    }

    /// Returns the inertia of all links as one rigid body about their centre of mass, in world axes: the momentum (linear, then
    /// angular) of a twist at the centre of mass.
    #[must_use]
    pub fn centroidal_composite_inertia(&self) -> DMatrix<f64> {
        let mass: f64 = self.links().map(|i| self.mass(i)).sum();
        let moments = self.links().map(|i| self.mass(i) * self.center(i));
        let center = moments.sum::<Vector3<f64>>() / mass;
        let mut sum = DMatrix::zeros(6, 6);
        for i in self.links() {
            let r = self.center(i) - center;
            let about = self.inertia(i)
                + self.mass(i) * (r.norm_squared() * Matrix3::identity() - r * r.transpose());
            let mut rotations = sum.view_mut((3, 3), (3, 3));
            rotations += about;
        }
        sum.view_mut((0, 0), (3, 3)).copy_from(&(mass * Matrix3::identity()));
        sum
    }

    /// Returns the rotors' part of the mass matrix.
    #[must_use]
    pub fn rotors(&self) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.model.nv(), self.model.nv());
        for (link, motions) in self.model.moving_links().iter().zip(&self.motions) {
            for Motion { v, ratio, .. } in motions {
                sum[(*v, *v)] += ratio * ratio * link.joint.dynamics.armature;
            }
        }
        sum
    }

    /// Returns the kinetic energy of the links and the rotors.
    #[must_use]
    pub fn kinetic_energy(&self, qd: &[f64]) -> f64 {
        let qd = DVector::from_column_slice(qd);
        let energy = |i| {
            let Jacobian { angular, linear } = self.jacobian(i, self.center(i));
            let (omega, v) = (angular * &qd, linear * &qd);
            0.5 * (self.mass(i) * v.dot(&v) + omega.dot(&(self.inertia(i) * omega)))
        };
        self.links().map(energy).sum::<f64>() + 0.5 * (self.rotors() * &qd).dot(&qd)
    }

    /// Returns the potential energy of the links and the springs, with compensated weights.
    #[must_use]
    pub fn potential_energy(&self) -> f64 {
        let gravity = Vector3::from(self.model.gravity());
        let weights = self.links().map(|i| -self.mass(i) * gravity.dot(&self.center(i)));
        let springs = self.model.springs().iter().map(|spring| {
            let stretch = self.stretch(spring);
            0.5 * spring.stiffness * stretch.iter().map(|x| x * x).sum::<f64>()
        });
        let carried = self.compensated().map(|(_, weight, center)| weight.dot(&center));
        weights.chain(springs).chain(carried).sum()
    }

    /// Returns for each compensated frame its link, the part of its weight that is compensated, and its centre of mass.
    fn compensated(&self) -> impl Iterator<Item = (usize, Vector3<f64>, Vector3<f64>)> {
        let gravity = Vector3::from(self.model.gravity());
        let frames = self.model.links().iter().zip(self.poses());
        let frames = frames.zip(self.model.gravity_compensation());
        frames.filter_map(move |((frame, pose), factor)| {
            let own = Vector3::from(frame.inertial.center_of_mass);
            let center = Vector3::from(pose.translation) + matrix(pose.rotation) * own;
            Some((frame.moving_link?, gravity * (factor * frame.inertial.mass), center))
        })
    }

    /// Returns the displacement of a spring's joint from the reference, along the joint's motions.
    fn stretch(&self, spring: &Spring) -> Vec<f64> {
        let Spring { link, reference, .. } = spring;
        let (joint, q) = (&self.model.moving_links()[*link].joint, &self.coordinates[*link]);
        let from = match joint.joint_type {
            JointType::Spherical => 0,
            JointType::Floating => 3,
            _ => return q.iter().zip(reference).map(|(q, reference)| q - reference).collect(),
        };
        let [rotation, before] = [q, reference].map(|q| attitude(&q[from..]));
        let turned = Rotation3::from_matrix_unchecked(before.transpose() * rotation).scaled_axis();
        let moved = (0..from).map(|k| q[k] - reference[k]);
        let moved = rotation.transpose() * Vector3::from_iterator(moved.chain([0.0; 3]).take(3));
        moved.iter().take(from).chain(turned.iter()).copied().collect()
    }

    /// Returns the torques that hold the springs.
    fn springs(&self) -> Vec<f64> {
        let mut tau = vec![0.0; self.model.nv()];
        for spring in self.model.springs() {
            let stretch = self.stretch(spring);
            for (Motion { v, ratio, .. }, x) in self.motions[spring.link].iter().zip(stretch) {
                tau[*v] += ratio * spring.stiffness * x;
            }
        }
        tau
    }

    /// Returns the torques of damping and friction.
    #[must_use]
    pub fn dissipation(&self, qd: &[f64]) -> Vec<f64> {
        let mut tau = vec![0.0; qd.len()];
        for (link, motions) in self.model.moving_links().iter().zip(&self.motions) {
            let dynamics = &link.joint.dynamics;
            for Motion { v, ratio, .. } in motions {
                let rate = ratio * qd[*v];
                let sign = if rate == 0.0 { 0.0 } else { rate.signum() };
                tau[*v] += ratio
                    * match self.model.joint_friction() {
                        JointFriction::Viscous => dynamics.damping * rate,
                        JointFriction::Coulomb => {
                            dynamics.damping * rate + dynamics.friction * sign
                        }
                        JointFriction::Smooth(w) => {
                            dynamics.damping * rate + dynamics.friction * rate / rate.hypot(w)
                        }
                        _ => 0.0,
                    };
            }
        }
        tau
    }

    /// Returns the joint torques that are equivalent to external forces.
    #[must_use]
    pub fn external(&self, forces: Forces<'_, f64>) -> Vec<f64> {
        let mut tau = DVector::zeros(self.model.nv());
        let (forces, in_world) = match forces {
            Forces::InLinkAxes(forces) => (forces, false),
            Forces::InWorldAxes(forces) => (forces, true),
        };
        for ((frame, pose), Wrench { moment, force }) in
            self.model.links().iter().zip(self.poses()).zip(forces)
        {
            let Some(link) = frame.moving_link else { continue };
            let axes = if in_world { Matrix3::identity() } else { matrix(pose.rotation) };
            let Jacobian { angular, linear } = self.jacobian(link, pose.translation.into());
            tau += linear.transpose() * (axes * Vector3::from(force.0));
            tau += angular.transpose() * (axes * Vector3::from(moment.0));
        }
        tau.as_slice().to_vec()
    }

    /// Returns the joint torques of a motion: each link's Newton-Euler equations, projected by its Jacobians, the rotors'
    /// part, springs, gravity compensation, damping and friction.
    #[must_use]
    pub fn inverse_dynamics(&self, qd: &[f64], qdd: &[f64]) -> Vec<f64> {
        let gravity = Vector3::from(self.model.gravity());
        let mut tau = DVector::from_vec(self.dissipation(qd));
        tau += DVector::from_vec(self.springs());
        for (link, motions) in self.model.moving_links().iter().zip(&self.motions) {
            let (joint, v) = (&link.joint, motions.first().map_or(0, |motion| motion.v));
            if joint.joint_type == JointType::Floating {
                // The armature of a floating joint is moved by the classical acceleration of its origin.
                let [linear, angular] =
                    [v, v + 3].map(|v| Vector3::from_column_slice(&qd[v..v + 3]));
                let mut force = tau.fixed_rows_mut::<3>(v);
                force += angular.cross(&linear) * joint.dynamics.armature;
            }
        }
        for (link, weight, center) in self.compensated() {
            tau += self.jacobian(link, center).linear.transpose() * weight;
        }
        tau += self.rotors() * DVector::from_column_slice(qdd);
        // Angular velocity, angular acceleration, acceleration of the origin.
        let mut motions: Vec<[Vector3<f64>; 3]> = Vec::new();
        for (i, link) in self.model.moving_links().iter().enumerate() {
            let (parent, origin) =
                link.parent.map_or(([Vector3::zeros(); 3], Vector3::zeros()), |p| {
                    (motions[p], self.origins[p])
                });
            let [omega, mut alpha, mut a] = parent;
            let arm = self.origins[i] - origin;
            a += alpha.cross(&arm) + omega.cross(&omega.cross(&arm));
            // The body that moves each of the joint's axes has this angular velocity.
            let mut angular_velocities = vec![omega];
            for Motion { v, ratio, angular, .. } in &self.motions[i] {
                angular_velocities.push(
                    angular_velocities[angular_velocities.len() - 1] + angular * (ratio * qd[*v]),
                );
            }
            for &Motion { v, ratio, angular, linear, carried_by } in &self.motions[i] {
                let (rate, change) = (ratio * qd[v], ratio * qdd[v]);
                let carrier = angular_velocities[carried_by];
                alpha += angular * change + carrier.cross(&angular) * rate;
                // The vector from the parent changes along the motion and rotates with the parent.
                a += linear * change + (carrier + omega).cross(&linear) * rate;
            }
            let omega = angular_velocities[angular_velocities.len() - 1];
            motions.push([omega, alpha, a]);
            let arm = self.center(i) - self.origins[i];
            let center = a + alpha.cross(&arm) + omega.cross(&omega.cross(&arm));
            let inertia = self.inertia(i);
            let force = (center - gravity) * self.mass(i);
            let moment = inertia * alpha + omega.cross(&(inertia * omega));
            let Jacobian { angular, linear } = self.jacobian(i, self.center(i));
            tau += linear.transpose() * force + angular.transpose() * moment;
        }
        tau.as_slice().to_vec()
    }
}
