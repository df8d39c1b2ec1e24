//! The documentation of a generated type: a usage example, the options, and tables of joints,
//! loops, modules and operations.

use std::fmt::Write as _;
use std::ops::Range;

use modyn_read::diagnostics::{Diagnostic, Diagnostics, sanitize_for_display};
use modyn_runtime::OperationCount;
use modyn_runtime::model::Model;

use super::{MachineCode, Robot};
use crate::names;
use crate::plan::{ARGUMENTS, Argument, ArgumentKind, CodeForm, Function};

/// Returns `name`, with any characters, as code in a doc comment.
pub(super) fn code(name: &str) -> String {
    // A backtick would end the code, a bar a table's cell.
    format!("`{}`", sanitize_for_display(name).replace(['`', '|'], "\u{fffd}"))
}

/// Prints the doc comment of the robot's type.
pub(super) fn robot(text: &mut String, robot: &Robot<'_>, operations: &[(&str, OperationCount)]) {
    let model = robot.model;
    let mut lines = format!(
        "Dynamics of the robot {}, compiled by modyn: {} moving joints, {} degrees of freedom.\n\n",
        code(model.name()),
        model.moving_links().len(),
        model.nv(),
    );
    example(&mut lines, robot);
    lines.push_str(
        "Joint vectors have the order of the joints below; mimic joints have no entries of their own. Matrices are\n\
         arrays of columns. Units are SI units and radians.\n",
    );
    if model.quaternions().next().is_some() {
        lines.push_str(
            "Quaternions in `q` must have length 1: `check_configuration` checks them, and \
             `normalize_configuration` scales them.\n",
        );
    }
    if let Some(code) = robot.code {
        machine_code(&mut lines, code);
    }
    joints(&mut lines, model);
    loops(&mut lines, model);
    contacts(&mut lines, model);
    options(&mut lines, robot);
    lines.push_str("\n# Kinematic modules\n\n");
    for (m, module) in robot.modules.modules().iter().enumerate() {
        let links: Vec<String> = model.moving_links()[module.links.clone()]
            .iter()
            .map(|link| code(&link.name))
            .collect();
        let parent = module.parent.map_or_else(|| "the base".into(), |p| format!("module {p}"));
        let _ = writeln!(lines, "- module {m} on {parent}: {}", links.join(", "));
    }
    lines.push_str("\n# Operations of one call\n\n");
    for (name, count) in operations {
        let _ = writeln!(lines, "- `{name}`: {count}");
    }
    let costs: Vec<String> =
        robot.plan.candidates.iter().map(|(name, total)| format!("{name}: {total}")).collect();
    let _ = writeln!(
        lines,
        "\nForward dynamics is computed with {} modules. Operations of the partitions that were considered, before \
         optimisation: {}.",
        robot.plan.elimination_modules.modules().len(),
        costs.join("; ")
    );
    warnings(&mut lines, &robot.options.warnings);
    for line in lines.lines() {
        let _ = writeln!(text, "{}", format!("/// {line}").trim_end());
    }
}

/// Prints the section about machine code in an object file.
fn machine_code(lines: &mut String, code: &MachineCode) {
    let words = code.target.words;
    let _ = writeln!(lines, "\n# Machine code\n\nThe functions are machine code for {words}.");
    if !code.needs.is_empty() {
        let _ = writeln!(
            lines,
            "They panic on processors without {}; `is_supported` asks the processor.",
            code.needs
        );
    }
}

/// The functions of the usage example. The first of each group that the robot has is shown.
const EXAMPLES: [&[Function]; 2] = [
    &[
        Function::ForwardDynamics,
        Function::InverseDynamics,
        Function::BiasForces,
        Function::GravityTorques,
        Function::MassMatrix,
    ],
    &[Function::LinkPose, Function::Jacobian, Function::LinkVelocity],
];

/// Prints a usage example, if the robot has one of the functions of [`EXAMPLES`].
fn example(lines: &mut String, robot: &Robot<'_>) {
    let has =
        |function: Function| robot.plan.functions.iter().any(|p| p.function == Some(function));
    let shown: Vec<Function> = EXAMPLES
        .iter()
        .filter_map(|group| group.iter().copied().find(|function| has(*function)))
        .collect();
    if shown.is_empty() {
        return;
    }
    let name = robot.name;
    let used = |argument: &&Argument| shown.iter().any(|f| f.row().arguments.contains(argument));
    // The robot's crate knows no path to this type, so the example is not run.
    lines.push_str("```ignore\n");
    for argument in ARGUMENTS.iter().filter(used) {
        let value = match argument.kind {
            ArgumentKind::Coordinates => format!("{name}::NEUTRAL"),
            _ => format!("[0.0; {name}::NV]"),
        };
        let _ = writeln!(lines, "let {} = {value};", argument.name);
    }
    for function in shown {
        let mut arguments: Vec<String> =
            function.row().arguments.iter().map(|argument| format!("&{}", argument.name)).collect();
        if function.row().by_link {
            let variants = names::variants(&robot.link_names());
            let tip =
                robot.model.moving_links().last().and_then(|l| robot.model.link_index(&l.name));
            let link = tip.map_or("", |tip| variants[tip].as_str());
            arguments.push(format!("{name}Link::{link}"));
        }
        let _ = writeln!(
            lines,
            "let {} = {name}::{}({});",
            function.result_name(),
            function.name(),
            arguments.join(", ")
        );
    }
    lines.push_str("```\n\n");
}

