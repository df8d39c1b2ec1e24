//! Model predictive path integral control (Williams, Aldrich and Theodorou 2017) of an arm and of a quadruped on its feet.
//!
//! Each control period draws many sequences of controls around the present one, computes all motions by one kernel, and
//! takes the mean of the sequences, weighted by their costs. Run it with
//! `cargo run --release --example mppi -- 4096` in `modyn-gpu`; the number is that of samples.

use std::path::Path;

use modyn_codegen::{Base, Builder, Function, FusedFunction, RolloutForces, RolloutOptions};
use modyn_gpu::{Gpu, GpuArray, GpuError, Rollout, RolloutArguments};

/// A robot, its task, and the settings of the method.
struct Task {
    name: &'static str,
    builder: Builder,
    options: RolloutOptions,
    /// The initial state.
    q: Vec<f32>,
    qd: Vec<f32>,
    /// The controls at the beginning, and the standard deviations of their changes.
    controls: Vec<f32>,
    deviations: Vec<f32>,
    /// The numbers of the cost function.
    data: Vec<f32>,
    /// The duration of a step, s; the steps that one set of controls is held; and the sets in a sequence.
    dt: f32,
    hold: usize,
    periods: usize,
}

/// The arm's controls are positions of its joints, which springs and dampers follow within the limits of the motors.
const ARM_FORCES: &str = "
fn forces(q: array<f32, 7>, qd: array<f32, 7>, u: array<f32, 7>, step: u32) -> array<f32, 7> {
    var angles = q;
    var rates = qd;
    var goals = u;
    var wanted: array<f32, 7>;
    for (var j = 0; j < 7; j++) {
        wanted[j] = 100.0 * (goals[j] - angles[j]) - 20.0 * rates[j];
    }
    var tau = arm7_inverse_dynamics(q, qd, wanted);
    for (var j = 0; j < 7; j++) {
        let limit = select(12.0, 87.0, j < 4);
        tau[j] = clamp(tau[j], -limit, limit);
    }
    return tau;
}";

/// The distance of the grasp point from the goal, and the speed.
const ARM_COST: &str = "
fn cost(q: array<f32, 7>, qd: array<f32, 7>, u: array<f32, 7>, step: u32) -> f32 {
    let pose = arm7_link_pose_grasp_point(q);
    let error = vec3<f32>(pose[9] - data[0], pose[10] - data[1], pose[11] - data[2]);
    var rates = qd;
    var speed = 0.0;
    for (var j = 0; j < 7; j++) {
        speed += rates[j] * rates[j];
    }
    return 100.0 * dot(error, error) + 0.01 * speed;
}";

/// The quadruped's controls are positions of its joints. Each foot has a spring, a damper and dry friction on the ground,
/// the plane z = 0: its force, multiplied by the foot's Jacobian transposed, is a joint force.
const QUADRUPED_FORCES: &str = "
fn forces(q: array<f32, 19>, qd: array<f32, 18>, u: array<f32, 12>, step: u32) -> array<f32, 18> {
    var coordinates = q;
    var rates = qd;
    var goals = u;
    var tau: array<f32, 18>;
    for (var j = 0; j < 12; j++) {
        tau[6 + j] = clamp(8.0 * (goals[j] - coordinates[7 + j]) - 0.2 * rates[6 + j], -2.7, 2.7);
    }
    // A pose (9 numbers of its rotation, 3 of its translation), then 18 columns of 3 linear and 3 angular numbers.
    var feet = quadruped_feet(q);
    for (var foot = 0; foot < 4; foot++) {
        let first = 120 * foot;
        let depth = -feet[first + 11];
        if (depth > 0.0) {
            var velocity = vec3<f32>(0.0);
            for (var j = 0; j < 18; j++) {
                let k = first + 12 + 6 * j;
                velocity += vec3<f32>(feet[k], feet[k + 1], feet[k + 2]) * rates[j];
            }
            let normal = max(2000.0 * depth - 20.0 * velocity.z, 0.0);
            let speed = max(length(velocity.xy), 1e-6);
            let force = vec3<f32>(-velocity.xy * min(20.0, 0.7 * normal / speed), normal);
            for (var j = 0; j < 18; j++) {
                let k = first + 12 + 6 * j;
                tau[j] += dot(vec3<f32>(feet[k], feet[k + 1], feet[k + 2]), force);
            }
        }
    }
    return tau;
}";

