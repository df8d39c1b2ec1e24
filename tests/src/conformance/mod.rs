//! The suite of all back ends: each computes every function of a plan on robots of every kind, and gives the results of the
//! plan's evaluation. The evaluation itself is compared with the interpreter elsewhere.
//!
//! A back end is a [`BackEnd`]: the robot that it makes, the arithmetic of its results, and a function that runs calls. The file
//! is part of this package, and by its path of the tests of the compiler and of the crate for graphics processors.

pub mod c;
pub mod numbers;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::plan::{Plan, Planned, Shape};
use modyn_codegen::{
    Base, Builder, CodeForm, Contact, ContactKind, Emitted, FloatType, Function, FusedFunction,
    Interpreter, LoopEnd, Planning, UserArgument, UserError, UserFunction,
};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    Activation, ActivationDynamics, Actuation, Actuator, AffineLaw, FixedTendon, Integrator,
    JointForceRange, JointFriction, Model, MovingLink, SoftConstraints, Spring, TendonJoint,
    TorqueSpeedLine, Transmission,
};
use modyn_runtime::{ConstraintSettings, ContactTarget, Scalar};

use crate::random::{Random, normalize_configuration, with_tendons};
use numbers::{Reference, evaluate, is_same};

pub use numbers::Arithmetic;

/// The number of states of each function.
pub const STATES: usize = 8;

/// A robot with options.
pub struct Case {
    /// The name.
    pub name: &'static str,
    /// The robot.
    pub builder: Builder,
}

/// Functions that most users need, without long derivatives.
pub const USED: [Function; 21] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::BiasForces,
    Function::GravityTorques,
    Function::MassMatrix,
    Function::KineticEnergy,
    Function::PotentialEnergy,
    Function::CenterOfMass,
    Function::CenterOfMassJacobian,
    Function::CentroidalMomentum,
    Function::CentroidalMomentumMatrix,
    Function::LinkPoses,
    Function::LinkPose,
    Function::LinkVelocity,
    Function::Jacobian,
    Function::JacobianDotQd,
    Function::JacobianLocal,
    Function::Integrate,
    Function::Difference,
    Function::VelocityToQdot,
    Function::NormalizeConfiguration,
];

/// Returns the builder of a robot of the repository.
///
/// # Panics
///
/// If there is no such robot.
#[must_use]
pub fn robot(name: &str) -> Builder {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let file =
        ["robots", "tests/golden"].map(|folder| root.join(folder).join(format!("{name}.urdf")));
    Builder::new().urdf(file.iter().find(|file| file.exists()).expect("a robot"))
}

/// Returns a contact at this point of a link, rotated.
#[must_use]
pub fn contact(name: &str, kind: ContactKind, link: &str, xyz: [f64; 3]) -> Contact {
    let end = LoopEnd { link: link.into(), xyz, rpy: [0.1, 0.2, 0.3] };
    Contact { name: name.into(), kind, end }
}

/// Returns a small robot with a contact and all functions.
#[must_use]
pub fn small() -> Case {
    let toe = contact("toe", ContactKind::Point, "lower", [0.1, 0.2, -0.3]);
    let builder = robot("double_pendulum").contacts([toe]);
    Case { name: "double_pendulum", builder: builder.functions(Function::ALL.iter().copied()) }
}

/// Returns a large robot on a floating base with the functions of [`USED`] and those of its two contacts.
#[must_use]
pub fn large() -> Case {
    let functions = USED.into_iter().chain([
        Function::ConstrainedForwardDynamics,
        Function::ConstraintResidual,
        Function::ImpactDynamics,
        Function::ConstraintJacobian,
        Function::Step,
        Function::TouchingPoints,
    ]);
    let feet = [
        contact("left", ContactKind::Point, "front_left_foot", [0.0, 0.01, -0.02]),
        contact("right", ContactKind::Surface, "hind_right_foot", [0.03, -0.01, 0.02]),
    ];
    let builder = robot("quadruped").base(Base::Floating).contacts(feet).functions(functions);
    Case { name: "quadruped", builder }
}

