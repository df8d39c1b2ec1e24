//! The option `actuators`: a robot of URDF or SDF has the actuators of the same robot in an MJCF.

use modyn_read::diagnostics::{Code, Diagnostics, Severity};
use modyn_read::{Base, Format, JointActuator, Mimic, ReadOptions, Reading, write};
use modyn_runtime::equations::actuation::ActuatorInput;
use modyn_runtime::model::{Actuator, Model, TorqueSpeedLine, Transmission};
use modyn_runtime::{ActuatorOutputs, Interpreter};

/// A trunk with two legs. The order of the text is not that of the tree.
const URDF: &str = r#"<robot name="r">
  <link name="trunk">INERTIAL</link>
  <joint name="left_knee" type="revolute"><parent link="left_thigh"/><child link="left_shank"/><origin xyz="0 0 -0.3"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="0" effort="12" velocity="9"/></joint>
  <joint name="left_hip" type="revolute"><parent link="trunk"/><child link="left_thigh"/><origin xyz="0 0.1 0"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="20" velocity="7"/></joint>
  <joint name="right_hip" type="continuous"><parent link="trunk"/><child link="right_thigh"/><origin xyz="0 -0.1 0"/><axis xyz="0 1 0"/></joint>
  <joint name="right_slide" type="prismatic"><parent link="right_thigh"/><child link="right_shank"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" effort="0" velocity="0"/></joint>
  <joint name="right_toe" type="continuous"><parent link="right_shank"/><child link="toe"/><axis xyz="0 1 0"/>
    <mimic joint="right_hip" multiplier="2"/></joint>
  <joint name="left_toe" type="fixed"><parent link="left_shank"/><child link="sole"/></joint>
  <joint name="right_ball" type="spherical"><parent link="toe"/><child link="ball"/></joint>
  <link name="left_thigh">INERTIAL</link><link name="left_shank">INERTIAL</link><link name="right_thigh">INERTIAL</link>
  <link name="right_shank">INERTIAL</link><link name="toe">INERTIAL</link><link name="sole"/><link name="ball">INERTIAL</link>
</robot>"#;

const INERTIAL: &str = r#"<inertial><origin xyz="0.01 0 -0.1"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>"#;

fn read(actuators: &[JointActuator], mimic: Mimic) -> Result<Reading, Diagnostics> {
    let text = URDF.replace("INERTIAL", INERTIAL);
    let actuators = actuators.to_vec();
    let base = Base::Floating;
    let options = ReadOptions { actuators, mimic, base, ..ReadOptions::default() };
    modyn_read::read(&text, "r.urdf", &options)
}

fn model(actuators: &[JointActuator]) -> Model {
    read(actuators, Mimic::Follow).unwrap_or_else(|error| panic!("{error}")).model
}

/// Returns the joint of an actuator.
fn joint<'m>(model: &'m Model, actuator: &Actuator) -> &'m str {
    let Transmission::Joint(link) = actuator.transmission else { panic!("a joint") };
    &model.moving_links()[link].joint.name
}

