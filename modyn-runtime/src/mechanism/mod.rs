//! The mechanism: the model rewritten for computation, by exact rewrites from [`Model`] to
//! [`Mechanism`].
//!
//! 0. **Composite joints** (`elementary`). Universal and planar joints are expanded into revolute
//!    and prismatic joints with massless bodies between them.
//! 1. **z axes** (`dh_frames`). Frames are rotated so that the axis of every revolute or prismatic
//!    joint is z.
//! 2. **Rotated frames.** A rotation between two frames is Rz Rx Rz. The last factor is added to
//!    the child's joint angle. The first factor is added to the parent's joint angle, for one child
//!    of each link: the child with the largest subtree. The remaining rotation is about x.
//! 3. **Shifted origins.** A revolute joint's frame may be anywhere along its axis. It is shifted
//!    to where one component of the translation from its parent vanishes. (2 and 3 generalize
//!    Denavit and Hartenberg to trees.)
//! 4. **Base inertia** (`base_inertia`). Mass on a revolute axis has one motion with the parent and
//!    the child. The child's mass, first moment along z and second moment along z may therefore be
//!    moved to the parent. After a prismatic joint this holds for the whole second moment, after a
//!    spherical joint for the mass. The child keeps the parameters that its joint's force depends
//!    on (Gautier and Khalil 1990, "Direct calculation of minimum set of inertial parameters of
//!    serial robots").
//! 5. **Snapping** (`snapping`). Constant rotations within 1e-11 rad of a multiple of a quarter
//!    turn become exact. Components of axes below 1e-11 become 0, and so do translations below
//!    1e-11 of the lengths that they move, and moments of base inertias that are rounding errors
//!    beside the others.
//!
//! The rewrites leave the joint coordinates, and so every joint-space quantity, unchanged. The
//! fourth changes the inertias of single links. On a fixed base it also drops mass that cannot
//! move, with its constant part of the potential energy. [`Body::inertia`] therefore keeps the
//! inertia of the description.
//!
//! The rewrites are exact, and save more operations than all passes of the compiler.
//!
//! The equations know bodies with one of four elementary joints, and degrees of freedom: unit
//! motions of a body in one component of its twist. Each degree of freedom has an entry of the
//! joint vectors (`Dof::v`). The degrees of freedom of a joint and of its mimic joints share one
//! entry, with ratios, so sums over degrees of freedom need no special case. The recursive
//! elimination needs an entry for each degree of freedom. Robots with mimic joints are therefore
//! solved by the factors of their mass matrix (`Elimination::Matrix`).
//!
//! Kinetic energy and momentum use base inertias, which is exact: inertia is moved to the parent
//! only where it moves with parent and child alike. Potential energy and the centre of mass also
//! depend on inertia that does not move, so they use the described inertias, or add the part
//! without effect on motion (`Mechanism::static_inertia`).

mod armature;
mod base_inertia;
mod body;
mod body_frame;
mod constrained_frames;
pub mod coordinates;
mod degree_of_freedom;
mod dh_frames;
mod elementary;
mod friction;
mod gravity_compensation;
mod merged;
mod snapping;
mod spring;
mod tree;

use alloc::vec::Vec;

use crate::Scalar;
use crate::joint::{ElementaryJoint, JointOffset};
use crate::model::{JointFriction, Model};
use crate::spatial::{AxisRotation, DhTransform, RigidInertia, Twist, Vector3};
use constrained_frames::{constrained, touching};
use coordinates::{Coordinates, coordinates};
use dh_frames::Frames;
use elementary::{ElementaryBody, expand_composite_joints};

pub(crate) use tree::{RootwardAccumulator, TreeAccess};

pub use {
    body::{Body, BodyStructure, inertia_without, rigid_inertia},
    body_frame::BodyFrame,
    constrained_frames::{ConstrainedFrames, ConstraintRow},
    degree_of_freedom::{Dof, Rates},
    gravity_compensation::CompensatedMass,
    merged::MergedMechanism,
    spring::{JointSpring, SpringReference},
    tree::{BodyTree, LimbRoot},
};

