//! Batches of functions of closed loops and contacts give each state the result of the function of one state, for random
//! sets of active contacts: at every SIMD level of this machine, and bit for bit where products are not fused.

use modyn::spatial::{Pose, Twist, Vector3, Wrench};
use modyn::{ConstraintSettings, ContactTarget, Robot, Scalar};
use modyn_tests::lanes::{columns, numbers, on_every_level, slices, vectors};
use modyn_tests::plain::{Plain, plain};

macro_rules! robots {
    ($($module:ident: $file:literal, $scalar:ident $(, $key:ident = $choice:tt)*;)*) => {$(
        mod $module {
            modyn::modyn! {
                pub Machine = $file,
                scalar = $scalar,
                functions = [
                    random_configuration,
                    constrained_forward_dynamics, constrained_forward_dynamics_batch,
                    impact_dynamics, impact_dynamics_batch,
                    constrained_inverse_dynamics, constrained_inverse_dynamics_batch,
                    constraint_residual, constraint_residual_batch,
                    project_constraints, project_constraints_batch,
                    constraint_jacobian, constraint_jacobian_batch,
                    constraint_jacobian_dot_qd, constraint_jacobian_dot_qd_batch,
                    operational_space_inertia, operational_space_inertia_batch
                ]
                $(, $key = $choice)*
            }
        }
    )*};
}

robots! {
    walker: "../../../robots/quadruped.urdf", f64, base = floating, contacts = [
        "foot": point("hind_left_foot", [0, 0, 0], [0.2, 0.1, -0.4]),
        "sole": surface("front_left_foot", [0.02, 0.01, -0.01], [0.5, -0.3, 0.7]),
        "heel": point("front_left_foot", [-0.1, 0.02, 0.03], [0, 0, 0]),
    ];
    zoo: "../../golden/joints_spherical.urdf", f64, contacts = [
        "hand": point("link4", [0.1, -0.2, 0.3], [0.2, 0.1, -0.4]),
        "elbow": point("tool3", [0.1, 0.2, 0.3], [0, 0, 0]),
        "plate": surface("tool1", [0.2, 0.1, -0.1], [0.5, -0.3, 0.7]),
    ];
    single: "../../../robots/arm6.urdf", f32, joint_friction = none, contacts = [
        "hand": point("tool", [0.1, -0.2, 0.3], [0.2, 0.1, -0.4]),
    ];
    linkage: "../../../robots/four_bar.urdf", f64, runtime_gravity = true;
    leg: "../../../robots/five_bar.urdf", f64, base = floating, contacts = [
        "foot": point("left_forearm", [0.4, 0, 0], [0, 0, 0]),
    ];
}

/// All numbers of a value, in order.
trait Flat {
    fn flat(&self, numbers: &mut Vec<f64>);
}

/// Returns slices for all numbers of a value.
fn take<'a, T: 'a, X: Take<'a, T>>(slices: &mut impl Iterator<Item = &'a mut [T]>) -> X {
    X::take(slices)
}

