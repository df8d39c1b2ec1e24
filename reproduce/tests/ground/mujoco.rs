//! The same motions in MuJoCo: `tests/golden/ground.json`, made by `tools/golden/ground.py`.
//!
//! Only the physics can be compared, not the numbers: MuJoCo's contacts are springs and dampers, whose settings the file
//! states; modyn's are rigid, and its steps are ten to twenty times as long. Both agree with a closed form where there is
//! one: free fall, Coulomb friction, weight. A contact at rest in MuJoCo is less than a tenth of a millimetre in the
//! ground and creeps along it. The motion between impact and rest depends on how a contact loses energy, so there the
//! two differ by some millimetres.

use std::fs;
use std::path::Path;

use modyn::ContactTarget;
use modyn::simulate::{Ground, GroundStep, State};
use modyn::spatial::{Pose, Vector3};
use serde_json::Value;

use crate::legged::{hold_legs, posture};
use crate::{Block, GRAVITY, Quadruped, STANDING, STEP, heights, hold, lowest, on, rotation};

/// A motion in MuJoCo.
struct Motion {
    case: Value,
    /// The time from one position to the next, s.
    sample: f64,
}

impl Motion {
    fn load(case: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden/ground.json");
        let text = fs::read_to_string(path).expect("the reference data");
        let mut data: Value = serde_json::from_str(&text).expect("JSON");
        let sample = data["sample"].as_f64().expect("a number");
        assert_eq!(data["gravity"][2].as_f64(), Some(-GRAVITY));
        Self { case: data[case].take(), sample }
    }

    fn number(&self, path: &str) -> f64 {
        self.case.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"))
    }

    /// Returns the place of the base at each sample, m.
    fn positions(&self) -> Vec<[f64; 3]> {
        let rows = self.case["positions"].as_array().expect("a list");
        let number = |row: &Value, k: usize| row[k].as_f64().expect("a number");
        rows.iter().map(|row| [0, 1, 2].map(|k| number(row, k))).collect()
    }

    /// Returns the force on each contact at the end, N.
    fn forces(&self, contacts: [&str; 4]) -> [[f64; 3]; 4] {
        contacts.map(|name| [0, 1, 2].map(|k| self.number(&format!("/forces/{name}/{k}"))))
    }
}

const CORNERS: [&str; 4] = ["a", "b", "c", "d"];

/// A motion in modyn: its places at the samples of the other motion, and the last step.
struct Run<R: modyn::Robot> {
    positions: Vec<[f64; 3]>,
    last: GroundStep<R>,
}

