//! Functions that are written once for all robots and all scalars, through the trait.

use std::cell::Cell;
use std::fmt::Debug;
use std::iter::zip;
use std::ops::{Add, Div, Mul, Neg, Sub};

use modyn::spatial::Pose;
use modyn::{Array, Factorization, Nalgebra, OperationCount, Robot, Scalar, functions};
use modyn_fleet::ROBOTS;
use modyn_fleet::robots::{
    Arm6, Arm6Link, GoldenPandaFingers, GoldenUr5, Gripper, GripperLink, Quadruped, QuadrupedLink,
    Tree9_5, Zoo7423_7, Zoo7423_7Link,
};
#[cfg(feature = "whole")]
use modyn_fleet::robots::{Tree10_6, Tree15_12, Tree15_12Link};
use modyn_tests::close::assert_close;
use modyn_tests::dual::Tangent;
use modyn_tests::fleet::Source;
use modyn_tests::golden::Golden;
use modyn_tests::random::{State, state};
use modyn_tests::results;
use modyn_tests::values::{self, FromNumbers, array, columns, of_state};
use nalgebra::{DMatrix, Matrix4, SMatrix, SVector};

/// Returns a random state of the fleet's robot with this name.
fn state_of(name: &str, seed: u64) -> State {
    let robot = ROBOTS.iter().find(|robot| robot.name() == name);
    state(seed, &robot.unwrap_or_else(|| panic!("no {name}")).spec.model())
}

/// Returns the numbers in any scalar, as a vector of a robot.
fn vector<T: Scalar, A: Array<T>>(numbers: &[f64]) -> A {
    let numbers: Vec<T> = numbers.iter().map(|&x| T::from_f64(x)).collect();
    array(&numbers)
}

/// A scalar that converts to `f64`.
trait Real: Scalar {
    fn to_f64(self) -> f64;
}

impl Real for f64 {
    fn to_f64(self) -> f64 {
        self
    }
}

impl Real for f32 {
    fn to_f64(self) -> f64 {
        self.into()
    }
}

fn numbers<T: Real>(array: &impl Array<T>) -> Vec<f64> {
    array.as_ref().iter().map(|x| x.to_f64()).collect()
}

/// The configuration and the velocities of a robot.
struct Motion<R: Robot, T: Scalar> {
    q: R::Q<T>,
    qd: R::V<T>,
}

impl<R: Robot, T: Scalar> Clone for Motion<R, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: Robot, T: Scalar> Copy for Motion<R, T> {}

impl<R: Robot, T: Scalar> Motion<R, T> {
    fn new(q: &[f64], qd: &[f64]) -> Self {
        Self { q: vector(q), qd: vector(qd) }
    }

    /// Returns the state after a time `h` at these velocities and accelerations.
    fn moved(&self, rates: &Rates<R, T>, h: T) -> Self {
        let Self { q, qd } = self;
        let Rates { qd: velocity, qdd } = rates;
        Self {
            q: Array::from_fn(|i| q.as_ref()[i] + h * velocity.as_ref()[i]),
            qd: Array::from_fn(|i| qd.as_ref()[i] + h * qdd.as_ref()[i]),
        }
    }

    fn energy(&self) -> T
    where
        R: functions::KineticEnergy + functions::PotentialEnergy,
    {
        R::kinetic_energy(&self.q, &self.qd) + R::potential_energy(&self.q)
    }
}

struct Rates<R: Robot, T: Scalar> {
    qd: R::V<T>,
    qdd: R::V<T>,
}

/// Returns the state after one Runge-Kutta step under the torques that `torques` returns.
fn rk4_step<R: Robot + functions::Defaults, T: Scalar>(
    motion: &Motion<R, T>,
    torques: impl Fn(&Motion<R, T>) -> R::V<T>,
    h: T,
) -> Motion<R, T> {
    let rates = |at: &Motion<R, T>| Rates::<R, T> {
        qd: at.qd,
        qdd: R::forward_dynamics(&at.q, &at.qd, &torques(at)),
    };
    let half = T::from_f64(0.5) * h;
    let a = rates(motion);
    let b = rates(&motion.moved(&a, half));
    let c = rates(&motion.moved(&b, half));
    let d = rates(&motion.moved(&c, h));
    let mean = |[a, b, c, d]: [&R::V<T>; 4]| {
        let sixth = T::from_f64(1.0 / 6.0);
        Array::from_fn(|i| {
            let between = b.as_ref()[i] + c.as_ref()[i];
            (a.as_ref()[i] + between + between + d.as_ref()[i]) * sixth
        })
    };
    let rates = Rates {
        qd: mean([&a.qd, &b.qd, &c.qd, &d.qd]),
        qdd: mean([&a.qdd, &b.qdd, &c.qdd, &d.qdd]),
    };
    motion.moved(&rates, h)
}

