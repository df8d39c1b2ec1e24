//! Fused functions as options: their names and members, and the checks that need no robot.

use modyn_read::diagnostics::{Code, Diagnostic, suggest};
use modyn_runtime::model::Model;

use super::own_names::{OwnNames, name_defect};
use super::types::{OptionValue, pair};
use super::value::{OptionError, Value, ValueKind};
use crate::intern::intern;
use crate::names;
use crate::plan::{self, Argument, BatchForm, Function, MemberFunction, Sizes, TracedFunction};

/// A fused function: several functions that one call computes, with their common work done once.
///
/// ```
/// use modyn_codegen::{Builder, FusedFunction, Function};
///
/// let control = FusedFunction::new("control")
///     .function(Function::MassMatrix)
///     .function(Function::BiasForces)
///     .of_link(Function::Jacobian, "hand");
/// let builder = Builder::new().urdf("arm.urdf").fused([control]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FusedFunction {
    name: String,
    members: Vec<Member>,
    batch: bool,
}

/// A function in a fused function.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Member {
    /// A function of the table, and the name of the link of a function of one link.
    Table(Function, Option<String>),
    /// A user's function or one of its derivatives, by name.
    User(String),
}

/// An error of a fused function, and its remedy.
struct Defect {
    /// The member with the error, by its index; `None` for the name or the whole fused function.
    member: Option<usize>,
    message: String,
    help: String,
}

impl FusedFunction {
    /// Returns a fused function without functions. The generated function has this name, in snake
    /// case; the name of the result's type follows from it.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), members: Vec::new(), batch: false }
    }

    /// Adds a function. Its field of the result has the function's name.
    #[must_use]
    pub fn function(mut self, function: Function) -> Self {
        self.members.push(Member::Table(function, None));
        self
    }

    /// Adds a function of one link, such as `jacobian`. Its field of the result has the names of
    /// the function and the link: `jacobian_hand`.
    #[must_use]
    pub fn of_link(mut self, function: Function, link: impl Into<String>) -> Self {
        self.members.push(Member::Table(function, Some(link.into())));
        self
    }

    /// Adds a function of the user's own that [`Builder::function`](crate::Builder::function)
    /// compiles, or a derivative of it, by name: `reach_cost`, `reach_cost_gradient`. Its field of
    /// the result has this name.
    #[must_use]
    pub fn own_function(mut self, name: impl Into<String>) -> Self {
        self.members.push(Member::User(name.into()));
        self
    }

    /// Adds the form of the fused function for many states.
    #[must_use]
    pub fn batch(mut self) -> Self {
        self.batch = true;
        self
    }

    /// Returns the functions of the table without the functions of one link.
    pub(crate) fn functions(&self) -> impl Iterator<Item = Function> {
        self.members.iter().filter_map(|member| match member {
            Member::Table(function, None) => Some(*function),
            _ => None,
        })
    }

    /// Returns the errors that no robot is needed to find.
    fn defects(&self) -> Vec<Defect> {
        let mut defects: Vec<Defect> = self.name_defect().into_iter().collect();
        if self.members.is_empty() {
            defects.push(Defect {
                member: None,
                message: "it has no functions".into(),
                help: "name some, such as `(mass_matrix, bias_forces)`".into(),
            });
        }
        for (i, member) in self.members.iter().enumerate() {
            let defect = member.defect(self.batch).or_else(|| {
                let same =
                    self.members[..i].iter().find(|other| other.field() == member.field())?;
                let help = match same == member {
                    true => "name it once",
                    false => {
                        "their links have the same name in snake case: put them in two fused \
                         functions"
                    }
                };
                Some((
                    format!("two functions would be the field `{}`", member.field()),
                    help.into(),
                ))
            });
            defects.extend(defect.map(|(message, help)| Defect { member: Some(i), message, help }));
        }
        defects
    }

    /// Returns the error of the fused function's name.
    fn name_defect(&self) -> Option<Defect> {
        let (message, help) = name_defect(&self.name, "fused function")?;
        Some(Defect { member: None, message, help })
    }

    /// Returns the errors of a fused function that no robot is needed to find.
    pub(crate) fn errors(&self) -> Vec<Diagnostic> {
        let defects = self.defects().into_iter();
        defects.map(|Defect { message, help, .. }| self.error(message, help)).collect()
    }

    /// Returns the fused function's name.
    pub(crate) fn names(&self) -> OwnNames {
        OwnNames {
            owner: format!("fused function `{}`", self.name),
            names: vec![self.name.clone()],
        }
    }

    fn error(&self, message: String, help: String) -> Diagnostic {
        let message = format!("fused function `{}`: {message}", self.name);
        Diagnostic::error(Code::Option, message).with_help(help)
    }

    /// Returns the fused function of a robot with these functions of the user; `None` if these are
    /// not known because of errors.
    ///
    /// # Errors
    ///
    /// If a link or a function of the user does not exist, the robot cannot have a function, or two
    /// functions have different arguments of one name.
    pub(crate) fn of(
        &self,
        model: &Model,
        user_functions: Option<&[TracedFunction]>,
    ) -> Result<plan::FusedFunction, Vec<Diagnostic>> {
        let mut members = Vec::new();
        let mut errors = Vec::new();
        for member in &self.members {
            let member_function = match member {
                Member::Table(function, link) => member.of_table(*function, link.as_ref(), model),
                Member::User(name) => match user_functions {
                    Some(functions) => member.of_user(name, functions),
                    None => continue,
                },
            };
            match member_function {
                Ok(member) => members.push(member),
                Err((message, help)) => errors.push(self.error(message, help)),
            }
        }
        let conflict = conflict(&members, &Sizes::new(model, 0));
        errors.extend(conflict.map(|(message, help)| self.error(message, help)));
        let name = intern(&self.name);
        let fused = plan::FusedFunction { name, members, batch: self.batch };
        if errors.is_empty() { Ok(fused) } else { Err(errors) }
    }
}

