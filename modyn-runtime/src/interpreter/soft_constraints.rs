//! Steps with soft constraints.

use alloc::{vec, vec::Vec};

use super::errors::{ShapeError, check};
use super::{Interpreter, UduFactorization};
use crate::equations::State;
use crate::equations::actuation::{ActuationWorkspace, ActuatorInput, depends_on_rate, moments};
use crate::equations::dynamics::Elimination;
use crate::equations::soft_constraints::{
    ActuatedForces, ActuatedInput, ContactParameters, CouplingParameters, DampingMatrix,
    JointParameters, Length, LengthTerm, LoopParameters, SoftModel, SoftStep, SpringParameters,
    StepConstraints, StepDrive, StepInput, StepProblem, StopParameters, TendonParameters,
    TouchingPoint, couples, next_state, soft_step, state_derivatives_by_newton, touching_points,
};
use crate::joint::JointType;
use crate::mechanism::Mechanism;
use crate::model::{
    Integrator, JointFriction, JointSum, LoopConstraint, LoopSoftness, Model, ModuleTree,
    SoftConstraints, SoftCoupling, SoftTendon, Softness, TendonSpring, TouchingShape,
};
use crate::spatial::{Twist, Vector3};
use crate::{ContactSurface, Portable, Scalar, StepSettings};

/// The acceleration by gravity in the unit of residuals, m/s^2.
const EARTH: f64 = 9.81;

/// The weight of a robot whose joints have rotors and whose links have no mass, N: residuals are finite.
const LEAST_WEIGHT: f64 = 1e-30;

const LENGTHS: &str = "the lengths are the model's";

/// The results of [`Interpreter::step`].
pub struct StepSolutionOutputs<'a, S> {
    /// The coordinates after the step.
    pub q: &'a mut [S],
    /// The velocities after the step.
    pub qd: &'a mut [S],
    /// The accelerations.
    pub qdd: &'a mut [S],
    /// The force of each point of the shapes that touch the ground, along the x and y axes of the
    /// plane, then along the normal, N.
    pub forces: &'a mut [S],
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's weight and the
    /// largest force.
    pub residual: &'a mut S,
    /// The number of iterations.
    pub iterations: &'a mut S,
}

/// The derivatives of the state after a step, by columns. A state has the entries of q, in tangent
/// space, of qd, and the activations of actuators.
pub struct StateDerivatives<'a, S> {
    /// With respect to the state before the step.
    pub a: &'a mut [S],
    /// With respect to the joint forces, or to the controls of actuators.
    pub b: &'a mut [S],
}

impl<S: Copy> StateDerivatives<'_, S> {
    /// Checks the lengths for states and inputs of these lengths.
    fn check(&self, states: usize, inputs: usize) -> Result<(), ShapeError> {
        check("a", self.a, states * states)?;
        check("b", self.b, states * inputs)
    }

    /// Sets the columns.
    fn fill(self, columns: Vec<Vec<S>>) {
        let entries = columns.into_iter().flatten();
        self.a.iter_mut().chain(self.b).zip(entries).for_each(|(out, entry)| *out = entry);
    }
}

/// The gradients of a weighted sum of the state after a step. A state has the entries of q, in
/// tangent space, of qd, then the activations of a step under controls.
pub struct StateGradients<'a, S> {
    /// The weights of the coordinates and the velocities.
    pub state_cotangent: &'a [S],
    /// The weights of the activations; none for a step under joint forces.
    pub act_cotangent: &'a [S],
    /// The gradient with respect to the state before the step.
    pub grad_x: &'a mut [S],
    /// The gradient with respect to the joint forces or the controls.
    pub grad_u: &'a mut [S],
}