/// Returns the acceleration of a critically damped spring that leads to rest at `goal`.
fn wanted<R: Robot, T: Scalar>(motion: &Motion<R, T>, goal: &R::Q<T>) -> R::V<T> {
    let (stiffness, damping) = (T::from_f64(100.0), T::from_f64(20.0));
    Array::from_fn(|i| {
        stiffness * (goal.as_ref()[i] - motion.q.as_ref()[i]) - damping * motion.qd.as_ref()[i]
    })
}

/// Returns the torques for that acceleration.
fn computed_torque<R: Robot + functions::Defaults, T: Scalar>(
    motion: &Motion<R, T>,
    goal: &R::Q<T>,
) -> R::V<T> {
    R::inverse_dynamics(&motion.q, &motion.qd, &wanted(motion, goal))
}

/// Runs `check::<Robot, Scalar>(name, tolerance)` for two robots and two scalars.
macro_rules! for_two_robots {
    ($check:ident) => {
        $check::<Gripper, f64>("gripper", 1e-11);
        $check::<Arm6, f64>("arm6", 1e-11);
        $check::<Gripper, f32>("gripper", 1e-3);
        $check::<Arm6, f32>("arm6", 1e-3);
    };
}

#[test]
fn computed_torque_gives_the_acceleration_it_wants() {
    fn check<R: Robot + functions::Defaults, T: Real>(name: &str, tolerance: f64) {
        for seed in 0..5 {
            let State { q, qd, qdd: goal, .. } = state_of(name, seed);
            let (motion, goal) = (Motion::<R, T>::new(&q, &qd), vector(&goal));
            let tau = computed_torque::<R, T>(&motion, &goal);
            let qdd = R::forward_dynamics(&motion.q, &motion.qd, &tau);
            let expected = numbers(&wanted::<R, T>(&motion, &goal));
            assert_close(name, &numbers(&qdd), &expected, tolerance);
        }
    }
    for_two_robots!(check);
}

#[test]
fn computed_torque_brings_a_robot_to_its_goal() {
    fn check<R: Robot + functions::Defaults, T: Real>(name: &str, tolerance: f64) {
        let State { q, qd, qdd: goal, .. } = state_of(name, 1);
        let target = vector(&goal);
        let mut motion = Motion::<R, T>::new(&q, &qd);
        for _ in 0..1000 {
            motion = rk4_step(&motion, |at| computed_torque(at, &target), T::from_f64(5e-3));
        }
        assert_close(name, &numbers(&motion.q), &goal, tolerance);
        assert_close(name, &numbers(&motion.qd), &vec![0.0; R::NV], tolerance);
    }
    for_two_robots!(check);
}

#[test]
fn an_unforced_motion_keeps_its_energy() {
    /// Returns the relative change of energy in a quarter of a second.
    fn drift<R: Robot + functions::Defaults, T: Real>(name: &str, steps: u32) -> f64 {
        let State { q, qd, .. } = state_of(name, 2);
        let start = Motion::<R, T>::new(&q, &qd);
        let h = T::from_f64(0.25 / f64::from(steps));
        let free = array::<T, R::V<T>>(&vec![T::zero(); R::NV]);
        let end = (0..steps).fold(start, |motion, _| rk4_step(&motion, |_| free, h));
        assert!(zip(numbers(&start.q), numbers(&end.q)).any(|(a, b)| (a - b).abs() > 0.1));
        let energy = start.energy().to_f64();
        (end.energy().to_f64() - energy).abs() / energy.abs().max(1.0)
    }
    fn check<R: Robot + functions::Defaults>(name: &str) {
        let (coarse, fine) = (drift::<R, f64>(name, 200), drift::<R, f64>(name, 400));
        // The method is of fourth order; rounding limits the accuracy.
        assert!(fine < coarse / 10.0 || fine < 1e-13, "{name}: {coarse:e}, then {fine:e}");
        assert!(fine < 1e-7, "{name}: {fine:e}");
        let single = drift::<R, f32>(name, 400);
        assert!(single < 1e-4, "{name}: {single:e}");
    }
    check::<Gripper>("gripper");
    check::<Arm6>("arm6");
}

