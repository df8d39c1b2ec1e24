//! The biped's desired motion: (61)-(64), and the inverse kinematics of its legs.
//!
//! (63) as printed lacks a minus sign on both lines. With the minus sign the repeatability conditions (62) hold; x_h,
//! y_h there are x_0, y_0 of (61).

use num_dual::{Dual2_64, DualNum as _};

/// Duration T of a step, s.
pub const DURATION: f64 = 1.0;
/// Height z_0 of the trunk's centre, m.
pub const HEIGHT: f64 = 0.80;
/// x_0(0), y_0(0), m.
pub const START: [f64; 2] = [-0.15, 0.10];
/// Stride length l_s, m.
pub const STRIDE: f64 = 0.60;
/// Largest height h_f of the swing foot, m.
pub const LIFT: f64 = 0.15;
const GRAVITY: f64 = 9.81;

/// Length of the thigh and of the shank, m.
const LIMB: f64 = 0.5;
/// Distance from the trunk's centre down to the hips, m.
const HIPS: f64 = 0.25;
/// Distance from the trunk's plane to each hip, m.
const HALF_WIDTH: f64 = 0.05;

/// A number and its first two time derivatives.
pub type Moving = Dual2_64;

/// The desired motion at one time.
#[derive(Clone, Debug)]
pub struct Posture {
    /// The coordinates, in the order of the model.
    pub q: [f64; 14],
    /// The velocities.
    pub qd: [f64; 12],
    /// The accelerations.
    pub qdd: [f64; 12],
}

/// w of (61), 1/s.
#[must_use]
pub fn frequency() -> f64 {
    (GRAVITY / HEIGHT).sqrt()
}

/// Returns the trunk's velocity at the start, (63) with the minus sign.
#[must_use]
pub fn start_velocity() -> [f64; 2] {
    let w = frequency();
    let e = (-w * DURATION).exp();
    [-(1.0 + e) / (1.0 - e) * w * START[0], -(1.0 - e) / (1.0 + e) * w * START[1]]
}

/// Returns the position of the trunk's centre, (61).
#[must_use]
pub fn trunk(t: f64) -> [Moving; 3] {
    let w = frequency();
    let (sinh, cosh) = ((w * t).sinh(), (w * t).cosh());
    let along = |start: f64, velocity: f64| {
        let x = start * cosh + velocity / w * sinh;
        Moving::new(x, start * w * sinh + velocity * cosh, w * w * x)
    };
    let [vx, vy] = start_velocity();
    [along(START[0], vx), along(START[1], vy), Moving::from_re(HEIGHT)]
}

/// Returns the position of the swing foot's ankle, (64). The paper leaves its y open; here the feet have the same
/// distance from the trunk at the start and at the end of the step.
#[must_use]
pub fn swing_ankle(t: f64) -> [Moving; 3] {
    let k = std::f64::consts::PI / DURATION;
    let wave = |size: f64, k: f64| {
        let (sin, cos) = (k * t).sin_cos();
        Moving::new(-size * cos, size * k * sin, size * k * k * cos)
    };
    let z = wave(LIFT / 2.0, 2.0 * k) + Moving::from_re(LIFT / 2.0);
    [wave(STRIDE / 2.0, k), Moving::from_re(2.0 * START[1]), z]
}

/// The joint angles of a leg between two points, its ankle and its hip.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// The rotation of shank and thigh about x.
    pub roll: Moving,
    /// The following rotation of the shank about y.
    pub shank: Moving,
    /// The rotation of the thigh relative to the shank about y; the knee points forwards.
    pub knee: Moving,
}

/// Returns the angles of the leg whose hip is at `d` from its ankle.
#[must_use]
pub fn leg([x, y, z]: [Moving; 3]) -> Leg {
    let upright = (y * y + z * z).sqrt();
    let roll = (-y).atan2(z);
    // Both limbs have the same length: the cosine of half the knee's angle is distance / (2 limb).
    let cos = (x * x + upright * upright).sqrt() * (0.5 / LIMB);
    let half = (Moving::from_re(1.0) - cos * cos).sqrt().atan2(cos);
    Leg { roll, shank: x.atan2(upright) + half, knee: -(half + half) }
}

/// Returns the desired posture at time `t`.
#[must_use]
pub fn desired(t: f64) -> Posture {
    let [x, y, z] = trunk(t);
    let down = z - Moving::from_re(HIPS);
    let side = Moving::from_re(HALF_WIDTH);
    let [ax, ay, az] = swing_ankle(t);
    let stance = leg([x, y - side, down]);
    let swing = leg([x - ax, y + side - ay, down - az]);

    let stance_thigh = stance.shank + stance.knee;
    let swing_thigh = swing.shank + swing.knee;
    let mut posture = Posture { q: [0.0; 14], qd: [0.0; 12], qdd: [0.0; 12] };
    let angles = [
        (0, 0, stance.roll),
        (1, 1, stance.shank),
        (2, 2, stance.knee),
        (11, 9, -swing.knee),
        (12, 10, -swing.shank),
        (13, 11, -swing.roll),
    ];
    for (q, v, angle) in angles {
        posture.q[q] = angle.re;
        (posture.qd[v], posture.qdd[v]) = (angle.v1, angle.v2);
    }
    // The trunk stays upright: relative to the thigh it rotates backwards, R_y(-thigh) R_x(-roll).
    let (roll, thigh) = (stance.roll, stance_thigh);
    let ((sx, cx), (sy, cy)) = ((-0.5 * roll.re).sin_cos(), (-0.5 * thigh.re).sin_cos());
    posture.q[3..7].copy_from_slice(&[cy * sx, sy * cx, -sy * sx, cy * cx]);
    let (sin, cos) = roll.re.sin_cos();
    let rate = [roll.v1, thigh.v1 * cos, thigh.v1 * sin].map(|x| -x);
    let coriolis = roll.v1 * thigh.v1;
    let change =
        [roll.v2, thigh.v2 * cos - coriolis * sin, thigh.v2 * sin + coriolis * cos].map(|x| -x);
    posture.qd[3..6].copy_from_slice(&rate);
    posture.qdd[3..6].copy_from_slice(&change);
    // The swing thigh relative to the trunk, R_x(roll) R_y(thigh), velocities in its own axes.
    let (roll, thigh) = (swing.roll, swing_thigh);
    let ((sx, cx), (sy, cy)) = ((0.5 * roll.re).sin_cos(), (0.5 * thigh.re).sin_cos());
    posture.q[7..11].copy_from_slice(&[sx * cy, cx * sy, sx * sy, cx * cy]);
    let (sin, cos) = thigh.re.sin_cos();
    let coriolis = roll.v1 * thigh.v1;
    posture.qd[6..9].copy_from_slice(&[roll.v1 * cos, thigh.v1, roll.v1 * sin]);
    let change = [roll.v2 * cos - coriolis * sin, thigh.v2, roll.v2 * sin + coriolis * cos];
    posture.qdd[6..9].copy_from_slice(&change);
    posture
}

