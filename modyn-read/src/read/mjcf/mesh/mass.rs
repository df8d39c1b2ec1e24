//! Volume, centre of mass and inertia of a mesh, as `MuJoCo` defines them.

use crate::description::{Mesh, cross};

/// The volume (or area) of a mesh, its centre of mass, and its inertia at density one.
#[derive(Clone)]
pub struct MassProperties {
    pub measure: f64,
    pub center_of_mass: [f64; 3],
    /// About the centre of mass: xx, xy, xz, yy, yz, zz.
    pub inertia: [f64; 6],
    /// The vertices.
    vertices: Vec<[f64; 3]>,
}

/// The principal axes of a mesh.
pub struct Principal {
    /// The axes as columns, from the largest moment of inertia to the smallest.
    pub axes: [[f64; 3]; 3],
    /// The half lengths of the box with the same inertia.
    pub half_lengths: [f64; 3],
}

/// The smallest volume and area.
const MIN_MEASURE: f64 = 1e-15;

impl MassProperties {
    /// Returns the properties by the attribute `inertia` of the mesh.
    ///
    /// # Errors
    ///
    /// Returns the reason why they cannot be computed.
    pub fn new(mesh: Mesh, method: &str) -> Result<Self, String> {
        let Mesh { vertices, faces } = mesh;
        let corners = |face: &[usize; 3]| face.map(|index| vertices[index]);
        let triangles: Vec<Triangle> =
            faces.iter().map(|face| Triangle::new(corners(face))).collect();
        let total = weighted(triangles.iter().map(|one| (one.area, one.center)));
        let (area, centroid) = total.ok_or("has no area")?;
        let is_shell = method == "shell";
        // A triangle of the shell, or the pyramid over a triangle.
        let weight = |one: &Triangle, origin: [f64; 3]| {
            if is_shell {
                return one.area;
            }
            let volume = (0..3).map(|i| one.normal[i] * (one.center[i] - origin[i])).sum::<f64>()
                * one.area
                / 3.0;
            if method == "legacy" { volume.abs() } else { volume }
        };
        let pyramids = triangles.iter().map(|one| {
            let center = core::array::from_fn(|i| 0.75 * one.center[i] + 0.25 * centroid[i]);
            (weight(one, centroid), center)
        });
        let (_, center_of_mass) = weighted(pyramids)
            .filter(|(volume, _)| *volume > 0.0)
            .ok_or("has no positive volume: its triangles may be inside out, or it may need `inertia=\"shell\"`")?;
        let mut measure = 0.0;
        let mut products = [[0.0; 3]; 3];
        for (face, one) in faces.iter().zip(&triangles) {
            let weight = weight(one, center_of_mass);
            measure += weight;
            let corners = corners(face)
                .map(|corner| core::array::from_fn::<f64, 3, _>(|i| corner[i] - center_of_mass[i]));
            let sum: [f64; 3] =
                core::array::from_fn(|i| corners.iter().map(|corner| corner[i]).sum());
            let scale = weight / if is_shell { 12.0 } else { 20.0 };
            for i in 0..3 {
                for j in 0..3 {
                    let squares: f64 = corners.iter().map(|corner| corner[i] * corner[j]).sum();
                    products[i][j] += scale * (squares + sum[i] * sum[j]);
                }
            }
        }
        if !(measure > MIN_MEASURE && area > MIN_MEASURE) {
            return Err("has no positive volume: its triangles may be inside out, or it may need \
                        `inertia=\"shell\"`"
                .into());
        }
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = products;
        let inertia = [yy + zz, -xy, -xz, xx + zz, -yz, xx + yy];
        Ok(Self { measure, center_of_mass, inertia, vertices })
    }

    /// Returns the principal axes.
    pub fn principal(&self) -> Principal {
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        let (moments, axes) = principal_axes([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
        let sum: f64 = moments.iter().sum();
        let half =
            |moment: f64| 0.5 * libm::sqrt((6.0 * (sum - 2.0 * moment) / self.measure).max(0.0));
        Principal { axes, half_lengths: moments.map(half) }
    }

    /// Returns the lowest and the highest coordinates of the vertices along the principal axes,
    /// from the centre of mass.
    pub fn bounds(&self, principal: &Principal) -> [[f64; 3]; 2] {
        // MuJoCo's box contains the centre of mass.
        let bounds = [[0.0_f64; 3], [0.0_f64; 3]];
        self.vertices.iter().fold(bounds, |[low, high], vertex| {
            let along: [f64; 3] = core::array::from_fn(|j| {
                (0..3).map(|i| principal.axes[i][j] * (vertex[i] - self.center_of_mass[i])).sum()
            });
            [
                core::array::from_fn(|j| low[j].min(along[j])),
                core::array::from_fn(|j| high[j].max(along[j])),
            ]
        })
    }
}

struct Triangle {
    area: f64,
    /// Of unit length; zero without an area.
    normal: [f64; 3],
    center: [f64; 3],
}

impl Triangle {
    fn new([a, b, c]: [[f64; 3]; 3]) -> Self {
        let edge = |end: [f64; 3]| core::array::from_fn(|i| end[i] - a[i]);
        let normal = cross(edge(b), edge(c));
        let length = libm::sqrt(normal.iter().map(|x| x * x).sum());
        let unit = if length < MIN_MEASURE { [0.0; 3] } else { normal.map(|x| x / length) };
        Self {
            area: length / 2.0,
            normal: unit,
            center: core::array::from_fn(|i| (a[i] + b[i] + c[i]) / 3.0),
        }
    }
}

/// Returns the sum of the weights and the weighted mean; `None` if the sum is tiny.
fn weighted(points: impl Iterator<Item = (f64, [f64; 3])>) -> Option<(f64, [f64; 3])> {
    let (sum, moments) = points.fold((0.0, [0.0; 3]), |(sum, moments), (weight, point)| {
        (sum + weight, core::array::from_fn(|i| moments[i] + weight * point[i]))
    });
    (sum.abs() > MIN_MEASURE).then(|| (sum, moments.map(|moment| moment / sum)))
}

/// Returns the eigenvalues of a symmetric matrix, the largest first, and the eigenvectors as
/// columns of a rotation: Jacobi's method.
pub fn principal_axes(mut matrix: [[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..20 {
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            if matrix[i][j] == 0.0 {
                continue;
            }
            let angle = 0.5 * libm::atan2(2.0 * matrix[i][j], matrix[j][j] - matrix[i][i]);
            let (sin, cos) = libm::sincos(angle);
            for row in matrix.iter_mut().chain(&mut axes) {
                (row[i], row[j]) = (cos * row[i] - sin * row[j], sin * row[i] + cos * row[j]);
            }
            let above = matrix[i];
            let below = matrix[j];
            matrix[i] = core::array::from_fn(|k| cos * above[k] - sin * below[k]);
            matrix[j] = core::array::from_fn(|k| sin * above[k] + cos * below[k]);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| matrix[b][b].total_cmp(&matrix[a][a]));
    let column = |j: usize| [axes[0][j], axes[1][j], axes[2][j]];
    let [x, y] = [column(order[0]), column(order[1])];
    let z = cross(x, y);
    let axes = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
    (order.map(|i| matrix[i][i]), axes)
}
