//! The programs of docs/gpu.md, as they are printed there.

use std::error::Error;

#[test]
fn accelerations_of_a_million_states() -> Result<(), Box<dyn Error>> {
    use modyn_codegen::{Builder, Function};
    use modyn_gpu::{Gpu, GpuRobot};

    let gpu = Gpu::new()?;
    let builder = Builder::new().urdf("../robots/arm7.urdf").functions([Function::ForwardDynamics]);
    let robot = GpuRobot::new(&gpu, &builder)?;
    let states = 1_000_000;
    let q = gpu.upload(&vec![0.1; 7 * states], states)?; // f32, in the layout below
    let qd = gpu.upload(&vec![0.0; 7 * states], states)?;
    let tau = gpu.upload(&vec![0.0; 7 * states], states)?;
    let qdd = robot.run("forward_dynamics", &[&q, &qd, &tau])?;
    let accelerations = qdd.read()?;

    assert_eq!(accelerations.len(), 7 * states);
    Ok(())
}

#[test]
fn a_type_with_its_description() -> Result<(), Box<dyn Error>> {
    use modyn_codegen::{Builder, Function};
    use modyn_gpu::{Gpu, GpuRobot};

    let (gpu, states) = (Gpu::new()?, 100);

    modyn::modyn! { Arm7 = "../../robots/arm7.urdf", functions = [default], embed_model = true }

    let builder = Builder::new().robot::<Arm7>().functions([Function::ForwardDynamics]);
    let robot = GpuRobot::new(&gpu, &builder)?;
    let q = gpu.upload_states(&vec![[0.1; Arm7::NQ]; states])?; // an array for each state
    let qd = gpu.upload_states(&vec![[0.0; Arm7::NV]; states])?;
    let tau = gpu.upload_states(&vec![[0.0; Arm7::NV]; states])?;
    let qdd: Vec<[f64; Arm7::NV]> =
        robot.run("forward_dynamics", &[&q, &qd, &tau])?.read_states()?;

    let expected = Arm7::forward_dynamics(&[0.1; 7], &[0.0; 7], &[0.0; 7]);
    let errors = qdd[states - 1].iter().zip(expected).map(|(a, b)| (a - b).abs());
    assert!(errors.fold(0.0, f64::max) < 1e-3, "{qdd:?}, {expected:?}");
    Ok(())
}

#[test]
fn motions() -> Result<(), Box<dyn Error>> {
    use modyn_codegen::{Builder, Function, RolloutOptions};
    use modyn_gpu::{Gpu, Rollout, RolloutArguments};

    let gpu = Gpu::new()?;
    let builder =
        Builder::new().urdf("../robots/arm7.urdf").functions([Function::StepSemiImplicit]);
    let rollout = Rollout::new(&gpu, &builder, &RolloutOptions::default())?;
    let (rollouts, steps) = (10_000, 50);
    let q = gpu.upload(&[0.1; 7], 1)?; // one initial state for all
    let qd = gpu.upload(&[0.0; 7], 1)?;
    let torques = gpu.upload(&vec![0.5; 7 * steps * rollouts], rollouts)?;
    let results = rollout.run(&RolloutArguments::new(&q, &qd, &torques, 0.01))?;
    let last = results.state.read()?; // q, then qd, of each rollout

    assert_eq!(last.len(), 14 * rollouts);
    Ok(())
}

/// Spaces and the folder of robots are others here.
#[test]
fn the_page_prints_these_programs() {
    let letters = |text: &str| text.replace("../", "").split_whitespace().collect::<String>();
    let page = letters(include_str!("../../docs/gpu.md"));
    let own = letters(include_str!("page.rs"));
    let blocks = page.split("```rust,ignore").skip(1).filter_map(|rest| rest.split("```").next());
    let missing: Vec<&str> = blocks.clone().filter(|block| !own.contains(block)).collect();
    assert!(missing.is_empty() && blocks.count() == 3, "{missing:#?}");
}
