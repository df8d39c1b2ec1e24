//! The laws of mechanics in steps of random robots in general position: only forces from outside change
//! the momentum, and contacts take energy.

use modyn_runtime::equations::soft_constraints::{SoftModel, StepInput, TouchingPoint};
use modyn_runtime::equations::{Motion, State, TimeStepInput};
use modyn_runtime::joint::JointType;
use modyn_runtime::model::{ContactShape, Model};
use modyn_runtime::spatial::{Matrix3, Momentum, Vector3};
use modyn_runtime::{ContactSurface, Interpreter, StepSettings, StepSolutionOutputs};
use serde_json::Value;

use crate::soft_steps::{floor, list, numbers, records, text};

/// A robot whose only joint to the world is a floating base, and one of its states.
struct Floating {
    model: Model,
    states: Vec<[Vec<f64>; 3]>,
}

/// Returns the random robots over a plane that no loop holds to the world, with their states and joint
/// forces. Their floating bases have neither rotors nor dampers, whose forces come from outside.
fn floating() -> Vec<Floating> {
    let robots = records("floors.json").into_iter().map(|file| {
        let mjcf = text(&file["mjcf"]);
        let model = match mjcf.split_once(r#"<joint type="free""#) {
            Some((before, after)) => {
                let (_, after) = after.split_once("/>").expect("an end");
                floor(&format!("{before}<freejoint/>{after}"))
            }
            None => floor(mjcf),
        };
        let state = |state: &Value| {
            let [q, qd, mut tau] = ["q", "qd", "tau"].map(|name| numbers(&state[name]));
            tau[..6].fill(0.0);
            [q, qd, tau]
        };
        Floating { model, states: list(&file["states"]).iter().map(state).collect() }
    });
    let is_free = |Floating { model, .. }: &Floating| {
        let roots = model.moving_links().iter().filter(|link| link.parent.is_none());
        let all = roots.map(|link| link.joint.joint_type).collect::<Vec<_>>();
        let loops = model.loop_constraints().iter().flat_map(|one| &one.ends);
        let holds = |frame: usize| model.links()[frame].moving_link.is_some();
        all == [JointType::Floating] && loops.into_iter().all(|end| holds(end.link))
    };
    let robots: Vec<Floating> = robots.filter(is_free).collect();
    assert!(robots.len() > 40, "{}", robots.len());
    robots
}

/// The state after a step, the accelerations, and the forces of the points.
struct Stepped {
    q: Vec<f64>,
    qd: Vec<f64>,
    qdd: Vec<f64>,
    forces: Vec<[f64; 3]>,
}

type Settings = StepSettings<f64, Vec<ContactSurface<f64>>>;

fn step(
    robot: &mut Interpreter<f64>,
    input: TimeStepInput<'_, f64>,
    settings: &Settings,
) -> Stepped {
    let TimeStepInput { q, qd, .. } = input;
    let points = robot.touching_points(State { q, qd }, settings).expect("lengths").len();
    let mut forces = vec![[0.0; 3]; points];
    let [mut next_q, mut next_qd, mut qdd] = [q.to_vec(), qd.to_vec(), qd.to_vec()];
    let outputs = StepSolutionOutputs {
        q: &mut next_q,
        qd: &mut next_qd,
        qdd: &mut qdd,
        forces: forces.as_flattened_mut(),
        residual: &mut 0.0,
        iterations: &mut 0.0,
    };
    let warm_start = vec![0.0; qd.len()];
    robot
        .step(StepInput { step: input, warm_start: &warm_start }, settings, outputs)
        .expect("good");
    Stepped { q: next_q, qd: next_qd, qdd, forces }
}

fn mass(model: &Model) -> f64 {
    model.moving_links().iter().map(|link| link.inertial.mass).sum()
}

