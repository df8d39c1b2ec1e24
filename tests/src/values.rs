//! All quantities of a robot at one state: from the interpreter, and from any generated robot.

use std::collections::BTreeSet;
use std::sync::Mutex;

use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::quantities::{Function, Record, Shape};
use modyn_runtime::spatial::{Momentum, Twist, Vector3, Wrench};
use modyn_runtime::{
    Array, CentroidalMomentumDerivatives, Factorization, ForwardDynamicsHessian, Interpreter,
    InverseDynamicsHessian, Robot, Scalar, StepDerivatives, StepHessian, functions,
};

use crate::arguments::interpreted as interpreted_function;
use crate::quantities::{Quantities, numbers};
use crate::random::{Random, State};

/// The state at which the quantities are computed.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub struct Inputs<T> {
    pub q: Vec<T>,
    pub qd: Vec<T>,
    pub qdd: Vec<T>,
    /// The torques of forward dynamics, and the right-hand side of the solver.
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
    /// Returns the same numbers in double precision.
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
    /// Twelve numbers for each link.
    pub link_poses: Vec<T>,
    pub factors: Factors<T>,
    /// All other quantities by name: those of the default functions, or of all functions.
    pub others: Named<T>,
}

/// Numbers by name.
pub type Named<T> = Vec<(&'static str, Vec<T>)>;

/// The results of a factorization; matrices by columns.
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
    /// Returns all numbers except the condition numbers, by name.
    #[must_use]
    pub fn named(&self) -> Named<T> {
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
            others,
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
        named.extend(others.iter().cloned());
        named
    }
}

impl<T> Values<T> {
    /// Returns the numbers with this name among the other quantities.
    ///
    /// # Panics
    ///
    /// If there are none.
    #[must_use]
    pub fn other(&self, name: &str) -> &[T] {
        let found = self.others.iter().find(|(other, _)| *other == name);
        &found.unwrap_or_else(|| panic!("no `{name}`")).1
    }
}

/// The arguments of functions: the [`Inputs`] as arrays, rounded to numbers that single precision can represent.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)]
pub struct Given<Q, V, F> {
    pub q: Q,
    pub qd: V,
    pub qdd: V,
    pub tau: V,
    /// The coordinates with quaternions that are longer than 1.
    pub long: Q,
    /// A wrench for each link.
    pub forces: F,
}

impl<Q, V, F> Given<Q, V, F> {
    /// Returns the inputs as arrays of a robot.
    ///
    /// # Panics
    ///
    /// If the inputs do not have the robot's length.
    #[must_use]
    pub fn new<T: Scalar>(Inputs { q, qd, qdd, tau }: &Inputs<T>) -> Self
    where
        Q: Array<T>,
        V: Array<T>,
        F: Array<Wrench<T>>,
    {
        let [qd, qdd, tau] = [qd, qdd, tau].map(|x| array(x));
        let long = Q::from_fn(|i| q[i] + q[i]);
        Self { q: array(q), qd, qdd, tau, long, forces: F::from_fn(wrench) }
    }
}

/// Returns the wrench on a link.
#[must_use]
pub fn wrench<T: Scalar>(link: usize) -> Wrench<T> {
    let mut random = Random::new(link as u64);
    let mut vector = || Vector3(std::array::from_fn(|_| T::from_f64(eighths(&mut random) - 4.0)));
    Wrench { moment: vector(), force: vector() }
}

/// Returns numbers in 0..1, one after the other.
pub fn uniform<T: Scalar>() -> impl FnMut() -> T {
    let mut random = Random::new(0);
    move || T::from_f64(eighths(&mut random) / 8.0)
}

#[allow(clippy::cast_precision_loss)]
fn eighths(random: &mut Random) -> f64 {
    random.below(64) as f64 / 8.0
}

/// Returns the numbers of all items, one item after the other.
pub fn each<X: Copy, T>(things: &impl Array<X>, numbers: impl Fn(&X) -> Vec<T>) -> Vec<T> {
    things.as_ref().iter().flat_map(numbers).collect()
}

