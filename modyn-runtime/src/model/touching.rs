//! What touches the ground: shapes of links, and the softness of their contacts and of joints.

use alloc::{string::String, vec, vec::Vec};

use super::{Integrator, LoopConstraintEnd, Model, SoftCoupling, SoftTendon, Softness};
use crate::{ContactSurface, StepSettings};

/// The cone of a contact's forces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Cone {
    /// Edges along the tangents: `MuJoCo`'s default.
    #[default]
    Pyramidal,
    /// A circular cone.
    Elliptic,
}

/// What a robot's steps with soft constraints have beside its joints, limits and friction.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SoftConstraints {
    /// The cone of all contacts.
    pub cone: Cone,
    /// The integrator of steps.
    pub integrator: Integrator,
    /// The time step of the description, s; `None` without one.
    #[cfg_attr(feature = "serde", serde(default))]
    pub time_step: Option<f64>,
    /// How many times stiffer friction is than the normal direction, `MuJoCo`'s `impratio`; `None`: 1.
    pub impratio: Option<f64>,
    /// The shapes that touch the ground.
    pub shapes: Vec<TouchingShape>,
    /// The ground that the points of the contacts touch, and the law of these contacts; `None`:
    /// [`ContactSurface::GROUND`].
    pub ground: Option<ContactSurface<f64>>,
    /// The softness of joints whose softness is not `MuJoCo`'s default.
    pub joints: Vec<JointSoftness>,
    /// The softness of loop constraints whose softness is not `MuJoCo`'s default.
    pub loops: Vec<LoopSoftness>,
    /// The tendons with limits, friction, springs or dampers.
    pub tendons: Vec<SoftTendon>,
    /// The couplings that no mimic joint follows.
    pub couplings: Vec<SoftCoupling>,
    /// The joints whose reference coordinates are not neutral. Mobilities are computed at the
    /// reference coordinates.
    pub references: Vec<JointReference>,
    /// Whether joint limits stop joints.
    pub joint_limits: bool,
    /// Whether damping and dry friction of joints act in steps where the other functions of the
    /// robot have none ([`JointFriction::None`](super::JointFriction::None)).
    pub joint_friction: bool,
}

impl Default for SoftConstraints {
    fn default() -> Self {
        Self {
            cone: Cone::default(),
            integrator: Integrator::default(),
            time_step: None,
            impratio: None,
            shapes: Vec::new(),
            ground: None,
            joints: Vec::new(),
            loops: Vec::new(),
            tendons: Vec::new(),
            couplings: Vec::new(),
            references: Vec::new(),
            joint_limits: true,
            joint_friction: false,
        }
    }
}

impl SoftConstraints {
    /// Returns the softness of a loop constraint.
    #[must_use]
    pub fn softness_of_loop(&self, constraint: usize) -> LoopSoftness {
        let mut given = self.loops.iter();
        let softness = given.find(|softness| softness.constraint == constraint);
        softness.copied().unwrap_or_else(|| LoopSoftness::standard(constraint))
    }
}

/// A shape of a link, and the ground that it touches.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TouchingShape {
    /// The name.
    pub name: String,
    /// The frame of the shape, on a link that moves.
    pub end: LoopConstraintEnd,
    /// The shape, about the origin of its frame.
    pub shape: ContactShape<f64>,
    /// The components of the contact's force.
    pub components: ContactComponents,
    /// The ground, and the law of the contact.
    pub surface: ContactSurface<f64>,
    /// The power of the curve of the contact's impedance.
    pub power: u32,
}

/// A shape without its rounding: all points within the radius of the contact's surface from a point
/// of it touch.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactShape<S> {
    /// A point, or a sphere.
    Point,
    /// A segment along the z axis, or a capsule, by half its length, m.
    Segment(S),
    /// A box, by half its lengths, m.
    Cuboid([S; 3]),
    /// A cylinder about the z axis: its radius and half its length, m.
    Cylinder([S; 2]),
    /// An ellipsoid, by its radii, m.
    Ellipsoid([S; 3]),
    /// Points, such as the corners of a convex hull, m.
    Points(Vec<[S; 3]>),
}

/// The components of a contact's force: `MuJoCo`'s `condim`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactComponents {
    /// The force along the normal: no friction.
    Normal,
    /// Also friction.
    #[default]
    Sliding,
    /// Also a moment about the normal.
    Torsional,
    /// Also moments about the tangents.
    Rolling,
}

/// The softness of a joint's limits and dry friction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointSoftness {
    /// The index of the joint.
    pub joint: usize,
    /// The distance from which on a limit acts, rad or m.
    pub margin: f64,
    /// The softness of the limits.
    pub limit: Softness<f64>,
    /// The softness of dry friction.
    pub friction: Softness<f64>,
}

/// The reference coordinate of a joint with one degree of freedom: `MuJoCo`'s `ref`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointReference {
    /// The index of the joint.
    pub joint: usize,
    /// The coordinate, rad or m.
    pub coordinate: f64,
}

