//! The output of `modyn inspect` for terminals.

use std::fmt::Write as _;

use modyn_codegen::MAX_CONDITION_F32;
use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::model::{Contact, JointFriction, LoopConstraint, Model, ModuleTree, MovingLink};
use unicode_width::UnicodeWidthStr;

use super::{Cost, Inspection, actuators, advice};
use crate::command::numbers::four_digits;
use crate::command::table::{Table, WIDTH, wrapped};

/// The decimal digits of 24 bits.
const F32_DIGITS: f64 = 7.2;

/// The largest number of modules that are drawn: the tree of a chain is as wide as it is high.
const MAX_DRAWN: usize = 1000;

/// The minimal width of a module's list of links; the tree of a deep robot grows to the right.
const LEAST_NAMES: usize = 30;

/// The largest number of pieces of advice that are shown; JSON has all.
const MAX_ADVICE: usize = 40;

/// Returns the inspection as text.
pub fn page(inspection: &Inspection) -> String {
    let Inspection { model, modules, advice, condition, has_dynamics, costs, .. } = inspection;
    let mut out = format!(
        "{}: {} moving links, {} coordinates, {} velocities, {} kg\n",
        sanitize_for_display(model.name()),
        model.moving_links().len(),
        model.nq(),
        model.nv(),
        four_digits(advice::total_mass(model)),
    );
    section(&mut out, "Joints (rad, m, s, N m, N)", &joints(model));
    if !model.loop_constraints().is_empty() {
        section(&mut out, "Loop joints", &loops(model));
    }
    if !model.contacts().is_empty() {
        section(&mut out, "Contacts", &contacts(model));
    }
    if !model.actuation().actuators.is_empty() {
        section(&mut out, "Actuators (N m, N)", &actuators::table(model));
    }
    if !model.keyframes().is_empty() {
        let shown = model.keyframes().iter().map(|key| sanitize_for_display(&key.name));
        let names: Vec<_> = shown.collect();
        section(&mut out, "Keyframes", &paragraph(&names.join(", ")));
    }
    section(&mut out, "Moving links, with the links fixed to them (kg, m, kg m^2)", &links(model));
    section(&mut out, "Kinematic modules", &tree(model, modules));
    match costs {
        None => {}
        Some(Ok(costs)) => section(
            &mut out,
            "Functions: operations of a call, and approximate machine code (x86-64, f64)",
            &functions(costs),
        ),
        Some(Err(why)) => {
            section(&mut out, "Functions", &format!("{}\n", sanitize_for_display(&why.to_string())))
        }
    }
    section(&mut out, "Conditioning", &paragraph(&conditioning(*condition, *has_dynamics)));
    if !advice.is_empty() {
        let line = |one: &advice::Advice| {
            paragraph(&format!("link `{}`: {}", sanitize_for_display(&one.link), one.message))
        };
        let mut lines: String = advice.iter().take(MAX_ADVICE).map(line).collect();
        if advice.len() > MAX_ADVICE {
            let _ = writeln!(lines, "... and {} more", advice.len() - MAX_ADVICE);
        }
        section(&mut out, "To look at", &lines);
    }
    out.push('\n');
    out
}

/// Returns the contacts, one on a line.
fn contacts(model: &Model) -> String {
    let line = |contact: &Contact| {
        let link = sanitize_for_display(&model.links()[contact.end.link].name);
        format!("{} ({}): {link}\n", sanitize_for_display(&contact.name), contact.kind.name())
    };
    model.contacts().iter().map(line).collect()
}

/// Returns the loop joints, one on a line.
fn loops(model: &Model) -> String {
    let line = |constraint: &LoopConstraint| {
        let [first, second] = constraint
            .ends
            .each_ref()
            .map(|end| sanitize_for_display(&model.links()[end.link].name));
        format!(
            "{} ({}): {first} and {second}\n",
            sanitize_for_display(&constraint.name),
            constraint.kind.name()
        )
    };
    model.loop_constraints().iter().map(line).collect()
}

