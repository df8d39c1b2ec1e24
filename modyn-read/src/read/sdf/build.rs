//! From a world to links and joints: the models that can move are one mechanism, and each joint
//! gets its frame in its parent link.

use std::collections::HashSet;

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{Actuation, Inertial, JointDynamics, Limits, LoopConstraintKind};
use modyn_runtime::spatial::Pose;
use rustc_hash::FxHashMap;

use super::frames::{Frames, NOTHING, inverse, resolve};
use super::ground::Grounding;
use super::world::{
    Axis, BallConstraint, BallConstraintEnd, FrameKind, Joint, JointKind, WORLD, World,
};
use crate::description::{
    Base, Description, EndRecord, InertialRecord, JointRecord, Kind, LinkRecord, Located,
    LoopRecord, Mimic, MimicRecord, ReadOptions, are_parallel,
};
use crate::diagnostics::{Code, Place, Report, Severity, Subject, Suggestions};

/// Returns the description of the models of a world that can move; `None` with errors in the
/// report.
pub fn describe(
    mut world: World,
    at: usize,
    options: &ReadOptions,
    report: &mut Report<'_>,
) -> Option<Description> {
    let moving = moving(&world, at, report)?;
    let mut name = &world.frames[world.scopes[moving[0]].frame].name;
    if moving.len() > 1 {
        name = world.name.as_ref().unwrap_or(name);
    }
    let name = name.clone();
    let inside = inside(&world, &moving);
    if moving.len() > 1 {
        world.qualify();
    }
    let surfaces = std::mem::take(&mut world.surfaces);
    let world = &world;
    let frames = resolve(world, report);
    let description = Description {
        name: name.text,
        at: name.at,
        gravity: world.gravity,
        links: Vec::new(),
        joints: Vec::new(),
        compensated: Vec::new(),
        loops: Vec::new(),
        contacts: Vec::new(),
        keyframes: Vec::new(),
        actuation: Actuation::default(),
        shape_notes: world.shape_notes.clone(),
        soft: None,
        softnesses: Vec::new(),
        loop_softnesses: Vec::new(),
    };
    let named = world.frames.iter().filter(|frame| !matches!(frame.kind, FrameKind::Joint(_)));
    let names = Names::new(named.map(|frame| frame.name.text.clone()));
    let near = Suggestions::new();
    let mut build = Build { world, frames, inside, options, names, near, description, report };
    build.links();
    build.joints();
    build.ball_constraints();
    build.roots();
    build.weights();
    let Build { frames, inside, mut description, report, .. } = build;
    let mut grounding =
        Grounding { world, frames: &frames, inside: &inside, options, surfaces, report };
    description.soft = grounding.soft_constraints(&description);
    Some(description)
}

/// Returns the scopes of the world's models that can move, at least one; `None` with an error in
/// the report.
fn moving(world: &World, at: usize, report: &mut Report<'_>) -> Option<Vec<usize>> {
    let models = (1..world.scopes.len()).filter(|&scope| world.scopes[scope].outer == WORLD);
    let (still, moving): (Vec<_>, Vec<_>) =
        models.partition(|&scope| world.scopes[scope].is_static);
    if !moving.is_empty() {
        return Some(moving);
    }
    let (code, at, message, help) = match still.first() {
        None => (Code::SdfModel, at, "the file has no model".into(), "write a `<model>`"),
        Some(&first) => {
            let name = &world.frames[world.scopes[first].frame].name;
            let message = format!("the model `{}` is static, so nothing moves", name.text);
            (Code::NoMovingJoint, name.at, message, "remove `<static>`")
        }
    };
    report.error(code, at, None, message, help);
    None
}

/// Returns for each scope whether it is one of the models or nested in one.
fn inside(world: &World, models: &[usize]) -> Vec<bool> {
    let mut inside = vec![false; world.scopes.len()];
    // An enclosing scope comes first.
    for scope in 1..world.scopes.len() {
        inside[scope] = models.contains(&scope) || inside[world.scopes[scope].outer];
    }
    inside
}

