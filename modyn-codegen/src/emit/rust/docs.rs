//! The documentation of a generated type.

use std::fmt::Write as _;

use modyn_runtime::OperationCount;

use super::Robot;
use crate::diagnostics::sanitize_for_display;
use crate::diagnostics::{Diagnostic, Diagnostics};

/// `name` as code in a doc comment, whatever stands in it.
pub(super) fn code(name: &str) -> String {
    // A backtick would end the code, a bar a table's cell.
    format!("`{}`", sanitize_for_display(name).replace(['`', '|'], "\u{fffd}"))
}

/// The doc comment of the robot's type.
pub(super) fn robot(text: &mut String, robot: &Robot<'_>, operations: &[(&str, OperationCount)]) {
    let model = robot.model;
    let mut lines = format!(
        "Dynamics of the robot {}: {} joints that move, {} degrees of freedom, compiled by modyn.\n\n\
         Vectors stand in the order of the joints below, without those that mimic another; matrices are\n\
         arrays of columns. SI units, radians; gravity {:?} m/s^2 in world axes.{}\n\n\
         | | joint | type | link | parent link |\n|---|---|---|---|---|\n",
        code(model.name()),
        model.links().len(),
        model.nv(),
        model.gravity(),
        match model.quaternions().next() {
            None => "",
            Some(_) =>
                " Quaternions in `q` must have length 1:\n\
                 with other lengths results are wrong; `check_configuration` tells, `normalize` repairs it.",
        },
    );
    for (i, link) in model.links().iter().enumerate() {
        let parent =
            link.parent.map_or_else(|| "the base".into(), |p| code(&model.links()[p].name));
        let (joint, kind) = (code(&link.joint.name), link.joint.joint_type.name());
        let _ = writeln!(lines, "| {i} | {joint} | {kind} | {} | {parent} |", code(&link.name));
    }
    if !model.loop_constraints().is_empty() {
        lines.push_str(
            "\nLoops, which `constrained_forward_dynamics` closes; all other functions are of the tree:\n\n\
             | | loop joint | type | first link | second link |\n|---|---|---|---|---|\n",
        );
        for (i, constraint) in model.loop_constraints().iter().enumerate() {
            let [first, second] =
                constraint.ends.each_ref().map(|end| code(&model.frames()[end.frame].name));
            let (name, kind) = (code(&constraint.name), constraint.kind.name());
            let _ = writeln!(lines, "| {i} | {name} | {kind} | {first} | {second} |");
        }
    }
    if !model.contacts().is_empty() {
        lines.push_str(
            "\nContacts, which `constrained_forward_dynamics` holds where they are active:\n\n\
             | | contact | type | link |\n|---|---|---|---|\n",
        );
        for (i, contact) in model.contacts().iter().enumerate() {
            let link = code(&model.frames()[contact.end.frame].name);
            let (name, kind) = (code(&contact.name), contact.kind.name());
            let _ = writeln!(lines, "| {i} | {name} | {kind} | {link} |");
        }
    }
    lines.push_str("\nKinematic modules:\n\n");
    for (m, module) in robot.modules.modules().iter().enumerate() {
        let links: Vec<String> =
            model.links()[module.links.clone()].iter().map(|link| code(&link.name)).collect();
        let parent = module.parent.map_or_else(|| "the base".into(), |p| format!("module {p}"));
        let _ = writeln!(lines, "- module {m} on {parent}: {}", links.join(", "));
    }
    lines.push_str("\nOperations:\n\n");
    for (name, count) in operations {
        let _ = writeln!(lines, "- `{name}`: {count}");
    }
    let costs: Vec<String> = robot
        .plan
        .candidates
        .iter()
        .map(|(name, total)| format!("{name} it takes {total}"))
        .collect();
    let _ = writeln!(
        lines,
        "\nForward dynamics is eliminated by {} modules; with {} operations.",
        robot.plan.eliminated.modules().len(),
        costs.join(", with ")
    );
    if !robot.options.warnings.is_empty() {
        lines.push_str("\nWarnings about the description:\n\n```text\n");
        let warnings = &robot.options.warnings;
        for warning in warnings.iter().take(Diagnostics::SHOWN) {
            // Where the file stands is no matter of the text, which is the same on every host.
            let warning = Diagnostic { file: None, ..warning.clone() };
            let _ = writeln!(lines, "{warning}");
        }
        if let Some(more) = Diagnostics::more(warnings.len()) {
            let _ = writeln!(lines, "{more}");
        }
        lines.push_str("```\n");
    }
    for line in lines.lines() {
        let _ = writeln!(text, "{}", format!("/// {line}").trim_end());
    }
}