#[test]
fn nalgebra_calls_are_the_array_calls() {
    fn check<R, const N: usize, const LINKS: usize>(name: &str)
    where
        R: Robot<
                Q<f64> = [f64; N],
                V<f64> = [f64; N],
                M<f64> = [[f64; N]; N],
                PerLink<Pose<f64>> = [Pose<f64>; LINKS],
            > + functions::Defaults,
    {
        for seed in 0..3 {
            let State { q, qd, qdd, tau } = state_of(name, seed);
            let [q, qd, qdd, tau] = [q, qd, qdd, tau].map(|x| SVector::from_column_slice(&x));
            let arrays: [[f64; N]; 4] = [q, qd, qdd, tau].map(Into::into);
            let [q0, qd0, qdd0, tau0] = &arrays;
            let same = |what, found: SVector<f64, N>, expected: [f64; N]| {
                assert_eq!(found, SVector::from(expected), "{name}: {what}");
            };
            type Of<R> = Nalgebra<R>;
            let found = Of::<R>::forward_dynamics(&q, &qd, &tau);
            same("forward dynamics", found, R::forward_dynamics::<f64>(q0, qd0, tau0));
            let found = Of::<R>::inverse_dynamics(&q, &qd, &qdd);
            same("inverse dynamics", found, R::inverse_dynamics::<f64>(q0, qd0, qdd0));
            let found = Of::<R>::bias_forces(&q, &qd);
            same("bias forces", found, R::bias_forces::<f64>(q0, qd0));
            same("gravity", Of::<R>::gravity_torques(&q), R::gravity_torques::<f64>(q0));
            let brge = R::brge::<f64>(q0);
            same("solve", Of::<R>::solve(&q, &tau), brge.solve(tau0));
            let energies = [Of::<R>::kinetic_energy(&q, &qd), Of::<R>::potential_energy(&q)];
            let expected: [f64; 2] = [R::kinetic_energy(q0, qd0), R::potential_energy(q0)];
            assert_eq!(energies, expected, "{name}");

            let rates = Of::<R>::velocity_to_qdot(&q, &qd);
            same("rates of the coordinates", rates, R::velocity_to_qdot::<f64>(q0, qd0));
            same(
                "coordinates",
                Of::<R>::normalize_configuration(&q),
                R::normalize_configuration::<f64>(q0),
            );
            let uniform = || {
                let mut number = seed as f64 / 3.0;
                move || {
                    number = (number + 0.618).fract();
                    number
                }
            };
            same(
                "random",
                Of::<R>::random_configuration(uniform()),
                R::random_configuration::<f64>(uniform()),
            );

            // Both sides are by columns; the mass matrix is symmetric, U is not.
            let m = Of::<R>::mass_matrix(&q);
            assert_eq!(m.as_slice(), R::mass_matrix::<f64>(q0).concat(), "{name}");
            let [u, d]: [SMatrix<f64, N, N>; 2] =
                [Of::<R>::brge(&q).u(), Of::<R>::brge(&q).d()].map(Into::into);
            assert_close(name, (u * d * u.transpose()).as_slice(), m.as_slice(), 1e-12);
            assert_eq!(u[(1, 0)], 0.0, "{name}: U is upper triangular");

            let poses: [_; LINKS] = Of::<R>::link_poses(&q);
            for (found, Pose { rotation: [x, y, z], translation: p }) in
                zip(poses, R::link_poses::<f64>(q0))
            {
                let row = |r: [f64; 3], p| [r[0], r[1], r[2], p];
                let rows = [row(x, p[0]), row(y, p[1]), row(z, p[2]), [0.0, 0.0, 0.0, 1.0]];
                let expected = Matrix4::from(rows).transpose();
                assert_close(name, found.to_matrix().as_slice(), expected.as_slice(), 1e-14);
            }
        }
    }
    check::<Gripper, 4, 5>("gripper");
    check::<Quadruped, 12, { Quadruped::LINK_NAMES.len() }>("quadruped");
}

/// A number and its derivative by one variable.
type Dual = Tangent<f64>;

