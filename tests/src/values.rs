//! All results of a robot in one state: from the interpreter, and from any compiled robot.

use std::fmt::Debug;
use std::str::FromStr;

use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::quantities::{Function, Record, Shape, Sizes};
use modyn_runtime::spatial::{Vector3, Wrench};
use modyn_runtime::{
    Array, ContactSurface, Factorization, Interpreter, Robot, Scalar, StepSettings,
};

use crate::arguments::{arguments, interpreted as interpreted_function};
use crate::quantities::Quantities;
use crate::random::State;

/// The arguments of each function.
pub type Arguments<'a> = &'a dyn Fn(Function) -> Vec<Vec<f64>>;

/// The results of functions, each as numbers; those of a function of one link for all links, one after the other.
pub type Results<T> = Vec<(Function, Vec<T>)>;

/// The results of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Values<T> {
    /// The results of the functions of the table.
    pub functions: Results<T>,
    /// The results of the factorization.
    pub factors: Factors<T>,
}

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
    /// Returns the numbers of a function's result.
    ///
    /// # Panics
    ///
    /// If the robot does not have the function.
    #[must_use]
    pub fn of(&self, function: Function) -> &[T] {
        let found = self.functions.iter().find(|(other, _)| *other == function);
        &found.unwrap_or_else(|| panic!("no {function:?}")).1
    }

    /// Returns all numbers except the condition numbers, by name: those of a function with several results for each result.
    #[must_use]
    pub fn named(&self, sizes: &Sizes) -> Vec<(String, Vec<T>)> {
        let Factors { u, d, u_inverse, d_inverse, solve, inverse, .. } = &self.factors;
        let of_functions =
            self.functions.iter().flat_map(|(f, numbers)| fields(*f, sizes, numbers));
        let matrices = [
            ("u", u),
            ("d", d),
            ("u_inverse", u_inverse),
            ("d_inverse", d_inverse),
            ("solve", solve),
            ("inverse", inverse),
            ("log_determinant", &vec![self.factors.log_determinant]),
        ]
        .map(|(name, numbers)| (name.into(), numbers.clone()));
        let blocks = self.factors.pivot_blocks.iter();
        let blocks = blocks.map(|block| ("pivot_block".into(), block.clone()));
        of_functions.chain(matrices).chain(blocks).collect()
    }
}

/// Returns the numbers of each result of a function by name, such as `step_rk4.qd`.
///
/// # Panics
///
/// If there are more or fewer numbers.
#[must_use]
pub fn fields<T: Copy>(function: Function, sizes: &Sizes, numbers: &[T]) -> Vec<(String, Vec<T>)> {
    let Shape::Record(Record::ResultsByType(_) | Record::ResultsByField(_), fields) =
        (function.row().result)(sizes)
    else {
        return vec![(function.name().into(), numbers.into())];
    };
    let mut rest = numbers;
    let mut split = |(field, shape): (&str, Shape)| {
        let (own, others) = rest.split_at(shape.len());
        rest = others;
        (format!("{}.{field}", function.name()), own.to_vec())
    };
    let split = fields.into_iter().map(&mut split).collect();
    assert!(rest.is_empty(), "{function:?}");
    split
}

/// Pairs the numbers of two robots by name.
///
/// # Panics
///
/// If the names differ.
pub fn pairs<S: Copy, T: Copy>(
    one: &Values<S>,
    other: &Values<T>,
    sizes: &Sizes,
) -> Vec<(String, Vec<S>, Vec<T>)> {
    let (one, other) = (one.named(sizes), other.named(sizes));
    assert_eq!(one.len(), other.len());
    let both = one.into_iter().zip(other);
    both.map(|((name, a), (same, b))| {
        assert_eq!(name, same);
        (name, a, b)
    })
    .collect()
}

/// Returns the arguments of functions in a state.
pub fn of_state<'a>(model: &'a Model, state: &'a State) -> impl Fn(Function) -> Vec<Vec<f64>> + 'a {
    |function| arguments(function, model, state)
}

/// Returns the arguments of functions in a state, rounded to single precision.
pub fn of_single_state<'a>(
    model: &'a Model,
    state: &'a State,
) -> impl Fn(Function) -> Vec<Vec<f64>> + 'a {
    |function| {
        let mut arrays = arguments(function, model, state);
        arrays.iter_mut().flatten().for_each(|x| *x = f64::from(*x as f32));
        arrays
    }
}

/// An argument of a function of a compiled robot.
pub trait FromNumbers {
    /// How many numbers it has.
    const COUNT: usize;

    /// Returns the argument with these numbers.
    fn from_numbers(numbers: &[f64]) -> Self;
}