/// The rate of the momentum about the centre of mass is the wrench of gravity and of the contacts: joint
/// limits, friction, dampers, tendons, couplings and closed loops act within the robot. In the air the
/// wrench is the weight.
#[test]
fn momentum_changes_by_forces_from_outside() {
    let [mut pushing, mut turning] = [0; 2];
    for (seed, Floating { model, states }) in floating().into_iter().enumerate() {
        let mut robot = Interpreter::<f64>::new(model.clone());
        let settings = Settings { tolerance: 1e-13, ..model.step_settings() };
        let weight = Vector3(model.gravity()).scale(mass(&model));
        for [q, qd, tau] in states {
            for height in [0.0, 50.0] {
                let mut q = q.clone();
                q[2] += height;
                let points =
                    robot.touching_points(State { q: &q, qd: &qd }, &settings).expect("lengths");
                let input = TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: 0.002 };
                let Stepped { qdd, forces, .. } = step(&mut robot, input, &settings);
                let motion = Motion { q: &q, qd: &qd, qdd: &qdd };
                let rate: Momentum<f64> = robot.centroidal_momentum_rate(motion).expect("lengths");
                let center = Vector3(robot.center_of_mass(&q).expect("lengths"));
                let [mut force, mut moment] = [weight, Vector3([0.0; 3])];
                let mut size = weight.dot(weight).sqrt();
                for (TouchingPoint { shape, place, .. }, in_plane) in points.iter().zip(&forces) {
                    let plane = settings.surfaces[*shape].plane.rotation;
                    let push = Matrix3(plane).mul_vector(Vector3(*in_plane));
                    force += push;
                    moment += (*place - center).cross(push);
                    size = size.max(push.dot(push).sqrt());
                    pushing += usize::from(push.dot(push) > 0.0);
                }
                assert!(height < 1.0 || forces.iter().all(|force| *force == [0.0; 3]), "{seed}");
                let shapes = model.touching_shapes();
                // The moments of contacts of four and six components are no results.
                let has_moments = shapes.iter().any(|shape| shape.components.count() > 3);
                let mut pairs: Vec<[Vector3<f64>; 2]> = vec![[rate.linear, force]];
                // The opposite forces of a loop that is not closed act at two places.
                if model.loop_constraints().is_empty() && (height > 1.0 || !has_moments) {
                    turning += usize::from(height < 1.0);
                    pairs.push([rate.angular, moment]);
                }
                for [rate, wrench] in pairs {
                    let difference = rate - wrench;
                    let error = difference.dot(difference).sqrt() / size;
                    assert!(error < 1e-8, "{seed} {height}: {rate:?} {wrench:?} {error:e}");
                }
            }
        }
    }
    assert!(pushing > 100 && turning > 10, "{pushing} {turning}");
}

/// The velocity of a point is the velocity of its link there, and its part along the normal is the rate of
/// the gap.
#[test]
fn velocities_of_touching_points() {
    for Floating { model, states } in floating() {
        let mut robot = Interpreter::<f64>::new(model.clone());
        let shapes = model.touching_shapes();
        let settings = model.step_settings();
        for [q, qd, _] in states {
            let mut points = |q: &[f64]| {
                robot.touching_points(State { q, qd: &qd }, &settings).expect("lengths")
            };
            let here = points(&q);
            let rest = Interpreter::<f64>::new(model.clone());
            let after = |time: f64| {
                let mut moved = q.clone();
                let change: Vec<f64> = qd.iter().map(|v| v * time).collect();
                rest.integrate(&q, &change, &mut moved).expect("lengths");
                moved
            };
            let [before, later] = [-1e-6, 1e-6].map(|time| points(&after(time)));
            for (point, (before, later)) in here.iter().zip(before.iter().zip(&later)) {
                let link = shapes[point.shape].end.link;
                let twist = robot.link_velocity(&q, &qd, link).expect("a link");
                let origin = Vector3(robot.link_pose(&q, link).expect("a link").translation);
                let in_world = twist.linear + twist.angular.cross(point.place - origin);
                let plane = Matrix3(settings.surfaces[point.shape].plane.rotation);
                let expected = plane.transposed().mul_vector(in_world);
                let size = 1.0 + in_world.dot(in_world).sqrt();
                for (found, expected) in point.velocity.0.iter().zip(expected.0) {
                    assert!((found - expected).abs() < 1e-12 * size, "{found} {expected}");
                }
                // The points of a cylinder move along its disks.
                if !matches!(shapes[point.shape].shape, ContactShape::Cylinder(_)) {
                    let rate = (later.gap - before.gap) / 2e-6;
                    assert!((rate - point.velocity.0[2]).abs() < 1e-6 * size, "{rate} {point:?}");
                }
            }
        }
    }
}

