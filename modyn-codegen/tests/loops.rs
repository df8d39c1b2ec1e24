//! Closed loops. The four-bar linkage and the five-bar robot are compared with their closed-form positions and with
//! Lagrange's equation in as many coordinates as they have degrees of freedom. Any robot is compared with finite
//! differences, and the interpreter with the generated code.

use std::f64::consts::PI;

use modyn_codegen::diagnostics::Code;
use modyn_codegen::passes::optimize;
use modyn_codegen::trace::Tracer;
use modyn_codegen::{Base, Loop, LoopConstraintKind, LoopEnd, ReadOptions, read};
use modyn_codegen::{Builder, Function};
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::constraints::{
    ConstrainedInverseOutputs, ConstrainedOutputs, ProjectionOutputs, ResidualOutputs,
};
use modyn_runtime::equations::soft_constraints::{LoopParameters, SoftModel};
use modyn_runtime::equations::{ForwardInput, Motion, State};
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{JointFriction, LoopConstraint, Model, ModelErrorKind, ModuleTree};
use modyn_runtime::spatial::{Pose, Twist, Wrench};
use modyn_runtime::{ConstraintSettings, Forces, Interpreter};

use crate::single_precision::step as soft_step;

const FOUR_BAR: &str = include_str!("../../robots/four_bar.urdf");
const FIVE_BAR: &str = include_str!("../../robots/five_bar.urdf");
const JOINT_ZOO: &str = include_str!("../../robots/joint_zoo.urdf");

fn model(text: &str) -> Model {
    model_with(text, &ReadOptions::default())
}

fn model_with(text: &str, options: &ReadOptions) -> Model {
    read(text, "loop.urdf", options).unwrap_or_else(|errors| panic!("{errors}")).model
}

/// A uniform bar, 0.02 m wide and high, with 1 kg/m.
struct Bar {
    length: f64,
    /// The inertia of the bar's rotor.
    armature: f64,
}

impl Bar {
    fn inertia(&self) -> f64 {
        self.length * (self.length.powi(2) + 0.02_f64.powi(2)) / 12.0
    }
}

/// The start of a bar, and the bar's angle.
type Place = ([f64; 2], f64);

/// A planar linkage, described by its geometry alone.
struct Linkage {
    bars: Vec<Bar>,
    /// Returns the places of the bars from the driving angles.
    place: fn(&[f64]) -> Vec<Place>,
    /// Returns the coordinates of the tree from the angles of the bars.
    coordinates: fn(&[f64]) -> Vec<f64>,
    /// The indices of the driving angles in these coordinates.
    driven: &'static [usize],
}

fn tip(([x, z], angle): Place, length: f64) -> [f64; 2] {
    [x + length * angle.cos(), z + length * angle.sin()]
}

/// Returns the angle at `from` of a triangle with the base from `from` to `to` and the sides `own` and `other`; the
/// triangle is on the left.
fn triangle(from: [f64; 2], to: [f64; 2], own: f64, other: f64) -> f64 {
    let [x, z] = [to[0] - from[0], to[1] - from[1]];
    let distance = x.hypot(z);
    z.atan2(x) + ((own * own + distance * distance - other * other) / (2.0 * own * distance)).acos()
}

fn four_bar() -> Linkage {
    fn place(theta: &[f64]) -> Vec<Place> {
        let crank = ([0.0, 0.0], theta[0]);
        let (pin, ground) = (tip(crank, 0.2), [0.5, 0.0]);
        let coupler = (pin, triangle(pin, ground, 0.5, 0.4));
        let [x, z] = tip(coupler, 0.5);
        vec![crank, coupler, (ground, z.atan2(x - 0.5))]
    }
    let bar = |length| Bar { length, armature: 0.0 };
    Linkage {
        bars: [0.2, 0.5, 0.4].map(bar).into(),
        place,
        coordinates: |a| vec![a[0], a[1] - a[0], a[2]],
        driven: &[0],
    }
}

fn five_bar() -> Linkage {
    fn place(theta: &[f64]) -> Vec<Place> {
        let (left, right) = (([0.0, 0.0], theta[0]), ([0.4, 0.0], theta[1]));
        let elbows = [tip(left, 0.3), tip(right, 0.3)];
        let forearm = (elbows[0], triangle(elbows[0], elbows[1], 0.4, 0.4));
        let [x, z] = tip(forearm, 0.4);
        let other = (elbows[1], (z - elbows[1][1]).atan2(x - elbows[1][0]));
        vec![left, forearm, right, other]
    }
    let bar = |(length, armature)| Bar { length, armature };
    Linkage {
        bars: [(0.3, 0.002), (0.4, 0.0), (0.3, 0.002), (0.4, 0.0)].map(bar).into(),
        place,
        coordinates: |a| vec![a[0], a[1] - a[0], a[2], a[3] - a[2]],
        driven: &[0, 2],
    }
}

/// Returns the derivative of `f` by entry `k`, by differences of fourth order.
fn slope(f: &dyn Fn(&[f64]) -> Vec<f64>, at: &[f64], k: usize, step: f64) -> Vec<f64> {
    let value = |by: f64| {
        let mut x = at.to_vec();
        x[k] += by * step;
        f(&x)
    };
    let values = [1.0, -1.0, 2.0, -2.0].map(value);
    (0..values[0].len())
        .map(|i| {
            let [a, b, c, d] = values.each_ref().map(|v| v[i]);
            (8.0 * (a - b) - (c - d)) / (12.0 * step)
        })
        .collect()
}

impl Linkage {
    fn angles(&self, theta: &[f64]) -> Vec<f64> {
        (self.place)(theta).into_iter().map(|(_, angle)| angle).collect()
    }

    fn q(&self, theta: &[f64]) -> Vec<f64> {
        (self.coordinates)(&self.angles(theta))
    }

    /// Returns dq/dt at these rates of the driving angles.
    fn qd(&self, theta: &[f64], rates: &[f64]) -> Vec<f64> {
        let along = |t: &[f64]| {
            let there: Vec<f64> = theta.iter().zip(rates).map(|(x, v)| x + v * t[0]).collect();
            self.q(&there)
        };
        slope(&along, &[0.0], 0, 1e-3)
    }

