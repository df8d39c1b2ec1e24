//! `modyn view`: the page, and its scripts in a browser.
#![cfg(feature = "command")]

use std::process::Command;

use modyn_runtime::Interpreter;
use modyn_runtime::spatial::Pose;
use serde_json::Value;

use crate::common::{self, modyn};

/// A robot with a shape of each kind, in general position.
const SHAPES: &str = r#"<robot name="shapes">
  <link name="base"><visual><geometry><box size="0.4 0.4 0.1"/></geometry></visual></link>
  <joint name="pivot" type="continuous"><parent link="base"/><child link="rod"/><origin xyz="0 0 0.1" rpy="0.3 0.2 0.1"/><axis xyz="0 0.6 0.8"/></joint>
  <link name="rod">
    <inertial><origin xyz="0 0 0.3"/><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 0.3" rpy="0.3 -0.4 0.5"/><geometry><cylinder radius="0.05" length="0.6"/></geometry><material name="m"><color rgba="0.9 0.3 0.1 1"/></material></visual>
    <visual><origin xyz="0 0 0.6"/><geometry><sphere radius="0.1"/></geometry></visual>
    <visual><geometry><mesh filename="corner.obj"/></geometry></visual>
    <visual><geometry><mesh filename="missing.stl"/></geometry></visual>
  </link>
</robot>"#;

const CORNER: &str =
    "v 0 0 0\nv 0.3 0 0\nv 0 0.3 0\nv 0 0 0.3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

#[test]
fn the_page_has_shapes_meshes_and_motions() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(path("shapes.urdf"), SHAPES).expect("written");
    std::fs::write(path("corner.obj"), CORNER).expect("written");
    for (name, q) in [("one", "1"), ("two", "-2")] {
        let csv = path(&format!("{name}.csv"));
        let found =
            modyn(&["simulate", &path("shapes.urdf"), "--q", q, "--time", "0.1", "--csv", &csv]);
        assert_eq!(found.code, 0, "{}", found.err);
    }
    let robot = path("shapes.urdf");
    let [one, two, html] = ["one.csv", "two.csv", "page.html"].map(path);
    let found = modyn(&["view", &robot, "-o", &html, "--motion", &one, "--motion", &two]);
    assert_eq!((found.code, &*found.out), (0, ""), "{}", found.err);
    assert!(
        found.err.contains("note: a shape of the link `rod` has the file `missing.stl`"),
        "{}",
        found.err
    );
    let data = common::page_data(&std::fs::read_to_string(&html).expect("a page"));
    let shapes = data["robots"][0]["shapes"].as_array().expect("shapes");
    let kinds = ["box", "cylinder", "sphere", "mesh"];
    assert!(shapes.iter().zip(kinds).all(|(shape, kind)| !shape[kind].is_null()), "{shapes:?}");
    assert_eq!((shapes.len(), data["meshes"].as_array().map(Vec::len)), (4, Some(1)));
    assert_eq!(shapes[1]["color"], serde_json::json!([0.9, 0.3, 0.1, 1]));
    let starts = [0, 1].map(|i| (&data["motions"][i]["name"], &data["motions"][i]["q"][0][0]));
    assert_eq!(
        starts.map(|(name, q)| (name.as_str(), q.as_f64())),
        [(Some("one"), Some(1.0)), (Some("two"), Some(-2.0))]
    );
}

/// A body that rests on three points: their forces carry its weight, without a torque about its centre of mass.
#[test]
fn contact_forces_carry_the_weight() {
    let feet = [("a", [0.3, 0.0]), ("b", [-0.2, 0.3]), ("c", [-0.2, -0.3])];
    let foot = |(name, [x, y]): (&str, [f64; 2])| {
        format!(
            "<link name=\"{name}\"/><joint name=\"j{name}\" type=\"fixed\"><parent link=\"body\"/><child link=\"{name}\"/>\
             <origin xyz=\"{x} {y} 0\"/></joint>"
        )
    };
    let robot = format!(
        "<robot name=\"tripod\"><link name=\"body\"><inertial><origin xyz=\"0 0 0.3\"/><mass value=\"2\"/>\
         <inertia ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>{}</robot>",
        feet.map(foot).concat()
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::write(path("tripod.urdf"), robot).expect("written");
    let contacts = "a: point(a), b: point(b), c: point(c)";
    let found = modyn(&[
        "simulate",
        &path("tripod.urdf"),
        "--base",
        "floating",
        "--contacts",
        contacts,
        "--ground",
        "plane",
        "--time",
        "1",
        "--html",
        &path("page.html"),
    ]);
    assert_eq!(found.code, 0, "{}", found.err);
    let data = common::page_data(&std::fs::read_to_string(path("page.html")).expect("a page"));
    let forces =
        data["motions"][0]["forces"].as_array().and_then(|all| all.last()).expect("forces");
    let forces: Vec<f64> =
        forces.as_array().expect("numbers").iter().map(|x| x.as_f64().expect("a number")).collect();
    let sum = |of: &dyn Fn(usize) -> f64| (0..3).map(of).sum::<f64>();
    for (k, expected) in [0.0, 0.0, 2.0 * 9.81].into_iter().enumerate() {
        assert!((sum(&|i| forces[6 * i + 3 + k]) - expected).abs() < 1e-3, "{forces:?}");
    }
    // The points are where the feet are.
    for (i, (_, place)) in feet.iter().enumerate() {
        assert!((0..2).all(|k| (forces[6 * i + k] - place[k]).abs() < 1e-3), "{forces:?}");
    }
    for k in 0..2 {
        assert!(sum(&|i| forces[6 * i + k] * forces[6 * i + 5]).abs() < 1e-3, "{forces:?}");
    }
}

#[test]
fn tables_that_are_no_motions_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let cases = [
        ("time (s),shoulder (rad)\n0,1\n", "has no column `elbow`"),
        ("shoulder,elbow\n0,1\n", "has no column `time`"),
        ("time,shoulder,elbow\n", "has no rows"),
        ("time,shoulder,elbow\n0,1,x\n", "has `x` instead of a number in row 2"),
        ("time,shoulder,elbow\n1,1,2\n0,1,2\n", "has a time before that of the row above in row 3"),
    ];
    for (text, message) in cases {
        std::fs::write(path("m.csv"), text).expect("written");
        let found = modyn(&[
            "view",
            "robots/double_pendulum.urdf",
            "-o",
            &path("p.html"),
            "--motion",
            &path("m.csv"),
        ]);
        assert_eq!(found.code, 2, "{}", found.err);
        assert!(found.err.contains(message), "{message}: {}", found.err);
    }
}

