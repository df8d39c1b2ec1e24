//! The laws of contacts and stops hold for the impulses of mechanisms that are hard to solve. The
//! checks are the laws themselves, and share no code with the solver.

use alloc::{vec, vec::Vec};
use core::array::from_fn;

use super::{Contact, ContactMode, Effort, GroundEquations, Residual, Stop};

const MOST: Effort = Effort { sweeps: 8, newton: 40 };

/// A sequence of numbers in -1..1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from((self.0 >> 33) as u32) / f64::from(1_u32 << 30) - 1.0
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Rigid bodies in contact: each has six velocities, angular before linear, at its centre of mass.
struct Bodies {
    /// 1 / mass and 1 / moment of inertia (of a sphere) of each body.
    inverse: Vec<[f64; 2]>,
    velocities: Vec<f64>,
    /// The Jacobian's rows.
    rows: Vec<Vec<f64>>,
    friction: Vec<f64>,
}

impl Bodies {
    fn new(masses: &[f64], size: f64, velocities: &[f64]) -> Self {
        let inverse = masses.iter().map(|mass| [1.0 / mass, 1.0 / (0.4 * mass * size * size)]);
        Self {
            inverse: inverse.collect(),
            velocities: velocities.to_vec(),
            rows: Vec::new(),
            friction: Vec::new(),
        }
    }

    /// Adds a contact at `arm` from the centre of body `upper`, which lies on body `lower` or,
    /// without one, on the world.
    fn contact(
        &mut self,
        (upper, arm): (usize, [f64; 3]),
        lower: Option<(usize, [f64; 3])>,
        normal: [f64; 3],
        friction: f64,
    ) {
        let first =
            cross(normal, if normal[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] });
        let length = dot(&first, &first).sqrt();
        let first = first.map(|x| x / length);
        for axis in [first, cross(normal, first), normal] {
            let mut row = vec![0.0; self.velocities.len()];
            let ends = [Some((upper, arm, 1.0)), lower.map(|(body, arm)| (body, arm, -1.0))];
            for (body, arm, sign) in ends.into_iter().flatten() {
                let turn = cross(arm, axis);
                for k in 0..3 {
                    row[6 * body + k] += sign * turn[k];
                    row[6 * body + 3 + k] += sign * axis[k];
                }
            }
            self.rows.push(row);
        }
        self.friction.push(friction);
    }

    fn matrix(&self) -> Vec<Vec<f64>> {
        let scaled = |row: &[f64]| -> Vec<f64> {
            let part = |v: usize| self.inverse[v / 6][usize::from(v % 6 < 3)];
            row.iter().enumerate().map(|(v, x)| x * part(v)).collect()
        };
        let scaled: Vec<Vec<f64>> = self.rows.iter().map(|row| scaled(row)).collect();
        self.rows.iter().map(|row| scaled.iter().map(|other| dot(row, other)).collect()).collect()
    }

    /// Returns the impulses, after a check of the laws of contacts within the residual, and the
    /// residual.
    fn try_solve(&self) -> (Vec<f64>, f64) {
        let b: Vec<f64> = self.rows.iter().map(|row| dot(row, &self.velocities)).collect();
        let (p, residual) = solve(&self.matrix(), &b, &self.friction, &[]);
        check(&self.matrix(), &b, &self.friction, &p, residual.contacts.max(1e-9));
        (p, residual.contacts)
    }

    /// Returns the impulses, whose residual must be at most `tolerance`.
    fn solve(&self, tolerance: f64) -> Vec<f64> {
        let (p, residual) = self.try_solve();
        assert!(residual <= tolerance, "{residual}");
        p
    }
}

