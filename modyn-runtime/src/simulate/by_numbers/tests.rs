//! The steps of lanes are those of single states, and derivatives are those of differences.

use alloc::{vec, vec::Vec};
use core::array::from_fn;

use super::{GroundRobot, JointStop, StepChanges, StepGradient, StepLanes};
use crate::simulate::{Ground, Residual};
use crate::{ConstraintSettings, ContactTarget};

const CONTACTS: usize = 2;
const N: usize = 7;
const ROWS: usize = 3 * CONTACTS;
const DT: f64 = 0.002;

/// A sequence of numbers in -1..1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from((self.0 >> 33) as u32) / f64::from(1_u32 << 30) - 1.0
    }
}

fn robot() -> GroundRobot {
    let stop = |k: usize| JointStop { coordinate: k, velocity: k, range: [-1.0, 1.0] };
    GroundRobot { contacts: CONTACTS, velocities: N, stops: vec![stop(1), stop(5)] }
}

/// A state of a robot with a random mass matrix and Jacobian.
struct Case {
    q: Vec<f64>,
    settings: ConstraintSettings<f64, Vec<ContactTarget<f64>>>,
    problem: Vec<f64>,
    inverse: Vec<f64>,
}

impl Case {
    /// Returns a state; with `stopped` a joint is at its stop.
    fn new(seed: u64, stopped: bool) -> Self {
        let mut random = Random(seed);
        let factor: [[f64; N]; N] = from_fn(|_| from_fn(|_| random.next()));
        let entry = |i: usize, j: usize| {
            let unit = if i == j { 0.3 } else { 0.0 };
            (0..N).map(|k| factor[i][k] * factor[j][k]).sum::<f64>() + unit
        };
        let inverse: Vec<f64> = (0..N * N).map(|k| entry(k / N, k % N)).collect();
        let jacobian: [[f64; N]; ROWS] = from_fn(|_| from_fn(|_| random.next()));
        let response: [[f64; N]; ROWS] =
            from_fn(|row| from_fn(|v| (0..N).map(|k| inverse[v * N + k] * jacobian[row][k]).sum()));
        let mobility = (0..ROWS * ROWS)
            .map(|k| (0..N).map(|v| jacobian[k / ROWS][v] * response[k % ROWS][v]).sum::<f64>());
        let qd: [f64; N] = from_fn(|_| 2.0 * random.next());
        let of = |row: usize| (0..N).map(|v| jacobian[row][v] * qd[v]).sum::<f64>();
        let heights = [0.001 * random.next(), 0.001 * random.next()];
        let before: [f64; ROWS] = from_fn(|row| of(row) + 0.1 * random.next());
        let all = qd.iter().chain(&heights).chain(&before).copied();
        let all = all.chain((0..ROWS).map(of)).chain(mobility);
        let contact = |friction, restitution, compliance| ContactTarget {
            friction,
            restitution,
            compliance,
            ..ContactTarget::<f64>::GROUND
        };
        let contacts = vec![contact(0.2, 0.4, 0.0), contact(1.2, 0.0, 0.05)];
        let numbers = ConstraintSettings::<f64, [ContactTarget<f64>; 0]>::DEFAULT.numbers();
        let at = if stopped { 0.9999 } else { 0.0 };
        Self {
            q: (0..N).map(|k| if k == 1 { at } else { 0.1 * random.next() }).collect(),
            settings: ConstraintSettings::from_numbers(numbers, contacts),
            problem: all.chain(response.into_iter().flatten()).collect(),
            inverse,
        }
    }

    /// Returns the velocities after the step, then the impulses, whose residual must be small.
    fn solve(&self, dt: f64) -> [Vec<f64>; 3] {
        let (found, wrong) = self.found(dt);
        assert!(wrong.contacts.max(wrong.stops) < 1e-11, "{wrong:?}");
        found
    }

    /// Returns the velocities after the step, then the impulses; and their residual.
    fn found(&self, dt: f64) -> ([Vec<f64>; 3], Residual) {
        let [mut p, mut s, mut qd] = [ROWS, N, N].map(|count| vec![0.0; count]);
        let ground = Ground { tolerance: 1e-13, ..Ground::default() };
        let (wrong, _) = robot().solve(
            &ground,
            (&self.q, dt, &self.settings),
            (|i| self.problem[i], |w: &mut [f64]| w.copy_from_slice(&self.inverse)),
            (&mut p, &mut s),
            &mut qd,
        );
        ([qd, p, s], wrong)
    }

