//! The shapes that touch the ground, from the geoms of MJCF. `tests/golden/floors.json` of the workspace has MuJoCo's steps with
//! them.

use modyn_read::diagnostics::{Code, Diagnostics};
use modyn_read::{ReadOptions, Reading};
use modyn_runtime::model::{Cone, ContactComponents, ContactShape, Model, TouchingShape};

/// Reads a model with the plane `floor` and these elements in a free body, and in `<mujoco>`.
fn reading(body: &str, others: &str) -> Result<Reading, Diagnostics> {
    let text = format!(
        r#"<mujoco model="m">{others}<worldbody><geom name="floor" type="plane" size="0 0 1" friction="0.5" solmix="3"/>
        <body name="b"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{body}</body></worldbody></mujoco>"#
    );
    modyn_read::read(&text, "robot.xml", &ReadOptions::default())
}

fn model(body: &str, others: &str) -> Model {
    reading(body, others).expect("an MJCF").model
}

fn shapes(body: &str, others: &str) -> Vec<TouchingShape> {
    model(body, others).touching_shapes()
}

fn warnings(body: &str, others: &str) -> Vec<String> {
    let warnings = reading(body, others).expect("an MJCF").warnings;
    assert!(warnings.iter().all(|warning| warning.code == Code::NotRead), "{warnings:?}");
    warnings.into_iter().map(|warning| warning.message).collect()
}

const CUBE: &str = "-1 -1 -1 1 -1 -1 -1 1 -1 1 1 -1 -1 -1 1 1 -1 1 -1 1 1 1 1 1 0 0 0";

