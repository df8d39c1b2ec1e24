//! Meshes in STL files, binary and as text.

use std::collections::HashMap;

use crate::description::Mesh;
use crate::work;

/// Returns the mesh; `None` if the file is not sound.
pub fn read(bytes: &[u8]) -> Option<Mesh> {
    binary(bytes).or_else(|| text(core::str::from_utf8(bytes).ok()?))
}

/// A text may begin as a binary file does, but has another length.
fn binary(bytes: &[u8]) -> Option<Mesh> {
    let (_, rest) = bytes.split_at_checked(80)?;
    let (count, triangles) = rest.split_first_chunk::<4>()?;
    let count = usize::try_from(u32::from_le_bytes(*count)).ok()?;
    if count == 0 || triangles.len() != count.checked_mul(50)? {
        return None;
    }
    let mut surface = Surface::default();
    for triangle in triangles.as_chunks::<50>().0 {
        // After the normal, three vertices of three numbers.
        let bytes_of_numbers: [[u8; 4]; 9] = *triangle[12..48].as_chunks().0.first_chunk()?;
        let numbers = bytes_of_numbers.map(f32::from_le_bytes);
        surface.triangle(core::array::from_fn(|i| {
            [numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]]
        }));
    }
    Some(surface.mesh)
}

fn text(text: &str) -> Option<Mesh> {
    let mut words = text.split_ascii_whitespace();
    words.next().filter(|word| *word == "solid")?;
    let mut surface = Surface::default();
    let mut corners = Vec::new();
    while let Some(word) = words.next() {
        match word {
            "vertex" => {
                let mut number = || words.next()?.parse::<f32>().ok();
                corners.push([number()?, number()?, number()?]);
            }
            "endloop" => surface.triangle(std::mem::take(&mut corners).try_into().ok()?),
            _ => {}
        }
    }
    Some(surface.mesh).filter(|mesh| !mesh.faces.is_empty())
}

/// A surface whose triangles share equal vertices.
#[derive(Default)]
struct Surface {
    mesh: Mesh,
    indices: HashMap<[u32; 3], usize>,
}

impl Surface {
    fn triangle(&mut self, corners: [[f32; 3]; 3]) {
        work::count(1);
        let face = corners.map(|corner| {
            *self.indices.entry(corner.map(f32::to_bits)).or_insert_with(|| {
                self.mesh.vertices.push(corner.map(f64::from));
                self.mesh.vertices.len() - 1
            })
        });
        self.mesh.faces.push(face);
    }
}
