//! The shapes of bodies that touch planes of the world, and the softness of their contacts and of
//! joints: the rules of `MuJoCo`'s documentation ("Computation", section "Contact").

use std::collections::{HashMap, HashSet};

use modyn_runtime::ContactSurface;
use modyn_runtime::model::{
    ContactComponents, Impedance, LoopConstraintEnd, SoftConstraints, Softness, TouchingShape,
};
use modyn_runtime::spatial::{Matrix3, Pose, Vector3};

use super::bodies::Bodies;
use super::check::list;
use super::geoms::{self, Touching};
use super::item::{Item, Naming};
use super::settings::ContactOverride;
use crate::description::SoftnessRecord;
use crate::diagnostics::{Code, Report, Severity};

/// The largest number of shapes that touch the ground.
const MAX_SHAPES: usize = 1_000;

/// The least sum of weights by which softness is mixed, as in `MuJoCo`.
const LEAST: f64 = 1e-15;

/// A geom that can touch other geoms.
#[derive(Clone)]
pub struct Geom<'e> {
    item: Item<'e>,
    body: String,
    /// The link, and whether it moves.
    link: usize,
    moves: bool,
    /// The pose of the body in the world, where the model is drawn.
    drawn: Pose<f64>,
    law: Law,
}

/// A plane or a height field of the world.
struct Ground<'a, 'e> {
    geom: &'a Geom<'e>,
    is_field: bool,
    /// The pose of a plane, with the axes of `MuJoCo`'s contacts.
    pose: Pose<f64>,
}

/// The attributes of a geom that decide which geoms it touches, and how.
#[derive(Clone, Copy)]
struct Law {
    types: [u32; 2],
    components: ContactComponents,
    priority: f64,
    weight: f64,
    contact: Contact,
}

/// The parameters of a contact.
#[derive(Clone, Copy)]
struct Contact {
    friction: [f64; 3],
    margin: f64,
    reference: [f64; 2],
    impedance: [f64; 5],
}

/// `MuJoCo`'s defaults.
const REFERENCE: [f64; 2] = [0.02, 1.0];
const IMPEDANCE: [f64; 5] = [0.9, 0.95, 0.001, 0.5, 2.0];
const FRICTION: [f64; 3] = [1.0, 0.005, 0.0001];

/// A place of a geom: its link, the pose of the body's frame in it, and whether the link moves.
pub struct Place<'a> {
    pub body: &'a str,
    pub link: usize,
    pub moves: bool,
    /// The pose of the body in the world, where the model is drawn.
    pub drawn: Pose<f64>,
}

