//! Reads the `<collision>`s of a link.

use roxmltree::Node;

use super::reader::Reader;
use super::visual::content;
use super::world::{Collision, CollisionGeometry, CollisionMesh, Surface};
use crate::description::normalized;
use crate::diagnostics::{Code, Place, Subject};
use crate::read::collision::touching_solid;
use crate::read::xml::element::{children, shown};

/// The coefficient of friction of a `<surface>` that gives none.
const FRICTION: f64 = 1.0;

/// The mask of a `<surface>` that gives none.
const MASK: u32 = 0xffff;

impl<'a> Reader<'a, '_, '_, '_> {
    /// Returns the collisions of a link. Their diagnostics are not in the report.
    pub fn collisions(&mut self, link: Node<'a, '_>, subject: Option<&Subject>) -> Vec<Collision> {
        let collisions: Vec<_> = self.xml.named(link, "collision").collect();
        collisions.into_iter().map(|node| self.collision(node, subject)).collect()
    }

    fn collision(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> Collision {
        let before = self.xml.report.count();
        let (pose, relative_to) = self.pose(node, subject);
        let geometry = self.touching_geometry(node, subject);
        let surface = self.surface(node, subject);
        let name = self.xml.optional(node, "name").map_or("", |name| name.text.trim()).to_owned();
        let diagnostics = self.xml.report.take_after(before);
        let at = self.xml.at(node);
        Collision { name, at, pose, relative_to, geometry, surface, diagnostics }
    }

    fn touching_geometry(
        &mut self,
        collision: Node<'a, '_>,
        subject: Option<&Subject>,
    ) -> CollisionGeometry {
        let example = "<geometry><box><size>0.1 0.2 0.3</size></box></geometry>";
        let Some(geometry) = self.xml.required(collision, "geometry", example, subject) else {
            return CollisionGeometry::Empty;
        };
        let Some(shape) = children(geometry).find(Node::is_element) else {
            return CollisionGeometry::Empty;
        };
        match shape.tag_name().name() {
            "empty" => CollisionGeometry::Empty,
            "plane" => self.plane(shape, subject),
            "mesh" => {
                let Some(uri) = content(shape, "uri") else {
                    return CollisionGeometry::Other("its `<mesh>` has no `<uri>`".into());
                };
                let uri = uri.trim().to_owned();
                let place = self.file_of(&uri).ok();
                let scale = content(shape, "scale").map(str::to_owned);
                CollisionGeometry::Mesh(CollisionMesh { uri, place, scale })
            }
            kind => {
                let place: Place = (Some(self.xml.at(shape)), subject.cloned());
                let text = |name: &str| content(shape, name);
                match touching_solid(kind, text, place, self.xml.report) {
                    Ok(Some(solid)) => CollisionGeometry::Solid(solid),
                    Ok(None) => CollisionGeometry::Empty,
                    Err(why) => CollisionGeometry::Other(why),
                }
            }
        }
    }

    /// Returns a plane. The z axis stands for a normal that is missing, or cannot be read.
    fn plane(&mut self, shape: Node<'a, '_>, subject: Option<&Subject>) -> CollisionGeometry {
        let normal = self.xml.single(shape, "normal", subject);
        let direction = normal.and_then(|normal| {
            let text = self.xml.content(normal);
            let unit = normalized(self.xml.numbers(text, subject)?);
            if unit.is_none() {
                let message = "the normal of a `<plane>` is zero";
                let help = "write the direction away from the ground, such as `0 0 1`";
                self.xml.report.error(Code::ZeroAxis, text.at, subject, message, help);
            }
            unit
        });
        CollisionGeometry::Plane(direction.map_or([0.0, 0.0, 1.0], |(unit, _)| unit))
    }

    /// Returns the surface of a collision.
    fn surface(&mut self, collision: Node<'a, '_>, subject: Option<&Subject>) -> Surface {
        let mut surface = Surface { friction: [FRICTION; 2], mask: MASK, has_more: false };
        if let Some(drake) = self.xml.single(collision, "drake.proximity_properties", subject)
            && self.xml.single(drake, "drake.mu_dynamic", subject).is_some()
        {
            surface.friction = [self.coefficient(drake, "drake.mu_dynamic", subject); 2];
        }
        let Some(node) = self.xml.single(collision, "surface", subject) else { return surface };
        if let Some(friction) = self.xml.single(node, "friction", subject) {
            if let Some(ode) = self.xml.single(friction, "ode", subject) {
                surface.friction = ["mu", "mu2"].map(|name| self.coefficient(ode, name, subject));
            }
            let torsional = self.xml.single(friction, "torsional", subject);
            surface.has_more |= torsional.is_some_and(|node| self.is_torsional(node, subject));
        }
        if let Some(bounce) = self.xml.single(node, "bounce", subject) {
            let restitution = self.number(bounce, "restitution_coefficient", subject);
            surface.has_more |= restitution.is_some_and(|coefficient| coefficient > 0.0);
        }
        if let Some(contact) = self.xml.single(node, "contact", subject) {
            let is_sensor = self.flag(contact, "collide_without_contact", subject) == Some(true);
            let mask = self.number(contact, "collide_bitmask", subject);
            surface.mask = if is_sensor { 0 } else { mask.map_or(MASK, |mask| mask as u32) };
        }
        surface
    }

    /// Returns a coefficient of friction; an infinite one is the largest number.
    fn coefficient(&mut self, ode: Node<'a, '_>, name: &str, subject: Option<&Subject>) -> f64 {
        let Some(node) = self.xml.single(ode, name, subject) else { return FRICTION };
        let errors = self.xml.report.errors();
        let number = self.finite(ode, name, subject);
        if number.is_some_and(|coefficient| coefficient < 0.0) {
            let message = format!("`<{}>` is negative", shown(name));
            let help = "write a coefficient of friction of at least 0";
            let at = self.xml.at(node);
            self.xml.report.error(Code::BadNumber, at, subject, message, help);
        }
        let is_infinite = number.is_none() && self.xml.report.errors() == errors;
        number.unwrap_or(if is_infinite { f64::MAX } else { FRICTION })
    }

    /// Returns whether a `<torsional>` resists a rotation about the normal.
    fn is_torsional(&mut self, node: Node<'a, '_>, subject: Option<&Subject>) -> bool {
        let coefficient = self.number(node, "coefficient", subject).unwrap_or(1.0);
        let has_patch = self.flag(node, "use_patch_radius", subject) != Some(false);
        let name = if has_patch { "patch_radius" } else { "surface_radius" };
        let radius = self.number(node, name, subject).unwrap_or(0.0);
        coefficient > 0.0 && radius > 0.0
    }
}
