//! A robot's skeleton: lines between the origins of its links.

use modyn_runtime::joint::JointType;
use modyn_runtime::model::Model;
use modyn_runtime::spatial::Pose;
use modyn_runtime::{Interpreter, ShapeError};

use crate::viewer::Frame;

/// The skeleton of a robot. Its points are the origins of the links of the description, then the centres of mass of links
/// without children.
pub struct Skeleton {
    /// The lines, as pairs of indices of points.
    pub edges: Vec<(usize, usize)>,
    tips: Vec<Tip>,
}

impl Skeleton {
    /// Returns the skeleton of a robot.
    #[must_use]
    pub fn new(model: &Model) -> Self {
        let (edges, tips) = edges(model);
        Self { edges, tips }
    }

    /// Returns the frames of a motion of this robot: times, s, and coordinates.
    ///
    /// # Errors
    ///
    /// If coordinates do not have the robot's length.
    pub fn frames<'q>(
        &self,
        model: &Model,
        motion: impl IntoIterator<Item = (f64, &'q [f64])>,
    ) -> Result<Vec<Frame>, ShapeError> {
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let mut poses = vec![Pose::identity(); model.frames().len()];
        let frame = |(time, q): (f64, &[f64])| {
            interpreter.link_poses(q, &mut poses)?;
            let tip = |&(frame, tip): &Tip| poses[frame].transform_point(tip);
            let points = poses.iter().map(|pose| pose.translation);
            Ok(Frame { time, points: points.chain(self.tips.iter().map(tip)).collect() })
        };
        motion.into_iter().map(frame).collect()
    }
}

/// A link's index, and a point in its frame.
type Tip = (usize, [f64; 3]);

fn edges(model: &Model) -> (Vec<(usize, usize)>, Vec<Tip>) {
    let (links, frames) = (model.links(), model.frames());
    let mut own: Vec<Option<usize>> = vec![None; links.len()];
    for (f, frame) in frames.iter().enumerate() {
        if let Some(link) = frame.link.filter(|&link| links[link].name == frame.name) {
            own[link] = Some(f);
        }
    }
    let root = frames.iter().position(|frame| frame.link.is_none());
    let mut edges = Vec::new();
    let mut ends = vec![true; links.len()];
    for (i, link) in links.iter().enumerate() {
        let parent = match link.parent {
            Some(parent) => {
                ends[parent] = false;
                own[parent]
            }
            // A floating base is not connected to the world.
            None if link.joint.joint_type == JointType::Floating => None,
            None => root,
        };
        edges.extend(parent.zip(own[i]));
    }
    // Links that are fixed to another link, away from its origin.
    for (f, frame) in frames.iter().enumerate() {
        let away = frame.pose.translation.iter().any(|x| x.abs() > 1e-9);
        let parent = match frame.link {
            Some(link) => own[link],
            None => root,
        };
        if let Some(parent) = parent.filter(|&parent| parent != f && away) {
            edges.push((parent, f));
            if let Some(link) = frame.link {
                ends[link] = false;
            }
        }
    }
    let mut tips = Vec::new();
    for (i, link) in links.iter().enumerate().filter(|(i, _)| ends[*i]) {
        let center = link.inertial.center_of_mass;
        if let Some(frame) = own[i].filter(|_| center.iter().any(|x| x.abs() > 1e-9)) {
            edges.push((frame, frames.len() + tips.len()));
            tips.push((frame, center));
        }
    }
    (edges, tips)
}
