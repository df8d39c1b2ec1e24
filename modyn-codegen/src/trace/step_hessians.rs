//! The graph of the contracted Hessian of a time step.
//!
//! A semi-implicit Euler step is qd' = qd + h qdd and q' = q (+) h qd'. Multiplied by the cotangent
//! (l_q, l_qd), its Hessian is the Hessian of h (l_qd + h J^T l_q)^T qdd, with the derivative J of
//! (+) by the displacement, and a correction for each rotation and each pose, whose displacements
//! do not commute. For a group of coordinates, let E be the motion of the displacement x = h qd',
//! and P the derivative of (+) by q. Displacements d of q and y of x displace q' by
//!
//! ```text
//! log(E^-1 exp(d) exp(x + y)) = P d + J y + 1/2 y^T (D J) y + 1/2 [P d, J y] + ...
//! ```
//!
//! to second order (Baker, Campbell and Hausdorff). So with the symmetric part S of the derivative
//! of J^T l_q by x, the matrix B of l_q^T [P d, J y], and the derivative W of qd' by q, qd and tau,
//! the correction is
//!
//! ```text
//! h^2 W^T S W + h/2 (B W + (B W)^T)
//! ```
//!
//! where B W has the rows of the group's entries of q.

use std::collections::BTreeMap;

use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::mechanism::coordinates::{CoordinateSpace, Coordinates};

use super::Tracer;
use super::composition::Composition;
use crate::graph::{Graph, Id};
use crate::passes::{jvp, optimize};

/// The variables q, qd and tau, and the pairs of them that a Hessian has.
const Q: usize = 0;
const QD: usize = 1;
const TAU: usize = 2;
const PAIRS: [(usize, usize); 6] = [(Q, Q), (Q, QD), (QD, QD), (Q, TAU), (QD, TAU), (TAU, TAU)];

/// The displacement of a step, with its effects.
struct Displacement {
    /// The coordinates before the step.
    q: Vec<Id>,
    /// h qd'.
    displacement: Vec<Id>,
    parameters: Vec<Id>,
    /// The cotangent of the coordinates.
    cotangent: Vec<Id>,
}

/// The matrices S and B of a group of coordinates, by columns.
struct Curvature {
    quadratic: Vec<Id>,
    bracket: Vec<Id>,
}

