//! The laws of contacts of geoms, and the softness of joints: the rules of `MuJoCo`'s documentation
//! ("Computation", section "Contact").

use modyn_runtime::ContactSurface;
use modyn_runtime::model::{ContactComponents, Impedance, Softness};
use modyn_runtime::spatial::Pose;

use super::check::{filled, list};
use super::item::Item;
use super::settings::{ContactOverride, IMPEDANCE, LEAST, REFERENCE};
use crate::description::SoftnessRecord;
use crate::diagnostics::{Code, Place, Report};

/// A geom that can touch other geoms.
#[derive(Clone)]
pub struct Geom<'e> {
    pub item: Item<'e>,
    pub carrier: Carrier,
    pub law: Law,
}

/// The body of a geom.
#[derive(Clone)]
pub struct Carrier {
    pub body: String,
    /// The link with the body's frame, and whether it moves.
    pub link: usize,
    pub moves: bool,
    /// The pose of the body in the world, where the model is drawn.
    pub drawn: Pose<f64>,
}

/// The attributes of a geom that decide which geoms it touches, and how.
#[derive(Clone, Copy)]
pub struct Law {
    /// `contype` and `conaffinity`.
    pub types: [u32; 2],
    priority: f64,
    weight: f64,
    pub contact: Contact,
}

/// The parameters of a contact.
#[derive(Clone, Copy)]
pub struct Contact {
    pub components: ContactComponents,
    pub friction: [f64; 3],
    pub margin: f64,
    pub reference: [f64; 2],
    pub impedance: [f64; 5],
}

/// `MuJoCo`'s default.
const FRICTION: [f64; 3] = [1.0, 0.005, 0.0001];

impl Default for Law {
    fn default() -> Self {
        let contact = Contact {
            components: ContactComponents::default(),
            friction: FRICTION,
            margin: 0.0,
            reference: REFERENCE,
            impedance: IMPEDANCE,
        };
        Self { types: [1, 1], priority: 0.0, weight: 1.0, contact }
    }
}

