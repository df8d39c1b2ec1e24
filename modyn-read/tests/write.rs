//! Writing: a robot that was written and read again is the same robot, in both formats.

#[path = "../../tests/src/random.rs"]
#[allow(dead_code)] // Each test uses some of the robots.
mod random;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use modyn_read::diagnostics::{Code, Severity};
use modyn_read::{
    Base, Contact, Format, Ground, LoopEnd, ReadOptions, joints_without_inertia, read, write,
};
use modyn_runtime::model::{
    Contact as ModelContact, ContactKind, Integrator, Keyframe, LoopConstraint, LoopConstraintEnd,
    LoopConstraintKind, Model, SoftConstraints, TouchingShape,
};
use modyn_runtime::quantities::{Function, Sizes};
use modyn_runtime::{Interpreter, Pose};
use random::Random;

/// The functions that are compared, if the robot has them. Together they depend on all numbers of a description.
const COMPARED: [Function; 9] = [
    Function::InverseDynamics,
    Function::MassMatrix,
    Function::KineticEnergy,
    Function::PotentialEnergy,
    Function::CenterOfMass,
    Function::CentroidalMomentumRate,
    Function::ConstraintResidual,
    Function::ConstraintJacobian,
    Function::ConstraintJacobianDotQd,
];

/// Returns the options with which a robot that was written is read: those that its format has no words for.
fn options(model: &Model, format: Format) -> ReadOptions {
    let end = |link: &str| LoopEnd { link: link.into(), xyz: [0.0; 3], rpy: [0.0; 3] };
    let contacts = model.contacts().iter().filter(|_| format == Format::Mjcf);
    let contacts = contacts.map(|contact| Contact {
        name: contact.name.clone(),
        kind: contact.kind,
        end: end(&contact.name),
    });
    ReadOptions {
        gravity: Some(model.gravity()).filter(|_| format == Format::Urdf),
        joint_friction: Some(model.joint_friction()),
        unphysical_inertia: Severity::Warning,
        contacts: contacts.collect(),
        ..ReadOptions::default()
    }
}

