//! Robots with their shapes and motions.

use modyn_read::{Geometry, Mesh, Shape, Shapes};
use modyn_runtime::Interpreter;
use modyn_runtime::joint::{JointType, planar};
use modyn_runtime::model::{Inertial, Model};
use modyn_runtime::spatial::Pose;

use super::json::{key, list, number, numbers, text};
use super::page_of;

/// Robots, and their motions, for a page.
///
/// ```
/// use modyn_cli::viewer::{Motion, Scene};
///
/// # fn main() -> Result<(), modyn_read::diagnostics::Diagnostics> {
/// let urdf = r#"<robot name="pendulum"><link name="base"/>
///     <joint name="pivot" type="continuous">
///       <parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
///     </joint>
///     <link name="rod">
///       <inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
///         <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
///       <visual><origin xyz="0 0 -0.5"/><geometry><cylinder radius="0.05" length="1"/></geometry></visual>
///     </link></robot>"#;
/// let options = modyn_read::ReadOptions { shapes: true, ..Default::default() };
/// let reading = modyn_read::read(urdf, "pendulum.urdf", &options)?;
///
/// let mut scene = Scene::new("A pendulum");
/// let robot = scene.robot(reading.model, reading.shapes);
/// let times: Vec<f64> = (0..50).map(|i| 0.02 * f64::from(i)).collect();
/// let coordinates = times.iter().map(|time| vec![time.sin()]).collect();
/// scene.motion(Motion { name: "swing".into(), robot, times, coordinates, forces: None });
/// assert!(scene.page().contains("A pendulum"));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Scene {
    title: String,
    robots: Vec<(Model, Shapes)>,
    motions: Vec<Motion>,
    ground: Option<f64>,
}

/// The motion of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// The name, which the page shows if there are several motions.
    pub name: String,
    /// The index of the robot, as [`Scene::robot`] returned it.
    pub robot: usize,
    /// The times, s, in ascending order.
    pub times: Vec<f64>,
    /// The coordinates at each time.
    pub coordinates: Vec<Vec<f64>>,
    /// The places of points that touch the ground, m, and the force on each, N, at each time, in
    /// world axes; `None` if they are not known.
    pub forces: Option<Vec<Vec<[f64; 6]>>>,
}

impl Scene {
    /// Returns a scene without robots.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// Adds a robot, and returns its index. Bodies without shapes are drawn by their joints and
    /// masses. A robot without motions can be moved by sliders.
    pub fn robot(&mut self, model: Model, shapes: Shapes) -> usize {
        self.robots.push((model, shapes));
        self.robots.len() - 1
    }

    /// Adds a motion of a robot. Several motions are shown beside each other.
    ///
    /// # Panics
    ///
    /// If there is no robot of that index, if the numbers of times and of states differ, if the
    /// coordinates do not have the robot's length, or if the numbers of points differ.
    pub fn motion(&mut self, motion: Motion) {
        let Motion { robot, times, coordinates, forces, .. } = &motion;
        let model = &self.robots[*robot].0;
        assert_eq!(times.len(), coordinates.len(), "the number of states is that of times");
        assert!(coordinates.iter().all(|q| q.len() == model.nq()), "states have `nq` coordinates");
        if let Some(forces) = forces {
            assert_eq!(times.len(), forces.len(), "the number of forces is that of times");
            let count = forces.first().map_or(0, Vec::len);
            assert!(forces.iter().all(|list| list.len() == count), "each point has a force");
        }
        self.motions.push(motion);
    }

    /// Draws the ground at this height, m. Without a call it is at zero, or below all motions if
    /// one of them goes below zero.
    ///
    /// # Panics
    ///
    /// If the height is not finite.
    pub fn ground(&mut self, height: f64) {
        assert!(height.is_finite(), "the ground has a height");
        self.ground = Some(height);
    }

    /// Returns the page.
    #[must_use]
    pub fn page(&self) -> String {
        page_of(&self.title, &self.data())
    }

