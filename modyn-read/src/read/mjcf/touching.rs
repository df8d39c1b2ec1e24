//! The shapes of bodies that touch planes of the world.

use std::collections::HashSet;

use modyn_runtime::model::{
    Integrator, JointReference, LoopConstraintEnd, SoftConstraints, TouchingShape,
};
use modyn_runtime::spatial::{Matrix3, Pose};

use super::bodies::Bodies;
use super::check::list;
use super::contact_law::{Carrier, Contact, Geom, Law, Pair, is_anisotropic, power};
use super::element::Attribute;
use super::geoms;
use super::item::Item;
use super::settings::Settings;
use crate::description::{self, ReadOptions, TakenNames, contact_plane};
use crate::diagnostics::{Code, Place};
use crate::read::collision::{MAX_SHAPES, Touching};

/// Returns the integrator of steps that is next to the integrator of `MuJoCo`.
fn integrator(settings: &Settings<'_>) -> Integrator {
    match settings.integrator.map(|attribute| attribute.value.as_str()) {
        Some("implicitfast" | "implicit") => Integrator::ImplicitFast,
        _ if settings.implicit_euler => Integrator::Euler,
        _ => Integrator::ExplicitEuler,
    }
}

/// A plane or a height field of the world.
struct Ground<'a, 'e> {
    /// The geom; `None` for the plane of the options.
    geom: Option<&'a Geom<'e>>,
    is_field: bool,
    /// The coefficient of friction that replaces the friction of the geoms.
    friction: Option<f64>,
    /// The pose of a plane, with the axes of `MuJoCo`'s contacts.
    pose: Pose<f64>,
}

/// The name of the body that does not move.
const WORLD: &str = "world";

impl Ground<'_, '_> {
    /// Returns the plane of the options.
    fn of_option(ground: &description::Ground) -> Self {
        let pose = ground.surface().plane;
        Self { geom: None, is_field: false, friction: ground.friction, pose }
    }
}

impl<'e> Bodies<'e, '_, '_> {
    /// Keeps the geoms of a body that can touch other geoms.
    pub fn touching(&mut self, geoms: &[Item<'e>], carrier: &Carrier) {
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
            if touches && carrier.moves != is_ground {
                self.geoms.push(Geom { item: item.clone(), carrier: carrier.clone(), law });
            }
        }
    }

    /// Adds the shapes that touch planes to the description, and warns of what else acts in
    /// `MuJoCo`'s steps.
    pub fn soft_constraints(&mut self, options: &ReadOptions) {
        let settings = &self.models[0].settings;
        let mut soft = SoftConstraints {
            cone: settings.cone,
            integrator: integrator(settings),
            time_step: Some(settings.time_step),
            impratio: settings.impratio,
            joint_limits: settings.limits,
            joint_friction: true,
            ..SoftConstraints::default()
        };
        if let Some(Attribute { value, at, .. }) = settings.integrator {
            self.ignored.integrator(value, (Some(*at), None));
        }
        let geoms = std::mem::take(&mut self.geoms);
        // Contacts of the options replace the shapes.
        let given = options.ground.filter(|_| options.contacts.is_empty());
        let mut grounds: Vec<Ground> = given.iter().map(Ground::of_option).collect();
        for geom in geoms.iter().filter(|geom| !geom.carrier.moves) {
            let pose = geom.item.pose(&self.models[geom.item.model].settings, self.report);
            let is_field = geom.item.text("type") == Some("hfield");
            let drawn = geom.carrier.drawn.compose(&pose);
            let normal = Matrix3(drawn.rotation).column(2);
            let pose = contact_plane(drawn.translation, normal.0);
            grounds.push(Ground { geom: Some(geom), is_field, friction: None, pose });
        }
        if settings.overriding.is_some_and(|given| is_anisotropic(&given.friction)) {
            self.ignored.anisotropic.push((None, None));
        }
        let rules = self.rules();
        let mut planes = Vec::new();
        let mut names = TakenNames::default();
        for geom in geoms.iter().filter(|geom| geom.carrier.moves) {
            for ground in &grounds {
                let Some(contact) = rules.contact(geom, ground) else { continue };
                if let Some(field) = ground.geom.filter(|_| ground.is_field) {
                    self.ignored.fields.push(place(&field.item));
                    continue;
                }
                planes.extend(ground.geom.map(|plane| place(&plane.item)));
                let shape = self.shape(geom, contact, ground);
                soft.shapes.extend(shape.map(|shape| {
                    let name = match geom.item.name() {
                        Some(name) => names.unique(&name, "shape"),
                        None => names.numbered(&format!("{}_geom", geom.carrier.body), 1),
                    };
                    TouchingShape { name, ..shape }
                }));
                if soft.shapes.len() > MAX_SHAPES {
                    let message = format!("more than {MAX_SHAPES} shapes touch the ground");
                    let help =
                        "write `contype=\"0\" conaffinity=\"0\"` for geoms that never touch it";
                    let at = self.description.at;
                    self.report.error(Code::Excessive, at, None, message, help);
                    return;
                }
            }
        }
        if let (Some(_), Some((at, _))) = (given, planes.first()) {
            let message =
                "the option `ground` adds a plane, and the file has one that the robot touches";
            let help = "leave the option out, or remove the plane from the file";
            self.report.error(Code::Option, *at, None, message, help);
        }
        let references = self.references.iter().enumerate();
        soft.references = references
            .filter(|(_, reference)| reference.drawn != 0.0)
            .map(|(joint, reference)| JointReference { joint, coordinate: reference.drawn })
            .collect();
        let limits = if soft.joint_limits { self.of_section("tendon") } else { Vec::new() };
        let spatial = limits.iter().filter(|item| item.element().name != "fixed");
        self.ignored.tendons = spatial.filter(|item| self.is_limited(item)).map(place).collect();
        soft.tendons = std::mem::take(&mut self.tendons);
        soft.couplings = std::mem::take(&mut self.couplings);
        for option in &self.models[0].settings.ignored {
            let places = self.ignored.options.entry(option.name.clone()).or_default();
            places.push((Some(option.at), None));
        }
        std::mem::take(&mut self.ignored).report(self.report);
        self.description.soft = Some(soft);
    }

