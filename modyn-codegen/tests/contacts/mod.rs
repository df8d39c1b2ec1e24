//! Contacts: accelerations and wrenches against dense solutions of M qdd = tau - h + J^T f by singular values, with M, h
//! and J from other functions; random masks on random trees; graphs against the interpreter.

mod derivatives;
mod order;
mod stretched;

use modyn_codegen::passes::optimize;
use modyn_codegen::plan::{COLUMN_LANES, LIMB_LIMITS, Sizes};
use modyn_codegen::program::{Execution, Program};
use modyn_codegen::trace::{DenseLoops, LimbPacking, Tracer};
use modyn_codegen::{Base, Builder, Contact, ContactKind, Function, LoopEnd, ReadOptions, read};
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::constraints::{
    ConstrainedInverseOutputs, ConstrainedOutputs, ImpulseOutputs, OperationalSpaceInertiaOutputs,
    ProjectionOutputs, ResidualOutputs,
};
use modyn_runtime::equations::{self, ForwardInput, Motion};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{
    LoopConstraint, LoopConstraintEnd, LoopConstraintKind, Model, ModelErrorKind, ModuleTree,
};
use modyn_runtime::spatial::{Pose, Twist, Vector3, Wrench};
use modyn_runtime::{ConstrainedDerivatives, ConstraintSettings, ContactTarget, Interpreter};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3 as V3};

const QUADRUPED: &str = include_str!("../../../robots/quadruped.urdf");
const HUMANOID: &str = include_str!("../../../robots/humanoid.urdf");

struct Random(u64);

impl Random {
    /// In [-1, 1).
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        #[allow(clippy::cast_precision_loss)]
        let unit = (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        2.0 * unit - 1.0
    }

    fn vector(&mut self, n: usize, size: f64) -> Vec<f64> {
        (0..n).map(|_| size * self.next()).collect()
    }

    fn three(&mut self, size: f64) -> [f64; 3] {
        [0; 3].map(|_| size * self.next())
    }
}

fn contact(name: &str, kind: ContactKind, link: &str, [xyz, rpy]: [[f64; 3]; 2]) -> Contact {
    Contact { name: name.into(), kind, end: LoopEnd { link: link.into(), xyz, rpy } }
}

fn model_of(text: &str, base: Base, contacts: Vec<Contact>) -> Model {
    let options = ReadOptions { base, contacts, ..ReadOptions::default() };
    read(text, "robot.urdf", &options).unwrap_or_else(|errors| panic!("{errors}")).model
}

fn quadruped() -> Model {
    let feet = ["front_left", "front_right", "hind_left", "hind_right"];
    let foot =
        |foot: &str| contact(foot, ContactKind::Point, &format!("{foot}_foot"), [[0.0; 3]; 2]);
    model_of(QUADRUPED, Base::Floating, feet.map(foot).into())
}

/// Contacts of the description, of the options, and of both are the same robot.
#[test]
fn elements_of_the_description_are_contacts() {
    let frames = [
        contact("left", ContactKind::Point, "front_left_foot", [[0.01, -0.02, 0.03], [0.0; 3]]),
        contact(
            "sole",
            ContactKind::Surface,
            "hind_right_foot",
            [[0.1, 0.2, -0.3], [0.3, -0.2, 0.7]],
        ),
    ];
    let element = |Contact { name, kind, end }: &Contact| {
        let numbers = |x: [f64; 3]| x.map(|x| x.to_string()).join(" ");
        let (kind, link) = (kind.name(), &end.link);
        let (xyz, rpy) = (numbers(end.xyz), numbers(end.rpy));
        format!(
            "<contact_frame name='{name}' type='{kind}' link='{link}' xyz='{xyz}' rpy='{rpy}'/>"
        )
    };
    let described = |frames: &[Contact]| {
        let elements: String = frames.iter().map(element).collect();
        QUADRUPED.replace("</robot>", &(elements + "</robot>"))
    };
    let text = |urdf: String, options: &[Contact]| {
        let builder = Builder::new().urdf_text(urdf, "robot.urdf").base(Base::Floating);
        let builder = builder.functions([Function::ConstrainedForwardDynamics]);
        let generated = builder.contacts(options.iter().cloned()).generate().expect("good");
        assert_eq!(generated.model.contacts().len(), 2);
        // The first lines name the options.
        let (_, text) = generated.text.split_once("\nimpl ").expect("functions");
        text.to_owned()
    };
    let expected = text(QUADRUPED.into(), &frames);
    assert!(text(described(&frames), &[]) == expected);
    assert!(text(described(&frames[..1]), &frames[1..]) == expected);
}

/// A tree of joints in general position on a base, with frames of points and surfaces on random links; a frame of the
/// base itself is among them.
fn random_tree(random: &mut Random, joints: usize, contacts: usize, base: Base) -> Model {
    let inertial = |random: &mut Random| {
        let [x, y, z] = random.three(0.2);
        format!(
            "<inertial><origin xyz='{x} {y} {z}' rpy='0.3 {y} 1'/><mass value='{}'/>\
             <inertia ixx='0.021' iyy='0.03' izz='0.025' ixy='0.002' ixz='-0.001' iyz='0.003'/></inertial>",
            2.0 + random.next()
        )
    };
    let mut text = format!("<robot name='tree'><link name='0'>{}</link>", inertial(random));
    for i in 1..=joints {
        let ([x, y, z], [a, b, c], [r, p, w]) =
            (random.three(0.4), random.three(1.0), random.three(3.0));
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss
        )]
        let parent = ((random.next() + 1.0) / 2.0 * i as f64) as usize;
        let kind = if i % 4 == 3 { "prismatic" } else { "revolute" };
        text += &format!(
            "<joint name='j{i}' type='{kind}'><parent link='{parent}'/><child link='{i}'/><axis xyz='{a} {b} {c}'/>\
             <origin xyz='{x} {y} {z}' rpy='{r} {p} {w}'/><limit lower='-3' upper='3' effort='9' velocity='9'/>\
             </joint><link name='{i}'>{}</link>",
            inertial(random)
        );
    }
    let contacts = (0..contacts).map(|k| {
        let kind = if k % 3 == 1 { ContactKind::Surface } else { ContactKind::Point };
        let link = (joints - k % joints).to_string();
        contact(&format!("c{k}"), kind, &link, [random.three(0.3), random.three(3.0)])
    });
    let mut contacts: Vec<Contact> = contacts.collect();
    if base == Base::Floating {
        contacts.push(contact("belly", ContactKind::Point, "0", [random.three(0.3), [0.0; 3]]));
    }
    model_of(&(text + "</robot>"), base, contacts)
}

type Settings = ConstraintSettings<f64, Vec<ContactTarget<f64>>>;

fn exact(model: &Model) -> Settings {
    let ConstraintSettings { alpha, beta, tolerance, rounding, .. } =
        ConstraintSettings::<f64>::EXACT;
    let targets = vec![ContactTarget::<f64>::EXACT; model.contacts().len()];
    ConstraintSettings { alpha, beta, tolerance, rounding, targets }
}

fn rotation([r, p, y]: [f64; 3]) -> Matrix3<f64> {
    *nalgebra::Rotation3::from_euler_angles(r, p, y).matrix()
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]))
}

