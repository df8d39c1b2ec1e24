//! Fig. 10: the change of total energy per unit mass of the gripper and the biped in free fall, by solver.
//!
//! In double precision the error of the integrator hides the differences between the three solvers. So accelerations
//! are also computed in single precision, and integrated in double precision.

use modyn_runtime::Interpreter;
use modyn_runtime::model::{Model, ModuleTree};

use crate::motion::{State, instants, integrate};
use crate::plot::{Axis, Chart, Line};
use crate::report::{Failure, Report, Table, power};
use crate::scalar::Number;
use crate::stability::{doubles, scalars};
use crate::{dense, gait, gripper, robots};

/// The solvers: GE, RGE, and BRGE by the paper's modules.
pub const SOLVERS: [&str; 3] = ["GE-N", "RGE-N", "BRGE-A"];

/// A robot in free fall.
#[derive(Clone, Debug)]
pub struct Fall {
    model: Model,
    modules: ModuleTree,
    start: State,
    /// The moving mass, kg.
    mass: f64,
}

impl Fall {
    fn new(model: Model, modules: ModuleTree, start: State) -> Self {
        let mass = model.moving_links().iter().map(|link| link.inertial.mass).sum();
        Self { model, modules, start, mass }
    }

    /// Returns the gripper of Table 3, at rest.
    #[must_use]
    pub fn gripper() -> Self {
        let model = robots::gripper();
        let modules = ModuleTree::chains(&model);
        Self::new(model, modules, State { q: gripper::POSTURE.to_vec(), qd: vec![0.0; 4] })
    }

    /// Returns the biped at the start of its step, at rest, its foot on the ground.
    #[must_use]
    pub fn biped() -> Self {
        let model = robots::biped();
        let modules = robots::biped_modules(&model);
        let q = gait::desired(0.0).q.to_vec();
        Self::new(model, modules, State { q, qd: vec![0.0; 12] })
    }

    /// Returns the change of total energy per unit mass (J/kg) at `times`, with accelerations by solver number `solver`
    /// on scalar `S`.
    ///
    /// # Panics
    ///
    /// Never: the lengths are those of the model.
    #[must_use]
    pub fn drift<S: Number>(&self, solver: usize, times: &[f64], tolerance: f64) -> Vec<f64> {
        let n = self.model.nv();
        let interpreter = Interpreter::<S>::new(self.model.clone());
        let mut interpreter = interpreter.eliminating_by(&self.modules).expect("its own modules");
        let zero = vec![S::zero(); n];
        let accelerate = |_: f64, state: &State| {
            let (q, qd) = (scalars::<S>(&state.q), scalars::<S>(&state.qd));
            let mut qdd = zero.clone();
            if solver == 2 {
                interpreter.forward_dynamics(&q, &qd, &zero, &mut qdd).expect("lengths");
            } else {
                let mut mass_matrix = vec![S::zero(); n * n];
                interpreter.mass_matrix(&q, &mut mass_matrix).expect("lengths");
                interpreter.bias_forces(&q, &qd, &mut qdd).expect("lengths");
                let phi: Vec<S> = qdd.iter().map(|&x| -x).collect();
                let solve = [dense::gaussian, dense::reverse_gaussian][solver];
                qdd = solve(&mass_matrix, &phi);
            }
            doubles(&qdd)
        };
        let geometry = Interpreter::<f64>::new(self.model.clone());
        let states = integrate(&geometry, self.start.clone(), times, tolerance, accelerate);
        let mut judge = geometry.clone();
        let mut energy = |state: &State| {
            judge.kinetic_energy(&state.q, &state.qd).expect("lengths")
                + judge.potential_energy(&state.q).expect("lengths")
        };
        let before = energy(&self.start);
        states.iter().map(|state| (energy(state) - before) / self.mass).collect()
    }
}

/// Writes the section of the page.
///
/// # Errors
///
/// If a plot cannot be written.
pub fn report(report: &mut Report) -> Result<(), Failure> {
    report.heading("Energy: Fig. 10");
    report.text(
        "The plots have the change of the total energy per unit mass of robots that fall freely from rest. The paper \
         prints plots without numbers, and states neither integrator nor tolerance. Here the integrator is Dormand and \
         Prince's, with a tolerance of 1e-9 a step in double precision. In the runs in single precision, only \
         the accelerations have single precision; the tolerance is 1e-5 a step.",
    );
    let mut rows = Vec::new();
    for (name, fall, end) in [("gripper", Fall::gripper(), 2.0), ("biped", Fall::biped(), 1.0)] {
        let times = instants(end, 101);
        for precision in ["double", "single"] {
            let of = |solver| match precision {
                "double" => fall.drift::<f64>(solver, &times, 1e-9),
                _ => fall.drift::<f32>(solver, &times, 1e-5),
            };
            let drifts = [of(0), of(1), of(2)];
            let largest =
                |drift: &Vec<f64>| drift.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let mut row = vec![format!("{name}, {precision} precision")];
            row.extend(drifts.iter().map(|drift| power(largest(drift))));
            rows.push(row);
            let line = |(solver, drift): (&str, Vec<f64>)| {
                Line::new(solver, times.iter().copied().zip(drift))
            };
            let title = format!("Fig. 10, {name}: change of energy, {precision} precision");
            let chart = Chart {
                title: &title,
                x: Axis::linear("time (s)"),
                y: Axis::linear("change of energy per unit mass (J/kg)"),
                lines: SOLVERS.into_iter().zip(drifts).map(line).collect(),
            };
            report.plot(&format!("fig10-{name}-{precision}.svg"), &chart)?;
        }
    }
    report.text("The largest change over the time of the plot (J/kg):");
    report.table(Table::new(&[&["robot"][..], &SOLVERS].concat(), rows));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::Fall;

    #[test]
    fn energy_is_kept_by_every_solver() {
        for fall in [Fall::gripper(), Fall::biped()] {
            for solver in 0..3 {
                let double = fall.drift::<f64>(solver, &[0.1, 0.2], 1e-9);
                assert!(double.iter().all(|x| x.abs() < 1e-6), "{double:?}");
                let single = fall.drift::<f32>(solver, &[0.1, 0.2], 1e-5);
                assert!(single.iter().all(|x| x.abs() < 2e-2), "{single:?}");
                assert!(single != double);
            }
        }
    }
}