/// Returns the components of a twist: angular, then linear.
pub fn twist<T: Scalar>(Twist { angular, linear }: &Twist<T>) -> Vec<T> {
    [angular.0, linear.0].concat()
}

/// Returns the components of a momentum: angular, then linear.
pub fn momentum<T: Scalar>(Momentum { angular, linear }: &Momentum<T>) -> Vec<T> {
    [angular.0, linear.0].concat()
}

/// Returns the components of a vector.
pub fn vector<T: Scalar>(Vector3(numbers): &Vector3<T>) -> Vec<T> {
    numbers.to_vec()
}

/// Evaluates the default functions that have no field in [`Values`]: through the type or, with a type parameter,
/// through the trait. `links` are all links.
#[macro_export]
macro_rules! default_quantities {
    ($robot:ident, $given:expr, $links:expr) => {{
        use $crate::quantities::numbers;
        use $crate::values::{each, list, twist, uniform};
        let (given, links) = ($given, $links);
        let (q, qd) = (&given.q, &given.qd);
        let random = $robot::random(uniform());
        vec![
            ("center_of_mass", list(&$robot::center_of_mass(q))),
            ("link_pose", links.iter().flat_map(|&l| numbers(&$robot::link_pose(q, l))).collect()),
            (
                "jacobian",
                links.iter().flat_map(|&l| each(&$robot::jacobian(q, l), twist)).collect(),
            ),
            ("integrate", list(&$robot::integrate(q, qd))),
            ("difference", list(&$robot::difference(q, &random))),
            ("velocity_to_qdot", list(&$robot::velocity_to_qdot(q, qd))),
            ("normalize", list(&$robot::normalize(&given.long))),
            ("random", list(&random)),
        ]
    }};
}

