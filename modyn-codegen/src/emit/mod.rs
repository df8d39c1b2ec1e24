//! From graphs to the text of a Rust type.
//!
//! Public items are documented; private functions are generic over the scalar, the type's own
//! functions concrete, so that inference stays plain and the robot's crate holds compiled code.
//! The text uses `core` and the crate `modyn` only. It is the same for the same input, in every
//! process: nothing in here depends on an address or on a hash map's order.

mod docs;
mod factorization;
mod function;
mod quantities;
mod types;

use std::fmt::Write as _;

use modyn_runtime::OperationCount;
use modyn_runtime::equations::brge::Layout;
use modyn_runtime::model::prepare::Prepared;
use modyn_runtime::model::{Model, ModuleTree};

use crate::error::Diagnostic;
use crate::names;
use crate::partition::{self, Choice};
use crate::passes::optimize;
use crate::trace::Tracer;
use function::{Parameter, Shape, function};
use quantities::{Quantity, quantities};

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
            warnings: Vec::new(),
        }
    }
}

/// The text, and what is worth reporting about it.
#[non_exhaustive]
pub struct Emitted {
    /// Rust items.
    pub text: String,
    /// The name of the type.
    pub type_name: String,
    /// What each function takes, by name.
    pub operations: Vec<(&'static str, OperationCount)>,
    /// The modules of the forward recursion, and what each candidate would have cost.
    pub partition: (ModuleTree, Vec<(&'static str, usize)>),
}

/// Compiles `model` to Rust.
#[must_use]
pub fn emit(model: &Model, modules: &ModuleTree, options: &EmitOptions) -> Emitted {
    let prepared = Prepared::new(model);
    let tracer = Tracer::new(&prepared);
    let Choice { modules: eliminated, graph: forward, candidates } =
        partition::choose(model, &tracer);
    let quantities = quantities(model, &tracer, forward);
    let mut operations: Vec<_> = quantities.iter().map(|q| (q.name, q.graph.count())).collect();
    let type_name = options.type_name.clone().unwrap_or_else(|| names::type_name(model.name()));
    let robot = Robot { model, modules, options, name: &type_name };
    let layout = Layout::new(modules, model.nv());
    let brge = optimize(tracer.brge(&layout));
    operations.push(("brge", brge.count()));

    let mut text = String::new();
    docs::robot(&mut text, &robot, &operations, (&eliminated, &candidates));
    robot.types(&mut text, &layout);
    let krate = &options.krate;
    let _ = writeln!(
        text,
        "#[allow(clippy::all, clippy::pedantic, clippy::nursery, dead_code, unused_imports, unused_variables, non_snake_case)]\n\
         const _: () = {{\n\
         use {krate} as __modyn;\n"
    );
    robot.functions(&mut text, &quantities, &operations);
    robot.robot_trait(&mut text, &quantities);
    robot.factorization(&mut text, &layout, &tracer);
    robot.enums(&mut text);
    for quantity in &quantities {
        let parameters: Vec<Parameter> =
            quantity.parameters.iter().map(|&name| Parameter { name, len: model.nv() }).collect();
        text += &function(quantity.name, &parameters, quantity.shape, &quantity.graph);
    }
    let q = [Parameter { name: "q", len: model.nv() }];
    text += &function("brge", &q, Shape::Vector(layout.size()), &brge);
    text += "};\n";
    Emitted { text, type_name, operations, partition: (eliminated, candidates) }
}

/// What the parts of the text are written from.
struct Robot<'a> {
    model: &'a Model,
    modules: &'a ModuleTree,
    options: &'a EmitOptions,
    name: &'a str,
}

impl Robot<'_> {
    fn joint_names(&self) -> Vec<&str> {
        self.model.links().iter().map(|link| link.joint.name.as_str()).collect()
    }

    fn link_names(&self) -> Vec<&str> {
        self.model.frames().iter().map(|frame| frame.name.as_str()).collect()
    }

    /// The type's own constants and functions.
    fn functions(
        &self,
        text: &mut String,
        quantities: &[Quantity],
        operations: &[(&str, OperationCount)],
    ) {
        let (name, n, float) = (self.name, self.model.nv(), self.options.float.name());
        let (joints, links) = (self.joint_names(), self.link_names());
        let _ = writeln!(
            text,
            "impl {name} {{\n\
             /// The robot's name in its description.\n\
             pub const NAME: &'static str = {:?};\n\
             /// Length of the coordinate vector.\n\
             pub const NQ: usize = {n};\n\
             /// Length of the velocity vector: degrees of freedom.\n\
             pub const NV: usize = {n};\n\
             /// The joints, in the order of all joint vectors.\n\
             pub const JOINT_NAMES: [&'static str; {n}] = {joints:?};\n\
             /// All links of the description, in its order.\n\
             pub const LINK_NAMES: [&'static str; {}] = {links:?};\n\
             /// The acceleration of free fall in world axes, m/s^2.\n\
             pub const GRAVITY: [f64; 3] = {:?};\n\
             /// The kinematic modules, parents before children.\n\
             pub const MODULES: [__modyn::KinematicModule; {}] = [",
            self.model.name(),
            links.len(),
            self.model.gravity(),
            self.modules.modules().len()
        );
        for module in self.modules.modules() {
            let range = module.links.clone();
            let link_names: Vec<&str> =
                self.model.links()[range.clone()].iter().map(|l| l.name.as_str()).collect();
            let _ = writeln!(
                text,
                "__modyn::KinematicModule {{ parent: ::core::option::Option::{:?}, children: &{:?}, links: &{link_names:?}, joints: &{:?}, first: {} }},",
                module.parent,
                module.children,
                &joints[range.clone()],
                range.start
            );
        }
        text.push_str("];\n");
        for (quantity, count) in operations {
            let OperationCount { multiplications, additions, divisions, sin_cos, others } = count;
            let _ = writeln!(
                text,
                "/// What `{quantity}` takes.\n\
                 pub const {}_OPERATIONS: __modyn::OperationCount = __modyn::OperationCount {{ multiplications: {multiplications}, \
                 additions: {additions}, divisions: {divisions}, sin_cos: {sin_cos}, others: {others} }};",
                quantity.to_uppercase()
            );
        }
        for quantity in quantities {
            let Quantity { name, shape, docs, .. } = quantity;
            let lines: Vec<String> = docs.lines().map(|line| format!("/// {line}\n")).collect();
            let _ = writeln!(
                text,
                "{}#[must_use]\npub fn {name}({}) -> {} {{\n    {name}({})\n}}",
                lines.concat(),
                quantity.typed(n, float),
                shape.type_of(float),
                quantity.parameters.join(", "),
            );
        }
        let _ = writeln!(
            text,
            "/// The generalized inertia matrix at `q` as U D U^T by kinematic modules: block reverse\n\
             /// Gaussian elimination.\n\
             #[must_use]\n\
             pub fn brge(q: &[{float}; {n}]) -> {name}Brge {{\n    {name}Brge {{ factors: brge(q) }}\n}}\n}}\n"
        );
    }

    /// `impl Robot`.
    fn robot_trait(&self, text: &mut String, quantities: &[Quantity]) {
        let (name, n) = (self.name, self.model.nv());
        let _ = writeln!(
            text,
            "impl __modyn::Robot for {name} {{\n\
             const NAME: &'static str = Self::NAME;\n\
             const NQ: usize = {n};\n\
             const NV: usize = {n};\n\
             const JOINT_NAMES: &'static [&'static str] = &Self::JOINT_NAMES;\n\
             const LINK_NAMES: &'static [&'static str] = &Self::LINK_NAMES;\n\
             const MODULES: &'static [__modyn::KinematicModule] = &Self::MODULES;\n\
             type Params = ();\n\
             type Q<T: __modyn::Scalar> = [T; {n}];\n\
             type V<T: __modyn::Scalar> = [T; {n}];\n\
             type M<T: __modyn::Scalar> = [[T; {n}]; {n}];\n\
             type Poses<T: __modyn::Scalar> = [__modyn::spatial::Pose<T>; {}];\n\
             type Brge<T: __modyn::Scalar> = {name}Brge<T>;",
            self.model.frames().len()
        );
        for quantity in quantities {
            // Where the links stand depends on no parameter.
            let (with, params) = match quantity.shape {
                Shape::Poses(_) => ("", ""),
                _ => ("_with", "(): &(), "),
            };
            let _ = writeln!(
                text,
                "fn {}{with}<T: __modyn::Scalar>({params}{}) -> {} {{\n    {}({})\n}}",
                quantity.name,
                quantity.typed(n, "T"),
                quantity.shape.type_of("T"),
                quantity.name,
                quantity.parameters.join(", "),
            );
        }
        let _ = writeln!(
            text,
            "fn brge_with<T: __modyn::Scalar>((): &(), q: &[T; {n}]) -> {name}Brge<T> {{\n    \
             {name}Brge {{ factors: brge(q) }}\n}}\n}}\n"
        );
    }
}
