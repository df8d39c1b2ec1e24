//! From bodies with any number of joints to links with one joint each, as in a URDF.

use std::collections::BTreeMap;
use std::rc::Rc;

use modyn_runtime::conventions::{quaternion_from_rotation, rotation_from_quaternion};
use modyn_runtime::model::{Actuation, Inertial, SoftCoupling, SoftTendon};
use modyn_runtime::spatial::Pose;

use super::contact_law::{self, Carrier};
use super::element::{Element, MAX_DEPTH};
use super::geoms;
use super::ignored::Ignored;
use super::inertia;
use super::item::{Item, Naming};
use super::joints::{self, References, is_free};
use super::mesh::Meshes;
use super::models::{Model, Source};
use super::pose::euler;
use crate::description::{
    Description, InertialRecord, JointRecord, Kind, LinkRecord, Located, ReadOptions, TakenNames,
};
use crate::diagnostics::{Code, Report, Severity};
use crate::work::counted;

/// The largest number of bodies, joints, geoms and sites, and of the characters of their names in
/// tens: models and replicas in each other have exponentially many.
const MAX_ITEMS: usize = 1_000_000;

/// The description so far.
pub struct Bodies<'e, 'r, 'f> {
    pub models: Vec<Model<'e>>,
    pub meshes: Meshes<'e>,
    /// Whether shapes are read.
    has_shapes: bool,
    pub description: Description,
    /// For each link, the moving link that carries it, which may be itself; 0 is the world.
    pub carriers: Vec<usize>,
    /// The link of each body, and the pose in which it is drawn, in the world.
    pub places: BTreeMap<String, (usize, Pose<f64>)>,
    /// The link and the pose on the link of each site.
    pub sites: BTreeMap<String, (usize, Pose<f64>, usize)>,
    /// For each joint of the description, its coordinates in the pose in which the model is drawn
    /// and where a spring is at rest.
    pub references: Vec<References>,
    /// For each joint of the description that a constraint holds, by its index, its coordinate.
    pub held: BTreeMap<usize, f64>,
    /// For each free joint of the description, by its index, its coordinates in the pose in which
    /// the model is drawn.
    pub free_poses: BTreeMap<usize, [f64; 7]>,
    /// For joints of the description, by their index, the time constant, s, and the damping ratio
    /// of `springdamper`.
    pub spring_dampers: Vec<(usize, [f64; 2])>,
    /// The models and their names in the whole model: the main model first, then each that was
    /// attached.
    pub attached: Vec<(usize, Rc<Naming>)>,
    /// The geoms that can touch others.
    pub geoms: Vec<contact_law::Geom<'e>>,
    /// The tendons that act in steps, with joints of the description in place of links.
    pub tendons: Vec<SoftTendon>,
    /// The couplings that act in steps, with joints of the description in place of links.
    pub couplings: Vec<SoftCoupling>,
    /// What does not act in steps, or in steps only.
    pub ignored: Ignored,
    /// Whether pairs of geoms are named, which touch each other in any case.
    pub has_pairs: bool,
    /// The models in which the present element is.
    open: Vec<usize>,
    /// The number of elements so far.
    items: usize,
    pub report: &'r mut Report<'f>,
}

/// The elements of a body, in the order of the text; frames are resolved.
#[derive(Default)]
struct Parts<'e> {
    inertials: Vec<Item<'e>>,
    joints: Vec<Item<'e>>,
    geoms: Vec<Item<'e>>,
    sites: Vec<Item<'e>>,
    bodies: Vec<Item<'e>>,
    /// The models to attach that `bodies` come from.
    sound: bool,
}

/// The place of a body's frame.
#[derive(Clone, Copy)]
struct Parent {
    link: usize,
    /// Its pose in the world in the drawn pose.
    drawn: Pose<f64>,
    depth: usize,
}

