//! Exact rewrites that make a model cheap to compute with: [`Model`] to [`Prepared`].
//!
//! 0. **Primitives.** Universal and planar joints are taken apart into revolute and prismatic ones
//!    with massless bodies between them.
//! 1. **z axes.** Frames are turned so that the axis of every revolute or prismatic joint is z.
//! 2. **Turned frames.** A rotation between two frames is Rz Rx Rz. The last factor joins the
//!    child's joint angle; the first is taken over by the parent's joint angle for one child of
//!    each link (the one that carries most). What is left is a rotation about x.
//! 3. **Shifted origins.** A revolute joint's frame may stand anywhere along its axis: where the
//!    translation from its parent has a component less. (2 and 3 are Denavit and Hartenberg's
//!    argument, carried over to trees.)
//! 4. **Minimal parameters.** Mass on a revolute axis moves with parent and child alike, so the
//!    child's mass, first moment along z and second moment along z may be counted with the parent;
//!    behind a prismatic joint the same holds for the whole second moment, behind a spherical one
//!    for the mass. What is then left on
//!    the child are the parameters its joint can feel (Gautier and Khalil 1990, "Direct calculation
//!    of minimum set of inertial parameters of serial robots").
//! 5. **Snapping.** Constant turns within 1e-11 rad of a quarter turn become that; translations and
//!    components of axes below 1e-11 become 0.
//!
//! All of them leave the joint coordinates, and so every joint-space quantity, as they were. The
//! fourth changes single links' inertias, and on a fixed base it drops mass that cannot move,
//! with its constant share of the potential energy; so [`Body::inertia`] keeps what was written.

pub mod coordinates;

use alloc::vec::Vec;
use core::ops::Range;

use self::coordinates::{Coordinates, coordinates};
use crate::Scalar;
use crate::joint::{JointType, Motion, Primitive, planar};
use crate::model::{Closure, ClosureKind, Friction, Inertial, Joint, Model};
use crate::spatial::{
    ArticulatedInertia, Axis, Matrix3, Placement, Pose, RigidInertia, Symmetric3, Turn, Twist,
    Vector3, VelocityMoments, Wrench,
};

/// Sines, cosines, translations (m) and components of axes nearer to 0 than this are taken for it.
const SNAP: f64 = 1e-11;

/// Where a revolute joint's turned frame has its zero, against the coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Zero<S> {
    /// That many quarter turns ahead.
    Quarters(u8),
    /// So many rad ahead.
    Angle(S),
}

impl<S: Scalar> Zero<S> {
    /// The turn by it.
    #[must_use]
    pub fn turn(self) -> Turn<S> {
        match self {
            Self::Quarters(n) => Turn::Quarters(n),
            Self::Angle(angle) => {
                let (sin, cos) = angle.sin_cos();
                Turn::Angle { cos, sin }
            }
        }
    }
}

/// A moving link, or a massless body inside a universal or planar joint, in its turned and shifted
/// frame.
#[derive(Clone, Debug)]
pub struct Body<S> {
    /// The body it hangs on; `None` for the world.
    pub parent: Option<usize>,
    /// What motion its joint allows, along z if along an axis.
    pub primitive: Primitive,
    /// Where its first coordinate stands in q.
    pub q: usize,
    /// The ratio and offset of its coordinate to that one, for a joint that mimics.
    pub mimic: Option<(S, S)>,
    /// Its degrees of freedom, among those of [`Prepared::dofs`].
    pub dofs: Range<usize>,
    /// The joint's zero.
    pub zero: Zero<S>,
    /// Where the joint stands on the parent.
    pub placement: Placement<S>,
    /// The model's link frame in this one; without meaning for a body inside a joint.
    pub link: Pose<S>,
    /// The inertia as the model has it.
    pub inertia: RigidInertia<S>,
    /// The inertia in minimal parameters: equal to `inertia` for all joint-space dynamics.
    pub minimal: RigidInertia<S>,
    /// How many limbs it is the first body of, where they are computed as one; else 1. What hangs on a
    /// parent adds up over them.
    pub limbs: usize,
    /// What each of these limbs hangs on, if that is not the same for all; else none. `parent` is then the
    /// last one.
    pub parents: Vec<Option<usize>>,
}

/// A degree of freedom: the unit motion of a body in one component.
#[derive(Clone, Copy, Debug)]
pub struct Dof<S> {
    /// The body that it moves.
    pub body: usize,
    /// The component (angular x, y, z, linear x, y, z) of the body's twist.
    pub component: usize,
    /// The entry of qd, qdd and tau.
    pub v: usize,
    /// The ratio to that entry, for a joint that mimics.
    pub multiplier: Option<S>,
    /// Inertia of the rotor as this motion feels it, if there is one.
    pub armature: Option<S>,
    /// Viscous damping, if it acts.
    pub damping: Option<S>,
    /// Coulomb friction, if it acts.
    pub friction: Option<S>,
}

