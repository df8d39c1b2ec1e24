//! Functions of many states at a time: a kernel for the runtime's batches, and the public functions
//! that run it.
//!
//! Each state has its own numbers and its own set of active contacts; all states share the settings
//! of constraints and the run-time parameters, which a kernel holds.
//!
//! A kernel has a text of its own, which is inlined into the runtime's functions for each vector
//! instruction set. The functions of one state are not affected.

use std::fmt::Write as _;

use super::Robot;
use super::function::function;
use super::parameter::Parameter;
use super::quantity::Quantity;
use super::shape::Shape;
use crate::intern::intern;
use crate::plan::{self, ArgumentKind, BatchForm, Function, Kernels, Record};

impl Robot<'_> {
    /// Prints everything for the batches of a quantity.
    pub(super) fn batches(&self, text: &mut String, quantity: &Quantity<'_>) {
        let Kernels::Straight { scalar: program, .. } = quantity.kernels else { return };
        let name = name(quantity);
        let parameters = quantity.all_parameters();
        let inlined = format!("{name}_lanes");
        *text += &function(&inlined, &parameters, &quantity.shape, program, self.options.scalar);
        self.kernel(text, quantity);
        self.batch_functions(text, quantity);
    }

    /// Prints the type that loads states and calls the inlined function.
    fn kernel(&self, text: &mut String, quantity: &Quantity<'_>) {
        let float = self.options.scalar.name();
        let runtime = quantity.runtime_parameter().map_or(0, |p| p.shape.len());
        let inputs = count(quantity, BatchForm::Numbers);
        let outputs = quantity.shape.len();
        let flags = match count(quantity, BatchForm::Sets) {
            0 => String::new(),
            flags => format!(", {flags}"),
        };
        let mut body = String::new();
        let mut fields = format!("[{float}; {runtime}]");
        let mut first = 0;
        let mut shared = 0;
        for parameter in &quantity.parameters {
            let Parameter { name, shape, .. } = parameter;
            let all = |each: &dyn Fn(usize) -> String| {
                shape.value(&(0..shape.len()).map(each).collect::<Vec<_>>())
            };
            let value = match parameter.batch_form() {
                BatchForm::Sets => all(&|i| format!("inputs.flag::<{i}>()")),
                BatchForm::Shared => {
                    shared += 1;
                    let _ = write!(fields, ", {}", shape.type_of(float));
                    let numbers = all(&|i| parameter.entry(i));
                    let splat = all(&|i| format!("T::splat({})", parameter.entry(i)));
                    format!("{{ let {numbers} = self.{shared}; {splat} }}")
                }
                BatchForm::Numbers | BatchForm::None => {
                    let start = first;
                    first += shape.len();
                    all(&|i| format!("inputs.get::<{}>()", start + i))
                }
            };
            let _ = writeln!(body, "    let {name} = {value};");
        }
        let mut arguments: Vec<String> =
            quantity.parameters.iter().map(|p| format!("&{}", p.name)).collect();
        if runtime > 0 {
            let all: Vec<String> = (0..runtime).map(|i| format!("T::splat(self.0[{i}])")).collect();
            let _ = writeln!(body, "    let params = [{}];", all.join(", "));
            arguments.push("&params".into());
        }
        arguments.push("&outputs".into());
        let _ = writeln!(body, "    {}_lanes({});", name(quantity), arguments.join(", "));
        let kernel = kernel_name(quantity);
        let _ = writeln!(
            text,
            "struct {kernel}({fields});\n\
             impl __modyn::batch::Kernel<{float}, {inputs}, {outputs}{flags}> for {kernel} {{\n\
             #[inline(always)]\n\
             fn run<T: __modyn::batch::Lanes<Lane = {float}>>(\n    &self,\n    \
             inputs: __modyn::batch::Inputs<'_, T, {inputs}{flags}>,\n    \
             outputs: __modyn::batch::Outputs<'_, T, {outputs}>,\n) {{\n{body}}}\n}}\n"
        );
    }

    /// Prints the public functions: over slices for each coordinate, the same on all cores, and
    /// over slices of states. If the quantity depends on run-time parameters, each has a form with
    /// parameters.
    fn batch_functions(&self, text: &mut String, quantity: &Quantity<'_>) {
        let robot = self.name;
        let float = self.options.scalar.name();
        let name = name(quantity);
        let result = result_name(quantity);
        let outputs = outputs(quantity);
        let has_form = |form| move |p: &&Parameter| p.batch_form() == form;
        let number_arguments = || quantity.parameters.iter().filter(has_form(BatchForm::Numbers));
        let sets = || quantity.parameters.iter().filter(has_form(BatchForm::Sets));
        let shared = || quantity.parameters.iter().filter(has_form(BatchForm::Shared));
        let all = || number_arguments().chain(sets()).chain(&outputs);
        let mut table: Vec<String> = all().map(|p| self.argument(p)).collect();
        if matches!(quantity.shape, Shape::Struct { .. }) {
            // In the form over slices of states, the result is one argument.
            table.push(self.argument(&Parameter::new(result, quantity.shape.clone())));
        }
        let _ = writeln!(
            text,
            "impl {robot} {{\n\
             const {}: &'static [__modyn::batch::Argument] = &[{}];",
            table_name(quantity),
            table.join(", ")
        );
        let lines: Vec<&str> = quantity.docs.lines().collect();
        let summary = lines.join("\n/// ");
        let columns = |p: &Parameter, reference: &str| {
            format!("{}: {}", p.name, p.shape.type_of(&format!("{reference}[{float}]")))
        };
        let input = |p: &Parameter| match p.batch_form() {
            BatchForm::Sets => format!("{}: {}", p.name, p.shape.type_of("&[bool]")),
            BatchForm::Shared => p.typed(float),
            BatchForm::Numbers | BatchForm::None => columns(p, "&"),
        };
        let mut by_columns: Vec<String> = quantity.parameters.iter().map(input).collect();
        by_columns.extend(outputs.iter().map(|p| columns(p, "&mut ")));
        let numbered = |p: &Parameter| numbered(p, quantity);
        let unpacked: Vec<String> = all()
            .map(|p| format!("    let {} = {};\n", p.shape.value(&numbered(p)), p.name))
            .collect();
        let list = |names: Vec<String>| format!("[{}]", names.join(", "));
        let inputs = list(number_arguments().flat_map(numbered).collect());
        let flags = list(sets().flat_map(numbered).collect());
        let results = list(outputs.iter().flat_map(numbered).collect());
        // A function without sets of contacts has no flags.
        let has_sets = sets().next().is_some();
        let (inputs, flagged) = match has_sets {
            true => (format!("({inputs}, {flags})"), "_flagged"),
            false => (inputs, ""),
        };
        let split = (unpacked.concat(), inputs, results);

        let of_state = |p: &Parameter| match p.batch_form() {
            BatchForm::Sets => format!("{}: &[{}]", p.name, self.contacts_type()),
            BatchForm::Shared => p.typed(float),
            BatchForm::Numbers | BatchForm::None => {
                format!("{}: &[{}]", p.name, p.shape.type_of(float))
            }
        };
        let mut by_states: Vec<String> = quantity.parameters.iter().map(of_state).collect();
        by_states.push(format!("{result}: &mut [{}]", quantity.shape.type_of(float)));
        let flattened = |p: &Parameter| match p.shape {
            Shape::Scalar => p.name.into(),
            _ => format!("{}.as_flattened()", p.name),
        };
        let mut flat = list(number_arguments().map(flattened).collect());
        if let Some(set) = sets().next() {
            let flags = match set.shape.is_empty() {
                true => "|(): &()| []".to_string(),
                false => format!("|set: &{}| set.to_array()", self.contacts_type()),
            };
            flat = format!(
                "__modyn::batch::FlaggedStates {{ inputs: {flat}, sets: Some({}), flags: {flags} }}",
                set.name
            );
        }
        let for_all: String =
            shared().map(|p| format!("\n/// All states share `{}`.", p.name)).collect();
        let held: String = shared().map(|p| format!(", *{}", p.name)).collect();
        let slices = slices_of_result(&quantity.shape);

        let dynamic = quantity.runtime_parameter().is_some();
        let forms: &[(&str, &str)] =
            if dynamic { &[("_with", "params"), ("", "DEFAULT")] } else { &[("", "")] };
        for (with, params) in forms {
            let mut first = String::new();
            let numbers = match *params {
                "params" => {
                    let _ = write!(first, "params: &{robot}Params, ");
                    "params.numbers".to_string()
                }
                "DEFAULT" => format!("{robot}Params::DEFAULT.numbers"),
                _ => "[]".into(),
            };
            let kernel = format!(
                "&{}({numbers}{held}), Self::{}",
                kernel_name(quantity),
                table_name(quantity)
            );
            let form = |suffix: &str, arguments: &[String], docs: &str, body: &str| {
                format!(
                    "/// {summary}\n///\n/// {docs}{for_all}\n///\n/// # Errors\n///\n\
                     /// If the arguments hold different numbers of states.\n\
                     pub fn {name}_{suffix}{with}({first}{}) -> ::core::result::Result<(), \
                     __modyn::BatchError> {{\n{body}}}\n",
                    arguments.join(", ")
                )
            };
            let (unpacked, inputs, outputs) = &split;
            *text += &form(
                "batch",
                &by_columns,
                "Computes many states: each slice holds one entry for each state. Results are \
                 written to the last arguments.",
                &format!(
                    "{unpacked}    __modyn::batch::run{flagged}({kernel}, {inputs}, {outputs})\n"
                ),
            );
            let parallel = form(
                "batch_par",
                &by_columns,
                "Computes many states on all cores: each slice holds one entry for each state. \
                 Results are written to the\n/// last arguments.",
                &format!(
                    "{unpacked}    __modyn::batch::run_parallel{flagged}({kernel}, {inputs}, {outputs})\n"
                ),
            );
            let _ = writeln!(text, "__modyn::__with_rayon! {{\n{parallel}}}");
            *text += &form(
                "each",
                &by_states,
                "Computes many states: each element of a slice is a state. Results are written to the last argument.",
                &format!(
                    "    __modyn::batch::run_each{flagged}({kernel}, {flat}, {result}, {slices})\n"
                ),
            );
        }
        text.push_str("}\n\n");
    }

    /// Returns a row of the table that errors name arguments by.
    fn argument(&self, Parameter { name, shape, kind, .. }: &Parameter) -> String {
        let coordinates = match (kind, shape) {
            (Some(ArgumentKind::Coordinates), _) => "&Self::COORDINATE_NAMES".into(),
            (Some(ArgumentKind::Numbers(_)), _) => "&[]".into(),
            // They belong to pivot blocks and couplings, which have no names.
            (Some(ArgumentKind::Factors), _) => format!("&[\"\"; {}]", shape.len()),
            (Some(ArgumentKind::ActiveContacts), _) if !shape.is_empty() => {
                "&Self::CONTACT_NAMES".into()
            }
            (Some(ArgumentKind::Controls), _) => "&Self::CONTROL_NAMES".into(),
            (Some(ArgumentKind::Activations), _) if !shape.is_empty() => {
                "&Self::ACTIVATION_NAMES".into()
            }
            (Some(ArgumentKind::Activations), _) => "&[]".into(),
            (_, shape) if ends_in(shape, self.model.nv()) => "&Self::VELOCITY_NAMES".into(),
            _ => "&[]".to_string(),
        };
        format!(
            "__modyn::batch::Argument {{ name: {name:?}, numbers: {}, coordinates: {coordinates} }}",
            shape.len()
        )
    }
}