impl<'e, 'r, 'f> Bodies<'e, 'r, 'f> {
    /// Returns the bodies and sites of the first of these models, with all models that it attaches.
    /// Names that the file lacks are generated.
    pub fn read(sources: &'e [Source], options: &ReadOptions, report: &'r mut Report<'f>) -> Self {
        let mut models: Vec<Model<'e>> =
            sources.iter().map(|source| Model::new(source, report)).collect();
        // The options of an attached model do not count.
        let flags = models[0].settings.flags;
        models.iter_mut().for_each(|model| model.settings.flags = flags);
        let root = &sources[0].root;
        let named = root.text("model").filter(|name| !name.trim().is_empty());
        if named.is_none() {
            let message = "the model has no name";
            let help = "write `<mujoco model=\"...\">`; it is called `robot` here";
            report.add(Severity::Warning, Code::MissingAttribute, root.at, None, message, help);
        }
        let description = Description {
            name: named.unwrap_or("robot").into(),
            at: root.at,
            gravity: Some(models[0].settings.gravity),
            links: Vec::new(),
            joints: Vec::new(),
            compensated: Vec::new(),
            loops: Vec::new(),
            contacts: Vec::new(),
            keyframes: Vec::new(),
            actuation: Actuation::default(),
            shape_notes: Vec::new(),
            soft: None,
            softnesses: Vec::new(),
            loop_softnesses: Vec::new(),
        };
        let naming = Rc::new(Naming::default());
        let mut bodies = Self {
            models,
            meshes: Meshes::default(),
            description,
            carriers: Vec::new(),
            places: BTreeMap::new(),
            sites: BTreeMap::new(),
            references: Vec::new(),
            tendons: Vec::new(),
            couplings: Vec::new(),
            has_shapes: options.shapes,
            held: BTreeMap::new(),
            free_poses: BTreeMap::new(),
            spring_dampers: Vec::new(),
            attached: vec![(0, naming.clone())],
            geoms: Vec::new(),
            ignored: Ignored::default(),
            has_pairs: sources
                .iter()
                .any(|source| source.root.in_sections("contact").any(|child| child.name == "pair")),
            open: vec![0],
            items: 0,
            report,
        };
        bodies.link("world".into(), root.at, 0);
        bodies.places.insert("world".into(), (0, Pose::identity()));
        let mut parts = Parts { sound: true, ..Parts::default() };
        for world in root.named("worldbody") {
            let item = Item {
                chain: vec![world],
                frame: Pose::identity(),
                inherited: None,
                naming: naming.clone(),
                model: 0,
            };
            bodies.collect(&item, 0, &mut parts);
        }
        if let Some(joint) = parts.joints.first().or(parts.inertials.first()) {
            let message = format!("`<{}>` in `<worldbody>` is not read", joint.element().name);
            let help = "write it in a `<body>`";
            bodies.report.error(Code::NotRead, joint.element().at, None, message, help);
        }
        let world = Parent { link: 0, drawn: Pose::identity(), depth: 0 };
        bodies.sites(&parts.sites, 0);
        bodies.shapes(&parts.geoms, 0, "world");
        let drawn = Pose::identity();
        let body = "world".to_owned();
        bodies.touching(&parts.geoms, &Carrier { body, link: 0, moves: false, drawn });
        for body in parts.bodies {
            bodies.body(body, world);
        }
        bodies.add_sites();
        bodies.scale_to_total_mass();
        bodies
    }

    /// Adds the elements in `container` to the parts of its body.
    fn collect(&mut self, container: &Item<'e>, depth: usize, parts: &mut Parts<'e>) {
        let element = container.element();
        if depth > MAX_DEPTH {
            let message = format!("elements are nested more than {MAX_DEPTH} deep");
            self.report.error(
                Code::NotRead,
                element.at,
                None,
                message,
                "attach fewer models in each other",
            );
            return;
        }
        let inherited = element.text("childclass").or(container.inherited);
        self.check_class(element.attribute("childclass"), container.model);
        parts.sound &= self.models[container.model].is_sound(&[element]);
        for child in counted(element.children.iter()) {
            let Naming { prefix, suffix } = &*container.naming;
            let name = prefix.len() + child.text("name").map_or(0, str::len) + suffix.len();
            if !self.count(1 + name / 10, child.at) {
                return;
            }
            let model = container.model;
            let is_body = matches!(
                child.name.as_str(),
                "body" | "frame" | "replicate" | "attach" | "freejoint"
            );
            self.check_class(child.attribute("class"), model);
            let classes = &self.models[model].classes;
            let chain = if is_body { vec![child] } else { classes.chain(child, inherited) };
            let inherited = if is_body { child.text("class").or(inherited) } else { inherited };
            let frame = container.frame;
            let naming = container.naming.clone();
            let item = Item { chain, frame, inherited, naming, model };
            match child.name.as_str() {
                "inertial" => parts.inertials.push(item),
                "joint" | "freejoint" => parts.joints.push(item),
                "geom" => parts.geoms.push(item),
                "site" => parts.sites.push(item),
                "body" => parts.bodies.push(item),
                "frame" => {
                    let frame = item.pose(&self.models[model].settings, self.report);
                    self.collect(&Item { frame, ..item }, depth + 1, parts);
                }
                "replicate" => self.replicate(&item, depth, parts),
                "attach" => self.attach(&item, depth, parts),
                _ => {}
            }
        }
    }