impl Tracer<'_> {
    /// Returns the graph of the coordinates and velocities after a semi-implicit Euler step, and of
    /// the gradients and the Hessian of their sum with the cotangent as weights: gradients by the
    /// state and by tau, then second derivatives by state and state, state and tau, tau and tau, by
    /// columns. A state has the entries of q (in tangent space), then the entries of qd. Inputs:
    /// `q`, `qd`, `tau`, the time and the cotangent. The mass matrix is factorized with `layout`.
    #[must_use]
    pub fn step_semi_implicit_hessian(&self, layout: &UduLayout) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let mut all = Composition::new();
        let [q, qd, tau, dt, cotangent] = [nq, nv, nv, 1, 2 * nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let dt = dt[0];
        let (of_q, of_qd) = cotangent.split_at(nv);
        let motion = self.motion(&mut all, layout, [&q, &qd, &tau, &parameters]);
        let change = all.scaled(dt, &motion.qdd);
        let next_qd = all.sums(&qd, &change);
        let displacement = all.scaled(dt, &next_qd);
        let next_q = all.add(&self.integrate(), &[&q, &displacement, &parameters]);
        let moved = Displacement { q, displacement, parameters, cotangent: of_q.to_vec() };
        let inputs = [&moved.q[..], &moved.displacement, of_q, &moved.parameters];
        let transported = all.add(&self.transported(), &inputs);
        let (by_start, by_displacement) = transported.split_at(nv);

        // The weights of qd', and the weights of the accelerations.
        let through_displacement = all.scaled(dt, by_displacement);
        let weights = all.sums(of_qd, &through_displacement);
        let scaled = all.scaled(dt, &weights);
        let gradient = self.weighted_accelerations(&mut all, layout, &motion, &scaled);
        let (by_q, by_qd) = gradient.gradients.split_at(nv);
        let by_q = all.sums(by_q, by_start);
        let by_qd = all.sums(by_qd, &weights);

        let groups: Vec<Vec<usize>> = self
            .column_groups()
            .into_iter()
            .map(|group| group.into_iter().flatten().collect())
            .collect();
        let none = vec![all.constant(0.0); nv * nv];
        let [q_q, q_qd, qd_qd] = gradient.blocks.clone();
        let mut blocks = [q_q, q_qd, qd_qd, gradient.by_q_tau.clone(), none.clone(), none];
        for block in &self.model.coordinates {
            if let CoordinateSpace::Line { .. } = block.space {
                continue;
            }
            let rows = block.v..block.v + block.velocities();
            let accelerations = self.acceleration_rows(&mut all, &motion, &gradient, rows.clone());
            let [by_q, mut by_qd, by_tau] = accelerations.map(|rows| all.scaled(dt, &rows));
            let one = all.constant(1.0);
            for (k, j) in rows.clone().enumerate() {
                let entry = &mut by_qd[j * rows.len() + k];
                *entry = all.sum(one, *entry);
            }
            let curvature = self.curvature(&mut all, block, &moved);
            let rates = [by_q, by_qd, by_tau];
            let correction = Correction { block, groups: &groups, dt, curvature, rates };
            correction.add_to(&mut all, &mut blocks);
        }
        let [q_q, q_qd, qd_qd, q_tau, qd_tau, tau_tau] = blocks;
        let column = |columns: &[Id], j: usize| columns[j * nv..][..nv].to_vec();
        let row = |columns: &[Id], i: usize| -> Vec<Id> {
            (0..nv).map(|j| columns[j * nv + i]).collect()
        };
        let of_state: Vec<Id> = (0..nv)
            .flat_map(|j| [column(&q_q, j), row(&q_qd, j)].concat())
            .chain((0..nv).flat_map(|j| [column(&q_qd, j), column(&qd_qd, j)].concat()))
            .collect();
        let of_tau: Vec<Id> =
            (0..nv).flat_map(|j| [column(&q_tau, j), column(&qd_tau, j)].concat()).collect();
        let gradients = [&by_q[..], &by_qd, &gradient.by_tau].concat();
        all.with_outputs(&[&next_q, &next_qd, &gradients, &of_state, &of_tau, &tau_tau])
    }

    /// Returns the graph of P^T w and J^T w, with the derivatives P and J of displaced coordinates
    /// by the coordinates before and by the displacement. Inputs: `q`, the displacement and the
    /// weights w.
    fn transported(&self) -> Graph {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let mut all = Composition::new();
        let [q, displacement, weights] = [nq, nv, nv].map(|count| all.inputs(count));
        let parameters = all.inputs(self.parameters.len());
        let inputs = [&q[..], &displacement, &parameters];
        let derivatives = all.add(&self.integrate_derivatives(), &inputs);
        let columns = derivatives.chunks(nv.max(1)).map(|column| all.dot(column, &weights));
        let products: Vec<Id> = columns.collect();
        all.with_outputs(&[&products])
    }

    /// Computes the matrices S and B of a rotation or a pose.
    fn curvature(
        &self,
        all: &mut Composition,
        block: &Coordinates<f64>,
        Displacement { q, displacement, parameters, cotangent }: &Displacement,
    ) -> Curvature {
        let nq = self.model.nq;
        let nv = self.model.nv;
        let size = block.velocities();
        let group = block.v..block.v + size;
        let [zero, one, half] = [0.0, 1.0, 0.5].map(|x| all.constant(x));

        // The derivative of J^T l by the displacement.
        let transported = optimize(self.transported());
        let inputs = nq + 2 * nv + parameters.len();
        let mut changes = jvp(&transported, inputs, nq..nq + nv);
        changes.outputs = changes.outputs[nv..][group.clone()].to_vec();
        let along_group = group.clone().flat_map(|j| {
            let mut unit = vec![zero; nv];
            unit[j] = one;
            all.add(&changes, &[q, displacement, cotangent, parameters, &unit])
        });
        let slopes: Vec<Id> = along_group.collect();
        let quadratic: Vec<Id> = (0..size * size)
            .map(|k| {
                let sum = all.sum(slopes[k], slopes[k % size * size + k / size]);
                all.product(half, sum)
            })
            .collect();

        // l^T [x, y] = y^T (l_linear x w + ...) for x with the rotation vector w.
        let derivatives = all.add(&self.integrate_derivatives(), &[q, displacement, parameters]);
        let (by_start, by_displacement) = derivatives.split_at(nv * nv);
        let of_group = |columns: &[Id], j: usize| columns[j * nv..][group.clone()].to_vec();
        let cotangent = &cotangent[group.clone()];
        let weights: Vec<Vec<Id>> = group
            .clone()
            .map(|j| {
                let x = of_group(by_start, j);
                let (linear, angular) = x.split_at(size - 3);
                let (force, moment) = cotangent.split_at(size - 3);
                let turned = all.cross(moment, angular);
                if linear.is_empty() {
                    return turned;
                }
                let moved = all.cross(force, linear);
                [all.cross(force, angular), all.sums(&moved, &turned)].concat()
            })
            .collect();
        let bracket = group.clone().flat_map(|j| {
            let y = of_group(by_displacement, j);
            weights.iter().map(|weights| all.dot(weights, &y)).collect::<Vec<_>>()
        });
        Curvature { quadratic, bracket: bracket.collect() }
    }
}

