//! An arm swings up a point mass by random shooting: all plans of a round move together, one state in each lane.

modyn::modyn! {
    Pendulum = "robots/double_pendulum.urdf",
    functions = [default, forward_dynamics_batch]
}
use modyn::simulate::{State, rollout::rollout};

const MOTIONS: usize = 500;
const STEPS: usize = 100;
const DT: f64 = 0.01;

/// A generator of numbers in -1..1, the same on every machine.
fn noise(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*state >> 33) as f64 / (1_u64 << 30) as f64 - 1.0
}

/// The potential energy gained since hanging, J: a measure of the height.
fn height(q: &[f64; 2]) -> f64 {
    Pendulum::potential_energy(q) - Pendulum::potential_energy(&[0.0; 2])
}

/// Rolls all plans out from rest; the best height of each.
fn roll_out(plans: &[Vec<[f64; 2]>]) -> Result<Vec<f64>, modyn::BatchError> {
    let mut motions = vec![State::<Pendulum>::at_rest([0.0; 2]); plans.len()];
    let mut best = vec![0.0_f64; plans.len()];
    rollout(
        &mut motions,
        STEPS,
        DT,
        |at, _| plans[at.motion][at.step],
        // Motions advance together, one state in each lane.
        Pendulum::forward_dynamics_each,
        |at, _, state| best[at.motion] = best[at.motion].max(height(&state.q)),
    )?;
    Ok(best)
}

fn main() -> Result<(), modyn::BatchError> {
    let mut seed = 1;
    let mut mean = vec![[0.0; 2]; STEPS];
    let mut heights = Vec::new();
    for round in 0..5 {
        // Each plan is the mean so far plus noise that is constant for ten steps.
        let plans: Vec<Vec<[f64; 2]>> = (0..MOTIONS)
            .map(|_| {
                let mut push = [0.0; 2];
                (0..STEPS)
                    .map(|step| {
                        if step % 10 == 0 {
                            push = [noise(&mut seed), noise(&mut seed)];
                        }
                        [0, 1].map(|k| mean[step][k] + push[k])
                    })
                    .collect()
            })
            .collect();
        let reached = roll_out(&plans)?;
        // The new mean is the mean of the best tenth of the plans.
        let mut order: Vec<usize> = (0..MOTIONS).collect();
        order.sort_by(|&a, &b| reached[b].total_cmp(&reached[a]));
        for (step, mean) in mean.iter_mut().enumerate() {
            let elite = &order[..MOTIONS / 10];
            *mean = [0, 1].map(|k| {
                elite.iter().map(|&i| plans[i][step][k]).sum::<f64>() / elite.len() as f64
            });
        }
        heights.push(reached[order[0]]);
        println!("round {round}: {:.3} J", heights[round]);
    }
    assert!(heights[4] > 1.2 * heights[0], "{heights:?}");
    Ok(())
}