/// A model rewritten for computation, on scalars of type `S`.
#[derive(Clone, Debug)]
pub struct Mechanism<S> {
    /// The acceleration of free fall in world axes.
    pub gravity: Vector3<S>,
    /// For each link of the description, the part of its own weight that is compensated; empty if
    /// none is.
    pub gravity_compensation: Vec<S>,
    /// The bodies: one for each moving link in the model's order, and more for composite joints.
    pub bodies: Vec<Body<S>>,
    /// The degrees of freedom in the order of their bodies. Without mimic joints this is the order
    /// of qd.
    pub dofs: Vec<Dof<S>>,
    /// The part of the inertia that no joint moves, about the world's origin. Base inertias leave
    /// it out.
    pub static_inertia: RigidInertia<S>,
    /// For each moving link of the model, its body: the last body of its joint.
    pub links: Vec<usize>,
    /// The length of q.
    pub nq: usize,
    /// The length of qd.
    pub nv: usize,
    /// The coordinates, grouped by their spaces.
    pub coordinates: Vec<Coordinates<S>>,
    /// The velocity of the smooth transition of Coulomb friction, rad/s or m/s; `None` for a jump.
    pub smooth: Option<S>,
    /// A frame for each link of the description, in the model's order.
    pub frames: Vec<BodyFrame<S>>,
    /// The constraints: loop constraints, then contacts, each in the model's order.
    pub constraints: Vec<ConstrainedFrames<S>>,
}

impl<S: Scalar> Mechanism<S> {
    /// Returns the mechanism with `f` applied to its numbers.
    #[must_use]
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> Mechanism<T> {
        Mechanism {
            gravity: Vector3(self.gravity.0.map(f)),
            gravity_compensation: self.gravity_compensation.iter().map(|x| f(*x)).collect(),
            bodies: self.bodies.iter().map(|body| body.map(f)).collect(),
            dofs: self.dofs.iter().map(|dof| dof.map(f)).collect(),
            static_inertia: self.static_inertia.map(f),
            links: self.links.clone(),
            nq: self.nq,
            nv: self.nv,
            coordinates: self.coordinates.iter().map(|c| c.map(|x| f(*x))).collect(),
            smooth: self.smooth.map(f),
            frames: self.frames.iter().map(|frame| frame.map(f)).collect(),
            constraints: self.constraints.iter().map(|constraint| constraint.map(f)).collect(),
        }
    }

    /// Returns the structure of each body, in the order of the bodies.
    pub fn structure(&self) -> impl Iterator<Item = BodyStructure> + '_ {
        self.bodies.iter().map(|body| body.structure(&self.dofs))
    }

    /// Returns the degrees of freedom of body `i`.
    #[must_use]
    pub fn dofs_of(&self, i: usize) -> &[Dof<S>] {
        &self.dofs[self.bodies[i].dofs.clone()]
    }

    /// Returns the rates of body `i`'s joint, given the joint vector `x`.
    #[must_use]
    pub fn rates(&self, i: usize, x: &[S]) -> Rates<S> {
        let dofs = self.dofs_of(i);
        let mut rates = Rates { numbers: [S::zero(); 6], count: dofs.len() };
        for (rate, dof) in rates.numbers.iter_mut().zip(dofs) {
            *rate = dof.rate(x);
        }
        rates
    }

    /// Returns `t` plus the motion of body `i`'s joint, given the joint rates (or accelerations)
    /// `x`: t + P qd.
    #[must_use]
    pub fn add_rates(&self, i: usize, t: Twist<S>, x: &[S]) -> Twist<S> {
        let mut components = t.components();
        for dof in self.dofs_of(i) {
            components[dof.component] = components[dof.component] + dof.rate(x);
        }
        Twist::from_components(components)
    }

    /// Returns the number of contacts, the last of the constraints.
    #[must_use]
    pub fn contacts(&self) -> usize {
        self.constraints.iter().filter(|constraint| constraint.contact).count()
    }

    /// Returns whether the robot has mimic joints. Degrees of freedom then share entries of the
    /// joint vectors.
    #[must_use]
    pub fn has_mimics(&self) -> bool {
        self.dofs.len() != self.nv
    }

    /// Adds `inertia` to the body that carries this link of the description (an
    /// index). `inertia` is about the link's origin, in the link's axes. Has no effect on a link that is
    /// fixed to the world.
    pub fn add_inertia(&mut self, link: usize, inertia: &RigidInertia<S>) {
        let BodyFrame { body: Some(body), pose } = self.frames[link] else { return };
        let body = &mut self.bodies[body];
        let inertia = inertia.placed(&pose);
        body.inertia = body.inertia + inertia;
        body.base_inertia = body.base_inertia + inertia;
    }

    /// Adds the part of `inertia` whose weight is compensated to the body that carries this link
    /// of the description (an index). `inertia` is the link's own, about its origin, in its axes.
    pub fn compensate(&mut self, link: usize, inertia: &RigidInertia<S>) {
        let Some(&factor) = self.gravity_compensation.get(link) else { return };
        let BodyFrame { body: Some(body), pose } = self.frames[link] else { return };
        let part = CompensatedMass::part(&inertia.placed(&pose), factor);
        let sum = &mut self.bodies[body].compensated;
        *sum = Some(sum.map_or(part, |sum| sum.plus(&part)));
    }

    /// Recomputes the base inertias and the static inertia from the bodies' inertias.
    pub fn update_base_inertias(&mut self) {
        self.static_inertia = base_inertia::move_to_parents(&mut self.bodies);
    }
}

