//! Beyond Tables 4 and 5: rounding in single precision and in Q16.16, by partition.
//!
//! The reference is the same computation without rounding, on the same rounded parameters ([`Exact`]), so the errors
//! are those of the solver alone.

use modyn_runtime::Interpreter;
use modyn_runtime::model::{Model, ModuleTree};

use crate::dense::{gaussian, norm, reverse_gaussian};
use crate::plot::{Axis, Chart, Line};
use crate::report::{Failure, Report, Table, power};
use crate::scalar::{Exact, Fixed, Number};
use crate::stability::scalars;
use crate::{gait, robots};

/// States of a robot: coordinates and velocities.
pub type States = Vec<(Vec<f64>, Vec<f64>)>;

/// A robot of the study.
pub struct Subject {
    /// The name.
    pub name: String,
    /// The robot.
    pub model: Model,
    /// The states at which accelerations are computed.
    pub states: States,
}

/// Returns random postures, up to 1.5 rad a joint, with velocities up to 1 rad/s.
fn anywhere(model: &Model, count: usize) -> States {
    let mut numbers = robots::spread(model.nv());
    let mut vector = |n: usize, size: f64| -> Vec<f64> {
        (0..n).map(|_| size * numbers.next().unwrap_or(0.0)).collect()
    };
    (0..count).map(|_| (vector(model.nq(), 1.5), vector(model.nv(), 1.0))).collect()
}

/// Returns the gripper, the biped on its step, and the 7-joint arm.
#[must_use]
pub fn subjects() -> Vec<Subject> {
    let [gripper, arm7] = [robots::gripper(), robots::arm7()];
    let step = (0..100).map(|k| gait::desired(f64::from(k) / 99.0));
    let states = step.map(|posture| (posture.q.to_vec(), posture.qd.to_vec())).collect();
    vec![
        Subject { name: "gripper".into(), states: anywhere(&gripper, 100), model: gripper },
        Subject { name: "biped".into(), states, model: robots::biped() },
        Subject { name: "arm7".into(), states: anywhere(&arm7, 100), model: arm7 },
    ]
}

/// Returns a chain with this number of links.
#[must_use]
pub fn chain(links: usize) -> Subject {
    let model = robots::chain(links);
    Subject { name: format!("chain of {links}"), states: anywhere(&model, 24), model }
}

/// A solver for the accelerations.
#[derive(Clone, Debug)]
pub enum Solver {
    /// Mass matrix and bias forces, then Gaussian elimination.
    Gaussian,
    /// Mass matrix and bias forces, then Gaussian elimination from the last column on.
    ReverseGaussian,
    /// The recursion by these modules.
    Modules(ModuleTree),
}

/// Returns the relative errors ||qdd - exact|| / ||exact|| on scalar `S` in free fall, state by state.
///
/// # Panics
///
/// If the modules belong to another robot.
#[must_use]
pub fn errors<S: Number>(subject: &Subject, solver: &Solver) -> Vec<f64> {
    let Subject { model, states, .. } = subject;
    let n = model.nv();
    let mut exact = Interpreter::<Exact<S>>::new(model.clone());
    let mut rounded = Interpreter::<S>::new(model.clone());
    if let Solver::Modules(modules) = solver {
        rounded = rounded.eliminating_by(modules).expect("its own modules");
    }
    let accelerations = |(q, qd): &(Vec<f64>, Vec<f64>)| {
        let (p, pd) = (scalars::<Exact<S>>(q), scalars::<Exact<S>>(qd));
        let mut expected = scalars::<Exact<S>>(&vec![0.0; n]);
        exact.forward_dynamics(&p, &pd, &scalars(&vec![0.0; n]), &mut expected).expect("lengths");
        let (q, qd) = (scalars::<S>(q), scalars::<S>(qd));
        let mut qdd = vec![S::zero(); n];
        match solver {
            Solver::Modules(_) => {
                rounded.forward_dynamics(&q, &qd, &vec![S::zero(); n], &mut qdd).expect("lengths");
            }
            Solver::Gaussian | Solver::ReverseGaussian => {
                let mut mass_matrix = vec![S::zero(); n * n];
                rounded.mass_matrix(&q, &mut mass_matrix).expect("lengths");
                rounded.bias_forces(&q, &qd, &mut qdd).expect("lengths");
                let phi: Vec<S> = qdd.iter().map(|&x| -x).collect();
                let forwards = matches!(solver, Solver::Gaussian);
                qdd = if forwards {
                    gaussian(&mass_matrix, &phi)
                } else {
                    reverse_gaussian(&mass_matrix, &phi)
                };
            }
        }
        let expected: Vec<f64> = expected.iter().map(|x| x.to_f64()).collect();
        let difference: Vec<f64> = qdd.iter().zip(&expected).map(|(x, y)| x.to_f64() - y).collect();
        norm(&difference) / norm(&expected)
    };
    states.iter().map(accelerations).collect()
}

/// Returns the median of the errors.
#[must_use]
pub fn median(mut errors: Vec<f64>) -> f64 {
    errors.sort_by(f64::total_cmp);
    errors.get(errors.len() / 2).copied().unwrap_or(0.0)
}

