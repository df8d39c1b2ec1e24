//! Gazebo's models (SDF). The models of `sdf/` have mechanisms in general position, and give Drake's numbers. An element that
//! would change the dynamics and is not supported is refused, with its line.

use std::path::Path;

use modyn_read::diagnostics::{Code, Diagnostics};
use modyn_read::{Base, Format, Mimic, ReadOptions};
use modyn_runtime::Interpreter;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{LoopConstraintKind, Model};

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/sdf")
}

fn read(text: &str, options: &ReadOptions) -> Result<Model, Diagnostics> {
    Format::Sdf.read(text, "robot.sdf", options).map(|reading| reading.model)
}

/// Returns a model with these elements.
fn model(elements: &str) -> Result<Model, Diagnostics> {
    read(
        &format!("<sdf version='1.12'><model name='m'>{elements}</model></sdf>"),
        &ReadOptions::default(),
    )
}

/// Compares a model of `sdf/` with the numbers of Drake, which `sdf/golden.py` wrote.
fn assert_drakes_numbers(name: &str) {
    let path = folder().join(name);
    let text = std::fs::read_to_string(&path).expect("a model");
    let golden = std::fs::read_to_string(path.with_extension("txt")).expect("Drake's numbers");
    let options = ReadOptions { folder: Some(folder()), ..ReadOptions::default() };
    let reading = modyn_read::read(&text, name, &options);
    let robot = reading.unwrap_or_else(|found| panic!("{found}")).model;
    let (nq, nv) = (robot.nq(), robot.nv());
    // For each entry of Drake's states, the entry of modyn's.
    let (mut q_of, mut v_of) = (Vec::new(), Vec::new());
    for line in golden.lines().filter_map(|line| line.strip_prefix("joint ")) {
        let joint = line.split(' ').next().unwrap_or_default();
        let link = robot.moving_links().iter().position(|link| link.joint.name == joint);
        let link = link.unwrap_or_else(|| panic!("{name}: no joint {joint}"));
        q_of.extend(robot.q_range(link));
        v_of.extend(robot.v_range(link));
    }
    assert_eq!((q_of.len(), v_of.len()), (nq, nv), "{name}");
    let frames: Vec<String> = robot.links().iter().map(|link| link.name.clone()).collect();
    let mut interpreter = Interpreter::<f64>::new(robot);
    let numbers = |line: &str| -> Vec<f64> {
        line.split(' ').map(|word| word.parse().expect("a number")).collect()
    };
    let is_state =
        |line: &&str| !["#", "joint ", "pose "].iter().any(|start| line.starts_with(start));
    let states: Vec<Vec<f64>> = golden.lines().filter(is_state).map(numbers).collect();
    let poses: Vec<&str> = golden.lines().filter_map(|line| line.strip_prefix("pose ")).collect();
    assert_eq!((states.len(), poses.len() % 3), (12, 0), "{name}");
    let near = |a: f64, b: f64, size: f64, what: &str| {
        assert!((a - b).abs() < 1e-12 * size, "{name}: {what}: {a} is not {b}");
    };
    for (state, poses) in states.chunks(4).zip(poses.chunks(poses.len() / 3)) {
        let [theirs_q, theirs_qd, theirs_bias, theirs_matrix] = state else { panic!("{name}") };
        let (mut q, mut qd) = (vec![0.0; nq], vec![0.0; nv]);
        q_of.iter().zip(theirs_q).for_each(|(&i, &x)| q[i] = x);
        v_of.iter().zip(theirs_qd).for_each(|(&i, &x)| qd[i] = x);
        let (mut bias, mut matrix) = (vec![0.0; nv], vec![0.0; nv * nv]);
        interpreter.bias_forces(&q, &qd, &mut bias).expect("sizes");
        interpreter.mass_matrix(&q, &mut matrix).expect("sizes");
        let size = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (i, &row) in v_of.iter().enumerate() {
            near(bias[row], theirs_bias[i], size(theirs_bias), "bias");
            for (j, &column) in v_of.iter().enumerate() {
                let theirs = theirs_matrix[j * nv + i];
                near(matrix[column * nv + row], theirs, size(theirs_matrix), "mass matrix");
            }
        }
        for line in poses {
            let (frame, rest) = line.split_once(' ').expect("a name");
            let index = frames.iter().position(|name| name == frame);
            let index = index.unwrap_or_else(|| panic!("{name}: no frame {frame}"));
            let pose = interpreter.link_pose(&q, index).expect("a frame");
            let ours = pose.rotation.iter().flatten().chain(&pose.translation);
            ours.zip(numbers(rest)).for_each(|(&a, b)| near(a, b, 10.0, frame));
        }
    }
}

