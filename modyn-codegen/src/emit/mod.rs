//! From graphs to the text of a Rust type.
//!
//! Public items are documented; private functions are generic over the scalar, the type's own
//! functions concrete, so that inference stays plain and the robot's crate holds compiled code.
//! The text uses `core` and the crate `modyn` only. It is the same for the same input, in every
//! process: nothing in here depends on an address or on a hash map's order.

mod docs;
mod function;

use std::fmt::Write as _;

use modyn_runtime::OperationCount;
use modyn_runtime::equations::brge::Layout;
use modyn_runtime::model::prepare::Prepared;
use modyn_runtime::model::{Model, ModuleTree};

use crate::error::Diagnostic;
use crate::expr::Graph;
use crate::names;
use crate::partition::{self, Choice};
use crate::passes::optimize;
use crate::trace::Tracer;
use function::{Parameter, Shape, function};

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

/// A quantity's function: its graph, and how it is called.
struct Quantity {
    name: &'static str,
    parameters: &'static [&'static str],
    shape: Shape,
    graph: Graph,
    /// The lines of its documentation.
    docs: &'static str,
}

/// The text, and what is worth reporting about it.
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
    let operations: Vec<_> = quantities.iter().map(|q| (q.name, q.graph.count())).collect();
    let type_name = options.type_name.clone().unwrap_or_else(|| names::type_name(model.name()));
    let robot = Robot { model, modules, options, name: &type_name };
    let layout = Layout::new(modules, model.nv());
    let brge = optimize(tracer.brge(&layout));
    let mut operations = operations;
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