impl Mechanism<f64> {
    /// Returns the mechanism of `model`.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let (elementary, body_of) = expand_composite_joints(model);
        let mut frames = Frames::with_axes_along_z(&elementary);
        frames.rotate(&elementary);
        frames.shift();
        let mut bodies = bodies(&elementary, &frames);
        let static_inertia = base_inertia::move_to_parents(&mut bodies);
        for body in &mut bodies {
            body.base_inertia = snapping::without_rounding(body.base_inertia);
        }
        let on_bodies = model.links().iter().map(|link| {
            let body = link.moving_link.map(|i| body_of[i]);
            let pose = body.map_or(link.pose, |body| frames.link[body].compose(&link.pose));
            BodyFrame { body, pose }
        });
        let frames: Vec<BodyFrame<f64>> = on_bodies.collect();
        let constrained = model.loop_constraints().iter().enumerate().map(|(i, constraint)| {
            constrained(&frames, constraint, model.characteristic_length(i))
        });
        let touching = model.contacts().iter().enumerate().map(|(i, contact)| {
            let carrier = frames[contact.end.link].body;
            let mut path = core::iter::successors(carrier, |&i| bodies[i].parent);
            let floats = path.any(|i| bodies[i].elementary_joint == ElementaryJoint::Floating);
            touching(&frames, contact, model.contact_length(i), floats)
        });
        let constraints = constrained.chain(touching).collect();
        let mut mechanism = Self {
            gravity: Vector3(model.gravity()),
            gravity_compensation: model.gravity_compensation().to_vec(),
            frames,
            constraints,
            bodies,
            dofs: dofs(&elementary, model.joint_friction()),
            static_inertia,
            links: body_of,
            nq: model.nq(),
            nv: model.nv(),
            coordinates: coordinates(model),
            smooth: match model.joint_friction() {
                JointFriction::Smooth(w) => Some(w),
                _ => None,
            },
        };
        let compensated =
            model.gravity_compensation().iter().enumerate().filter(|(_, x)| **x != 0.0);
        for (link, _) in compensated {
            mechanism.compensate(link, &rigid_inertia(&model.links()[link].inertial));
        }
        mechanism
    }

    /// Returns the mechanism with its numbers as scalars of type `S`.
    #[must_use]
    pub fn cast<S: Scalar>(&self) -> Mechanism<S> {
        self.map(S::from_f64)
    }
}

/// Returns the bodies in their rotated and shifted frames, with the model's inertias.
fn bodies(elementary: &[ElementaryBody<'_>], frames: &Frames) -> Vec<Body<f64>> {
    let mut next = 0;
    let body = |(i, record): (usize, &ElementaryBody<'_>)| {
        let inertia = rigid_inertia(&record.inertial.transformed(&frames.link[i]));
        let first = next;
        next += record.elementary_joint.components().len();
        Body {
            parent: record.parent,
            elementary_joint: record.elementary_joint,
            q: record.q,
            mimic: record.mimic,
            dofs: first..next,
            offset: match frames.offset[i].rotation() {
                AxisRotation::Quarters(n) => JointOffset::Quarters(n),
                AxisRotation::Angle { cos, sin } => JointOffset::Angle(libm::atan2(sin, cos)),
            },
            placement: DhTransform {
                azimuth: frames.azimuth[i].rotation(),
                translation: frames.kept_translation(i),
                tilt: frames.tilt[i].rotation(),
            },
            link: frames.link[i],
            inertia,
            base_inertia: inertia,
            spring: record.spring,
            compensated: None,
        }
    };
    elementary.iter().enumerate().map(body).collect()
}

/// Returns the degrees of freedom of all bodies, with the damping and friction that `friction`
/// selects.
fn dofs(elementary: &[ElementaryBody<'_>], friction: JointFriction) -> Vec<Dof<f64>> {
    let acting = |x: f64, acts: bool| (acts && x != 0.0).then_some(x);
    let dry = matches!(friction, JointFriction::Coulomb | JointFriction::Smooth(_));
    let dof = |(body, record): (usize, &ElementaryBody<'_>)| {
        let dynamics = record.joint.dynamics;
        let v = record.v;
        let multiplier = record.mimic.map(|(multiplier, _)| multiplier);
        record.elementary_joint.components().iter().enumerate().map(move |(k, &component)| Dof {
            body,
            component,
            v: v + k,
            multiplier,
            armature: acting(dynamics.armature, true),
            damping: acting(dynamics.damping, friction != JointFriction::None),
            friction: acting(dynamics.friction, dry),
        })
    };
    elementary.iter().enumerate().flat_map(dof).collect()
}
