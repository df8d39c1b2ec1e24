//! The inertia of a body without `<inertial>`, from its geoms as in `MuJoCo`: each is a solid of uniform density.

use core::f64::consts::PI;

use mjcf_rs::assets::Assets;
use mjcf_rs::body::{Geom, GeomType};
use modyn_runtime::model::Inertial;
use modyn_runtime::spatial::Pose;

use super::pose::pose;
use crate::description::normalized;

/// The default density, that of water, kg/m^3.
const DENSITY: f64 = 1000.0;

/// Returns the inertia of all geoms together, in the body's frame.
///
/// # Errors
///
/// Returns the reason why a geom's inertia is not computed.
pub fn inertial(geoms: &[Geom], assets: &Assets) -> Result<Inertial, &'static str> {
    let mut whole = Inertial::default();
    for geom in geoms.iter().filter(|geom| has_mass(geom)) {
        whole = whole.merged(&solid(geom, assets)?);
    }
    Ok(whole)
}

/// Returns whether a geom has a mass.
pub fn has_mass(geom: &Geom) -> bool {
    let weightless = geom.mass.or(geom.density) == Some(0.0);
    !weightless && geom.type_ != GeomType::Plane
}

/// Returns a geom's inertia in its body's frame.
fn solid(geom: &Geom, assets: &Assets) -> Result<Inertial, &'static str> {
    if geom.mesh.is_some() {
        return Err("the mass of a mesh is not computed");
    }
    let (place, [x, y, z]) = pose_and_size(geom)?;
    // The volume, and the second moments divided by the volume: the integrals of x^2, y^2 and z^2.
    let (volume, squares) = match geom.type_ {
        GeomType::Sphere => (4.0 / 3.0 * PI * x * x * x, [x * x / 5.0; 3]),
        GeomType::Ellipsoid => {
            (4.0 / 3.0 * PI * x * y * z, [x * x / 5.0, y * y / 5.0, z * z / 5.0])
        }
        GeomType::Box => (8.0 * x * y * z, [x * x / 3.0, y * y / 3.0, z * z / 3.0]),
        GeomType::Cylinder => (2.0 * PI * x * x * z, [x * x / 4.0, x * x / 4.0, z * z / 3.0]),
        GeomType::Capsule => capsule(x, z),
        // The mass of a height field is that of the box with its half lengths and its mean height, about the geom's origin.
        GeomType::Hfield => {
            let field = geom.hfield.as_deref().and_then(|name| assets.hfield(name));
            let [x, y, top, bottom] =
                field.ok_or("the height field of a geom is not in the file")?.size;
            let z = 0.25 * top + 0.5 * bottom;
            (8.0 * x * y * z, [x * x / 3.0, y * y / 3.0, z * z / 3.0])
        }
        _ => return Err("the mass of a mesh is not computed"),
    };
    if !(volume > 0.0 && volume.is_finite()) {
        return Err("a geom has no volume: its `size` must be above 0");
    }
    let mass = geom.mass.unwrap_or_else(|| geom.density.unwrap_or(DENSITY) * volume);
    let [xx, yy, zz] = squares.map(|square| mass * square);
    let inertia = [yy + zz, 0.0, 0.0, xx + zz, 0.0, xx + yy];
    Ok(Inertial { mass, center_of_mass: [0.0; 3], inertia }.transformed(&place))
}

/// Returns volume and moments of a cylinder of this radius and half length with a hemisphere on each end.
fn capsule(radius: f64, half: f64) -> (f64, [f64; 3]) {
    let square = radius * radius;
    let (cylinder, ball) = (2.0 * PI * square * half, 4.0 / 3.0 * PI * square * radius);
    let volume = cylinder + ball;
    let across = (cylinder * square / 4.0 + ball * square / 5.0) / volume;
    // A hemisphere's centre of mass is 3/8 of the radius from its base.
    let caps = half * half + 0.75 * half * radius + square / 5.0;
    let along = (cylinder * half * half / 3.0 + ball * caps) / volume;
    (volume, [across, across, along])
}

/// Returns the pose and the sizes of a geom. The z axis of a geom between two points is along their line.
fn pose_and_size(geom: &Geom) -> Result<(Pose<f64>, [f64; 3]), &'static str> {
    let Some([x1, y1, z1, x2, y2, z2]) = geom.fromto else {
        let [x, y, z] = geom.size;
        // Radius and half length.
        let round = matches!(geom.type_, GeomType::Cylinder | GeomType::Capsule);
        return Ok((pose(&geom.pose), if round { [x, x, y] } else { [x, y, z] }));
    };
    let along = [x2 - x1, y2 - y1, z2 - z1];
    let (axis, length) = normalized(along).ok_or("the ends of a geom's `fromto` coincide")?;
    let radius = geom.size[0];
    let translation = [(x1 + x2) / 2.0, (y1 + y2) / 2.0, (z1 + z2) / 2.0];
    // The geom is symmetric about its z axis, so any x axis will do.
    let rotation = rotation_with_z(axis);
    Ok((Pose { rotation, translation }, [radius, radius, length / 2.0]))
}

/// Returns a rotation with this z axis.
fn rotation_with_z([x, y, z]: [f64; 3]) -> [[f64; 3]; 3] {
    // Without a singularity: Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
    let sign = 1.0_f64.copysign(z);
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    [[1.0 + sign * x * x * a, b, x], [sign * b, sign + y * y * a, y], [-sign * x, -y, z]]
}
