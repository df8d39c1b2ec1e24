//! The `<collision>`s of links in URDF and SDF, whose shapes touch the ground in steps.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use modyn_runtime::ContactSurface;
use modyn_runtime::model::{
    ContactComponents, ContactShape, LoopConstraintEnd, SoftConstraints, TouchingShape,
};
use modyn_runtime::spatial::Pose;
use rustc_hash::FxHashMap;

use super::mesh::hull;
use super::visual::solid;
use crate::description::{Base, Description, Geometry, Kind, Mesh, TakenNames};
use crate::diagnostics::{Code, Place, Report, Subject};

/// The largest number of shapes that touch the ground.
pub const MAX_SHAPES: usize = 1_000;

/// The power of the curve of a contact's impedance, as `MuJoCo`'s default.
const POWER: u32 = 2;

/// The largest coefficient of friction. The larger a coefficient is, the softer are the contacts of
/// `MuJoCo`'s pyramids: at 2 a box at rest sinks by 0.6 mm, at 4 by 7 mm, and at 10 by 0.2 m.
const MAX_FRICTION: f64 = 2.0;

/// A shape for contacts, and the radius of its rounding.
pub struct Touching {
    pub shape: ContactShape<f64>,
    pub radius: f64,
}

/// A `<collision>` of a link.
pub struct Collision {
    /// The name; `None` if it has none.
    pub name: Option<String>,
    pub at: usize,
    /// The pose in the link's frame.
    pub pose: Pose<f64>,
    /// The geometry, or why it does not touch the ground.
    pub geometry: Result<Geometry, String>,
}

/// The shapes of links that touch the ground.
#[derive(Default)]
pub struct Collisions {
    shapes: Vec<TouchingShape>,
    names: TakenNames,
    /// The corners of the hulls of meshes, by the address of the mesh.
    corners: HashMap<*const Mesh, Corners>,
    /// The meshes of these addresses.
    meshes: Vec<std::sync::Arc<Mesh>>,
    /// The collisions that do not touch the ground, by the reason.
    untouched: BTreeMap<String, Vec<Place>>,
    /// The collisions whose friction is above [`MAX_FRICTION`].
    rough: Vec<Place>,
}

/// The corners of a hull, or the fault of the mesh, as the end of a sentence about it.
type Corners = Result<Rc<[[f64; 3]]>, &'static str>;

impl Collisions {
    /// Adds the shape of a collision of the link with this index and name, once for each surface
    /// that it touches.
    pub fn add(
        &mut self,
        frame: usize,
        link: &str,
        collision: Collision,
        surfaces: &[ContactSurface<f64>],
    ) {
        let Collision { name, at, pose, geometry } = collision;
        let place: Place = (Some(at), Some(Subject::Link(link.into())));
        let Touching { shape, radius } = match geometry.and_then(|solid| self.touching(solid)) {
            Ok(touching) => touching,
            Err(why) => {
                self.untouched.entry(why).or_default().push(place);
                return;
            }
        };
        if surfaces.iter().any(|surface| surface.friction > MAX_FRICTION) {
            self.rough.push(place);
        }
        for surface in surfaces {
            let friction = surface.friction.min(MAX_FRICTION);
            let name = match &name {
                Some(name) => self.names.unique(name, "shape"),
                None => self.names.numbered(&format!("{link}_collision"), 1),
            };
            self.shapes.push(TouchingShape {
                name,
                end: LoopConstraintEnd { link: frame, pose },
                shape: shape.clone(),
                components: ContactComponents::Sliding,
                surface: ContactSurface { radius, friction, ..*surface },
                power: POWER,
            });
        }
    }

    /// Returns whether there are more shapes than may touch the ground.
    pub fn are_too_many(&self) -> bool {
        self.shapes.len() > MAX_SHAPES
    }

    /// Returns what steps of a robot have by these shapes. Warns, once for each reason, of
    /// collisions that do not touch the ground.
    pub fn soft_constraints(self, report: &mut Report<'_>) -> SoftConstraints {
        for (why, places) in &self.untouched {
            let message = format!("a `<collision>` does not touch the ground in `step`: {why}");
            let help = "give the link a collision of another shape, or name `contacts`";
            report.warn_once(Code::NotRead, places, &message, help);
        }
        let message =
            format!("a coefficient of friction above {MAX_FRICTION} is {MAX_FRICTION} in `step`");
        let help = "write the measured coefficient: a larger one makes contacts soft, by the pyramids of MuJoCo's law";
        report.warn_once(Code::NotRead, &self.rough, &message, help);
        if self.are_too_many() {
            let message = format!("more than {MAX_SHAPES} shapes touch the ground");
            let help = "remove the `<collision>`s that never touch it, or name `contacts`";
            report.error(Code::Excessive, None, None, message, help);
        }
        SoftConstraints { shapes: self.shapes, ..SoftConstraints::default() }
    }

