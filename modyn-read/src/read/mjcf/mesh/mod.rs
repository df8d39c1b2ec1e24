//! Meshes: their mass properties, from which geoms get their inertia, and their surfaces for
//! pictures.

mod mass;

pub use mass::{MassProperties, Principal, principal_axes};

use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

use super::check::{list, numbers};
use super::element::{Element, path_of};
use super::models::Model;
use super::pose::from_quaternion;
use crate::description::Mesh;
use crate::diagnostics::Report;
use crate::read::mesh::{Purpose, checked, hull, read, scaled};

/// The meshes that were read, by the index of their model and their name.
#[derive(Default)]
pub struct Meshes<'e> {
    known: HashMap<(usize, &'e str), Result<Rc<MassProperties>, String>>,
    /// The surfaces for pictures.
    pictures: HashMap<(usize, &'e str), Result<Arc<Mesh>, String>>,
    /// The corners of the hulls.
    corners: HashMap<(usize, &'e str), Corners>,
}

/// The corners of a hull, or why they are not known.
type Corners = Result<Rc<[[f64; 3]]>, String>;

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

    /// Returns the [corners](hull::corners) of the convex hull of the mesh of this name.
    ///
    /// # Errors
    ///
    /// Returns the reason why they are not known.
    pub fn corners(
        &mut self,
        name: &'e str,
        index: usize,
        model: &Model<'e>,
        report: &mut Report<'_>,
    ) -> Corners {
        let known = self.corners.entry((index, name));
        known.or_insert_with(|| corners(name, model, report).map(Rc::from)).clone()
    }

    /// Returns the surface of the mesh of this name, for a picture.
    ///
    /// # Errors
    ///
    /// Returns the reason why it is not known.
    pub fn picture(
        &mut self,
        name: &'e str,
        index: usize,
        model: &Model<'e>,
        report: &mut Report<'_>,
    ) -> Result<Arc<Mesh>, String> {
        let known = self.pictures.entry((index, name));
        known.or_insert_with(|| picture(name, model, report).map(Arc::new)).clone()
    }
}

/// A mesh as geoms have it, with the attributes of its element.
struct Asset<'e> {
    mesh: Mesh,
    /// The element, then the elements of its classes.
    chain: Vec<&'e Element>,
}

impl<'e> Asset<'e> {
    /// Returns the mesh of this name, moved and scaled as its element says.
    fn read(
        name: &str,
        model: &Model<'e>,
        purpose: Purpose,
        report: &mut Report<'_>,
    ) -> Result<Self, String> {
        let missing = || format!("the mesh `{name}` is not in the file");
        let asset = model.asset("mesh", name).ok_or_else(missing)?;
        let chain = model.classes.chain(asset, None);
        if !model.is_sound(&chain) {
            return Err(format!("the mesh `{name}` has errors"));
        }
        let mesh = surface(asset, model, purpose, report)
            .map_err(|why| format!("the mesh `{name}` {why}"))?;
        let mut asset = Self { mesh, chain };
        let position = asset.text("refpos").and_then(numbers).unwrap_or([0.0; 3]);
        let quaternion = asset.text("refquat").and_then(numbers).unwrap_or([1.0, 0.0, 0.0, 0.0]);
        let rotation = from_quaternion(quaternion)
            .ok_or_else(|| format!("`refquat` of the mesh `{name}` is zero"))?;
        let scale: [f64; 3] = asset.text("scale").and_then(numbers).unwrap_or([1.0; 3]);
        for vertex in &mut asset.mesh.vertices {
            let moved: [f64; 3] = core::array::from_fn(|i| vertex[i] - position[i]);
            *vertex =
                core::array::from_fn(|i| (0..3).map(|k| rotation[k][i] * moved[k]).sum::<f64>());
        }
        asset.mesh = scaled(asset.mesh, scale);
        Ok(asset)
    }

    /// Returns the text of an attribute of the element or of its classes.
    fn text(&self, name: &str) -> Option<&'e str> {
        self.chain.iter().find_map(|element| element.text(name))
    }
}

/// Returns the corners of the convex hull of a mesh.
fn corners(name: &str, model: &Model, report: &mut Report<'_>) -> Result<Vec<[f64; 3]>, String> {
    let vertices = Asset::read(name, model, Purpose::Picture, report)?.mesh.vertices;
    hull::corners(&vertices).map_err(|why| format!("the mesh `{name}` {why}"))
}

/// Returns the surface of a mesh: the convex hull if its element has vertices alone.
fn picture(name: &str, model: &Model, report: &mut Report<'_>) -> Result<Mesh, String> {
    let mut mesh = Asset::read(name, model, Purpose::Picture, report)?.mesh;
    if mesh.faces.is_empty() {
        let faces = hull::hull(&mesh.vertices);
        mesh.faces = faces.map_err(|why| format!("the mesh `{name}` {why}"))?;
    }
    Ok(mesh)
}

fn mass_properties(
    name: &str,
    model: &Model,
    report: &mut Report<'_>,
) -> Result<MassProperties, String> {
    let mut asset = Asset::read(name, model, Purpose::Mass, report)?;
    let method = asset.text("inertia").unwrap_or("legacy");
    if asset.mesh.faces.is_empty() || method == "convex" {
        // MuJoCo's hull with fewer vertices is not the convex hull.
        if asset.text("maxhullvert").is_some_and(|count| count.trim() != "-1") {
            return Err(format!("the hull of the mesh `{name}` is cut by `maxhullvert`"));
        }
        let faces = hull::hull(&asset.mesh.vertices);
        asset.mesh.faces = faces.map_err(|why| format!("the mesh `{name}` {why}"))?;
    }
    MassProperties::new(asset.mesh, method).map_err(|why| format!("the mesh `{name}` {why}"))
}

/// Returns the surface as it is in the file or in the element.
fn surface(
    asset: &Element,
    model: &Model,
    purpose: Purpose,
    report: &mut Report<'_>,
) -> Result<Mesh, String> {
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
        return checked(Mesh { vertices, faces });
    };
    let path = path_of(file);
    let file = if model.settings.strip_path {
        path.file_name().map(PathBuf::from).unwrap_or_default()
    } else {
        path
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
    let existing =
        places.iter().find(|place| model.source.store.is_file(place)).unwrap_or(&places[0]);
    let place = super::element::normalized(existing);
    report.depends_on(place.clone());
    read(&model.source.store, &place, purpose)
}