impl<S: Scalar> StateGradients<'_, S> {
    /// Checks the lengths for so many velocities, activations and inputs.
    fn check(&self, [nv, activations, inputs]: [usize; 3]) -> Result<(), ShapeError> {
        check("state_cotangent", self.state_cotangent, 2 * nv)?;
        check("act_cotangent", self.act_cotangent, activations)?;
        check("grad_x", self.grad_x, 2 * nv + activations)?;
        check("grad_u", self.grad_u, inputs)
    }

    /// Sets the gradients by the columns of the derivatives.
    fn fill(self, columns: &[Vec<S>]) {
        let weights = || self.state_cotangent.iter().chain(self.act_cotangent);
        for (gradient, column) in self.grad_x.iter_mut().chain(self.grad_u).zip(columns) {
            let products = weights().zip(column).map(|(&weight, &entry)| weight * entry);
            *gradient = products.fold(S::zero(), |sum, product| sum + product);
        }
    }
}

/// The change of the state after a step under a change of its arguments. A state has the entries of
/// q, in tangent space, of qd, then the activations of a step under controls.
pub struct StateChange<'a, S> {
    /// The change of the coordinates, in tangent space.
    pub tangent_q: &'a [S],
    /// The change of the velocities.
    pub tangent_qd: &'a [S],
    /// The change of the activations; none for a step under joint forces.
    pub tangent_act: &'a [S],
    /// The change of the joint forces or the controls.
    pub tangent_u: &'a [S],
    /// The change of the state after the step.
    pub tangent_x: &'a mut [S],
}

impl<S: Scalar> StateChange<'_, S> {
    /// Checks the lengths for so many velocities, activations and inputs.
    fn check(&self, [nv, activations, inputs]: [usize; 3]) -> Result<(), ShapeError> {
        check("tangent_q", self.tangent_q, nv)?;
        check("tangent_qd", self.tangent_qd, nv)?;
        check("tangent_act", self.tangent_act, activations)?;
        check("tangent_u", self.tangent_u, inputs)?;
        check("tangent_x", self.tangent_x, 2 * nv + activations)
    }

    /// Sets the change by the columns of the derivatives.
    fn fill(self, columns: &[Vec<S>]) {
        self.tangent_x.fill(S::zero());
        let changes = [self.tangent_q, self.tangent_qd, self.tangent_act, self.tangent_u]
            .into_iter()
            .flatten();
        for (&change, column) in changes.zip(columns) {
            for (sum, &entry) in self.tangent_x.iter_mut().zip(column) {
                *sum = *sum + change * entry;
            }
        }
    }
}

