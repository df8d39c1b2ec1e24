//! The inertia of geoms as in `MuJoCo`, each a solid or a shell of uniform density, and their
//! shapes.

use core::f64::consts::PI;

use modyn_runtime::model::{ContactShape, Inertial};
use modyn_runtime::spatial::Pose;

use super::check::numbers;
use super::item::Item;
use super::mesh::{MassProperties, Meshes, Principal};
use super::models::Model;
use super::pose::to_z_axis;
use crate::description::{Geometry, Shape, normalized};
use crate::diagnostics::Report;
use crate::read::collision::Touching;

/// The default density, the density of water, kg/m^3.
const DENSITY: f64 = 1000.0;

/// Returns whether a geom has a mass.
pub fn has_mass(geom: &Item, model: &Model) -> bool {
    let [low, high] = model.settings.inertia_groups;
    let group = geom.number("group").unwrap_or(0.0);
    let weightless = geom.number("mass").or_else(|| geom.number("density")) == Some(0.0);
    !weightless && geom.text("type") != Some("plane") && (low..=high).contains(&group)
}

/// Volume or area, and the moments of inertia about the axes of the centre, divided by the mass.
struct Moments {
    measure: f64,
    moments: [f64; 3],
}

/// Returns a geom's inertia in its body's frame.
///
/// # Errors
///
/// Returns the reason why it is not computed.
pub fn inertial<'e>(
    geom: &Item<'e>,
    model: &Model<'e>,
    meshes: &mut Meshes<'e>,
    report: &mut Report<'_>,
) -> Result<Inertial, String> {
    let kind = geom.text("type").unwrap_or("sphere");
    let density = geom.number("density").unwrap_or(DENSITY);
    let mass = |measure: f64| geom.number("mass").unwrap_or(density * measure);
    let is_shell = geom.text("shellinertia") == Some("true");
    if kind == "sdf" {
        return Err("the mass of a signed distance field is not computed".into());
    }
    let mesh = match geom.text("mesh") {
        Some(name) => Some(meshes.get(name, geom.model, model, report)?),
        None if kind == "mesh" => return Err("a geom of type `mesh` has no `mesh`".into()),
        None => None,
    };
    if let Some(mesh) = &mesh
        && kind == "mesh"
    {
        let mass = mass(mesh.measure);
        let inertia = mesh.inertia.map(|moment| moment * mass / mesh.measure);
        let inertial = Inertial { mass, center_of_mass: [0.0; 3], inertia };
        let center = Pose { translation: mesh.center_of_mass, ..Pose::identity() };
        let place = geom.pose(&model.settings, report);
        return Ok(inertial.transformed(&place.compose(&center)));
    }
    let (place, size) = placed(geom, model, mesh.as_deref(), report)?;
    let shape = if is_shell { shell(kind, size) } else { solid(kind, size) };
    if !(shape.measure > 0.0 && shape.measure.is_finite()) {
        return Err("a geom has no volume: its `size` must be above 0".into());
    }
    let mass = mass(shape.measure);
    let [xx, yy, zz] = shape.moments.map(|moment| mass * moment);
    let inertia = [xx, 0.0, 0.0, yy, 0.0, zz];
    Ok(Inertial { mass, center_of_mass: [0.0; 3], inertia }.transformed(&place))
}

