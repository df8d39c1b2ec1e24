//! What can be wrong with the parts of a model.

use alloc::{collections::BTreeMap, string::String, vec::Vec};
use core::fmt;

use super::Model;
use crate::spatial::Pose;

/// A defect of a model's parts, and where it is.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelError {
    /// The joint, link or frame concerned; the model's name where it concerns the whole.
    pub name: String,
    /// What is wrong.
    pub kind: ModelErrorKind,
}

/// The kinds of [`ModelError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ModelErrorKind {
    /// The model has no moving joint.
    NoJoint,
    /// Another link (or joint) has the same name.
    DuplicateName,
    /// The parent (or the link a frame is fixed to) does not exist or does not come before it.
    Parent,
    /// The links do not stand depth first.
    Order,
    /// A figure is NaN or infinite.
    NotFinite,
    /// The axis is not of unit length.
    Axis,
    /// The rotation matrix is not orthonormal and right-handed.
    Rotation,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.kind {
            ModelErrorKind::NoJoint => "has no moving joint; a model needs at least one",
            ModelErrorKind::DuplicateName => "is a name used twice; names must be unique",
            ModelErrorKind::Parent => "has a parent that does not come before it in the model",
            ModelErrorKind::Order => "is out of order; links must stand depth first",
            ModelErrorKind::NotFinite => "has a figure that is NaN or infinite",
            ModelErrorKind::Axis => "has an axis that is not of unit length",
            ModelErrorKind::Rotation => "has a rotation that is not orthonormal and right-handed",
        };
        write!(f, "`{}` {what}", self.name)
    }
}

impl core::error::Error for ModelError {}

/// Every defect of `model`, links first, then frames.
pub(super) fn check(model: &Model) -> Vec<ModelError> {
    let mut errors = Vec::new();
    let mut report = |name: &str, kind| errors.push(ModelError { name: name.into(), kind });
    if model.links.is_empty() {
        report(&model.name, ModelErrorKind::NoJoint);
    }
    if !finite(&model.gravity) {
        report(&model.name, ModelErrorKind::NotFinite);
    }
    let mut joints = BTreeMap::new();
    let mut names = BTreeMap::new();
    // The links on the path from the root to the one before: a depth-first successor hangs on one of them.
    let mut path: Vec<usize> = Vec::new();
    for (i, link) in model.links.iter().enumerate() {
        if names.insert(&link.name, i).is_some() {
            report(&link.name, ModelErrorKind::DuplicateName);
        }
        if joints.insert(&link.joint.name, i).is_some() {
            report(&link.joint.name, ModelErrorKind::DuplicateName);
        }
        match link.parent {
            Some(parent) if parent >= i => report(&link.name, ModelErrorKind::Parent),
            parent => {
                while path.last().copied() != parent && path.pop().is_some() {}
                if path.last().copied() != parent {
                    report(&link.name, ModelErrorKind::Order);
                }
                path.push(i);
            }
        }
        let joint = &link.joint;
        let pose = (joint.origin.rotation, joint.origin.translation);
        let inertial = &link.inertial;
        if !(pose.0.iter().all(|row| finite(row))
            && finite(&pose.1)
            && finite(&joint.axis)
            && finite(&[inertial.mass])
            && finite(&inertial.center_of_mass)
            && finite(&inertial.inertia))
        {
            report(&link.name, ModelErrorKind::NotFinite);
            continue;
        }
        let length_squared: f64 = joint.axis.iter().map(|x| x * x).sum();
        if (length_squared - 1.0).abs() > 1e-9 {
            report(&joint.name, ModelErrorKind::Axis);
        }
        if !is_rotation(&pose.0) {
            report(&joint.name, ModelErrorKind::Rotation);
        }
    }
    let mut frames = BTreeMap::new();
    for (i, frame) in model.frames.iter().enumerate() {
        if frames.insert(&frame.name, i).is_some() {
            report(&frame.name, ModelErrorKind::DuplicateName);
        }
        if frame.link.is_some_and(|link| link >= model.links.len()) {
            report(&frame.name, ModelErrorKind::Parent);
        }
        let Pose { rotation, translation } = &frame.pose;
        if !(rotation.iter().all(|row| finite(row)) && finite(translation)) {
            report(&frame.name, ModelErrorKind::NotFinite);
        } else if !is_rotation(rotation) {
            report(&frame.name, ModelErrorKind::Rotation);
        }
    }
    errors
}

fn finite(figures: &[f64]) -> bool {
    figures.iter().all(|x| x.is_finite())
}

fn is_rotation(r: &[[f64; 3]; 3]) -> bool {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let [x, y, z] = r;
    let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    near(dot(x, x), 1.0)
        && near(dot(y, y), 1.0)
        && near(dot(x, y), 0.0)
        && cross.iter().zip(z).all(|(a, b)| near(*a, *b))
}