impl<S: Scalar> Interpreter<S> {
    /// Computes the state after a step with contacts, joint limits and dry joint friction: see
    /// [`step`](crate::Robot::step). Allocates memory at each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step(
        &mut self,
        input: StepInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        let dampers = DampingMatrix::zero(input.step.qd.len());
        self.damped_step(input, &dampers, settings, outputs)
    }

    /// Computes the results of [`step`](Self::step), and the derivatives of the state after it: see
    /// [`step_derivatives`](crate::Robot::step_derivatives). Allocates memory at each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_derivatives(
        &mut self,
        input: StepInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
        derivatives: StateDerivatives<'_, S>,
    ) -> Result<(), ShapeError> {
        derivatives.check(2 * self.model.nv(), self.model.nv())?;
        derivatives.fill(self.columns_of_step(input, settings, outputs)?);
        Ok(())
    }

    /// Computes the results of [`step`](Self::step), and the gradients of a weighted sum of the
    /// state after it: see [`step_vjp`](crate::Robot::step_vjp). Allocates memory at each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_vjp(
        &mut self,
        input: StepInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
        gradients: StateGradients<'_, S>,
    ) -> Result<(), ShapeError> {
        gradients.check([self.model.nv(), 0, self.model.nv()])?;
        gradients.fill(&self.columns_of_step(input, settings, outputs)?);
        Ok(())
    }

    /// Computes the results of [`step`](Self::step), and the change of the state after it: see
    /// [`step_jvp`](crate::Robot::step_jvp). Allocates memory at each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_jvp(
        &mut self,
        input: StepInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
        change: StateChange<'_, S>,
    ) -> Result<(), ShapeError> {
        change.check([self.model.nv(), 0, self.model.nv()])?;
        change.fill(&self.columns_of_step(input, settings, outputs)?);
        Ok(())
    }

    /// Computes the results of [`step_actuated`](Self::step_actuated), and the derivatives of the
    /// state and the activations after it: see
    /// [`step_actuated_derivatives`](crate::Robot::step_actuated_derivatives). Allocates memory at
    /// each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_actuated_derivatives(
        &mut self,
        input: ActuatedInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
        next_act: &mut [S],
        derivatives: StateDerivatives<'_, S>,
    ) -> Result<(), ShapeError> {
        let ActuatorInput { act, ctrl, .. } = input.actuators;
        derivatives.check(2 * self.model.nv() + act.len(), ctrl.len())?;
        derivatives.fill(self.columns_of_actuated_step(input, settings, outputs, next_act)?);
        Ok(())
    }

    /// Computes the results of [`step_actuated`](Self::step_actuated), and the gradients of a
    /// weighted sum of the state and the activations after it: see
    /// [`step_actuated_vjp`](crate::Robot::step_actuated_vjp). Allocates memory at each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_actuated_vjp(
        &mut self,
        input: ActuatedInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
        next_act: &mut [S],
        gradients: StateGradients<'_, S>,
    ) -> Result<(), ShapeError> {
        let ActuatorInput { act, ctrl, .. } = input.actuators;
        gradients.check([self.model.nv(), act.len(), ctrl.len()])?;
        gradients.fill(&self.columns_of_actuated_step(input, settings, outputs, next_act)?);
        Ok(())
    }

    /// Computes the results of [`step_actuated`](Self::step_actuated), and the change of the state
    /// and the activations after it: see [`step_actuated_jvp`](crate::Robot::step_actuated_jvp).
    /// Allocates memory at each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_actuated_jvp(
        &mut self,
        input: ActuatedInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
        next_act: &mut [S],
        change: StateChange<'_, S>,
    ) -> Result<(), ShapeError> {
        let ActuatorInput { act, ctrl, .. } = input.actuators;
        change.check([self.model.nv(), act.len(), ctrl.len()])?;
        change.fill(&self.columns_of_actuated_step(input, settings, outputs, next_act)?);
        Ok(())
    }

    /// Computes a step, and returns the columns of the derivatives of the state after it.
    fn columns_of_step(
        &mut self,
        input: StepInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
    ) -> Result<Vec<Vec<S>>, ShapeError> {
        let StepSolutionOutputs { q, qd, qdd, forces, residual, iterations } = outputs;
        let solution = StepSolutionOutputs { q, qd, qdd: &mut *qdd, forces, residual, iterations };
        self.step(input, settings, solution)?;
        let drive = StepDrive::Forces(input.step.tau);
        let at_solution = StepInput { warm_start: qdd, ..input };
        Ok(self.state_derivatives(at_solution, settings, |_| drive))
    }

    /// Computes a step under controls, and returns the columns of the derivatives of the state and
    /// the activations after it.
    fn columns_of_actuated_step(
        &mut self,
        input: ActuatedInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
        next_act: &mut [S],
    ) -> Result<Vec<Vec<S>>, ShapeError> {
        let StepSolutionOutputs { q, qd, qdd, forces, residual, iterations } = outputs;
        let solution = StepSolutionOutputs { q, qd, qdd: &mut *qdd, forces, residual, iterations };
        self.step_actuated(input, settings, solution, next_act)?;
        let Self { model, mechanism, .. } = self;
        let workspace = &mut ActuationWorkspace::new(model);
        let tau = input.forces(model, mechanism, workspace).tau;
        let at_solution = StepInput { warm_start: qdd, ..input.under(&tau) };
        Ok(self
            .state_derivatives(at_solution, settings, |model| StepDrive::Actuators(model, input)))
    }

    /// Returns the columns of the derivatives of the state after a step, whose input starts from its
    /// solution.
    fn state_derivatives<'a>(
        &'a mut self,
        input: StepInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        drive: impl FnOnce(&'a Model) -> StepDrive<'a, S>,
    ) -> Vec<Vec<S>> {
        let Self { model, soft, mechanism, elimination, .. } = self;
        let soft = &*soft.get_or_insert_with(|| SoftModel::of(model).map(S::from_f64));
        let mechanism = &soft.mechanism(mechanism);
        let elimination = elimination_of_steps(model, mechanism, soft, elimination);
        let constraints = StepConstraints { soft, settings };
        state_derivatives_by_newton(mechanism, &elimination, input, constraints, drive(model))
    }

    /// Computes the state after a step under the controls of the actuators, and their activations
    /// after it, `next_act`: see [`step_actuated`](crate::Robot::step_actuated). Allocates memory at
    /// each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn step_actuated(
        &mut self,
        input: ActuatedInput<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
        next_act: &mut [S],
    ) -> Result<(), ShapeError> {
        let ActuatedInput { actuators, applied, .. } = input;
        self.check_vectors(&[("applied", applied)])?;
        self.check_actuators(actuators)?;
        check("next_act", next_act, actuators.act.len())?;
        let Self { model, actuation, mechanism, .. } = self;
        let workspace = actuation.get_or_insert_with(|| ActuationWorkspace::new(model));
        let ActuatedForces { tau, dampers, act } = input.forces(model, mechanism, workspace);
        self.damped_step(input.under(&tau), &dampers, settings, outputs)?;
        next_act.copy_from_slice(&act);
        Ok(())
    }

    /// Computes the state after a step with further dampers, which act with the velocities after it.
    fn damped_step(
        &mut self,
        input: StepInput<'_, S>,
        dampers: &DampingMatrix<S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
        outputs: StepSolutionOutputs<'_, S>,
    ) -> Result<(), ShapeError> {
        self.check_forward_input(input.step.forward_input())?;
        self.check_vectors(&[("warm_start", input.warm_start)])?;
        let Self { model, soft, mechanism, elimination, workspace, .. } = self;
        let soft = soft.get_or_insert_with(|| SoftModel::of(model).map(S::from_f64));
        let points: usize = soft.contacts.iter().map(|contact| contact.shape.points()).sum();
        check("step_settings.surfaces", settings.surfaces.as_ref(), soft.contacts.len())?;
        check("outputs.q", outputs.q, model.nq())?;
        check("outputs.qd", outputs.qd, model.nv())?;
        check("outputs.qdd", outputs.qdd, model.nv())?;
        check("outputs.forces", outputs.forces, 3 * points)?;
        let mechanism = &soft.mechanism(mechanism);
        let elimination = &elimination_of_steps(model, mechanism, soft, elimination);
        let constraints = StepConstraints { soft: &*soft, settings };
        let problem = StepProblem::new(mechanism, elimination, input, constraints, workspace);
        let SoftStep { motion, residual, iterations } = soft_step(problem.damped_by(dampers));
        let [q, qd] = next_state(mechanism, soft, input.step, [&motion.qdd, &motion.damped]);
        outputs.q.copy_from_slice(&q);
        outputs.qd.copy_from_slice(&qd);
        outputs.qdd.copy_from_slice(&motion.qdd);
        for (output, force) in outputs.forces.chunks_mut(3).zip(&motion.forces) {
            output.copy_from_slice(force);
        }
        (*outputs.residual, *outputs.iterations) = (residual, iterations);
        Ok(())
    }

    /// Returns the points of the shapes that can touch the ground, in the order of the forces of a
    /// step. Allocates memory at each call.
    ///
    /// # Errors
    ///
    /// If a slice does not have the model's length.
    pub fn touching_points(
        &mut self,
        state: State<'_, S>,
        settings: &StepSettings<S, impl AsRef<[ContactSurface<S>]>>,
    ) -> Result<Vec<TouchingPoint<S>>, ShapeError> {
        self.check_state(state)?;
        let Self { model, soft, mechanism, workspace, .. } = self;
        let soft = soft.get_or_insert_with(|| SoftModel::of(model).map(S::from_f64));
        check("step_settings.surfaces", settings.surfaces.as_ref(), soft.contacts.len())?;
        Ok(touching_points(mechanism, soft, settings, state, workspace))
    }

    /// Replaces what the robot's soft constraints have beside the settings of a step.
    pub fn set_soft_model(&mut self, soft: SoftModel<S>) {
        self.soft = Some(soft);
    }
}

