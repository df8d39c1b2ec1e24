//! Many links that are fixed to one body share the code of their functions. Their results are those of the interpreter.

use std::path::{Path, PathBuf};
use std::process::Command;

use modyn_codegen::{Builder, Function};
use modyn_runtime::Interpreter;
use modyn_runtime::spatial::{Pose, Twist};

const OF_LINKS: [Function; 11] = [
    Function::LinkPose,
    Function::LinkVelocity,
    Function::LinkVelocityLocal,
    Function::LinkAcceleration,
    Function::LinkAccelerationLocal,
    Function::Jacobian,
    Function::JacobianLocal,
    Function::JacobianTimeDerivative,
    Function::JacobianTimeDerivativeLocal,
    Function::JacobianDotQd,
    Function::JacobianDotQdLocal,
];

/// Returns a chain of joints in general position, with these numbers of links fixed to the world and to each moving link.
fn urdf(joints: usize, fixed: &[usize]) -> String {
    let mut text = String::from("<robot name='comb'><link name='b0'/>");
    let fix = |body: usize, text: &mut String| {
        for i in 0..fixed[body.min(fixed.len() - 1)] {
            let x = 0.1 * i as f64 + 0.3 * body as f64;
            *text += &format!(
                "<link name='f{body}_{i}'/><joint name='fix{body}_{i}' type='fixed'>\
                 <parent link='b{body}'/><child link='f{body}_{i}'/>\
                 <origin xyz='{x} {} {}' rpy='{} {x} {}'/></joint>",
                0.2 - x,
                0.5 * x,
                0.7 - x,
                1.1 * x,
            );
        }
    };
    fix(0, &mut text);
    for j in 1..=joints {
        let kind = ["continuous", "prismatic", "continuous"][j % 3];
        let limit = if kind == "prismatic" {
            "<limit lower='-1' upper='1' effort='1' velocity='1'/>"
        } else {
            ""
        };
        text += &format!(
            "<joint name='j{j}' type='{kind}'><parent link='b{}'/><child link='b{j}'/>\
             <origin xyz='0.1 -0.2 {}' rpy='0.4 {} -0.9'/><axis xyz='0.6 0.48 0.64'/>{limit}</joint>\
             <link name='b{j}'><inertial><origin xyz='0.1 0.02 -0.03'/><mass value='1.5'/>\
             <inertia ixx='0.3' iyy='0.4' izz='0.5' ixy='0.01' ixz='0.02' iyz='-0.03'/></inertial></link>",
            j - 1,
            0.3 * j as f64,
            0.2 * j as f64,
        );
        fix(j, &mut text);
    }
    text + "</robot>"
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Returns the numbers that a program prints; it has the generated file as a module, and this body of `main`.
fn run(folder: &Path, text: &str, main: &str) -> Vec<f64> {
    std::fs::write(folder.join("comb.rs"), text).expect("writes");
    let main = format!("mod comb;\nuse comb::*;\nfn main() {{\n{main}\n}}\n");
    std::fs::write(folder.join("main.rs"), main).expect("writes");
    let rustc = std::env::var_os("RUSTC").unwrap_or("rustc".into());
    let mut command = Command::new(rustc);
    command.current_dir(folder).args(["--edition=2024", "main.rs", "-o", "program"]);
    let output = command.output().expect("rustc runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = Command::new(folder.join("program")).output().expect("runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).expect("text");
    printed.lines().map(|line| line.parse().expect("a number")).collect()
}

/// Returns the `main` of a program that prints all numbers of all functions of all links.
fn main_of(scalar: &str) -> String {
    format!(
        "let (q, qd, qdd): ([{scalar}; 3], [{scalar}; 3], [{scalar}; 3]) = ({Q:?}, {QD:?}, {QDD:?});
         let twist = |t: runtime::spatial::Twist<{scalar}>| t.components().iter().for_each(|x| println!(\"{{x:?}}\"));
         let pose = |p: runtime::spatial::Pose<{scalar}>| p.rotation.iter().flatten().chain(&p.translation).for_each(|x| println!(\"{{x:?}}\"));
         for p in Comb::link_poses(&q) {{ pose(p) }}
         for link in CombLink::ALL {{
             pose(Comb::link_pose(&q, link));
             twist(Comb::link_velocity(&q, &qd, link));
             twist(Comb::link_velocity_local(&q, &qd, link));
             twist(Comb::link_acceleration(&q, &qd, &qdd, link));
             twist(Comb::link_acceleration_local(&q, &qd, &qdd, link));
             Comb::jacobian(&q, link).into_iter().for_each(twist);
             Comb::jacobian_local(&q, link).into_iter().for_each(twist);
             Comb::jacobian_time_derivative(&q, &qd, link).into_iter().for_each(twist);
             Comb::jacobian_time_derivative_local(&q, &qd, link).into_iter().for_each(twist);
             twist(Comb::jacobian_dot_qd(&q, &qd, link));
             twist(Comb::jacobian_dot_qd_local(&q, &qd, link));
         }}"
    )
}

const Q: [f64; 3] = [0.7, -0.4, 1.3];
const QD: [f64; 3] = [0.9, 0.6, -0.8];
const QDD: [f64; 3] = [-0.5, 1.2, 0.3];

/// Returns the same numbers from the interpreter.
fn interpreted(urdf: &str) -> Vec<f64> {
    let reading = modyn_codegen::read(urdf, "comb.urdf", &Default::default()).expect("good");
    let mut robot = Interpreter::<f64>::new(reading.model);
    let links = robot.model().links().len();
    let mut poses = vec![Pose::identity(); links];
    robot.link_poses(&Q, &mut poses).expect("fits");
    let pose = |p: &Pose<f64>| [p.rotation.concat(), p.translation.to_vec()].concat();
    let mut all: Vec<f64> = poses.iter().flat_map(pose).collect();
    let twists = |t: &[Twist<f64>]| t.iter().flat_map(|t| t.components()).collect::<Vec<_>>();
    for link in 0..links {
        all.extend(pose(&robot.link_pose(&Q, link).expect("fits")));
        all.extend(twists(&[
            robot.link_velocity(&Q, &QD, link).expect("fits"),
            robot.link_velocity_local(&Q, &QD, link).expect("fits"),
            robot.link_acceleration(&Q, &QD, &QDD, link).expect("fits"),
            robot.link_acceleration_local(&Q, &QD, &QDD, link).expect("fits"),
        ]));
        let mut columns = [Twist::zero(); 3];
        robot.jacobian(&Q, link, &mut columns).expect("fits");
        all.extend(twists(&columns));
        robot.jacobian_local(&Q, link, &mut columns).expect("fits");
        all.extend(twists(&columns));
        robot.jacobian_time_derivative(&Q, &QD, link, &mut columns).expect("fits");
        all.extend(twists(&columns));
        robot.jacobian_time_derivative_local(&Q, &QD, link, &mut columns).expect("fits");
        all.extend(twists(&columns));
        all.extend(twists(&[
            robot.jacobian_dot_qd(&Q, &QD, link).expect("fits"),
            robot.jacobian_dot_qd_local(&Q, &QD, link).expect("fits"),
        ]));
    }
    all
}

#[test]
fn links_that_share_code_have_their_own_numbers() {
    let urdf = urdf(3, &[12, 3, 15, 20]);
    let functions = OF_LINKS.iter().copied().chain([Function::LinkPoses]);
    let builder = Builder::new().urdf_text(&*urdf, "comb.urdf").self_contained();
    let builder = builder.functions(functions);
    let expected = interpreted(&urdf);
    for (float, scalar, tolerance) in [
        (modyn_codegen::FloatType::F64, "f64", 1e-12),
        (modyn_codegen::FloatType::F32, "f32", 2e-5),
    ] {
        let generated = builder.clone().scalar(float).generate().expect("good");
        assert!(generated.text.contains("link_pose_on_"), "links share code");
        let found =
            run(&folder(&format!("fixed_links_{scalar}")), &generated.text, &main_of(scalar));
        assert_eq!(found.len(), expected.len());
        for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{i}: {a} instead of {b}");
        }
    }
}

/// Default functions of ten joints: each further link adds a row of a table and its name.
#[test]
fn text_grows_by_little_for_each_fixed_link() {
    let generated = |links: usize| {
        let urdf = urdf(10, &[0, 0, links / 2, links / 2, 0]);
        let builder = Builder::new().urdf_text(urdf, "comb.urdf");
        builder.generate().unwrap_or_else(|errors| panic!("{errors}"))
    };
    let (few, many) = (generated(200), generated(400));
    let growth = (many.text.len() - few.text.len()) / 200;
    assert!(growth < 1500, "{growth} bytes a link");
    assert!(generated(4000).text.len() < 5_000_000);
    // All functions except the one shared by the links have the same operations as before.
    let operations = |generated: &modyn_codegen::Generated| -> Vec<_> {
        let of_one = generated.static_operations.iter().filter(|(name, _)| *name != "link_poses");
        of_one.copied().collect()
    };
    assert_eq!(operations(&few), operations(&many));
}

/// A body with few links keeps a function for each link, so nothing is slower for ordinary robots.
#[test]
fn few_links_have_functions_of_their_own() {
    let urdf = urdf(2, &[7, 7, 7]);
    let text = Builder::new().urdf_text(urdf, "comb.urdf").generate().expect("good").text;
    assert!(text.contains("link_pose_23") && !text.contains("_on_0"));
}
