//! Contacts of the options: frames of links that can touch the world.

use modyn_runtime::model::{Contact, LoopConstraintEnd};
use modyn_runtime::spatial::Pose;
use rustc_hash::FxHashSet;

use crate::description::{self, Description, MAX_NUMBER, roll_pitch_yaw};
use crate::diagnostics::{Code, Diagnostic, Report, suggest};

/// Returns the contacts, and reports their errors. `carriers` has, for each link of the description, the moving
/// link that carries it.
pub fn contacts(
    description: &Description,
    options: &[description::Contact],
    carriers: &[Option<usize>],
    report: &mut Report<'_>,
) -> Vec<Contact> {
    let mut names: FxHashSet<&str> =
        description.loops.iter().map(|closing| closing.name.as_str()).collect();
    let mut contact = |option: &'_ description::Contact| {
        let name = &option.name;
        let errors = report.errors();
        let mut error = |message: String, help: &str| {
            let message = format!("contact `{name}`: {message}");
            report.push(Diagnostic::error(Code::Option, message).with_help(help));
        };
        if name.is_empty() {
            error("its name is empty".into(), "give it a name, such as `left_foot`");
        }
        let link = &option.end.link;
        let frame = description.link_names().position(|own| own == link);
        match frame.map(|frame| carriers[frame]) {
            None => {
                let help = suggest(link, description.link_names()).map_or_else(
                    || "name a link of the description".into(),
                    |name| format!("did you mean `{name}`?"),
                );
                error(format!("link `{link}` does not exist"), &help);
            }
            Some(None) => {
                let help = "name a link that moves, or let the base float: `base = floating`";
                error(format!("link `{link}` is fixed to the world"), help);
            }
            Some(Some(_)) => {}
        }
        let numbers = option.end.xyz.iter().chain(&option.end.rpy);
        if !numbers.into_iter().all(|x| x.abs() < MAX_NUMBER) {
            error("its place is not finite".into(), "write `xyz` in m and `rpy` in rad");
        }
        let rotation = roll_pitch_yaw(option.end.rpy);
        let pose = Pose { rotation, translation: option.end.xyz };
        let end = LoopConstraintEnd { frame: frame?, pose };
        (report.errors() == errors).then(|| Contact { name: name.clone(), kind: option.kind, end })
    };
    let found: Vec<Contact> = options.iter().filter_map(&mut contact).collect();
    for option in options {
        if !names.insert(&option.name) {
            let message =
                format!("contact `{}`: another constraint has the same name", option.name);
            let help = "give one of them another name";
            report.push(Diagnostic::error(Code::Option, message).with_help(help));
        }
    }
    found
}
