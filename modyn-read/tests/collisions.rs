//! The `<collision>`s of URDF and SDF touch the ground as the geoms of the same robot in an MJCF do.

use modyn_read::diagnostics::{Code, Diagnostics};
use modyn_read::{Base, Contact, ContactKind, FileStore, Ground, LoopEnd, ReadOptions, Reading};
use modyn_runtime::equations::TimeStepInput;
use modyn_runtime::equations::soft_constraints::StepInput;
use modyn_runtime::model::{ContactShape, Model, TouchingShape};
use modyn_runtime::{Interpreter, StepSolutionOutputs};

/// A tilted plane.
const TILTED: ([f64; 3], [f64; 3]) = ([0.3, -0.2, -0.4], [0.2, 0.6, 1.7]);

/// A mesh of a tetrahedron with a point inside.
const OBJ: &str = "v 0 0 0\nv 0.1 0 0\nv 0 0.2 0\nv 0 0 0.3\nv 0.01 0.01 0.01\n\
                   f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 1 2 5\n";

/// The shapes of a floating link, of a link on a joint, and of a link that is fixed to that link.
const URDF: &str = r#"<robot name="r">
  <link name="trunk">
    <inertial><origin xyz="0.01 0.02 0.03"/><mass value="2"/><inertia ixx="0.2" iyy="0.3" izz="0.25" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision name="hull"><origin xyz="0.1 0.2 0.3" rpy="0.3 -0.4 0.5"/><geometry><box size="0.2 0.4 0.6"/></geometry></collision>
    <collision><origin xyz="-0.1 0.1 0.2"/><geometry><sphere radius="0.2"/></geometry></collision>
    <collision><origin rpy="1 0.2 0.1"/><geometry><cylinder radius="0.1" length="0.4"/></geometry></collision>
  </link>
  <joint name="hip" type="continuous"><parent link="trunk"/><child link="leg"/><origin xyz="0.2 0 -0.3" rpy="0.1 0.2 0.3"/><axis xyz="0 1 0"/></joint>
  <link name="leg">
    <inertial><origin xyz="0 0 -0.1"/><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 -0.2" rpy="0.2 0.7 -0.1"/><geometry><capsule radius="0.1" length="0.4"/></geometry></collision>
  </link>
  <joint name="ankle" type="fixed"><parent link="leg"/><child link="foot"/><origin xyz="0.05 0 -0.4" rpy="0.3 0.1 0.2"/></joint>
  <link name="foot">
    <collision><origin xyz="0.1 0 0" rpy="0 0.3 0"/><geometry><mesh filename="part.obj" scale="1 2 -1"/></geometry></collision>
  </link>
</robot>"#;

/// The same robot.
const MJCF: &str = r#"<mujoco model="r"><compiler angle="radian" eulerseq="XYZ"/>
  <asset><mesh name="part" file="part.obj" scale="1 2 -1" inertia="exact"/></asset>
  <worldbody>FLOOR<body name="trunk"><freejoint name="floating_base" align="false"/>
    <inertial pos="0.01 0.02 0.03" mass="2" diaginertia="0.2 0.3 0.25"/>
    <geom name="hull" type="box" pos="0.1 0.2 0.3" euler="0.3 -0.4 0.5" size="0.1 0.2 0.3"/>
    <geom name="trunk_collision_1" pos="-0.1 0.1 0.2" size="0.2"/>
    <geom name="trunk_collision_2" type="cylinder" euler="1 0.2 0.1" size="0.1 0.2"/>
    <body name="leg" pos="0.2 0 -0.3" euler="0.1 0.2 0.3"><joint name="hip" axis="0 1 0"/>
      <inertial pos="0 0 -0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
      <geom name="leg_collision_1" type="capsule" pos="0 0 -0.2" euler="0.2 0.7 -0.1" size="0.1 0.2"/>
      <body name="foot" pos="0.05 0 -0.4" euler="0.3 0.1 0.2">
        <geom name="foot_collision_1" type="mesh" mesh="part" pos="0.1 0 0" euler="0 0.3 0" mass="0"/>
      </body>
    </body>
  </body></worldbody>
</mujoco>"#;

