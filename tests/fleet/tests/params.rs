//! Robots with run-time parameters equal robots whose descriptions have those parameters.

use std::hint::black_box;

use modyn::{Factorization, Inertial, InertialDefect, ParameterError, Robot, functions};
use modyn_fleet::ROBOTS;
use modyn_fleet::robots::{GoldenPandaLoaded, GoldenPandaLoadedParams};
use modyn_runtime::model::{Model, ModuleTree};
use modyn_tests::changed::changed;
use modyn_tests::close::assert_close;
use modyn_tests::compiled::Compiled;
use modyn_tests::counting::measure;
use modyn_tests::random::{Random, state};
use modyn_tests::values::{Given, GivenTo, Inputs, Named, columns, interpreted, list};

const TOLERANCE: f64 = 1e-10;

/// Returns the robot of that name, its model and its modules.
fn compiled(name: &str) -> (&'static Compiled, Model, ModuleTree) {
    let robot = ROBOTS.iter().find(|robot| robot.name() == name).expect("compiled");
    let model = robot.spec.model();
    let modules = robot.spec.modules(&model);
    (robot, model, modules)
}

/// Returns all default functions that depend on parameters.
fn defaults<R: Robot + functions::Defaults>(
    params: &R::Params<f64>,
    given: &GivenTo<R, f64>,
) -> Named<f64> {
    let Given { q, qd, qdd, tau, .. } = given;
    let brge = R::brge_with(params, q);
    vec![
        ("forward_dynamics", list(&R::forward_dynamics_with(params, q, qd, tau))),
        ("inverse_dynamics", list(&R::inverse_dynamics_with(params, q, qd, qdd))),
        ("bias_forces", list(&R::bias_forces_with(params, q, qd))),
        ("gravity_torques", list(&R::gravity_torques_with(params, q))),
        ("mass_matrix", columns(&R::mass_matrix_with(params, q))),
        ("kinetic_energy", vec![R::kinetic_energy_with(params, q, qd)]),
        ("potential_energy", vec![R::potential_energy_with(params, q)]),
        ("center_of_mass", R::center_of_mass_with(params, q).to_vec()),
        ("u", columns(&brge.u())),
        ("d", columns(&brge.d())),
        ("solve", list(&brge.solve(tau))),
    ]
}

/// [`others`] of a robot that has these functions.
type Others<R> = fn(&<R as Robot>::Params<f64>, &GivenTo<R, f64>) -> Named<f64>;

