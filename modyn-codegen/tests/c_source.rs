//! Generated C compiles without a warning, and returns the same bits as generated Rust.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use modyn_codegen::{Base, Contact, ContactKind, LoopEnd};
use modyn_codegen::{
    Builder, Bundle, CodeForm, FloatType, Function, Interpreter, Scalar, UserArgument, UserError,
    UserFunction,
};

fn robot(name: &str) -> Builder {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden");
    let file = [robots, golden].map(|folder| folder.join(format!("{name}.urdf")));
    Builder::new().urdf(file.iter().find(|file| file.exists()).expect("a robot"))
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("c_source").join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Runs a command and returns its output.
fn run(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, errors) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{command:?}\n{out}\n{errors}");
    assert_eq!(errors, "", "{command:?}");
    out
}

const STRICT: [&str; 6] =
    ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"];

/// Returns the installed C compilers; gcc must be one of them.
fn compilers() -> Vec<&'static str> {
    let runs = |name: &&&str| Command::new(name).arg("--version").output().is_ok();
    let found: Vec<&str> = ["gcc", "clang"].iter().filter(runs).copied().collect();
    assert!(found.contains(&"gcc"), "gcc is needed (Debian: gcc)");
    found
}

/// Writes `builder`'s C to a folder and compiles it with each compiler; returns the folder and the header.
fn compiled(name: &str, builder: &Builder) -> (PathBuf, String) {
    let (found, _) = builder.clone().type_name("Ours").generate_c().expect("good");
    let folder = folder(name);
    assert_eq!(found.prefix, "ours");
    std::fs::write(folder.join("ours.h"), &found.header).expect("writes");
    std::fs::write(folder.join("ours.c"), &found.source).expect("writes");
    for foreign in ["malloc", "stdlib", "string.h", "stdint.h"] {
        assert!(!found.source.contains(foreign), "{foreign}");
    }
    for compiler in compilers() {
        let mut command = Command::new(compiler);
        run(command
            .args(STRICT)
            .args(["-O1", "-c", "ours.c", "-o", "ours.o"])
            .current_dir(&folder));
    }
    (folder, found.header)
}

/// A function of the header.
#[derive(Debug)]
struct Declared {
    name: String,
    /// The lengths of its arguments and its result.
    lengths: Vec<usize>,
    /// The index of the argument that has the active contacts.
    switches: Option<usize>,
    /// Whether one argument is a link.
    by_link: bool,
}

/// Returns the functions of the header that Rust exports, too.
fn functions(header: &str) -> Vec<Declared> {
    let mut functions = Vec::new();
    for line in header.lines().filter(|line| line.ends_with(");")) {
        let (head, arguments) = line.split_once('(').expect("a declaration");
        let name = head.split(' ').next_back().expect("a name").trim_start_matches("ours_");
        // Rust exports no C functions for these.
        if name.starts_with("brge") || name == "random" || name.ends_with("_with") {
            continue;
        }
        let lengths = arguments.split('[').skip(1).map(|size| size.split(']').next().expect("]"));
        let lengths = lengths.map(|size| size.parse().expect("a size")).collect();
        let switches = arguments.split(", ").position(|own| own.contains(" contacts["));
        let by_link = head.starts_with("int");
        functions.push(Declared { name: name.into(), lengths, switches, by_link });
    }
    functions
}