/// Evaluates the functions that are not default ones in the same way.
#[macro_export]
macro_rules! other_quantities {
    ($robot:ident, $given:expr, $links:expr) => {{
        use $crate::values::{
            array, columns, each, forward_hessian_numbers, inverse_hessian_numbers, list, momentum,
            twist, vector,
        };
        let (given, links) = ($given, $links);
        let (q, qd, qdd, tau) = (&given.q, &given.qd, &given.qdd, &given.tau);
        let forces = &given.forces;
        let generalized =
            [$robot::generalized_forces(q, forces), $robot::generalized_forces_world(q, forces)];
        let inverse = $robot::inverse_dynamics_derivatives(q, qd, qdd);
        let forward = $robot::forward_dynamics_derivatives(q, qd, tau);
        let random = $robot::random($crate::values::uniform());
        let integrate = $robot::integrate_derivatives(q, qd);
        let inverse_vjp = $robot::inverse_dynamics_vjp(q, qd, qdd, tau);
        let inverse_jvp = $robot::inverse_dynamics_jvp(q, qd, qdd, tau, qdd, qd);
        let forward_vjp = $robot::forward_dynamics_vjp(q, qd, tau, qdd);
        let forward_jvp = $robot::forward_dynamics_jvp(q, qd, tau, qdd, tau, qd);
        let inverse_hessian = $robot::inverse_dynamics_hessian(q, qd, qdd, tau);
        let forward_hessian = $robot::forward_dynamics_hessian(q, qd, tau, qdd);
        let dt = $crate::values::time_step();
        let semi_implicit = $robot::step_semi_implicit(q, qd, tau, dt);
        let linear_step = $robot::step_semi_implicit_derivatives(q, qd, tau, dt);
        let costate = array(&$crate::values::costate(&list(qdd), &list(tau)));
        let step_hessian = $robot::step_semi_implicit_hessian(q, qd, tau, dt, &costate);
        let rk4 = $robot::step_rk4(q, qd, tau, dt);
        let linear_rk4 = $robot::step_rk4_derivatives(q, qd, tau, dt);
        let midpoint = $robot::step_implicit_midpoint(q, qd, tau, dt);
        let linear_midpoint = $robot::step_implicit_midpoint_derivatives(q, qd, tau, dt);
        let difference = $robot::difference_derivatives(q, &random);
        vec![
            (
                "forward_dynamics_external",
                list(&$robot::forward_dynamics_external(q, qd, tau, forces)),
            ),
            (
                "forward_dynamics_external_world",
                list(&$robot::forward_dynamics_external_world(q, qd, tau, forces)),
            ),
            (
                "inverse_dynamics_external",
                list(&$robot::inverse_dynamics_external(q, qd, qdd, forces)),
            ),
            (
                "inverse_dynamics_external_world",
                list(&$robot::inverse_dynamics_external_world(q, qd, qdd, forces)),
            ),
            ("generalized_forces.tau", list(&generalized[0].tau)),
            ("generalized_forces.dq", columns(&generalized[0].dq)),
            ("generalized_forces_world.tau", list(&generalized[1].tau)),
            ("generalized_forces_world.dq", columns(&generalized[1].dq)),
            ("inverse_dynamics_derivatives.dq", columns(&inverse.dq)),
            ("inverse_dynamics_derivatives.dqd", columns(&inverse.dqd)),
            ("forward_dynamics_derivatives.qdd", list(&forward.qdd)),
            ("forward_dynamics_derivatives.dq", columns(&forward.dq)),
            ("forward_dynamics_derivatives.dqd", columns(&forward.dqd)),
            ("forward_dynamics_derivatives.dtau", columns(&forward.dtau)),
            ("inverse_dynamics_vjp.tau", list(&inverse_vjp.tau)),
            ("inverse_dynamics_vjp.dq", list(&inverse_vjp.dq)),
            ("inverse_dynamics_vjp.dqd", list(&inverse_vjp.dqd)),
            ("inverse_dynamics_vjp.dqdd", list(&inverse_vjp.dqdd)),
            ("inverse_dynamics_jvp.tau", list(&inverse_jvp.tau)),
            ("inverse_dynamics_jvp.dtau", list(&inverse_jvp.dtau)),
            ("forward_dynamics_vjp.qdd", list(&forward_vjp.qdd)),
            ("forward_dynamics_vjp.dq", list(&forward_vjp.dq)),
            ("forward_dynamics_vjp.dqd", list(&forward_vjp.dqd)),
            ("forward_dynamics_vjp.dtau", list(&forward_vjp.dtau)),
            ("forward_dynamics_jvp.qdd", list(&forward_jvp.qdd)),
            ("forward_dynamics_jvp.dqdd", list(&forward_jvp.dqdd)),
            ("inverse_dynamics_hessian", inverse_hessian_numbers(&inverse_hessian)),
            ("forward_dynamics_hessian", forward_hessian_numbers(&forward_hessian)),
            ("step_semi_implicit.q", list(&semi_implicit.q)),
            ("step_semi_implicit.qd", list(&semi_implicit.qd)),
            ("step_semi_implicit_derivatives.q", list(&linear_step.q)),
            ("step_semi_implicit_derivatives.qd", list(&linear_step.qd)),
            ("step_semi_implicit_derivatives.a", columns(&linear_step.a)),
            ("step_semi_implicit_derivatives.b", columns(&linear_step.b)),
            ("step_semi_implicit_hessian", $crate::values::step_hessian_numbers(&step_hessian)),
            ("step_rk4.q", list(&rk4.q)),
            ("step_rk4.qd", list(&rk4.qd)),
            ("step_rk4_derivatives", $crate::values::linear_step_numbers(&linear_rk4)),
            ("step_implicit_midpoint", [list(&midpoint.q), list(&midpoint.qd)].concat()),
            (
                "step_implicit_midpoint_derivatives",
                $crate::values::linear_step_numbers(&linear_midpoint),
            ),
            ("integrate_derivatives.dq", columns(&integrate.dq)),
            ("integrate_derivatives.dv", columns(&integrate.dv)),
            ("difference_derivatives.dfrom", columns(&difference.dfrom)),
            ("difference_derivatives.dto", columns(&difference.dto)),
            ("regressor", columns(&$robot::regressor(q, qd, qdd))),
            ("center_of_mass_jacobian", each(&$robot::center_of_mass_jacobian(q), vector)),
            ("centroidal_momentum_matrix", each(&$robot::centroidal_momentum_matrix(q), momentum)),
            (
                "centroidal_composite_inertia",
                $robot::centroidal_composite_inertia(q).iter().flat_map(momentum).collect(),
            ),
            ("centroidal_momentum", momentum(&$robot::centroidal_momentum(q, qd))),
            ("centroidal_momentum_rate", momentum(&$robot::centroidal_momentum_rate(q, qd, qdd))),
            (
                "centroidal_momentum_derivatives",
                $crate::values::centroidal_numbers(&$robot::centroidal_momentum_derivatives(
                    q, qd, qdd,
                )),
            ),
            (
                "link_velocity",
                links.iter().flat_map(|&l| twist(&$robot::link_velocity(q, qd, l))).collect(),
            ),
            (
                "local_link_velocity",
                links.iter().flat_map(|&l| twist(&$robot::local_link_velocity(q, qd, l))).collect(),
            ),
            (
                "link_acceleration",
                links
                    .iter()
                    .flat_map(|&l| twist(&$robot::link_acceleration(q, qd, qdd, l)))
                    .collect(),
            ),
            (
                "local_link_acceleration",
                links
                    .iter()
                    .flat_map(|&l| twist(&$robot::local_link_acceleration(q, qd, qdd, l)))
                    .collect(),
            ),
            (
                "local_jacobian",
                links.iter().flat_map(|&l| each(&$robot::local_jacobian(q, l), twist)).collect(),
            ),
            ("coriolis_matrix", columns(&$robot::coriolis_matrix(q, qd))),
            (
                "jacobian_time_derivative",
                links
                    .iter()
                    .flat_map(|&l| each(&$robot::jacobian_time_derivative(q, qd, l), twist))
                    .collect(),
            ),
            (
                "local_jacobian_time_derivative",
                links
                    .iter()
                    .flat_map(|&l| each(&$robot::local_jacobian_time_derivative(q, qd, l), twist))
                    .collect(),
            ),
            (
                "bias_acceleration",
                links.iter().flat_map(|&l| twist(&$robot::bias_acceleration(q, qd, l))).collect(),
            ),
            (
                "local_bias_acceleration",
                links
                    .iter()
                    .flat_map(|&l| twist(&$robot::local_bias_acceleration(q, qd, l)))
                    .collect(),
            ),
        ]
    }};
}

