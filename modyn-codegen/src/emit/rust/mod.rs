//! Rust: the type of a robot, its functions and its other items.
//!
//! Public items are documented. Private functions are generic over the scalar. The type's own functions are concrete:
//! type inference stays simple, and the code is compiled in the robot's crate. The text uses `core` and the crate
//! `modyn` only. The same input gives the same text in every process: nothing depends on an address or on the order of a
//! hash map.

mod batch;
mod c_functions;
mod constants;
mod contacts;
mod dispatch;
mod docs;
mod embedded;
mod factorization;
mod frames;
mod function;
mod header;
mod layout;
mod machine_code;
mod missing;
mod parameter;
mod parameters;
mod shape;
mod types;

use std::fmt::Write as _;

use modyn_runtime::OperationCount;
use modyn_runtime::model::{Model, ModuleTree, PARAMETERS_PER_LINK};

use super::{EmitOptions, FloatType, MachineCode};
use crate::names;
use crate::plan::{self, CForm, Constants, Function, Kernels, Plan, Planned};
use crate::program::Program;
use function::function;
use parameter::Parameter;
use shape::Shape;

/// Returns the items of a robot, and the header of its functions for C if the options request them.
#[must_use]
pub(super) fn print(
    (model, modules): (&Model, &ModuleTree),
    (plan, constants): (&Plan, &Constants),
    options: &EmitOptions,
    name: &str,
) -> (String, Option<String>) {
    let mut options = options.clone();
    if options.self_contained {
        options.crate_path = format!("self::{}", embedded::MODULE);
    }
    let options = &options;
    let robot = Robot { model, modules, options, plan, constants, name, code: None };
    let quantity = |planned| Quantity::new(planned, name);
    let quantities: Vec<Quantity<'_>> = plan.functions.iter().map(quantity).collect();
    let per_call = |p: &Planned| (p.name, p.operations_per_call());
    let operations: Vec<(&str, OperationCount)> = plan.functions.iter().map(per_call).collect();
    let mut text = String::new();
    docs::robot(&mut text, &robot, &operations);
    robot.types(&mut text, &quantities);
    let path = &options.crate_path;
    let _ = writeln!(
        text,
        "#[allow(clippy::all, clippy::pedantic, clippy::nursery, dead_code, unused_imports, unused_variables, non_snake_case)]\n\
         const _: () = {{\n\
         use {path} as __modyn;\n"
    );
    // Rustdoc shows methods before constants if they come first.
    robot.own_functions(&mut text, &quantities);
    robot.constants(&mut text, &operations);
    if !options.self_contained {
        robot.robot_trait(&mut text, &quantities);
        let generated = plan.functions.iter().chain(&plan.batches).filter_map(|p| p.function);
        robot.availability(&mut text, &generated.collect::<Vec<_>>());
    }
    if robot.factorizes() {
        robot.factorization(&mut text);
    }
    robot.enums(&mut text);
    robot.contact_functions(&mut text);
    robot.parameters(&mut text);
    let of_links = |p: &Planned| matches!(p.kernels, Kernels::ByLink(_) | Kernels::Poses { .. });
    if plan.functions.iter().any(of_links) && plan.frames.any_shared() {
        robot.placements(&mut text);
    }
    for quantity in &quantities {
        robot.private_functions(&mut text, quantity);
    }
    for planned in &plan.batches {
        robot.batches(&mut text, &quantity(planned));
    }
    text += "};\n";
    let c_header = options.c_prefix.as_ref().map(|prefix| {
        robot.c_functions(&mut text, prefix, &quantities);
        robot.c_header(prefix, &quantities)
    });
    if options.self_contained {
        text = layout::indented(&embedded::in_any_edition(&text));
        text += &embedded::module(&text);
    }
    (text, c_header)
}