/// Returns a program that calls the functions of both with the same numbers, in general position, and compares the
/// results. The numbers are close to zero, some multiples of 2 pi, close to the limit of the fast reduction of angles,
/// and beyond that limit.
fn harness(functions: &[Declared], real: &str) -> String {
    let mut text = format!(
        "#include <math.h>\n#include <stddef.h>\n#include <stdio.h>\n#include <string.h>\n#include \"ours.h\"\n\
         typedef {real} real;\n\
         static unsigned long long state = 1;\n\
         static real number(int round) {{\n\
         state = state * 6364136223846793005ULL + 1442695040888963407ULL;\n\
         real x = (real)(state >> 33) / (real)2147483648.0 * (real)4.0 - (real)2.0;\n\
         static const real scales[4] = {{ 1.0, 50.0, 1500.0, 1e7 }};\n\
         return x * scales[round % 4];\n}}\n\
         static int same(const real *a, const real *b, int n) {{\n\
         int i;\nfor (i = 0; i < n; ++i) {{\n\
         if (memcmp(a + i, b + i, sizeof *a) != 0 && !(a[i] != a[i] && b[i] != b[i])) {{ return 0; }}\n}}\nreturn 1;\n}}\n"
    );
    let mut main = String::new();
    for Declared { name, lengths, switches, by_link } in functions {
        let (arguments, result) = lengths.split_at(lengths.len() - 1);
        let (result, scalar) = (result[0], SCALARS.contains(&name.as_str()));
        let declared: Vec<String> =
            (0..arguments.len()).map(|i| format!("const real *a{i}")).collect();
        let declared = declared.join(", ");
        let named: Vec<String> = (0..arguments.len()).map(|i| format!("a{i}")).collect();
        let named = named.join(", ");
        let prototype = match (scalar, by_link) {
            (true, _) => format!("real theirs_{name}({declared});"),
            (false, true) => format!("_Bool theirs_{name}({declared}, size_t link, real *out);"),
            (false, false) => format!("void theirs_{name}({declared}, real *out);"),
        };
        let _ = writeln!(text, "{prototype}");
        let _ = writeln!(main, "for (round = 0; round < 12; ++round) {{");
        for (i, length) in arguments.iter().enumerate() {
            // A contact is active (1) or not (0).
            let number = if switches == &Some(i) { "number(round) > 0" } else { "number(round)" };
            let _ = writeln!(
                main,
                "real a{i}[{length}];\nfor (i = 0; i < {length}; ++i) {{ a{i}[i] = {number}; }}"
            );
        }
        let _ = writeln!(main, "real x[{result}];\nreal y[{result}];");
        let (ours, theirs) = (format!("ours_{name}({named}"), format!("theirs_{name}({named}"));
        let _ = match (scalar, by_link) {
            (true, _) => writeln!(main, "{ours}, x);\ny[0] = {theirs});"),
            (false, true) => writeln!(
                main,
                "if ({ours}, OURS_LINKS, x) != 0) {{ printf(\"no such link\"); return 1; }}\n\
                 unsigned int link = (unsigned int)round % OURS_LINKS;\n\
                 if ({ours}, link, x) != 1 || !{theirs}, link, y)) {{ printf(\"link\"); return 1; }}"
            ),
            (false, false) => writeln!(main, "{ours}, x);\n{theirs}, y);"),
        };
        let _ = writeln!(
            main,
            "for (i = 0; i < {result}; ++i) {{ moved += x[i] != 0; }}\n\
             if (!same(x, y, {result})) {{ printf(\"{name} differs\\n\"); }}\n}}"
        );
    }
    text + &format!(
        "int main(void) {{\nint i;\nint round;\nint moved = 0;\n{main}\
         printf(\"%s\\n\", moved > 100 ? \"done\" : \"nothing moved\");\nreturn 0;\n}}\n"
    )
}

/// The functions that return one number.
const SCALARS: [&str; 3] = ["kinetic_energy", "potential_energy", "reach"];

/// Compares generated C with self-contained generated Rust.
fn compare(name: &str, builder: &Builder, float: FloatType) {
    let builder = builder.clone().scalar(float);
    let (folder, header) = compiled(name, &builder);
    let rust = builder.type_name("Theirs").self_contained().c_functions("theirs");
    rust.write(folder.join("theirs.rs")).expect("good");
    let rustc = std::env::var_os("RUSTC").unwrap_or("rustc".into());
    let arguments = ["--edition=2024", "--crate-type=staticlib", "--crate-name=theirs"];
    let mut command = Command::new(rustc);
    command.args(arguments).args(["-C", "opt-level=0", "-C", "panic=abort", "--cap-lints=allow"]);
    command.arg("theirs.rs").current_dir(&folder);
    run(&mut command);
    let functions = functions(&header);
    assert!(functions.len() > 10, "{functions:?}");
    let real = if float == FloatType::F64 { "double" } else { "float" };
    std::fs::write(folder.join("main.c"), harness(&functions, real)).expect("writes");
    for compiler in compilers() {
        let mut command = Command::new(compiler);
        command.args(["-std=c99", "-O1", "-ffp-contract=off", "main.c", "ours.c", "-o", "main"]);
        run(command.args(["-L.", "-ltheirs", "-lpthread", "-ldl", "-lm"]).current_dir(&folder));
        assert_eq!(run(&mut Command::new(folder.join("main"))), "done\n", "{name}, {compiler}");
    }
}