    /// Returns the data of the page, JSON, which the script of the view takes as well.
    #[must_use]
    pub fn data(&self) -> String {
        let mut meshes: Vec<&Mesh> = Vec::new();
        let mut out = String::from("{");
        key(&mut out, "title");
        text(&mut out, &self.title);
        key(&mut out, "robots");
        list(&mut out, &self.robots, |out, (model, shapes)| robot(out, model, shapes, &mut meshes));
        key(&mut out, "meshes");
        list(&mut out, &meshes, |out, mesh| surface(out, mesh));
        key(&mut out, "motions");
        list(&mut out, &self.motions, |out, motion| {
            out.push('{');
            key(out, "name");
            text(out, &motion.name);
            key(out, "robot");
            *out += &motion.robot.to_string();
            key(out, "times");
            numbers(out, &motion.times);
            key(out, "q");
            list(out, &motion.coordinates, numbers);
            if let Some(forces) = &motion.forces {
                key(out, "forces");
                list(out, forces, |out, forces| numbers(out, forces.as_flattened()));
            }
            out.push('}');
        });
        if let Some(height) = self.ground {
            key(&mut out, "ground");
            number(&mut out, height);
        }
        out += ",\"figures\":[]}";
        out
    }
}

/// Writes a robot. Meshes that are not among `meshes` are added to these.
fn robot<'s>(out: &mut String, model: &Model, shapes: &'s Shapes, meshes: &mut Vec<&'s Mesh>) {
    out.push('{');
    key(out, "name");
    text(out, model.name());
    key(out, "neutral");
    let mut neutral = vec![0.0; model.nq()];
    // The slice has the model's length, so the call cannot fail.
    let _ = Interpreter::<f64>::new(model.clone()).neutral(&mut neutral);
    numbers(out, &neutral);
    // The links that are fixed to the world, together.
    let fixed = model.links().iter().filter(|link| link.moving_link.is_none());
    let inertials = fixed.map(|frame| frame.inertial.transformed(&frame.pose));
    let base = inertials.fold(Inertial::default(), |sum, inertial| sum.merged(&inertial));
    key(out, "base");
    out.push('{');
    mass(out, &base);
    out.push('}');
    key(out, "bodies");
    list(out, 0..model.moving_links().len(), |out, link| body(out, model, link));
    key(out, "frames");
    list(out, model.links(), |out, frame| {
        out.push('{');
        key(out, "name");
        text(out, &frame.name);
        key(out, "body");
        index(out, frame.moving_link);
        key(out, "pose");
        pose(out, &frame.pose);
        out.push('}');
    });
    key(out, "shapes");
    let of_frames = shapes.of_frames.iter().enumerate();
    let all = of_frames.flat_map(|(frame, shapes)| shapes.iter().map(move |shape| (frame, shape)));
    list(out, all, |out, (frame, drawn)| shape(out, frame, drawn, meshes));
    out.push('}');
}

/// Writes a moving link with its joint.
fn body(out: &mut String, model: &Model, link: usize) {
    let body = &model.moving_links()[link];
    let joint = &body.joint;
    let inertial = &body.inertial;
    out.push('{');
    key(out, "name");
    text(out, &body.name);
    key(out, "parent");
    index(out, body.parent);
    mass(out, inertial);
    key(out, "joint");
    out.push('{');
    key(out, "name");
    text(out, &joint.name);
    key(out, "type");
    text(out, joint.joint_type.name());
    key(out, "origin");
    pose(out, &joint.origin);
    key(out, "axis");
    numbers(out, &joint.axis);
    key(out, "second");
    numbers(out, &joint.second_axis);
    if joint.joint_type == JointType::Planar {
        key(out, "plane");
        numbers(out, planar::plane(joint.axis).as_flattened());
    }
    let mimic = model.mimic(link);
    key(out, "q");
    *out += &model.q_range(link).start.to_string();
    key(out, "isMimic");
    *out += if mimic.is_some() { "true" } else { "false" };
    key(out, "multiplier");
    number(out, mimic.map_or(1.0, |mimic| mimic.multiplier));
    key(out, "offset");
    number(out, mimic.map_or(0.0, |mimic| mimic.offset));
    if joint.joint_type.nq() == 1 {
        key(out, "range");
        numbers(out, &model.coordinate_range(link));
    }
    *out += "}}";
}

/// Writes mass, centre of mass and inertia about it.
fn mass(out: &mut String, inertial: &Inertial) {
    key(out, "mass");
    number(out, inertial.mass);
    key(out, "center");
    numbers(out, &inertial.center_of_mass);
    key(out, "inertia");
    numbers(out, &inertial.inertia);
}