/// A URDF with Drake's transmissions and joints.
#[test]
fn extensions_of_urdf_are_drakes() {
    assert_drakes_numbers("extensions.urdf");
}

/// Drake goes by the prefix: the URI and the declaration have no meaning.
#[test]
fn prefixes_need_no_declaration() {
    let text = std::fs::read_to_string(folder().join("frames.sdf")).expect("a model");
    let declaration = " xmlns:drake=\"drake.mit.edu\"";
    let read = |declared: &str| {
        read(&text.replace(declaration, declared), &ReadOptions::default()).expect("a model")
    };
    let declared = read(declaration);
    let armatures = declared.moving_links().iter().map(|link| link.joint.dynamics.armature);
    assert!(armatures.into_iter().any(|armature| (armature - 0.288).abs() < 1e-15));
    assert_eq!(read(" xmlns:drake=\"my.company/drk\""), declared);
    assert_eq!(read(""), declared);
}

/// Unknown elements and extensions are named at every level; attributes of extensions have no
/// effect.
#[test]
fn extensions_are_named_at_every_level() {
    let levels =
        ["world", "model", "link", "inertial", "inertia", "joint", "axis", "limit", "dynamics"];
    let extra = |level: &str| {
        assert!(levels.contains(&level));
        format!("<drake:of_{level} gz:a='1'/><{level}_word/>")
    };
    let text = format!(
        "<sdf version='1.12'><world name='w' gz:b='2'>{}<model name='m'>{}
         <link name='arm'>{}<inertial>{}<inertia>{}</inertia></inertial><sensor name='s' type='custom' gz:type='dvl'/></link>
         <joint name='j' type='revolute'>{}<parent>world</parent><child>arm</child>
         <axis>{}<limit>{}</limit><dynamics>{}</dynamics></axis></joint></model></world></sdf>",
        extra("world"), extra("model"), extra("link"), extra("inertial"), extra("inertia"), extra("joint"),
        extra("axis"), extra("limit"), extra("dynamics"),
    );
    let reading = Format::Sdf.read(&text, "robot.sdf", &ReadOptions::default()).expect("a robot");
    let warnings: Vec<String> = reading.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 2 * levels.len(), "{warnings:#?}");
    for level in levels {
        for name in
            [format!("the extension `<drake:of_{level}>`"), format!("the element `<{level}_word>`")]
        {
            assert!(
                warnings.iter().any(|warning| warning.contains(&name)),
                "{name}: {warnings:#?}"
            );
        }
    }
}

/// Drake's constraint of two points closes a loop, also with the world.
#[test]
fn drakes_ball_constraint_is_read() {
    let read = |second: &str| {
        let link =
            |name: &str| format!("<link name='{name}'><inertial><mass>1</mass></inertial></link>");
        let joint = "<joint name='j' type='continuous'><parent>a</parent><child>b</child><axis/></joint>
            <joint name='ball_constraint' type='fixed'><parent>world</parent><child>a</child></joint>";
        let part = |name: &str, text: &str| {
            format!("<drake:ball_constraint_{name}>{text}</drake:ball_constraint_{name}>")
        };
        let parts = part("body_A", "b") + second + &part("p_AP", "1 2 3") + &part("p_BQ", "4 5 6");
        model(&format!(
            "{}{}{joint}<drake:ball_constraint>{parts}</drake:ball_constraint>",
            link("a"),
            link("b")
        ))
    };
    for (name, frame) in [("a", "a"), ("world", "world")] {
        let second = format!("<drake:ball_constraint_body_B>{name}</drake:ball_constraint_body_B>");
        let model = read(&second).expect("a model");
        let [constraint] = model.loop_constraints() else { panic!("one constraint") };
        let ends = constraint
            .ends
            .each_ref()
            .map(|end| (model.links()[end.link].name.as_str(), end.pose.translation));
        assert_eq!(ends, [("b", [1.0, 2.0, 3.0]), (frame, [4.0, 5.0, 6.0])]);
        assert_eq!(constraint.kind, LoopConstraintKind::Point);
        assert_eq!(constraint.name, "ball_constraint_2");
    }
    let misspelt = "<drake:ball_constraint_body_B>c</drake:ball_constraint_body_B>";
    for (second, code) in [(misspelt, Code::LoopLink), ("", Code::MissingElement)] {
        let found = read(second).expect_err("refused").into_vec();
        assert_eq!(found[0].code, code, "{found:?}");
    }
}

