//! Times machine code of a Hessian: `machine_code ROBOT.urdf fixed|floating FUNCTION` prints the milliseconds from the text to
//! callable code, the bytes of the code for one state, and the ns of a state, alone (`ns`) and in a batch (`batch`).

use std::error::Error;
use std::time::{Duration, Instant};

use modyn_codegen::{Base, Builder, Function, JointFriction};
use modyn_jit::{Call, Compiled, Options};
use modyn_runtime::Interpreter;

/// A multiple of all numbers of lanes; columns do not begin at multiples of 4,096 bytes.
const STATES: usize = 72;

/// Numbers of at most this magnitude, the same on every machine: a linear congruential generator.
fn numbers(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Returns the least time of many calls, in this unit of seconds.
fn least(unit: f64, seconds: f64, mut call: impl FnMut()) -> f64 {
    let (start, mut best) = (Instant::now(), Duration::MAX);
    while start.elapsed().as_secs_f64() < seconds {
        let first = Instant::now();
        call();
        best = best.min(first.elapsed());
    }
    best.as_secs_f64() / unit
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut next = || arguments.next().ok_or("expected ROBOT.urdf fixed|floating FUNCTION");
    let (path, base, name) = (next()?, next()?, next()?);
    let text = std::fs::read_to_string(&path)?;
    let function = Function::ALL.iter().find(|function| function.name() == name);
    let function = *function.ok_or("there is no such function")?;
    let base = if base == "floating" { Base::Floating } else { Base::Fixed };
    let builder = || {
        let builder = Builder::new().urdf_text(&*text, &*path).base(base);
        builder.joint_friction(JointFriction::None).functions([function])
    };
    let mut options = Options::default();
    let build = |options| Compiled::<f64>::build(&builder(), options);
    println!("ms {:.1}", least(1e-3, 3.0, || drop(build(options))));

    options.batches = true;
    let robot = build(options)?;
    let call: Call<'_, f64> = robot.function(function)?;
    println!("bytes {}", call.size().bytes);
    let interpreter = Interpreter::<f64>::new(robot.model().clone());
    let mut seed = 1;
    let mut states: Vec<Vec<f64>> = Vec::new();
    for (name, shape) in call.arguments() {
        let mut all: Vec<f64> = (0..STATES * shape.len()).map(|_| numbers(&mut seed)).collect();
        match *name {
            "q" => {
                for q in all.chunks_mut(shape.len()) {
                    interpreter.normalize_configuration(q)?;
                }
            }
            "dt" => all.fill(0.01),
            _ => {}
        }
        states.push(all);
    }
    let length = call.result().len();
    let mut results = vec![0.0; STATES * length];
    let of_state = |k: usize| -> Vec<&[f64]> {
        states.iter().map(|all| all.chunks(all.len() / STATES).nth(k).unwrap_or(&[])).collect()
    };
    let each: Vec<Vec<&[f64]>> = (0..STATES).map(of_state).collect();
    let mut refused = false;
    let ns = least(1e-9 * STATES as f64, 1.5, || {
        for (state, result) in each.iter().zip(results.chunks_mut(length)) {
            refused |= call.one(state, result).is_err();
        }
    });
    println!("ns {ns:.1}");
    let all: Vec<&[f64]> = states.iter().map(Vec::as_slice).collect();
    let ns = least(1e-9 * STATES as f64, 1.5, || refused |= call.many(&all, &mut results).is_err());
    println!("batch {ns:.1}");
    if refused { Err("a call was refused".into()) } else { Ok(()) }
}
