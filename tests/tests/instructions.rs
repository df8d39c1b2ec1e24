//! The machine code of batches, and of equal limbs and columns of one state: packed arithmetic of the level's full
//! width, without calls on the common path. A function that is not inlined into the function of a level would lose its
//! vector instructions without a message.

#![cfg(target_arch = "x86_64")]

use std::path::Path;
use std::process::Command;

const CRATE: &str = r#"
modyn::modyn! { pub Arm = "arm7.urdf", functions = [forward_dynamics_batch, mass_matrix_batch] }
modyn::modyn! { pub Single = "arm7.urdf", scalar = f32, functions = [inverse_dynamics_batch] }
modyn::modyn! { pub Quadruped = "quadruped.urdf", functions = [forward_dynamics] }
modyn::modyn! { pub Slopes = "arm7.urdf", functions = [forward_dynamics_derivatives] }
modyn::modyn! { pub Humanoid = "humanoid.urdf", functions = [bias_forces_batch] }
"#;

/// Returns the assembly of a crate with some batches, built as a user builds it.
fn assembly() -> &'static str {
    static ONCE: std::sync::OnceLock<String> = std::sync::OnceLock::new();
    ONCE.get_or_init(compiled)
}

fn compiled() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("instructions");
    std::fs::create_dir_all(folder.join("src")).expect("a folder");
    for robot in ["arm7.urdf", "quadruped.urdf", "humanoid.urdf"] {
        let robots = root.join("robots");
        std::fs::copy(robots.join(robot), folder.join("src").join(robot)).expect("a robot");
    }
    std::fs::copy(root.join("Cargo.lock"), folder.join("Cargo.lock")).expect("a lock file");
    let manifest = format!(
        "[package]\nname = \"instructions\"\nedition = \"2024\"\n[workspace]\n[dependencies]\n\
         modyn = {{ path = {root:?}, default-features = false, features = [\"std\"] }}\n"
    );
    std::fs::write(folder.join("Cargo.toml"), manifest).expect("a file");
    std::fs::write(folder.join("src/lib.rs"), CRATE).expect("a file");
    let mut command = Command::new(env!("CARGO"));
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy();
        if (name.starts_with("CARGO") && name != "CARGO_HOME") || name == "RUSTFLAGS" {
            command.env_remove(&*name);
        }
    }
    let output = command
        .current_dir(&folder)
        .args(["rustc", "--release", "--offline", "--target-dir", "target", "--"])
        .args(["--emit", "asm=all.s", "-C", "codegen-units=1"])
        .output()
        .expect("Cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::read_to_string(folder.join("all.s")).expect("a file")
}

/// The floating-point arithmetic of one function.
#[derive(Debug, Default)]
struct Counts {
    /// The width of the registers in bits, and the number of packed instructions of that width.
    packed: [(usize, usize); 3],
    scalar: usize,
    calls: Vec<String>,
}

impl Counts {
    fn of(lines: &[&str]) -> Self {
        let mut counts = Self { packed: [(128, 0), (256, 0), (512, 0)], ..Self::default() };
        for line in lines {
            let mut words = line.split_whitespace();
            let Some(operation) = words.next() else { continue };
            let rest: String = words.collect();
            if operation.starts_with("call") {
                counts.calls.push(rest);
                continue;
            }
            let name = operation.strip_prefix('v').unwrap_or(operation);
            let arithmetic =
                ["add", "sub", "mul", "div", "sqrt", "fmadd", "fmsub", "fnmadd", "fnmsub"];
            if !arithmetic.iter().any(|start| name.starts_with(start)) {
                continue;
            }
            if name.ends_with("pd") || name.ends_with("ps") {
                let register = ["xmm", "ymm", "zmm"].iter().rposition(|r| rest.contains(r));
                counts.packed[register.expect("a vector")].1 += 1;
            } else if name.ends_with("sd") || name.ends_with("ss") {
                counts.scalar += 1;
            }
        }
        counts
    }
}

/// Returns the functions of an instruction set, by a part of their mangled names (lengths precede names).
fn functions<'a>(lines: &'a [&'a str], mangled: &str) -> Vec<(&'a str, Counts)> {
    let starts = lines
        .iter()
        .enumerate()
        .filter(|(_, line)| line.ends_with(':') && line.starts_with('_') && line.contains(mangled));
    let counts = starts.map(|(start, symbol)| {
        let body = &lines[start..];
        let end = body.iter().position(|line| line.contains(".cfi_endproc")).expect("an end");
        (*symbol, Counts::of(&body[..end]))
    });
    counts.collect()
}

/// Four legs in four lanes are packed, except for packs that are assembled from single numbers. An arm's derivatives
/// have packed code for four columns at once, and scalar code whose products are fused in place.
#[test]
#[ignore = "slow: an optimised build of modyn and of five robots"]
fn limbs_and_columns_are_packed() {
    let text = assembly();
    let lines: Vec<&str> = text.lines().collect();
    let mut found = functions(&lines, "5lanes4avx212run_simd_f64");
    found.sort_by_key(|(_, counts)| counts.scalar);
    let [legs, arm] = &found[..] else { panic!("{found:?}") };
    for (symbol, counts) in [legs, arm] {
        assert!(counts.packed[1].1 >= 100, "{symbol} {counts:?}");
        let known = |call: &String| call.contains("correct") || call.starts_with("*%");
        assert!(counts.calls.iter().all(known), "{symbol} {counts:?}");
    }
    let (symbol, legs) = legs;
    assert!(legs.packed[0].1 + legs.packed[2].1 + legs.scalar < 10, "{symbol} {legs:?}");
    let (symbol, arm) = arm;
    assert!(arm.packed[1].1 >= 300 && arm.scalar < 2000, "{symbol} {arm:?}");
}

#[test]
#[ignore = "slow: an optimised build of modyn and of five robots"]
fn packed_and_of_full_width() {
    let text = assembly();
    let lines: Vec<&str> = text.lines().collect();
    let mut seen = [0; 3];
    for (level, name, width) in [(0, "sse2", 128), (1, "avx2", 256), (2, "avx512", 512)] {
        let mangled = format!("5lanes{}{name}", name.len());
        for (symbol, counts) in functions(&lines, &mangled) {
            if symbol.contains("run_simd") {
                continue;
            }
            let all: usize = counts.packed.iter().map(|(_, n)| n).sum();
            if all + counts.scalar < 50 {
                continue;
            }
            seen[level] += 1;
            assert_eq!(counts.scalar, 0, "{symbol} {counts:?}");
            assert!(
                counts.packed.iter().all(|&(w, n)| w == width || n == 0),
                "{symbol} {counts:?}"
            );
            // The correction of huge angles (its address is in a register where it is called often), and the chunks of
            // long functions.
            let known = |call: &String| {
                ["correct", "outlined", &mangled].iter().any(|name| call.contains(name))
                    || call.starts_with("*%")
            };
            assert!(counts.calls.iter().all(known), "{symbol} {counts:?}");
        }
    }
    assert!(seen.iter().all(|&functions| functions >= 4), "{seen:?}");
}
