//! C++17 with Eigen, by the compiler of the host.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use modyn_codegen::diagnostics::Diagnostics;
use modyn_codegen::plan::{Argument, ArgumentKind, Record, Shape};
use modyn_codegen::{Builder, Emitted, Function, FusedFunction, Target};

use crate::conformance::c::{STRICT, execute, main_of, write};
use crate::conformance::{Arithmetic, BackEnd, Call, Case, Subject, USED, command, folder, robot};

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