impl<'e> Bodies<'e, '_, '_> {
    /// Keeps the geoms of a body that can touch other geoms.
    pub fn touching(&mut self, geoms: &[Item<'e>], place: &Place<'_>) {
        if !self.models[0].settings.contacts {
            return;
        }
        for item in geoms {
            if !self.models[item.model].is_sound(&item.chain) {
                continue;
            }
            let law = Law::of(item, self.report);
            let is_ground = matches!(item.text("type"), Some("plane" | "hfield"));
            let touches = law.types != [0, 0] || self.has_pairs;
            if touches && place.moves != is_ground {
                self.geoms.push(Geom {
                    item: item.clone(),
                    body: place.body.to_owned(),
                    link: place.link,
                    moves: place.moves,
                    drawn: place.drawn,
                    law,
                });
            }
        }
    }

    /// Adds the shapes that touch planes to the description.
    pub fn soft_constraints(&mut self) {
        let settings = &self.models[0].settings;
        let mut soft = SoftConstraints {
            cone: settings.cone,
            impratio: settings.impratio,
            joint_limits: settings.limits,
            joint_friction: true,
            ..SoftConstraints::default()
        };
        let geoms = std::mem::take(&mut self.geoms);
        let mut grounds = Vec::new();
        for geom in geoms.iter().filter(|geom| !geom.moves) {
            let pose = geom.item.pose(&self.models[geom.item.model].settings, self.report);
            let is_field = geom.item.text("type") == Some("hfield");
            grounds.push(Ground { geom, is_field, pose: plane(&geom.drawn.compose(&pose)) });
        }
        let rules = Rules { pairs: self.pairs(), excluded: self.excluded() };
        let mut names = Names::default();
        for geom in geoms.iter().filter(|geom| geom.moves) {
            let touched =
                grounds.iter().filter_map(|ground| Some((ground, rules.law(geom, ground)?)));
            for (ground, law) in touched {
                if soft.shapes.len() >= MAX_SHAPES {
                    return self.refuse_many_shapes();
                }
                if ground.is_field {
                    self.warn_of_field(ground.geom.item.element().at);
                    continue;
                }
                let shape = self.shape(geom, &mut names, law, ground.pose);
                soft.shapes.extend(shape);
            }
        }
        self.description.soft = Some(soft);
    }

    /// Returns a shape that touches a plane; `None` with a warning if its contacts are not computed.
    fn shape(
        &mut self,
        geom: &Geom<'e>,
        names: &mut Names,
        law: (ContactComponents, Contact),
        plane: Pose<f64>,
    ) -> Option<TouchingShape> {
        let (components, mixed) = law;
        let item = &geom.item;
        let at = item.element().at;
        let model = &self.models[item.model];
        let touching = geoms::touching(item, model, &mut self.meshes, self.report);
        let (pose, Touching { shape, radius }) = match touching {
            Ok(touching) => touching,
            Err(why) => {
                let message = format!("a geom does not touch the ground in `step`: {why}");
                let help = "give the body a geom of another type for its contacts";
                self.report.add(Severity::Warning, Code::NotRead, at, None, message, help);
                return None;
            }
        };
        let contact = self.models[0].settings.overriding.map_or(mixed, Contact::from);
        let name = item.name().unwrap_or_else(|| format!("{}_geom", geom.body));
        Some(TouchingShape {
            name: names.unique(&name),
            end: LoopConstraintEnd { frame: geom.link, pose },
            shape,
            components,
            surface: contact.surface(plane, radius),
            power: power(contact.impedance[4], at, self.report),
        })
    }

    fn refuse_many_shapes(&mut self) {
        let message = format!("more than {MAX_SHAPES} shapes touch the ground");
        let help = "write `contype=\"0\" conaffinity=\"0\"` for geoms that never touch it";
        self.report.error(Code::Excessive, self.description.at, None, message, help);
    }

    fn warn_of_field(&mut self, at: usize) {
        let message = "a height field does not stop the robot in `step`";
        let help = "use a plane, or steps on the ground with a `HeightField` of the caller";
        self.report.add(Severity::Warning, Code::NotRead, at, None, message, help);
    }

    /// Returns the pairs of `<contact>` of all models.
    fn pairs(&mut self) -> Vec<Pair> {
        let mut pairs = Vec::new();
        for (element, naming, model) in self.contacts("pair") {
            let chain = self.models[model].classes.chain(element, None);
            let item = Item { chain, frame: Pose::identity(), inherited: None, naming, model };
            let geoms = ["geom1", "geom2"]
                .map(|name| item.text(name).map(|name| item.naming.name(name)).unwrap_or_default());
            let numbers = |name: &str| item.text(name).and_then(list);
            pairs.push(Pair {
                geoms,
                components: item.number("condim").map(|n| n as usize),
                friction: numbers("friction"),
                margin: item.number("margin"),
                reference: numbers("solref"),
                impedance: numbers("solimp"),
            });
        }
        pairs
    }

    /// Returns the pairs of bodies whose geoms do not touch each other.
    fn excluded(&self) -> HashSet<[String; 2]> {
        let excluded = self.contacts("exclude").into_iter();
        let bodies = excluded.map(|(element, naming, _)| {
            ["body1", "body2"].map(|name| match element.text(name) {
                Some("world") => "world".to_owned(),
                name => naming.name(name.unwrap_or_default()),
            })
        });
        bodies.collect()
    }

    /// Returns the elements of this name in `<contact>` of all models.
    fn contacts(
        &self,
        name: &str,
    ) -> Vec<(&'e super::element::Element, std::rc::Rc<Naming>, usize)> {
        let models = self.attached.iter().flat_map(|(model, naming)| {
            let root = &self.models[*model].source.root;
            let elements = root.in_sections("contact").filter(move |child| child.name == name);
            elements.map(move |element| (element, naming.clone(), *model))
        });
        models.collect()
    }
}

/// The names of shapes so far, and how often each was wanted.
#[derive(Default)]
struct Names(HashMap<String, usize>);

impl Names {
    /// Returns a name that no shape has, `name` if it is free.
    fn unique(&mut self, name: &str) -> String {
        let mut unique = name.to_owned();
        while let Some(count) = self.0.get_mut(&unique) {
            *count += 1;
            unique = format!("{name}_{count}");
        }
        self.0.insert(unique.clone(), 1);
        unique
    }
}

/// What `<contact>` says of pairs of geoms.
struct Rules {
    pairs: Vec<Pair>,
    excluded: HashSet<[String; 2]>,
}

impl Rules {
    /// Returns the law of the contact of a geom with a ground; `None` if they do not touch.
    fn law(&self, geom: &Geom, ground: &Ground) -> Option<(ContactComponents, Contact)> {
        let ground = ground.geom;
        if let Some(pair) = self.pairs.iter().find(|pair| pair.is_of(geom, ground)) {
            return Some(pair.law([&geom.law, &ground.law]));
        }
        let bodies = [[&geom.body, &ground.body], [&ground.body, &geom.body]];
        let is_excluded =
            bodies.iter().any(|bodies| self.excluded.contains(&bodies.map(String::clone)));
        (!is_excluded && geom.law.touches(&ground.law)).then(|| geom.law.mixed(&ground.law))
    }
}

/// A pair of `<contact>`, by the names of its geoms, and its own parameters.
struct Pair {
    geoms: [String; 2],
    components: Option<usize>,
    friction: Option<Vec<f64>>,
    margin: Option<f64>,
    reference: Option<Vec<f64>>,
    impedance: Option<Vec<f64>>,
}

impl Pair {
    fn is_of(&self, a: &Geom, b: &Geom) -> bool {
        let is = |name: &str, geom: &Geom| geom.item.name().as_deref() == Some(name);
        let [first, second] = &self.geoms;
        is(first, a) && is(second, b) || is(first, b) && is(second, a)
    }

