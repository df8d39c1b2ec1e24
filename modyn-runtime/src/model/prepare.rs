//! Exact rewrites that make a model cheap to compute with: [`Model`] to [`Prepared`].
//!
//! 1. **z axes.** Link frames are turned so that every joint's axis is z.
//! 2. **Turned frames.** A rotation between two frames is Rz Rx Rz. The last factor joins the
//!    child's joint angle; the first is taken over by the parent's joint angle for one child of
//!    each link (the one that carries most). What is left is a rotation about x.
//! 3. **Shifted origins.** A revolute joint's frame may stand anywhere along its axis: where the
//!    translation from its parent has a component less. (2 and 3 are Denavit and Hartenberg's
//!    argument, carried over to trees.)
//! 4. **Minimal parameters.** Mass on a revolute axis moves with parent and child alike, so the
//!    child's mass, first moment along z and second moment along z may be counted with the parent;
//!    behind a prismatic joint the same holds for the whole second moment. What is then left on
//!    the child are the parameters its joint can feel (Gautier and Khalil 1990, "Direct calculation
//!    of minimum set of inertial parameters of serial robots").
//! 5. **Snapping.** Constant turns within 1e-11 rad of a quarter turn become that; translations and
//!    components of axes below 1e-11 become 0.
//!
//! All five leave the joint coordinates, and so every joint-space quantity, as they were. The
//! fourth changes single links' inertias, and on a fixed base it drops mass that cannot move,
//! with its constant share of the potential energy; so [`Body::inertia`] keeps what was written.

use alloc::vec::Vec;

use super::{Inertial, Model};
use crate::Scalar;
use crate::joint::{JointType, Motion};
use crate::spatial::{
    ArticulatedInertia, Axis, Matrix3, Placement, Pose, RigidInertia, Symmetric3, Turn, Twist,
    Vector3, Wrench,
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

/// A moving link in its turned and shifted frame, whose z axis is the joint's.
#[derive(Clone, Copy, Debug)]
pub struct Body<S> {
    /// The body it hangs on; `None` for the world.
    pub parent: Option<usize>,
    /// What motion its joint allows along z.
    pub joint_type: JointType,
    /// The joint's zero.
    pub zero: Zero<S>,
    /// Where the joint stands on the parent.
    pub placement: Placement<S>,
    /// The model's link frame in this one.
    pub link: Pose<S>,
    /// The inertia as the model has it.
    pub inertia: RigidInertia<S>,
    /// The inertia in minimal parameters: equal to `inertia` for all joint-space dynamics.
    pub minimal: RigidInertia<S>,
}

/// A link of the description, as a frame on a body.
#[derive(Clone, Copy, Debug)]
pub struct BodyFrame<S> {
    /// The body that carries it; `None` for the world.
    pub body: Option<usize>,
    /// Its pose in the body's turned frame, or in the world.
    pub pose: Pose<S>,
}

/// A model rewritten for computing, on scalars of type `S`.
#[derive(Clone, Debug)]
pub struct Prepared<S> {
    /// The acceleration of free fall in world axes.
    pub gravity: Vector3<S>,
    /// One body a moving link, in the model's order.
    pub bodies: Vec<Body<S>>,
    /// One frame a link of the description, in the model's order.
    pub frames: Vec<BodyFrame<S>>,
}

impl<S: Scalar> Body<S> {
    /// The joint at coordinate `q`.
    #[must_use]
    pub fn motion(&self, q: S) -> Motion<S> {
        Motion::new(self.joint_type, self.zero, q)
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

    /// An articulated inertia on this body at its parent: A^T M A.
    #[must_use]
    pub fn articulated_to_parent(
        &self,
        motion: &Motion<S>,
        i: &ArticulatedInertia<S>,
    ) -> ArticulatedInertia<S> {
        self.placement.articulated_to_parent(&motion.articulated_to_parent(i))
    }
}

impl Prepared<f64> {
    /// Rewrites `model`.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let mut frames = Frames::on_axes(model);
        frames.turn(model);
        frames.shift();
        let mut prepared = frames.finish(model);
        prepared.minimize();
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
                    joint_type: b.joint_type,
                    zero: match b.zero {
                        Zero::Quarters(n) => Zero::Quarters(n),
                        Zero::Angle(x) => Zero::Angle(f(x)),
                    },
                    placement: b.placement.map(f),
                    link: b.link.map(f),
                    inertia: b.inertia.map(f),
                    minimal: b.minimal.map(f),
                })
                .collect(),
            frames: self
                .frames
                .iter()
                .map(|frame| BodyFrame { body: frame.body, pose: frame.pose.map(f) })
                .collect(),
        }
    }

    /// Moves what joints cannot feel towards the root, leaves first.
    fn minimize(&mut self) {
        for i in (0..self.bodies.len()).rev() {
            let body = self.bodies[i];
            let own = body.minimal;
            let (kept, moved) = match body.joint_type {
                JointType::Revolute | JointType::Continuous => {
                    let (c, s) = (own.first_moment, own.second_moment);
                    let on_axis = Symmetric3 { zz: s.zz, ..Symmetric3::zero() };
                    (
                        RigidInertia {
                            mass: 0.0,
                            first_moment: Vector3([c[0], c[1], 0.0]),
                            second_moment: Symmetric3 { zz: 0.0, ..s },
                        },
                        RigidInertia {
                            mass: own.mass,
                            first_moment: Vector3::along_z(c[2]),
                            second_moment: on_axis,
                        },
                    )
                }
                JointType::Prismatic => (
                    RigidInertia { second_moment: Symmetric3::zero(), ..own },
                    RigidInertia { second_moment: own.second_moment, ..RigidInertia::zero() },
                ),
            };
            self.bodies[i].minimal = kept;
            if let Some(parent) = body.parent {
                let sum = self.bodies[parent].minimal + body.placement.rigid_to_parent(&moved);
                self.bodies[parent].minimal = sum;
            }
        }
    }
}

