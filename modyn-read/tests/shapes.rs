//! The shapes of links: the same robot in each format has the same ones.

use std::sync::atomic::{AtomicUsize, Ordering};

use modyn_read::{Geometry, ReadOptions, Shape, Shapes, read};

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
    assert_eq!(with.shapes.of_frames.len(), with.model.links().len());
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

/// Each file is read once for each scale, and the shapes share its mesh.
#[test]
fn shapes_of_one_file_share_their_mesh() {
    let visual =
        r#"<visual><geometry><mesh filename="part.stl" scale="1 2 S"/></geometry></visual>"#;
    let visuals = visual.replace('S', "3").repeat(100) + &visual.replace('S', "4").repeat(100);
    let text = format!(
        "<robot name='r'><link name='a'/><link name='b'>{visuals}<inertial><mass value='1'/>\
         <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>\
         <joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint></robot>"
    );
    let found = shapes(&text, "a.urdf");
    let mesh = |shape: &Shape| match &shape.geometry {
        Geometry::Mesh(mesh) => mesh.clone(),
        other => panic!("{other:?}"),
    };
    let meshes: Vec<_> = only(&found).iter().map(mesh).collect();
    assert_eq!(meshes.len(), 200);
    for (i, mesh) in meshes.iter().enumerate() {
        assert!(std::sync::Arc::ptr_eq(mesh, &meshes[i / 100 * 100]), "{i}");
        let height = mesh.vertices.iter().map(|vertex| vertex[2]).fold(0.0, f64::max);
        assert!((height - if i < 100 { 0.9 } else { 1.2 }).abs() < 1e-6, "{i}: {height}");
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

/// The vertices and the faces of a mesh.
type Surface = (Vec<[f64; 3]>, Vec<[usize; 3]>);

/// Returns the surface of a COLLADA file.
fn collada(dae: &str) -> Option<Surface> {
    let text = r#"<robot name="r"><link name="a"/>
  <joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint>
  <link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="part.dae" scale="1 1 2"/></geometry></visual></link></robot>"#;
    let files = modyn_read::FileStore::in_memory([("part.dae".into(), dae.as_bytes().to_vec())]);
    let folder = Some("".into());
    let options = ReadOptions { folder, files, shapes: true, ..ReadOptions::default() };
    let shapes = read(text, "r.urdf", &options).expect("read").shapes;
    let shape = shapes.of_frames.iter().flatten().next()?;
    let Geometry::Mesh(mesh) = &shape.geometry else { panic!("{shape:?}") };
    Some((mesh.vertices.clone(), mesh.faces.clone()))
}

/// Returns six times the signed volume inside of triangles.
fn volume(vertices: &[[f64; 3]], faces: &[[usize; 3]]) -> f64 {
    let determinant = |face: &[usize; 3]| {
        let [a, b, c] = face.map(|i| vertices[i]);
        (0..3).map(move |i| {
            let (k, l) = ((i + 1) % 3, (i + 2) % 3);
            a[i] * (b[k] * c[l] - b[l] * c[k])
        })
    };
    faces.iter().flat_map(determinant).sum()
}

/// A tetrahedron of triangles and a box of quadrangles under transforms of nodes, one of which is a mirror, in tenths of a metre.
#[test]
fn collada_has_its_axes_unit_and_nodes() {
    let list = |points: &[[f64; 3]]| {
        let words: Vec<String> = points.as_flattened().iter().map(ToString::to_string).collect();
        words.join(" ")
    };
    let source = |name: &str, points: &[[f64; 3]]| {
        format!(
            "<source id=\"{name}\"><float_array id=\"{name}-a\" count=\"{}\">{}</float_array><technique_common>\
             <accessor source=\"#{name}-a\" count=\"{}\" stride=\"3\"/></technique_common></source>\
             <vertices id=\"{name}-v\"><input semantic=\"POSITION\" source=\"#{name}\"/></vertices>",
            3 * points.len(),
            list(points),
            points.len()
        )
    };
    let corners: Vec<[f64; 3]> = (0..8)
        .map(|i| [f64::from(i & 1), 2.0 * f64::from(i >> 1 & 1), 3.0 * f64::from(i >> 2)])
        .collect();
    // Corners have a normal before the vertex.
    let triangles: Vec<String> =
        FACES.iter().flatten().map(|corner| format!("7 {corner}")).collect();
    let dae = |up: &str, pieces: &str| {
        format!(
            "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\
             <asset><unit name=\"decimeter\" meter=\"0.1\"/><up_axis>{up}</up_axis></asset>\
             <library_geometries><geometry id=\"tetra\"><mesh>{}<triangles count=\"4\"><input semantic=\"NORMAL\" offset=\"0\" source=\"#n\"/>\
             <input semantic=\"VERTEX\" offset=\"1\" source=\"#t-v\"/><p>{}</p></triangles></mesh></geometry>\
             <geometry id=\"box\"><mesh>{}<polylist count=\"6\"><input semantic=\"VERTEX\" offset=\"0\" source=\"#b-v\"/>\
             <vcount>4 4 4 4 4 4</vcount><p>0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5</p></polylist></mesh></geometry></library_geometries>\
             <library_nodes><node id=\"inner\"><matrix>1 0 0 10 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url=\"#tetra\"/></node></library_nodes>\
             <library_visual_scenes><visual_scene id=\"s\">{pieces}</visual_scene></library_visual_scenes>\
             <scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>",
            source("t", &CORNERS),
            triangles.join(" "),
            source("b", &corners)
        )
    };
    let mirrored = "<node><translate>1 2 3</translate><rotate>1 1 1 120</rotate><scale>2 1 -1</scale><instance_node url=\"#inner\"/></node>";
    let (vertices, faces) = collada(&dae("Y_UP", mirrored)).expect("a mesh");
    // The third of a turn permutes the axes. The URDF doubles z.
    let expected = CORNERS.map(|[x, y, z]| {
        let [x, y, z] =
            [1.0 - z, 2.0 + 2.0 * (x + 10.0), 3.0 + y].map(|length: f64| -> f64 { length / 10.0 });
        [x, -z, 2.0 * y]
    });
    for (found, expected) in vertices.iter().zip(expected) {
        assert!(
            found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12),
            "{found:?} {expected:?}"
        );
    }
    let tetra = 0.1 * 0.2 * 0.3;
    assert!((volume(&vertices, &faces) - 2.0 * 2.0 * tetra / 1000.0).abs() < 1e-12);
    // A rotation in general position keeps the volume; the diagonal of the box keeps its length before the doubling.
    let tilted = "<node><rotate>0.48 0.6 0.64 50</rotate><node><rotate>0 0 2 -20</rotate><instance_geometry url=\"#box\"/></node></node>";
    for up in ["X_UP", "Y_UP", "Z_UP"] {
        let (vertices, faces) = collada(&dae(up, tilted)).expect("a mesh");
        assert_eq!((vertices.len(), faces.len()), (8, 12));
        assert!((volume(&vertices, &faces) - 2.0 * 6.0 * 6.0 / 1000.0).abs() < 1e-12, "{up}");
        let diagonal: f64 = [1.0, 1.0, 0.5]
            .iter()
            .zip(0..)
            .map(|(s, k)| (s * (vertices[7][k] - vertices[0][k])).powi(2))
            .sum();
        assert!((diagonal - (1.0 + 4.0 + 9.0) / 100.0).abs() < 1e-12, "{up}");
    }
    // The axes to the right and upwards become x and z.
    for (up, right, upwards) in
        [("X_UP", "0 -1 0", "1 0 0"), ("Y_UP", "1 0 0", "0 1 0"), ("Z_UP", "1 0 0", "0 0 1")]
    {
        for (way, expected) in [(right, [0.1, 0.0, 0.0]), (upwards, [0.0, 0.0, 0.2])] {
            let moved = format!(
                "<node><translate>{way}</translate><instance_geometry url=\"#box\"/></node>"
            );
            let (vertices, _) = collada(&dae(up, &moved)).expect("a mesh");
            assert!(
                vertices[0].iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15),
                "{up} {way}: {:?}",
                vertices[0]
            );
        }
    }
    // Files that are not sound are left out, and nodes that contain themselves end.
    let sound = dae("Y_UP", mirrored);
    for (from, to) in [
        ("#inner", "#outer"),
        ("7 3", "7 4"),
        ("meter=\"0.1\"", "meter=\"x\""),
        ("Y_UP", "W_UP"),
        (
            "<instance_geometry url=\"#tetra\"/>",
            "<instance_node url=\"#inner\"/><instance_node url=\"#inner\"/>",
        ),
        ("</scene>", ""),
        ("120", "a"),
    ] {
        assert!(sound.contains(from), "{from}");
        assert_eq!(collada(&sound.replace(from, to)), None, "{from} {to}");
    }
}
