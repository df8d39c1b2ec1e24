//! Reads the `<visual>`s of a link.

use modyn_runtime::spatial::Pose;
use roxmltree::Node;

use super::reader::Reader;
use crate::description::{Geometry, Shape, roll_pitch_yaw};
use crate::read::visual::{numbers, solid};
use crate::read::xml::element::{children, is};

impl<'a> Reader<'a, '_, '_, '_> {
    /// Returns the shapes of the link of this name.
    pub fn shapes(&mut self, link: Node<'a, '_>, name: &str) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for visual in self.xml.named(link, "visual").collect::<Vec<_>>() {
            let shape = child(visual, "geometry")
                .and_then(|node| children(node).find(Node::is_element))
                .filter(|node| node.tag_name().name() != "empty");
            // An empty geometry is not seen.
            let Some(shape) = shape else { continue };
            let color = child(visual, "material").and_then(|material| {
                let colors = ["diffuse", "ambient"];
                colors.into_iter().find_map(|name| color(content(material, name)?))
            });
            let pose = child(visual, "pose");
            let shape = match pose
                .filter(|pose| pose.attribute("relative_to").is_some_and(|name| !name.is_empty()))
            {
                Some(_) => Err("has a pose relative to another frame".into()),
                None => self.geometry(shape),
            };
            match shape {
                Ok(geometry) => {
                    let pose = pose.map_or_else(Pose::identity, pose_of);
                    shapes.push(Shape { pose, geometry, color });
                }
                Err(why) => {
                    self.world.shape_notes.push(format!("a shape of the link `{name}` {why}"));
                }
            }
        }
        shapes
    }

    fn geometry(&mut self, shape: Node<'a, '_>) -> Result<Geometry, String> {
        let kind = shape.tag_name().name();
        if kind != "mesh" {
            return solid(kind, |name| content(shape, name))
                .ok_or_else(|| format!("is a `<{kind}>` that cannot be drawn"));
        }
        let uri = content(shape, "uri").ok_or("is a `<mesh>` without `<uri>`")?.trim();
        let place =
            self.file_of(uri).map_err(|_| format!("has the file `{uri}`, which is not found"))?;
        self.xml.report.depends_on(place.clone());
        self.world.surfaces.surface(&self.options.files, uri, &[place], content(shape, "scale"))
    }
}

pub fn child<'a, 't>(node: Node<'a, 't>, name: &str) -> Option<Node<'a, 't>> {
    children(node).find(|child| is(*child, name))
}

/// Returns the text of a child element.
pub fn content<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    child(node, name)?.text()
}

/// Returns a colour of three or four numbers.
fn color(text: &str) -> Option<[f64; 4]> {
    numbers::<4>(text).or_else(|| numbers::<3>(text).map(|[r, g, b]| [r, g, b, 1.0]))
}

/// Returns the pose in a `<pose>`; a pose that cannot be read is identity.
fn pose_of(node: Node) -> Pose<f64> {
    let Some([x, y, z, roll, pitch, yaw]) = node.text().and_then(numbers::<6>) else {
        return Pose::identity();
    };
    let is_degrees = node.attribute("degrees") == Some("true");
    let angles =
        [roll, pitch, yaw].map(|angle| if is_degrees { angle.to_radians() } else { angle });
    Pose { rotation: roll_pitch_yaw(angles), translation: [x, y, z] }
}
