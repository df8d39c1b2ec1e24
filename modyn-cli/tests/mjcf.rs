//! Every command also reads MuJoCo's models.

use crate::common;

use common::modyn;

const CART: &str = r#"<mujoco model="cart pole"><option gravity="0 0 -1.62"/><worldbody><body name="cart">
  <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/><joint name="slide" type="slide" axis="1 0 0"/>
  <body name="pole"><inertial pos="0 0 0.5" mass="0.1" diaginertia="0.01 0.01 0.001"/>
  <joint name="pivot" axis="0 1 0"/></body></body></worldbody></mujoco>"#;

#[test]
fn every_command_takes_mjcf() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (good, bad, code) = (path("cart.xml"), path("bad.xml"), path("cart.rs"));
    std::fs::write(&good, CART).expect("written");
    std::fs::write(
        &bad,
        CART.replace("<option", "<tendon><spatial stiffness=\"1\"/></tendon><option"),
    )
    .expect("written");

    assert_eq!(modyn(&["check", &good]).code, 0);
    let refused = modyn(&["check", &bad]);
    assert_eq!(refused.code, 1);
    assert!(
        refused.out.contains("error[not-read]: forces of a tendon (`stiffness`) are not read"),
        "{}",
        refused.out
    );

    let shown = modyn(&["inspect", &good, "--json"]).json();
    assert_eq!(shown["coordinates"], serde_json::json!(["slide", "pivot"]));
    assert_eq!(shown["gravity"][2], -1.62);

    let written = modyn(&["generate", &good, "-o", &code]);
    assert_eq!(written.code, 0, "{}", written.err);
    assert!(std::fs::read_to_string(&code).expect("a file").contains("pub struct CartPole;"));
    assert_eq!(modyn(&["generate", &good, "-o", &code, "--check"]).code, 0);

    let functions = "forward_dynamics,gravity_torques";
    let compared = modyn(&["compare", &good, "--functions", functions]);
    assert_eq!(compared.code, 0, "{}{}", compared.out, compared.err);
    let moved = modyn(&["simulate", &good, "--random", "1"]);
    assert_eq!(moved.code, 0, "{}", moved.err);
}