    /// Counts elements and names. Returns whether they may be read; otherwise an error is in the
    /// report.
    fn count(&mut self, items: usize, at: usize) -> bool {
        let is_first = self.items <= MAX_ITEMS;
        self.items += items;
        let is_excess = self.items > MAX_ITEMS;
        if is_excess && is_first {
            let message = format!(
                "there are more than {MAX_ITEMS} bodies, joints, geoms and sites, or tens of \
                 characters in their names"
            );
            let help = "attach and replicate fewer elements, and give them short names";
            self.report.error(Code::Excessive, at, None, message, help);
        }
        !is_excess
    }

    /// Reports a class that the model does not have.
    fn check_class(&mut self, class: Option<&super::element::Attribute>, model: usize) {
        if let Some(class) = class
            && !self.models[model].classes.contains(&class.value)
        {
            let message = format!("the class `{}` does not exist", class.value);
            let help = "write the class of a `<default>` of this file";
            self.report.error(Code::NotRead, class.at, None, message, help);
        }
    }

    /// Adds copies of the elements in `<replicate>`, each displaced from the one before.
    fn replicate(&mut self, item: &Item<'e>, depth: usize, parts: &mut Parts<'e>) {
        let count = item.number("count").unwrap_or(0.0);
        let offset = item.numbers("offset").unwrap_or([0.0; 3]);
        let angles = item.numbers("euler").unwrap_or([0.0; 3]);
        let digits = format!("{count}").len();
        let mut position = [0.0; 3];
        for i in 0..count.clamp(0.0, MAX_ITEMS as f64) as usize {
            if !self.count(1, item.element().at) {
                return;
            }
            let rotation =
                euler(angles.map(|angle| i as f64 * angle), &self.models[item.model].settings);
            let step = Pose { rotation, translation: position };
            position = step.transform_point(offset);
            let separator = item.text("sep").unwrap_or("");
            let Naming { prefix, suffix } = &*item.naming;
            let naming = Naming {
                prefix: prefix.clone(),
                suffix: format!("{separator}{i:0digits$}{suffix}"),
            };
            let copy =
                Item { frame: item.frame.compose(&step), naming: Rc::new(naming), ..item.clone() };
            self.collect(&copy, depth + 1, parts);
        }
    }