    /// Returns the law of the pair: what it does not say follows from its geoms.
    fn law(&self, [a, b]: [&Law; 2]) -> (ContactComponents, Contact) {
        let (components, mixed) = a.mixed(b);
        let most = a.contact.margin.max(b.contact.margin);
        // The five coefficients: both tangents, spin, both rolls.
        let friction = self.friction.as_ref().map_or(mixed.friction, |given| {
            let given = |k: usize, default: f64| given.get(k).copied().unwrap_or(default);
            let [sliding, spin, roll] = mixed.friction;
            [given(0, sliding), given(2, spin), given(3, roll)]
        });
        let contact = Contact {
            friction,
            margin: self.margin.unwrap_or(most),
            reference: filled(self.reference.as_deref(), mixed.reference),
            impedance: filled(self.impedance.as_deref(), mixed.impedance),
        };
        (self.components.and_then(ContactComponents::from_count).unwrap_or(components), contact)
    }
}

impl Law {
    fn of(geom: &Item, report: &mut Report<'_>) -> Self {
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
    fn touches(&self, other: &Self) -> bool {
        self.types[0] & other.types[1] != 0 || other.types[0] & self.types[1] != 0
    }

    /// Returns the law of the contact of two geoms.
    fn mixed(&self, other: &Self) -> (ContactComponents, Contact) {
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
        Self {
            friction: [friction[0], friction[2], friction[3]],
            margin,
            reference: filled(Some(&reference), REFERENCE),
            impedance: filled(Some(&impedance), IMPEDANCE),
        }
    }
}

impl Contact {
    fn surface(&self, plane: Pose<f64>, radius: f64) -> ContactSurface<f64> {
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
fn power(exponent: f64, at: usize, report: &mut Report<'_>) -> u32 {
    if exponent >= 1.0 && exponent.fract() != 0.0 {
        let message = format!("the power {exponent} of `solimp` is not read: it is rounded");
        let help = "write an integer as the fifth number of `solimp`";
        report.add(Severity::Warning, Code::NotRead, at, None, message, help);
    }
    exponent.round().clamp(1.0, 100.0) as u32
}

/// Returns the pose of a plane with the axes of `MuJoCo`'s contacts with it: the x axis is
/// the first tangent.
fn plane(ground: &Pose<f64>) -> Pose<f64> {
    let normal = Matrix3(ground.rotation).column(2);
    let near = Vector3(if normal.0[1].abs() < 0.5 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] });
    let in_plane = near - normal.scale(normal.dot(near));
    let tangent = in_plane.scale(1.0 / libm::sqrt(in_plane.dot(in_plane)));
    let axes = [tangent, normal.cross(tangent), normal];
    Pose { rotation: Matrix3::from_columns(|k| axes[k]).0, translation: ground.translation }
}

/// Returns the given numbers, and defaults for those that are missing.
fn filled<const N: usize>(given: Option<&[f64]>, defaults: [f64; N]) -> [f64; N] {
    let given = given.unwrap_or_default();
    core::array::from_fn(|k| given.get(k).copied().unwrap_or(defaults[k]))
}

/// Returns the parameters of all contacts that a model sets in its options.
pub fn overriding(settings: &dyn Fn(&str) -> Option<Vec<f64>>) -> ContactOverride {
    ContactOverride {
        friction: filled(settings("o_friction").as_deref(), [1.0, 1.0, 0.005, 0.0001, 0.0001]),
        margin: settings("o_margin").and_then(|margin| margin.first().copied()).unwrap_or(0.0),
        reference: filled(settings("o_solref").as_deref(), REFERENCE),
        impedance: filled(settings("o_solimp").as_deref(), IMPEDANCE),
    }
}
