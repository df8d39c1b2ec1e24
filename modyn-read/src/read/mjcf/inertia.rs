//! The inertia of a body.

use modyn_runtime::model::Inertial;
use modyn_runtime::spatial::Pose;

use super::item::Item;
use super::mesh::principal_axes;
use super::models::Model;
use super::settings::Settings;
use crate::diagnostics::{Code, Report, Subject};

/// Returns the inertia of an `<inertial>` in the body's frame; `None` with an error in the report,
/// or without a sound mass.
pub fn explicit(
    item: &Item,
    name: &str,
    model: &Model,
    report: &mut Report<'_>,
) -> Option<Inertial> {
    let pose = item.pose(&model.settings, report);
    let mut missing = |what: &str, help: &str| {
        if item.text(what).is_none() {
            let message = format!("`<inertial>` has no `{what}`");
            let subject = Subject::Link(name.into());
            report.error(Code::MissingAttribute, item.element().at, Some(&subject), message, help);
        }
    };
    let inertia = match (item.numbers("fullinertia"), item.numbers("diaginertia")) {
        (Some([xx, yy, zz, xy, xz, yz]), _) => [xx, xy, xz, yy, yz, zz],
        (None, Some([xx, yy, zz])) => [xx, 0.0, 0.0, yy, 0.0, zz],
        // A point mass, as in MuJoCo.
        (None, None) => [0.0; 6],
    };
    let Some(mass) = item.number("mass") else {
        missing("mass", "write `mass=\"...\"`, kg");
        return None;
    };
    if item.text("pos").is_none() {
        missing("pos", "write `pos=\"...\"`, the centre of mass");
        return None;
    }
    Some(Inertial { mass, center_of_mass: [0.0; 3], inertia }.transformed(&pose))
}

/// Returns the inertia with the least mass and moments of inertia of the settings.
pub fn bounded(inertial: Option<Inertial>, settings: &Settings) -> Option<Inertial> {
    let least = settings.bound_inertia.max(0.0);
    if settings.bound_mass <= 0.0 && least == 0.0 && !settings.balance_inertia {
        return inertial;
    }
    let whole = inertial.unwrap_or_default();
    let [xx, xy, xz, yy, yz, zz] = whole.inertia;
    let (moments, axes) = principal_axes([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    let mut bounded = moments.map(|moment| moment.max(least));
    let [a, b, c] = bounded;
    if settings.balance_inertia && (a + b < c || a + c < b || b + c < a) {
        bounded = [(a + b + c) / 3.0; 3];
    }
    let inertia = if bounded == moments {
        whole.inertia
    } else {
        let frame = Pose { rotation: axes, translation: [0.0; 3] };
        let [xx, yy, zz] = bounded;
        let inertia = [xx, 0.0, 0.0, yy, 0.0, zz];
        Inertial { mass: 0.0, center_of_mass: [0.0; 3], inertia }.transformed(&frame).inertia
    };
    Some(Inertial { mass: whole.mass.max(settings.bound_mass), inertia, ..whole })
}

/// Reports a body whose inertia is not computed.
pub fn report_missing(name: &str, at: usize, why: &str, report: &mut Report<'_>) {
    let message = format!("it has no `<inertial>`, and {why}");
    let help = "write `<inertial>`, or give the geoms `mass=\"0\"`; MuJoCo writes each \
                `<inertial>` if it reads the file with \
                `<compiler saveinertial=\"true\"/>` and `mj_saveLastXML` saves the model";
    let subject = Subject::Link(name.into());
    report.error(Code::MissingElement, at, Some(&subject), message, help);
}