    /// Adds the elements of another model, or a part of this model again.
    fn attach(&mut self, item: &Item<'e>, depth: usize, parts: &mut Parts<'e>) {
        let element = item.element();
        let mut refuse = |message: String, help: &str| {
            self.report.error(Code::NotRead, element.at, None, message, help);
        };
        let index = match element.text("model") {
            None => Some(item.model),
            Some(name) => self.models[item.model].attached(name),
        };
        let Some(index) = index else {
            let message = format!(
                "the model `{}` is not in `<asset>`",
                element.text("model").unwrap_or_default()
            );
            return refuse(message, "write `<asset><model name=\"...\" file=\"...\"/></asset>`");
        };
        if element.text("model").is_some() && self.open.contains(&index) {
            let message = "a model is attached to itself".into();
            return refuse(message, "attach a model that does not contain this one");
        }
        let prefix =
            format!("{}{}", item.naming.prefix, element.text("prefix").unwrap_or_default());
        let naming = Rc::new(Naming { prefix, suffix: item.naming.suffix.clone() });
        let root = &self.models[index].source.root;
        let part = ["body", "frame"].iter().find_map(|kind| Some((*kind, element.text(kind)?)));
        let of_model = |element, inherited| Item {
            chain: vec![element],
            frame: item.frame,
            inherited,
            naming: naming.clone(),
            model: index,
        };
        self.attached.push((index, naming.clone()));
        self.open.push(index);
        match part {
            None => {
                for world in root.named("worldbody") {
                    self.collect(&of_model(world, None), depth + 1, parts);
                }
            }
            Some((kind, name)) => {
                let place = root.named("worldbody").find_map(|world| find(world, kind, name, None));
                match place {
                    Some((body, inherited)) if kind == "body" => {
                        parts.bodies.push(of_model(body, inherited))
                    }
                    Some((frame, inherited)) => {
                        let item = of_model(frame, inherited);
                        let frame = item.pose(&self.models[index].settings, self.report);
                        self.collect(&Item { frame, ..item }, depth + 1, parts);
                    }
                    None => {
                        let message = format!("the {kind} `{name}` is not in the model");
                        let help = "write the name of a part of the attached model";
                        self.report.error(Code::NotRead, element.at, None, message, help);
                    }
                }
            }
        }
        self.open.pop();
    }

    /// Adds a body with its joints and everything in it.
    fn body(&mut self, item: Item<'e>, parent: Parent) {
        let element = item.element();
        let at = element.at;
        if parent.depth > MAX_DEPTH {
            let message = format!("bodies are nested more than {MAX_DEPTH} deep");
            self.report.error(
                Code::NotRead,
                at,
                None,
                message,
                "attach fewer models in each other",
            );
            return;
        }
        let pose = item.pose(&self.models[item.model].settings, self.report);
        let name = item.name().unwrap_or_else(|| format!("body_{}", self.places.len()));
        let mut parts = Parts { sound: true, ..Parts::default() };
        let inside = Item { frame: Pose::identity(), ..item.clone() };
        self.collect(&inside, 0, &mut parts);
        let mut above = parent.link;
        // The pose of the body's frame in the link that was added last.
        let mut frame = pose;
        let first_joint = self.description.joints.len();
        for (k, joint) in parts.joints.iter().enumerate() {
            let place = joint.element().at;
            let joint_name = joint.name().unwrap_or_else(|| match k {
                0 => format!("{name}_joint"),
                _ => format!("{name}_joint_{}", k + 1),
            });
            let model = &self.models[joint.model];
            let (made, references) = joints::joint(joint, &joint_name, &pose, model, self.report);
            if is_free(joint) {
                let alone = parent.link == 0 && parts.joints.len() == 1;
                joints::check_free(
                    joint,
                    &joint_name,
                    alone,
                    parts.bodies.is_empty(),
                    model,
                    self.report,
                );
            }
            let at_joint = |position: [f64; 3]| joint.frame.transform_point(position);
            let anchor = if is_free(joint) {
                [0.0; 3]
            } else {
                at_joint(joint.numbers("pos").unwrap_or([0.0; 3]))
            };
            let origin = if is_free(joint) {
                Pose::identity()
            } else {
                frame.compose(&translation(anchor)).compose(&joints::displacement(
                    made.kind,
                    made.axis,
                    -references.drawn,
                ))
            };
            let last = k + 1 == parts.joints.len() && anchor == [0.0; 3];
            let link = if last { name.clone() } else { format!("{name}_behind_{joint_name}") };
            let child = self.link(link, place, self.carriers.len());
            self.description.links[child].auxiliary = !last;
            if let Some(softness) = contact_law::joint_softness(joint, &mut self.ignored.powers) {
                self.description.softnesses.push((self.description.joints.len(), softness));
            }
            if let Some(numbers) = joints::spring_damper(joint) {
                self.spring_dampers.push((self.description.joints.len(), numbers));
            }
            self.push(JointRecord { origin, ..made }, references, above, child);
            above = child;
            frame = translation(anchor.map(|x| -x));
        }
        // A body without joints, or whose frame is not at its last joint, is fixed to the last
        // link.
        if parts.joints.is_empty() || self.description.links[above].name.text != name {
            let child = self.link(name.clone(), at, self.carriers[above]);
            let fixed = JointRecord { origin: frame, ..joints::fixed(format!("{name}_fixed"), at) };
            self.push(fixed, References::default(), above, child);
            above = child;
        }
        let drawn = parent.drawn.compose(&pose);
        self.places.entry(name.clone()).or_insert((above, drawn));
        let moves = self.carriers[above] != 0;
        let is_compensated = moves && self.models[0].settings.flags.is_passive();
        let factor = item.number("gravcomp").filter(|factor| *factor != 0.0);
        if let Some(factor) = factor.filter(|_| is_compensated) {
            self.description.compensated.push((above, factor));
        }
        let inertial = self.inertial(&item, &name, &parts, moves);
        self.description.links[above].inertial = inertial;
        if parts.joints.iter().any(is_free) && parts.joints.len() == 1 {
            // The pose of a floating body is its coordinates.
            self.references[first_joint] = References::default();
            let [x, y, z] = drawn.translation;
            let [a, b, c, d] = quaternion_from_rotation(drawn.rotation);
            self.free_poses.insert(first_joint, [x, y, z, a, b, c, d]);
        }
        self.sites(&parts.sites, above);
        self.shapes(&parts.geoms, above, &name);
        let carrier = Carrier { body: name, link: above, moves, drawn };
        self.touching(&parts.geoms, &carrier);
        let parent = Parent { link: above, drawn, depth: parent.depth + 1 };
        for body in parts.bodies {
            self.body(body, parent);
        }
    }