fn all(builder: Builder) -> Builder {
    builder.functions(Function::ALL.iter().copied())
}

/// All functions but Hessians and implicit steps, the longest ones.
fn all_but_the_longest(builder: Builder) -> Builder {
    let is_long = |function: &Function| {
        ["hessian", "midpoint", "rk4_derivatives"].iter().any(|word| function.name().contains(word))
    };
    builder.functions(Function::ALL.iter().copied().filter(|function| !is_long(function)))
}

/// A bundle of functions of a state, of which some are of one link and one has several results.
fn with_bundle(builder: Builder, link: &str) -> Builder {
    let bundle = Bundle::new("control")
        .function(Function::MassMatrix)
        .function(Function::ForwardDynamicsDerivatives)
        .of_link(Function::Jacobian, link)
        .function(Function::KineticEnergy)
        .of_link(Function::LinkPose, link);
    builder.bundles([bundle])
}

/// A cost of reaching a target, with derivatives.
struct Reach;

impl UserFunction<3> for Reach {
    fn docs(&self) -> String {
        "Returns the squared distance of the wrist to `target`, times `weight`.".into()
    }

    fn arguments(&self) -> [UserArgument; 3] {
        [
            UserArgument::Q,
            UserArgument::numbers("target", 3),
            UserArgument::number("weight").variable(),
        ]
    }

    fn evaluate<S: Scalar>(
        &self,
        robot: &mut Interpreter<S>,
        [q, target, weight]: [&[S]; 3],
    ) -> Result<Vec<S>, UserError> {
        let link = robot.model().frame_index("wrist_3_link").ok_or("there is no wrist")?;
        let pose = robot.link_pose(q, link)?;
        let squares = pose.translation.iter().zip(target).map(|(&x, &t)| (x - t) * (x - t));
        Ok(vec![weight[0] * squares.fold(S::zero(), |sum, square| sum + square)])
    }
}

#[test]
fn an_arm_computes_the_bits_of_rust() {
    let arm = with_bundle(robot("ur5"), "wrist_3_link").function("reach", Reach);
    compare("ur5", &arm, FloatType::F64);
}

#[test]
fn single_precision_computes_the_bits_of_rust() {
    compare("pendulum_f32", &all(robot("double_pendulum")), FloatType::F32);
}

#[test]
#[ignore = "slow: rustc, gcc and clang compile all functions"]
fn all_functions_of_an_arm_compute_the_bits_of_rust() {
    compare("ur5_f64", &with_bundle(all(robot("ur5")), "wrist_3_link"), FloatType::F64);
    compare(
        "ur5_f32",
        &with_bundle(all_but_the_longest(robot("ur5")), "wrist_3_link"),
        FloatType::F32,
    );
}

/// A bundle in C gives the numbers of its functions in C.
#[test]
fn a_bundle_computes_its_functions() {
    let alone = [
        Function::MassMatrix,
        Function::ForwardDynamicsDerivatives,
        Function::Jacobian,
        Function::KineticEnergy,
        Function::LinkPose,
    ];
    let builder = robot("ur5").functions(alone).runtime_gravity();
    let builder = with_bundle(builder, "forearm_link");
    let (folder, header) = compiled("bundle", &builder);
    let declared =
        "void ours_control(const double q[6], const double qd[6], const double tau[6], double out[";
    assert!(header.contains(declared), "{header}");
    assert!(header.contains("void ours_control_with(const double q[6], const double qd[6], const double tau[6], const double params[3], "));
    let main = r#"
        #include <math.h>
        #include <stdio.h>
        #include "ours.h"
        static int at = 0;
        static int differ = 0;
        static double all[36 + 6 + 3 * 36 + 36 + 1 + 12];
        static void compare(const double *x, int n)
        {
            int i;
            for (i = 0; i < n; ++i, ++at) {
                if (!(fabs(x[i] - all[at]) <= 1e-11 * (1.0 + fabs(x[i])))) { ++differ; }
            }
        }
        int main(void)
        {
            const double q[6] = { 0.3, -1.2, 0.8, 0.4, 1.9, -0.7 };
            const double qd[6] = { 0.5, -0.3, 1.1, 0.2, -0.9, 0.6 };
            const double tau[6] = { 10.0, -20.0, 5.0, 1.0, -2.0, 0.5 };
            const double gravity[3] = { 1.0, -2.0, -8.0 };
            double x[200];
            ours_control_with(q, qd, tau, gravity, all);
            ours_mass_matrix_with(q, gravity, x);
            compare(x, 36);
            ours_forward_dynamics_derivatives_with(q, qd, tau, gravity, x);
            compare(x, 6 + 3 * 36);
            ours_jacobian(q, OURS_LINK_FOREARM_LINK, x);
            compare(x, 36);
            ours_kinetic_energy_with(q, qd, gravity, x);
            compare(x, 1);
            ours_link_pose(q, OURS_LINK_FOREARM_LINK, x);
            compare(x, 12);
            printf("%d %d\n", at, differ);
            return 0;
        }
"#;
    std::fs::write(folder.join("main.c"), main).expect("writes");
    for compiler in compilers() {
        let mut command = Command::new(compiler);
        command.args(STRICT).args(["-O1", "main.c", "ours.c", "-o", "main", "-lm"]);
        run(command.current_dir(&folder));
        assert_eq!(
            run(&mut Command::new(folder.join("main"))),
            "199 0
",
            "{compiler}"
        );
    }
}

