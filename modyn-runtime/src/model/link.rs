//! The links of the description, and the moving links.

use alloc::string::String;
use alloc::vec::Vec;

use super::{Inertial, Joint};
use crate::spatial::Pose;

/// A moving link, with the joint towards its parent.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MovingLink {
    /// The link's name in the description.
    pub name: String,
    /// The parent: the index of a moving link; `None` for the world.
    pub parent: Option<usize>,
    /// The joint between parent and link.
    pub joint: Joint,
    /// The inertia of the link and of all links that are fixed to it, in the link's frame.
    pub inertial: Inertial,
}

/// A link of the description, moving or not, fixed to a moving link or to the world.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Link {
    /// The link's name in the description.
    pub name: String,
    /// The moving link that it is fixed to; `None` for the world.
    pub moving_link: Option<usize>,
    /// The pose in that link's frame (identity for the moving link itself), or in the world.
    pub pose: Pose<f64>,
    /// The link's own inertia in its own frame. The moving link's inertia includes it.
    pub inertial: Inertial,
}

/// Returns the length of the longest path between joints of a robot's links, m. The distance of a
/// root's joint from the world's origin does not count.
#[must_use]
pub fn longest_path(links: &[MovingLink]) -> f64 {
    let mut lengths: Vec<f64> = Vec::with_capacity(links.len());
    for link in links {
        let [x, y, z] = link.joint.origin.translation;
        let before = link.parent.and_then(|parent| lengths.get(parent));
        lengths.push(before.map_or(0.0, |before| before + libm::sqrt(x * x + y * y + z * z)));
    }
    lengths.into_iter().fold(0.0, f64::max)
}
