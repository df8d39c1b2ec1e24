//! Functions of users: each becomes several planned functions, its value and its derivatives.

use std::fmt;
use std::sync::Arc;

use modyn_runtime::model::Model;
use modyn_runtime::{
    Interpreter, UserArgument, UserArgumentKind, UserDerivatives, UserError, UserFunction,
};

use super::context::SymbolicRobot;
use super::wrapped::wrapped;
use super::{Argument, ArgumentKind, Record, Shape, Sizes};
use crate::graph::{Expr, Graph};
use crate::intern::intern;
use crate::names;
use crate::trace::{Parameters, TangentGraphs, TangentInput, Tracer, UserGraphs, UserTraceError};

/// The largest number of operations of a form of a user's function. Their text has about 20 MB.
pub const MAX_USER_OPERATIONS: usize = 400_000;

/// A user's function on expressions.
type Evaluate =
    dyn Fn(&mut Interpreter<Expr>, &[&[Expr]]) -> Result<Vec<Expr>, UserError> + Send + Sync;

/// A user's function with its name, independent of any robot.
#[derive(Clone)]
pub struct NamedFunction {
    /// The name, in snake case.
    pub name: String,
    /// Whether its value and derivatives also have forms for many states.
    pub batch: bool,
    /// The documentation.
    pub docs: String,
    /// The arguments.
    pub arguments: Vec<UserArgument>,
    /// The derivatives to be compiled.
    pub derivatives: UserDerivatives,
    evaluate: Arc<Evaluate>,
}

impl fmt::Debug for NamedFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, batch, docs, arguments, derivatives, evaluate: _ } = self;
        let mut debug = f.debug_struct("NamedFunction");
        debug.field("name", name).field("batch", batch).field("docs", docs);
        debug
            .field("arguments", arguments)
            .field("derivatives", derivatives)
            .finish_non_exhaustive()
    }
}

/// The forms of a user's function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UserForm {
    /// The value.
    Value,
    /// The value, and its change along a displacement.
    Jvp,
    /// The results, and products of a vector and their derivatives.
    Vjp,
    /// The value of a function of one result, and its gradients.
    Gradient,
    /// The results, and their derivatives.
    Jacobian,
    /// The results, and the gradients and the Hessian of their weighted sum.
    Hessian,
}

impl UserForm {
    /// All forms.
    pub const ALL: [Self; 6] =
        [Self::Value, Self::Jvp, Self::Vjp, Self::Gradient, Self::Jacobian, Self::Hessian];

    /// Returns the end of the form's name, after the function's name.
    #[must_use]
    pub const fn suffix(self) -> &'static str {
        match self {
            Self::Value => "",
            Self::Jvp => "_jvp",
            Self::Vjp => "_vjp",
            Self::Gradient => "_gradient",
            Self::Jacobian => "_jacobian",
            Self::Hessian => "_hessian",
        }
    }

    /// Returns the form's graph; `None` if it takes more than [`MAX_USER_OPERATIONS`].
    fn graph(self, graphs: &TangentGraphs<'_>) -> Option<Graph> {
        let graph = match self {
            Self::Value => graphs.value.clone(),
            Self::Jvp => graphs.jvp(),
            Self::Vjp | Self::Gradient => graphs.vjp(),
            Self::Jacobian => graphs.jacobian(),
            Self::Hessian => graphs.hessian(MAX_USER_OPERATIONS)?,
        };
        (!graph.takes_more_than(MAX_USER_OPERATIONS)).then_some(graph)
    }

    /// Returns whether a function of this number of results has the form if these derivatives are
    /// compiled.
    fn exists(self, derivatives: UserDerivatives, results: usize) -> bool {
        match self {
            Self::Value => true,
            Self::Jvp => derivatives >= UserDerivatives::First,
            Self::Gradient => derivatives >= UserDerivatives::First && results == 1,
            Self::Vjp | Self::Jacobian => derivatives >= UserDerivatives::First && results != 1,
            Self::Hessian => derivatives >= UserDerivatives::Second,
        }
    }
}

/// The reason why a function of a user has no plan.
#[derive(Debug)]
pub enum UserPlanError {
    /// It cannot be traced.
    Trace(UserTraceError),
    /// It has no results.
    NoResults,
    /// Its value has a constant that is not a finite number.
    NotFinite,
    /// A form takes more than [`MAX_USER_OPERATIONS`].
    TooLong(UserForm),
}