#[test]
#[ignore = "slow: rustc, gcc and clang compile large robots"]
fn all_joint_types_compute_the_bits_of_rust() {
    compare("zoo_f64", &all_but_the_longest(robot("joint_zoo")), FloatType::F64);
    compare("zoo_f32", &all_but_the_longest(robot("joint_zoo")), FloatType::F32);
}

#[test]
#[ignore = "slow: rustc, gcc and clang compile large robots"]
fn loops_and_floating_bases_compute_the_bits_of_rust() {
    compare("five_bar", &all(robot("five_bar")), FloatType::F64);
    let floating = robot("quadruped").functions(LIMBS).base(Base::Floating);
    compare("floating", &floating, FloatType::F64);
}

#[test]
#[ignore = "slow: rustc, gcc and clang compile large robots"]
fn contacts_compute_the_bits_of_rust() {
    let point = |name: &str, link: &str, at: [f64; 3]| Contact {
        name: name.into(),
        kind: if at[0] > 0.0 { ContactKind::Surface } else { ContactKind::Point },
        end: LoopEnd { link: link.into(), xyz: at, rpy: at },
    };
    let builder = robot("quadruped").base(Base::Floating).functions(LIMBS.into_iter().chain([
        Function::ConstrainedForwardDynamics,
        Function::ConstraintResidual,
        Function::ProjectConstraints,
        Function::ContactImpulse,
        Function::ConstrainedInverseDynamics,
        Function::ConstraintJacobian,
        Function::ConstraintBiasAcceleration,
        Function::OperationalInertia,
    ]));
    let builder = builder.contacts([
        point("left", "front_left_foot", [0.0, 0.01, -0.02]),
        point("right", "hind_right_foot", [0.03, -0.01, 0.02]),
    ]);
    let (found, _) = builder.generate_c().expect("good");
    let declared = "const double contacts[2], const double settings[52], double out[43]";
    assert!(found.header.contains(declared), "{}", found.header);
    compare("contacts", &builder, FloatType::F64);
}

/// First derivatives of accelerations and wrenches, and second derivatives, which have an argument of wrenches.
#[test]
fn derivatives_with_a_contact_compute_the_bits_of_rust() {
    let end = LoopEnd { link: "lower".into(), xyz: [0.1, 0.2, -0.3], rpy: [0.1, 0.2, 0.3] };
    let contact = Contact { name: "toe".into(), kind: ContactKind::Point, end };
    let functions = Function::DEFAULT.iter().filter(|function| !function.row().of_constraints);
    let functions = functions.copied().chain([
        Function::ConstrainedForwardDynamicsDerivatives,
        Function::ConstrainedForwardDynamicsHessian,
    ]);
    let builder = robot("double_pendulum").functions(functions).contacts([contact]);
    let (found, _) = builder.generate_c().expect("good");
    let declared =
        "const double cotangent[2], const double wrench_cotangent[6], const double contacts[1]";
    assert!(found.header.contains(declared), "{}", found.header);
    compare("second_derivatives", &builder, FloatType::F64);
}