/// Drake's extension `mimic` is SDF's.
#[test]
fn drakes_mimic_is_read() {
    let joints = |mimic: &str, drakes: &str| {
        let link =
            |name: &str| format!("<link name='{name}'><inertial><mass>1</mass></inertial></link>");
        let joint = |name: &str, mimic: &str, drakes: &str| {
            format!(
                "<joint name='{name}' type='revolute'><parent>world</parent><child>{name}_link</child>
                 <axis><xyz>0 0 1</xyz>{mimic}</axis>{drakes}</joint>"
            )
        };
        let links = link("a_link") + &link("b_link");
        model(&format!("{links}{}{}", joint("a", "", ""), joint("b", mimic, drakes)))
            .expect("a model")
    };
    let sdfs = "<mimic joint='a'><multiplier>3</multiplier><offset>0.5</offset></mimic>";
    let drakes = "<drake:mimic joint='a' multiplier='3' offset='0.5'/>";
    assert_eq!(joints("", drakes), joints(sdfs, ""));
    assert_eq!(joints("", drakes).nv(), 1);
}

/// Poses relative to frames, joints and links that come later, axes in other frames, and each joint type.
#[test]
fn frames_are_drakes() {
    assert_drakes_numbers("frames.sdf");
}

/// A world with nested models, placement frames, included and merged files.
#[test]
fn nested_models_are_drakes() {
    assert_drakes_numbers("nested.sdf");
}

/// The axes of old versions are in the model's frame. A link without `<inertial>` has SDF's default.
#[test]
fn old_versions_are_drakes() {
    assert_drakes_numbers("old.sdf");
}

/// Joints whose child is closer to the world than their parent.
#[test]
fn reversed_joints_are_drakes() {
    assert_drakes_numbers("reversed.sdf");
}

/// Inertias of collisions, and a mimic joint.
#[test]
fn solids_are_drakes() {
    assert_drakes_numbers("solids.sdf");
}

/// A world with several models that move, joints between models, and one to a static model.
#[test]
fn worlds_are_drakes() {
    assert_drakes_numbers("world.sdf");
}

/// A joint of the world connects models as a joint of a model connects the models in it.
#[test]
fn joints_of_the_world_connect_models() {
    let link = |name: &str, mass: f64| {
        format!(
            "<link name='{name}'><pose>0.1 {mass} 0.2 0.3 0.1 {mass}</pose><inertial><pose>0.1 0.2 {mass} 0 0 0</pose>\
             <mass>{mass}</mass></inertial></link>"
        )
    };
    let models = format!(
        "<model name='a'><pose>0.1 0.2 0.3 0.4 0.5 0.6</pose>{}</model><model name='b'>{}</model>\
         <joint name='j' type='revolute'><pose>0.1 0 0.2 0.1 0.3 0</pose><parent>a::l</parent><child>b::m</child>\
         <axis><xyz>0 0.6 -0.8</xyz></axis></joint>",
        link("l", 0.3),
        link("m", 0.7),
    );
    let joint = |parent, child| {
        format!(
            "<joint name='k' type='revolute'><pose relative_to='a::l'/><parent>{parent}</parent><child>{child}</child>\
             <axis><xyz>0.6 0 0.8</xyz></axis></joint>"
        )
    };
    let numbers = |models: &str, sign: f64| {
        let text = format!("<sdf version='1.12'><world name='w'>{models}</world></sdf>");
        let robot = read(&text, &ReadOptions::default()).unwrap_or_else(|found| panic!("{found}"));
        let moving: Vec<_> =
            (0..robot.moving_links().len()).filter(|&i| robot.v_range(i).len() == 1).collect();
        let names =
            moving.iter().map(|&i| robot.moving_links()[i].joint.name.clone()).collect::<Vec<_>>();
        assert_eq!(names, ["k", "j"]);
        let mut numbers = [0.0; 6];
        let (bias, matrix) = numbers.split_at_mut(2);
        let mut interpreter = Interpreter::<f64>::new(robot);
        interpreter.bias_forces(&[0.3 * sign, -0.7], &[0.4 * sign, 0.9], bias).expect("sizes");
        interpreter.mass_matrix(&[0.3 * sign, -0.7], matrix).expect("sizes");
        for entry in [0, 3, 4] {
            numbers[entry] *= sign;
        }
        numbers
    };
    let nested = format!("<model name='n'>{models}{}</model>", joint("world", "a::l"));
    let nested = numbers(&nested, 1.0);
    let floor =
        "<model name='s'><static>1</static><pose>1 2 3 4 5 6</pose><link name='p'/></model>";
    let near = |found: [f64; 6]| {
        for (a, b) in found.iter().zip(nested) {
            assert!((a - b).abs() < 1e-12, "{found:?} {nested:?}");
        }
    };
    near(numbers(&format!("{floor}{models}{}", joint("s::p", "a::l")), 1.0));
    near(numbers(&format!("{floor}{models}{}", joint("a::l", "s::p")), -1.0));
}