/// Writes and reads a robot, and checks that nothing has changed; `false` if the format has no words for the robot.
fn round(name: &str, model: &Model, format: Format, random: &mut Random) -> bool {
    let mut home = vec![0.0; model.nq()];
    let interpreter = Interpreter::<f64>::new(model.clone());
    interpreter.random_configuration(|| random.between(0.0, 1.0), &mut home).expect("coordinates");
    let qd: Vec<f64> = (0..model.nv()).map(|_| random.between(-1.0, 1.0)).collect();
    let keyframe =
        Keyframe { name: "home".into(), q: home.clone(), qd: qd.clone(), ..Keyframe::default() };
    let model = &model.clone().with_keyframes(vec![keyframe]).expect("coordinates");
    let written = match write(model, format) {
        Ok(written) => written,
        Err(found) => {
            assert!(found.iter().all(|one| one.code == Code::Inexpressible), "{name}: {found}");
            return false;
        }
    };
    let file = format!("{name}.{}", format.name());
    let again = read(&written.text, &file, &options(model, format));
    let again = again.unwrap_or_else(|found| panic!("{file}: {found}\n{}", written.text)).model;
    assert_eq!((again.nq(), again.nv()), (model.nq(), model.nv()), "{file}");
    let kept = again.keyframe("home");
    assert_eq!(kept.is_some(), format == Format::Mjcf, "{file}");
    if let Some(kept) = kept {
        assert_close(&format!("{file}: home"), &home, &kept.q);
        assert_close(&format!("{file}: home"), &qd, &kept.qd);
    }
    let mut robots = [model, &again].map(|model| Interpreter::<f64>::new(model.clone()));
    for own in 0..model.moving_links().len() {
        let q = model.q_range(own);
        let mut others = (0..again.moving_links().len()).filter(|&i| again.q_range(i) == q);
        let joint = &model.moving_links()[own].joint;
        if joint.mimic.is_some()
            || q.len() > 1
            || (format == Format::Mjcf && joint.limits.is_none())
        {
            continue;
        }
        let other = others.find(|&i| again.mimic(i).is_none()).expect("a joint");
        assert_eq!(joint.name, again.moving_links()[other].joint.name, "{file}");
        let efforts = [joint, &again.moving_links()[other].joint]
            .map(|joint| joint.limits.map_or([None; 2], |limits| [limits.effort, limits.velocity]));
        let is_left_out = format == Format::Mjcf && efforts[0][0] == Some(0.0);
        assert!(is_left_out || efforts[0][0] == efforts[1][0], "{file}: {}", joint.name);
        assert!(format == Format::Mjcf || efforts[0][1] == efforts[1][1], "{file}: {}", joint.name);
        let ranges = [model.coordinate_range(own), again.coordinate_range(other)];
        let [lower, upper] = ranges[0];
        assert!(
            ranges[0] == ranges[1] || format == Format::Mjcf && lower >= upper,
            "{file}: {}",
            joint.name
        );
    }
    let dynamic = joints_without_inertia(model).is_empty();
    assert_eq!(dynamic, joints_without_inertia(&again).is_empty(), "{file}");
    for _ in 0..3 {
        let mut q = vec![0.0; model.nq()];
        robots[0].random_configuration(|| random.between(0.0, 1.0), &mut q).expect("coordinates");
        let [qd, qdd] = [(); 2]
            .map(|()| -> Vec<f64> { (0..model.nv()).map(|_| random.between(-1.0, 1.0)).collect() });
        let settings = modyn_runtime::ConstraintSettings::<f64>::DEFAULT.numbers();
        let targets = modyn_runtime::ContactTarget::<f64>::default().numbers();
        let settings: Vec<f64> =
            settings.into_iter().chain((0..model.contacts().len()).flat_map(|_| targets)).collect();
        let has = |function: &Function| {
            function.fits(&Sizes::new(model, 0)) && (dynamic || !function.row().needs_inertia)
        };
        for function in COMPARED.into_iter().filter(has) {
            let arguments = function.row().arguments.iter().map(|argument| match argument.name {
                "q" => &q[..],
                "qd" => &qd,
                "qdd" => &qdd,
                _ => &settings,
            });
            let arguments: Vec<&[f64]> = arguments.collect();
            let [expected, found] = robots.each_mut().map(|robot| {
                let mut result = vec![0.0; (function.row().result)(&robot.sizes()).len()];
                robot.evaluate(function, &arguments, 0, &mut result).expect("a result");
                result
            });
            assert_close(&format!("{file}: {}", function.name()), &expected, &found);
        }
        let mut count = 0;
        for (i, frame) in model.links().iter().enumerate() {
            // MuJoCo reserves the name of the world.
            let is_renamed =
                format == Format::Mjcf && frame.name == "world" && frame.moving_link.is_some();
            let name = if is_renamed { "world_frame" } else { &frame.name };
            let Some(j) = again.link_index(name) else { continue };
            let of = |robot: &Interpreter<f64>, link| {
                let Pose { rotation, translation } = robot.link_pose(&q, link).expect("a pose");
                [rotation.as_flattened(), &translation].concat()
            };
            assert_close(
                &format!("{file}: {}", frame.name),
                &of(&robots[0], i),
                &of(&robots[1], j),
            );
            count += 1;
        }
        let is_whole = format == Format::Urdf || !written.text.contains("Without inertia");
        assert!(count == model.links().len() || !is_whole, "{file}: {count} frames");
    }
    true
}

fn assert_close(what: &str, expected: &[f64], found: &[f64]) {
    assert_eq!(expected.len(), found.len(), "{what}");
    let size = expected.iter().fold(1e-3_f64, |size, x| size.max(x.abs()));
    for (a, b) in expected.iter().zip(found) {
        // The centre of mass of no mass is nowhere.
        let are_equal = (a - b).abs() <= 1e-11 * size || a.is_nan() && b.is_nan();
        assert!(are_equal, "{what}: {expected:?} is {found:?}");
    }
}