#[test]
#[ignore = "slow: rustc, gcc and clang compile large robots"]
fn shared_limbs_compute_the_bits_of_rust() {
    compare("quadruped", &robot("quadruped").share().functions(LIMBS), FloatType::F64);
}

/// Functions of one state that are short, besides forward and inverse dynamics.
const SHORT: [Function; 11] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::GravityTorques,
    Function::KineticEnergy,
    Function::PotentialEnergy,
    Function::CenterOfMass,
    Function::CentroidalMomentum,
    Function::Integrate,
    Function::Difference,
    Function::VelocityToQdot,
    Function::Normalize,
];

#[test]
fn loops_over_bodies_compute_the_bits_of_rust() {
    let small = |name: &str| robot(name).functions(SHORT).code(CodeForm::Small);
    compare("looped_zoo", &small("joint_zoo"), FloatType::F64);
    compare("looped_floating", &small("quadruped").base(Base::Floating), FloatType::F32);
    compare("looped_gravity", &small("arm6").runtime_gravity(), FloatType::F64);
}

/// Returns a chain of joints in general position.
fn chain(joints: usize) -> Builder {
    let mut text = String::from("<robot name='chain'><link name='0'/>");
    for i in 1..=joints {
        let x = (0.7 * i as f64).sin();
        let _ = write!(
            text,
            "<joint name='{i}' type='continuous'><origin xyz='0.1 {x} 0.3' rpy='0.3 {x} -0.4'/>\
             <axis xyz='0.6 0.48 0.64'/><parent link='{}'/><child link='{i}'/></joint>\
             <link name='{i}'><inertial><origin xyz='{x} 0.1 0.2'/><mass value='{}'/>\
             <inertia ixx='1' iyy='1.1' izz='1.2' ixy='0.1' ixz='0' iyz='0.05'/></inertial></link>",
            i - 1,
            2.0 + x,
        );
    }
    Builder::new().urdf_text(text + "</robot>", "chain.urdf").functions([Function::ForwardDynamics])
}

/// The instructions of loops take as many bytes for 112 joints as for 14.
#[test]
fn the_instructions_of_loops_do_not_grow_with_the_robot() {
    let bytes = |joints: usize, code: CodeForm| -> usize {
        let name = format!("chain{joints}_{code:?}");
        let (folder, _) = compiled(&name, &chain(joints).code(code));
        let mut command = Command::new("gcc");
        command.args(["-std=c99", "-O2", "-c", "ours.c", "-o", "ours.o"]).current_dir(&folder);
        run(&mut command);
        let sizes = run(Command::new("size").args(["-A", "ours.o"]).current_dir(&folder));
        let lines = sizes.lines().filter(|line| line.starts_with(".text"));
        let sizes = lines.filter_map(|line| line.split_whitespace().nth(1)?.parse::<usize>().ok());
        sizes.sum()
    };
    let [short, long] = [14, 112].map(|joints| bytes(joints, CodeForm::Small));
    assert!(short.abs_diff(long) < 64 && long < MAX_LOOP, "{short} {long}");
    assert!(bytes(14, CodeForm::Fast) > 5 * short);
}

/// The largest number of bytes of forward dynamics of a chain in loops, with its own sine and cosine, by gcc.
const MAX_LOOP: usize = 9000;

/// On each body, the links after the eighth share a function; each has a row of a table.
/// Returns three bodies with 11, 1 and 11 links.
fn comb() -> Builder {
    let mut text = String::from("<robot name='comb'><link name='b0'/>");
    for body in 0..3 {
        for i in 0..[11, 0, 10][body] {
            let x = 0.1 * i as f64 + 0.3 * body as f64;
            let _ = write!(
                text,
                "<link name='f{body}_{i}'/><joint name='fix{body}_{i}' type='fixed'><parent link='b{body}'/>\
                 <child link='f{body}_{i}'/><origin xyz='{x} {} {}' rpy='{} {x} {}'/></joint>",
                0.2 - x,
                0.5 * x,
                0.7 - x,
                1.1 * x,
            );
        }
        if body < 2 {
            let _ = write!(
                text,
                "<joint name='j{body}' type='continuous'><parent link='b{body}'/><child link='b{}'/>\
                 <origin xyz='0.1 -0.2 0.3' rpy='0.4 0.5 -0.9'/><axis xyz='0.6 0.48 0.64'/></joint>\
                 <link name='b{}'><inertial><origin xyz='0.1 0.02 -0.03'/><mass value='1.5'/>\
                 <inertia ixx='0.3' iyy='0.4' izz='0.5' ixy='0.01' ixz='0.02' iyz='-0.03'/></inertial></link>",
                body + 1,
                body + 1,
            );
        }
    }
    Builder::new().urdf_text(text + "</robot>", "comb.urdf").functions(LIMBS)
}