fn shape<'s>(out: &mut String, frame: usize, shape: &'s Shape, meshes: &mut Vec<&'s Mesh>) {
    out.push('{');
    key(out, "frame");
    *out += &frame.to_string();
    key(out, "pose");
    pose(out, &shape.pose);
    key(out, "color");
    numbers(out, &shape.color.unwrap_or(UNCOLORED));
    match &shape.geometry {
        Geometry::Box { size } => lengths(out, "box", size),
        Geometry::Sphere { radius } => {
            key(out, "sphere");
            number(out, *radius);
        }
        Geometry::Ellipsoid { radii } => lengths(out, "ellipsoid", radii),
        Geometry::Cylinder { radius, length } => lengths(out, "cylinder", &[*radius, *length]),
        Geometry::Capsule { radius, length } => lengths(out, "capsule", &[*radius, *length]),
        Geometry::Mesh(mesh) => {
            // Most equal meshes are one.
            let same_place = meshes.iter().position(|known| std::ptr::eq(*known, &**mesh));
            let known = same_place.or_else(|| meshes.iter().position(|known| **known == **mesh));
            let index = known.unwrap_or_else(|| {
                meshes.push(mesh);
                meshes.len() - 1
            });
            key(out, "mesh");
            *out += &index.to_string();
        }
        // A geometry that this page does not know is not drawn.
        _ => lengths(out, "ellipsoid", &[0.0; 3]),
    }
    out.push('}');
}

/// The colour of shapes without one.
const UNCOLORED: [f64; 4] = [0.82, 0.84, 0.86, 1.0];

fn lengths(out: &mut String, name: &str, lengths: &[f64]) {
    key(out, name);
    numbers(out, lengths);
}

/// Writes the index of a body; -1 is the world.
fn index(out: &mut String, link: Option<usize>) {
    match link {
        Some(link) => *out += &link.to_string(),
        None => *out += "-1",
    }
}

/// Writes nine numbers of the rotation, row by row, and three of the translation.
fn pose(out: &mut String, pose: &Pose<f64>) {
    numbers(out, pose.rotation.as_flattened().iter().chain(&pose.translation));
}

/// Writes a mesh: 16 bits for each coordinate within the bounding box, and 32 for each corner of a
/// triangle.
fn surface(out: &mut String, mesh: &Mesh) {
    let extreme = |pick: fn(f64, f64) -> f64, start: f64| -> [f64; 3] {
        core::array::from_fn(|k| mesh.vertices.iter().map(|vertex| vertex[k]).fold(start, pick))
    };
    let low = extreme(f64::min, f64::INFINITY);
    let high = extreme(f64::max, f64::NEG_INFINITY);
    let size: [f64; 3] = core::array::from_fn(|k| high[k] - low[k]);
    let place = |vertex: &[f64; 3]| -> [u16; 3] {
        core::array::from_fn(|k| {
            let part = if size[k] > 0.0 { (vertex[k] - low[k]) / size[k] } else { 0.0 };
            (part * f64::from(u16::MAX)).round() as u16
        })
    };
    let vertices = mesh.vertices.iter().flat_map(place).flat_map(u16::to_le_bytes);
    let faces = mesh.faces.iter().flatten().flat_map(|&corner| (corner as u32).to_le_bytes());
    out.push('{');
    lengths(out, "low", &low);
    lengths(out, "size", &size);
    key(out, "vertices");
    base64(out, vertices);
    key(out, "faces");
    base64(out, faces);
    out.push('}');
}

/// Writes bytes as a text in base 64.
fn base64(out: &mut String, bytes: impl IntoIterator<Item = u8>) {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bytes: Vec<u8> = bytes.into_iter().collect();
    out.push('"');
    for group in bytes.chunks(3) {
        let bits = (0..3).fold(0, |bits, i| bits << 8 | u32::from(*group.get(i).unwrap_or(&0)));
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize];
            out.push(if i <= group.len() { char::from(digit) } else { '=' });
        }
    }
    out.push('"');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_64_is_that_of_rfc_4648() {
        for (bytes, expected) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("foobar", "Zm9vYmFy"),
        ] {
            let mut out = String::new();
            base64(&mut out, bytes.bytes());
            assert_eq!(out, format!("\"{expected}\""));
        }
    }
}
