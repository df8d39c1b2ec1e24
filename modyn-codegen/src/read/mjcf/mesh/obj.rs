//! Meshes in Wavefront OBJ files.

use super::Mesh;

/// Returns the mesh; `None` if the file is not sound. Faces with more than three vertices become triangles. As in `MuJoCo`,
/// only the first object or group with faces counts.
pub fn read(bytes: &[u8]) -> Option<Mesh> {
    // Names of materials may have any encoding.
    let text = String::from_utf8_lossy(bytes);
    let mut mesh = Mesh::default();
    let mut is_first = true;
    for line in text.lines() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let mut number = || words.next()?.parse::<f32>().ok().map(f64::from);
                mesh.vertices.push([number()?, number()?, number()?]);
            }
            Some("o" | "g") => is_first &= mesh.faces.is_empty(),
            Some("f") if is_first => {
                let count = mesh.vertices.len();
                let face: Vec<usize> =
                    words.map(|word| vertex(word, count)).collect::<Option<_>>()?;
                mesh.triangulate(face)?;
            }
            _ => {}
        }
    }
    Some(mesh)
}

impl Mesh {
    /// Adds the triangles of a face; `None` if a vertex does not exist.
    fn triangulate(&mut self, mut face: Vec<usize>) -> Option<()> {
        if let [a, b, c, d] = face[..] {
            // In single precision, in which MuJoCo compares them.
            let between = |i: usize, k: usize| {
                let (from, to) = (self.vertices.get(i)?, self.vertices.get(k)?);
                let along = |i: usize| to[i] as f32 - from[i] as f32;
                Some(along(0) * along(0) + along(1) * along(1) + along(2) * along(2))
            };
            // A quadrangle is cut along its shorter diagonal.
            if between(a, c)? >= between(b, d)? {
                face = vec![b, c, d, a];
            }
        }
        let (first, rest) = face.split_first()?;
        self.faces.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        Some(())
    }
}

/// Returns the index of the vertex of a corner such as `3/1/2`; negative numbers count from the last vertex.
fn vertex(corner: &str, count: usize) -> Option<usize> {
    let number: i64 = corner.split('/').next()?.parse().ok()?;
    if number < 0 {
        count.checked_sub(usize::try_from(-number).ok()?)
    } else {
        usize::try_from(number).ok()?.checked_sub(1)
    }
}