/// The same robot in a world with a static plane. The foot is a frame of the leg.
const SDF: &str = r#"<sdf version="1.9"><world name="w"><gravity>0 0 -9.81</gravity>
  <model name="plane"><static>true</static><pose>0.1 0.2 0.3 0.4 0.5 0.6</pose>
    <link name="leg"><pose>-0.1 0.3 -0.2 0.2 0.1 0.3</pose><collision name="c">
      <pose>0.2 -0.5 0.1 0.1 -0.3 0.2</pose><geometry><plane><normal>0.2 0.6 1.7</normal><size>9 9</size></plane></geometry>
      <surface><friction><ode><mu>100</mu><mu2>50</mu2></ode></friction></surface></collision></link></model>
  <model name="r">
    <link name="trunk">
      <inertial><pose>0.01 0.02 0.03 0 0 0</pose><mass>2</mass><inertia><ixx>0.2</ixx><iyy>0.3</iyy><izz>0.25</izz></inertia></inertial>
      <collision name="hull"><pose>0.1 0.2 0.3 0.3 -0.4 0.5</pose><geometry><box><size>0.2 0.4 0.6</size></box></geometry></collision>
      <collision name="trunk_collision_1"><pose>-0.1 0.1 0.2 0 0 0</pose><geometry><sphere><radius>0.2</radius></sphere></geometry></collision>
      <collision name="trunk_collision_2"><pose>0 0 0 1 0.2 0.1</pose>
        <geometry><cylinder><radius>0.1</radius><length>0.4</length></cylinder></geometry></collision>
      <collision name="none"><geometry><empty/></geometry></collision>
    </link>
    <joint name="hip" type="continuous"><parent>trunk</parent><child>leg</child><axis><xyz>0 1 0</xyz></axis></joint>
    <link name="leg"><pose relative_to="trunk">0.2 0 -0.3 0.1 0.2 0.3</pose>
      <inertial><pose>0 0 -0.1 0 0 0</pose><mass>1</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>
      <collision name="leg_collision_1"><pose>0 0 -0.2 0.2 0.7 -0.1</pose>
        <geometry><capsule><radius>0.1</radius><length>0.4</length></capsule></geometry></collision>
      <collision name="foot_collision_1"><pose relative_to="foot">0.1 0 0 0 0.3 0</pose>
        <geometry><mesh><uri>part.obj</uri><scale>1 2 -1</scale></mesh></geometry></collision>
    </link>
    <frame name="foot" attached_to="leg"><pose relative_to="leg">0.05 0 -0.4 0.3 0.1 0.2</pose></frame>
  </model></world></sdf>"#;

/// Returns a folder in memory that has the mesh.
fn options(ground: Option<Ground>, base: Base) -> ReadOptions {
    let files = FileStore::in_memory([("part.obj".into(), OBJ.into())]);
    ReadOptions { folder: Some("".into()), files, ground, base, ..ReadOptions::default() }
}

fn read(text: &str, file: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    modyn_read::read(text, file, options)
}