/// Returns the time of a step, s.
#[must_use]
pub fn time_step<T: Scalar>() -> T {
    T::from_f64(1.0 / 128.0)
}

/// Returns the costate of a step's Hessian: multipliers of the coordinates, then of the velocities.
#[must_use]
pub fn costate<T: Scalar>(of_q: &[T], of_qd: &[T]) -> Vec<T> {
    [of_q, of_qd].concat()
}

/// The arguments of a type's functions through the trait.
pub type GivenTo<R, T> =
    Given<<R as Robot>::Q<T>, <R as Robot>::V<T>, <R as Robot>::PerLink<Wrench<T>>>;

/// Returns the quantities of a generated robot through the trait: those of the default functions.
///
/// # Panics
///
/// If the inputs do not have the robot's length.
pub fn generated<R: Robot + functions::Defaults, T: Scalar>(
    inputs: &Inputs<T>,
    links: &[R::Link],
    pivot_blocks: impl FnOnce(&R::UduFactorization<T>) -> Vec<Vec<T>>,
) -> Values<T> {
    let given = GivenTo::<R, T>::new(inputs);
    let Given { q, qd, qdd, tau, .. } = &given;
    let brge = R::brge(q);
    let factors = Factors {
        u: columns(&brge.u()),
        d: columns(&brge.d()),
        u_inverse: columns(&brge.u_inverse()),
        d_inverse: columns(&brge.d_inverse()),
        solve: list(&brge.solve(tau)),
        inverse: columns(&brge.inverse()),
        log_determinant: brge.log_determinant(),
        pivot_blocks: pivot_blocks(&brge),
        // One random number more than there are coordinates.
        condition_numbers: (0..=R::MODULES.len())
            .filter_map(|m| brge.condition_number(m))
            .collect(),
    };
    Values {
        forward_dynamics: list(&R::forward_dynamics(q, qd, tau)),
        inverse_dynamics: list(&R::inverse_dynamics(q, qd, qdd)),
        bias_forces: list(&R::bias_forces(q, qd)),
        gravity_torques: list(&R::gravity_torques(q)),
        mass_matrix: columns(&R::mass_matrix(q)),
        kinetic_energy: R::kinetic_energy(q, qd),
        potential_energy: R::potential_energy(q),
        link_poses: each(&R::link_poses(q), numbers),
        factors,
        others: default_quantities!(R, &given, links),
    }
}

