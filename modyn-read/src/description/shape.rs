//! The shapes of a robot, for pictures: the equations of motion know nothing of them.

use std::sync::Arc;

use modyn_runtime::spatial::Pose;

/// The shapes of a robot, as far as its description and its files have them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shapes {
    /// For each frame of the model its shapes, in the frame's axes. Empty if no shapes were asked
    /// for.
    pub of_frames: Vec<Vec<Shape>>,
    /// A sentence for each shape that could not be read.
    pub notes: Vec<String>,
}

/// A shape that belongs to a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The pose of the geometry in the link's frame.
    pub pose: Pose<f64>,
    /// The geometry.
    pub geometry: Geometry,
    /// Red, green, blue and opacity, from 0 to 1, as encoded by sRGB; `None` if the description has
    /// no colour.
    pub color: Option<[f64; 4]>,
}

/// The geometry of a shape. Lengths are in m.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Geometry {
    /// A box about its centre.
    Box {
        /// The lengths of its edges along x, y and z.
        size: [f64; 3],
    },
    /// A sphere about its centre.
    Sphere {
        /// The radius.
        radius: f64,
    },
    /// An ellipsoid about its centre.
    Ellipsoid {
        /// The radii along x, y and z.
        radii: [f64; 3],
    },
    /// A cylinder about its centre, along z.
    Cylinder {
        /// The radius.
        radius: f64,
        /// The length along z.
        length: f64,
    },
    /// A cylinder along z with half a sphere at each end.
    Capsule {
        /// The radius.
        radius: f64,
        /// The length of the cylinder, without the half spheres.
        length: f64,
    },
    /// A surface of triangles.
    Mesh(Arc<Mesh>),
}

impl Geometry {
    /// Returns whether all lengths are positive numbers.
    pub(crate) fn is_sound(&self) -> bool {
        let lengths: &[f64] = match self {
            Self::Box { size: lengths } | Self::Ellipsoid { radii: lengths } => lengths,
            Self::Sphere { radius } => &[*radius],
            Self::Cylinder { radius, length } => &[*radius, *length],
            // A capsule without a cylinder is a sphere.
            Self::Capsule { radius, length } => &[*radius, *length + *radius],
            Self::Mesh(_) => &[],
        };
        lengths.iter().all(|&length| length > 0.0 && length < super::MAX_NUMBER)
    }
}

/// A surface of triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The vertices, m.
    pub vertices: Vec<[f64; 3]>,
    /// The vertices of each triangle, as indices, counterclockwise from outside.
    pub faces: Vec<[usize; 3]>,
}