/// A form of a user's function of one robot.
#[derive(Clone, Debug)]
pub struct TracedForm {
    /// The name.
    pub name: &'static str,
    /// The documentation, in lines.
    pub docs: &'static str,
    /// The documentation of each field of the result; empty for the value.
    pub fields: Vec<&'static str>,
    /// The arguments.
    pub arguments: Vec<Argument>,
    /// The layout of the result.
    pub result: Shape,
    /// The graph, before all passes.
    pub graph: Graph,
    /// Another graph of the same results, which shares more with the functions of the table in a
    /// fused function; `None` if it is too long.
    pub in_fused: Option<Graph>,
}

/// A user's function of one robot.
#[derive(Clone, Debug)]
pub struct TracedFunction {
    /// The name.
    pub name: &'static str,
    /// The names of the arguments.
    pub arguments: Vec<&'static str>,
    /// Whether its forms are also compiled for many states.
    pub batch: bool,
    /// Whether it depends on run-time parameters.
    pub depends_on_parameters: bool,
    /// Its value and derivatives.
    pub forms: Vec<TracedForm>,
}

impl NamedFunction {
    /// Returns a user's function with a name, in snake case.
    pub fn new<const N: usize>(
        name: String,
        function: impl UserFunction<N> + Send + Sync + 'static,
        batch: bool,
    ) -> Self {
        let arguments = function.arguments().to_vec();
        let derivatives = match arguments.iter().any(UserArgument::is_variable) {
            true => function.derivatives(),
            false => UserDerivatives::None,
        };
        Self {
            name,
            batch,
            docs: function.docs(),
            arguments,
            derivatives,
            evaluate: Arc::new(move |robot, arguments| {
                function.evaluate(robot, arguments.try_into()?)
            }),
        }
    }

    /// Returns the names of all functions that it may become.
    pub(crate) fn names(&self) -> impl Iterator<Item = String> {
        UserForm::ALL.iter().map(|form| format!("{}{}", self.name, form.suffix()))
    }

    /// Returns the variables: the arguments that derivatives are with respect to.
    pub(crate) fn variables(&self) -> impl Iterator<Item = &UserArgument> {
        self.arguments.iter().filter(|argument| argument.is_variable())
    }

    /// Returns the names of the arguments of all forms, the function's arguments first.
    pub(crate) fn argument_names(&self) -> Vec<String> {
        let argument_names = self.arguments.iter().map(|argument| argument.name().to_string());
        let mut names: Vec<String> = argument_names.collect();
        if self.derivatives >= UserDerivatives::First {
            names.extend(self.variables().map(|argument| format!("tangent_{}", argument.name())));
            names.push(WEIGHTS.into());
        }
        names
    }

    /// Returns the names of the blocks of its Hessian, if it has one.
    pub(crate) fn block_names(&self) -> Vec<String> {
        let variables: Vec<&UserArgument> = match self.derivatives {
            UserDerivatives::Second => self.variables().collect(),
            _ => Vec::new(),
        };
        let rows = variables.iter().enumerate();
        rows.flat_map(|(i, a)| variables[i..].iter().map(|b| block_name(a, b))).collect()
    }

    /// Returns the function of a robot with these run-time parameters.
    ///
    /// # Errors
    ///
    /// If the function cannot be traced, or a form of it is too long.
    pub(crate) fn of(
        &self,
        model: &Model,
        parameters: Parameters,
    ) -> Result<TracedFunction, UserPlanError> {
        let robot = SymbolicRobot::new(model, parameters);
        let tracer = Tracer::with_parameters(&robot.mechanism, robot.parameters.clone());
        let sizes = Sizes::new(model, 0);
        let UserGraphs { optimized: graphs, traced } = tracer
            .user_function(model, self.inputs(&sizes), &*self.evaluate)
            .map_err(UserPlanError::Trace)?;
        let live = graphs.value.live();
        let constants = live
            .iter()
            .enumerate()
            .filter_map(|(at, &live)| graphs.value.value(u32::try_from(at).ok()?).filter(|_| live));
        if graphs.value.outputs.is_empty() {
            return Err(UserPlanError::NoResults);
        }
        if constants.into_iter().any(|constant| !constant.is_finite()) {
            return Err(UserPlanError::NotFinite);
        }
        let results = graphs.value.outputs.len();
        let forms = UserForm::ALL.iter().filter(|form| form.exists(self.derivatives, results));
        Ok(TracedFunction {
            name: intern(&self.name),
            arguments: self.arguments.iter().map(UserArgument::name).collect(),
            batch: self.batch,
            depends_on_parameters: graphs.depends_on_parameters(),
            forms: forms
                .map(|&form| self.form(form, &graphs, &traced))
                .collect::<Result<_, _>>()?,
        })
    }