/// A ground almost without friction hardly pushes along itself: in a motion over it only gravity changes
/// the momentum along it, up to the error of the steps. Friction changes the momentum.
#[test]
fn slippery_ground_keeps_the_momentum_along_it() {
    let [mut largest, mut pushed] = [0.0_f64; 2];
    for (seed, Floating { model, states }) in floating().into_iter().enumerate().step_by(12) {
        let mut robot = Interpreter::<f64>::new(model.clone());
        let plane = Matrix3(model.step_settings().surfaces[0].plane.rotation);
        let along = [plane.column(0), plane.column(1)];
        let [q, qd, _] = &states[0];
        let tau = vec![0.0; model.nv()];
        let dt = 5e-4;
        let steps = 150;
        let change = |friction: f64, robot: &mut Interpreter<f64>| {
            let mut settings = model.step_settings();
            for surface in &mut settings.surfaces {
                surface.friction = friction;
            }
            let momentum = |robot: &mut Interpreter<f64>, q: &[f64], qd: &[f64]| {
                robot.centroidal_momentum(q, qd).expect("lengths").linear
            };
            let before = momentum(robot, q, qd);
            let [mut q, mut qd] = [q.clone(), qd.clone()];
            let mut push = 0.0_f64;
            for _ in 0..steps {
                let input = TimeStepInput { q: &q, qd: &qd, tau: &tau, dt };
                let next = step(robot, input, &settings);
                push += next.forces.iter().map(|force| dt * force[2]).sum::<f64>();
                [q, qd] = [next.q, next.qd];
            }
            let fall = Vector3(model.gravity()).scale(mass(&model) * dt * f64::from(steps));
            let change = momentum(robot, &q, &qd) - before - fall;
            let along = along.map(|axis| axis.dot(change).abs());
            [along[0].max(along[1]) / push.max(mass(&model)), push]
        };
        let [without, push] = change(1e-4, &mut robot);
        let [with, _] = change(1.0, &mut robot);
        assert!(without < 1e-2, "{seed}: {without} of {push}");
        largest = largest.max(with);
        pushed += f64::from(u8::from(push > 0.0));
    }
    assert!(largest > 0.1 && pushed > 1.0, "{largest} {pushed}");
}

/// A passive robot that is thrown on the ground never has more energy than at the start, and loses some at each impact.
#[test]
fn contacts_dissipate_energy() {
    for (seed, Floating { model, states }) in floating().into_iter().enumerate().step_by(15) {
        let mut robot = Interpreter::<f64>::new(model.clone());
        // Limits, tendons, couplings and loops can store energy at the start.
        let mut soft = SoftModel::of(&model);
        soft.stops().for_each(|stops| stops.range = [None; 2]);
        soft.tendons.clear();
        soft.couplings.clear();
        soft.loops.clear();
        robot.set_soft_model(soft);
        let settings = model.step_settings();
        let [q, qd, _] = &states[0];
        let [mut q, mut qd] = [q.clone(), qd.clone()];
        let gaps = robot.touching_points(State { q: &q, qd: &qd }, &settings).expect("lengths");
        let lowest = gaps.iter().map(|point| point.gap).fold(f64::INFINITY, f64::min);
        q[2] += 0.02 - lowest;
        let height = robot.center_of_mass(&q).expect("lengths")[2];
        let energy = |robot: &mut Interpreter<f64>, q: &[f64], qd: &[f64]| {
            let kinetic = robot.kinetic_energy(q, qd).expect("lengths");
            kinetic + robot.potential_energy(q).expect("lengths")
        };
        let first = energy(&mut robot, &q, &qd);
        let tau = vec![0.0; model.nv()];
        let [mut most, mut impacts] = [f64::NEG_INFINITY, 0.0];
        for _ in 0..1500 {
            let input = TimeStepInput { q: &q, qd: &qd, tau: &tau, dt: 5e-4 };
            let next = step(&mut robot, input, &settings);
            impacts += f64::from(u8::from(next.forces.iter().any(|force| force[2] > 0.0)));
            [q, qd] = [next.q, next.qd];
            most = most.max(energy(&mut robot, &q, &qd));
        }
        let lost = first - energy(&mut robot, &q, &qd);
        assert!(impacts > 100.0, "{seed}: {impacts}");
        assert!(lost > 0.0 && most < first + 2e-3 * lost, "{seed} {height}: {first} {most} {lost}");
    }
}