impl<S: Scalar> Dof<S> {
    /// Its rate (or acceleration), of the joint vector `x`.
    #[must_use]
    pub fn rate(&self, x: &[S]) -> S {
        self.scale(x[self.v])
    }

    /// `x` as the joint that it belongs to has it, with the ratio of a joint that mimics.
    #[must_use]
    pub fn scale(&self, x: S) -> S {
        self.multiplier.map_or(x, |multiplier| multiplier * x)
    }

    /// Adds what it feels to the joint vector `sum`.
    pub fn add(&self, felt: S, sum: &mut [S]) {
        sum[self.v] = sum[self.v] + self.scale(felt);
    }
}

/// The rates of a joint: as many numbers as it has degrees of freedom.
#[derive(Clone, Copy, Debug)]
pub struct Rates<S> {
    numbers: [S; 6],
    count: usize,
}

impl<S> core::ops::Deref for Rates<S> {
    type Target = [S];
    fn deref(&self) -> &[S] {
        &self.numbers[..self.count]
    }
}

/// A link of the description, as a frame on a body.
#[derive(Clone, Copy, Debug)]
pub struct BodyFrame<S> {
    /// The body that carries it; `None` for the world.
    pub body: Option<usize>,
    /// Its pose in the body's turned frame, or in the world.
    pub pose: Pose<S>,
}

impl<S: Scalar> BodyFrame<S> {
    /// Each number through `f`.
    fn map<T>(&self, f: impl FnMut(S) -> T) -> BodyFrame<T> {
        BodyFrame { body: self.body, pose: self.pose.map(f) }
    }
}

/// Two frames that are held together.
#[derive(Clone, Debug)]
pub struct HeldFrames<S> {
    /// The first frame, whose axes what is held is given in, and the second.
    pub ends: [BodyFrame<S>; 2],
    /// The axis that the frames have in common, if one is held.
    pub hinge: Option<Vector3<S>>,
    /// What is held, a row of the constraint Jacobian each.
    pub rows: Vec<HeldRow<S>>,
}

/// What a closure holds in one direction.
#[derive(Clone, Copy, Debug)]
pub struct HeldRow<S> {
    /// Whether it is a rotation about the direction, not a displacement along it.
    pub angular: bool,
    /// A unit vector in the first frame's axes.
    pub direction: Vector3<S>,
}

impl<S: Scalar> HeldFrames<S> {
    /// Each number through `f`.
    fn map<T>(&self, f: impl Fn(S) -> T) -> HeldFrames<T> {
        let vector = |v: Vector3<S>| Vector3(v.0.map(&f));
        let row =
            |row: &HeldRow<S>| HeldRow { angular: row.angular, direction: vector(row.direction) };
        HeldFrames {
            ends: self.ends.map(|end| end.map(&f)),
            hinge: self.hinge.map(vector),
            rows: self.rows.iter().map(row).collect(),
        }
    }
}

/// A model rewritten for computing, on scalars of type `S`.
#[derive(Clone, Debug)]
pub struct Prepared<S> {
    /// The acceleration of free fall in world axes.
    pub gravity: Vector3<S>,
    /// One body (or more, see [`Primitive`]) a moving link, in the model's order.
    pub bodies: Vec<Body<S>>,
    /// The degrees of freedom in the order of their bodies. Without mimics, in that of qd.
    pub dofs: Vec<Dof<S>>,
    /// What minimal parameters leave to the world: inertia of bodies that no joint moves, about the
    /// world's origin.
    pub immobile: RigidInertia<S>,
    /// By moving link of the model: its body, which is the last one of its joint.
    pub links: Vec<usize>,
    /// Length of q.
    pub nq: usize,
    /// Length of qd.
    pub nv: usize,
    /// The coordinates, by what they are.
    pub coordinates: Vec<Coordinates<S>>,
    /// Over which velocity Coulomb friction rises; `None` where its sign jumps.
    pub smooth: Option<S>,
    /// One frame a link of the description, in the model's order.
    pub frames: Vec<BodyFrame<S>>,
    /// What closes loops, in the model's order.
    pub closures: Vec<HeldFrames<S>>,
    /// How many columns of derivatives are computed side by side, of joints one behind the other: 1, but
    /// where the compiler has lanes for them (numbers have not).
    pub columns_abreast: usize,
}

