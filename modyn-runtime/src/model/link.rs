//! Links: the moving links, and all links of the description as frames.

use alloc::string::String;

use super::{Inertial, Joint};
use crate::spatial::Pose;

/// A moving link, with the joint towards its parent.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Link {
    /// The link's name in the description.
    pub name: String,
    /// The parent: the index of a moving link; `None` for the world.
    pub parent: Option<usize>,
    /// The joint between parent and link.
    pub joint: Joint,
    /// The inertia of the link and of all links that are fixed to it, in the link's frame.
    pub inertial: Inertial,
}

/// A link of the description, moving or not, as a frame fixed to a moving link (or to the world).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Frame {
    /// The link's name in the description.
    pub name: String,
    /// The moving link that it is fixed to; `None` for the world.
    pub link: Option<usize>,
    /// The pose in that link's frame (identity for the moving link itself), or in the world.
    pub pose: Pose<f64>,
    /// The link's own inertia in its own frame. The moving link's inertia includes it.
    pub inertial: Inertial,
}
