//! Contacts: frames of links that can touch the world.

use alloc::string::String;

use super::{LoopConstraintEnd, Model};

/// A frame of a link that can touch the world.
///
/// A contact is a constraint between the world and a link, as a
/// [`LoopConstraint`](super::LoopConstraint) is one between two links. The set of active contacts
/// and the target of each ([`ContactTarget`](crate::ContactTarget)) are arguments of the functions
/// of constraints.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contact {
    /// The name, which no other constraint has.
    pub name: String,
    /// The motions that the contact stops.
    pub kind: ContactKind,
    /// The frame, on a link that moves. The z axis of a surface's frame is its normal, away from
    /// the world.
    pub end: LoopConstraintEnd,
}

/// The motions that a [`Contact`] stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ContactKind {
    /// The displacements of the frame's origin: three rows.
    Point,
    /// The displacements and the rotations of the frame: six rows.
    Surface,
}

impl ContactKind {
    /// Returns the kind of this name, `point` or `surface`; `None` for other names.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "point" => Some(Self::Point),
            "surface" => Some(Self::Surface),
            _ => None,
        }
    }

    /// Returns the name: `point` or `surface`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Surface => "surface",
        }
    }

    /// Returns the number of constraint rows.
    #[must_use]
    pub fn rows(self) -> usize {
        match self {
            Self::Point => 3,
            Self::Surface => 6,
        }
    }
}

impl Model {
    /// Returns the characteristic length of a contact, m. It is a sum over the links from the
    /// contact's frame up to the root, each with its share of the length of a
    /// [loop](Self::characteristic_length); 1 m if all of these are zero. The length does not
    /// depend on the coordinates, nor on inertias that are set at run time: redundant contacts
    /// share their load as in the description.
    ///
    /// # Panics
    ///
    /// If there is no contact of that index.
    #[must_use]
    pub fn contact_length(&self, contact: usize) -> f64 {
        let end = &self.contacts[contact].end;
        let link = &self.links[end.link];
        let mut at = (link.moving_link, link.pose.transform_point(end.pose.translation));
        let mut length = 0.0;
        while let (Some(i), point) = at {
            length += self.length_of_link(i, point);
            at = (self.moving_links[i].parent, self.moving_links[i].joint.origin.translation);
        }
        if length > 0.0 { length } else { 1.0 }
    }
}