/// Returns the pose in its body of a geom that is no mesh itself, and its half lengths and radii in
/// the order of `size`. A solid may be fitted to a mesh.
fn placed(
    geom: &Item,
    model: &Model,
    mesh: Option<&MassProperties>,
    report: &mut Report<'_>,
) -> Result<(Pose<f64>, [f64; 3]), String> {
    let kind = geom.text("type").unwrap_or("sphere");
    let mut place = geom.pose(&model.settings, report);
    let size = if let Some(mesh) = mesh {
        let principal = mesh.principal();
        let scale = geom.number("fitscale").unwrap_or(1.0);
        let (center, size) =
            fitted(kind, &principal, model.settings.fit_box.then(|| mesh.bounds(&principal)));
        let on_mesh = Pose { rotation: principal.axes, translation: mesh.center_of_mass };
        place = place.compose(&on_mesh).compose(&Pose { translation: center, ..Pose::identity() });
        size.map(|size| scale * size)
    } else if let Some(ends) = geom.numbers("fromto") {
        let (between, half) = between(ends).ok_or("the ends of a geom's `fromto` coincide")?;
        place = geom.frame.compose(&between);
        let radius = sizes(geom)[0];
        if kind == "cylinder" || kind == "capsule" {
            [radius, half, 0.0]
        } else {
            [radius, radius, half]
        }
    } else if kind == "hfield" {
        // The mass of a height field is the mass of the box with its half lengths and its mean
        // height, about the geom's origin.
        let field = geom.text("hfield").and_then(|name| model.asset("hfield", name));
        let size = field.and_then(|field| field.text("size")).and_then(super::check::numbers);
        let [x, y, top, bottom] = size.ok_or("the height field of a geom is not in the file")?;
        [x, y, 0.25 * top + 0.5 * bottom]
    } else {
        sizes(geom)
    };
    Ok((place, size))
}

/// The colour of a geom without one.
const GRAY: [f64; 4] = [0.5, 0.5, 0.5, 1.0];

/// The number of groups that `MuJoCo` shows; collision shapes are often in higher ones.
const SHOWN_GROUPS: f64 = 3.0;

/// Returns a geom as a shape in its body's frame; `None` if it is not shown.
///
/// # Errors
///
/// Returns the reason why it cannot be drawn.
pub fn shape<'e>(
    geom: &Item<'e>,
    model: &Model<'e>,
    meshes: &mut Meshes<'e>,
    report: &mut Report<'_>,
) -> Result<Option<Shape>, String> {
    let kind = geom.text("type").unwrap_or("sphere");
    let color = geom.numbers("rgba").or_else(|| {
        let material = model.asset("material", geom.text("material")?)?;
        let chain = model.classes.chain(material, None);
        chain.iter().find_map(|element| element.text("rgba")).and_then(numbers)
    });
    let is_hidden = geom.number("group").unwrap_or(0.0) >= SHOWN_GROUPS;
    let is_clear = color.is_some_and(|[.., opacity]: [f64; 4]| opacity == 0.0);
    if is_hidden || is_clear || matches!(kind, "plane" | "hfield" | "sdf") {
        return Ok(None);
    }
    let color = Some(color.unwrap_or(GRAY));
    if kind == "mesh" {
        let name = geom.text("mesh").ok_or("a geom of type `mesh` has no `mesh`")?;
        let geometry = Geometry::Mesh(meshes.picture(name, geom.model, model, report)?);
        return Ok(Some(Shape { pose: geom.pose(&model.settings, report), geometry, color }));
    }
    let mesh = match geom.text("mesh") {
        Some(name) => Some(meshes.get(name, geom.model, model, report)?),
        None => None,
    };
    let (pose, [x, y, z]) = placed(geom, model, mesh.as_deref(), report)?;
    let geometry = match kind {
        "sphere" => Geometry::Sphere { radius: x },
        "capsule" => Geometry::Capsule { radius: x, length: 2.0 * y },
        "cylinder" => Geometry::Cylinder { radius: x, length: 2.0 * y },
        "ellipsoid" => Geometry::Ellipsoid { radii: [x, y, z] },
        _ => Geometry::Box { size: [2.0 * x, 2.0 * y, 2.0 * z] },
    };
    if !geometry.is_sound() {
        return Err("its `size` must be above 0".into());
    }
    Ok(Some(Shape { pose, geometry, color }))
}

