//! Advantage (4) of the paper: modules in parallel, and the links inside a module one after the other.
//!
//! A prototype on Table 6: branches on one common first link are eliminated at the same time, then the first link is
//! solved for, then the branches are accelerated at the same time. This takes two forks and two joins a call, the
//! minimum for any hybrid of the recursion.

use std::time::Instant;

use modyn_runtime::spatial::Twist;
use rayon::prelude::*;

use crate::plot::{Axis, Chart, Line};
use crate::report::{Failure, Report, Table, fixed};
use crate::robots;
use crate::table6::{Left, Part, Table6};

/// The way in which branches are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// One after the other.
    Serial,
    /// By rayon's pool of threads.
    Pool,
    /// By two new threads for each phase.
    Threads,
}

/// A first link with equal branches, and the memory for the solution.
pub struct Hand {
    solver: Table6<f64>,
    root: Part<f64>,
    branches: Vec<Part<f64>>,
    left: Vec<Option<Left<f64>>>,
    length: usize,
    q: Vec<f64>,
    phi: Vec<f64>,
    /// The accelerations.
    pub qdd: Vec<f64>,
}

impl Hand {
    /// Returns a robot with this number of branches and of links in each branch.
    #[must_use]
    pub fn new(branches: usize, length: usize) -> Self {
        let model = robots::palm(branches, length);
        let n = model.nv();
        let solver = Table6::new(&model);
        let numbers: Vec<f64> = robots::spread(branches + length).take(2 * n).collect();
        let (q, phi) = numbers.split_at(n);
        let part = |k: usize| solver.part(1 + k * length..1 + (k + 1) * length);
        let (root, branches) = (solver.part(0..1), (0..branches).map(part).collect::<Vec<_>>());
        let left = vec![None; branches.len()];
        let (q, phi, qdd) = (q.to_vec(), phi.to_vec(), vec![0.0; n]);
        Self { solver, root, branches, left, length, q, phi, qdd }
    }

    /// Solves qdd = I^-1 phi.
    pub fn solve(&mut self, mode: Mode) {
        let Self { solver, root, branches, left, length, q, phi, qdd } = self;
        let eliminate = |(part, left): (&mut Part<f64>, &mut Option<Left<f64>>)| {
            *left = solver.eliminate(part, (q, phi), &[]);
        };
        let half = branches.len() / 2;
        match mode {
            Mode::Serial => branches.iter_mut().zip(&mut *left).for_each(eliminate),
            Mode::Pool => branches.par_iter_mut().zip(&mut *left).for_each(eliminate),
            Mode::Threads => {
                let (first, second) = branches.split_at_mut(half);
                let (left, right) = left.split_at_mut(half);
                std::thread::scope(|scope| {
                    scope.spawn(move || first.iter_mut().zip(left).for_each(eliminate));
                    second.iter_mut().zip(right).for_each(eliminate);
                });
            }
        }
        let children: Vec<_> = left.iter().flatten().map(|&left| (0, left)).collect();
        solver.eliminate(root, (q, phi), &children);
        let (first, others) = qdd.split_at_mut(1);
        solver.accelerate(root, None, |_, acceleration| first[0] = acceleration);
        let twist: Twist<f64> = root.twist(0);
        let accelerate = |(part, qdd): (&mut Part<f64>, &mut [f64])| {
            let mut at = 0;
            solver.accelerate(part, Some(twist), |_, acceleration| {
                qdd[at] = acceleration;
                at += 1;
            });
        };
        match mode {
            Mode::Serial => {
                branches.iter_mut().zip(others.chunks_mut(*length)).for_each(accelerate)
            }
            Mode::Pool => {
                branches.par_iter_mut().zip(others.par_chunks_mut(*length)).for_each(accelerate);
            }
            Mode::Threads => {
                let (first, second) = branches.split_at_mut(half);
                let (left, right) = others.split_at_mut(half * *length);
                let length = *length;
                std::thread::scope(|scope| {
                    scope.spawn(move || {
                        first.iter_mut().zip(left.chunks_mut(length)).for_each(accelerate);
                    });
                    second.iter_mut().zip(right.chunks_mut(length)).for_each(accelerate);
                });
            }
        }
    }

    /// Returns the minimal time of several calls, s.
    pub fn seconds(&mut self, mode: Mode) -> f64 {
        let calls = (400_000 / self.q.len()).clamp(20, 3000);
        let mut call = || {
            let start = Instant::now();
            self.solve(mode);
            start.elapsed().as_secs_f64()
        };
        (0..calls).map(|_| call()).fold(f64::INFINITY, f64::min)
    }
}

/// Returns the speed-ups of the pool and of threads, by sizes.
fn speed_ups(sizes: &[(usize, usize)]) -> Vec<(usize, [f64; 3])> {
    let measured = |&(branches, length): &(usize, usize)| {
        let mut hand = Hand::new(branches, length);
        let times = [Mode::Serial, Mode::Pool, Mode::Threads].map(|mode| hand.seconds(mode));
        (1 + branches * length, times)
    };
    sizes.iter().map(measured).collect()
}

/// Writes the section of the page.
///
/// # Errors
///
/// If a plot cannot be written.
pub fn report(report: &mut Report) -> Result<(), Failure> {
    report.heading("Modules in parallel");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    report.text(format!(
        "Table 6 is computed with the branches of a first link on threads, in two phases a call. Times are the least of \
         several calls on a machine with {cores} cores. The numbers are the time of the branches one after the other, \
         divided by their time in parallel: on rayon's pool, and on two threads that each phase starts.",
    ));
    let cases = [
        ("many branches of 4 links", [2, 4, 8, 16, 32, 64, 128, 256, 512, 1024].map(|b| (b, 4))),
        ("4 branches", [2, 4, 8, 16, 32, 64, 128, 256, 1024, 4096].map(|length| (4, length))),
    ];
    let mut lines = Vec::new();
    for (name, sizes) in cases {
        let measured = speed_ups(&sizes);
        let rows = measured.iter().map(|&(n, [serial, pool, threads])| {
            let times = [serial * 1e6, serial / pool, serial / threads];
            [n.to_string()].into_iter().chain(times.map(|x| fixed(x, 2))).collect()
        });
        report.table(Table::new(
            &[name, "one after the other (us)", "pool", "threads"],
            rows.collect(),
        ));
        for (mode, k) in [("pool", 1), ("threads", 2)] {
            let points = measured.iter().map(|(n, times)| (*n as f64, times[0] / times[k]));
            lines.push(Line::new(format!("{name}: {mode}"), points));
        }
    }
    let title = "Branches in parallel: how many times faster";
    let (x, y) = (
        Axis::logarithmic("links"),
        Axis::linear("time one after the other over time in parallel"),
    );
    report.plot("parallel.svg", &Chart { title, x, y, lines })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Hand, Mode};
    use crate::robots;
    use crate::table6::Table6;

    #[test]
    fn branches_in_parallel_give_the_same_numbers() {
        for (branches, length) in [(1, 1), (2, 3), (5, 2), (7, 4)] {
            let mut hand = Hand::new(branches, length);
            let expected =
                Table6::<f64>::new(&robots::palm(branches, length)).solve(&hand.q, &hand.phi);
            for mode in [Mode::Serial, Mode::Pool, Mode::Threads] {
                hand.qdd.fill(0.0);
                hand.solve(mode);
                for (found, expected) in hand.qdd.iter().zip(&expected) {
                    assert!((found - expected).abs() <= 1e-9 * (1.0 + expected.abs()), "{mode:?}");
                }
            }
        }
    }
}
