//! The same motions in MuJoCo: `tests/golden/ground.json`, made by `lab/golden/ground.py`.
//!
//! MuJoCo's contacts are springs and dampers, whose settings the file states; modyn's are rigid with steps of 1 ms, or
//! compliant with MuJoCo's steps ([`Law`]). Both agree with a closed form where there is one: free fall, Coulomb friction, weight. A contact at rest in
//! MuJoCo is less than a tenth of a millimetre in the ground and creeps along it. The motion between impact and rest depends on how a
//! contact loses energy: there rigid contacts differ by some millimetres.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use modyn::simulate::{Ground, GroundStep, State};
use modyn::spatial::{Pose, Vector3};
use modyn::{Array, ContactTarget, Robot, functions};
use serde_json::Value;

use super::legged::{Humanoid, TROT, Upright, hold_legs, posture};
use super::{
    Block, GRAVITY, Quadruped, STANDING, STEP, Settings, heights, hold, lowest, on, rotation,
};

/// A motion in MuJoCo.
struct Motion {
    case: Value,
    /// The time from one position to the next, s.
    sample: f64,
}

impl Motion {
    fn load(case: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/ground.json");
        let text = fs::read_to_string(path).expect("the reference data");
        let mut data: Value = serde_json::from_str(&text).expect("JSON");
        let sample = data["sample"].as_f64().expect("a number");
        assert_eq!(data["gravity"][2].as_f64(), Some(-GRAVITY));
        Self { case: data[case].take(), sample }
    }

    fn number(&self, path: &str) -> f64 {
        self.case.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"))
    }

    /// Returns the energy that the ground took, J.
    fn lost(&self) -> f64 {
        self.number("/energy/0") + self.number("/work") - self.number("/energy/1")
    }

    /// Returns the place of the base at each sample, m.
    fn positions(&self) -> Vec<[f64; 3]> {
        let rows = self.case["positions"].as_array().expect("a list");
        let number = |row: &Value, k: usize| row[k].as_f64().expect("a number");
        rows.iter().map(|row| [0, 1, 2].map(|k| number(row, k))).collect()
    }

    /// Returns the force on each contact at the end, N.
    fn forces<const CONTACTS: usize>(&self, contacts: [&str; CONTACTS]) -> [[f64; 3]; CONTACTS] {
        contacts.map(|name| [0, 1, 2].map(|k| self.number(&format!("/forces/{name}/{k}"))))
    }
}

const CORNERS: [&str; 4] = ["a", "b", "c", "d"];

/// A motion of MuJoCo's, and the law of the contacts in modyn.
type Case<'a> = (&'a Motion, Law);

/// A motion in modyn.
struct Run<R: Robot> {
    /// The places of the base at the samples of the other motion, m.
    positions: Vec<[f64; 3]>,
    last: GroundStep<R>,
    /// The height of the lowest contact of all states, m.
    deepest: f64,
    /// The work of the motors, J.
    work: f64,
    /// The energy that the ground took, J.
    lost: f64,
}

/// The law of contacts along their normals.
#[derive(Clone, Copy)]
enum Law {
    Rigid,
    /// MuJoCo's, with its `solref` and the impedance at which its contacts carry the robots.
    Compliant,
}

use Law::{Compliant, Rigid};

impl Law {
    /// Returns the time step, s.
    fn step(self) -> f64 {
        match self {
            Rigid => STEP,
            Compliant => 1e-4,
        }
    }

    /// Returns the settings with this law. The mobility of a contact is the mean of those in three directions.
    fn of<R, const CONTACTS: usize>(
        self,
        settings: &Settings<CONTACTS>,
        start: &State<R>,
    ) -> Settings<CONTACTS>
    where
        R: Robot<PerContact<ContactTarget<f64>> = [ContactTarget<f64>; CONTACTS]>
            + functions::ContactProblem,
    {
        let mut settings = *settings;
        if let Compliant = self {
            let tau = R::V::<f64>::from_fn(|_| 0.0);
            let problem = R::contact_problem(&start.q, &start.qd, &tau, STEP, &settings);
            for (c, target) in settings.contacts.iter_mut().enumerate() {
                let own =
                    (3 * c..3 * c + 3).map(|row| problem.mobility.as_ref()[row].as_ref()[row]);
                *target = target.compliant([0.004, 1.0], 0.99, own.sum::<f64>() / 3.0);
            }
        }
        settings
    }
}