/// Returns robots of every other kind: all joint types, closed loops, mimic joints, run-time parameters, equal limbs in
/// routines, loops over bodies, products of matrices in loops, dependent rows of contacts, many
/// links on one body, fused functions, functions of the user, a solver and its derivatives, tendons, and actuators.
///
/// # Panics
///
/// If a robot of the repository has other links.
#[must_use]
pub fn kinds() -> Vec<Case> {
    let case = |name, builder: Builder| Case { name, builder };
    let looped = [Function::ForwardDynamics, Function::InverseDynamics];
    let gripper = robot("gripper").runtime_gravity();
    let links = gripper.generate().expect("good").model.moving_links().to_vec();
    let [replaced, loaded] = [1, 2].map(|link: usize| links[link].name.clone());
    vec![
        case("joint_zoo", sprung().functions(USED)),
        case("five_bar", robot("five_bar")),
        case("mimic_gripper", robot("mimic_gripper").functions(USED)),
        case("parameters", gripper.runtime_inertia([replaced]).payload([loaded])),
        case("routines", robot("quadruped").share_limbs().functions(USED)),
        case("loops", sprung().functions(looped).code(CodeForm::Looped).runtime_gravity()),
        case("products", products()),
        case("columns", columns()),
        case("column", column()),
        case("points", points()),
        case("comb", comb().functions(USED)),
        case("own_functions", own_functions()),
        case("solver", solver()),
        case("tendons", tendons()),
        case("actuators", actuated(true)),
        case("motors", actuated(false)),
    ]
}

/// Returns a robot whose derivatives and Hessian multiply matrices in loops, and add the free fall of its base; those of a step have no
/// loops.
fn products() -> Builder {
    let functions = [
        Function::ForwardDynamicsDerivatives,
        Function::ForwardDynamicsDerivativesBatch,
        Function::ForwardDynamicsHessian,
        Function::ForwardDynamicsHessianBatch,
        Function::StepSemiImplicitDerivatives,
        Function::Knot,
        Function::KnotBatch,
    ];
    robot("arm6").base(Base::Floating).functions(functions).code(CodeForm::Looped)
}

/// Returns a robot whose derivatives under constraints are products of one matrix with many columns, in loops.
fn columns() -> Builder {
    let functions = [
        Function::ConstrainedForwardDynamicsDerivatives,
        Function::ConstrainedForwardDynamicsDerivativesBatch,
        Function::ConstrainedKnot,
        Function::ConstrainedKnotBatch,
    ];
    let hand = contact("hand", ContactKind::Surface, "wrist_3_link", [0.1, 0.0, -0.2]);
    let arm = robot("ur5").base(Base::Floating).contacts([hand]);
    arm.functions(functions).code(CodeForm::Looped)
}

/// Returns the same of a robot with one joint, whose matrices have one column, and two contacts.
fn column() -> Builder {
    let text = r#"<robot name="pendulum"><link name="base"/><link name="bob"><inertial>
        <origin xyz="0.1 0.2 -0.3"/><mass value="1.5"/>
        <inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0.01" ixz="0.02" iyz="-0.01"/></inertial></link>
        <joint name="pivot" type="continuous"><parent link="base"/><child link="bob"/>
        <origin xyz="0.3 -0.1 0.2" rpy="0.4 0.1 -0.2"/><axis xyz="0.6 0 0.8"/></joint></robot>"#;
    let contacts = [
        contact("toe", ContactKind::Point, "bob", [0.1, 0.2, -0.3]),
        contact("sole", ContactKind::Surface, "bob", [-0.2, 0.1, -0.1]),
    ];
    let functions = [Function::ConstrainedForwardDynamicsDerivatives, Function::ConstrainedKnot];
    let pendulum = Builder::new().urdf_text(text, "pendulum.urdf").contacts(contacts);
    pendulum.functions(functions).code(CodeForm::Looped)
}