/// Prints the table of joints.
fn joints(lines: &mut String, model: &Model) {
    lines.push_str(
        "\n# Joints\n\n\
         | | joint | type | `q` | `qd` | link | parent link |\n|---|---|---|---|---|---|---|\n",
    );
    for (i, link) in model.moving_links().iter().enumerate() {
        let parent =
            link.parent.map_or_else(|| "the base".into(), |p| code(&model.moving_links()[p].name));
        let type_name = link.joint.joint_type.name();
        let kind = match &link.joint.mimic {
            None => type_name.to_string(),
            Some(mimic) => {
                let leader = code(&model.moving_links()[mimic.leader].joint.name);
                format!(
                    "{type_name}, mimics {leader}: {:?} q + {:?}",
                    mimic.multiplier, mimic.offset
                )
            }
        };
        let _ = writeln!(
            lines,
            "| {i} | {} | {kind} | {} | {} | {} | {parent} |",
            code(&link.joint.name),
            entries(&model.q_range(i)),
            entries(&model.v_range(i)),
            code(&link.name)
        );
    }
}

/// Returns a range of entries as text: `3`, or `3..7`.
fn entries(range: &Range<usize>) -> String {
    match range.len() {
        1 => range.start.to_string(),
        _ => format!("{range:?}"),
    }
}

/// Prints the table of loop constraints, if there are any.
fn loops(lines: &mut String, model: &Model) {
    if model.loop_constraints().is_empty() {
        return;
    }
    lines.push_str(
        "\n# Closed loops\n\n\
         `constrained_forward_dynamics`, `project_constraints` and `constraint_residual` use these loop joints. All\n\
         other functions ignore them.\n\n\
         | | loop joint | type | first link | second link |\n|---|---|---|---|---|\n",
    );
    for (i, constraint) in model.loop_constraints().iter().enumerate() {
        let [first, second] =
            constraint.ends.each_ref().map(|end| code(&model.links()[end.link].name));
        let name = code(&constraint.name);
        let kind = constraint.kind.name();
        let _ = writeln!(lines, "| {i} | {name} | {kind} | {first} | {second} |");
    }
}

/// Prints the table of contacts.
fn contacts(lines: &mut String, model: &Model) {
    if model.contacts().is_empty() {
        return;
    }
    lines.push_str(
        "\n# Contacts\n\n`constrained_forward_dynamics` holds the active contacts.\n\n\
         | | contact | type | link |\n|---|---|---|---|\n",
    );
    for (i, contact) in model.contacts().iter().enumerate() {
        let link = code(&model.links()[contact.end.link].name);
        let name = code(&contact.name);
        let kind = contact.kind.name();
        let _ = writeln!(lines, "| {i} | {name} | {kind} | {link} |");
    }
}

/// Prints the options that the type was compiled with.
fn options(lines: &mut String, robot: &Robot<'_>) {
    let model = robot.model;
    let options = robot.options;
    let choices = &robot.plan.choices;
    let is = |functions: &[Function]| {
        functions.len() == choices.functions.len()
            && functions.iter().all(|function| choices.functions.contains(function))
    };
    let functions = if is(Function::DEFAULT) {
        "default".into()
    } else if is(Function::ALL) {
        "all".into()
    } else {
        let names: Vec<&str> = choices.functions.iter().map(|function| function.name()).collect();
        format!("[{}]", names.join(", "))
    };
    let friction = format!("{:?}", model.joint_friction()).to_lowercase();
    let gravity = model.gravity();
    let _ = writeln!(
        lines,
        "\n# Options\n\n- `scalar = {}`\n- `functions = {functions}`\n- `gravity = {gravity:?}` (m/s^2, world axes)\n\
         - `joint_friction = {friction}`",
        options.scalar.name()
    );
    for fused in &choices.fused {
        let members: Vec<&str> = fused.members.iter().map(|member| member.docs).collect();
        let batch = if fused.batch { ", also for many states" } else { "" };
        let _ = writeln!(lines, "- fused function `{}`{batch}: {}", fused.name, members.join(", "));
    }
    for function in &choices.user_functions {
        let batch = if function.batch { ", also for many states" } else { "" };
        let arguments = function.arguments.join(", ");
        let _ = writeln!(lines, "- function `{}({arguments})` of the user{batch}", function.name);
    }
    for (option, links) in
        [("runtime_inertia", &choices.runtime_inertia), ("payload", &choices.payload)]
    {
        let names: Vec<String> = links.iter().map(|&i| code(&model.links()[i].name)).collect();
        if !names.is_empty() {
            let _ = writeln!(lines, "- `{option}`: {}", names.join(", "));
        }
    }
    if choices.runtime_gravity {
        lines.push_str("- `runtime_gravity = true`\n");
    }
    if choices.share_limbs {
        lines.push_str("- `share_limbs = true`\n");
    }
    if choices.code != CodeForm::default() {
        let _ = writeln!(lines, "- `code = {}`", format!("{:?}", choices.code).to_lowercase());
    }
    if options.self_contained {
        lines.push_str("- `self_contained = true`\n");
    }
    if options.embed_model {
        lines.push_str("- `embed_model = true`\n");
    }
    if let Some(prefix) = &options.c_prefix {
        let _ = writeln!(lines, "- `c_functions = {prefix}`");
    }
}

/// Prints the warnings about the description, if there are any.
fn warnings(lines: &mut String, warnings: &[Diagnostic]) {
    if warnings.is_empty() {
        return;
    }
    lines.push_str("\n# Warnings about the description\n\n```text\n");
    for warning in warnings.iter().take(Diagnostics::SHOWN) {
        // The text must not depend on the folder of the file.
        let mut warning = warning.clone();
        warning.file = None;
        let _ = writeln!(lines, "{warning}");
    }
    if let Some(more) = Diagnostics::count_hidden(warnings.len()) {
        let _ = writeln!(lines, "{more}");
    }
    lines.push_str("```\n");
}