/// Drake does not read cones. The moments are integrated over slices here.
#[test]
fn a_cone_is_the_sum_of_its_slices() {
    let robot = model(
        "<link name='l'><inertial auto='true'/><collision name='c'>
         <geometry><cone><radius>0.3</radius><length>0.8</length></cone></geometry></collision></link>",
    )
    .expect("a cone");
    let (n, radius, length) = (100_000, 0.3, 0.8);
    let (mut mass, mut first, mut xx, mut zz) = (0.0, 0.0, 0.0, 0.0);
    for i in 0..n {
        let height = (f64::from(i) + 0.5) / f64::from(n);
        let (z, r) = ((height - 0.5) * length, (1.0 - height) * radius);
        let slice = 1000.0 * std::f64::consts::PI * r * r * length / f64::from(n);
        mass += slice;
        first += slice * z;
        xx += slice * (r * r / 4.0 + z * z);
        zz += slice * r * r / 2.0;
    }
    let own = robot.moving_links()[0].inertial;
    let expected = [mass, first / mass, xx - first * first / mass, zz];
    for (a, b) in
        [own.mass, own.center_of_mass[2], own.inertia[0], own.inertia[5]].iter().zip(expected)
    {
        assert!((a - b).abs() < 1e-8 * b.abs(), "{a} is not {b}");
    }
}

const ARM: &str = "<link name='base'/><link name='arm'><pose>0 0 1 0 0 0</pose></link>
    <joint name='j' type='revolute'><parent>base</parent><child>arm</child><axis><xyz>0 1 0</xyz>
    <limit><lower>-inf</lower><upper>2</upper><effort>inf</effort><velocity>3</velocity></limit></axis></joint>";

/// Forces of gravity are affine in the mass of a link, so those of a link without mass follow from two masses.
#[test]
fn a_link_without_gravity_has_inertia_alone() {
    let robot = |mass: f64, gravity: bool| {
        let text = format!(
            "<link name='base'><pose>0.1 0.2 0.3 0.4 0.5 0.6</pose><inertial><pose>0.1 0 0.3 0 0 0</pose></inertial></link>
             <link name='arm'><pose>0 0 1 0.3 0.2 0.1</pose><gravity>{gravity}</gravity>
             <inertial><pose>0.2 0.1 0.4 0 0 0</pose><mass>{mass}</mass></inertial></link>
             <joint name='i' type='revolute'><parent>world</parent><child>base</child><axis><xyz>0.6 0.8 0</xyz></axis></joint>
             <joint name='j' type='revolute'><parent>base</parent><child>arm</child><axis><xyz>0 0.6 0.8</xyz></axis></joint>"
        );
        Interpreter::<f64>::new(model(&text).unwrap_or_else(|found| panic!("{found}")))
    };
    let q = [0.3, -0.7];
    let torques = |mass, gravity| {
        let mut torques = [0.0; 2];
        robot(mass, gravity).gravity_torques(&q, &mut torques).expect("sizes");
        torques
    };
    let (once, twice, without) = (torques(1.5, true), torques(3.0, true), torques(1.5, false));
    for ((once, twice), without) in once.iter().zip(twice).zip(without) {
        assert!((2.0 * once - twice - without).abs() < 1e-12 && (once - without).abs() > 0.1);
    }
    let matrix = |gravity| {
        let mut matrix = [0.0; 4];
        robot(1.5, gravity).mass_matrix(&q, &mut matrix).expect("sizes");
        matrix
    };
    assert_eq!(matrix(true), matrix(false));
}