/// Returns the descriptions of a folder.
fn descriptions(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let files = std::fs::read_dir(folder).expect("a folder");
    let mut files: Vec<PathBuf> = files.map(|file| file.expect("a file").path()).collect();
    files.retain(|file| {
        file.extension().is_some_and(|own| own == "urdf" || own == "sdf" || own == "xml")
    });
    files.sort();
    files
}

/// Shapes of each kind, of two bodies and of a body that is fixed to one of them, on two planes.
const SHAPES: &str = r#"<mujoco model="r"><option cone="elliptic" impratio="3"/>
  <asset><mesh name="part" vertex="0 0 0 0.1 0 0 0 0.2 0 0 0 0.3"/></asset><worldbody>
  <geom name="floor" type="plane" size="0 0 1" pos="0.1 0.2 -0.3" zaxis="0.1 0.2 1" friction="0.7"/>
  <geom name="wall" type="plane" size="0 0 1" pos="-3 0 0" zaxis="1 0 0.2" contype="0" conaffinity="2"/>
  <body name="trunk"><freejoint name="base" align="false"/><inertial pos="0.01 0.02 0.03" mass="2" diaginertia="0.2 0.3 0.25"/>
    <geom name="hull" type="box" pos="0.1 0.2 0.3" quat="0.9 0.1 0.2 0.3" size="0.1 0.2 0.3"/>
    <geom size="0.2" pos="-0.1 0.1 0.2" contype="3"/>
    <body name="leg" pos="0.2 0 -0.3" quat="0.8 0.3 -0.2 0.1"><joint name="hip" axis="0 1 0"/>
      <inertial pos="0 0 -0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
      <geom name="shin" type="capsule" size="0.1 0.2" pos="0 0 -0.2" friction="1.4" margin="0.01"/>
      <geom name="heel" type="cylinder" size="0.1 0.2" quat="0.2 0.3 0.4 0.5" friction="1.4 0.02 0.003" condim="6"
            solref="0.03 0.9" solimp="0.8 0.9 0.002 0.6 3"/>
      <body name="foot" pos="0.05 0 -0.4" quat="0.9 0.1 0.2 0.1">
        <geom name="sole" type="ellipsoid" size="0.1 0.2 0.05" pos="0.1 0 0" mass="0"/>
        <geom name="toe" type="mesh" mesh="part" pos="0.1 0 0" quat="0.9 0 0.2 0.1" mass="0"/>
      </body></body></body></worldbody></mujoco>"#;

/// The numbers of the shapes that touch the ground, by their names, with the names of their links.
fn touching(model: &Model) -> BTreeMap<(String, String), Vec<f64>> {
    let numbers = |shape: TouchingShape| {
        let link = model.links()[shape.end.link].name.clone();
        let mut numbers = shape.end.pose.rotation.as_flattened().to_vec();
        numbers.extend(shape.end.pose.translation);
        let mut sizes = shape.shape.numbers();
        sizes.sort_by(f64::total_cmp);
        numbers.extend(sizes);
        numbers.extend(shape.surface.numbers());
        numbers.extend([shape.components.count() as f64, f64::from(shape.power)]);
        ((shape.name, link), numbers)
    };
    model.touching_shapes().into_iter().map(numbers).collect()
}

