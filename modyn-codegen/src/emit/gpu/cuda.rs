//! CUDA C++, for NVRTC or nvcc. Sine, cosine, arctangent and logarithm return what generated C
//! returns, for all arguments.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::rollout::{Rollout, RolloutBuffer};
use super::{Dialect, GpuArgument, GpuKernel, Storage};
use crate::emit::FloatType;
use crate::emit::c;
use crate::emit::support::Support;

/// The largest number of threads of a block. From it the compiler knows how many registers a thread
/// may have. Without the number of blocks, at least 1, ptxas 12.9 gave 32 registers to a kernel
/// with calls.
const BLOCK: usize = 128;

/// The words before the type of a support function. (Their tables stay `static const`: the indices
/// are counters of loops that the compiler unrolls.) The reduction of large angles, inlined for
/// each angle, would be two thirds of a kernel.
const QUALIFIERS: c::Qualifiers = c::Qualifiers {
    function: "static __device__",
    rare_function: "static __device__ __noinline__",
};

/// The first statements of a kernel: the index of the thread's state.
const THREAD: &str = "    const size_t n = count;\n    \
                      const size_t state = (size_t)blockIdx.x * blockDim.x + threadIdx.x;\n    \
                      if (state >= n) { return; }\n";

pub(super) struct Cuda {
    pub float: FloatType,
    pub storage: Storage,
    /// For a function of arrays with a row of numbers for each state, the lengths of the rows of
    /// its results. A thread's own arrays are then its rows.
    pub rows: Option<Vec<usize>>,
}

impl Cuda {
    fn real(&self) -> &'static str {
        self.float.in_c()
    }

    /// Returns the name of the number of states, if functions need it to find their numbers.
    fn count(&self) -> Option<&'static str> {
        (self.storage == Storage::Buffers).then_some("n")
    }

    /// Returns the name of a function of the mathematical library in this precision.
    fn library(&self, name: &str) -> String {
        match self.float {
            FloatType::F64 => name.into(),
            FloatType::F32 => format!("{name}f"),
        }
    }

    /// Returns the names of the results.
    fn results(&self) -> Vec<String> {
        match &self.rows {
            Some(lengths) => (0..lengths.len()).map(|k| format!("out{k}")).collect(),
            None => vec!["out".into()],
        }
    }

    /// Returns the parameters for the arguments and the results, from the index of the state on.
    fn parameters(&self, kernel: &GpuKernel) -> Vec<String> {
        let real = self.real();
        let arrays = kernel.arguments.iter();
        let arguments = arrays.map(|a| format!("const {real} *__restrict__ {}", a.name));
        let results = self.results().into_iter();
        arguments.chain(results.map(|name| format!("{real} *__restrict__ {name}"))).collect()
    }

    /// Returns the kernel of a function of arrays with this body. Argument `k` of state `i` is row
    /// `i / every{k} % rows{k}` of its array, whose rows are `stride{k}` numbers apart.
    fn rows_kernel(&self, kernel: &GpuKernel, results: &[usize], body: &str) -> String {
        let mut parameters = self.parameters(kernel);
        let mut head = String::new();
        for (k, GpuArgument { name, .. }) in kernel.arguments.iter().enumerate() {
            let numbers = ["every", "rows", "stride"].map(|word| format!("unsigned int {word}{k}"));
            parameters.extend(numbers);
            let row = format!("(unsigned int)state / every{k} % rows{k}");
            let _ = writeln!(head, "    {name} += (size_t)({row}) * stride{k};");
        }
        for (k, len) in results.iter().enumerate() {
            let _ = writeln!(head, "    out{k} += state * {len};");
        }
        parameters.push("unsigned int count".into());
        format!(
            "extern \"C\" __global__ void __launch_bounds__({BLOCK}, 1) {}({})\n{{\n\
             {THREAD}{head}{body}}}\n",
            kernel.name,
            parameters.join(", ")
        )
    }
}

impl Dialect for Cuda {
    fn preamble(&self, used: &BTreeSet<Support>) -> String {
        let functions = c::support(used, self.float, &QUALIFIERS);
        format!(
            "#ifdef __CUDACC_RTC__\n\
             #define NAN __int_as_float(0x7fffffff)\n\
             #define INFINITY __int_as_float(0x7f800000)\n\
             #else\n#include <math.h>\n#endif\n\n{functions}"
        )
    }

    fn constant(&self, name: &str, value: usize) -> String {
        format!("#define {name} {value}\n")
    }

    fn literal(&self, value: f64) -> String {
        c::literal(value, self.float)
    }

    fn define(&self, name: &str, value: &str) -> String {
        format!("const {} {name} = {value};", self.real())
    }

    fn sin_cos(&self, angle: &str, sine: &str, cosine: &str) -> String {
        format!("{} {sine}, {cosine}; modyn_sin_cos({angle}, &{sine}, &{cosine});", self.real())
    }

    fn multiply_add(&self, a: &str, b: &str, c: &str) -> String {
        format!("{}({a}, {b}, {c})", self.library("fma"))
    }

    fn square_root(&self, x: &str) -> String {
        format!("{}({x})", self.library("sqrt"))
    }

    fn absolute(&self, x: &str) -> String {
        format!("{}({x})", self.library("fabs"))
    }

    fn select(&self, x: &str, then: &str, otherwise: &str) -> String {
        format!("({x} >= {}) ? {then} : {otherwise}", self.literal(0.0))
    }

    fn argument(&self, _: &GpuKernel, argument: &GpuArgument, j: usize) -> String {
        match argument.common || self.storage == Storage::Own {
            true => format!("{}[{j}]", argument.name),
            false => format!("{}[{j} * n]", argument.name),
        }
    }

