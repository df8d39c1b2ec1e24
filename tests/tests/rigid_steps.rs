//! Rigid contacts: steps beside exact complementarity and Coulomb's law, and motions beside their
//! closed forms.

use modyn_codegen::{Base, ReadOptions, read};
use modyn_runtime::equations::TimeStepInput;
use modyn_runtime::equations::soft_constraints::{SoftModel, StepInput};
use modyn_runtime::model::{Cone, Contact, ContactKind, LoopConstraintEnd, Model};
use modyn_runtime::spatial::{Matrix3, Pose, Twist, Vector3};
use modyn_runtime::{ContactSurface, Interpreter, StepSettings, StepSolutionOutputs};
use modyn_tests::random::Random;

use crate::soft_steps::floor;

const DT: f64 = 0.002;
/// The random motions of each robot and cone, and the steps of each.
const MOTIONS: usize = 25;
const STEPS: usize = 12;

type Settings = StepSettings<f64, Vec<ContactSurface<f64>>>;

/// A state, the accelerations from which its step starts, and the results of the step before.
#[derive(Clone)]
struct Moving {
    q: Vec<f64>,
    qd: Vec<f64>,
    qdd: Vec<f64>,
    forces: Vec<[f64; 3]>,
    residual: f64,
}

impl Moving {
    fn new(q: Vec<f64>, qd: Vec<f64>, points: usize) -> Self {
        let qdd = vec![0.0; qd.len()];
        Self { q, qd, qdd, forces: vec![[0.0; 3]; points], residual: 0.0 }
    }

    /// Returns the motion after a step.
    fn step(&self, robot: &mut Interpreter<f64>, tau: &[f64], settings: &Settings) -> Self {
        let mut next = self.clone();
        let step = TimeStepInput { q: &self.q, qd: &self.qd, tau, dt: DT };
        let outputs = StepSolutionOutputs {
            q: &mut next.q,
            qd: &mut next.qd,
            qdd: &mut next.qdd,
            forces: next.forces.as_flattened_mut(),
            residual: &mut next.residual,
            iterations: &mut 0.0,
        };
        let input = StepInput { step, warm_start: &self.qdd };
        robot.step(input, settings, outputs).expect("lengths");
        next
    }
}

/// A robot of this repository with points, in a posture in which its feet are below its trunk.
struct Legged {
    model: Model,
    posture: Vec<f64>,
}