/// Returns the solver of the steps of `mechanism`; `of_dynamics` is the solver of
/// forward dynamics.
fn elimination_of_steps<S: Scalar>(
    model: &Model,
    mechanism: &Mechanism<S>,
    soft: &SoftModel<S>,
    of_dynamics: &Elimination,
) -> Elimination {
    match soft.couples_limbs() {
        true => Elimination::of_steps(mechanism, &ModuleTree::links(model), soft.coupled_joints()),
        false => of_dynamics.clone(),
    }
}

/// The mobilities of a robot at its reference configuration. They become part of generated text, so
/// they are the same on every host.
struct Mobilities {
    robot: Interpreter<Portable>,
    q: Vec<Portable>,
    factors: UduFactorization<Portable>,
}

impl Mobilities {
    fn at_reference(model: &Model) -> Self {
        let robot = Interpreter::<Portable>::new(model.clone());
        let mut q = vec![Portable(0.0); model.nq()];
        robot.neutral(&mut q).expect(LENGTHS);
        for reference in &model.soft_constraints().references {
            // Mimic joints follow their leaders.
            if model.mimic(reference.joint).is_none() {
                q[model.q_range(reference.joint).start] = Portable(reference.coordinate);
            }
        }
        let factors = robot.brge(&q).expect(LENGTHS);
        Self { robot, q, factors }
    }