    fn numbers(&self) -> Vec<f64> {
        let contacts = self.settings.contacts.iter().flat_map(ContactTarget::numbers);
        self.settings.numbers().into_iter().chain(contacts).collect()
    }

    /// Returns this state after a change along a direction.
    fn moved(&self, by: f64, along: &Direction) -> Self {
        let add = |x: &[f64], dx: &[f64]| -> Vec<f64> {
            x.iter().zip(dx).map(|(x, dx)| dx.mul_add(by, *x)).collect()
        };
        let numbers = add(&self.numbers(), &along.settings);
        let (first, contacts) = numbers.split_at(4);
        let contacts = contacts.as_chunks::<25>().0.iter();
        let contacts = contacts.map(|numbers| ContactTarget::from_numbers(*numbers)).collect();
        Self {
            q: add(&self.q, &along.q),
            settings: ConstraintSettings::from_numbers(from_fn(|k| first[k]), contacts),
            problem: add(&self.problem, &along.problem),
            inverse: add(&self.inverse, &along.inverse),
        }
    }
}

/// A change of all that a step depends on.
struct Direction {
    q: Vec<f64>,
    settings: Vec<f64>,
    problem: Vec<f64>,
    inverse: Vec<f64>,
}

fn symmetrize(matrix: &mut [f64], n: usize) {
    for i in 0..n {
        for j in 0..i {
            matrix[i * n + j] = matrix[j * n + i];
        }
    }
}

#[test]
fn steps_in_lanes_are_those_of_single_states() {
    const LANES: usize = 16;
    let cases: Vec<Case> = (0..LANES as u64).map(|k| Case::new(k, k % 5 == 4)).collect();
    let rows = |of: &dyn Fn(&Case) -> Vec<f64>| -> Vec<f64> {
        let all: Vec<Vec<f64>> = cases.iter().map(of).collect();
        (0..all[0].len() * LANES).map(|k| all[k % LANES][k / LANES]).collect()
    };
    let mut p = vec![0.0; ROWS * LANES];
    let mut qd = vec![0.0; N * LANES];
    let mut solved = [None; LANES];
    let numbers = StepLanes {
        lanes: LANES,
        q: &rows(&|case| case.q.clone()),
        dt: &[DT; LANES],
        settings: &rows(&Case::numbers),
        problem: &rows(&|case| case.problem.clone()),
        stops: &[0.0; N * LANES],
    };
    // Sweeps alone: enough of them for two contacts.
    let ground = Ground { sweeps: 300, ..Ground::default() };
    robot().solve_lanes(&ground, &numbers, (&mut p, &mut qd), &mut solved);
    let mut compared = 0;
    for (lane, case) in cases.iter().enumerate() {
        let [velocities, impulses, stops] = case.solve(DT);
        if stops.iter().any(|&s| s != 0.0) {
            assert_eq!(solved[lane], None, "{lane}: a stop acts");
        }
        if solved[lane].is_none() {
            continue;
        }
        compared += 1;
        for (v, x) in velocities.iter().enumerate() {
            assert!((qd[v * LANES + lane] - x).abs() < 1e-7, "{lane}: {x}");
        }
        for (row, x) in impulses.iter().enumerate() {
            assert!((p[row * LANES + lane] - x).abs() < 1e-6, "{lane}: {x}");
        }
    }
    assert!(compared >= LANES / 4, "{compared} of {LANES} were solved by sweeps");
}

