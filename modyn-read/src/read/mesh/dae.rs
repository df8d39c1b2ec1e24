//! Meshes in COLLADA files (DAE): the triangles of all instances in the scene, without materials.
//!
//! Source: COLLADA 1.4.1, Digital Asset Schema, Khronos Group 2008.

use std::collections::HashMap;

use roxmltree::{Document, Node};

use super::obj::triangulate;
use crate::description::Mesh;
use crate::diagnostics::Report;
use crate::read::xml::document::within_limits;
use crate::read::xml::element::children;
use crate::work;

/// The largest number of nodes, and of vertices and triangles together: a node may be instanced by
/// others any number of times.
const MAX_NODES: usize = 100_000;
const MAX_PARTS: usize = 20_000_000;

/// The three upper rows of a matrix that acts on points.
type Transform = [[f64; 4]; 3];

/// Returns the mesh in m, with z upwards; `None` if the file is not sound.
pub fn read(bytes: &[u8]) -> Option<Mesh> {
    // Names may have any encoding.
    let decoded = String::from_utf8_lossy(bytes);
    let text = within_limits(&decoded, 0, &mut Report::without_file())?;
    let document = Document::parse(&text).ok()?;
    let root = document.root_element();
    let ids = root.descendants().filter_map(|node| Some((node.attribute("id")?, node)));
    let mut scene = Scene { ids: ids.collect(), mesh: Mesh::default(), tests: 0 };
    let asset = child(root, "asset");
    let attribute = asset.and_then(|asset| child(asset, "unit")?.attribute("meter"));
    let unit: f64 = attribute.map_or(Some(1.0), |text| text.trim().parse().ok())?;
    let up = asset.and_then(|asset| child(asset, "up_axis")?.text()).unwrap_or("Y_UP");
    // The axis that points upwards becomes z, the one to the right x.
    let rows = match up.trim() {
        "X_UP" => [[0.0, -unit, 0.0], [0.0, 0.0, -unit], [unit, 0.0, 0.0]],
        "Y_UP" => [[unit, 0.0, 0.0], [0.0, 0.0, -unit], [0.0, unit, 0.0]],
        "Z_UP" => [[unit, 0.0, 0.0], [0.0, unit, 0.0], [0.0, 0.0, unit]],
        _ => return None,
    };
    let upright = rows.map(|[x, y, z]| [x, y, z, 0.0]);
    let shown = child(root, "scene")
        .and_then(|node| scene.target(child(node, "instance_visual_scene")?, "url"))
        .or_else(|| root.descendants().find(|node| node.tag_name().name() == "visual_scene"));
    match shown {
        Some(shown) => scene.add_nodes(shown, &upright)?,
        None => {
            let geometries = root.descendants().filter(|node| node.tag_name().name() == "geometry");
            for geometry in geometries.collect::<Vec<_>>() {
                scene.add_geometry(geometry, &upright)?;
            }
        }
    }
    Some(scene.mesh)
}

struct Scene<'a, 't> {
    ids: HashMap<&'a str, Node<'a, 't>>,
    mesh: Mesh,
    /// The effort of cutting polygons so far.
    tests: usize,
}

impl<'a, 't> Scene<'a, 't> {
    /// Returns the element that an attribute names.
    fn target(&self, node: Node<'a, 't>, attribute: &str) -> Option<Node<'a, 't>> {
        self.ids.get(node.attribute(attribute)?.trim().strip_prefix('#')?).copied()
    }

    /// Adds the geometries of the nodes in a scene; `None` if one is not sound.
    fn add_nodes(&mut self, shown: Node<'a, 't>, upright: &Transform) -> Option<()> {
        let mut waiting = vec![(shown, *upright)];
        let mut count = 0;
        while let Some((node, outer)) = waiting.pop() {
            // An element counts in each instance of its node.
            count += 1 + elements(node).count();
            if count > MAX_NODES {
                return None;
            }
            let placed = elements(node).try_fold(outer, |sum, part| {
                Some(local(part)?.map_or(sum, |transform| product(&sum, &transform)))
            })?;
            for part in elements(node) {
                match part.tag_name().name() {
                    "node" => waiting.push((part, placed)),
                    "instance_node" => waiting.push((self.target(part, "url")?, placed)),
                    "instance_geometry" => self.add_geometry(self.target(part, "url")?, &placed)?,
                    "instance_controller" => {
                        let skin = child(self.target(part, "url")?, "skin")?;
                        self.add_geometry(self.target(skin, "source")?, &placed)?;
                    }
                    _ => {}
                }
            }
        }
        Some(())
    }