/// A change of the gravitational acceleration, of links' inertias, and of payloads.
#[derive(Clone, Debug, Default)]
struct Change {
    gravity: Option<[f64; 3]>,
    inertias: Vec<(&'static str, Inertial)>,
    payloads: Vec<(&'static str, Inertial)>,
}

impl Change {
    /// Returns the model of a description with this change.
    fn of(&self, model: &Model) -> Model {
        let gravity = self.gravity.unwrap_or(model.gravity());
        let fallen = model.clone().with_gravity(gravity).expect("finite");
        let replaced = self.inertias.iter().fold(fallen, |model, (link, inertial)| {
            let at = model.frame_index(link).expect("a link");
            changed(&model, at, *inertial)
        });
        self.payloads.iter().fold(replaced, |model, (link, payload)| {
            let at = model.frame_index(link).expect("a link");
            let loaded = model.frames()[at].inertial.merged(payload);
            changed(&model, at, loaded)
        })
    }
}

/// Returns changes of two links' inertias and of gravity, each alone and all together.
fn changes(links: [&'static str; 2]) -> Vec<Change> {
    let mut random = Random::new(7);
    let [first, second] = links.map(|link| (link, random.inertial()));
    let none = (links[0], Inertial::default());
    let gravity = Some([1.0, 2.0, -3.0]);
    let [load, other_load] = links.map(|link| (link, random.inertial()));
    let change = |gravity, inertias: &[_]| {
        let inertias = inertias.to_vec();
        Change { gravity, inertias, payloads: Vec::new() }
    };
    let loaded = |change: Change, payloads: &[_]| Change { payloads: payloads.to_vec(), ..change };
    vec![
        Change::default(),
        change(gravity, &[]),
        change(Some([0.0; 3]), &[]),
        change(None, &[first]),
        change(None, &[none]),
        change(None, &[second]),
        loaded(change(None, &[]), &[load]),
        loaded(change(None, &[none]), &[load, other_load]),
        loaded(change(gravity, &[first, second]), &[load, other_load]),
    ]
}

/// Asserts that the robot with parameters equals the interpreter of the changed model.
fn check<R: Robot + functions::Defaults>(
    name: &str,
    links: [&'static str; 2],
    others: Option<Others<R>>,
    params: impl Fn(&Change) -> R::Params<f64>,
) {
    let (_, described, modules) = compiled(name);
    for change in changes(links) {
        let (model, params) = (change.of(&described), params(&change));
        for seed in 0..3 {
            let inputs = Inputs::from(&state(seed, &model));
            let given = GivenTo::<R, f64>::new(&inputs);
            let mut found = defaults::<R>(&params, &given);
            found.extend(others.into_iter().flat_map(|others| others(&params, &given)));
            let expected = interpreted(&model, &modules, &inputs, others.is_some()).named();
            for (quantity, found) in found {
                let expected = expected.iter().find(|(name, _)| *name == quantity);
                let (_, expected) = expected.unwrap_or_else(|| panic!("no {quantity}"));
                let what = format!("{name}, {change:?}: {quantity}");
                assert_close(&what, &found, expected, TOLERANCE);
            }
        }
    }
}

/// Returns the parameters of a robot with that change.
macro_rules! params {
    ($params:ident, [$first:literal: $own:ident, $load:ident; $second:literal: $other:ident, $other_load:ident], $change:expr) => {{
        let Change { gravity, inertias, payloads } = $change;
        let mut params = $params::default();
        params.set_gravity(gravity.unwrap_or(params.gravity()));
        for &(link, inertial) in inertias {
            let set = match link {
                $first => params.$own(inertial),
                _ => params.$other(inertial),
            };
            set.expect("a body's");
        }
        for &(link, inertial) in payloads {
            let set = match link {
                $first => params.$load(inertial),
                _ => params.$other_load(inertial),
            };
            set.expect("a body's");
        }
        params
    }};
}

/// Returns the parameters of the Panda.
fn panda(change: &Change) -> GoldenPandaLoadedParams {
    params!(
        GoldenPandaLoadedParams,
        ["panda_hand": set_inertia_of_panda_hand, set_payload_of_panda_hand;
         "panda_link4": set_inertia_of_panda_link4, set_payload_of_panda_link4],
        change
    )
}

#[test]
fn parameters_are_another_description() {
    let links = ["panda_hand", "panda_link4"];
    check::<GoldenPandaLoaded>("golden_panda_loaded", links, None, panda);
}

#[test]
fn the_default_is_the_description() {
    let (_, model, _) = compiled("golden_panda_loaded");
    let described = GoldenPandaLoadedParams::DEFAULT;
    assert_eq!(GoldenPandaLoadedParams::default(), described);
    assert_eq!(described.gravity(), model.gravity());
    for (link, inertial) in [
        ("panda_hand", described.inertia_of_panda_hand()),
        ("panda_link4", described.inertia_of_panda_link4()),
    ] {
        let frame = &model.frames()[model.frame_index(link).expect("a link")];
        assert_eq!(inertial, frame.inertial, "{link}");
    }
    // A payload is added to the inertia of the hand, so the default payload is zero.
    assert_eq!(described.payload_of_panda_hand(), Inertial::default());
    assert_eq!(described.payload_of_panda_link4(), Inertial::default());
    // The hand is fixed to another link; link 4 moves.
    let fixed = |link: &str| model.links().iter().all(|moving| moving.name != link);
    assert!(fixed("panda_hand") && !fixed("panda_link4"));
}

#[test]
fn an_inertia_is_a_bodys() {
    let good = Random::new(1).inertial();
    let mut params = GoldenPandaLoadedParams::DEFAULT;
    assert_eq!(params.set_inertia_of_panda_hand(good), Ok(()));
    assert_eq!(params.inertia_of_panda_hand(), good);
    assert_eq!(params.set_payload_of_panda_link4(good), Ok(()));
    assert_eq!(params.payload_of_panda_link4(), good);
    let before = params;
    let unequal = Inertial { inertia: [1.0, 0.0, 0.0, 1.0, 0.0, 3.0], ..good };
    let indefinite = Inertial { inertia: [1.0, 2.0, 0.0, 1.0, 0.0, 1.0], ..good };
    for (nonsense, expected) in [
        (Inertial { mass: -1.0, ..good }, InertialDefect::NegativeMass(-1.0)),
        (Inertial { mass: 0.0, ..good }, InertialDefect::InertiaWithoutMass),
        (Inertial { mass: f64::NAN, ..good }, InertialDefect::NotFinite),
        (Inertial { center_of_mass: [0.0, f64::INFINITY, 0.0], ..good }, InertialDefect::NotFinite),
        (Inertial { inertia: [f64::NAN; 6], ..good }, InertialDefect::NotFinite),
        (unequal, InertialDefect::TriangleInequality([1.0, 1.0, 3.0])),
        (indefinite, InertialDefect::NotPositiveSemidefinite([-1.0, 1.0, 3.0])),
    ] {
        let expected = std::mem::discriminant(&expected);
        for found in
            [params.set_inertia_of_panda_hand(nonsense), params.set_payload_of_panda_hand(nonsense)]
        {
            let Err(ParameterError::Defect(found)) = found else { panic!("{nonsense:?} is taken") };
            assert_eq!(std::mem::discriminant(&found), expected, "{found}");
        }
        assert_eq!(params, before, "nothing has changed");
    }
}

#[test]
fn a_change_allocates_nothing() {
    let inertial = black_box(Random::new(2).inertial());
    let (q, qd) = black_box((GoldenPandaLoaded::NEUTRAL, [0.1; GoldenPandaLoaded::NV]));
    let ((), allocated) = measure(|| {
        let mut params = GoldenPandaLoadedParams::DEFAULT;
        for scale in [1.0, 2.0] {
            params.set_gravity(params.gravity().map(|g| g * scale));
            params.set_inertia_of_panda_hand(inertial).ok();
            params.set_payload_of_panda_link4(inertial).ok();
            black_box(GoldenPandaLoaded::forward_dynamics_with(&params, &q, &qd, &qd));
            black_box(GoldenPandaLoaded::brge_with(&params, &q));
        }
        let nonsense = Inertial { mass: -1.0, ..inertial };
        black_box(params.set_payload_of_panda_hand(nonsense)).ok();
    });
    assert_eq!((allocated.calls, allocated.peak), (0, 0));
}

/// A robot with all functions.
#[cfg(feature = "whole")]
mod all_functions {
    use modyn_fleet::robots::{Zoo10153_8Loaded, Zoo10153_8LoadedParams};
    use modyn_tests::values::{
        array, centroidal_numbers, costate, each, forward_hessian_numbers, inverse_hessian_numbers,
        linear_step_numbers, momentum, step_hessian_numbers, time_step, vector,
    };

    use super::*;

    /// Returns all other functions that depend on parameters.
    fn others<R: Robot + functions::All>(
        params: &R::Params<f64>,
        given: &GivenTo<R, f64>,
    ) -> Named<f64> {
        let Given { q, qd, qdd, tau, forces, .. } = given;
        let inverse = R::inverse_dynamics_derivatives_with(params, q, qd, qdd);
        let forward = R::forward_dynamics_derivatives_with(params, q, qd, tau);
        let inverse_vjp = R::inverse_dynamics_vjp_with(params, q, qd, qdd, tau);
        let inverse_jvp = R::inverse_dynamics_jvp_with(params, q, qd, qdd, tau, qdd, qd);
        let forward_vjp = R::forward_dynamics_vjp_with(params, q, qd, tau, qdd);
        let forward_jvp = R::forward_dynamics_jvp_with(params, q, qd, tau, qdd, tau, qd);
        let inverse_hessian = R::inverse_dynamics_hessian_with(params, q, qd, qdd, tau);
        let forward_hessian = R::forward_dynamics_hessian_with(params, q, qd, tau, qdd);
        let dt = time_step();
        let semi_implicit = R::step_semi_implicit_with(params, q, qd, tau, dt);
        let linear_step = R::step_semi_implicit_derivatives_with(params, q, qd, tau, dt);
        let costate = array(&costate(&list(qdd), &list(tau)));
        let step_hessian = R::step_semi_implicit_hessian_with(params, q, qd, tau, dt, &costate);
        let linear_rk4 = R::step_rk4_derivatives_with(params, q, qd, tau, dt);
        let midpoint = R::step_implicit_midpoint_with(params, q, qd, tau, dt);
        let linear_midpoint = R::step_implicit_midpoint_derivatives_with(params, q, qd, tau, dt);
        vec![
            ("inverse_dynamics_vjp.dq", list(&inverse_vjp.dq)),
            ("inverse_dynamics_jvp.dtau", list(&inverse_jvp.dtau)),
            ("forward_dynamics_vjp.dq", list(&forward_vjp.dq)),
            ("forward_dynamics_jvp.dqdd", list(&forward_jvp.dqdd)),
            ("inverse_dynamics_hessian", inverse_hessian_numbers(&inverse_hessian)),
            ("forward_dynamics_hessian", forward_hessian_numbers(&forward_hessian)),
            ("step_semi_implicit.qd", list(&semi_implicit.qd)),
            ("step_semi_implicit_derivatives.a", columns(&linear_step.a)),
            ("step_semi_implicit_hessian", step_hessian_numbers(&step_hessian)),
            ("step_rk4.qd", list(&R::step_rk4_with(params, q, qd, tau, dt).qd)),
            ("step_rk4_derivatives", linear_step_numbers(&linear_rk4)),
            ("step_implicit_midpoint", [list(&midpoint.q), list(&midpoint.qd)].concat()),
            ("step_implicit_midpoint_derivatives", linear_step_numbers(&linear_midpoint)),
            (
                "forward_dynamics_external",
                list(&R::forward_dynamics_external_with(params, q, qd, tau, forces)),
            ),
            (
                "forward_dynamics_external_world",
                list(&R::forward_dynamics_external_world_with(params, q, qd, tau, forces)),
            ),
            (
                "inverse_dynamics_external",
                list(&R::inverse_dynamics_external_with(params, q, qd, qdd, forces)),
            ),
            (
                "inverse_dynamics_external_world",
                list(&R::inverse_dynamics_external_world_with(params, q, qd, qdd, forces)),
            ),
            ("inverse_dynamics_derivatives.dq", columns(&inverse.dq)),
            ("inverse_dynamics_derivatives.dqd", columns(&inverse.dqd)),
            ("forward_dynamics_derivatives.qdd", list(&forward.qdd)),
            ("forward_dynamics_derivatives.dq", columns(&forward.dq)),
            ("forward_dynamics_derivatives.dqd", columns(&forward.dqd)),
            ("forward_dynamics_derivatives.dtau", columns(&forward.dtau)),
            ("regressor", columns(&R::regressor_with(params, q, qd, qdd))),
            ("center_of_mass_jacobian", each(&R::center_of_mass_jacobian_with(params, q), vector)),
            (
                "centroidal_momentum_matrix",
                each(&R::centroidal_momentum_matrix_with(params, q), momentum),
            ),
            ("centroidal_momentum", momentum(&R::centroidal_momentum_with(params, q, qd))),
            (
                "centroidal_momentum_rate",
                momentum(&R::centroidal_momentum_rate_with(params, q, qd, qdd)),
            ),
            (
                "centroidal_momentum_derivatives",
                centroidal_numbers(&R::centroidal_momentum_derivatives_with(params, q, qd, qdd)),
            ),
        ]
    }

    /// Returns the parameters of a robot with all joint types.
    fn zoo(change: &Change) -> Zoo10153_8LoadedParams {
        params!(
            Zoo10153_8LoadedParams,
            ["fixed6": set_inertia_of_fixed6, set_payload_of_fixed6;
             "link2": set_inertia_of_link2, set_payload_of_link2],
            change
        )
    }

    #[test]
    fn parameters_are_another_description() {
        let others = Some(others::<Zoo10153_8Loaded> as Others<Zoo10153_8Loaded>);
        check::<Zoo10153_8Loaded>("zoo10153_8_loaded", ["fixed6", "link2"], others, zoo);
    }

    #[test]
    fn a_types_own_functions_take_parameters_as_the_traits_do() {
        type R = Zoo10153_8Loaded;
        let (_, model, _) = compiled("zoo10153_8_loaded");
        let change = changes(["fixed6", "link2"]).pop().expect("a change");
        let described = Zoo10153_8LoadedParams::DEFAULT;
        let params = zoo(&change);
        assert_ne!(params, described);
        let given = GivenTo::<R, f64>::new(&Inputs::from(&state(3, &model)));
        let Given { q, qd, qdd, tau, forces, .. } = &given;
        // Every function with these parameters, with the default parameters, and without parameters.
        macro_rules! same {
        ($($function:ident, $with:ident($($argument:expr),*);)*) => {$({
            let own = R::$function($($argument),*);
            assert_eq!(own, <R as Robot>::$function($($argument),*), stringify!($function));
            assert_eq!(own, R::$with(&described, $($argument),*), stringify!($function));
            let changed = R::$with(&params, $($argument),*);
            assert_eq!(changed, <R as Robot>::$with(&params, $($argument),*), stringify!($with));
            assert_ne!(changed, own, stringify!($with));
        })*};
    }
        let dt = time_step();
        let costate = array(&costate(&list(qdd), &list(tau)));
        same! {
            forward_dynamics, forward_dynamics_with(q, qd, tau);
            forward_dynamics_external, forward_dynamics_external_with(q, qd, tau, forces);
            forward_dynamics_external_world, forward_dynamics_external_world_with(q, qd, tau, forces);
            forward_dynamics_derivatives, forward_dynamics_derivatives_with(q, qd, tau);
            inverse_dynamics, inverse_dynamics_with(q, qd, qdd);
            inverse_dynamics_external, inverse_dynamics_external_with(q, qd, qdd, forces);
            inverse_dynamics_external_world, inverse_dynamics_external_world_with(q, qd, qdd, forces);
            inverse_dynamics_derivatives, inverse_dynamics_derivatives_with(q, qd, qdd);
            bias_forces, bias_forces_with(q, qd);
            gravity_torques, gravity_torques_with(q);
            mass_matrix, mass_matrix_with(q);
            kinetic_energy, kinetic_energy_with(q, qd);
            potential_energy, potential_energy_with(q);
            inverse_dynamics_vjp, inverse_dynamics_vjp_with(q, qd, qdd, tau);
            inverse_dynamics_jvp, inverse_dynamics_jvp_with(q, qd, qdd, tau, qdd, qd);
            forward_dynamics_vjp, forward_dynamics_vjp_with(q, qd, tau, qdd);
            forward_dynamics_jvp, forward_dynamics_jvp_with(q, qd, tau, qdd, tau, qd);
            inverse_dynamics_hessian, inverse_dynamics_hessian_with(q, qd, qdd, tau);
            forward_dynamics_hessian, forward_dynamics_hessian_with(q, qd, tau, qdd);
            step_semi_implicit, step_semi_implicit_with(q, qd, tau, dt);
            step_semi_implicit_derivatives, step_semi_implicit_derivatives_with(q, qd, tau, dt);
            step_semi_implicit_hessian, step_semi_implicit_hessian_with(q, qd, tau, dt, &costate);
            step_rk4, step_rk4_with(q, qd, tau, dt);
            step_rk4_derivatives, step_rk4_derivatives_with(q, qd, tau, dt);
            step_implicit_midpoint, step_implicit_midpoint_with(q, qd, tau, dt);
            step_implicit_midpoint_derivatives, step_implicit_midpoint_derivatives_with(q, qd, tau, dt);
            regressor, regressor_with(q, qd, qdd);
            center_of_mass, center_of_mass_with(q);
            center_of_mass_jacobian, center_of_mass_jacobian_with(q);
            centroidal_momentum, centroidal_momentum_with(q, qd);
            centroidal_momentum_rate, centroidal_momentum_rate_with(q, qd, qdd);
            centroidal_momentum_derivatives, centroidal_momentum_derivatives_with(q, qd, qdd);
            centroidal_momentum_matrix, centroidal_momentum_matrix_with(q);
        }
        let factors =
            [R::brge(q), R::brge_with(&described, q), R::brge_with(&params, q)].map(|b| b.d());
        assert_eq!(factors[0], factors[1]);
        assert_eq!(factors[2], <R as Robot>::brge_with(&params, q).d());
        assert_ne!(factors[2], factors[0]);
    }
}
