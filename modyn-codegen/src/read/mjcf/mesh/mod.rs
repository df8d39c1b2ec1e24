//! Meshes, as far as geoms get their inertia from them.

mod hull;
mod mass;
mod obj;
mod stl;

pub use mass::{MassProperties, Principal, principal_axes};

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::check::{list, numbers};
use super::element::{Element, path_of};
use super::models::Model;
use super::pose::from_quaternion;
use crate::diagnostics::Report;

/// The largest number of bytes of a mesh file.
const MAX_BYTES: u64 = 1 << 28;

/// The surface of a mesh.
#[derive(Default)]
pub struct Mesh {
    pub vertices: Vec<[f64; 3]>,
    /// The vertices of each triangle.
    pub faces: Vec<[usize; 3]>,
}

/// The meshes that were read, by the index of their model and their name.
#[derive(Default)]
pub struct Meshes<'e> {
    known: HashMap<(usize, &'e str), Result<Rc<MassProperties>, String>>,
}

impl<'e> Meshes<'e> {
    /// Returns the volume (or area) and inertia of the mesh of this name.
    ///
    /// # Errors
    ///
    /// Returns the reason why it is not computed.
    pub fn get(
        &mut self,
        name: &'e str,
        index: usize,
        model: &Model<'e>,
        report: &mut Report<'_>,
    ) -> Result<Rc<MassProperties>, String> {
        let known = self.known.entry((index, name));
        known.or_insert_with(|| mass_properties(name, model, report).map(Rc::new)).clone()
    }
}

fn mass_properties(
    name: &str,
    model: &Model,
    report: &mut Report<'_>,
) -> Result<MassProperties, String> {
    let mut assets = model.source.root.in_sections("asset").filter(|asset| asset.name == "mesh");
    let asset = assets.find(|asset| match asset.text("name") {
        Some(own) => own == name,
        None => asset.text("file").map(stem).as_deref() == Some(name),
    });
    let asset = asset.ok_or_else(|| format!("the mesh `{name}` is not in the file"))?;
    let chain = model.classes.chain(asset, None);
    if !model.is_sound(&chain) {
        return Err(format!("the mesh `{name}` has errors"));
    }
    let text = |name| chain.iter().find_map(|element| element.text(name));
    let mut mesh =
        surface(asset, model, report).map_err(|why| format!("the mesh `{name}` {why}"))?;
    let position = text("refpos").and_then(numbers).unwrap_or([0.0; 3]);
    let quaternion = text("refquat").and_then(numbers).unwrap_or([1.0, 0.0, 0.0, 0.0]);
    let rotation = from_quaternion(quaternion)
        .ok_or_else(|| format!("`refquat` of the mesh `{name}` is zero"))?;
    let scale: [f64; 3] = text("scale").and_then(numbers).unwrap_or([1.0; 3]);
    for vertex in &mut mesh.vertices {
        let moved: [f64; 3] = core::array::from_fn(|i| vertex[i] - position[i]);
        *vertex = core::array::from_fn(|i| {
            scale[i] * (0..3).map(|k| rotation[k][i] * moved[k]).sum::<f64>()
        });
    }
    // A reflection turns the triangles inside out.
    if scale.iter().product::<f64>() < 0.0 {
        mesh.faces.iter_mut().for_each(|face| face.swap(1, 2));
    }
    let method = text("inertia").unwrap_or("legacy");
    if mesh.faces.is_empty() || method == "convex" {
        // MuJoCo's hull with fewer vertices is not the convex hull.
        if text("maxhullvert").is_some_and(|count| count.trim() != "-1") {
            return Err(format!("the hull of the mesh `{name}` is cut by `maxhullvert`"));
        }
        let faces = hull::hull(&mesh.vertices);
        mesh.faces =
            faces.ok_or_else(|| format!("the mesh `{name}` has all vertices in one plane"))?;
    }
    MassProperties::new(mesh, method).map_err(|why| format!("the mesh `{name}` {why}"))
}

/// Returns the surface as it is in the file or in the element.
fn surface(asset: &Element, model: &Model, report: &mut Report<'_>) -> Result<Mesh, String> {
    if asset.text("builtin").is_some_and(|kind| kind != "none")
        || asset.named("plugin").next().is_some()
    {
        return Err("is made by MuJoCo".into());
    }
    let Some(file) = asset.text("file") else {
        let vertices = asset.text("vertex").and_then(list).unwrap_or_default();
        let faces = asset.text("face").and_then(list).unwrap_or_default();
        let vertices = vertices.as_chunks().0.to_vec();
        // Anything but an index is no vertex.
        let faces = faces
            .as_chunks()
            .0
            .iter()
            .map(|face: &[f64; 3]| face.map(|index| index as usize))
            .collect();
        return Mesh { vertices, faces }.checked();
    };
    let file = path_of(file);
    let file = if model.settings.strip_path {
        file.file_name().map(PathBuf::from).unwrap_or_default()
    } else {
        file
    };
    let Some(main) = &model.source.folder else {
        return Err(format!(
            "is in the file `{}`, which is not read since the folder of this text is unknown",
            file.display()
        ));
    };
    let meshes = path_of(model.settings.mesh_folder);
    let included = model.source.include_folder(asset.at);
    let mut places = vec![main.join(&meshes).join(&file)];
    places.extend(
        included.iter().flat_map(|folder| [folder.join(&file), folder.join(&meshes).join(&file)]),
    );
    let place = places.iter().find(|place| place.is_file()).unwrap_or(&places[0]);
    let place = super::element::normalized(place);
    report.depends_on(place.clone());
    let bytes = read(&place)?;
    let extension = place.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let mesh = match extension.as_str() {
        "stl" => stl::read(&bytes),
        "obj" => obj::read(&bytes),
        "msh" => msh(&bytes),
        _ => {
            return Err(format!(
                "has a file of an unknown format, `{}`; STL, OBJ and MSH are read",
                place.display()
            ));
        }
    };
    let mesh =
        mesh.ok_or_else(|| format!("has the file `{}`, which is not sound", place.display()))?;
    mesh.checked()
}

fn read(place: &Path) -> Result<Vec<u8>, String> {
    let shown = place.display();
    if !place.is_file() {
        return Err(format!("has the file `{shown}`, which does not exist"));
    }
    let size = std::fs::metadata(place).map_or(0, |data| data.len());
    if size > MAX_BYTES {
        return Err(format!("has the file `{shown}`, which has more than {MAX_BYTES} bytes"));
    }
    std::fs::read(place)
        .map_err(|why| format!("has the file `{shown}`, which cannot be read: {why}"))
}

/// Returns the name of a file without its folder and its extension.
pub fn stem(file: &str) -> String {
    path_of(file).file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

impl Mesh {
    /// Returns the mesh, if its triangles have vertices.
    fn checked(self) -> Result<Self, String> {
        let count = self.vertices.len();
        if count < 4 {
            return Err("has fewer than four vertices".into());
        }
        if self.faces.iter().flatten().any(|index| *index >= count) {
            return Err("has a triangle with a vertex that does not exist".into());
        }
        if !self.vertices.iter().flatten().all(|x| x.is_finite()) {
            return Err("has a vertex that is not finite".into());
        }
        Ok(self)
    }
}

/// Returns the mesh of a file in MuJoCo's format: four counts, then vertices, normals, texture coordinates and faces.
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