impl<S: Scalar> Body<S> {
    /// The joint where the robot's coordinates are `q`.
    #[must_use]
    pub fn motion(&self, q: &[S]) -> Motion<S> {
        let own = &q[self.q..self.q + self.primitive.nq()];
        match (self.mimic, own) {
            (Some((multiplier, offset)), &[q]) => {
                Motion::new(self.primitive, self.zero, &[multiplier * q + offset])
            }
            _ => Motion::new(self.primitive, self.zero, own),
        }
    }

    /// A direction of the parent's frame, seen from this body.
    #[must_use]
    pub fn to_child(&self, motion: &Motion<S>, v: Vector3<S>) -> Vector3<S> {
        motion.to_child(self.placement.to_child(v))
    }

    /// A direction of this body's frame, seen from the parent.
    #[must_use]
    pub fn to_parent(&self, motion: &Motion<S>, v: Vector3<S>) -> Vector3<S> {
        self.placement.to_parent(motion.to_parent(v))
    }

    /// The parent's twist carried rigidly to this body: A t of the paper.
    #[must_use]
    pub fn twist_to_child(&self, motion: &Motion<S>, t: Twist<S>) -> Twist<S> {
        motion.twist_to_child(self.placement.twist_to_child(t))
    }

    /// A wrench on this body at its parent: A^T w.
    #[must_use]
    pub fn wrench_to_parent(&self, motion: &Motion<S>, w: Wrench<S>) -> Wrench<S> {
        self.placement.wrench_to_parent(motion.wrench_to_parent(w))
    }

    /// A rigid inertia on this body at its parent: A^T M A.
    #[must_use]
    pub fn rigid_to_parent(&self, motion: &Motion<S>, i: &RigidInertia<S>) -> RigidInertia<S> {
        self.placement.rigid_to_parent(&motion.rigid_to_parent(i))
    }

    /// Moments of velocities against this body's frame, of points of inertia `i`, at its parent and
    /// against the parent's frame.
    #[must_use]
    pub fn velocities_to_parent(
        &self,
        motion: &Motion<S>,
        velocities: &VelocityMoments<S>,
        i: &RigidInertia<S>,
        rates: &[S],
    ) -> VelocityMoments<S> {
        self.placement.velocities_to_parent(&motion.velocities_to_parent(velocities, i, rates))
    }

    /// An articulated inertia on this body at its parent: A^T M A.
    #[must_use]
    pub fn articulated_to_parent(
        &self,
        motion: &Motion<S>,
        i: &ArticulatedInertia<S>,
    ) -> ArticulatedInertia<S> {
        self.placement.articulated_to_parent(&motion.articulated_to_parent(i))
    }

    /// A mass on this body and its first moment, at its parent.
    #[must_use]
    pub fn mass_to_parent(
        &self,
        motion: &Motion<S>,
        mass: S,
        first_moment: Vector3<S>,
    ) -> (S, Vector3<S>) {
        let turned = motion.to_parent(first_moment);
        let at_joint = motion.displacement().map_or(turned, |d| turned + d.scale(mass));
        (mass, self.placement.to_parent(at_joint) + self.placement.origin().scale(mass))
    }

    /// The numbers that its joint gets from what it hangs on: those of a body, or of the world (`None`).
    pub fn from_parents<const N: usize>(&self, of: impl Fn(Option<usize>) -> [S; N]) -> [S; N] {
        if self.parents.is_empty() {
            return of(self.parent);
        }
        let each: Vec<[S; N]> = self.parents.iter().map(|&parent| of(parent)).collect();
        core::array::from_fn(|n| S::by_limb(&each.iter().map(|x| x[n]).collect::<Vec<_>>()))
    }

    /// Of numbers of limbs that hang on different bodies: those of limbs on body `parent`, and zeros.
    pub(crate) fn only_on(&self, parent: usize, x: S) -> S {
        let on = |(limb, on): (usize, &Option<usize>)| {
            if *on == Some(parent) { x.of_limb(limb) } else { S::zero() }
        };
        S::by_limb(&self.parents.iter().enumerate().map(on).collect::<Vec<_>>())
    }

    /// Gives each body that it hangs on what the limbs there leave together: `add` gets the body and what
    /// `left` makes of the sum over them.
    pub fn to_parents<X>(
        &self,
        left: impl Fn(&dyn Fn(S) -> S) -> X,
        mut add: impl FnMut(usize, X),
    ) {
        let mut give = |parent: Option<usize>, limbs: Range<usize>| {
            if let Some(parent) = parent {
                add(parent, left(&|x: S| x.over_limbs(limbs.clone())));
            }
        };
        if self.parents.is_empty() {
            return give(self.parent, 0..self.limbs);
        }
        let mut start = 0;
        for limbs in self.parents.chunk_by(|a, b| a == b) {
            give(limbs[0], start..start + limbs.len());
            start += limbs.len();
        }
    }