    /// Adds the triangles of a geometry; `None` if it is not sound.
    fn add_geometry(&mut self, geometry: Node<'a, 't>, placed: &Transform) -> Option<()> {
        // Splines have no triangles.
        let Some(surface) = child(geometry, "mesh") else { return Some(()) };
        let [x, y, z] = placed.map(|row| [row[0], row[1], row[2]]);
        let normal: [f64; 3] = core::array::from_fn(|i| {
            x[(i + 1) % 3] * y[(i + 2) % 3] - x[(i + 2) % 3] * y[(i + 1) % 3]
        });
        let is_mirrored = normal.iter().zip(z).map(|(a, b)| a * b).sum::<f64>() < 0.0;
        let before = self.mesh.faces.len();
        let mut starts: HashMap<_, (usize, usize)> = HashMap::new();
        for part in elements(surface) {
            let kind = part.tag_name().name();
            if !["triangles", "polylist", "polygons", "trifans", "tristrips"].contains(&kind) {
                continue;
            }
            let offset =
                |input: &Node| input.attribute("offset").unwrap_or("0").trim().parse().ok();
            let inputs: Vec<_> =
                elements(part).filter(|one| one.tag_name().name() == "input").collect();
            let stride =
                inputs.iter().filter_map(offset).max().unwrap_or(0_usize).checked_add(1)?;
            let vertex =
                inputs.iter().find(|input| input.attribute("semantic") == Some("VERTEX"))?;
            let offset = offset(vertex)?;
            let vertices = self.target(*vertex, "source")?;
            let position =
                elements(vertices).find(|input| input.attribute("semantic") == Some("POSITION"))?;
            let source = self.target(position, "source")?;
            let (start, count) = match starts.get(&source.id()) {
                Some(known) => *known,
                None => {
                    let start = self.mesh.vertices.len();
                    let positions = self.positions(source)?;
                    self.mesh.vertices.extend(positions.iter().map(|point| moved(placed, point)));
                    starts.insert(source.id(), (start, positions.len()));
                    (start, positions.len())
                }
            };
            work::count(1);
            let corners = |text: &str| -> Option<Vec<usize>> {
                let words: Vec<usize> = numbers(text)?;
                let indices = words.chunks_exact(stride).map(|corner| corner[offset]);
                indices.map(|corner| (corner < count).then_some(start + corner)).collect()
            };
            let lists = elements(part).filter(|one| one.tag_name().name() == "p");
            let indices = lists.map(|list| corners(list.text().unwrap_or_default()));
            let lists: Vec<Vec<usize>> = indices.collect::<Option<_>>()?;
            match kind {
                "triangles" => {
                    self.mesh.faces.extend(lists.iter().flat_map(|list| list.as_chunks().0))
                }
                "trifans" => {
                    let fan = |list: &[usize]| -> Vec<[usize; 3]> {
                        list.get(1..)
                            .unwrap_or_default()
                            .windows(2)
                            .map(|pair| [list[0], pair[0], pair[1]])
                            .collect()
                    };
                    self.mesh.faces.extend(lists.iter().flat_map(|list| fan(list)));
                }
                "tristrips" => {
                    let turned = |(i, corner): (usize, &[usize])| {
                        if i % 2 == 0 {
                            [corner[0], corner[1], corner[2]]
                        } else {
                            [corner[1], corner[0], corner[2]]
                        }
                    };
                    let strips = lists.iter().flat_map(|list| list.windows(3).enumerate());
                    self.mesh.faces.extend(strips.map(turned));
                }
                "polygons" => {
                    for list in lists {
                        triangulate(&mut self.mesh, list, &mut self.tests)?;
                    }
                }
                _ => {
                    let counts: Vec<usize> =
                        numbers(child(part, "vcount")?.text().unwrap_or_default())?;
                    let all = lists.concat();
                    let mut rest = all.as_slice();
                    for count in counts {
                        let (polygon, after) = rest.split_at_checked(count)?;
                        triangulate(&mut self.mesh, polygon.to_vec(), &mut self.tests)?;
                        rest = after;
                    }
                }
            }
            if self.mesh.vertices.len() + self.mesh.faces.len() > MAX_PARTS {
                return None;
            }
        }
        if is_mirrored {
            self.mesh.faces[before..].iter_mut().for_each(|face| face.swap(1, 2));
        }
        Some(())
    }