#[test]
fn shapes_that_touch_the_ground_are_written() {
    let model = read(SHAPES, "r.xml", &ReadOptions::default()).expect("an MJCF").model;
    let shapes = touching(&model);
    assert_eq!(shapes.len(), 7, "{:?}", shapes.keys());
    let written = write(&model, Format::Mjcf).expect("an MJCF");
    let again = read(&written.text, "r.xml", &ReadOptions::default());
    let again = again.unwrap_or_else(|found| panic!("{found}\n{}", written.text));
    assert_eq!(again.warnings, [], "{}", written.text);
    let [soft, kept] = [&model, &again.model].map(Model::soft_constraints);
    assert_eq!((kept.cone, kept.impratio), (soft.cone, soft.impratio));
    let read_again = touching(&again.model);
    assert_eq!(read_again.keys().collect::<Vec<_>>(), shapes.keys().collect::<Vec<_>>());
    for (name, numbers) in &shapes {
        assert_close(&format!("{name:?}"), numbers, &read_again[name]);
    }
    for integrator in [Integrator::Euler, Integrator::ImplicitFast, Integrator::ExplicitEuler] {
        let soft = SoftConstraints { integrator, ..model.soft_constraints().clone() };
        let changed = model.clone().with_soft_constraints(soft).expect("the same shapes");
        let written = write(&changed, Format::Mjcf).expect("an MJCF");
        let again = read(&written.text, "r.xml", &ReadOptions::default()).expect("an MJCF").model;
        assert_eq!(again.soft_constraints().integrator, integrator);
        let urdf = write(&changed, Format::Urdf).expect("a URDF").text;
        assert_eq!(urdf.contains("the integrator of `step`"), integrator != Integrator::Euler);
    }
    // A URDF has the shapes, and the option has the ground.
    let written = write(&model, Format::Urdf).expect("a URDF");
    assert!(written.text.contains("Left out: shape `toe`."), "{}", written.text);
    assert!(written.text.contains("Left out: 1 more plane"), "{}", written.text);
    let option = written.text.split("`ground = ").nth(1).and_then(|rest| rest.split('`').next());
    let numbers = option.expect("an option").replace(|c: char| !"0123456789.-e,".contains(c), "");
    let numbers: Vec<f64> =
        numbers.split(',').filter_map(|x| x.trim_start_matches('e').parse().ok()).collect();
    let [x, y, z, nx, ny, nz] = numbers[..] else { panic!("{option:?}") };
    let ground = Some(Ground::plane([x, y, z], [nx, ny, nz]));
    let given = ReadOptions { ground, ..ReadOptions::default() };
    let again = read(&written.text, "r.urdf", &given).expect("a URDF").model;
    let read_again = touching(&again);
    let names: Vec<&str> = read_again.keys().map(|(name, _)| &**name).collect();
    assert_eq!(names, ["heel", "hull", "shin", "sole", "trunk_geom_1"]);
    for (name, numbers) in &read_again {
        // Poses, sizes, plane, radius and friction; the law of `heel` and the margin of `shin` are left out.
        let kept = numbers.len() - 11;
        assert_close(&format!("{name:?}"), &shapes[name][..kept], &numbers[..kept]);
    }
    assert!(
        written.text.contains("The contacts of shapes `shin`, `heel` have"),
        "{}",
        written.text
    );
}

#[test]
fn descriptions_are_written_and_read_again() {
    let mut random = Random::new(1);
    let (mut urdf, mut mjcf, mut all) = (0, 0, 0);
    for file in
        ["../robots", "tests/good", "tests/sdf", "tests/mjcf"].into_iter().flat_map(descriptions)
    {
        let text = std::fs::read_to_string(&file).expect("UTF-8");
        let name = file.file_name().expect("a name").to_string_lossy().into_owned();
        for base in [Base::Auto, Base::Floating] {
            let options = ReadOptions {
                base,
                folder: file.parent().map(Into::into),
                unphysical_inertia: Severity::Warning,
                ..ReadOptions::default()
            };
            // Some descriptions need options or have a floating base, and parts of others are read on their own.
            let Ok(reading) = read(&text, &name, &options) else { continue };
            all += 1;
            urdf += usize::from(round(&name, &reading.model, Format::Urdf, &mut random));
            mjcf += usize::from(round(&name, &reading.model, Format::Mjcf, &mut random));
        }
    }
    assert!(all > 80 && urdf > all - 8 && mjcf > 60, "{urdf} and {mjcf} of {all} written");
}