/// Returns the model of a floating robot without warnings.
fn floating(text: &str, file: &str, ground: Option<Ground>) -> Model {
    let base = if file.ends_with("urdf") { Base::Floating } else { Base::Auto };
    let reading = read(text, file, &options(ground, base)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(reading.warnings, [], "{file}");
    reading.model
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}

/// The numbers of a shape on the body that moves its link.
fn on_body(model: &Model, shape: &TouchingShape) -> Vec<f64> {
    let frame = &model.links()[shape.end.link];
    let pose = frame.pose.compose(&shape.end.pose);
    let mut numbers = vec![frame.moving_link.expect("a link that moves") as f64];
    numbers.extend(pose.rotation.as_flattened());
    numbers.extend(pose.translation);
    numbers.extend(shape.shape.numbers());
    numbers.extend(shape.surface.numbers());
    numbers
}

fn assert_same_shapes(a: &Model, b: &Model) {
    let [first, second] = [a, b].map(Model::touching_shapes);
    assert_eq!(first.len(), second.len());
    for (x, y) in first.iter().zip(&second) {
        assert_eq!((&x.name, x.components, x.power), (&y.name, y.components, y.power));
        assert_eq!(core::mem::discriminant(&x.shape), core::mem::discriminant(&y.shape));
        let numbers = [on_body(a, x), on_body(b, y)];
        assert!(close(&numbers[0], &numbers[1]), "{x:?}\n{y:?}");
    }
}

/// Returns the velocities after a step of a robot that lies on the ground, and the forces.
fn step(model: &Model) -> [Vec<f64>; 2] {
    let q = [0.02, 0.01, -0.3, 0.1, 0.2, -0.1, 0.97, 0.4];
    let norm: f64 = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
    let q: Vec<f64> = q
        .iter()
        .enumerate()
        .map(|(i, x)| if (3..7).contains(&i) { x / norm } else { *x })
        .collect();
    let qd = [0.1, -0.2, 0.3, 0.2, -0.3, -0.5, 0.7];
    let points: usize = model.touching_shapes().iter().map(|shape| shape.shape.points()).sum();
    let [mut next, mut velocities, mut qdd] = [vec![0.0; 8], vec![0.0; 7], vec![0.0; 7]];
    let mut forces = vec![0.0; 3 * points];
    let outputs = StepSolutionOutputs {
        q: &mut next,
        qd: &mut velocities,
        qdd: &mut qdd,
        forces: &mut forces,
        residual: &mut 0.0,
        iterations: &mut 0.0,
    };
    let step = TimeStepInput { q: &q, qd: &qd, tau: &[0.0; 7], dt: 0.002 };
    let input = StepInput { step, warm_start: &[0.0; 7] };
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    interpreter.step(input, &model.step_settings(), outputs).expect("lengths");
    [velocities, forces]
}

#[test]
fn shapes_of_each_format_touch_the_ground_of_the_options_as_a_plane_of_the_world() {
    let (point, normal) = TILTED;
    let ground = Some(Ground::plane(point, normal));
    let [a, b, c] = point;
    let [x, y, z] = normal;
    let floor =
        format!(r#"<geom type="plane" size="0 0 1" pos="{a} {b} {c}" zaxis="{x} {y} {z}"/>"#);
    let scene = floating(&MJCF.replace("FLOOR", &floor), "r.xml", None);
    let urdf = floating(URDF, "r.urdf", ground);
    let mjcf = floating(&MJCF.replace("FLOOR", ""), "r.xml", ground);
    assert_eq!(scene.touching_shapes().len(), 5);
    let [expected, forces] = step(&scene);
    assert!(forces.iter().any(|force| *force > 1.0), "{forces:?}");
    for model in [&urdf, &mjcf] {
        assert_same_shapes(model, &scene);
        let [velocities, pushes] = step(model);
        assert!(close(&velocities, &expected) && pushes.len() == forces.len(), "{velocities:?}");
    }
}

/// The plane of a static model is the ground, wherever its model, link and collision are.
#[test]
fn planes_of_static_models_are_the_ground() {
    let sdf = floating(SDF, "r.sdf", None);
    let plane = sdf.touching_shapes()[0].surface.plane;
    // The poses of the model, the link and the collision, each about the frame before.
    let poses = [
        ([0.1, 0.2, 0.3], [0.4, 0.5, 0.6]),
        ([-0.1, 0.3, -0.2], [0.2, 0.1, 0.3]),
        ([0.2, -0.5, 0.1], [0.1, -0.3, 0.2]),
    ];
    let [mut point, mut normal] = [[0.0; 3], TILTED.1];
    for (xyz, rpy) in poses.into_iter().rev() {
        [point, normal] = [point, normal].map(|vector| rotated(vector, rpy));
        point = core::array::from_fn(|k| point[k] + xyz[k]);
    }
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    let unit = normal.map(|x| x / length);
    assert!(close(&plane.rotation.map(|row| row[2]), &unit), "{plane:?}");
    let height: f64 = (0..3).map(|k| unit[k] * (plane.translation[k] - point[k])).sum();
    assert!(height.abs() < 1e-12, "{height}");
    let urdf = floating(URDF, "r.urdf", Some(Ground::plane(point, normal)));
    let level: Vec<TouchingShape> = sdf.touching_shapes();
    for (a, b) in level.iter().zip(urdf.touching_shapes()) {
        assert_eq!((&a.name, a.surface.friction), (&b.name, 1.0));
        let [x, y] = [on_body(&sdf, a), on_body(&urdf, &b)];
        // The points of the planes differ, not the planes.
        let numbers = x.len() - 23;
        assert!(close(&x[numbers + 12..], &y[numbers + 12..]), "{a:?}\n{b:?}");
        assert!(close(&x[..numbers + 9], &y[..numbers + 9]), "{a:?}\n{b:?}");
    }
    // The foot of the URDF is a link with a mobility of its own; the foot of the SDF is the leg.
    let foot = r#"<collision><origin xyz="0.1 0 0" rpy="0 0.3 0"/>"#;
    let urdf = URDF.replace(foot, "<visual>");
    let urdf = urdf.replace("</collision>\n  </link>\n</robot>", "</visual></link></robot>");
    let mesh = "<mesh><uri>part.obj</uri><scale>1 2 -1</scale></mesh>";
    let sdf = floating(&SDF.replace(mesh, "<empty/>"), "r.sdf", None);
    let urdf = floating(&urdf, "r.urdf", Some(Ground::plane(point, normal)));
    assert_eq!((sdf.touching_shapes().len(), urdf.touching_shapes().len()), (4, 4));
    // Other points of the plane give other rounding errors, up to the tolerance of the solver.
    let [[expected, _], [velocities, _]] = [&urdf, &sdf].map(step);
    let mut pairs = velocities.iter().zip(&expected);
    assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-6), "{velocities:?} {expected:?}");
}

