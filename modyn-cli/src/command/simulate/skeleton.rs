//! A robot's skeleton: lines between the origins of its links.

use modyn_runtime::Interpreter;
use modyn_runtime::joint::JointType;
use modyn_runtime::model::Model;
use modyn_runtime::spatial::Pose;

use super::motion::Motion;
use crate::command::outcome::Failure;
use crate::viewer::Frame;

/// The edges and frames for the viewer.
pub struct Skeleton {
    pub edges: Vec<(usize, usize)>,
    pub frames: Vec<Frame>,
}

/// Returns the skeleton. Its points are the links of the description, then the centres of mass of links without children.
pub fn of(model: &Model, motion: &Motion) -> Result<Skeleton, Failure> {
    let (edges, tips) = edges(model);
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let mut poses = vec![Pose::identity(); model.frames().len()];
    let mut frames = Vec::with_capacity(motion.samples.len());
    for sample in &motion.samples {
        interpreter
            .link_poses(&sample.q, &mut poses)
            .map_err(|error| Failure::usage(format!("error: {error}")))?;
        let mut points: Vec<_> = poses.iter().map(|pose| pose.translation).collect();
        points.extend(tips.iter().map(|&(frame, tip)| poses[frame].transform_point(tip)));
        frames.push(Frame { time: sample.time, points });
    }
    Ok(Skeleton { edges, frames })
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
        let behind = match link.parent {
            Some(parent) => {
                ends[parent] = false;
                own[parent]
            }
            // A floating base is not connected to the world.
            None if link.joint.joint_type == JointType::Floating => None,
            None => root,
        };
        edges.extend(behind.zip(own[i]));
    }
    // Links that are fixed to another link, away from its origin.
    for (f, frame) in frames.iter().enumerate() {
        let away = frame.pose.translation.iter().any(|x| x.abs() > 1e-9);
        let behind = match frame.link {
            Some(link) => own[link],
            None => root,
        };
        if let Some(behind) = behind.filter(|&behind| behind != f && away) {
            edges.push((behind, f));
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