    /// Gives them a mass on this body and its first moment.
    pub fn mass_to_parents(
        &self,
        motion: &Motion<S>,
        mass: S,
        first_moment: Vector3<S>,
        add: impl FnMut(usize, (S, Vector3<S>)),
    ) {
        if self.parent.is_some() {
            let (mass, first_moment) = self.mass_to_parent(motion, mass, first_moment);
            self.to_parents(|sum| (sum(mass), Vector3(first_moment.0.map(sum))), add);
        }
    }

    /// Gives them a wrench on this body.
    pub fn wrench_to_parents(
        &self,
        motion: &Motion<S>,
        w: Wrench<S>,
        add: impl FnMut(usize, Wrench<S>),
    ) {
        if self.parent.is_some() {
            let carried = self.wrench_to_parent(motion, w).components();
            self.to_parents(|sum| Wrench::from_components(carried.map(sum)), add);
        }
    }

    /// Gives them a rigid inertia on this body.
    pub fn rigid_to_parents(
        &self,
        motion: &Motion<S>,
        i: &RigidInertia<S>,
        add: impl FnMut(usize, RigidInertia<S>),
    ) {
        if self.parent.is_some() {
            let carried = self.rigid_to_parent(motion, i);
            self.to_parents(|sum| carried.map(sum), add);
        }
    }

    /// Gives them an articulated inertia on this body.
    pub fn articulated_to_parents(
        &self,
        motion: &Motion<S>,
        i: &ArticulatedInertia<S>,
        add: impl FnMut(usize, ArticulatedInertia<S>),
    ) {
        if self.parent.is_some() {
            let carried = self.articulated_to_parent(motion, i);
            let entry = |row, column| carried.entry(row, column);
            self.to_parents(
                |sum| ArticulatedInertia::from_fn(|row, column| sum(entry(row, column))),
                add,
            );
        }
    }
}

impl<S: Scalar> Prepared<S> {
    /// The degrees of freedom of body `i`.
    #[must_use]
    pub fn dofs_of(&self, i: usize) -> &[Dof<S>] {
        &self.dofs[self.bodies[i].dofs.clone()]
    }

    /// The rates of body `i`'s joint, of the joint vector `x`.
    #[must_use]
    pub fn rates(&self, i: usize, x: &[S]) -> Rates<S> {
        let dofs = self.dofs_of(i);
        let mut rates = Rates { numbers: [S::zero(); 6], count: dofs.len() };
        for (rate, dof) in rates.numbers.iter_mut().zip(dofs) {
            *rate = dof.rate(x);
        }
        rates
    }

    /// `t` with body `i`'s joint's own rates (or accelerations) added: t + P qd.
    #[must_use]
    pub fn add_rates(&self, i: usize, t: Twist<S>, x: &[S]) -> Twist<S> {
        let mut components = t.components();
        for dof in self.dofs_of(i) {
            components[dof.component] = components[dof.component] + dof.rate(x);
        }
        Twist::from_components(components)
    }

    /// Whether joints follow others: degrees of freedom then share entries of the joint vectors.
    #[must_use]
    pub fn has_mimics(&self) -> bool {
        self.dofs.len() != self.nv
    }

    /// The torque that joints hold against the rates `qd` by damping and friction, at `dof`.
    #[must_use]
    pub fn resistance(&self, dof: &Dof<S>, qd: &[S]) -> Option<S> {
        let rate = dof.rate(qd);
        let viscous = dof.damping.map(|damping| damping * rate);
        let dry = dof.friction.map(|friction| match self.smooth {
            Some(w) => friction * (rate / (rate * rate + w * w).sqrt()),
            None => {
                let backwards = (-rate).select_nonnegative(S::zero(), friction);
                rate.select_nonnegative(backwards, -friction)
            }
        });
        match (viscous, dry) {
            (Some(viscous), Some(dry)) => Some(viscous + dry),
            (viscous, dry) => viscous.or(dry),
        }
    }

    /// The derivative of [`resistance`](Self::resistance) by the degree of freedom's own rate; that
    /// of Coulomb friction counts as 0 at the jump too.
    #[must_use]
    pub fn resistance_slope(&self, dof: &Dof<S>, qd: &[S]) -> Option<S> {
        let smooth = dof.friction.zip(self.smooth).map(|(friction, w)| {
            let (rate, square) = (dof.rate(qd), w * w);
            let steep = (rate * rate + square).sqrt().recip();
            friction * square * (steep * steep * steep)
        });
        match (dof.damping, smooth) {
            (Some(damping), Some(smooth)) => Some(damping + smooth),
            (damping, smooth) => damping.or(smooth),
        }
    }