impl Legged {
    fn new(name: &str, points: &[(&str, [f64; 3])], bend: impl Fn(&str) -> f64) -> Self {
        let path = format!("{}/../robots/{name}.urdf", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("a robot");
        let options = ReadOptions { base: Base::Floating, ..ReadOptions::default() };
        let model = read(&text, name, &options).expect("good").model;
        let contacts = points.iter().enumerate().map(|(k, &(link, translation))| {
            let frame = model.links().iter().position(|frame| frame.name == link);
            let pose = Pose { translation, ..Pose::identity() };
            let end = LoopConstraintEnd { link: frame.expect("a link"), pose };
            Contact { name: format!("point {k}"), kind: ContactKind::Point, end }
        });
        let contacts = contacts.collect();
        let model = model.with_contacts(contacts).expect("contacts");
        let bends = model.moving_links().iter().skip(1).map(|link| bend(&link.joint.name));
        let base = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let posture = base.into_iter().chain(bends).collect();
        Self { model, posture }
    }

    fn quadruped() -> Self {
        let feet = ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"]
            .map(|foot| (foot, [0.0; 3]));
        Self::new("quadruped", &feet, |joint| {
            let side = if joint.starts_with("front") { 1.0 } else { -1.0 };
            match joint {
                joint if joint.ends_with("knee") => -1.2 * side,
                joint if joint.contains("pitch") => 0.6 * side,
                _ => 0.0,
            }
        })
    }

    fn humanoid() -> Self {
        let corners = [[0.12, 0.03], [0.12, -0.03], [-0.05, 0.025], [-0.05, -0.025]];
        let soles = ["left_ankle_roll_link", "right_ankle_roll_link"];
        let points = soles.map(|sole| corners.map(|[x, y]| (sole, [x, y, -0.035])));
        Self::new("humanoid", points.as_flattened(), |joint| match joint {
            joint if joint.contains("knee") => 0.42,
            joint if joint.contains("pitch") && !joint.contains("shoulder") => -0.21,
            _ => 0.0,
        })
    }

    /// Returns a random motion near the posture, and the settings of a ground with an oblique plane
    /// for each link, a little above or below its points.
    fn near_the_ground(&self, random: &mut Random) -> (Moving, Settings) {
        let robot = Interpreter::<f64>::new(self.model.clone());
        let mut vector = |size: f64| -> Vec<f64> {
            (0..self.model.nv()).map(|_| random.between(-size, size)).collect()
        };
        let mut q = self.posture.clone();
        robot.integrate(&self.posture, &vector(0.2), &mut q).expect("lengths");
        let qd = vector(0.5);
        let mut settings = self.model.step_settings();
        let mut plane = Pose::identity();
        let mut frame = usize::MAX;
        for (contact, surface) in self.model.contacts().iter().zip(&mut settings.surfaces) {
            let end = &contact.end;
            if frame != end.link {
                frame = end.link;
                let [x, y] = [0; 2].map(|_| random.between(-0.1, 0.1));
                let z = Vector3([x, y, 1.0]).scale((1.0 + x * x + y * y).sqrt().recip());
                let side =
                    z.cross(Vector3([random.between(0.5, 1.0), random.between(0.5, 1.0), 0.1]));
                let side = side.scale(side.dot(side).sqrt().recip());
                let axes = [side, z.cross(side), z];
                plane.rotation = Matrix3::from_columns(|k| axes[k]).0;
            }
            let [point, _] = place(&robot, &q, end);
            let depth = random.between(-2e-4, 5e-4);
            plane.translation = (point + Matrix3(plane.rotation).column(2).scale(depth)).0;
            surface.plane = plane;
            surface.friction = 0.7;
        }
        (Moving::new(q, qd, self.model.contacts().len()), settings)
    }
}

/// Returns the position of a point in the world, and relative to its link's origin.
fn place(robot: &Interpreter<f64>, q: &[f64], end: &LoopConstraintEnd) -> [Vector3<f64>; 2] {
    let pose = robot.link_pose(q, end.link).expect("a link");
    let lever = Matrix3(pose.rotation).mul_vector(Vector3(end.pose.translation));
    [Vector3(pose.translation) + lever, lever]
}

/// How far the contacts after steps are from complementarity and from Coulomb's law.
#[derive(Default)]
struct Distance {
    /// The velocities along the normal of contacts that stick, beside that at which depth decays, m/s.
    closing: Vec<f64>,
    /// The slip of contacts that stick, m/s.
    sticking: Vec<f64>,
    /// The slip of contacts that slide, m/s.
    sliding: Vec<f64>,
    /// The velocities along the normal of contacts that slide, beside that at which depth decays, m/s.
    separation: Vec<f64>,
    /// The angles between the friction and the direction against the slip, degrees.
    angle: Vec<f64>,
}

impl Distance {
    /// Adds the contacts that touch before a step and push in it.
    fn add(
        &mut self,
        robot: &mut Interpreter<f64>,
        [start, end]: [&Moving; 2],
        settings: &Settings,
        cone: Cone,
    ) {
        let contacts = robot.model().contacts().to_vec();
        // The velocity after the step, in the axes of the base before it.
        let [before, after] = [start, end]
            .map(|moving| Matrix3(robot.link_pose(&moving.q, 0).expect("base").rotation));
        let turned = before.transposed().times(&after);
        let mut qd = end.qd.clone();
        let linear = turned.mul_vector(Vector3([qd[0], qd[1], qd[2]]));
        qd[..3].copy_from_slice(&linear.0);
        let contacts = contacts.iter().zip(&settings.surfaces).zip(&end.forces);
        for ((Contact { end, .. }, surface), force) in contacts {
            let axes = Matrix3(surface.plane.rotation);
            let [point, lever] = place(robot, &start.q, end);
            let gap = axes.column(2).dot(point - Vector3(surface.plane.translation));
            let [x, y, push] = *force;
            if gap >= 0.0 || push <= 0.0 {
                assert_eq!(*force, [0.0; 3]);
                continue;
            }
            // The contact is half way between the point and the plane.
            let lever = lever - axes.column(2).scale(gap / 2.0);
            let mut columns = vec![Twist::zero(); qd.len()];
            robot.jacobian(&start.q, end.link, &mut columns).expect("a link");
            let velocity = columns.iter().zip(&qd).fold(Vector3::zero(), |sum, (column, &rate)| {
                sum + (column.linear + column.angular.cross(lever)).scale(rate)
            });
            let [first, second, normal] = [0, 1, 2].map(|k| axes.column(k).dot(velocity));
            let normal = normal + gap / (16.0 * DT);
            let slip = first.hypot(second);
            let drag = match cone {
                Cone::Elliptic => x.hypot(y),
                Cone::Pyramidal => x.abs() + y.abs(),
            };
            if drag < surface.friction * push * (1.0 - 1e-6) {
                self.closing.push(normal.abs());
                self.sticking.push(slip);
            } else {
                self.sliding.push(slip);
                self.separation.push(normal.abs());
                let cosine = -(x * first + y * second) / (slip * x.hypot(y));
                self.angle.push(cosine.clamp(-1.0, 1.0).acos().to_degrees());
            }
        }
    }

