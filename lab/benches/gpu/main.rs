//! Time of kernels on the machine's graphics processor, from 256 states to a million.
//!
//! ```text
//! lab/benches/gpu/run measure | lab/record "lab/benches/gpu/run measure" "NOTE" > docs/data/gpu.tsv
//! lab/benches/gpu/run    # measures nothing: compares small batches with the interpreter
//! ```
//!
//! A row has the time of a state in ns: of a call on arrays that are on the processor, which takes memory for the result; and
//! of copying the arguments there and the result back. The time of a call is the median of several passes. A pass starts the
//! kernel so often that it takes some 20 ms, or that its results take 1 GB, and waits once. The time to compile is that from
//! the description to the first result, of one state. Batches too large for the processor's buffers are left out.

use std::path::Path;
use std::time::{Duration, Instant};

use modyn_codegen::{Base, Builder, Function};
use modyn_gpu::{Gpu, GpuArray, GpuError, GpuRobot};
use modyn_runtime::Interpreter;

/// The name in the table, the file in `tests/golden`, the base and the function.
const KERNELS: [(&str, &str, Base, Function); 4] = [
    ("Panda", "panda", Base::Fixed, Function::ForwardDynamics),
    ("Panda", "panda", Base::Fixed, Function::ForwardDynamicsDerivatives),
    ("Solo12, floating base", "solo12", Base::Floating, Function::ForwardDynamics),
    ("G1, floating base", "g1", Base::Floating, Function::ForwardDynamics),
];

const SIZES: [usize; 4] = [256, 4096, 65_536, 1_048_576];

/// The memory of the results that a pass may wait for, bytes.
const MEMORY: usize = 1 << 30;

/// The states that are compared with the interpreter.
const COMPARED: usize = 200;

const TITLES: &str =
    "| robot | kernel | states | ns a state | ns to copy there | ns to copy back | ms to compile |";

/// The result of an expression that fails only if the processor does.
type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

fn builder(file: &str, base: Base, function: Function) -> Builder {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden");
    Builder::new().urdf(golden.join(format!("{file}.urdf"))).base(base).functions([function])
}

/// Returns q, qd and tau of so many states in general position.
fn states(interpreter: &Interpreter<f64>, count: usize) -> [Vec<Vec<f64>>; 3] {
    let (nq, nv) = (interpreter.model().nq(), interpreter.model().nv());
    let mut seed = 1_u64;
    let mut number = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // Numbers that both precisions have.
        f64::from(((seed >> 40) as f32) / 8_388_608.0 - 1.0)
    };
    let mut vectors = |n: usize| -> Vec<Vec<f64>> {
        (0..count).map(|_| (0..n).map(|_| number()).collect()).collect()
    };
    let [mut q, qd, tau] = [vectors(nq), vectors(nv), vectors(nv)];
    for q in &mut q {
        let mut unit = q.clone();
        interpreter.normalize_configuration(&mut unit).expect("lengths");
        *q = unit.iter().map(|x| f64::from(*x as f32)).collect();
    }
    [q, qd, tau]
}

/// Returns states by columns, as kernels have them.
fn columns(states: &[Vec<f64>]) -> Vec<f32> {
    (0..states[0].len()).flat_map(|j| states.iter().map(move |state| state[j] as f32)).collect()
}

/// Returns the median time of `passes` passes.
fn median(passes: usize, mut pass: impl FnMut() -> Fallible<Duration>) -> Fallible<Duration> {
    let mut times = (0..passes).map(|_| pass()).collect::<Fallible<Vec<Duration>>>()?;
    times.sort();
    Ok(times[passes / 2])
}