#[test]
fn patterns_name_joints_with_one_degree_of_freedom_and_limits_are_the_descriptions() {
    let pd = JointActuator::position("*_hip", 20.0, 0.5).with_saturation(30.0).with_velocity(8.0);
    let knee = JointActuator::velocity("left_knee", 0.3).with_saturation(15.0).with_delay(3);
    let slide = JointActuator::motor("right_s*").with_effort(40.0);
    let robot = model(&[slide, knee, pd]);
    // In the order of the joints of the robot, not of the text or of the options.
    let joints = ["left_hip", "left_knee", "right_hip", "right_slide"];
    let tree_order: Vec<&str> = robot.moving_links().iter().map(|link| &*link.joint.name).collect();
    let with_actuator = tree_order.iter().filter(|name| joints.contains(name)).copied();
    assert_eq!(robot.control_names(), with_actuator.collect::<Vec<_>>());
    let actuators = &robot.actuation().actuators;
    assert!(actuators.iter().all(|actuator| actuator.name == joint(&robot, actuator)));
    let names: Vec<String> =
        [3, 2, 1].iter().map(|steps| format!("left_knee_before_{steps}")).collect();
    assert_eq!(robot.activation_names(), names);
    let actuator = |name: &str| {
        let actuator = actuators.iter().find(|actuator| actuator.name == name).expect("a joint");
        let line = actuator.torque_speed_line;
        (actuator.force_range, line.map(|line| [line.stall_force, line.no_load_speed]))
    };
    assert_eq!(actuator("left_hip"), (Some([-20.0, 20.0]), Some([30.0, 8.0])));
    assert_eq!(actuator("left_knee"), (Some([-12.0, 12.0]), Some([15.0, 9.0])));
    assert_eq!(actuator("right_hip"), (None, Some([30.0, 8.0])));
    assert_eq!(actuator("right_slide"), (Some([-40.0, 40.0]), None));
    // The option's largest force replaces the joint's effort limit.
    let slide = robot.moving_links().iter().find(|link| link.joint.name == "right_slide");
    assert_eq!(slide.and_then(|link| link.joint.limits?.effort), Some(40.0));
    // A mimic joint has an actuator by its own name, or if it has a coordinate of its own.
    let all = JointActuator::motor("*").with_effort(1.0);
    assert_eq!(model(std::slice::from_ref(&all)).control_names().len(), 4);
    let toe = JointActuator::motor("right_toe");
    assert_eq!(model(&[all.clone(), toe]).control_names().len(), 5);
    let independent = read(&[all], Mimic::Independent).expect("a robot").model;
    assert_eq!(independent.control_names().len(), 5);
}

#[test]
fn stars_stand_for_any_text() {
    let is_matched = |pattern: &str| match read(&[JointActuator::motor(pattern)], Mimic::Follow) {
        Ok(reading) => reading.model.control_names().contains(&"left_knee"),
        Err(_) => false,
    };
    for pattern in ["left_*", "*_knee", "*t_k*", "l*f*_*e", "left_knee*", "**_knee", "*left_knee"] {
        assert!(is_matched(pattern), "{pattern}");
    }
    let others = ["left_", "*_hip", "left_*_knee", "*k*k*", "left_kneee*", "left_knee*knee", ""];
    for pattern in others {
        assert!(!is_matched(pattern), "{pattern}");
    }
}

#[test]
fn wrong_actuators_are_refused_with_their_joint_and_a_remedy() {
    let motor = JointActuator::motor;
    let cases = [
        (motor("left_knees"), "left_knees", "does not exist", "did you mean `left_knee`?"),
        (motor("*_ankle"), "*_ankle", "no joint with one degree", "or several by `*`"),
        (motor("left_toe"), "left_toe", "does not move", "revolute, continuous or prismatic"),
        (motor("right_ball"), "right_ball", "several degrees of freedom", "revolute"),
        (motor("right_slide"), "right_slide", "effort limit is 0", "`effort = 20`"),
        (
            motor("right_slide").with_effort(1.0).with_saturation(2.0),
            "right_slide",
            "no velocity limit",
            "`velocity = 25`",
        ),
        (motor("right_hip").with_saturation(2.0), "right_hip", "no velocity limit", "velocity"),
        (motor("left_hip").with_velocity(2.0), "left_hip", "no stall force", "`saturation = 30`"),
        (motor("left_hip").with_effort(0.0), "left_hip", "the effort of", "in N m"),
        (motor("left_hip").with_effort(f64::NAN), "left_hip", "the effort of", "in N m"),
        (motor("left_hip").with_saturation(-1.0), "left_hip", "the saturation of", "stall force"),
        (
            motor("left_hip").with_saturation(1.0).with_velocity(f64::INFINITY),
            "left_hip",
            "the velocity of",
            "rad/s",
        ),
        (motor("left_hip").with_delay(2001), "left_hip", "more than 2000", "delay = 2"),
        (motor("left_*").with_delay(1001), "left_hip", "2002 steps together", "delay = 2"),
        (JointActuator::position("left_hip", -1.0, 1.0), "left_hip", "a gain", "kp in N m/rad"),
        (JointActuator::position("left_hip", 1.0, f64::NAN), "left_hip", "a gain", "kd in N m"),
        (JointActuator::velocity("left_hip", f64::INFINITY), "left_hip", "a gain", "kd in N m"),
    ];
    for (actuator, joint, message, help) in cases {
        let errors = read(&[actuator], Mimic::Follow).expect_err(message);
        let refused = errors.iter().filter(|one| one.severity == Severity::Error);
        let [error] = &*refused.collect::<Vec<_>>() else { panic!("{errors}") };
        assert_eq!(error.code, Code::Option, "{error}");
        let subject = error.subject.as_ref().expect("a joint").to_string();
        assert!(subject.contains(joint), "{subject}");
        assert!(error.message.contains(message), "{error}");
        assert!(error.help.as_ref().is_some_and(|text| text.contains(help)), "{help}: {error}");
    }
    let errors = read(&[motor("*_hip"), motor("left_*")], Mimic::Follow).expect_err("two");
    assert!(errors.to_string().contains("two actuators"), "{errors}");
}

