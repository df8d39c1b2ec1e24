//! The evaluation of any function of the table on numbers.

mod components;
mod given;
mod records;

use components::{fill, write};
use given::{Given, parts};

use super::arguments::{
    COSTATE, COTANGENT, DQ, DQD, DQDD, DTAU, FROM, Q, QD, QDD, TAU, TO, UNIFORMS, V,
};
use super::function::Function;
use super::shape::{Shape, Sizes};
use crate::Scalar;
use crate::equations::Forces;
use crate::interpreter::{
    ActuatorOutputs, ForwardDerivatives, FrameError, HessianOutputs, Interpreter, ShapeError,
    StepHessianOutputs, StepOutputs, check,
};

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
    /// # Ok::<(), modyn_runtime::FrameError>(())
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
    ) -> Result<(), FrameError> {
        let row = function.row();
        let sizes = self.sizes();
        if let Some(joint) = self.joint_without_inertia().filter(|_| row.needs_inertia) {
            return Err(FrameError::NoInertia { joint });
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
        compute(self, function, &given, &shape, result)
    }

    /// Returns the sizes of the robot, which the lengths of arguments and results follow from.
    #[must_use]
    pub fn sizes(&self) -> Sizes {
        Sizes::new(self.model(), self.layout().size())
    }
}