/// Returns the items of a robot whose functions are in an object file.
#[must_use]
pub(super) fn print_for_object(
    (model, modules): (&Model, &ModuleTree),
    (plan, constants): (&Plan, &Constants),
    options: &EmitOptions,
    name: &str,
    code: &MachineCode,
) -> String {
    let robot = Robot { model, modules, options, plan, constants, name, code: Some(code) };
    let quantities: Vec<Quantity<'_>> =
        plan.functions.iter().map(|planned| Quantity::new(planned, name)).collect();
    let operations = plan.operations_per_call();
    let mut text = String::new();
    docs::robot(&mut text, &robot, &operations);
    robot.types(&mut text, &quantities);
    let path = &options.crate_path;
    let _ = writeln!(
        text,
        "#[allow(clippy::all, clippy::pedantic, clippy::nursery, dead_code, unused_imports, unused_variables, non_snake_case)]\n\
         const _: () = {{\n\
         use {path} as __modyn;\n"
    );
    robot.own_functions(&mut text, &quantities);
    robot.constants(&mut text, &operations);
    robot.enums(&mut text);
    robot.contact_functions(&mut text);
    robot.parameters(&mut text);
    robot.machine_functions(&mut text, &quantities, code);
    text += "};\n";
    text
}

/// A planned function with its Rust types.
struct Quantity<'a> {
    /// The function; `None` for a bundle.
    function: Option<Function>,
    name: &'static str,
    /// The name of the function or bundle of one state, if this is its form for many states.
    batch_of: Option<&'static str>,
    parameters: Vec<Parameter>,
    shape: Shape,
    /// Whether the function of the trait depends on run-time parameters.
    dynamic: bool,
    /// The number of run-time parameters.
    runtime: usize,
    kernels: &'a Kernels,
    docs: &'static str,
    /// The documentation of each field of the result, if the result is a type of the robot's own.
    fields: &'a [&'static str],
    c_form: CForm,
}

impl<'a> Quantity<'a> {
    fn new(planned: &'a Planned, robot: &str) -> Self {
        let parameter = |(name, shape): &(&'static str, plan::Shape)| {
            let contacts = matches!(shape, plan::Shape::Record(plan::Record::Contacts, _));
            Parameter::new(name, Shape::new(shape, robot)).with_contacts(contacts)
        };
        Self {
            function: planned.function,
            name: planned.name,
            batch_of: planned.batch_of,
            parameters: planned.arguments.iter().map(parameter).collect(),
            shape: Shape::new(&planned.result, robot),
            dynamic: planned.function.is_some_and(Function::depends_on_parameters),
            runtime: planned.parameters,
            kernels: &planned.kernels,
            docs: planned.docs,
            fields: &planned.fields,
            c_form: planned.c_form,
        }
    }

    /// Returns the parameter of a private function for the run-time parameters.
    fn runtime_parameter(&self) -> Option<Parameter> {
        (self.runtime > 0).then(|| Parameter::new("params", Shape::vector(self.runtime)))
    }

    /// Returns the parameters of a private function.
    fn all_parameters(&self) -> Vec<Parameter> {
        self.parameters.iter().cloned().chain(self.runtime_parameter()).collect()
    }
}

/// The inputs of all parts of the text.
struct Robot<'a> {
    model: &'a Model,
    modules: &'a ModuleTree,
    options: &'a EmitOptions,
    plan: &'a Plan,
    constants: &'a Constants,
    name: &'a str,
    /// The machine code that the functions call; `None` if their programs are printed.
    code: Option<&'a MachineCode>,
}