/// Returns numbers whose derivative is 1 for entry `by` and 0 for all others; all are 0 if there is no such entry.
fn varied<A: Array<Dual>>(x: &[f64], by: usize) -> A {
    A::from_fn(|i| Dual { x: x[i], dx: if i == by { 1.0 } else { 0.0 } })
}

fn slopes(array: &impl Array<Dual>) -> Vec<f64> {
    array.as_ref().iter().map(|x| x.dx).collect()
}

/// Returns the Jacobian by columns: column j has the derivatives by number j of `n`.
fn jacobian(n: usize, column: impl Fn(usize) -> Vec<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(n, n, &(0..n).flat_map(column).collect::<Vec<_>>())
}

#[test]
fn dual_numbers_give_the_derivatives_of_the_reference_data() {
    fn check<R: Robot + functions::Defaults>(name: &str) {
        let constant = R::NV;
        let states = Golden::load(name).states;
        assert!(!states.is_empty());
        for state in states {
            let vector = |name| state.vector(name);
            let (q, v, a, tau) = (&state.q(), &vector("v"), &vector("a"), &vector("tau"));
            let forward = |[i, j, k]: [usize; 3]| {
                slopes(&R::forward_dynamics(&varied(q, i), &varied(v, j), &varied(tau, k)))
            };
            let inverse = |[i, j]: [usize; 2]| {
                slopes(&R::inverse_dynamics(&varied(q, i), &varied(v, j), &varied(a, constant)))
            };
            let close = |what, found: DMatrix<f64>| {
                let expected = state.matrix(what);
                assert_close(what, found.as_slice(), expected.as_slice(), 1e-9);
            };
            let n = R::NV;
            close("dqdd_dq", jacobian(n, |i| forward([i, constant, constant])));
            close("dqdd_dv", jacobian(n, |i| forward([constant, i, constant])));
            close("dqdd_dtau", jacobian(n, |i| forward([constant, constant, i])));
            close("dtau_dq", jacobian(n, |i| inverse([i, constant])));
            close("dtau_dv", jacobian(n, |i| inverse([constant, i])));
        }
    }
    check::<GoldenUr5>("ur5");
    check::<GoldenPandaFingers>("panda_fingers");
}

#[test]
fn dual_numbers_are_near_finite_differences() {
    type R = Tree9_5;
    const N: usize = R::NV;
    let State { q, qd, tau, .. } = state_of("tree9_5", 3);
    let exact = jacobian(N, |i| {
        let (q, qd, tau) = (varied(&q, i), varied(&qd, N), varied(&tau, N));
        slopes(&<R as Robot>::forward_dynamics(&q, &qd, &tau))
    });
    let differences = jacobian(N, |i| {
        let at = |h: f64| {
            let mut q: [f64; N] = array(&q);
            q[i] += h;
            R::forward_dynamics(&q, &array(&qd), &array(&tau))
        };
        let h = 1e-5;
        zip(at(h), at(-h)).map(|(above, below)| (above - below) / (2.0 * h)).collect()
    });
    assert!(exact.norm() > 1.0);
    assert_close("dqdd/dq", exact.as_slice(), differences.as_slice(), 1e-7);

    // Jacobi's formula: the derivative of a matrix's log-determinant is the trace of its inverse times its derivative.
    for i in 0..N {
        let q = varied(&q, i);
        let [m, inverse] = [<R as Robot>::mass_matrix(&q), <R as Robot>::brge(&q).inverse()];
        let matrix = |part: fn(&Dual) -> f64, m: &[[Dual; N]; N]| {
            DMatrix::from_column_slice(N, N, &columns(m).iter().map(part).collect::<Vec<_>>())
        };
        let expected = (matrix(|x| x.x, &inverse) * matrix(|x| x.dx, &m)).trace();
        let found = <R as Robot>::brge(&q).log_determinant().dx;
        assert_close("log determinant", &[found], &[expected], 1e-11);
    }
}

#[test]
fn torques_are_the_derivatives_of_the_energies() {
    fn check<R: Robot + functions::Defaults>(name: &str) {
        let State { q, qd, .. } = state_of(name, 4);
        let constant = R::NV;
        let gravity: Vec<f64> =
            (0..R::NV).map(|i| R::potential_energy(&varied(&q, i)).dx).collect();
        let expected = R::gravity_torques(&vector(&q));
        assert_close(name, &numbers::<f64>(&expected), &gravity, 1e-11);
        let momentum: Vec<f64> = (0..R::NV)
            .map(|i| R::kinetic_energy(&varied(&q, constant), &varied(&qd, i)).dx)
            .collect();
        let m = columns(&R::mass_matrix::<f64>(&vector(&q)));
        assert_close(name, &modyn_tests::dense::times(&m, &qd), &momentum, 1e-11);
    }
    check::<Gripper>("gripper");
    check::<Arm6>("arm6");
    check::<Tree9_5>("tree9_5");
    #[cfg(feature = "whole")]
    check::<Tree10_6>("tree10_6");
}

