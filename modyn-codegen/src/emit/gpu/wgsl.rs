//! Prints WGSL, in single precision. The language allows a driver to flush subnormal numbers to
//! zero, and to ignore infinities and NaN.
//!
//! Sine and cosine are the polynomials of the runtime, since the language guarantees little about
//! its own. The language lets a compiler reorder sums. Mesa's compiler does, which destroys a
//! reduction by pi in parts. So only angles below [`LIMIT`] are reduced in floating point; there
//! the loss is small. All others are reduced in integers.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use modyn_runtime::{ELEMENTARY_F32, FRAC_1_PI_BITS, PI_BITS, SIN_COS_F32};

use super::rollout::{Rollout, RolloutBuffer};
use super::{Dialect, GpuArgument, GpuKernel, Storage};
use crate::emit::FloatType;
use crate::emit::c;
use crate::emit::support::Support;

/// The threads of a workgroup.
const WORKGROUP: usize = 64;

/// The limit of angles that are reduced in floating point, rad. Their multiple of pi is at most 3.
/// If a compiler adds the parts of pi to one number, the error grows by at most 2.7e-7.
const LIMIT: f64 = 8.0;

/// The words of 1 / pi that the reduction of angles of single precision reads.
const LIMBS: usize = 10;

pub(super) struct Wgsl {
    pub storage: Storage,
    pub prefix: String,
}

/// Returns a number.
#[allow(clippy::cast_possible_truncation)]
fn number(value: f64) -> String {
    let single = value as f32;
    match single {
        _ if single.is_nan() => "bitcast<f32>(modyn_nan_bits)".into(),
        _ if single.is_finite() => c::literal(value, FloatType::F32),
        _ if single > 0.0 => "bitcast<f32>(modyn_infinity_bits)".into(),
        _ => "(-bitcast<f32>(modyn_infinity_bits))".into(),
    }
}

impl Support {
    fn wgsl(self) -> &'static str {
        match self {
            Self::SinCos => include_str!("sin_cos.wgsl"),
            Self::Atan2 => include_str!("atan2.wgsl"),
            Self::Logarithm => include_str!("ln.wgsl"),
            Self::Maximum => include_str!("maximum.wgsl"),
        }
    }
}

/// Returns the value of a polynomial in `variable`, the highest coefficient first.
fn polynomial(variable: &str, coefficients: &[f64]) -> String {
    let (first, rest) = coefficients.split_first().expect("a coefficient");
    let literal = |value: &f64| number(*value);
    rest.iter().fold(literal(first), |sum, c| format!("fma({variable}, {sum}, {})", literal(c)))
}

/// Returns the coefficients of a series, the highest first, from numerators and denominators, the
/// lowest first.
fn series(terms: &[(f64, f64)]) -> Vec<f64> {
    terms.iter().rev().map(|(over, under)| over / under).collect()
}

/// Returns the words of the templates with their values, from the runtime's constants.
fn words() -> Vec<(&'static str, String)> {
    let literal = number;
    let reduced = |x: String, part: &f64| format!("fma(n, {}, {x})", literal(*part));
    let halves = FRAC_1_PI_BITS.iter().flat_map(|word| [word >> 32, word & 0xffff_ffff]);
    let limbs: Vec<String> = halves.take(LIMBS).map(|half| format!("{half:#010x}u")).collect();
    let numbers = &ELEMENTARY_F32;
    vec![
        ("LIMIT", literal(LIMIT)),
        ("LIMBS", LIMBS.to_string()),
        ("FRAC_1_PI_BITS", limbs.join(", ")),
        ("PI_BITS", format!("{:#x}u", PI_BITS >> 32)),
        ("FRAC_1_PI", literal(core::f64::consts::FRAC_1_PI)),
        ("REDUCTION", SIN_COS_F32.minus_pi.iter().fold("x".into(), reduced)),
        ("SINE", polynomial("z", &SIN_COS_F32.sine)),
        ("COSINE", polynomial("z", &SIN_COS_F32.cosine)),
        ("ARCTANGENT", polynomial("z", &series(&numbers.arctangent))),
        ("TAN_15", literal(numbers.tan_15)),
        ("ROOT_3", literal(numbers.root_3)),
        ("PI", literal(numbers.pi.0)),
        ("PI_REST", literal(numbers.pi.1)),
        ("HALF_PI", literal(numbers.half_pi.0)),
        ("HALF_REST", literal(numbers.half_pi.1)),
        ("SIXTH_PI", literal(numbers.sixth_pi.0)),
        ("SIXTH_REST", literal(numbers.sixth_pi.1)),
        ("LOGARITHM", polynomial("z", &series(&numbers.logarithm))),
        ("MIN_POSITIVE", literal(numbers.min_positive)),
        ("TWO_UP", literal(numbers.two_up)),
        ("ROOT_HALF", format!("{:#x}", numbers.root_half_bits)),
        ("LN_2", literal(numbers.ln_2.0)),
        ("LN_2_REST", literal(numbers.ln_2.1)),
    ]
}

