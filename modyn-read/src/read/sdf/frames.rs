//! The pose frame semantics of SDF: the pose of each frame, and the link that it is attached to.

use modyn_runtime::spatial::Pose;

use super::world::{FrameKind, WORLD, World};
use crate::description::Located;
use crate::diagnostics::{Code, Report, Suggestions};

/// The largest rounding error that counts as zero: of an entry of a rotation, and as a part of the
/// lengths of which a translation is a difference.
pub const NOTHING: f64 = 1e-12;

/// The resolved frames of a world.
pub struct Frames {
    /// For each frame, its pose in the frame of its own scope.
    poses: Vec<Pose<f64>>,
    /// For each frame, the index of the link that it is attached to; `None` for the world.
    pub links: Vec<Option<usize>>,
}

impl Frames {
    /// Returns the pose of a frame in the frame of a scope around it.
    pub fn pose(&self, world: &World, scope: usize, frame: usize) -> Pose<f64> {
        compose(&self.poses, &world.path(scope, frame))
    }

    /// Returns the pose of a frame in the frame of a link; both are within the scope.
    pub fn between(&self, world: &World, scope: usize, [link, frame]: [usize; 2]) -> Pose<f64> {
        let [link, frame] = [link, frame].map(|end| self.pose(world, scope, end));
        let sizes = link.translation.iter().chain(&frame.translation);
        let negligible = NOTHING * sizes.fold(0.0, |most: f64, x| most.max(x.abs()));
        let mut between = inverse(&link).compose(&frame);
        for x in between.translation.iter_mut().filter(|x| x.abs() <= negligible) {
            *x = 0.0;
        }
        between
    }
}

/// Returns the product of the poses on a path that [`World::path`] returns.
fn compose(poses: &[Pose<f64>], path: &[usize]) -> Pose<f64> {
    path.iter().fold(Pose::identity(), |pose, &frame| poses[frame].compose(&pose))
}

/// Returns the inverse.
pub fn inverse(pose: &Pose<f64>) -> Pose<f64> {
    let r = &pose.rotation;
    let rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[j][i]));
    let [x, y, z] = pose.translation;
    let translation = rotation.map(|row| -(row[0] * x + row[1] * y + row[2] * z));
    Pose { rotation, translation }
}

/// Resolves all names and poses; errors are in the report.
pub fn resolve(world: &World, report: &mut Report<'_>) -> Frames {
    let mut resolver = Resolver { world, near: Suggestions::new(), report };
    let bases: Vec<_> = (0..world.frames.len()).map(|frame| resolver.base(frame)).collect();
    let placements: Vec<_> =
        (0..world.scopes.len()).map(|scope| resolver.placement(scope)).collect();
    let poses = resolver.poses(&bases, &placements);
    let next: Vec<_> = (0..world.frames.len()).map(|frame| resolver.attached_to(frame)).collect();
    let links = resolver.links(&next);
    Frames { poses, links }
}

struct Resolver<'w, 'r, 'f> {
    world: &'w World,
    near: Suggestions,
    report: &'r mut Report<'f>,
}