#[test]
fn geoms_have_their_shapes() {
    let asset = format!(r#"<asset><mesh name="cube" vertex="{CUBE}"/></asset>"#);
    let body = r#"<geom name="ball" size="0.1" pos="1 2 3"/><geom type="capsule" size="0.1" fromto="0 0 0 0 0 1"/>
        <geom type="box" size="1 2 3"/><geom type="cylinder" size="0.2 0.3"/><geom type="ellipsoid" size="1 2 3"/>
        <geom type="mesh" mesh="cube"/><geom type="plane" size="1 1 1" contype="0" conaffinity="0"/>"#;
    let shapes = shapes(body, &asset);
    let names: Vec<&str> = shapes.iter().map(|shape| &*shape.name).collect();
    assert_eq!(names, ["ball", "b_geom_1", "b_geom_2", "b_geom_3", "b_geom_4", "b_geom_5"]);
    assert_eq!((&shapes[0].shape, shapes[0].surface.radius), (&ContactShape::Point, 0.1));
    assert_eq!(shapes[0].end.pose.translation, [1.0, 2.0, 3.0]);
    assert_eq!((&shapes[1].shape, shapes[1].surface.radius), (&ContactShape::Segment(0.5), 0.1));
    assert_eq!(shapes[2].shape, ContactShape::Cuboid([1.0, 2.0, 3.0]));
    assert_eq!(shapes[3].shape, ContactShape::Cylinder([0.2, 0.3]));
    assert_eq!(shapes[4].shape, ContactShape::Ellipsoid([1.0, 2.0, 3.0]));
    let ContactShape::Points(corners) = &shapes[5].shape else { panic!("{:?}", shapes[5]) };
    let mut sorted = corners.clone();
    sorted.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    sorted.dedup();
    assert_eq!(sorted.len(), 8, "the corners of a cube, without the point inside: {corners:?}");
    assert!(corners.iter().flatten().all(|x| x.abs() == 1.0));
}

/// A hull with more corners keeps 16 corners, far from each other.
#[test]
fn hulls_have_a_largest_number_of_corners() {
    let ring = |height: f64| {
        (0..40).map(move |k| {
            let angle = f64::from(k) * core::f64::consts::TAU / 40.0;
            format!("{} {} {height} ", angle.cos(), angle.sin())
        })
    };
    let vertices: String = ring(0.0).chain(ring(1.0)).collect();
    let asset = format!(r#"<asset><mesh name="disk" vertex="{vertices}"/></asset>"#);
    let shapes = shapes(r#"<geom type="mesh" mesh="disk"/>"#, &asset);
    let ContactShape::Points(corners) = &shapes[0].shape else { panic!("{:?}", shapes[0]) };
    assert_eq!(corners.len(), 16);
    for (i, a) in corners.iter().enumerate() {
        for b in &corners[..i] {
            let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
            assert!(square > 0.1, "{a:?} {b:?}");
        }
    }
}

#[test]
fn masks_pairs_and_exclusions_decide_what_touches() {
    let ball = |attributes: &str| format!(r#"<geom name="ball" size="0.1" {attributes}/>"#);
    for (body, others, count) in [
        (ball(""), "", 1),
        (ball(r#"contype="0""#), "", 1),
        (ball(r#"contype="0" conaffinity="0""#), "", 0),
        (ball(r#"contype="2" conaffinity="2""#), "", 0),
        // All bits.
        (ball(r#"contype="-1" conaffinity="0""#), "", 1),
        (ball(""), r#"<contact><exclude body1="b" body2="world"/></contact>"#, 0),
        (ball(""), r#"<contact><exclude body1="world" body2="b"/></contact>"#, 0),
        (
            ball(r#"contype="0" conaffinity="0""#),
            r#"<contact><pair geom1="ball" geom2="floor"/></contact>"#,
            1,
        ),
        (ball(""), r#"<option><flag contact="disable"/></option>"#, 0),
        (ball(""), r#"<option><flag constraint="disable"/></option>"#, 0),
    ] {
        assert_eq!(shapes(&body, others).len(), count, "{body} {others}");
    }
}

#[test]
fn parameters_are_mixed() {
    let surface = |geom: &str, others: &str| {
        let shape = shapes(&format!(r#"<geom name="ball" size="0.1" {geom}/>"#), others).remove(0);
        (shape.surface, shape.components, shape.power)
    };
    // The weights of the mixture are 3 and 1; the largest friction counts, and margins are added.
    let given = r#"solref="0.06 2" solimp="0.5 0.55 0.005 0.9 2" friction="0.2 0.01 0.02" margin="0.1" condim="4""#;
    let (mixed, components, power) = surface(given, "");
    assert_eq!((components, power), (ContactComponents::Torsional, 2));
    assert_eq!(
        (mixed.friction, mixed.torsional_friction, mixed.rolling_friction),
        (0.5, 0.01, 0.02)
    );
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
    assert!(close(&mixed.solref, &[0.03, 1.25]) && mixed.margin == 0.1, "{mixed:?}");
    assert!(close(&mixed.solimp, &[0.8, 0.85, 0.002, 0.6]), "{mixed:?}");
    // The direct form, of which the smaller numbers count.
    let (direct, ..) = surface(r#"solref="-100 -5""#, "");
    assert_eq!(direct.solref, [-100.0, -5.0]);
    // A higher priority.
    let (prior, components, _) = surface(&format!(r#"{given} priority="1""#), "");
    assert_eq!(
        (prior.friction, prior.solref, components),
        (0.2, [0.06, 2.0], ContactComponents::Torsional)
    );
    // A pair has its own numbers, and MuJoCo's defaults for the others.
    let pair = r#"<contact><pair geom1="ball" geom2="floor" friction="0.9 0.9 0.3" condim="6"/></contact>"#;
    let (own, components, _) = surface(given, pair);
    assert_eq!((own.friction, own.torsional_friction, own.rolling_friction), (0.9, 0.3, 0.0001));
    assert_eq!(
        (own.solref, own.margin, components),
        ([0.02, 1.0], 0.0, ContactComponents::Rolling)
    );
    // The options replace all of them.
    let options = r#"<option cone="elliptic" impratio="7" o_margin="0.3" o_friction="2 2 3 4 4" o_solref="0.5 0.6">
        <flag override="enable" limit="disable"/></option>"#;
    let (replaced, ..) = surface(given, options);
    assert_eq!((replaced.friction, replaced.margin, replaced.solref), (2.0, 0.3, [0.5, 0.6]));
    let soft = model(r#"<geom size="1"/>"#, options).soft_constraints().clone();
    assert_eq!((soft.cone, soft.impratio, soft.joint_limits), (Cone::Elliptic, Some(7.0), false));
}

/// What acts in MuJoCo's steps and not here is said once, and only where it acts.
#[test]
fn what_has_no_effect_is_said() {
    let ball = |attributes: &str| {
        format!(r#"<geom name="ball" size="0.1" {attributes}/><geom size="0.2" {attributes}/>"#)
    };
    assert_eq!(warnings(&ball(""), ""), [""; 0]);
    let pair = |attributes: &str| {
        format!(r#"<contact><pair geom1="ball" geom2="floor" {attributes}/></contact>"#)
    };
    let field = r#"<asset><hfield name="h" nrow="2" ncol="2" size="1 1 1 1"/></asset>"#;
    let on_field = |geom: &str| {
        let text = format!(
            r#"<mujoco model="m">{field}<worldbody><geom type="hfield" hfield="h"/><body><freejoint/>{geom}</body></worldbody></mujoco>"#
        );
        modyn_read::read(&text, "robot.xml", &ReadOptions::default()).expect("an MJCF").warnings
    };
    let messages = on_field(&ball(""));
    assert!(messages.len() == 1 && messages[0].message.contains("height field"), "{messages:?}");
    assert_eq!(on_field(&ball(r#"contype="0" conaffinity="0""#)).len(), 0);
    for (body, others, part) in [
        (ball(r#"adhesion="2""#), String::new(), "`adhesion`"),
        (ball(r#"surfacevel="1 0 0""#), String::new(), "`surfacevel`"),
        (ball(""), pair(r#"solreffriction="0.1 1""#), "`solreffriction`"),
        (ball(""), pair(r#"friction="1 2""#), "first tangent"),
        (ball(r#"solimp="0.9 0.95 0.001 0.5 2.5""#), String::new(), "power of `solimp`"),
        (
            format!(
                r#"{}<body><joint name="j" type="hinge"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>"#,
                ball("")
            ),
            r#"<tendon><spatial range="-1 1"><site site="p"/><site site="q"/></spatial></tendon>"#
                .into(),
            "limits of a tendon that is not `<fixed>`",
        ),
        (
            r#"<geom type="mesh" mesh="no"/><geom type="mesh" mesh="no"/>"#.into(),
            String::new(),
            "does not touch the ground",
        ),
    ] {
        let messages = warnings(&body, &others);
        assert!(messages.len() == 1 && messages[0].contains(part), "{part}: {messages:?}");
    }
    // Where the geom touches nothing, nothing is left out.
    assert_eq!(warnings(&ball(r#"adhesion="2" contype="0" conaffinity="0""#), ""), [""; 0]);
}

#[test]
fn wrong_settings_are_refused() {
    let ball = |attributes: &str| format!(r#"<geom name="ball" size="0.1" {attributes}/>"#);
    let pair = |attributes: &str| {
        format!(r#"<contact><pair geom1="ball" geom2="floor" {attributes}/></contact>"#)
    };
    for (body, others, part) in [
        (ball(r#"condim="2""#), String::new(), "`condim=\"2\"` is no number of components"),
        (ball(""), pair(r#"condim="5""#), "`condim=\"5\"` is no number of components"),
        (ball(""), pair(r#"friction="rough""#), "`rough` is not a number"),
        (ball(r#"friction="1 2 3 4""#), String::new(), "friction"),
        (ball(""), r#"<option impratio="0"/>"#.into(), "`impratio` is 0"),
        (ball(""), r#"<option cone="round"/>"#.into(), "cone"),
    ] {
        let error = reading(&body, &others).expect_err(part).to_string();
        assert!(error.contains(part), "{part}: {error}");
    }
    let many: String = (0..1001).map(|_| r#"<geom size="0.1"/>"#).collect();
    let error = reading(&many, "").expect_err("too many").to_string();
    assert!(error.contains("more than 1000 shapes touch the ground"), "{error}");
}