impl Dialect for Wgsl {
    fn preamble(&self, used: &BTreeSet<Support>) -> String {
        let words = words();
        // These bits are read from memory: a constant expression must not be infinite or NaN.
        let mut text = String::from(
            "var<private> modyn_nan_bits: u32 = 0x7fc00000u;\nvar<private> modyn_infinity_bits: u32 = 0x7f800000u;\n\n",
        );
        for support in used {
            let function = words.iter().fold(support.wgsl().to_string(), |text, (word, value)| {
                text.replace(&format!("${word}$"), value)
            });
            let _ = writeln!(text, "{function}");
        }
        text
    }

    fn literal(&self, value: f64) -> String {
        number(value)
    }

    fn constant(&self, name: &str, value: usize) -> String {
        format!("const {name} = {value}u;\n")
    }

    fn define(&self, name: &str, value: &str) -> String {
        format!("let {name} = {value};")
    }

    fn sin_cos(&self, angle: &str, sine: &str, cosine: &str) -> String {
        format!(
            "let t{sine} = modyn_sin_cos({angle}); let {sine} = t{sine}.x; let {cosine} = t{sine}.y;"
        )
    }

    fn multiply_add(&self, a: &str, b: &str, c: &str) -> String {
        format!("fma({a}, {b}, {c})")
    }

    fn square_root(&self, x: &str) -> String {
        format!("sqrt({x})")
    }

    fn absolute(&self, x: &str) -> String {
        format!("abs({x})")
    }

    fn select(&self, x: &str, then: &str, otherwise: &str) -> String {
        format!("select({otherwise}, {then}, {x} >= 0.0f)")
    }

    fn argument(&self, kernel: &GpuKernel, argument: &GpuArgument, j: usize) -> String {
        let buffer = format!("{}_{}", kernel.name, argument.name);
        match (argument.common, self.storage) {
            (true, Storage::Own) => {
                format!("{}[{j}u]", self.buffer(RolloutBuffer::Parameters))
            }
            (false, Storage::Own) => format!("{}[{j}u]", own_array(argument)),
            (true, Storage::Buffers) => format!("{buffer}[{j}u]"),
            (false, Storage::Buffers) => format!("{buffer}[{j}u * n + state]"),
        }
    }

    fn store(&self, kernel: &GpuKernel, j: usize, value: &str, inner: bool) -> String {
        match (self.storage, inner) {
            (Storage::Own, true) => format!("(*out)[{j}u] = {value};"),
            (Storage::Own, false) => format!("out[{j}u] = {value};"),
            (Storage::Buffers, _) => format!("{}_out[{j}u * n + state] = {value};", kernel.name),
        }
    }

    fn live_value(&self, chunk: usize, i: usize, inner: bool) -> String {
        if inner { format!("(*chunk{chunk})[{i}]") } else { format!("chunk{chunk}[{i}]") }
    }

    fn chunk(
        &self,
        kernel: &GpuKernel,
        number: usize,
        live_in: &[usize],
        values: &[usize],
        body: &str,
    ) -> String {
        let read_chunks = live_in.iter().chain([&number]);
        let chunks = read_chunks
            .map(|&k| format!(", chunk{k}: ptr<function, array<f32, {}>>", values[k].max(1)));
        let of_state = match self.storage {
            Storage::Buffers => "n: u32, state: u32".into(),
            Storage::Own => {
                let out = format!("out: ptr<function, array<f32, {}>>", kernel.result);
                parameters(kernel).into_iter().chain([out]).collect::<Vec<String>>().join(", ")
            }
        };
        format!(
            "fn {}_chunk{number}({of_state}{}) {{\n{body}}}\n\n",
            kernel.name,
            chunks.collect::<String>()
        )
    }

    fn call(
        &self,
        kernel: &GpuKernel,
        number: usize,
        live_in: &[usize],
        values: &[usize],
    ) -> String {
        let chunks: String =
            live_in.iter().chain([&number]).map(|k| format!(", &chunk{k}")).collect();
        let of_state = match self.storage {
            Storage::Buffers => "n, state".into(),
            Storage::Own => {
                let buffers = kernel.arguments.iter().filter(|argument| !argument.common);
                let names = buffers.map(own_array).chain(["&out"]);
                names.collect::<Vec<&str>>().join(", ")
            }
        };
        format!(
            "    var chunk{number}: array<f32, {}>;\n    {}_chunk{number}({of_state}{chunks});\n",
            values[number].max(1),
            kernel.name
        )
    }