/// Returns a vector rotated about x, then y, then z.
fn rotated([x, y, z]: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> [f64; 3] {
    let [y, z] = [roll.cos() * y - roll.sin() * z, roll.sin() * y + roll.cos() * z];
    let [x, z] = [pitch.cos() * x + pitch.sin() * z, pitch.cos() * z - pitch.sin() * x];
    [yaw.cos() * x - yaw.sin() * y, yaw.sin() * x + yaw.cos() * y, z]
}

/// Returns the names and the frictions of the shapes of the SDF, and the warnings, with texts
/// replaced.
fn touching_sdf(
    replaced: &[(&str, &str)],
    ground: Option<Ground>,
) -> (Vec<(String, f64)>, Vec<String>) {
    let text = replaced.iter().fold(SDF.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    });
    let reading = read(&text, "r.sdf", &options(ground, Base::Auto));
    let reading = reading.unwrap_or_else(|error| panic!("{error}"));
    let shapes = reading.model.touching_shapes().into_iter();
    let messages = reading.warnings.into_iter().map(|warning| warning.message);
    (shapes.map(|shape| (shape.name, shape.surface.friction)).collect(), messages.collect())
}

/// The plane of the SDF, which is a robot without ground then.
const NO_PLANE: (&str, &str) =
    ("<plane><normal>0.2 0.6 1.7</normal><size>9 9</size></plane>", "<empty/>");