/// A number that counts the operations on it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Counted(f64);

thread_local! {
    static COUNT: Cell<OperationCount> = const {
        Cell::new(OperationCount {
            multiplications: 0,
            additions: 0,
            divisions: 0,
            sin_cos: 0,
            others: 0,
        })
    };
}

impl Counted {
    fn after(value: f64, counter: fn(&mut OperationCount) -> &mut usize) -> Self {
        let mut counts = COUNT.get();
        *counter(&mut counts) += 1;
        COUNT.set(counts);
        Self(value)
    }
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::after(self.0 + other.0, |count| &mut count.additions)
    }
}

impl Sub for Counted {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::after(self.0 - other.0, |count| &mut count.additions)
    }
}

impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::after(self.0 * other.0, |count| &mut count.multiplications)
    }
}

impl Div for Counted {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        Self::after(self.0 / other.0, |count| &mut count.divisions)
    }
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Scalar for Counted {
    fn from_f64(value: f64) -> Self {
        Self(value)
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = Scalar::sin_cos(self.0);
        (Self::after(sin, |count| &mut count.sin_cos), Self(cos))
    }

    fn atan2(self, x: Self) -> Self {
        Self::after(Scalar::atan2(self.0, x.0), |count| &mut count.others)
    }

    fn sqrt(self) -> Self {
        Self::after(Scalar::sqrt(self.0), |count| &mut count.others)
    }

    fn ln(self) -> Self {
        Self::after(Scalar::ln(self.0), |count| &mut count.others)
    }

    fn abs(self) -> Self {
        Self::after(self.0.abs(), |count| &mut count.others)
    }

    fn max(self, other: Self) -> Self {
        Self::after(self.0.max(other.0), |count| &mut count.others)
    }

    fn select_nonnegative(self, then: Self, otherwise: Self) -> Self {
        Self::after(Scalar::select_nonnegative(self.0, then.0, otherwise.0), |count| {
            &mut count.others
        })
    }
}

impl FromNumbers for Counted {
    const COUNT: usize = 1;

    fn from_numbers(numbers: &[f64]) -> Self {
        Self(numbers[0])
    }
}

#[test]
fn counted_operations_equal_the_announced_ones() {
    macro_rules! check {
        ($source:expr, $robot:ident, $link:ident) => {{
            let robot = ROBOTS.iter().find(|robot| robot.spec.source == $source).expect("compiled");
            let (model, state) = (robot.spec.model(), state_of(&robot.name(), 5));
            let arguments = of_state(&model, &state);
            COUNT.set(OperationCount::default());
            let count = |_: &dyn Debug| [COUNT.take()];
            let counts =
                results!(each count; of_trait $robot, Counted, default, &arguments, &$link::ALL);
            assert_eq!(counts.len(), robot.operations.len());
            for (function, counts) in counts {
                let name = function.name();
                let found = counts.iter().max_by_key(|count| count.total()).expect("a call");
                let (_, announced) =
                    robot.operations.iter().find(|(other, _)| *other == name).expect("announced");
                assert_eq!(found, announced, "{}: `{name}`", robot.name());
            }
            // Counting does not change the results.
            let found = results!(
                each values::numbers::<f64>;
                of_trait $robot, Counted, default, &arguments, &$link::ALL
            );
            let expected = (robot.double)(&arguments);
            for (function, found) in found {
                assert_close(&robot.name(), &found, expected.of(function), 1e-12);
            }
        }};
    }
    check!(Source::Described("gripper"), Gripper, GripperLink);
    check!(Source::Described("arm6"), Arm6, Arm6Link);
    check!(Source::Described("quadruped"), Quadruped, QuadrupedLink);
    #[cfg(feature = "whole")]
    check!(Source::Random(15, 12), Tree15_12, Tree15_12Link);
    check!(Source::Zoo(7423, 7), Zoo7423_7, Zoo7423_7Link);
}
