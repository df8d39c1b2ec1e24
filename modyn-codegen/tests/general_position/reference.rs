//! Constrained forward dynamics by independent means: Jacobians from joint axes in world axes, bias accelerations by
//! differences, and the pseudo-inverse from singular values.

use modyn_runtime::Interpreter;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{LoopConstraintKind, Model};
use modyn_runtime::spatial::Pose;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3, Vector6};

use super::mechanisms::matrix;

pub struct Solution {
    pub qdd: Vec<f64>,
    /// For each constraint: force and moment.
    pub wrenches: Vec<[f64; 6]>,
    /// For each constraint: linear and angular residual.
    pub residuals: Vec<[f64; 6]>,
    pub rank: usize,
}

/// A pose in the world frame.
struct Placed {
    axes: Matrix3<f64>,
    origin: Vector3<f64>,
}

impl Placed {
    fn new(pose: &Pose<f64>) -> Self {
        Self { axes: matrix(pose.rotation), origin: pose.translation.into() }
    }
}

pub struct Reference<'a> {
    model: &'a Model,
    interpreter: Interpreter,
}

impl<'a> Reference<'a> {
    pub fn new(model: &'a Model) -> Self {
        Self { model, interpreter: Interpreter::new(model.clone()) }
    }

    fn link(&mut self, q: &[f64], link: Option<usize>) -> Pose<f64> {
        let frames = self.model.links();
        let own = |i| {
            frames.iter().position(|f| {
                f.moving_link == Some(i) && f.name == self.model.moving_links()[i].name
            })
        };
        link.map_or(Pose::identity(), |i| {
            self.interpreter.link_pose(q, own(i).expect("a frame")).expect("a pose")
        })
    }

    /// Returns the moving link of a constraint's frame, and the frame's pose in the world frame.
    fn end(&mut self, q: &[f64], constraint: usize, end: usize) -> (Option<usize>, Placed) {
        let end = self.model.loop_constraints()[constraint].ends[end].clone();
        let frame = &self.model.links()[end.link];
        let link = frame.moving_link;
        let local = frame.pose.compose(&end.pose);
        (link, Placed::new(&self.link(q, link).compose(&local)))
    }

    /// Adds `sign` times the Jacobian of a point on a link, in world axes.
    fn add_jacobian(
        &mut self,
        q: &[f64],
        link: Option<usize>,
        point: Vector3<f64>,
        sign: f64,
        sum: &mut DMatrix<f64>,
    ) {
        let mut at = link;
        while let Some(i) = at {
            let (joint, parent) =
                (self.model.moving_links()[i].joint.clone(), self.model.moving_links()[i].parent);
            let placed = Placed::new(&self.link(q, Some(i)));
            let before = Placed::new(&self.link(q, parent).compose(&joint.origin));
            let column = self.model.v_range(i).start;
            let mut add = |column: usize, angular: Vector3<f64>, linear: Vector3<f64>| {
                for k in 0..3 {
                    sum[(k, column)] += sign * linear[k];
                    sum[(3 + k, column)] += sign * angular[k];
                }
            };
            let axis = before.axes * Vector3::from(joint.axis);
            let lever = point - placed.origin;
            match joint.joint_type {
                JointType::Prismatic => add(column, Vector3::zeros(), axis),
                JointType::Universal => {
                    add(column, axis, axis.cross(&lever));
                    let second = placed.axes * Vector3::from(joint.second_axis);
                    add(column + 1, second, second.cross(&lever));
                }
                _ => add(column, axis, axis.cross(&lever)),
            }
            at = parent;
        }
    }