/// The softness of a loop constraint in steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoopSoftness {
    /// The index of the loop constraint.
    pub constraint: usize,
    /// The softness.
    pub softness: Softness<f64>,
    /// The factor of the rows of rotations, m: `MuJoCo`'s `torquescale`.
    pub torque_scale: f64,
}

impl LoopSoftness {
    /// Returns `MuJoCo`'s default for a loop constraint.
    #[must_use]
    pub fn standard(constraint: usize) -> Self {
        Self { constraint, softness: Softness::standard(), torque_scale: 1.0 }
    }
}

impl<S: Copy> ContactShape<S> {
    /// Returns the shape with `f` applied to its numbers.
    pub fn map<T>(&self, f: impl Fn(S) -> T + Copy) -> ContactShape<T> {
        match self {
            Self::Point => ContactShape::Point,
            Self::Segment(half) => ContactShape::Segment(f(*half)),
            Self::Cuboid(halves) => ContactShape::Cuboid(halves.map(f)),
            Self::Cylinder(sizes) => ContactShape::Cylinder(sizes.map(f)),
            Self::Ellipsoid(radii) => ContactShape::Ellipsoid(radii.map(f)),
            Self::Points(points) => {
                ContactShape::Points(points.iter().map(|point| point.map(f)).collect())
            }
        }
    }

    /// Returns the numbers of the shape.
    #[must_use]
    pub fn numbers(&self) -> Vec<S> {
        match self {
            Self::Point => Vec::new(),
            Self::Segment(half) => vec![*half],
            Self::Cuboid(numbers) | Self::Ellipsoid(numbers) => numbers.to_vec(),
            Self::Cylinder(sizes) => sizes.to_vec(),
            Self::Points(points) => points.concat(),
        }
    }

    /// Returns the number of points that can touch a plane at the same time.
    #[must_use]
    pub fn points(&self) -> usize {
        match self {
            Self::Point | Self::Ellipsoid(_) => 1,
            Self::Segment(_) => 2,
            Self::Cuboid(_) | Self::Cylinder(_) => 4,
            Self::Points(points) => points.len(),
        }
    }
}

impl ContactComponents {
    /// Returns the components of this number; `None` for numbers that no contact has.
    #[must_use]
    pub fn from_count(count: usize) -> Option<Self> {
        match count {
            1 => Some(Self::Normal),
            3 => Some(Self::Sliding),
            4 => Some(Self::Torsional),
            6 => Some(Self::Rolling),
            _ => None,
        }
    }

    /// Returns the number of components.
    #[must_use]
    pub fn count(self) -> usize {
        match self {
            Self::Normal => 1,
            Self::Sliding => 3,
            Self::Torsional => 4,
            Self::Rolling => 6,
        }
    }
}

impl StepSettings<f64, Vec<ContactSurface<f64>>> {
    /// Returns the numbers of the settings, then the numbers of the surfaces: the argument
    /// `step_settings` of functions of numbers.
    #[must_use]
    pub fn all_numbers(&self) -> Vec<f64> {
        let surfaces = self.surfaces.iter().flat_map(ContactSurface::numbers);
        self.numbers().into_iter().chain(surfaces).collect()
    }
}

impl Model {
    /// Returns what steps with soft constraints have beside joints, limits and friction.
    #[must_use]
    pub fn soft_constraints(&self) -> &SoftConstraints {
        &self.soft_constraints
    }

    /// Returns the time step of the description, s; `None` without one.
    #[must_use]
    pub fn time_step(&self) -> Option<f64> {
        self.soft_constraints.time_step
    }

    /// Returns the settings of a step by the description: the surfaces of the
    /// [`touching_shapes`](Self::touching_shapes).
    #[must_use]
    pub fn step_settings(&self) -> StepSettings<f64, Vec<ContactSurface<f64>>> {
        let StepSettings { tolerance, impratio, coulomb, .. } = StepSettings::<f64>::DEFAULT;
        let shapes = self.touching_shapes().into_iter();
        StepSettings {
            tolerance,
            impratio: self.soft_constraints.impratio.unwrap_or(impratio),
            coulomb,
            surfaces: shapes.map(|shape| shape.surface).collect(),
        }
    }

    /// Returns the shapes that touch the ground in a step: the points of the contacts if there are
    /// contacts, else the shapes of the description.
    #[must_use]
    pub fn touching_shapes(&self) -> Vec<TouchingShape> {
        if self.contacts.is_empty() {
            return self.soft_constraints.shapes.clone();
        }
        let surface = self.soft_constraints.ground.unwrap_or_default();
        let points = self.contacts.iter().map(|contact| TouchingShape {
            name: contact.name.clone(),
            end: contact.end.clone(),
            shape: ContactShape::Point,
            components: ContactComponents::Sliding,
            surface,
            power: 2,
        });
        points.collect()
    }
}