    /// Gives link `frame` of the description (as an index) another inertia in place of its own:
    /// `own`, which a [`Model`]'s frame states, and `other`, both about the link's origin in its
    /// own axes. On a link that is fixed to the world this changes nothing.
    pub fn replace_inertia(
        &mut self,
        frame: usize,
        own: &RigidInertia<S>,
        other: &RigidInertia<S>,
    ) {
        let BodyFrame { body: Some(body), pose } = self.frames[frame] else { return };
        let body = &mut self.bodies[body];
        let (own, other) = (own.placed(&pose), other.placed(&pose));
        body.inertia = body.inertia.minus(&own) + other;
        body.minimal = body.minimal.minus(&own) + other;
    }
}

impl Prepared<f64> {
    /// Rewrites `model`.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let (atoms, links) = atoms(model);
        let mut frames = Frames::on_axes(&atoms);
        frames.turn(&atoms);
        frames.shift();
        let mut prepared = frames.finish(model, &atoms, links);
        prepared.minimize();
        prepared.closures = model.closures().iter().map(|c| prepared.held(c)).collect();
        prepared
    }

    /// The same with each number as a scalar of type `S`.
    #[must_use]
    pub fn cast<S: Scalar>(&self) -> Prepared<S> {
        let f = S::from_f64;
        Prepared {
            gravity: Vector3(self.gravity.0.map(f)),
            bodies: self
                .bodies
                .iter()
                .map(|b| Body {
                    parent: b.parent,
                    primitive: b.primitive,
                    q: b.q,
                    mimic: b.mimic.map(|(multiplier, offset)| (f(multiplier), f(offset))),
                    dofs: b.dofs.clone(),
                    zero: match b.zero {
                        Zero::Quarters(n) => Zero::Quarters(n),
                        Zero::Angle(x) => Zero::Angle(f(x)),
                    },
                    placement: b.placement.map(f),
                    link: b.link.map(f),
                    inertia: b.inertia.map(f),
                    minimal: b.minimal.map(f),
                    limbs: b.limbs,
                    parents: b.parents.clone(),
                })
                .collect(),
            dofs: self
                .dofs
                .iter()
                .map(|d| Dof {
                    body: d.body,
                    component: d.component,
                    v: d.v,
                    multiplier: d.multiplier.map(f),
                    armature: d.armature.map(f),
                    damping: d.damping.map(f),
                    friction: d.friction.map(f),
                })
                .collect(),
            immobile: self.immobile.map(f),
            links: self.links.clone(),
            nq: self.nq,
            nv: self.nv,
            coordinates: self.coordinates.iter().map(|c| c.map(|x| f(*x))).collect(),
            smooth: self.smooth.map(f),
            frames: self.frames.iter().map(|frame| frame.map(f)).collect(),
            closures: self.closures.iter().map(|closure| closure.map(f)).collect(),
            columns_abreast: self.columns_abreast,
        }
    }

    /// What a closure holds.
    fn held(&self, closure: &Closure) -> HeldFrames<f64> {
        let ends = closure.ends.each_ref().map(|end| {
            let BodyFrame { body, pose } = self.frames[end.frame];
            BodyFrame { body, pose: pose.compose(&end.pose).map(snap) }
        });
        let hinge = match closure.kind {
            ClosureKind::Revolute(axis) => Some(Vector3(axis.map(snap))),
            _ => None,
        };
        let row = |angular| move |d: [f64; 3]| HeldRow { angular, direction: Vector3(d.map(snap)) };
        let [angular, linear] = closure.kind.held();
        let rows = angular.into_iter().map(row(true)).chain(linear.into_iter().map(row(false)));
        HeldFrames { ends, hinge, rows: rows.collect() }
    }

    /// Moves what joints cannot feel towards the root, leaves first.
    fn minimize(&mut self) {
        for i in (0..self.bodies.len()).rev() {
            let Body { minimal: own, primitive, .. } = self.bodies[i];
            let (c, s) = (own.first_moment, own.second_moment);
            let moved = match primitive {
                Primitive::Revolute => RigidInertia {
                    mass: own.mass,
                    first_moment: Vector3::along_z(c[2]),
                    second_moment: Symmetric3 { zz: s.zz, ..Symmetric3::zero() },
                },
                Primitive::Prismatic => RigidInertia { second_moment: s, ..RigidInertia::zero() },
                Primitive::Spherical => RigidInertia { mass: own.mass, ..RigidInertia::zero() },
                Primitive::Floating => continue,
            };
            self.bodies[i].minimal = own.minus(&moved);
            let carried = self.bodies[i].placement.rigid_to_parent(&moved);
            if let Some(parent) = self.bodies[i].parent {
                self.bodies[parent].minimal = self.bodies[parent].minimal + carried;
            } else {
                self.immobile = self.immobile + carried;
            }
        }
    }
}

