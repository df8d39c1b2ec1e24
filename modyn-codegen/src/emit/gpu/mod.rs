//! Prints kernels for graphics processors: one kernel for each function, one thread for each state.
//!
//! Arguments and results are structures of arrays: scalar `j` of state `i` of `n` states is number
//! `j n + i` of its buffer, so that neighbouring threads read neighbouring numbers. Run-time
//! parameters are shared by all states.
//!
//! `function.rs` prints the statements, whose syntax both languages share. A [`Dialect`] has the
//! other syntax: the kernel's head, and the functions that are not operators.
//!
//! A [`rollout`] is another text of the same programs: functions on a thread's own arrays, and
//! kernels that call a time step in a loop.

mod constrained;
mod cuda;
mod function;
mod rollout;
mod wgsl;

use rollout::Rollout;
pub use rollout::{GpuRollout, RolloutBuffer, RolloutForces, RolloutOptions, RolloutSource};

use std::collections::BTreeSet;

use modyn_read::diagnostics::sanitize_for_display;
use modyn_runtime::model::Model;

use super::support::Support;
use super::{Backend, EmitOptions, File, FloatType, PlannedRobot};
use crate::names;
use crate::plan::{Argument, Frames, Kernels, LinkProgram, Plan, Planned, Shape};
use crate::program::{Execution, Program};

/// A language for graphics processors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GpuLanguage {
    /// CUDA C++, for NVRTC or nvcc.
    Cuda,
    /// WGSL, for `WebGPU`; in single precision only.
    Wgsl,
}

/// The back end of a language.
pub(super) struct Gpu(pub GpuLanguage);

impl Backend for Gpu {
    fn execution(&self, _: &EmitOptions) -> Execution {
        Execution::Threads
    }

    fn print(&self, robot: &PlannedRobot<'_>) -> Vec<File> {
        let ending = match self.0 {
            GpuLanguage::Cuda => "cu",
            GpuLanguage::Wgsl => "wgsl",
        };
        vec![File::new(format!("{}.{ending}", robot.stem), print(robot, self.0))]
    }

    fn with_origin(&self, text: &str, origin: &str) -> String {
        format!("// {origin}\n{text}")
    }

    fn scalar(&self, chosen: FloatType) -> FloatType {
        if self.0 == GpuLanguage::Wgsl { FloatType::F32 } else { chosen }
    }

    fn kernels(&self, robot: &PlannedRobot<'_>) -> Vec<GpuKernel> {
        let kernels = kernels(robot.plan, robot.model, &robot.prefix());
        kernels.into_iter().map(|kernel| kernel.description).collect()
    }
}

/// A kernel: a function for many states. Its buffers are the arguments in their order, then the
/// result. In WGSL their bindings in group 0 are counted in this order, and after them comes a
/// uniform `vec4<u32>` whose first component is the number of states.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct GpuKernel {
    /// The name of the entry point.
    pub name: String,
    /// The name of the function.
    pub function: &'static str,
    /// The link of the function, as an index into the description's links; `None` for functions
    /// without a link.
    pub link: Option<usize>,
    /// The arguments.
    pub arguments: Vec<GpuArgument>,
    /// The number of scalars of one state's result.
    pub result: usize,
    /// The number of statements of its program.
    pub statements: usize,
}

/// An argument of a kernel.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct GpuArgument {
    /// The name.
    pub name: String,
    /// The number of scalars.
    pub len: usize,
    /// Whether all states share the numbers, as they share run-time parameters: these are stored
    /// once.
    pub common: bool,
}

/// The program of a kernel with its arguments, some of which may be constants.
struct Kernel<'a> {
    description: GpuKernel,
    docs: String,
    program: &'a Program,
    /// The values of the program's arguments after the kernel's arguments: the placement of a link
    /// that shares a program with other links.
    placement_numbers: Vec<f64>,
}

/// The syntax of a language.
trait Dialect {
    /// Returns the text before all kernels: definitions of the functions that they call.
    fn preamble(&self, used: &BTreeSet<Support>) -> String;

    /// Returns the definition of a whole number that the user's functions can name.
    fn constant(&self, name: &str, value: usize) -> String;

    /// Returns a number.
    fn literal(&self, value: f64) -> String;

    /// Returns the definition of a local value.
    fn define(&self, name: &str, value: &str) -> String;

    /// Returns the statements that define the sine and the cosine of an angle.
    fn sin_cos(&self, angle: &str, sine: &str, cosine: &str) -> String;

    /// Returns `a b + c`, rounded once.
    fn multiply_add(&self, a: &str, b: &str, c: &str) -> String;

    /// Returns the square root.
    fn square_root(&self, x: &str) -> String;

    /// Returns the absolute value.
    fn absolute(&self, x: &str) -> String;

    /// Returns the second value where the first is at least zero, else the third.
    fn select(&self, x: &str, then: &str, otherwise: &str) -> String;