/// Runs steps until the end of the other motion.
fn run<R, const CONTACTS: usize>(
    (motion, law): Case<'_>,
    start: State<R>,
    settings: &Settings<CONTACTS>,
    torques: impl Fn(&State<R>, f64) -> R::V<f64>,
) -> Run<R>
where
    R: Robot<PerContact<ContactTarget<f64>> = [ContactTarget<f64>; CONTACTS]>
        + functions::ForwardDynamics
        + functions::Brge
        + functions::Integrate
        + functions::ContactProblem
        + functions::ConstraintResidual
        + functions::KineticEnergy
        + functions::PotentialEnergy,
{
    let (settings, dt) = (&law.of(settings, &start), law.step());
    let place = |state: &State<R>| [0, 1, 2].map(|k| state.q.as_ref()[k]);
    let energy =
        |state: &State<R>| R::kinetic_energy(&state.q, &state.qd) + R::potential_energy(&state.q);
    let ground = Ground::default();
    let (mut positions, mut deepest, mut work) = (vec![place(&start)], 0.0_f64, 0.0);
    let [steps, every] = [motion.number("/time"), motion.sample].map(|time| (time / dt).round());
    let (mut state, mut step) = (start, 0.0);
    let last = loop {
        let tau = torques(&state, step * dt);
        let next = state.step_on_ground(dt, &tau, &ground, settings);
        let power = |state: &State<R>| -> f64 {
            tau.as_ref().iter().zip(state.qd.as_ref()).map(|(tau, qd)| tau * qd).sum()
        };
        work += dt * (power(&state) + power(&next.state)) / 2.0;
        state = next.state;
        deepest = deepest.min(lowest(&state, settings));
        step += 1.0;
        if step % every == 0.0 {
            positions.push(place(&state));
        }
        if step >= steps {
            break next;
        }
    };
    assert_eq!(positions.len(), motion.positions().len());
    Run { positions, last, deepest, work, lost: energy(&start) + work - energy(&state) }
}

impl<R: Robot> Run<R> {
    /// Returns the largest distance between the bases of both motions at a sample, m.
    fn apart(&self, motion: &Motion) -> f64 {
        let pairs = self.positions.iter().zip(motion.positions());
        pairs.map(|(a, b)| distance(*a, b)).fold(0.0, f64::max)
    }