/// A body with its primitive joint, before frames are turned.
struct Atom<'a> {
    parent: Option<usize>,
    primitive: Primitive,
    /// The frame whose z is the axis, in the atom's own; identity where there is no axis.
    frame: Matrix3<f64>,
    /// Where the atom stands in its parent at coordinate zero.
    origin: Pose<f64>,
    joint: &'a Joint,
    inertial: Inertial,
    q: usize,
    v: usize,
    mimic: Option<(f64, f64)>,
}

/// The bodies of a model, universal and planar joints taken apart; and by link, its body.
fn atoms(model: &Model) -> (Vec<Atom<'_>>, Vec<usize>) {
    let mut atoms: Vec<Atom<'_>> = Vec::with_capacity(model.links().len());
    let mut bodies: Vec<usize> = Vec::with_capacity(model.links().len());
    for (i, link) in model.links().iter().enumerate() {
        let joint = &link.joint;
        let axis = joint.axis;
        let plane = planar::plane(axis);
        let across = |column: usize| plane.map(|row| row[column]);
        let along = |primitive, axis| (primitive, frame_along(axis));
        let free = Matrix3(Pose::identity().rotation);
        let parts: &[(Primitive, Matrix3<f64>)] = match joint.joint_type {
            JointType::Revolute | JointType::Continuous => &[along(Primitive::Revolute, axis)],
            JointType::Prismatic => &[along(Primitive::Prismatic, axis)],
            JointType::Universal => {
                &[along(Primitive::Revolute, axis), along(Primitive::Revolute, joint.second_axis)]
            }
            JointType::Planar => &[
                along(Primitive::Prismatic, across(0)),
                along(Primitive::Prismatic, across(1)),
                along(Primitive::Revolute, axis),
            ],
            JointType::Spherical => &[(Primitive::Spherical, free)],
            JointType::Floating => &[(Primitive::Floating, free)],
        };
        let mimic = model.mimic(i).map(|mimic| (mimic.multiplier, mimic.offset));
        for (k, &(primitive, frame)) in parts.iter().enumerate() {
            let first = k == 0;
            let last = k + 1 == parts.len();
            atoms.push(Atom {
                parent: if first { link.parent.map(|p| bodies[p]) } else { Some(atoms.len() - 1) },
                primitive,
                frame,
                origin: if first { joint.origin } else { Pose::identity() },
                joint,
                inertial: if last { link.inertial } else { Inertial::default() },
                q: model.q_range(i).start + k,
                v: model.v_range(i).start + k,
                mimic,
            });
        }
        bodies.push(atoms.len() - 1);
    }
    (atoms, bodies)
}

/// The model's frames while they are being turned and shifted.
struct Frames {
    children: Vec<Vec<usize>>,
    primitive: Vec<Primitive>,
    /// Rz(azimuth) Trans(translation) Rx(tilt) Rz(zero) from the parent's frame, joint at 0.
    azimuth: Vec<Direction>,
    translation: Vec<Vector3<f64>>,
    tilt: Vec<Direction>,
    zero: Vec<Direction>,
    /// The model's link frame in the turned and shifted one.
    link: Vec<Pose<f64>>,
}