const MJCF: &str = r#"<mujoco model="r"><compiler angle="radian"/><worldbody>
  <body name="thigh"><joint name="hip" axis="0 1 0"/><geom size="0.1" pos="0.1 0 -0.2"/>
    <body name="shank" pos="0 0 -0.4"><joint name="knee" axis="0 1 0" RANGE/><geom size="0.1" pos="0 0.05 -0.2"/></body></body>
  </worldbody><actuator>ACTUATORS</actuator></mujoco>"#;

fn of_mjcf(text: &str, actuators: Vec<JointActuator>) -> Reading {
    let options = ReadOptions { actuators, ..ReadOptions::default() };
    let reading = modyn_read::read(text, "r.xml", &options);
    reading.unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn the_option_replaces_the_actuators_of_an_mjcf() {
    let servos = r#"<position name="servo" joint="knee" kp="20" kv="0.5" forcerange="-3 3"/>
                    <motor joint="hip" forcerange="-4 4"/>"#;
    let text = MJCF.replace("RANGE", r#"actuatorfrcrange="-2 5""#);
    let option = vec![
        JointActuator::position("knee", 20.0, 0.5).with_effort(9.0),
        JointActuator::motor("hip").with_effort(4.0),
    ];
    let expected = r#"<motor name="hip" joint="hip" forcerange="-4 4"/>
                      <position name="knee" joint="knee" kp="20" kv="0.5" forcerange="-9 9"/>"#;
    let replaced = of_mjcf(&text.replace("ACTUATORS", servos), option.clone());
    let messages: Vec<&str> = replaced.warnings.iter().map(|warning| &*warning.message).collect();
    let message = "the option `actuators` replaces actuators `servo`, `hip` of the file";
    assert_eq!(messages, [message]);
    let described = of_mjcf(&text.replace("ACTUATORS", expected), Vec::new());
    assert_eq!(replaced.model.actuation(), described.model.actuation());
    assert_eq!(described.model.actuation().joint_force_ranges[0].range, [-2.0, 5.0]);
    // Without actuators in the file there is no warning.
    let added = of_mjcf(&text.replace("ACTUATORS", ""), option);
    assert_eq!(added.warnings, []);
    assert_eq!(added.model.actuation(), described.model.actuation());
}

const SDF: &str = r#"<sdf version="1.9"><model name="r"><link name="rod">
    <inertial><pose>0.01 0 -0.1 0 0 0</pose><mass>1</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link>
  <joint name="pivot" type="revolute"><parent>world</parent><child>rod</child>
    <axis><xyz>0 1 0</xyz><limit><effort>5</effort><velocity>4</velocity></limit></axis></joint></model></sdf>"#;

#[test]
fn an_sdf_has_the_limits_of_its_joints() {
    let actuators = vec![JointActuator::motor("piv*").with_saturation(7.0)];
    let options = ReadOptions { actuators, ..ReadOptions::default() };
    let model = modyn_read::read(SDF, "r.sdf", &options).expect("a robot").model;
    let [actuator] = &*model.actuation().actuators else { panic!("one actuator") };
    assert_eq!((&*actuator.name, actuator.force_range), ("pivot", Some([-5.0, 5.0])));
    let line = TorqueSpeedLine { stall_force: 7.0, no_load_speed: 4.0 };
    assert_eq!(actuator.torque_speed_line, Some(line));
    // A velocity that is NaN reaches the force.
    let mut robot = Interpreter::<f64>::new(model.clone());
    let mut force = |rate: f64, ctrl: f64| {
        let mut tau = [0.0];
        let input = ActuatorInput { q: &[0.0], qd: &[rate], ctrl: &[ctrl], act: &[], dt: 0.01 };
        robot.actuate(input, ActuatorOutputs { tau: &mut tau, act: &mut [] }).expect("lengths");
        tau[0]
    };
    assert_eq!([force(0.0, 3.0), force(3.0, 3.0), force(3.0, -6.0)], [3.0, 1.75, -5.0]);
    assert!(force(f64::NAN, 3.0).is_nan() && force(1.0, f64::NAN).is_nan());
    // Beyond the no-load speed the motor brakes, at most with its largest force.
    assert_eq!([force(6.0, 3.0), force(9.0, 3.0), force(-6.0, -1.0)], [-3.5, -5.0, 3.5]);
}

/// An MJCF that is written has the actuators, apart from parts that MuJoCo has no law for.
#[test]
fn actuators_are_written_to_an_mjcf() {
    let pd = JointActuator::position("*_hip", 20.0, 0.5).with_effort(11.0);
    let knee = JointActuator::velocity("left_knee", 0.3);
    let slide = JointActuator::motor("right_slide").with_effort(2.0);
    let robot = model(&[pd.clone(), knee.clone(), slide]);
    let written = write(&robot, Format::Mjcf).expect("an MJCF");
    assert!(written.notes.iter().all(|note| !note.contains("ctuator")), "{:?}", written.notes);
    for element in ["<position name=\"left_hip\"", "<velocity name=\"left_knee\"", "<motor name"] {
        assert!(written.text.contains(element), "{element}: {}", written.text);
    }
    let again = of_mjcf(&written.text, Vec::new()).model;
    assert_same_forces(&robot, &again);
    let limited = model(&[pd.with_saturation(9.0).with_velocity(3.0), knee.with_delay(2)]);
    let written = write(&limited, Format::Mjcf).expect("an MJCF");
    let line = "The torque-speed line is left out for actuators `left_hip`, `right_hip`.";
    let delay = "The delay in steps is left out for actuator `left_knee`";
    for part in [line, delay] {
        assert!(written.notes.iter().any(|note| note.contains(part)), "{:?}", written.notes);
    }
    let urdf = write(&limited, Format::Urdf).expect("a URDF");
    let left_out = |note: &String| note.starts_with("Left out: actuators `left_hip`");
    assert!(urdf.notes.iter().any(left_out), "{:?}", urdf.notes);
    // Further laws, ranges and activations of an MJCF.
    let general = r#"<general joint="knee" gear="-1.5" gaintype="affine" gainprm="1 0.2 0.3" biastype="affine" biasprm="0.1 -0.4 -0.2"
        dyntype="filterexact" dynprm="0.03" actearly="true" actrange="-0.6 0.5" ctrlrange="-1 0.8" forcerange="-3 1"/>
      <intvelocity name="i" joint="hip" kp="3" kv="0.2" actrange="-1 1"/><motor name="m" joint="hip" gear="3" ctrlrange="-1 1"/>"#;
    let text = MJCF.replace("RANGE", r#"actuatorfrcrange="-2 5""#).replace("ACTUATORS", general);
    let robot = of_mjcf(&text, Vec::new()).model;
    let written = write(&robot, Format::Mjcf).expect("an MJCF");
    assert_eq!(written.notes, [""; 0]);
    assert_eq!(of_mjcf(&written.text, Vec::new()).model.actuation(), robot.actuation());
    // A joint's effort limit would limit an actuator that exceeds it.
    let mut actuation = model(&[JointActuator::motor("left_hip")]).actuation().clone();
    actuation.actuators[0].force_range = Some([-30.0, 25.0]);
    let robot = model(&[]).with_actuation(actuation).expect("an actuator");
    let written = write(&robot, Format::Mjcf).expect("an MJCF");
    let note = "The effort limit of joint `left_hip`, 20, is left out: its actuators exceed it.";
    assert!(written.notes.iter().any(|one| one == note), "{:?}", written.notes);
}

/// Compares the forces of the actuators of two robots, by their names.
fn assert_same_forces(a: &Model, b: &Model) {
    assert!(!a.control_names().is_empty());
    let forces = |model: &Model| {
        let numbers = |count: usize, scale: f64| -> Vec<f64> {
            (0..count).map(|k| scale * (1.7 * k as f64 + 0.3).sin()).collect()
        };
        let q = numbers(model.nq(), 0.9);
        let qd = numbers(model.nv(), 3.0);
        let names = model.control_names().into_iter();
        let ctrl: Vec<f64> = names.map(|name| name.len() as f64 / 5.0 - 1.0).collect();
        let mut tau = vec![0.0; model.nv()];
        let input = ActuatorInput { q: &q, qd: &qd, ctrl: &ctrl, act: &[], dt: 0.01 };
        let outputs = ActuatorOutputs { tau: &mut tau, act: &mut [] };
        Interpreter::<f64>::new(model.clone()).actuate(input, outputs).expect("lengths");
        tau
    };
    assert_eq!(a.velocity_names(), b.velocity_names());
    assert_eq!(forces(a), forces(b));
}

/// Forces by the formulas of Isaac Lab 2.3.2's `DCMotor` and `DelayedPDActuator`, on both sides of each kink.
#[test]
fn the_line_and_the_delay_are_isaac_labs() {
    let [kp, kd, effort, saturation, velocity] = [25.0, 0.4, 12.0, 18.0, 9.0];
    let actuator =
        JointActuator::position("left_knee", kp, kd).with_saturation(saturation).with_delay(2);
    let robot = model(std::slice::from_ref(&actuator));
    assert_eq!(
        robot.actuation().actuators[0].torque_speed_line,
        Some(TorqueSpeedLine { stall_force: saturation, no_load_speed: velocity })
    );
    let knee = robot.moving_links().iter().position(|link| link.joint.name == "left_knee");
    let link = knee.expect("a joint");
    let [place, rate] = [robot.q_range(link).start, robot.v_range(link).start];
    let mut interpreter = Interpreter::<f64>::new(robot.clone());
    let mut regions = std::collections::BTreeSet::new();
    for step in -40..=40 {
        for target in [-3.0, -0.3, 0.2, 2.0] {
            let [mut q, mut qd] = [vec![0.1; robot.nq()], vec![0.2; robot.nv()]];
            let [position, speed] = [-0.7, 0.53 * f64::from(step)];
            (q[place], qd[rate]) = (position, speed);
            let act = [target, target + 0.1];
            let mut tau = vec![0.0; robot.nv()];
            let mut next = [0.0; 2];
            let input = ActuatorInput { q: &q, qd: &qd, ctrl: &[7.0], act: &act, dt: 0.01 };
            let outputs = ActuatorOutputs { tau: &mut tau, act: &mut next };
            interpreter.actuate(input, outputs).expect("lengths");
            // Isaac Lab clips the speed at which the line reaches the largest force.
            let most = velocity * (1.0 + effort / saturation);
            let clipped = speed.clamp(-most, most);
            let high = (saturation * (1.0 - clipped / velocity)).min(effort);
            let low = (saturation * (-1.0 - clipped / velocity)).max(-effort);
            let wanted = kp * (target - position) - kd * speed;
            let expected = wanted.max(low).min(high);
            assert!((tau[rate] - expected).abs() < 1e-12, "{speed}, {target}: {tau:?}");
            assert_eq!(next, [target + 0.1, 7.0]);
            tau[rate] = 0.0;
            assert!(tau.iter().all(|force| *force == 0.0), "{tau:?}");
            let region = |force: f64, end: f64| if force == end { 1 } else { 0 };
            regions.insert((
                region(expected, high),
                region(expected, low),
                region(expected.abs(), effort),
                speed.abs() > velocity,
                speed > 0.0,
            ));
        }
    }
    assert!(regions.len() >= 12, "{regions:?}");
}
