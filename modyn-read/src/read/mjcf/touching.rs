//! The shapes of bodies that touch planes of the world.

use std::collections::{HashMap, HashSet};

use modyn_runtime::model::{ContactComponents, LoopConstraintEnd, SoftConstraints, TouchingShape};
use modyn_runtime::spatial::{Matrix3, Pose, Vector3};

use super::bodies::Bodies;
use super::check::{filled, list};
use super::contact_law::{Contact, Geom, Law, Place, power};
use super::geoms::{self, Touching};
use super::item::{Item, Naming};
use crate::diagnostics::{Code, Severity};

/// The largest number of shapes that touch the ground.
const MAX_SHAPES: usize = 1_000;

/// A plane or a height field of the world.
struct Ground<'a, 'e> {
    geom: &'a Geom<'e>,
    is_field: bool,
    /// The pose of a plane, with the axes of `MuJoCo`'s contacts.
    pose: Pose<f64>,
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
