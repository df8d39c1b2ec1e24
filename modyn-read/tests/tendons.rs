//! Fixed tendons and soft couplings of MJCF, which act in steps. `tests/golden/floors.json` of the workspace has MuJoCo's steps with
//! them.

use modyn_read::diagnostics::{Diagnostics, Severity};
use modyn_read::{Mimic, ReadOptions, Reading};
use modyn_runtime::model::{
    Integrator, JointFriction, JointSum, Model, Softness, TendonJoint, TendonSpring,
};

/// Returns the model of two joints with references, and these elements.
fn tied(elements: &str, options: &ReadOptions) -> Result<Reading, Diagnostics> {
    let text = format!(
        r#"<mujoco model="m"><compiler angle="radian"/><default><tendon margin="0.3"/></default><worldbody>
        <body><joint name="a" ref="0.25" springref="0.5"/><geom size="1"/>
        <body pos="1 0 0"><joint name="b" axis="0 1 0" ref="0.5" springref="-1"/><geom size="1" pos="1 0 0"/>
        <body pos="1 0 0"><joint name="c" axis="0 1 0"/><geom size="1" pos="1 0 0"/></body></body>
        <body><joint name="ball" type="ball"/><geom size="1"/></body></body></worldbody>{elements}</mujoco>"#
    );
    modyn_read::read(&text, "robot.xml", options)
}

/// Returns the two tendons of a model, of which the second one couples a joint with a held one.
fn tendons(attributes: &str) -> String {
    format!(
        r#"<tendon><fixed name="t" {attributes}><joint joint="a" coef="2"/><joint joint="b" coef="-1"/></fixed>
        <fixed range="0 1"><joint joint="c" coef="3"/><joint joint="a" coef="1"/></fixed></tendon>"#
    )
}