/// Returns the robot in a unit of mass in which the largest entry of its mass matrix is about 64, for Q16.16. In
/// kilograms the gripper's inertias would be a few units of the last place.
#[must_use]
pub fn for_fixed_point(subject: Subject) -> Subject {
    with_largest(subject, 64.0)
}

/// Returns the robot in a unit of mass, a power of two in kilograms, in which the largest entry of its mass matrix is
/// about `size`.
#[must_use]
pub fn with_largest(subject: Subject, size: f64) -> Subject {
    let mut interpreter = Interpreter::<f64>::new(subject.model.clone());
    let n = subject.model.nv();
    let mut mass_matrix = vec![0.0; n * n];
    let mut largest: f64 = 0.0;
    for (q, _) in &subject.states {
        interpreter.mass_matrix(q, &mut mass_matrix).expect("lengths");
        largest = mass_matrix.iter().fold(largest, |largest, x| largest.max(x.abs()));
    }
    let unit = (size / largest).log2().round().exp2();
    Subject { model: robots::in_mass_unit(&subject.model, unit), ..subject }
}

/// Returns the solvers of the tables.
fn solvers(model: &Model) -> Vec<(String, Solver)> {
    let by = |name: &str, modules| (name.to_owned(), Solver::Modules(modules));
    let mut solvers = vec![
        ("GE on the mass matrix".to_owned(), Solver::Gaussian),
        ("RGE on the mass matrix".to_owned(), Solver::ReverseGaussian),
        by("BRGE by links", ModuleTree::links(model)),
        by("BRGE by pairs", robots::pieces(model, 2)),
        by("BRGE by whole chains", ModuleTree::chains(model)),
    ];
    match model.name() {
        "biped" => solvers.push(by("BRGE by the paper's modules", robots::biped_modules(model))),
        "gripper" => solvers.push(by("BRGE by the paper's modules", ModuleTree::chains(model))),
        _ => {}
    }
    solvers
}

/// Returns the median errors by the length of a chain, a line for each solver.
#[must_use]
pub fn against_length<S: Number>(lengths: &[usize], adjust: fn(Subject) -> Subject) -> Vec<Line> {
    let subjects: Vec<Subject> = lengths.iter().map(|&n| adjust(chain(n))).collect();
    (0..5)
        .map(|k| {
            let point = |subject: &Subject| {
                let solver = &solvers(&subject.model)[k].1;
                (subject.model.nv() as f64, median(errors::<S>(subject, solver)))
            };
            Line::new(solvers(&subjects[0].model)[k].0.clone(), subjects.iter().map(point))
        })
        .collect()
}

/// Returns the median errors by the length of the modules of a chain.
#[must_use]
pub fn against_pieces<S: Number>(subject: &Subject) -> Line {
    let longest = subject.model.moving_links().len();
    let points = (1..=longest).map(|length| {
        let solver = Solver::Modules(robots::pieces(&subject.model, length));
        (length as f64, median(errors::<S>(subject, &solver)))
    });
    Line::new(subject.name.clone(), points)
}

/// Returns all partitions of a serial chain into modules, by their lengths, with the median error on scalar `S`; the
/// most accurate first.
///
/// # Panics
///
/// If the robot branches.
#[must_use]
pub fn by_cuts<S: Number>(subject: &Subject) -> Vec<(Vec<usize>, f64)> {
    let links: Vec<&str> =
        subject.model.moving_links().iter().map(|link| link.name.as_str()).collect();
    let mut cuts: Vec<(Vec<usize>, f64)> = (0..1_usize << (links.len() - 1))
        .map(|cut| {
            // Bit k: whether a module ends after link k.
            let mut modules = vec![vec![links[0]]];
            for (k, link) in links.iter().enumerate().skip(1) {
                if cut >> (k - 1) & 1 == 1 {
                    modules.push(Vec::new());
                }
                modules.last_mut().expect("one at least").push(link);
            }
            let lengths = modules.iter().map(Vec::len).collect();
            let modules = ModuleTree::from_names(&subject.model, &modules).expect("one chain");
            (lengths, median(errors::<S>(subject, &Solver::Modules(modules))))
        })
        .collect();
    cuts.sort_by(|a, b| a.1.total_cmp(&b.1));
    cuts
}

/// Returns the median errors in Q16.16 by the unit of mass, which is given by the largest entry of the mass matrix.
#[must_use]
pub fn against_unit(subject: fn() -> Subject) -> Vec<Line> {
    let names = solvers(&subject().model);
    let point = |k: usize, size: i32| {
        let subject = with_largest(subject(), 2f64.powi(size));
        let solver = &solvers(&subject.model)[k].1;
        (2f64.powi(size), median(errors::<Fixed>(&subject, solver)))
    };
    let line = |k: usize| Line::new(names[k].0.clone(), (-2..=12).map(|size| point(k, size)));
    (0..names.len()).map(line).collect()
}