macro_rules! from_numbers {
    ($($float:ty)*) => {$(
        impl FromNumbers for $float {
            const COUNT: usize = 1;

            fn from_numbers(numbers: &[f64]) -> Self {
                Self::from_f64(numbers[0])
            }
        }
    )*};
}

from_numbers!(f64 f32);

impl<X: FromNumbers, const N: usize> FromNumbers for [X; N] {
    const COUNT: usize = N * X::COUNT;

    fn from_numbers(numbers: &[f64]) -> Self {
        assert_eq!(numbers.len(), Self::COUNT, "numbers of the array");
        std::array::from_fn(|i| X::from_numbers(&numbers[i * X::COUNT..][..X::COUNT]))
    }
}

impl<T: FromNumbers> FromNumbers for Wrench<T> {
    const COUNT: usize = 6;

    fn from_numbers(numbers: &[f64]) -> Self {
        let [force, moment] = FromNumbers::from_numbers(numbers);
        Self { force: Vector3(force), moment: Vector3(moment) }
    }
}

impl<T: FromNumbers + Copy, const N: usize> FromNumbers
    for StepSettings<T, [ContactSurface<T>; N]>
{
    const COUNT: usize = StepSettings::<f64>::COUNT + N * ContactSurface::<f64>::COUNT * T::COUNT;

    fn from_numbers(numbers: &[f64]) -> Self {
        let (common, surfaces) = numbers.split_at(StepSettings::<f64>::COUNT);
        let contacts: [[T; ContactSurface::<f64>::COUNT]; N] = FromNumbers::from_numbers(surfaces);
        let contacts = contacts.map(ContactSurface::from_numbers);
        Self::from_numbers(FromNumbers::from_numbers(common), contacts)
    }
}

/// Returns the numbers of any result in the order of its fields, from its text.
pub fn numbers<T: FromStr>(result: &dyn Debug) -> Vec<T> {
    let text = format!("{result:?}");
    text.split(|c| " ,:()[]{}".contains(c)).filter_map(|word| word.parse().ok()).collect()
}

/// Returns the [`Results`] of a compiled robot: of `all` functions of one state that need no constraints and no actuators, or of the `default` ones.
///
/// `own` calls the functions of the type, `of_trait` those of the trait. With `own_with` and `trait_with`, and parameters at the
/// end, the functions that depend on run-time parameters are called with these. `each f;` calls `f` with each result for its
/// numbers.
#[macro_export]
macro_rules! results {
    (
        each $each:expr;
        $form:ident $robot:ty, $float:ident, $functions:ident, $given:expr, $links:expr $(, $params:expr)?
    ) => {{
        let (given, links, each) = ($given, $links, $each);
        let mut results = Vec::new();
        $(let params = $params;)?
        $crate::row_results! {
            [$functions ($form $robot, $float, given links each results [$($params, params)?])]
        }
        results
    }};
    ($form:ident $robot:ty, $float:ident, $($rest:tt)*) => {
        $crate::results!(each $crate::values::numbers::<$float>; $form $robot, $float, $($rest)*)
    };
}

