//! Contacts: frames of links that touch the world, or do not.

use alloc::string::String;

use super::{LoopConstraintEnd, Model};

/// A frame of a link that may be in contact with the world.
///
/// A contact is a constraint like a [`LoopConstraint`](super::LoopConstraint), between the world and a link. Which
/// contacts are active is an argument of the functions that meet them, and so is the plane or the frame in the world
/// that each of them holds on to: see [`ContactTarget`](crate::ContactTarget).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contact {
    /// Its name.
    pub name: String,
    /// The motions that it prevents.
    pub kind: ContactKind,
    /// The frame, on a link that moves. The z axis of a surface's frame is its normal, away from the world.
    pub end: LoopConstraintEnd,
}

/// The motions that a [`Contact`] prevents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactKind {
    /// Those of the frame's origin: three rows.
    Point,
    /// Those of the frame: six rows.
    Surface,
}

impl ContactKind {
    /// The kind of this name: `point` or `surface`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "point" => Some(Self::Point),
            "surface" => Some(Self::Surface),
            _ => None,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Surface => "surface",
        }
    }

    /// The number of constraint rows.
    #[must_use]
    pub fn rows(self) -> usize {
        match self {
            Self::Point => 3,
            Self::Surface => 6,
        }
    }
}

impl Model {
    /// The characteristic length of a contact, m: that of a [loop](Self::characteristic_length) which the contact would
    /// close between the link and the world's origin. Links up to the root count, a floating joint as one without
    /// length.
    ///
    /// # Panics
    ///
    /// If there is no contact of that index.
    #[must_use]
    pub fn contact_length(&self, contact: usize) -> f64 {
        let end = &self.contacts[contact].end;
        let frame = &self.frames[end.frame];
        let mut at = (frame.link, frame.pose.transform_point(end.pose.translation));
        let mut length = 0.0;
        while let (Some(i), point) = at {
            length += self.length_of_link(i, point);
            at = (self.links[i].parent, self.links[i].joint.origin.translation);
        }
        if length > 0.0 { length } else { 1.0 }
    }
}