fn matrix(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

fn column(m: &Matrix3<f64>, k: usize) -> V3<f64> {
    V3::new(m[(0, k)], m[(1, k)], m[(2, k)])
}

/// Targets anywhere, moving, stabilized and compliant.
fn general(model: &Model, random: &mut Random, compliance: f64) -> Settings {
    let mut settings = exact(model);
    for target in &mut settings.targets {
        let pose =
            Pose { rotation: rows(&rotation(random.three(3.0))), translation: random.three(1.0) };
        let velocity =
            Twist { angular: Vector3(random.three(1.0)), linear: Vector3(random.three(1.0)) };
        let (tangential, alpha, beta) = (random.next().abs(), 3.0, 5.0);
        let compliance = compliance * (1.5 + random.next());
        let (restitution, weight) = (0.0, 1.0);
        *target = ContactTarget {
            pose,
            velocity,
            tangential,
            alpha,
            beta,
            compliance,
            restitution,
            weight,
        };
    }
    settings
}

struct State {
    q: Vec<f64>,
    qd: Vec<f64>,
    tau: Vec<f64>,
}

fn state(model: &Model, random: &mut Random) -> State {
    let interpreter = Interpreter::<f64>::new(model.clone());
    let mut q = vec![0.0; model.nq()];
    interpreter.random_configuration(|| (random.next() + 1.0) / 2.0, &mut q).expect("fits");
    let nv = model.nv();
    State { q, qd: random.vector(nv, 2.0), tau: random.vector(nv, 5.0) }
}

#[derive(Debug)]
struct Solution {
    qdd: Vec<f64>,
    wrenches: Vec<[f64; 6]>,
    rank: f64,
}

fn interpreted(model: &Model, state: &State, active: &[bool], settings: &Settings) -> Solution {
    let mut interpreter = Interpreter::new(model.clone());
    let count = model.constraints();
    let (mut qdd, mut wrenches) = (vec![0.0; model.nv()], vec![Wrench::zero(); count]);
    let mut residuals = vec![Twist::zero(); count];
    let into =
        ConstrainedOutputs { qdd: &mut qdd, wrenches: &mut wrenches, residuals: &mut residuals };
    let rank = interpreter.constrained_forward_dynamics(
        ForwardInput { q: &state.q, qd: &state.qd, tau: &state.tau },
        active,
        settings,
        into,
    );
    let rank = rank.expect("fits");
    Solution { qdd, wrenches: wrenches.iter().map(Wrench::components).collect(), rank }
}

/// All that the dense witness needs of a contact: from the pose and the Jacobian of its link.
struct Frame {
    /// Linear, then angular rows in world axes at the frame's origin.
    jacobian: DMatrix<f64>,
    /// The classical acceleration without joint accelerations.
    bias: DVector<f64>,
    axes: Matrix3<f64>,
    origin: V3<f64>,
}

fn frame(interpreter: &mut Interpreter<f64>, State { q, qd, .. }: &State, c: usize) -> Frame {
    let model = interpreter.model().clone();
    let end = &model.contacts()[c].end;
    let nv = model.nv();
    let mut columns = vec![Twist::zero(); nv];
    interpreter.jacobian(q, end.link, &mut columns).expect("a link");
    let rate = interpreter.link_acceleration(q, qd, &vec![0.0; nv], end.link).expect("a link");
    let velocity = interpreter.link_velocity(q, qd, end.link).expect("a link");
    let link = interpreter.link_pose(q, end.link).expect("a link");
    let lever = matrix(link.rotation) * V3::from(end.pose.translation);
    let v = |x: Vector3<f64>| V3::from(x.0);
    let mut jacobian = DMatrix::zeros(6, nv);
    for (j, column) in columns.iter().enumerate() {
        let (angular, linear) = (v(column.angular), v(column.linear));
        jacobian.view_mut((0, j), (3, 1)).copy_from(&(linear + angular.cross(&lever)));
        jacobian.view_mut((3, j), (3, 1)).copy_from(&angular);
    }
    let (omega, alpha) = (v(velocity.angular), v(rate.angular));
    let linear = v(rate.linear) + alpha.cross(&lever) + omega.cross(&omega.cross(&lever));
    let mut bias = DVector::zeros(6);
    bias.rows_mut(0, 3).copy_from(&linear);
    bias.rows_mut(3, 3).copy_from(&alpha);
    let axes = matrix(link.rotation) * matrix(end.pose.rotation);
    Frame { jacobian, bias, axes, origin: V3::from(link.translation) + lever }
}

/// The displacement from the target, as documented.
fn displacement(frame: &Frame, target: &ContactTarget<f64>, kind: ContactKind) -> [V3<f64>; 2] {
    let axes = matrix(target.pose.rotation);
    let normal = column(&axes, 2);
    let split = |x: V3<f64>| {
        let along = normal * normal.dot(&x);
        (along, x - along)
    };
    let (height, within) = split(frame.origin - V3::from(target.pose.translation));
    let linear = height + within * target.tangential;
    let tilt = normal.cross(&column(&frame.axes, 2));
    let twist: V3<f64> =
        (0..2).map(|k| column(&axes, k).cross(&column(&frame.axes, k))).sum::<V3<f64>>() * 0.5;
    let angular = match kind {
        ContactKind::Point => V3::zeros(),
        ContactKind::Surface => tilt + split(twist).0 * target.tangential,
    };
    [linear, angular]
}

/// The largest difference to a dense solution, relative to the largest number.
fn dense(model: &Model, state: &State, active: &[bool], settings: &Settings) -> Solution {
    let nv = model.nv();
    let mut interpreter = Interpreter::new(model.clone());
    let mut masses = vec![0.0; nv * nv];
    interpreter.mass_matrix(&state.q, &mut masses).expect("fits");
    let masses = DMatrix::from_column_slice(nv, nv, &masses);
    let mut bias = vec![0.0; nv];
    interpreter.bias_forces(&state.q, &state.qd, &mut bias).expect("fits");
    let force = DVector::from_column_slice(&state.tau) - DVector::from(bias);
    let cholesky = masses.clone().cholesky().expect("positive");
    let free = cholesky.solve(&force);
    let qd = DVector::from_column_slice(&state.qd);

    // By row: contact, whether it is a rotation, Jacobian in units of length, wanted acceleration.
    let mut all = Vec::new();
    for (c, contact) in model.contacts().iter().enumerate().filter(|(c, _)| active[*c]) {
        let target = &settings.targets[c];
        let found = frame(&mut interpreter, state, c);
        let moving = target.velocity.components();
        let parts = displacement(&found, target, contact.kind);
        let displacement = parts.each_ref().map(V3::as_slice).concat();
        for k in 0..contact.kind.rows() {
            let row = found.jacobian.row(k);
            let velocity = (row * &qd)[0] - moving[k];
            let wanted = -found.bias[k]
                - 2.0 * target.alpha * velocity
                - target.beta.powi(2) * displacement[k];
            let length = if k < 3 { 1.0 } else { model.contact_length(c) };
            all.push((c, k, row * length, wanted * length, length));
        }
    }
    let m = all.len();
    let mut wrenches = vec![[0.0; 6]; model.contacts().len()];
    if m == 0 {
        return Solution { qdd: free.as_slice().into(), wrenches, rank: 0.0 };
    }
    let jacobian = DMatrix::from_fn(m, nv, |i, j| all[i].2[j]);
    let wanted = DVector::from_fn(m, |i, _| all[i].3);
    let response = cholesky.solve(&jacobian.transpose());
    let mut delassus = &jacobian * &response;
    for (i, row) in all.iter().enumerate() {
        delassus[(i, i)] += settings.targets[row.0].compliance;
    }
    let right = wanted - &jacobian * &free;
    // The matrix is symmetric. Solutions by nalgebra's singular values are wrong by 1e-4 for one of these robots.
    let eigen = delassus.symmetric_eigen();
    let tolerance = 1e-9 * eigen.eigenvalues.max();
    let is_kept = |value: f64| value > tolerance;
    let mut parts = eigen.eigenvectors.tr_mul(&right);
    for (part, &value) in parts.iter_mut().zip(&eigen.eigenvalues) {
        *part = if is_kept(value) { *part / value } else { 0.0 };
    }
    let multipliers = &eigen.eigenvectors * parts;
    let qdd = free + response * &multipliers;
    for (row, x) in all.iter().zip(&multipliers) {
        wrenches[row.0][row.1] = x * row.4;
    }
    #[allow(clippy::cast_precision_loss)]
    let rank = eigen.eigenvalues.iter().filter(|&&value| is_kept(value)).count() as f64;
    Solution { qdd: qdd.as_slice().into(), wrenches, rank }
}

fn assert_same(found: &Solution, expected: &Solution, tolerance: f64) {
    let numbers = |solution: &Solution| [solution.qdd.clone(), solution.wrenches.concat()];
    for (found, expected) in numbers(found).iter().zip(&numbers(expected)) {
        let scale = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < tolerance * scale, "{a} instead of {b}, of {scale}");
        }
    }
    assert!(
        (found.rank - expected.rank).abs() < 0.5,
        "{} instead of {}",
        found.rank,
        expected.rank
    );
}