/// The correction of a Hessian for a rotation or a pose.
struct Correction<'a> {
    block: &'a Coordinates<f64>,
    /// The columns that share the lanes of a pack.
    groups: &'a [Vec<usize>],
    dt: Id,
    curvature: Curvature,
    /// The block's rows of the derivatives of qd' by q, qd and tau.
    rates: [Vec<Id>; 3],
}

impl Correction<'_> {
    /// Adds the correction to the blocks of a Hessian.
    fn add_to(self, all: &mut Composition, blocks: &mut [Vec<Id>; 6]) {
        let Self { block, groups, dt, curvature: Curvature { quadratic, bracket }, rates } = self;
        let size = block.velocities();
        let nv = rates[Q].len() / size;
        let half = all.constant(0.5);
        let square = all.product(dt, dt);
        let half_dt = all.product(half, dt);
        let row = |matrix: &[Id], i: usize| -> Vec<Id> {
            (0..size).map(|k| matrix[k * size + i]).collect()
        };
        // The columns of each group in lanes.
        let packed: [Vec<Vec<Id>>; 3] = rates.each_ref().map(|columns| {
            let pack = |group: &Vec<usize>| {
                let entry = |k: usize| group.iter().map(move |&j| columns[j * size + k]);
                (0..size).map(|k| all.pack(&entry(k).collect::<Vec<_>>())).collect()
            };
            groups.iter().map(pack).collect()
        });
        // A square matrix of the rotation or pose times the rows of a variable.
        let mut times = |factor: Id, matrix: &[Id]| -> [Vec<Id>; 3] {
            let rows: Vec<Vec<Id>> =
                (0..size).map(|i| all.scaled(factor, &row(matrix, i))).collect();
            packed.each_ref().map(|packed| {
                let mut entries = vec![dt; nv * size];
                for (columns, group) in packed.iter().zip(groups) {
                    for (k, row) in rows.iter().enumerate() {
                        let entry = all.dot(row, columns);
                        for (lane, &j) in group.iter().enumerate() {
                            entries[j * size + k] = all.lane(entry, lane);
                        }
                    }
                }
                entries
            })
        };
        let curved = times(square, &quadratic);
        let turned = times(half_dt, &bracket);
        for ((a, b), entries) in PAIRS.into_iter().zip(blocks) {
            for column in 0..nv {
                let height = if a == b { column + 1 } else { nv };
                let mut sums = BTreeMap::new();
                for (rows, group) in packed[a].iter().zip(groups) {
                    if group.iter().any(|&row| row < height) {
                        let sum = all.dot(rows, &curved[b][column * size..][..size]);
                        let lanes = group.iter().enumerate();
                        sums.extend(lanes.map(|(lane, &row)| (row, all.lane(sum, lane))));
                    }
                }
                for (row, mut sum) in sums.into_iter().filter(|&(row, _)| row < height) {
                    let in_group = |entry: usize| entry.checked_sub(block.v).filter(|&k| k < size);
                    if let Some(k) = in_group(row).filter(|_| a == Q) {
                        sum = all.sum(sum, turned[b][column * size + k]);
                    }
                    if let Some(k) = in_group(column).filter(|_| b == Q) {
                        sum = all.sum(sum, turned[a][row * size + k]);
                    }
                    let entry = all.sum(entries[column * nv + row], sum);
                    entries[column * nv + row] = entry;
                    if a == b {
                        entries[row * nv + column] = entry;
                    }
                }
            }
        }
    }
}
