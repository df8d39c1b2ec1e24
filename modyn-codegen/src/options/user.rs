//! Checks of users' functions: those that need no robot, and the words for errors of tracing.

use super::own_names::{OwnNames, name_defect};
use crate::names::{self, CPP_WORDS};
use crate::plan::{
    ARGUMENTS, Argument, ArgumentKind, MAX_USER_OPERATIONS, NamedFunction, UserForm, UserPlanError,
};
use crate::trace::UserTraceError;
use modyn_read::diagnostics::{Code, Diagnostic};
use modyn_runtime::{UserArgument, UserArgumentKind};

/// Names that arguments cannot have beside [`CPP_WORDS`]: local names of generated code, and types
/// and functions of C and CUDA.
const RESERVED: &[&str] = &[
    "bodies",
    "body",
    "common",
    "cos",
    "fabs",
    "fabsf",
    "fma",
    "fmaf",
    "i",
    "inputs",
    "j",
    "k",
    "kernel",
    "link",
    "memcpy",
    "n",
    "null",
    "of",
    "out",
    "outputs",
    "own",
    "params",
    "placement",
    "result",
    "sin",
    "sqrt",
    "sqrtf",
    "state",
    "states",
    "table",
    "uniform",
    "x",
];

/// Returns the names of a function.
pub(crate) fn names_of(function: &NamedFunction) -> OwnNames {
    OwnNames { owner: owner(function), names: function.names().collect() }
}

fn owner(function: &NamedFunction) -> String {
    format!("function `{}`", function.name)
}

fn error(function: &NamedFunction, code: Code, message: &str, help: String) -> Diagnostic {
    Diagnostic::error(code, format!("{}: {message}", owner(function))).with_help(help)
}

/// Returns the errors of a function that no robot is needed to find.
pub(crate) fn errors(function: &NamedFunction) -> Vec<Diagnostic> {
    let mut defects: Vec<(String, String)> =
        name_defect(&function.name, "function").into_iter().collect();
    if function.arguments.is_empty() {
        let help = "give it some, such as `UserArgument::Q`".into();
        defects.push(("it has no arguments".into(), help));
    }
    defects.extend(
        function.arguments.iter().filter_map(|argument| argument_defect(argument, function)),
    );
    let names = function.argument_names();
    for (i, name) in names.iter().enumerate() {
        if names[..i].contains(name) {
            let count = function.arguments.len();
            let message = match i < count {
                true => format!("two arguments have the name `{name}`"),
                false => format!("functions of its derivatives have another argument `{name}`"),
            };
            defects.push((message, "rename the argument".into()));
        }
    }
    let blocks = function.block_names();
    let twice = blocks.iter().enumerate().find(|(i, name)| blocks[..*i].contains(name));
    if let Some((_, name)) = twice {
        let message = format!("two blocks of its Hessian have the name `{name}`");
        defects.push((message, "rename an argument".into()));
    }
    let error = |(message, help): (String, String)| error(function, Code::Option, &message, help);
    defects.into_iter().map(error).collect()
}

/// Returns the error of an argument and its remedy.
fn argument_defect(argument: &UserArgument, function: &NamedFunction) -> Option<(String, String)> {
    let name = argument.name();
    let defect = |message: String, help: &str| Some((message, help.to_string()));
    let letters = |c: char| c.is_ascii_lowercase() || c == '_';
    if !name.chars().all(letters) || names::snake(name) != name {
        let message = format!("the argument {name:?} has no name of lower-case words");
        return defect(
            message,
            "use letters and single underscores between them, such as `end_force`",
        );
    }
    if [RESERVED, CPP_WORDS].iter().any(|words| words.contains(&name))
        || function.names().any(|other| other == name)
    {
        return defect(format!("generated code has another `{name}`"), "rename the argument");
    }
    if argument.kind() == UserArgumentKind::Numbers(0) {
        return defect(format!("the argument `{name}` has no numbers"), "remove it");
    }
    let known: Option<&Argument> = ARGUMENTS.iter().find(|known| known.name == name);
    let same = |known: &Argument| {
        matches!(
            (known.kind, argument.kind()),
            (ArgumentKind::Coordinates, UserArgumentKind::Coordinates)
                | (ArgumentKind::Velocities, UserArgumentKind::Velocities)
                | (ArgumentKind::Time, UserArgumentKind::Number)
        )
    };
    if known.is_some_and(|known| !same(known)) {
        let message = format!("the argument `{name}` has another meaning in other functions");
        return defect(
            message,
            "rename it, or declare it as they do, such as by `UserArgument::Q`",
        );
    }
    None
}

/// Returns the diagnostic of a function that cannot be planned.
pub(crate) fn plan_error(function: &NamedFunction, reason: &UserPlanError) -> Diagnostic {
    match reason {
        UserPlanError::Trace(UserTraceError::Own(inner)) => {
            let help = "the error is that of the function itself".into();
            error(function, Code::Option, &inner.to_string(), help)
        }
        UserPlanError::Trace(UserTraceError::Foreign(_)) => {
            let message = "it used an expression of another trace";
            let help =
                "compute with the arguments of this call alone, and store no numbers between calls";
            error(function, Code::Option, message, help.into())
        }
        UserPlanError::NoResults => {
            let help = "return one number or several".into();
            error(function, Code::Option, "it has no results", help)
        }
        UserPlanError::NotFinite => {
            let message = "it has a constant that is not a finite number";
            let help =
                "look for a division by zero, or the root of a negative number, of constants";
            error(function, Code::Option, message, help.into())
        }
        UserPlanError::TooLong(form) => {
            let message = format!(
                "`{}{}` takes more than {MAX_USER_OPERATIONS} operations",
                function.name,
                form.suffix()
            );
            let help = match form {
                UserForm::Hessian => {
                    "leave out second derivatives by `UserFunction::derivatives`, or make fewer arguments variable"
                }
                UserForm::Value => "compute it by several functions",
                _ => "leave out derivatives by `UserFunction::derivatives`",
            };
            error(function, Code::TooLarge, &message, help.into())
        }
    }
}