/// Returns the name of the function of one state.
fn name(quantity: &Quantity<'_>) -> &'static str {
    quantity.batch_of.unwrap_or(quantity.name)
}

/// Returns the name of the result.
fn result_name(quantity: &Quantity<'_>) -> &'static str {
    quantity.function.map_or(name(quantity), Function::result_name)
}

/// Returns the parameters for the results: one for each field of a record.
fn outputs(quantity: &Quantity<'_>) -> Vec<Parameter> {
    match &quantity.shape {
        Shape::Struct { fields, .. } => {
            let field = |(name, field): &(&'static str, Shape)| {
                // A new state has the names of the state.
                let taken = quantity.parameters.iter().any(|argument| argument.name == *name);
                let name = if taken { intern(&format!("new_{name}")) } else { *name };
                let parameter = Parameter::new(name, field.clone());
                match quantity.result {
                    plan::Shape::Record(Record::Factorization, _) => {
                        parameter.of_kind(ArgumentKind::Factors)
                    }
                    _ => parameter,
                }
            };
            fields.iter().map(field).collect()
        }
        shape => vec![Parameter::new(result_name(quantity), shape.clone())],
    }
}

fn kernel_name(quantity: &Quantity<'_>) -> String {
    format!("{}Kernel", crate::names::helper_type(name(quantity)))
}

fn table_name(quantity: &Quantity<'_>) -> String {
    format!("{}_ARGUMENTS", name(quantity).to_uppercase())
}

/// Returns the number of entries of the arguments of this form.
fn count(quantity: &Quantity<'_>, form: BatchForm) -> usize {
    let of_form = quantity.parameters.iter().filter(|p| p.batch_form() == form);
    of_form.map(|p| p.shape.len()).sum()
}

/// Returns the names of a parameter's slices. The names of links, which fields of the robot's own
/// results have, may end in digits, but have no two underscores in a row.
fn numbered(parameter: &Parameter, quantity: &Quantity<'_>) -> Vec<String> {
    let separator = if quantity.fields.is_empty() { "" } else { "__" };
    (0..parameter.shape.len()).map(|i| format!("{}{separator}{i}", parameter.name)).collect()
}

/// Returns the closure from a reference `x` to a result to the slices of its numbers.
fn slices_of_result(shape: &Shape) -> String {
    let mut lets = Vec::new();
    let slices = match shape {
        Shape::Struct { .. } => slices("x", shape, &mut lets),
        _ if has_structures(shape) => slices("(*x)", shape, &mut lets),
        _ => vec![slice_of("x", shape)],
    };
    match lets.is_empty() {
        true => format!("|x| [{}]", slices.join(", ")),
        false => format!("|x| {{ {} [{}] }}", lets.concat(), slices.join(", ")),
    }
}

/// Returns the slices of all numbers of a value, which is a place. Elements of arrays of structures
/// are named by `lets`.
fn slices(value: &str, shape: &Shape, lets: &mut Vec<String>) -> Vec<String> {
    match shape {
        Shape::Struct { fields, .. } => {
            let place = |(i, (name, _)): (usize, &(&str, Shape))| match *name {
                "" => format!("{value}.{i}"),
                name => format!("{value}.{name}"),
            };
            let places: Vec<String> = fields.iter().enumerate().map(place).collect();
            let fields = fields.iter().zip(places);
            fields.flat_map(|((_, field), place)| slices(&place, field, lets)).collect()
        }
        Shape::Array(element, n) if has_structures(element) => {
            let names: Vec<String> = (0..*n).map(|i| format!("e{}_{i}", lets.len())).collect();
            lets.push(format!("let [{}] = &mut {value};", names.join(", ")));
            names.iter().flat_map(|name| slices(&format!("(*{name})"), element, lets)).collect()
        }
        Shape::Scalar => vec![slice_of(&format!("&mut {value}"), shape)],
        Shape::Array(..) => vec![slice_of(value, shape)],
    }
}

/// Returns whether a value is an array of `n` numbers, or an array of such arrays.
fn ends_in(shape: &Shape, n: usize) -> bool {
    match shape {
        Shape::Array(element, length) if matches!(**element, Shape::Scalar) => *length == n,
        Shape::Array(element, _) => ends_in(element, n),
        Shape::Scalar | Shape::Struct { .. } => false,
    }
}

/// Returns whether there are structures in a value.
fn has_structures(shape: &Shape) -> bool {
    match shape {
        Shape::Scalar => false,
        Shape::Array(element, _) => has_structures(element),
        Shape::Struct { .. } => true,
    }
}

/// Returns all entries of `value`, a place or a reference, as a mutable slice.
fn slice_of(value: &str, shape: &Shape) -> String {
    match shape {
        Shape::Array(element, _) => {
            format!("{value}.as_mut_slice(){}", ".as_flattened_mut()".repeat(depth(element)))
        }
        _ => format!("::core::slice::from_mut({value})"),
    }
}

/// Returns the nesting depth of arrays.
fn depth(shape: &Shape) -> usize {
    match shape {
        Shape::Array(element, _) => 1 + depth(element),
        _ => 0,
    }
}