    /// Returns the centres and angles of the bars, and their angles relative to the bars that carry them.
    fn points(&self, theta: &[f64]) -> Vec<f64> {
        let places = (self.place)(theta).into_iter().zip(&self.bars);
        let points = places.flat_map(|(place, bar)| {
            let [x, z] = tip(place, bar.length / 2.0);
            [x, z, place.1]
        });
        points.chain(self.q(theta)).collect()
    }

    /// Returns the mass matrix in the driving angles.
    fn inertia(&self, theta: &[f64]) -> Vec<f64> {
        let slopes: Vec<Vec<f64>> =
            (0..theta.len()).map(|k| slope(&|x| self.points(x), theta, k, 1e-3)).collect();
        let mut matrix = Vec::new();
        for a in &slopes {
            for b in &slopes {
                let mut entry = 0.0;
                for (i, bar) in self.bars.iter().enumerate() {
                    let joint = 3 * self.bars.len() + i;
                    entry += bar.length * (a[3 * i] * b[3 * i] + a[3 * i + 1] * b[3 * i + 1])
                        + bar.inertia() * a[3 * i + 2] * b[3 * i + 2]
                        + bar.armature * a[joint] * b[joint];
                }
                matrix.push(entry);
            }
        }
        matrix
    }

    fn potential(&self, theta: &[f64]) -> f64 {
        let points = self.points(theta);
        self.bars.iter().enumerate().map(|(i, bar)| 9.81 * bar.length * points[3 * i + 1]).sum()
    }

    /// Returns the accelerations of the driving angles under the tree's torques, by Lagrange's equation.
    fn accelerations(&self, theta: &[f64], rates: &[f64], tau: &[f64]) -> Vec<f64> {
        let n = theta.len();
        let matrix = self.inertia(theta);
        let changes: Vec<Vec<f64>> =
            (0..n).map(|k| slope(&|x| self.inertia(x), theta, k, 2e-3)).collect();
        let force: Vec<f64> = (0..n)
            .map(|i| {
                let weight = slope(&|x| vec![self.potential(x)], theta, i, 1e-3)[0];
                let joints = slope(&|x| self.q(x), theta, i, 1e-3);
                let torque: f64 = joints.iter().zip(tau).map(|(a, b)| a * b).sum();
                let mut coriolis = 0.0;
                for j in 0..n {
                    for k in 0..n {
                        coriolis += (changes[k][i * n + j] - 0.5 * changes[i][j * n + k])
                            * rates[j]
                            * rates[k];
                    }
                }
                torque - weight - coriolis
            })
            .collect();
        match n {
            1 => vec![force[0] / matrix[0]],
            _ => {
                let [a, b, c, d] = [matrix[0], matrix[1], matrix[2], matrix[3]];
                let determinant = a * d - b * c;
                vec![
                    (d * force[0] - b * force[1]) / determinant,
                    (a * force[1] - c * force[0]) / determinant,
                ]
            }
        }
    }

    /// Returns the accelerations of all joints of the tree.
    fn qdd(&self, theta: &[f64], rates: &[f64], tau: &[f64]) -> Vec<f64> {
        let accelerations = self.accelerations(theta, rates, tau);
        let rate = |t: &[f64]| {
            let at = |x: f64, v: f64, a: f64| (x + v * t[0] + 0.5 * a * t[0] * t[0], v + a * t[0]);
            let states = theta.iter().zip(rates).zip(&accelerations);
            let (x, v): (Vec<f64>, Vec<f64>) = states.map(|((x, v), a)| at(*x, *v, *a)).unzip();
            self.qd(&x, &v)
        };
        slope(&rate, &[0.0], 0, 4e-4)
    }
}

/// Pseudo-random numbers in [-1, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        f64::from(u32::try_from(self.0 >> 32).expect("32 bits")) / 2_147_483_648.0 - 1.0
    }

    fn vector(&mut self, n: usize, size: f64) -> Vec<f64> {
        (0..n).map(|_| size * self.next()).collect()
    }
}

/// Returns the accelerations, and the wrenches that close the loops.
fn constrained(
    interpreter: &mut Interpreter,
    state: (&[f64], &[f64], &[f64]),
    settings: &ConstraintSettings<f64>,
) -> (Vec<f64>, Vec<Wrench<f64>>) {
    let (qdd, wrenches, _, _) = constrained_with_rank(interpreter, state, settings);
    (qdd, wrenches)
}

/// The accelerations, the wrenches that close the loops, the residuals, and the rank.
type Constrained = (Vec<f64>, Vec<Wrench<f64>>, Vec<Twist<f64>>, f64);

fn constrained_with_rank(
    interpreter: &mut Interpreter,
    (q, qd, tau): (&[f64], &[f64], &[f64]),
    settings: &ConstraintSettings<f64>,
) -> Constrained {
    let mut qdd = vec![0.0; qd.len()];
    let loops = interpreter.model().loop_constraints().len();
    let (mut wrenches, mut residuals) = (vec![Wrench::zero(); loops], vec![Twist::zero(); loops]);
    let into =
        ConstrainedOutputs { qdd: &mut qdd, wrenches: &mut wrenches, residuals: &mut residuals };
    let solve = Interpreter::constrained_forward_dynamics;
    let rank = solve(interpreter, ForwardInput { q, qd, tau }, &[], settings, into).expect("fits");
    (qdd, wrenches, residuals, rank)
}

/// Returns the displacements and the velocities of the constrained directions of all loops.
fn errors(interpreter: &mut Interpreter, q: &[f64], qd: &[f64]) -> [Vec<f64>; 2] {
    let twists = || vec![Twist::zero(); interpreter.model().loop_constraints().len()];
    let (mut displacements, mut velocities) = (twists(), twists());
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let into = ResidualOutputs { displacements: &mut displacements, velocities: &mut velocities };
    interpreter.constraint_residual(State { q, qd }, &settings, into).expect("fits");
    [displacements, velocities].map(|twists| twists.iter().flat_map(Twist::components).collect())
}

fn assert_near(found: &[f64], expected: &[f64], within: f64) {
    assert_eq!(found.len(), expected.len());
    let size = expected.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= within * size, "{found:?} instead of {expected:?}");
    }
}