#[test]
fn the_surface_of_an_sdf_decides_about_friction_and_what_touches() {
    let surface = |inside: &str| format!("</geometry><surface>{inside}</surface></collision>");
    let hull = r#"</geometry></collision>
      <collision name="trunk_collision_1">"#;
    let with = |inside: &str| {
        let to = surface(inside) + r#"<collision name="trunk_collision_1">"#;
        touching_sdf(&[(hull, &to)], None)
    };
    let ode = |mu: &str| format!("<friction><ode>{mu}</ode></friction>");
    let (shapes, messages) = with(&ode("<mu>0.4</mu><mu2>0.4</mu2>"));
    let frictions: Vec<f64> = shapes.iter().map(|(_, friction)| *friction).collect();
    assert_eq!((frictions, messages), (vec![0.4, 1.0, 1.0, 1.0, 1.0], vec![]));
    let drake = "</geometry><drake:proximity_properties><drake:mu_dynamic>0.2</drake:mu_dynamic>\
                 </drake:proximity_properties></collision><collision name=\"trunk_collision_1\">";
    let (shapes, messages) =
        touching_sdf(&[("<sdf ", "<sdf xmlns:drake='http://drake.mit.edu' "), (hull, drake)], None);
    assert_eq!((shapes[0].1, shapes[1].1, messages), (0.2, 1.0, vec![]));
    // The plane has 100 and 50.
    assert_eq!(with(&ode("<mu>1.5</mu><mu2>1.5</mu2>")).0[0].1, 1.5);
    // A large coefficient is bounded.
    let (shapes, messages) = with(&ode("<mu>40</mu><mu2>inf</mu2>"));
    assert_eq!(shapes[0].1, 2.0);
    assert!(messages.iter().any(|one| one.contains("above 2 is 2")), "{messages:?}");
    for (inside, part) in [
        (ode("<mu>0.4</mu>"), "friction `<mu>` in all directions"),
        (
            "<bounce><restitution_coefficient>0.1</restitution_coefficient></bounce>".into(),
            "`<bounce>`",
        ),
        (
            "<friction><torsional><patch_radius>0.1</patch_radius></torsional></friction>".into(),
            "`<torsional>`",
        ),
    ] {
        let (shapes, messages) = with(&inside);
        assert_eq!(shapes.len(), 5);
        assert!(messages.len() == 1 && messages[0].contains(part), "{part}: {messages:?}");
    }
    for inside in [
        "<contact><collide_without_contact>true</collide_without_contact></contact>",
        "<contact><collide_bitmask>65536</collide_bitmask></contact>",
    ] {
        let (shapes, messages) = with(inside);
        assert_eq!((shapes.len(), &*shapes[0].0, messages.len()), (4, "trunk_collision_1", 0));
    }
    // A friction of zero and torsional friction without a radius have no effect.
    let idle = "<bounce/><friction><torsional><coefficient>1</coefficient></torsional></friction>";
    assert_eq!(with(idle).1, [""; 0]);
}

#[test]
fn an_sdf_touches_the_ground_of_the_options_unless_it_has_its_own() {
    let level = Ground::default();
    let (shapes, messages) = touching_sdf(&[NO_PLANE], Some(level));
    assert_eq!((shapes.len(), messages.len()), (5, 0));
    let (shapes, _) = touching_sdf(&[NO_PLANE], Some(level.with_friction(0.3)));
    assert!(shapes.iter().all(|(_, friction)| *friction == 0.3));
    assert!(touching_sdf(&[NO_PLANE], None).0.is_empty());
    let error = read(SDF, "r.sdf", &options(Some(level), Base::Auto)).expect_err("two");
    assert!(error.to_string().contains("the option `ground` adds a plane"), "{error}");
    // Two planes.
    let plane = r#"<collision name="d"><geometry><plane/></geometry></collision></link></model>"#;
    let (shapes, _) = touching_sdf(&[("</link></model>", plane)], None);
    let names: Vec<&str> = shapes.iter().take(4).map(|(name, _)| &**name).collect();
    assert_eq!(
        (shapes.len(), names),
        (10, vec!["hull", "hull_shape", "trunk_collision_1", "trunk_collision_1_shape"])
    );
    // Contacts replace the shapes.
    let end = LoopEnd { link: "leg".into(), xyz: [0.0; 3], rpy: [0.0; 3] };
    let contacts = vec![Contact { name: "toe".into(), kind: ContactKind::Point, end }];
    let given = ReadOptions { contacts, ..options(Some(level), Base::Auto) };
    let model = read(SDF, "r.sdf", &given).expect("a point on the ground of the options").model;
    assert_eq!(model.touching_shapes()[0].name, "toe");
}

