//! C++17 with Eigen, by the compiler of the host.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::plan::{Argument, ArgumentKind, Record, Shape};
use modyn_codegen::{Builder, ContactKind, Emitted, Function, FusedFunction, Target};

use crate::conformance::c::{STRICT, execute, main_of, write};
use crate::conformance::{
    Arithmetic, BackEnd, Call, Case, Subject, USED, command, contact, folder, robot,
};

/// Where Debian's package `libeigen3-dev` has its headers.
const EIGEN: &str = "/usr/include/eigen3";

pub struct Cpp;

/// What a program needs for its calls. A struct of the class has the layout of its numbers.
const HEAD: &str = r#"
#define EIGEN_RUNTIME_NO_MALLOC
#include "ours.hpp"
struct Structured {
    const void *numbers;
    template <class T> operator const T &() const { return *static_cast<const T *>(numbers); }
};
template <int Rows, int Columns> using Given = Eigen::Map<const Ours::Matrix<Rows, Columns>>;
template <std::size_t Size> std::array<bool, Size> flags(const void *numbers) {
    std::array<bool, Size> set;
    for (std::size_t i = 0; i < Size; ++i) set[i] = static_cast<const real *>(numbers)[i] != 0;
    return set;
}
"#;

/// Returns whether the headers of Eigen are installed.
pub fn has_eigen() -> bool {
    Path::new(EIGEN).join("Eigen/Core").exists()
}

/// Returns a robot whose names are keywords, macros, and words of the class.
pub fn keywords() -> Case {
    let names = ["class", "int", "unix", "nq", "Q", "new", "errno", "wchar_t", "Scalar", "*/ x"];
    let mut text = String::from("<robot name='namespace'><link name='auto'/>");
    let parents = std::iter::once("auto").chain(names);
    for (parent, name) in parents.zip(names) {
        let _ = write!(
            text,
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{name}'/><axis xyz='0.6 0 0.8'/>\
             <origin xyz='0.1 0.2 0.3'/><limit lower='-3' upper='3' effort='9' velocity='9'/></joint>\
             <link name='{name}'><inertial><mass value='1'/><origin xyz='0.1 0 0.2'/>\
             <inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>"
        );
    }
    let builder = Builder::new().urdf_text(text + "</robot>", "keywords.urdf");
    Case { name: "keywords", builder: builder.functions(USED) }
}

/// Returns an argument of the class from the array `name`.
fn given(name: &str, argument: &Argument, shape: &Shape) -> String {
    let map = |rows: usize, columns: usize| {
        format!("Given<{rows}, {columns}>(static_cast<const real *>({name}))")
    };
    match shape {
        _ if argument.kind == ArgumentKind::ActiveContacts => {
            format!("flags<{}>({name})", shape.len())
        }
        Shape::Array(element, count, _) => match &**element {
            Shape::Record(Record::Spatial("Vector3"), _) => map(3, *count),
            Shape::Record(..) => format!("Structured{{{name}}}"),
            _ => map(shape.len(), 1),
        },
        Shape::Record(Record::Factorization, _) => map(shape.len(), 1),
        Shape::Scalar => format!("*static_cast<const real *>({name})"),
        Shape::Record(..) => format!("Structured{{{name}}}"),
    }
}

/// Returns the statement of a call.
fn call(robot: &Emitted, call: &Call) -> String {
    let functions = robot.plan.functions.iter();
    let functions = functions.map(|planned| (planned.name.to_owned(), &planned.arguments));
    let factors = robot.plan.factorization.iter();
    let factors = factors.map(|part| (format!("brge_{}", part.name), &part.arguments));
    let (_, arguments) =
        functions.chain(factors).find(|(name, _)| *name == call.function).expect("a function");
    let nonempty = arguments.iter().filter(|(_, shape)| !shape.is_empty()).enumerate();
    let mut passed: Vec<String> =
        nonempty.map(|(i, (argument, shape))| given(&format!("a{i}"), argument, shape)).collect();
    if call.has_parameters {
        let last = call.arguments.len() - 1;
        let count = call.arguments[last].len();
        passed.push(format!("Given<{count}, 1>(static_cast<const real *>(a{last}))"));
    }
    if let Some(link) = call.link {
        passed.push(format!("static_cast<Ours::Link>({link})"));
    }
    let mut text = String::from("Eigen::internal::set_is_malloc_allowed(false);\n        ");
    let _ = write!(text, "auto r = Ours::{}({});\n        ", call.function, passed.join(", "));
    text += "Eigen::internal::set_is_malloc_allowed(true);\n        \
             *static_cast<decltype(r) *>(x) = r;";
    text
}

impl BackEnd for Cpp {
    type Robot = Emitted;

    fn name(&self) -> String {
        "cpp".into()
    }

    fn programs(&self) -> &[&'static str] {
        &["gcc", "g++"]
    }

    fn arithmetic(&self) -> Arithmetic {
        Arithmetic::Separate
    }

    fn has_numbers_of_contacts(&self) -> bool {
        false
    }

    fn make(&self, builder: &Builder) -> Result<Emitted, Diagnostics> {
        builder.emit(Target::Cpp)
    }

