//! Steps of robots that are known at run time, by MuJoCo's law: with the ground, joint limits and dry
//! joint friction.
//!
//! `modyn::simulate::State::step` is the same step for generated robots.

use modyn_runtime::equations::actuation::ActuatorInput;
use modyn_runtime::equations::soft_constraints::{
    ActuatedInput, SoftModel, StepInput, TouchingPoint,
};
use modyn_runtime::equations::{State, TimeStepInput};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Impedance, Keyframe, Model, Softness};
use modyn_runtime::{
    ActuatorOutputs, ContactSurface, Interpreter, ShapeError, StepSettings, StepSolutionOutputs,
};

/// What touches the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Ground {
    /// Nothing.
    #[default]
    None,
    /// The points of the contacts touch the plane z = 0, with this coefficient of friction.
    Plane(f64),
    /// The shapes of the description touch their planes, or the points of the contacts the ground of
    /// the options.
    Described,
}

/// What joint limits do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Limits {
    /// Nothing.
    #[default]
    None,
    /// They stop the joints, and joint forces stay within the effort limits.
    Act,
    /// They stop the joints; joints with one coordinate are held where they start.
    Hold,
}

/// The choices of a motion by steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// What touches the ground.
    pub ground: Ground,
    /// What joint limits do.
    pub limits: Limits,
    /// Whether the actuators act.
    pub actuators: bool,
}

impl Options {
    /// Returns the choices of a robot whose shapes touch a floor: its contacts, its joint limits and
    /// its actuators act. `None` for other robots, and for a robot whose contacts are named.
    #[must_use]
    pub fn of_scene(model: &Model) -> Option<Self> {
        let is_scene = model.contacts().is_empty() && !model.touching_shapes().is_empty();
        is_scene.then_some(Self { ground: Ground::Described, limits: Limits::Act, actuators: true })
    }

    /// Returns whether neither the ground nor limits nor actuators act.
    #[must_use]
    pub fn is_none(self) -> bool {
        self == Self::default()
    }
}

/// Returns the names of the mimic joints whose limits contradict the limits of their leaders.
/// Limits that contradict are not enforced.
#[must_use]
pub fn contradictory_limits(model: &Model) -> Vec<String> {
    let contradicts = |&link: &usize| {
        let joint = &model.moving_links()[link].joint;
        let Some(limits) = &joint.limits else { return false };
        let Some(mimic) = model.mimic(link) else { return false };
        model.coordinate_range(link).iter().any(|q| {
            let q = mimic.multiplier * q + mimic.offset;
            limits.lower.is_some_and(|lower| q < lower - 1e-9)
                || limits.upper.is_some_and(|upper| q > upper + 1e-9)
        })
    };
    let links = (0..model.moving_links().len()).filter(contradicts);
    links.map(|link| model.moving_links()[link].joint.name.clone()).collect()
}

/// A robot that moves by steps.
pub struct ContactSteps {
    interpreter: Interpreter<f64>,
    settings: StepSettings<f64, Vec<ContactSurface<f64>>>,
    /// The velocity of each joint with an effort limit that acts, and the limit, N m or N.
    efforts: Vec<(usize, f64)>,
    /// The accelerations of the last step, from which the solver starts.
    qdd: Vec<f64>,
    /// The actuators; `None` if none acts.
    actuators: Option<Actuators>,
}

/// The actuators of a robot.
struct Actuators {
    ctrl: Vec<f64>,
    act: Vec<f64>,
}

impl Actuators {
    /// Returns the actuators of a model if they act, with controls and activations that are zero, as
    /// MuJoCo starts; `None` if it has none.
    fn of(model: &Model, options: Options) -> Option<Self> {
        let [controls, activations] = [model.control_names().len(), model.activation_names().len()];
        let acts = options.actuators && controls > 0;
        acts.then(|| Self { ctrl: vec![0.0; controls], act: vec![0.0; activations] })
    }
}