/// Returns the 12 joint angles of Fig. 9. The hips' are Euler angles, y-x-z for the stance hip and x-y-z for the swing
/// hip (each about an axis rotated by the preceding ones); the step is far from their singularities.
#[must_use]
pub fn angles(q: &[f64; 14]) -> [f64; 12] {
    let r = rotation([q[3], q[4], q[5], q[6]]);
    let stance = [r[0][2].atan2(r[2][2]), (-r[1][2]).asin(), r[1][0].atan2(r[1][1])];
    let r = rotation([q[7], q[8], q[9], q[10]]);
    let swing = [(-r[1][2]).atan2(r[2][2]), r[0][2].asin(), (-r[0][1]).atan2(r[0][0])];
    let [a, b, c] = stance;
    let [d, e, f] = swing;
    [q[0], q[1], q[2], a, b, c, d, e, f, q[11], q[12], q[13]]
}

/// The names of the angles.
pub const ANGLES: [&str; 12] = [
    "stance ankle, x",
    "stance ankle, y",
    "stance knee",
    "stance hip, y",
    "stance hip, x",
    "stance hip, z",
    "swing hip, x",
    "swing hip, y",
    "swing hip, z",
    "swing knee",
    "swing ankle, y",
    "swing ankle, x",
];

fn rotation([x, y, z, w]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use modyn_runtime::Interpreter;
    use modyn_runtime::spatial::Pose;

    use super::{DURATION, START, STRIDE, angles, desired, start_velocity, swing_ankle, trunk};
    use crate::robots;

    #[test]
    fn steps_can_be_repeated() {
        // (62), by (63) with its minus; as printed x(T) would be -5.13 m.
        let ([x, y, _], [vx, vy]) = (trunk(DURATION), start_velocity());
        assert!((x.re + START[0]).abs() < 1e-12 && (x.v1 - vx).abs() < 1e-12);
        assert!((y.re - START[1]).abs() < 1e-12 && (y.v1 + vy).abs() < 1e-12);
        let w = super::frequency();
        let printed = START[0] * w.cosh() - vx / w * w.sinh();
        assert!((printed + 5.13).abs() < 5e-3, "{printed}");
        assert!((swing_ankle(0.0)[0].re + STRIDE / 2.0).abs() < 1e-15);
        assert!((swing_ankle(DURATION)[0].re - STRIDE / 2.0).abs() < 1e-15);
    }

    #[test]
    fn legs_reach_their_feet() {
        let model = robots::biped();
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let mut poses = vec![Pose::identity(); model.links().len()];
        for k in 0..=20 {
            let t = DURATION * f64::from(k) / 20.0;
            interpreter.link_poses(&desired(t).q, &mut poses).expect("lengths");
            let pose = |name: &str| poses[model.link_index(name).expect("a link")];
            let (trunk_pose, foot) = (pose("trunk"), pose("swing_foot"));
            // The trunk's frame is at the stance hip.
            let [x, y, z] = trunk(t).map(|x| x.re);
            let hip = [x, y - 0.05, z - 0.25];
            let close =
                |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(close(trunk_pose.translation, hip), "{t}: {:?}", trunk_pose.translation);
            assert!(close(foot.translation, swing_ankle(t).map(|x| x.re)), "{t}");
            for pose in [trunk_pose, foot] {
                for (i, row) in pose.rotation.into_iter().enumerate() {
                    assert!(close(row, std::array::from_fn(|j| f64::from(u8::from(i == j)))));
                }
            }
        }
    }

    #[test]
    fn rates_are_those_of_the_coordinates() {
        let interpreter = Interpreter::<f64>::new(robots::biped());
        let h = 1e-5;
        for k in 1..20 {
            let t = DURATION * f64::from(k) / 20.0;
            let (before, now, after) = (desired(t - h), desired(t), desired(t + h));
            let mut step = [0.0; 12];
            interpreter.difference(&before.q, &after.q, &mut step).expect("lengths");
            for (i, step) in step.into_iter().enumerate() {
                assert!((step / (2.0 * h) - now.qd[i]).abs() < 1e-6, "rate {i} at {t}");
                let change = (after.qd[i] - before.qd[i]) / (2.0 * h);
                assert!((change - now.qdd[i]).abs() < 1e-6, "acceleration {i} at {t}");
            }
            assert!(angles(&now.q)[5].abs() < 1e-12 && angles(&now.q)[8].abs() < 1e-12, "no yaw");
        }
    }
}