    /// Returns the distances of steps with rigid contacts from the states of random motions: by the
    /// share of Coulomb's law that `rigid` selects, and by MuJoCo's law.
    fn of(legged: &Legged, cone: Cone) -> [Self; 2] {
        let mut robot = Interpreter::<f64>::new(legged.model.clone());
        let soft = SoftModel::of(robot.model());
        robot.set_soft_model(SoftModel { cone, ..soft });
        let mut random = Random::new(7);
        let [mut distance, mut by_mujoco] = [Self::default(), Self::default()];
        for _ in 0..MOTIONS {
            let (mut moving, settings) = legged.near_the_ground(&mut random);
            let rigid = settings.rigid();
            let mujoco = Settings { coulomb: 0.0, ..rigid.clone() };
            let tau = vec![0.0; moving.qd.len()];
            for k in 0..STEPS {
                let next = moving.step(&mut robot, &tau, &rigid);
                assert!(next.residual <= rigid.tolerance, "{}", next.residual);
                // In the first steps, contacts land.
                if k > 2 {
                    distance.add(&mut robot, [&moving, &next], &rigid, cone);
                    let hopping = moving.step(&mut robot, &tau, &mujoco);
                    by_mujoco.add(&mut robot, [&moving, &hopping], &mujoco, cone);
                }
                moving = next;
            }
        }
        [distance, by_mujoco]
    }
}

/// Returns a quantile.
fn quantile(numbers: &[f64], share: f64) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted[(share * (sorted.len() - 1) as f64) as usize]
}

/// `cargo test -p modyn-tests --test tests rigid_contacts -- --nocapture` prints the numbers of
/// docs/data/rigid-contacts.tsv.
#[test]
fn rigid_contacts_are_near_complementarity_and_coulombs_law() {
    for (name, legged) in [("quadruped", Legged::quadruped()), ("humanoid", Legged::humanoid())] {
        for cone in [Cone::Pyramidal, Cone::Elliptic] {
            let [rigid, by_mujoco] = Distance::of(&legged, cone);
            let Distance { closing, sticking, sliding, separation, angle } = &rigid;
            let speeds = [sticking, closing, sliding, separation, &by_mujoco.separation];
            let row = speeds.map(|numbers| {
                let [median, most] = [0.5, 0.99].map(|share| 1e3 * quantile(numbers, share));
                format!("{median:.2}, {most:.2}")
            });
            let angles = [0.5, 0.99].map(|share| quantile(angle, share));
            let counts = [sticking.len(), sliding.len()];
            println!("| {name}, {cone:?} | {counts:?} | {} | {angles:.1?} |", row.join(" | "));
            assert!(counts.into_iter().all(|count| count > 20), "{counts:?}");
            assert!(quantile(sticking, 0.99) < 2e-3 && quantile(closing, 0.5) < 5e-3);
            let [large, large_by_mujoco] =
                [separation, &by_mujoco.separation].map(|numbers| quantile(numbers, 0.9));
            assert!(large < 0.5 * large_by_mujoco, "{large} {large_by_mujoco}");
            // The edges of a pyramid are up to 45 degrees off the slip.
            let most = if cone == Cone::Elliptic { 5.0 } else { 46.0 };
            assert!(angles[1] < most, "{angles:?}");
        }
    }
}