/// The state after a step, and the forces in it.
pub struct Step {
    /// The coordinates.
    pub q: Vec<f64>,
    /// The velocities.
    pub qd: Vec<f64>,
    /// The accelerations by the laws.
    pub qdd: Vec<f64>,
    /// The joint forces, with the forces of actuators.
    pub tau: Vec<f64>,
    /// The points that can touch the ground.
    pub points: Vec<GroundPoint>,
    /// The largest mismatch between the forces and their laws, divided by the sum of the robot's
    /// weight and the largest force.
    pub residual: f64,
    /// The number of iterations of the solver.
    pub iterations: f64,
}

/// A point that can touch the ground, before a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundPoint {
    /// The place in the world, m.
    pub place: [f64; 3],
    /// The force of the ground in the step, N, in world axes.
    pub force: [f64; 3],
    /// The height above the ground, m; negative in the ground.
    pub gap: f64,
}

impl GroundPoint {
    /// The place, then the force, for the viewer.
    #[must_use]
    pub fn numbers(&self) -> [f64; 6] {
        let [x, y, z] = self.place;
        let [fx, fy, fz] = self.force;
        [x, y, z, fx, fy, fz]
    }
}

/// The softness of limits that hold a joint: 0.1 um away from its place for each 1000 rad/s^2 or
/// m/s^2.
const FIRM: Softness<f64> = Softness {
    reference: [0.002, 1.0],
    impedance: Impedance { least: 0.9999, most: 0.9999, width: 0.001, midpoint: 0.5, power: 2 },
};

impl ContactSteps {
    /// Returns the steps of a robot that starts at the coordinates `q`.
    #[must_use]
    pub fn new(model: &Model, options: Options, q: &[f64]) -> Self {
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let mut soft = SoftModel::of(model);
        let mut settings = model.step_settings();
        match options.ground {
            Ground::None => {
                soft.contacts.clear();
                settings.surfaces.clear();
            }
            Ground::Plane(friction) => {
                settings.surfaces.iter_mut().for_each(|surface| surface.friction = friction);
            }
            Ground::Described => {}
        }
        if options.limits == Limits::None {
            soft.stops().for_each(|stops| stops.range = [None; 2]);
        }
        if options.limits == Limits::Hold {
            for joint in soft.joints.iter_mut().flatten() {
                joint.stops.range = [Some(q[joint.coordinate]); 2];
                (joint.stops.narrow, joint.stops.limit) = (true, FIRM);
            }
        }
        interpreter.set_soft_model(soft);
        let effort = |link: usize| {
            let joint = &model.moving_links()[link].joint;
            let v = model.v_range(link);
            let has_own_velocity = joint.mimic.is_none() && v.len() == 1;
            Some((v.start, joint.limits.as_ref()?.effort?)).filter(|_| has_own_velocity)
        };
        let joints = 0..if options.limits == Limits::Act { model.moving_links().len() } else { 0 };
        let efforts = joints.filter_map(effort).collect();
        let actuators = Actuators::of(model, options);
        Self { interpreter, settings, efforts, qdd: vec![0.0; model.nv()], actuators }
    }

    /// Returns the steps with the controls and the activations of a keyframe.
    #[must_use]
    pub fn from_keyframe(mut self, keyframe: &Keyframe) -> Self {
        if let Some(Actuators { ctrl, act }) = &mut self.actuators {
            // An empty list stands for zeros.
            ctrl.iter_mut().zip(&keyframe.ctrl).for_each(|(x, given)| *x = *given);
            act.iter_mut().zip(&keyframe.act).for_each(|(x, given)| *x = *given);
        }
        self
    }