/// An error in a collision counts where it would touch the ground.
#[test]
fn collisions_of_an_sdf_are_checked_where_they_touch() {
    let sphere = "<sphere><radius>0.2</radius></sphere>";
    for (from, to, part) in [
        (sphere, "<torus/>", "contacts of a `<torus>` are not computed"),
        (sphere, "<plane/>", "it is a `<plane>` that moves"),
        ("part.obj", "none.obj", "its geometry has the file `none.obj`, which is not found"),
        ("<uri>part.obj</uri>", "", "its `<mesh>` has no `<uri>`"),
    ] {
        let (shapes, messages) = touching_sdf(&[(from, to)], None);
        assert!(shapes.len() == 4 && messages.len() == 1, "{part}: {messages:?}");
        assert!(messages[0].contains(part), "{part}: {messages:?}");
        assert_eq!(touching_sdf(&[NO_PLANE, (from, to)], None).1, [""; 0]);
    }
    for (from, to, part) in [
        (sphere, "<sphere/>", "the lengths of the `<sphere>` are not numbers above 0"),
        ("<pose>-0.1 0.1 0.2 0 0 0</pose>", "<pose>a 0.1 0.2 0 0 0</pose>", "`a` is not a number"),
        (r#"relative_to="foot""#, r#"relative_to="toes""#, "the frame `toes` does not exist here"),
        ("<geometry><empty/></geometry>", "", "`<collision>` has no `<geometry>`"),
        (
            "<normal>0.2 0.6 1.7</normal>",
            "<normal>0 0 0</normal>",
            "the normal of a `<plane>` is zero",
        ),
        ("<mu>100</mu>", "<mu>-1</mu>", "`<mu>` is negative"),
    ] {
        let text = SDF.replacen(from, to, 1);
        let error = read(&text, "r.sdf", &options(None, Base::Auto)).expect_err(part).to_string();
        assert!(error.contains(part), "{part}: {error}");
        if from.contains("mu") || from.contains("normal") {
            continue;
        }
        let without = text.replacen(NO_PLANE.0, NO_PLANE.1, 1);
        assert!(read(&without, "r.sdf", &options(None, Base::Auto)).is_ok(), "{part}");
    }
}

/// The mesh has three points that are not on its hull.
#[test]
fn a_mesh_touches_by_the_corners_of_its_hull() {
    let model = floating(URDF, "r.urdf", Some(Ground::default()));
    let shape = model.touching_shapes().pop().expect("a shape");
    let ContactShape::Points(mut corners) = shape.shape else { panic!("{shape:?}") };
    corners.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    let expected = [[0.0, 0.0, -0.3], [0.0, 0.0, 0.0], [0.0, 0.4, 0.0], [0.1, 0.0, 0.0]];
    // An OBJ has single precision.
    let mut pairs = corners.as_flattened().iter().zip(expected.as_flattened());
    assert!(corners.len() == 4 && pairs.all(|(a, b)| (a - b).abs() < 1e-7), "{corners:?}");
}

#[test]
fn without_ground_or_with_contacts_no_shape_is_read() {
    // A mesh that does not exist is no warning where its shape touches nothing.
    let text = URDF.replace("part.obj", "none.obj");
    let mut without = options(None, Base::Floating);
    let reading = read(&text, "r.urdf", &without).expect("read");
    assert!(reading.model.touching_shapes().is_empty() && reading.warnings.is_empty());
    let end = LoopEnd { link: "foot".into(), xyz: [0.0; 3], rpy: [0.0; 3] };
    without.contacts = vec![Contact { name: "toe".into(), kind: ContactKind::Point, end }];
    let level = read(&text, "r.urdf", &without).expect("read").model;
    let given = ReadOptions {
        ground: Some(Ground::plane([0.0, 0.0, 0.2], [0.0, 0.0, 3.0]).with_friction(0.3)),
        ..without
    };
    let reading = read(&text, "r.urdf", &given).expect("read");
    assert_eq!(reading.warnings, []);
    let [on_level, on_given] =
        [&level, &reading.model].map(|model| model.touching_shapes().remove(0));
    assert_eq!((&*on_given.name, on_given.shape), ("toe", ContactShape::Point));
    assert_eq!(on_level.surface.plane.translation, [0.0; 3]);
    assert_eq!((on_given.surface.plane.translation[2], on_given.surface.friction), (0.2, 0.3));
    assert_eq!(on_given.surface.plane.rotation[2], [0.0, 0.0, 1.0]);
}

/// Shapes of links that do not move touch nothing, and their meshes are not read.
#[test]
fn links_that_do_not_move_touch_nothing() {
    let text = URDF.replace(r#"<box size="0.2 0.4 0.6"/>"#, r#"<mesh filename="none.obj"/>"#);
    let reading = read(&text, "r.urdf", &options(Some(Ground::default()), Base::Auto));
    let Reading { model, warnings, .. } = reading.expect("read");
    let names: Vec<String> = model.touching_shapes().into_iter().map(|shape| shape.name).collect();
    assert_eq!(names, ["leg_collision_1", "foot_collision_1"]);
    assert_eq!(warnings, []);
}

/// Returns the friction of the shapes and the warnings, with elements added to the robot.
fn frictions(extensions: &str, ground: Ground) -> (Vec<f64>, Vec<String>) {
    let text = URDF.replace("</robot>", &format!("{extensions}</robot>"));
    let reading = read(&text, "r.urdf", &options(Some(ground), Base::Floating)).expect("read");
    let shapes = reading.model.touching_shapes().into_iter();
    let messages = reading.warnings.into_iter().map(|warning| warning.message);
    (shapes.map(|shape| shape.surface.friction).collect(), messages.collect())
}

#[test]
fn friction_is_that_of_gazebo_unless_the_ground_has_one() {
    let given = r#"<gazebo reference="foot"><mu1 value="0.6"/><mu2>0.6</mu2></gazebo>
        <gazebo reference="leg"><mu1>0.3</mu1></gazebo><gazebo reference="leg"><mu2>0.3</mu2></gazebo>"#;
    assert_eq!(frictions(given, Ground::default()), (vec![1.0, 1.0, 1.0, 0.3, 0.6], vec![]));
    assert_eq!(frictions(given, Ground::default().with_friction(0.8)).0, [0.8; 5]);
    // Drake's friction is of one shape, and PyBullet's of a link.
    let drake = "<drake:proximity_properties><drake:mu_dynamic value=\"0.2\"/></drake:proximity_properties>";
    let contact = "<contact><lateral_friction value=\"0.7\"/></contact>";
    let text = URDF
        .replace("<robot ", "<robot xmlns:drake='http://drake.mit.edu' ")
        .replacen("</collision>", &format!("{drake}</collision>"), 1)
        .replacen("</inertial>", &format!("</inertial>{contact}"), 1);
    let ground = options(Some(Ground::default()), Base::Floating);
    let shapes = read(&text, "r.urdf", &ground).expect("read").model.touching_shapes();
    let coefficients: Vec<f64> = shapes.iter().map(|shape| shape.surface.friction).collect();
    assert_eq!(coefficients, [0.2, 0.7, 0.7, 1.0, 1.0]);
    let uneven = r#"<gazebo reference="foot"><mu1>0.6</mu1></gazebo>"#;
    let rough = r#"<gazebo reference="foot"><mu1>1e15</mu1><mu2>1e15</mu2></gazebo>"#;
    let (coefficients, messages) = frictions(rough, Ground::default());
    assert_eq!(coefficients, [1.0, 1.0, 1.0, 1.0, 2.0]);
    assert!(messages.len() == 1 && messages[0].contains("above 2 is 2"), "{messages:?}");
    let (coefficients, messages) = frictions(uneven, Ground::default());
    assert_eq!(coefficients, [1.0, 1.0, 1.0, 1.0, 0.6]);
    assert!(
        messages.len() == 1 && messages[0].contains("`<mu1>` in all directions"),
        "{messages:?}"
    );
}

#[test]
fn shapes_that_do_not_touch_are_named_and_wrong_ones_refused() {
    let ground = options(Some(Ground::default()), Base::Floating);
    for (from, to, part) in [
        ("part.obj", "none.obj", "its geometry has the file `none.obj`, which is not found"),
        (r#"<sphere radius="0.2"/>"#, "<torus/>", "contacts of a `<torus>` are not computed"),
        (r#"<geometry><sphere radius="0.2"/></geometry>"#, "<geometry/>", "`<geometry>` is empty"),
    ] {
        let reading = read(&URDF.replace(from, to), "r.urdf", &ground).expect(part);
        let [warning] = &reading.warnings[..] else { panic!("{:?}", reading.warnings) };
        assert!(warning.message.contains(part), "{part}: {warning}");
        assert!(warning.position.is_some() && warning.code == Code::NotRead, "{warning}");
        assert_eq!(reading.model.touching_shapes().len(), 4);
    }
    let wrong = r#"<gazebo reference="foot"><mu1>-1</mu1></gazebo></robot>"#;
    for (from, to, part) in [
        (
            r#"radius="0.2""#,
            r#"radius="nan""#,
            "the lengths of the `<sphere>` are not numbers above 0",
        ),
        (r#"<box size="0.2 0.4 0.6"/>"#, "<box/>", "the lengths of the `<box>`"),
        (r#"rpy="1 0.2 0.1""#, r#"rpy="1 0.2""#, "3 numbers are needed"),
        (r#"<geometry><sphere radius="0.2"/></geometry>"#, "", "`<collision>` has no `<geometry>`"),
        ("</robot>", wrong, "`<mu1>` is -1"),
    ] {
        let error =
            read(&URDF.replacen(from, to, 1), "r.urdf", &ground).expect_err(part).to_string();
        assert!(error.contains(part), "{part}: {error}");
        assert!(
            read(&URDF.replacen(from, to, 1), "r.urdf", &options(None, Base::Floating)).is_ok()
        );
    }
    let sphere = "<collision><geometry><sphere radius=\"1\"/></geometry></collision>";
    let many = URDF.replacen(
        r#"<link name="leg">"#,
        &format!("<link name=\"leg\">{}", sphere.repeat(1001)),
        1,
    );
    let error = read(&many, "r.urdf", &ground).expect_err("too many").to_string();
    assert!(error.contains("more than 1000 shapes touch the ground"), "{error}");
}

#[test]
fn a_ground_is_checked() {
    let level = [0.0, 0.0, 1.0];
    for (ground, part) in [
        (Ground::plane([f64::NAN, 0.0, 0.0], level), "a number of the ground is not finite"),
        (
            Ground::plane([0.0; 3], [0.0, f64::INFINITY, 0.0]),
            "a number of the ground is not finite",
        ),
        (Ground::plane([0.0; 3], [0.0; 3]), "the normal of the ground is zero"),
        (Ground::default().with_friction(-0.1), "the friction of the ground"),
        (Ground::default().with_friction(f64::NAN), "the friction of the ground"),
    ] {
        let error = read(URDF, "r.urdf", &options(Some(ground), Base::Floating)).expect_err(part);
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn ground_that_touches_nothing_is_a_warning_and_a_second_floor_an_error() {
    let text = URDF.replace("collision", "visual");
    let reading = read(&text, "r.urdf", &options(Some(Ground::default()), Base::Floating));
    let warnings = reading.expect("read").warnings;
    assert!(
        warnings.len() == 1 && warnings[0].message.contains("nothing touches the ground"),
        "{warnings:?}"
    );
    let floor = r#"<geom name="floor" type="plane" size="0 0 1" MASK/>"#;
    let scene = |mask: &str| MJCF.replace("FLOOR", &floor.replace("MASK", mask));
    let given = options(Some(Ground::default()), Base::Auto);
    let error = read(&scene(""), "r.xml", &given).expect_err("two floors").to_string();
    assert!(error.contains("the option `ground` adds a plane, and the file has one"), "{error}");
    let drawn = scene(r#"contype="0" conaffinity="0""#);
    let model = read(&drawn, "r.xml", &given).expect("a floor that is drawn").model;
    assert_eq!(model.touching_shapes().len(), 5);
}

/// The friction of the ground replaces the mixture, and masks and exclusions hold.
#[test]
fn geoms_touch_the_ground_of_the_options_by_their_laws() {
    let given = |ground| {
        let text = MJCF.replace("FLOOR", "").replace(
            r#"<geom name="hull""#,
            r#"<geom name="hull" friction="1.4 0.1" condim="4" margin="0.1""#,
        );
        let text = text
            .replace(r#"<geom name="trunk_collision_1""#, r#"<geom contype="0" conaffinity="2""#);
        let exclude = r#"<contact><exclude body1="world" body2="leg"/></contact></mujoco>"#;
        floating(&text.replace("</mujoco>", exclude), "r.xml", Some(ground)).touching_shapes()
    };
    let shapes = given(Ground::default());
    let names: Vec<&str> = shapes.iter().map(|shape| &*shape.name).collect();
    assert_eq!(names, ["hull", "trunk_collision_2", "foot_collision_1"]);
    let surface = shapes[0].surface;
    assert_eq!((surface.friction, surface.torsional_friction, surface.margin), (1.4, 0.1, 0.1));
    let shapes = given(Ground::default().with_friction(0.7));
    assert!(shapes.iter().all(|shape| shape.surface.friction == 0.7), "{shapes:?}");
}