/// Returns the further quantities of a robot with all functions.
///
/// # Panics
///
/// If the inputs do not have the robot's length.
pub fn generated_others<R: Robot + functions::All, T: Scalar>(
    inputs: &Inputs<T>,
    links: &[R::Link],
) -> Named<T> {
    let given = GivenTo::<R, T>::new(inputs);
    other_quantities!(R, &given, links)
}

/// Returns the interpreter's quantities: of all functions, or of the default ones.
#[must_use]
pub fn interpreted<T: Scalar>(
    model: &Model,
    modules: &ModuleTree,
    inputs: &Inputs<T>,
    all: bool,
) -> Values<T> {
    let Inputs { q, qd, qdd, tau } = inputs;
    let mut interpreter =
        Interpreter::with_modules(model.clone(), modules.clone()).expect("its own modules");
    let brge = interpreter.factors(q);
    let every = 0..=modules.modules().len();
    let factors = Factors {
        u: brge.u(),
        d: brge.d(),
        u_inverse: brge.u_inverse(),
        d_inverse: brge.d_inverse(),
        solve: brge.solve(tau).expect("the length is right"),
        inverse: brge.inverse(),
        log_determinant: brge.log_determinant(),
        pivot_blocks: every.clone().filter_map(|m| brge.pivot_block(m)).collect(),
        condition_numbers: every.filter_map(|m| brge.condition_number(m)).collect(),
    };
    let others = interpreted_others(&mut interpreter, inputs, all);
    Values {
        forward_dynamics: interpreter.qdd(q, qd, tau),
        inverse_dynamics: interpreter.tau(q, qd, qdd),
        bias_forces: interpreter.bias(q, qd),
        gravity_torques: interpreter.gravity(q),
        mass_matrix: interpreter.dense_mass_matrix(q),
        kinetic_energy: interpreter.kinetic(q, qd),
        potential_energy: interpreter.potential(q),
        link_poses: interpreter.poses(q).iter().flat_map(numbers).collect(),
        factors,
        others,
    }
}

/// Returns the interpreter's results of all functions that have no field in [`Values`], or of the default ones: the fields of a
/// result each by itself, and the results of all links one after the other.
fn interpreted_others<T: Scalar>(
    interpreter: &mut Interpreter<T>,
    inputs: &Inputs<T>,
    all: bool,
) -> Named<T> {
    let sizes = interpreter.sizes();
    let mut random = inputs.q.clone();
    interpreter.random(uniform(), &mut random).expect(LENGTHS);
    let mut named = Vec::new();
    for &function in Function::ALL {
        let row = function.row();
        let is_other = !FIELDS.contains(&function) && function.batched().is_none();
        if !is_other || row.of_constraints || !(all || row.default) {
            continue;
        }
        let arguments: Vec<Vec<T>> = (row.arguments.iter())
            .map(|argument| given(function, argument.name, inputs, &random, sizes.links))
            .collect();
        let result = interpreted_function(interpreter, function, &arguments);
        let fields = match (row.result)(&sizes) {
            Shape::Record(Record::Several(_) | Record::Each(_), fields) => fields,
            shape => vec![("", shape)],
        };
        // The numbers of records with many fields are compared together.
        if fields.len() == 1 || WHOLE.contains(&function) {
            named.push((function.name(), result));
            continue;
        }
        let mut rest = &result[..];
        for (field, shape) in fields {
            let (numbers, others) = rest.split_at(shape.len());
            named.push((field_name(function, field), numbers.to_vec()));
            rest = others;
        }
    }
    named
}

