//! Runs the robots on the host and writes their results bit for bit into the image, compiles the arm's C source, and
//! writes the memory layout.

use std::error::Error;
use std::fmt::{LowerHex, Write as _};
use std::path::Path;

use robots::{c, double, single};

/// The number of states; every second one has angles beyond the fast argument reduction.
const STATES: usize = 6;

/// Returns numbers from `low` to `high`, spread by steps of the golden ratio.
fn spread(count: usize, seed: usize, low: f64, high: f64) -> Vec<f64> {
    let number =
        |i: usize| ((i + 1) as f64 * 0.618_033_988_749_894_9 + seed as f64 * 0.377).fract();
    (0..count).map(|i| low + (high - low) * number(i)).collect()
}

fn list<T: LowerHex>(bits: impl IntoIterator<Item = T>) -> String {
    let bits: Vec<String> = bits.into_iter().map(|bits| format!("{bits:#x}")).collect();
    format!("[{}]", bits.join(", "))
}

macro_rules! cases {
    ($text:ident, $scalar:ident, $float:ty, $name:ident, $robot:ident) => {{
        use $scalar::$name::$robot as Robot;
        const N: usize = Robot::NV;
        let bits = <$float>::to_bits;
        writeln!(
            $text,
            "pub const {}: [Case<{N}>; {STATES}] = [",
            stringify!($name).to_uppercase()
        )?;
        for state in 0..STATES {
            let turns = if state % 2 == 1 { 1e6 } else { 1.0 };
            let vector = |seed, size: f64| -> [$float; N] {
                let numbers = spread(N, 10 * state + seed, -size, size);
                std::array::from_fn(|i| numbers[i] as $float)
            };
            let (q, qd, tau) = (vector(0, 3.0 * turns), vector(1, 2.0), vector(2, 20.0));
            let brge = Robot::brge(&q);
            let numbers = [brge.log_determinant(), brge.condition_numbers()[0]];
            let poses = Robot::link_poses(&q);
            let pose = poses[poses.len() - 1];
            writeln!(
                $text,
                "Case {{ q: {}, qd: {}, tau: {}, forward: {}, inverse: {}, mass: [{}], solved: {}, \
                 numbers: {}, place: {} }},",
                list(q.map(bits)),
                list(qd.map(bits)),
                list(tau.map(bits)),
                list(Robot::forward_dynamics(&q, &qd, &tau).map(bits)),
                list(Robot::inverse_dynamics(&q, &qd, &tau).map(bits)),
                Robot::mass_matrix(&q).map(|column| list(column.map(bits))).join(", "),
                list(brge.solve(&tau).map(bits)),
                list(numbers.map(bits)),
                list(pose.translation.map(bits)),
            )?;
        }
        writeln!($text, "];")?;
    }};
}

/// Legs that share one function give the same results as legs with a function each.
macro_rules! same_legs {
    ($scalar:ident, $float:ty, $tolerance:literal) => {
        for state in 0..STATES {
            use $scalar::{legs, legs_shared};
            let vector = |seed, size: f64| -> [$float; 12] {
                let numbers = spread(12, 10 * state + seed, -size, size);
                std::array::from_fn(|i| numbers[i] as $float)
            };
            let (q, qd, tau) = (vector(0, 3.0), vector(1, 2.0), vector(2, 20.0));
            let alone = legs::Quadruped::forward_dynamics(&q, &qd, &tau);
            let shared = legs_shared::Quadruped::forward_dynamics(&q, &qd, &tau);
            let largest = alone.iter().fold(0.0, |a: $float, b| a.max(b.abs()));
            if !alone.iter().zip(shared).all(|(a, b)| (a - b).abs() <= $tolerance * largest) {
                return Err(format!("shared legs: {shared:?}, not {alone:?}").into());
            }
        }
    };
}

/// Compiles the arm's C source for the target, as firmware is built.
fn compile_c(out: &Path) -> Result<(), Box<dyn Error>> {
    let single = std::env::var_os("CARGO_FEATURE_F32").is_some();
    let texts = if single { c::SINGLE } else { c::DOUBLE };
    for (name, text) in texts {
        std::fs::write(out.join(name), text)?;
    }
    let mut build = cc::Build::new();
    build
        .compiler("clang")
        .archiver("ar")
        .file(out.join("arm7.c"))
        .include(out)
        .include("include")
        .warnings_into_errors(true);
    // Products and sums stay apart, as on the host; the inspection needs the size of each frame.
    for flag in
        ["-std=c99", "-pedantic", "-ffp-contract=off", "-fno-math-errno", "-fstack-size-section"]
    {
        build.flag(flag);
    }
    // The processor that Rust compiles for.
    let rust_flags = std::env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    if let Some((_, cpu)) =
        rust_flags.split('\u{1f}').find_map(|flag| flag.split_once("target-cpu="))
    {
        build.flag(format!("-mcpu={cpu}"));
    }
    if std::env::var("CARGO_CFG_TARGET_ARCH")? == "riscv32" {
        build.flag("-march=rv32imafc").flag("-mabi=ilp32f");
    }
    build.try_compile("arm7_c")?;
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=include");
    let out = std::env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    let out = Path::new(&out);
    same_legs!(single, f32, 1e-4);
    same_legs!(double, f64, 1e-12);
    let (mut f32s, mut f64s) = (String::new(), String::new());
    cases!(f32s, single, f32, gripper, Gripper);
    cases!(f32s, single, f32, arm7, Arm7);
    cases!(f32s, single, f32, leg, Leg);
    cases!(f32s, single, f32, legs, Quadruped);
    cases!(f32s, single, f32, legs_shared, Quadruped);
    cases!(f64s, double, f64, gripper, Gripper);
    cases!(f64s, double, f64, arm7, Arm7);
    cases!(f64s, double, f64, leg, Leg);
    cases!(f64s, double, f64, legs, Quadruped);
    cases!(f64s, double, f64, legs_shared, Quadruped);
    std::fs::write(out.join("cases_f32.rs"), f32s)?;
    std::fs::write(out.join("cases_f64.rs"), f64s)?;

    let memory = match std::env::var("CARGO_CFG_TARGET_ARCH")?.as_str() {
        // The boards mps2-an386 and mps2-an500.
        "arm" => {
            "MEMORY { FLASH : ORIGIN = 0x00000000, LENGTH = 4M  RAM : ORIGIN = 0x20000000, LENGTH = 4M }\n"
        }
        // The board virt.
        "riscv32" => {
            "MEMORY { RAM : ORIGIN = 0x80000000, LENGTH = 16M }\n\
             REGION_ALIAS(\"REGION_TEXT\", RAM); REGION_ALIAS(\"REGION_RODATA\", RAM);\n\
             REGION_ALIAS(\"REGION_DATA\", RAM); REGION_ALIAS(\"REGION_BSS\", RAM);\n\
             REGION_ALIAS(\"REGION_HEAP\", RAM); REGION_ALIAS(\"REGION_STACK\", RAM);\n"
        }
        // Other targets are checked on the host only.
        _ => return Ok(()),
    };
    compile_c(out)?;
    std::fs::write(out.join("memory.x"), memory)?;
    println!("cargo::rustc-link-search={}", out.display());
    if std::env::var("CARGO_CFG_TARGET_ARCH")? == "riscv32" {
        println!("cargo::rustc-link-arg=-Tmemory.x");
    }
    println!("cargo::rustc-link-arg=-Tlink.x");
    println!("cargo::rustc-link-arg=--nmagic");
    Ok(())
}