fn masks(model: &Model, random: &mut Random, count: usize) -> Vec<Vec<bool>> {
    let n = model.contacts().len();
    let some = (0..count).map(|_| (0..n).map(|_| random.next() > -0.3).collect());
    some.chain([vec![true; n], vec![false; n]]).collect()
}

#[test]
fn a_quadruped_with_any_feet_on_the_ground_is_as_the_dense_solution_says() {
    let (model, mut random) = (quadruped(), Random(1));
    for mask in 0..16_u32 {
        let active: Vec<bool> = (0..4).map(|k| mask & (1 << k) != 0).collect();
        let state = state(&model, &mut random);
        for settings in [exact(&model), general(&model, &mut random, 0.0)] {
            let found = interpreted(&model, &state, &active, &settings);
            assert_same(&found, &dense(&model, &state, &active, &settings), 1e-9);
            assert!((found.rank - 3.0 * f64::from(mask.count_ones())).abs() < 0.5);
            for (wrench, _) in found.wrenches.iter().zip(&active).filter(|(_, active)| !**active) {
                assert!(wrench.iter().all(|&x| x == 0.0), "{wrench:?}");
            }
        }
    }
}

#[test]
fn random_trees_with_random_masks_are_as_the_dense_solution_says() {
    let mut random = Random(2);
    for (k, joints) in [6, 9, 14].into_iter().cycle().take(12).enumerate() {
        let base = if k % 3 == 2 { Base::Fixed } else { Base::Floating };
        let model = random_tree(&mut random, joints, if base == Base::Fixed { 1 } else { 3 }, base);
        for active in masks(&model, &mut random, 4) {
            let state = state(&model, &mut random);
            let settings = general(&model, &mut random, 0.0);
            let found = interpreted(&model, &state, &active, &settings);
            assert_same(&found, &dense(&model, &state, &active, &settings), 1e-7);
        }
    }
}

/// Four points of one body, two surfaces of another: more rows than the bodies can move.
fn redundant(random: &mut Random) -> Model {
    let model = random_tree(random, 5, 0, Base::Floating);
    let end =
        |model: &Model, link: &str, random: &mut Random| modyn_runtime::model::LoopConstraintEnd {
            link: model.link_index(link).expect("a link"),
            pose: Pose {
                rotation: rows(&rotation(random.three(3.0))),
                translation: random.three(0.3),
            },
        };
    let mut contacts: Vec<modyn_runtime::model::Contact> = Vec::new();
    for (k, (kind, link)) in [
        (ContactKind::Point, "0"),
        (ContactKind::Point, "0"),
        (ContactKind::Point, "0"),
        (ContactKind::Point, "0"),
        (ContactKind::Surface, "5"),
        (ContactKind::Surface, "5"),
    ]
    .into_iter()
    .enumerate()
    {
        let end = end(&model, link, random);
        contacts.push(modyn_runtime::model::Contact { name: format!("c{k}"), kind, end });
    }
    model.with_contacts(contacts).expect("good")
}

#[test]
fn redundant_contacts_share_their_forces_and_no_mask_makes_a_number_that_is_none() {
    let mut random = Random(3);
    let model = redundant(&mut random);
    for mask in 0..64_u32 {
        let active: Vec<bool> = (0..6).map(|k| mask & (1 << k) != 0).collect();
        // Consistent rows: the robot is at rest.
        let mut state = state(&model, &mut random);
        state.qd.fill(0.0);
        for compliance in [0.0, 1e-3] {
            let mut settings = exact(&model);
            settings.targets.iter_mut().for_each(|target| target.compliance = compliance);
            let found = interpreted(&model, &state, &active, &settings);
            let all = found.qdd.iter().chain(found.wrenches.iter().flatten());
            assert!(all.into_iter().all(|x| x.is_finite()), "{found:?}");
            let expected = dense(&model, &state, &active, &settings);
            assert_same(&found, &expected, 1e-6);
            if compliance > 0.0 {
                continue;
            }
            let points = (mask & 15).count_ones();
            let most = [0, 3, 5, 6, 6][points as usize] + if mask >> 4 == 0 { 0 } else { 6 };
            assert!(found.rank <= f64::from(most) + 0.5, "{} of {most}", found.rank);
        }
    }
}

#[test]
fn compliant_contacts_may_have_more_rows_than_joints_move_them() {
    let mut random = Random(19);
    for joints in [1, 2, 4] {
        let model = random_tree(&mut random, joints, 2, Base::Fixed);
        for active in masks(&model, &mut random, 2) {
            let state = state(&model, &mut random);
            let settings = general(&model, &mut random, 0.02);
            let found = interpreted(&model, &state, &active, &settings);
            assert_same(&found, &dense(&model, &state, &active, &settings), 1e-8);
        }
    }
}

#[test]
fn what_gets_compiled_is_what_the_interpreter_computes() {
    let mut random = Random(4);
    let models =
        [quadruped(), random_tree(&mut random, 7, 2, Base::Floating), redundant(&mut random)];
    for model in models {
        let mechanism = Mechanism::new(&model);
        let tracer = Tracer::new(&mechanism);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
        let dynamics = optimize(tracer.constrained_forward_dynamics(&layout));
        let residual = optimize(tracer.evaluation(Function::ConstraintResidual, &model, None));
        let projection = optimize(tracer.project_constraints(&layout));
        println!("{}: {:?}", model.name(), dynamics.count());
        let mut interpreter = Interpreter::new(model.clone());
        for active in masks(&model, &mut random, 5) {
            let state = state(&model, &mut random);
            let settings = general(&model, &mut random, 0.01);
            let numbers = numbers(&settings);
            let switches: Vec<f64> = active.iter().map(|&on| f64::from(u8::from(on))).collect();
            let found = dynamics
                .evaluate(&[&*state.q, &state.qd, &state.tau, &switches, &numbers].concat());
            let expected = interpreted(&model, &state, &active, &settings);
            let (nv, count) = (model.nv(), model.constraints());
            let wrenches =
                found[nv..][..6 * count].chunks(6).map(|w| std::array::from_fn(|k| w[k])).collect();
            let rank = found[found.len() - 1];
            assert_same(&Solution { qdd: found[..nv].into(), wrenches, rank }, &expected, 1e-8);

            let twists = || vec![Twist::zero(); count];
            let (mut displacements, mut velocities) = (twists(), twists());
            let into =
                ResidualOutputs { displacements: &mut displacements, velocities: &mut velocities };
            interpreter
                .constraint_residual(
                    equations::State { q: &state.q, qd: &state.qd },
                    &settings,
                    into,
                )
                .expect("fits");
            let found = residual.evaluate(&[&*state.q, &state.qd, &numbers].concat());
            let expected = displacements.iter().chain(&velocities).flat_map(Twist::components);
            expected.zip(&found).for_each(|(a, b)| assert!((a - b).abs() < 1e-10));
            for (c, (own, contact)) in displacements.iter().zip(model.contacts()).enumerate() {
                let frame = frame(&mut interpreter, &state, c);
                let [a, l] = displacement(&frame, &settings.targets[c], contact.kind);
                let expected = [a.as_slice(), l.as_slice()].concat();
                own.components()
                    .iter()
                    .zip(expected)
                    .for_each(|(x, y)| assert!((x - y).abs() < 1e-12));
            }

            let (mut dq, mut dqd) = (vec![0.0; nv], vec![0.0; nv]);
            let into = ProjectionOutputs { step_q: &mut dq, step_qd: &mut dqd };
            let projected = interpreter.project_constraints(
                equations::State { q: &state.q, qd: &state.qd },
                &active,
                &settings,
                into,
            );
            projected.expect("fits");
            let found = projection.evaluate(&[&*state.q, &state.qd, &switches, &numbers].concat());
            let scale = dq.iter().chain(&dqd).fold(1.0_f64, |most, x| most.max(x.abs()));
            dq.iter()
                .chain(&dqd)
                .zip(&found)
                .for_each(|(a, b)| assert!((a - b).abs() < 1e-8 * scale));
        }
    }
}