    /// Returns scalar `j` of an argument of this thread's state.
    fn argument(&self, kernel: &GpuKernel, argument: &GpuArgument, j: usize) -> String;

    /// Returns the statement that stores scalar `j` of the result of this thread's state, in a
    /// chunk (`inner`) or in the kernel.
    fn store(&self, kernel: &GpuKernel, j: usize, value: &str, inner: bool) -> String;

    /// Returns entry `i` of the values that an earlier chunk passes on, in a chunk (`inner`) or in
    /// the kernel.
    fn live_value(&self, chunk: usize, i: usize, inner: bool) -> String;

    /// Returns the function of a chunk with this body: chunk `k` passes `values[k]` values on, and
    /// the function reads the values of `live_in` and writes the values of the chunk.
    fn chunk(
        &self,
        kernel: &GpuKernel,
        number: usize,
        live_in: &[usize],
        values: &[usize],
        body: &str,
    ) -> String;

    /// Returns the statements by which the kernel calls a chunk.
    fn call(
        &self,
        kernel: &GpuKernel,
        number: usize,
        live_in: &[usize],
        values: &[usize],
    ) -> String;

    /// Returns the kernel with this body; a function on a thread's own arrays, if [`Storage::Own`].
    fn kernel(&self, kernel: &GpuKernel, docs: &str, body: &str) -> String;

