//! A quadruped that stands, one that trots, and a humanoid that stands.

use modyn::simulate::State;

use super::{GRAVITY, Quadruped, STEP, Settings, heights, lowest, on_ground, rotation};

// G1's numbers. Each sole has the four points at which Unitree's description of G1 has spheres.
modyn::modyn! {
    "../../../../robots/humanoid.urdf",
    base = floating,
    functions = [
        forward_dynamics,
        mass_matrix,
        brge,
        gravity_torques,
        kinetic_energy,
        potential_energy,
        integrate,
        difference,
        step,
        constraint_residual,
    ],
    contacts = [
        "left_toe_out": point("left_ankle_roll_link", [0.12, 0.03, -0.035]),
        "left_toe_in": point("left_ankle_roll_link", [0.12, -0.03, -0.035]),
        "left_heel_out": point("left_ankle_roll_link", [-0.05, 0.025, -0.035]),
        "left_heel_in": point("left_ankle_roll_link", [-0.05, -0.025, -0.035]),
        "right_toe_in": point("right_ankle_roll_link", [0.12, 0.03, -0.035]),
        "right_toe_out": point("right_ankle_roll_link", [0.12, -0.03, -0.035]),
        "right_heel_in": point("right_ankle_roll_link", [-0.05, 0.025, -0.035]),
        "right_heel_out": point("right_ankle_roll_link", [-0.05, -0.025, -0.035]),
    ]
}

/// Returns coordinates with bent legs, the lowest foot 2 cm above the ground.
pub fn posture() -> [f64; 19] {
    let mut q = Quadruped::NEUTRAL;
    for leg in 0..4 {
        let bend = if leg < 2 { 0.6 } else { -0.6 };
        q[7 + 3 * leg + 1] = bend;
        q[7 + 3 * leg + 2] = -2.0 * bend;
    }
    q[2] = 0.02 - lowest(&State::<Quadruped>::at_rest(q));
    q
}

/// Returns the torques that hold the legs at `posture`, N m.
pub fn hold_legs(state: &State<Quadruped>, posture: &[f64; 19]) -> [f64; 18] {
    let error = Quadruped::difference(&state.q, posture);
    core::array::from_fn(|i| if i < 6 { 0.0 } else { 20.0 * error[i] - 0.4 * state.qd[i] })
}

/// The direction of the robots that trot and stand on soles, rad.
const HEADING: f64 = 0.7;

/// Returns the angle between the z axes of the base and of the world, rad. `q` begins with the pose of the base.
fn tilt(q: &[f64]) -> f64 {
    let (x, y) = (q[3], q[4]);
    (1.0 - 2.0 * (x * x + y * y)).acos()
}

/// It falls from 2 cm, stands, and its feet neither sink nor slip. Steps are 2 ms.
#[test]
fn a_quadruped_stands() {
    let posture = posture();
    let mut state = State::<Quadruped>::at_rest(posture);
    let settings = on_ground();
    let (mut carried, mut deepest) = (0.0, 0.0_f64);
    for _ in 0..600 {
        let step = state.step(0.002, &hold_legs(&state, &posture), &settings);
        (state, carried) = (step.state, step.forces.iter().map(|force| force[2]).sum());
        deepest = deepest.min(lowest(&state));
    }
    let weight = Quadruped::gravity_torques(&Quadruped::NEUTRAL)[2];
    assert!((carried - weight).abs() < 1e-3 * weight, "{carried} N of {weight} N");
    // Soft contacts creep.
    assert!(state.qd.iter().all(|v| v.abs() < 5e-3), "{:?}", state.qd);
    assert!(deepest > -2e-3, "{deepest} m");
    assert!(heights(&state).iter().all(|h| h.abs() < 1e-4));
    assert!(
        state.q[2] > 0.2 && state.q[0].abs() < 0.05 && state.q[1].abs() < 0.05,
        "{:?}",
        state.q
    );
}

/// A trot: the diagonal pairs of feet swing in turn.
pub struct Trot {
    /// The time of a stride, s.
    period: f64,
    /// The speed, m/s.
    speed: f64,
    /// The height of the hips above standing feet, m.
    height: f64,
    /// The height of a swinging foot at most, m.
    lift: f64,
    /// The time of standing before the first stride, s.
    wait: f64,
    /// The time in which the strides reach their full length, s.
    ramp: f64,
}

pub const TROT: Trot =
    Trot { period: 0.4, speed: 0.3, height: 0.25, lift: 0.04, wait: 0.3, ramp: 0.6 };
/// The length of a thigh and of a shank, m.
const LEG: f64 = 0.16;

