//! Warns of limits and lengths that no robot has: an empty range, an effort or velocity of 0,
//! degrees, millimetres.

use core::f64::consts::TAU;

use modyn_runtime::joint::JointType;

use crate::description::{Description, JointRecord, Kind};
use crate::diagnostics::{Code, Place, Report};

/// The width of a range, rad, above which it is probably in degrees: no joint but a winch makes
/// four revolutions.
const WIDE: f64 = 4.0 * TAU;

/// The width of a range, rad, from which its bounds are a way to write that there are none.
const UNBOUNDED: f64 = 1000.0;

/// The length, m, above which it may be in millimetres.
const LONG: f64 = 10.0;

/// The ratio of a length in millimetres to one in metres that is surprising.
const DISPROPORTIONATE: f64 = 100.0;

/// Warns, once for each kind, of the limits and lengths of a description.
pub fn check(description: &Description, report: &mut Report<'_>) {
    let joints = || description.joints.iter().filter(|joint| joint.kind != Kind::Fixed);
    let places = |is_meant: &dyn Fn(&JointRecord) -> bool| -> Vec<Place> {
        let meant = joints().filter(|joint| is_meant(joint));
        meant.map(|joint| (Some(joint.name.at), Some(joint.subject()))).collect()
    };
    let width = |joint: &JointRecord| {
        let limits = joint.limits?;
        Some(limits.upper? - limits.lower?)
    };
    let empty = places(&|joint| width(joint) == Some(0.0));
    let message =
        "the upper limit of its position is the lower one: steps with limits hold it still";
    let help = "write the range of its positions; a joint that rotates without limits is \
                `continuous` in a URDF";
    report.warn_once(Code::EmptyRange, &empty, message, help);

    let zero = places(&|joint| joint.limits.is_some_and(|limits| limits.effort == Some(0.0)));
    let message = "its effort limit is 0: steps with limits apply no joint force";
    let help = "write the largest joint force, N m or N, or omit the limit if there is none";
    report.warn_once(Code::ZeroLimit, &zero, message, help);
    let zero = places(&|joint| joint.limits.is_some_and(|limits| limits.velocity == Some(0.0)));
    let message = "its velocity limit is 0";
    let help = "write the largest velocity, rad/s or m/s, or omit the limit if there is none";
    report.warn_once(Code::ZeroLimit, &zero, message, help);

    let in_degrees = places(&|joint| {
        let is_wide = width(joint).is_some_and(|width| width > WIDE && width < UNBOUNDED);
        joint.kind == Kind::Moving(JointType::Revolute) && is_wide
    });
    let message = "its range is more than four revolutions, as if it were in degrees";
    let help =
        "write the range in rad; a joint that rotates without limits is `continuous` in a URDF";
    report.warn_once(Code::LimitUnit, &in_degrees, message, help);

    let typical = typical_length(description);
    let is_long = |length: f64| length > LONG && length > DISPROPORTIONATE * typical;
    let in_millimetres = places(&|joint| {
        let range = joint.limits.filter(|_| joint.kind == Kind::Moving(JointType::Prismatic));
        let bounds = range.map_or([None; 2], |limits| [limits.lower, limits.upper]);
        let is_far = |bound: f64| is_long(bound.abs()) && bound.abs() < UNBOUNDED;
        offset(joint).is_some_and(is_long) || bounds.into_iter().flatten().any(is_far)
    });
    let message = format!(
        "its origin or its range is more than {DISPROPORTIONATE} times as long as the robot's \
         other lengths, as if it were in mm"
    );
    report.warn_once(Code::LengthUnit, &in_millimetres, &message, "write lengths in m");
}

/// Returns the distance of a joint from its parent's frame, m; `None` for a joint of the world, in
/// which a robot may be anywhere.
fn offset(joint: &JointRecord) -> Option<f64> {
    let of_world = joint.parent.as_ref().is_some_and(|parent| parent.text == "world");
    (!of_world).then(|| norm(joint.origin.translation))
}

/// Returns the median, or the smaller number beside it, of the lengths in a robot that are not
/// zero, m; infinity if there are none.
fn typical_length(description: &Description) -> f64 {
    let offsets = description.joints.iter().filter_map(offset);
    let inertials = description.links.iter().filter_map(|link| link.inertial.as_ref());
    let centers = inertials.map(|record| norm(record.inertial.center_of_mass));
    let mut lengths: Vec<f64> = offsets.chain(centers).filter(|length| *length > 0.0).collect();
    lengths.sort_by(f64::total_cmp);
    let middle = lengths.len().saturating_sub(1) / 2;
    lengths.get(middle).copied().unwrap_or(f64::INFINITY)
}

fn norm(vector: [f64; 3]) -> f64 {
    libm::sqrt(vector.iter().map(|x| x * x).sum())
}