impl Law {
    pub fn of(geom: &Item, report: &mut Report<'_>) -> Self {
        let number = |name: &str, default: f64| geom.number(name).unwrap_or(default);
        let numbers = |name: &str| geom.text(name).and_then(list);
        Self {
            types: ["contype", "conaffinity"].map(|name| number(name, 1.0) as i32 as u32),
            priority: number("priority", 0.0),
            weight: number("solmix", 1.0),
            contact: Contact {
                components: components(geom, report).unwrap_or_default(),
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

    /// Returns the contact of two geoms.
    pub fn mixed(&self, other: &Self) -> Contact {
        let margin = self.contact.margin + other.contact.margin;
        if self.priority != other.priority {
            let law = if self.priority > other.priority { self } else { other };
            return Contact { margin, ..law.contact };
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
        Contact {
            components: a.components.max(b.components),
            friction: core::array::from_fn(|k| a.friction[k].max(b.friction[k])),
            margin,
            reference: [reference(0), reference(1)],
            impedance: core::array::from_fn(|k| mixed(a.impedance[k], b.impedance[k])),
        }
    }
}

/// Returns the components of the contacts of a geom or of a pair; `None` if it has no `condim`, or
/// with an error in the report.
fn components(item: &Item, report: &mut Report<'_>) -> Option<ContactComponents> {
    let count = item.number("condim")?;
    let components = ContactComponents::from_count(count as usize);
    if components.is_none() || count.fract() != 0.0 {
        let message = format!("`condim=\"{count}\"` is no number of components");
        let help = "write 1, 3, 4 or 6";
        report.error(Code::NotRead, item.element().at, None, message, help);
    }
    components
}

/// A pair of `<contact>`, by the names of its geoms. A missing attribute has `MuJoCo`'s default value;
/// the laws of the geoms have no effect.
pub struct Pair {
    geoms: [String; 2],
    pub contact: Contact,
}

impl Pair {
    pub fn of(item: &Item, report: &mut Report<'_>) -> Self {
        let numbers = |name: &str| item.text(name).and_then(list);
        let name = |attribute| item.text(attribute).map(|name| item.naming.name(name));
        let [sliding, spin, roll] = FRICTION;
        let friction = [sliding, sliding, spin, roll, roll];
        Self {
            geoms: ["geom1", "geom2"].map(|attribute| name(attribute).unwrap_or_default()),
            contact: Contact {
                components: components(item, report).unwrap_or_default(),
                friction: isotropic(filled(numbers("friction").as_deref(), friction)),
                margin: item.number("margin").unwrap_or(0.0),
                reference: filled(numbers("solref").as_deref(), REFERENCE),
                impedance: filled(numbers("solimp").as_deref(), IMPEDANCE),
            },
        }
    }

    /// Returns whether the pair is of these geoms.
    pub fn is_of(&self, a: &Geom, b: &Geom) -> bool {
        let is = |name: &str, geom: &Geom| geom.item.name().as_deref() == Some(name);
        let [first, second] = &self.geoms;
        is(first, a) && is(second, b) || is(first, b) && is(second, a)
    }
}

/// Returns the sliding, torsional and rolling friction of the five coefficients of a contact: both
/// tangents, spin, both rolls.
fn isotropic([sliding, _, spin, roll, _]: [f64; 5]) -> [f64; 3] {
    [sliding, spin, roll]
}

/// Returns whether an attribute has other coefficients along the second tangent than along the
/// first.
pub fn is_anisotropic(coefficients: &[f64]) -> bool {
    let differ = |a: usize, b: usize| {
        coefficients.get(a).zip(coefficients.get(b)).is_some_and(|(a, b)| a != b)
    };
    differ(0, 1) || differ(3, 4)
}

impl ContactOverride {
    /// Returns a contact with these parameters.
    pub fn replaced(self, contact: Contact) -> Contact {
        let Self { friction, margin, reference, impedance } = self;
        let friction = isotropic(friction);
        Contact { friction, margin, reference, impedance, ..contact }
    }
}

impl Contact {
    /// Returns the contact with this coefficient of sliding friction, if there is one.
    pub fn with_friction(self, friction: Option<f64>) -> Self {
        let [sliding, torsional, rolling] = self.friction;
        Self { friction: [friction.unwrap_or(sliding), torsional, rolling], ..self }
    }

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
/// Adds the joint to `rounded` if a power was rounded.
pub fn joint_softness(joint: &Item, rounded: &mut Vec<Place>) -> Option<SoftnessRecord> {
    let names = ["solreflimit", "solimplimit", "solreffriction", "solimpfriction", "margin"];
    if names.iter().all(|name| joint.text(name).is_none()) {
        return None;
    }
    Some(SoftnessRecord {
        limit: softness(joint, ["solreflimit", "solimplimit"], rounded),
        friction: softness(joint, ["solreffriction", "solimpfriction"], rounded),
        margin: joint.number("margin").unwrap_or(0.0),
    })
}

/// Returns the softness in the attributes of these names, a reference and an impedance. Adds the
/// element to `rounded` if a power was rounded.
pub fn softness(
    item: &Item,
    [reference, impedance]: [&str; 2],
    rounded: &mut Vec<Place>,
) -> Softness<f64> {
    let numbers = |name: &str| item.text(name).and_then(list);
    let [least, most, width, midpoint, exponent] = filled(numbers(impedance).as_deref(), IMPEDANCE);
    let power = power(exponent, item.element().at, rounded);
    Softness {
        reference: filled(numbers(reference).as_deref(), REFERENCE),
        impedance: Impedance { least, most, width, midpoint, power },
    }
}

/// Returns the power of a curve of impedances, which is rounded to an integer: the place of one that
/// was none is added to `rounded`. The mean of two equal powers may have a rounding error.
pub fn power(exponent: f64, at: usize, rounded: &mut Vec<Place>) -> u32 {
    const ROUNDING: f64 = 1e-9;
    if exponent >= 1.0 && (exponent - exponent.round()).abs() > ROUNDING {
        rounded.push((Some(at), None));
    }
    exponent.round().clamp(1.0, 100.0) as u32
}