    /// Returns the steps with this tolerance of the solver.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.settings.tolerance = tolerance;
        self
    }

    /// Reduces joint forces to the effort limits.
    pub fn limit(&self, tau: &mut [f64]) {
        for &(velocity, effort) in &self.efforts {
            tau[velocity] = tau[velocity].clamp(-effort, effort);
        }
    }

    /// Returns the step from this state on.
    ///
    /// # Errors
    ///
    /// If a length is not the model's.
    pub fn step(&mut self, input: TimeStepInput<'_, f64>) -> Result<Step, ShapeError> {
        let TimeStepInput { q, qd, tau, dt } = input;
        let Self { interpreter, settings, qdd, actuators, .. } = self;
        let points = interpreter.touching_points(State { q, qd }, settings)?;
        let mut forces = vec![0.0; 3 * points.len()];
        let mut step = Step {
            q: vec![0.0; q.len()],
            qd: vec![0.0; qd.len()],
            qdd: vec![0.0; qd.len()],
            tau: tau.to_vec(),
            points: Vec::new(),
            residual: 0.0,
            iterations: 0.0,
        };
        let outputs = StepSolutionOutputs {
            q: &mut step.q,
            qd: &mut step.qd,
            qdd: &mut step.qdd,
            forces: &mut forces,
            residual: &mut step.residual,
            iterations: &mut step.iterations,
        };
        match actuators {
            None => {
                let input = StepInput { step: input, warm_start: qdd };
                interpreter.step(input, settings, outputs)?;
            }
            Some(Actuators { ctrl, act }) => {
                let actuators = ActuatorInput { q, qd, ctrl, act, dt };
                let mut next_act = act.clone();
                let mut actuator_forces = vec![0.0; qd.len()];
                let actuated = ActuatorOutputs { tau: &mut actuator_forces, act: &mut next_act };
                interpreter.actuate(actuators, actuated)?;
                let input = ActuatedInput { actuators, applied: tau, warm_start: qdd };
                interpreter.step_actuated(input, settings, outputs, &mut next_act)?;
                *act = next_act;
                step.tau.iter_mut().zip(actuator_forces).for_each(|(tau, force)| *tau += force);
            }
        }
        qdd.copy_from_slice(&step.qdd);
        let forces = points.into_iter().zip(forces.as_chunks::<3>().0);
        let in_world = forces.map(|(TouchingPoint { shape, place, gap, .. }, force)| GroundPoint {
            place: place.0,
            force: settings.surfaces[shape].plane.rotate(*force),
            gap,
        });
        step.points = in_world.collect();
        Ok(step)
    }
}

/// The least upward component of the normal of a plane onto which a robot is put.
const LEVEL: f64 = 0.1;

/// Moves each floating base up or down such that the lowest shape that it carries is on the ground.
///
/// # Errors
///
/// If `q` does not have the model's length.
pub fn put_on_ground(model: &Model, q: &mut [f64]) -> Result<(), ShapeError> {
    move_to_ground(model, q, |_| true)
}

/// Lifts each floating base that carries a shape in the ground such that the lowest one is on it.
///
/// # Errors
///
/// If `q` does not have the model's length.
pub fn lift_out_of_ground(model: &Model, q: &mut [f64]) -> Result<(), ShapeError> {
    move_to_ground(model, q, |lowest| lowest < 0.0)
}

/// Moves each floating base whose lowest shape is at a height that fulfils the condition onto the
/// ground.
fn move_to_ground(
    model: &Model,
    q: &mut [f64],
    is_moved: impl Fn(f64) -> bool,
) -> Result<(), ShapeError> {
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let settings = model.step_settings();
    let rest = vec![0.0; model.nv()];
    let points = interpreter.touching_points(State { q, qd: &rest }, &settings)?;
    let shapes = model.touching_shapes();
    // The link of each point, and the height of the point.
    let height_of = |&TouchingPoint { shape, gap, .. }: &TouchingPoint<f64>| {
        let upwards = settings.surfaces[shape].plane.rotation[2][2];
        (upwards > LEVEL).then(|| (shapes[shape].end.link, gap / upwards))
    };
    let heights: Vec<(usize, f64)> = points.iter().filter_map(height_of).collect();
    let base = |link: usize| {
        let links = std::iter::successors(model.links()[link].moving_link, |&i| {
            model.moving_links()[i].parent
        });
        links.last()
    };
    for (i, link) in model.moving_links().iter().enumerate() {
        if link.parent.is_some() || link.joint.joint_type != JointType::Floating {
            continue;
        }
        let carried = heights.iter().filter(|(link, _)| base(*link) == Some(i));
        let lowest = carried.map(|(_, height)| *height).fold(f64::INFINITY, f64::min);
        if lowest.is_finite() && is_moved(lowest) {
            // The coordinates are in the axes of the joint's frame.
            let [.., up] = link.joint.origin.rotation;
            let place = &mut q[model.q_range(i).start..];
            place.iter_mut().zip(up).for_each(|(x, up)| *x -= up * lowest);
        }
    }
    Ok(())
}