/// Programs of independent rows find the states whose rows are dependent: results and ranks are the interpreter's.
#[test]
fn programs_of_independent_rows_find_dependent_rows() {
    let mut random = Random(23);
    let mut seen = [0, 0];
    for model in [quadruped(), redundant(&mut random)] {
        let mechanism = Mechanism::new(&model);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
        let settings = exact(&model);
        let (numbers, nv, count) = (numbers(&settings), model.nv(), model.constraints());
        let inputs = model.nq() + 2 * nv + count + numbers.len();
        let loops = DenseLoops { rows: Some(inputs), products: false };
        let tracer = Tracer::new(&mechanism).with_loops(loops);
        let around = tracer.constrained_forward_dynamics(&layout);
        assert!(around.dense.rows.is_some(), "independent rows");
        let program = Program::try_new(&around, inputs, Execution::Scalar);
        let program = program.expect("valid");
        assert_eq!(program.to_string().parse(), Ok(program.clone()));
        for active in masks(&model, &mut random, 40) {
            // Consistent rows: the robot is at rest.
            let mut state = state(&model, &mut random);
            state.qd.fill(0.0);
            let switches = switches(&active);
            let found =
                program.evaluate(&[&*state.q, &state.qd, &state.tau, &switches, &numbers].concat());
            let wrenches =
                found[nv..][..6 * count].chunks(6).map(|w| std::array::from_fn(|k| w[k])).collect();
            let rank = found[found.len() - 1];
            let expected = interpreted(&model, &state, &active, &settings);
            assert_same(&Solution { qdd: found[..nv].into(), wrenches, rank }, &expected, 1e-6);
            let rows = model.contacts().iter().zip(&active).filter(|(_, active)| **active);
            let rows: usize = rows.map(|(contact, _)| contact.kind.rows()).sum();
            seen[usize::from(rank < rows as f64 - 0.5)] += 1;
        }
    }
    assert!(seen.iter().all(|&states| states > 10), "independent and dependent: {seen:?}");
}

/// A long function is cut into chunks. Those that name the instruction set have it as a parameter.
#[test]
fn chunks_with_dependent_rows_name_types_that_they_have() {
    let functions = [Function::ConstrainedForwardDynamicsDerivatives];
    let builder = Builder::new().model(quadruped()).functions(functions);
    let text = builder.generate().map_err(|error| error.to_string()).expect("good").text;
    let chunks = text.split("struct ").skip(1).filter_map(|of| of.split("\n}\n}").next());
    let chunks: Vec<&str> = chunks.filter(|chunk| chunk.contains("batch::Chunk for ")).collect();
    assert!(chunks.iter().any(|chunk| chunk.contains("RowEquations")), "{}", chunks.len());
    let is_known =
        |chunk: &&str| !chunk.contains("V::") || chunk.contains("V: __modyn::batch::SimdBackend");
    assert!(chunks.iter().all(is_known), "{}", chunks.len());
}

fn numbers(settings: &Settings) -> Vec<f64> {
    let ConstraintSettings { alpha, beta, tolerance, rounding, targets } = settings;
    let mut numbers = vec![*alpha, *beta, *tolerance, *rounding];
    for target in targets {
        let ContactTarget { pose, velocity, tangential, alpha, beta, .. } = target;
        numbers.extend(pose.rotation.iter().flatten());
        numbers.extend(pose.translation);
        numbers.extend(velocity.components());
        numbers.extend([tangential, alpha, beta, &target.compliance]);
        numbers.extend([target.restitution, target.weight]);
    }
    numbers
}

#[test]
fn steps_put_active_contacts_on_their_targets_and_stop_them() {
    let (model, mut random) = (quadruped(), Random(5));
    let mut interpreter = Interpreter::new(model.clone());
    let State { mut q, mut qd, .. } = state(&model, &mut random);
    q[..3].copy_from_slice(&[0.0, 0.0, 0.4]);
    let settings = exact(&model);
    let active = [true, false, true, true];
    let (mut dq, mut dqd) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
    for _ in 0..30 {
        let into = ProjectionOutputs { step_q: &mut dq, step_qd: &mut dqd };
        interpreter
            .project_constraints(equations::State { q: &q, qd: &qd }, &active, &settings, into)
            .expect("fits");
        let before = q.clone();
        interpreter.integrate(&before, &dq, &mut q).expect("fits");
    }
    interpreter
        .project_constraints(
            equations::State { q: &q, qd: &qd },
            &active,
            &settings,
            ProjectionOutputs { step_q: &mut dq, step_qd: &mut dqd },
        )
        .expect("fits");
    qd.iter_mut().zip(&dqd).for_each(|(v, d)| *v += d);
    let (mut displacements, mut velocities) = (vec![Twist::zero(); 4], vec![Twist::zero(); 4]);
    let into = ResidualOutputs { displacements: &mut displacements, velocities: &mut velocities };
    interpreter
        .constraint_residual(equations::State { q: &q, qd: &qd }, &settings, into)
        .expect("fits");
    for (c, active) in active.into_iter().enumerate() {
        let linear = [displacements[c].linear.0, velocities[c].linear.0].concat();
        let most = linear.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        assert_eq!(most < 1e-12, active, "{c}: {most}");
    }
}

#[test]
fn bad_contacts_are_refused() {
    let bad = |contact: Contact| {
        let options = ReadOptions { contacts: vec![contact], ..ReadOptions::default() };
        read(QUADRUPED, "robot.urdf", &options).expect_err("refused").to_string()
    };
    let point =
        |link: &str, at: [f64; 3]| contact("foot", ContactKind::Point, link, [at, [0.0; 3]]);
    let said = bad(point("front_left_fot", [0.0; 3]));
    assert!(said.contains("contact `foot`: link `front_left_fot` does not exist"), "{said}");
    assert!(said.contains("did you mean `front_left_foot`?"), "{said}");
    let said = bad(point("trunk", [0.0; 3]));
    assert!(said.contains("link `trunk` is fixed to the world"), "{said}");
    let said = bad(point("front_left_foot", [f64::NAN, 0.0, 0.0]));
    assert!(said.contains("its place is not finite"), "{said}");

    let model = quadruped();
    let kinds = |change: &dyn Fn(&mut modyn_runtime::model::Contact)| {
        let mut contacts = model.contacts().to_vec();
        change(&mut contacts[0]);
        let errors = model.clone().with_contacts(contacts).expect_err("refused");
        errors.into_iter().map(|error| error.kind).collect::<Vec<_>>()
    };
    assert_eq!(kinds(&|c| c.name = "hind_left".into()), [ModelErrorKind::DuplicateName]);
    assert_eq!(kinds(&|c| c.end.link = 99), [ModelErrorKind::ContactLink]);
    assert_eq!(kinds(&|c| c.end.pose.translation[0] = f64::NAN), [ModelErrorKind::NotFinite]);
    assert_eq!(kinds(&|c| c.end.pose.rotation[0][0] = 2.0), [ModelErrorKind::Rotation]);
}

