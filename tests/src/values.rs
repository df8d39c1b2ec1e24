//! All of a robot's quantities at one state: of the interpreter, and of any generated robot.

use std::iter::zip;

use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::{Array, Factorization, Interpreter, Robot, Scalar};

use crate::quantities::{Quantities, numbers};
use crate::random::State;

/// What the quantities are taken at.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Inputs<T> {
    pub q: Vec<T>,
    pub qd: Vec<T>,
    pub qdd: Vec<T>,
    /// The torques of forward dynamics, and the right-hand side to solve for.
    pub tau: Vec<T>,
}

impl<T: Scalar> From<&State> for Inputs<T> {
    fn from(State { q, qd, qdd, tau }: &State) -> Self {
        let [q, qd, qdd, tau] =
            [q, qd, qdd, tau].map(|x| x.iter().map(|&x| T::from_f64(x)).collect());
        Self { q, qd, qdd, tau }
    }
}

impl Inputs<f32> {
    /// The same numbers in double precision.
    #[must_use]
    pub fn double(&self) -> Inputs<f64> {
        let Self { q, qd, qdd, tau } = self;
        let [q, qd, qdd, tau] =
            [q, qd, qdd, tau].map(|x| x.iter().copied().map(f64::from).collect());
        Inputs { q, qd, qdd, tau }
    }
}

/// The quantities; matrices by columns.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Values<T> {
    pub forward_dynamics: Vec<T>,
    pub inverse_dynamics: Vec<T>,
    pub bias_forces: Vec<T>,
    pub gravity_torques: Vec<T>,
    pub mass_matrix: Vec<T>,
    pub kinetic_energy: T,
    pub potential_energy: T,
    /// Twelve numbers a link.
    pub link_poses: Vec<T>,
    pub factors: Factors<T>,
}

/// What a factorization offers; matrices by columns.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Factors<T> {
    pub u: Vec<T>,
    pub d: Vec<T>,
    pub u_inverse: Vec<T>,
    pub d_inverse: Vec<T>,
    pub solve: Vec<T>,
    pub inverse: Vec<T>,
    pub log_determinant: T,
    pub pivot_blocks: Vec<Vec<T>>,
    pub condition_numbers: Vec<T>,
}

impl<T: Copy> Values<T> {
    /// All numbers but the condition numbers, by name.
    #[must_use]
    pub fn named(&self) -> Vec<(&'static str, Vec<T>)> {
        let Self {
            forward_dynamics,
            inverse_dynamics,
            bias_forces,
            gravity_torques,
            mass_matrix,
            kinetic_energy,
            potential_energy,
            link_poses,
            factors,
        } = self;
        let Factors {
            u,
            d,
            u_inverse,
            d_inverse,
            solve,
            inverse,
            log_determinant,
            pivot_blocks,
            condition_numbers: _,
        } = factors;
        let mut named = vec![
            ("forward_dynamics", forward_dynamics.clone()),
            ("inverse_dynamics", inverse_dynamics.clone()),
            ("bias_forces", bias_forces.clone()),
            ("gravity_torques", gravity_torques.clone()),
            ("mass_matrix", mass_matrix.clone()),
            ("kinetic_energy", vec![*kinetic_energy]),
            ("potential_energy", vec![*potential_energy]),
            ("link_poses", link_poses.clone()),
            ("u", u.clone()),
            ("d", d.clone()),
            ("u_inverse", u_inverse.clone()),
            ("d_inverse", d_inverse.clone()),
            ("solve", solve.clone()),
            ("inverse", inverse.clone()),
            ("log_determinant", vec![*log_determinant]),
        ];
        named.extend(pivot_blocks.iter().map(|block| ("pivot_block", block.clone())));
        named
    }
}

