//! Base parameters: a minimal set of combinations of inertial parameters that joint forces depend
//! on.
//!
//! The combinations are found numerically (Gautier 1991, "Numerical calculation of the base
//! inertial parameters of robots"). The regressors at many states are stacked, and the columns are
//! orthogonalized in the order of the parameters. The parameter of a column that depends on earlier
//! columns is grouped with the parameters of those columns. Parents come before children. A
//! parameter that has no effect on a joint of its own is therefore grouped with its parent's
//! parameters, as in Khalil and Dombre 2002, chapter 9. Columns and coefficients are compared in a
//! unit of length of the robot's size, so that the combinations of a robot and of its scaled copy
//! are the same.

use alloc::{format, string::String, vec, vec::Vec};

use super::regressor;
use crate::Portable;
use crate::equations::kinematics::coordinates;
use crate::equations::{Motion, Workspace};
use crate::mechanism::{Dof, Mechanism};
use crate::model::{INERTIAL_PARAMETERS, Model, PARAMETERS_PER_LINK, longest_path};
use crate::spatial::Vector3;

/// The relative length of a column's independent part above which the column counts as independent.
/// Smaller parts cannot be identified, and arise from the rounded angles of parallel axes.
const TOLERANCE: f64 = 1e-7;

/// Coefficients closer than this to 0, 1 or -1 are set to that value.
const SNAP: f64 = 1e-8;

/// A combination of inertial parameters that joint forces depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseParameter {
    name: String,
    /// The parameter that the others are grouped with: 10 times its link plus its index among the
    /// ten. It is also the column of the regressor that belongs to the combination.
    pub kept: usize,
    /// The combination: parameters and their coefficients. The first is [`kept`](Self::kept),
    /// with 1.
    pub combination: Vec<(usize, f64)>,
}

impl BaseParameter {
    /// Returns the combination as text, such as `Izz_forearm + Iyy_hand + m_hand * 0.16`.
    /// Coefficients have six digits.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// A minimal set of combinations of inertial parameters that determines all joint forces.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseParameters {
    /// The combinations, in the order of the parameters they are named after.
    pub parameters: Vec<BaseParameter>,
}

impl BaseParameters {
    /// Returns the base parameters of `model`. They depend neither on its inertias nor on its
    /// limits.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let unit = Unit::new(model);
        let columns = stacked_regressors(model, unit);
        let largest = columns.iter().map(|column| length(column)).fold(0.0, f64::max);
        let mut basis = Basis { directions: Vec::new(), triangle: Vec::new() };
        let mut parameters: Vec<BaseParameter> = Vec::new();
        for (index, column) in columns.into_iter().enumerate() {
            let whole = length(&column);
            if whole <= TOLERANCE * largest {
                continue;
            }
            let (mut parts, rest) = basis.split(column);
            let remaining = length(&rest);
            if remaining > TOLERANCE * whole {
                parts.push(remaining);
                basis.directions.push(rest.into_iter().map(|x| x / remaining).collect());
                basis.triangle.push(parts);
                let combination = vec![(index, 1.0)];
                parameters.push(BaseParameter { name: String::new(), kept: index, combination });
            } else {
                basis.solve(&mut parts);
                for (parameter, part) in parameters.iter_mut().zip(parts) {
                    let part =
                        snap(part) * unit.of_parameter(index) / unit.of_parameter(parameter.kept);
                    if part != 0.0 {
                        parameter.combination.push((index, part));
                    }
                }
            }
        }
        for parameter in &mut parameters {
            parameter.name = name(model, &parameter.combination);
        }
        Self { parameters }
    }

    /// Returns the values of the combinations for the inertias of `model`, which must have the same
    /// tree.
    #[must_use]
    pub fn values(&self, model: &Model) -> Vec<f64> {
        let links = 0..model.moving_links().len();
        let all = links.filter_map(|link| model.inertial_parameters(link));
        self.values_of(&all.flatten().collect::<Vec<f64>>())
    }

    /// Returns the values of the combinations for these inertial parameters, ten for each moving
    /// link.
    #[must_use]
    pub fn values_of(&self, all: &[f64]) -> Vec<f64> {
        let value = |&(index, coefficient): &(usize, f64)| {
            all.get(index).map_or(0.0, |parameter| coefficient * parameter)
        };
        self.parameters.iter().map(|one| one.combination.iter().map(value).sum()).collect()
    }

    /// Returns the columns of the regressor that belong to the combinations: tau is the product of
    /// these columns and the values.
    #[must_use]
    pub fn regressor_columns(&self) -> Vec<usize> {
        self.parameters.iter().map(|parameter| parameter.kept).collect()
    }
}

