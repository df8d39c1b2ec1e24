//! Finds joints without inertia: the pivots of the articulated-body elimination (Featherstone
//! 1987).
//!
//! A pivot is the inertia at a joint while the joints of its descendants are free. The pivots are
//! computed at one configuration in general position. A pivot that is zero there is zero in nearly
//! every configuration. The mass matrix is then singular, and forward dynamics divides by zero.
//!
//! The check runs when inertias change at run time. The compiler checks descriptions by itself.
//!
//! A mimic joint is locked, and its inertia is added to its leader's as a rotor.
//!
//! The compiler removes the described inertias of `runtime_inertia` links before inertia is moved
//! to parents, and adds the arguments to their bodies. It emits this check for the joints that move
//! no inertia when all these arguments are zero; often there are none, and no check. The
//! interpreter runs the check at each change. Payloads need no check, since more inertia never
//! makes a mass matrix singular.

use alloc::{vec, vec::Vec};

use crate::Scalar;
use crate::joint::JointTransform;
use crate::mechanism::coordinates::CoordinateSpace;
use crate::mechanism::{Dof, Mechanism};
use crate::spatial::{ArticulatedInertia, SpatialAxis};

/// A pivot counts as zero below this many units of the scalar's precision, relative to the inertia
/// about the same axis with the child joints locked.
const CANCELLED: f64 = 256.0;
/// A pivot counts as zero below this many units of the scalar's precision, relative to the inertia
/// about all axes together: a rotation of the axes leaves that much rounding.
const ROTATED: f64 = 32.0;

/// The memory of [`pivots`].
#[derive(Clone, Debug)]
pub struct PivotWorkspace<S> {
    /// Coordinates in general position.
    q: Vec<S>,
    motions: Vec<JointTransform<S>>,
    /// For each body, the inertia of its descendants: with their joints free, and with their joints
    /// locked.
    free: Vec<ArticulatedInertia<S>>,
    locked: Vec<ArticulatedInertia<S>>,
    /// For each entry of qd, the inertia that its mimic joints add.
    followers: Vec<S>,
}

impl<S: Scalar> PivotWorkspace<S> {
    /// Returns the memory for `model`.
    #[must_use]
    pub fn new(model: &Mechanism<S>) -> Self {
        let none = vec![zero_inertia(); model.bodies.len()];
        Self {
            q: configuration(model),
            motions: Vec::with_capacity(model.bodies.len()),
            free: none.clone(),
            locked: none,
            followers: vec![S::zero(); model.nv],
        }
    }
}

fn zero_inertia<S: Scalar>() -> ArticulatedInertia<S> {
    ArticulatedInertia::from_fn(|_, _| S::zero())
}

/// Returns coordinates in general position, the same on every host. Angles and displacements are
/// between 0.3 and 6.3; rotations have large angles and oblique axes.
fn configuration<S: Scalar>(model: &Mechanism<S>) -> Vec<S> {
    let spread = |entry: usize| {
        #[allow(clippy::cast_precision_loss)] // Precise up to 2^52 entries.
        let golden = entry as f64 * 0.618_033_988_749_895;
        golden - libm::floor(golden)
    };
    let mut q = vec![0.0; model.nq];
    for coordinates in &model.coordinates {
        let at = coordinates.q;
        let (numbers, rotation) = match coordinates.space {
            CoordinateSpace::Line { .. } => (at..at + 1, None),
            CoordinateSpace::Rotation => (at..at, Some(at)),
            CoordinateSpace::Pose => (at..at + 3, Some(at + 3)),
        };
        for entry in numbers {
            q[entry] = 0.3 + 6.0 * spread(entry);
        }
        if let Some(start) = rotation {
            let oblique: [f64; 4] = core::array::from_fn(|k| 0.2 + spread(start + k));
            let length = libm::sqrt(oblique.iter().map(|x| x * x).sum());
            for (entry, x) in q[start..start + 4].iter_mut().zip(oblique) {
                *entry = x / length;
            }
        }
    }
    q.into_iter().map(S::from_f64).collect()
}

/// Computes the pivot of each entry of qd into `pivots`: the inertia at this joint while the joints
/// of its descendants are free, kg or kg m^2.
///
/// A pivot within the rounding of a scalar of precision `epsilon` is exactly zero, or NaN.
/// `epsilon` is the distance from 1 to the next number.
pub fn pivots<S: Scalar>(
    model: &Mechanism<S>,
    epsilon: S,
    workspace: &mut PivotWorkspace<S>,
    pivots: &mut [S],
) {
    let PivotWorkspace { q, motions, .. } = workspace;
    motions.clear();
    motions.extend(model.bodies.iter().map(|body| body.motion(q)));
    workspace.followers.fill(S::zero());
    if model.has_mimics() {
        let mut followers = core::mem::take(&mut workspace.followers);
        sweep(model, epsilon, workspace, &[], |dof, pivot| {
            if dof.multiplier.is_some() {
                dof.add(dof.scale(pivot), &mut followers);
            }
        });
        workspace.followers = followers;
    }
    let followers = core::mem::take(&mut workspace.followers);
    sweep(model, epsilon, workspace, &followers, |dof, pivot| {
        if dof.multiplier.is_none() {
            pivots[dof.v] = pivot;
        }
    });
    workspace.followers = followers;
}

/// Eliminates the joints from the leaves to the root, and passes the pivot of each degree of
/// freedom to `give`.
fn sweep<S: Scalar>(
    model: &Mechanism<S>,
    epsilon: S,
    workspace: &mut PivotWorkspace<S>,
    followers: &[S],
    mut give: impl FnMut(&Dof<S>, S),
) {
    let PivotWorkspace { motions, free, locked, .. } = workspace;
    free.fill(zero_inertia());
    locked.fill(zero_inertia());
    let units = |n: f64| epsilon * S::from_f64(n);
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let own_inertia = body.inertia.articulated();
        let whole = own_inertia + free[i];
        let next_locked = own_inertia + locked[i];
        let mut left = whole;
        for dof in model.dofs_of(i).iter().rev() {
            let component = dof.component;
            let column = left.column(component).components();
            let block = match dof.axis() {
                SpatialAxis::Linear(_) => &next_locked.translational,
                SpatialAxis::Angular(_) => &next_locked.rotational,
            };
            let rounding = units(CANCELLED) * next_locked.entry(component, component)
                + units(ROTATED) * (block.xx + block.yy + block.zz);
            let inertia =
                (rounding - column[component]).select_nonnegative(S::zero(), column[component]);
            let mut pivot = dof.armature.map_or(inertia, |armature| inertia + armature);
            if dof.multiplier.is_none()
                && let Some(&following) = followers.get(dof.v)
            {
                pivot = pivot + following;
            }
            give(dof, pivot);
            if dof.multiplier.is_some() {
                continue;
            }
            // A joint with a zero pivot counts as locked for the joints of its ancestors.
            let reciprocal = (-pivot).select_nonnegative(S::zero(), pivot.recip());
            left = ArticulatedInertia::from_fn(|row, other| {
                left.entry(row, other) - column[row] * column[other] * reciprocal
            });
        }
        if let Some(parent) = body.parent {
            free[parent] = free[parent] + body.articulated_to_parent(&motions[i], &left);
            locked[parent] = locked[parent] + body.articulated_to_parent(&motions[i], &whole);
        }
    }
}