/// Computes a function from numbers of the right lengths; a function of many states for one of them.
fn compute<S: Scalar>(
    robot: &mut Interpreter<S>,
    function: Function,
    given: &Given<'_, S>,
    shape: &Shape,
    out: &mut [S],
) -> Result<(), FrameError> {
    use Function as F;

    let link = given.link;
    match function {
        F::ForwardDynamics | F::ForwardDynamicsBatch => {
            robot.forward_dynamics(&given[Q], &given[QD], &given[TAU], out)?
        }
        F::InverseDynamics | F::InverseDynamicsBatch => {
            robot.inverse_dynamics(&given[Q], &given[QD], &given[QDD], out)?
        }
        F::BiasForces | F::BiasForcesBatch => robot.bias_forces(&given[Q], &given[QD], out)?,
        F::GravityTorques | F::GravityTorquesBatch => robot.gravity_torques(&given[Q], out)?,
        F::MassMatrix | F::MassMatrixBatch => robot.mass_matrix(&given[Q], out)?,
        F::CoriolisMatrix => robot.coriolis_matrix(&given[Q], &given[QD], out)?,
        F::Brge | F::BrgeBatch => robot.factorize(&given[Q], out),
        F::KineticEnergy | F::KineticEnergyBatch => {
            out[0] = robot.kinetic_energy(&given[Q], &given[QD])?
        }
        F::PotentialEnergy | F::PotentialEnergyBatch => {
            out[0] = robot.potential_energy(&given[Q])?
        }
        F::ForwardDynamicsExternalLocal => {
            let wrenches = given.forces();
            let forces = Forces::InLinkAxes(&wrenches);
            robot.forward_dynamics_external(&given[Q], &given[QD], &given[TAU], forces, out)?;
        }
        F::ForwardDynamicsExternal => {
            let wrenches = given.forces();
            let forces = Forces::InWorldAxes(&wrenches);
            robot.forward_dynamics_external(&given[Q], &given[QD], &given[TAU], forces, out)?;
        }
        F::InverseDynamicsExternalLocal => {
            let wrenches = given.forces();
            let forces = Forces::InLinkAxes(&wrenches);
            robot.inverse_dynamics_external(&given[Q], &given[QD], &given[QDD], forces, out)?;
        }
        F::InverseDynamicsExternal => {
            let wrenches = given.forces();
            let forces = Forces::InWorldAxes(&wrenches);
            robot.inverse_dynamics_external(&given[Q], &given[QD], &given[QDD], forces, out)?;
        }
        F::GeneralizedForcesLocal => {
            let [tau, dq] = parts(shape, out);
            robot.generalized_forces(&given[Q], Forces::InLinkAxes(&given.forces()), tau, dq)?;
        }
        F::GeneralizedForces => {
            let [tau, dq] = parts(shape, out);
            robot.generalized_forces(&given[Q], Forces::InWorldAxes(&given.forces()), tau, dq)?;
        }
        F::InverseDynamicsDerivatives | F::InverseDynamicsDerivativesBatch => {
            let [dq, dqd] = parts(shape, out);
            robot.inverse_dynamics_derivatives(&given[Q], &given[QD], &given[QDD], dq, dqd)?;
        }
        F::ForwardDynamicsDerivatives | F::ForwardDynamicsDerivativesBatch => {
            let [qdd, dqdd_dq, dqdd_dqd, dqdd_dtau] = parts(shape, out);
            let outputs = ForwardDerivatives { qdd, dqdd_dq, dqdd_dqd, dqdd_dtau };
            robot.forward_dynamics_derivatives(&given[Q], &given[QD], &given[TAU], outputs)?;
        }
        F::InverseDynamicsVjp => {
            let [tau, gradients @ ..] = parts::<_, 4>(shape, out);
            robot.inverse_dynamics_vjp(given.motion(), &given[COTANGENT], tau, gradients)?;
        }
        F::InverseDynamicsJvp => {
            let [tau, dtau] = parts(shape, out);
            let change = [DQ, DQD, DQDD].map(|argument| &given[argument]);
            robot.inverse_dynamics_jvp(given.motion(), change, tau, dtau)?;
        }
        F::ForwardDynamicsVjp => {
            let [qdd, gradients @ ..] = parts::<_, 4>(shape, out);
            robot.forward_dynamics_vjp(given.forward_input(), &given[COTANGENT], qdd, gradients)?;
        }
        F::ForwardDynamicsJvp => {
            let [qdd, dqdd] = parts(shape, out);
            let change = [DQ, DQD, DTAU].map(|argument| &given[argument]);
            robot.forward_dynamics_jvp(given.forward_input(), change, qdd, dqdd)?;
        }
        F::InverseDynamicsHessian | F::InverseDynamicsHessianBatch => {
            let [value, dx, dy, dz, hessian @ ..] = parts::<_, 8>(shape, out);
            let outputs = HessianOutputs { value, gradients: [dx, dy, dz], hessian };
            robot.inverse_dynamics_hessian(given.motion(), &given[COTANGENT], outputs)?;
        }
        F::ForwardDynamicsHessian | F::ForwardDynamicsHessianBatch => {
            let [value, dx, dy, dz, hessian @ ..] = parts::<_, 8>(shape, out);
            let outputs = HessianOutputs { value, gradients: [dx, dy, dz], hessian };
            robot.forward_dynamics_hessian(given.forward_input(), &given[COTANGENT], outputs)?;
        }
        F::StepSemiImplicit => {
            let [q, qd] = parts(shape, out);
            robot.step_semi_implicit(given.time_step(), q, qd)?;
        }
        F::StepSemiImplicitDerivatives => {
            let [q, qd, a, b] = parts(shape, out);
            robot.step_semi_implicit_derivatives(given.time_step(), StepOutputs { q, qd, a, b })?;
        }
        F::StepSemiImplicitHessian => {
            let [q, qd, dx, dtau, dx_dx, dx_dtau, dtau_dtau] = parts(shape, out);
            let outputs = StepHessianOutputs { q, qd, dx, dtau, dx_dx, dx_dtau, dtau_dtau };
            robot.step_semi_implicit_hessian(given.time_step(), &given[COSTATE], outputs)?;
        }
        F::StepRk4 => {
            let [q, qd] = parts(shape, out);
            robot.step_rk4(given.time_step(), q, qd)?;
        }
        F::StepRk4Derivatives => {
            let [q, qd, a, b] = parts(shape, out);
            robot.step_rk4_derivatives(given.time_step(), StepOutputs { q, qd, a, b })?;
        }
        F::StepImplicitMidpoint => {
            let [q, qd] = parts(shape, out);
            robot.step_implicit_midpoint(given.time_step(), q, qd)?;
        }
        F::StepImplicitMidpointDerivatives => {
            let [q, qd, a, b] = parts(shape, out);
            robot.step_implicit_midpoint_derivatives(
                given.time_step(),
                StepOutputs { q, qd, a, b },
            )?;
        }
        F::ConstrainedForwardDynamics | F::ConstrainedForwardDynamicsBatch => {
            records::constrained_forward_dynamics(robot, given, parts(shape, out))
        }
        F::ConstraintResidual | F::ConstraintResidualBatch => {
            records::constraint_residual(robot, given, parts(shape, out))?
        }
        F::ProjectConstraints | F::ProjectConstraintsBatch => {
            records::project_constraints(robot, given, parts(shape, out))
        }
        F::ConstrainedForwardDynamicsDerivatives
        | F::ConstrainedForwardDynamicsDerivativesBatch => {
            records::constrained_forward_dynamics_derivatives(robot, given, parts(shape, out))
        }
        F::ConstrainedForwardDynamicsHessian => {
            records::constrained_forward_dynamics_hessian(robot, given, parts(shape, out))
        }
        F::ImpactDynamics | F::ImpactDynamicsBatch => {
            records::impact_dynamics(robot, given, parts(shape, out))
        }
        F::Step => records::step(robot, given, parts(shape, out))?,
        F::StepDerivatives => records::step_derivatives(robot, given, parts(shape, out))?,
        F::Actuate | F::ActuateBatch => {
            let [tau, act] = parts(shape, out);
            robot.actuate(given.actuator_input(), ActuatorOutputs { tau, act })?;
        }
        F::StepActuated => records::step_actuated(robot, given, parts(shape, out))?,
        F::StepActuatedDerivatives => {
            records::step_actuated_derivatives(robot, given, parts(shape, out))?;
        }
        F::ConstrainedInverseDynamics | F::ConstrainedInverseDynamicsBatch => {
            records::constrained_inverse_dynamics(robot, given, parts(shape, out))
        }
        F::ConstraintJacobian | F::ConstraintJacobianBatch => {
            fill(out, |columns| robot.constraint_jacobian(&given[Q], columns))?
        }
        F::ConstraintJacobianDotQd | F::ConstraintJacobianDotQdBatch => {
            fill(out, |twists| robot.constraint_jacobian_dot_qd(given.state(), twists))?
        }
        F::OperationalSpaceInertia | F::OperationalSpaceInertiaBatch => {
            records::operational_space_inertia(robot, given, parts(shape, out))
        }
        F::Regressor => robot.regressor(&given[Q], &given[QD], &given[QDD], out)?,
        F::CenterOfMass => out.copy_from_slice(&robot.center_of_mass(&given[Q])?),
        F::CenterOfMassJacobian => {
            fill(out, |columns| robot.center_of_mass_jacobian(&given[Q], columns))?
        }
        F::CentroidalMomentumMatrix => {
            fill(out, |columns| robot.centroidal_momentum_matrix(&given[Q], columns))?
        }
        F::CentroidalCompositeInertia => records::centroidal_composite_inertia(robot, given, out)?,
        F::CentroidalMomentum => write(&[robot.centroidal_momentum(&given[Q], &given[QD])?], out),
        F::CentroidalMomentumRate => write(&[robot.centroidal_momentum_rate(given.motion())?], out),
        F::CentroidalMomentumDerivatives => {
            records::centroidal_momentum_derivatives(robot, given, parts(shape, out))?
        }
        F::LinkPoses => fill(out, |poses| robot.link_poses(&given[Q], poses))?,
        F::LinkPose => write(&[robot.link_pose(&given[Q], link)?], out),
        F::LinkVelocity => write(&[robot.link_velocity(&given[Q], &given[QD], link)?], out),
        F::LinkVelocityLocal => {
            write(&[robot.link_velocity_local(&given[Q], &given[QD], link)?], out)
        }
        F::LinkAcceleration => {
            let acceleration = robot.link_acceleration(&given[Q], &given[QD], &given[QDD], link)?;
            write(&[acceleration], out);
        }
        F::LinkAccelerationLocal => {
            let acceleration =
                robot.link_acceleration_local(&given[Q], &given[QD], &given[QDD], link)?;
            write(&[acceleration], out);
        }
        F::Jacobian => fill(out, |columns| robot.jacobian(&given[Q], link, columns))?,
        F::JacobianLocal => fill(out, |columns| robot.jacobian_local(&given[Q], link, columns))?,
        F::JacobianTimeDerivative => fill(out, |columns| {
            robot.jacobian_time_derivative(&given[Q], &given[QD], link, columns)
        })?,
        F::JacobianTimeDerivativeLocal => fill(out, |columns| {
            robot.jacobian_time_derivative_local(&given[Q], &given[QD], link, columns)
        })?,
        F::JacobianDotQd => write(&[robot.jacobian_dot_qd(&given[Q], &given[QD], link)?], out),
        F::JacobianDotQdLocal => {
            write(&[robot.jacobian_dot_qd_local(&given[Q], &given[QD], link)?], out)
        }
        F::Integrate => robot.integrate(&given[Q], &given[V], out)?,
        F::Difference => robot.difference(&given[FROM], &given[TO], out)?,
        F::IntegrateDerivatives => {
            let [dq, dv] = parts(shape, out);
            robot.integrate_derivatives(&given[Q], &given[V], dq, dv)?;
        }
        F::DifferenceDerivatives => {
            let [dfrom, dto] = parts(shape, out);
            robot.difference_derivatives(&given[FROM], &given[TO], dfrom, dto)?;
        }
        F::VelocityToQdot => robot.velocity_to_qdot(&given[Q], &given[QD], out)?,
        F::Normalize => {
            out.copy_from_slice(&given[Q]);
            robot.normalize(out)?;
        }
        F::Random => {
            let mut numbers = given[UNIFORMS].iter().copied();
            robot.random(|| numbers.next().unwrap_or_else(S::zero), out)?;
        }
    }
    Ok(())
}
