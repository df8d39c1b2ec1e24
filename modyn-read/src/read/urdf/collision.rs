//! Reads the `<collision>`s of links, whose shapes touch the ground.

use modyn_runtime::ContactSurface;
use roxmltree::Node;
use rustc_hash::FxHashMap;

use super::reader::Reader;
use crate::description::{Description, Geometry};
use crate::diagnostics::{Code, Place, Subject};
use crate::read::collision::{Collision, Collisions, moving_links, touching_solid};
use crate::read::xml::element::{attribute, children, is, written};

/// The coefficients of friction of a link along the two tangents of Gazebo's contacts, and their
/// place.
#[derive(Default)]
struct LinkFriction {
    coefficients: [Option<f64>; 2],
    at: usize,
}

/// The elements of `<gazebo>` with the coefficients of friction along the two tangents.
const COEFFICIENTS: [&str; 2] = ["mu1", "mu2"];

/// Gazebo's coefficient of friction of a link that has none.
const FRICTION: f64 = 1.0;

impl<'a> Reader<'a, '_, '_, '_> {
    /// Adds the shapes that touch the ground of the options, if there is one and no contacts replace
    /// the shapes.
    pub fn collisions(&mut self, robot: Node<'a, '_>, description: &mut Description) {
        let Some(ground) = self.options.ground else { return };
        if !(self.options.contacts.is_empty() && description.contacts.is_empty()) {
            return;
        }
        let mut frictions = self.frictions(robot);
        let mut indices = FxHashMap::default();
        for (link, name) in description.link_names().enumerate() {
            indices.entry(name.to_owned()).or_insert(link);
        }
        let moves = moving_links(description, self.options.base);
        let mut collisions = Collisions::default();
        for node in children(robot).filter(|node| is(*node, "link")) {
            let Some(name) = attribute(node, "name") else { continue };
            let Some(&link) = indices.get(name.text).filter(|link| moves[**link]) else { continue };
            let subject = Subject::Link(name.text.into());
            let described = frictions.remove(name.text);
            let of_gazebo = described.map(|friction| self.friction(&friction, &subject));
            let of_link = of_gazebo.or_else(|| self.lateral_friction(node, &subject));
            let default = ground.surface();
            for part in children(node).filter(|part| is(*part, "collision")) {
                if collisions.are_too_many() {
                    break;
                }
                let Some(collision) = self.collision(part, &subject) else { continue };
                let of_shape = self.dynamic_friction(part, &subject);
                let described = of_shape.or(of_link).unwrap_or(default.friction);
                let friction = ground.friction.unwrap_or(described);
                let surface = ContactSurface { friction, ..default };
                collisions.add(link, name.text, collision, &[surface]);
            }
        }
        self.xml.report.warn_once(
            Code::NotRead,
            &self.anisotropic,
            "contacts have in `step` the friction `<mu1>` in all directions",
            "write the same number in `<mu1>` and `<mu2>`",
        );
        description.soft = Some(collisions.soft_constraints(self.xml.report));
    }

    /// Returns a `<collision>`; `None` with an error in the report.
    fn collision(&mut self, node: Node<'a, '_>, subject: &Subject) -> Option<Collision> {
        let pose = self.origin(node, Some(subject));
        let example = "<geometry><box size=\"0.1 0.2 0.3\"/></geometry>";
        let element = self.xml.required(node, "geometry", example, Some(subject))?;
        let geometry = match children(element).find(Node::is_element) {
            Some(shape) => self.touching_geometry(shape, subject).transpose()?,
            None => Err("its `<geometry>` is empty".into()),
        };
        let text = attribute(node, "name").map(|name| name.text.trim().to_owned());
        let name = text.filter(|name| !name.is_empty());
        Some(Collision { name, at: node.range().start, pose, geometry })
    }

    /// Returns the geometry of a collision; `None` with an error in the report.
    fn touching_geometry(
        &mut self,
        shape: Node<'a, '_>,
        subject: &Subject,
    ) -> Result<Option<Geometry>, String> {
        let kind = shape.tag_name().name();
        if kind == "mesh" {
            return self.geometry(shape).map(Some).map_err(|why| format!("its geometry {why}"));
        }
        let place: Place = (Some(shape.range().start), Some(subject.clone()));
        touching_solid(kind, |name| shape.attribute(name), place, self.xml.report)
    }

    /// Returns the friction that `<gazebo>` gives to links, by their names.
    fn frictions(&mut self, robot: Node<'a, '_>) -> FxHashMap<&'a str, LinkFriction> {
        let mut frictions: FxHashMap<&'a str, LinkFriction> = FxHashMap::default();
        for gazebo in children(robot).filter(|node| is(*node, "gazebo")) {
            let Some(link) = attribute(gazebo, "reference") else { continue };
            for (tangent, name) in COEFFICIENTS.into_iter().enumerate() {
                let Some(node) = self.xml.single(gazebo, name, None) else { continue };
                let subject = Subject::Link(link.text.into());
                let Some(coefficient) = self.coefficient(node, &subject) else { continue };
                let friction = frictions.entry(link.text).or_default();
                friction.coefficients[tangent] = Some(coefficient);
                friction.at = node.range().start;
            }
        }
        frictions
    }

    /// Returns the coefficient of friction of a link's contacts by Gazebo's coefficients.
    fn friction(&mut self, friction: &LinkFriction, subject: &Subject) -> f64 {
        let [first, second] = friction.coefficients.map(|given| given.unwrap_or(FRICTION));
        if first != second {
            self.anisotropic.push((Some(friction.at), Some(subject.clone())));
        }
        first
    }

    /// Returns the coefficient of friction in `<contact>` of a link, an extension of PyBullet.
    fn lateral_friction(&mut self, link: Node<'a, '_>, subject: &Subject) -> Option<f64> {
        let contact = self.xml.single(link, "contact", Some(subject))?;
        let friction = self.xml.single(contact, "lateral_friction", Some(subject))?;
        self.coefficient(friction, subject)
    }

    /// Returns the coefficient of dynamic friction of a collision, an extension of Drake.
    fn dynamic_friction(&mut self, collision: Node<'a, '_>, subject: &Subject) -> Option<f64> {
        let properties = self.xml.single(collision, "drake.proximity_properties", Some(subject))?;
        let friction = self.xml.single(properties, "drake.mu_dynamic", Some(subject))?;
        self.coefficient(friction, subject)
    }

    /// Returns the coefficient of friction in an element; `None` with an error in the report.
    fn coefficient(&mut self, node: Node<'a, '_>, subject: &Subject) -> Option<f64> {
        let text = self.value(node);
        let [coefficient] = self.xml.numbers(text, Some(subject))?;
        if coefficient < 0.0 {
            let message = format!("`<{}>` is {coefficient}", written(node));
            let help = "write a coefficient of friction of at least 0";
            self.xml.report.error(Code::BadNumber, text.at, Some(subject), message, help);
            return None;
        }
        Some(coefficient)
    }
}
