//! The points of shapes that can touch a plane, as in MuJoCo's contacts of shapes with planes.

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::model::ContactShape;
use crate::spatial::Vector3;

/// Returns the points of a shape that can touch a plane with this normal, in the shape's frame.
pub(super) fn points<S: Scalar>(shape: &ContactShape<S>, normal: Vector3<S>) -> Vec<Vector3<S>> {
    let zero = S::zero();
    match shape {
        ContactShape::Point => vec![Vector3::zero()],
        ContactShape::Segment(half) => [*half, -*half].map(|z| Vector3([zero, zero, z])).to_vec(),
        ContactShape::Cuboid([x, y, z]) => {
            // The lower one of each two opposite corners.
            let corners = [[*x, *y, *z], [*x, *y, -*z], [*x, -*y, *z], [-*x, *y, *z]];
            let lower = |corner: [S; 3]| {
                let height = normal.dot(Vector3(corner));
                Vector3(corner.map(|x| height.select_nonnegative(-x, x)))
            };
            corners.map(lower).to_vec()
        }
        ContactShape::Cylinder([radius, half]) => cylinder(*radius, *half, normal),
        ContactShape::Ellipsoid(radii) => {
            let scaled: [S; 3] = core::array::from_fn(|k| radii[k] * normal.0[k]);
            let length = Vector3(scaled).dot(Vector3(scaled)).sqrt();
            vec![Vector3(core::array::from_fn(|k| -(radii[k] * scaled[k] / length)))]
        }
        ContactShape::Points(points) => points.iter().map(|point| Vector3(*point)).collect(),
    }
}

/// Returns the direction of the first tangent of a shape's contacts; `None` for shapes whose
/// tangents follow the plane.
pub(super) fn tangent<S: Scalar>(shape: &ContactShape<S>) -> Option<Vector3<S>> {
    let [zero, one] = [S::zero(), S::one()];
    matches!(shape, ContactShape::Segment(_)).then_some(Vector3([zero, zero, one]))
}

/// Returns the lowest point of the disk that is nearer to the plane, the one of the other disk, and
/// the two points that form an equilateral triangle with the first one.
fn cylinder<S: Scalar>(radius: S, half: S, normal: Vector3<S>) -> Vec<Vector3<S>> {
    let [x, y, z] = normal.0;
    let square = x * x + y * y;
    // A disk that is parallel to the plane starts at its x axis.
    let is_parallel = S::from_f64(1e-30) - square;
    let scale = radius / is_parallel.select_nonnegative(S::one(), square).sqrt();
    let lowest = [
        is_parallel.select_nonnegative(radius, -(x * scale)),
        is_parallel.select_nonnegative(S::zero(), -(y * scale)),
    ];
    let nearer = z.select_nonnegative(-half, half);
    let [along, across] = [0.5, 0.866_025_403_784_438_6].map(S::from_f64);
    let on_disk = |[x, y]: [S; 2], z: S| Vector3([x, y, z]);
    let corner = |side: S| {
        let [x, y] = lowest;
        on_disk([side * y * across - x * along, -(side * x * across) - y * along], nearer)
    };
    vec![on_disk(lowest, nearer), on_disk(lowest, -nearer), corner(S::one()), corner(-S::one())]
}