/// Returns driving angles at which the linkage can be assembled, far from singular configurations.
fn angles(linkage: &Linkage, random: &mut Random) -> Vec<f64> {
    if linkage.driven.len() == 1 {
        return vec![PI * random.next()];
    }
    vec![1.8 + 0.25 * random.next(), 1.35 + 0.25 * random.next()]
}

fn against_closed_form(text: &str, linkage: &Linkage) {
    let mut interpreter = Interpreter::new(model(text));
    let mut random = Random(1);
    for _ in 0..100 {
        let theta = angles(linkage, &mut random);
        let rates = random.vector(theta.len(), 3.0);
        let (q, qd) = (linkage.q(&theta), linkage.qd(&theta, &rates));
        let tau = random.vector(q.len(), 2.0);
        let [displacements, velocities] = errors(&mut interpreter, &q, &qd);
        assert_near(&displacements, &vec![0.0; displacements.len()], 1e-14);
        assert_near(&velocities, &vec![0.0; velocities.len()], 1e-8);
        let expected = linkage.qdd(&theta, &rates, &tau);
        let settings = ConstraintSettings::<f64>::EXACT;
        let (qdd, _) = constrained(&mut interpreter, (&q, &qd, &tau), &settings);
        assert_near(&qdd, &expected, 1e-7);
        // Without the loop constraint, the accelerations are different.
        let mut free = vec![0.0; q.len()];
        interpreter.forward_dynamics(&q, &qd, &tau, &mut free).expect("fits");
        let differs = free.iter().zip(&qdd).any(|(a, b)| (a - b).abs() > 1e-3 * b.abs());
        assert!(differs, "{free:?}");
    }
}

#[test]
fn the_four_bar_linkage_moves_as_lagranges_equation_says() {
    against_closed_form(FOUR_BAR, &four_bar());
}

#[test]
fn the_five_bar_robot_moves_as_lagranges_equation_says() {
    against_closed_form(FIVE_BAR, &five_bar());
}

/// Returns the four-bar linkage with its coupler cut in the middle and welded by a rigid loop constraint: three of its
/// six rows are redundant.
fn sawn() -> String {
    let half = |name: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0.125 0 0'/><mass value='0.25'/>\
             <inertia ixx='1.6666666666666667e-5' iyy='0.0013104166666666667' \
             izz='0.0013104166666666667' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let (before, rest) = FOUR_BAR.split_once("<link name=\"coupler\">").expect("a coupler");
    let (_, after) = rest.split_once("</link>").expect("closed");
    let (rocker, _) = after.split_once("<loop_joint").expect("a loop");
    format!(
        "{before}{}{rocker}\
         <joint name='rocker_pin' type='continuous'><parent link='rocker'/><child link='rest'/>\
         <origin xyz='0.4 0 0' rpy='0 0 0'/><axis xyz='0 -1 0'/></joint>{}\
         <loop_joint name='weld' type='fixed'><link1 link='coupler' xyz='0.25 0 0'/>\
         <link2 link='rest' xyz='0.25 0 0' rpy='0 3.141592653589793 0'/></loop_joint></robot>",
        half("coupler"),
        half("rest"),
    )
}

#[test]
fn redundant_rows_change_no_acceleration() {
    let linkage = four_bar();
    let point = FOUR_BAR.replace("type=\"revolute\"", "type=\"spherical\"");
    let mut random = Random(2);
    let [mut hinge, mut ball] = [FOUR_BAR, &point].map(|text| Interpreter::new(model(text)));
    let mut weld = Interpreter::new(model(&sawn()));
    let settings = ConstraintSettings::<f64>::EXACT;
    for _ in 0..50 {
        let theta = angles(&linkage, &mut random);
        let rates = random.vector(1, 3.0);
        let (q, qd) = (linkage.q(&theta), linkage.qd(&theta, &rates));
        let tau = [2.0 * random.next(), 0.0, 2.0 * random.next()];
        let (expected, _) = constrained(&mut hinge, (&q, &qd, &tau), &settings);
        let (qdd, _) = constrained(&mut ball, (&q, &qd, &tau), &settings);
        assert_near(&qdd, &expected, 1e-11);
        // The second half of the coupler points in the opposite direction.
        let back = q[0] + q[1] - q[2] + PI;
        let rate = qd[0] + qd[1] - qd[2];
        let (q, qd) = ([q[0], q[1], q[2], back], [qd[0], qd[1], qd[2], rate]);
        let tau = [tau[0], tau[1], tau[2], 0.0];
        let [displacements, _] = errors(&mut weld, &q, &qd);
        assert_near(&displacements, &[0.0; 6], 1e-14);
        let (qdd, _) = constrained(&mut weld, (&q, &qd, &tau), &settings);
        assert_near(&qdd[..3], &expected, 1e-9);
        assert_near(&qdd[3..], &[expected[0] + expected[1] - expected[2]], 1e-9);
    }
}

/// Neither a mount that rotates the linkage, nor an axis with the error of four decimals of pi, locks the linkage.
#[test]
fn a_mounted_linkage_is_not_locked() {
    let linkage = four_bar();
    let (q, qd) = (linkage.q(&[0.8]), linkage.qd(&[0.8], &[2.0]));
    let state = (&*q, &*qd, &[0.1, 0.0, 0.0][..]);
    let settings = ConstraintSettings::<f64>::EXACT;
    let solve = |text: &str| {
        let mut interpreter = Interpreter::new(model(text));
        constrained_with_rank(&mut interpreter, state, &settings)
    };
    let (expected, _, _, rank) = solve(FOUR_BAR);
    assert_eq!(rank, 2.0);
    for rpy in ["0 0 0.3", "0 0 0.7853982", "0 0 1.5708"] {
        let mount = format!(
            "<link name='floor'/><joint name='mount' type='fixed'><parent link='floor'/>\
             <child link='ground'/><origin rpy='{rpy}'/></joint><link name=\"ground\"/>"
        );
        let (qdd, _, _, rank) = solve(&FOUR_BAR.replace("<link name=\"ground\"/>", &mount));
        assert_near(&qdd, &expected, 1e-9);
        assert_eq!(rank, 2.0, "{rpy}");
    }
    let pivot = "<origin xyz=\"0.5 0 0\"/>";
    let off = FOUR_BAR.replace(pivot, "<origin xyz=\"0.5 0 0\" rpy=\"0.0000037 0 0\"/>");
    let (qdd, _, _, rank) = solve(&off);
    assert_near(&qdd, &expected, 1e-4);
    assert_eq!(rank, 2.0);
}