/// Returns a robot with two contacts of one link, which have a dependent row if both are active.
fn points() -> Builder {
    let functions = [
        Function::ConstrainedForwardDynamics,
        Function::ImpactDynamics,
        Function::ProjectConstraints,
    ];
    let points = [
        contact("toe", ContactKind::Point, "wrist_3_link", [0.1, 0.2, -0.3]),
        contact("heel", ContactKind::Point, "wrist_3_link", [-0.2, 0.1, -0.1]),
    ];
    robot("ur5").base(Base::Floating).contacts(points).functions(functions)
}

/// Returns a robot with a contact, a joint stop and dry friction, whose step is a loop that ends early.
fn solver() -> Builder {
    let text = include_str!("../../../robots/double_pendulum.urdf");
    let axis = r#"<axis xyz="0 1 0"/>"#;
    let text = text.replace(axis, &format!(r#"{axis}<dynamics damping="0.1" friction="0.3"/>"#));
    let toe = contact("toe", ContactKind::Point, "lower", [0.1, 0.2, -0.3]);
    let pendulum = Builder::new().urdf_text(text, "double_pendulum.urdf").contacts([toe]);
    let functions =
        [Function::Step, Function::StepDerivatives, Function::StepVjp, Function::StepJvp];
    pendulum.joint_friction(JointFriction::Coulomb).runtime_gravity().functions(functions)
}

/// Returns a gripper with tendons and a coupling, one finger of which is a mimic joint.
fn tendons() -> Builder {
    let model = robot("mimic_gripper").generate().expect("good").model;
    Builder::new().model(with_tendons(model, 1)).functions([Function::Step])
}

/// Returns a gripper with actuators, among them some of a mimic joint and of a tendon and some with a
/// torque-speed line. With activations and delays the integrator is `Euler`, without `implicitfast`.
fn actuated(activates: bool) -> Builder {
    let model = robot("mimic_gripper").generate().expect("good").model;
    let links = model.moving_links().iter().enumerate();
    let single = links.filter(|(_, link)| link.joint.joint_type.nv() == 1);
    let joints: Vec<usize> = single.map(|(link, _)| link).collect();
    let tendon = FixedTendon {
        name: "tendon".into(),
        joints: joints.iter().map(|&link| TendonJoint { link, coefficient: 0.7 }).collect(),
        offset: 0.2,
        force_range: Some([-0.4, 0.3]),
    };
    let filters = [
        ActivationDynamics::Integrator,
        ActivationDynamics::Filter(0.02),
        ActivationDynamics::ExactFilter(0.03),
    ];
    let actuator = |k: usize| Actuator {
        name: format!("motor_{k}"),
        transmission: match k % 4 {
            3 => Transmission::Tendon(0),
            _ => Transmission::Joint(joints[k % joints.len()]),
        },
        gear: 1.5 - 0.4 * k as f64,
        gain: AffineLaw { constant: 0.8, length: 0.1 * k as f64, velocity: 0.2 },
        bias: AffineLaw { constant: 0.1, length: -0.3, velocity: -0.1 * k as f64 },
        control_range: k.is_multiple_of(2).then_some([-0.6, 0.5]),
        torque_speed_line: (k % 4 > 1)
            .then_some(TorqueSpeedLine { stall_force: 0.3, no_load_speed: 0.7 }),
        force_range: k.is_multiple_of(3).then_some([-0.5, 0.4]),
        delay: if activates { [0, 3, 1, 0, 2, 1, 0, 0][k] } else { 0 },
        activation: (activates && ![0, 4].contains(&k)).then(|| Activation {
            dynamics: filters[k % 3],
            range: k.is_multiple_of(2).then_some([-0.5, 0.7]),
            early: k % 2 == 1,
        }),
        enabled: k != 5,
    };
    let force_range = JointForceRange { link: joints[0], range: [-0.3, 0.5] };
    let actuation = Actuation {
        actuators: (0..8).map(actuator).collect(),
        tendons: vec![tendon],
        joint_force_ranges: vec![force_range],
    };
    let integrator = if activates { Integrator::Euler } else { Integrator::ImplicitFast };
    let soft = SoftConstraints { integrator, ..model.soft_constraints().clone() };
    let model = model.with_actuation(actuation).and_then(|model| model.with_soft_constraints(soft));
    let model = model.expect("good actuators");
    let functions = [Function::Actuate, Function::ActuateBatch, Function::StepActuated];
    Builder::new().model(model).functions(functions)
}

/// Returns a robot with all joint types, and a spring at each joint.
fn sprung() -> Builder {
    let model = robot("joint_zoo").generate().expect("good").model;
    let unit = [0.1, 0.5, -0.7, 0.5];
    let spring = |(link, described): (usize, &MovingLink)| {
        let reference = match described.joint.joint_type {
            JointType::Spherical => unit.to_vec(),
            JointType::Floating => [&[0.3, -0.2, 0.4][..], &unit].concat(),
            joint_type => vec![0.4; joint_type.nq()],
        };
        Spring { link, stiffness: 3.0 + link as f64, reference }
    };
    let springs = model.moving_links().iter().enumerate().map(spring).collect();
    Builder::new().model(model.with_springs(springs).expect("good springs"))
}

/// Returns an arm with a fused function, of which some functions are of one link and one has several results, and a
/// function of the user with its derivatives.
fn own_functions() -> Builder {
    let fused = FusedFunction::new("control")
        .function(Function::MassMatrix)
        .function(Function::ForwardDynamicsDerivatives)
        .of_link(Function::Jacobian, "wrist_3_link")
        .function(Function::KineticEnergy)
        .of_link(Function::LinkPose, "forearm_link");
    let builder = robot("ur5").functions([Function::GravityTorques]);
    builder.fused([fused]).function("reach", Reach).runtime_gravity()
}

/// A cost of reaching a target.
struct Reach;

impl UserFunction<3> for Reach {
    fn docs(&self) -> String {
        "Returns the squared distance of the wrist to `target`, times `weight`.".into()
    }

    fn arguments(&self) -> [UserArgument; 3] {
        let weight = UserArgument::number("weight").variable();
        [UserArgument::Q, UserArgument::numbers("target", 3), weight]
    }

    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        [q, target, weight]: [&[S]; 3],
    ) -> Result<Vec<S>, UserError> {
        let link = robot.model().link_index("wrist_3_link").ok_or("there is no wrist")?;
        let pose = robot.link_pose(q, link)?;
        let squares = pose.translation.iter().zip(target).map(|(&x, &t)| (x - t) * (x - t));
        Ok(vec![weight[0] * squares.fold(S::zero(), |sum, square| sum + square)])
    }
}

/// Returns three bodies with 11, 1 and 11 links: on each body, the links after the eighth share a function.
fn comb() -> Builder {
    let mut text = String::from("<robot name='comb'><link name='b0'/>");
    for (body, links) in [11, 0, 10].into_iter().enumerate() {
        for i in 0..links {
            let x = 0.1 * f64::from(i) + 0.3 * [0.0, 1.0, 2.0][body];
            let _ = write!(
                text,
                "<link name='f{body}_{i}'/><joint name='fix{body}_{i}' type='fixed'><parent link='b{body}'/>\
                 <child link='f{body}_{i}'/><origin xyz='{x} {} {}' rpy='{} {x} {}'/></joint>",
                0.2 - x,
                0.5 * x,
                0.7 - x,
                1.1 * x,
            );
        }
        if body < 2 {
            let _ = write!(
                text,
                "<joint name='j{body}' type='continuous'><parent link='b{body}'/><child link='b{next}'/>\
                 <origin xyz='0.1 -0.2 0.3' rpy='0.4 0.5 -0.9'/><axis xyz='0.6 0.48 0.64'/></joint>\
                 <link name='b{next}'><inertial><origin xyz='0.1 0.02 -0.03'/><mass value='1.5'/>\
                 <inertia ixx='0.3' iyy='0.4' izz='0.5' ixy='0.01' ixz='0.02' iyz='-0.03'/></inertial></link>",
                next = body + 1,
            );
        }
    }
    Builder::new().urdf_text(text + "</robot>", "comb.urdf")
}

/// A robot that a back end has made, with the plan that it follows.
pub trait Made {
    /// Returns the plan and the robot.
    fn parts(&self) -> (&Plan, &Model);
}

impl Made for Emitted {
    fn parts(&self) -> (&Plan, &Model) {
        (&self.plan, &self.model)
    }
}

impl Made for Planning {
    fn parts(&self) -> (&Plan, &Model) {
        (&self.plan, &self.model)
    }
}

/// A robot with what else a back end needs.
impl<M: Made, X> Made for (M, X) {
    fn parts(&self) -> (&Plan, &Model) {
        self.0.parts()
    }
}

/// A back end of the suite.
pub trait BackEnd {
    /// A robot of this back end.
    type Robot: Made;

    /// Returns the name.
    fn name(&self) -> String;

    /// Returns the arithmetic of the results.
    fn arithmetic(&self) -> Arithmetic;

    /// Returns the programs besides gcc that must be installed; without them the tests of the back end do not run.
    fn programs(&self) -> &[&'static str] {
        &[]
    }

    /// Returns whether the back end has a function.
    fn has(&self, _: &Planned) -> bool {
        true
    }

    /// Returns whether one state is computed by programs on vectors, where there are some.
    fn on_vectors(&self, _: FloatType) -> bool {
        false
    }

    /// Returns whether calls have run-time parameters; else these are those of the description.
    fn takes_parameters(&self) -> bool {
        true
    }

    /// Returns whether a set of contacts is numbers, which may be NaN; else it is booleans.
    fn has_numbers_of_contacts(&self) -> bool {
        true
    }

    /// Makes the robot.
    ///
    /// # Errors
    ///
    /// If the robot is refused.
    fn make(&self, builder: &Builder) -> Result<Self::Robot, Diagnostics>;

    /// Runs all calls, one after another. There are [`STATES`] calls of each function and link.
    fn run(&self, subject: &Subject<'_, Self::Robot>, folder: &Path) -> Vec<Vec<f64>>;
}

/// A robot with calls.
pub struct Subject<'a, R> {
    /// The robot.
    pub robot: &'a R,
    /// The precision.
    pub float: FloatType,
    /// The calls.
    pub calls: Vec<Call>,
}

/// A call of a function for one state.
pub struct Call {
    /// The name of the function.
    pub function: String,
    /// The link of a function of a link.
    pub link: Option<usize>,
    /// Whether the last array is the run-time parameters.
    pub has_parameters: bool,
    /// The arrays of arguments that have numbers.
    pub arguments: Vec<Vec<f64>>,
    /// The layout of the result.
    pub shape: Shape,
    /// The numbers of the result.
    pub expected: Vec<f64>,
    /// The largest error, if the arithmetic is not the reference's; else the bits are the same.
    pub tolerance: Option<f64>,
}

/// Returns whether the programs of a back end are installed.
pub fn is_installed(back_end: &impl BackEnd) -> bool {
    let runs = |name: &str| Command::new(name).arg("--version").output().is_ok();
    let missing = back_end.programs().iter().find(|name| !runs(name));
    if let Some(name) = missing {
        println!("not compared: {name} is not installed");
    }
    missing.is_none()
}

/// Compares a back end with the evaluation of its programs. Returns the number of compared results.
///
/// # Panics
///
/// If a result differs.
pub fn conforms<B: BackEnd>(back_end: &B, case: &Case, float: FloatType) -> usize {
    let builder = case.builder.clone().type_name("Ours").scalar(float);
    let robot = back_end.make(&builder).unwrap_or_else(|errors| panic!("{}: {errors}", case.name));
    robot_conforms(back_end, case.name, &robot, float)
}

/// Compares a robot of a back end with the evaluation of its programs. Returns the number of compared results.
///
/// # Panics
///
/// If a result differs.
pub fn robot_conforms<B: BackEnd>(
    back_end: &B,
    name: &str,
    robot: &B::Robot,
    float: FloatType,
) -> usize {
    let (plan, model) = robot.parts();
    let mut calls = Vec::new();
    for planned in plan.functions.iter().filter(|planned| back_end.has(planned)) {
        if !planned.result.is_empty() {
            calls.extend(calls_of(back_end, (plan, model), planned, float));
        }
    }
    let subject = Subject { robot, float, calls };
    let folder = folder(&format!("{}_{name}_{float:?}", back_end.name()));
    let found = back_end.run(&subject, &folder);
    compare(&format!("{}, {name}, {float:?}", back_end.name()), &subject.calls, &found);
    subject.calls.len()
}

/// Compares the results of calls with the expected ones.
///
/// # Panics
///
/// If a result differs.
pub fn compare(name: &str, calls: &[Call], found: &[Vec<f64>]) {
    assert_eq!(calls.len(), found.len(), "{name}");
    let mut moving = 0;
    for (number, (call, found)) in calls.iter().zip(found).enumerate() {
        let Call { function, link, expected, tolerance, .. } = call;
        let place = format!("{name}, {function} of link {link:?}, state {}", number % STATES);
        assert_eq!(found.len(), expected.len(), "{place}");
        for (i, (&a, &b)) in found.iter().zip(expected).enumerate() {
            let is_near = tolerance.is_some_and(|tolerance| (a - b).abs() <= tolerance);
            assert!(
                is_near || is_same(a, b),
                "{place}, number {i}: {a:e}, not {b:e}, {tolerance:?}"
            );
            moving += usize::from(b != 0.0);
        }
    }
    assert!(moving >= calls.len() / 2, "{name}: nothing moves");
}

/// Returns the calls of a function: each link in each state.
fn calls_of<B: BackEnd>(
    back_end: &B,
    (plan, model): (&Plan, &Model),
    planned: &Planned,
    float: FloatType,
) -> Vec<Call> {
    let links = if planned.is_by_link() { plan.frames.programs().len() } else { 1 };
    let defaults = plan.parameters.described(model.gravity());
    let name: u64 = planned.name.bytes().map(u64::from).sum();
    let (mut random, mut calls) = (Random::new(name), Vec::new());
    let arithmetic = back_end.arithmetic();
    let given = planned.parameters > 0 && back_end.takes_parameters();
    for link in 0..links {
        let of = Reference {
            planned,
            frames: &plan.frames,
            link,
            on_vectors: back_end.on_vectors(float),
        };
        for state in 0..STATES {
            // Far angles have a reduction of their own; a language's own sine is not compared there.
            let scale = match arithmetic {
                Arithmetic::Own(_) => [1.0, 2.0, 50.0, 1.0, 1.0, 1.0, 1.0, 1.0][state],
                _ => [1.0, 2.0, 50.0, 1500.0, 1e7, 1e20, 1.0, 1.0][state],
            };
            let mut arguments = arguments(&mut random, (model, planned), scale);
            if planned.parameters > 0 {
                let near = |x: &f64| x + 0.01 * random.between(0.0, 1.0);
                arguments.push(if given {
                    defaults.iter().map(near).collect()
                } else {
                    defaults.clone()
                });
            }
            if state >= STATES - 2 && !matches!(arithmetic, Arithmetic::Own(_)) {
                // A special flag of a contact is no boolean. Special settings, times and random
                // numbers are errors in Python.
                let mut given = planned.arguments.iter().filter(|(_, shape)| !shape.is_empty());
                let has_flags = given.any(|(argument, _)| argument.name == "active");
                let of_numbers = back_end.has_numbers_of_contacts();
                let can_be_special = |name: &str| match name {
                    "active" if !of_numbers => false,
                    _ if has_flags && of_numbers && state == STATES - 1 => name == "active",
                    _ => !["settings", "step_settings", "dt", "uniforms"].contains(&name),
                };
                let mut ordinary: Vec<&mut f64> = (planned.arguments.iter())
                    .zip(&mut arguments)
                    .filter(|((argument, _), _)| can_be_special(argument.name))
                    .flat_map(|(_, numbers)| numbers)
                    .collect();
                set_special(&mut random, &mut ordinary);
            }
            if float == FloatType::F32 {
                arguments.iter_mut().flatten().for_each(|x| *x = f64::from(*x as f32));
            }
            let all = arguments.concat();
            let (expected, tolerance) = match (arithmetic, float) {
                (Arithmetic::Own(part), _) => {
                    let expected = evaluate(&of, arithmetic, &all);
                    let tolerance = tolerance(&of, (part, float), &all, &expected);
                    (expected, Some(tolerance))
                }
                (_, FloatType::F64) => (evaluate(&of, arithmetic, &all), None),
                (_, FloatType::F32) => (in_single_precision(&of, arithmetic, &all), None),
            };
            if planned.parameters > 0 && !given {
                arguments.pop();
            }
            calls.push(Call {
                function: planned.name.into(),
                link: planned.is_by_link().then_some(link),
                has_parameters: given,
                arguments: arguments.into_iter().filter(|array| !array.is_empty()).collect(),
                shape: planned.result.clone(),
                expected,
                tolerance,
            });
        }
    }
    calls
}

/// Puts an infinity, NaN, a zero or a subnormal number among numbers.
fn set_special(random: &mut Random, numbers: &mut [&mut f64]) {
    const SPECIAL: [f64; 6] = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 0.0, -0.0, 1e-310];
    if !numbers.is_empty() {
        *numbers[random.below(numbers.len())] = SPECIAL[random.below(6)];
    }
}

