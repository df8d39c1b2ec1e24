//! The shapes of links in XML, for pictures. A shape that cannot be read is left out with a note,
//! and is never an error.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use crate::description::{FileStore, Geometry, MAX_NUMBER, Mesh};
use crate::read::mesh::{self, Purpose};

/// Returns `N` numbers, separated by white space; `None` for another text.
pub fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let list = crate::read::xml::numbers::numbers(text).ok()?;
    list.iter().all(|x| x.abs() < MAX_NUMBER).then_some(list)
}

/// Returns the geometry of an element of this name, which is the same in URDF and SDF; `None` if it
/// is no solid, or if a length is missing or not positive. `text` is the text of a length.
pub fn solid<'t>(element: &str, text: impl Fn(&str) -> Option<&'t str>) -> Option<Geometry> {
    let length = |name| text(name).and_then(numbers::<1>).map(|[length]| length);
    let three = |name| text(name).and_then(numbers::<3>);
    let geometry = match element {
        "box" => Geometry::Box { size: three("size")? },
        "sphere" => Geometry::Sphere { radius: length("radius")? },
        "ellipsoid" => Geometry::Ellipsoid { radii: three("radii")? },
        "cylinder" => Geometry::Cylinder { radius: length("radius")?, length: length("length")? },
        "capsule" => Geometry::Capsule { radius: length("radius")?, length: length("length")? },
        _ => return None,
    };
    geometry.is_sound().then_some(geometry)
}

/// The largest number of vertices and triangles of all meshes of a description.
const MAX_PARTS: usize = 20_000_000;

/// The meshes of a description: shapes with the same file and scale share their mesh.
#[derive(Default)]
pub struct Surfaces {
    /// The meshes by their file and the bits of their scale.
    read: HashMap<(PathBuf, [u64; 3]), Result<Arc<Mesh>, String>>,
    /// The number of vertices and triangles so far.
    parts: usize,
}

impl Surfaces {
    /// Returns the mesh of the first of these files that exists, scaled along x, y and z.
    ///
    /// # Errors
    ///
    /// Returns what is wrong with the mesh, as the end of a sentence about it.
    pub fn surface(
        &mut self,
        files: &FileStore,
        name: &str,
        places: &[PathBuf],
        scale: Option<&str>,
    ) -> Result<Geometry, String> {
        let scale = scale.map_or(Some([1.0; 3]), numbers::<3>);
        let nonzero = scale.filter(|scale| scale.iter().all(|&factor| factor != 0.0));
        let scale = nonzero.ok_or("has a `scale` that is not three numbers other than zero")?;
        let key = |place: &PathBuf| (place.clone(), scale.map(f64::to_bits));
        let known = places.iter().find_map(|place| self.read.get(&key(place)));
        if let Some(mesh) = known {
            return mesh.clone().map(Geometry::Mesh);
        }
        let existing = places.iter().find(|place| files.is_file(place));
        let place = existing.ok_or_else(|| format!("has the file `{name}`, which is not found"))?;
        if self.parts > MAX_PARTS {
            return Err(format!(
                "has the file `{name}`, which is not read, since the meshes before it have more \
                 than {MAX_PARTS} vertices and triangles"
            ));
        }
        let read = mesh::read(files, place, Purpose::Picture);
        let mesh = read.map(|mesh| Arc::new(mesh::scaled(mesh, scale)));
        self.parts += mesh.as_ref().map_or(0, |mesh| mesh.vertices.len() + mesh.faces.len());
        self.read.insert(key(place), mesh.clone());
        mesh.map(Geometry::Mesh)
    }
}