/// Springs of axes act, and links without gravity have no weight.
#[test]
fn springs_and_weightless_links() {
    let dynamics = "<dynamics><spring_stiffness>4</spring_stiffness>\
        <spring_reference>0.3</spring_reference></dynamics>";
    let elements = |second: &str| {
        format!(
            "<link name='a'/><link name='b'><gravity>false</gravity></link><link name='c'/>\
            <joint name='ja' type='revolute'><parent>world</parent><child>a</child><axis>{dynamics}</axis></joint>\
            <joint name='jb' type='ball'><parent>a</parent><child>b</child></joint>\
            <joint name='jc' type='universal'><parent>b</parent><child>c</child><axis>{dynamics}</axis>\
            <axis2><xyz>1 0 0</xyz>{second}</axis2></joint>"
        )
    };
    let robot = model(&elements(dynamics)).expect("an SDF");
    let springs = robot.springs().iter().map(|spring| {
        (&*robot.moving_links()[spring.link].joint.name, spring.stiffness, &*spring.reference)
    });
    let expected: [(_, _, &[f64]); 2] = [("ja", 4.0, &[0.3]), ("jc", 4.0, &[0.3, 0.3])];
    assert_eq!(springs.collect::<Vec<_>>(), expected);
    let factors = robot.links().iter().zip(robot.gravity_compensation());
    let weightless = factors.filter(|(_, factor)| **factor == 1.0);
    assert_eq!(weightless.map(|(frame, _)| &*frame.name).collect::<Vec<_>>(), ["b"]);
    // A joint has one stiffness.
    let error = model(&elements("")).expect_err("two springs");
    assert_eq!(error.iter().next().map(|one| one.code), Some(Code::NotRead));
}

/// The base floats unless a joint or an option fixes it. A model without weight has no gravity.
#[test]
fn the_base_and_gravity() {
    let text = format!("<sdf version='1.12'><model name='m'>{ARM}</model></sdf>");
    let with = |base| read(&text, &ReadOptions { base, ..ReadOptions::default() });
    for base in [Base::Auto, Base::Floating] {
        let robot = with(base).expect("floats");
        assert_eq!(robot.moving_links()[0].joint.joint_type, JointType::Floating);
        assert_eq!(robot.moving_links()[0].joint.name, "floating_base");
    }
    let robot = with(Base::Fixed).expect("fixed");
    assert_eq!(robot.nq(), 1);
    let limits = robot.moving_links()[0].joint.limits.expect("limits");
    assert_eq!((limits.lower, limits.upper), (None, Some(2.0)));
    assert_eq!((limits.velocity, limits.effort), (Some(3.0), None));
    let weightless = text
        .replace("'base'/>", "'base'><gravity>0</gravity></link>")
        .replace("<pose>", "<gravity>false</gravity><pose>");
    let robot = read(&weightless, &ReadOptions::default()).expect("weightless");
    assert_eq!(robot.gravity(), [0.0; 3]);
    let fixed = text.replace("base</parent>", "world</parent>").replace("<link name='base'/>", "");
    let options = ReadOptions { base: Base::Floating, ..ReadOptions::default() };
    assert_eq!(
        read(&fixed, &options).expect_err("it does not float").iter().next().map(|one| one.code),
        Some(Code::Option)
    );
}

#[test]
fn a_joint_closes_a_loop() {
    let robot = model(&format!(
        "{ARM}<link name='rod'/><joint name='k' type='revolute'><parent>base</parent><child>rod</child>
         <axis><xyz>0 1 0</xyz></axis></joint>
         <joint name='pin' type='revolute'><parent>rod</parent><child>arm</child><axis><xyz>0 1 0</xyz></axis>
         <physics><simbody><must_be_loop_joint>true</must_be_loop_joint></simbody></physics></joint>"
    ))
    .expect("a loop");
    let [pin] = robot.loop_constraints() else { panic!("one loop") };
    assert_eq!(pin.kind, LoopConstraintKind::Revolute([0.0, 1.0, 0.0]));
    assert_eq!(pin.ends[0].pose.translation, [0.0, 0.0, 1.0]);
}