    /// Fixes free bodies where they are drawn.
    pub fn fix_base(&mut self) {
        let mut carriers: Vec<usize> = (0..self.carriers.len()).collect();
        for (&joint, &[x, y, z, a, b, c, d]) in &self.free_poses {
            let rotation = rotation_from_quaternion([a, b, c, d]);
            let record = &mut self.description.joints[joint];
            record.origin = Pose { rotation, translation: [x, y, z] };
            record.kind = Kind::Fixed;
            // The first link is the world; each of the others has a joint.
            carriers[joint + 1] = 0;
        }
        self.carriers.iter_mut().for_each(|carrier| *carrier = carriers[*carrier]);
    }

    fn link(&mut self, name: String, at: usize, carrier: usize) -> usize {
        let name = Located { text: name, at };
        self.description.links.push(LinkRecord::new(name, None));
        self.carriers.push(carrier);
        self.carriers.len() - 1
    }

    /// Adds a joint between two links.
    fn push(&mut self, joint: JointRecord, references: References, parent: usize, child: usize) {
        let name = |link: usize| Some(self.description.links[link].name.clone());
        let parent = name(parent);
        let child = name(child);
        self.description.joints.push(JointRecord { parent, child, ..joint });
        self.references.push(references);
    }

    /// Keeps the named sites of a link, which become frames after all bodies have their names.
    fn sites(&mut self, sites: &[Item<'e>], link: usize) {
        for site in sites {
            let Some(name) = site.name() else { continue };
            let described = site.pose(&self.models[site.model].settings, self.report);
            let pose = match site.numbers("fromto").and_then(geoms::between) {
                Some((between, _)) => site.frame.compose(&between),
                None => described,
            };
            self.sites.entry(name).or_insert((link, pose, site.element().at));
        }
    }

    /// Adds the shapes of a link's geoms, if they are asked for.
    fn shapes(&mut self, geoms: &[Item<'e>], link: usize, body: &str) {
        if !self.has_shapes {
            return;
        }
        for geom in geoms {
            let model = &self.models[geom.model];
            match geoms::shape(geom, model, &mut self.meshes, self.report) {
                Ok(shape) => self.description.links[link].shapes.extend(shape),
                Err(why) => {
                    let note = format!("a geom of the body `{body}` is not drawn: {why}");
                    self.description.shape_notes.push(note);
                }
            }
        }
    }

    /// Adds a link without inertia for each site.
    fn add_sites(&mut self) {
        let mut taken = TakenNames::new(self.description.link_names());
        let mut sites: Vec<_> =
            self.sites.iter().map(|(name, site)| (name.clone(), *site)).collect();
        sites.sort_by_key(|(_, (link, _, at))| (*at, *link));
        for (name, (link, origin, at)) in sites {
            let name = taken.unique(&name, "site");
            let child = self.link(name.clone(), at, self.carriers[link]);
            let fixed = JointRecord { origin, ..joints::fixed(format!("{name}_fixed"), at) };
            self.push(fixed, References::default(), link, child);
        }
    }

    /// Returns the inertia of a body in its frame.
    fn inertial(
        &mut self,
        item: &Item<'e>,
        name: &str,
        parts: &Parts<'e>,
        moves: bool,
    ) -> Option<InertialRecord> {
        // Bodies that are fixed to the world have no effect on the dynamics, except by the total
        // mass.
        if !moves && self.models[0].settings.total_mass.is_none() {
            return None;
        }
        let model = &self.models[item.model];
        let settings = &model.settings;
        let first = parts.inertials.first();
        let at = first.map_or(item.element().at, |inertial| inertial.element().at);
        if let Some(second) = parts.inertials.get(1) {
            let message = "a second `<inertial>` in one body";
            self.report.error(
                Code::RepeatedElement,
                second.element().at,
                None,
                message,
                "keep one of them",
            );
        }
        let heavy: Vec<&Item> = parts
            .geoms
            .iter()
            .filter(|geom| geoms::has_mass(geom, &self.models[geom.model]))
            .collect();
        let is_explicit =
            first.is_some() && (settings.inertia_from_geom != Some(true) || heavy.is_empty());
        let mut sound = parts.sound;
        let record = |inertial, sound| Some(InertialRecord { inertial, at, mass_at: at, sound });
        let inertial = match first.filter(|_| is_explicit) {
            Some(inertial) => {
                sound &= model.is_sound(&inertial.chain);
                inertia::explicit(inertial, name, model, self.report).map(Some).unwrap_or_else(
                    || {
                        sound = false;
                        Some(Inertial::default())
                    },
                )
            }
            None if heavy.is_empty() || settings.inertia_from_geom == Some(false) => None,
            None => {
                let mut whole = Inertial::default();
                for geom in heavy {
                    let model = &self.models[geom.model];
                    if !model.is_sound(&geom.chain) {
                        sound = false;
                        continue;
                    }
                    match geoms::inertial(geom, model, &mut self.meshes, self.report) {
                        Ok(inertial) => whole = whole.merged(&inertial),
                        Err(why) => {
                            inertia::report_missing(name, at, &why, self.report);
                            sound = false;
                            break;
                        }
                    }
                }
                Some(whole)
            }
        };
        if !sound {
            return record(inertial.unwrap_or_default(), false);
        }
        let inertial = inertia::bounded(inertial, settings);
        inertial.and_then(|inertial| record(inertial, true))
    }

    /// Scales all masses and inertias, if the model has a total mass.
    fn scale_to_total_mass(&mut self) {
        let Some(total) = self.models[0].settings.total_mass else { return };
        let mut records: Vec<_> =
            self.description.links.iter_mut().filter_map(|link| link.inertial.as_mut()).collect();
        let sum: f64 = records.iter().map(|record| record.inertial.mass).sum();
        if sum > 0.0 {
            for record in &mut records {
                record.inertial.mass *= total / sum;
                record.inertial.inertia =
                    record.inertial.inertia.map(|moment| moment * total / sum);
            }
        }
    }
}

/// Returns the element of this kind and name in `element`, and the class that it inherits.
fn find<'e>(
    element: &'e Element,
    kind: &str,
    name: &str,
    inherited: Option<&'e str>,
) -> Option<(&'e Element, Option<&'e str>)> {
    let inherited = element.text("childclass").or(inherited);
    counted(element.children.iter()).find_map(|child| {
        if child.name == kind && child.text("name") == Some(name) {
            return Some((child, inherited));
        }
        let is_container = ["body", "frame", "replicate"].contains(&child.name.as_str());
        if is_container { find(child, kind, name, inherited) } else { None }
    })
}

fn translation(translation: [f64; 3]) -> Pose<f64> {
    Pose { translation, ..Pose::identity() }
}