/// Returns the rows of a kernel.
fn measure(gpu: &Gpu, index: usize) -> Fallible<String> {
    let (name, file, base, function) = KERNELS[index];
    let builder = builder(file, base, function);
    let interpreter = Interpreter::<f64>::new(builder.plan()?.model);
    let upload = |count: usize| -> Fallible<Vec<GpuArray>> {
        let states = states(&interpreter, count);
        states.iter().map(|all| Ok(gpu.upload(&columns(all), count)?)).collect()
    };
    let one = upload(1)?;
    let start = Instant::now();
    let robot = GpuRobot::new(gpu, &builder)?;
    robot.run(function.name(), &one.iter().collect::<Vec<_>>())?.read()?;
    let compile = start.elapsed();
    let mut rows = String::new();
    for count in SIZES {
        let numbers = states(&interpreter, count).map(|all| columns(&all));
        let arrays = upload(count)?;
        let arguments: Vec<&GpuArray> = arrays.iter().collect();
        let result = match robot.run(function.name(), &arguments) {
            Err(error @ GpuError::TooLarge { .. }) => {
                eprintln!("{name}, {}, {count} states are left out: {error}", function.name());
                break;
            }
            result => result?,
        };
        let run = |times: u32| -> Fallible<Duration> {
            let start = Instant::now();
            for _ in 0..times {
                robot.run(function.name(), &arguments)?;
            }
            gpu.wait()?;
            Ok(start.elapsed())
        };
        run(1)?;
        let times = (0.02 / run(1)?.as_secs_f64()).ceil().clamp(1.0, 1e4) as u32;
        let times = times.min((MEMORY / (4 * result.scalars() * count)).max(1) as u32);
        let kernel = median(11, || run(times))? / times;
        let there = median(5, || {
            let start = Instant::now();
            let copies: Vec<GpuArray> =
                numbers.iter().map(|all| gpu.upload(all, count)).collect::<Result<_, _>>()?;
            gpu.wait()?;
            drop(copies);
            Ok(start.elapsed())
        })?;
        let back = median(5, || {
            let start = Instant::now();
            result.read()?;
            Ok(start.elapsed())
        })?;
        let [kernel, there, back] =
            [kernel, there, back].map(|time| time.as_secs_f64() * 1e9 / count as f64);
        rows += &format!(
            "| {name} | `{}` | {count} | {kernel:.3} | {there:.2} | {back:.2} | {:.0} |\n",
            function.name(),
            compile.as_secs_f64() * 1e3,
        );
    }
    Ok(rows)
}

/// Compares the accelerations of a kernel, the first numbers of its result, with the interpreter's.
fn compare(gpu: &Gpu, index: usize) -> Fallible<()> {
    let (name, file, base, function) = KERNELS[index];
    let builder = builder(file, base, function);
    let mut interpreter = Interpreter::<f64>::new(builder.plan()?.model);
    let robot = GpuRobot::new(gpu, &builder)?;
    let all = states(&interpreter, COMPARED);
    let arrays: Vec<GpuArray> =
        all.iter().map(|all| gpu.upload(&columns(all), COMPARED)).collect::<Result<_, _>>()?;
    let found = robot.run(function.name(), &arrays.iter().collect::<Vec<_>>())?.read()?;
    let mut expected = vec![0.0; interpreter.model().nv()];
    let mut errors = Vec::new();
    for i in 0..COMPARED {
        interpreter.forward_dynamics(&all[0][i], &all[1][i], &all[2][i], &mut expected)?;
        let largest = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
        let error =
            |(j, x): (usize, &f64)| (f64::from(found[j * COMPARED + i]) - x).abs() / largest;
        errors.extend(expected.iter().enumerate().map(error));
    }
    // A few states are badly conditioned.
    errors.sort_by(f64::total_cmp);
    let usual = errors[errors.len() * 9 / 10];
    println!("{name}, {}: nine tenths of the errors are below {usual:.1e}", function.name());
    if usual < 1e-3 { Ok(()) } else { Err(format!("{name}: the results are wrong").into()) }
}

fn main() -> Fallible<()> {
    let gpu = Gpu::new()?;
    let all = 0..KERNELS.len();
    if !std::env::args().any(|argument| argument == "measure") {
        return all.into_iter().try_for_each(|index| compare(&gpu, index));
    }
    if gpu.is_software() {
        return Err(
            format!("{} is a software processor, whose times say nothing", gpu.name()).into()
        );
    }
    println!("{TITLES}\n|---|---|---|---|---|---|---|");
    for index in all {
        print!("{}", measure(&gpu, index)?);
    }
    Ok(())
}
