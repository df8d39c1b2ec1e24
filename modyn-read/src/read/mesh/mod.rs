//! Meshes in files: STL, Wavefront OBJ, COLLADA, and the format of `MuJoCo`.

mod dae;
pub mod hull;
mod obj;
mod stl;

use std::io::Read as _;
use std::path::Path;

use crate::description::{FileStore, Mesh};

/// The largest number of bytes of a mesh file.
const MAX_BYTES: u64 = 1 << 28;

/// The use of a mesh.
#[derive(Clone, Copy, PartialEq)]
pub enum Purpose {
    /// The mass of a geom, as `MuJoCo` computes it: of the first object in a file.
    Mass,
    /// A picture of all objects.
    Picture,
}

/// Returns the mesh in a file, by the extension of its name.
///
/// # Errors
///
/// Returns what is wrong with the mesh, as the end of a sentence about it.
pub fn read(files: &FileStore, place: &Path, purpose: Purpose) -> Result<Mesh, String> {
    let bytes = bytes(files, place)?;
    let extension = place.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let read = match extension.as_str() {
        "stl" => stl::read(&bytes),
        "obj" => obj::read(&bytes, purpose),
        "msh" => msh(&bytes),
        // MuJoCo reads no COLLADA.
        "dae" if purpose == Purpose::Picture => dae::read(&bytes),
        _ => {
            return Err(format!(
                "has a file of an unknown format, `{}`; STL, OBJ and MSH are read, and DAE for pictures",
                place.display()
            ));
        }
    };
    let mesh =
        read.ok_or_else(|| format!("has the file `{}`, which is not sound", place.display()))?;
    checked(mesh)
}

fn bytes(files: &FileStore, place: &Path) -> Result<Vec<u8>, String> {
    let shown = place.display();
    if !files.is_file(place) {
        return Err(format!("has the file `{shown}`, which does not exist"));
    }
    let unreadable =
        |why: std::io::Error| format!("has the file `{shown}`, which cannot be read: {why}");
    let (size, mut file) = files.open(place).map_err(unreadable)?;
    if size > MAX_BYTES {
        return Err(format!("has the file `{shown}`, which has more than {MAX_BYTES} bytes"));
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(bytes)
}

/// Returns the mesh, if its triangles have vertices.
///
/// # Errors
///
/// Returns what is wrong with the mesh, as the end of a sentence about it.
pub fn checked(mesh: Mesh) -> Result<Mesh, String> {
    let count = mesh.vertices.len();
    if count < 4 {
        return Err("has fewer than four vertices".into());
    }
    if mesh.faces.iter().flatten().any(|index| *index >= count) {
        return Err("has a triangle with a vertex that does not exist".into());
    }
    if !mesh.vertices.iter().flatten().all(|x| x.is_finite()) {
        return Err("has a vertex that is not finite".into());
    }
    Ok(mesh)
}

/// Returns the mesh with its vertices scaled along x, y and z.
pub fn scaled(mut mesh: Mesh, scale: [f64; 3]) -> Mesh {
    for vertex in &mut mesh.vertices {
        *vertex = core::array::from_fn(|i| scale[i] * vertex[i]);
    }
    // A reflection turns the triangles inside out.
    if scale.iter().product::<f64>() < 0.0 {
        mesh.faces.iter_mut().for_each(|face| face.swap(1, 2));
    }
    mesh
}

/// Returns the mesh of a file in MuJoCo's format: four counts, then vertices, normals, texture
/// coordinates and faces.
fn msh(bytes: &[u8]) -> Option<Mesh> {
    let (header, data) = bytes.split_first_chunk::<16>()?;
    let count =
        |i: usize| usize::try_from(i32::from_le_bytes(*header[4 * i..].first_chunk()?)).ok();
    let [vertices, normals, textures, faces] = [count(0)?, count(1)?, count(2)?, count(3)?];
    let before = 12 * vertices + 12 * normals + 8 * textures;
    if data.len() != before + 12 * faces {
        return None;
    }
    let float = |bytes: &[u8; 4]| f64::from(f32::from_le_bytes(*bytes));
    let index = |bytes: &[u8; 4]| usize::try_from(i32::from_le_bytes(*bytes)).unwrap_or(usize::MAX);
    let vertices = data[..12 * vertices]
        .as_chunks()
        .0
        .as_chunks()
        .0
        .iter()
        .map(|one: &[_; 3]| one.each_ref().map(float));
    let faces = data[before..]
        .as_chunks()
        .0
        .as_chunks()
        .0
        .iter()
        .map(|one: &[_; 3]| one.each_ref().map(index));
    Some(Mesh { vertices: vertices.collect(), faces: faces.collect() })
}