    /// Returns whether a tendon has a range that limits it.
    fn is_limited(&self, tendon: &Item<'e>) -> bool {
        super::joints::is_limited(tendon, "limited", "range", &self.models[tendon.model])
    }

    /// Returns a shape without a name that touches a plane; `None` if its contacts are not computed.
    fn shape(
        &mut self,
        geom: &Geom<'e>,
        contact: Contact,
        ground: &Ground<'_, 'e>,
    ) -> Option<TouchingShape> {
        let item = &geom.item;
        let model = &self.models[item.model];
        let touching = geoms::touching(item, model, &mut self.meshes, self.report);
        let (pose, Touching { shape, radius }) = match touching {
            Ok(touching) => touching,
            Err(why) => {
                self.ignored.untouched.entry(why).or_default().push(place(item));
                return None;
            }
        };
        let is_set = |item: &&Item| ["adhesion", "surfacevel"].iter().any(|name| item.sets(name));
        let unread = std::iter::once(item).chain(ground.geom.map(|geom| &geom.item)).filter(is_set);
        self.ignored.parameters.extend(unread.map(place));
        let overriding = self.models[0].settings.overriding;
        let replaced = overriding.map_or(contact, |overriding| overriding.replaced(contact));
        let contact = replaced.with_friction(ground.friction);
        Some(TouchingShape {
            name: String::new(),
            end: LoopConstraintEnd { link: geom.carrier.link, pose },
            shape,
            components: contact.components,
            surface: contact.surface(ground.pose, radius),
            power: power(contact.impedance[4], item.element().at, &mut self.ignored.powers),
        })
    }

    /// Returns what `<contact>` of all models says.
    fn rules(&mut self) -> Rules {
        let mut rules = Rules::default();
        for item in self.of_section("contact") {
            if !self.models[item.model].is_sound(&item.chain) {
                continue;
            }
            if item.element().name == "pair" {
                if ["adhesion", "solreffriction"].iter().any(|name| item.sets(name)) {
                    self.ignored.parameters.push(place(&item));
                }
                if item.text("friction").and_then(list).is_some_and(|all| is_anisotropic(&all)) {
                    self.ignored.anisotropic.push(place(&item));
                }
                rules.pairs.push(Pair::of(&item, self.report));
            } else {
                let body = |attribute: &str| match item.text(attribute) {
                    Some(WORLD) => WORLD.to_owned(),
                    name => item.naming.name(name.unwrap_or_default()),
                };
                rules.excluded.insert(["body1", "body2"].map(body));
            }
        }
        rules
    }
}

/// Returns the place of an item.
fn place(item: &Item) -> Place {
    (Some(item.element().at), None)
}

/// What `<contact>` says of pairs of geoms and of bodies.
#[derive(Default)]
struct Rules {
    pairs: Vec<Pair>,
    excluded: HashSet<[String; 2]>,
}

impl Rules {
    /// Returns the contact of a geom with a ground; `None` if they do not touch.
    fn contact(&self, geom: &Geom, ground: &Ground) -> Option<Contact> {
        if let Some(plane) = ground.geom {
            return self.contact_of_geoms(geom, plane);
        }
        let law = Law::default();
        let bodies = [geom.carrier.body.clone(), WORLD.to_owned()];
        let is_excluded = self.excludes(bodies);
        (!is_excluded && geom.law.touches(&law)).then(|| geom.law.mixed(&law))
    }

    /// Returns whether two bodies do not touch each other.
    fn excludes(&self, [first, second]: [String; 2]) -> bool {
        let reversed = [second.clone(), first.clone()];
        self.excluded.contains(&[first, second]) || self.excluded.contains(&reversed)
    }

    /// Returns the contact of two geoms; `None` if they do not touch.
    fn contact_of_geoms(&self, a: &Geom, b: &Geom) -> Option<Contact> {
        if let Some(pair) = self.pairs.iter().find(|pair| pair.is_of(a, b)) {
            return Some(pair.contact);
        }
        let is_excluded = self.excludes([a, b].map(|geom| geom.carrier.body.clone()));
        (!is_excluded && a.law.touches(&b.law)).then(|| a.law.mixed(&b.law))
    }
}