impl Robot<'_> {
    /// Returns whether the robot has a factorization type.
    fn factorizes(&self) -> bool {
        !self.plan.factorization.is_empty()
    }

    fn joint_names(&self) -> Vec<&str> {
        self.model.links().iter().map(|link| link.joint.name.as_str()).collect()
    }

    fn link_names(&self) -> Vec<&str> {
        self.model.frames().iter().map(|frame| frame.name.as_str()).collect()
    }

    fn link_variants(&self) -> Vec<String> {
        names::variants(&self.link_names())
    }

    /// Prints the private functions that compute, generic over the scalar.
    fn private_functions(&self, text: &mut String, quantity: &Quantity<'_>) {
        let (name, parameters) = (quantity.name, quantity.all_parameters());
        let function = |name: &str, program: &Program| {
            function(name, &parameters, &quantity.shape, program, self.options.scalar)
        };
        match quantity.kernels {
            Kernels::One(program) => *text += &function(name, program),
            Kernels::Dispatched { scalar, simd } => {
                self.dispatched(text, quantity, &parameters, (scalar, simd));
            }
            Kernels::ByLink(programs) => self.link_functions(text, quantity, programs),
            Kernels::Poses { bodies, placed, .. } => {
                self.poses_function(text, quantity, (bodies, placed));
            }
        }
    }

    /// Returns the body of a public function: a call of the private function, or one for each link.
    fn call(&self, quantity: &Quantity<'_>, params: &str) -> String {
        let name = quantity.name;
        if quantity.function == Some(Function::Random) {
            return format!(
                "let mut uniform = uniform;\n    {name}(&::core::array::from_fn(|_| uniform()))"
            );
        }
        let argument = |parameter: &Parameter| match &parameter.shape {
            shape if parameter.contacts && shape.is_empty() => "&[]".into(),
            _ if parameter.contacts => "&contacts.numbers()".into(),
            Shape::Scalar => format!("&{}", parameter.name),
            _ => parameter.name.into(),
        };
        let mut arguments: Vec<String> = quantity.parameters.iter().map(argument).collect();
        if quantity.runtime_parameter().is_some() {
            arguments.push(params.into());
        }
        let arguments = arguments.join(", ");
        match quantity.kernels {
            Kernels::One(_) | Kernels::Dispatched { .. } | Kernels::Poses { .. } => {
                format!("{name}({arguments})")
            }
            Kernels::ByLink(_) if self.code.is_some() => format!("{name}({arguments}, link)"),
            Kernels::ByLink(_) => {
                let arms: Vec<String> = self
                    .link_variants()
                    .iter()
                    .enumerate()
                    .map(|(i, link)| {
                        let call = self.link_call(name, i, &arguments);
                        format!("{}Link::{link} => {call},\n", self.name)
                    })
                    .collect();
                format!("match link {{\n{}    }}", arms.concat())
            }
        }
    }

    /// Returns the parameters of a public function over scalar `t`, after `first`.
    fn typed(&self, quantity: &Quantity<'_>, first: Option<String>, t: &str) -> String {
        if quantity.function == Some(Function::Random) {
            return format!("uniform: impl ::core::ops::FnMut() -> {t}");
        }
        let own = quantity.parameters.iter().map(|parameter| match parameter.shape {
            _ if parameter.contacts => format!("{}: {}", parameter.name, self.contacts_type()),
            Shape::Scalar => format!("{}: {t}", parameter.name),
            _ => parameter.typed(t),
        });
        let link = matches!(quantity.kernels, Kernels::ByLink(_))
            .then(|| format!("link: {}Link", self.name));
        first.into_iter().chain(own).chain(link).collect::<Vec<_>>().join(", ")
    }

    /// Prints the type's own functions.
    fn own_functions(&self, text: &mut String, quantities: &[Quantity<'_>]) {
        let (name, float) = (self.name, self.options.scalar.name());
        let _ = writeln!(text, "impl {name} {{");
        for quantity in quantities {
            let function = quantity.name;
            let lines: Vec<String> =
                quantity.docs.lines().map(|line| format!("/// {line}\n")).collect();
            let (docs, returned) = (lines.concat(), quantity.shape.type_of(float));
            let _ = writeln!(
                text,
                "{docs}#[must_use]\npub fn {function}({}) -> {returned} {{\n    {}\n}}",
                self.typed(quantity, None, float),
                self.call(quantity, &format!("&{name}Params::DEFAULT.numbers")),
            );
            if quantity.runtime_parameter().is_some() {
                let params = format!("params: &{name}Params");
                let _ = writeln!(
                    text,
                    "{docs}///\n/// The robot has the run-time parameters `params`.\n#[must_use]\n\
                     pub fn {function}_with({}) -> {returned} {{\n    {}\n}}",
                    self.typed(quantity, Some(params), float),
                    self.call(quantity, "&params.numbers"),
                );
            }
        }
        let _ = writeln!(
            text,
            "/// Checks that the quaternions of spherical and floating joints in `q` have length 1, to half of the scalar's\n\
             /// digits. No other function checks them, and accelerations are wrong with other lengths.\n///\n\
             /// # Errors\n///\n/// Names the first joint whose quaternion does not have length 1.\n\
             pub fn check_configuration(q: &[{float}; {nq}]) -> \
             ::core::result::Result<(), __modyn::ConfigurationError<{float}>> {{\n    \
             __modyn::configuration::check(Self::QUATERNIONS.iter().copied(), q)\n}}",
            nq = self.model.nq(),
        );
        text.push_str("}\n\n");
    }

    /// Prints the implementation of `Robot`.
    fn robot_trait(&self, text: &mut String, quantities: &[Quantity<'_>]) {
        let (name, nq, nv) = (self.name, self.model.nq(), self.model.nv());
        let (links, constraints) = (self.model.frames().len(), self.model.constraints());
        let (contacts, contacts_type) = (self.model.contacts().len(), self.contacts_type());
        let names = |count: usize, name: &str| match count {
            0 => String::new(),
            _ => format!("const {name}: &'static [&'static str] = &Self::{name};\n"),
        };
        let constraint_names = names(self.model.loop_constraints().len(), "LOOP_CONSTRAINT_NAMES")
            + &names(contacts, "CONTACT_NAMES");
        let params =
            if self.plan.parameters.is_empty() { "()".into() } else { format!("{name}Params<T>") };
        let brge = if self.factorizes() {
            format!("{name}UduFactorization<T>")
        } else {
            format!("__modyn::NotGenerated<[T; {nv}], [[T; {nv}]; {nv}]>")
        };
        let _ = writeln!(
            text,
            "impl __modyn::Robot for {name} {{\n\
             const NAME: &'static str = Self::NAME;\n\
             const NQ: usize = {nq};\n\
             const NV: usize = {nv};\n\
             const JOINT_NAMES: &'static [&'static str] = &Self::JOINT_NAMES;\n\
             const LINK_NAMES: &'static [&'static str] = &Self::LINK_NAMES;\n\
             const COORDINATE_NAMES: &'static [&'static str] = &Self::COORDINATE_NAMES;\n\
             const VELOCITY_NAMES: &'static [&'static str] = &Self::VELOCITY_NAMES;\n\
             {constraint_names}\
             const QUATERNIONS: &'static [(&'static str, usize)] = &Self::QUATERNIONS;\n\
             const LIMITS: __modyn::JointLimits<'static> = Self::LIMITS;\n\
             const MODULES: &'static [__modyn::KinematicModule] = &Self::MODULES;\n\
             type Params<T: __modyn::Scalar> = {params};\n\
             type Link = {name}Link;\n\
             type Q<T: __modyn::Scalar> = [T; {nq}];\n\
             type V<T: __modyn::Scalar> = [T; {nv}];\n\
             type M<T: __modyn::Scalar> = [[T; {nv}]; {nv}];\n\
             type PerVelocity<X: ::core::marker::Copy> = [X; {nv}];\n\
             type PerState<X: ::core::marker::Copy> = [X; {state}];\n\
             type PerLink<X: ::core::marker::Copy> = [X; {links}];\n\
             type Contacts = {contacts_type};\n\
             type PerContact<X: ::core::marker::Copy> = [X; {contacts}];\n\
             type PerConstraint<X: ::core::marker::Copy> = [X; {constraints}];\n\
             type PerConstraintRow<X: ::core::marker::Copy> = [X; {rows}];\n\
             type Regressor<T: __modyn::Scalar> = [[T; {nv}]; {columns}];\n\
             type UduFactorization<T: __modyn::Scalar> = {brge};\n\
             fn neutral<T: __modyn::Scalar>() -> [T; {nq}] {{\n    Self::NEUTRAL.map(|x| T::from_f64(::core::convert::Into::into(x)))\n}}",
            state = 2 * nv,
            rows = self.model.constraint_rows(),
            columns = PARAMETERS_PER_LINK * self.model.links().len(),
        );
        // The trait, which all robots share, has no bundles.
        for quantity in quantities.iter().filter(|quantity| quantity.function.is_some()) {
            let with = if quantity.dynamic { "_with" } else { "" };
            let first = quantity.dynamic.then(|| "params: &Self::Params<T>".into());
            let _ = writeln!(
                text,
                "fn {}{with}<T: __modyn::Scalar>({}) -> {} {{\n    {}\n}}",
                quantity.name,
                self.typed(quantity, first, "T"),
                quantity.shape.type_of("T"),
                self.call(quantity, "&params.numbers"),
            );
        }
        text.push_str("}\n\n");
    }
}
