//! The description of a robot: links, joints, inertias, the tree of links and its kinematic
//! modules.
//!
//! A [`Model`] is validated when it is created, so the equations never see an invalid tree. Moving
//! link `i` and joint `i` belong together, as in the paper: every moving link has exactly one
//! joint, towards its parent. A link that is fixed to another link is only a [`Link`]. Its inertia is
//! merged into the moving link that carries it.

mod actuator;
mod check;
mod contact;
mod error;
mod integrator;
mod joint;
mod keyframe;
mod link;
mod loop_constraint;
mod modules;
mod softness;
mod spring;
mod tendon;
mod touching;

pub use crate::inertial::{INERTIAL_PARAMETERS, Inertial, InertialDefect, PARAMETERS_PER_LINK};
pub use actuator::{
    Activation, ActivationDynamics, Actuation, Actuator, AffineLaw, FixedTendon, JointForceRange,
    TendonJoint, TorqueSpeedLine, Transmission,
};
pub use contact::{Contact, ContactKind};
pub use error::{ModelError, ModelErrorKind};
pub use integrator::Integrator;
pub use joint::{Joint, JointDynamics, JointFriction, Limits, Mimic};
pub use keyframe::Keyframe;
pub use link::{Link, MovingLink, longest_path};
pub(crate) use loop_constraint::radius_of_gyration;
pub use loop_constraint::{LoopConstraint, LoopConstraintEnd, LoopConstraintKind};
pub use modules::{Module, ModuleError, ModuleTree};
pub use softness::{Impedance, Softness};
pub use spring::Spring;
pub use tendon::{JointSum, SoftCoupling, SoftTendon, TendonSpring};
pub use touching::{
    Cone, ContactComponents, ContactShape, JointReference, JointSoftness, LoopSoftness,
    SoftConstraints, TouchingShape,
};

use alloc::{string::String, vec::Vec};
use core::ops::Range;

use crate::joint::JointType;

/// The default gravity, m/s^2: 9.81 along -z of the world.
pub const DEFAULT_GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// A validated robot.
///
/// Moving links are in depth-first order, parents before children. Their order is the order of all
/// joint vectors. Units are SI units and radians.
///
/// ```
/// use modyn_runtime::joint::JointType;
/// use modyn_runtime::model::{DEFAULT_GRAVITY, Joint, MovingLink, Model};
/// use modyn_runtime::{Inertial, Pose};
///
/// let joint = Joint::new("pivot", JointType::Continuous, [0.0, 1.0, 0.0], Pose::identity());
/// let inertial = Inertial { mass: 2.0, center_of_mass: [0.0, 0.0, -0.5], inertia: [0.0; 6] };
/// let rod = MovingLink { name: "rod".into(), parent: None, joint, inertial };
/// let model = Model::new("pendulum", DEFAULT_GRAVITY, vec![rod], vec![]).expect("a valid model");
/// assert_eq!((model.nq(), model.nv()), (1, 1));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Model {
    name: String,
    gravity: [f64; 3],
    joint_friction: JointFriction,
    moving_links: Vec<MovingLink>,
    links: Vec<Link>,
    springs: Vec<Spring>,
    /// For each link, the part of its weight that is compensated; empty if none is.
    gravity_compensation: Vec<f64>,
    loop_constraints: Vec<LoopConstraint>,
    contacts: Vec<Contact>,
    soft_constraints: SoftConstraints,
    actuation: Actuation,
    keyframes: Vec<Keyframe>,
    /// For each link, the place of its joint's coordinates and velocities.
    #[cfg_attr(feature = "serde", serde(skip))]
    joint_indices: Vec<JointIndices>,
}

/// The place of a joint in the joint vectors, and the mimic relation to the joint that has this
/// place.
#[derive(Clone, Debug, Default, PartialEq)]
struct JointIndices {
    q: Range<usize>,
    v: Range<usize>,
    /// Chains of mimic joints are resolved: the leader has a coordinate of its own.
    mimic: Option<Mimic>,
    /// The links whose joints mimic this one.
    followers: Vec<usize>,
}

