//! Reads the `<visual>`s of a link.

use std::path::PathBuf;

use modyn_runtime::spatial::Pose;
use roxmltree::Node;
use rustc_hash::FxHashMap;

use super::reader::Reader;
use crate::description::{Geometry, Shape, roll_pitch_yaw};
use crate::read::visual::{numbers, solid};
use crate::read::xml::element::{children, is};

impl<'a> Reader<'a, '_, '_, '_> {
    /// Returns the shapes of the link of this name.
    pub fn shapes(&mut self, link: Node<'a, '_>, name: &str) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for visual in self.xml.named(link, "visual").collect::<Vec<_>>() {
            let part = |name: &str| children(visual).find(|node| is(*node, name));
            let element = part("geometry").and_then(|node| children(node).find(Node::is_element));
            let described = element.ok_or_else(|| "has no `<geometry>`".into());
            match described.and_then(|element| self.geometry(element)) {
                Ok(geometry) => shapes.push(Shape {
                    pose: part("origin").map_or_else(Pose::identity, pose),
                    geometry,
                    color: part("material").and_then(|material| self.color(material)),
                }),
                Err(why) => self.shape_notes.push(format!("a shape of the link `{name}` {why}")),
            }
        }
        shapes
    }

    /// Returns a geometry, or its fault, as the end of a sentence about it.
    pub fn geometry(&mut self, geometry: Node<'a, '_>) -> Result<Geometry, String> {
        let kind = geometry.tag_name().name();
        if kind != "mesh" {
            return solid(kind, |name| geometry.attribute(name))
                .ok_or_else(|| format!("is a `<{kind}>` that cannot be drawn"));
        }
        let file = geometry.attribute("filename").ok_or("is a `<mesh>` without `filename`")?;
        let places = self.places(file.trim());
        for place in &places {
            self.xml.report.depends_on(place.clone());
        }
        self.surfaces.surface(&self.options.files, file, &places, geometry.attribute("scale"))
    }

    /// Returns the colour of a material, which may be one of the robot's.
    fn color(&mut self, material: Node<'a, '_>) -> Option<[f64; 4]> {
        color_in(material).or_else(|| {
            let root = self.xml.root;
            let colors = self.materials.get_or_insert_with(|| {
                let mut colors = FxHashMap::default();
                for shared in children(root).filter(|node| is(*node, "material")) {
                    if let Some(name) = shared.attribute("name") {
                        colors.entry(name).or_insert_with(|| color_in(shared));
                    }
                }
                colors
            });
            colors.get(material.attribute("name")?).copied().flatten()
        })
    }

    /// Returns the places of a file that the description names by a path or by the name of a
    /// package.
    fn places(&mut self, file: &str) -> Vec<PathBuf> {
        let folder = self.options.folder.as_deref();
        if let Some((scheme @ ("package" | "model"), rest)) = file.split_once("://") {
            let (package, path) = rest.split_once('/').unwrap_or((rest, ""));
            let place = self.packages.find(package, self.options).map(|folder| folder.join(path));
            // A package that is not installed often has its folder around the description.
            let around = folder.into_iter().flat_map(|folder| {
                let absolute = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
                let above: Vec<_> = absolute.ancestors().map(|one| one.join(rest)).collect();
                let inside = absolute.ancestors().map(|one| one.join(path)).collect::<Vec<_>>();
                above.into_iter().chain(if scheme == "package" { inside } else { Vec::new() })
            });
            return place.into_iter().chain(around).collect();
        }
        let path = file.strip_prefix("file://").unwrap_or(file);
        folder.map(|folder| folder.join(path)).into_iter().collect()
    }
}

/// Returns the pose of an `<origin>`; numbers that cannot be read are zero.
fn pose(origin: Node) -> Pose<f64> {
    let three = |name| origin.attribute(name).and_then(numbers::<3>).unwrap_or_default();
    Pose { rotation: roll_pitch_yaw(three("rpy")), translation: three("xyz") }
}

/// Returns the colour that is written in a material.
fn color_in(material: Node) -> Option<[f64; 4]> {
    let color = children(material).find(|child| is(*child, "color"))?;
    numbers::<4>(color.attribute("rgba")?)
}