fn solve(
    a: &[Vec<f64>],
    b: &Vec<f64>,
    friction: &[f64],
    ranges: &[[f64; 2]],
) -> (Vec<f64>, Residual) {
    let mut contacts: Vec<Contact<f64>> = friction.iter().map(|&mu| Contact::new(mu)).collect();
    let mut stops: Vec<Stop<f64>> = ranges.iter().map(|&range| Stop::new(range)).collect();
    let mut p = vec![0.0; b.len()];
    let mut equations = GroundEquations { a, b, contacts: &mut contacts, stops: &mut stops };
    let memory = || vec![vec![0.0; b.len()]; b.len()];
    let (residual, effort) = equations.solve(&mut p, memory, (MOST, 1e-10));
    assert!(effort.sweeps <= MOST.sweeps && effort.newton <= MOST.newton);
    assert!(p.iter().all(|x| x.is_finite()));
    (p, residual)
}

/// Signorini's and Coulomb's laws, within a velocity.
fn check(a: &[Vec<f64>], b: &[f64], friction: &[f64], p: &[f64], tolerance: f64) {
    let u: Vec<f64> = a.iter().zip(b).map(|(row, b)| b + dot(row, p)).collect();
    for (c, mu) in friction.iter().enumerate() {
        let [x, y, z] = [3 * c, 3 * c + 1, 3 * c + 2];
        // The impulse that changes the velocity by the tolerance.
        let little = 4.0 * tolerance / a[z][z].max(1e-12);
        let (sliding, rubbing) = (u[x].hypot(u[y]), p[x].hypot(p[y]));
        assert!(
            p[z] >= -little && u[z] >= -4.0 * tolerance,
            "contact {c}: {} N s, {} m/s",
            p[z],
            u[z]
        );
        assert!(p[z] <= little || u[z] <= 4.0 * tolerance, "contact {c} pushes while it opens");
        assert!(
            rubbing <= mu * p[z].max(0.0) * (1.0 + 1e-6) + little,
            "contact {c} beyond its cone"
        );
        if sliding > 1e3 * tolerance && p[z] > little {
            let cosine = -(p[x] * u[x] + p[y] * u[y]);
            let most = mu * p[z] * sliding;
            assert!(
                (cosine - most).abs() <= 1e-3 * most + 4.0 * little * sliding,
                "contact {c} rubs {cosine} of {most}"
            );
        }
    }
}

/// A box on four corners that spins, slides and falls, with and without friction.
#[test]
fn corners_of_a_box() {
    let mut random = Random(3);
    for case in 0..200 {
        let mut velocities = [0.0; 6];
        velocities.fill_with(|| random.next());
        velocities[5] -= 1.0;
        let mut bodies = Bodies::new(&[2.0], 0.3, &velocities);
        let friction = [0.0, 0.1, 0.5, 1.0, 3.0][case % 5];
        for corner in [[0.2, 0.1, -0.1], [-0.2, 0.1, -0.1], [0.2, -0.1, -0.1], [-0.2, -0.1, -0.1]] {
            bodies.contact((0, corner), None, [0.0, 0.0, 1.0], friction);
        }
        bodies.solve(1e-8);
    }
}

/// A box that lands flat is stopped by all corners alike.
#[test]
fn redundant_corners_share_the_load() {
    let mut bodies = Bodies::new(&[3.0], 0.2, &[0.0, 0.0, 0.0, 0.0, 0.0, -2.0]);
    for corner in [[0.2, 0.1, -0.1], [-0.2, 0.1, -0.1], [0.2, -0.1, -0.1], [-0.2, -0.1, -0.1]] {
        bodies.contact((0, corner), None, [0.0, 0.0, 1.0], 0.7);
    }
    let p = bodies.solve(1e-9);
    for c in 0..4 {
        assert!((p[3 * c + 2] - 1.5).abs() < 0.15, "{p:?}");
    }
}

/// A sphere between two walls that form a wedge, pressed into it.
#[test]
fn a_wedge() {
    for (angle, friction) in
        [(0.2_f64, 0.0), (0.2, 0.1), (0.2, 1.0), (1.2, 0.0), (1.2, 0.3), (1.2, 1.0)]
    {
        let mut bodies = Bodies::new(&[1.0], 0.1, &[0.1, -0.2, 0.3, 0.2, 0.4, -1.0]);
        for sign in [1.0, -1.0] {
            let normal = [sign * angle.cos(), 0.0, angle.sin()];
            bodies.contact((0, normal.map(|x| -0.1 * x)), None, normal, friction);
        }
        bodies.solve(1e-8);
    }
}