/// The functions that have a field in [`Values`].
const FIELDS: [Function; 9] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::BiasForces,
    Function::GravityTorques,
    Function::MassMatrix,
    Function::KineticEnergy,
    Function::PotentialEnergy,
    Function::LinkPoses,
    Function::Brge,
];

/// The functions whose fields [`other_quantities`](crate::other_quantities) has in one list.
const WHOLE: [Function; 7] = [
    Function::InverseDynamicsHessian,
    Function::ForwardDynamicsHessian,
    Function::StepSemiImplicitHessian,
    Function::StepRk4Derivatives,
    Function::StepImplicitMidpoint,
    Function::StepImplicitMidpointDerivatives,
    Function::CentroidalMomentumDerivatives,
];

/// Returns the name of a field of a function's result.
fn field_name(function: Function, field: &str) -> &'static str {
    static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let name = format!("{}.{field}", function.name());
    let mut names = NAMES.lock().expect("no panic");
    if let Some(name) = names.get(&*name) {
        return name;
    }
    let name: &'static str = name.leak();
    names.insert(name);
    name
}

/// Returns the argument that [`default_quantities`](crate::default_quantities) and
/// [`other_quantities`](crate::other_quantities) give to a function.
fn given<T: Scalar>(
    function: Function,
    name: &str,
    Inputs { q, qd, qdd, tau }: &Inputs<T>,
    random: &[T],
    links: usize,
) -> Vec<T> {
    match (function, name) {
        // Quaternions longer than 1.
        (Function::Normalize, _) => q.iter().map(|&x| x + x).collect(),
        (_, "q" | "from") => q.clone(),
        (_, "to") => random.to_vec(),
        (_, "qd" | "v") => qd.clone(),
        (Function::InverseDynamicsVjp | Function::InverseDynamicsHessian, "cotangent")
        | (Function::InverseDynamicsJvp, "dq")
        | (Function::ForwardDynamicsJvp, "dqd")
        | (_, "tau") => tau.clone(),
        (_, "dqdd" | "dtau") => qd.clone(),
        (_, "qdd" | "cotangent" | "dq" | "dqd") => qdd.clone(),
        (_, "costate") => costate(qdd, tau),
        (_, "dt") => vec![time_step()],
        (_, "uniforms") => {
            let mut next = uniform();
            qd.iter().map(|_| next()).collect()
        }
        (_, "forces") => {
            let wrenches = (0..links).map(wrench);
            wrenches.flat_map(|wrench: Wrench<T>| wrench.components()).collect()
        }
        _ => panic!("{name} of {function:?}"),
    }
}

const LENGTHS: &str = "the lengths are right";

/// Returns the numbers of an array.
#[must_use]
pub fn list<T: Scalar>(numbers: &impl Array<T>) -> Vec<T> {
    numbers.as_ref().to_vec()
}

/// Returns an array of these numbers.
///
/// # Panics
///
/// If the length is wrong.
#[must_use]
pub fn array<T: Scalar, A: Array<T>>(numbers: &[T]) -> A {
    assert_eq!(numbers.len(), A::LEN, "numbers for the array");
    A::from_fn(|i| numbers[i])
}

/// Returns the numbers of a matrix, column after column.
#[must_use]
pub fn columns<T: Scalar, V: Array<T>>(matrix: &impl Array<V>) -> Vec<T> {
    matrix.as_ref().iter().flat_map(|column| column.as_ref().to_vec()).collect()
}

