//! The inertia of solids of uniform density.

use core::f64::consts::PI;

use modyn_runtime::model::Inertial;

use crate::description::MAX_NUMBER;

/// Returns the inertia of a solid of SDF in its geometry's frame. The sizes are the edges of a box,
/// the radii of an ellipsoid or a sphere, or the radius, the radius and the length along z. Returns
/// `None` if the mass is not a positive number.
pub fn solid(shape: &str, [x, y, z]: [f64; 3], density: f64) -> Option<Inertial> {
    let mut center = 0.0;
    // The volume, and the second moments about the centre of mass divided by the volume: the means
    // of x^2, y^2, z^2.
    let (volume, squares) = match shape {
        "box" => (x * y * z, [x * x / 12.0, y * y / 12.0, z * z / 12.0]),
        "cylinder" => (PI * x * x * z, [x * x / 4.0, x * x / 4.0, z * z / 12.0]),
        "capsule" => capsule(x, z),
        // The tip is at z = length / 2, the centre of mass a quarter of the length above the base.
        "cone" => {
            center = -0.25 * z;
            (PI * x * x * z / 3.0, [x * x * 3.0 / 20.0, x * x * 3.0 / 20.0, z * z * 3.0 / 80.0])
        }
        _ => (4.0 / 3.0 * PI * x * y * z, [x * x / 5.0, y * y / 5.0, z * z / 5.0]),
    };
    let mass = density * volume;
    let fits = [x, y, z, density, mass].iter().all(|&number| number > 0.0 && number < MAX_NUMBER);
    let [xx, yy, zz] = squares.map(|square| mass * square);
    let inertia = [yy + zz, 0.0, 0.0, xx + zz, 0.0, xx + yy];
    fits.then_some(Inertial { mass, center_of_mass: [0.0, 0.0, center], inertia })
}

/// Returns volume and moments of a cylinder of this radius and length with a hemisphere on each
/// end.
fn capsule(radius: f64, length: f64) -> (f64, [f64; 3]) {
    let square = radius * radius;
    let half = 0.5 * length;
    let cylinder = PI * square * length;
    let ball = 4.0 / 3.0 * PI * square * radius;
    let volume = cylinder + ball;
    let across = (cylinder * square / 4.0 + ball * square / 5.0) / volume;
    // A hemisphere's centre of mass is 3/8 of the radius from its base.
    let caps = half * half + 0.75 * half * radius + square / 5.0;
    let along = (cylinder * half * half / 3.0 + ball * caps) / volume;
    (volume, [across, across, along])
}