/// Pushes the results of each function that all robots have. A row: whether it is a default
/// function, the function, its name, its name with parameters, its arguments, and its link.
#[doc(hidden)]
#[macro_export]
macro_rules! row_results {
    ([$functions:ident $to:tt]) => {
        $crate::row_results! {
            @each $functions $to
            // <!-- data: calls-of-tests -->
            default ForwardDynamics forward_dynamics [forward_dynamics_with] [q qd tau] [];
            default InverseDynamics inverse_dynamics [inverse_dynamics_with] [q qd qdd] [];
            default BiasForces bias_forces [bias_forces_with] [q qd] [];
            default GravityTorques gravity_torques [gravity_torques_with] [q] [];
            default MassMatrix mass_matrix [mass_matrix_with] [q] [];
            other CoriolisMatrix coriolis_matrix [coriolis_matrix_with] [q qd] [];
            default Brge brge [brge_with] [q] [];
            default KineticEnergy kinetic_energy [kinetic_energy_with] [q qd] [];
            default PotentialEnergy potential_energy [potential_energy_with] [q] [];
            other ForwardDynamicsExternalLocal forward_dynamics_external_local [forward_dynamics_external_local_with] [q qd tau forces] [];
            other ForwardDynamicsExternal forward_dynamics_external [forward_dynamics_external_with] [q qd tau forces] [];
            other InverseDynamicsExternalLocal inverse_dynamics_external_local [inverse_dynamics_external_local_with] [q qd qdd forces] [];
            other InverseDynamicsExternal inverse_dynamics_external [inverse_dynamics_external_with] [q qd qdd forces] [];
            other GeneralizedForcesLocal generalized_forces_local [] [q forces] [];
            other GeneralizedForces generalized_forces [] [q forces] [];
            other InverseDynamicsDerivatives inverse_dynamics_derivatives [inverse_dynamics_derivatives_with] [q qd qdd] [];
            other ForwardDynamicsDerivatives forward_dynamics_derivatives [forward_dynamics_derivatives_with] [q qd tau] [];
            other InverseDynamicsVjp inverse_dynamics_vjp [inverse_dynamics_vjp_with] [q qd qdd cotangent] [];
            other InverseDynamicsJvp inverse_dynamics_jvp [inverse_dynamics_jvp_with] [q qd qdd tangent_q tangent_qd tangent_qdd] [];
            other ForwardDynamicsVjp forward_dynamics_vjp [forward_dynamics_vjp_with] [q qd tau cotangent] [];
            other ForwardDynamicsJvp forward_dynamics_jvp [forward_dynamics_jvp_with] [q qd tau tangent_q tangent_qd tangent_tau] [];
            other InverseDynamicsHessian inverse_dynamics_hessian [inverse_dynamics_hessian_with] [q qd qdd cotangent] [];
            other ForwardDynamicsHessian forward_dynamics_hessian [forward_dynamics_hessian_with] [q qd tau cotangent] [];
            other StepSemiImplicit step_semi_implicit [step_semi_implicit_with] [q qd tau dt] [];
            other StepSemiImplicitDerivatives step_semi_implicit_derivatives [step_semi_implicit_derivatives_with] [q qd tau dt] [];
            other Knot knot [knot_with] [q qd tau dt] [];
            other StepSemiImplicitHessian step_semi_implicit_hessian [step_semi_implicit_hessian_with] [q qd tau dt state_cotangent] [];
            other StepRk4 step_rk4 [step_rk4_with] [q qd tau dt] [];
            other StepRk4Derivatives step_rk4_derivatives [step_rk4_derivatives_with] [q qd tau dt] [];
            other StepImplicitMidpoint step_implicit_midpoint [step_implicit_midpoint_with] [q qd tau dt] [];
            other StepImplicitMidpointDerivatives step_implicit_midpoint_derivatives [step_implicit_midpoint_derivatives_with] [q qd tau dt] [];
            other Step step [step_with] [q qd tau dt warm_start step_settings] [];
            other StepDerivatives step_derivatives [step_derivatives_with] [q qd tau dt warm_start step_settings] [];
            other StepVjp step_vjp [step_vjp_with] [q qd tau dt state_cotangent warm_start step_settings] [];
            other StepJvp step_jvp [step_jvp_with] [q qd tau tangent_q tangent_qd tangent_tau dt warm_start step_settings] [];
            other Regressor regressor [regressor_with] [q qd qdd] [];
            default CenterOfMass center_of_mass [center_of_mass_with] [q] [];
            other CenterOfMassJacobian center_of_mass_jacobian [center_of_mass_jacobian_with] [q] [];
            other CentroidalMomentumMatrix centroidal_momentum_matrix [centroidal_momentum_matrix_with] [q] [];
            other CentroidalCompositeInertia centroidal_composite_inertia [centroidal_composite_inertia_with] [q] [];
            other CentroidalMomentum centroidal_momentum [centroidal_momentum_with] [q qd] [];
            other CentroidalMomentumRate centroidal_momentum_rate [centroidal_momentum_rate_with] [q qd qdd] [];
            other CentroidalMomentumDerivatives centroidal_momentum_derivatives [centroidal_momentum_derivatives_with] [q qd qdd] [];
            default LinkPoses link_poses [] [q] [];
            default LinkPose link_pose [] [q] [link];
            other LinkVelocity link_velocity [] [q qd] [link];
            other LinkVelocityLocal link_velocity_local [] [q qd] [link];
            other LinkAcceleration link_acceleration [] [q qd qdd] [link];
            other LinkAccelerationLocal link_acceleration_local [] [q qd qdd] [link];
            default Jacobian jacobian [] [q] [link];
            other JacobianLocal jacobian_local [] [q] [link];
            other JacobianTimeDerivative jacobian_time_derivative [] [q qd] [link];
            other JacobianTimeDerivativeLocal jacobian_time_derivative_local [] [q qd] [link];
            other JacobianDotQd jacobian_dot_qd [] [q qd] [link];
            other JacobianDotQdLocal jacobian_dot_qd_local [] [q qd] [link];
            default Integrate integrate [] [q v] [];
            default Difference difference [] [from to] [];
            other IntegrateDerivatives integrate_derivatives [] [q v] [];
            other DifferenceDerivatives difference_derivatives [] [from to] [];
            default VelocityToQdot velocity_to_qdot [] [q qd] [];
            default NormalizeConfiguration normalize_configuration [] [q] [];
            default RandomConfiguration random_configuration [] [uniforms] [];
            // <!-- end -->
        }
    };
    (@each $functions:ident $to:tt $(
        $default:ident $function:ident $name:ident $with:tt $arguments:tt $link:tt;
    )*) => {
        $($crate::row_results! {
            @$functions $default $to $function $name $with $arguments $link
        })*
    };
    (@default other $($row:tt)*) => {};
    (@default default $($row:tt)*) => { $crate::row_results! { @row $($row)* } };
    (@all $default:ident $($row:tt)*) => { $crate::row_results! { @row $($row)* } };
    (@row (own_with $($to:tt)*) $function:ident $name:ident [] $($row:tt)*) => {};
    (@row (trait_with $($to:tt)*) $function:ident $name:ident [] $($row:tt)*) => {};
    (
        @row ($form:ident $robot:ty, $float:ident, $given:ident $links:ident $each:ident $results:ident $params:tt)
        $function:ident $name:ident $with:tt [$($argument:ident)*] [$($link:ident)?]
    ) => {{
        let given = $given(::modyn_runtime::quantities::Function::$function);
        let [$($argument),*] = &*given else { panic!("as many arguments as in the row") };
        let mut numbers = Vec::new();
        $(for $link in $links.iter().copied())? {
            let result = $crate::row_results!(
                @$form $robot, $float, $name $with $params
                ($($crate::row_results!(@argument $argument $argument)),* $(, $link)?)
            );
            numbers.extend($each(&result));
        }
        $results.push((::modyn_runtime::quantities::Function::$function, numbers));
    }};
    (@own $robot:ty, $float:ident, $name:ident $with:tt $params:tt ($($argument:expr),*)) => {
        <$robot>::$name($($argument),*)
    };
    (@of_trait $robot:ty, $float:ident, $name:ident $with:tt $params:tt ($($argument:expr),*)) => {
        <$robot as ::modyn_runtime::Robot>::$name::<$float>($($argument),*)
    };
    (@own_with $robot:ty, $float:ident, $name:ident [$with:ident] [$of:expr, $params:ident] ($($argument:expr),*)) => {
        <$robot>::$with($params, $($argument),*)
    };
    (@trait_with $robot:ty, $float:ident, $name:ident [$with:ident] [$of:expr, $params:ident] ($($argument:expr),*)) => {
        <$robot as ::modyn_runtime::Robot>::$with::<$float>($params, $($argument),*)
    };
    (@argument dt $numbers:ident) => { $crate::values::FromNumbers::from_numbers($numbers) };
    (@argument uniforms $numbers:ident) => {{
        let mut rest = $numbers.iter();
        move || $crate::values::FromNumbers::from_numbers(&[rest.next().copied().unwrap_or(0.0)])
    }};
    (@argument $name:ident $numbers:ident) => {
        &$crate::values::FromNumbers::from_numbers($numbers)
    };
}