#[test]
fn derivatives_are_those_of_differences() {
    let mut acted = 0;
    let mut stopped = 0;
    for seed in 0..40 {
        let case = Case::new(seed, seed % 2 == 0);
        let mut random = Random(seed + 1000);
        let mut numbers = |count: usize, scale: f64| -> Vec<f64> {
            (0..count).map(|_| scale * random.next()).collect()
        };
        let mut along = Direction {
            q: numbers(N, 1e-3),
            settings: numbers(case.numbers().len(), 0.1),
            problem: numbers(case.problem.len(), 1e-3),
            inverse: numbers(N * N, 0.1),
        };
        // Matrices stay symmetric.
        symmetrize(&mut along.inverse, N);
        let mobility = robot().places().mobility;
        symmetrize(&mut along.problem[mobility..][..ROWS * ROWS], ROWS);
        let weights = [N, ROWS, N].map(|count| numbers(count, 1.0));
        let found = case.solve(DT);
        let at = |by: f64| case.moved(by, &along).solve(by.mul_add(1e-4, DT));
        let difference = |step: f64| -> Vec<f64> {
            let ahead = at(step).concat();
            let back = at(-step).concat();
            ahead.iter().zip(back).map(|(a, b)| (a - b) / (2.0 * step)).collect()
        };
        let fine = difference(1e-6);
        let coarse = difference(4e-6);
        // Where two laws meet, there are two derivatives.
        if fine.iter().zip(&coarse).any(|(a, b)| (a - b).abs() > 1e-4 * (1.0 + a.abs())) {
            continue;
        }
        acted += usize::from(found[1].iter().any(|&p| p != 0.0));
        stopped += usize::from(found[2].iter().any(|&s| s != 0.0));
        let set = |w: &mut [f64]| w.copy_from_slice(&case.inverse);
        let before = (&*case.q, DT, &case.settings);
        let problem = |i: usize| case.problem[i];
        let impulses = (&*found[1], &*found[2]);
        // Along one of two directions, nothing changes.
        let rows = |along: &[f64]| along.iter().flat_map(|&x| [0.0, x]).collect::<Vec<_>>();
        let [of_problem, of_inverse, of_q, of_settings] =
            [&along.problem, &along.inverse, &along.q, &along.settings].map(|along| rows(along));
        let changes = StepChanges {
            problem: &of_problem,
            inverse: &of_inverse,
            q: &of_q,
            dt: &[0.0, 1e-4],
            settings: &of_settings,
        };
        let [mut of_velocities, mut of_contacts, mut of_stops] =
            [N, ROWS, N].map(|count| vec![0.0; 2 * count]);
        let results = [&mut *of_velocities, &mut *of_contacts, &mut *of_stops];
        robot().changes(before, (problem, set), impulses, &changes, results);
        let all = [of_velocities, of_contacts, of_stops].concat();
        let [still, all] =
            [0, 1].map(|k| all.iter().skip(k).step_by(2).copied().collect::<Vec<_>>());
        assert!(still.iter().all(|&x| x == 0.0), "{seed}: changes without a change");
        for (k, (x, expected)) in all.iter().zip(&fine).enumerate() {
            assert!(
                (x - expected).abs() < 1e-4 * (1.0 + expected.abs()),
                "{seed} {k}: {x}, {expected}"
            );
        }
        let [mut of_q, mut of_settings, mut of_problem] =
            [N, along.settings.len(), along.problem.len()].map(|count| vec![0.0; count]);
        let mut of_inverse = Vec::new();
        let mut of_dt = 0.0;
        let gradient = StepGradient {
            problem: &mut of_problem,
            inverse: &mut of_inverse,
            q: &mut of_q,
            dt: &mut of_dt,
            settings: &mut of_settings,
        };
        robot().add_gradient(
            before,
            (problem, set),
            impulses,
            weights.each_ref().map(Vec::as_slice),
            gradient,
        );
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let backward = dot(&of_q, &along.q)
            + dot(&of_settings, &along.settings)
            + dot(&of_problem, &along.problem)
            + dot(&of_inverse, &along.inverse)
            + 1e-4 * of_dt;
        let forward = dot(&weights.concat(), &all);
        assert!(
            (backward - forward).abs() < 1e-9 * (1.0 + forward.abs()),
            "{seed}: {backward}, {forward}"
        );
    }
    assert!(acted >= 10 && stopped >= 5, "{acted} with contacts, {stopped} with stops");
}