    /// Returns the row of `docs/data/ground.tsv`, in J and mm.
    fn row(&self, motion: &Motion) -> [f64; 7] {
        let [deepest, other] = [self.deepest, motion.number("/deepest")].map(|m| -1e3 * m);
        let apart = 1e3 * self.apart(motion);
        [self.work, motion.number("/work"), self.lost, motion.lost(), deepest, other, apart]
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Returns the sum of the vertical forces, N.
fn carried(forces: &[[f64; 3]]) -> f64 {
    forces.iter().map(|force| force[2]).sum()
}

/// Returns the settings of level ground with this friction.
fn rubbing(friction: f64) -> Settings {
    on(ContactTarget { friction, ..ContactTarget::<f64>::GROUND })
}

/// A block that falls on a corner.
fn falls(case: Case<'_>) -> Run<Block> {
    run(case, falling(), &rubbing(0.6), |state, _| hold(state))
}

fn falling() -> State<Block> {
    let mut q = Block::NEUTRAL;
    q[2] = 0.4;
    q[3..7].copy_from_slice(&rotation([0.3, 1.0, -0.4], 0.6).1);
    State::at_rest(q)
}

/// A block that slides and stops.
fn slides(case: Case<'_>) -> Run<Block> {
    let mut q = Block::NEUTRAL;
    q[2] = STANDING;
    q[3..7].copy_from_slice(&rotation([0.0, 0.0, 1.0], 0.8).1);
    let mut start = State::<Block>::at_rest(q);
    start.qd[..2].copy_from_slice(&[0.9, 1.2]);
    run(case, start, &rubbing(0.35), |state, _| hold(state))
}

/// The angle of the slope, rad.
const SLOPE: f64 = 0.5;

/// A block on a slope in general position.
fn on_a_slope(case: Case<'_>, friction: f64) -> Run<Block> {
    let translation = [0.3, -0.2, 0.7];
    let (rows, quaternion) = rotation([0.6, -0.8, 0.0], SLOPE);
    let pose = Pose { rotation: rows, translation };
    let settings = on(ContactTarget { pose, friction, ..ContactTarget::<f64>::GROUND });
    let up = Vector3(rows.map(|row| row[2]));
    let mut q = Block::NEUTRAL;
    (0..3).for_each(|k| q[k] = translation[k] + STANDING * up[k]);
    q[3..7].copy_from_slice(&quaternion);
    run(case, State::at_rest(q), &settings, |state, _| hold(state))
}

/// A quadruped that falls from 2 cm and stands.
fn stands(case: Case<'_>) -> Run<Quadruped> {
    let posture = posture();
    let settings = on(ContactTarget::<f64>::GROUND);
    run(case, State::at_rest(posture), &settings, |state, _| hold_legs(state, &posture))
}

/// A quadruped that trots.
fn trots(case: Case<'_>) -> Run<Quadruped> {
    let settings = on(ContactTarget::<f64>::GROUND);
    run(case, TROT.start(), &settings, |state, time| TROT.torques(state, time))
}

/// A humanoid that stands on its soles after a push.
fn stands_on_soles(case: Case<'_>) -> Run<Humanoid> {
    let (upright, settings) = (Upright::new(), on(ContactTarget::<f64>::GROUND));
    run(case, upright.start(), &settings, |state, _| upright.torques(state))
}

/// The first corner hits the ground at the time and with the speed that both have to agree about. At rest both have the
/// block flat on the ground, and corners carry the weight as statics says: the shares of three of them fix the fourth.
#[test]
fn a_block_falls_as_in_mujoco() {
    let motion = Motion::load("drop");
    let start = falling();
    let (settings, ground) = (rubbing(0.6), Ground::default());
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

    let run = falls((&motion, Rigid));
    for (k, (a, b)) in run.positions.iter().zip(motion.positions()).enumerate() {
        let separation = distance(*a, b);
        // Semi-implicit Euler falls by g t dt / 2 more.
        let falling = (k as f64) * motion.sample < time;
        assert!(!falling || separation < GRAVITY * time * STEP, "{separation} m at sample {k}");
    }
    assert!(run.apart(&motion) < 0.03, "{} m", run.apart(&motion));
    let last = run.last;
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
    let expected = motion.lost();
    assert!((run.lost - expected).abs() < 1e-2 * expected, "{} J, {expected} J", run.lost);
}

/// Sliding stops after Coulomb's distance, in MuJoCo within one per cent.
#[test]
fn a_block_slides_as_in_mujoco() {
    let motion = Motion::load("slide");
    let Run { positions, .. } = slides((&motion, Rigid));
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
    for (case, friction, creep) in [("slope", 0.2, 2e-3), ("slope_held", 0.8, 1e-5)] {
        let motion = Motion::load(case);
        let Run { positions, .. } = on_a_slope((&motion, Rigid), friction);
        let acceleration = (GRAVITY * (SLOPE.sin() - friction * SLOPE.cos())).max(0.0);
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
    let run = stands((&motion, Rigid));
    assert!(run.apart(&motion) < 2e-3, "{} m", run.apart(&motion));
    let last = run.last;
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

/// Both trot with the same controller: the bases are within a twentieth of the way, at the same height. In both the motors
/// give and the ground takes. Rigid impacts without rebound take more than those on MuJoCo's springs; the energy that stays is
/// the same.
#[test]
fn a_quadruped_trots_as_in_mujoco() {
    let motion = Motion::load("trot");
    let run = trots((&motion, Rigid));
    let way = distance(run.positions[0], *run.positions.last().expect("samples"));
    assert!(run.apart(&motion) < 0.05 * way, "{} m of {way} m", run.apart(&motion));
    for (found, expected) in run.positions.iter().zip(motion.positions()) {
        assert!((found[2] - expected[2]).abs() < 5e-3, "{found:?}, {expected:?}");
    }
    let [work, expected] = [run.work, motion.number("/work")];
    assert!(expected > 0.0 && work > expected && work < 3.0 * expected, "{work} J, {expected} J");
    let stayed = [work - run.lost, expected - motion.lost()];
    assert!((stayed[0] - stayed[1]).abs() < 0.05, "{stayed:?} J");
    assert!(run.lost > 0.0 && motion.lost() > 0.0);
}

/// With MuJoCo's law of contacts the motors of a trot give what they give there, and the bases are closer.
#[test]
#[ignore = "slow: 30,000 steps"]
fn a_quadruped_trots_on_compliant_ground_as_in_mujoco() {
    let motion = Motion::load("trot");
    let run = trots((&motion, Compliant));
    let [work, expected] = [run.work, motion.number("/work")];
    assert!((work - expected).abs() < 0.05, "{work} J, {expected} J");
    assert!((run.lost - motion.lost()).abs() < 0.05, "{} J, {} J", run.lost, motion.lost());
    assert!(run.apart(&motion) < 0.01, "{} m", run.apart(&motion));
}

/// After the same push both stand in the same place, and each sole carries the same share of the weight.
#[test]
fn a_humanoid_stands_as_in_mujoco() {
    let motion = Motion::load("stand_on_soles");
    let run = stands_on_soles((&motion, Rigid));
    assert!(run.apart(&motion) < 5e-3, "{} m", run.apart(&motion));
    let forces = run.last.forces.map(|force| force.0);
    let expected: [[f64; 3]; 8] = motion.forces(Humanoid::CONTACT_NAMES);
    let weight = motion.number("/mass") * GRAVITY;
    for sole in [0..4, 4..8] {
        let [found, expected] = [&forces, &expected].map(|forces| carried(&forces[sole.clone()]));
        assert!((found - expected).abs() < 0.02 * weight, "{found} N, {expected} N");
    }
}

/// The numbers of a row of the table, for a motion in MuJoCo.
type Row<'a> = dyn Fn(Case<'_>) -> [f64; 7] + 'a;

/// Returns the names and the numbers of the rows of `docs/data/ground.tsv` with this law.
fn rows(law: Law) -> [([&'static str; 2], [f64; 7]); 6] {
    let cases: [(&str, &str, &Row<'_>); 6] = [
        ("a block falls on a corner", "drop", &|case| falls(case).row(case.0)),
        ("a block slides and stops", "slide", &|case| slides(case).row(case.0)),
        ("a block slides down a slope", "slope", &|case| on_a_slope(case, 0.2).row(case.0)),
        ("a quadruped falls and stands", "stand", &|case| stands(case).row(case.0)),
        ("a quadruped trots", "trot", &|case| trots(case).row(case.0)),
        ("a humanoid stands after a push", "stand_on_soles", &|case| {
            stands_on_soles(case).row(case.0)
        }),
    ];
    let law_in_words = match law {
        Rigid => "rigid, 1 ms",
        Compliant => "compliant, 0.1 ms",
    };
    cases.map(|(name, case, row)| ([name, law_in_words], row((&Motion::load(case), law))))
}

fn table() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/data/ground.tsv")
}

/// Compares the table of the guide with the rows, within the rounding of its numbers.
fn compare(rows: &[([&str; 2], [f64; 7])]) {
    let text = fs::read_to_string(table()).expect("the table");
    for (name, row) in rows {
        let mut lines = text.lines().map(|line| line.split('\t').collect::<Vec<_>>());
        let line = lines.find(|line| line.starts_with(name)).expect("a row");
        assert_eq!(line.len(), 2 + row.len());
        for (cell, number) in line[2..].iter().zip(row) {
            let written: f64 = cell.parse().expect("a number");
            assert!((written - number).abs() < 0.02 + 0.01 * number.abs(), "{name:?}: {number}");
        }
    }
}

#[test]
fn the_guide_has_these_energies_and_depths() {
    compare(&rows(Rigid));
}

/// With the variable `UPDATE_SNAPSHOTS` the file is written.
#[test]
#[ignore = "slow: 200,000 steps"]
fn the_guide_has_all_energies_and_depths() {
    let [rigid, compliant] = [Rigid, Compliant].map(rows);
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        let mut text = String::from(
            "# command: UPDATE_SNAPSHOTS=1 cargo test --manifest-path lab/Cargo.toml -- --ignored the_guide\n\
             motion\tcontacts\twork of the motors, modyn\tMuJoCo\ttaken by the ground, modyn\tMuJoCo\t\
             depth, modyn\tMuJoCo\tapart\n",
        );
        for ([name, law], row) in rigid.iter().zip(&compliant).flat_map(|(a, b)| [a, b]) {
            let cells = row.map(|number| format!("{number:.2}").replace("-0.00", "0.00"));
            writeln!(text, "{name}\t{law}\t{}", cells.join("\t")).expect("text");
        }
        fs::write(table(), text).expect("writes");
    }
    compare(&[rigid, compliant].concat());
}