/// Slices for all numbers of a value.
trait Take<'a, T: 'a> {
    fn take(slices: &mut impl Iterator<Item = &'a mut [T]>) -> Self;
}

impl<'a, T: 'a> Take<'a, T> for &'a mut [T] {
    fn take(slices: &mut impl Iterator<Item = &'a mut [T]>) -> Self {
        slices.next().expect("a slice")
    }
}

impl<'a, T: 'a, X: Take<'a, T>, const N: usize> Take<'a, T> for [X; N] {
    fn take(slices: &mut impl Iterator<Item = &'a mut [T]>) -> Self {
        std::array::from_fn(|_| X::take(slices))
    }
}

macro_rules! numbers {
    ($($Number:ty)*) => {$(
        impl Flat for $Number {
            fn flat(&self, numbers: &mut Vec<f64>) {
                numbers.push((*self).into());
            }
        }

        impl Flat for Plain<$Number> {
            fn flat(&self, numbers: &mut Vec<f64>) {
                self.0.flat(numbers);
            }
        }
    )*};
}

numbers!(f64 f32);

impl<X: Flat, const N: usize> Flat for [X; N] {
    fn flat(&self, numbers: &mut Vec<f64>) {
        self.iter().for_each(|x| x.flat(numbers));
    }
}

macro_rules! fields {
    ($($Type:ident<$($X:ident),*> { $($field:tt: $Field:ty),* })*) => {$(
        impl<$($X: Flat),*> Flat for $Type<$($X),*> {
            fn flat(&self, numbers: &mut Vec<f64>) {
                $(self.$field.flat(numbers);)*
            }
        }
    )*};
    (take $($Type:ident { $($field:tt: $Field:ty),* })*) => {$(
        impl<'a, T: 'a, X: Take<'a, T>> Take<'a, T> for $Type<X> {
            fn take(slices: &mut impl Iterator<Item = &'a mut [T]>) -> Self {
                Self { $($field: <$Field>::take(slices)),* }
            }
        }
    )*};
}

use modyn::{
    ConstrainedForwardDynamics, ConstrainedForwardDynamicsDerivatives, ConstrainedInverseDynamics,
    ConstraintProjection, ConstraintResidual, ImpactDynamics, OperationalSpaceInertia,
};

fields! {
    Vector3<X> { 0: [X; 3] }
    Twist<X> { linear: Vector3<X>, angular: Vector3<X> }
    Wrench<X> { force: Vector3<X>, moment: Vector3<X> }
    ConstrainedForwardDynamics<V, W, R, X> { qdd: V, wrenches: W, residuals: R, rank: X }
    ConstrainedForwardDynamicsDerivatives<V, W, M, D, X> {
        qdd: V, wrenches: W, dqdd_dq: M, dqdd_dqd: M, dqdd_dtau: M, dwrenches_dq: D, dwrenches_dqd: D, dwrenches_dtau: D, rank: X
    }
    ImpactDynamics<V, W, X> { qd: V, impulses: W, rank: X }
    ConstrainedInverseDynamics<V, W, X> { tau: V, wrenches: W, rank: X }
    ConstraintResidual<R> { displacements: R, velocities: R }
    ConstraintProjection<V, X> { step_q: V, step_qd: V, rank: X }
    OperationalSpaceInertia<M, X> { delassus: M, inertia: M, rank: X }
}

fields! { take
    Vector3 { 0: [X; 3] }
    Twist { linear: Vector3<X>, angular: Vector3<X> }
    Wrench { force: Vector3<X>, moment: Vector3<X> }
}

/// The largest difference between fused and unfused products, relative to the largest number of a result, for states in
/// which J I^-1 J^T is well conditioned.
fn fused_error<T: Flat + Scalar>() -> f64 {
    if std::mem::size_of::<T>() == 4 { 5e-3 } else { 1e-9 }
}

/// Returns all numbers of a value.
fn flat(value: &impl Flat) -> Vec<f64> {
    let mut numbers = Vec::new();
    value.flat(&mut numbers);
    numbers
}

/// Returns settings with a target in general position that moves, compliance, stabilization and restitution.
fn settings<const N: usize>() -> ConstraintSettings<f64, [ContactTarget<f64>; N]> {
    let rotation = |k: usize| {
        let ((sin, cos), (s, c)) = (0.4f64.sin_cos(), (0.3 + k as f64).sin_cos());
        [[cos, -sin * c, sin * s], [sin, cos * c, -cos * s], [0.0, s, c]]
    };
    let target = |k: usize| ContactTarget {
        pose: Pose { rotation: rotation(k), translation: [0.1, -0.2, 0.3] },
        velocity: Twist {
            angular: Vector3([0.1, -0.3, 0.2]),
            linear: Vector3([0.2, 0.1, -0.1 * k as f64]),
        },
        tangential: 0.4,
        alpha: 5.0,
        beta: 7.0 + k as f64,
        compliance: 0.02 * (1 + k) as f64,
        restitution: 0.3,
        weight: 1.0 + 0.5 * k as f64,
    };
    let targets = std::array::from_fn(target);
    ConstraintSettings { alpha: 3.0, beta: 4.0, tolerance: 1e-7, rounding: 1e-7, targets }
}

/// Returns settings in another scalar.
fn settings_in<T: Copy, const N: usize>(
    settings: &ConstraintSettings<f64, [ContactTarget<f64>; N]>,
    of: impl Fn(f64) -> T,
) -> ConstraintSettings<T, [ContactTarget<T>; N]> {
    let targets = settings.targets.map(|t| ContactTarget::from_numbers(t.numbers().map(&of)));
    ConstraintSettings::from_numbers(settings.numbers().map(&of), targets)
}

#[track_caller]
fn same(found: &[Vec<f64>], expected: &[Vec<f64>], bound: f64, what: &str) {
    assert_eq!(found.len(), expected.len());
    for (state, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert_eq!(found.len(), expected.len());
        let largest = expected.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        for (a, b) in found.iter().zip(expected) {
            let within = (a - b).abs() <= bound * largest;
            assert!(within, "{what} of state {state}: {found:?} {expected:?}");
        }
    }
}

/// Compares all batch functions, with columns and with arrays of states, with the functions of one state.
/// `$of_bools` makes a set of contacts.
macro_rules! robot {
    ($module:ident, $T:ty, $contacts:literal, $of_bools:expr) => {{
        type Name = $module::Machine;
        type P = Plain<$T>;
        const NV: usize = <Name as Robot>::NV;
        let settings = settings_in(&settings::<$contacts>(), |x| x as $T);
        let plain_settings = settings_in(&self::settings::<$contacts>(), |x| Plain(x as $T));
        for states in [0, 1, 3, 7, 16, 17, 33] {
            let mut uniform = numbers();
            let q: Vec<_> =
                (0..states).map(|_| Name::random_configuration(|| (0.5 + 0.5 * uniform()) as $T)).collect();
            let [qd, tau, qdd] = [2.0, 5.0, 3.0].map(|size| -> Vec<[$T; NV]> { vectors(states, size) });
            let masks: Vec<[bool; $contacts]> =
                (0..states).map(|_| std::array::from_fn(|_| uniform() > -0.3)).collect();
            let sets: Vec<<Name as Robot>::Contacts> = masks.iter().map($of_bools).collect();
            let (qs, qds, taus, qdds) = (columns(&q), columns(&qd), columns(&tau), columns(&qdd));
            let (qs, qds, taus, qdds) = (slices(&qs), slices(&qds), slices(&taus), slices(&qdds));
            let flags = columns(&masks);
            let flags = slices(&flags);
            let (p, s) = (&plain_settings, &settings);
            on_every_level(|fused| {
                let bound = if fused { fused_error::<$T>() } else { 0.0 };
                macro_rules! compare {
                    (
                        $name:literal: $empty:expr; |$i:ident| $one:expr;
                        |$slices:ident| $batch:expr; |$results:ident| $each:expr
                    ) => {{
                        let one = |$i: usize| flat(&$one);
                        let expected: Vec<Vec<f64>> = (0..states).map(one).collect();
                        let empty = $empty;
                        let mut found = vec![vec![7.0 as $T; states]; flat(&empty).len()];
                        let $slices = &mut found.iter_mut().map(|column| &mut column[..]);
                        $batch.expect("sizes");
                        assert!($slices.next().is_none());
                        let by_state = |i: usize| found.iter().map(|c| f64::from(c[i])).collect();
                        let found: Vec<Vec<f64>> = (0..states).map(by_state).collect();
                        same(&found, &expected, bound, concat!($name, ", columns"));
                        let mut found = vec![empty; states];
                        let $results = &mut found[..];
                        $each.expect("sizes");
                        let found: Vec<Vec<f64>> = found.iter().map(flat).collect();
                        same(&found, &expected, bound, concat!($name, ", states"));
                    }};
                }
                let (q0, v0) = (&Name::NEUTRAL, &[0.0; NV]);
                let none = <<Name as Robot>::Contacts as modyn::ContactSet>::NONE;
                let at = |i: usize| (plain(&q[i]), plain(&qd[i]), plain(&tau[i]), plain(&qdd[i]));
                compare!(
                    "constrained_forward_dynamics":
                    Name::constrained_forward_dynamics(q0, v0, v0, none, s);
                    |i| { let (q, v, x, _) = at(i); <Name as Robot>::constrained_forward_dynamics::<P>(&q, &v, &x, sets[i], p) };
                    |to| Name::constrained_forward_dynamics_batch(qs, qds, taus, flags, s, take(to), take(to), take(to), take(to));
                    |to| Name::constrained_forward_dynamics_each(&q, &qd, &tau, &sets, s, to)
                );
                compare!(
                    "impact_dynamics": Name::impact_dynamics(q0, v0, none, s);
                    |i| { let (q, v, _, _) = at(i); <Name as Robot>::impact_dynamics::<P>(&q, &v, sets[i], p) };
                    |to| Name::impact_dynamics_batch(qs, qds, flags, s, take(to), take(to), take(to));
                    |to| Name::impact_dynamics_each(&q, &qd, &sets, s, to)
                );
                compare!(
                    "constrained_inverse_dynamics":
                    Name::constrained_inverse_dynamics(q0, v0, v0, none, s);
                    |i| { let (q, v, _, a) = at(i); <Name as Robot>::constrained_inverse_dynamics::<P>(&q, &v, &a, sets[i], p) };
                    |to| Name::constrained_inverse_dynamics_batch(qs, qds, qdds, flags, s, take(to), take(to), take(to));
                    |to| Name::constrained_inverse_dynamics_each(&q, &qd, &qdd, &sets, s, to)
                );
                compare!(
                    "constraint_residual": Name::constraint_residual(q0, v0, s);
                    |i| { let (q, v, _, _) = at(i); <Name as Robot>::constraint_residual::<P>(&q, &v, p) };
                    |to| Name::constraint_residual_batch(qs, qds, s, take(to), take(to));
                    |to| Name::constraint_residual_each(&q, &qd, s, to)
                );
                compare!(
                    "project_constraints": Name::project_constraints(q0, v0, none, s);
                    |i| { let (q, v, _, _) = at(i); <Name as Robot>::project_constraints::<P>(&q, &v, sets[i], p) };
                    |to| Name::project_constraints_batch(qs, qds, flags, s, take(to), take(to), take(to));
                    |to| Name::project_constraints_each(&q, &qd, &sets, s, to)
                );
                compare!(
                    "constraint_jacobian": Name::constraint_jacobian(q0);
                    |i| <Name as Robot>::constraint_jacobian::<P>(&at(i).0);
                    |to| Name::constraint_jacobian_batch(qs, take(to));
                    |to| Name::constraint_jacobian_each(&q, to)
                );
                compare!(
                    "constraint_jacobian_dot_qd": Name::constraint_jacobian_dot_qd(q0, v0);
                    |i| <Name as Robot>::constraint_jacobian_dot_qd::<P>(&at(i).0, &at(i).1);
                    |to| Name::constraint_jacobian_dot_qd_batch(qs, qds, take(to));
                    |to| Name::constraint_jacobian_dot_qd_each(&q, &qd, to)
                );
                compare!(
                    "operational_space_inertia": Name::operational_space_inertia(q0, none, s);
                    |i| <Name as Robot>::operational_space_inertia::<P>(&at(i).0, sets[i], p);
                    |to| Name::operational_space_inertia_batch(qs, flags, s, take(to), take(to), take(to));
                    |to| Name::operational_space_inertia_each(&q, &sets, s, to)
                );
            });
        }
    }};
}

#[test]
fn sets_of_contacts_of_a_floating_robot() {
    robot!(walker, f64, 3, |&mask| walker::MachineContacts::from_array(mask));
}

#[test]
fn sets_of_contacts_of_many_joint_types() {
    robot!(zoo, f64, 3, |&mask| zoo::MachineContacts::from_array(mask));
}

#[test]
fn sets_in_single_precision() {
    robot!(single, f32, 1, |&mask| single::MachineContacts::from_array(mask));
}

#[test]
fn loops_without_contacts() {
    robot!(linkage, f64, 0, |[]| ());
}

#[test]
fn loops_and_contacts() {
    robot!(leg, f64, 1, |&mask| leg::MachineContacts::from_array(mask));
}

impl<'a, T: 'a, V: Take<'a, T>, W: Take<'a, T>, R: Take<'a, T>, X: Take<'a, T>> Take<'a, T>
    for ConstrainedForwardDynamics<V, W, R, X>
{
    fn take(slices: &mut impl Iterator<Item = &'a mut [T]>) -> Self {
        let (qdd, wrenches) = (V::take(slices), W::take(slices));
        Self { qdd, wrenches, residuals: R::take(slices), rank: X::take(slices) }
    }
}

/// A robot with derivatives and a fused function.
mod more {
    modyn::modyn! {
        pub Machine = "../../../robots/five_bar.urdf",
        functions = [
            random_configuration, constrained_forward_dynamics,
            constrained_forward_dynamics_derivatives, constrained_forward_dynamics_derivatives_batch
        ],
        fused = [held: batch(constrained_forward_dynamics, mass_matrix)],
        contacts = [
            "foot": point("left_forearm", [0.3, 0, 0], [0, 0, 0]),
            "elbow": point("right_arm", [0.2, 0.1, 0], [0.3, 0, 0])
        ],
    }
}

use more::{Machine, MachineContacts, MachineHeld};

/// The numbers of a result of the fused function: of accelerations, wrenches, residuals, the rank and the mass matrix.
const HELD: usize = 4 + 3 * 6 + 3 * 6 + 1 + 4 * 4;

/// States of that robot, with their sets and settings.
struct States {
    q: Vec<[f64; 4]>,
    qd: Vec<[f64; 4]>,
    tau: Vec<[f64; 4]>,
    sets: Vec<MachineContacts>,
    settings: ConstraintSettings<f64, [ContactTarget<f64>; 2]>,
}

impl States {
    fn new(states: usize) -> Self {
        let mut uniform = numbers();
        let mut set = || MachineContacts { foot: uniform() > 0.0, elbow: uniform() > 0.3 };
        let sets = (0..states).map(|_| set()).collect();
        let q =
            (0..states).map(|_| Machine::random_configuration(|| 0.5 + 0.5 * uniform())).collect();
        let settings = settings();
        Self { q, qd: vectors(states, 2.0), tau: vectors(states, 5.0), sets, settings }
    }
}

/// Derivatives of many states, with loops and contacts.
#[test]
fn derivatives_of_many_states() {
    let States { q, qd, tau, sets, settings } = &States::new(37);
    let plain_settings = settings_in(settings, Plain);
    on_every_level(|fused| {
        let one = |i: usize| {
            let (q, qd, tau) = (plain(&q[i]), plain(&qd[i]), plain(&tau[i]));
            <Machine as Robot>::constrained_forward_dynamics_derivatives(
                &q,
                &qd,
                &tau,
                sets[i],
                &plain_settings,
            )
        };
        let all: Vec<Vec<f64>> = (0..q.len()).map(|i| flat(&one(i))).collect();
        let empty = Machine::constrained_forward_dynamics_derivatives(
            &q[0],
            &qd[0],
            &tau[0],
            MachineContacts::NONE,
            settings,
        );
        let mut found = vec![empty; q.len()];
        Machine::constrained_forward_dynamics_derivatives_each(
            q, qd, tau, sets, settings, &mut found,
        )
        .expect("sizes");
        let found: Vec<Vec<f64>> = found.iter().map(flat).collect();
        same(&found, &all, if fused { fused_error::<f64>() } else { 0.0 }, "derivatives");
    });
}

/// A fused function of many states has the set and the settings once for its functions.
#[test]
fn a_fused_function_of_many_states() {
    let States { q, qd, tau, sets, settings } = &States::new(19);
    on_every_level(|fused| {
        let one = |i: usize| Machine::held(&q[i], &qd[i], &tau[i], sets[i], settings);
        let mut found: Vec<MachineHeld<f64>> = vec![one(0); q.len()];
        Machine::held_each(q, qd, tau, sets, settings, &mut found).expect("sizes");
        let numbers = |held: &MachineHeld<f64>| {
            [flat(&held.constrained_forward_dynamics), flat(&held.mass_matrix)].concat()
        };
        let expected: Vec<Vec<f64>> = (0..q.len()).map(|i| numbers(&one(i))).collect();
        let found: Vec<Vec<f64>> = found.iter().map(numbers).collect();
        same(&found, &expected, if fused { fused_error::<f64>() } else { 1e-12 }, "fused");
    });
}

/// On all cores, results are the same.
#[test]
fn on_all_cores() {
    let States { q, qd, tau, sets, settings } = &States::new(1000);
    let masks: Vec<[bool; 2]> = sets.iter().map(|set| set.to_array()).collect();
    let (qs, qds, taus, flags) = (columns(q), columns(qd), columns(tau), columns(&masks));
    let inputs = (slices(&qs), slices(&qds), slices(&taus), slices(&flags));
    let zero = || vec![vec![0.0; q.len()]; HELD];
    let (q, qd, tau, flags) = inputs;
    on_every_level(|_| {
        let (mut one, mut all) = (zero(), zero());
        let to = &mut one.iter_mut().map(|column| &mut column[..]);
        Machine::held_batch(q, qd, tau, flags, settings, take(to), take(to)).expect("sizes");
        let to = &mut all.iter_mut().map(|column| &mut column[..]);
        Machine::held_batch_par(q, qd, tau, flags, settings, take(to), take(to)).expect("sizes");
        assert!(one == all);
    });
}

/// A set of contacts is missing: the error names the argument, and nothing is written.
#[test]
fn errors_name_the_argument() {
    let States { q, qd, tau, sets, settings } = &States::new(9);
    let mut found = vec![Machine::held(&q[0], &qd[0], &tau[0], sets[0], settings); 9];
    let before = found.clone();
    let called = Machine::held_each(q, qd, tau, &sets[..8], settings, &mut found);
    let said = called.expect_err("a set is missing").to_string();
    assert_eq!(said, "`active` holds 8 states, `q` holds 9");
    assert_eq!(found, before);
    let masks: Vec<[bool; 2]> = sets.iter().map(|set| set.to_array()).collect();
    let (qs, qds, taus, flags) = (columns(q), columns(qd), columns(tau), columns(&masks));
    let mut numbers = vec![vec![0.0; 9]; HELD];
    let to = &mut numbers.iter_mut().map(|column| &mut column[..]);
    let called = Machine::held_batch(
        slices(&qs),
        slices(&qds),
        slices(&taus),
        [&flags[0], &flags[1][..7]],
        settings,
        take(to),
        take(to),
    );
    let said = called.expect_err("two flags are missing").to_string();
    assert_eq!(said, "`active[1]` (elbow) holds 7 states, `q[0]` holds 9");
}