/// The Jacobian rows of the active contacts in world axes, in the order of the results; by row its contact, its component
/// and the factor of its units of length.
fn dense_rows(
    model: &Model,
    interpreter: &mut Interpreter<f64>,
    state: &State,
    active: &[bool],
) -> (DMatrix<f64>, Vec<(usize, usize, f64)>) {
    let mut rows = Vec::new();
    let mut kept = Vec::new();
    for (c, contact) in model.contacts().iter().enumerate() {
        let found = frame(interpreter, state, c);
        for k in 0..contact.kind.rows() {
            let length = if k < 3 { 1.0 } else { model.contact_length(c) };
            let on = if active[c] { 1.0 } else { 0.0 };
            rows.push(found.jacobian.row(k) * on);
            kept.push((c, k, length));
        }
    }
    (DMatrix::from_fn(rows.len(), model.nv(), |i, j| rows[i][j]), kept)
}

fn dense_masses(model: &Model, interpreter: &mut Interpreter<f64>, q: &[f64]) -> DMatrix<f64> {
    let nv = model.nv();
    let mut masses = vec![0.0; nv * nv];
    interpreter.mass_matrix(q, &mut masses).expect("fits");
    DMatrix::from_column_slice(nv, nv, &masses)
}

fn scaled(jacobian: &DMatrix<f64>, kept: &[(usize, usize, f64)]) -> DMatrix<f64> {
    DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |i, j| jacobian[(i, j)] * kept[i].2)
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < tolerance * scale, "{a} instead of {b}, of {scale}");
    }
}

fn components(wrenches: &[Wrench<f64>]) -> Vec<f64> {
    wrenches.iter().flat_map(Wrench::components).collect()
}

fn switches(active: &[bool]) -> Vec<f64> {
    active.iter().map(|&on| f64::from(u8::from(on))).collect()
}

/// Robots with random masks.
fn for_all(seed: u64, mut check: impl FnMut(&Model, &State, &[bool], &Settings)) {
    let mut random = Random(seed);
    let fixed = random_tree(&mut random, 8, 1, Base::Fixed);
    let floating = random_tree(&mut random, 9, 3, Base::Floating);
    for model in [quadruped(), fixed, floating] {
        for active in masks(&model, &mut random, 5) {
            let state = state(&model, &mut random);
            let mut settings = general(&model, &mut random, 0.0);
            for target in &mut settings.targets {
                (target.restitution, target.weight) = (random.next().abs(), 1.5 + random.next());
            }
            check(&model, &state, &active, &settings);
        }
    }
}

#[test]
fn velocities_after_an_impact_are_as_the_dense_solution_says() {
    for_all(11, |model, state, active, settings| {
        let mut interpreter = Interpreter::new(model.clone());
        let (nv, count) = (model.nv(), model.constraints());
        let (mut after, mut impulses) = (vec![0.0; nv], vec![Wrench::zero(); count]);
        let into = ImpulseOutputs { qd: &mut after, impulses: &mut impulses };
        let motion = equations::State { q: &state.q, qd: &state.qd };
        interpreter.impact_dynamics(motion, active, settings, into).expect("fits");

        let (jacobian, kept) = dense_rows(model, &mut interpreter, state, active);
        let masses = dense_masses(model, &mut interpreter, &state.q);
        let qd = DVector::from_column_slice(&state.qd);
        let velocity = &jacobian * &qd;
        let mut wanted = DVector::zeros(kept.len());
        for (i, &(c, k, length)) in kept.iter().enumerate().filter(|(_, row)| active[row.0]) {
            let target = &settings.targets[c];
            let moving = target.velocity.components();
            let mut own = -(velocity[i] - moving[k]);
            if k < 3 {
                let normal = column(&matrix(target.pose.rotation), 2);
                let first = i - k;
                let speed: f64 =
                    (0..3).map(|j| normal[j] * (velocity[first + j] - moving[j])).sum();
                own -= target.restitution * speed * normal[k];
            }
            wanted[i] = own * length;
        }
        let jacobian = scaled(&jacobian, &kept);
        let response = masses.cholesky().expect("positive").solve(&jacobian.transpose());
        let delassus = (&jacobian * &response).svd(true, true);
        // Nearly singular states have the rank that the tolerances say.
        let largest = delassus.singular_values[0].max(1.0);
        if delassus.singular_values.iter().any(|x| (1e-13..1e-7).contains(&(x / largest))) {
            return;
        }
        let multipliers =
            delassus.solve(&wanted, 1e-9 * delassus.singular_values[0].max(1.0)).expect("solves");
        assert_near(&after, (qd + response * &multipliers).as_slice(), 1e-7);
        let mut expected = vec![0.0; 6 * count];
        for (&(c, k, length), x) in kept.iter().zip(&multipliers) {
            expected[6 * c + k] = x * length;
        }
        assert_near(&components(&impulses), &expected, 1e-7);
    });
}

#[test]
fn jacobians_and_bias_accelerations_are_those_of_the_links() {
    for_all(12, |model, state, _, _| {
        let mut interpreter = Interpreter::new(model.clone());
        let (nv, count) = (model.nv(), model.constraints());
        let (mut columns, mut bias) = (vec![Twist::zero(); nv * count], vec![Twist::zero(); count]);
        interpreter.constraint_jacobian(&state.q, &mut columns).expect("fits");
        let motion = equations::State { q: &state.q, qd: &state.qd };
        interpreter.constraint_jacobian_dot_qd(motion, &mut bias).expect("fits");
        for (c, contact) in model.contacts().iter().enumerate() {
            let expected = frame(&mut interpreter, state, c);
            for k in 0..6 {
                let held = if k < contact.kind.rows() { 1.0 } else { 0.0 };
                for (j, column) in columns[c * nv..][..nv].iter().enumerate() {
                    let difference = column.components()[k] - held * expected.jacobian[(k, j)];
                    assert!(difference.abs() < 1e-12);
                }
                let difference = bias[c].components()[k] - held * expected.bias[k];
                assert!(difference.abs() < 1e-9);
            }
        }
    });
}

#[test]
fn the_operational_space_inertia_is_the_inverse_of_what_the_dense_solution_says() {
    for_all(13, |model, state, active, settings| {
        let mut interpreter = Interpreter::new(model.clone());
        let mut settings = settings.clone();
        settings.targets.iter_mut().for_each(|target| target.compliance = 0.02);
        let rows = model.constraint_rows();
        let mut delassus = vec![0.0; rows * rows];
        let mut inertia = vec![0.0; rows * rows];
        let into =
            OperationalSpaceInertiaOutputs { delassus: &mut delassus, inertia: &mut inertia };
        let rank = interpreter.operational_space_inertia(&state.q, active, &settings, into);
        let (jacobian, kept) = dense_rows(model, &mut interpreter, state, active);
        let masses = dense_masses(model, &mut interpreter, &state.q);
        let response = masses.cholesky().expect("positive").solve(&jacobian.transpose());
        let mut expected = &jacobian * response;
        let on = kept.iter().map(|row| if active[row.0] { 1.0 } else { 0.0 });
        for (i, on) in on.clone().enumerate() {
            expected[(i, i)] += 0.02 * on / kept[i].2.powi(2);
        }
        assert_near(&delassus, expected.as_slice(), 1e-9);
        let found = DMatrix::from_column_slice(rows, rows, &inertia) * expected;
        let identity = DMatrix::from_diagonal(&DVector::from_iterator(rows, on.clone()));
        assert_near(found.as_slice(), identity.as_slice(), 1e-7);
        assert!((rank.expect("fits") - on.sum::<f64>()).abs() < 0.5);
    });
}