/// A generated robot's, through the traits.
///
/// # Panics
///
/// If the inputs do not have the robot's length.
pub fn generated<R: Robot, T: Scalar>(
    inputs: &Inputs<T>,
    pivot_blocks: impl FnOnce(&R::Brge<T>) -> Vec<Vec<T>>,
) -> Values<T> {
    let [q, qd, qdd, tau] = [&inputs.q, &inputs.qd, &inputs.qdd, &inputs.tau];
    let [qd, qdd, tau] = [qd, qdd, tau].map(|x| array::<T, R::V<T>>(x));
    let q = array(q);
    let brge = R::brge(&q);
    let factors = Factors {
        u: columns(&brge.u()),
        d: columns(&brge.d()),
        u_inverse: columns(&brge.u_inverse()),
        d_inverse: columns(&brge.d_inverse()),
        solve: brge.solve(&tau).as_ref().to_vec(),
        inverse: columns(&brge.inverse()),
        log_determinant: brge.log_determinant(),
        pivot_blocks: pivot_blocks(&brge),
        // One more than there are.
        condition_numbers: (0..=R::MODULES.len())
            .filter_map(|m| brge.condition_number(m))
            .collect(),
    };
    Values {
        forward_dynamics: R::forward_dynamics(&q, &qd, &tau).as_ref().to_vec(),
        inverse_dynamics: R::inverse_dynamics(&q, &qd, &qdd).as_ref().to_vec(),
        bias_forces: R::bias_forces(&q, &qd).as_ref().to_vec(),
        gravity_torques: R::gravity_torques(&q).as_ref().to_vec(),
        mass_matrix: columns(&R::mass_matrix(&q)),
        kinetic_energy: R::kinetic_energy(&q, &qd),
        potential_energy: R::potential_energy(&q),
        link_poses: R::link_poses(&q).as_ref().iter().flat_map(numbers).collect(),
        factors,
    }
}

/// The interpreter's.
#[must_use]
pub fn interpreted<T: Scalar>(
    model: &Model,
    modules: &ModuleTree,
    inputs: &Inputs<T>,
) -> Values<T> {
    let Inputs { q, qd, qdd, tau } = inputs;
    let mut interpreter =
        Interpreter::with_modules(model.clone(), modules.clone()).expect("its own modules");
    let brge = interpreter.factors(q);
    let all = 0..=modules.modules().len();
    let factors = Factors {
        u: brge.u(),
        d: brge.d(),
        u_inverse: brge.u_inverse(),
        d_inverse: brge.d_inverse(),
        solve: brge.solve(tau).expect("the length is right"),
        inverse: brge.inverse(),
        log_determinant: brge.log_determinant(),
        pivot_blocks: all.clone().filter_map(|m| brge.pivot_block(m)).collect(),
        condition_numbers: all.filter_map(|m| brge.condition_number(m)).collect(),
    };
    Values {
        forward_dynamics: interpreter.qdd(q, qd, tau),
        inverse_dynamics: interpreter.tau(q, qd, qdd),
        bias_forces: interpreter.bias(q, qd),
        gravity_torques: interpreter.gravity(q),
        mass_matrix: interpreter.gim(q),
        kinetic_energy: interpreter.kinetic(q, qd),
        potential_energy: interpreter.potential(q),
        link_poses: interpreter.poses(q).iter().flat_map(numbers).collect(),
        factors,
    }
}

/// An array of those numbers.
///
/// # Panics
///
/// If it has another length.
#[must_use]
pub fn array<T: Scalar, A: Array<T>>(numbers: &[T]) -> A {
    assert_eq!(numbers.len(), A::LEN, "numbers for the array");
    A::from_fn(|i| numbers[i])
}

/// The numbers of a matrix, column after column.
#[must_use]
pub fn columns<T: Scalar, V: Array<T>>(matrix: &impl Array<V>) -> Vec<T> {
    matrix.as_ref().iter().flat_map(|column| column.as_ref().to_vec()).collect()
}

/// Numbers in double precision.
#[must_use]
pub fn double(numbers: &[f32]) -> Vec<f64> {
    numbers.iter().copied().map(f64::from).collect()
}

/// Pairs what two have of the same name.
///
/// # Panics
///
/// If they do not have the same names.
pub fn pairs<S: Copy, T: Copy>(
    one: &Values<S>,
    other: &Values<T>,
) -> Vec<(&'static str, Vec<S>, Vec<T>)> {
    let (one, other) = (one.named(), other.named());
    assert_eq!(one.len(), other.len(), "pivot blocks");
    zip(one, other).map(|((name, a), (_, b))| (name, a, b)).collect()
}