    /// Returns the points of a source.
    fn positions(&self, source: Node<'a, 't>) -> Option<Vec<[f64; 3]>> {
        let accessor = child(child(source, "technique_common")?, "accessor")?;
        let number = |name, default: usize| match accessor.attribute(name) {
            Some(text) => text.trim().parse().ok(),
            None => Some(default),
        };
        let stride = number("stride", 1)?.max(3);
        let offset = number("offset", 0)?;
        let values: Vec<f64> =
            numbers(self.target(accessor, "source")?.text().unwrap_or_default())?;
        let points = values.get(offset..)?.chunks(stride);
        Some(points.filter_map(|point| point.first_chunk().copied()).collect())
    }
}

fn elements<'a, 't>(node: Node<'a, 't>) -> impl Iterator<Item = Node<'a, 't>> {
    children(node).filter(Node::is_element)
}

fn child<'a, 't>(node: Node<'a, 't>, name: &str) -> Option<Node<'a, 't>> {
    elements(node).find(|child| child.tag_name().name() == name)
}

/// Returns the numbers of a text; `None` if a word is not one.
fn numbers<T: core::str::FromStr>(text: &str) -> Option<Vec<T>> {
    text.split_ascii_whitespace().map(|word| word.parse().ok()).collect()
}

/// Returns the transform of an element of a node; `Some(None)` if it is no transform.
fn local(part: Node) -> Option<Option<Transform>> {
    let values = || numbers::<f64>(part.text().unwrap_or_default());
    let transform = match part.tag_name().name() {
        "matrix" => *values()?.as_chunks::<4>().0.first_chunk()?,
        "translate" => {
            let [x, y, z] = *values()?.first_chunk()?;
            [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]]
        }
        "scale" => {
            let [x, y, z] = *values()?.first_chunk()?;
            [[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0]]
        }
        "rotate" => {
            let [x, y, z, angle] = *values()?.first_chunk()?;
            let length = (x * x + y * y + z * z).sqrt();
            let axis = if length > 0.0 { [x, y, z].map(|part| part / length) } else { [0.0; 3] };
            let sin = libm::sin(angle.to_radians());
            let cos = libm::cos(angle.to_radians());
            // Rodrigues' formula.
            let across =
                [[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]];
            core::array::from_fn(|i| {
                core::array::from_fn(|k| match k {
                    3 => 0.0,
                    _ => {
                        let diagonal = if i == k { cos } else { 0.0 };
                        diagonal + sin * across[i][k] + (1.0 - cos) * axis[i] * axis[k]
                    }
                })
            })
        }
        "skew" | "lookat" => return None,
        _ => return Some(None),
    };
    Some(Some(transform))
}

fn moved(transform: &Transform, [x, y, z]: &[f64; 3]) -> [f64; 3] {
    transform.map(|row| row[0] * x + row[1] * y + row[2] * z + row[3])
}

fn product(a: &Transform, b: &Transform) -> Transform {
    a.map(|row| {
        core::array::from_fn(|k| {
            let translation = if k == 3 { row[3] } else { 0.0 };
            translation + (0..3).map(|i| row[i] * b[i][k]).sum::<f64>()
        })
    })
}
