//! Reads the `<inertial>` of a link.

use modyn_runtime::model::Inertial;
use roxmltree::Node;

use super::reader::Reader;
use super::solids;
use crate::description::InertialRecord;
use crate::diagnostics::{Code, Subject};
use crate::read::xml::element::children;

/// The density of a solid that gives none: the density of water, kg/m^3.
const DENSITY: f64 = 1000.0;

impl<'a> Reader<'a, '_, '_, '_> {
    /// Returns the inertia of a link in its frame; `None` without an `<inertial>`.
    pub fn inertial(
        &mut self,
        link: Node<'a, '_>,
        subject: Option<&Subject>,
    ) -> Option<InertialRecord> {
        let node = self.xml.single(link, "inertial", subject)?;
        let errors = self.xml.report.errors();
        let at = self.xml.at(node);
        let known =
            ["mass", "density", "auto_inertia_params", "pose", "inertia", "fluid_added_mass"];
        self.warn_of_unknown(node, &known, subject);
        let fluid = self.xml.named(node, "fluid_added_mass").next();
        if let Some(fluid) = fluid {
            let message = "`<fluid_added_mass>` is not supported: the inertia of a fluid is none of a rigid body";
            let help = "remove it, and add the fluid's forces to the external wrenches";
            self.xml.report.error(Code::NotRead, self.xml.at(fluid), subject, message, help);
        }
        let is_auto =
            self.xml.optional(node, "auto").and_then(|text| self.truth(text, "auto", subject));
        let mass = self.number(node, "mass", subject);
        let mass_at =
            self.xml.named(node, "mass").next().map_or(at, |mass| self.xml.content(mass).at);
        let inertial = if is_auto == Some(true) {
            let whole = self.automatic(link, node, subject);
            // A given mass scales the density.
            let scale = mass.filter(|_| whole.mass > 0.0).map_or(1.0, |mass| mass / whole.mass);
            let inertia = whole.inertia.map(|entry| entry * scale);
            Inertial { mass: whole.mass * scale, inertia, ..whole }
        } else {
            let (pose, _) = self.pose(node, subject);
            // The defaults of SDF.
            let mut inertia = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
            if let Some(node) = self.xml.single(node, "inertia", subject) {
                let names = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
                self.warn_of_unknown(node, &names, subject);
                for (name, entry) in names.into_iter().zip(&mut inertia) {
                    *entry = self.number(node, name, subject).unwrap_or(*entry);
                }
            }
            let mass = mass.unwrap_or(1.0);
            Inertial { mass, center_of_mass: [0.0; 3], inertia }.transformed(&pose)
        };
        let sound = self.xml.report.errors() == errors;
        Some(InertialRecord { inertial, at, mass_at, sound })
    }

    /// Returns the inertia of the solids in a link's `<collision>`s together, as `auto="true"` asks
    /// for.
    fn automatic(
        &mut self,
        link: Node<'a, '_>,
        inertial: Node<'a, '_>,
        subject: Option<&Subject>,
    ) -> Inertial {
        let density = self.number(inertial, "density", subject).unwrap_or(DENSITY);
        let mut whole = Inertial::default();
        let collisions: Vec<_> = self.xml.named(link, "collision").collect();
        for collision in &collisions {
            let (pose, frame) = self.pose(*collision, subject);
            if let Some(frame) = frame {
                let message = "a `<collision>` whose pose is relative to another frame has no automatic inertia";
                let help = "write its pose in the link's frame, or write `<mass>` and `<inertia>`";
                self.xml.report.error(Code::NotRead, frame.at, subject, message, help);
            }
            let density = self.number(*collision, "density", subject).unwrap_or(density);
            if let Some(solid) = self.solid(*collision, density, subject) {
                whole = whole.merged(&solid.transformed(&pose));
            }
        }
        if collisions.is_empty() {
            let message = "`auto` needs a `<collision>`, and the link has none";
            let help = "write `<mass>` and `<inertia>` instead of `auto=\"true\"`";
            self.xml.report.error(
                Code::MissingElement,
                self.xml.at(inertial),
                subject,
                message,
                help,
            );
        }
        whole
    }

    /// Returns the inertia of a `<collision>` of this density, in the frame of its geometry.
    fn solid(
        &mut self,
        collision: Node<'a, '_>,
        density: f64,
        subject: Option<&Subject>,
    ) -> Option<Inertial> {
        let geometry = self.xml.required(
            collision,
            "geometry",
            "<geometry><box><size>0.1 0.2 0.3</size></box></geometry>",
            subject,
        )?;
        let shape =
            children(geometry).find(Node::is_element).filter(|n| n.tag_name().name() != "empty")?;
        let at = self.xml.at(shape);
        let mut size = |name| {
            let node = self.xml.single(shape, name, subject);
            if node.is_none() {
                let message = format!("`<{}>` has no `<{name}>`", shape.tag_name().name());
                let help = format!("write `<{name}>...</{name}>` in m");
                self.xml.report.error(Code::MissingElement, at, subject, message, help);
            }
            node.map(|node| self.xml.content(node))
        };
        let numbers = match shape.tag_name().name() {
            "box" => size("size").and_then(|text| self.xml.numbers::<3>(text, subject)),
            "ellipsoid" => size("radii").and_then(|text| self.xml.numbers::<3>(text, subject)),
            "sphere" => size("radius")
                .and_then(|text| self.xml.numbers::<1>(text, subject))
                .map(|[r]| [r; 3]),
            "cylinder" | "capsule" | "cone" => {
                let texts = [size("radius"), size("length")];
                let [r, l] =
                    texts.map(|text| text.and_then(|text| self.xml.numbers::<1>(text, subject)));
                r.zip(l).map(|([r], [l])| [r, r, l])
            }
            other => {
                let message = format!("the mass of a `<{other}>` is not computed");
                let help = "write `<mass>` and `<inertia>` instead of `auto=\"true\"`";
                self.xml.report.error(Code::NotRead, at, subject, message, help);
                return None;
            }
        }?;
        let inertial = solids::solid(shape.tag_name().name(), numbers, density);
        if inertial.is_none() {
            let message = "its sizes or its density are not above 0, or too large";
            let help = "write lengths in m and the density in kg/m^3";
            self.xml.report.error(Code::NotFinite, at, subject, message, help);
        }
        inertial
    }
}
