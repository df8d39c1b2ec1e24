//! A robot: links, joints, inertias, the tree they form and its kinematic modules.
//!
//! A [`Model`] is validated when it is made, so the equations never meet a broken tree.
//! Link `i` is the moving link behind joint `i`, as in the paper: every moving link has exactly
//! one joint, towards its parent. Links that are fixed to another link are [`Frame`]s; their
//! inertia has been merged into the link that carries them.

mod contact;
mod error;
mod joint;
mod link;
mod loop_constraint;
mod modules;

pub use crate::inertial::{INERTIAL_PARAMETERS, Inertial, InertialDefect, PARAMETERS_PER_LINK};
pub use contact::{Contact, ContactKind};
pub use error::{ModelError, ModelErrorKind};
pub use joint::{Friction, Joint, JointDynamics, Limits, Mimic};
pub use link::{Frame, Link};
pub use loop_constraint::{LoopConstraint, LoopConstraintEnd, LoopConstraintKind};
pub use modules::{Module, ModuleError, ModuleTree};

use alloc::{string::String, vec::Vec};
use core::ops::Range;

use crate::joint::JointType;

/// Standard gravity of the defaults, in m/s^2: 9.81 along -z of the world.
pub const DEFAULT_GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// A validated robot.
///
/// Links stand depth first, parents before children; that order is the order of all joint
/// vectors. SI units, radians.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Model {
    name: String,
    gravity: [f64; 3],
    friction: Friction,
    links: Vec<Link>,
    frames: Vec<Frame>,
    loop_constraints: Vec<LoopConstraint>,
    contacts: Vec<Contact>,
    /// By link: where its joint's coordinates and velocities stand.
    #[cfg_attr(feature = "serde", serde(skip))]
    places: Vec<Place>,
}

/// Where a joint stands in the joint vectors, or how it follows the one that does.
#[derive(Clone, Debug, Default, PartialEq)]
struct Place {
    q: Range<usize>,
    v: Range<usize>,
    /// Resolved through chains of mimics: the leader has coordinates of its own.
    mimic: Option<Mimic>,
}

impl Model {
    /// Checks the parts and makes a model of them.
    ///
    /// `gravity` is the acceleration of free fall in world axes, m/s^2. `frames` are the links of
    /// the description in its own order; [`link_poses`](crate::Interpreter::link_poses) gives theirs.
    ///
    /// # Errors
    ///
    /// Every defect found: a name used twice, a parent that does not come before its child, links
    /// out of depth-first order, an axis that is not of unit length, a rotation that is none, a
    /// number that is not finite, a robot without a joint. Inertias are only required to be
    /// finite here; whether they are physical is [`Inertial::defect`]'s to say.
    pub fn new(
        name: impl Into<String>,
        gravity: [f64; 3],
        links: Vec<Link>,
        frames: Vec<Frame>,
    ) -> Result<Self, Vec<ModelError>> {
        let friction = Friction::None;
        let (loop_constraints, contacts, places) = (Vec::new(), Vec::new(), Vec::new());
        let name = name.into();
        let mut model =
            Self { name, gravity, friction, links, frames, loop_constraints, contacts, places };
        let errors = error::check(&model);
        if !errors.is_empty() {
            return Err(errors);
        }
        model.places = model.placed();
        Ok(model)
    }

    /// Where the joints stand in the joint vectors.
    fn placed(&self) -> Vec<Place> {
        let mut places: Vec<Place> = Vec::with_capacity(self.links.len());
        let (mut q, mut v) = (0, 0);
        for link in &self.links {
            let own = link.joint.mimic.is_none();
            let joint_type = link.joint.joint_type;
            let (nq, nv) = if own { (joint_type.nq(), joint_type.nv()) } else { (0, 0) };
            places.push(Place { q: q..q + nq, v: v..v + nv, mimic: None });
            (q, v) = (q + nq, v + nv);
        }
        for (i, mimic) in self.resolved_mimics().into_iter().enumerate() {
            if let Some(mimic) = mimic {
                // A leader that is followed at last has a place of its own.
                places[i] = Place { mimic: Some(mimic), ..places[mimic.leader].clone() };
            }
        }
        places
    }

