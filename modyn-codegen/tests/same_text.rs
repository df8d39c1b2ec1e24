//! The generated code of many robots is fixed: `snapshots/` has a few functions of three small robots to read, and
//! `same_text.hashes` a hash for each robot and set of options.
//!
//! A change that should not alter generated code must leave these files unchanged. Any other change writes them again:
//!
//! ```console
//! INSTA_UPDATE=always UPDATE_SNAPSHOTS=1 cargo test --release -p modyn-codegen same_text::
//! ```
//!
//! With `MODYN_TEXTS=folder` the test writes the texts to that folder, for a comparison with another commit. The hash
//! covers neither comments nor the part of the runtime in self-contained files.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use modyn_codegen::Base;
use modyn_codegen::{Builder, CodeForm, FloatType, Function, Generated};
use rayon::prelude::*;

/// Robots that take seconds: revolute and prismatic joints, mimics, friction and a loop.
const SMALL: &[&str] = &["gripper", "mimic_gripper", "four_bar"];

/// Sets of options, with their names.
type Options = (&'static str, fn(Builder) -> Builder);

const OPTIONS: &[Options] = &[
    ("default", |b| b),
    ("all", all),
    ("all f32", |b| all(b).scalar(FloatType::F32)),
    ("all floating", |b| all(b).base(Base::Floating)),
    ("all share", |b| all(b).share_limbs()),
    ("all floating share f32", |b| {
        all(b).base(Base::Floating).share_limbs().scalar(FloatType::F32)
    }),
    ("all self_contained", |b| all(b).self_contained()),
    ("all self_contained share f32", |b| {
        all(b).self_contained().share_limbs().scalar(FloatType::F32)
    }),
    ("all gravity c", |b| all(b).runtime_gravity().c_functions("robot")),
    ("all parameters", |b| with_inertia(all(b).runtime_gravity())),
    ("small", small),
    ("small floating gravity", |b| small(b).base(Base::Floating).runtime_gravity()),
    ("long", long),
    ("long floating", |b| long(b).base(Base::Floating)),
    ("floating self_contained parameters c", |b| {
        with_inertia(b.base(Base::Floating).self_contained()).c_functions("robot")
    }),
];

/// Functions that do not fit into one text with all others if the robot is a humanoid.
const LONG: &[Function] = &[
    Function::StepSemiImplicitHessian,
    Function::StepImplicitMidpoint,
    Function::StepImplicitMidpointDerivatives,
    Function::InverseDynamicsHessianBatch,
    Function::ForwardDynamicsHessianBatch,
];

fn all(builder: Builder) -> Builder {
    // Its text is too long for a humanoid with a floating base.
    let is_long =
        |function: &Function| LONG.contains(function) || *function == Function::StepRk4Derivatives;
    builder.functions(Function::ALL.iter().copied().filter(|function| !is_long(function)))
}

/// Loops over bodies.
fn small(builder: Builder) -> Builder {
    let functions = [Function::ForwardDynamics, Function::InverseDynamics];
    builder.functions(functions).code(CodeForm::Looped)
}

fn long(builder: Builder) -> Builder {
    builder.functions(LONG.iter().copied())
}

/// Makes the inertia of the last moving link an argument, and a payload of the first one.
fn with_inertia(builder: Builder) -> Builder {
    let only = builder.clone().functions([Function::PotentialEnergy]).generate();
    let model = only.ok().map(|only| only.model);
    let links = model.as_ref().map_or(&[][..], |model| model.moving_links());
    let name = |link: Option<&modyn_runtime::model::MovingLink>| link.map(|link| link.name.clone());
    builder.runtime_inertia(name(links.last())).payload(name(links.first()))
}

/// Returns the paths of the robots, by name.
fn robots() -> BTreeMap<String, PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folders = ["robots", "tests/golden"].map(|folder| root.join(folder));
    let files = folders.iter().flat_map(|folder| std::fs::read_dir(folder).expect("a folder"));
    let files = files.map(|file| file.expect("a file").path());
    let robots = files.filter(|file| file.extension().is_some_and(|end| end == "urdf"));
    robots.map(|file| (file.file_stem().expect("a name").to_string_lossy().into(), file)).collect()
}

/// Returns the generated items without comments and without the runtime.
fn code(generated: &Generated) -> String {
    let own = generated.text.split("\npub mod runtime {").next().unwrap_or_default();
    let lines = own.lines().filter(|line| !line.trim_start().starts_with("//"));
    let mut code = lines.fold(String::new(), |text, line| text + line + "\n");
    for (name, count) in &generated.static_operations {
        let _ = writeln!(code, "{name} {}", count.total());
    }
    code
}

/// Returns the FNV-1a hash, 64 bits.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
fn code_of_small_robots() {
    let code = |name: &str, with: fn(Builder) -> Builder| {
        let generated = with(Builder::new().urdf(&robots()[name])).generate().expect("good");
        insta::assert_snapshot!(name, code(&generated));
    };
    code("double_pendulum", |b| b.functions([Function::ForwardDynamics, Function::Jacobian]));
    code("four_bar", |b| b.functions([Function::ConstraintJacobian]).scalar(FloatType::F32));
    code("gripper", |b| b.functions([Function::InverseDynamics]).runtime_gravity());
}

#[test]
fn generated_code_is_the_same() {
    assert!(compare(|robot| SMALL.contains(&robot)) >= 40);
}

#[test]
#[ignore = "slow: large robots"]
fn generated_code_of_large_robots_is_the_same() {
    assert!(compare(|robot| !SMALL.contains(&robot)) >= 200);
}

/// Compares the code of these robots with the hashes, and returns the number of texts. With `UPDATE_SNAPSHOTS` all robots
/// are compared.
fn compare(selected: fn(&str) -> bool) -> usize {
    let update = std::env::var_os("UPDATE_SNAPSHOTS").is_some();
    let texts = std::env::var_os("MODYN_TEXTS").map(PathBuf::from);
    let cases: Vec<_> = robots()
        .into_iter()
        .filter(|(robot, _)| update || selected(robot))
        .flat_map(|(robot, file)| OPTIONS.iter().map(move |one| (robot.clone(), file.clone(), one)))
        .collect();
    let text = |(robot, file, (options, with)): &(String, PathBuf, &Options)| {
        // A robot that cannot have a floating base remains refused.
        let code = with(Builder::new().urdf(file))
            .generate()
            .map_or_else(|e| e.to_string().replace(&*file.to_string_lossy(), ""), |g| code(&g));
        let name = format!("{robot}, {options}");
        if let Some(folder) = &texts {
            std::fs::write(folder.join(format!("{name}.rs")), &code).expect("a folder");
        }
        (name, format!("{:016x}", hash(&code)))
    };
    let found: BTreeMap<String, String> = cases.par_iter().map(text).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/same_text.hashes");
    if update {
        let lines: Vec<String> =
            found.iter().map(|(name, hash)| format!("{hash} {name}\n")).collect();
        std::fs::write(&path, lines.concat()).expect("writes");
    }
    let kept = std::fs::read_to_string(&path).expect("the hashes");
    let kept: BTreeMap<&str, &str> = kept
        .lines()
        .filter_map(|line| line.split_once(' '))
        .map(|(hash, name)| (name, hash))
        .collect();
    let changed =
        |(name, hash): &(&String, &String)| kept.get(name.as_str()) != Some(&hash.as_str());
    let changed: Vec<String> =
        found.iter().filter(changed).map(|(name, hash)| format!("{hash} {name}")).collect();
    assert!(changed.is_empty(), "generated code has changed: {changed:#?}");
    found.len()
}