impl Member {
    /// Returns the name of the field.
    fn field(&self) -> String {
        match self {
            Self::Table(function, None) => function.name().into(),
            Self::Table(function, Some(link)) => {
                format!("{}_{}", function.name(), names::snake(link))
            }
            Self::User(name) => name.clone(),
        }
    }

    /// Returns the error and its remedy that no robot is needed to find, in a fused function for
    /// many states if `batch`.
    fn defect(&self, batch: bool) -> Option<(String, String)> {
        let Self::Table(function, link) = self else { return None };
        let row = function.row();
        let name = function.name();
        let refusal = |message: String, help: &str| Some((message, help.to_string()));
        if let Some(one) = row.batch_of {
            let message = format!("`{name}` is a function of many states");
            let help = format!(
                "write `{}`; a fused function `name: batch(..)` has a form for many states",
                one.name()
            );
            return Some((message, help));
        }
        if function.is_of_random_numbers() {
            let message = format!("`{name}` has no state as argument");
            return refusal(message, "call it by itself");
        }
        match (link, row.by_link) {
            (None, true) => {
                let help = format!("name the link: `{name}(\"link\")`");
                return Some((format!("`{name}` is a function of one link"), help));
            }
            (Some(_), false) => {
                let help = format!("write `{name}`");
                return Some((format!("`{name}` is not a function of one link"), help));
            }
            _ => {}
        }
        if batch && *function == Function::Brge {
            let message = "`brge` has no form for many states in a fused function, since its \
                factors are private";
            return refusal(message.into(), "take the function `brge_batch`, or leave out `batch`");
        }
        let other =
            row.arguments.iter().find(|argument| argument.kind.batch_form() == BatchForm::None);
        let argument = other.filter(|_| batch)?.name;
        let message =
            format!("`{name}` has no form for many states, since it has the argument `{argument}`");
        refusal(message, "leave it out, or leave out `batch`")
    }

    /// Returns the member of a robot's fused function for a function of the table, or the error and
    /// its remedy.
    fn of_table(
        &self,
        function: Function,
        link: Option<&String>,
        model: &Model,
    ) -> Result<plan::Member, (String, String)> {
        let name = function.name();
        if !function.fits(&Sizes::new(model, 0)) {
            let row = function.row();
            let (robots, needed) = if row.of_actuators {
                ("robots with actuators", "`actuators`")
            } else if row.of_touching_shapes {
                ("robots with shapes that touch the ground", "`contacts` or a `ground`")
            } else {
                ("robots with closed loops or contacts", "`contacts` or `loops`")
            };
            let help = format!("leave it out, or give the robot {needed}");
            return Err((format!("only {robots} have the function `{name}`"), help));
        }
        if function.row().has_solver {
            let message =
                format!("`{name}` is no member of a fused function, since its solver is a loop");
            return Err((message, "leave it out, and call it by itself".into()));
        }
        let names = || model.links().iter().map(|link| link.name.as_str());
        let index = link.map(|link| {
            names().position(|other| other == link).ok_or_else(|| {
                let help = suggest(link, names()).map_or_else(
                    || "name a link of the description".into(),
                    |name| format!("did you mean `{name}`?"),
                );
                (format!("link `{link}` does not exist"), help)
            })
        });
        // Names of descriptions have any characters; these end no comment of any language.
        let plain = |c: char| if c.is_ascii_alphanumeric() || "_-. ".contains(c) { c } else { '_' };
        let docs = match link {
            None => format!("`{name}`"),
            Some(link) => {
                format!("`{name}` of link `{}`", link.chars().map(plain).collect::<String>())
            }
        };
        Ok(plan::Member {
            function: MemberFunction::Table { function, link: index.transpose()? },
            field: intern(&self.field()),
            docs: intern(&docs),
        })
    }