impl Trot {
    /// Returns the place of a foot relative to its hip at this time, forwards and upwards, m.
    fn foot(&self, leg: usize, time: f64) -> [f64; 2] {
        if time < self.wait {
            return [0.0, -self.height];
        }
        let length = self.speed * self.period / 2.0 * ((time - self.wait) / self.ramp).min(1.0);
        let offset = if leg == 1 || leg == 2 { 0.5 } else { 0.0 };
        // The first half of a stride is the swing.
        let phase = 2.0 * (time / self.period + offset).rem_euclid(1.0);
        if phase < 1.0 {
            let (sine, cosine) = (std::f64::consts::PI * phase).sin_cos();
            [-length / 2.0 * cosine, self.lift * sine * sine - self.height]
        } else {
            [length / 2.0 - length * (phase - 1.0), -self.height]
        }
    }

    /// Returns the joint angles at this time, rad: thigh and shank have equal lengths.
    fn angles(&self, time: f64) -> [f64; 12] {
        let mut angles = [0.0; 12];
        for leg in 0..4 {
            let [x, z] = self.foot(leg, time);
            // Front knees point backwards and hind knees forwards.
            let side = if leg < 2 { 1.0 } else { -1.0 };
            let bend = side * (x.hypot(z) / (2.0 * LEG)).acos();
            angles[3 * leg + 1] = f64::atan2(-x, -z) + bend;
            angles[3 * leg + 2] = -2.0 * bend;
        }
        angles
    }

    /// Returns the robot at rest, its lowest foot 5 mm above the ground.
    pub fn start(&self) -> State<Quadruped> {
        let mut q = Quadruped::NEUTRAL;
        q[3..7].copy_from_slice(&rotation([0.0, 0.0, 1.0], HEADING).1);
        q[7..].copy_from_slice(&self.angles(0.0));
        q[2] = 0.005 - lowest(&State::<Quadruped>::at_rest(q));
        State::at_rest(q)
    }

    /// Returns torques towards the angles and their rates at this time, N m.
    pub fn torques(&self, state: &State<Quadruped>, time: f64) -> [f64; 18] {
        const INSTANT: f64 = 1e-4;
        let (wanted, next) = (self.angles(time), self.angles(time + INSTANT));
        let mut tau = [0.0; 18];
        for (i, tau) in tau[6..].iter_mut().enumerate() {
            let rate = (next[i] - wanted[i]) / INSTANT;
            *tau = 20.0 * (wanted[i] - state.q[7 + i]) + 0.4 * (rate - state.qd[6 + i]);
        }
        tau
    }
}

fn energy(state: &State<Quadruped>) -> f64 {
    Quadruped::kinetic_energy(&state.q, &state.qd) + Quadruped::potential_energy(&state.q)
}

/// The joints follow a trot by feedback alone, and the base follows the feet: forwards in a direction in general position,
/// level, at its height. The ground takes energy and gives none.
#[test]
fn a_quadruped_trots() {
    let settings = on_ground();
    let mut state = TROT.start();
    let start = energy(&state);
    let (mut deepest, mut steepest, mut work, mut swings) = (0.0_f64, 0.0_f64, 0.0, [0; 4]);
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let steps = 3000;
    for i in 0..steps {
        let time = f64::from(i) * STEP;
        let tau = TROT.torques(&state, time);
        let step = state.step(STEP, &tau, &settings);
        let power = |state: &State<Quadruped>| (6..18).map(|i| tau[i] * state.qd[i]).sum::<f64>();
        work += STEP * (power(&state) + power(&step.state)) / 2.0;
        state = step.state;
        let above = heights(&state);
        deepest = above.into_iter().fold(deepest, f64::min);
        for (swings, above) in swings.iter_mut().zip(above) {
            *swings += usize::from(above > 0.01);
        }
        steepest = steepest.max(tilt(&state.q));
        if time > TROT.wait {
            range = [range[0].min(state.q[2]), range[1].max(state.q[2])];
        }
    }
    let (sine, cosine) = HEADING.sin_cos();
    let forwards = cosine * state.q[0] + sine * state.q[1];
    let sideways = cosine * state.q[1] - sine * state.q[0];
    let lost = start + work - energy(&state);
    println!(
        "{forwards:.3} m forwards, {sideways:.3} m sideways, {:.1e} m in the ground, tilted by {steepest:.3} rad, \
         motors give {work:.2} J, the ground takes {lost:.2} J",
        -deepest
    );
    // After the ramp, of half the speed on average.
    let expected = TROT.speed * (f64::from(steps) * STEP - TROT.wait - TROT.ramp / 2.0);
    assert!((forwards - expected).abs() < 0.15 * expected, "{forwards} m of {expected} m");
    assert!(sideways.abs() < 0.1 * forwards, "{sideways} m");
    assert!(steepest < 0.1, "{steepest} rad");
    assert!(range[0] > TROT.height - 0.015 && range[1] < TROT.height + 0.01, "{range:?}");
    assert!(deepest > -3e-3, "{deepest} m");
    // Each foot is higher than 1 cm for about a third of the time.
    assert!(swings.iter().all(|&count| count > 500 && count < 1200), "{swings:?}");
    assert!(work > 0.0 && lost > 0.0, "{work} J, {lost} J");
    // The motors pay for the friction and the impacts of the feet alone: a few times the weight times the way.
    assert!(work < 2.5 * GRAVITY * forwards, "{work} J");
}