    /// Returns the shape of a geometry, or why its contacts are not computed.
    fn touching(&mut self, geometry: Geometry) -> Result<Touching, String> {
        let sharp = |shape| Touching { shape, radius: 0.0 };
        Ok(match geometry {
            Geometry::Box { size } => sharp(ContactShape::Cuboid(size.map(|edge| 0.5 * edge))),
            Geometry::Ellipsoid { radii } => sharp(ContactShape::Ellipsoid(radii)),
            Geometry::Cylinder { radius, length } => {
                sharp(ContactShape::Cylinder([radius, 0.5 * length]))
            }
            Geometry::Sphere { radius } => Touching { shape: ContactShape::Point, radius },
            Geometry::Capsule { radius, length } if length > 0.0 => {
                Touching { shape: ContactShape::Segment(0.5 * length), radius }
            }
            Geometry::Capsule { radius, .. } => Touching { shape: ContactShape::Point, radius },
            Geometry::Mesh(mesh) => {
                let known =
                    self.corners.entry(std::sync::Arc::as_ptr(&mesh)).or_insert_with(|| {
                        let corners = hull::corners(&mesh.vertices);
                        self.meshes.push(mesh);
                        corners.map(Rc::from)
                    });
                let corners = known.clone().map_err(|why| format!("its mesh {why}"))?;
                sharp(ContactShape::Points(corners.to_vec()))
            }
        })
    }
}

/// The elements of geometries that are solids in URDF and SDF.
const SOLIDS: &[&str] = &["box", "sphere", "ellipsoid", "cylinder", "capsule"];

/// Returns the solid of an element of this name, as [`solid`]; `None` with an error in the report if
/// its lengths are not positive numbers.
///
/// # Errors
///
/// Returns why an element of this name does not touch the ground.
pub fn touching_solid<'t>(
    element: &str,
    text: impl Fn(&str) -> Option<&'t str>,
    place: Place,
    report: &mut Report<'_>,
) -> Result<Option<Geometry>, String> {
    let geometry = solid(element, text);
    if geometry.is_none() && !SOLIDS.contains(&element) {
        return Err(format!("contacts of a `<{element}>` are not computed"));
    }
    if geometry.is_none() {
        let (at, subject) = place;
        let message = format!("the lengths of the `<{element}>` are not numbers above 0");
        let help = "write the lengths of the shape in m";
        report.error(Code::NotFinite, at, subject.as_ref(), message, help);
    }
    Ok(geometry)
}

/// Returns the index of each link of a description by its name; of the first link with a name.
pub fn link_indices(description: &Description) -> FxHashMap<&str, usize> {
    let mut indices = FxHashMap::default();
    for (link, name) in description.link_names().enumerate() {
        indices.entry(name).or_insert(link);
    }
    indices
}

/// Returns for each link of a description whether it moves in the world.
pub fn moving_links(description: &Description, base: Base) -> Vec<bool> {
    let indices = link_indices(description);
    let count = description.links.len();
    let mut children = vec![Vec::new(); count];
    let mut is_root = vec![true; count];
    for joint in &description.joints {
        let ends = [&joint.parent, &joint.child];
        let links = ends.map(|link| link.as_ref().and_then(|link| indices.get(&*link.text)));
        if let [Some(&parent), Some(&child)] = links {
            children[parent].push((child, joint.kind != Kind::Fixed));
            is_root[child] = false;
        }
    }
    let mut moves = vec![base == Base::Floating; count];
    let mut open: Vec<usize> = (0..count).filter(|&link| is_root[link]).collect();
    while let Some(link) = open.pop() {
        // A link with several parents is an error of the tree.
        for (child, is_free) in std::mem::take(&mut children[link]) {
            moves[child] = moves[link] || is_free;
            open.push(child);
        }
    }
    moves
}
