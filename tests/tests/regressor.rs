//! The regressor of inverse dynamics, which is linear in the inertias, and the base parameters.

use modyn_runtime::equations::identification::BaseParameters;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    DEFAULT_GRAVITY, Inertial, Joint, JointDynamics, JointFriction, Mimic, Model, MovingLink,
};
use modyn_runtime::spatial::Pose;
use modyn_runtime::{Interpreter, ShapeError};
use modyn_tests::close::assert_close;
use modyn_tests::floating::floated;
use modyn_tests::golden::{FIXED_BASE, model as read, urdf};
use modyn_tests::quantities::Quantities as _;
use modyn_tests::random::{Random, mixed_tree, tree};
use nalgebra::{DMatrix, DVector};

const LENGTHS: &str = "the lengths are right";

/// Returns a random state, without regard to limits: q, qd, qdd.
fn state(robot: &Interpreter<f64>, seed: u64) -> [Vec<f64>; 3] {
    let mut random = Random::new(!seed);
    let mut vector = |size: f64| -> Vec<f64> {
        (0..robot.model().nv()).map(|_| random.between(-size, size)).collect()
    };
    let (step, qd, qdd) = (vector(2.5), vector(2.0), vector(4.0));
    let mut neutral = vec![0.0; robot.model().nq()];
    robot.neutral(&mut neutral).expect(LENGTHS);
    let mut q = neutral.clone();
    robot.integrate(&neutral, &step, &mut q).expect(LENGTHS);
    [q, qd, qdd]
}

fn regressor(robot: &mut Interpreter<f64>, [q, qd, qdd]: &[Vec<f64>; 3]) -> DMatrix<f64> {
    let (rows, count) = (qd.len(), 10 * robot.model().moving_links().len());
    let mut columns = vec![0.0; rows * count];
    robot.regressor(q, qd, qdd, &mut columns).expect(LENGTHS);
    DMatrix::from_vec(rows, count, columns)
}

fn parameters(model: &Model) -> DVector<f64> {
    let all = (0..model.moving_links().len())
        .filter_map(|link| model.inertial_parameters(link))
        .flatten();
    DVector::from_vec(all.collect())
}

/// Returns the reference robots, on fixed and on floating bases.
fn robots() -> Vec<Model> {
    let extra = Inertial { mass: 3.0, center_of_mass: [0.1, 0.2, -0.1], inertia: [0.0; 6] };
    let fixed: Vec<Model> = FIXED_BASE.iter().map(|name| read(&urdf(name))).collect();
    let floating: Vec<Model> = fixed.iter().map(|model| floated(model, extra)).collect();
    [fixed, floating].concat()
}

/// Returns a random tree with joints of all types, some of which are mimic joints.
fn varied(seed: u64, links: usize) -> Model {
    let mut random = Random::new(seed);
    let model = mixed_tree(seed, links);
    let mut links = model.moving_links().to_vec();
    let mut leaders: Vec<usize> = Vec::new();
    for (i, link) in links.iter_mut().enumerate() {
        let joint = &mut link.joint;
        match random.below(8) {
            0 => {
                joint.joint_type = JointType::Universal;
                let [x, y, z] = joint.axis;
                joint.second_axis = [y, z, x];
                if (x * y + y * z + z * x).abs() > 0.9 {
                    joint.joint_type = JointType::Planar;
                }
            }
            1 => joint.joint_type = JointType::Planar,
            2 => joint.joint_type = JointType::Spherical,
            3 => joint.joint_type = JointType::Floating,
            _ => {
                if !leaders.is_empty() && random.chance(0.3) {
                    let leader = leaders[random.below(leaders.len())];
                    joint.mimic = Some(Mimic { leader, multiplier: -1.5, offset: 0.3 });
                } else {
                    leaders.push(i);
                }
            }
        }
    }
    Model::new("varied", model.gravity(), links, model.links().to_vec())
        .unwrap_or_else(|errors| panic!("seed {seed}: {errors:?}"))
}