impl Frames {
    /// Every axis as z.
    fn on_axes(atoms: &[Atom<'_>]) -> Self {
        let mut frames = Self {
            children: main_child_first(atoms),
            primitive: atoms.iter().map(|atom| atom.primitive).collect(),
            azimuth: Vec::with_capacity(atoms.len()),
            translation: Vec::with_capacity(atoms.len()),
            tilt: Vec::with_capacity(atoms.len()),
            zero: Vec::with_capacity(atoms.len()),
            link: atoms
                .iter()
                .map(|a| Pose { rotation: a.frame.transposed().0, translation: [0.0; 3] })
                .collect(),
        };
        for atom in atoms {
            let mut rotation = Matrix3(atom.origin.rotation).times(&atom.frame);
            let mut translation = Vector3(atom.origin.translation);
            if let Some(parent) = atom.parent {
                let back = atoms[parent].frame.transposed();
                rotation = back.times(&rotation);
                translation = back.mul_vector(translation);
            }
            let [azimuth, tilt, zero] = split(&rotation);
            frames.translation.push(turn_of(inverse(azimuth)).vector(Axis::Z, translation));
            frames.azimuth.push(azimuth);
            frames.tilt.push(tilt);
            frames.zero.push(zero);
        }
        frames
    }

    /// Turns each frame about its own z: a prismatic joint's by what stands behind its tilt, a
    /// revolute one's towards its main child (or a leaf's towards its centre of mass). Frames of
    /// joints without an axis stay the links', whose axes their velocities are in.
    fn turn(&mut self, atoms: &[Atom<'_>]) {
        for (i, atom) in atoms.iter().enumerate() {
            let by = match self.children[i].first() {
                _ if self.primitive[i] == Primitive::Prismatic => inverse(self.zero[i]),
                _ if self.primitive[i] != Primitive::Revolute => continue,
                // Parallel axes need no azimuth, so the turn is free for the translation.
                Some(&main) if self.tilt[main].1 == 0.0 => towards(self.translation[main]),
                Some(&main) => self.azimuth[main],
                None => {
                    towards(Vector3(self.link[i].transform_point(atom.inertial.center_of_mass)))
                }
            };
            // Rz(q) Rz(by): the new frame is ahead of the old one.
            self.zero[i] = combine(self.zero[i], by);
            let back = turn_of(inverse(by));
            let columns = Matrix3(self.link[i].rotation).transposed().0;
            let columns = columns.map(|c| back.vector(Axis::Z, Vector3(c)).0);
            self.link[i].rotation = Matrix3(columns).transposed().0;
            for &child in &self.children[i] {
                let azimuth = combine(self.azimuth[child], inverse(by));
                let (cos, sin) = self.tilt[child];
                if sin == 0.0 {
                    // Rz(a) Rx(0 or pi) = Rx(0 or pi) Rz(a or -a): one with the child's zero.
                    let sense = if cos > 0.0 { azimuth } else { inverse(azimuth) };
                    self.zero[child] = combine(sense, self.zero[child]);
                    self.translation[child] =
                        turn_of(azimuth).vector(Axis::Z, self.translation[child]);
                } else {
                    self.azimuth[child] = azimuth;
                }
            }
        }
    }

    /// Shifts each revolute joint's frame along its axis to where a component of the translation
    /// from its parent vanishes.
    fn shift(&mut self) {
        for i in 0..self.children.len() {
            if self.primitive[i] != Primitive::Revolute {
                continue;
            }
            // Behind the azimuth the axis is (0, -sin, cos).
            let (cos, sin) = self.tilt[i];
            let [x, y, z] = self.translation[i].0;
            let (by, shifted) = if sin.abs() > cos.abs() {
                (y / sin, [x, 0.0, z + y / sin * cos])
            } else {
                (-z / cos, [x, y + z / cos * sin, 0.0])
            };
            self.translation[i] = Vector3(shifted);
            self.link[i].translation[2] -= by;
            for &child in &self.children[i] {
                self.translation[child][2] -= by;
            }
        }
    }

    fn finish(self, model: &Model, atoms: &[Atom<'_>], links: Vec<usize>) -> Prepared<f64> {
        let mut dofs = Vec::with_capacity(model.nv());
        let mut bodies: Vec<Body<f64>> = Vec::with_capacity(atoms.len());
        let friction = model.friction();
        for (i, atom) in atoms.iter().enumerate() {
            let inertia = rigid_inertia(&atom.inertial.transformed(&self.link[i]));
            let first = dofs.len();
            dofs.extend(atom.primitive.components().iter().enumerate().map(|(k, &component)| {
                let drive = &atom.joint.drive;
                let acting = |x: f64, acts: bool| (acts && x != 0.0).then_some(x);
                let dry = matches!(friction, Friction::Coulomb | Friction::Smooth(_));
                Dof {
                    body: i,
                    component,
                    v: atom.v + k,
                    multiplier: atom.mimic.map(|(multiplier, _)| multiplier),
                    armature: acting(drive.armature, true),
                    damping: acting(drive.damping, friction != Friction::None),
                    friction: acting(drive.friction, dry),
                }
            }));
            bodies.push(Body {
                parent: atom.parent,
                primitive: atom.primitive,
                q: atom.q,
                mimic: atom.mimic,
                dofs: first..dofs.len(),
                zero: match turn_of(self.zero[i]) {
                    Turn::Quarters(n) => Zero::Quarters(n),
                    Turn::Angle { cos, sin } => Zero::Angle(libm::atan2(sin, cos)),
                },
                placement: Placement {
                    azimuth: turn_of(self.azimuth[i]),
                    translation: Vector3(self.translation[i].0.map(snap)),
                    tilt: turn_of(self.tilt[i]),
                },
                link: self.link[i],
                inertia,
                minimal: inertia,
                limbs: 1,
                parents: Vec::new(),
            });
        }
        let frames = model.frames().iter().map(|frame| {
            let body = frame.link.map(|link| links[link]);
            let pose = body.map_or(frame.pose, |body| self.link[body].compose(&frame.pose));
            BodyFrame { body, pose }
        });
        Prepared {
            gravity: Vector3(model.gravity()),
            frames: frames.collect(),
            closures: Vec::new(),
            columns_abreast: 1,
            bodies,
            dofs,
            immobile: RigidInertia::zero(),
            links,
            nq: model.nq(),
            nv: model.nv(),
            coordinates: coordinates(model),
            smooth: match friction {
                Friction::Smooth(w) => Some(w),
                _ => None,
            },
        }
    }
}

/// Cosine and sine of a constant angle.
type Direction = (f64, f64);

/// No angle.
const AHEAD: Direction = (1.0, 0.0);

/// The direction of a vector in the x, y plane; ahead where it has none.
fn towards(v: Vector3<f64>) -> Direction {
    let [x, y, _] = v.0;
    let length = libm::hypot(x, y);
    if length < 1e-12 { AHEAD } else { snapped((x / length, y / length)) }
}

fn inverse((cos, sin): Direction) -> Direction {
    (cos, -sin)
}

/// The sum of the angles.
fn combine((c, s): Direction, (cos, sin): Direction) -> Direction {
    snapped((c * cos - s * sin, s * cos + c * sin))
}

fn snap(x: f64) -> f64 {
    if x.abs() < SNAP { 0.0 } else { x }
}

/// A direction of length 1 again, along an axis where it is nearly that.
fn snapped((cos, sin): Direction) -> Direction {
    match (snap(cos), snap(sin)) {
        (cos, 0.0) => (1.0_f64.copysign(cos), 0.0),
        (0.0, sin) => (0.0, 1.0_f64.copysign(sin)),
        (cos, sin) => {
            let length = libm::hypot(cos, sin);
            (cos / length, sin / length)
        }
    }
}

fn turn_of((cos, sin): Direction) -> Turn<f64> {
    if sin == 0.0 {
        Turn::Quarters(if cos > 0.0 { 0 } else { 2 })
    } else if cos == 0.0 {
        Turn::Quarters(if sin > 0.0 { 1 } else { 3 })
    } else {
        Turn::Angle { cos, sin }
    }
}

/// `rotation` as Rz(azimuth) Rx(tilt) Rz(zero); parallel axes have no azimuth.
fn split(rotation: &Matrix3<f64>) -> [Direction; 3] {
    let r = rotation.0.map(|row| row.map(snap));
    // The third column is (sin a sin t, -cos a sin t, cos t).
    let sin = libm::hypot(r[0][2], r[1][2]);
    let tilt = snapped((r[2][2], sin));
    let azimuth = if tilt.1 == 0.0 { AHEAD } else { towards(Vector3([-r[1][2], r[0][2], 0.0])) };
    let first = Vector3([r[0][0], r[1][0], r[2][0]]);
    let first = turn_of(inverse(azimuth)).vector(Axis::Z, first);
    [azimuth, tilt, towards(turn_of(inverse(tilt)).vector(Axis::X, first))]
}

/// A right-handed frame (as columns) whose z axis is `axis`; exact where that is a coordinate axis.
fn frame_along(axis: [f64; 3]) -> Matrix3<f64> {
    let unit = |v: Vector3<f64>| v.scale(1.0 / libm::sqrt(v.dot(v)));
    let z = unit(Vector3(axis.map(snap)));
    // Any direction that is not near the axis; `turn` chooses the x axis afterwards.
    let across = if z[0].abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let y = unit(z.cross(Vector3(across)));
    Matrix3([y.cross(z).0, y.0, z.0]).transposed()
}

/// The children of each body, the one that most bodies hang on first.
fn main_child_first(atoms: &[Atom<'_>]) -> Vec<Vec<usize>> {
    let mut size = alloc::vec![1usize; atoms.len()];
    let mut children = alloc::vec![Vec::new(); atoms.len()];
    for (i, atom) in atoms.iter().enumerate().rev() {
        if let Some(parent) = atom.parent {
            size[parent] += size[i];
            children[parent].push(i);
        }
    }
    for siblings in &mut children {
        siblings.reverse();
        siblings.sort_by_key(|&child| core::cmp::Reverse(size[child]));
    }
    children
}

/// Mass and moments about the frame's origin.
#[must_use]
pub fn rigid_inertia(inertial: &Inertial) -> RigidInertia<f64> {
    let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
    let inertia = Symmetric3 { xx, xy, xz, yy, yz, zz };
    RigidInertia::new(inertial.mass, Vector3(inertial.center_of_mass), &inertia)
}
