//! The evaluation of any function of the table on numbers.

mod call;
mod components;
mod derivatives;
mod external;
mod records;
mod steps;

use call::{Call, Given, Output};

use super::arguments::{FROM, Q, QD, QDD, TAU, TO, UNIFORMS, V};
use super::function::Function;
use super::shape::Sizes;
use crate::Scalar;
use crate::equations::Forces;
use crate::interpreter::{Interpreter, LinkError, ShapeError, check};
use crate::spatial::Vector3;

impl<S: Scalar> Interpreter<S> {
    /// Computes any function of the table from numbers: `arguments` has a slice for each argument
    /// of its [row](Function::row), and `result` receives the numbers in the order of the row's
    /// result. `link` is the link of a function of one link, as an index into the links of the
    /// description; other functions ignore it. A function of many states is computed for one.
    ///
    /// A set of active contacts is a number for each contact, 1 or 0. The settings of constraints
    /// are [`ConstraintSettings::numbers`](crate::ConstraintSettings::numbers), then
    /// [`ContactTarget::numbers`](crate::ContactTarget::numbers) for each contact.
    /// Allocates memory at each call.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::Interpreter;
    /// use modyn_runtime::quantities::Function;
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let mut energy = [0.0];
    /// pendulum.evaluate(Function::KineticEnergy, &[&[0.3], &[2.0]], 0, &mut energy)?;
    /// assert_eq!(energy, [0.5 * 2.0 * 1.0]);
    /// # Ok::<(), modyn_runtime::LinkError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If there are not as many arguments as in the row, if a slice does not have the length of its
    /// argument, if there is no such link, or if the function needs inertia and a joint
    /// [moves none](Self::joint_without_inertia).
    pub fn evaluate(
        &mut self,
        function: Function,
        arguments: &[&[S]],
        link: usize,
        result: &mut [S],
    ) -> Result<(), LinkError> {
        let row = function.row();
        let sizes = self.sizes();
        if let Some(joint) = self.joint_without_inertia().filter(|_| row.needs_inertia) {
            return Err(LinkError::NoInertia { joint });
        }
        if arguments.len() != row.arguments.len() {
            let expected = row.arguments.len();
            let count = arguments.len();
            return Err(ShapeError::new("arguments", expected, count).into());
        }
        for (argument, numbers) in row.arguments.iter().zip(arguments) {
            check(argument.name, numbers, argument.shape(&sizes).len())?;
        }
        let shape = (row.result)(&sizes);
        check(function.result_name(), result, shape.len())?;
        let given = Given { arguments: row.arguments, numbers: arguments, link };
        let out = Output { shape: &shape, numbers: result };
        compute(function, Call { robot: self, given, out })
    }

    /// Returns the sizes of the robot, which the lengths of arguments and results follow from.
    #[must_use]
    pub fn sizes(&self) -> Sizes {
        Sizes::new(self.model(), self.layout().size())
    }
}