/// A unit of length, m: the power of two below the length of the longest path between joints, so
/// that scaling is exact.
#[derive(Clone, Copy)]
struct Unit(f64);

impl Unit {
    fn new(model: &Model) -> Self {
        let longest = longest_path(model.moving_links());
        Self(if longest > 0.0 { power_of_two(longest) } else { 1.0 })
    }

    /// Returns the unit of the second moment, divided by the unit of an inertial parameter: of a
    /// mass m^2, of a first moment m.
    fn of_parameter(self, index: usize) -> f64 {
        match index % PARAMETERS_PER_LINK {
            0 => self.0 * self.0,
            1..=3 => self.0,
            _ => 1.0,
        }
    }

    /// Returns the unit of each joint velocity: of a sliding joint m.
    fn of_velocities(self, mechanism: &Mechanism<Portable>) -> Vec<f64> {
        let mut units = vec![1.0; mechanism.nv];
        let slides = |dof: &&Dof<_>| dof.multiplier.is_none() && !dof.axis().is_angular();
        for dof in mechanism.dofs.iter().filter(slides) {
            units[dof.v] = self.0;
        }
        units
    }

    /// Returns the gravity multiplied by a power of two, so that it has 8 to 16 units of length per
    /// s^2.
    fn gravity(self, gravity: Vector3<Portable>) -> Vector3<Portable> {
        let size = gravity.0.iter().fold(0.0, |most: f64, x| most.max(x.0.abs()));
        let factor = if size > 0.0 { 8.0 * self.0 / power_of_two(size) } else { 1.0 };
        Vector3(gravity.0.map(|x| Portable(x.0 * factor)))
    }
}

/// Returns the largest power of two that is not above a positive number.
fn power_of_two(x: f64) -> f64 {
    libm::scalbn(1.0, libm::ilogb(x))
}

/// Returns the columns of the regressors at many states, stacked, in these units. They are computed
/// with portable numbers, the same on every host, since they become part of generated text.
fn stacked_regressors(model: &Model, unit: Unit) -> Vec<Vec<f64>> {
    let mut mechanism = Mechanism::new(model).cast::<Portable>();
    mechanism.gravity = unit.gravity(mechanism.gravity);
    let units = unit.of_velocities(&mechanism);
    let workspace = &mut Workspace::new(&mechanism);
    let nq = model.nq();
    let nv = model.nv();
    let count = PARAMETERS_PER_LINK * model.moving_links().len();
    // Four times as many rows as columns, and for each joint four times as many states as a link
    // has parameters: the rank at random states is then the largest possible.
    let states = (4 * count).div_ceil(nv).max(4 * PARAMETERS_PER_LINK);
    let mut columns = vec![Vec::with_capacity(states * nv); count];
    let zero = Portable(0.0);
    let mut neutral = vec![zero; nq];
    let mut q = vec![zero; nq];
    coordinates::neutral(&mechanism, &mut neutral);
    let mut random = Random(0);
    let mut one = vec![zero; nv * count];
    for _ in 0..states {
        let [step, qd, qdd]: [Vec<Portable>; 3] =
            core::array::from_fn(|_| units.iter().map(|u| Portable(u * random.next())).collect());
        coordinates::integrate(&mechanism, &neutral, &step, &mut q);
        regressor(&mechanism, Motion { q: &q, qd: &qd, qdd: &qdd }, workspace, &mut one);
        for (index, (column, part)) in columns.iter_mut().zip(one.chunks(nv)).enumerate() {
            let rows = part.iter().zip(&units);
            column.extend(rows.map(|(number, row)| number.0 * row / unit.of_parameter(index)));
        }
    }
    columns
}

/// The QR factorization of the independent columns: Q and R by columns.
struct Basis {
    directions: Vec<Vec<f64>>,
    triangle: Vec<Vec<f64>>,
}

impl Basis {
    /// Returns the column's components along the directions, and the remainder. Gram-Schmidt
    /// orthogonalization runs twice, since one pass leaves rounding errors of the column's
    /// magnitude.
    fn split(&self, mut column: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
        let mut parts = vec![0.0; self.directions.len()];
        for _ in 0..2 {
            for (part, direction) in parts.iter_mut().zip(&self.directions) {
                let along = dot(&column, direction);
                *part += along;
                column.iter_mut().zip(direction).for_each(|(x, d)| *x -= along * d);
            }
        }
        (parts, column)
    }

