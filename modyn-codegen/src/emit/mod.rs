//! From graphs to the text of a Rust type.
//!
//! Public items are documented; private functions are generic over the scalar, the type's own
//! functions concrete, so that inference stays plain and the robot's crate holds compiled code.
//! The text uses `core` and the crate `modyn` only. It is the same for the same input, in every
//! process: nothing in here depends on an address or on a hash map's order.

mod abreast;
mod batch;
mod c;
mod constants;
mod docs;
mod embedded;
mod factorization;
pub(crate) mod frames;
mod function;
mod header;
mod layout;
mod missing;
mod parameters;
mod quantities;
mod shape;
mod shared;
mod types;

use std::fmt::Write as _;

use modyn_runtime::OperationCount;
use modyn_runtime::equations::ModulePartition;
use modyn_runtime::equations::brge::UduLayout;
use modyn_runtime::equations::dynamics::Elimination;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::{Model, ModuleTree, PARAMETERS_PER_LINK};

use crate::error::Diagnostic;
use crate::expr::Graph;
use crate::functions::Function;
use crate::names;
use crate::partition::{self, Choice};
use crate::trace::{Limbs, Parameters, Tracer};
use frames::Frames;
use function::{Parameter, function};
use quantities::{Graphs, Quantity, Source};
use shape::Shape;

/// The scalar that the type's own functions are concrete in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FloatType {
    /// Double precision.
    #[default]
    F64,
    /// Single precision.
    F32,
}

impl FloatType {
    fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
        }
    }
}

/// What the text depends on besides the model.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct EmitOptions {
    /// The name of the type; made from the model's name if `None`.
    pub type_name: Option<String>,
    /// Its visibility: `pub`, `pub(crate)` or nothing.
    pub visibility: String,
    /// The path of the crate `modyn`.
    pub krate: String,
    /// The scalar of the type's own functions.
    pub float: FloatType,
    /// Whether the text carries the part of the runtime that it needs, and depends on `core` alone.
    pub self_contained: bool,
    /// What the names of functions for C begin with; there are none if `None`.
    pub c_prefix: Option<String>,
    /// The functions that it has.
    pub functions: Vec<Function>,
    /// Whether gravity is an argument.
    pub runtime_gravity: bool,
    /// Whether equal limbs run through one function.
    pub share: bool,
    /// The links, as indices into the model's frames, whose own inertia is an argument.
    pub runtime_inertia: Vec<usize>,
    /// The links, as indices into the model's frames, to which an inertia is added that is an argument.
    pub payload: Vec<usize>,
    /// What was found odd in the description, for the documentation.
    pub warnings: Vec<Diagnostic>,
}

impl Default for EmitOptions {
    fn default() -> Self {
        Self {
            type_name: None,
            visibility: "pub".into(),
            krate: "::modyn".into(),
            float: FloatType::default(),
            self_contained: false,
            c_prefix: None,
            functions: Function::DEFAULT.to_vec(),
            runtime_gravity: false,
            share: false,
            runtime_inertia: Vec::new(),
            payload: Vec::new(),
            warnings: Vec::new(),
        }
    }
}