/// Returns a single link on the world.
fn single(joint_type: JointType, axis: [f64; 3]) -> Model {
    let joint = Joint::new("joint", joint_type, axis, Pose::identity());
    let inertial = Inertial { mass: 1.0, center_of_mass: [0.1, 0.2, 0.3], inertia: [0.0; 6] };
    let links = vec![MovingLink { name: "link".into(), parent: None, joint, inertial }];
    Model::new("single", DEFAULT_GRAVITY, links, vec![]).expect("a valid model")
}

fn agrees(model: Model, seed: u64) {
    let name = model.name().to_owned();
    let mut robot = Interpreter::new(model);
    let state = state(&robot, seed);
    let [q, qd, qdd] = &state;
    let tau = regressor(&mut robot, &state) * parameters(robot.model());
    assert_close(&name, tau.as_slice(), &robot.tau(q, qd, qdd), 1e-10);
}

#[test]
fn torques_are_linear_in_the_inertias() {
    for model in robots() {
        (0..4).for_each(|seed| agrees(model.clone(), seed));
    }
    for seed in 0..200 {
        agrees(mixed_tree(seed, 1 + seed as usize % 12), seed);
        agrees(varied(seed, 1 + seed as usize % 12), seed);
    }
}

#[test]
fn joint_dynamics_are_not_in_the_regressor() {
    let model = tree(5, 6);
    let dynamics = JointDynamics { armature: 0.3, damping: 0.7, friction: 0.0 };
    let mut links = model.moving_links().to_vec();
    links.iter_mut().for_each(|link| link.joint.dynamics = dynamics);
    let model = Model::new("driven", model.gravity(), links, vec![]).expect("a valid model");
    let mut robot =
        Interpreter::new(model.with_joint_friction(JointFriction::Viscous).expect("sound"));
    let state = state(&robot, 5);
    let [q, qd, qdd] = &state;
    let linear = regressor(&mut robot, &state) * parameters(robot.model());
    let joints = 0.3 * DVector::from_column_slice(qdd) + 0.7 * DVector::from_column_slice(qd);
    assert_close("driven", (linear + joints).as_slice(), &robot.tau(q, qd, qdd), 1e-10);
}

/// Returns the regressors at many states, one below the other, with columns of length 1 (or 0).
fn stacked(robot: &mut Interpreter<f64>, seed: u64) -> DMatrix<f64> {
    let columns = 10 * robot.model().moving_links().len();
    let states = (3 * columns / robot.model().nv()).max(30) as u64;
    let blocks: Vec<DMatrix<f64>> = (0..states)
        .map(|k| {
            let state = state(robot, seed ^ (k << 8));
            regressor(robot, &state)
        })
        .collect();
    let nv = robot.model().nv();
    let mut all = DMatrix::from_fn(nv * blocks.len(), columns, |i, j| blocks[i / nv][(i % nv, j)]);
    let largest = all.column_iter().map(|column| column.norm()).fold(0.0, f64::max);
    for mut column in all.column_iter_mut() {
        let norm = column.norm();
        column /= if norm > 1e-7 * largest { norm } else { f64::INFINITY };
    }
    all
}

fn rank(matrix: &DMatrix<f64>) -> usize {
    let triangle = matrix.clone().qr().r();
    let values = triangle.singular_values();
    values.iter().filter(|x| **x > 1e-7 * values.max()).count()
}

fn base_parameters_are_a_basis(model: Model, seed: u64) {
    let what = format!("{}, {} links, seed {seed}", model.name(), model.moving_links().len());
    let base = BaseParameters::new(&model);
    let mut robot = Interpreter::new(model);
    let all = stacked(&mut robot, seed);
    assert_eq!(base.parameters.len(), rank(&all), "{what}: as many as the rank");
    let kept = all.select_columns(&base.regressor_columns());
    assert_eq!(base.parameters.len(), rank(&kept), "{what}: independent");
    let values = DVector::from_vec(base.values(robot.model()));
    let state = state(&robot, seed);
    let [q, qd, qdd] = &state;
    let columns = regressor(&mut robot, &state).select_columns(&base.regressor_columns());
    let tau = columns * values;
    assert_close(&what, tau.as_slice(), &robot.tau(q, qd, qdd), 1e-10);
}