/// A pile of spheres whose masses are in the ratio 1 to 10,000, the heavy one on top or below, hit
/// from above.
#[test]
fn stacks_of_unequal_masses() {
    for masses in [[1.0, 1.0, 1.0], [1.0, 100.0, 1e4], [1e4, 100.0, 1.0], [1.0, 1e4, 1.0]] {
        let mut velocities = [0.0; 18];
        for (k, v) in [(5, -0.1), (11, -0.2), (17, -3.0), (3, 0.3), (15, -0.2), (1, 1.0)] {
            velocities[k] = v;
        }
        let mut bodies = Bodies::new(&masses, 0.1, &velocities);
        let (up, down) = ([0.02, 0.0, 0.1], [0.0, 0.0, -0.1]);
        bodies.contact((0, down), None, [0.0, 0.0, 1.0], 0.6);
        bodies.contact((1, down), Some((0, up)), [0.0, 0.0, 1.0], 0.6);
        bodies.contact((2, down), Some((1, up)), [0.0, 0.0, 1.0], 0.6);
        bodies.solve(1e-8);
    }
}

/// Two narrow soles of four corners each, on one body that hits the ground with them, without a
/// first guess: 24 rows of rank 6. Of a hundred impacts at most two are left with a residual.
#[test]
fn two_soles() {
    let mut random = Random(11);
    let mut missed = Vec::new();
    for case in 0..100 {
        let mut velocities = [0.0; 6];
        velocities.fill_with(|| 0.3 * random.next());
        velocities[5] -= 0.3;
        let mut bodies = Bodies::new(&[30.0], 0.5, &velocities);
        for foot in [0.1, -0.1] {
            for corner in [[0.12, 0.03], [0.12, -0.03], [-0.05, 0.03], [-0.05, -0.03]] {
                let arm = [corner[0], foot + corner[1], -0.7];
                bodies.contact((0, arm), None, [0.0, 0.0, 1.0], [0.0, 0.3, 0.9][case % 3]);
            }
        }
        let (_, residual) = bodies.try_solve();
        missed.extend(Some(residual).filter(|&residual| residual > 1e-8));
    }
    assert!(missed.len() <= 2 && missed.iter().all(|&residual| residual < 0.05), "{missed:?}");
}

/// A planar robot cannot move out of its plane, and a cart cannot move along the normal: nothing
/// becomes infinite.
#[test]
fn directions_without_motion() {
    let planar = vec![vec![1.0, 0.0, 0.2], vec![0.0, 0.0, 0.0], vec![0.2, 0.0, 0.7]];
    let (p, residual) = solve(&planar, &vec![2.0, 0.0, -1.0], &[0.5], &[]);
    assert!(residual.contacts < 1e-9 && p[1].abs() < 1e-6, "{p:?} {residual:?}");
    // It slides: p_x = -0.5 p_n and 0.2 p_x + 0.7 p_n = 1.
    assert!((p[2] - 1.0 / 0.6).abs() < 1e-9 && (p[0] + 0.5 * p[2]).abs() < 1e-9, "{p:?}");
    let cart = vec![vec![1.0, 0.0, 0.0], vec![0.0, 0.0, 0.0], vec![0.0, 0.0, 0.0]];
    let (p, residual) = solve(&cart, &vec![2.0, 0.0, -1.0], &[0.5], &[]);
    assert_eq!((p, residual.contacts), (vec![0.0; 3], 0.0));
}