    /// Returns the Jacobian of the relative twist in the first frame's axes, without the free directions.
    fn jacobian(&mut self, q: &[f64], constraint: usize) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(6, self.model.nv());
        let [(a, first), (b, second)] = [0, 1].map(|end| self.end(q, constraint, end));
        self.add_jacobian(q, a, second.origin, -1.0, &mut jacobian);
        self.add_jacobian(q, b, second.origin, 1.0, &mut jacobian);
        let mut axes = Matrix6::zeros();
        axes.fixed_view_mut::<3, 3>(0, 0).copy_from(&first.axes.transpose());
        axes.fixed_view_mut::<3, 3>(3, 3).copy_from(&first.axes.transpose());
        let axes = self.constrained(constraint) * axes;
        DMatrix::from_column_slice(6, 6, axes.as_slice()) * jacobian
    }

    /// Returns the projection to the constrained part of a twist.
    fn constrained(&self, constraint: usize) -> Matrix6<f64> {
        let mut projection = Matrix6::identity();
        let across = |axis: [f64; 3]| {
            let axis = Vector3::from(axis);
            Matrix3::identity() - axis * axis.transpose()
        };
        let (at, block) = match self.model.loop_constraints()[constraint].kind {
            LoopConstraintKind::Point => (3, Matrix3::zeros()),
            LoopConstraintKind::Rigid => (3, Matrix3::identity()),
            LoopConstraintKind::Revolute(axis) => (3, across(axis)),
            LoopConstraintKind::Prismatic(axis) => (0, across(axis)),
        };
        projection.fixed_view_mut::<3, 3>(at, at).copy_from(&block);
        projection
    }

    pub fn displacement(&mut self, q: &[f64], constraint: usize) -> Vector6<f64> {
        let [(_, first), (_, second)] = [0, 1].map(|end| self.end(q, constraint, end));
        let back = first.axes.transpose();
        let relative = back * second.axes;
        let angular = match self.model.loop_constraints()[constraint].kind {
            LoopConstraintKind::Revolute(axis) => {
                Vector3::from(axis).cross(&(relative * Vector3::from(axis)))
            }
            _ => {
                let skew = (relative - relative.transpose()) * 0.5;
                Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)])
            }
        };
        let linear = back * (second.origin - first.origin);
        let mut both = Vector6::zeros();
        both.fixed_rows_mut::<3>(0).copy_from(&linear);
        both.fixed_rows_mut::<3>(3).copy_from(&angular);
        self.constrained(constraint) * both
    }

    /// Returns the derivative of J qd by time at constant qd, by differences of sixth order.
    fn jacobian_dot_qd(&mut self, q: &[f64], qd: &[f64], constraint: usize) -> DVector<f64> {
        let step = 1e-3;
        let mut sum = DVector::zeros(6);
        for (k, weight) in [(1.0, 45.0), (2.0, -9.0), (3.0, 1.0)] {
            for sign in [1.0, -1.0] {
                let by: Vec<f64> = qd.iter().map(|v| v * sign * k * step).collect();
                let mut there = q.to_vec();
                self.interpreter.integrate(q, &by, &mut there).expect("fits");
                let velocity = self.jacobian(&there, constraint) * DVector::from_column_slice(qd);
                sum += velocity * (sign * weight / (60.0 * step));
            }
        }
        sum
    }

    /// Returns the documented length, from positions in the world frame.
    pub fn length(&mut self, q: &[f64], constraint: usize) -> f64 {
        let [a, b] = [0, 1].map(|end| self.end(q, constraint, end));
        let paths = [a, b].map(|(link, placed)| {
            let mut places = vec![(link, placed.origin)];
            while let Some((Some(i), _)) = places.last().copied() {
                let link = &self.model.moving_links()[i];
                let (parent, origin) = (link.parent, link.joint.origin);
                places.push((parent, Placed::new(&self.link(q, parent).compose(&origin)).origin));
            }
            places
        });
        let mut length = 0.0;
        let shared = |place: &(Option<usize>, Vector3<f64>),
                      other: &[(Option<usize>, Vector3<f64>)]| {
            other.iter().any(|(link, _)| *link == place.0)
        };
        let mut meets = Vec::new();
        for (own, other) in [(&paths[0], &paths[1]), (&paths[1], &paths[0])] {
            let mut at = 0;
            while !shared(&own[at], other) {
                let link = own[at].0.expect("moves");
                let inertial = self.model.moving_links()[link].inertial;
                length += (own[at].1 - Placed::new(&self.link(q, Some(link))).origin).norm();
                if inertial.mass > 0.0 {
                    let [xx, _, _, yy, _, zz] = inertial.inertia;
                    let center = Vector3::from(inertial.center_of_mass).norm_squared();
                    length += (center + (xx + yy + zz) / (2.0 * inertial.mass)).sqrt();
                }
                at += 1;
            }
            meets.push(own[at].1);
        }
        length + (meets[0] - meets[1]).norm()
    }

    /// Returns the accelerations, and the wrenches with the smallest norm (moment / l)^2 + force^2.
    pub fn solve(
        &mut self,
        (q, qd, tau): (&[f64], &[f64], &[f64]),
        (alpha, beta): (f64, f64),
    ) -> Solution {
        let (n, loops) = (self.model.nv(), self.model.loop_constraints().len());
        let velocities = DVector::from_column_slice(qd);
        let (mut jacobian, mut target) = (DMatrix::zeros(6 * loops, n), DVector::zeros(6 * loops));
        let mut scales = DVector::from_element(6 * loops, 1.0);
        for c in 0..loops {
            let own = self.jacobian(q, c);
            let bias = self.jacobian_dot_qd(q, qd, c);
            let gamma = -(bias
                + &own * &velocities * (2.0 * alpha)
                + self.displacement(q, c) * beta.powi(2));
            jacobian.rows_mut(6 * c, 6).copy_from(&own);
            target.rows_mut(6 * c, 6).copy_from(&gamma);
            scales.rows_mut(6 * c + 3, 3).fill(self.length(q, c));
        }
        let mut mass = vec![0.0; n * n];
        self.interpreter.mass_matrix(q, &mut mass).expect("fits");
        let mass = DMatrix::from_column_slice(n, n, &mass).cholesky().expect("positive definite");
        let mut bias = vec![0.0; n];
        self.interpreter.bias_forces(q, qd, &mut bias).expect("fits");
        let force = DVector::from_column_slice(tau) - DVector::from_column_slice(&bias);
        let free = mass.solve(&force);
        let scale = DMatrix::from_diagonal(&scales);
        let half =
            mass.l().solve_lower_triangular(&(&scale * &jacobian).transpose()).expect("regular");
        // (J M^-1 J^T)^+ from the singular values of J L^-T, whose squares are its eigenvalues.
        let (u, values) = right_singular(half);
        let cutoff = 1e-6 * values.max();
        let needed = &scale * (&target - &jacobian * &free);
        let along = u.transpose() * &needed;
        let keep = |f: &dyn Fn(f64, f64) -> f64| {
            let parts = along.iter().zip(values.iter());
            DVector::from_iterator(
                along.len(),
                parts.map(|(&x, &v)| if v > cutoff { f(x, v) } else { 0.0 }),
            )
        };
        let multipliers = &scale * (&u * keep(&|x, v| x / (v * v)));
        let missed = &u * keep(&|x, _| x) - needed;
        let missed = missed.component_div(&scales);
        let qdd = free + mass.solve(&(jacobian.transpose() * &multipliers));
        let six = |all: &DVector<f64>| {
            (0..loops).map(|c| std::array::from_fn(|k| all[6 * c + k])).collect::<Vec<[f64; 6]>>()
        };
        Solution {
            qdd: qdd.as_slice().to_vec(),
            wrenches: six(&multipliers),
            residuals: six(&missed),
            rank: values.iter().filter(|&&v| v > cutoff).count(),
        }
    }
}