/// Names that are taken.
struct Names {
    taken: HashSet<String>,
    /// By name, the last number that was appended.
    numbers: FxHashMap<String, usize>,
}

impl Names {
    fn new(taken: impl Iterator<Item = String>) -> Self {
        Self { taken: taken.collect(), numbers: FxHashMap::default() }
    }

    /// Returns the name, or one with a number, which is not taken. It is taken then.
    fn unused(&mut self, name: &str) -> String {
        let mut unused = name.to_string();
        while !self.taken.insert(unused.clone()) {
            let number = self.numbers.entry(name.into()).or_insert(1);
            *number += 1;
            unused = format!("{name}_{number}");
        }
        unused
    }
}

/// A joint with its links, the parent first, and its pose in each.
struct Edge<'w> {
    joint: &'w Joint,
    ends: [(usize, Pose<f64>); 2],
    subject: Subject,
}

struct Build<'w, 'r, 'f> {
    world: &'w World,
    frames: Frames,
    /// For each scope, whether it belongs to a model that can move.
    inside: Vec<bool>,
    options: &'w ReadOptions,
    /// The full names of all frames but joints, and of links that were added.
    names: Names,
    near: Suggestions,
    description: Description,
    report: &'r mut Report<'f>,
}

impl Build<'_, '_, '_> {
    /// Adds the world, the links, and the `<frame>`s, which are links without inertia.
    fn links(&mut self) {
        let world = self.world;
        let name = world.frames[WORLD].name.clone();
        self.description.links.push(LinkRecord::new(name, None));
        for (index, frame) in world.frames.iter().enumerate() {
            let name = frame.name.clone();
            match &frame.kind {
                FrameKind::Link(link) if self.inside[frame.scope] => {
                    let inertial_record = &world.links[*link].inertial;
                    let (at, mass_at, sound) =
                        inertial_record.as_ref().map_or((name.at, name.at, true), |record| {
                            (record.at, record.mass_at, record.sound)
                        });
                    let described =
                        inertial_record.as_ref().map_or(DEFAULT_INERTIA, |record| record.inertial);
                    let inertial = Some(InertialRecord { inertial: described, at, mass_at, sound });
                    let shapes = world.links[*link].shapes.clone();
                    let record = LinkRecord { shapes, ..LinkRecord::new(name, inertial) };
                    self.description.links.push(record);
                }
                FrameKind::Frame(_) if self.inside[frame.scope] => {
                    let scope = &world.scopes[frame.scope];
                    // A name that is reserved, or another element's, is an error already.
                    let is_known =
                        scope.names.get(&name.text[scope.prefix.len()..]) == Some(&index);
                    let Some(link) = self.frames.links[index].filter(|_| is_known) else {
                        continue;
                    };
                    let link = self.world.links[link].frame;
                    let origin = self.frames.between(world, frame.scope, [link, index]);
                    let fixed = self.record(format!("{}_fixed", name.text), name.at);
                    let child = name.text.clone();
                    self.description.links.push(LinkRecord::new(name, None));
                    self.connect(JointRecord { origin, ..fixed }, link, &child);
                }
                _ => {}
            }
        }
    }

    /// Returns a fixed joint without its links, whose name no other joint has.
    fn record(&self, name: String, at: usize) -> JointRecord {
        JointRecord {
            name: Located { text: name, at },
            kind: Kind::Fixed,
            parent: None,
            child: None,
            origin: Pose::identity(),
            axis: [0.0, 0.0, 1.0],
            second_axis: [0.0, 1.0, 0.0],
            limits: None,
            mimic: None,
            dynamics: JointDynamics::default(),
            spring: None,
            actuator_forces: None,
            dynamics_at: at,
            sound: true,
        }
    }

    /// Adds a joint between two links.
    fn connect(&mut self, joint: JointRecord, parent: usize, child: &str) {
        let parent = Some(self.world.frames[parent].name.clone());
        let child = Some(Located { text: child.into(), at: joint.name.at });
        self.description.joints.push(JointRecord { parent, child, ..joint });
    }

    /// Adds the joints.
    fn joints(&mut self) {
        let world = self.world;
        let mut edges = Vec::new();
        for joint in &world.joints {
            let joint_frame = &world.frames[joint.frame];
            let Some(link) = self.frames.links[joint.frame] else { continue };
            let subject = Subject::Joint(joint_frame.name.text.clone());
            let child = self.end(link);
            let Some(parent) = self.parent(joint, joint_frame.scope, &subject) else { continue };
            if (parent, child) == (WORLD, WORLD) {
                continue;
            }
            let ends = [parent, child].map(|link| {
                let pose = match link {
                    WORLD => self.frames.pose(world, WORLD, joint.frame),
                    _ => self.frames.between(world, joint_frame.scope, [link, joint.frame]),
                };
                (link, pose)
            });
            edges.push(Edge { joint, ends, subject });
        }
        let edges = self.tree(edges);
        let reversed = self.reversed(&edges);
        for (Edge { joint, ends, subject }, reversed) in edges.iter().zip(reversed) {
            let directions = joint.axes.each_ref().map(|axis| self.direction(joint, axis.as_ref()));
            let made = self.made(joint, directions, subject);
            let [parent, child] = *ends;
            if reversed {
                let directions = directions.map(|axis| axis.map(|x| -x));
                self.place(joint, made, directions, [child, parent], subject);
            } else {
                self.place(joint, made, directions, [parent, child], subject);
            }
        }
    }

    /// Returns the joints of a spanning tree, in order. The other joints close loops: those that
    /// say so, and those between links that joints before them connect.
    fn tree<'w>(&mut self, edges: Vec<Edge<'w>>) -> Vec<Edge<'w>> {
        // For each frame, a frame of the same connected part; a part's last frame leads to itself.
        let mut next: Vec<usize> = (0..self.world.frames.len()).collect();
        let mut tree = Vec::new();
        let mut loops = Vec::new();
        for edge in edges {
            let [parent, child] = edge.ends.each_ref().map(|(link, _)| *link);
            let parts = [parent, child].map(|mut frame| {
                while next[frame] != frame {
                    next[frame] = next[next[frame]];
                    frame = next[frame];
                }
                frame
            });
            // A joint between a link and itself is an error of the tree.
            if edge.joint.closes_loop || parts[0] == parts[1] && parent != child {
                if !edge.joint.closes_loop {
                    let at = self.world.frames[edge.joint.frame].name.at;
                    loops.push((Some(at), Some(edge.subject.clone())));
                }
                self.closing(edge);
            } else {
                next[parts[0]] = parts[1];
                tree.push(edge);
            }
        }
        let message = "it connects links that other joints connect, so it closes a loop: it is a \
                       constraint, and has no \
                       coordinate";
        let help = "to choose another joint of the loop for this, write \
                    `<physics><simbody><must_be_loop_joint>true</must_be_loop_joint></simbody></physics>` in it";
        self.report.warn_once(Code::LoopEnds, &loops, message, help);
        tree
    }

    /// Returns for each joint whether its child is closer to the root than its parent. Such a joint
    /// is exchanged: about the opposite axis, its coordinate means the same.
    fn reversed(&self, edges: &[Edge]) -> Vec<bool> {
        let mut joints: FxHashMap<usize, Vec<usize>> = FxHashMap::default();
        let mut children = HashSet::new();
        for (index, Edge { ends: [(parent, _), (child, _)], .. }) in edges.iter().enumerate() {
            joints.entry(*parent).or_default().push(index);
            joints.entry(*child).or_default().push(index);
            children.insert(*child);
        }
        let links = self.world.links.iter().map(|link| link.frame);
        let roots = std::iter::once(WORLD).chain(links.filter(|link| !children.contains(link)));
        let mut seen = HashSet::new();
        let mut reversed = vec![false; edges.len()];
        for root in roots {
            if !seen.insert(root) {
                continue;
            }
            let mut open = vec![root];
            while let Some(link) = open.pop() {
                for &index in joints.get(&link).into_iter().flatten() {
                    let Edge { joint, ends: [(parent, _), (child, _)], .. } = &edges[index];
                    let other = if *parent == link { *child } else { *parent };
                    let is_fixed_order =
                        matches!(joint.kind, Some(JointKind::Universal | JointKind::Ball));
                    let backwards = *child == link;
                    if !(backwards && is_fixed_order) && seen.insert(other) {
                        reversed[index] = backwards;
                        open.push(other);
                    }
                }
            }
        }
        reversed
    }

    /// Returns the frame of a joint's parent link, or of the world; `None` with an error in the
    /// report.
    fn parent(&mut self, joint: &Joint, scope: usize, subject: &Subject) -> Option<usize> {
        let world = self.world;
        let name = joint.parent.as_ref()?;
        if name.text == "world" {
            return Some(WORLD);
        }
        let Some(parent) = world.find(scope, &name.text) else {
            let message = format!("its parent `{}` does not exist", name.text);
            let names = world.scopes[scope].names.keys().map(String::as_str);
            let help = match self.near.suggest(&name.text, names) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "name a link or frame of the same model, or `world`".into(),
            };
            self.report.error(Code::UnknownParent, name.at, Some(subject), message, help);
            return None;
        };
        Some(self.end(self.frames.links[parent]?))
    }

    /// Returns the frame of a link, or the frame of the world for a link of a static model.
    fn end(&self, link: usize) -> usize {
        let frame = self.world.links[link].frame;
        if self.inside[self.world.frames[frame].scope] { frame } else { WORLD }
    }

    /// Returns the direction of an axis in the joint's frame.
    fn direction(&mut self, joint: &Joint, axis: Option<&Axis>) -> [f64; 3] {
        let Some(axis) = axis else { return [0.0, 0.0, 1.0] };
        let Some(name) = &axis.expressed_in else { return axis.direction };
        let scope = self.world.frames[joint.frame].scope;
        let Some(frame) = self.world.find(scope, &name.text) else {
            let message = format!("the frame `{}` of its axis does not exist here", name.text);
            let help = "name a link, joint or frame of the same model, or `__model__`";
            let subject = Subject::Joint(self.world.frames[joint.frame].name.text.clone());
            self.report.error(Code::FrameName, name.at, Some(&subject), message, help);
            return axis.direction;
        };
        let [joint_pose, other] =
            [joint.frame, frame].map(|frame| self.frames.pose(self.world, scope, frame));
        inverse(&joint_pose).rotate(other.rotate(axis.direction))
    }

    /// Returns a joint's record without its links and its place.
    fn made(&mut self, joint: &Joint, directions: [[f64; 3]; 2], subject: &Subject) -> JointRecord {
        let frame = &self.world.frames[joint.frame];
        let mut record = self.record(frame.name.text.clone(), frame.name.at);
        record.sound = joint.sound;
        let unlimited = |axis: &Axis| axis.limits.lower.is_none() && axis.limits.upper.is_none();
        let kind = match joint.kind {
            None => Kind::Unknown,
            Some(JointKind::Fixed) => Kind::Fixed,
            Some(JointKind::Revolute | JointKind::Screw)
                if !joint.axes[0].as_ref().is_some_and(unlimited) =>
            {
                Kind::Moving(JointType::Revolute)
            }
            Some(JointKind::Revolute | JointKind::Screw | JointKind::Continuous) => {
                Kind::Moving(JointType::Continuous)
            }
            Some(JointKind::Prismatic) => Kind::Moving(JointType::Prismatic),
            Some(JointKind::Universal) => Kind::Moving(JointType::Universal),
            Some(JointKind::Ball) => Kind::Moving(JointType::Spherical),
        };
        record.kind = kind;
        let Some(axis) = &joint.axes[0] else { return record };
        record.dynamics = axis.dynamics;
        record.dynamics_at = axis.dynamics_at;
        record.spring = axis.spring.clone();
        let mut limits = axis.limits;
        let mut mimic = &axis.mimic;
        if let Some(second) = &joint.axes[1] {
            self.second_axis(axis, second, directions, subject);
            if let (Some(spring), Some(second)) = (&mut record.spring, &second.spring) {
                spring.reference.extend(&second.reference);
            }
            let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
            limits = Limits {
                lower: None,
                upper: None,
                velocity: least(limits.velocity, second.limits.velocity),
                effort: least(limits.effort, second.limits.effort),
            };
            mimic = if mimic.is_some() { mimic } else { &second.mimic };
        }
        if kind == Kind::Moving(JointType::Continuous) {
            limits = Limits { lower: None, upper: None, ..limits };
        }
        let Limits { lower, upper, velocity, effort } = limits;
        record.limits =
            [lower, upper, velocity, effort].iter().any(Option::is_some).then_some(limits);
        record.mimic = mimic.as_ref().map(|mimic| {
            let leader_frame = self.world.find(frame.scope, &mimic.leader.text);
            let text = leader_frame.map_or(&mimic.leader, |leader| &self.world.frames[leader].name);
            let leader = Located { text: text.text.clone(), at: mimic.leader.at };
            MimicRecord { leader, multiplier: mimic.multiplier, offset: mimic.offset }
        });
        record
    }

    /// Reports what a joint with two axes cannot have.
    fn second_axis(
        &mut self,
        first: &Axis,
        second: &Axis,
        [a, b]: [[f64; 3]; 2],
        subject: &Subject,
    ) {
        let mut error = |code, message, help| {
            self.report.error(code, second.at, Some(subject), message, help);
        };
        if are_parallel(a, b) {
            let help = "write `<xyz>` of `<axis2>` across that of `<axis>`";
            error(Code::ParallelAxes, "its two axes are parallel", help);
        }
        let stiffness = |axis: &Axis| axis.spring.as_ref().map(|spring| spring.stiffness);
        if first.dynamics != second.dynamics || stiffness(first) != stiffness(second) {
            let message =
                "damping, friction or springs of its two axes differ, which is not supported";
            error(
                Code::NotRead,
                message,
                "write two `revolute` joints with a light link between them",
            );
        }
        let bounded = |axis: &&Axis| axis.limits.lower.is_some() || axis.limits.upper.is_some();
        if let Some(axis) = [first, second].iter().find(|axis| bounded(axis)) {
            let message = "`<lower>` and `<upper>` are not read: the joint has several coordinates";
            let help = "remove them; such a joint has velocity and effort limits only";
            let severity = Severity::Warning;
            let code = Code::NotRead;
            self.report.add(severity, code, axis.at, Some(subject), message, help);
        }
    }

    /// Adds a joint. The frame of the link that it moves is the joint's, so a child link elsewhere
    /// needs a link between them, which has the joint's frame and name.
    fn place(
        &mut self,
        joint: &Joint,
        made: JointRecord,
        directions: [[f64; 3]; 2],
        [(parent, in_parent), (child, in_child)]: [(usize, Pose<f64>); 2],
        subject: &Subject,
    ) {
        let to_child = inverse(&in_child);
        let child = self.world.frames[child].name.text.clone();
        let is_apart = match joint.kind {
            Some(JointKind::Fixed | JointKind::Prismatic) => false,
            Some(JointKind::Screw) => true,
            Some(JointKind::Ball) => !is_identity(&in_child),
            _ => in_child.translation != [0.0; 3],
        };
        if !is_apart {
            let origin =
                if is_identity(&in_child) { in_parent } else { in_parent.compose(&to_child) };
            let [axis, second_axis] = directions.map(|direction| in_child.rotate(direction));
            self.connect(JointRecord { origin, axis, second_axis, ..made }, parent, &child);
            return;
        }
        let name = made.name.text.clone();
        let at = made.name.at;
        let between = self.names.unused(&name);
        let name_between = Located { text: between.clone(), at };
        let record = LinkRecord { auxiliary: true, ..LinkRecord::new(name_between, None) };
        self.description.links.push(record);
        let [axis, second_axis] = directions;
        self.connect(
            JointRecord { origin: in_parent, axis, second_axis, ..made },
            parent,
            &between,
        );
        let mut last = self.record(format!("{name}_fixed"), at);
        last.origin = to_child;
        if joint.kind == Some(JointKind::Screw) {
            if self.options.mimic != Mimic::Follow {
                let message = "a screw joint is a rotation that a translation follows, so it needs `mimic = follow`";
                let help = "set the option `mimic = follow`, or replace the screw joint";
                self.report.error(Code::Mimic, at, Some(subject), message, help);
            }
            last.name.text = format!("{name}_slide");
            last.kind = Kind::Moving(JointType::Prismatic);
            last.axis = in_child.rotate(axis);
            let leader = Located { text: name, at };
            last.mimic = Some(MimicRecord { leader, multiplier: joint.pitch, offset: 0.0 });
        }
        last.parent = Some(Located { text: between, at });
        last.child = Some(Located { text: child, at });
        self.description.joints.push(last);
    }

    /// Adds a joint that closes a loop.
    fn closing(&mut self, Edge { joint, ends, subject }: Edge<'_>) {
        let subject = &subject;
        let axis = self.direction(joint, joint.axes[0].as_ref());
        let name = &self.world.frames[joint.frame].name;
        let axes = joint.axes.iter().flatten();
        if axes.clone().any(|axis| axis.mimic.is_some()) {
            let message = "it closes a loop and mimics another joint, which is not supported";
            let help = "remove `<mimic>`, or let another joint close the loop";
            self.report.error(Code::NotRead, name.at, Some(subject), message, help);
        }
        if let Some(axis) = axes.clone().find(|axis| axis.dynamics != JointDynamics::default()) {
            let message = "it closes a loop, so its damping and friction do not act";
            let help = "remove them, or let another joint close the loop";
            let severity = Severity::Warning;
            let code = Code::NotRead;
            self.report.add(severity, code, axis.dynamics_at, Some(subject), message, help);
        }
        let kind = match joint.kind {
            Some(JointKind::Fixed) => Some(LoopConstraintKind::Rigid),
            Some(JointKind::Revolute | JointKind::Continuous) => {
                Some(LoopConstraintKind::Revolute(axis))
            }
            Some(JointKind::Prismatic) => Some(LoopConstraintKind::Prismatic(axis)),
            Some(JointKind::Ball) => Some(LoopConstraintKind::Point),
            Some(JointKind::Universal | JointKind::Screw) => {
                let message = "a joint of this type cannot close a loop";
                let help = "close the loop by a revolute, prismatic, ball or fixed joint";
                self.report.error(Code::NotRead, name.at, Some(subject), message, help);
                None
            }
            None => None,
        };
        let ends = ends.map(|(link, pose)| {
            let link = Some(self.world.frames[link].name.text.clone());
            EndRecord { link, at: Some(name.at), pose }
        });
        let at = Some(name.at);
        let name = name.text.clone();
        self.description.loops.push(LoopRecord { name, at, kind, ends });
    }

    /// Adds Drake's constraints of two points.
    fn ball_constraints(&mut self) {
        let world = self.world;
        let joints = self.description.joint_names().map(str::to_string);
        let mut names = Names::new(joints.collect::<Vec<_>>().into_iter());
        for BallConstraint { scope, at, ends } in &world.ball_constraints {
            if !self.inside[*scope] {
                continue;
            }
            let ends = ends.each_ref().map(|BallConstraintEnd { link, point }| {
                let frame = link.as_ref().and_then(|name| match name.text.as_str() {
                    "world" => Some(WORLD),
                    text => world.find(*scope, text),
                });
                let place = link.as_ref().map_or(*at, |link| link.at);
                // A name that no link has is reported with the other loops.
                let name = match frame {
                    Some(frame) => Some(world.frames[frame].name.text.clone()),
                    None => link.as_ref().map(|link| link.text.clone()),
                };
                let pose = Pose { translation: *point, ..Pose::identity() };
                EndRecord { link: name, at: Some(place), pose }
            });
            let name = names.unused("ball_constraint");
            let kind = Some(LoopConstraintKind::Point);
            self.description.loops.push(LoopRecord { name, at: Some(*at), kind, ends });
        }
    }

    /// Connects each link that is no joint's child to the world: as it is placed, or floating.
    fn roots(&mut self) {
        let world = self.world;
        let children: HashSet<&str> = self
            .description
            .joints
            .iter()
            .filter_map(|joint| joint.child.as_ref().map(|child| child.text.as_str()))
            .collect();
        let roots: Vec<usize> = world
            .links
            .iter()
            .map(|link| link.frame)
            .filter(|&frame| self.inside[world.frames[frame].scope])
            .filter(|&frame| !children.contains(world.frames[frame].name.text.as_str()))
            .collect();
        let mut names = Names::new(self.description.joint_names().map(str::to_string));
        if self.options.base == Base::Floating && roots.is_empty() {
            let message = "`base = floating` is set, but a joint fixes the model to the world";
            let help = "remove the option, or the joint whose parent is `world`";
            self.report.error(Code::Option, self.description.at, None, message, help);
        }
        for root in roots {
            let name = &world.frames[root].name;
            let record = if self.options.base == Base::Fixed {
                let origin = self.frames.pose(world, WORLD, root);
                JointRecord { origin, ..self.record(format!("{}_fixed", name.text), name.at) }
            } else {
                let qualification = &world.scopes[world.frames[root].scope].qualification;
                let unused = names.unused(&format!("{qualification}floating_base"));
                let kind = Kind::Moving(JointType::Floating);
                JointRecord { kind, ..self.record(unused, name.at) }
            };
            self.connect(record, WORLD, &name.text);
        }
    }

    /// Returns the names of the links that cannot move.
    fn welded(&self) -> HashSet<String> {
        let mut children: FxHashMap<&str, Vec<&str>> = FxHashMap::default();
        for joint in self.description.joints.iter().filter(|joint| joint.kind == Kind::Fixed) {
            if let (Some(parent), Some(child)) = (&joint.parent, &joint.child) {
                children.entry(&parent.text).or_default().push(&child.text);
            }
        }
        let mut welded = HashSet::new();
        let mut open = vec!["world"];
        while let Some(link) = open.pop() {
            if welded.insert(link.to_string()) {
                open.extend(children.get(link).into_iter().flatten());
            }
        }
        welded
    }

    /// Compensates the weight of links without gravity; without any weight, gravity is zero. Warns
    /// of moving links without inertia.
    fn weights(&mut self) {
        let world = self.world;
        let inside = world.links.iter().filter(|link| self.inside[world.frames[link.frame].scope]);
        let links_inside: Vec<_> = inside.collect();
        let welded = self.welded();
        let without: Vec<Place> = links_inside
            .iter()
            .filter(|link| link.inertial.is_none())
            .map(|link| &world.frames[link.frame].name)
            .filter(|name| !welded.contains(&name.text))
            .map(|name| (Some(name.at), Some(Subject::Link(name.text.clone()))))
            .collect();
        let message =
            "it has no `<inertial>`, so SDF gives it a mass of 1 kg and an inertia of 1 kg m^2";
        let help = "write the link's `<inertial>`";
        self.report.warn_once(Code::MissingInertial, &without, message, help);
        if !links_inside.is_empty() && links_inside.iter().all(|link| link.weightless) {
            self.description.gravity = Some([0.0; 3]);
            return;
        }
        let without: HashSet<&str> = links_inside
            .iter()
            .filter(|link| link.weightless)
            .map(|link| world.frames[link.frame].name.text.as_str())
            .filter(|name| !welded.contains(*name))
            .collect();
        let links = self.description.links.iter().enumerate();
        let compensated = links.filter(|(_, link)| without.contains(link.name.text.as_str()));
        self.description.compensated = compensated.map(|(index, _)| (index, 1.0)).collect();
    }
}

/// The inertia of a link that gives none.
const DEFAULT_INERTIA: Inertial =
    Inertial { mass: 1.0, center_of_mass: [0.0; 3], inertia: [1.0, 0.0, 0.0, 1.0, 0.0, 1.0] };

/// Returns whether a pose is the identity but for rounding errors.
fn is_identity(pose: &Pose<f64>) -> bool {
    let Pose { rotation, translation } = Pose::<f64>::identity();
    let mut entries = pose.rotation.iter().flatten().zip(rotation.iter().flatten());
    pose.translation == translation && entries.all(|(a, b)| (a - b).abs() <= NOTHING)
}