impl Model {
    /// Returns the model of these links, after checking them.
    ///
    /// `gravity` is the acceleration of free fall in world axes, m/s^2. `links` are all links of the
    /// description, moving or not, in its own order, which is the order of
    /// [`link_poses`](crate::Interpreter::link_poses).
    ///
    /// # Errors
    ///
    /// Returns every defect found: a repeated name, a parent that does not come before its child,
    /// links out of depth-first order, an axis that is not of unit length, an invalid rotation, a
    /// number that is not finite, a robot without a joint. Inertias only have to be finite here;
    /// [`Inertial::defect`] checks whether they are physical.
    pub fn new(
        name: impl Into<String>,
        gravity: [f64; 3],
        moving_links: Vec<MovingLink>,
        links: Vec<Link>,
    ) -> Result<Self, Vec<ModelError>> {
        let joint_friction = JointFriction::None;
        let loop_constraints = Vec::new();
        let contacts = Vec::new();
        let keyframes = Vec::new();
        let joint_indices = Vec::new();
        let name = name.into();
        let mut model = Self {
            name,
            gravity,
            joint_friction,
            moving_links,
            links,
            springs: Vec::new(),
            gravity_compensation: Vec::new(),
            loop_constraints,
            contacts,
            soft_constraints: SoftConstraints::default(),
            actuation: Actuation::default(),
            keyframes,
            joint_indices,
        };
        let errors = check::check(&model);
        if !errors.is_empty() {
            return Err(errors);
        }
        model.joint_indices = model.joint_indices();
        Ok(model)
    }

    /// Returns the places of the joints in the joint vectors.
    fn joint_indices(&self) -> Vec<JointIndices> {
        let mut joint_indices: Vec<JointIndices> = Vec::with_capacity(self.moving_links.len());
        let mut q = 0;
        let mut v = 0;
        for link in &self.moving_links {
            let is_independent = link.joint.mimic.is_none();
            let joint_type = link.joint.joint_type;
            let (nq, nv) = if is_independent { (joint_type.nq(), joint_type.nv()) } else { (0, 0) };
            let followers = Vec::new();
            joint_indices.push(JointIndices { q: q..q + nq, v: v..v + nv, mimic: None, followers });
            (q, v) = (q + nq, v + nv);
        }
        for (i, mimic) in self.resolved_mimics().into_iter().enumerate() {
            if let Some(mimic) = mimic {
                // The leader at the end of a chain has a place of its own.
                let leader = &mut joint_indices[mimic.leader];
                leader.followers.push(i);
                let q = leader.q.clone();
                let v = leader.v.clone();
                joint_indices[i] = JointIndices { q, v, mimic: Some(mimic), followers: Vec::new() };
            }
        }
        joint_indices
    }

    /// Returns, for each link, the mimic relation to a joint with a coordinate of its own. Every
    /// mimic joint is visited once, so that chains of mimic joints take linear time.
    fn resolved_mimics(&self) -> Vec<Option<Mimic>> {
        let mut resolved: Vec<Option<Mimic>> = alloc::vec![None; self.moving_links.len()];
        let mut waiting = Vec::new();
        for start in 0..self.moving_links.len() {
            let mut at = start;
            while resolved[at].is_none()
                && let Some(mimic) = self.moving_links[at].joint.mimic
            {
                waiting.push((at, mimic));
                at = mimic.leader;
            }
            let mut relation = resolved[at];
            while let Some((follower, mimic)) = waiting.pop() {
                relation = Some(relation.map_or(mimic, |next| Mimic {
                    leader: next.leader,
                    multiplier: mimic.multiplier * next.multiplier,
                    offset: mimic.multiplier * next.offset + mimic.offset,
                }));
                resolved[follower] = relation;
            }
        }
        resolved
    }