/// Computes a function from numbers of the right lengths; a function of many states for one of them.
fn compute<S: Scalar>(function: Function, call: Call<'_, S>) -> Result<(), LinkError> {
    use Function as F;

    let given = call.given;
    let link = given.link;
    match function {
        F::ForwardDynamics | F::ForwardDynamicsBatch => call.numbers(|robot, out| {
            robot.forward_dynamics(&given[Q], &given[QD], &given[TAU], out)
        })?,
        F::InverseDynamics | F::InverseDynamicsBatch => call.numbers(|robot, out| {
            robot.inverse_dynamics(&given[Q], &given[QD], &given[QDD], out)
        })?,
        F::BiasForces | F::BiasForcesBatch => {
            call.numbers(|robot, out| robot.bias_forces(&given[Q], &given[QD], out))?
        }
        F::GravityTorques | F::GravityTorquesBatch => {
            call.numbers(|robot, out| robot.gravity_torques(&given[Q], out))?
        }
        F::MassMatrix | F::MassMatrixBatch => {
            call.numbers(|robot, out| robot.mass_matrix(&given[Q], out))?
        }
        F::CoriolisMatrix => {
            call.numbers(|robot, out| robot.coriolis_matrix(&given[Q], &given[QD], out))?
        }
        F::Brge | F::BrgeBatch => call.robot.factorize(&given[Q], call.out.numbers),
        F::KineticEnergy | F::KineticEnergyBatch => {
            call.number(|robot| robot.kinetic_energy(&given[Q], &given[QD]))?
        }
        F::PotentialEnergy | F::PotentialEnergyBatch => {
            call.number(|robot| robot.potential_energy(&given[Q]))?
        }
        F::ForwardDynamicsExternalLocal => {
            call.forward_dynamics_external(Forces::InLinkAxes(&given.forces()))?
        }
        F::ForwardDynamicsExternal => {
            call.forward_dynamics_external(Forces::InWorldAxes(&given.forces()))?
        }
        F::InverseDynamicsExternalLocal => {
            call.inverse_dynamics_external(Forces::InLinkAxes(&given.forces()))?
        }
        F::InverseDynamicsExternal => {
            call.inverse_dynamics_external(Forces::InWorldAxes(&given.forces()))?
        }
        F::GeneralizedForcesLocal => {
            call.generalized_forces(Forces::InLinkAxes(&given.forces()))?
        }
        F::GeneralizedForces => call.generalized_forces(Forces::InWorldAxes(&given.forces()))?,
        F::InverseDynamicsDerivatives | F::InverseDynamicsDerivativesBatch => {
            call.inverse_dynamics_derivatives()?
        }
        F::ForwardDynamicsDerivatives | F::ForwardDynamicsDerivativesBatch => {
            call.forward_dynamics_derivatives()?
        }
        F::InverseDynamicsVjp => call.inverse_dynamics_vjp()?,
        F::InverseDynamicsJvp => call.inverse_dynamics_jvp()?,
        F::ForwardDynamicsVjp => call.forward_dynamics_vjp()?,
        F::ForwardDynamicsJvp => call.forward_dynamics_jvp()?,
        F::InverseDynamicsHessian | F::InverseDynamicsHessianBatch => {
            call.inverse_dynamics_hessian()?
        }
        F::ForwardDynamicsHessian | F::ForwardDynamicsHessianBatch => {
            call.forward_dynamics_hessian()?
        }
        F::StepSemiImplicit => call.step_semi_implicit()?,
        F::StepSemiImplicitDerivatives => call.step_semi_implicit_derivatives()?,
        F::Knot | F::KnotBatch => call.knot()?,
        F::StepSemiImplicitHessian => call.step_semi_implicit_hessian()?,
        F::StepRk4 => call.step_rk4()?,
        F::StepRk4Derivatives => call.step_rk4_derivatives()?,
        F::StepImplicitMidpoint => call.step_implicit_midpoint()?,
        F::StepImplicitMidpointDerivatives => call.step_implicit_midpoint_derivatives()?,
        F::ConstrainedForwardDynamics | F::ConstrainedForwardDynamicsBatch => {
            call.constrained_forward_dynamics()
        }
        F::ConstraintResidual | F::ConstraintResidualBatch => call.constraint_residual()?,
        F::ProjectConstraints | F::ProjectConstraintsBatch => call.project_constraints(),
        F::ConstrainedForwardDynamicsDerivatives
        | F::ConstrainedForwardDynamicsDerivativesBatch => {
            call.constrained_forward_dynamics_derivatives()
        }
        F::ConstrainedKnot | F::ConstrainedKnotBatch => call.constrained_knot(),
        F::ConstrainedForwardDynamicsHessian => call.constrained_forward_dynamics_hessian(),
        F::ImpactDynamics | F::ImpactDynamicsBatch => call.impact_dynamics(),
        F::Step => call.step()?,
        F::StepDerivatives => call.step_derivatives()?,
        F::StepVjp => call.step_vjp()?,
        F::StepJvp => call.step_jvp()?,
        F::TouchingPoints | F::TouchingPointsBatch => call.touching_points()?,
        F::Actuate | F::ActuateBatch => call.actuate()?,
        F::StepActuated => call.step_actuated()?,
        F::StepActuatedDerivatives => call.step_actuated_derivatives()?,
        F::StepActuatedVjp => call.step_actuated_vjp()?,
        F::StepActuatedJvp => call.step_actuated_jvp()?,
        F::ConstrainedInverseDynamics | F::ConstrainedInverseDynamicsBatch => {
            call.constrained_inverse_dynamics()
        }
        F::ConstraintJacobian | F::ConstraintJacobianBatch => {
            call.objects(|robot, columns| robot.constraint_jacobian(&given[Q], columns))?
        }
        F::ConstraintJacobianDotQd | F::ConstraintJacobianDotQdBatch => {
            call.objects(|robot, twists| robot.constraint_jacobian_dot_qd(given.state(), twists))?
        }
        F::OperationalSpaceInertia | F::OperationalSpaceInertiaBatch => {
            call.operational_space_inertia()
        }
        F::Regressor => {
            call.numbers(|robot, out| robot.regressor(&given[Q], &given[QD], &given[QDD], out))?
        }
        F::CenterOfMass => call.object(|robot| robot.center_of_mass(&given[Q]).map(Vector3))?,
        F::CenterOfMassJacobian => {
            call.objects(|robot, columns| robot.center_of_mass_jacobian(&given[Q], columns))?
        }
        F::CentroidalMomentumMatrix => {
            call.objects(|robot, columns| robot.centroidal_momentum_matrix(&given[Q], columns))?
        }
        F::CentroidalCompositeInertia => call.centroidal_composite_inertia()?,
        F::CentroidalMomentum => {
            call.object(|robot| robot.centroidal_momentum(&given[Q], &given[QD]))?
        }
        F::CentroidalMomentumRate => {
            call.object(|robot| robot.centroidal_momentum_rate(given.motion()))?
        }
        F::CentroidalMomentumDerivatives => call.centroidal_momentum_derivatives()?,
        F::LinkPoses => call.objects(|robot, poses| robot.link_poses(&given[Q], poses))?,
        F::LinkPose => call.object(|robot| robot.link_pose(&given[Q], link))?,
        F::LinkVelocity => call.object(|robot| robot.link_velocity(&given[Q], &given[QD], link))?,
        F::LinkVelocityLocal => {
            call.object(|robot| robot.link_velocity_local(&given[Q], &given[QD], link))?
        }
        F::LinkAcceleration => {
            call.object(|robot| robot.link_acceleration(&given[Q], &given[QD], &given[QDD], link))?
        }
        F::LinkAccelerationLocal => call.object(|robot| {
            robot.link_acceleration_local(&given[Q], &given[QD], &given[QDD], link)
        })?,
        F::Jacobian => call.objects(|robot, columns| robot.jacobian(&given[Q], link, columns))?,
        F::JacobianLocal => {
            call.objects(|robot, columns| robot.jacobian_local(&given[Q], link, columns))?
        }
        F::JacobianTimeDerivative => call.objects(|robot, columns| {
            robot.jacobian_time_derivative(&given[Q], &given[QD], link, columns)
        })?,
        F::JacobianTimeDerivativeLocal => call.objects(|robot, columns| {
            robot.jacobian_time_derivative_local(&given[Q], &given[QD], link, columns)
        })?,
        F::JacobianDotQd => {
            call.object(|robot| robot.jacobian_dot_qd(&given[Q], &given[QD], link))?
        }
        F::JacobianDotQdLocal => {
            call.object(|robot| robot.jacobian_dot_qd_local(&given[Q], &given[QD], link))?
        }
        F::Integrate => call.numbers(|robot, out| robot.integrate(&given[Q], &given[V], out))?,
        F::Difference => {
            call.numbers(|robot, out| robot.difference(&given[FROM], &given[TO], out))?
        }
        F::IntegrateDerivatives => call.integrate_derivatives()?,
        F::DifferenceDerivatives => call.difference_derivatives()?,
        F::VelocityToQdot => {
            call.numbers(|robot, out| robot.velocity_to_qdot(&given[Q], &given[QD], out))?
        }
        F::NormalizeConfiguration => {
            call.out.numbers.copy_from_slice(&given[Q]);
            call.robot.normalize_configuration(call.out.numbers)?;
        }
        F::RandomConfiguration => {
            let mut numbers = given[UNIFORMS].iter().copied();
            call.robot.random_configuration(
                || numbers.next().unwrap_or_else(S::zero),
                call.out.numbers,
            )?;
        }
    }
    Ok(())
}
