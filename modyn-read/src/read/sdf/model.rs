//! Reads a `<world>` and a `<model>` with all its elements.

use modyn_runtime::spatial::Pose;
use roxmltree::Node;

use super::reader::{Reader, trimmed};
use super::world::{
    BallConstraint, BallConstraintEnd, Frame, FrameKind, Link, Overrides, Scope, WORLD,
};
use crate::description::Located;
use crate::diagnostics::{Code, Subject};
use crate::read::xml::element::{children, shown};

/// Drake's extension for a constraint of two points.
const BALL_CONSTRAINT: &str = "drake.ball_constraint";

/// The deepest nesting of models.
const MAX_DEPTH: usize = 64;

/// The longest start of a full name, in bytes: each part of a model repeats it.
const MAX_PREFIX: usize = 512;

/// A model whose elements are read next.
struct OpenModel {
    scope: usize,
    /// The scope that the model is in, and the start of full names there.
    outer: usize,
    prefix: String,
    /// Whether its elements become elements of the outer scope.
    merge: bool,
}

impl<'a> Reader<'a, '_, '_, '_> {
    /// Reads a `<world>`: its gravity, models, frames and joints.
    pub fn world(&mut self, node: Node<'a, '_>) {
        self.world.name = self.xml.optional(node, "name").map(trimmed);
        let own_gravity = self.xml.single(node, "gravity", None);
        // Before SDF 1.6, gravity was in `<physics>`.
        let physics = self.xml.named(node, "physics").next();
        let old = physics.and_then(|physics| self.xml.named(physics, "gravity").next());
        let element = own_gravity.or(old).map(|node| self.xml.content(node));
        let gravity = element.map(|text| self.xml.numbers::<3>(text, None));
        self.world.gravity = Some(gravity.flatten().unwrap_or(DEFAULT_GRAVITY));
        let known = [
            "audio",
            "wind",
            "include",
            "gravity",
            "magnetic_field",
            "atmosphere",
            "gui",
            "physics",
            "scene",
            "light",
            "frame",
            "model",
            "actor",
            "plugin",
            "joint",
            "road",
            "spherical_coordinates",
            "state",
            "population",
        ];
        self.warn_of_unknown(node, &known, None);
        self.elements(node, WORLD, 0);
    }

    /// Reads a `<model>` of a scope.
    pub fn model(&mut self, node: Node<'a, '_>, outer: usize, depth: usize, overrides: Overrides) {
        if let Some(opened) = self.open(node, outer, depth, overrides) {
            self.elements(node, opened.scope, depth);
            self.close(&opened);
        }
    }

    /// Begins a model; `None` if it is nested too deeply. Models within it are read in the stack of
    /// [`model`](Self::model), so this function is not a part of it.
    #[inline(never)]
    fn open(
        &mut self,
        node: Node<'a, '_>,
        outer: usize,
        depth: usize,
        overrides: Overrides,
    ) -> Option<OpenModel> {
        let at = self.xml.at(node);
        let attribute = self.xml.attribute(node, "name", None).map(trimmed);
        let name = overrides.name.or(attribute).unwrap_or(Located { text: "model".into(), at });
        let merge = overrides.merge && outer != WORLD;
        let before = self.world.scopes[outer].prefix.clone();
        // The names of the world's models are no part of the full names, unless several move.
        let prefix = match outer {
            WORLD => String::new(),
            _ if merge => before.clone(),
            _ => format!("{before}{}::", name.text),
        };
        if depth > MAX_DEPTH || prefix.len() > MAX_PREFIX {
            let message =
                format!("models are nested more than {MAX_DEPTH} deep, or have long names");
            let help = "check where the file comes from: no robot is nested this deeply";
            self.xml.report.error(Code::Excessive, at, None, message, help);
            return None;
        }
        let own_subject = Subject::Robot(name.text.clone());
        let subject = Some(&own_subject);
        let own_pose = self.pose(node, subject);
        let (pose, relative_to) = overrides.pose.unwrap_or(own_pose);
        let flag = self.flag(node, "static", subject);
        let own_static = overrides.is_static.or(flag) == Some(true);
        let filled =
            |name| self.xml.optional(node, name).map(trimmed).filter(|name| !name.text.is_empty());
        let scope = self.world.scopes.len();
        let frame = self.world.frames.len();
        let full = Located { text: format!("{before}{}", name.text), at: name.at };
        let mut new = Scope::new(frame, outer, prefix);
        new.placement = overrides.placement.or(filled("placement_frame"));
        new.canonical = filled("canonical_link");
        new.is_static = own_static || self.world.scopes[outer].is_static;
        if new.is_static && outer != WORLD && !self.world.scopes[outer].is_static {
            let message = "a static model within one that moves is not read";
            let help = "remove `<static>`; a `fixed` joint to `world` stops the model";
            self.xml.report.error(Code::NotRead, at, subject, message, help);
        }
        self.world.scopes.push(new);
        let kind = FrameKind::Model(scope);
        self.world.frames.push(Frame { name: full, scope: outer, kind, pose, relative_to });
        if !merge {
            self.declare(outer, &name, frame);
        }
        let known = [
            "static",
            "self_collide",
            "allow_auto_disable",
            "include",
            "model",
            "enable_wind",
            "frame",
            "pose",
            "link",
            "joint",
            "plugin",
            "gripper",
            BALL_CONSTRAINT,
        ];
        self.warn_of_unknown(node, &known, subject);
        Some(OpenModel { scope, outer, prefix: before, merge })
    }

    /// Ends a model: the elements of a merged model are elements of the enclosing model as well.
    #[inline(never)]
    fn close(&mut self, model: &OpenModel) {
        if !model.merge {
            return;
        }
        for frame in self.world.scopes[model.scope].content.clone() {
            let full = &self.world.frames[frame].name;
            let name = Located { text: full.text[model.prefix.len()..].into(), at: full.at };
            self.declare(model.outer, &name, frame);
        }
    }

    /// Reads the models, links, joints and frames of a scope.
    fn elements(&mut self, node: Node<'a, '_>, scope: usize, depth: usize) {
        for child in children(node).filter(Node::is_element) {
            match child.tag_name().name() {
                "model" => self.model(child, scope, depth + 1, Overrides::default()),
                "include" => self.include(child, scope, depth),
                _ => self.part(child, scope),
            }
        }
    }

    /// Reads an element of a scope that contains no models.
    #[inline(never)]
    fn part(&mut self, node: Node<'a, '_>, scope: usize) {
        match node.tag_name().name() {
            "link" if scope != WORLD => self.link(node, scope),
            "joint" => self.joint(node, scope),
            BALL_CONSTRAINT => self.ball_constraint(node, scope),
            "frame" => self.frame(node, scope),
            "plugin" => {
                let message = "a `<plugin>` is not read: forces that it applies do not act".into();
                let help = "apply such forces in the program that uses the robot";
                self.unread.add(message, (Some(self.xml.at(node)), None), help);
            }
            "population" => {
                let message = "`<population>` is not read";
                let help = "write out its models";
                let at = self.xml.at(node);
                self.xml.report.error(Code::NotRead, at, None, message, help);
            }
            _ => {}
        }
    }

    /// Reads Drake's constraint of two points of links.
    fn ball_constraint(&mut self, node: Node<'a, '_>, scope: usize) {
        let at = self.xml.at(node);
        let ends = [("body_A", "p_AP"), ("body_B", "p_BQ")].map(|(body, point)| {
            let link = self.name_in(node, &format!("{BALL_CONSTRAINT}_{body}"), None);
            let of_point = format!("{BALL_CONSTRAINT}_{point}");
            let shown = shown(&of_point);
            let example = format!("<{shown}>0 0 0</{shown}>");
            let element = self.xml.required(node, &of_point, &example, None);
            let point = element.and_then(|point| self.xml.numbers(self.xml.content(point), None));
            BallConstraintEnd { link, point: point.unwrap_or_default() }
        });
        self.world.ball_constraints.push(BallConstraint { scope, at, ends });
    }

    /// Reads a `<frame>`.
    fn frame(&mut self, node: Node<'a, '_>, scope: usize) {
        let Some(name) = self.xml.attribute(node, "name", None).map(trimmed) else { return };
        let (pose, relative_to) = self.pose(node, None);
        let attached_to = self.xml.optional(node, "attached_to").map(trimmed);
        let kind = FrameKind::Frame(attached_to.filter(|name| !name.text.is_empty()));
        self.push(scope, &name, kind, pose, relative_to);
    }

    /// Reads a `<link>`.
    fn link(&mut self, node: Node<'a, '_>, scope: usize) {
        let attribute = self.xml.attribute(node, "name", None).map(trimmed);
        let name = attribute.unwrap_or(Located { text: String::new(), at: self.xml.at(node) });
        let own_subject = Subject::Link(name.text.clone());
        let subject = Some(&own_subject);
        let known = [
            "gravity",
            "enable_wind",
            "self_collide",
            "kinematic",
            "must_be_base_link",
            "velocity_decay",
            "pose",
            "inertial",
            "collision",
            "visual",
            "sensor",
            "projector",
            "audio_sink",
            "audio_source",
            "battery",
            "light",
            "particle_emitter",
        ];
        self.warn_of_unknown(node, &known, subject);
        let (pose, relative_to) = self.pose(node, subject);
        let weightless = self.flag(node, "gravity", subject) == Some(false);
        if self.flag(node, "kinematic", subject) == Some(true) {
            let message =
                "`<kinematic>` is not read: a link that ignores forces is no part of the dynamics";
            let help = "remove it, and command the joints' accelerations instead";
            self.xml.report.error(Code::NotRead, self.xml.at(node), subject, message, help);
        }
        if let Some(decay) = self.xml.named(node, "velocity_decay").next() {
            let message =
                "`<velocity_decay>` is not read: it damps a link in one simulator only".into();
            let help = "write `<damping>` of the joints";
            self.unread.add(message, (Some(self.xml.at(decay)), subject.cloned()), help);
        }
        let inertial = self.inertial(node, subject);
        let index = self.world.links.len();
        let frame = self.push(scope, &name, FrameKind::Link(index), pose, relative_to);
        let shapes = if self.options.shapes { self.shapes(node, &name.text) } else { Vec::new() };
        let collisions = self.collisions(node, subject);
        self.world.links.push(Link { frame, inertial, shapes, weightless, collisions });
    }

    /// Adds a frame to a scope and returns its index.
    pub fn push(
        &mut self,
        scope: usize,
        name: &Located,
        kind: FrameKind,
        pose: Pose<f64>,
        relative_to: Option<Located>,
    ) -> usize {
        let frame = self.world.frames.len();
        let text = format!("{}{}", self.world.scopes[scope].prefix, name.text);
        let full = Located { text, at: name.at };
        self.world.frames.push(Frame { name: full, scope, kind, pose, relative_to });
        self.declare(scope, name, frame);
        frame
    }

    /// Makes a frame known by its name among its siblings.
    fn declare(&mut self, scope: usize, name: &Located, frame: usize) {
        self.world.scopes[scope].content.push(frame);
        // A missing name is an error already.
        if name.text.is_empty() {
            return;
        }
        let reserved =
            name.text == "world" || name.text.starts_with("__") && name.text.ends_with("__");
        if reserved {
            let message = format!("the name `{}` is reserved", name.text);
            let help = "give it another name; a joint to the world has `<parent>world</parent>`";
            self.xml.report.error(Code::FrameName, name.at, None, message, help);
            return;
        }
        let names = &mut self.world.scopes[scope].names;
        let Some(&first) = names.get(name.text.as_str()) else {
            names.insert(name.text.clone(), frame);
            return;
        };
        let [first, new] = [first, frame].map(|frame| &self.world.frames[frame]);
        let both = |kinds: fn(&FrameKind) -> bool| kinds(&first.kind) && kinds(&new.kind);
        // The links and the joints are compared with all others of the robot later.
        if both(|kind| matches!(kind, FrameKind::Link(_)))
            || both(|kind| matches!(kind, FrameKind::Joint(_)))
        {
            return;
        }
        // Before SDF 1.7, only links had frames.
        if self.version < 107 {
            if matches!(new.kind, FrameKind::Link(_)) {
                names.insert(name.text.clone(), frame);
            }
            return;
        }
        let place = self.xml.report.position(first.name.at);
        let message = format!("`{}` is also the name of another element, at {place}", name.text);
        let help = "links, joints, frames and models beside each other need different names";
        self.xml.report.error(Code::FrameName, name.at, None, message, help);
    }
}

/// The acceleration of free fall in a world that gives none, m/s^2.
const DEFAULT_GRAVITY: [f64; 3] = [0.0, 0.0, -9.8];
