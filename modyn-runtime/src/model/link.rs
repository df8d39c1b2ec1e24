//! Links: those that joints move, and all links of the description as frames.

use alloc::string::String;

use super::{Inertial, Joint};
use crate::spatial::Pose;

/// A moving link, with the joint that moves it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Link {
    /// The link's name in the description.
    pub name: String,
    /// The moving link it hangs on; `None` for the world.
    pub parent: Option<usize>,
    /// The joint between the two.
    pub joint: Joint,
    /// Its inertia, together with all that is fixed to it, in its own frame.
    pub inertial: Inertial,
}

/// A link of the description, moving or not, as a frame fixed to a moving link (or to the world).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Frame {
    /// The link's name in the description.
    pub name: String,
    /// The moving link it is fixed to; `None` for the world.
    pub link: Option<usize>,
    /// Its pose in that link's frame (identity for the moving link itself), or in the world.
    pub pose: Pose<f64>,
    /// Its own inertia in its own frame: its share of the moving link's.
    pub inertial: Inertial,
}