/// A number that has an effect must not lose it when it is NaN: else a robot falls through the
/// ground, and nothing tells.
#[test]
fn nan_reaches_velocities_and_residual() {
    let changed = |case: &Case, k: usize, by: &dyn Fn(f64) -> f64| -> (Case, f64) {
        let mut along = Direction {
            q: vec![0.0; N],
            settings: vec![0.0; case.numbers().len()],
            problem: vec![0.0; case.problem.len()],
            inverse: vec![0.0; N * N],
        };
        let mut dt = DT;
        let mut first = 0;
        let numbers = case.numbers();
        let parts: [(&[f64], &mut Vec<f64>); 4] = [
            (&case.q, &mut along.q),
            (&numbers, &mut along.settings),
            (&case.problem, &mut along.problem),
            (&case.inverse, &mut along.inverse),
        ];
        for (at, change) in parts {
            if let Some(i) = k.checked_sub(first).filter(|&i| i < at.len()) {
                change[i] = by(at[i]) - at[i];
            }
            first += at.len();
        }
        if k == first {
            dt = by(dt);
        }
        (case.moved(1.0, &along), dt)
    };
    let mut effects = 0;
    for seed in 0..8 {
        let case = Case::new(seed, seed % 2 == 0);
        let count = N + case.numbers().len() + case.problem.len() + N * N;
        let (before, _) = case.found(DT);
        for k in 0..=count {
            let (moved, dt) = changed(&case, k, &|x| x * 1.01 + 1e-3);
            if moved.found(dt).0 == before {
                continue;
            }
            effects += 1;
            let (moved, dt) = changed(&case, k, &|_| f64::NAN);
            let ([velocities, ..], wrong) = moved.found(dt);
            assert!(
                velocities.iter().any(|v| v.is_nan()),
                "{seed}: number {k} is NaN: {velocities:?}"
            );
            // The free motion, the responses and the inverse of the mass matrix act on velocities,
            // and less on the laws.
            let at = robot().places();
            let in_problem = k.checked_sub(N + case.numbers().len());
            let is_of_laws = in_problem.is_none_or(|i| (at.heights..at.responses).contains(&i));
            assert!(
                !is_of_laws || (wrong.contacts + wrong.stops).is_nan(),
                "{seed}: number {k} is NaN, and the residual {wrong:?}"
            );
        }
    }
    assert!(effects > 300, "{effects} numbers had an effect");
}

/// NaN in one state keeps to it: the other lanes are solved as before, and the lane of the state is
/// not solved.
#[test]
fn nan_stays_in_its_lane() {
    const LANES: usize = 8;
    let cases: Vec<Case> = (0..LANES as u64).map(|k| Case::new(k, false)).collect();
    let rows = |of: &dyn Fn(&Case) -> Vec<f64>| -> Vec<f64> {
        let all: Vec<Vec<f64>> = cases.iter().map(of).collect();
        (0..all[0].len() * LANES).map(|k| all[k % LANES][k / LANES]).collect()
    };
    let solve = |settings: &[f64]| {
        let mut p = vec![0.0; ROWS * LANES];
        let mut qd = vec![0.0; N * LANES];
        let mut solved = [None; LANES];
        let numbers = StepLanes {
            lanes: LANES,
            q: &rows(&|case| case.q.clone()),
            dt: &[DT; LANES],
            settings,
            problem: &rows(&|case| case.problem.clone()),
            stops: &[0.0; N * LANES],
        };
        let ground = Ground { sweeps: 300, ..Ground::default() };
        robot().solve_lanes(&ground, &numbers, (&mut p, &mut qd), &mut solved);
        (solved, qd)
    };
    let settings = rows(&Case::numbers);
    let (expected, velocities) = solve(&settings);
    assert!(expected.iter().flatten().count() >= 2, "{expected:?}");
    let lane = expected.iter().position(Option::is_some).expect("a lane that is solved");
    let mut with_nan = settings.clone();
    with_nan[(GroundRobot::first_number_of(1) + super::FRICTION) * LANES + lane] = f64::NAN;
    let (found, others) = solve(&with_nan);
    for other in 0..LANES {
        match other == lane {
            true => assert_eq!(found[other], None),
            false => {
                assert_eq!(found[other], expected[other]);
                for v in 0..N {
                    let k = v * LANES + other;
                    assert_eq!(others[k].to_bits(), velocities[k].to_bits());
                }
            }
        }
    }
}
