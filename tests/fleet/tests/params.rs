//! Robots with run-time parameters equal robots whose descriptions have those parameters.

use std::hint::black_box;

use modyn::{Inertial, InertialDefect, ParameterError};
use modyn_fleet::ROBOTS;
use modyn_fleet::robots::{GoldenPandaLoaded, GoldenPandaLoadedLink, GoldenPandaLoadedParams};
use modyn_runtime::Interpreter;
use modyn_runtime::equations::soft_constraints::SoftModel;
use modyn_runtime::model::{Model, ModuleTree};
use modyn_runtime::quantities::{Function, Sizes};
use modyn_tests::arguments;
use modyn_tests::changed::changed;
use modyn_tests::close::assert_close;
use modyn_tests::compiled::Compiled;
use modyn_tests::counting::measure;
use modyn_tests::random::{Random, state};
use modyn_tests::results;
use modyn_tests::values::{Arguments, Results, fields, interpreted, of_state};

const TOLERANCE: f64 = 1e-10;

/// Returns the robot of that name, its model and its modules.
fn compiled(name: &str) -> (&'static Compiled, Model, ModuleTree) {
    let robot = ROBOTS.iter().find(|robot| robot.name() == name).expect("compiled");
    let model = robot.spec.model();
    let modules = robot.spec.modules(&model);
    (robot, model, modules)
}

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
            let at = model.link_index(link).expect("a link");
            changed(&model, at, *inertial)
        });
        self.payloads.iter().fold(replaced, |model, (link, payload)| {
            let at = model.link_index(link).expect("a link");
            let loaded = model.links()[at].inertial.merged(payload);
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

/// Returns the step of a changed model. Mobilities do not follow run-time parameters.
fn step(model: &Model, described: &Model, given: Arguments<'_>) -> Vec<f64> {
    let mut robot = Interpreter::new(model.clone());
    robot.set_soft_model(SoftModel::of(described));
    arguments::interpreted(&mut robot, Function::Step, &given(Function::Step))
}

/// Asserts that a robot's functions with parameters equal the interpreter of the changed model.
fn check(
    name: &str,
    links: [&'static str; 2],
    with: impl Fn(&Change, Arguments<'_>) -> Results<f64>,
) {
    let (robot, described, modules) = compiled(name);
    for change in changes(links) {
        let model = change.of(&described);
        let sizes = Sizes::new(&model, 0);
        for seed in 0..3 {
            let state = state(seed, &model);
            let arguments = of_state(&model, &state);
            let expected = interpreted(&model, &modules, &arguments, robot.spec.all);
            let expected_step = step(&model, &described, &arguments);
            let found = with(&change, &arguments);
            assert!(found.len() > 8, "{name}");
            for (function, found) in found {
                let numbers = match function {
                    Function::Step => &expected_step,
                    _ => expected.of(function),
                };
                let all = fields(function, &sizes, numbers).into_iter();
                for ((field, expected), (_, found)) in all.zip(fields(function, &sizes, &found)) {
                    let what = format!("{name}, {change:?}: {field}");
                    assert_close(&what, &found, &expected, TOLERANCE);
                }
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
    check("golden_panda_loaded", links, |change, arguments| {
        let params = &panda(change);
        results!(trait_with GoldenPandaLoaded, f64, default, arguments, &GoldenPandaLoadedLink::ALL, params)
    });
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
        let frame = &model.links()[model.link_index(link).expect("a link")];
        assert_eq!(inertial, frame.inertial, "{link}");
    }
    // A payload is added to the inertia of the hand, so the default payload is zero.
    assert_eq!(described.payload_of_panda_hand(), Inertial::default());
    assert_eq!(described.payload_of_panda_link4(), Inertial::default());
    // The hand is fixed to another link; link 4 moves.
    let fixed = |link: &str| model.moving_links().iter().all(|moving| moving.name != link);
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
    use modyn_fleet::robots::{Zoo10153_8Loaded, Zoo10153_8LoadedLink, Zoo10153_8LoadedParams};

    use super::*;

    /// Returns the parameters of a robot with all joint types.
    fn zoo(change: &Change) -> Zoo10153_8LoadedParams {
        params!(
            Zoo10153_8LoadedParams,
            ["fixed6": set_inertia_of_fixed6, set_payload_of_fixed6;
             "link2": set_inertia_of_link2, set_payload_of_link2],
            change
        )
    }

    /// Returns the results of one of the forms of functions with parameters.
    macro_rules! with {
        ($form:ident, $arguments:expr, $params:expr) => {
            results!($form Zoo10153_8Loaded, f64, all, $arguments, &Zoo10153_8LoadedLink::ALL, $params)
        };
    }

    #[test]
    fn parameters_are_another_description() {
        check("zoo10153_8_loaded", ["fixed6", "link2"], |change, arguments| {
            with!(trait_with, arguments, &zoo(change))
        });
    }

    #[test]
    fn a_types_own_functions_take_parameters_as_the_traits_do() {
        let (_, model, _) = compiled("zoo10153_8_loaded");
        let change = changes(["fixed6", "link2"]).pop().expect("a change");
        let (described, params) = (&Zoo10153_8LoadedParams::DEFAULT, &zoo(&change));
        let state = state(3, &model);
        let arguments = &of_state(&model, &state);
        let links = &Zoo10153_8LoadedLink::ALL;
        let own = results!(own Zoo10153_8Loaded, f64, all, arguments, links);
        let by_default = with!(own_with, arguments, described);
        let changed = with!(own_with, arguments, params);
        assert_eq!(changed, with!(trait_with, arguments, params));
        assert!(by_default.len() > 30);
        for (by_default, changed) in by_default.iter().zip(&changed) {
            assert!(own.contains(by_default), "{:?}", by_default.0);
            assert_ne!(by_default, changed);
        }
    }
}