/// Returns the right singular vectors, as columns, and the singular values by one-sided Jacobi rotations (Hestenes 1958).
/// nalgebra's vectors of nearly equal values are off by 1e-8.
fn right_singular(mut matrix: DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
    const SWEEPS: usize = 40;
    let n = matrix.ncols();
    let mut vectors = DMatrix::identity(n, n);
    let least = 1e-32 * matrix.norm_squared();
    for _ in 0..SWEEPS {
        for (p, q) in (0..n).flat_map(|q| (0..q).map(move |p| (p, q))) {
            let [a, b] = [p, q].map(|column| matrix.column(column).norm_squared());
            let c = matrix.column(p).dot(&matrix.column(q));
            if c.abs() <= least.max(1e-16 * (a * b).sqrt()) {
                continue;
            }
            let half_cotangent = (b - a) / (2.0 * c);
            let tangent =
                half_cotangent.signum() / (half_cotangent.abs() + half_cotangent.hypot(1.0));
            let cosine = tangent.hypot(1.0).recip();
            for rotated in [&mut matrix, &mut vectors] {
                let [x, y] = [p, q].map(|column| rotated.column(column).into_owned());
                rotated.set_column(p, &((&x - &y * tangent) * cosine));
                rotated.set_column(q, &((&x * tangent + &y) * cosine));
            }
        }
    }
    let values = DVector::from_iterator(n, matrix.column_iter().map(|column| column.norm()));
    (vectors, values)
}