#[test]
fn fixed_tendons_act_in_steps() {
    let options = ReadOptions { unsupported_forces: Severity::Warning, ..ReadOptions::default() };
    let read = |attributes: &str, others: &str| {
        let reading = tied(&(tendons(attributes) + others), &options).expect(attributes);
        let messages = reading.warnings.iter().map(|warning| warning.message.clone()).collect();
        (reading.model, messages)
    };
    let joint = |link, coefficient| TendonJoint { link, coefficient };
    let all = r#"range="-1 2" frictionloss="0.5" solreffriction="0.1 1" stiffness="3" damping="4""#;
    let (model, messages): (Model, Vec<String>) = read(all, "");
    let [tendon, other] = &model.soft_constraints().tendons[..] else { panic!("two tendons") };
    assert_eq!(tendon.length.joints, [joint(0, 2.0), joint(1, -1.0)]);
    assert_eq!((tendon.range, tendon.margin, tendon.dry_friction), (Some([-1.0, 2.0]), 0.3, 0.5));
    assert_eq!((tendon.limit, tendon.friction.reference), (Softness::standard(), [0.1, 1.0]));
    // The spring is at rest where those of the joints are.
    let spring = TendonSpring { stiffness: 3.0, rest: [2.0; 2], damping: 4.0 };
    assert_eq!(tendon.spring, spring);
    assert_eq!(
        (other.range, other.dry_friction, other.spring),
        (Some([0.0, 1.0]), 0.0, TendonSpring::default())
    );
    assert!(
        messages.len() == 2 && messages.iter().all(|text| text.contains("`step` only")),
        "{messages:?}"
    );
    assert!(messages[0].contains("(`damping`, `stiffness`)"), "{messages:?}");
    let rest = |attributes: &str| read(attributes, "").0.soft_constraints().tendons[0].spring.rest;
    assert_eq!(rest(r#"stiffness="1" springlength="0.7""#), [0.7; 2]);
    assert_eq!(rest(r#"stiffness="1" springlength="-0.5 0.7""#), [-0.5, 0.7]);
    // A held joint is a part of the length.
    let (held, _) = read("", r#"<equality><joint joint1="a" polycoef="0.5"/></equality>"#);
    let length = &held.soft_constraints().tendons[0].length;
    assert_eq!((&length.joints[..], length.offset), (&[joint(1, 3.0)][..], 0.75));
    // Switches.
    for (flag, limits, friction, spring, damping) in [
        ("limit", None, 0.5, 3.0, 4.0),
        ("frictionloss", Some([-1.0, 2.0]), 0.0, 3.0, 4.0),
        ("spring", Some([-1.0, 2.0]), 0.5, 0.0, 4.0),
        ("damper", Some([-1.0, 2.0]), 0.5, 3.0, 0.0),
    ] {
        let (model, _) = read(all, &format!("<option><flag {flag}=\"disable\"/></option>"));
        let tendon = &model.soft_constraints().tendons[0];
        let acts = model.soft_constraints().joint_limits;
        assert_eq!(tendon.range.filter(|_| acts), limits, "{flag}");
        assert_eq!(tendon.dry_friction, friction, "{flag}");
        assert_eq!(tendon.spring.stiffness, spring, "{flag}");
        assert_eq!(tendon.spring.damping, damping, "{flag}");
    }
    let still = ReadOptions { joint_friction: Some(JointFriction::None), ..options.clone() };
    let reading = tied(&tendons(r#"frictionloss="1""#), &still).expect("no friction");
    assert_eq!(reading.warnings.len(), 0, "{:?}", reading.warnings);
}

#[test]
fn couplings_act_in_steps() {
    let read = |constraint: &str| {
        let elements = tendons("") + &format!("<equality>{constraint}</equality>");
        tied(&elements, &ReadOptions::default()).expect(constraint)
    };
    let joint = |link, coefficient| TendonJoint { link, coefficient };
    let sum = |joints: &[TendonJoint], offset| JointSum { joints: joints.to_vec(), offset };
    let quadratic = read(r#"<joint joint1="c" joint2="a" polycoef="1 2 3" solref="0.1 1"/>"#);
    let [coupling] = &quadratic.model.soft_constraints().couplings[..] else {
        panic!("one coupling")
    };
    assert_eq!(coupling.sums, [sum(&[joint(2, 1.0)], 0.0), sum(&[joint(0, 1.0)], -0.25)]);
    assert_eq!(coupling.polynomial, [1.0, 2.0, 3.0, 0.0, 0.0]);
    assert_eq!(coupling.softness.reference, [0.1, 1.0]);
    assert!(quadratic.warnings.len() == 1 && quadratic.warnings[0].message.contains("`step` only"));
    assert_eq!(quadratic.model.nv(), 6);
    let same_tendon_twice = read(r#"<tendon tendon1="t" tendon2="t" polycoef="0 1 1"/>"#);
    let both = sum(&[joint(0, 2.0), joint(1, -1.0)], -0.5 + 0.5);
    let couplings = &same_tendon_twice.model.soft_constraints().couplings;
    assert_eq!(couplings[0].sums, [both.clone(), both]);
}

#[test]
fn wrong_tendons_are_refused() {
    for (elements, part) in [
        (tendons(r#"range="2 1""#), "lower limit of a tendon"),
        (tendons(r#"frictionloss="-1""#), "is negative"),
        (tendons(r#"solreflimit="fast""#), "`fast` is not a number"),
        (tendons(r#"stiffness="1" springlength="2 1""#), "empty range"),
        (tendons(r#"stiffness="1""#), "act in `step` only"),
        (tendons(r#"stiffness="1 2""#), "are not read"),
        (tendons(r#"stiffness="1" springyield="1""#), "are not read"),
        (tendons("").replace("\"c\"", "\"ball\""), "no hinge and no slide"),
        (
            r#"<equality><joint joint1="a" joint2="ball" polycoef="0 1 1"/></equality>"#.into(),
            "no hinge and no slide",
        ),
        (
            r#"<equality><connect body1="a" body2="b" solref="x"/></equality>"#.into(),
            "`x` is not a number",
        ),
    ] {
        let error = tied(&elements, &ReadOptions::default()).expect_err(part).to_string();
        assert!(error.contains(part), "{part}: {error}");
    }
    let joint = r#"<joint joint1="c" joint2="a" polycoef="0 1 1"/>"#.repeat(1001);
    let error = tied(&format!("<equality>{joint}</equality>"), &ReadOptions::default());
    let error = error.expect_err("too many").to_string();
    assert!(error.contains("more than 1000 tendons and couplings"), "{error}");
}

#[test]
fn couplings_have_the_attributes_of_their_class() {
    let read = |attributes: &str, constraint: &str| {
        let class =
            format!("<default><default class=\"k\"><equality {attributes}/></default></default>");
        let elements = class + &tendons("") + &format!("<equality>{constraint}</equality>");
        tied(&elements, &ReadOptions::default()).expect(constraint).model
    };
    for constraint in [
        r#"<joint class="k" joint1="c" joint2="a" polycoef="0 1 1"/>"#,
        r#"<tendon class="k" tendon1="t" tendon2="t" polycoef="0 1 1"/>"#,
    ] {
        let model = read(r#"solref="0.3 1""#, constraint);
        assert_eq!(model.soft_constraints().couplings[0].softness.reference, [0.3, 1.0]);
        let inactive = read(r#"active="false""#, constraint);
        assert_eq!(inactive.soft_constraints().couplings.len(), 0);
    }
}

/// Linear couplings are exact, or soft if joints have coordinates of their own.
#[test]
fn linear_couplings_of_independent_joints_are_soft() {
    let constraints = r#"<equality><joint joint1="b" joint2="a" polycoef="0.5 2"/><joint joint1="c" polycoef="0.1"/>
        <tendon tendon1="t"/></equality>"#;
    let elements = tendons(r#"frictionloss="1""#) + constraints;
    let options = ReadOptions { mimic: Mimic::Independent, ..ReadOptions::default() };
    let reading = tied(&elements, &options).expect("an MJCF");
    let soft = reading.model.soft_constraints();
    assert_eq!((reading.model.nv(), soft.couplings.len(), soft.tendons.len()), (6, 3, 2));
    let joints =
        soft.couplings.iter().map(|coupling| coupling.sums.each_ref().map(|sum| sum.joints.len()));
    assert_eq!(joints.collect::<Vec<_>>(), [[1, 1], [1, 0], [2, 0]]);
    assert_eq!(reading.warnings.len(), 1, "of friction: {:?}", reading.warnings);
}

/// Steps have MuJoCo's `Euler` and `implicitfast`.
#[test]
fn integrators_with_other_steps_are_said() {
    let options = ReadOptions { unsupported_forces: Severity::Warning, ..ReadOptions::default() };
    let damped = tendons(r#"damping="1""#);
    let cases = [
        ("Euler", Integrator::Euler, None),
        ("RK4", Integrator::Euler, Some("`Euler` in place of `RK4`")),
        ("implicit", Integrator::ImplicitFast, Some("`implicitfast` in place of `implicit`")),
        ("implicitfast", Integrator::ImplicitFast, None),
    ];
    for (name, integrator, expected) in cases {
        let option = format!("<option integrator=\"{name}\"/>");
        let reading = tied(&(option + &damped), &options).expect(name);
        assert_eq!(reading.model.soft_constraints().integrator, integrator, "{name}");
        let mut messages = reading.warnings.iter().map(|warning| &warning.message);
        let warning = messages.find(|message| message.contains("the integrator"));
        assert_eq!(warning.is_some(), expected.is_some(), "{name}: {warning:?}");
        assert!(warning.is_none_or(|text| text.contains(expected.unwrap_or_default())), "{name}");
    }
    let explicit = r#"<flag eulerdamp="disable"/>"#;
    for (options_of_steps, integrator) in [
        (String::new(), Integrator::Euler),
        (format!("<option>{explicit}</option>"), Integrator::ExplicitEuler),
        (
            format!("<option integrator=\"implicitfast\">{explicit}</option>"),
            Integrator::ImplicitFast,
        ),
    ] {
        let reading = tied(&options_of_steps, &options).expect("an MJCF");
        assert_eq!(reading.model.soft_constraints().integrator, integrator, "{options_of_steps}");
    }
}

/// Options of MuJoCo's solver that lead to other steps have a warning each, where they have an effect.
#[test]
fn options_with_other_steps_are_said() {
    let warnings = |option: &str| -> Vec<String> {
        let reading = tied(option, &ReadOptions::default()).expect(option);
        reading.warnings.into_iter().map(|warning| warning.message).collect()
    };
    for (option, name) in [
        (r#"<option noslip_iterations="4"/>"#, "noslip_iterations"),
        (r#"<option><flag refsafe="disable"/></option>"#, "refsafe"),
        (r#"<option><flag diagexact="enable"/></option>"#, "diagexact"),
        (r#"<option><flag ipc="enable"/></option>"#, "ipc"),
    ] {
        let expected = format!("`{name}` changes the steps of MuJoCo, and not `step`");
        assert_eq!(warnings(option), [expected], "{option}");
    }
    let flags = r#"refsafe="enable" diagexact="disable" ipc="disable""#;
    let none = format!("<option noslip_iterations=\"0\"><flag {flags}/></option>");
    assert_eq!(warnings(&none), [""; 0]);
}