    /// Returns whether the function's value depends on the inertia of links; `false` if the
    /// function cannot be traced.
    pub(crate) fn depends_on_inertia(&self, model: &Model) -> bool {
        let carries =
            |moving: usize| model.links().iter().position(|link| link.moving_link == Some(moving));
        let links: Vec<usize> = (0..model.moving_links().len()).filter_map(carries).collect();
        let robot = SymbolicRobot::new(model, Parameters::new(model, false, &links, &[]));
        let tracer = Tracer::with_parameters(&robot.mechanism, robot.parameters.clone());
        let inputs = self.inputs(&Sizes::new(model, 0));
        let graphs = tracer.user_function(model, inputs, &*self.evaluate);
        graphs.is_ok_and(|graphs| graphs.optimized.depends_on_parameters())
    }

    fn inputs(&self, sizes: &Sizes) -> Vec<TangentInput> {
        let input = |argument: &UserArgument| TangentInput {
            len: self::argument(argument).shape(sizes).len(),
            is_coordinates: argument.kind() == UserArgumentKind::Coordinates,
            varies: argument.is_variable(),
        };
        self.arguments.iter().map(input).collect()
    }

    fn form(
        &self,
        form: UserForm,
        graphs: &TangentGraphs<'_>,
        traced: &TangentGraphs<'_>,
    ) -> Result<TracedForm, UserPlanError> {
        let graph = form.graph(graphs).ok_or(UserPlanError::TooLong(form))?;
        let in_fused = form.graph(traced);
        let name = intern(&format!("{}{}", self.name, form.suffix()));
        let count = graphs.value.outputs.len();
        let Results { fields, docs, sum } = self.results(form, count, &graphs.displacements());
        let mut arguments: Vec<Argument> = self.arguments.iter().map(argument).collect();
        match form {
            UserForm::Jvp => arguments.extend(self.variables().map(change)),
            UserForm::Vjp | UserForm::Hessian if count != 1 => {
                arguments.push(Argument { name: WEIGHTS, kind: ArgumentKind::Numbers(count) });
            }
            _ => {}
        }
        let (result, docs) = match form {
            UserForm::Value => (value_shape(count), printable(&self.docs)),
            _ => {
                let record = Record::Fused(intern(&names::type_name(name)));
                let shapes = fields.iter().map(|(name, shape, _)| (*name, shape.clone()));
                (Shape::Record(record, shapes.collect()), self.derivative_docs(&docs, &sum))
            }
        };
        let fields = match form {
            UserForm::Value => Vec::new(),
            _ => fields.into_iter().map(|(.., docs)| docs).collect(),
        };
        Ok(TracedForm { name, docs: intern(&docs), fields, arguments, result, graph, in_fused })
    }

    /// Returns the documentation of a form with derivatives.
    fn derivative_docs(&self, docs: &str, sum: &str) -> String {
        let coordinates =
            |argument: &&UserArgument| argument.kind() == UserArgumentKind::Coordinates;
        let names: Vec<String> = self
            .variables()
            .filter(coordinates)
            .map(|argument| format!("`{}`", argument.name()))
            .collect();
        let tangent = match names.is_empty() {
            true => String::new(),
            false => format!(
                " Derivatives with respect to {} are in tangent space.",
                names.join(" and ")
            ),
        };
        wrapped(&format!("Returns the value of `{}`, and {docs}{sum}.{tangent}", self.name))
    }

