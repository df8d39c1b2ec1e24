//! Checks of the options, by themselves and with the robot.

use std::collections::BTreeMap;

use modyn_read::diagnostics::{Code, Diagnostic, Diagnostics, Severity, Subject, listed, suggest};
use modyn_read::{Base, Mimic, gravity_error};
use modyn_runtime::model::{Model, ModuleError, ModuleTree};

use super::Builder;
use super::source::Source;
use super::syntax::{is_c_prefix, is_path, is_visibility};
use crate::emit::Target;
use crate::names;
use crate::options::{FusedFunction, ModuleChoice, shared_names, user};
use crate::plan::{Choices, Function, MAX_LINKS, MAX_OPERATIONS, Plan, TooLong};
use crate::program::Execution;

impl Builder {
    /// Returns the errors of options that are copied into the text.
    pub(super) fn option_errors(&self) -> Vec<Diagnostic> {
        let mut errors = Vec::new();
        let mut error = |code, message: String, help: String| {
            errors.push(Diagnostic::error(code, message).with_help(help));
        };
        if let Some(name) =
            self.options.code.type_name.as_ref().filter(|&name| names::type_name(name) != *name)
        {
            error(
                Code::TypeName,
                format!("{name:?} is not a type name in upper camel case"),
                format!("`{}` is one", names::type_name(name)),
            );
        }
        if let Some(visibility) =
            self.options.code.visibility.as_ref().filter(|text| !is_visibility(text))
        {
            error(
                Code::Option,
                format!("{visibility:?} is not a visibility"),
                "`pub`, `pub(crate)`, `pub(super)`, `pub(in path)`, or nothing for private".into(),
            );
        }
        if let Some(path) = self.options.code.crate_path.as_ref().filter(|text| !is_path(text)) {
            error(
                Code::Option,
                format!("{path:?} is not the path of a crate or module"),
                "give the path of `modyn`, such as `::modyn` or `crate::robots::modyn`".into(),
            );
        }
        if let Some(prefix) =
            self.options.code.c_functions.as_ref().filter(|name| !is_c_prefix(name))
        {
            error(
                Code::Option,
                format!("{prefix:?} is not a prefix of C functions"),
                "use a letter, then letters, digits and underscores".into(),
            );
        }
        if self.options.code.self_contained && self.options.code.crate_path.is_some() {
            error(
                Code::Option,
                "a self-contained file does not use the crate `modyn`, so `crate` has no effect"
                    .into(),
                "remove `crate` or `self_contained`".into(),
            );
        }
        if self.options.code.self_contained && self.options.code.embed_model {
            error(
                Code::Option,
                "a self-contained file has no description, which needs the crate `modyn`".into(),
                "remove `embed_model` or `self_contained`".into(),
            );
        }
        if matches!(self.source, Source::Model(_)) && !self.options.read.loops.is_empty() {
            error(
                Code::Option,
                "a `Model` has its own loop constraints".into(),
                "set them with `Model::with_loop_constraints`".into(),
            );
        }
        if matches!(self.source, Source::Model(_)) && !self.options.read.contacts.is_empty() {
            error(
                Code::Option,
                "a model that is given as one has its own contacts".into(),
                "set them with `Model::with_contacts`".into(),
            );
        }
        if matches!(self.source, Source::Model(_)) && self.options.read.ground.is_some() {
            error(
                Code::Option,
                "a model that is given as one has its own ground".into(),
                "set it with `Model::with_soft_constraints`".into(),
            );
        }
        if matches!(self.source, Source::Model(_)) && !self.options.read.actuators.is_empty() {
            error(
                Code::Option,
                "a model that is given as one has its own actuators".into(),
                "set them with `Model::with_actuation`".into(),
            );
        }
        let read = &self.options.read;
        let of_reading = [
            ("base", read.base != Base::default()),
            ("mimic", read.mimic != Mimic::default()),
            ("armature", !read.armature.is_empty()),
            ("rotors", !read.rotors.is_empty()),
            ("joint_friction", read.joint_friction.is_some()),
        ];
        let given = of_reading.iter().filter(|(_, given)| *given);
        for (option, _) in given.filter(|_| matches!(self.source, Source::Model(_))) {
            error(
                Code::Option,
                format!("`{option}` is an option for descriptions, but the robot is a `Model`"),
                "set it in the model: joints have their type and armature, \
                 `Model::with_joint_friction` sets the friction"
                    .into(),
            );
        }
        errors.extend(read.gravity.and_then(gravity_error));
        let fused = &self.options.code.fused;
        let functions = &self.options.user_functions;
        errors.extend(fused.iter().flat_map(FusedFunction::errors));
        errors.extend(functions.iter().flat_map(user::errors));
        let names =
            fused.iter().map(FusedFunction::names).chain(functions.iter().map(user::names_of));
        errors.extend(shared_names(&names.collect::<Vec<_>>()));
        errors
    }