#[test]
fn two_constraints_of_one_joint_share_its_forces() {
    let twice = FOUR_BAR.replace(
        "</robot>",
        "<loop_joint name='again' type='revolute'><link1 link='coupler' xyz='0.5 0 0'/>\
         <link2 link='rocker' xyz='0.4 0 0'/><axis xyz='0 -1 0'/></loop_joint></robot>",
    );
    let linkage = four_bar();
    let (q, qd) = (linkage.q(&[0.8]), linkage.qd(&[0.8], &[2.0]));
    let settings = ConstraintSettings::<f64>::EXACT;
    let state = (&*q, &*qd, &[0.1, 0.0, 0.0][..]);
    let (expected, once) = constrained(&mut Interpreter::new(model(FOUR_BAR)), state, &settings);
    let (qdd, forces) = constrained(&mut Interpreter::new(model(&twice)), state, &settings);
    assert_near(&qdd, &expected, 1e-11);
    for wrench in forces {
        assert_near(&wrench.components().map(|x| 2.0 * x), &once[0].components(), 1e-11);
    }
}

/// Returns a floating robot with joints of all types, one mimic joint, and the selected ones of three loop constraints.
/// With all three there are more rows than joints.
fn bound_zoo(which: &[usize]) -> Model {
    let end = |link: &str, xyz, rpy| LoopEnd { link: link.into(), xyz, rpy };
    let (straight, oblique) = ([0.0; 3], [0.9, -0.4, 1.3]);
    let closed =
        |name: &str, kind, first, second| Loop { name: name.into(), kind, ends: [first, second] };
    let axis = [0.96, 1.2, 1.28];
    let all = [
        closed(
            "slide",
            LoopConstraintKind::Prismatic(axis),
            end("hand", [0.1, 0.2, 0.3], oblique),
            end("platform", [0.2, 0.0, 0.1], straight),
        ),
        closed(
            "hinge",
            LoopConstraintKind::Revolute(axis),
            end("hand", [0.0, 0.1, 0.0], straight),
            end("floor", [0.1, 0.0, 0.2], oblique),
        ),
        closed(
            "ball",
            LoopConstraintKind::Point,
            end("floor", [1.0, 0.2, 0.3], oblique),
            end("tip", [0.0; 3], straight),
        ),
    ];
    let loops = which.iter().map(|&i| all[i].clone()).collect();
    let floor = "<link name='floor'><inertial><mass value='5'/><inertia ixx='0.2' iyy='0.3' izz='0.4' \
                 ixy='0' ixz='0' iyz='0'/></inertial></link>";
    let text = JOINT_ZOO.replace("<link name=\"floor\"/>", floor);
    model_with(&text, &ReadOptions { base: Base::Floating, loops, ..Default::default() })
}

/// Returns a state with quaternions of unit length.
fn state(interpreter: &mut Interpreter, random: &mut Random) -> [Vec<f64>; 3] {
    let (nq, nv) = (interpreter.model().nq(), interpreter.model().nv());
    let mut q = random.vector(nq, 1.0);
    interpreter.normalize_configuration(&mut q).expect("fits");
    [q, random.vector(nv, 1.0), random.vector(nv, 5.0)]
}

#[test]
fn what_parts_changes_as_its_rate_says() {
    let mut interpreter = Interpreter::new(bound_zoo(&[0, 1, 2]));
    let mut random = Random(3);
    for _ in 0..10 {
        let [q, qd, _] = state(&mut interpreter, &mut random);
        let step = 1e-4;
        let mut there = |by: f64| {
            let (mut q_then, by) = (vec![0.0; q.len()], by * step);
            let distance: Vec<f64> = qd.iter().map(|v| v * by).collect();
            interpreter.integrate(&q, &distance, &mut q_then).expect("fits");
            errors(&mut interpreter, &q_then, &qd)
        };
        let [before, after] = [there(-1.0), there(1.0)];
        let [_, velocities] = errors(&mut interpreter, &q, &qd);
        // Angular displacements are no vectors: their derivative is the velocity only near zero.
        for (i, expected) in velocities.iter().enumerate().filter(|(i, _)| i % 6 < 3) {
            let slope = (after[0][i] - before[0][i]) / (2.0 * step);
            assert!((slope - expected).abs() < 1e-5, "{i}: {slope} instead of {expected}");
        }
    }
}

#[test]
fn the_accelerations_keep_what_is_held() {
    for which in [&[0][..], &[1], &[2], &[0, 2]] {
        keeps_what_is_held(&mut Interpreter::new(bound_zoo(which)));
    }
}

fn keeps_what_is_held(interpreter: &mut Interpreter) {
    let mut random = Random(4);
    let settings = ConstraintSettings::<f64>::EXACT;
    for _ in 0..10 {
        let [q, qd, tau] = state(interpreter, &mut random);
        let (qdd, _) = constrained(interpreter, (&q, &qd, &tau), &settings);
        let step = 1e-4;
        let mut velocities = |by: f64| {
            let (mut q_then, by) = (vec![0.0; q.len()], by * step);
            let distance: Vec<f64> =
                qd.iter().zip(&qdd).map(|(v, a)| (v + 0.5 * a * by) * by).collect();
            interpreter.integrate(&q, &distance, &mut q_then).expect("fits");
            let qd: Vec<f64> = qd.iter().zip(&qdd).map(|(v, a)| v + a * by).collect();
            let [_, velocities] = errors(interpreter, &q_then, &qd);
            velocities
        };
        let [before, after] = [velocities(-1.0), velocities(1.0)];
        let size = qdd.iter().fold(1.0_f64, |size, a| size.max(a.abs()));
        for (a, b) in before.iter().zip(&after) {
            let rate = (b - a) / (2.0 * step);
            assert!(rate.abs() < 1e-6 * size * size, "{rate} at accelerations of {size}");
        }
    }
}