fn quantities(model: &Model, tracer: &Tracer<'_>, forward_dynamics: Graph) -> Vec<Quantity> {
    let n = model.nv();
    let quantity =
        |name, parameters, shape, graph, docs| Quantity { name, parameters, shape, graph, docs };
    vec![
        quantity(
            "forward_dynamics",
            &["q", "qd", "tau"],
            Shape::Vector(n),
            forward_dynamics,
            "Joint accelerations (rad/s^2 or m/s^2) at coordinates `q` and velocities `qd` under the joint\n\
             torques or forces `tau` (N m or N), gravity included: block reverse Gaussian elimination of the\n\
             generalized inertia matrix by inter- and intra-modular recursion.",
        ),
        quantity(
            "inverse_dynamics",
            &["q", "qd", "qdd"],
            Shape::Vector(n),
            optimize(tracer.inverse_dynamics()),
            "Joint torques or forces (N m or N) of the accelerations `qdd` at coordinates `q` and velocities\n\
             `qd`, gravity included: recursive Newton-Euler.",
        ),
        quantity(
            "bias_forces",
            &["q", "qd"],
            Shape::Vector(n),
            optimize(tracer.bias_forces()),
            "Coriolis, centrifugal and gravity torques: inverse dynamics without acceleration.",
        ),
        quantity(
            "gravity_torques",
            &["q"],
            Shape::Vector(n),
            optimize(tracer.gravity_torques()),
            "Joint torques that hold the robot still at `q`.",
        ),
        quantity(
            "mass_matrix",
            &["q"],
            Shape::Matrix(n, n),
            optimize(tracer.mass_matrix()),
            "The generalized inertia matrix at `q`, an array of columns: by composite modules.",
        ),
        quantity(
            "kinetic_energy",
            &["q", "qd"],
            Shape::Scalar,
            optimize(tracer.kinetic_energy()),
            "Kinetic energy of the moving links, J.",
        ),
        quantity(
            "potential_energy",
            &["q"],
            Shape::Scalar,
            optimize(tracer.potential_energy()),
            "Potential energy of the moving links under gravity, J; zero at the world's origin.",
        ),
        quantity(
            "link_poses",
            &["q"],
            Shape::Poses(model.frames().len()),
            optimize(tracer.link_poses()),
            "The poses in the world of all links of the description, fixed ones too, in the order of\n\
             `LINK_NAMES`.",
        ),
    ]
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

    /// The public types, without their functions.
    fn types(&self, text: &mut String, layout: &Layout) {
        let (name, vis) = (self.name, &self.options.visibility);
        let float = self.options.float.name();
        let _ = writeln!(
            text,
            "#[allow(dead_code)]\n#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]\n{vis} struct {name};\n"
        );
        for (kind, names, what) in
            [("Joint", self.joint_names(), "joint"), ("Link", self.link_names(), "link")]
        {
            let _ = writeln!(
                text,
                "/// A {what} of [`{name}`].\n\
                 #[allow(dead_code)]\n\
                 #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]\n\
                 {vis} enum {name}{kind} {{"
            );
            for (variant, original) in names::variants(&names).iter().zip(&names) {
                let _ = writeln!(text, "    /// {}\n    {variant},", docs::code(original));
            }
            text.push_str("}\n\n");
        }
        let _ = writeln!(
            text,
            "/// The generalized inertia matrix of [`{name}`] as U D U^T by kinematic modules.\n\
             #[allow(dead_code)]\n\
             #[derive(Clone, Copy, Debug, PartialEq)]\n\
             {vis} struct {name}Brge<T = {float}> {{\n    factors: [T; {}],\n}}\n",
            layout.size()
        );
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

    /// The functions of the factorization.
    fn factorization(&self, text: &mut String, layout: &Layout, tracer: &Tracer<'_>) {
        let (name, n) = (self.name, self.model.nv());
        let square = Shape::Matrix(n, n);
        let matrix = square.type_of("T");
        let vector = Shape::Vector(n).type_of("T");
        let factors = Parameter { name: "factors", len: layout.size() };
        let rhs = Parameter { name: "rhs", len: n };
        let graphs = [
            (
                "u",
                square,
                tracer.u(layout),
                "The block upper triangular U, (43), an array of columns.",
            ),
            ("d", square, tracer.d(layout), "The block diagonal D, (45), an array of columns."),
            ("u_inverse", square, tracer.u_inverse(layout), "U^-1, (54), an array of columns."),
            ("d_inverse", square, tracer.d_inverse(layout), "D^-1, (54), an array of columns."),
            (
                "log_determinant",
                Shape::Scalar,
                tracer.log_determinant(layout),
                "The natural logarithm of the determinant.",
            ),
        ];
        let _ = writeln!(text, "impl<T: __modyn::Scalar> {name}Brge<T> {{");
        for (function_name, shape, _, docs) in &graphs {
            let _ = writeln!(
                text,
                "/// {docs}\n#[must_use]\npub fn {function_name}(&self) -> {} {{\n    \
                 {function_name}(&self.factors)\n}}",
                shape.type_of("T")
            );
        }
        let _ = writeln!(
            text,
            "/// The x with I x = `rhs`, by the three steps of (60).\n\
             #[must_use]\n\
             pub fn solve(&self, rhs: &{vector}) -> {vector} {{\n    solve(&self.factors, rhs)\n}}\n\
             /// The inverse, (50), an array of columns.\n\
             #[must_use]\n\
             pub fn inverse(&self) -> {matrix} {{\n    \
             ::core::array::from_fn(|j| {{\n        \
             let unit = ::core::array::from_fn(|i| if i == j {{ T::one() }} else {{ T::zero() }});\n        \
             solve(&self.factors, &unit)\n    }})\n}}"
        );
        let mut condition_numbers = String::new();
        for (m, block) in layout.blocks().iter().enumerate() {
            let size = block.links.len();
            let entries: Vec<String> = (0..layout.size())
                .map(|i| if layout.d(m).contains(&i) { format!("d{i}") } else { "_".into() })
                .collect();
            // Only the entries up to the block's last are named; the rest is one pattern.
            let shown = entries[..layout.d(m).end].join(", ");
            let names = entries[layout.d(m)].join(", ");
            let joints = self.joint_names()[block.links.clone()].join(", ");
            let block_rows: Vec<String> = entries[layout.d(m)]
                .chunks(size)
                .map(|row| format!("[{}]", row.join(", ")))
                .collect();
            let _ = writeln!(
                text,
                "/// The pivot block of module {m} (joints {}), (46), an array of columns.\n\
                 #[must_use]\n\
                 pub fn pivot_block_{m}(&self) -> [[T; {size}]; {size}] {{\n    \
                 let [{shown}, ..] = self.factors;\n    [{}]\n}}",
                docs::code(&joints),
                block_rows.join(", ")
            );
            let _ = writeln!(
                condition_numbers,
                "        {{\n            let [{shown}, ..] = self.factors;\n            \
                 __modyn::jacobi::condition_number(&mut [{names}], {size})\n        }},"
            );
        }
        let count = layout.blocks().len();
        let _ = writeln!(
            text,
            "/// The condition number (2-norm) of each module's pivot block, by a fixed number of Jacobi sweeps.\n\
             #[must_use]\n\
             pub fn condition_numbers(&self) -> [T; {count}] {{\n    [\n{condition_numbers}    ]\n}}\n}}\n"
        );
        let _ = writeln!(
            text,
            "impl<T: __modyn::Scalar> __modyn::Factorization<T> for {name}Brge<T> {{\n\
             type V = {vector};\n\
             type M = {matrix};"
        );
        for (function_name, shape, ..) in &graphs {
            let _ = writeln!(
                text,
                "fn {function_name}(&self) -> {} {{\n    Self::{function_name}(self)\n}}",
                shape.type_of("T")
            );
        }
        let _ = writeln!(
            text,
            "fn solve(&self, rhs: &{vector}) -> {vector} {{\n    Self::solve(self, rhs)\n}}\n\
             fn inverse(&self) -> {matrix} {{\n    Self::inverse(self)\n}}\n\
             fn condition_number(&self, module: usize) -> ::core::option::Option<T> {{\n    \
             Self::condition_numbers(self).get(module).copied()\n}}\n}}\n"
        );
        for (function_name, shape, graph, _) in graphs {
            *text +=
                &function(function_name, std::slice::from_ref(&factors), shape, &optimize(graph));
        }
        let solve = optimize(tracer.solve(layout));
        *text += &function("solve", &[factors, rhs], Shape::Vector(n), &solve);
    }

    /// The functions of the enums.
    fn enums(&self, text: &mut String) {
        let name = self.name;
        for (kind, names, constant) in [
            ("Joint", self.joint_names(), "JOINT_NAMES"),
            ("Link", self.link_names(), "LINK_NAMES"),
        ] {
            let variants = names::variants(&names);
            let all: Vec<String> = variants.iter().map(|v| format!("Self::{v}")).collect();
            let arms: Vec<String> = variants
                .iter()
                .zip(&names)
                .map(|(variant, name)| format!("Self::{variant} => {name:?},\n"))
                .collect();
            let _ = writeln!(
                text,
                "impl {name}{kind} {{\n\
                 /// All, in the order of `{constant}`.\n\
                 pub const ALL: [Self; {}] = [{}];\n\
                 /// The position in `{constant}`.\n\
                 #[must_use]\n\
                 pub const fn index(self) -> usize {{\n    self as usize\n}}\n\
                 /// The name in the description.\n\
                 #[must_use]\n\
                 pub const fn name(self) -> &'static str {{\n    match self {{\n{}    }}\n}}\n}}\n",
                all.len(),
                all.join(", "),
                arms.concat(),
            );
        }
    }
}

impl Quantity {
    /// The parameters with their types.
    fn typed(&self, n: usize, scalar: &str) -> String {
        let typed: Vec<String> =
            self.parameters.iter().map(|name| format!("{name}: &[{scalar}; {n}]")).collect();
        typed.join(", ")
    }
}