    /// By link: how its joint follows one that has coordinates of its own. Every mimic is followed
    /// once, so that chains of them take linear time.
    fn resolved_mimics(&self) -> Vec<Option<Mimic>> {
        let mut resolved: Vec<Option<Mimic>> = alloc::vec![None; self.links.len()];
        let mut waiting = Vec::new();
        for start in 0..self.links.len() {
            let mut at = start;
            while resolved[at].is_none()
                && let Some(mimic) = self.links[at].joint.mimic
            {
                waiting.push((at, mimic));
                at = mimic.leader;
            }
            let mut known = resolved[at];
            while let Some((follower, own)) = waiting.pop() {
                known = Some(known.map_or(own, |next| Mimic {
                    leader: next.leader,
                    multiplier: own.multiplier * next.multiplier,
                    offset: own.multiplier * next.offset + own.offset,
                }));
                resolved[follower] = known;
            }
        }
        resolved
    }

    /// The same robot with joints that resist their motion in this way.
    ///
    /// # Errors
    ///
    /// If friction is to be smoothed by what is no velocity above zero.
    pub fn with_friction(mut self, friction: Friction) -> Result<Self, Vec<ModelError>> {
        self.friction = friction;
        let errors = error::check_whole(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// The same robot where things fall with this acceleration, in world axes, m/s^2.
    ///
    /// # Errors
    ///
    /// If it is not finite.
    pub fn with_gravity(mut self, gravity: [f64; 3]) -> Result<Self, Vec<ModelError>> {
        self.gravity = gravity;
        let errors = error::check_whole(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// The same robot with these loops closed, in place of those that it had.
    ///
    /// # Errors
    ///
    /// Every defect found: a name used twice, a link that does not exist or does not move against
    /// the other, an axis that is not of unit length, a rotation that is none, a number that is not
    /// finite.
    pub fn with_loop_constraints(
        mut self,
        loop_constraints: Vec<LoopConstraint>,
    ) -> Result<Self, Vec<ModelError>> {
        self.loop_constraints = loop_constraints;
        let errors = error::check_loop_constraints(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// The same robot with these contacts, in place of those that it had.
    ///
    /// # Errors
    ///
    /// Every defect found: a name used twice, a link that does not exist or does not move, a rotation that is none, a
    /// number that is not finite.
    pub fn with_contacts(mut self, contacts: Vec<Contact>) -> Result<Self, Vec<ModelError>> {
        self.contacts = contacts;
        let errors = error::check_contacts(&self);
        if errors.is_empty() { Ok(self) } else { Err(errors) }
    }

    /// How joints resist their motion.
    #[must_use]
    pub fn friction(&self) -> Friction {
        self.friction
    }

    /// The robot's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The acceleration of free fall in world axes, m/s^2.
    #[must_use]
    pub fn gravity(&self) -> [f64; 3] {
        self.gravity
    }

    /// The moving links, depth first.
    #[must_use]
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// All links of the description as frames, in the description's order.
    #[must_use]
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// What holds links together besides the joints.
    #[must_use]
    pub fn loop_constraints(&self) -> &[LoopConstraint] {
        &self.loop_constraints
    }

    /// The frames of links that may touch the world.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The number of constraints: loop constraints, then contacts.
    #[must_use]
    pub fn constraints(&self) -> usize {
        self.loop_constraints.len() + self.contacts.len()
    }

    /// The number of constraint rows, all contacts active.
    #[must_use]
    pub fn constraint_rows(&self) -> usize {
        let loops = self.loop_constraints.iter().map(|constraint| constraint.kind.rows());
        loops.chain(self.contacts.iter().map(|contact| contact.kind.rows())).sum()
    }

    /// The link of the description of that name, as an index of [`frames`](Self::frames).
    #[must_use]
    pub fn frame_index(&self, name: &str) -> Option<usize> {
        self.frames.iter().position(|frame| frame.name == name)
    }

    /// The ten parameters of moving link `link` that torques are linear in: see
    /// [`Inertial::parameters`]. Those of all moving links, one after the other, are the pi of
    /// tau = Y pi. `None` if there is no such link.
    #[must_use]
    pub fn inertial_parameters(&self, link: usize) -> Option<[f64; PARAMETERS_PER_LINK]> {
        self.links.get(link).map(|link| link.inertial.parameters())
    }

    /// Length of the coordinate vector q.
    #[must_use]
    pub fn nq(&self) -> usize {
        self.places.iter().map(|place| place.q.end).max().unwrap_or(0)
    }

    /// Length of the velocity vector qd: the degrees of freedom.
    #[must_use]
    pub fn nv(&self) -> usize {
        self.places.iter().map(|place| place.v.end).max().unwrap_or(0)
    }

    /// The entries of q that belong to the joint of moving link `link`: its leader's for a joint that
    /// mimics, none if there is no such link.
    #[must_use]
    pub fn q_range(&self, link: usize) -> Range<usize> {
        self.places.get(link).map_or(0..0, |place| place.q.clone())
    }

    /// The entries of qd, and of tau, that belong to the joint of moving link `link`: its leader's for a
    /// joint that mimics, none if there is no such link.
    #[must_use]
    pub fn v_range(&self, link: usize) -> Range<usize> {
        self.places.get(link).map_or(0..0, |place| place.v.clone())
    }

    /// How the joint of link `link` follows one that has a coordinate of its own, chains of mimics
    /// resolved; `None` if it has its own, or if there is no such link.
    #[must_use]
    pub fn mimic(&self, link: usize) -> Option<Mimic> {
        self.places.get(link).and_then(|place| place.mimic)
    }

    /// Whether a joint follows another one.
    #[must_use]
    pub fn has_mimics(&self) -> bool {
        self.places.iter().any(|place| place.mimic.is_some())
    }

    /// The quaternions in q: the name of the joint of each, and the entry of q that it begins at.
    pub fn quaternions(&self) -> impl Iterator<Item = (&str, usize)> + '_ {
        self.links.iter().zip(&self.places).filter_map(|(link, place)| {
            let first = match link.joint.joint_type {
                JointType::Spherical => 0,
                JointType::Floating => 3,
                _ => return None,
            };
            Some((link.joint.name.as_str(), place.q.start + first))
        })
    }

    /// What each entry of q is called: by its joint, and its part of the joint where that has
    /// several (`hip.qw`).
    #[must_use]
    pub fn coordinate_names(&self) -> Vec<String> {
        self.entry_names(JointType::coordinates)
    }

    /// What each entry of qd is called.
    #[must_use]
    pub fn velocity_names(&self) -> Vec<String> {
        self.entry_names(JointType::velocities)
    }

    fn entry_names(&self, parts: fn(JointType) -> &'static [&'static str]) -> Vec<String> {
        let own = self.links.iter().map(|link| &link.joint).filter(|joint| joint.mimic.is_none());
        own.flat_map(|joint| {
            parts(joint.joint_type).iter().map(|part| match *part {
                "" => joint.name.clone(),
                part => alloc::format!("{}.{part}", joint.name),
            })
        })
        .collect()
    }

    /// The links that hang directly on each link, in order.
    #[must_use]
    pub fn children(&self) -> Vec<Vec<usize>> {
        let mut children = alloc::vec![Vec::new(); self.links.len()];
        for (i, link) in self.links.iter().enumerate() {
            if let Some(siblings) = link.parent.and_then(|p| children.get_mut(p)) {
                siblings.push(i);
            }
        }
        children
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for Model {
    /// Reads the parts and validates them, as [`Model::new`] does.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(serde::Deserialize)]
        #[serde(rename = "Model")]
        struct Parts {
            name: String,
            gravity: [f64; 3],
            #[serde(default)]
            friction: Friction,
            links: Vec<Link>,
            frames: Vec<Frame>,
            #[serde(default)]
            loop_constraints: Vec<LoopConstraint>,
            #[serde(default)]
            contacts: Vec<Contact>,
        }
        let Parts { name, gravity, friction, links, frames, loop_constraints, contacts } =
            Parts::deserialize(deserializer)?;
        let model = Self::new(name, gravity, links, frames)
            .and_then(|model| model.with_friction(friction))
            .and_then(|model| model.with_loop_constraints(loop_constraints))
            .and_then(|model| model.with_contacts(contacts));
        model.map_err(|errors| {
            let all: Vec<String> = errors.iter().map(alloc::string::ToString::to_string).collect();
            serde::de::Error::custom(all.join("; "))
        })
    }
}