    /// Solves R x = b in place: from components along the directions to coefficients of the kept
    /// columns.
    fn solve(&self, x: &mut [f64]) {
        for (k, column) in self.triangle.iter().enumerate().rev() {
            let value = x[k] / column[k];
            x[k] = value;
            x[..k].iter_mut().zip(column).for_each(|(x, r)| *x -= value * r);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn length(a: &[f64]) -> f64 {
    libm::sqrt(dot(a, a))
}

fn snap(x: f64) -> f64 {
    let near = [0.0, 1.0, -1.0].into_iter().find(|y| (x - y).abs() < SNAP);
    near.unwrap_or(x)
}

/// Returns the combination as text.
fn name(model: &Model, combination: &[(usize, f64)]) -> String {
    let mut text = String::new();
    for &(index, coefficient) in combination {
        text.push_str(match (text.is_empty(), coefficient < 0.0) {
            (true, _) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        });
        text.push_str(INERTIAL_PARAMETERS[index % PARAMETERS_PER_LINK]);
        text.push('_');
        text.push_str(&model.moving_links()[index / PARAMETERS_PER_LINK].name);
        let factor = coefficient.abs();
        if factor != 1.0 {
            let digits = format!("{factor:.5e}");
            text.push_str(&format!(" * {}", digits.parse().unwrap_or(factor)));
        }
    }
    text
}

/// A fixed sequence of numbers in -3..3: SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    #[allow(clippy::cast_precision_loss)]
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let first_round = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (first_round ^ (first_round >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let unit = ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
        6.0 * unit - 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Interpreter;
    use crate::joint::JointType;
    use crate::model::{DEFAULT_GRAVITY, Inertial, Joint, MovingLink};
    use crate::spatial::Pose;

    /// Returns two bodies on revolute joints with these axes.
    fn model(axes: [[f64; 3]; 2]) -> Model {
        let link = |(i, axis)| {
            let origin = Pose { translation: [0.3, -0.2, 0.5], ..Pose::identity() };
            let name = format!("{i}");
            let joint = Joint::new(name.clone(), JointType::Revolute, axis, origin);
            let inertial = Inertial {
                mass: 1.5,
                center_of_mass: [0.1, 0.2, -0.3],
                inertia: [0.3, 0.02, -0.01, 0.4, 0.03, 0.5],
            };
            MovingLink { name, parent: (i == 1).then_some(0), joint, inertial }
        };
        let links = axes.into_iter().enumerate().map(link).collect();
        Model::new("r", DEFAULT_GRAVITY, links, Vec::new()).expect("good")
    }

    #[test]
    fn rounded_coefficients_are_whole() {
        for whole in [0.0, 1.0, -1.0] {
            assert_eq!([snap(whole + 1e-10), snap(whole - 1e-10)], [whole; 2]);
            assert_eq!(snap(whole + 1e-6), whole + 1e-6);
        }
    }

    #[test]
    fn torques_are_columns_times_values() {
        let x = [0.48, 0.6, 0.64];
        let y = [0.0, 1.0, 0.0];
        let z = [0.0, 0.0, 1.0];
        for axes in [[z, y], [x, y], [z, z]] {
            let model = model(axes);
            let base = BaseParameters::new(&model);
            let columns = base.regressor_columns();
            let values = base.values(&model);
            assert_eq!(columns.len(), values.len());
            let mut robot = Interpreter::<f64>::new(model);
            for k in 0..3 {
                let vector = |j: usize| [0.7, -1.1].map(|s| s * (0.4 + f64::from(k) + j as f64));
                let q = vector(0);
                let qd = vector(1);
                let qdd = vector(2);
                let mut all = [0.0; 40];
                let mut expected = [0.0; 2];
                robot.regressor(&q, &qd, &qdd, &mut all).expect("sizes");
                robot.inverse_dynamics(&q, &qd, &qdd, &mut expected).expect("sizes");
                for (row, expected) in expected.into_iter().enumerate() {
                    let terms =
                        columns.iter().zip(&values).map(|(c, value)| all[2 * c + row] * value);
                    let sum: f64 = terms.sum();
                    assert!((sum - expected).abs() < 1e-10, "{axes:?}: {sum} {expected}");
                }
            }
        }
    }

    /// With perpendicular axes, moments of inertia only matter as sums and differences.
    #[test]
    fn coefficients_close_to_one_are_one() {
        let base = BaseParameters::new(&model([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]));
        let all = || base.parameters.iter().flat_map(|one| &one.combination).map(|part| part.1);
        for exact in [1.0, -1.0] {
            assert!(all().any(|x| x == exact));
            assert!(all().all(|x| x == exact || (x - exact).abs() > 1e-6));
        }
        assert!(base.parameters.iter().any(|one| one.name().contains(" - ")));
        assert!(base.parameters.iter().all(|one| !one.name().contains("* 1 ")));
    }
}