    /// Returns the text before the functions of a rollout: definitions that all its kernels share.
    fn rollout_head(&self, rollout: &Rollout<'_>) -> String;

    /// Returns the kernel of a rollout with this body, after the definitions of `n`, `state`,
    /// `starts`, `start` and `steps`, and of `dt` as an array.
    fn rollout_kernel(&self, rollout: &Rollout<'_>, body: &str) -> String;

    /// Returns the name of a buffer of a rollout.
    fn buffer(&self, buffer: RolloutBuffer) -> String;

    /// Returns the definition of a variable array with these values.
    fn array(&self, name: &str, values: &[String]) -> String;

    /// Returns the definition of a variable array of zeros.
    fn zeros(&self, name: &str, len: usize) -> String;

    /// Returns the syntax of the routines that loops call, whose arguments and results are a
    /// thread's own arrays.
    fn of_routines(&self) -> Box<dyn Dialect>;

    /// Returns the definition of a variable that is zero.
    fn zero(&self, name: &str) -> String;

    /// Returns the statement that defines an array of length `len` as the result of a call.
    fn call_into(&self, name: &str, len: usize, function: &str, arguments: &[String]) -> String;

    /// Returns the first line of a loop that counts from zero to less than `end`.
    fn counting(&self, counter: &str, end: &str) -> String;

    /// Returns the statement that makes the first `len` numbers of a buffer, whose states share
    /// them, an array of the buffer's name; `None` if the buffer is one.
    fn shared_array(&self, buffer: RolloutBuffer, len: usize) -> Option<String>;

    /// Returns the condition under which the states of all steps are stored.
    fn is_recorded(&self) -> &'static str;

    /// Returns the buffers that the user's functions receive as their last arguments.
    fn shared_buffers(&self) -> &'static [RolloutBuffer];
}

impl GpuKernel {
    /// Returns the name without the robot's name, `prefix`: the function's name, followed by the
    /// link's name for a function of a link.
    #[must_use]
    pub fn own_name(&self, prefix: &str) -> &str {
        let name = self.name.strip_prefix(prefix);
        name.and_then(|name| name.strip_prefix('_')).unwrap_or(&self.name)
    }
}

/// The place of a program's arguments and results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Storage {
    /// In the buffers of a kernel, for all states.
    Buffers,
    /// In arrays that a thread has for its own, which compilers keep in registers. Run-time
    /// parameters stay in their buffer.
    Own,
}

/// Returns the syntax of a language.
fn dialect(
    language: GpuLanguage,
    float: FloatType,
    storage: Storage,
    prefix: &str,
) -> Box<dyn Dialect> {
    match language {
        GpuLanguage::Cuda => Box::new(cuda::Cuda { float, storage, rows: None }),
        GpuLanguage::Wgsl => Box::new(wgsl::Wgsl { storage, prefix: prefix.into() }),
    }
}

/// Prints a rollout: a kernel for each time step among the functions of a plan.
pub(super) use rollout::print as print_rollout;

/// Returns the text of all kernels.
fn print(robot: &PlannedRobot<'_>, language: GpuLanguage) -> String {
    let PlannedRobot { model, plan, options, .. } = *robot;
    let prefix = robot.prefix();
    let dialect = dialect(language, options.scalar, Storage::Buffers, &prefix);
    let mut used = BTreeSet::new();
    let mut text = String::new();
    for kernel in &kernels(plan, model, &prefix) {
        text += &function::print(&*dialect, kernel, &mut used);
    }
    head(&*dialect, model, &prefix) + &dialect.preamble(&used) + &text
}

/// The name of the kernel in the text of a function of arrays.
const ROWS_KERNEL: &str = "modyn_rows";

/// Returns the CUDA text of a function of arrays, planned for threads, as
/// [`Builder::emit_rows`](crate::Builder::emit_rows) documents it.
pub(super) fn print_rows(planned: &Planned, lengths: [&[usize]; 2], float: FloatType) -> String {
    let [arguments, results] = lengths;
    let (program, _) = planned.kernels.straight().expect("a function of arrays has one program");
    let argument = |(k, &len)| GpuArgument { name: format!("in{k}"), len, common: false };
    let description = GpuKernel {
        name: ROWS_KERNEL.into(),
        function: planned.name,
        link: None,
        arguments: arguments.iter().enumerate().map(argument).collect(),
        result: results.iter().sum(),
        statements: program.statements.len(),
    };
    let kernel =
        Kernel { description, docs: String::new(), program, placement_numbers: Vec::new() };
    let dialect = cuda::Cuda { float, storage: Storage::Own, rows: Some(results.to_vec()) };
    let mut used = BTreeSet::new();
    let text = function::print(&dialect, &kernel, &mut used);
    let title = format!("// `{}` on rows of numbers, compiled by modyn.\n", planned.name);
    title + &dialect.preamble(&used) + &text
}

/// The largest number of columns of a list of names.
const COLUMNS: usize = 100;

/// Returns the first lines of a text.
fn head(dialect: &dyn Dialect, model: &Model, prefix: &str) -> String {
    let [x, y, z] = model.gravity();
    let mut text = format!(
        "// Dynamics of a robot, compiled by modyn: a kernel a function, a thread a state. SI units, radians;\n\
         // gravity ({x:?}, {y:?}, {z:?}) m/s^2 in world axes. Scalar j of state i of n states is \
         number j n + i of its\n\
         // buffer. Vectors are in the order of the description's joints, depth first; matrices \
         are arrays of columns.\n"
    );
    text += &list("Coordinates q", &model.coordinate_names());
    text += &list("Velocities qd, accelerations and joint forces", &model.velocity_names());
    for (name, value) in [("NQ", model.nq()), ("NV", model.nv())] {
        text += &dialect.constant(&format!("{}_{name}", prefix.to_uppercase()), value);
    }
    text + "\n"
}

/// Returns a comment with a title and names.
fn list(title: &str, names: &[impl AsRef<str>]) -> String {
    let mut text = format!("// {title}:");
    let mut column = text.len();
    let mut names = names.iter().map(|name| sanitize_for_display(name.as_ref())).peekable();
    while let Some(name) = names.next() {
        let end = if names.peek().is_some() { "," } else { "." };
        if column + name.len() + 2 > COLUMNS {
            text += "\n//  ";
            column = 4;
        }
        column += name.len() + 2;
        text += &format!(" {name}{end}");
    }
    text + "\n"
}

/// Returns the kernels of all functions.
fn kernels<'a>(plan: &'a Plan, model: &Model, prefix: &str) -> Vec<Kernel<'a>> {
    let link_names: Vec<&str> = model.links().iter().map(|link| link.name.as_str()).collect();
    let links = names::fields(&link_names, &[]);
    let placements: Vec<[f64; Frames::PLACEMENT]> = plan.frames.placements().collect();
    let mut kernels = Vec::new();
    for planned in plan.functions.iter().filter(|planned| !planned.result.is_empty()) {
        let name = format!("{prefix}_{}", planned.name);
        match &planned.kernels {
            Kernels::Straight { scalar, .. } => {
                kernels.push(kernel(planned, name, None, scalar, Vec::new()));
            }
            Kernels::ByLink(programs) => {
                for (link, LinkProgram { program, placement }) in
                    plan.frames.programs().iter().enumerate()
                {
                    let placement_numbers =
                        placement.map_or(Vec::new(), |row| placements[row].to_vec());
                    let own_name = format!("{name}_{}", links[link]);
                    let program = &programs[*program];
                    kernels.push(kernel(planned, own_name, Some(link), program, placement_numbers));
                }
            }
            Kernels::Poses { .. } => unreachable!("threads share no poses"),
        }
    }
    kernels
}

fn kernel<'a>(
    planned: &Planned,
    name: String,
    link: Option<usize>,
    program: &'a Program,
    placement_numbers: Vec<f64>,
) -> Kernel<'a> {
    let argument = |(argument, shape): &(Argument, Shape)| GpuArgument {
        name: argument.name.into(),
        len: shape.len(),
        common: false,
    };
    let parameters = GpuArgument { name: "params".into(), len: planned.parameters, common: true };
    let arguments = planned.arguments.iter().map(argument).chain([parameters]);
    let description = GpuKernel {
        name,
        function: planned.name,
        link,
        arguments: arguments.filter(|argument| argument.len > 0).collect(),
        result: planned.result.len(),
        statements: program.statements.len(),
    };
    let lines = planned.docs.replace('\n', "\n// ");
    let docs = format!("// {lines}\n// `out`: {}.\n", planned.result.in_words());
    Kernel { description, docs, program, placement_numbers }
}