    /// Returns J M^-1 J^T of a row J.
    fn of_row(&self, row: &[Portable]) -> f64 {
        let response = self.factors.solve(row).expect(LENGTHS);
        row.iter().zip(response).map(|(a, b)| a.0 * b.0).sum()
    }

    /// Returns the mean mobilities of displacements of a link's center of mass, 1/kg, and of
    /// rotations, 1/(kg m^2); zero for a link that cannot move.
    fn of_link(&mut self, link: usize) -> [f64; 2] {
        let Self { robot, q, .. } = self;
        if robot.mechanism.frames[link].body.is_none() {
            return [0.0; 2];
        }
        let center = robot.model.links()[link].inertial.center_of_mass.map(Portable);
        let mut twists = vec![Twist::zero(); robot.model.nv()];
        robot.jacobian_local(q, link, &mut twists).expect(LENGTHS);
        let mean = |part: &dyn Fn(&Twist<Portable>) -> Vector3<Portable>| {
            let axis = |k: usize| -> f64 {
                let row: Vec<Portable> = twists.iter().map(|twist| part(twist).0[k]).collect();
                self.of_row(&row)
            };
            (axis(0) + axis(1) + axis(2)) / 3.0
        };
        let at_center =
            |twist: &Twist<Portable>| twist.linear + twist.angular.cross(Vector3(center));
        [mean(&at_center), mean(&|twist| twist.angular)]
    }
}