#[test]
fn many_links_of_one_body_compute_the_bits_of_rust() {
    let source = comb().generate_c().expect("good").0.source;
    assert!(source.contains("static const double comb_placements[7][12]"));
    for function in ["link_pose_on_1(", "jacobian_on_0(", "link_poses_placed("] {
        assert!(source.contains(&format!("static void comb_{function}")), "{function}");
    }
    compare("comb_f64", &comb(), FloatType::F64);
}

#[test]
#[ignore = "slow: rustc, gcc and clang compile large robots"]
fn many_links_of_one_body_compute_the_bits_of_rust_in_single_precision() {
    compare("comb_f32", &comb(), FloatType::F32);
}

/// Functions of equal limbs, and cheap functions.
const LIMBS: [Function; 21] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::BiasForces,
    Function::GravityTorques,
    Function::MassMatrix,
    Function::KineticEnergy,
    Function::PotentialEnergy,
    Function::CenterOfMass,
    Function::CenterOfMassJacobian,
    Function::CentroidalMomentum,
    Function::CentroidalMomentumMatrix,
    Function::LinkPoses,
    Function::LinkPose,
    Function::LinkVelocity,
    Function::Jacobian,
    Function::BiasAcceleration,
    Function::LocalJacobian,
    Function::Integrate,
    Function::Difference,
    Function::VelocityToQdot,
    Function::Normalize,
];

#[test]
fn run_time_parameters_compile_and_have_their_defaults() {
    let builder = robot("gripper").runtime_gravity();
    let links = builder.generate().expect("good").model.links().to_vec();
    let [replaced, loaded] = [1, 2].map(|link: usize| links[link].name.clone());
    let builder = builder.runtime_inertia([replaced]).payload([loaded]);
    let (folder, header) = compiled("parameters", &builder);
    assert!(header.contains("extern const double ours_default_parameters[23];"));
    assert!(header.contains(
        "void ours_gravity_torques_with(const double q[4], const double params[23], double out[4]);"
    ));
    // Gravity, the inertia of the description, and no payload.
    let source = std::fs::read_to_string(folder.join("ours.c")).expect("the source");
    let (_, defaults) = source.split_once("ours_default_parameters[23] = { ").expect("defaults");
    let defaults = defaults.split_once(" };").expect("an end").0.split(", ");
    let defaults: Vec<f64> = defaults.map(|x| x.parse().expect("a number")).collect();
    let own = builder.generate().expect("good").model;
    let own = own.frames().iter().find(|frame| frame.link == Some(1)).expect("a link").inertial;
    assert_eq!(defaults[..3], [0.0, 0.0, -9.81]);
    assert_eq!(defaults[3], own.mass);
    assert_eq!(defaults[4..7], own.center_of_mass);
    assert_eq!(defaults[7..13], own.inertia);
    assert_eq!(defaults[13..], [0.0; 10]);
    assert!(header.contains("void ours_gravity_torques(const double q[4], double out[4]);"));
    assert!(header.contains("void ours_brge_solve(const double factors["));
}

/// The description's names become parts of identifiers and nothing else.
#[test]
fn names_cannot_break_out() {
    let text = r#"<robot name="a */ #error b"><link name="w */ x"/>
        <joint name="j" type="continuous"><parent link="w */ x"/><child link="int"/></joint>
        <link name="int"><inertial><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;
    let builder = Builder::new().urdf_text(text, "a.urdf");
    let (_, header) = compiled("names", &builder);
    assert!(header.contains("OURS_LINK_W_X = 0,\n    OURS_LINK_INT = 1"), "{header}");
    assert_eq!(builder.generate_c().expect("good").0.prefix, "aerror_b");
}