/// The stiffness (N m/rad) and the damping (N m s/rad) of a joint that moves this inertia (kg m^2).
fn gains(joint: &str, inertia: f64) -> [f64; 2] {
    let is = |part| joint.contains(part);
    if is("ankle_roll") {
        [60.0, 0.2]
    } else if is("ankle_pitch") {
        [300.0, 1.5]
    } else if is("hip") || is("knee") || is("waist") {
        [500.0, 8.0]
    } else {
        // Arms, at 20 rad/s.
        [400.0 * inertia, 20.0 * inertia]
    }
}

/// The humanoid in an asymmetric posture.
pub struct Upright {
    posture: [f64; Humanoid::NQ],
    gains: [[f64; 2]; Humanoid::NV],
}

impl Upright {
    /// The soles are 1 cm above the ground.
    pub fn new() -> Self {
        let mut posture = Humanoid::NEUTRAL;
        posture[3..7].copy_from_slice(&rotation([0.0, 0.0, 1.0], HEADING).1);
        let bends =
            [("hip_pitch", -0.2), ("knee", 0.42), ("ankle_pitch", -0.22), ("left_elbow", 0.5)];
        for (i, joint) in Humanoid::JOINT_NAMES[1..].iter().enumerate() {
            let bend = bends.iter().find(|(part, _)| joint.contains(part));
            posture[7 + i] = bend.map_or(0.0, |(_, angle)| *angle);
        }
        posture[2] = 0.01 - lowest(&State::<Humanoid>::at_rest(posture));
        let mass = Humanoid::mass_matrix(&posture);
        let gains = core::array::from_fn(|i| match i {
            0..6 => [0.0; 2],
            _ => gains(Humanoid::JOINT_NAMES[i - 5], mass[i][i]),
        });
        Self { posture, gains }
    }

    /// Returns the robot in its posture after a push to the left.
    pub fn start(&self) -> State<Humanoid> {
        let mut state = State::<Humanoid>::at_rest(self.posture);
        state.qd[1] = 0.1;
        state
    }

    /// Returns the torques that hold the posture, N m.
    pub fn torques(&self, state: &State<Humanoid>) -> [f64; Humanoid::NV] {
        let error = Humanoid::difference(&state.q, &self.posture);
        core::array::from_fn(|i| self.gains[i][0] * error[i] - self.gains[i][1] * state.qd[i])
    }
}

/// Feedback of joint angles holds a humanoid upright for two seconds after a push to the side, in an asymmetric posture
/// and a heading in general position. Its soles do not slip. Steps are 2 ms.
#[test]
fn a_humanoid_stands() {
    // Without optimisation, the function `step` of a humanoid needs more than the 2 MiB of a test's stack.
    let stands = std::thread::Builder::new().stack_size(8 << 20).spawn(stand_after_a_push);
    stands.expect("a thread").join().expect("it stands");
}

fn stand_after_a_push() {
    let settings = on_ground();
    let upright = Upright::new();
    let mut state = upright.start();
    let places = |state: &State<Humanoid>| {
        let found =
            Humanoid::constraint_residual(&state.q, &state.qd, &Settings::DEFAULT).displacements;
        found.map(|place| place.linear)
    };
    let (mut deepest, mut steepest, mut landed) = (0.0_f64, 0.0_f64, None);
    let mut carried = 0.0;
    let steps = 1000;
    for i in 0..steps {
        let tau = upright.torques(&state);
        let step = state.step(0.002, &tau, &settings);
        state = step.state;
        deepest = deepest.min(lowest(&state));
        steepest = steepest.max(tilt(&state.q));
        if i == 100 {
            landed = Some(places(&state));
        }
        if i >= steps / 2 {
            carried += step.forces.iter().map(|force| force[2]).sum::<f64>() / f64::from(steps / 2);
        }
    }
    let landed = landed.expect("it ran");
    let slip = places(&state).into_iter().zip(landed).map(|(after, before)| {
        let way = after - before;
        way.dot(way).sqrt()
    });
    let slip = slip.fold(0.0, f64::max);
    println!(
        "{:.1e} m in the ground, tilted by {steepest:.3} rad, soles slip {slip:.1e} m",
        -deepest
    );
    assert!(deepest > -3e-3, "{deepest} m");
    assert!(steepest < 0.15, "{steepest} rad");
    assert!(slip < 2e-3, "{slip} m");
    assert!(state.q[2] > 0.75 && state.q[0].hypot(state.q[1]) < 0.08, "{:?}", &state.q[..7]);
    let weight = Humanoid::gravity_torques(&Humanoid::NEUTRAL)[2];
    assert!((carried - weight).abs() < 0.02 * weight, "{carried} N of {weight} N");
}