impl SoftModel<f64> {
    /// Returns what a robot's soft constraints have beside the settings of a step: the joint limits
    /// of the description, its dry joint friction if friction is enabled, its tendons and couplings,
    /// and mobilities at the reference configuration.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        let mechanism = Mechanism::<f64>::new(model);
        let mut mobilities = Mobilities::at_reference(model);
        let shapes = model.touching_shapes();
        let contact = |shape: TouchingShape| {
            let link = shape.end.link;
            let [mobility, _] = mobilities.of_link(link);
            let frame = &mechanism.frames[link];
            ContactParameters {
                body: frame.body.expect("shapes are on moving links"),
                pose: frame.pose.compose(&shape.end.pose),
                shape: shape.shape,
                components: shape.components,
                mobility,
                power: shape.power,
            }
        };
        let contacts: Vec<_> = shapes.into_iter().map(contact).collect();
        let closed = |(i, constraint): (usize, &LoopConstraint)| {
            let [first, second] =
                constraint.ends.each_ref().map(|end| mobilities.of_link(end.link));
            let LoopSoftness { softness, torque_scale, .. } =
                model.soft_constraints().softness_of_loop(i);
            let mobility = [0, 1].map(|k| first[k] + second[k]);
            LoopParameters { mobility, softness, torque_scale }
        };
        let loops: Vec<_> = model.loop_constraints().iter().enumerate().map(closed).collect();
        let has_limits = model.soft_constraints().joint_limits;
        let mut joints = vec![None; model.nv()];
        for i in 0..model.moving_links().len() {
            let coordinates = model.q_range(i);
            if coordinates.len() != 1 || model.mimic(i).is_some() {
                continue;
            }
            let dof = model.v_range(i).start;
            let mut unit = vec![Portable(0.0); model.nv()];
            unit[dof] = Portable(1.0);
            // Mimic joints stop and brake their leader.
            let [lower, upper] = model.coordinate_range(i);
            let friction = dry_friction(model, i);
            let mut softnesses = model.soft_constraints().joints.iter();
            let softness = softnesses.find(|softness| softness.joint == i);
            let margin = softness.map_or(0.0, |softness| softness.margin);
            let stops = StopParameters {
                range: [lower, upper]
                    .map(|limit| Some(limit).filter(|x| has_limits && x.is_finite())),
                narrow: upper - lower <= 2.0 * margin,
                margin,
                mobility: mobilities.of_row(&unit),
                limit: softness.map_or_else(Softness::standard, |softness| softness.limit),
                dry_friction: Some(friction).filter(|friction| *friction > 0.0),
                friction: softness.map_or_else(Softness::standard, |softness| softness.friction),
            };
            joints[dof] = Some(JointParameters { coordinate: coordinates.start, stops });
        }
        let soft = model.soft_constraints();
        let tendons: Vec<_> =
            soft.tendons.iter().map(|tendon| mobilities.tendon(model, tendon)).collect();
        let acting = |coupling| mobilities.coupling(model, coupling);
        let couplings = soft.couplings.iter().filter_map(acting).collect();
        let mass: f64 = model.moving_links().iter().map(|link| link.inertial.mass).sum();
        let SoftConstraints { cone, integrator, .. } = *model.soft_constraints();
        SoftModel {
            cone,
            integrator,
            weight: (mass * EARTH).max(LEAST_WEIGHT),
            contacts,
            damping: damping_in_steps(model, &mechanism),
            joints,
            coupled_dampers: coupled_dampers(model, &mechanism, &tendons),
            free_bodies: free_bodies(model, &mechanism),
            tendons,
            couplings,
            loops,
        }
    }
}

impl Mobilities {
    /// Returns J M^-1 J^T of a length.
    fn of_length(&self, length: &Length<f64>) -> f64 {
        let mut row = vec![Portable(0.0); self.robot.model.nv()];
        length.terms.iter().for_each(|term| row[term.dof] = Portable(term.factor));
        self.of_row(&row)
    }

    fn tendon(&self, model: &Model, tendon: &SoftTendon) -> TendonParameters<f64> {
        let SoftTendon { range, margin, limit, dry_friction, friction, spring, .. } = *tendon;
        let TendonSpring { stiffness, rest, damping } = spring;
        let length = length(model, &tendon.length);
        let moves = !length.terms.is_empty();
        let limits = range.filter(|_| moves && model.soft_constraints().joint_limits);
        TendonParameters {
            stops: StopParameters {
                range: limits.map_or([None; 2], |limits| limits.map(Some)),
                narrow: limits.is_some_and(|[lower, upper]| upper - lower <= 2.0 * margin),
                margin,
                mobility: self.of_length(&length),
                limit,
                dry_friction: Some(dry_friction)
                    .filter(|x| moves && *x > 0.0 && has_friction(model)),
                friction,
            },
            spring: (stiffness > 0.0).then_some(SpringParameters { stiffness, rest }),
            damping: Some(damping).filter(|damping| *damping > 0.0),
            length,
        }
    }

    /// Returns a coupling; `None` if it moves no joint.
    fn coupling(&self, model: &Model, coupling: &SoftCoupling) -> Option<CouplingParameters<f64>> {
        let lengths = coupling.sums.each_ref().map(|sum| length(model, sum));
        let [first, second] = lengths.each_ref().map(|length| self.of_length(length));
        let moves = lengths.iter().any(|length| !length.terms.is_empty());
        moves.then_some(CouplingParameters {
            lengths,
            polynomial: coupling.polynomial,
            mobility: first + second,
            softness: coupling.softness,
        })
    }
}