    /// Returns the fields of a form's result.
    fn results(&self, form: UserForm, count: usize, displacements: &[usize]) -> Results {
        let quoted = format!("`{}`", self.name);
        let sum = match (form, count) {
            (UserForm::Vjp | UserForm::Hessian, 2..) => format!(" of `{WEIGHTS}`^T {quoted}"),
            (UserForm::Gradient | UserForm::Hessian, _) => format!(" of {quoted}"),
            _ => String::new(),
        };
        let mut fields =
            vec![("value", value_shape(count), intern(&format!("The value of {quoted}.")))];
        let variables: Vec<(&UserArgument, usize)> =
            self.variables().zip(displacements.iter().copied()).collect();
        let derivative = |columns: usize, argument: &UserArgument| match form {
            UserForm::Jacobian => {
                let shape = if count == 1 { Shape::Scalar } else { Shape::vector(count) };
                let text = format!(
                    "The derivatives of {quoted} with respect to `{}`, by columns.",
                    argument.name()
                );
                (shape.array(columns), intern(&text))
            }
            _ => {
                let text = format!("The gradient{sum} with respect to `{}`.", argument.name());
                (gradient_shape(argument, columns), intern(&text))
            }
        };
        let docs = match form {
            UserForm::Value => "",
            UserForm::Jvp => {
                let text = format!("The change of {quoted}.");
                fields.push(("tangent_value", value_shape(count), intern(&text)));
                "its change along the changes of its arguments"
            }
            UserForm::Vjp | UserForm::Gradient => "the gradients",
            UserForm::Jacobian => "its derivatives, by columns",
            UserForm::Hessian => "the gradients and the Hessian, in blocks by columns,",
        };
        if !matches!(form, UserForm::Value | UserForm::Jvp) {
            for &(argument, columns) in &variables {
                let (shape, docs) = derivative(columns, argument);
                let name = match form {
                    UserForm::Jacobian => format!("dvalue_d{}", argument.name()),
                    _ => format!("grad_{}", argument.name()),
                };
                fields.push((intern(&name), shape, docs));
            }
        }
        if form == UserForm::Hessian {
            for (i, &(a, rows)) in variables.iter().enumerate() {
                for &(b, columns) in &variables[i..] {
                    let name = intern(&block_name(a, b));
                    let text = format!(
                        "The second derivatives{sum} with respect to `{}` (rows) and `{}` (columns), by columns.",
                        a.name(),
                        b.name()
                    );
                    fields.push((name, Shape::matrix(columns, rows), intern(&text)));
                }
            }
        }
        Results { fields, docs: docs.into(), sum }
    }
}

/// Returns the name of the block of a Hessian with a row for each entry of `a` and a column for each
/// entry of `b`.
fn block_name(a: &UserArgument, b: &UserArgument) -> String {
    format!("hess_{}_{}", a.name(), b.name())
}

/// The name of the weights of results.
const WEIGHTS: &str = "cotangent";

/// The fields of a form's result, with its documentation: the words about the derivatives, and
/// about the sum that they are of.
struct Results {
    fields: Vec<(&'static str, Shape, &'static str)>,
    docs: String,
    sum: String,
}

/// Returns the layout of a value: one result is a number.
fn value_shape(count: usize) -> Shape {
    if count == 1 { Shape::Scalar } else { Shape::vector(count) }
}

/// Returns the layout of a gradient with respect to an argument.
fn gradient_shape(argument: &UserArgument, len: usize) -> Shape {
    match argument.kind() {
        UserArgumentKind::Number => Shape::Scalar,
        _ => Shape::vector(len),
    }
}

/// Returns an argument as functions of the table have them.
fn argument(argument: &UserArgument) -> Argument {
    let kind = match argument.kind() {
        UserArgumentKind::Coordinates => ArgumentKind::Coordinates,
        UserArgumentKind::Velocities => ArgumentKind::Velocities,
        UserArgumentKind::Number => ArgumentKind::Number,
        UserArgumentKind::Numbers(count) => ArgumentKind::Numbers(count),
    };
    Argument { name: argument.name(), kind }
}

/// Returns the change of an argument, which for coordinates is in tangent space.
fn change(variable: &UserArgument) -> Argument {
    let Argument { name, kind } = argument(variable);
    let kind = match kind {
        ArgumentKind::Coordinates => ArgumentKind::Velocities,
        other => other,
    };
    Argument { name: intern(&format!("tangent_{name}")), kind }
}

/// Returns a documentation that ends no comment of any language.
fn printable(docs: &str) -> String {
    let lines = docs.lines().map(|line| {
        let plain: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        wrapped(&plain.replace("*/", "* /").replace("/*", "/ *"))
    });
    lines.collect::<Vec<_>>().join("\n")
}