/// Returns the median errors of the solvers, a column for each robot.
fn medians<S: Number>(adjust: fn(Subject) -> Subject) -> Table {
    let subjects: Vec<Subject> = subjects().into_iter().map(adjust).collect();
    let mut head = vec!["solver".to_owned()];
    head.extend(subjects.iter().map(|subject| subject.name.clone()));
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (k, subject) in subjects.iter().enumerate() {
        for (name, solver) in solvers(&subject.model) {
            if !rows.iter().any(|row| row[0] == name) {
                let mut row = vec![String::new(); head.len()];
                row[0].clone_from(&name);
                rows.push(row);
            }
            let row = rows.iter_mut().find(|row| row[0] == name).expect("its row");
            row[1 + k] = power(median(errors::<S>(subject, &solver)));
        }
    }
    Table::new(&head, rows)
}

/// Returns the median errors in single precision and in Q16.16.
#[must_use]
pub fn tables() -> [Table; 2] {
    [medians::<f32>(|subject| subject), medians::<Fixed>(for_fixed_point)]
}

/// Writes the section of the page.
///
/// # Errors
///
/// If a plot cannot be written.
pub fn report(report: &mut Report) -> Result<(), Failure> {
    report.heading("Beyond Tables 4 and 5: single precision and Q16.16");
    report.text(
        "Median of ||qdd - exact|| / ||exact|| over postures, falling freely; exact is the same computation in \
         double-double on the same rounded numbers.",
    );
    let [single, fixed] = tables();
    report.text("In single precision:");
    report.table(single);
    report.text(
        "In Q16.16, with mass in a unit that makes the mass matrix's largest entry about 64:",
    );
    report.table(fixed);
    report.text(
        "Every partition of the robots that are one chain, in single precision: the best and the worst, by the lengths of \
         their modules from the base on, and how many partitions are better than by links.",
    );
    let rows = subjects().into_iter().skip(1).map(|subject| {
        let cuts = by_cuts::<f32>(&subject);
        let shown = |(lengths, error): &(Vec<usize>, f64)| {
            let lengths: Vec<String> = lengths.iter().map(usize::to_string).collect();
            format!("{}: {}", lengths.join(" "), power(*error))
        };
        let by_links =
            cuts.iter().position(|(lengths, _)| lengths.iter().all(|&length| length == 1));
        let better = by_links.unwrap_or(0);
        let (best, worst) = (shown(&cuts[0]), shown(&cuts[cuts.len() - 1]));
        vec![subject.name, best, shown(&cuts[better]), worst, format!("{better} of {}", cuts.len())]
    });
    let head = ["robot", "best", "by links", "worst", "better than by links"];
    report.table(Table::new(&head, rows.collect()));
    let chart = |title, x, lines| Chart {
        title,
        x,
        y: Axis::logarithmic("median relative error of qdd"),
        lines,
    };
    let links = Axis::logarithmic("links of the chain");
    let lines = against_length::<f32>(&[2, 4, 8, 16, 32, 64], |subject| subject);
    report.plot(
        "stability-f32.svg",
        &chart("Single precision: error against the length of a chain", links, lines),
    )?;
    let lines = against_length::<Fixed>(&[2, 4, 8, 12, 16], for_fixed_point);
    report.plot(
        "stability-fixed.svg",
        &chart("Q16.16: error against the length of a chain", links, lines),
    )?;
    let unit = Axis::logarithmic("largest entry of the mass matrix in the unit of mass chosen");
    let lines = against_unit(|| subjects().remove(2));
    report.plot(
        "stability-unit.svg",
        &chart("Q16.16: error of the 7-joint arm by unit of mass", unit, lines),
    )?;
    let pieces = Axis::linear("links a module, at most");
    let mut lines: Vec<Line> = subjects().iter().map(against_pieces::<f32>).collect();
    lines.push(against_pieces::<f32>(&chain(16)));
    report.plot(
        "stability-pieces.svg",
        &chart("Single precision: error by partition", pieces, lines),
    )?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use modyn_runtime::model::ModuleTree;

    use super::{Solver, chain, errors, for_fixed_point, median, subjects};
    use crate::scalar::Fixed;

    #[test]
    fn single_precision_loses_no_more_than_it_must() {
        for subject in subjects() {
            let solver = Solver::Modules(ModuleTree::links(&subject.model));
            let error = median(errors::<f32>(&subject, &solver));
            assert!(error > 1e-9 && error < 2e-5, "{}: {error}", subject.name);
            assert!(median(errors::<f64>(&subject, &solver)) < 1e-13);
        }
    }

    #[test]
    fn the_recursion_beats_the_matrix_on_long_chains() {
        let subject = chain(32);
        let links = Solver::Modules(ModuleTree::links(&subject.model));
        let [links, gaussian] =
            [links, Solver::Gaussian].map(|solver| median(errors::<f32>(&subject, &solver)));
        assert!(10.0 * links < gaussian, "{links}, {gaussian}");
    }

    #[test]
    fn fixed_point_carries_the_gripper_in_a_fitting_unit() {
        let subject = for_fixed_point(subjects().remove(0));
        let solver = Solver::Modules(ModuleTree::links(&subject.model));
        let error = median(errors::<Fixed>(&subject, &solver));
        assert!(error < 1e-2, "{error}");
    }
}