/// Returns the largest error of results if each argument is rounded by a part of it, and each sum by a part of the largest
/// result: 64 times the largest change in four states that are that near. In single precision it is at least 8 times the largest error
/// of eight evaluations at these states: where terms nearly cancel, one evaluation may have a twentieth of the error of another.
fn tolerance(
    of: &Reference<'_>,
    (part, float): (f64, FloatType),
    arguments: &[f64],
    expected: &[f64],
) -> f64 {
    let mut random = Random::new(7);
    let largest = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
    let (mut spread, mut rounded) = (0.0_f64, 0.0_f64);
    for _ in 0..4 {
        let shaken: Vec<f64> =
            arguments.iter().map(|x| x * (1.0 + random.between(-part, part))).collect();
        let exact = evaluate(of, Arithmetic::Separate, &shaken);
        spread = spread.max(largest_change(&exact, expected));
        if float == FloatType::F32 {
            for arithmetic in [Arithmetic::Separate, Arithmetic::Fused] {
                let single = in_single_precision(of, arithmetic, &shaken);
                rounded = rounded.max(largest_change(&single, expected));
            }
        }
    }
    (64.0 * (part * largest + spread)).max(8.0 * rounded)
}

/// Returns the largest difference of two lists of numbers.
fn largest_change(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

/// Returns results that are rounded to `f32` after each operation.
fn in_single_precision(of: &Reference<'_>, arithmetic: Arithmetic, arguments: &[f64]) -> Vec<f64> {
    let numbers: Vec<f32> = arguments.iter().map(|&x| x as f32).collect();
    evaluate(of, arithmetic, &numbers).into_iter().map(f64::from).collect()
}

/// Returns numbers in general position for the arguments of a function, each an array.
fn arguments(
    random: &mut Random,
    (model, planned): (&Model, &Planned),
    scale: f64,
) -> Vec<Vec<f64>> {
    let mut arrays = Vec::new();
    for (argument, shape) in &planned.arguments {
        let mut numbers: Vec<f64> =
            (0..shape.len()).map(|_| random.between(-scale, scale)).collect();
        match argument.name {
            // Quaternions have length one, except where they are scaled to it.
            "q" | "from" | "to" if planned.name != "normalize_configuration" => {
                normalize_configuration(model, &mut numbers)
            }
            // A contact is active or not.
            "active" => {
                numbers.iter_mut().for_each(|x| *x = if *x > 0.0 { 1.0 } else { 0.0 });
            }
            "settings" => set_settings(random, &mut numbers),
            "step_settings" => numbers = random.step_settings(model.touching_shapes().len()),
            "dt" => numbers[0] = 0.01 * numbers[0].abs() / scale,
            "uniforms" => numbers.iter_mut().for_each(|x| *x = (x.abs() / scale).min(0.99)),
            _ => {}
        }
        arrays.push(numbers);
    }
    arrays
}

/// Puts settings within their ranges: others are errors in Python. The limits of dependent rows are small, since results are not
/// continuous there.
fn set_settings(random: &mut Random, numbers: &mut [f64]) {
    let mut settings = ConstraintSettings::<f64>::DEFAULT;
    settings.alpha = random.between(0.0, 3.0);
    settings.beta = random.between(0.0, 3.0);
    settings.tolerance = 1e-10;
    settings.rounding = 1e-10;
    let (common, targets) = numbers.split_at_mut(ConstraintSettings::<f64>::COUNT);
    common.copy_from_slice(&settings.numbers());
    for numbers in targets.chunks_exact_mut(ContactTarget::<f64>::COUNT) {
        let mut target = ContactTarget::from_numbers(core::array::from_fn(|k| numbers[k]));
        target.pose.rotation = random.any_rotation();
        target.tangential = random.between(0.0, 1.0);
        target.alpha = random.between(0.0, 3.0);
        target.beta = random.between(0.0, 3.0);
        target.compliance = random.between(0.0, 1.0);
        target.restitution = random.between(0.0, 1.0);
        target.weight = random.between(0.1, 1.0);
        numbers.copy_from_slice(&target.numbers());
    }
}

/// Returns the folder of this name, within the target folder of the running test.
///
/// # Panics
///
/// If it cannot be made.
#[must_use]
pub fn folder(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a test");
    let target = test.ancestors().nth(3).expect("in `target/debug/deps`");
    let folder = target.join("tmp/conformance").join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Runs a command without errors and warnings, and returns its output.
///
/// # Panics
///
/// If the command fails or prints warnings.
pub fn command(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, errors) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{command:?}\n{out}\n{errors}");
    // GNU Octave sometimes says this at its end, after all work.
    let is_said = |line: &str| !line.starts_with("error: ignoring const execution_exception&");
    let errors: Vec<&str> = errors.lines().filter(|line| is_said(line)).collect();
    assert!(errors.is_empty(), "{command:?}: {errors:?}");
    out
}

/// Writes numbers in a precision, one after another.
///
/// # Panics
///
/// If the file cannot be written.
pub fn write_numbers<'a>(
    file: &Path,
    numbers: impl IntoIterator<Item = &'a f64>,
    float: FloatType,
) {
    let bytes = numbers.into_iter().flat_map(|&x| match float {
        FloatType::F64 => x.to_ne_bytes().to_vec(),
        FloatType::F32 => (x as f32).to_ne_bytes().to_vec(),
    });
    std::fs::write(file, bytes.collect::<Vec<u8>>()).expect("writes");
}

/// Reads the results of calls, one after another.
///
/// # Panics
///
/// If the file is missing or has another length.
#[must_use]
pub fn read_results(file: &Path, calls: &[Call], float: FloatType) -> Vec<Vec<f64>> {
    let bytes = std::fs::read(file).expect("the results");
    let numbers: Vec<f64> = match float {
        FloatType::F64 => bytes.as_chunks().0.iter().map(|x| f64::from_ne_bytes(*x)).collect(),
        FloatType::F32 => {
            bytes.as_chunks().0.iter().map(|x| f32::from_ne_bytes(*x).into()).collect()
        }
    };
    let mut rest = &*numbers;
    let results = calls.iter().map(|call| {
        let (own, after) = rest.split_at(call.expected.len());
        rest = after;
        own.to_vec()
    });
    let results = results.collect();
    assert!(rest.is_empty(), "{} numbers too many", rest.len());
    results
}