    fn kernel(&self, kernel: &GpuKernel, docs: &str, body: &str) -> String {
        if self.storage == Storage::Own {
            let name = &kernel.name;
            let parameters = parameters(kernel).join(", ");
            let result = format!("array<f32, {}>", kernel.result);
            return format!(
                "{docs}fn {name}({parameters}) -> {result} {{\n    var out: {result};\n{body}    return out;\n}}\n\n"
            );
        }
        let name = &kernel.name;
        let mut buffers = String::new();
        let count = kernel.arguments.len();
        for (i, argument) in kernel.arguments.iter().enumerate() {
            let _ = writeln!(
                buffers,
                "@group(0) @binding({i}) var<storage, read> {name}_{}: array<f32>;",
                argument.name
            );
        }
        format!(
            "{docs}{buffers}@group(0) @binding({count}) var<storage, read_write> {name}_out: array<f32>;\n\
             @group(0) @binding({}) var<uniform> {name}_count: vec4<u32>;\n\n\
             {}{body}}}\n\n",
            count + 1,
            head(name, &format!("{name}_count.x")),
        )
    }

    fn rollout_head(&self, rollout: &Rollout<'_>) -> String {
        let prefix = &rollout.prefix;
        let mut text = format!(
            "struct {prefix}_size {{ count: u32, steps: u32, starts: u32, recorded: u32, dt: f32 }}\n"
        );
        for (i, buffer) in rollout.buffers.iter().enumerate() {
            let access = if buffer.is_result() { "read_write" } else { "read" };
            let name = self.buffer(*buffer);
            let _ = writeln!(
                text,
                "@group(0) @binding({i}) var<storage, {access}> {name}: array<f32>;"
            );
        }
        let count = rollout.buffers.len();
        let _ = writeln!(
            text,
            "@group(0) @binding({count}) var<uniform> {prefix}_sizes: {prefix}_size;\n"
        );
        text
    }

    fn rollout_kernel(&self, rollout: &Rollout<'_>, body: &str) -> String {
        let sizes = format!("{}_sizes", rollout.prefix);
        format!(
            "{}{}    let steps = {sizes}.steps;\n    \
             let starts = {sizes}.starts;\n    let start = state % starts;\n    \
             let recorded = {sizes}.recorded != 0u;\n    let dt = array<f32, 1>({sizes}.dt);\n{body}}}\n\n",
            rollout.docs,
            head(rollout.name, &format!("{sizes}.count")),
        )
    }

    /// The numbers of the user's functions have a name without a prefix.
    fn buffer(&self, buffer: RolloutBuffer) -> String {
        match buffer {
            RolloutBuffer::Data => buffer.name().into(),
            _ => format!("{}_{}", self.prefix, buffer.name()),
        }
    }

    fn array(&self, name: &str, values: &[String]) -> String {
        format!("var {name} = array<f32, {}>({});", values.len(), values.join(", "))
    }

    /// A variable begins with zeros.
    fn zeros(&self, name: &str, len: usize) -> String {
        format!("var {name}: array<f32, {len}>;")
    }

    fn of_routines(&self) -> Box<dyn Dialect> {
        Box::new(Self { storage: Storage::Own, prefix: self.prefix.clone() })
    }

    fn zero(&self, name: &str) -> String {
        format!("var {name} = 0.0f;")
    }

    fn call_into(&self, name: &str, _: usize, function: &str, arguments: &[String]) -> String {
        format!("let {name} = {function}({});", arguments.join(", "))
    }

    fn counting(&self, counter: &str, end: &str) -> String {
        format!("for (var {counter} = 0u; {counter} < {end}; {counter}++) {{")
    }

    fn shared_array(&self, buffer: RolloutBuffer, len: usize) -> Option<String> {
        let place = self.buffer(buffer);
        let numbers: Vec<String> = (0..len).map(|j| format!("{place}[{j}u]")).collect();
        Some(format!("let {} = array<f32, {len}>({});", buffer.name(), numbers.join(", ")))
    }

    fn is_recorded(&self) -> &'static str {
        "recorded"
    }

    /// A function of WGSL names the buffers by itself.
    fn shared_buffers(&self) -> &'static [RolloutBuffer] {
        &[]
    }
}

/// Returns the name of an argument on a thread's own arrays. WGSL reserves some words.
fn own_array(argument: &GpuArgument) -> &str {
    match &*argument.name {
        "active" => "active_",
        "from" => "from_",
        name => name,
    }
}

/// Returns the parameters of a function on a thread's own arrays.
fn parameters(kernel: &GpuKernel) -> Vec<String> {
    let buffers = kernel.arguments.iter().filter(|argument| !argument.common);
    buffers
        .map(|argument| format!("{}: array<f32, {}>", own_array(argument), argument.len))
        .collect()
}

/// Returns the first lines of a kernel, for a number of states.
fn head(name: &str, count: &str) -> String {
    format!(
        "@compute @workgroup_size({WORKGROUP})\n\
         fn {name}(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {{\n    \
         let n = {count};\n    let state = id.y * groups.x * {WORKGROUP}u + id.x;\n    \
         if (state >= n) {{ return; }}\n"
    )
}