/// The first joints between links are the tree; a joint between connected links closes a loop, without saying so.
#[test]
fn a_joint_between_connected_links_closes_a_loop() {
    let text = format!(
        "<sdf version='1.12'><model name='m'>{ARM}<link name='rod'><inertial/></link>
         <joint name='k' type='revolute'><parent>base</parent><child>rod</child><axis><xyz>0 1 0</xyz></axis></joint>
         <joint name='pin' type='revolute'><parent>rod</parent><child>arm</child><axis><xyz>0 1 0</xyz>
         <dynamics><damping>1</damping></dynamics></axis></joint></model></sdf>"
    );
    let reading = Format::Sdf.read(&text, "robot.sdf", &ReadOptions::default()).expect("a loop");
    let [pin] = reading.model.loop_constraints() else { panic!("one loop") };
    assert_eq!(pin.kind, LoopConstraintKind::Revolute([0.0, 1.0, 0.0]));
    let found: Vec<_> = reading.warnings.iter().map(|warning| warning.code).collect();
    assert!(found.contains(&Code::LoopEnds) && found.contains(&Code::NotRead), "{found:?}");
    let mimic = text.replace(
        "<dynamics><damping>1</damping></dynamics>",
        "<mimic joint='k'><multiplier>1</multiplier></mimic>",
    );
    let error = read(&mimic, &ReadOptions::default()).expect_err("a mimic joint has a coordinate");
    assert!(error.to_string().contains("it closes a loop and mimics another joint"), "{error}");
}

/// Without its follower, a screw would be another joint.
/// A joint within its child is at the joint's place, however small the robot is; a rounding error of poses is no offset.
#[test]
fn small_offsets_of_joints_are_kept() {
    let robot = |size: f64, offset: &str| {
        let [near, far] = [0.1, 0.2].map(|x| size * x);
        model(&format!(
            "<link name='base'/><frame name='near'><pose>{near} 0 0 0 0 0</pose></frame>
             <link name='arm'><pose relative_to='near'>{far} 0 0 0 0 0</pose></link>
             <joint name='fixed' type='fixed'><parent>world</parent><child>base</child></joint>
             <joint name='hinge' type='revolute'><parent>base</parent><child>arm</child>
             <pose{offset} 0 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint>"
        ))
        .unwrap_or_else(|found| panic!("{found}"))
    };
    let arm = |model: &Model| {
        let link = model.links().iter().find(|link| link.name == "arm").expect("a link");
        link.pose.translation[0]
    };
    let offset = arm(&robot(1e-3, ">5e-13"));
    assert!((offset + 5e-13).abs() < 1e-17, "{offset}");
    // 0.1 + 0.2 - 0.3 is 5.6e-17.
    assert_eq!(arm(&robot(1.0, " relative_to='base'>0.3")), 0.0);
}

#[test]
fn a_screw_follows() {
    let text = "<sdf version='1.12'><model name='m'><link name='l'/><joint name='j' type='screw'>
        <parent>world</parent><child>l</child><axis/></joint></model></sdf>";
    assert_eq!(read(text, &ReadOptions::default()).expect("a screw").nv(), 1);
    for mimic in [Mimic::Independent, Mimic::Refuse] {
        let found = read(text, &ReadOptions { mimic, ..ReadOptions::default() });
        assert!(found.expect_err("two joints").iter().any(|one| one.code == Code::Mimic));
    }
}

/// Errors in an included file have its name and its lines.
#[test]
fn included_files_have_places() {
    let include = |uri: &str| {
        let text = format!(
            "<sdf version='1.12'><model name='m'>\n<include><uri>{uri}</uri></include></model></sdf>"
        );
        let options =
            ReadOptions { folder: Some(folder().join("wrong")), ..ReadOptions::default() };
        read(&text, &options).expect_err(uri).to_string()
    };
    let shown = include("mass.sdf");
    assert!(shown.contains("mass.sdf:3:") && shown.contains("error[bad-number]"), "{shown}");
    let shown = include("itself.sdf");
    assert!(
        shown.contains("itself.sdf:3:") && shown.contains("the file includes itself"),
        "{shown}"
    );
    let shown = include("model://none");
    assert!(shown.contains("robot.sdf:2:") && shown.contains("SDF_PATH"), "{shown}");
    for uri in
        ["model://../sdf/finger.sdf", "https://x/y", "", "mass.sdf/x", "file:///dev/null", "."]
    {
        let shown = include(uri);
        assert!(shown.contains("robot.sdf:2:") && shown.contains("error[include]"), "{shown}");
    }
    let text = "<sdf version='1.12'><model name='m'><include><uri>finger.sdf</uri></include></model></sdf>";
    let shown = read(text, &ReadOptions::default()).expect_err("no folder").to_string();
    assert!(shown.contains("give the path of this file"), "{shown}");
}