/// Returns a sum of joint coordinates as a sum of entries of q: mimic joints follow their leaders.
fn length(model: &Model, sum: &JointSum) -> Length<f64> {
    let mut length = Length { terms: Vec::<LengthTerm<f64>>::new(), offset: sum.offset };
    for joint in &sum.joints {
        let mimic = model.mimic(joint.link);
        let factor = joint.coefficient * mimic.map_or(1.0, |mimic| mimic.multiplier);
        length.offset += joint.coefficient * mimic.map_or(0.0, |mimic| mimic.offset);
        let [coordinate, dof] = [model.q_range(joint.link).start, model.v_range(joint.link).start];
        match length.terms.iter_mut().find(|term| term.dof == dof) {
            Some(term) => term.factor += factor,
            None => length.terms.push(LengthTerm { coordinate, dof, factor }),
        }
    }
    length.terms.retain(|term| term.factor != 0.0);
    length
}

/// Returns the entries of qd that each damper of `implicitfast` couples.
fn coupled_dampers(
    model: &Model,
    mechanism: &Mechanism<f64>,
    tendons: &[TendonParameters<f64>],
) -> Vec<Vec<usize>> {
    if model.soft_constraints().integrator != Integrator::ImplicitFast {
        return Vec::new();
    }
    let damped = tendons.iter().filter(|tendon| tendon.damping.is_some());
    let of_tendons = damped.map(|tendon| tendon.length.terms.iter().map(|term| term.dof).collect());
    let actuators = model.actuation().actuators.iter().filter(|one| depends_on_rate(one));
    let of_actuators = actuators
        .map(|actuator| moments(model, actuator).into_iter().map(|(dof, _)| dof).collect());
    of_tendons.chain(of_actuators).filter(|dofs: &Vec<usize>| couples(mechanism, dofs)).collect()
}

/// Returns the bodies whose rotation is implicit: by `implicitfast`, bodies that are free and carry
/// no joint.
fn free_bodies(model: &Model, mechanism: &Mechanism<f64>) -> Vec<usize> {
    if model.soft_constraints().integrator != Integrator::ImplicitFast {
        return Vec::new();
    }
    let links = model.moving_links().iter().enumerate().filter(|(i, link)| {
        let is_free = link.parent.is_none() && link.joint.joint_type == JointType::Floating;
        is_free && model.moving_links().iter().all(|other| other.parent != Some(*i))
    });
    links.map(|(i, _)| mechanism.links[i]).collect()
}

/// Returns the damping of each degree of freedom of the mechanism in steps.
fn damping_in_steps(model: &Model, mechanism: &Mechanism<f64>) -> Vec<Option<f64>> {
    let damping = |mechanism: &Mechanism<f64>| {
        mechanism.dofs.iter().map(|dof| dof.damping).collect::<Vec<_>>()
    };
    match model.joint_friction() {
        JointFriction::None if model.soft_constraints().joint_friction => {
            let damped = model.clone().with_joint_friction(JointFriction::Viscous);
            damping(&Mechanism::new(&damped.expect("a kind of friction without parameters")))
        }
        _ => damping(mechanism),
    }
}

/// Returns whether dry friction acts in steps.
fn has_friction(model: &Model) -> bool {
    let acts = matches!(model.joint_friction(), JointFriction::Coulomb | JointFriction::Smooth(_));
    acts || model.soft_constraints().joint_friction
}

/// Returns the dry friction of a joint and of the mimic joints that follow it, N m or N; zero if
/// friction is not enabled.
fn dry_friction(model: &Model, joint: usize) -> f64 {
    if !has_friction(model) {
        return 0.0;
    }
    let joints = model.moving_links().iter().enumerate().filter_map(|(i, link)| {
        let multiplier = match model.mimic(i) {
            Some(mimic) if mimic.leader == joint => mimic.multiplier.abs(),
            None if i == joint => 1.0,
            _ => return None,
        };
        Some(multiplier * link.joint.dynamics.friction)
    });
    joints.sum()
}