    /// Returns the model with this kind of joint friction.
    ///
    /// # Errors
    ///
    /// If the transition velocity of smooth friction is not positive.
    pub fn with_joint_friction(
        mut self,
        joint_friction: JointFriction,
    ) -> Result<Self, Vec<ModelError>> {
        self.joint_friction = joint_friction;
        let errors = check::check_model(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// Returns the model with this gravity, the acceleration of free fall in world axes, m/s^2.
    ///
    /// # Errors
    ///
    /// If a component is not finite.
    pub fn with_gravity(mut self, gravity: [f64; 3]) -> Result<Self, Vec<ModelError>> {
        self.gravity = gravity;
        let errors = check::check_model(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// Returns the model with these springs in place of its present ones.
    ///
    /// # Errors
    ///
    /// Returns every defect found: a link that does not exist or has another spring, a stiffness
    /// that is negative, a reference that is no coordinates of the joint, a number that is not
    /// finite.
    pub fn with_springs(mut self, springs: Vec<Spring>) -> Result<Self, Vec<ModelError>> {
        self.springs = springs;
        let errors = check::check_springs(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// Returns the model with gravity compensation: for each frame, an upward force at the centre
    /// of mass of the link's own inertia, of this part of its weight. With 1 the link's weight has
    /// no effect. The force moves with gravity, and with inertias that change at run time; payloads
    /// are not compensated. No factors are no compensation.
    ///
    /// # Errors
    ///
    /// If there is not one factor for each frame, or one is not finite.
    pub fn with_gravity_compensation(mut self, factors: Vec<f64>) -> Result<Self, Vec<ModelError>> {
        self.gravity_compensation = factors;
        let errors = check::check_gravity_compensation(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// Returns the model with these loop constraints in place of its present ones.
    ///
    /// # Errors
    ///
    /// Returns every defect found: a repeated name, a link that does not exist, two links that do
    /// not move relative to each other, an axis that is not of unit length, an invalid rotation, a
    /// number that is not finite.
    pub fn with_loop_constraints(
        mut self,
        loop_constraints: Vec<LoopConstraint>,
    ) -> Result<Self, Vec<ModelError>> {
        self.loop_constraints = loop_constraints;
        let errors = check::check_loop_constraints(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// Returns the robot with these contacts, which replace its present contacts.
    ///
    /// # Errors
    ///
    /// All defects of the contacts: a name used twice, a link that does not exist or does not move,
    /// a matrix that is not a rotation, a number that is not finite.
    pub fn with_contacts(mut self, contacts: Vec<Contact>) -> Result<Self, Vec<ModelError>> {
        self.contacts = contacts;
        let errors = check::check_contacts(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// Returns the robot with these shapes, cones and softness of steps with soft constraints, which
    /// replace the present ones.
    ///
    /// # Errors
    ///
    /// All defects: a link or a joint that does not exist, a shape on a link that does not move, a
    /// tendon of a joint with several degrees of freedom, a size that is not above zero, a matrix
    /// that is not a rotation, a number that is not finite or out of its range.
    pub fn with_soft_constraints(mut self, soft: SoftConstraints) -> Result<Self, Vec<ModelError>> {
        self.soft_constraints = soft;
        let errors = check::check_soft_constraints(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// Returns the robot with these actuators, tendons and ranges of joint forces, which replace the
    /// present ones.
    ///
    /// # Errors
    ///
    /// All defects: a name used twice, a joint that does not exist or has several degrees of
    /// freedom, a tendon that does not exist, a range whose lower end is not below its upper end, a
    /// range of a tendon's forces that does not contain zero, a time constant that is negative, a
    /// torque-speed line whose force or speed is not above zero, delays of too many steps, a number
    /// that is not finite, keyframes with controls or activations of other actuators.
    pub fn with_actuation(mut self, actuation: Actuation) -> Result<Self, Vec<ModelError>> {
        self.actuation = actuation;
        let mut errors = check::check_actuation(&self);
        errors.extend(check::check_keyframes(&self));
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// Returns the robot with these keyframes, which replace its present keyframes.
    ///
    /// # Errors
    ///
    /// All defects of the keyframes: a name used twice, a number of coordinates that is not nq, a
    /// number of velocities, controls or activations that is neither the robot's nor zero, a number
    /// that is not finite, a quaternion that is not of unit length.
    pub fn with_keyframes(mut self, keyframes: Vec<Keyframe>) -> Result<Self, Vec<ModelError>> {
        self.keyframes = keyframes;
        let errors = check::check_keyframes(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// Returns the kind of joint friction.
    #[must_use]
    pub fn joint_friction(&self) -> JointFriction {
        self.joint_friction
    }

    /// Returns the robot's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the acceleration of free fall in world axes, m/s^2.
    #[must_use]
    pub fn gravity(&self) -> [f64; 3] {
        self.gravity
    }

    /// Returns the moving links, in depth-first order.
    #[must_use]
    pub fn moving_links(&self) -> &[MovingLink] {
        &self.moving_links
    }

    /// Returns all links, moving or not, in the description's order.
    #[must_use]
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Returns the springs.
    #[must_use]
    pub fn springs(&self) -> &[Spring] {
        &self.springs
    }

    /// Returns the spring of the joint of moving link `link`; `None` without a spring.
    #[must_use]
    pub fn spring(&self, link: usize) -> Option<&Spring> {
        self.springs.iter().find(|spring| spring.link == link)
    }

    /// Returns for each frame the part of its own weight that is compensated; empty without
    /// compensation.
    #[must_use]
    pub fn gravity_compensation(&self) -> &[f64] {
        &self.gravity_compensation
    }

    /// Returns the loop constraints.
    #[must_use]
    pub fn loop_constraints(&self) -> &[LoopConstraint] {
        &self.loop_constraints
    }

    /// Returns the contacts: the frames of links that can touch the world.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Returns the keyframes: named states, in the order of the description.
    #[must_use]
    pub fn keyframes(&self) -> &[Keyframe] {
        &self.keyframes
    }

    /// Returns the number of constraints: loop constraints and contacts.
    #[must_use]
    pub fn constraints(&self) -> usize {
        self.loop_constraints.len() + self.contacts.len()
    }

    /// Returns the number of constraint rows, all contacts active.
    #[must_use]
    pub fn constraint_rows(&self) -> usize {
        let loops = self.loop_constraints.iter().map(|constraint| constraint.kind.rows());
        loops.chain(self.contacts.iter().map(|contact| contact.kind.rows())).sum()
    }

    /// Returns the index in [`links`](Self::links) of the link named `name`; `None` if there is
    /// no such link.
    #[must_use]
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// Returns the ten inertial parameters of moving link `link`, in which joint forces are linear
    /// (see [`Inertial::parameters`]); `None` if there is no such link. The parameters of all
    /// moving links, concatenated, are pi in tau = Y pi.
    #[must_use]
    pub fn inertial_parameters(&self, link: usize) -> Option<[f64; PARAMETERS_PER_LINK]> {
        self.moving_links.get(link).map(|link| link.inertial.parameters())
    }

    /// Returns nq, the length of the coordinate vector q.
    #[must_use]
    pub fn nq(&self) -> usize {
        self.joint_indices.iter().map(|place| place.q.end).max().unwrap_or(0)
    }

    /// Returns nv, the length of the velocity vector qd: the number of degrees of freedom.
    #[must_use]
    pub fn nv(&self) -> usize {
        self.joint_indices.iter().map(|place| place.v.end).max().unwrap_or(0)
    }

    /// Returns the entries of q of moving link `link`'s joint; for a mimic joint the leader's
    /// entries. The range is empty if there is no such link.
    #[must_use]
    pub fn q_range(&self, link: usize) -> Range<usize> {
        self.joint_indices.get(link).map_or(0..0, |place| place.q.clone())
    }

    /// Returns the entries of qd and tau of moving link `link`'s joint; for a mimic joint the
    /// leader's entries. The range is empty if there is no such link.
    #[must_use]
    pub fn v_range(&self, link: usize) -> Range<usize> {
        self.joint_indices.get(link).map_or(0..0, |place| place.v.clone())
    }

    /// Returns the mimic relation of moving link `link`'s joint to a joint with a coordinate of its
    /// own; chains of mimic joints are resolved. Returns `None` if the joint has its own coordinate
    /// or does not exist.
    #[must_use]
    pub fn mimic(&self, link: usize) -> Option<Mimic> {
        self.joint_indices.get(link).and_then(|place| place.mimic)
    }

    /// Returns the lowest and the highest coordinate of moving link `link`'s joint, rad or m:
    /// within the limits of the joint and of all joints that mimic it. For a mimic joint the
    /// coordinate is its leader's.
    ///
    /// The range is infinite without limits, for a joint with several coordinates, and if there is
    /// no such link. The limits of a mimic joint are ignored if they contradict those before: if
    /// they would leave less than 1e-9 of the largest bound.
    #[must_use]
    pub fn coordinate_range(&self, link: usize) -> [f64; 2] {
        let leader = self.mimic(link).map_or(link, |mimic| mimic.leader);
        let limits = self.position_limits(leader);
        let indices = self.joint_indices.get(leader).map_or(&[][..], |place| &place.followers);
        let followers = indices.iter().filter_map(|&i| Some((i, self.mimic(i)?)));
        followers.fold(limits, |[low, high], (i, mimic)| {
            let bounds = self.position_limits(i);
            let [a, b] = bounds.map(|bound| (bound - mimic.offset) / mimic.multiplier);
            let (lower, upper) = if mimic.multiplier < 0.0 { (b, a) } else { (a, b) };
            let lower = if lower > low { lower } else { low };
            let upper = if upper < high { upper } else { high };
            let finite = [lower, upper].into_iter().filter(|bound| bound.is_finite());
            let largest = finite.fold(0.0, |most: f64, bound| most.max(bound.abs()));
            if upper - lower > 1e-9 * largest { [lower, upper] } else { [low, high] }
        })
    }

    /// Returns the velocity limit of moving link `link`'s joint, rad/s or m/s: within the limits of
    /// the joint and of all joints that mimic it. For a mimic joint the velocity is its leader's.
    /// Infinite without limits, or if there is no such link.
    #[must_use]
    pub fn velocity_limit(&self, link: usize) -> f64 {
        let leader = self.mimic(link).map_or(link, |mimic| mimic.leader);
        let limit = |link: usize| self.moving_links.get(link)?.joint.limits?.velocity;
        let indices = self.joint_indices.get(leader).map_or(&[][..], |place| &place.followers);
        // A joint with the multiplier 0 does not move.
        let followers = indices.iter().filter_map(|&i| {
            let multiplier = self.mimic(i)?.multiplier.abs();
            Some(limit(i)? / multiplier).filter(|_| multiplier > 0.0)
        });
        followers.fold(limit(leader).unwrap_or(f64::INFINITY), f64::min)
    }

    /// Returns the position limits of moving link `link`'s joint by itself, infinite without a
    /// limit.
    fn position_limits(&self, link: usize) -> [f64; 2] {
        let joint = self.moving_links.get(link).map(|link| &link.joint);
        let single = joint.filter(|joint| joint.joint_type.nq() == 1);
        let limits = single.and_then(|joint| joint.limits.as_ref());
        [
            limits.and_then(|limits| limits.lower).unwrap_or(f64::NEG_INFINITY),
            limits.and_then(|limits| limits.upper).unwrap_or(f64::INFINITY),
        ]
    }

    /// Returns whether the robot has mimic joints.
    #[must_use]
    pub fn has_mimics(&self) -> bool {
        self.joint_indices.iter().any(|place| place.mimic.is_some())
    }

    /// Returns the quaternions in q: the joint's name and the entry of q of the quaternion's x, for
    /// each.
    pub fn quaternions(&self) -> impl Iterator<Item = (&str, usize)> + '_ {
        self.moving_links.iter().zip(&self.joint_indices).filter_map(|(link, place)| {
            let first = match link.joint.joint_type {
                JointType::Spherical => 0,
                JointType::Floating => 3,
                _ => return None,
            };
            Some((link.joint.name.as_str(), place.q.start + first))
        })
    }

    /// Returns the name of each entry of q: the joint's name, and the component for joints with
    /// several coordinates (`hip.qw`).
    #[must_use]
    pub fn coordinate_names(&self) -> Vec<String> {
        self.entry_names(JointType::coordinates)
    }

    /// Returns the name of each entry of qd.
    #[must_use]
    pub fn velocity_names(&self) -> Vec<String> {
        self.entry_names(JointType::velocities)
    }

    fn entry_names(&self, parts: fn(JointType) -> &'static [&'static str]) -> Vec<String> {
        let independent =
            self.moving_links.iter().map(|link| &link.joint).filter(|joint| joint.mimic.is_none());
        independent
            .flat_map(|joint| {
                parts(joint.joint_type).iter().map(|part| match *part {
                    "" => joint.name.clone(),
                    part => alloc::format!("{}.{part}", joint.name),
                })
            })
            .collect()
    }

    /// Returns the children of each link, in order.
    #[must_use]
    pub fn children(&self) -> Vec<Vec<usize>> {
        let mut children = alloc::vec![Vec::new(); self.moving_links.len()];
        for (i, link) in self.moving_links.iter().enumerate() {
            if let Some(siblings) = link.parent.and_then(|p| children.get_mut(p)) {
                siblings.push(i);
            }
        }
        children
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Model {
    /// Deserializes the parts and validates them, as [`Model::new`] does.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(serde::Deserialize)]
        #[serde(rename = "Model")]
        struct Parts {
            name: String,
            gravity: [f64; 3],
            #[serde(default)]
            joint_friction: JointFriction,
            moving_links: Vec<MovingLink>,
            links: Vec<Link>,
            #[serde(default)]
            springs: Vec<Spring>,
            #[serde(default)]
            gravity_compensation: Vec<f64>,
            #[serde(default)]
            loop_constraints: Vec<LoopConstraint>,
            #[serde(default)]
            contacts: Vec<Contact>,
            #[serde(default)]
            soft_constraints: SoftConstraints,
            #[serde(default)]
            actuation: Actuation,
            #[serde(default)]
            keyframes: Vec<Keyframe>,
        }
        let Parts {
            name,
            gravity,
            joint_friction,
            moving_links,
            links,
            springs,
            gravity_compensation,
            loop_constraints,
            contacts,
            soft_constraints,
            actuation,
            keyframes,
        } = Parts::deserialize(deserializer)?;
        let model = Self::new(name, gravity, moving_links, links)
            .and_then(|model| model.with_joint_friction(joint_friction))
            .and_then(|model| model.with_springs(springs))
            .and_then(|model| model.with_gravity_compensation(gravity_compensation))
            .and_then(|model| model.with_loop_constraints(loop_constraints))
            .and_then(|model| model.with_contacts(contacts))
            .and_then(|model| model.with_soft_constraints(soft_constraints))
            .and_then(|model| model.with_actuation(actuation))
            .and_then(|model| model.with_keyframes(keyframes));
        model.map_err(|errors| {
            let all: Vec<String> = errors.iter().map(alloc::string::ToString::to_string).collect();
            serde::de::Error::custom(all.join("; "))
        })
    }
}