/// If the loop's forces act as external forces, inverse dynamics returns the given torques.
#[test]
fn the_forces_are_those_that_close_the_loops() {
    for text in [FOUR_BAR, FIVE_BAR] {
        forces_close(model(text));
    }
    forces_close(bound_zoo(&[0, 2]));
}

fn forces_close(model: Model) {
    let loop_constraints = model.loop_constraints().to_vec();
    let mut interpreter = Interpreter::new(model);
    let mut random = Random(5);
    for _ in 0..10 {
        let [q, qd, tau] = state(&mut interpreter, &mut random);
        let settings = ConstraintSettings::<f64>::DEFAULT;
        let (qdd, forces) = constrained(&mut interpreter, (&q, &qd, &tau), &settings);
        let mut wrenches = vec![Wrench::zero(); interpreter.model().links().len()];
        for (constraint, wrench) in loop_constraints.iter().zip(&forces) {
            let [first, second] = constraint
                .ends
                .each_ref()
                .map(|end| interpreter.link_pose(&q, end.link).expect("a link").compose(&end.pose));
            let force = first.rotate(wrench.force.0);
            let moment = first.rotate(wrench.moment.0);
            for (sign, end) in [(-1.0, 0), (1.0, 1)] {
                let frame = constraint.ends[end].link;
                let origin = interpreter.link_pose(&q, frame).expect("a link").translation;
                let [x, y, z]: [f64; 3] =
                    std::array::from_fn(|i| second.translation[i] - origin[i]);
                let lever = [
                    y * force[2] - z * force[1],
                    z * force[0] - x * force[2],
                    x * force[1] - y * force[0],
                ];
                let six = std::array::from_fn(|i| {
                    sign * if i < 3 { force[i] } else { moment[i - 3] + lever[i - 3] }
                });
                wrenches[frame] += Wrench::from_components(six);
            }
        }
        let mut found = vec![0.0; tau.len()];
        let outside = Forces::InWorldAxes(&wrenches);
        interpreter.inverse_dynamics_external(&q, &qd, &qdd, outside, &mut found).expect("fits");
        let size = qdd.iter().fold(1.0_f64, |size, a| size.max(a.abs()));
        assert_near(&found, &tau, 1e-9 * size);
    }
}

/// Integrates one step by the Runge-Kutta method of fourth order; the torques are zero.
fn step(interpreter: &mut Interpreter, state: &mut [Vec<f64>; 2], h: f64) {
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let tau = vec![0.0; state[1].len()];
    let mut rates: Vec<[Vec<f64>; 2]> = Vec::new();
    let at = |state: &[Vec<f64>; 2], rates: &[Vec<f64>; 2], by: f64| {
        [0, 1].map(|k| state[k].iter().zip(&rates[k]).map(|(x, v)| x + v * by).collect::<Vec<_>>())
    };
    for by in [0.0, 0.5, 0.5, 1.0] {
        let now = rates.last().map_or_else(|| state.clone(), |last| at(state, last, by * h));
        let (qdd, _) = constrained(interpreter, (&now[0], &now[1], &tau), &settings);
        rates.push([now[1].clone(), qdd]);
    }
    for (rate, weight) in rates.iter().zip([1.0, 2.0, 2.0, 1.0]) {
        *state = at(state, rate, weight * h / 6.0);
    }
}

/// Returns the relative change of energy in one second of free motion, in steps of `h`; the loops must remain closed.
fn energy_lost(text: &str, linkage: &Linkage, theta: &[f64], h: f64) -> f64 {
    let mut interpreter = Interpreter::new(model(text));
    let energy = |interpreter: &mut Interpreter, [q, qd]: &[Vec<f64>; 2]| {
        interpreter.kinetic_energy(q, qd).expect("fits")
            + interpreter.potential_energy(q).expect("fits")
    };
    let mut state = [linkage.q(theta), linkage.qd(theta, &vec![3.0; theta.len()])];
    let (start, before) = (state[0].clone(), energy(&mut interpreter, &state));
    let mut time = 0.0;
    while time < 1.0 - 0.5 * h {
        step(&mut interpreter, &mut state, h);
        time += h;
    }
    let [displacements, _] = errors(&mut interpreter, &state[0], &state[1]);
    assert_near(&displacements, &vec![0.0; displacements.len()], 1e-8);
    let moved = state[0].iter().zip(&start).any(|(a, b)| (a - b).abs() > 0.5);
    assert!(moved, "{state:?}");
    (energy(&mut interpreter, &state) - before).abs() / before
}

#[test]
fn energy_is_kept_and_the_loops_stay_closed() {
    for (text, linkage, theta) in
        [(FOUR_BAR, four_bar(), vec![1.2]), (FIVE_BAR, five_bar(), vec![1.9, 1.2])]
    {
        let [coarse, fine] = [1e-3, 2.5e-4].map(|h| energy_lost(text, &linkage, &theta, h));
        // The lost energy is the error of the integrator, which is of fourth order.
        assert!(fine < 1e-7 && fine < coarse / 50.0, "{fine} {coarse}");
    }
}

