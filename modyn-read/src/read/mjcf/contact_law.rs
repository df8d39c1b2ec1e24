//! The laws of contacts of geoms, and the softness of joints: the rules of `MuJoCo`'s documentation
//! ("Computation", section "Contact").

use modyn_runtime::ContactSurface;
use modyn_runtime::model::{ContactComponents, Impedance, Softness};
use modyn_runtime::spatial::Pose;

use super::check::{filled, list};
use super::item::Item;
use super::settings::{ContactOverride, IMPEDANCE, REFERENCE};
use crate::description::SoftnessRecord;
use crate::diagnostics::{Code, Report, Severity};

/// The least sum of weights by which softness is mixed, as in `MuJoCo`.
const LEAST: f64 = 1e-15;

/// A geom that can touch other geoms.
#[derive(Clone)]
pub struct Geom<'e> {
    pub item: Item<'e>,
    pub body: String,
    /// The link, and whether it moves.
    pub link: usize,
    pub moves: bool,
    /// The pose of the body in the world, where the model is drawn.
    pub drawn: Pose<f64>,
    pub law: Law,
}

/// The attributes of a geom that decide which geoms it touches, and how.
#[derive(Clone, Copy)]
pub struct Law {
    pub types: [u32; 2],
    pub components: ContactComponents,
    pub priority: f64,
    pub weight: f64,
    pub contact: Contact,
}

/// The parameters of a contact.
#[derive(Clone, Copy)]
pub struct Contact {
    pub friction: [f64; 3],
    pub margin: f64,
    pub reference: [f64; 2],
    pub impedance: [f64; 5],
}

/// `MuJoCo`'s default.
const FRICTION: [f64; 3] = [1.0, 0.005, 0.0001];

/// A place of a geom: its link, the pose of the body's frame in it, and whether the link moves.
pub struct Place<'a> {
    pub body: &'a str,
    pub link: usize,
    pub moves: bool,
    /// The pose of the body in the world, where the model is drawn.
    pub drawn: Pose<f64>,
}

impl Law {
    pub fn of(geom: &Item, report: &mut Report<'_>) -> Self {
        let at = geom.element().at;
        let number = |name: &str, default: f64| geom.number(name).unwrap_or(default);
        let count = number("condim", 3.0);
        let components = ContactComponents::from_count(count as usize).unwrap_or_else(|| {
            let message = format!("`condim=\"{count}\"` is no number of components");
            report.error(Code::NotRead, at, None, message, "write 1, 3, 4 or 6");
            ContactComponents::Sliding
        });
        let numbers = |name: &str| geom.text(name).and_then(list);
        Self {
            types: ["contype", "conaffinity"].map(|name| number(name, 1.0) as i32 as u32),
            components,
            priority: number("priority", 0.0),
            weight: number("solmix", 1.0),
            contact: Contact {
                friction: filled(numbers("friction").as_deref(), FRICTION),
                margin: number("margin", 0.0),
                reference: filled(numbers("solref").as_deref(), REFERENCE),
                impedance: filled(numbers("solimp").as_deref(), IMPEDANCE),
            },
        }
    }

    /// Returns whether geoms with these laws touch each other.
    pub fn touches(&self, other: &Self) -> bool {
        self.types[0] & other.types[1] != 0 || other.types[0] & self.types[1] != 0
    }

    /// Returns the law of the contact of two geoms.
    pub fn mixed(&self, other: &Self) -> (ContactComponents, Contact) {
        let margin = self.contact.margin + other.contact.margin;
        if self.priority != other.priority {
            let law = if self.priority > other.priority { self } else { other };
            return (law.components, Contact { margin, ..law.contact });
        }
        let share = match [self.weight >= LEAST, other.weight >= LEAST] {
            [true, true] => self.weight / (self.weight + other.weight),
            [false, false] => 0.5,
            [false, true] => 0.0,
            [true, false] => 1.0,
        };
        let [a, b] = [&self.contact, &other.contact];
        let mixed = |a: f64, b: f64| share * a + (1.0 - share) * b;
        let is_standard = a.reference[0] > 0.0 && b.reference[0] > 0.0;
        let reference = |k: usize| match is_standard {
            true => mixed(a.reference[k], b.reference[k]),
            false => a.reference[k].min(b.reference[k]),
        };
        let contact = Contact {
            friction: core::array::from_fn(|k| a.friction[k].max(b.friction[k])),
            margin,
            reference: [reference(0), reference(1)],
            impedance: core::array::from_fn(|k| mixed(a.impedance[k], b.impedance[k])),
        };
        (self.components.max(other.components), contact)
    }
}

impl From<ContactOverride> for Contact {
    fn from(given: ContactOverride) -> Self {
        let ContactOverride { friction, margin, reference, impedance } = given;
        Self { friction: [friction[0], friction[2], friction[3]], margin, reference, impedance }
    }
}

impl Contact {
    pub fn surface(&self, plane: Pose<f64>, radius: f64) -> ContactSurface<f64> {
        let [friction, torsional_friction, rolling_friction] = self.friction.map(|x| x.max(0.0));
        let [least, most, width, midpoint, _] = self.impedance;
        ContactSurface {
            plane,
            radius,
            friction,
            torsional_friction,
            rolling_friction,
            margin: self.margin,
            solref: self.reference,
            solimp: [least, most, width, midpoint],
        }
    }
}

/// Returns the softness of a joint's limits and friction; `None` if it is `MuJoCo`'s default.
pub fn joint_softness(joint: &Item, report: &mut Report<'_>) -> Option<SoftnessRecord> {
    let names = ["solreflimit", "solimplimit", "solreffriction", "solimpfriction", "margin"];
    if names.iter().all(|name| joint.text(name).is_none()) {
        return None;
    }
    let numbers = |name: &str| joint.text(name).and_then(list);
    let mut softness = |reference: &str, impedance: &str| {
        let [least, most, width, midpoint, exponent] =
            filled(numbers(impedance).as_deref(), IMPEDANCE);
        let power = power(exponent, joint.element().at, report);
        Softness {
            reference: filled(numbers(reference).as_deref(), REFERENCE),
            impedance: Impedance { least, most, width, midpoint, power },
        }
    };
    Some(SoftnessRecord {
        limit: softness("solreflimit", "solimplimit"),
        friction: softness("solreffriction", "solimpfriction"),
        margin: joint.number("margin").unwrap_or(0.0),
    })
}

/// Returns the power of a curve of impedances.
pub fn power(exponent: f64, at: usize, report: &mut Report<'_>) -> u32 {
    if exponent >= 1.0 && exponent.fract() != 0.0 {
        let message = format!("the power {exponent} of `solimp` is not read: it is rounded");
        let help = "write an integer as the fifth number of `solimp`";
        report.add(Severity::Warning, Code::NotRead, at, None, message, help);
    }
    exponent.round().clamp(1.0, 100.0) as u32
}