impl Resolver<'_, '_, '_> {
    /// Returns the frame of a name; `None` with an error in the report.
    fn find(&mut self, scope: usize, name: &Located, what: &str) -> Option<usize> {
        let frame = self.world.find(scope, &name.text);
        if frame.is_none() {
            let message = format!("{what} `{}` does not exist here", name.text);
            let names = self.world.scopes[scope].names.keys().map(String::as_str);
            let help = match self.near.suggest(&name.text, names) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "name a link, joint, frame or model beside it, `__model__`, or a part of a nested \
                         model as in `model::link`"
                    .into(),
            };
            self.report.error(Code::FrameName, name.at, None, message, help);
        }
        frame
    }

    /// Returns the frame that a frame's pose is relative to; `None` for its model's.
    fn base(&mut self, frame: usize) -> Option<usize> {
        let record = &self.world.frames[frame];
        if let Some(name) = &record.relative_to {
            return self.find(record.scope, name, "the frame");
        }
        match &record.kind {
            FrameKind::Joint(joint) => {
                let child = self.world.joints[*joint].child.as_ref()?;
                self.world.find(record.scope, &child.text)
            }
            FrameKind::Frame(Some(name)) => self.world.find(record.scope, &name.text),
            _ => None,
        }
    }

    /// Returns the frame inside a model that the model's pose is about; `None` for the model's.
    fn placement(&mut self, scope: usize) -> Option<usize> {
        let name = self.world.scopes[scope].placement.as_ref()?;
        self.find(scope, name, "the placement frame")
    }

    /// Returns the pose of each frame in the frame of its scope.
    fn poses(&mut self, bases: &[Option<usize>], placements: &[Option<usize>]) -> Vec<Pose<f64>> {
        let world = self.world;
        let mut poses: Vec<_> = world.frames.iter().map(|frame| frame.pose).collect();
        // The path to the base in the own scope, and to the placement frame in the model.
        let paths = |frame: usize| {
            let record = &world.frames[frame];
            let base = bases[frame].map_or(Vec::new(), |base| world.path(record.scope, base));
            let placement = match record.kind {
                FrameKind::Model(scope) => placements[scope].map(|inner| world.path(scope, inner)),
                _ => None,
            };
            [base, placement.unwrap_or_default()]
        };
        let mut state = vec![State::New; world.frames.len()];
        for start in 0..world.frames.len() {
            let mut open = vec![start];
            while let Some(&frame) = open.last() {
                let [base, placement] = paths(frame);
                if state[frame] == State::New {
                    state[frame] = State::Open;
                    for needed in base.iter().chain(&placement).copied() {
                        match state[needed] {
                            State::New => open.push(needed),
                            State::Open => self.cycle(needed, &open, &state),
                            State::Done => {}
                        }
                    }
                    continue;
                }
                open.pop();
                if state[frame] == State::Open {
                    state[frame] = State::Done;
                    let inside = inverse(&compose(&poses, &placement));
                    poses[frame] = compose(&poses, &base).compose(&poses[frame]).compose(&inside);
                }
            }
        }
        poses
    }

    /// Reports frames whose poses depend on each other.
    fn cycle(&mut self, frame: usize, open: &[usize], state: &[State]) {
        let names: Vec<String> = open
            .iter()
            .filter(|&&other| state[other] == State::Open)
            .skip_while(|&&other| other != frame)
            .take(10)
            .map(|&other| format!("`{}`", self.world.frames[other].name.text))
            .collect();
        let message = format!("poses depend on each other: {}", names.join(", "));
        let help = "write one of these poses relative to `__model__`";
        let at = self.world.frames[frame].name.at;
        self.report.error(Code::FrameCycle, at, None, message, help);
    }

    /// Returns the frame that a frame is attached to; `None` for links, the world, and names that
    /// do not exist.
    fn attached_to(&mut self, frame: usize) -> Option<usize> {
        let world = self.world;
        let record = &world.frames[frame];
        match &record.kind {
            FrameKind::World | FrameKind::Link(_) => None,
            FrameKind::Joint(joint) => {
                let child = world.joints[*joint].child.as_ref()?;
                let child_frame = self.find(record.scope, child, "the child")?;
                if child_frame == WORLD {
                    let message = "the world cannot be the child of a joint";
                    let help = "exchange `<parent>` and `<child>`";
                    self.report.error(Code::FrameName, child.at, None, message, help);
                }
                Some(child_frame)
            }
            FrameKind::Frame(Some(name)) => self.find(record.scope, name, "the frame"),
            FrameKind::Frame(None) => Some(world.scopes[record.scope].frame),
            FrameKind::Model(scope) => match &world.scopes[*scope].canonical {
                Some(name) => self.find(*scope, name, "the canonical link"),
                None => first_link(world, *scope),
            },
        }
    }

    /// Returns the link that each frame is attached to.
    fn links(&mut self, next: &[Option<usize>]) -> Vec<Option<usize>> {
        let mut links = vec![None; next.len()];
        let mut state = vec![State::New; next.len()];
        for start in 0..next.len() {
            let mut path = Vec::new();
            let mut at = start;
            let link = loop {
                match state[at] {
                    State::Done => break links[at],
                    State::Open => {
                        let frame = &self.world.frames[at].name;
                        let message = format!("frame `{}` is attached to itself", frame.text);
                        let help = "attach it to a link";
                        self.report.error(Code::FrameCycle, frame.at, None, message, help);
                        break None;
                    }
                    State::New => {}
                }
                state[at] = State::Open;
                path.push(at);
                match (&self.world.frames[at].kind, next[at]) {
                    (FrameKind::Link(link), _) => break Some(*link),
                    (_, Some(to)) => at = to,
                    (_, None) => break None,
                }
            };
            for frame in path {
                links[frame] = link;
                state[frame] = State::Done;
            }
        }
        links
    }
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    New,
    Open,
    Done,
}

/// Returns the frame of a model's first link, or else of the first link of its nested models.
fn first_link(world: &World, scope: usize) -> Option<usize> {
    let content = &world.scopes[scope].content;
    let link = |&&frame: &&usize| matches!(world.frames[frame].kind, FrameKind::Link(_));
    content.iter().find(link).copied().or_else(|| {
        content.iter().find_map(|&frame| match world.frames[frame].kind {
            FrameKind::Model(inner) => first_link(world, inner),
            _ => None,
        })
    })
}