/// Baumgarte stabilization: phi'' = -2 alpha phi' - beta^2 phi, for any torques.
#[test]
fn what_is_apart_comes_together() {
    let linkage = five_bar();
    let mut q = linkage.q(&[1.9, 1.2]);
    q[1] += 0.02;
    let mut interpreter = Interpreter::new(model(FIVE_BAR));
    let mut state = [q, vec![0.0; 4]];
    let gap = |interpreter: &mut Interpreter, state: &[Vec<f64>; 2]| {
        let [displacements, _] = errors(interpreter, &state[0], &state[1]);
        displacements.iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    let before = gap(&mut interpreter, &state);
    for _ in 0..100 {
        step(&mut interpreter, &mut state, 1e-3);
    }
    // (1 + beta t) exp(-beta t) after 0.1 s at 20/s.
    let expected = before * 3.0 * (-2.0_f64).exp();
    assert!((gap(&mut interpreter, &state) - expected).abs() < 0.02 * expected);
}

#[test]
fn what_has_no_loops_is_a_tree() {
    let text = FOUR_BAR.split_once("<loop_joint").expect("a loop").0.to_owned() + "</robot>";
    let mut interpreter = Interpreter::new(model(&text));
    let (q, qd, tau) = ([0.3, 0.2, 0.1], [1.0, 2.0, 3.0], [0.1, 0.2, 0.3]);
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let (qdd, forces) = constrained(&mut interpreter, (&q, &qd, &tau), &settings);
    let mut expected = [0.0; 3];
    interpreter.forward_dynamics(&q, &qd, &tau, &mut expected).expect("fits");
    assert_near(&qdd, &expected, 1e-12);
    assert!(forces.is_empty());
}

/// The mean length of no contacts was zero, by which moments were divided: the rank was 3.
#[test]
fn a_floating_base_without_contacts_is_carried_by_nothing() {
    let model = bound_zoo(&[0, 2]);
    let mut interpreter = Interpreter::new(model.clone());
    let [q, qd, qdd] = state(&mut interpreter, &mut Random(7));
    let (mut tau, mut expected) = (vec![0.0; qd.len()], vec![0.0; qd.len()]);
    interpreter.inverse_dynamics(&q, &qd, &qdd, &mut expected).expect("fits");
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let mut wrenches = [Wrench::zero(); 2];
    let motion = Motion { q: &q, qd: &qd, qdd: &qdd };
    let into = ConstrainedInverseOutputs { tau: &mut tau, wrenches: &mut wrenches };
    let rank = interpreter.constrained_inverse_dynamics(motion, &[], &settings, into);
    assert_eq!(rank.expect("fits").to_bits(), 0.0_f64.to_bits());
    assert_near(&tau, &expected, 1e-12);
    assert!(wrenches.iter().flat_map(Wrench::components).all(|x| x == 0.0));

    let mechanism = Mechanism::new(&model);
    let tracer = Tracer::new(&mechanism);
    let graph = optimize(tracer.evaluation(Function::ConstrainedInverseDynamics, &model, None));
    let numbers = settings.numbers();
    let found = graph.evaluate(&[&*q, &qd, &qdd, &numbers].concat());
    assert_near(&found, &[expected, vec![0.0; 13]].concat(), 1e-12);
}

#[test]
fn what_gets_compiled_is_what_the_interpreter_computes() {
    for model in [model(FOUR_BAR), model(FIVE_BAR), model(&sawn()), bound_zoo(&[0, 2])] {
        let mechanism = Mechanism::new(&model);
        let tracer = Tracer::new(&mechanism);
        let layout = UduLayout::new(&mechanism, &ModuleTree::chains(&model));
        let graphs = [
            tracer.constrained_forward_dynamics(&layout),
            tracer.evaluation(Function::ConstraintResidual, &model, None),
            tracer.project_constraints(&layout),
        ]
        .map(optimize);
        let mut interpreter = Interpreter::new(model);
        let mut random = Random(6);
        for _ in 0..20 {
            let [q, qd, tau] = state(&mut interpreter, &mut random);
            let settings =
                ConstraintSettings { alpha: 3.0, beta: 5.0, ..ConstraintSettings::<f64>::DEFAULT };
            let numbers = [3.0, 5.0, settings.tolerance, settings.rounding];
            let (qdd, wrenches, residuals, rank) =
                constrained_with_rank(&mut interpreter, (&q, &qd, &tau), &settings);
            let wrenches = wrenches.iter().flat_map(Wrench::components);
            let residuals = residuals.iter().flat_map(Twist::components);
            let expected: Vec<f64> =
                qdd.into_iter().chain(wrenches).chain(residuals).chain([rank]).collect();
            let found = graphs[0].evaluate(&[&*q, &qd, &tau, &numbers].concat());
            assert_near(&found, &expected, 1e-8);
            let found = graphs[1].evaluate(&[&*q, &qd].concat());
            assert_near(&found, &errors(&mut interpreter, &q, &qd).concat(), 1e-12);
            let (mut dq, mut dqd) = (vec![0.0; qd.len()], vec![0.0; qd.len()]);
            let into = ProjectionOutputs { step_q: &mut dq, step_qd: &mut dqd };
            let rank = interpreter
                .project_constraints(State { q: &q, qd: &qd }, &[], &settings, into)
                .expect("fits");
            let found = graphs[2].evaluate(&[&*q, &qd, &numbers].concat());
            assert_near(&found, &[dq, dqd, vec![rank]].concat(), 1e-8);
        }
    }
}

#[test]
fn steps_close_the_loops() {
    let linkage = four_bar();
    let settings = ConstraintSettings::<f64>::DEFAULT;
    let mut random = Random(7);
    for text in [FOUR_BAR, &sawn()] {
        let mut interpreter = Interpreter::new(model(text));
        let n = interpreter.model().nv();
        let theta = angles(&linkage, &mut random);
        let mut q = linkage.q(&theta);
        if n == 4 {
            q.push(q[0] + q[1] - q[2] + PI);
        }
        for (q, by) in q.iter_mut().zip(random.vector(n, 0.05)) {
            *q += by;
        }
        let mut qd = random.vector(n, 1.0);
        let mut step = |q: &mut Vec<f64>, qd: &mut Vec<f64>| {
            let (mut dq, mut dqd) = (vec![0.0; n], vec![0.0; n]);
            let into = ProjectionOutputs { step_q: &mut dq, step_qd: &mut dqd };
            interpreter.project_constraints(State { q, qd }, &[], &settings, into).expect("fits");
            let [displacements, velocities] = errors(&mut interpreter, q, qd);
            let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
            // The smallest change in the metric of kinetic energy only removes kinetic energy.
            let energy = interpreter.kinetic_energy(q, qd).expect("fits");
            let taken = interpreter.kinetic_energy(q, &dqd).expect("fits");
            let closed: Vec<f64> = qd.iter().zip(&dqd).map(|(v, d)| v + d).collect();
            let left = interpreter.kinetic_energy(q, &closed).expect("fits");
            assert!((energy - taken - left).abs() < 1e-9 * energy);
            let [_, still] = errors(&mut interpreter, q, &closed);
            assert!(norm(&still) < 1e-9 * norm(&velocities).max(1.0), "{still:?}");
            *q = q.iter().zip(&dq).map(|(q, d)| q + d).collect();
            *qd = closed;
            norm(&displacements)
        };
        let gaps: Vec<f64> = (0..6).map(|_| step(&mut q, &mut qd)).collect();
        assert!(gaps[0] > 1e-3 && gaps[5] < 1e-13, "{gaps:?}");
    }
}

/// Returns a state near a random one in which the loops are closed.
fn closed_state(interpreter: &mut Interpreter, random: &mut Random) -> [Vec<f64>; 3] {
    let [mut q, mut qd, tau] = state(interpreter, random);
    let settings = ConstraintSettings::<f64>::EXACT;
    for _ in 0..40 {
        let mut dq = vec![0.0; qd.len()];
        let mut dqd = vec![0.0; qd.len()];
        let into = ProjectionOutputs { step_q: &mut dq, step_qd: &mut dqd };
        let state = State { q: &q, qd: &qd };
        interpreter.project_constraints(state, &[], &settings, into).expect("fits");
        let mut moved = vec![0.0; q.len()];
        interpreter.integrate(&q, &dq, &mut moved).expect("fits");
        q = moved;
        qd = qd.iter().zip(&dqd).map(|(v, d)| v + d).collect();
    }
    [q, qd, tau]
}

/// With loops that hardly yield, a step accelerates a closed mechanism as constrained dynamics do, which share no
/// rows with it.
#[test]
fn stiff_loops_of_steps_accelerate_as_loops_of_constrained_dynamics() {
    let zoo = |kind: Option<LoopConstraintKind>, which: usize| {
        let model = bound_zoo(&[which]);
        let mut loops = model.loop_constraints().to_vec();
        loops.iter_mut().for_each(|closed| closed.kind = kind.unwrap_or(closed.kind));
        model.clone().with_loop_constraints(loops).expect("good")
    };
    let kinds = [(None, 0), (None, 1), (None, 2), (Some(LoopConstraintKind::Rigid), 2)];
    let models = kinds.map(|(kind, which)| zoo(kind, which)).into_iter();
    let mut compared = 0;
    for model in models.chain([model(FOUR_BAR), model(FIVE_BAR)]) {
        let model = model.with_joint_friction(JointFriction::None).expect("no friction");
        let mut interpreter = Interpreter::new(model.clone());
        let soft = SoftModel::of(interpreter.model());
        let stiff = |closed: &LoopParameters<f64>| LoopParameters {
            mobility: closed.mobility.map(|mobility| 1e-7 * mobility),
            ..*closed
        };
        let loops = soft.loops.iter().map(stiff).collect();
        interpreter.set_soft_model(SoftModel { loops, joints: vec![None; model.nv()], ..soft });
        let mut random = Random(9);
        for _ in 0..5 {
            let [q, qd, tau] = closed_state(&mut interpreter, &mut random);
            let [displacements, _] = errors(&mut interpreter, &q, &qd);
            if displacements.iter().any(|x| x.abs() > 1e-11) {
                continue;
            }
            let settings = ConstraintSettings::<f64>::EXACT;
            let (expected, _) = constrained(&mut interpreter, (&q, &qd, &tau), &settings);
            let velocities = model.nq()..model.nq() + model.nv();
            let accelerations = velocities.end..velocities.end + model.nv();
            let settings = model.step_settings().numbers().to_vec();
            let given = [q, qd, tau, vec![1e-3], expected.clone(), settings];
            let result = soft_step(&mut interpreter, &given);
            assert_near(&result[accelerations], &expected, 1e-5);
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared}");
}

#[test]
fn single_precision_closes_loops_too() {
    let linkage = four_bar();
    let mut interpreter = Interpreter::<f32>::new(model(FOUR_BAR));
    let mut double = Interpreter::new(model(FOUR_BAR));
    let mut random = Random(8);
    for _ in 0..50 {
        let theta = angles(&linkage, &mut random);
        let (q, qd) = (linkage.q(&theta), linkage.qd(&theta, &[1.0]));
        let exact = ConstraintSettings::<f64>::EXACT;
        let (expected, _) = constrained(&mut double, (&q, &qd, &[0.0; 3]), &exact);
        #[allow(clippy::cast_possible_truncation)]
        let [q, qd] = [q, qd].map(|x| x.iter().map(|x| *x as f32).collect::<Vec<f32>>());
        let (mut qdd, mut wrenches, mut residuals) = ([0.0; 3], [Wrench::zero()], [Twist::zero()]);
        let settings = ConstraintSettings::<f32>::EXACT;
        let into = ConstrainedOutputs {
            qdd: &mut qdd,
            wrenches: &mut wrenches,
            residuals: &mut residuals,
        };
        let solve = Interpreter::constrained_forward_dynamics;
        solve(
            &mut interpreter,
            ForwardInput { q: &q, qd: &qd, tau: &[0.0; 3] },
            &[],
            &settings,
            into,
        )
        .expect("fits");
        assert_near(&qdd.map(f64::from), &expected, 1e-3);
    }
}

#[test]
fn generated_code_says_which_loops_it_closes() {
    let generate =
        |text: &str| Builder::new().urdf_text(text, "loop.urdf").generate().expect("good");
    let closed = generate(FOUR_BAR);
    for part in [
        "pub const LOOP_CONSTRAINT_NAMES: [&'static str; 1] = [\"rocker_pin\"];",
        "| 0 | `rocker_pin` | revolute | `coupler` | `rocker` |",
        "pub fn constrained_forward_dynamics(q: &[f64; 3], qd: &[f64; 3], tau: &[f64; 3], \
         active: (), settings: &__modyn::ConstraintSettings<f64, [__modyn::ContactTarget<f64>; 0]>)",
    ] {
        assert!(closed.text.contains(part), "{part}\n{}", closed.text);
    }
    // The zero rows of an aligned linkage are folded away. With rows in a fixed order, and
    // without rank and residuals, the counts were 186 and 4; pivoting and the norm of the forces add the rest.
    let count = closed.operations.iter().find(|(name, _)| *name == "constrained_forward_dynamics");
    assert_eq!(count.map(|(_, count)| (count.total(), count.others)), Some((223, 18)));
    let derivatives = |text: &str| {
        let of = Function::ConstrainedForwardDynamicsDerivatives;
        let builder = Builder::new().urdf_text(text, "loop.urdf").functions([of]);
        let generated = builder.generate().expect("good");
        generated.operations.iter().map(|(_, count)| count.total()).sum::<usize>()
    };
    assert_eq!([derivatives(FOUR_BAR), derivatives(FIVE_BAR)], [806, 1239]);
    // A tree has no such functions, even if all functions are selected.
    let tree = FOUR_BAR.split_once("<loop_joint").expect("a loop").0.to_owned() + "</robot>";
    let tree = Builder::new().urdf_text(tree, "tree.urdf").functions(Function::ALL.iter().copied());
    let tree = tree.generate().expect("good");
    assert!(!tree.text.contains("__modyn::Constr") && !tree.text.contains("LOOP_CONSTRAINT_NAMES"));
    let counted = tree.operations.iter().chain(&tree.static_operations);
    assert!(counted.map(|(name, _)| name).all(|name| !name.contains("constrain")));
}

#[test]
fn loops_are_read_as_they_are_written() {
    let model = model(include_str!("../../modyn-read/tests/good/loops.urdf"));
    let [point, rigid, hinge, slide] = model.loop_constraints() else { panic!("four loops") };
    assert_eq!((point.name.as_str(), point.kind), ("point", LoopConstraintKind::Point));
    let links = |constraint: &modyn_runtime::model::LoopConstraint| {
        constraint.ends.each_ref().map(|end| model.links()[end.link].name.clone())
    };
    assert_eq!(links(point), ["base", "tool"]);
    let [first, second] = &point.ends;
    assert_eq!(first.pose.translation, [1.0, 2.0, 3.0]);
    assert_near(
        &first.pose.rotation.concat(),
        &[0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        1e-15,
    );
    assert_eq!(second.pose, Pose { translation: [0.5, 0.0, 0.0], ..Pose::identity() });
    assert_eq!(
        (rigid.kind, links(rigid)),
        (LoopConstraintKind::Rigid, ["base".into(), "arm".into()])
    );
    assert_eq!(hinge.kind, LoopConstraintKind::Revolute([1.0, 0.0, 0.0]));
    let LoopConstraintKind::Prismatic(axis) = slide.kind else { panic!("{:?}", slide.kind) };
    assert_near(&axis, &[0.0, 0.6, 0.8], 1e-15);
}

#[test]
fn a_model_says_what_is_wrong_with_its_loop_constraints() {
    let model = model(FOUR_BAR);
    let kinds = |change: &dyn Fn(&mut Vec<LoopConstraint>)| {
        let mut loop_constraints = model.loop_constraints().to_vec();
        change(&mut loop_constraints);
        let errors = model.clone().with_loop_constraints(loop_constraints).expect_err("refused");
        errors.into_iter().map(|error| error.kind).collect::<Vec<_>>()
    };
    use ModelErrorKind::{
        Axis, DuplicateName, LoopConstraintEnds, LoopConstraintLink, NotFinite, Rotation,
    };
    assert_eq!(kinds(&|c| c[0].ends[0].link = 99), [LoopConstraintLink]);
    assert_eq!(kinds(&|c| c[0].ends[0].link = c[0].ends[1].link), [LoopConstraintEnds]);
    assert_eq!(kinds(&|c| c.push(c[0].clone())), [DuplicateName]);
    assert_eq!(kinds(&|c| c[0].ends[0].pose.translation[1] = f64::NAN), [NotFinite]);
    assert_eq!(kinds(&|c| c[0].ends[1].pose.rotation[0][0] = -1.0), [Rotation]);
    assert_eq!(kinds(&|c| c[0].kind = LoopConstraintKind::Prismatic([1.0, 1.0, 0.0])), [Axis]);
    assert_eq!(
        kinds(&|c| c[0].kind = LoopConstraintKind::Revolute([f64::INFINITY; 3])),
        [NotFinite]
    );
}

#[test]
fn an_options_loop_is_checked_as_a_descriptions() {
    let end = |link: &str| LoopEnd { link: link.into(), xyz: [0.0; 3], rpy: [0.0; 3] };
    let codes = |name: &str, kind, ends| {
        let loops = vec![Loop { name: name.into(), kind, ends }];
        let options = ReadOptions { loops, ..Default::default() };
        let errors = read(FOUR_BAR, "loop.urdf", &options).expect_err("refused");
        assert!(errors.iter().all(|error| error.help.is_some() && error.subject.is_some()));
        errors.iter().map(|error| error.code).collect::<Vec<_>>()
    };
    let good = || [end("coupler"), end("ground")];
    let slide = LoopConstraintKind::Prismatic;
    assert_eq!(codes("a", slide([0.0; 3]), good()), [Code::Option]);
    assert_eq!(codes("a", slide([f64::NAN; 3]), good()), [Code::Option]);
    assert_eq!(codes("crank_pin", LoopConstraintKind::Point, good()), [Code::DuplicateJoint]);
    assert_eq!(codes("rocker_pin", LoopConstraintKind::Point, good()), [Code::DuplicateJoint]);
    assert_eq!(codes("a", LoopConstraintKind::Rigid, [end("x"), end("ground")]), [Code::LoopLink]);
    assert_eq!(
        codes("a", LoopConstraintKind::Rigid, [end("crank"), end("crank")]),
        [Code::LoopEnds]
    );
    let far = LoopEnd { rpy: [0.0, f64::INFINITY, 0.0], ..end("crank") };
    assert_eq!(codes("a", LoopConstraintKind::Point, [far, end("ground")]), [Code::NotFinite]);
    // A model contains its loop constraints already.
    let closing = Loop { name: "a".into(), kind: LoopConstraintKind::Point, ends: good() };
    let builder = Builder::new().model(model(FOUR_BAR)).loops([closing]);
    let errors = builder.generate().expect_err("refused");
    assert_eq!(errors.iter().map(|error| error.code).collect::<Vec<_>>(), [Code::Option]);
    let moon = Builder::new().model(model(FOUR_BAR)).gravity([0.0, 0.0, -1.62]);
    assert_eq!(moon.generate().expect("good").model.loop_constraints().len(), 1);
}