    fn store(&self, _: &GpuKernel, j: usize, value: &str, _: bool) -> String {
        match (self.storage, &self.rows) {
            (_, Some(lengths)) => {
                let mut place = j;
                let mut array = 0;
                while place >= lengths[array] {
                    place -= lengths[array];
                    array += 1;
                }
                format!("out{array}[{place}] = {value};")
            }
            (Storage::Own, None) => format!("out[{j}] = {value};"),
            (Storage::Buffers, None) => format!("out[{j} * n] = {value};"),
        }
    }

    fn live_value(&self, chunk: usize, i: usize, _: bool) -> String {
        format!("chunk{chunk}[{i}]")
    }

    fn chunk(
        &self,
        kernel: &GpuKernel,
        number: usize,
        live_in: &[usize],
        _: &[usize],
        body: &str,
    ) -> String {
        let real = self.real();
        let mut parameters = self.parameters(kernel);
        parameters.extend(self.count().map(|n| format!("size_t {n}")));
        parameters.extend(live_in.iter().map(|k| format!("const {real} *__restrict__ chunk{k}")));
        parameters.push(format!("{real} *__restrict__ chunk{number}"));
        format!(
            "static __device__ __noinline__ void {}_chunk{number}({})\n{{\n{body}}}\n\n",
            kernel.name,
            parameters.join(", ")
        )
    }

    fn call(
        &self,
        kernel: &GpuKernel,
        number: usize,
        live_in: &[usize],
        values: &[usize],
    ) -> String {
        let names = kernel.arguments.iter().map(|argument| argument.name.clone());
        let buffers = names.chain(self.results()).chain(self.count().map(String::from));
        let chunks = live_in.iter().chain([&number]).map(|k| format!("chunk{k}"));
        let arguments: Vec<String> = buffers.chain(chunks).collect();
        format!(
            "    {} chunk{number}[{}];\n    {}_chunk{number}({});\n",
            self.real(),
            values[number].max(1),
            kernel.name,
            arguments.join(", ")
        )
    }

    fn kernel(&self, kernel: &GpuKernel, docs: &str, body: &str) -> String {
        if let Some(results) = &self.rows {
            return self.rows_kernel(kernel, results, body);
        }
        let parameters = self.parameters(kernel).join(", ");
        if self.storage == Storage::Own {
            let name = &kernel.name;
            return format!(
                "{docs}static __device__ __forceinline__ void {name}({parameters})\n{{\n{body}}}\n\n"
            );
        }
        let mut head = String::new();
        for argument in kernel.arguments.iter().filter(|argument| !argument.common) {
            let _ = writeln!(head, "    {} += state;", argument.name);
        }
        format!(
            "{docs}extern \"C\" __global__ void __launch_bounds__({BLOCK}, 1) {}({parameters}, \
             unsigned int count)\n{{\n\
             {THREAD}{head}    out += state;\n{body}}}\n\n",
            kernel.name,
        )
    }

    fn rollout_head(&self, rollout: &Rollout<'_>) -> String {
        format!(
            "// The scalar of all functions, for the user's functions.\ntypedef {} {}_real;\n\n",
            self.real(),
            rollout.prefix
        )
    }

    fn rollout_kernel(&self, rollout: &Rollout<'_>, body: &str) -> String {
        let real = self.real();
        let buffers = rollout.buffers.iter().map(|buffer| {
            let constant = if buffer.is_result() { "" } else { "const " };
            format!("{constant}{real} *__restrict__ {}", buffer.name())
        });
        let time = format!("{real} time_step");
        let numbers = [&*time, "unsigned int steps", "unsigned int starts", "unsigned int count"];
        let parameters: Vec<String> = buffers.chain(numbers.map(String::from)).collect();
        format!(
            "{}extern \"C\" __global__ void __launch_bounds__({BLOCK}, 1) {}({})\n{{\n{THREAD}    \
             const size_t start = state % starts;\n    const {real} dt[1] = {{ time_step }};\n{body}}}\n\n",
            rollout.docs,
            rollout.name,
            parameters.join(", ")
        )
    }

    fn buffer(&self, buffer: RolloutBuffer) -> String {
        buffer.name().into()
    }

    fn array(&self, name: &str, values: &[String]) -> String {
        format!("{} {name}[{}] = {{ {} }};", self.real(), values.len(), values.join(", "))
    }

    fn zeros(&self, name: &str, len: usize) -> String {
        format!("{} {name}[{len}] = {{ {} }};", self.real(), self.literal(0.0))
    }

    fn of_routines(&self) -> Box<dyn Dialect> {
        Box::new(Self { float: self.float, storage: Storage::Own, rows: None })
    }

    fn zero(&self, name: &str) -> String {
        format!("{} {name} = 0;", self.real())
    }

    fn call_into(&self, name: &str, len: usize, function: &str, arguments: &[String]) -> String {
        let arguments =
            arguments.iter().map(|argument| format!("{argument}, ")).collect::<String>();
        format!("{} {name}[{len}]; {function}({arguments}{name});", self.real())
    }

    fn counting(&self, counter: &str, end: &str) -> String {
        format!("for (unsigned int {counter} = 0; {counter} < {end}; ++{counter}) {{")
    }

    fn shared_array(&self, _: RolloutBuffer, _: usize) -> Option<String> {
        None
    }

    fn is_recorded(&self) -> &'static str {
        "trajectory"
    }

    fn shared_buffers(&self) -> &'static [RolloutBuffer] {
        &[RolloutBuffer::Data, RolloutBuffer::Parameters]
    }
}