    /// Returns the member of a robot's fused function for a user's function, or the error and its
    /// remedy.
    fn of_user(
        &self,
        name: &str,
        functions: &[TracedFunction],
    ) -> Result<plan::Member, (String, String)> {
        let forms = || {
            functions
                .iter()
                .flat_map(|function| function.forms.iter().map(move |form| (function, form)))
        };
        let Some((owner, form)) = forms().find(|(_, form)| form.name == name) else {
            let help = match suggest(name, forms().map(|(_, form)| form.name)) {
                Some(meant) => format!("did you mean `{meant}`?"),
                None => "add it with `Builder::function`".into(),
            };
            return Err((format!("there is no function `{name}` of yours"), help));
        };
        let function = MemberFunction::User {
            form: Box::new(form.clone()),
            depends_on_parameters: owner.depends_on_parameters,
        };
        let docs = intern(&format!("`{name}`"));
        Ok(plan::Member { function, field: intern(&self.field()), docs })
    }
}

/// `"name": (function, function("link"), ...)`, or `"name": batch(...)`
impl OptionValue for FusedFunction {
    fn read(value: &Value) -> Result<Self, OptionError> {
        let expected = "expected `name: (function, function(\"link\"), ...)`, or `name: \
                        batch(...)` for many states as well";
        let (name, list) = pair(value, expected)?;
        let (items, batch) = match &list.kind {
            ValueKind::List(items) => (items, false),
            ValueKind::Call(word, items) if word == "batch" => (items, true),
            _ => return Err(OptionError::form(list.at, expected)),
        };
        let member = |item: &Value| {
            let (name, link) = match &item.kind {
                ValueKind::Word(name) => (name, None),
                ValueKind::Call(name, arguments) => match arguments.as_slice() {
                    [link] => (name, Some(String::read(link)?)),
                    _ => {
                        return Err(OptionError::form(
                            item.at,
                            format!("expected one link: `{name}(\"link\")`"),
                        ));
                    }
                },
                _ => {
                    return Err(OptionError::form(
                        item.at,
                        "expected a function, or `function(\"link\")`",
                    ));
                }
            };
            let function = Function::from_name(name)
                .ok_or_else(|| OptionError::new(item.at, unknown(name)))?;
            Ok(Member::Table(function, link))
        };
        let members = items.iter().map(member).collect::<Result<Vec<_>, OptionError>>()?;
        let fused = Self { name, members, batch };
        match fused.defects().into_iter().next() {
            None => Ok(fused),
            Some(Defect { member, message, help }) => {
                let at = member.map_or(value.at, |i| items[i].at);
                Err(OptionError::new(
                    at,
                    format!("fused function `{}`: {message}; {help}", fused.name),
                ))
            }
        }
    }

    fn rust(&self) -> String {
        let mut text = format!("FusedFunction::new({:?})", self.name);
        for member in &self.members {
            text += &match member {
                Member::Table(function, None) => format!(".function(Function::{function:?})"),
                Member::Table(function, Some(link)) => {
                    format!(".of_link(Function::{function:?}, {link:?})")
                }
                Member::User(name) => format!(".own_function({name:?})"),
            };
        }
        if self.batch { text + ".batch()" } else { text }
    }
}

/// Returns the error, and its remedy, of two functions with different arguments of one name.
fn conflict(members: &[plan::Member], sizes: &Sizes) -> Option<(String, String)> {
    members.iter().enumerate().find_map(|(i, member)| {
        members[..i].iter().find_map(|other| {
            let [arguments, others] = [member, other].map(|member| member.function.arguments());
            let differs = |a: &&Argument| {
                others.iter().any(|b| a.name == b.name && a.shape(sizes) != b.shape(sizes))
            };
            let name = arguments.iter().find(differs)?.name;
            let message =
                format!("{} and {} have different arguments `{name}`", other.docs, member.docs);
            Some((message, "put them in two fused functions".into()))
        })
    })
}

/// Returns the message that no function of a fused function has this name.
fn unknown(name: &str) -> String {
    let known: Vec<&str> = (Function::ALL.iter())
        .filter(|function| function.batched().is_none() && !function.is_of_random_numbers())
        .map(|function| function.name())
        .collect();
    match suggest(name, known.iter().copied()) {
        Some(meant) => format!("there is no function `{name}`; did you mean `{meant}`?"),
        None => format!(
            "there is no function `{name}`; a fused function can have: {}",
            known.join(", ")
        ),
    }
}