/// Returns the numbers of a Hessian of inverse dynamics, in the order of its fields.
#[must_use]
pub fn inverse_hessian_numbers<T: Scalar, V: Array<T>, M: Array<V>>(
    of: &InverseDynamicsHessian<V, M>,
) -> Vec<T> {
    let vectors = [&of.tau, &of.dq, &of.dqd, &of.dqdd].map(list);
    let matrices = [&of.dq_dq, &of.dq_dqd, &of.dqd_dqd, &of.dq_dqdd].map(columns);
    [vectors, matrices].concat().concat()
}

/// Returns the numbers of a Hessian of forward dynamics, in the order of its fields.
#[must_use]
pub fn forward_hessian_numbers<T: Scalar, V: Array<T>, M: Array<V>>(
    of: &ForwardDynamicsHessian<V, M>,
) -> Vec<T> {
    let vectors = [&of.qdd, &of.dq, &of.dqd, &of.dtau].map(list);
    let matrices = [&of.dq_dq, &of.dq_dqd, &of.dqd_dqd, &of.dq_dtau].map(columns);
    [vectors, matrices].concat().concat()
}

/// Returns the numbers of the Hessian of a step, in the order of its fields.
#[must_use]
pub fn step_hessian_numbers<T, Q, V, X, M, N, K>(of: &StepHessian<Q, V, X, V, M, N, K>) -> Vec<T>
where
    T: Scalar,
    Q: Array<T>,
    V: Array<T>,
    X: Array<T>,
    M: Array<X>,
    N: Array<X>,
    K: Array<V>,
{
    let vectors = [list(&of.q), list(&of.qd), list(&of.dx), list(&of.dtau)];
    let matrices = [columns(&of.dx_dx), columns(&of.dx_dtau), columns(&of.dtau_dtau)];
    [vectors.concat(), matrices.concat()].concat()
}

/// Returns the numbers of the centroidal momentum, its rate and their derivatives, in the order of their fields.
#[must_use]
pub fn centroidal_numbers<T: Scalar, M: Array<Momentum<T>>>(
    of: &CentroidalMomentumDerivatives<Momentum<T>, M>,
) -> Vec<T> {
    let values = [&of.momentum, &of.rate].map(momentum).concat();
    let matrices =
        [&of.momentum_dq, &of.rate_dq, &of.rate_dqd].map(|columns| each(columns, momentum));
    [values, matrices.concat()].concat()
}

/// Returns the numbers of a step and its derivatives, in the order of their fields.
#[must_use]
pub fn linear_step_numbers<T, Q, V, X, A, B>(of: &StepDerivatives<Q, V, A, B>) -> Vec<T>
where
    T: Scalar,
    Q: Array<T>,
    V: Array<T>,
    X: Array<T>,
    A: Array<X>,
    B: Array<X>,
{
    [list(&of.q), list(&of.qd), columns(&of.a), columns(&of.b)].concat()
}

/// Returns the numbers in double precision.
#[must_use]
pub fn double(numbers: &[f32]) -> Vec<f64> {
    numbers.iter().copied().map(f64::from).collect()
}

/// Pairs the numbers of two lists by name.
///
/// # Panics
///
/// If the names differ.
pub fn pairs<S: Copy, T: Copy>(
    one: &Values<S>,
    other: &Values<T>,
) -> Vec<(&'static str, Vec<S>, Vec<T>)> {
    let (mut one, mut other) = (one.named(), other.named());
    // Pivot blocks, which share a name, keep their order.
    one.sort_by_key(|(name, _)| *name);
    other.sort_by_key(|(name, _)| *name);
    assert_eq!(names(&one), names(&other));
    let pairs = one.into_iter().zip(other);
    pairs.map(|((name, a), (_, b))| (name, a, b)).collect()
}

fn names<T>(named: &Named<T>) -> Vec<&'static str> {
    named.iter().map(|(name, _)| *name).collect()
}