/// The model's frames while they are being turned and shifted.
struct Frames {
    children: Vec<Vec<usize>>,
    revolute: Vec<bool>,
    /// Rz(azimuth) Trans(translation) Rx(tilt) Rz(zero) from the parent's frame, joint at 0.
    azimuth: Vec<Direction>,
    translation: Vec<Vector3<f64>>,
    tilt: Vec<Direction>,
    zero: Vec<Direction>,
    /// The model's link frame in the turned and shifted one.
    link: Vec<Pose<f64>>,
}

impl Frames {
    /// Every joint's axis as z.
    fn on_axes(model: &Model) -> Self {
        let links = model.links();
        let axes: Vec<Matrix3<f64>> = links.iter().map(|l| frame_along(l.joint.axis)).collect();
        let mut frames = Self {
            children: main_child_first(model),
            revolute: links.iter().map(|l| l.joint.joint_type != JointType::Prismatic).collect(),
            azimuth: Vec::with_capacity(links.len()),
            translation: Vec::with_capacity(links.len()),
            tilt: Vec::with_capacity(links.len()),
            zero: Vec::with_capacity(links.len()),
            link: axes
                .iter()
                .map(|a| Pose { rotation: a.transposed().0, translation: [0.0; 3] })
                .collect(),
        };
        for (link, axis) in links.iter().zip(&axes) {
            let origin = &link.joint.origin;
            let mut rotation = Matrix3(origin.rotation).times(axis);
            let mut translation = Vector3(origin.translation);
            if let Some(parent) = link.parent {
                let back = axes[parent].transposed();
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
    /// revolute one's towards its main child (or a leaf's towards its centre of mass).
    fn turn(&mut self, model: &Model) {
        for (i, link) in model.links().iter().enumerate() {
            let by = match self.children[i].first() {
                _ if !self.revolute[i] => inverse(self.zero[i]),
                // Parallel axes need no azimuth, so the turn is free for the translation.
                Some(&main) if self.tilt[main].1 == 0.0 => towards(self.translation[main]),
                Some(&main) => self.azimuth[main],
                None => {
                    towards(Vector3(self.link[i].transform_point(link.inertial.center_of_mass)))
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
            if !self.revolute[i] {
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

    fn finish(self, model: &Model) -> Prepared<f64> {
        let bodies = model.links().iter().enumerate().map(|(i, link)| {
            let inertia = rigid_inertia(&link.inertial.transformed(&self.link[i]));
            Body {
                parent: link.parent,
                joint_type: link.joint.joint_type,
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
            }
        });
        let frames = model.frames().iter().map(|frame| BodyFrame {
            body: frame.link,
            pose: frame.link.map_or(frame.pose, |link| self.link[link].compose(&frame.pose)),
        });
        Prepared {
            gravity: Vector3(model.gravity()),
            bodies: bodies.collect(),
            frames: frames.collect(),
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

/// The children of each link, the one that most links hang on first.
fn main_child_first(model: &Model) -> Vec<Vec<usize>> {
    let mut size = alloc::vec![1usize; model.links().len()];
    for (i, link) in model.links().iter().enumerate().rev() {
        if let Some(parent) = link.parent {
            size[parent] += size[i];
        }
    }
    let mut children = model.children();
    for siblings in &mut children {
        siblings.sort_by_key(|&child| core::cmp::Reverse(size[child]));
    }
    children
}

/// Mass and moments about the frame's origin.
fn rigid_inertia(inertial: &Inertial) -> RigidInertia<f64> {
    let m = inertial.mass;
    let c = inertial.center_of_mass;
    let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
    let half_trace = 0.5 * (xx + yy + zz);
    RigidInertia {
        mass: m,
        first_moment: Vector3(c.map(|x| m * x)),
        second_moment: Symmetric3 {
            xx: half_trace - xx + m * c[0] * c[0],
            xy: m * c[0] * c[1] - xy,
            xz: m * c[0] * c[2] - xz,
            yy: half_trace - yy + m * c[1] * c[1],
            yz: m * c[1] * c[2] - yz,
            zz: half_trace - zz + m * c[2] * c[2],
        },
    }
}
