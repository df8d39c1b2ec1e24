//! The interpreter's numbers at states from standard input, for comparison with other programs
//! (`lab/robots`). A line has one state: q, then qd, then tau.
//!
//! ```console
//! echo "0.1 0.2 0 0 1 0" | cargo run --release -p modyn-codegen --example evaluate -- robots/double_pendulum.urdf
//! ```
//!
//! The output begins with a line for each joint that has coordinates (the number of its coordinates and velocities, its
//! type, its name), then an empty line. A line for each state follows: accelerations under the torques tau, bias forces, and
//! the mass matrix by columns. For a robot with loops, the accelerations with the loops closed come after them, without
//! stabilization, then the loops' displacements, six for each loop. A robot with a joint that moves no inertia has no
//! dynamics: then the numbers of a state are, for each of these joints, the pose of its link in the world (rotation by rows,
//! translation) and its velocity in world axes (angular, linear). Words after the path: `fixed`, `floating`, `independent`
//! (mimics), `warn` (of inertias that no rigid body has) and `forces` (which are not read).

use std::error::Error;
use std::io::{BufRead as _, Write as _};
use std::path::Path;

use modyn_codegen::diagnostics::Severity;
use modyn_codegen::{Base, Mimic, ReadOptions, read};
use modyn_runtime::equations::constraints::{ConstrainedOutputs, ResidualOutputs};
use modyn_runtime::equations::{ForwardInput, State};
use modyn_runtime::{ConstraintSettings, Interpreter, Twist, Wrench};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments
        .next()
        .ok_or("evaluate ROBOT [fixed] [floating] [independent] [warn] [forces]")?;
    let mut options = ReadOptions::default();
    for word in arguments {
        match word.as_str() {
            "fixed" => options.base = Base::Fixed,
            "floating" => options.base = Base::Floating,
            "independent" => options.mimic = Mimic::Independent,
            "warn" => options.unphysical_inertia = Severity::Warning,
            "forces" => options.unsupported_forces = Severity::Warning,
            other => return Err(format!("no option `{other}`").into()),
        }
    }
    let text = std::fs::read_to_string(&path)?;
    options.folder = Path::new(&path).parent().map(Path::to_owned);
    let model = read(&text, &path, &options)?.model;
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let mut frames = Vec::new();
    for (i, link) in
        model.moving_links().iter().enumerate().filter(|(i, _)| model.mimic(*i).is_none())
    {
        let (nq, nv) = (model.q_range(i).len(), model.v_range(i).len());
        writeln!(out, "{nq} {nv} {} {}", link.joint.joint_type.name(), link.joint.name)?;
        frames.extend(model.link_index(&link.name));
    }
    writeln!(out)?;
    let (nq, n) = (model.nq(), model.nv());
    let loops = if model.contacts().is_empty() { model.loop_constraints().len() } else { 0 };
    let mut interpreter = Interpreter::<f64>::new(model);
    let settings =
        ConstraintSettings { alpha: 0.0, beta: 0.0, ..ConstraintSettings::<f64>::DEFAULT };
    let mut closed = vec![0.0; if loops > 0 { n } else { 0 }];
    let (mut wrenches, mut residuals) = (vec![Wrench::zero(); loops], vec![Twist::zero(); loops]);
    let (mut displacements, mut velocities) = (residuals.clone(), residuals.clone());
    let (mut qdd, mut bias, mut matrix) = (vec![0.0; n], vec![0.0; n], vec![0.0; n * n]);
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let state = line.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        if state.len() != nq + 2 * n {
            return Err(format!("a state has {nq} + 2 * {n} numbers, not {}", state.len()).into());
        }
        let ((q, qd), tau) = (state[..nq + n].split_at(nq), &state[nq + n..]);
        if interpreter.joint_without_inertia().is_some() {
            let mut numbers = Vec::new();
            for &frame in &frames {
                let pose = interpreter.link_pose(q, frame)?;
                numbers.extend(pose.rotation.into_iter().flatten().chain(pose.translation));
                numbers.extend(interpreter.link_velocity(q, qd, frame)?.components());
            }
            writeln!(out, "{}", words(&numbers))?;
            continue;
        }
        interpreter.forward_dynamics(q, qd, tau, &mut qdd)?;
        interpreter.bias_forces(q, qd, &mut bias)?;
        interpreter.mass_matrix(q, &mut matrix)?;
        if loops > 0 {
            let results = ConstrainedOutputs {
                qdd: &mut closed,
                wrenches: &mut wrenches,
                residuals: &mut residuals,
            };
            interpreter.constrained_forward_dynamics(
                ForwardInput { q, qd, tau },
                &[],
                &settings,
                results,
            )?;
            let results =
                ResidualOutputs { displacements: &mut displacements, velocities: &mut velocities };
            interpreter.constraint_residual(State { q, qd }, &settings, results)?;
        }
        let displacements: Vec<f64> = displacements.iter().flat_map(Twist::components).collect();
        let numbers = [&qdd[..], &bias, &matrix, &closed, &displacements].concat();
        writeln!(out, "{}", words(&numbers))?;
    }
    Ok(())
}

/// Returns numbers as words.
fn words(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}