/// Returns a sentence, wrapped to the width of the output.
fn paragraph(text: &str) -> String {
    let lines = wrapped(text.trim_end().split(' '), " ", WIDTH - 4);
    lines.join("\n    ") + "\n"
}

fn section(out: &mut String, title: &str, body: &str) {
    // Bold on terminals.
    let _ = writeln!(out, "\n\u{1b}[1m{title}\u{1b}[0m");
    body.lines().for_each(|line| {
        let _ = writeln!(out, "  {line}");
    });
}

fn optional(x: Option<f64>) -> String {
    x.map_or_else(|| "-".into(), four_digits)
}

fn vector(x: &[f64]) -> String {
    x.iter().map(|&x| four_digits(x)).collect::<Vec<_>>().join(" ")
}

fn joints(model: &Model) -> String {
    let mut table = Table::new(&[
        "q", "joint", "type", "axis", "parent", "lower", "upper", "velocity", "effort", "",
    ]);
    for (i, link) in model.moving_links().iter().enumerate() {
        let joint = &link.joint;
        let limits = joint.limits.as_ref();
        let q = model.q_range(i);
        let place = match q.len() {
            1 => format!("{}", q.start),
            _ => format!("{}..{}", q.start, q.end),
        };
        table.row([
            place,
            sanitize_for_display(&joint.name),
            joint.joint_type.name().into(),
            vector(&joint.axis),
            parent(model, link),
            optional(limits.and_then(|l| l.lower)),
            optional(limits.and_then(|l| l.upper)),
            optional(limits.and_then(|l| l.velocity)),
            optional(limits.and_then(|l| l.effort)),
            notes(model, i),
        ]);
    }
    table.with_remarks().fitted()
}

fn parent(model: &Model, link: &MovingLink) -> String {
    link.parent
        .map_or_else(|| "the base".into(), |p| sanitize_for_display(&model.moving_links()[p].name))
}

/// Returns whether damping acts, and whether Coulomb friction acts.
pub fn active_friction(model: &Model) -> [bool; 2] {
    let friction = model.joint_friction();
    [
        friction != JointFriction::None,
        !matches!(friction, JointFriction::None | JointFriction::Viscous),
    ]
}

/// Returns notes on a joint: mimic relation, armature, spring, damping, friction.
fn notes(model: &Model, link: usize) -> String {
    let joint = &model.moving_links()[link].joint;
    let mut notes = Vec::new();
    if let Some(mimic) = model.mimic(link) {
        let leader = sanitize_for_display(&model.moving_links()[mimic.leader].joint.name);
        let ratio = four_digits(mimic.multiplier);
        let offset = four_digits(mimic.offset);
        notes.push(format!("follows {leader} times {ratio} plus {offset}"));
    }
    let dynamics = &joint.dynamics;
    if dynamics.armature != 0.0 {
        notes.push(format!("armature {}", four_digits(dynamics.armature)));
    }
    if let Some(spring) = model.spring(link) {
        let reference: Vec<String> = spring.reference.iter().map(|x| four_digits(*x)).collect();
        let stiffness = four_digits(spring.stiffness);
        notes.push(format!("spring {stiffness} from {}", reference.join(" ")));
    }
    let [damps, rubs] = active_friction(model);
    for (what, x, acts) in
        [("damping", dynamics.damping, damps), ("friction", dynamics.friction, rubs)]
    {
        if x != 0.0 {
            let inactive = if acts { "" } else { " (does not act)" };
            notes.push(format!("{what} {}{inactive}", four_digits(x)));
        }
    }
    notes.join(", ")
}