    fn run(&self, subject: &Subject<'_, Emitted>, folder: &Path) -> Vec<Vec<f64>> {
        write(subject.robot, folder);
        let main = main_of(subject, HEAD, |one, _| call(subject.robot, one));
        std::fs::write(folder.join("main.cpp"), main).expect("writes");
        let mut gcc = Command::new("gcc");
        gcc.args(STRICT).args(["-Wconversion", "-Wshadow", "-c", "ours.c"]);
        command(gcc.current_dir(folder));
        let mut compile = Command::new("g++");
        compile.args([
            "-std=c++17",
            "-pedantic",
            "-Wall",
            "-Wextra",
            "-Wconversion",
            "-Wshadow",
            "-Werror",
        ]);
        compile.args(["-O1", "-ffp-contract=off", "-isystem", EIGEN, "main.cpp", "ours.o"]);
        command(compile.args(["-o", "main", "-lm"]).current_dir(folder));
        execute(subject, folder, &["./main"])
    }
}

/// Robots have the names of members, records and words of the template; fused functions have names of records, members
/// and keywords.
pub fn compiles_under_names_of_members() {
    let functions = [Function::LinkPoses, Function::StepRk4, Function::GeneralizedForces];
    let fused = ["pose", "matrix", "class", "q"].map(|name| {
        let members = FusedFunction::new(name).function(Function::ForwardDynamics);
        members.function(Function::MassMatrix)
    });
    let fused = robot("double_pendulum").functions(functions).fused(fused);
    for name in ["Link", "Pose", "Matrix", "Eigen", "Step", "Real", "Class", "Members"] {
        let emitted = fused.clone().type_name(name).emit(Target::Cpp).expect(name);
        let folder = folder(&format!("cpp_named_{name}"));
        write(&emitted, &folder);
        let stem = emitted.files[0].name.trim_end_matches(".hpp").to_owned();
        let mut compile = Command::new("g++");
        compile.args(["-std=c++17", "-pedantic", "-Wall", "-Wextra", "-Wshadow", "-Werror"]);
        compile.args(["-isystem", EIGEN, "-fsyntax-only", "-x", "c++", "-include"]);
        command(compile.arg(format!("{stem}.hpp")).arg("/dev/null").current_dir(&folder));
    }
}

/// A rollout is a loop of steps over the columns of its controls, which may be some of a matrix.
pub fn rollouts_are_loops_of_steps() {
    let tip = contact("tip", ContactKind::Point, "lower", [0.1, 0.0, -0.4]);
    let builder = robot("double_pendulum").contacts([tip]).type_name("Ours");
    let emitted = builder.functions([Function::StepRk4, Function::Step]).emit(Target::Cpp);
    let folder = folder("cpp_rollouts");
    write(&emitted.expect("good"), &folder);
    std::fs::write(folder.join("main.cpp"), ROLLOUTS).expect("writes");
    command(Command::new("gcc").args(["-O1", "-c", "ours.c"]).current_dir(&folder));
    let mut compile = Command::new("g++");
    compile.args(["-std=c++17", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-isystem", EIGEN]);
    compile.args(["main.cpp", "ours.o", "-lm", "-o", "main"]);
    command(compile.current_dir(&folder));
    assert_eq!(command(&mut Command::new(folder.join("main"))), "the same\n");
}

const ROLLOUTS: &str = r#"
#include <cstdio>
#define EIGEN_RUNTIME_NO_MALLOC
#include "ours.hpp"

int main() {
    constexpr int steps = 40;
    using State = Eigen::Matrix<double, Ours::nq + Ours::nv, 1>;
    Eigen::Matrix<double, Ours::nv, Eigen::Dynamic> controls(Ours::nv, steps + 3);
    for (int k = 0; k < controls.size(); ++k) controls.data()[k] = 0.02 * (k % 7) - 0.05;
    Ours::StepSettings settings = Ours::default_step_settings();
    settings.surfaces[0].plane.translation[2] = -0.6;
    Eigen::Matrix<double, Ours::nq + Ours::nv, steps> trajectory, by_rk4;
    Ours::Vector<Ours::nq> q(0.3, -0.2), at = q, start = q;
    Ours::Vector<Ours::nv> qd(0.1, 0.4), rate = qd, speed = qd, warm = qd * 0, warm_start = warm;
    Eigen::internal::set_is_malloc_allowed(false);
    Ours::rollout(controls.leftCols<steps>(), 0.01, settings, q, qd, warm, trajectory.data());
    Ours::rollout_rk4(controls.middleCols<steps>(2), 0.01, start, speed, by_rk4.data());
    Eigen::internal::set_is_malloc_allowed(true);
    bool touched = false, same = true;
    for (int k = 0; k < steps; ++k) {
        const auto next = Ours::step(at, rate, controls.col(k), 0.01, warm_start, settings);
        at = next.q, rate = next.qd, warm_start = next.qdd;
        touched = touched || next.forces(2, 0) > 0;
        same = same && (trajectory.col(k) - (State() << at, rate).finished()).isZero(0);
    }
    same = same && at == q && rate == qd && warm == warm_start;
    at << 0.3, -0.2, rate << 0.1, 0.4;
    for (int k = 0; k < steps; ++k) {
        const auto next = Ours::step_rk4(at, rate, controls.col(k + 2), 0.01);
        at = next.q, rate = next.qd;
    }
    same = same && at == start && rate == speed && by_rk4.col(steps - 1) == (State() << at, rate).finished();
    std::puts(touched && same ? "the same" : touched ? "they differ" : "nothing touched");
}
"#;