/// The height, the velocities and the tilt of the trunk, and the distance of the legs from those of standing.
const QUADRUPED_COST: &str = "
fn cost(q: array<f32, 19>, qd: array<f32, 18>, u: array<f32, 12>, step: u32) -> f32 {
    var coordinates = q;
    var legs = 0.0;
    for (var leg = 0; leg < 4; leg++) {
        for (var j = 0; j < 3; j++) {
            let error = coordinates[7 + 3 * leg + j] - data[2 + j];
            legs += error * error;
        }
    }
    let height = q[2] - data[0];
    let speed = qd[0] - data[1];
    let drift = qd[1] * qd[1] + qd[2] * qd[2] + 0.1 * (qd[3] * qd[3] + qd[4] * qd[4] + qd[5] * qd[5]);
    let tilt = q[3] * q[3] + q[4] * q[4];
    return 200.0 * height * height + 0.5 * speed * speed + 0.2 * drift + 20.0 * tilt + 0.2 * legs;
}";

fn robot(name: &str) -> Builder {
    Builder::new()
        .urdf(Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../robots/{name}.urdf")))
}

/// The arm reaches for a point.
fn arm() -> Task {
    let functions = [Function::StepSemiImplicit, Function::InverseDynamics, Function::LinkPose];
    let forces = RolloutForces { text: ARM_FORCES.into(), controls: 7 };
    let q = vec![0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8];
    Task {
        name: "arm",
        builder: robot("arm7").functions(functions),
        options: RolloutOptions {
            cost: Some(ARM_COST.into()),
            forces: Some(forces),
            active_contacts: None,
        },
        controls: q.clone(),
        q,
        qd: vec![0.0; 7],
        deviations: vec![0.3; 7],
        data: vec![0.3, 0.4, 0.4],
        dt: 0.01,
        hold: 4,
        periods: 10,
    }
}

/// The quadruped rises from a crouch and moves forward slowly.
fn quadruped() -> Task {
    let mut feet = FusedFunction::new("feet");
    for link in ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"] {
        feet = feet.of_link(Function::LinkPose, link).of_link(Function::Jacobian, link);
    }
    let builder = robot("quadruped").base(Base::Floating);
    let forces = RolloutForces { text: QUADRUPED_FORCES.into(), controls: 12 };
    let crouch = [0.0, 1.0, -2.0].repeat(4);
    let trunk = [0.0, 0.0, 0.173, 0.0, 0.0, 0.0, 1.0];
    Task {
        name: "quadruped",
        builder: builder.functions([Function::StepSemiImplicit]).fused([feet]),
        options: RolloutOptions {
            cost: Some(QUADRUPED_COST.into()),
            forces: Some(forces),
            active_contacts: None,
        },
        q: [&trunk[..], &crouch].concat(),
        qd: vec![0.0; 18],
        controls: crouch,
        deviations: vec![0.2; 12],
        data: vec![0.24, 0.1, 0.0, 0.72, -1.44],
        dt: 0.002,
        hold: 10,
        periods: 8,
    }
}

/// Normally distributed numbers.
struct Random(u64);

impl Random {
    /// Returns a number in (0, 1).
    fn uniform(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 41) as f32 + 0.5) / (1 << 23) as f32
    }

    /// Returns a number with mean 0 and standard deviation 1 (Box and Muller 1958).
    fn normal(&mut self) -> f32 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (core::f32::consts::TAU * self.uniform()).cos()
    }
}

struct Controller {
    gpu: Gpu,
    task: Task,
    rollout: Rollout,
    data: GpuArray,
    /// The present sequence: a set of controls after another.
    sequence: Vec<f32>,
    random: Random,
}

impl Controller {
    fn new(gpu: &Gpu, task: Task) -> Result<Self, GpuError> {
        let rollout = Rollout::new(gpu, &task.builder, &task.options)?;
        let data = gpu.upload(&task.data, 1)?;
        let sequence = task.controls.repeat(task.periods);
        Ok(Self { gpu: gpu.clone(), task, rollout, data, sequence, random: Random(1) })
    }