fn links(model: &Model) -> String {
    let mut table = Table::new(&["link", "mass", "centre of mass", "principal moments", "carries"]);
    let mut carried = vec![Vec::new(); model.moving_links().len()];
    for link in model.links() {
        if let Some(i) = link.moving_link.filter(|&i| model.moving_links()[i].name != link.name) {
            carried[i].push(sanitize_for_display(&link.name));
        }
    }
    for (link, carried) in model.moving_links().iter().zip(&carried) {
        table.row([
            sanitize_for_display(&link.name),
            four_digits(link.inertial.mass),
            vector(&link.inertial.center_of_mass),
            vector(&link.inertial.principal_moments()),
            carried.join(", "),
        ]);
    }
    table.with_remarks().fitted()
}

/// Returns the modules as a tree, without recursion, since a chain of modules may be long.
fn tree(model: &Model, tree: &ModuleTree) -> String {
    let modules = tree.modules();
    if modules.len() > MAX_DRAWN {
        return format!("{} modules: too many to draw\n", modules.len());
    }
    let mut out = String::from("the base\n");
    let roots = (0..modules.len()).filter(|&m| modules[m].parent.is_none()).collect::<Vec<_>>();
    let mut waiting: Vec<(usize, String, bool)> = Vec::new();
    let put = |waiting: &mut Vec<_>, children: &[usize], indent: &str| {
        for (i, &child) in children.iter().enumerate().rev() {
            waiting.push((child, indent.to_string(), i + 1 == children.len()));
        }
    };
    put(&mut waiting, &roots, "");
    while let Some((m, indent, last)) = waiting.pop() {
        let links = modules[m].links.clone();
        let names: Vec<String> =
            links.map(|i| sanitize_for_display(&model.moving_links()[i].name)).collect();
        let (branch, below) = if last { ("└─", "   ") } else { ("├─", "│  ") };
        let start = format!("{indent}{branch} {m}: ");
        let room = WIDTH.saturating_sub(start.width()).max(LEAST_NAMES);
        let names = wrapped(names.iter().map(String::as_str), " ─ ", room);
        // Links that continue on the next line are aligned with the first link.
        let bar = if modules[m].children.is_empty() { "" } else { "│" };
        let rest = format!("{indent}{below}{bar}");
        for (i, names) in names.iter().enumerate() {
            let space = " ".repeat(start.width().saturating_sub(rest.width()));
            let _ = if i == 0 {
                writeln!(out, "{start}{names}")
            } else {
                writeln!(out, "{rest}{space}{names}")
            };
        }
        put(&mut waiting, &modules[m].children, &format!("{indent}{below}"));
    }
    out
}

fn functions(costs: &[Cost]) -> String {
    let mut table = Table::new(&["function", "mul", "add", "div", "sin/cos", "in all", "code, kB"]);
    for Cost { name, operations, bytes, .. } in costs {
        table.row([
            (*name).into(),
            operations.multiplications.to_string(),
            operations.additions.to_string(),
            operations.divisions.to_string(),
            operations.sin_cos.to_string(),
            operations.total().to_string(),
            bytes.map_or_else(|| "-".into(), |bytes| format!("{:.1}", bytes / 1000.0)),
        ]);
    }
    let loops = costs
        .iter()
        .filter_map(|cost| Some(paragraph(&format!("{} has {}", cost.name, cost.loops.as_ref()?))));
    table.right_aligned_from(1).text() + &loops.collect::<String>()
}

fn conditioning(condition: Option<f64>, has_dynamics: bool) -> String {
    match condition {
        None if !has_dynamics => "the robot has no dynamics, since links have no inertia\n".into(),
        None => "not computed: the robot is too large\n".into(),
        Some(number) => format!(
            "mass matrix, scaled to a unit diagonal: up to {number:.1e}; f32 {}\n",
            if number > MAX_CONDITION_F32 {
                "may keep no digits of the accelerations: use f64, or compare with it".into()
            } else {
                let digits = (F32_DIGITS - number.log10()).floor();
                format!("keeps about {digits} digits of accelerations")
            }
        ),
    }
}