/// Returns a box on a plane with the friction 0.5.
fn sliding_box(cone: &str) -> Model {
    floor(&format!(
        "<mujoco model='box'><option cone='{cone}'/><worldbody>\
         <geom type='plane' size='1 1 1' friction='0.5 0 0'/><body pos='0 0 0.05'><freejoint/>\
         <geom type='box' size='0.1 0.15 0.05' mass='2' friction='0.5 0 0'/></body>\
         </worldbody></mujoco>"
    ))
}

/// A box that slides on its plane is decelerated by its friction, and does not lift off: by MuJoCo's law
/// with as stiff contacts it hops.
#[test]
fn a_rigid_box_slides_by_coulombs_law() {
    // Pyramids have the friction of Coulomb's law along their edges.
    for (cone, angle) in [("elliptic", 0.3_f64), ("pyramidal", 0.0)] {
        let model = sliding_box(cone);
        let mut robot = Interpreter::<f64>::new(model.clone());
        let rigid = model.step_settings().rigid();
        let mut slide = |coulomb: f64| {
            let settings = Settings { coulomb, ..rigid.clone() };
            let q = vec![0.0, 0.0, 0.05 - 1e-6, 0.0, 0.0, 0.0, 1.0];
            let qd = vec![angle.cos(), angle.sin(), 0.0, 0.0, 0.0, 0.0];
            let mut moving = Moving::new(q, qd, 4);
            let mut heights = Vec::new();
            for _ in 0..150 {
                moving = moving.step(&mut robot, &[0.0; 6], &settings);
                heights.push(moving.q[2] - 0.05);
            }
            assert!(moving.qd.iter().all(|rate| rate.abs() < 1e-3), "{:?}", moving.qd);
            let way = [moving.q[0], moving.q[1]];
            (way, [quantile(&heights, 0.0), quantile(&heights, 1.0)])
        };
        let ([x, y], [lowest, highest]) = slide(1.0);
        let expected = 1.0 / (2.0 * 0.5 * 9.81);
        assert!((x.hypot(y) / expected - 1.0).abs() < 0.01, "{x} {y} {expected}");
        assert!((y.atan2(x) - angle).abs() < 1e-3, "{x} {y}");
        assert!(highest < 1e-6 && lowest > -2e-4, "{lowest} {highest}");
        let (_, [_, hop]) = slide(0.0);
        assert!(hop > 5e-3, "{hop}");
    }
}

/// A box that falls on its plane at any time within a step is stopped within the way of a step, and
/// rebounds with less than a tenth of its speed.
#[test]
fn a_rigid_box_hardly_rebounds() {
    let model = sliding_box("elliptic");
    let mut robot = Interpreter::<f64>::new(model.clone());
    let settings = model.step_settings().rigid();
    for phase in 0..7 {
        let q = vec![0.0, 0.0, 0.06 + DT * f64::from(phase) / 7.0, 0.0, 0.0, 0.0, 1.0];
        let mut moving = Moving::new(q, vec![0.0, 0.0, -1.0, 0.0, 0.0, 0.0], 4);
        let [mut rebound, mut depth] = [0.0_f64; 2];
        for _ in 0..100 {
            moving = moving.step(&mut robot, &[0.0; 6], &settings);
            rebound = rebound.max(moving.qd[2]);
            depth = depth.max(0.05 - moving.q[2]);
        }
        assert!(rebound < 0.1 && depth < 1.2 * DT && depth > 0.0, "{phase}: {rebound} {depth}");
    }
}
