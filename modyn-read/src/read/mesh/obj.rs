//! Meshes in Wavefront OBJ files.

use super::Purpose;
use crate::description::Mesh;
use crate::work;

/// Returns the mesh; `None` if the file is not sound. Faces with more than three vertices become
/// triangles. For a mass, as in `MuJoCo`, only the first object or group with faces counts.
pub fn read(bytes: &[u8], purpose: Purpose) -> Option<Mesh> {
    // Names of materials may have any encoding.
    let text = String::from_utf8_lossy(bytes);
    let mut mesh = Mesh::default();
    let mut is_first = true;
    let mut tests = 0;
    for line in text.lines() {
        work::count(1);
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let mut number = || words.next()?.parse::<f32>().ok().map(f64::from);
                mesh.vertices.push([number()?, number()?, number()?]);
            }
            Some("o" | "g") => is_first &= mesh.faces.is_empty(),
            Some("f") if is_first || purpose == Purpose::Picture => {
                let count = mesh.vertices.len();
                let face: Vec<usize> =
                    words.map(|word| vertex(word, count)).collect::<Option<_>>()?;
                triangulate(&mut mesh, face, &mut tests)?;
            }
            _ => {}
        }
    }
    Some(mesh)
}

/// Adds the triangles of a face; `None` if a vertex does not exist, or if finding them takes too
/// long.
pub fn triangulate(mesh: &mut Mesh, mut face: Vec<usize>, tests: &mut usize) -> Option<()> {
    if face.len() > MAX_CORNERS {
        return Some(());
    }
    if face.len() > 4 {
        let triangles = ears(&mesh.vertices, face, tests)?;
        mesh.faces.extend(triangles);
        return Some(());
    }
    if let [a, b, c, d] = face[..] {
        // In single precision, in which MuJoCo compares them.
        let between = |i: usize, k: usize| {
            let from = mesh.vertices.get(i)?;
            let to = mesh.vertices.get(k)?;
            let along = |i: usize| to[i] as f32 - from[i] as f32;
            Some(along(0) * along(0) + along(1) * along(1) + along(2) * along(2))
        };
        // A quadrangle is cut along its shorter diagonal.
        if between(a, c)? >= between(b, d)? {
            face = vec![b, c, d, a];
        }
    }
    let (first, rest) = face.split_first()?;
    mesh.faces.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
    Some(())
}

/// The largest number of corners of a face: MuJoCo leaves out faces with more.
const MAX_CORNERS: usize = 100;

/// The largest number of tests whether a corner is in a triangle.
const MAX_TESTS: usize = 1 << 28;

/// Returns the triangles of a polygon: ears are cut off, in the order and in the single precision
/// of MuJoCo's reader, since the inertia of a surface that is not closed depends on its triangles.
/// `None` if a vertex does not exist, or after too many `tests`.
fn ears(vertices: &[[f64; 3]], polygon: Vec<usize>, tests: &mut usize) -> Option<Vec<[usize; 3]>> {
    let points: Vec<[f32; 3]> =
        polygon.iter().map(|i| Some(vertices.get(*i)?.map(|x| x as f32))).collect::<Option<_>>()?;
    let [x, y] = projection(&points);
    let mut corners: Vec<(usize, [f32; 2])> =
        polygon.iter().zip(&points).map(|(i, point)| (*i, [point[x], point[y]])).collect();
    let mut triangles = Vec::new();
    let mut at = 0;
    // The corners that are tried before the next ear must be found.
    let mut left = corners.len();
    while corners.len() > 3 && left > 0 {
        let count = corners.len();
        at %= count;
        left -= 1;
        let ear = [0, 1, 2].map(|k| corners[(at + k) % count]);
        let [a, b, c] = ear.map(|(_, point)| point);
        let turn = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
        let area = (a[0] * b[1] - a[1] * b[0]) * 0.5;
        let mut others = (3..count).map(|k| corners[(at + k) % count].1);
        *tests += count;
        work::count(count);
        if *tests > MAX_TESTS {
            return None;
        }
        if turn * area < 0.0 || others.any(|point| is_inside([a, b, c], point)) {
            at += 1;
            continue;
        }
        triangles.push(ear.map(|(i, _)| i));
        corners.remove((at + 1) % count);
        left = corners.len();
    }
    if let [a, b, c] = corners[..] {
        triangles.push([a.0, b.0, c.0]);
    }
    Some(triangles)
}

/// Returns the two axes of the plane in which a polygon is seen: the axes of the largest area at
/// its first corner.
fn projection(points: &[[f32; 3]]) -> [usize; 2] {
    let count = points.len();
    for k in 0..count {
        let [a, b, c] = [0, 1, 2].map(|i| points[(k + i) % count]);
        let [e, f]: [[f32; 3]; 2] =
            [core::array::from_fn(|i| b[i] - a[i]), core::array::from_fn(|i| c[i] - b[i])];
        let [x, y, z] = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| (e[i] * f[j] - e[j] * f[i]).abs());
        if x > f32::EPSILON || y > f32::EPSILON || z > f32::EPSILON {
            return match () {
                () if x > y && x > z => [1, 2],
                () if z > x && z > y => [0, 1],
                () => [0, 2],
            };
        }
    }
    [1, 2]
}

/// Returns whether a point is in a triangle: a ray from it crosses the edges an odd number of
/// times.
fn is_inside(triangle: [[f32; 2]; 3], [x, y]: [f32; 2]) -> bool {
    let crossed = (0..3).filter(|&i| {
        let [xi, yi] = triangle[i];
        let [xj, yj] = triangle[(i + 2) % 3];
        (yi > y) != (yj > y) && x < (xj - xi) * (y - yi) / (yj - yi) + xi
    });
    crossed.count() % 2 == 1
}

/// Returns the index of the vertex of a corner such as `3/1/2`; negative numbers count from the
/// last vertex.
fn vertex(corner: &str, count: usize) -> Option<usize> {
    let number: i64 = corner.split('/').next()?.parse().ok()?;
    if number < 0 {
        count.checked_sub(usize::try_from(-number).ok()?)
    } else {
        usize::try_from(number).ok()?.checked_sub(1)
    }
}