/// Returns the pose of a geom in its body, and its shape for contacts.
///
/// # Errors
///
/// Returns the reason why its contacts are not computed.
pub fn touching<'e>(
    geom: &Item<'e>,
    model: &Model<'e>,
    meshes: &mut Meshes<'e>,
    report: &mut Report<'_>,
) -> Result<(Pose<f64>, Touching), String> {
    let kind = geom.text("type").unwrap_or("sphere");
    if kind == "sdf" {
        return Err("contacts of signed distance fields are not computed".into());
    }
    if kind == "mesh" {
        let name = geom.text("mesh").ok_or("a geom of type `mesh` has no `mesh`")?;
        let points = meshes.corners(name, geom.model, model, report)?;
        let shape = ContactShape::Points(points.to_vec());
        return Ok((geom.pose(&model.settings, report), Touching { shape, radius: 0.0 }));
    }
    let mesh = match geom.text("mesh") {
        Some(name) => Some(meshes.get(name, geom.model, model, report)?),
        None => None,
    };
    let (pose, [x, y, z]) = placed(geom, model, mesh.as_deref(), report)?;
    let (shape, radius) = match kind {
        "sphere" => (ContactShape::Point, x),
        "capsule" => (ContactShape::Segment(y), x),
        "cylinder" => (ContactShape::Cylinder([x, y]), 0.0),
        "ellipsoid" => (ContactShape::Ellipsoid([x, y, z]), 0.0),
        _ => (ContactShape::Cuboid([x, y, z]), 0.0),
    };
    let is_sound = shape.numbers().iter().all(|size| *size > 0.0) && radius >= 0.0;
    if !is_sound {
        return Err("its `size` must be above 0".into());
    }
    Ok((pose, Touching { shape, radius }))
}

/// Returns the numbers of `size`, with zeros for missing ones.
fn sizes(geom: &Item) -> [f64; 3] {
    let sizes = geom.text("size").and_then(super::check::list).unwrap_or_default();
    let size = |i| sizes.get(i).copied().unwrap_or(0.0);
    [size(0), size(1), size(2)]
}

/// Returns the pose between two points, with the z axis along their line, and half their distance;
/// `None` if they coincide.
pub fn between([x1, y1, z1, x2, y2, z2]: [f64; 6]) -> Option<(Pose<f64>, f64)> {
    let (axis, length) = normalized([x1 - x2, y1 - y2, z1 - z2])?;
    let translation = [(x1 + x2) / 2.0, (y1 + y2) / 2.0, (z1 + z2) / 2.0];
    Some((Pose { rotation: to_z_axis(axis), translation }, length / 2.0))
}

/// Returns the centre, in the principal frame of a mesh, and the sizes of a shape that is fitted to
/// the mesh: to its bounding box (the lowest and the highest corner), or else to the box with the
/// mesh's inertia.
fn fitted(kind: &str, mesh: &Principal, bounds: Option<[[f64; 3]; 2]>) -> ([f64; 3], [f64; 3]) {
    let Some([low, high]) = bounds else {
        let [x, y, z] = mesh.half_lengths;
        let radius = (x + y) / 2.0;
        let size = match kind {
            "sphere" => [(x + y + z) / 3.0, 0.0, 0.0],
            "capsule" => [radius, (z - radius / 2.0).max(0.0), 0.0],
            "cylinder" => [radius, z, 0.0],
            _ => [x, y, z],
        };
        return ([0.0; 3], size);
    };
    let center = core::array::from_fn(|i| (low[i] + high[i]) / 2.0);
    let [x, y, z]: [f64; 3] = core::array::from_fn(|i| (high[i] - low[i]) / 2.0);
    let size = match kind {
        "sphere" => [x.max(y).max(z), 0.0, 0.0],
        "capsule" => [x.max(y), z - x.max(y), 0.0],
        "cylinder" => [x.max(y), z, 0.0],
        _ => [x, y, z],
    };
    (center, size)
}

