//! Checks whether the masses and inertias of bodies are physical.

use modyn_runtime::model::{Inertial, InertialDefect, MovingLink, longest_path};

use super::{Body, LinkView};
use crate::description::MAX_NUMBER;
use crate::diagnostics::{Code, Place, Report, Severity};

/// Checks whether the inertia of a body as a whole is physical; `false` with an error in the
/// report.
pub fn check(body: &Body, whole: &Inertial, unphysical: Severity, report: &mut Report<'_>) -> bool {
    let negative = check_masses(body, report);
    let sound = body.inertials().all(|(_, record)| record.sound);
    sound && check_whole(body, whole, negative, unphysical, report) && !negative
}

/// Returns whether a link of the body has a negative mass. It is an error on any link, since a sum
/// could hide it. No option accepts it: the equations have no meaning with it.
fn check_masses(body: &Body, report: &mut Report<'_>) -> bool {
    let errors = report.errors();
    for (link, record) in body.inertials().filter(|(_, record)| record.inertial.mass < 0.0) {
        let message = format!("the mass is {} kg", record.inertial.mass);
        let help = "write a mass of at least 0";
        report.error(Code::NegativeMass, record.mass_at, Some(&link.subject()), message, help);
    }
    report.errors() > errors
}

fn check_whole(
    body: &Body,
    whole: &Inertial,
    negative: bool,
    severity: Severity,
    report: &mut Report<'_>,
) -> bool {
    let Some((moving, fixed)) = body.links.split_first() else { return true };
    let at = body.inertials().next().map_or(moving.at, |(_, record)| record.at);
    let numbers = [whole.mass].into_iter().chain(whole.center_of_mass).chain(whole.inertia);
    if !numbers.into_iter().all(|x| x.abs() < MAX_NUMBER) {
        let message = "the inertia is too large to compute with";
        let help = "write kg, m and kg m^2";
        report.error(Code::NotFinite, at, Some(&moving.subject()), message, help);
        return false;
    }
    if negative {
        // The sum has no meaning then; each link that is too large is reported.
        for (link, record) in body.inertials() {
            let Inertial { mass, .. } = record.inertial;
            let repaired = Inertial { mass: mass.abs(), ..record.inertial };
            if let Some(defect) = repaired.defect().filter(|_| mass < 0.0) {
                let (code, help) = advice(&defect);
                report.add(
                    severity,
                    code,
                    record.at,
                    Some(&link.subject()),
                    defect.to_string(),
                    help,
                );
            }
        }
    } else if let Some(defect) = whole.defect() {
        let (code, help) = advice(&defect);
        let message = format!("{defect}{}", fixed_names(fixed));
        report.add(severity, code, at, Some(&moving.subject()), message, help);
        return severity == Severity::Warning;
    }
    true
}

/// Returns the code of a defect, and the advice.
fn advice(defect: &InertialDefect) -> (Code, String) {
    let (code, help) = match defect {
        InertialDefect::NegativeMass(_) => {
            return (Code::NegativeMass, "write a mass of at least 0".into());
        }
        InertialDefect::InertiaWithoutMass => {
            (Code::InertiaWithoutMass, "write the mass, or zeros for the rotational inertia")
        }
        InertialDefect::NotPositiveSemidefinite(_) => (
            Code::IndefiniteInertia,
            "check the signs of ixy, ixz, iyz and whether the inertia is about the centre of mass",
        ),
        _ => (
            Code::TriangleInequality,
            "check ixx, iyy, izz and whether the inertia is about the centre of mass",
        ),
    };
    (code, format!("{help}; or accept it with the option `unphysical_inertia = warn`"))
}

fn fixed_names(fixed: &[LinkView]) -> String {
    let mut heavy =
        fixed.iter().filter(|link| link.inertial.is_some()).map(|link| format!("`{}`", link.name));
    let names: Vec<String> = heavy.by_ref().take(10).collect();
    let more = if heavy.next().is_some() { ", ..." } else { "" };
    if names.is_empty() {
        String::new()
    } else {
        format!(" (together with the links that are fixed to it: {}{more})", names.join(", "))
    }
}

/// Warns of links whose mass is too large for their inertia. `links` are the robot's moving links.
pub fn densities(bodies: &[Body], links: &[MovingLink], report: &mut Report<'_>) {
    let longest = longest_path(links);
    let size = if longest > 0.0 { longest } else { 1.0 };
    let mut places: Vec<Place> = Vec::new();
    let mut message = String::new();
    for (link, record) in bodies.iter().flat_map(Body::inertials).filter(|(_, record)| record.sound)
    {
        let Some(defect) = implausible(&record.inertial, size) else { continue };
        if places.is_empty() {
            message = defect;
        }
        places.push((record.mass_at, Some(link.subject())));
    }
    let help =
        "write the mass in kg (not in g), and the inertia in kg m^2 about the centre of mass";
    report.warn_once(Code::ImplausibleMass, &places, &message, help);
}

/// A density above the density of any material (osmium has 22,600), kg/m^3.
const MAX_DENSITY: f64 = 30_000.0;

/// The radius of gyration below which a link counts as a point mass with rounding errors, as a part
/// of the robot's size.
const POINT: f64 = 1e-6;

/// Returns a message if no body can have this mass and inertia; `size` is the robot's, m. Among all
/// bodies of one volume and mass, a ball has the smallest inertia. A body is therefore at least as
/// dense as the ball of its mass and inertia.
fn implausible(inertial: &Inertial, size: f64) -> Option<String> {
    let Inertial { mass, inertia: [xx, _, _, yy, _, zz], .. } = *inertial;
    // A ball of radius r has the moment 2/5 m r^2 about each axis.
    let radius = libm::sqrt((xx + yy + zz) / 3.0 / (0.4 * mass));
    let density = mass / (4.0 / 3.0 * core::f64::consts::PI * radius * radius * radius);
    (radius > POINT * size && density > MAX_DENSITY).then(|| {
        format!(
            "its mass of {mass} kg is too large for its inertia: even a ball with both, of radius {:.3} mm, has \
             {density:.1e} kg/m^3, and no material has more than 2.3e4",
            radius * 1e3
        )
    })
}

/// Warns of moving links without `<inertial>`, if no link that is fixed to them has one either.
/// Bodies in `refused` have an error instead.
pub fn warn_of_missing(bodies: &[Body], refused: &[usize], report: &mut Report<'_>) {
    let mut said = vec![false; bodies.len()];
    refused.iter().for_each(|&i| said[i] = true);
    let places: Vec<Place> = bodies
        .iter()
        .zip(said)
        .filter(|(body, said)| !said && body.inertials().next().is_none())
        .filter_map(|(body, _)| body.links.iter().find(|link| !link.auxiliary))
        .map(|link| (link.at, Some(link.subject())))
        .collect();
    let message = "it moves, but has no `<inertial>`, so it counts as massless";
    let help =
        "write its mass and inertia, or an `<inertial>` with zeros if it is massless on purpose";
    report.warn_once(Code::MissingInertial, &places, message, help);
}