/// The names of browsers that this test can use.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// Returns the text that a script of a page puts into its element `result`; `None` if there is no browser.
fn in_browser(page: &str, script: &str) -> Option<Value> {
    let is_there = |name: &&&str| Command::new(name).arg("--version").output().is_ok();
    let browser = BROWSERS.iter().find(is_there)?;
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("page.html");
    let element = format!(
        "<pre id=\"result\"></pre><script>\ndocument.getElementById(\"result\").textContent = JSON.stringify((() => {{\n{script}\n}})());\n</script></body>"
    );
    std::fs::write(&file, page.replace("</body>", &element)).expect("written");
    let output = Command::new(browser)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
        ])
        .args(["--virtual-time-budget=1000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
        .arg(format!("file://{}", file.display()))
        .output()
        .expect("the browser runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let result =
        text.split("<pre id=\"result\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let result = result.unwrap_or_else(|| panic!("no result: {text}"));
    let result = result.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    Some(serde_json::from_str(&result).unwrap_or_else(|error| panic!("{error}: {result}")))
}

/// Poses in the page are those of the interpreter, for every joint type; and the picture is no plain surface.
#[test]
#[ignore = "slow: starts a browser"]
fn the_page_places_and_draws_links_in_a_browser() {
    let folder = tempfile::tempdir().expect("a folder");
    let html = folder.path().join("page.html").to_string_lossy().into_owned();
    let found = modyn(&[
        "simulate",
        "robots/joint_zoo.urdf",
        "--random",
        "5",
        "--time",
        "0.1",
        "--html",
        &html,
    ]);
    assert_eq!(found.code, 0, "{}", found.err);
    let page = std::fs::read_to_string(&html).expect("a page");
    let script = "
        if (!viewer) return document.body.textContent;
        viewer.play(false);
        const robot = viewer.robots[0], { gl } = viewer.renderer;
        viewer.draw([400, 300]);
        const pixels = new Uint8Array(400 * 300 * 4), colors = new Set();
        gl.readPixels(0, 0, 400, 300, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        for (let i = 0; i < pixels.length; i += 4) colors.add(pixels.slice(i, i + 3).join());
        return { poses: data.motions[0].q.map((q) => robot.poses(q).flat()), colors: colors.size,
          error: gl.getError(), scene: viewer.sceneFile().size };";
    let script = format!("const data = viewer ? viewer.data : null;\n{script}");
    let Some(result) = in_browser(&page, &script) else {
        eprintln!("skipped: none of {BROWSERS:?} is installed");
        return;
    };
    assert_eq!(result["error"], 0, "{result}");
    assert!(result["colors"].as_u64() > Some(1000), "{}", result["colors"]);
    assert!(result["scene"].as_u64() > Some(10_000), "{}", result["scene"]);
    let text =
        std::fs::read_to_string(common::root().join("robots/joint_zoo.urdf")).expect("a robot");
    let model =
        modyn_codegen::read(&text, "joint_zoo.urdf", &Default::default()).expect("read").model;
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let mut poses = vec![Pose::identity(); model.links().len()];
    let data = common::page_data(&page);
    let states = data["motions"][0]["q"].as_array().expect("states");
    assert_eq!(states.len(), 6);
    let list = |value: &Value| -> Vec<f64> {
        value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
    };
    for (q, shown) in states.iter().zip(result["poses"].as_array().expect("poses")) {
        let (mut q, shown) = (list(q), list(shown));
        interpreter.normalize_configuration(&mut q).expect("the length");
        interpreter.link_poses(&q, &mut poses).expect("the length");
        for (link, matrix) in shown.chunks(16).enumerate() {
            let name = &model.moving_links()[link].name;
            let frame = model.link_index(name).expect("a frame");
            let Pose { rotation, translation } = poses[frame];
            for i in 0..3 {
                assert!(
                    (matrix[12 + i] - translation[i]).abs() < 2e-5,
                    "{name}: {matrix:?} {:?}",
                    poses[frame]
                );
                for j in 0..3 {
                    assert!(
                        (matrix[4 * j + i] - rotation[i][j]).abs() < 2e-5,
                        "{name}: {matrix:?} {:?}",
                        poses[frame]
                    );
                }
            }
        }
    }
}
