//! Monitoring by module (Sect. 2): condition numbers of the modules' pivot blocks along a motion, compared with that of
//! the mass matrix.

use modyn_runtime::Interpreter;
use modyn_runtime::model::{Model, ModuleTree};

use crate::motion::instants;
use crate::plot::{Axis, Chart, Line};
use crate::report::{Failure, Report, Table, fixed};
use crate::{dense, gait, robots};

/// The condition numbers at a posture: of the mass matrix, and of each module's pivot block I_hat.
#[derive(Clone, Debug)]
pub struct Conditions {
    /// The condition number of the mass matrix.
    pub mass_matrix: f64,
    /// The condition numbers of the pivot blocks.
    pub modules: Vec<f64>,
}

/// Returns the condition numbers along a motion.
///
/// # Panics
///
/// If a posture or the modules belong to another robot.
#[must_use]
pub fn along(model: &Model, modules: &ModuleTree, motion: &[Vec<f64>]) -> Vec<Conditions> {
    let n = model.nv();
    let mut interpreter =
        Interpreter::<f64>::with_modules(model.clone(), modules.clone()).expect("its own modules");
    let at = |q: &Vec<f64>| {
        let mut mass_matrix = vec![0.0; n * n];
        interpreter.mass_matrix(q, &mut mass_matrix).expect("lengths");
        let brge = interpreter.brge(q).expect("lengths");
        let modules =
            (0..modules.modules().len()).filter_map(|m| brge.condition_number(m)).collect();
        Conditions { mass_matrix: dense::condition_number(&mass_matrix), modules }
    };
    motion.iter().map(at).collect()
}

/// Returns postures of the arm whose elbow moves through its straight posture, where the hand's Jacobian is singular.
#[must_use]
pub fn stretching_arm(times: &[f64]) -> Vec<Vec<f64>> {
    let posture = |&t: &f64| vec![0.3, 0.5, -0.4, -1.5 + 3.0 * t, 0.4, 0.6 - 1.2 * t, 0.2];
    times.iter().map(posture).collect()
}

/// Writes the section of the page.
///
/// # Errors
///
/// If a plot cannot be written.
pub fn report(report: &mut Report) -> Result<(), Failure> {
    report.heading("Monitoring by module");
    report.text(
        "The plots have the condition numbers (2-norm) of the modules' pivot blocks and of the whole mass matrix along a \
         motion. One robot is the biped on its step, by the paper's modules. The other is a 7-joint arm in modules of \
         three and four links. Its elbow is straight at half time, where the hand loses a direction. The mass matrix is \
         positive definite in a kinematic singularity, too; its condition number shows bad scaling.",
    );
    let times = instants(1.0, 101);
    let step: Vec<Vec<f64>> = times.iter().map(|&t| gait::desired(t).q.to_vec()).collect();
    let (biped, arm) = (robots::biped(), robots::arm7());
    let name = |i: usize| arm.moving_links()[i].name.as_str();
    let halves: Vec<Vec<&str>> = [0..3, 3..7].into_iter().map(|r| r.map(name).collect()).collect();
    let halves = ModuleTree::from_names(&arm, &halves).expect("links of the arm");
    let cases = [
        (
            "biped",
            ["supporting leg, trunk", "swing leg"],
            &biped,
            robots::biped_modules(&biped),
            step,
        ),
        ("arm", ["links 1 to 3", "links 4 to 7"], &arm, halves, stretching_arm(&times)),
    ];
    for (name, parts, model, modules, motion) in cases {
        let conditions = along(model, &modules, &motion);
        let over = |f: &dyn Fn(&Conditions) -> f64| -> Vec<(f64, f64)> {
            times.iter().copied().zip(conditions.iter().map(f)).collect()
        };
        let mut lines = vec![Line::new("whole mass matrix", over(&|c| c.mass_matrix))];
        lines.extend(parts.iter().enumerate().map(|(m, part)| {
            Line::new(format!("module {}: {part}", m + 1), over(&|c| c.modules[m]))
        }));
        let title = format!("Condition numbers by module: {name}");
        let chart = Chart {
            title: &title,
            x: Axis::linear("time (s)"),
            y: Axis::logarithmic("condition number"),
            lines,
        };
        report.plot(&format!("conditioning-{name}.svg"), &chart)?;
        let range = |f: &dyn Fn(&Conditions) -> f64| {
            let all = || conditions.iter().map(f);
            let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
            format!("{} to {}", fixed(low, 1), fixed(high, 1))
        };
        let mut row = vec![name.to_owned(), range(&|c| c.mass_matrix)];
        row.extend((0..parts.len()).map(|m| range(&|c| c.modules[m])));
        report
            .table(Table::new(&["motion", "whole mass matrix", "module 1", "module 2"], vec![row]));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use modyn_runtime::model::ModuleTree;

    use super::{along, stretching_arm};
    use crate::motion::instants;
    use crate::{gait, robots};

    #[test]
    fn pivot_blocks_are_better_conditioned_than_the_whole() {
        let biped = robots::biped();
        let motion: Vec<Vec<f64>> =
            instants(1.0, 21).iter().map(|&t| gait::desired(t).q.to_vec()).collect();
        // Schur complements and diagonal blocks of a positive definite matrix have at most its condition number.
        for conditions in along(&biped, &robots::biped_modules(&biped), &motion) {
            assert_eq!(conditions.modules.len(), 2);
            assert!(
                conditions
                    .modules
                    .iter()
                    .all(|&c| c > 1.0 && c <= conditions.mass_matrix * (1.0 + 1e-6))
            );
        }
        let arm = robots::arm7();
        for conditions in
            along(&arm, &ModuleTree::chains(&arm), &stretching_arm(&instants(1.0, 11)))
        {
            assert!(
                (conditions.modules[0] / conditions.mass_matrix - 1.0).abs() < 1e-6,
                "one module is all"
            );
        }
    }
}
