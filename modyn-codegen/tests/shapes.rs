//! The shapes of links: the same robot in each format has the same ones.

use std::sync::atomic::{AtomicUsize, Ordering};

use modyn_codegen::{Geometry, ReadOptions, Shape, Shapes, read};

/// A tetrahedron, as an object of an OBJ and as a text of STL.
const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.3]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn stl() -> String {
    let corner = |i: &usize| {
        let [x, y, z] = CORNERS[*i];
        format!("vertex {x} {y} {z}\n")
    };
    let facet = |face: &[usize; 3]| {
        let corners: String = face.iter().map(corner).collect();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid\n{}endsolid\n", FACES.iter().map(facet).collect::<String>())
}

/// Two objects, of which `MuJoCo` takes the mass of the first alone.
fn obj() -> String {
    let object = |first: usize| {
        let vertices = CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
        let face =
            |[a, b, c]: &[usize; 3]| format!("f {} {} {}\n", a + first, b + first, c + first);
        let faces = FACES.iter().map(face);
        format!("o part{first}\n{}", vertices.chain(faces).collect::<String>())
    };
    object(1) + &object(5)
}

/// Reads a description in a folder that has the meshes.
fn shapes(text: &str, file: &str) -> Shapes {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("modyn-shapes-{}-{number}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("part.stl"), stl()).expect("written");
    std::fs::write(folder.join("parts.obj"), obj()).expect("written");
    let options = ReadOptions { folder: Some(folder.clone()), ..ReadOptions::default() };
    let without = read(text, file, &options).expect("read");
    assert_eq!(without.shapes, Shapes::default());
    let with = read(text, file, &ReadOptions { shapes: true, ..options }).expect("read");
    assert_eq!((&with.model, &with.warnings), (&without.model, &without.warnings));
    assert_eq!(with.shapes.of_frames.len(), with.model.frames().len());
    std::fs::remove_dir_all(folder).expect("removed");
    with.shapes
}

/// Returns the shapes of the only link that has some.
fn only(shapes: &Shapes) -> &[Shape] {
    let mut some = shapes.of_frames.iter().filter(|shapes| !shapes.is_empty());
    let found = some.next().expect("shapes");
    assert!(some.next().is_none());
    found
}

const URDF: &str = r#"<robot name="arm">
  <material name="blue"><color rgba="0.1 0.2 0.8 1"/></material>
  <link name="base"/>
  <joint name="pivot" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>
  <link name="rod">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0.1 0.2 0.3" rpy="0.3 -0.4 0.5"/><geometry><box size="0.2 0.4 0.6"/></geometry><material name="blue"/></visual>
    <visual><geometry><sphere radius="0.2"/></geometry></visual>
    <visual><geometry><cylinder radius="0.1" length="0.4"/></geometry></visual>
    <visual><geometry><capsule radius="0.1" length="0.4"/></geometry></visual>
    <visual><geometry><mesh filename="part.stl" scale="1 2 -1"/></geometry></visual>
    <visual><geometry><mesh filename="parts.obj"/></geometry></visual>
  </link>
</robot>"#;

const SDF: &str = r#"<sdf version="1.9"><model name="arm">
  <link name="rod">
    <inertial><mass>1</mass></inertial>
    <visual name="a"><pose>0.1 0.2 0.3 0.3 -0.4 0.5</pose><geometry><box><size>0.2 0.4 0.6</size></box></geometry>
      <material><diffuse>0.1 0.2 0.8 1</diffuse></material></visual>
    <visual name="b"><geometry><sphere><radius>0.2</radius></sphere></geometry></visual>
    <visual name="c"><geometry><cylinder><radius>0.1</radius><length>0.4</length></cylinder></geometry></visual>
    <visual name="d"><geometry><capsule><radius>0.1</radius><length>0.4</length></capsule></geometry></visual>
    <visual name="e"><geometry><mesh><uri>part.stl</uri><scale>1 2 -1</scale></mesh></geometry></visual>
    <visual name="f"><geometry><mesh><uri>parts.obj</uri></mesh></geometry></visual>
    <visual name="g"><geometry><empty/></geometry></visual>
  </link>
  <joint name="pivot" type="continuous"><parent>world</parent><child>rod</child><axis><xyz>0 1 0</xyz></axis></joint>
</model></sdf>"#;

const MJCF: &str = r#"<mujoco model="arm">
  <compiler angle="radian" eulerseq="XYZ"/>
  <asset>
    <material name="blue" rgba="0.1 0.2 0.8 1"/>
    <mesh name="part" file="part.stl" scale="1 2 -1"/>
    <mesh name="parts" file="parts.obj"/>
  </asset>
  <worldbody><geom type="plane" size="1 1 1"/><body name="rod">
    <joint type="hinge" axis="0 1 0"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
    <geom type="box" pos="0.1 0.2 0.3" euler="0.3 -0.4 0.5" size="0.1 0.2 0.3" material="blue"/>
    <geom size="0.2"/>
    <geom type="cylinder" size="0.1 0.2"/>
    <geom type="capsule" size="0.1" fromto="0 0 0.2 0 0 -0.2"/>
    <geom type="mesh" mesh="part"/>
    <geom type="mesh" mesh="parts"/>
    <geom type="box" size="1 1 1" group="3"/>
  </body></worldbody>
</mujoco>"#;

#[test]
fn each_format_has_the_same_shapes() {
    let [urdf, sdf, mjcf] =
        [(URDF, "a.urdf"), (SDF, "a.sdf"), (MJCF, "a.xml")].map(|(text, file)| shapes(text, file));
    for shapes in [&urdf, &sdf, &mjcf] {
        assert_eq!(shapes.notes, [""; 0]);
        assert_eq!(only(shapes).len(), 6);
    }
    assert_eq!(only(&urdf), only(&sdf));
    let blue = Some([0.1, 0.2, 0.8, 1.0]);
    assert_eq!(only(&urdf).iter().map(|shape| shape.color).collect::<Vec<_>>(), {
        let mut colors = vec![blue];
        colors.resize(6, None);
        colors
    });
    assert_eq!(only(&mjcf)[0].color, blue);
    for (a, b) in only(&urdf).iter().zip(only(&mjcf)) {
        assert_eq!(a.geometry, b.geometry);
        assert_eq!(a.pose.translation, b.pose.translation);
        let numbers = |shape: &Shape| shape.pose.rotation.as_flattened().to_vec();
        assert!(
            numbers(a).iter().zip(numbers(b)).all(|(a, b)| (a - b).abs() < 1e-12),
            "{a:?} {b:?}"
        );
    }
    let Geometry::Mesh(part) = &only(&urdf)[4].geometry else { panic!("a mesh") };
    let Geometry::Mesh(parts) = &only(&urdf)[5].geometry else { panic!("a mesh") };
    assert_eq!((part.faces.len(), parts.faces.len()), (4, 8));
    // A mirrored mesh still has its triangles outwards: its volume is that of the tetrahedron, scaled.
    let volume: f64 = part
        .faces
        .iter()
        .map(|face| {
            let [a, b, c] = face.map(|corner| part.vertices[corner]);
            let cross =
                [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
            (0..3).map(|k| a[k] * cross[k]).sum::<f64>() / 6.0
        })
        .sum();
    assert!((volume - 2.0 * 0.1 * 0.2 * 0.3 / 6.0).abs() < 1e-8, "{volume}");
}

#[test]
fn a_rotated_shape_has_its_pose_in_the_frame_of_its_link() {
    let found = shapes(URDF, "a.urdf");
    let pose = &only(&found)[0].pose;
    // The point (0, 0, 1), rotated about x, then y, then z, each about the axes of the link.
    let (roll, pitch, yaw): (f64, f64, f64) = (0.3, -0.4, 0.5);
    let [x, y, z] = [0.0, -roll.sin(), roll.cos()];
    let [x, z] = [pitch.cos() * x + pitch.sin() * z, pitch.cos() * z - pitch.sin() * x];
    let [x, y] = [yaw.cos() * x - yaw.sin() * y, yaw.sin() * x + yaw.cos() * y];
    for (a, b) in pose.transform_point([0.0, 0.0, 1.0]).iter().zip([x + 0.1, y + 0.2, z + 0.3]) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

/// Nothing in a shape refuses a robot.
#[test]
fn shapes_that_cannot_be_read_are_notes() {
    let cases = [
        (
            r#"<box size="0.2 0.4 0.6"/>"#,
            r#"<box size="0.2 nan 0.6"/>"#,
            "is a `<box>` that cannot be drawn",
        ),
        (
            r#"<sphere radius="0.2"/>"#,
            r#"<sphere radius="-1"/>"#,
            "is a `<sphere>` that cannot be drawn",
        ),
        (r#"<sphere radius="0.2"/>"#, "<torus/>", "is a `<torus>` that cannot be drawn"),
        (r#"<geometry><sphere radius="0.2"/></geometry>"#, "", "has no `<geometry>`"),
        (
            r#"filename="part.stl""#,
            r#"filename="none.stl""#,
            "has the file `none.stl`, which is not found",
        ),
        (
            r#"filename="part.stl""#,
            r#"filename="package://none/part.dae""#,
            "has the file `package://none/part.dae`, which is not found",
        ),
        (
            r#"scale="1 2 -1""#,
            r#"scale="0 1 1""#,
            "has a `scale` that is not three numbers other than zero",
        ),
    ];
    for (sound, wrong, note) in cases {
        let text = URDF.replacen(sound, wrong, 1);
        assert_ne!(text, URDF);
        let found = shapes(&text, "a.urdf");
        assert_eq!(found.notes, [format!("a shape of the link `rod` {note}")], "{wrong}");
        assert_eq!(only(&found).len(), 5);
    }
}