/// Returns volume and moments of a solid.
fn solid(kind: &str, [x, y, z]: [f64; 3]) -> Moments {
    // The integrals of the squared coordinates, divided by the volume.
    let (measure, squares) = match kind {
        "sphere" => (4.0 / 3.0 * PI * x * x * x, [x * x / 5.0; 3]),
        "ellipsoid" => (4.0 / 3.0 * PI * x * y * z, [x * x / 5.0, y * y / 5.0, z * z / 5.0]),
        "cylinder" => (2.0 * PI * x * x * y, [x * x / 4.0, x * x / 4.0, y * y / 3.0]),
        "capsule" => capsule(x, y),
        // A box or a height field.
        _ => (8.0 * x * y * z, [x * x / 3.0, y * y / 3.0, z * z / 3.0]),
    };
    uniform(measure, squares)
}

fn uniform(measure: f64, [xx, yy, zz]: [f64; 3]) -> Moments {
    Moments { measure, moments: [yy + zz, xx + zz, xx + yy] }
}

/// Returns volume and squares of a cylinder of this radius and half length with a hemisphere on
/// each end.
fn capsule(radius: f64, half: f64) -> (f64, [f64; 3]) {
    let square = radius * radius;
    let cylinder = 2.0 * PI * square * half;
    let ball = 4.0 / 3.0 * PI * square * radius;
    let volume = cylinder + ball;
    let across = (cylinder * square / 4.0 + ball * square / 5.0) / volume;
    // A hemisphere's centre of mass is 3/8 of the radius from its base.
    let caps = half * half + 0.75 * half * radius + square / 5.0;
    let along = (cylinder * half * half / 3.0 + ball * caps) / volume;
    (volume, [across, across, along])
}

/// Returns area and moments of a shell.
fn shell(kind: &str, [x, y, z]: [f64; 3]) -> Moments {
    match kind {
        "sphere" => uniform(4.0 * PI * x * x, [x * x / 3.0; 3]),
        "cylinder" => {
            let side = 4.0 * PI * x * y;
            let disks = 2.0 * PI * x * x;
            let area = side + disks;
            let across = (side * x * x / 2.0 + disks * x * x / 4.0) / area;
            uniform(area, [across, across, (side * y * y / 3.0 + disks * y * y) / area])
        }
        "capsule" => {
            let side = 4.0 * PI * x * y;
            let caps = 4.0 * PI * x * x;
            let area = side + caps;
            let across = (side * x * x / 2.0 + caps * x * x / 3.0) / area;
            // A hemisphere's centre of mass is half of the radius from its base.
            let along = (side * y * y / 3.0 + caps * (y * y + x * y + x * x / 3.0)) / area;
            uniform(area, [across, across, along])
        }
        "ellipsoid" => {
            // The area by Thomsen's formula, and the moments of the space between two solids, both
            // as in MuJoCo.
            const P: f64 = 1.6075;
            const THICKNESS: f64 = 1e-6;
            let power = |product: f64| libm::pow(product, P);
            let mean = (power(x * y) + power(y * z) + power(z * x)) / 3.0;
            let area = 4.0 * PI * libm::pow(mean, 1.0 / P);
            let [a, b, c] = [x, y, z].map(|half| half + THICKNESS);
            let inner = x * y * z;
            let outer = a * b * c;
            let square = |inside: f64, outside: f64| {
                (outer * outside * outside - inner * inside * inside) / (5.0 * (outer - inner))
            };
            uniform(area, [square(x, a), square(y, b), square(z, c)])
        }
        _ => {
            let [xy, yz, zx] = [x * y, y * z, z * x];
            let sum = xy + yz + zx;
            // Each side has a constant coordinate, or one that is uniform.
            let square =
                |half: f64, across: f64| half * half * (across + (sum - across) / 3.0) / sum;
            uniform(8.0 * sum, [square(x, yz), square(y, zx), square(z, xy)])
        }
    }
}