/// Returns the results of a factorization that is called through the trait.
pub fn factors<R: Robot, T: Scalar>(
    brge: &R::UduFactorization<T>,
    tau: &R::V<T>,
    pivot_blocks: Vec<Vec<T>>,
) -> Factors<T> {
    Factors {
        u: columns(&brge.u()),
        d: columns(&brge.d()),
        u_inverse: columns(&brge.u_inverse()),
        d_inverse: columns(&brge.d_inverse()),
        solve: brge.solve(tau).as_ref().to_vec(),
        inverse: columns(&brge.inverse()),
        log_determinant: brge.log_determinant(),
        pivot_blocks,
        condition_numbers: (0..=R::MODULES.len())
            .filter_map(|m| brge.condition_number(m))
            .collect(),
    }
}

/// Returns the interpreter's results: of all functions of one state that need no constraints and no actuators, or of the default ones.
///
/// # Panics
///
/// If the modules or the arguments are not those of the model.
#[must_use]
pub fn interpreted(
    model: &Model,
    modules: &ModuleTree,
    arguments: Arguments<'_>,
    all: bool,
) -> Values<f64> {
    let mut robot =
        Interpreter::with_modules(model.clone(), modules.clone()).expect("its own modules");
    let is_computed = |function: &Function| {
        let row = function.row();
        row.is_general() && row.batch_of.is_none() && (all || row.default)
    };
    let functions = Function::ALL.iter().copied().filter(is_computed);
    let functions = functions
        .map(|function| {
            (function, interpreted_function(&mut robot, function, &arguments(function)))
        })
        .collect();
    let [q, _, tau] = &*arguments(Function::ForwardDynamics) else { panic!("three arguments") };
    let brge = robot.factors(q);
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
    Values { functions, factors }
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

/// Returns the numbers in double precision.
#[must_use]
pub fn double(numbers: &[f32]) -> Vec<f64> {
    numbers.iter().copied().map(f64::from).collect()
}