#[test]
fn random_robots_are_written_and_read_again() {
    let (mut urdf, mut mjcf) = (0, 0);
    for seed in random::seeds(60) {
        let mut random = Random::new(seed);
        let model = random::mixed_zoo(seed, 1 + seed as usize % 9);
        let model = constrained(model, &mut random);
        let is_written = round("random", &model, Format::Urdf, &mut random);
        let has_no_forces = model.springs().is_empty() && model.gravity_compensation().is_empty();
        assert!(is_written || !has_no_forces, "seed {seed}");
        urdf += usize::from(is_written);
        mjcf += usize::from(round("random", &model, Format::Mjcf, &mut random));
    }
    assert!(urdf > 20 && mjcf > 10, "{urdf} robots written as URDF, {mjcf} as MJCF");
}

/// Returns a pose in general position.
fn general_pose(random: &mut Random) -> Pose<f64> {
    let quaternion: [f64; 4] = std::array::from_fn(|_| random.between(0.2, 1.0));
    let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
    let quaternion = quaternion.map(|x| x / length);
    let rotation = modyn_runtime::conventions::rotation_from_quaternion(quaternion);
    Pose { rotation, translation: std::array::from_fn(|_| random.between(-0.5, 0.5)) }
}

/// Returns the robot with a contact, and a loop between two links, if it has two.
fn constrained(model: Model, random: &mut Random) -> Model {
    let last = model.moving_links().len() - 1;
    let frame = |link: usize| model.link_index(&model.moving_links()[link].name).expect("a frame");
    let mut end =
        |link: usize| LoopConstraintEnd { link: frame(link), pose: general_pose(&mut *random) };
    let ends = [end(0), end(last)];
    let contact = ModelContact { name: "sole".into(), kind: ContactKind::Surface, end: end(last) };
    let axis = [0.6, 0.0, 0.8];
    let kinds = [
        LoopConstraintKind::Point,
        LoopConstraintKind::Rigid,
        LoopConstraintKind::Revolute(axis),
        LoopConstraintKind::Prismatic(axis),
    ];
    let kind = kinds[random.below(4)];
    let loops = vec![LoopConstraint { name: "pin".into(), kind, ends }];
    let model = model.with_contacts(vec![contact]).expect("a contact");
    if last == 0 { model } else { model.with_loop_constraints(loops).expect("a loop") }
}

/// Names keep all their characters, and properties that a format cannot express are said or refused.
#[test]
fn names_limits_and_notes() {
    let text = r#"<robot name="a &lt;b> &amp; &quot;c&quot;"><link name="base -- 1"/>
        <joint name="j&#10;k" type="revolute"><parent link="base -- 1"/><child link="d&#9;e"/><origin xyz="0 0 1e-20"/>
          <limit lower="-1" upper="1e31" effort="1e31" velocity="3"/></joint>
        <link name="d&#9;e"><inertial><mass value="1"/>
          <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;
    let gravity = Some([0.0, 0.0, -1.62]);
    let model = read(text, "r.urdf", &ReadOptions { gravity, ..ReadOptions::default() });
    let model = model.expect("a robot").model;
    let limits = model.moving_links()[0].joint.limits.expect("limits");
    assert_eq!((limits.lower, limits.upper, limits.effort), (Some(-1.0), None, None));
    let written = write(&model, Format::Urdf).expect("a URDF");
    assert_eq!(written.notes.len(), 1, "{:?}", written.notes);
    assert!(written.text.contains("`gravity = [0, 0, -1.62]`"), "{}", written.text);
    let again = read(&written.text, "r.urdf", &ReadOptions { gravity, ..ReadOptions::default() });
    assert_eq!(again.expect("a robot").model, model);
    let written = write(&model, Format::Mjcf).expect("an MJCF");
    assert!(
        written.notes.iter().any(|note| note.contains("velocity limit")),
        "{:?}",
        written.notes
    );
    assert_eq!(
        read(&written.text, "r.xml", &ReadOptions::default()).expect("a robot").model.gravity(),
        model.gravity()
    );
    let found = write(&model, Format::Sdf).expect_err("SDF is not written");
    assert!(found.to_string().contains("write a URDF or an MJCF"), "{found}");
}