    /// Returns a warning for a type `Robot`, which would collide with the trait that users import.
    pub(super) fn name_conflict(
        &self,
        model: &Model,
        warnings: &[Diagnostic],
    ) -> Option<Diagnostic> {
        let name = names::type_name(model.name());
        // A robot without a name already has a warning.
        let said = warnings.iter().any(|w| w.code == Code::MissingAttribute && w.subject.is_none());
        (self.options.code.type_name.is_none() && name == "Robot" && !said).then(|| {
            let message = "the type `Robot` will collide with `use modyn::Robot`";
            let help = "name it: `modyn!(pub MyArm = \"...\")`, or `Builder::type_name`";
            let subject = Subject::Robot(model.name().into());
            let warning = Diagnostic::new(Severity::Warning, Code::TypeName, message);
            warning.with_subject(subject).with_help(help)
        })
    }

    /// Returns the modules that the option `modules` selects.
    pub(super) fn module_tree(&self, model: &Model) -> Result<ModuleTree, Diagnostics> {
        match &self.options.code.modules {
            ModuleChoice::Chains => Ok(ModuleTree::chains(model)),
            ModuleChoice::Links => Ok(ModuleTree::links(model)),
            ModuleChoice::List(list) => ModuleTree::from_names(model, list).map_err(|errors| {
                let names = || model.moving_links().iter().map(|link| link.name.as_str());
                let diagnostic = |error: &ModuleError| {
                    let diagnostic = Diagnostic::error(Code::Modules, error.to_string());
                    let meant = match error {
                        ModuleError::UnknownLink { name, .. } => suggest(name, names()),
                        _ => None,
                    };
                    match meant {
                        Some(meant) => diagnostic.with_help(format!("did you mean `{meant}`?")),
                        None => diagnostic,
                    }
                };
                Diagnostics::new(errors.iter().map(diagnostic).collect())
            }),
        }
    }
}

/// Returns a warning for each replacement of selected functions that a language does not have.
pub(super) fn left_out(target: Target, selected: &[Function]) -> Vec<Diagnostic> {
    // `default` and `all` are requests for the functions that there are.
    let is_of_a_group = |function: &Function| {
        selected.len() == Function::ALL.len() || Function::DEFAULT.contains(function)
    };
    let mut missing: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for function in selected.iter().filter(|function| !is_of_a_group(function)) {
        if let Some(help) = target.backend().lacks(*function) {
            missing.entry(help).or_default().push(format!("`{}`", function.name()));
        }
    }
    let warning = |(help, names): (&str, Vec<String>)| {
        let verbs = if names.len() == 1 { ["has", "is"] } else { ["have", "are"] };
        let message = format!(
            "{} {} no form for {}, and {} left out",
            names.join(", "),
            verbs[0],
            target.title(),
            verbs[1]
        );
        Diagnostic::new(Severity::Warning, Code::Option, message).with_help(help)
    };
    missing.into_iter().map(warning).collect()
}

