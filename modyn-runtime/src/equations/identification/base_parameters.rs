//! Base parameters: the fewest combinations of inertial parameters that joint torques depend on.
//!
//! Found on numbers (Gautier 1991, "Numerical calculation of the base inertial parameters of
//! robots"): the columns of regressors at many states, stacked, are orthogonalized in the order of
//! the parameters, and one that depends on columns before it has its parameter grouped with
//! theirs. Parents come before children, so what a joint cannot feel is counted with the parent,
//! as in the textbooks (Khalil and Dombre 2002, chapter 9).

use alloc::{format, string::String, vec, vec::Vec};

use super::regressor;
use crate::Portable;
use crate::equations::Workspace;
use crate::equations::kinematics::coordinates;
use crate::mechanism::Mechanism;
use crate::model::{INERTIAL_PARAMETERS, Model, PARAMETERS_PER_LINK};

/// A column of the regressor is independent of others if more than that part of it is: below, nothing
/// can be identified, and above is what a description's rounded angles make of parallel axes.
const TOLERANCE: f64 = 1e-7;

/// Coefficients this near to 0, 1 or -1 are taken for it.
const SNAP: f64 = 1e-8;

/// A combination of inertial parameters that joint torques depend on.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseParameter {
    name: String,
    /// The parameter that the others are grouped with (10 times its link, and its place among the
    /// ten): the column of the regressor that belongs to the combination.
    pub kept: usize,
    /// The combination: parameters and their coefficients, [`kept`](Self::kept) and its 1 first.
    pub combination: Vec<(usize, f64)>,
}

impl BaseParameter {
    /// The combination as text, such as `Izz_forearm + Iyy_hand + m_hand * 0.16`, with coefficients
    /// to six digits.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// A smallest set of combinations of inertial parameters that determines all joint torques.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseParameters {
    /// The combinations, in the order of the parameters that the others are grouped with.
    pub parameters: Vec<BaseParameter>,
}

impl BaseParameters {
    /// Those of `model`, whatever its inertias and limits are.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let columns = stacked_regressors(model);
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
                    let part = snap(part);
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

    /// Their values for the inertias of `model`: that robot, or the same with other inertias.
    #[must_use]
    pub fn values(&self, model: &Model) -> Vec<f64> {
        let all: Vec<f64> = (0..model.links().len())
            .filter_map(|link| model.inertial_parameters(link))
            .flatten()
            .collect();
        let value = |&(index, coefficient): &(usize, f64)| {
            all.get(index).map_or(0.0, |parameter| coefficient * parameter)
        };
        self.parameters.iter().map(|one| one.combination.iter().map(value).sum()).collect()
    }

    /// The columns of the regressor that belong to them: tau is these columns times the values.
    #[must_use]
    pub fn regressor_columns(&self) -> Vec<usize> {
        self.parameters.iter().map(|parameter| parameter.kept).collect()
    }
}

/// The columns of the regressors at many states, one under the other: the same numbers on every host, since
/// they become part of generated text.
fn stacked_regressors(model: &Model) -> Vec<Vec<f64>> {
    let mechanism = Mechanism::new(model).cast::<Portable>();
    let workspace = &mut Workspace::new(&mechanism);
    let (nq, nv) = (model.nq(), model.nv());
    let count = PARAMETERS_PER_LINK * model.links().len();
    // Four times as many rows as columns, and of each joint's torque four times as many as a link
    // has parameters: generic states then show all there is to see.
    let states = (4 * count).div_ceil(nv).max(4 * PARAMETERS_PER_LINK);
    let mut columns = vec![Vec::with_capacity(states * nv); count];
    let zero = Portable(0.0);
    let (mut neutral, mut q) = (vec![zero; nq], vec![zero; nq]);
    coordinates::neutral(&mechanism, &mut neutral);
    let mut random = Random(0);
    let mut one = vec![zero; nv * count];
    for _ in 0..states {
        let [step, qd, qdd]: [Vec<Portable>; 3] =
            core::array::from_fn(|_| (0..nv).map(|_| Portable(random.next())).collect());
        coordinates::integrate(&mechanism, (&neutral, &step), &mut q);
        regressor(&mechanism, (&q, &qd, &qdd), workspace, &mut one);
        for (column, part) in columns.iter_mut().zip(one.chunks(nv)) {
            column.extend(part.iter().map(|number| number.0));
        }
    }
    columns
}

/// What stacked columns span: Q and R by columns.
struct Basis {
    directions: Vec<Vec<f64>>,
    triangle: Vec<Vec<f64>>,
}

impl Basis {
    /// The column's parts along the directions, and what is left of it: Gram and Schmidt, twice, as
    /// the first time leaves rounding errors of the column's own size.
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

    /// From parts along the directions to coefficients of the columns kept: R x = b, in place.
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

/// The combination as text.
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
        text.push_str(&model.links()[index / PARAMETERS_PER_LINK].name);
        let factor = coefficient.abs();
        if factor != 1.0 {
            let digits = format!("{factor:.5e}");
            text.push_str(&format!(" * {}", digits.parse().unwrap_or(factor)));
        }
    }
    text
}

/// A fixed stream of numbers in -3..3: SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    #[allow(clippy::cast_precision_loss)]
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let unit = ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
        6.0 * unit - 3.0
    }
}