#[test]
fn base_parameters_of_reference_robots() {
    for (k, model) in robots().into_iter().enumerate() {
        base_parameters_are_a_basis(model, k as u64);
    }
}

#[test]
fn base_parameters_of_random_robots() {
    for seed in 0..60 {
        base_parameters_are_a_basis(mixed_tree(seed, 1 + seed as usize % 8), seed);
        base_parameters_are_a_basis(varied(seed, 1 + seed as usize % 6), seed);
    }
}

#[test]
fn counts_are_the_textbooks() {
    let count = |model: &Model| BaseParameters::new(model).parameters.len();
    let named = |name: &str| read(&urdf(name));
    // Seven for each revolute joint; one for a first joint with a vertical axis (Gautier and Khalil 1990).
    assert_eq!(count(&named("ur5")), 36);
    assert_eq!(count(&named("panda")), 43);
    // Ten for a floating base.
    assert_eq!(count(&floated(&named("solo12"), Inertial::default())), 10 + 12 * 7);
    assert_eq!(count(&single(JointType::Revolute, [0.0, 0.0, 1.0])), 1);
    assert_eq!(count(&single(JointType::Revolute, [1.0, 0.0, 0.0])), 3);
    assert_eq!(count(&single(JointType::Prismatic, [0.6, 0.0, 0.8])), 1);
    assert_eq!(count(&single(JointType::Spherical, [0.0, 0.0, 1.0])), 9);
    assert_eq!(count(&single(JointType::Floating, [0.0, 0.0, 1.0])), 10);
}

#[test]
fn base_parameters_are_named_by_their_links() {
    let base = BaseParameters::new(&read(&urdf("ur5")));
    let names: Vec<&str> = base.parameters.iter().map(|parameter| parameter.name()).collect();
    assert_eq!(
        names[2],
        "mcz_upper_arm_link + m_forearm_link * 0.425 + m_wrist_1_link * 0.425 \
         + m_wrist_2_link * 0.425 + m_wrist_3_link * 0.425"
    );
    assert_eq!(names[24], "Ixx_wrist_2_link - Iyy_wrist_2_link + Izz_wrist_3_link");
    assert_eq!(names[35], "Iyz_wrist_3_link");
    assert_eq!(base.parameters[35].kept, 58);
    let index = |link: usize, parameter: usize| 10 * link + parameter;
    let expected = [(index(4, 4), 1.0), (index(4, 7), -1.0), (index(5, 9), 1.0)];
    let found = base.parameters.iter().find(|one| one.kept == index(4, 4)).expect("Ixx of wrist 2");
    assert_eq!(found.combination, expected);
}

#[test]
fn unidentifiable_parameters_are_in_no_combination() {
    let base = BaseParameters::new(&single(JointType::Revolute, [0.0, 0.0, 1.0]));
    let [izz] = &base.parameters[..] else { panic!("{base:?}") };
    assert_eq!((izz.kept, &izz.combination[..], izz.name()), (9, &[(9, 1.0)][..], "Izz_link"));
}

#[test]
fn lengths_are_checked() {
    let mut robot = Interpreter::new(tree(1, 3));
    let (v, short, mut columns) = (vec![0.0; 3], [0.0], vec![0.0; 90]);
    let error = |parameter, expected| Err(ShapeError::new(parameter, expected, 1));
    assert_eq!(robot.regressor(&short, &v, &v, &mut columns), error("q", 3));
    assert_eq!(robot.regressor(&v, &short, &v, &mut columns), error("qd", 3));
    assert_eq!(robot.regressor(&v, &v, &short, &mut columns), error("qdd", 3));
    assert_eq!(robot.regressor(&v, &v, &v, &mut [0.0]), error("columns", 90));
}