/// Returns the selected functions that a robot has whose joints `singular` move no inertia, and an
/// error if a function that needs inertia was selected by its name or is in a fused function.
pub(super) fn without_inertia(
    model: &Model,
    singular: &[usize],
    selected: &[Function],
    fused: &[Function],
) -> (Vec<Function>, Option<Diagnostic>) {
    let needs = |function: &&Function| function.row().needs_inertia;
    // `default` and `all` are requests for the functions that there are.
    let has = |group: &[Function]| group.iter().all(|function| selected.contains(function));
    let has_all = has(Function::ALL);
    let has_default = has(Function::DEFAULT);
    let is_of_a_group =
        |function: &&Function| has_all || has_default && Function::DEFAULT.contains(function);
    let by_name = selected.iter().filter(|function| !is_of_a_group(function)).chain(fused);
    let named: Vec<&str> = by_name.filter(needs).map(|function| function.name()).collect();
    let error = named.first().map(|_| {
        let verb = if named.len() == 1 { "needs" } else { "need" };
        needs_inertia(model, singular, &listed("function", named.iter().copied()), verb)
    });
    (selected.iter().copied().filter(|function| !function.row().needs_inertia).collect(), error)
}

/// Returns the error of functions that need inertia, of a robot whose joints `singular` move none.
pub(super) fn needs_inertia(
    model: &Model,
    singular: &[usize],
    functions: &str,
    verb: &str,
) -> Diagnostic {
    let joints = singular.iter().map(|&i| model.moving_links()[i].joint.name.as_str());
    let message = format!(
        "{functions} {verb} inertia, and {} {} none",
        listed("joint", joints),
        if singular.len() == 1 { "moves" } else { "move" },
    );
    let help = "select kinematic functions, such as `link_pose` and `jacobian`; or write the \
                `<inertial>` of the links, or \
                give each joint an armature by the option `armature`";
    Diagnostic::error(Code::KinematicsOnly, message).with_help(help)
}

/// Returns a warning for each function whose packed program is invalid.
pub fn invalid_programs(plan: &Plan) -> impl Iterator<Item = Diagnostic> {
    plan.faults().map(|(name, fault)| {
        let message =
            format!("`{name}` is computed on scalars: its packed program is invalid ({})", fault.rule);
        let help = "its results are right, but take longer; please report this fault of modyn, with the description";
        Diagnostic::new(Severity::Warning, Code::InvalidProgram, message).with_help(help)
    })
}

/// Returns a warning for functions whose second derivatives were left out.
pub(super) fn without_hessian(functions: &[String], prefix: &str) -> Option<Diagnostic> {
    (!functions.is_empty()).then(|| {
        let prefixed: Vec<String> =
            functions.iter().map(|name| format!("{prefix}_{name}")).collect();
        let names = prefixed.join("`, `");
        let message = format!("`{names}` has no second derivatives: their code would be too long");
        let help = "use a Hessian approximation (IPOPT: `hessian_approximation`)";
        Diagnostic::new(Severity::Warning, Code::Option, message).with_help(help)
    })
}

/// Returns the links of this `option`, as indices into the model's links.
pub(super) fn links_that_move(
    model: &Model,
    option: &str,
    code: Code,
    names: &[String],
) -> Result<Vec<usize>, Diagnostics> {
    let mut errors = Vec::new();
    let mut links = Vec::new();
    let described = || model.links().iter().map(|link| link.name.as_str());
    for name in names {
        let mut error = |message: String, help: String| {
            errors.push(Diagnostic::error(code, message).with_help(help));
        };
        match described().position(|other| other == name) {
            None => {
                let help = match suggest(name, described()) {
                    Some(meant) => format!("did you mean `{meant}`?"),
                    None => "name a link of the description".into(),
                };
                error(format!("`{name}` in `{option}` is not a link"), help);
            }
            Some(link) if model.links()[link].moving_link.is_none() => error(
                format!("link `{name}` in `{option}` does not move"),
                "remove it: a link that is fixed to the world has no effect on the dynamics".into(),
            ),
            Some(link) if links.contains(&link) => {
                error(
                    format!("link `{name}` is listed in `{option}` twice"),
                    "name it once".into(),
                );
            }
            Some(link) => links.push(link),
        }
    }
    if errors.is_empty() { Ok(links) } else { Err(Diagnostics::new(errors)) }
}