/// Runs steps of `dt` seconds until the end of the other motion.
fn run<R: modyn::Robot>(
    motion: &Motion,
    dt: f64,
    start: State<R>,
    step: impl Fn(&State<R>) -> GroundStep<R>,
) -> Run<R> {
    let place = |state: &State<R>| [0, 1, 2].map(|k| state.q.as_ref()[k]);
    let mut positions = vec![place(&start)];
    let mut last = step(&start);
    let mut steps = 1;
    while f64::from(steps) * dt < motion.number("/time") - dt / 2.0 {
        if (f64::from(steps) * dt / motion.sample + 1e-9).fract() < 1e-6 {
            positions.push(place(&last.state));
        }
        last = step(&last.state);
        steps += 1;
    }
    positions.push(place(&last.state));
    assert_eq!(positions.len(), motion.positions().len());
    Run { positions, last }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Returns the sum of the vertical forces, N.
fn carried(forces: &[[f64; 3]; 4]) -> f64 {
    forces.iter().map(|force| force[2]).sum()
}

/// The first corner hits the ground at the time and with the speed that both have to agree about. At rest both have the
/// block flat on the ground, and corners carry the weight as statics says: the shares of three of them fix the fourth.
#[test]
fn a_block_falls_as_in_mujoco() {
    let motion = Motion::load("drop");
    let mut q = Block::NEUTRAL;
    q[2] = 0.4;
    q[3..7].copy_from_slice(&rotation([0.3, 1.0, -0.4], 0.6).1);
    let start = State::<Block>::at_rest(q);
    let (settings, ground) = (on(ContactTarget::<f64>::GROUND), Ground::with_friction(0.6));
    let step = |state: &State<Block>| state.step_on_ground(STEP, &hold(state), &ground, &settings);

    let (mut state, mut time) = (start, 0.0);
    let found = loop {
        let next = step(&state);
        if next.forces.iter().any(|force| force[2] > 0.0) {
            let speeds = Block::constraint_residual(&state.q, &state.qd, &settings).velocities;
            let above = heights(&state, &settings);
            let first = (0..4).min_by(|&a, &b| above[a].total_cmp(&above[b])).expect("four");
            break (CORNERS[first], speeds[first].linear[2]);
        }
        (state, time) = (next.state, time + STEP);
    };
    assert_eq!(Some(found.0), motion.case.pointer("/impact/point").and_then(Value::as_str));
    let expected = motion.number("/impact/speed");
    // A step of free fall.
    let exact = 2.0 * GRAVITY * lowest(&start, &settings);
    assert!((expected + exact.sqrt()).abs() < 2e-3, "{expected} m/s");
    assert!((found.1 - expected).abs() < 2.0 * GRAVITY * STEP, "{found:?}, {expected} m/s");
    assert!((time - motion.number("/impact/time")).abs() < 2.0 * STEP, "{time} s");

    let Run { positions, last } = run(&motion, STEP, start, step);
    let mut most = 0.0_f64;
    for (k, (a, b)) in positions.iter().zip(motion.positions()).enumerate() {
        let separation = distance(*a, b);
        // Semi-implicit Euler falls by g t dt / 2 more.
        let falling = (k as f64) * motion.sample < time;
        assert!(!falling || separation < GRAVITY * time * STEP, "{separation} m at sample {k}");
        most = most.max(separation);
    }
    println!("at most {:.1} mm from MuJoCo's motion", 1e3 * most);
    assert!(most < 0.03, "{most} m");
    let (height, expected) = (last.state.q[2], motion.number("/base/2"));
    assert!((height - STANDING).abs() < 1e-4 && (expected - STANDING).abs() < 1e-4);
    let (forces, expected) = (last.forces.map(|force| force.0), motion.forces(CORNERS));
    let weight = motion.number("/mass") * GRAVITY;
    for forces in [&forces, &expected] {
        assert!((carried(forces) - weight).abs() < 1e-3 * weight, "{forces:?}");
        assert!(forces.iter().all(|force| force[2] > 0.0));
    }
    // The moments about both axes of the base.
    for k in 0..2 {
        let corners = [[0.15, 0.1], [-0.15, 0.1], [0.15, -0.1], [-0.15, -0.1]];
        let moment = |forces: &[[f64; 3]; 4]| -> f64 {
            forces.iter().zip(corners).map(|(force, place)| force[2] * place[k]).sum()
        };
        let (found, expected) = (moment(&forces), moment(&expected));
        assert!((found - expected).abs() < 1e-3 * weight * 0.15, "{found} N m, {expected} N m");
    }
    let kept = motion.number("/energy/0") - motion.number("/energy/1");
    let energy = |state: &State<Block>| {
        Block::kinetic_energy(&state.q, &state.qd) + Block::potential_energy(&state.q)
    };
    let lost = energy(&start) - energy(&last.state);
    assert!((lost - kept).abs() < 1e-2 * kept, "{lost} J, {kept} J");
}

/// Sliding stops after Coulomb's distance, in MuJoCo within one per cent.
#[test]
fn a_block_slides_as_in_mujoco() {
    let motion = Motion::load("slide");
    let mut q = Block::NEUTRAL;
    q[2] = STANDING;
    q[3..7].copy_from_slice(&rotation([0.0, 0.0, 1.0], 0.8).1);
    let mut start = State::<Block>::at_rest(q);
    start.qd[..2].copy_from_slice(&[0.9, 1.2]);
    let (settings, ground) = (on(ContactTarget::<f64>::GROUND), Ground::with_friction(0.35));
    let Run { positions, .. } = run(&motion, STEP, start, |state| {
        state.step_on_ground(STEP, &hold(state), &ground, &settings)
    });
    let exact = 1.5 * 1.5 / (2.0 * 0.35 * GRAVITY);
    for (k, (a, b)) in positions.iter().zip(motion.positions()).enumerate() {
        assert!(distance(*a, b) < 0.01 * exact, "{a:?}, {b:?} at sample {k}");
    }
    for end in [positions.last(), motion.positions().last()] {
        let way = end.map(|end| f64::hypot(end[0], end[1])).expect("samples");
        assert!((way - exact).abs() < 0.01 * exact, "{way} m of {exact} m");
    }
}

/// On a slope in general position the block slides down as Coulomb says, or stays; MuJoCo's creeps by less than 10 um.
#[test]
fn a_slope_holds_as_in_mujoco() {
    let (angle, place) = (0.5_f64, [0.3, -0.2, 0.7]);
    let (rows, quaternion) = rotation([0.6, -0.8, 0.0], angle);
    let pose = Pose { rotation: rows, translation: place };
    let settings = on(ContactTarget { pose, ..ContactTarget::<f64>::GROUND });
    let up = Vector3(rows.map(|row| row[2]));
    let mut q = Block::NEUTRAL;
    (0..3).for_each(|k| q[k] = place[k] + STANDING * up[k]);
    q[3..7].copy_from_slice(&quaternion);
    for (case, friction, creep) in [("slope", 0.2, 2e-3), ("slope_held", 0.8, 1e-5)] {
        let motion = Motion::load(case);
        let ground = Ground::with_friction(friction);
        let start = State::<Block>::at_rest(q);
        let Run { positions, .. } = run(&motion, STEP, start, |state| {
            state.step_on_ground(STEP, &hold(state), &ground, &settings)
        });
        let acceleration = (GRAVITY * (angle.sin() - friction * angle.cos())).max(0.0);
        for (k, (a, b)) in positions.iter().zip(motion.positions()).enumerate() {
            let time = (k as f64) * motion.sample;
            let exact = acceleration * time * time / 2.0;
            let [found, expected] = [*a, b].map(|end| distance(end, positions[0]));
            // A first-order step, and the play of the flap.
            let tolerance = creep + acceleration * time * STEP;
            assert!((expected - exact).abs() < tolerance, "{case}: {expected} m of {exact} m");
            assert!((found - exact).abs() < tolerance, "{case}: {found} m of {exact} m");
        }
    }
}

/// Both stand at the same height with the same joint angles; each foot carries the same share of the weight. Forces along
/// the ground depend on how the feet landed: rigid feet stay there, MuJoCo's creep.
#[test]
fn a_quadruped_stands_as_in_mujoco() {
    let motion = Motion::load("stand");
    let posture = posture();
    let (settings, ground) = (on(ContactTarget::<f64>::GROUND), Ground::with_friction(0.8));
    let start = State::<Quadruped>::at_rest(posture);
    let Run { positions, last } = run(&motion, STEP, start, |state| {
        state.step_on_ground(STEP, &hold_legs(state, &posture), &ground, &settings)
    });
    let mut most = 0.0_f64;
    for (a, b) in positions.iter().zip(motion.positions()) {
        most = most.max(distance(*a, b));
    }
    println!("at most {:.1} mm from MuJoCo's motion", 1e3 * most);
    assert!(most < 2e-3, "{most} m");
    assert!((last.state.q[2] - motion.number("/base/2")).abs() < 5e-4, "{:?}", last.state);
    for (i, joint) in Quadruped::JOINT_NAMES[1..].iter().enumerate() {
        let (found, expected) = (last.state.q[7 + i], motion.number(&format!("/joints/{joint}")));
        assert!((found - expected).abs() < 3e-3, "{joint}: {found} rad, {expected} rad");
    }
    let (forces, expected) =
        (last.forces.map(|force| force.0), motion.forces(["fl", "fr", "hl", "hr"]));
    let weight = motion.number("/mass") * GRAVITY;
    for (found, expected) in forces.iter().zip(&expected) {
        assert!((found[2] - expected[2]).abs() < 0.01 * weight, "{forces:?}");
    }
    for forces in [&forces, &expected] {
        assert!((carried(forces) - weight).abs() < 1e-3 * weight, "{forces:?}");
        for k in 0..2 {
            let sum: f64 = forces.iter().map(|force| force[k]).sum();
            assert!(sum.abs() < 1e-3 * weight, "{forces:?}");
        }
    }
}
