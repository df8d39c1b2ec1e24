//! Contacts of the description and of the options: frames of links that can touch the world.

use modyn_runtime::model::{Contact, LoopConstraintEnd};
use modyn_runtime::spatial::Pose;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::description::{
    self, ContactRecord, Description, EndRecord, LoopEnd, MAX_NUMBER, roll_pitch_yaw,
};
use crate::diagnostics::{Code, Report, Suggestions};

/// Returns the record of a contact of the options.
pub fn from_option(option: &description::Contact) -> ContactRecord {
    let LoopEnd { link, xyz, rpy } = &option.end;
    let pose = Pose { rotation: roll_pitch_yaw(*rpy), translation: *xyz };
    let end = EndRecord { link: Some(link.clone()), at: None, pose };
    ContactRecord { name: option.name.clone(), at: None, kind: Some(option.kind), end }
}

/// Returns the contacts, and reports their errors. `carriers` has, for each link of the
/// description, the moving link that carries it.
pub fn contacts(
    description: &Description,
    carriers: &[Option<usize>],
    report: &mut Report<'_>,
) -> Vec<Contact> {
    let loops = description.loops.iter().map(|closing| closing.name.as_str());
    let mut names: FxHashSet<&str> = loops.collect();
    let mut links = Links { description, frames: FxHashMap::default(), near: Suggestions::new() };
    for (frame, name) in description.link_names().enumerate() {
        links.frames.entry(name).or_insert(frame);
    }
    let all = description.contacts.iter();
    all.filter_map(|record| {
        let is_new = names.insert(&record.name);
        contact(&mut links, record, is_new, carriers, report)
    })
    .collect()
}

/// The links of a description by their names.
struct Links<'d> {
    description: &'d Description,
    frames: FxHashMap<&'d str, usize>,
    near: Suggestions,
}

/// Returns the contact of a record; `None` with an error in the report.
fn contact(
    links: &mut Links<'_>,
    record: &ContactRecord,
    is_new: bool,
    carriers: &[Option<usize>],
    report: &mut Report<'_>,
) -> Option<Contact> {
    let errors = report.errors();
    let code = if record.at.is_some() { Code::ContactFrame } else { Code::Option };
    let mut error = |at: Option<usize>, message: String, help: &str| {
        report.error(code, at, Some(&record.subject()), message, help);
    };
    // An element without a name is already an error.
    if record.name.is_empty() && record.at.is_none() {
        error(None, "its name is empty".into(), "give it a name, such as `left_foot`");
    }
    if !is_new && !record.name.is_empty() {
        let help = "give one of them another name";
        error(record.at, "another constraint has the same name".into(), help);
    }
    let end = &record.end;
    let link = end.link.as_deref();
    let frame = link.and_then(|link| links.frames.get(link).copied());
    match (link, frame.map(|frame| carriers[frame])) {
        (Some(link), None) => {
            let help = links.near.suggest(link, links.description.link_names()).map_or_else(
                || "name a link of the description".into(),
                |name| format!("did you mean `{name}`?"),
            );
            error(end.at, format!("link `{link}` does not exist"), &help);
        }
        (Some(link), Some(None)) => {
            let help = "name a link that moves, or let the base float: `base = floating`";
            error(end.at, format!("link `{link}` is fixed to the world"), help);
        }
        _ => {}
    }
    let numbers = end.pose.rotation.iter().flatten().chain(&end.pose.translation);
    if !numbers.into_iter().all(|x| x.abs() < MAX_NUMBER) {
        let help = "write `xyz` in m and `rpy` in rad";
        error(end.at, "its place is not finite".into(), help);
    }
    let end = LoopConstraintEnd { link: frame?, pose: end.pose };
    let contact = Contact { name: record.name.clone(), kind: record.kind?, end };
    (report.errors() == errors).then_some(contact)
}