/// Returns the error that a function of arrays, which is differentiated this many times, takes too
/// many operations.
pub fn too_long_entries(
    model: &Model,
    modules: &ModuleTree,
    reason: &TooLong,
    derivatives: usize,
) -> Diagnostic {
    let TooLong::Function { name, .. } = reason else { return too_long(model, modules, reason) };
    let (what, help) = match derivatives {
        0 => (format!("`{name}`"), "leave links out that do not matter, or make joints `fixed`"),
        _ => (
            format!("a derivative of order {derivatives} of `{name}`"),
            "differentiate by fewer arguments, or by products with vectors in place of matrices",
        ),
    };
    let joints = model.moving_links().len();
    let message =
        format!("{what} of {joints} moving joints takes more than {MAX_OPERATIONS} operations");
    Diagnostic::error(Code::TooLarge, message).with_help(help)
}

/// Returns the error that none of the fused functions with these names has this one.
pub fn no_fused_function<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Diagnostic {
    let help = match suggest(name, names) {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => "add it to the option `fused`".into(),
    };
    Diagnostic::error(Code::Option, format!("there is no fused function `{name}`")).with_help(help)
}

/// Returns whether these functions are short enough with modules of one link, whose factors have no
/// dense pivots.
fn helps_by_links(model: &Model, modules: &ModuleTree, names: &[&str]) -> bool {
    let links = ModuleTree::links(model);
    let all = Function::ALL.iter().copied();
    let functions = all.filter(|function| names.contains(&function.name())).collect();
    let choices = Choices { functions, ..Choices::default() };
    *modules != links && Plan::new(model, &links, &choices, Execution::Scalar).is_ok()
}

/// Returns the error that the functions of a robot take too many operations.
pub fn too_long(model: &Model, modules: &ModuleTree, reason: &TooLong) -> Diagnostic {
    let joints = model.moving_links().len();
    let other = "use `modyn::Interpreter`, which has no such limit";
    let TooLong::Function { name, before } = reason else {
        let message = format!(
            "code is made for at most {MAX_LINKS} moving joints, and the robot has {joints}"
        );
        let help = format!("make unimportant joints `fixed`; or {other}");
        return Diagnostic::error(Code::TooLarge, message).with_help(help);
    };
    let listed = |(name, operations): &(&str, usize)| format!("`{name}` {operations}");
    let reached: Vec<&str> = before.iter().map(|(name, _)| *name).chain([*name]).collect();
    let mut before = before.clone();
    before.sort_by_key(|(_, operations)| std::cmp::Reverse(*operations));
    before.retain(|(_, operations)| *operations > MAX_OPERATIONS / 10);
    let others = match before.is_empty() {
        true => String::new(),
        false => {
            let longest: Vec<String> = before.iter().take(3).map(listed).collect();
            format!(", with the functions before it ({})", longest.join(", "))
        }
    };
    let longest_module =
        modules.modules().iter().map(|module| &module.links).max_by_key(|l| l.len());
    let longest = longest_module.map(|links| {
        let [first, last] =
            [links.start, links.end - 1].map(|link| &model.moving_links()[link].name);
        format!("; the longest module has {} links, from `{first}` to `{last}`", links.len())
    });
    let message = format!(
        "`{name}` of {joints} moving joints and {} links takes more than {MAX_OPERATIONS} operations{others}{}",
        model.links().len(),
        longest.unwrap_or_default(),
    );
    let help = if *name == Function::Brge.name() && helps_by_links(model, modules, &reached) {
        format!(
            "try `modules = links`, or leave `{name}` out of the option `functions`; or {other}"
        )
    } else {
        let long = before.iter().map(|(name, _)| *name).chain([*name]);
        let quoted: Vec<String> = long.map(|name| format!("`{name}`")).collect();
        let long = quoted.join(" or ");
        let instead = match *name == Function::Brge.name() {
            true => " (`forward_dynamics` solves for accelerations without the factors)",
            false => "",
        };
        format!(
            "leave {long} out of the option `functions`{instead}, or remove links that nothing needs; or {other}"
        )
    };
    Diagnostic::error(Code::TooLarge, message).with_help(help)
}
