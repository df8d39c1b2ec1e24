//! The shapes that touch the ground, as the formats have them.

use modyn_runtime::ContactSurface;
use modyn_runtime::model::{ContactShape, Model, TouchingShape};
use modyn_runtime::spatial::Pose;

use super::xml::{Element, number};
use crate::diagnostics::listed;

/// Returns the shapes of the description without the shapes that touch a further plane.
pub fn solids(model: &Model) -> Vec<&TouchingShape> {
    let mut solids: Vec<&TouchingShape> = Vec::new();
    for shape in &model.soft_constraints().shapes {
        let is_same = |solid: &&TouchingShape| {
            solid.end == shape.end
                && solid.shape == shape.shape
                && solid.surface.radius == shape.surface.radius
                && solid.surface.plane != shape.surface.plane
        };
        if !solids.iter().any(is_same) {
            solids.push(shape);
        }
    }
    solids
}

/// Returns the planes that the shapes touch, without repetition.
pub fn planes(model: &Model) -> Vec<Pose<f64>> {
    let mut planes = Vec::new();
    for shape in &model.soft_constraints().shapes {
        if !planes.contains(&shape.surface.plane) {
            planes.push(shape.surface.plane);
        }
    }
    planes
}

/// Returns the `<geometry>` of a URDF; `None` if URDF has no words for the shape.
pub fn urdf_geometry(shape: &TouchingShape) -> Option<Element> {
    let radius = shape.surface.radius;
    let solid = match &shape.shape {
        ContactShape::Point if radius > 0.0 => Element::new("sphere").numbers("radius", &[radius]),
        ContactShape::Segment(half) if radius > 0.0 => {
            Element::new("capsule").numbers("radius", &[radius]).numbers("length", &[2.0 * half])
        }
        ContactShape::Cuboid(halves) if radius == 0.0 => {
            Element::new("box").numbers("size", &halves.map(|half| 2.0 * half))
        }
        ContactShape::Cylinder([radius_of_edge, half]) if radius == 0.0 => Element::new("cylinder")
            .numbers("radius", &[*radius_of_edge])
            .numbers("length", &[2.0 * half]),
        ContactShape::Ellipsoid(radii) if radius == 0.0 => {
            Element::new("ellipsoid").numbers("radii", radii)
        }
        _ => return None,
    };
    Some(Element::new("geometry").child(solid))
}

/// A geom of an MJCF, and the mesh that it names.
pub struct WrittenGeom {
    pub geom: Element,
    pub mesh: Option<Element>,
}

/// Returns the geom of a shape without its place; `None` if MJCF has no words for the shape. `plane`
/// is the index of the plane that it touches.
pub fn geom(shape: &TouchingShape, plane: usize) -> Option<WrittenGeom> {
    let ContactSurface { radius, friction, torsional_friction, rolling_friction, .. } =
        shape.surface;
    let ContactSurface { margin, solref, solimp, .. } = shape.surface;
    let name = &*shape.name;
    let mut mesh = None;
    let sized = |kind: &str, sizes: &[f64]| {
        Element::new("geom").with("name", name).with("type", kind).numbers("size", sizes)
    };
    let solid = match &shape.shape {
        ContactShape::Point => sized("sphere", &[radius]),
        ContactShape::Segment(half) if radius > 0.0 => sized("capsule", &[radius, *half]),
        _ if radius > 0.0 => return None,
        ContactShape::Segment(_) => return None,
        ContactShape::Cuboid(halves) => sized("box", halves),
        ContactShape::Cylinder(sizes) => sized("cylinder", sizes),
        ContactShape::Ellipsoid(radii) => sized("ellipsoid", radii),
        ContactShape::Points(points) => {
            let vertices = points.as_flattened();
            mesh = Some(Element::new("mesh").with("name", name).numbers("vertex", vertices));
            Element::new("geom").with("name", name).with("type", "mesh").with("mesh", name)
        }
    };
    let [least, most, width, midpoint] = solimp;
    // The plane has another priority, so that the numbers of the shape count.
    let geom = solid
        .with("mass", "0")
        .with("priority", "1")
        .with("contype", (1_u32 << plane).to_string())
        .with("conaffinity", "0")
        .with("condim", shape.components.count().to_string())
        .numbers("friction", &[friction, torsional_friction, rolling_friction])
        .numbers("solref", &solref)
        .numbers("solimp", &[least, most, width, midpoint, f64::from(shape.power)]);
    let with_margin = if margin == 0.0 { geom } else { geom.numbers("margin", &[margin]) };
    Some(WrittenGeom { geom: with_margin, mesh })
}

/// Returns notes about shapes without words in the format, and about the ground, which a URDF has no
/// words for.
pub fn notes(model: &Model, left_out: &[&TouchingShape], is_urdf: bool) -> Vec<String> {
    let mut notes = Vec::new();
    if !left_out.is_empty() {
        let names = left_out.iter().map(|shape| &*shape.name);
        notes.push(format!("Left out: {}.", listed("shape", names)));
    }
    let planes = match (is_urdf, model.soft_constraints().ground) {
        (_, Some(surface)) if !model.contacts().is_empty() => vec![surface.plane],
        (true, _) if model.contacts().is_empty() => planes(model),
        _ => Vec::new(),
    };
    if let Some(plane) = planes.first() {
        let list = |vector: [f64; 3]| vector.map(number).join(", ");
        let normal = plane.rotation.map(|row| row[2]);
        let [point, normal] = [plane.translation, normal].map(list);
        notes.push(format!(
            "The format has no ground: read the robot with the option `ground = plane([{point}], [{normal}])`."
        ));
    }
    if planes.len() > 1 {
        notes.push(format!("Left out: {} more planes of the ground.", planes.len() - 1));
    }
    notes
}