/// The text, and what is worth reporting about it.
#[non_exhaustive]
pub struct Emitted {
    /// Rust items.
    pub text: String,
    /// The header of the functions for C, if there are some.
    pub c_header: Option<String>,
    /// The name of the type.
    pub type_name: String,
    /// What each function takes, by name.
    pub operations: Vec<(&'static str, OperationCount)>,
    /// What stands in the text of each function, by name: all that it may call.
    pub written: Vec<(&'static str, OperationCount)>,
    /// The modules of the forward recursion, and what each candidate would have cost.
    pub partition: (ModuleTree, Vec<(&'static str, usize)>),
}

/// Compiles `model` to Rust.
#[must_use]
pub fn emit(model: &Model, modules: &ModuleTree, options: &EmitOptions) -> Emitted {
    let mut options = options.clone();
    if options.self_contained {
        options.krate = format!("self::{}", embedded::MODULE);
    }
    let options = &options;
    let prepared = Mechanism::new(model);
    let (inertias, payloads) = (&options.runtime_inertia, &options.payload);
    let equal = inertias.is_empty() && payloads.is_empty();
    let parameters = Parameters::new(model, options.runtime_gravity, inertias, payloads);
    let frames = &Frames::new(&prepared);
    let all_links = Tracer::with_parameters(&prepared, parameters.clone());
    // Nearly no function is about links, of which there may be very many; but what one weighs may be given.
    let tracer =
        if equal { Tracer::with_parameters(frames.bare(), parameters) } else { all_links.clone() };
    let Choice { modules: eliminated, graph: forward_dynamics, candidates } =
        partition::choose(model, &prepared, &tracer);
    let type_name = options.type_name.clone().unwrap_or_else(|| names::type_name(model.name()));
    let layout = UduLayout::new(&prepared, modules);
    let (layout, tracer) = (&layout, &tracer);
    let robot = Robot { model, modules, options, layout, tracer, frames, name: &type_name };
    let elimination = Elimination::new(&prepared, &eliminated);
    // A file of its own has no vectors, and a link that is given at run time has no equal.
    let pays = (options.share || !options.self_contained) && equal;
    let limbs: Vec<Limbs> = if pays { Limbs::ways(&prepared, !options.share) } else { Vec::new() };
    // What is cheapest limb by limb need not be so side by side.
    let uniform = [ModuleTree::links(model), partition::whole_chains(model)];
    let others = uniform.iter().filter(|modules| !limbs.is_empty() && **modules != eliminated);
    let partitions: Vec<ModulePartition> = [&eliminated]
        .into_iter()
        .chain(others)
        .map(|m| ModulePartition::new(&prepared, m))
        .collect();
    let source = Source {
        tracer,
        all_links: &all_links,
        frames,
        limbs: &limbs,
        partitions: &partitions,
        independent: limbs.first().is_some_and(|limbs| limbs.independent(&prepared)),
        vectors: !options.self_contained && !options.share,
        elimination: &elimination,
        layout,
        for_derivatives: &UduLayout::new(&prepared, &partition::whole_chains(model)),
        forward_dynamics: &forward_dynamics,
    };
    // Batches are the runtime's to run; a tree has no loops.
    let left_out = |function: &Function| {
        options.self_contained && function.batched().is_some()
            || function.is_of_loops() && model.loop_constraints().is_empty()
    };
    let selected = Function::ALL.iter().filter(|function| options.functions.contains(function));
    let selected = selected.filter(|function| !left_out(function));
    let (batches, quantities): (Vec<Quantity>, Vec<Quantity>) =
        selected.map(|f| robot.quantity(*f, &source)).partition(|q| q.function.batched().is_some());
    let count = |q: &Quantity| match &q.abreast {
        Some(graph) if options.share => shared::count(graph),
        _ => q.graphs.count(frames.rows()),
    };
    let named = |q: &Quantity| (q.function.name(), count(q));
    let mut operations: Vec<_> = quantities.iter().map(named).collect();
    let written = quantities.iter().map(|q| {
        let count = match &q.abreast {
            Some(graph) if options.share => shared::written(graph),
            abreast => q.graphs.all().iter().chain(abreast).map(Graph::count).sum(),
        };
        (q.function.name(), count)
    });
    let written = written.collect();

    let mut text = String::new();
    docs::robot(&mut text, &robot, &operations, (&eliminated, &candidates));
    robot.types(&mut text);
    let krate = &options.krate;
    let _ = writeln!(
        text,
        "#[allow(clippy::all, clippy::pedantic, clippy::nursery, dead_code, unused_imports, unused_variables, non_snake_case)]\n\
         const _: () = {{\n\
         use {krate} as __modyn;\n"
    );
    robot.constants(&mut text, &operations);
    robot.own_functions(&mut text, &quantities);
    if !options.self_contained {
        robot.robot_trait(&mut text, &quantities);
        let generated = quantities.iter().chain(&batches).map(|quantity| quantity.function);
        robot.availability(&mut text, &generated.collect::<Vec<_>>());
    }
    if robot.factorizes() {
        robot.factorization(&mut text);
    }
    robot.enums(&mut text);
    robot.parameters(&mut text);
    if quantities.iter().any(|q| !matches!(q.graphs, Graphs::One(_))) && frames.any_shared() {
        frames.table(&mut text, options.float);
    }
    for quantity in &quantities {
        robot.private_functions(&mut text, quantity);
    }
    for quantity in &batches {
        robot.batches(&mut text, quantity);
    }
    text += "};\n";
    operations.extend(batches.iter().map(named));
    let c_header = options.c_prefix.as_ref().map(|prefix| {
        robot.c_functions(&mut text, prefix, &quantities);
        robot.c_header(prefix, &quantities)
    });
    if options.self_contained {
        text = layout::indented(&embedded::in_any_edition(&text));
        text += &embedded::module(&text);
    }
    Emitted { text, c_header, type_name, operations, written, partition: (eliminated, candidates) }
}

/// What the parts of the text are written from.
struct Robot<'a> {
    model: &'a Model,
    modules: &'a ModuleTree,
    options: &'a EmitOptions,
    layout: &'a UduLayout,
    tracer: &'a Tracer<'a>,
    frames: &'a Frames,
    name: &'a str,
}

impl Robot<'_> {
    /// Whether it has the factorization's type.
    fn factorizes(&self) -> bool {
        let has = |function| self.options.functions.contains(&function);
        has(Function::Brge) || has(Function::BrgeBatch) && !self.options.self_contained
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

    /// The parameter of a private function that stands for what is known at run time only.
    fn runtime_parameter(&self, quantity: &Quantity) -> Option<Parameter> {
        let numbers = self.tracer.parameters().len();
        (quantity.dynamic && numbers > 0).then(|| Parameter::new("params", Shape::vector(numbers)))
    }

    /// The functions that compute, generic over the scalar.
    fn private_functions(&self, text: &mut String, quantity: &Quantity) {
        let mut parameters = quantity.parameters.clone();
        parameters.extend(self.runtime_parameter(quantity));
        let name = quantity.function.name();
        match &quantity.graphs {
            Graphs::One(graph) => match &quantity.abreast {
                Some(vectors) if self.options.share => {
                    self.shared(text, quantity, &parameters, vectors);
                }
                Some(vectors) => Self::abreast(text, quantity, &parameters, (graph, vectors)),
                None => *text += &function(name, &parameters, &quantity.shape, graph),
            },
            Graphs::ByLink(graphs) => {
                self.frames.functions(text, quantity, graphs, self.options.float);
            }
            Graphs::Poses(graphs) => {
                self.frames.poses_function(text, quantity, graphs, self.options.float);
            }
        }
    }

    /// The body of a public function: the call of the private one, or for each link one.
    fn call(&self, quantity: &Quantity, params: &str) -> String {
        let name = quantity.function.name();
        if quantity.function == Function::Random {
            return format!(
                "let mut uniform = uniform;\n    {name}(&::core::array::from_fn(|_| uniform()))"
            );
        }
        let mut arguments: Vec<&str> = quantity.parameters.iter().map(|p| p.name).collect();
        if self.runtime_parameter(quantity).is_some() {
            arguments.push(params);
        }
        let arguments = arguments.join(", ");
        match &quantity.graphs {
            Graphs::One(_) | Graphs::Poses(_) => format!("{name}({arguments})"),
            Graphs::ByLink(_) => {
                let arms: Vec<String> = self
                    .link_variants()
                    .iter()
                    .enumerate()
                    .map(|(i, link)| {
                        let call = self.frames.call(name, i, &arguments);
                        format!("{}Link::{link} => {call},\n", self.name)
                    })
                    .collect();
                format!("match link {{\n{}    }}", arms.concat())
            }
        }
    }

    /// The parameters of a public function over scalar `t`, behind `first`.
    fn typed(&self, quantity: &Quantity, first: Option<String>, t: &str) -> String {
        if quantity.function == Function::Random {
            return format!("uniform: impl ::core::ops::FnMut() -> {t}");
        }
        let own = quantity.parameters.iter().map(|parameter| parameter.typed(t));
        let link = matches!(quantity.graphs, Graphs::ByLink(_))
            .then(|| format!("link: {}Link", self.name));
        first.into_iter().chain(own).chain(link).collect::<Vec<_>>().join(", ")
    }

    /// The type's own functions.
    fn own_functions(&self, text: &mut String, quantities: &[Quantity]) {
        let (name, float) = (self.name, self.options.float.name());
        let _ = writeln!(text, "impl {name} {{");
        for quantity in quantities {
            let function = quantity.function.name();
            let lines: Vec<String> =
                quantity.docs.lines().map(|line| format!("/// {line}\n")).collect();
            let (docs, returned) = (lines.concat(), quantity.shape.type_of(float));
            let _ = writeln!(
                text,
                "{docs}#[must_use]\npub fn {function}({}) -> {returned} {{\n    {}\n}}",
                self.typed(quantity, None, float),
                self.call(quantity, &format!("&{name}Params::DEFAULT.numbers")),
            );
            if self.runtime_parameter(quantity).is_some() {
                let params = format!("params: &{name}Params");
                let _ = writeln!(
                    text,
                    "{docs}///\n/// With these parameters.\n#[must_use]\n\
                     pub fn {function}_with({}) -> {returned} {{\n    {}\n}}",
                    self.typed(quantity, Some(params), float),
                    self.call(quantity, "&params.numbers"),
                );
            }
        }
        let _ = writeln!(
            text,
            "/// Checks that the quaternions of spherical and floating joints in `q` have length 1, to half of the scalar's\n\
             /// digits. Nothing else checks it, and accelerations are wrong where it does not hold.\n///\n\
             /// # Errors\n///\n/// The first joint whose quaternion has another length.\n\
             pub fn check_configuration(q: &[{float}; {nq}]) -> \
             ::core::result::Result<(), __modyn::ConfigurationError<{float}>> {{\n    \
             __modyn::configuration::check(Self::QUATERNIONS.iter().copied(), q)\n}}",
            nq = self.model.nq(),
        );
        text.push_str("}\n\n");
    }

    /// `impl Robot`.
    fn robot_trait(&self, text: &mut String, quantities: &[Quantity]) {
        let (name, nq, nv) = (self.name, self.model.nq(), self.model.nv());
        let (links, loop_constraints) =
            (self.model.frames().len(), self.model.loop_constraints().len());
        let loop_constraint_names = match loop_constraints {
            0 => "",
            _ => {
                "const LOOP_CONSTRAINT_NAMES: &'static [&'static str] = &Self::LOOP_CONSTRAINT_NAMES;\n"
            }
        };
        let params = if self.tracer.parameters().is_empty() {
            "()".into()
        } else {
            format!("{name}Params<T>")
        };
        let brge = if self.factorizes() {
            format!("{name}Brge<T>")
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
             {loop_constraint_names}\
             const QUATERNIONS: &'static [(&'static str, usize)] = &Self::QUATERNIONS;\n\
             const LIMITS: __modyn::JointLimits<'static> = Self::LIMITS;\n\
             const MODULES: &'static [__modyn::KinematicModule] = &Self::MODULES;\n\
             type Params<T: __modyn::Scalar> = {params};\n\
             type Link = {name}Link;\n\
             type Q<T: __modyn::Scalar> = [T; {nq}];\n\
             type V<T: __modyn::Scalar> = [T; {nv}];\n\
             type M<T: __modyn::Scalar> = [[T; {nv}]; {nv}];\n\
             type PerVelocity<X: ::core::marker::Copy> = [X; {nv}];\n\
             type PerLink<X: ::core::marker::Copy> = [X; {links}];\n\
             type PerLoopConstraint<X: ::core::marker::Copy> = [X; {loop_constraints}];\n\
             type Regressor<T: __modyn::Scalar> = [[T; {nv}]; {columns}];\n\
             type Brge<T: __modyn::Scalar> = {brge};\n\
             fn neutral<T: __modyn::Scalar>() -> [T; {nq}] {{\n    Self::NEUTRAL.map(|x| T::from_f64(::core::convert::Into::into(x)))\n}}",
            columns = PARAMETERS_PER_LINK * self.model.links().len(),
        );
        for quantity in quantities {
            let with = if quantity.dynamic { "_with" } else { "" };
            let first = quantity.dynamic.then(|| "params: &Self::Params<T>".into());
            let _ = writeln!(
                text,
                "fn {}{with}<T: __modyn::Scalar>({}) -> {} {{\n    {}\n}}",
                quantity.function.name(),
                self.typed(quantity, first, "T"),
                quantity.shape.type_of("T"),
                self.call(quantity, "&params.numbers"),
            );
        }
        text.push_str("}\n\n");
    }
}