    /// Returns the final states and the costs of sequences, all from the present state.
    fn run(&self, sequences: &[Vec<f32>]) -> Result<(Vec<f32>, Vec<f32>), GpuError> {
        let task = &self.task;
        let mut controls = Vec::new();
        for set in 0..sequences[0].len() / task.controls.len() {
            let set = set * task.controls.len()..(set + 1) * task.controls.len();
            for _ in 0..task.hold {
                for j in set.clone() {
                    controls.extend(sequences.iter().map(|sequence| sequence[j]));
                }
            }
        }
        let controls = self.gpu.upload(&controls, sequences.len())?;
        let (q, qd) = (self.gpu.upload(&task.q, 1)?, self.gpu.upload(&task.qd, 1)?);
        let arguments = RolloutArguments {
            data: Some(&self.data),
            ..RolloutArguments::new(&q, &qd, &controls, task.dt)
        };
        let results = self.rollout.run(&arguments)?;
        let costs = results.cost.expect("there is a cost function").read()?;
        Ok((results.state.read()?, costs))
    }

    /// Improves the sequence by this number of samples, moves the robot by its first set of controls, and returns the cost
    /// of a step of the sequence before.
    fn period(&mut self, samples: usize) -> Result<f32, GpuError> {
        let n = self.task.controls.len();
        let mut sequences = vec![self.sequence.clone(); samples];
        // The first sample is the sequence itself.
        for sequence in &mut sequences[1..] {
            for (i, x) in sequence.iter_mut().enumerate() {
                *x += self.task.deviations[i % n] * self.random.normal();
            }
        }
        let (_, costs) = self.run(&sequences)?;
        let steps = (self.task.hold * self.task.periods) as f32;
        // A motion that left all bounds counts as infinitely expensive.
        let costs: Vec<f32> =
            costs.iter().map(|x| if x.is_finite() { *x } else { f32::INFINITY }).collect();
        let least = costs.iter().copied().fold(f32::INFINITY, f32::min);
        let finite = || costs.iter().filter(|x| x.is_finite());
        let mean = finite().sum::<f32>() / finite().count().max(1) as f32;
        let temperature = (0.1 * (mean - least)).max(f32::MIN_POSITIVE);
        let weights: Vec<f32> = costs.iter().map(|x| ((least - x) / temperature).exp()).collect();
        let total: f32 = weights.iter().sum();
        for (i, x) in self.sequence.iter_mut().enumerate() {
            let of_sample = sequences.iter().zip(&weights).map(|(sample, w)| w * sample[i]);
            *x = of_sample.sum::<f32>() / total;
        }
        let (state, _) = self.run(&[self.sequence[..n].to_vec()])?;
        let nq = self.task.q.len();
        self.task.q.copy_from_slice(&state[..nq]);
        self.task.qd.copy_from_slice(&state[nq..]);
        // The next sequence begins a set later, and ends with the last set twice.
        self.sequence.rotate_left(n);
        let last = self.sequence.len() - n;
        self.sequence.copy_within(last - n..last, last);
        Ok(costs[0] / steps)
    }
}

fn main() -> Result<(), GpuError> {
    let samples = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(1024);
    let gpu = Gpu::new()?;
    println!("{}, {samples} samples a period", gpu.name());
    for task in [arm(), quadruped()] {
        let mut controller = Controller::new(&gpu, task)?;
        for period in 0..40 {
            let start = std::time::Instant::now();
            let cost = controller.period(samples)?;
            let time = start.elapsed().as_secs_f64() * 1e3;
            println!("{} period {period}: cost {cost:.4}, {time:.1} ms", controller.task.name);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the costs of periods.
    fn costs(task: Task, periods: usize, samples: usize) -> Vec<f32> {
        let gpu = Gpu::new().expect("a processor: Mesa has one in software");
        let mut controller = Controller::new(&gpu, task).expect("kernels");
        (0..periods).map(|_| controller.period(samples).expect("it runs")).collect()
    }

    #[test]
    fn the_arm_comes_closer_to_its_goal() {
        let costs = costs(arm(), 15, 128);
        assert!(costs[14] < 0.2 * costs[0], "{costs:?}");
    }

    #[test]
    #[ignore = "slow: a quadruped on a software processor"]
    fn the_quadruped_rises_and_stays_upright() {
        let costs = costs(quadruped(), 12, 192);
        assert!(costs[11] < 0.5 * costs[0], "{costs:?}");
    }
}