/// A chain of joints at their lower stops that move on; each joint pushes its neighbours on.
#[test]
fn coupled_stops() {
    const N: usize = 12;
    // The inverse mass matrix of masses between springs: its condition is that of a fine mesh.
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    };
    let a: Vec<Vec<f64>> = (0..N).map(|i| (0..N).map(|j| entry(i, j)).collect()).collect();
    let b: Vec<f64> = (0..N).map(|i| if i % 3 == 0 { 0.5 } else { -1.0 }).collect();
    let (p, residual) = solve(&a, &b, &[], &[[0.0, f64::INFINITY]; N]);
    assert!(residual.stops < 1e-9, "{residual:?}");
    for (k, row) in a.iter().enumerate() {
        let u = b[k] + dot(row, &p);
        assert!(
            p[k] >= 0.0 && u >= -1e-9 && (p[k] == 0.0 || u <= 1e-9),
            "{k}: {} N m s, {u} rad/s",
            p[k]
        );
    }
    // From above, and with a limit on both sides.
    let range = [[-0.2, 0.2]; N];
    let (p, residual) = solve(&a, &b, &[], &range);
    assert!(residual.stops < 1e-9, "{residual:?}");
    for (k, row) in a.iter().enumerate() {
        let u = b[k] + dot(row, &p);
        assert!(u.abs() <= 0.2 + 1e-9, "{u} rad/s");
        assert!(p[k] <= 0.0 || u <= -0.2 + 1e-9, "{k}: {} N m s, {u} rad/s", p[k]);
        assert!(p[k] >= 0.0 || u >= 0.2 - 1e-9, "{k}: {} N m s, {u} rad/s", p[k]);
    }
}

/// The state of a contact follows from its impulse.
#[test]
fn modes() {
    let mode = |friction: f64, p: [f64; 3]| Contact::new(friction).mode(p);
    assert_eq!(mode(0.5, [0.0; 3]), ContactMode::Open);
    assert_eq!(mode(0.5, [0.1, 0.2, 1.0]), ContactMode::Stick);
    assert_eq!(mode(0.5, [0.3, -0.4, 1.0]), ContactMode::Slip);
    assert_eq!(mode(0.0, [0.0, 0.0, 1.0]), ContactMode::Slip);
}

/// Two narrow soles on light feet, which turn about the joints of their ankles beneath a heavy
/// body: their points move by far unlike masses, and are redundant. Of 200 impacts without a first
/// guess at most 4 are left with a residual.
#[test]
fn soles_on_light_feet() {
    let mut random = Random(23);
    let mut missed = 0;
    for _ in 0..200 {
        // The body, then a roll and a pitch of each ankle.
        let inverse: [f64; 10] = from_fn(|k| match k {
            0..3 => 0.4,
            3..6 => 0.03,
            _ => [1500.0, 300.0][k % 2],
        });
        let velocities: [f64; 10] = from_fn(|k| match k {
            0..6 => 0.3 * random.next(),
            _ => 2.0 * random.next(),
        });
        let mut rows = Vec::new();
        for (foot, y) in [0.1, -0.1].into_iter().enumerate() {
            for [x, side] in [[0.12, 0.03], [0.12, -0.03], [-0.05, 0.03], [-0.05, -0.03]] {
                let (arm, of_ankle) = ([x, y + side, -0.7], [x, side, -0.035]);
                for (k, axis) in
                    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().enumerate()
                {
                    let (turn, own) = (cross(arm, axis), cross(of_ankle, axis));
                    let mut row =
                        vec![turn[0], turn[1], turn[2], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
                    row[3 + k] = 1.0;
                    (row[6 + 2 * foot], row[7 + 2 * foot]) = (own[0], own[1]);
                    rows.push(row);
                }
            }
        }
        let entry = |a: &[f64], b: &[f64]| (0..10).map(|v| a[v] * inverse[v] * b[v]).sum::<f64>();
        let a: Vec<Vec<f64>> =
            rows.iter().map(|row| rows.iter().map(|other| entry(row, other)).collect()).collect();
        let b: Vec<f64> = rows.iter().map(|row| dot(row, &velocities)).collect();
        let (p, residual) = solve(&a, &b, &[0.8; 8], &[]);
        check(&a, &b, &[0.8; 8], &p, residual.contacts.max(1e-9));
        missed += usize::from(residual.contacts > 1e-8);
    }
    assert!(missed <= 4, "{missed}");
}