#[test]
fn contacts_carry_the_base_with_the_smallest_wrenches() {
    for_all(14, |model, state, active, settings| {
        let mut interpreter = Interpreter::new(model.clone());
        let (nv, count) = (model.nv(), model.constraints());
        let (mut tau, mut wrenches) = (vec![0.0; nv], vec![Wrench::zero(); count]);
        let into = ConstrainedInverseOutputs { tau: &mut tau, wrenches: &mut wrenches };
        let motion = Motion { q: &state.q, qd: &state.qd, qdd: &state.tau };
        let rank = interpreter.constrained_inverse_dynamics(motion, active, settings, into);
        let rank = rank.expect("fits");
        let mut needed = vec![0.0; nv];
        interpreter.inverse_dynamics(&state.q, &state.qd, &state.tau, &mut needed).expect("fits");
        // Whatever the wrenches, the robot moves so.
        let (jacobian, kept) = dense_rows(model, &mut interpreter, state, active);
        let found = components(&wrenches);
        let forces =
            DVector::from_iterator(kept.len(), kept.iter().map(|&(c, k, _)| found[6 * c + k]));
        let carried = jacobian.transpose() * &forces;
        let sum: Vec<f64> = tau.iter().zip(&carried).map(|(a, b)| a + b).collect();
        assert_near(&sum, &needed, 1e-9);
        let base = if model.nq() == nv { 0 } else { 6 };
        // The smallest: J_b W J_b^T by singular values.
        let scaled = scaled(&jacobian, &kept);
        let columns = scaled.columns(0, base).transpose();
        let weights: Vec<f64> = kept.iter().map(|row| settings.targets[row.0].weight).collect();
        let weights = DMatrix::from_diagonal(&DVector::from_vec(weights));
        if base == 0 || !active.contains(&true) {
            assert!(found.iter().all(|&x| x == 0.0) && rank == 0.0);
            return;
        }
        let gram = (&columns * &weights * columns.transpose()).svd(true, true);
        let tolerance = 1e-9 * gram.singular_values[0];
        assert!((rank - gram.rank(tolerance) as f64).abs() < 0.5, "{rank}");
        if rank < 5.5 {
            return;
        }
        assert!(tau[..base].iter().all(|x| x.abs() < 1e-8), "{tau:?}");
        let needed = DVector::from_column_slice(&needed[..base]);
        let expected =
            weights * columns.transpose() * gram.solve(&needed, tolerance).expect("solves");
        let own =
            DVector::from_iterator(kept.len(), kept.iter().zip(&forces).map(|(row, f)| f / row.2));
        assert_near(own.as_slice(), expected.as_slice(), 1e-7);
    });
}

#[test]
fn what_gets_compiled_of_the_other_functions_is_what_the_interpreter_computes() {
    for_all(15, |model, state, active, settings| {
        let mechanism = Mechanism::new(model);
        let tracer = Tracer::new(&mechanism);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(model));
        let mut interpreter = Interpreter::new(model.clone());
        let (nv, count, rows) = (model.nv(), model.constraints(), model.constraint_rows());
        let (on, numbers) = (switches(active), numbers(settings));
        let motion = equations::State { q: &state.q, qd: &state.qd };

        let (mut qd, mut impulses) = (vec![0.0; nv], vec![Wrench::zero(); count]);
        let into = ImpulseOutputs { qd: &mut qd, impulses: &mut impulses };
        let rank = interpreter.impact_dynamics(motion, active, settings, into).expect("fits");
        let graph = optimize(tracer.impact_dynamics(&layout));
        let found = graph.evaluate(&[&*state.q, &state.qd, &on, &numbers].concat());
        assert_near(&found, &[qd, components(&impulses), vec![rank]].concat(), 1e-8);

        let (mut tau, mut wrenches) = (vec![0.0; nv], vec![Wrench::zero(); count]);
        let into = ConstrainedInverseOutputs { tau: &mut tau, wrenches: &mut wrenches };
        let all = Motion { q: &state.q, qd: &state.qd, qdd: &state.tau };
        let rank = interpreter.constrained_inverse_dynamics(all, active, settings, into);
        let graph = optimize(tracer.evaluation(Function::ConstrainedInverseDynamics, model, None));
        let found = graph.evaluate(&[&*state.q, &state.qd, &state.tau, &on, &numbers].concat());
        let expected = [tau, components(&wrenches), vec![rank.expect("fits")]].concat();
        assert_near(&found, &expected, 1e-8);

        let mut columns = vec![Twist::zero(); nv * count];
        interpreter.constraint_jacobian(&state.q, &mut columns).expect("fits");
        let expected: Vec<f64> = columns.iter().flat_map(Twist::components).collect();
        let graph = optimize(tracer.evaluation(Function::ConstraintJacobian, model, None));
        let found = graph.evaluate(&state.q);
        assert_near(&found, &expected, 1e-12);

        let mut bias = vec![Twist::zero(); count];
        interpreter.constraint_jacobian_dot_qd(motion, &mut bias).expect("fits");
        let expected: Vec<f64> = bias.iter().flat_map(Twist::components).collect();
        let graph = optimize(tracer.evaluation(Function::ConstraintJacobianDotQd, model, None));
        assert_near(&graph.evaluate(&[&*state.q, &state.qd].concat()), &expected, 1e-11);

        let mut delassus = vec![0.0; rows * rows];
        let mut inertia = vec![0.0; rows * rows];
        let into =
            OperationalSpaceInertiaOutputs { delassus: &mut delassus, inertia: &mut inertia };
        let rank =
            interpreter.operational_space_inertia(&state.q, active, settings, into).expect("fits");
        let graph = optimize(tracer.operational_space_inertia(&layout));
        let found = graph.evaluate(&[&*state.q, &on, &numbers].concat());
        assert_near(&found, &[delassus, inertia, vec![rank]].concat(), 1e-7);
    });
}

/// The accelerations, the wrenches and their derivatives, in the order of a graph's results.
fn derivatives(model: &Model, state: &State, active: &[bool], settings: &Settings) -> Vec<f64> {
    let mut interpreter = Interpreter::new(model.clone());
    let (nv, count) = (model.nv(), model.constraints());
    let (mut qdd, mut wrenches) = (vec![0.0; nv], vec![Wrench::zero(); count]);
    let mut matrices = [0; 3].map(|_| vec![0.0; nv * nv]);
    let mut changes = [0; 3].map(|_| vec![Wrench::zero(); nv * count]);
    let outputs = ConstrainedDerivatives::new(&mut qdd, &mut wrenches, &mut matrices, &mut changes);
    let motion = ForwardInput { q: &state.q, qd: &state.qd, tau: &state.tau };
    let rank =
        interpreter.constrained_forward_dynamics_derivatives(motion, active, settings, outputs);
    let changes: Vec<f64> = changes.iter().flat_map(|of| components(of)).collect();
    let rank = vec![rank.expect("fits")];
    [qdd, components(&wrenches), matrices.concat(), changes, rank].concat()
}

/// The state with entry `k` of q (in the tangent space), qd or tau moved.
fn moved(model: &Model, state: &State, variable: usize, k: usize, by: f64) -> State {
    let State { q, qd, tau } = state;
    let mut step = vec![0.0; model.nv()];
    step[k] = by;
    let mut there = State { q: q.clone(), qd: qd.clone(), tau: tau.clone() };
    match variable {
        0 => {
            Interpreter::<f64>::new(model.clone()).integrate(q, &step, &mut there.q).expect("fits")
        }
        1 => there.qd[k] += by,
        _ => there.tau[k] += by,
    }
    there
}

#[test]
fn derivatives_are_those_of_differences() {
    let mut checked = 0;
    for_all(16, |model, state, active, settings| {
        let (nv, count) = (model.nv(), model.constraints());
        let value = |there: &State| {
            let found = interpreted(model, there, active, settings);
            ([found.qdd, found.wrenches.concat()].concat(), found.rank)
        };
        let (here, rank) = value(state);
        // Where rows are redundant, wrenches are not smooth.
        let rows = model.contacts().iter().zip(active).filter(|(_, on)| **on);
        let rows = rows.map(|(contact, _)| contact.kind.rows()).sum::<usize>();
        if (rank - rows as f64).abs() > 0.5 {
            return;
        }
        checked += 1;
        let found = derivatives(model, state, active, settings);
        assert_near(&found[..nv + 6 * count], &here, 1e-12);
        let (matrices, changes) = found[nv + 6 * count..].split_at(3 * nv * nv);
        for variable in 0..3 {
            for k in 0..nv {
                let step = 1e-4;
                let at = |by: f64| value(&moved(model, state, variable, k, by * step)).0;
                let [a, b, c, d] = [1.0, -1.0, 2.0, -2.0].map(at);
                let slope: Vec<f64> = (0..nv + 6 * count)
                    .map(|i| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * step))
                    .collect();
                let column = &matrices[variable * nv * nv + k * nv..][..nv];
                assert_near(column, &slope[..nv], 1e-6);
                for c in 0..count {
                    let own = &changes[6 * (variable * count * nv + c * nv + k)..][..6];
                    let scale =
                        here[nv..].iter().chain(&slope).fold(1.0_f64, |m, x| m.max(x.abs()));
                    for (x, y) in own.iter().zip(&slope[nv + 6 * c..]) {
                        assert!((x - y).abs() < 1e-6 * scale, "{variable} {k} {c}: {x}, not {y}");
                    }
                }
            }
        }
    });
    assert!(checked > 8, "{checked}");
}

/// Random trees with two loops of each pair of types, between frames that do not coincide, and contacts.
fn for_all_loops(seed: u64, mut check: impl FnMut(&Model, &State, &[bool], &Settings)) {
    let mut random = Random(seed);
    let axis = [0.6, 0.0, -0.8];
    let kinds = [
        LoopConstraintKind::Point,
        LoopConstraintKind::Revolute(axis),
        LoopConstraintKind::Prismatic(axis),
        LoopConstraintKind::Rigid,
    ];
    for (k, first) in kinds.into_iter().enumerate() {
        let second = kinds[(k + k / 2 + 1) % 4];
        let base = if k % 2 == 0 { Base::Floating } else { Base::Fixed };
        let model = random_tree(&mut random, 13, 1, base);
        let mut end = |link: &str| LoopConstraintEnd {
            link: model.link_index(link).expect("a link"),
            pose: Pose {
                rotation: rows(&rotation(random.three(3.0))),
                translation: random.three(0.3),
            },
        };
        let loops = [(first, ["13", "0"]), (second, ["9", "12"])];
        let loops = loops.into_iter().enumerate().map(|(i, (kind, ends))| LoopConstraint {
            name: format!("loop{i}"),
            kind,
            ends: ends.map(&mut end),
        });
        let loops = loops.collect();
        let model = model.clone().with_loop_constraints(loops).expect("good");
        for active in masks(&model, &mut random, 1) {
            let state = state(&model, &mut random);
            let mut settings = general(&model, &mut random, 0.0);
            (settings.alpha, settings.beta) = (2.0, 3.0);
            check(&model, &state, &active, &settings);
        }
    }
}

/// The programs of batches, which have one text for all sets, with a random set for each state.
#[test]
fn programs_of_batches_are_the_interpreters() {
    let mut random = Random(31);
    for k in 0..6 {
        let base = if k % 3 == 2 { Base::Fixed } else { Base::Floating };
        let model = random_tree(&mut random, 6 + k, 1 + k % 2, base);
        let mechanism = Mechanism::new(&model);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
        let graph = optimize(Tracer::new(&mechanism).constrained_forward_dynamics(&layout));
        let settings = general(&model, &mut random, 0.01);
        let mut program = None;
        for active in masks(&model, &mut random, 4) {
            let state = state(&model, &mut random);
            let inputs =
                [&*state.q, &state.qd, &state.tau, &switches(&active), &numbers(&settings)];
            let inputs = inputs.concat();
            let program =
                program.get_or_insert_with(|| Program::new(&graph, inputs.len(), Execution::Batch));
            let expected = interpreted(&model, &state, &active, &settings);
            let found = program.evaluate(&inputs);
            let (qdd, wrenches) = (expected.qdd, expected.wrenches.concat());
            assert_near(&found[..qdd.len()], &qdd, 1e-7);
            assert_near(&found[qdd.len()..][..wrenches.len()], &wrenches, 1e-7);
            assert_near(&found[found.len() - 1..], &[expected.rank], 1e-12);
        }
    }
}

#[test]
fn compiled_derivatives_are_the_interpreters() {
    let check = |model: &Model, state: &State, active: &[bool], settings: &Settings| {
        let mechanism = Mechanism::new(model);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(model));
        let inputs = [&*state.q, &state.qd, &state.tau, &switches(active), &numbers(settings)];
        let expected = derivatives(model, state, active, settings);
        let tracer = Tracer::new(&mechanism);
        for tracer in [&tracer, &tracer.column_lanes(COLUMN_LANES)] {
            let graph = optimize(tracer.constrained_forward_dynamics_derivatives(&layout));
            println!("{}: {:?}", model.name(), graph.count());
            assert_near(&graph.evaluate(&inputs.concat()), &expected, 1e-7);
        }
    };
    for_all(17, check);
    for_all_loops(22, check);
}

/// Robots with equal limbs: contacts on all limbs, on some, on the trunk, and of several kinds on one limb.
fn with_equal_limbs() -> Vec<Model> {
    let at = [[0.02, -0.01, 0.03], [0.3, -0.2, 0.5]];
    let some = [
        ("hind_left_thigh", ContactKind::Point),
        ("hind_right_foot", ContactKind::Surface),
        ("front_left_foot", ContactKind::Point),
        ("front_left_foot", ContactKind::Point),
    ];
    let three = [
        ("front_right_foot", ContactKind::Point),
        ("trunk", ContactKind::Point),
        ("front_left_foot", ContactKind::Point),
    ];
    let soles = [
        ("left_ankle_roll_link", ContactKind::Surface),
        ("right_ankle_roll_link", ContactKind::Surface),
        ("left_hand", ContactKind::Point),
    ];
    let contacts = |all: &[(&str, ContactKind)]| {
        let each = all.iter().enumerate();
        each.map(|(k, (link, kind))| contact(&format!("c{k}"), *kind, link, at)).collect::<Vec<_>>()
    };
    vec![
        quadruped(),
        model_of(QUADRUPED, Base::Floating, contacts(&some)),
        model_of(QUADRUPED, Base::Floating, contacts(&three)),
        model_of(HUMANOID, Base::Floating, contacts(&soles)),
        model_of(HUMANOID, Base::Fixed, contacts(&soles)),
    ]
}

#[test]
fn contacts_of_equal_limbs_in_lanes_give_the_same() {
    let mut random = Random(18);
    for model in with_equal_limbs() {
        let mechanism = Mechanism::new(&model);
        let limbs = LimbPacking::find(&mechanism, &LIMB_LIMITS).expect("equal limbs");
        assert!(limbs.merges_contacts(&mechanism));
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
        let packed = Tracer::new(&mechanism).packed(&limbs);
        let dynamics = optimize(packed.constrained_forward_dynamics(&layout));
        let impulse = optimize(packed.impact_dynamics(&layout));
        let projection = optimize(packed.project_constraints(&layout));
        for active in masks(&model, &mut random, 12) {
            let state = state(&model, &mut random);
            for settings in [exact(&model), general(&model, &mut random, 0.01)] {
                let mut interpreter = Interpreter::new(model.clone());
                let count = model.constraints();
                let (mut qdd, mut wrenches) = (vec![0.0; model.nv()], vec![Wrench::zero(); count]);
                let mut residuals = vec![Twist::zero(); count];
                let motion = ForwardInput { q: &state.q, qd: &state.qd, tau: &state.tau };
                let into = ConstrainedOutputs {
                    qdd: &mut qdd,
                    wrenches: &mut wrenches,
                    residuals: &mut residuals,
                };
                let rank =
                    interpreter.constrained_forward_dynamics(motion, &active, &settings, into);
                let residuals = residuals.iter().flat_map(Twist::components).collect();
                let rank = vec![rank.expect("fits")];
                let expected = [qdd, components(&wrenches), residuals, rank].concat();
                let inputs =
                    [&*state.q, &state.qd, &state.tau, &switches(&active), &numbers(&settings)];
                assert_near(&dynamics.evaluate(&inputs.concat()), &expected, 1e-8);

                let motion = equations::State { q: &state.q, qd: &state.qd };
                let (mut qd, mut impulses) = (vec![0.0; model.nv()], vec![Wrench::zero(); count]);
                let into = ImpulseOutputs { qd: &mut qd, impulses: &mut impulses };
                let rank = interpreter.impact_dynamics(motion, &active, &settings, into);
                let expected = [qd, components(&impulses), vec![rank.expect("fits")]].concat();
                let inputs = [&*state.q, &state.qd, &switches(&active), &numbers(&settings)];
                assert_near(&impulse.evaluate(&inputs.concat()), &expected, 1e-8);

                let (mut dq, mut dqd) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
                let into = ProjectionOutputs { step_q: &mut dq, step_qd: &mut dqd };
                let rank = interpreter.project_constraints(motion, &active, &settings, into);
                let expected = [dq, dqd, vec![rank.expect("fits")]].concat();
                assert_near(&projection.evaluate(&inputs.concat()), &expected, 1e-8);
            }
        }
    }
}

/// Operations of the floating quadruped with four point feet, eliminated by legs. A count that falls is to be entered;
/// one that rises is a regression.
#[test]
fn operation_counts_are_as_frozen() {
    let model = quadruped();
    let mechanism = Mechanism::new(&model);
    let (tracer, layout) =
        (Tracer::new(&mechanism), UduLayout::new(&mechanism, &ModuleTree::chains(&model)));
    let limbs = LimbPacking::find(&mechanism, &LIMB_LIMITS).expect("four legs");
    let evaluation = |function| tracer.evaluation(function, &model, None);
    let loops = DenseLoops { rows: Some(1000), products: false };
    let around =
        |tracer: &Tracer<'_>| tracer.with_loops(loops).constrained_forward_dynamics(&layout);
    let derivatives = |tracer: &Tracer<'_>| {
        tracer.with_loops(loops).constrained_forward_dynamics_derivatives(&layout)
    };
    let found = [
        ("constrained_forward_dynamics", tracer.constrained_forward_dynamics(&layout)),
        (
            "constrained_forward_dynamics in lanes",
            tracer.packed(&limbs).constrained_forward_dynamics(&layout),
        ),
        ("constrained_forward_dynamics of independent rows", around(&tracer)),
        (
            "constrained_forward_dynamics of independent rows in lanes",
            around(&tracer.packed(&limbs)),
        ),
        ("constrained_forward_dynamics_derivatives of independent rows", derivatives(&tracer)),
        (
            "constrained_forward_dynamics_derivatives of independent rows in lanes",
            derivatives(&tracer.column_lanes(COLUMN_LANES)),
        ),
        ("impact_dynamics in lanes", tracer.packed(&limbs).impact_dynamics(&layout)),
        ("project_constraints in lanes", tracer.packed(&limbs).project_constraints(&layout)),
        (
            "constrained_forward_dynamics_derivatives",
            tracer.constrained_forward_dynamics_derivatives(&layout),
        ),
        (
            "constrained_forward_dynamics_derivatives in lanes",
            tracer.column_lanes(COLUMN_LANES).constrained_forward_dynamics_derivatives(&layout),
        ),
        ("impact_dynamics", tracer.impact_dynamics(&layout)),
        ("constrained_inverse_dynamics", evaluation(Function::ConstrainedInverseDynamics)),
        ("operational_space_inertia", tracer.operational_space_inertia(&layout)),
        (
            "operational_space_inertia in lanes",
            tracer.column_lanes(COLUMN_LANES).operational_space_inertia(&layout),
        ),
        ("constraint_jacobian", evaluation(Function::ConstraintJacobian)),
        ("constraint_jacobian_dot_qd", evaluation(Function::ConstraintJacobianDotQd)),
        ("constraint_residual", evaluation(Function::ConstraintResidual)),
        ("project_constraints", tracer.project_constraints(&layout)),
    ]
    .map(|(name, graph)| (name, optimize(graph).count().total()));
    let frozen = [
        ("constrained_forward_dynamics", 9303),
        ("constrained_forward_dynamics in lanes", 4982),
        ("constrained_forward_dynamics of independent rows", 7845),
        ("constrained_forward_dynamics of independent rows in lanes", 3524),
        ("constrained_forward_dynamics_derivatives of independent rows", 64756),
        ("constrained_forward_dynamics_derivatives of independent rows in lanes", 29362),
        ("impact_dynamics in lanes", 4284),
        ("project_constraints in lanes", 5260),
        ("constrained_forward_dynamics_derivatives", 70694),
        ("constrained_forward_dynamics_derivatives in lanes", 31772),
        ("impact_dynamics", 7297),
        ("constrained_inverse_dynamics", 2111),
        ("operational_space_inertia", 11061),
        ("operational_space_inertia in lanes", 7533),
        ("constraint_jacobian", 400),
        ("constraint_jacobian_dot_qd", 424),
        ("constraint_residual", 540),
        ("project_constraints", 8573),
    ];
    assert_eq!(found, frozen);

    // The products of a map are loops.
    let arguments = Function::ConstrainedForwardDynamicsDerivatives.row().arguments.iter();
    let sizes = Sizes::new(&model, layout.size());
    let arguments = arguments.map(|argument| argument.shape(&sizes).len()).sum();
    let counts =
        [(1, Execution::Scalar), (COLUMN_LANES, Execution::Simd)].map(|(lanes, execution)| {
            let loops = DenseLoops { rows: Some(arguments), products: true };
            let tracer = tracer.column_lanes(lanes).with_loops(loops);
            let graph = optimize(tracer.constrained_forward_dynamics_derivatives(&layout));
            let program = Program::try_new(&graph, arguments, execution).expect("valid");
            [program.static_operations(), program.operations_per_call()].map(|count| count.total())
        });
    assert_eq!(counts, [[28716, 67576], [19093, 29441]]);
}
