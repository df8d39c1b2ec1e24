//! The checks of a model: each returns all defects that it finds.

use alloc::{collections::BTreeMap, vec::Vec};

use super::{
    Activation, ActivationDynamics, Actuation, Actuator, AffineLaw, ContactShape, Impedance,
    Inertial, JointFriction, JointSum, Keyframe, Limits, Model, ModelError, ModelErrorKind,
    SoftConstraints, SoftCoupling, SoftTendon, Softness, TendonSpring, TorqueSpeedLine,
    Transmission,
};
use crate::joint::JointType;
use crate::spatial::Pose;

/// Returns all defects of `model` without its loop constraints: of the whole, then of
/// moving links, then of all links.
pub(super) fn check(model: &Model) -> Vec<ModelError> {
    let mut errors = check_model(model);
    let mut report = |name: &str, kind| errors.push(ModelError { name: name.into(), kind });
    if model.moving_links.is_empty() {
        report(&model.name, ModelErrorKind::NoJoint);
    }
    let leads = resolves_to_coordinates(model);
    let mut joints = BTreeMap::new();
    let mut names = BTreeMap::new();
    // The links from the root to the previous link: a depth-first successor is the child of one of
    // them.
    let mut path: Vec<usize> = Vec::new();
    for (i, link) in model.moving_links.iter().enumerate() {
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
            && finite(&joint.second_axis)
            && finite(&[joint.dynamics.armature, joint.dynamics.damping, joint.dynamics.friction])
            && joint.mimic.is_none_or(|mimic| finite(&[mimic.multiplier, mimic.offset]))
            && finite(&[inertial.mass])
            && finite(&inertial.center_of_mass)
            && finite(&inertial.inertia)
            && joint.limits.as_ref().is_none_or(are_numbers))
        {
            report(&link.name, ModelErrorKind::NotFinite);
            continue;
        }
        let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let is_unit = |axis| (dot(axis, axis) - 1.0).abs() < 1e-9;
        if !is_unit(&joint.axis) {
            report(&joint.name, ModelErrorKind::Axis);
        }
        let second = &joint.second_axis;
        if joint.joint_type == JointType::Universal
            && (!is_unit(second) || dot(&joint.axis, second).abs() > 1.0 - 1e-6)
        {
            report(&joint.name, ModelErrorKind::SecondAxis);
        }
        if [joint.dynamics.armature, joint.dynamics.damping, joint.dynamics.friction]
            .iter()
            .any(|x| *x < 0.0)
        {
            report(&joint.name, ModelErrorKind::JointDynamics);
        }
        if !leads[i] {
            report(&joint.name, ModelErrorKind::Mimic);
        }
        if !is_rotation(&pose.0) {
            report(&joint.name, ModelErrorKind::Rotation);
        }
    }
    let mut links = BTreeMap::new();
    for (i, link) in model.links.iter().enumerate() {
        if links.insert(&link.name, i).is_some() {
            report(&link.name, ModelErrorKind::DuplicateName);
        }
        if link.moving_link.is_some_and(|i| i >= model.moving_links.len()) {
            report(&link.name, ModelErrorKind::Parent);
        }
        let Pose { rotation, translation } = &link.pose;
        let Inertial { mass, center_of_mass, inertia } = &link.inertial;
        if !(rotation.iter().all(|row| finite(row))
            && finite(translation)
            && finite(&[*mass])
            && finite(center_of_mass)
            && finite(inertia))
        {
            report(&link.name, ModelErrorKind::NotFinite);
        } else if !is_rotation(rotation) {
            report(&link.name, ModelErrorKind::Rotation);
        }
    }
    errors
}

/// Returns the defects of the model's own numbers: gravity and friction.
pub(super) fn check_model(model: &Model) -> Vec<ModelError> {
    let sound = match model.joint_friction {
        JointFriction::Smooth(width) => width > 0.0 && width.is_finite(),
        _ => true,
    };
    let kinds = [
        (finite(&model.gravity), ModelErrorKind::NotFinite),
        (sound, ModelErrorKind::JointFriction),
    ];
    let bad = kinds.into_iter().filter(|(good, _)| !good);
    bad.map(|(_, kind)| ModelError { name: model.name.clone(), kind }).collect()
}

/// Returns all defects of the gravity compensation of a `model` that has no other defects.
pub(super) fn check_gravity_compensation(model: &Model) -> Vec<ModelError> {
    let factors = &model.gravity_compensation;
    let of_each = factors.is_empty() || factors.len() == model.links.len();
    let kinds = [
        (of_each, ModelErrorKind::GravityCompensation),
        (finite(factors), ModelErrorKind::NotFinite),
    ];
    let bad = kinds.into_iter().filter(|(good, _)| !good);
    bad.map(|(_, kind)| ModelError { name: model.name.clone(), kind }).collect()
}

/// Returns all defects of the springs of a `model` that has no other defects.
pub(super) fn check_springs(model: &Model) -> Vec<ModelError> {
    let mut errors = Vec::new();
    for (i, spring) in model.springs.iter().enumerate() {
        let mut report = |name: &str, kind| errors.push(ModelError { name: name.into(), kind });
        let Some(link) = model.moving_links.get(spring.link) else {
            report(&model.name, ModelErrorKind::Spring);
            continue;
        };
        let joint = &link.joint;
        let reference = &spring.reference;
        if !finite(reference) || !spring.stiffness.is_finite() {
            report(&joint.name, ModelErrorKind::NotFinite);
            continue;
        }
        let quaternion = match joint.joint_type {
            JointType::Spherical => reference.get(0..4),
            JointType::Floating => reference.get(3..7),
            _ => None,
        };
        let square = quaternion.map_or(1.0, |q| q.iter().map(|x| x * x).sum::<f64>());
        if reference.len() != joint.joint_type.nq()
            || (square - 1.0).abs() > 1e-9
            || spring.stiffness < 0.0
            || model.springs[..i].iter().any(|other| other.link == spring.link)
        {
            report(&joint.name, ModelErrorKind::Spring);
        }
    }
    errors
}

/// Returns all defects of the loop constraints of a `model` that has no other defects.
pub(super) fn check_loop_constraints(model: &Model) -> Vec<ModelError> {
    let mut errors = Vec::new();
    let mut names = BTreeMap::new();
    for (i, constraint) in model.loop_constraints.iter().enumerate() {
        let name = &constraint.name;
        let mut report = |kind| errors.push(ModelError { name: name.clone(), kind });
        if names.insert(name, i).is_some() {
            report(ModelErrorKind::DuplicateName);
        }
        let links = constraint.ends.each_ref().map(|end| model.links.get(end.link));
        match links {
            [Some(a), Some(b)] if a.moving_link == b.moving_link => {
                report(ModelErrorKind::LoopConstraintEnds)
            }
            [Some(_), Some(_)] => {}
            _ => report(ModelErrorKind::LoopConstraintLink),
        }
        let axis = constraint.kind.axis();
        let poses = constraint.ends.each_ref().map(|end| &end.pose);
        if !poses
            .iter()
            .all(|pose| pose.rotation.iter().all(|row| finite(row)) && finite(&pose.translation))
            || axis.is_some_and(|axis| !finite(&axis))
        {
            report(ModelErrorKind::NotFinite);
            continue;
        }
        if axis.is_some_and(|axis| (axis.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() > 1e-9) {
            report(ModelErrorKind::Axis);
        }
        if !poses.iter().all(|pose| is_rotation(&pose.rotation)) {
            report(ModelErrorKind::Rotation);
        }
    }
    errors
}

/// Returns all defects of the contacts of a `model` that is sound without them.
pub(super) fn check_contacts(model: &Model) -> Vec<ModelError> {
    let mut errors = Vec::new();
    let loops = model.loop_constraints.iter().map(|constraint| (&constraint.name, 0));
    let mut names: BTreeMap<_, usize> = loops.collect();
    for contact in &model.contacts {
        let name = &contact.name;
        let mut report = |kind| errors.push(ModelError { name: name.clone(), kind });
        if names.insert(name, 0).is_some() {
            report(ModelErrorKind::DuplicateName);
        }
        match model.links.get(contact.end.link) {
            None => report(ModelErrorKind::ContactLink),
            Some(link) if link.moving_link.is_none() => report(ModelErrorKind::ContactFixed),
            Some(_) => {}
        }
        let Pose { rotation, translation } = &contact.end.pose;
        if !(rotation.iter().all(|row| finite(row)) && finite(translation)) {
            report(ModelErrorKind::NotFinite);
        } else if !is_rotation(rotation) {
            report(ModelErrorKind::Rotation);
        }
    }
    errors
}

/// Returns all defects of the soft constraints of a `model` that is sound without them.
pub(super) fn check_soft_constraints(model: &Model) -> Vec<ModelError> {
    let mut errors = Vec::new();
    let soft = &model.soft_constraints;
    let SoftConstraints { shapes, joints, loops, tendons, couplings, references, .. } = soft;
    for shape in shapes {
        let mut report = |kind| errors.push(ModelError { name: shape.name.clone(), kind });
        match model.links.get(shape.end.link) {
            None => report(ModelErrorKind::ContactLink),
            Some(link) if link.moving_link.is_none() => report(ModelErrorKind::ContactFixed),
            Some(_) => {}
        }
        let Pose { rotation, translation } = &shape.end.pose;
        let sizes = shape.shape.numbers();
        let has_sizes = match &shape.shape {
            ContactShape::Points(points) => !points.is_empty(),
            _ => sizes.iter().all(|size| *size > 0.0),
        };
        if !(rotation.iter().all(|row| finite(row)) && finite(translation) && finite(&sizes)) {
            report(ModelErrorKind::NotFinite);
        } else if !is_rotation(rotation) {
            report(ModelErrorKind::Rotation);
        } else if !has_sizes || shape.surface.check().is_err() {
            report(ModelErrorKind::TouchingShape);
        }
    }
    let is_ground_sound = soft.ground.is_none_or(|surface| surface.check().is_ok());
    let is_positive = |x: Option<f64>| x.is_none_or(|x| x.is_finite() && x > 0.0);
    if ![soft.impratio, soft.time_step].into_iter().all(is_positive) || !is_ground_sound {
        errors.push(ModelError { name: model.name.clone(), kind: ModelErrorKind::TouchingShape });
    }
    for softness in joints {
        let link = model.moving_links.get(softness.joint);
        let name = link.map_or(&model.name, |link| &link.joint.name).clone();
        let mut report = |kind| errors.push(ModelError { name: name.clone(), kind });
        let numbers = [softness.limit, softness.friction].map(softness_numbers);
        if !(finite(numbers.as_flattened()) && softness.margin.is_finite()) {
            report(ModelErrorKind::NotFinite);
        } else if link.is_none() {
            report(ModelErrorKind::JointSoftness);
        }
    }
    for softness in loops {
        let constraint = model.loop_constraints.get(softness.constraint);
        let name = constraint.map_or(&model.name, |constraint| &constraint.name).clone();
        let mut report = |kind| errors.push(ModelError { name: name.clone(), kind });
        let numbers = softness_numbers(softness.softness);
        if !(finite(&numbers) && softness.torque_scale.is_finite()) {
            report(ModelErrorKind::NotFinite);
        } else if constraint.is_none() {
            report(ModelErrorKind::LoopSoftness);
        }
    }
    for reference in references {
        let link = model.moving_links.get(reference.joint);
        let name = link.map_or(&model.name, |link| &link.joint.name).clone();
        if !reference.coordinate.is_finite() {
            errors.push(ModelError { name, kind: ModelErrorKind::NotFinite });
        } else if link.is_none_or(|link| link.joint.joint_type.nv() != 1) {
            errors.push(ModelError { name, kind: ModelErrorKind::JointSoftness });
        }
    }
    for tendon in tendons {
        let SoftTendon { range, margin, limit, dry_friction, friction, spring, .. } = tendon;
        let TendonSpring { stiffness, rest, damping } = *spring;
        let numbers = [*dry_friction, stiffness, damping, *margin, rest[0], rest[1]];
        let softness = [*limit, *friction].map(softness_numbers);
        let is_finite = finite(&numbers) && finite(softness.as_flattened());
        let ranges = [*range, Some(rest)].into_iter().flatten();
        let mut report = |kind| errors.push(ModelError { name: tendon.name.clone(), kind });
        if let Some(kind) = defect_of_sums(model, core::slice::from_ref(&tendon.length)) {
            report(kind);
        } else if !(is_finite && range.is_none_or(|range| finite(&range))) {
            report(ModelErrorKind::NotFinite);
        } else if numbers[..3].iter().any(|number| *number < 0.0)
            || ranges.into_iter().any(|[low, high]| low > high)
        {
            report(ModelErrorKind::Tendon);
        }
    }
    for coupling in couplings {
        let SoftCoupling { sums, polynomial, softness, .. } = coupling;
        let mut report = |kind| errors.push(ModelError { name: coupling.name.clone(), kind });
        if let Some(kind) = defect_of_sums(model, sums) {
            report(kind);
        } else if !(finite(polynomial) && finite(&softness_numbers(*softness))) {
            report(ModelErrorKind::NotFinite);
        }
    }
    errors
}

/// Returns the defect of sums of joint coordinates, if there is one.
fn defect_of_sums(model: &Model, sums: &[JointSum]) -> Option<ModelErrorKind> {
    let joints = || sums.iter().flat_map(|sum| &sum.joints);
    let is_single = |link: usize| {
        model.moving_links.get(link).is_some_and(|link| link.joint.joint_type.nv() == 1)
    };
    let offsets = sums.iter().map(|sum| sum.offset);
    let mut numbers = joints().map(|joint| joint.coefficient).chain(offsets);
    if !joints().all(|joint| is_single(joint.link)) {
        Some(ModelErrorKind::Transmission)
    } else if !numbers.all(f64::is_finite) {
        Some(ModelErrorKind::NotFinite)
    } else {
        None
    }
}

/// Returns the numbers of a softness that must be finite.
fn softness_numbers(softness: Softness<f64>) -> [f64; 6] {
    let Impedance { least, most, width, midpoint, .. } = softness.impedance;
    let [first, second] = softness.reference;
    [least, most, width, midpoint, first, second]
}

/// Returns all defects of the keyframes of a `model` that is sound without them.
pub(super) fn check_keyframes(model: &Model) -> Vec<ModelError> {
    let mut errors = Vec::new();
    let mut names = BTreeMap::new();
    for keyframe in &model.keyframes {
        let Keyframe { name, q, qd, ctrl, act } = keyframe;
        let mut report = |kind| errors.push(ModelError { name: name.clone(), kind });
        if names.insert(name, ()).is_some() {
            report(ModelErrorKind::DuplicateName);
        }
        let fits = |numbers: &[f64], count: usize| [0, count].contains(&numbers.len());
        let has_counts = q.len() == model.nq()
            && fits(qd, model.nv())
            && fits(ctrl, model.actuation.actuators.len())
            && fits(act, model.actuation.states());
        if !has_counts {
            report(ModelErrorKind::KeyframeLength);
        } else if ![q, qd, ctrl, act].into_iter().all(|numbers| finite(numbers)) {
            report(ModelErrorKind::NotFinite);
        } else if model.quaternions().any(|(_, at)| {
            let square: f64 = q[at..at + 4].iter().map(|x| x * x).sum();
            (square - 1.0).abs() > 1e-9
        }) {
            report(ModelErrorKind::KeyframeQuaternion);
        }
    }
    errors
}

/// Returns all defects of the actuators of a `model` that is sound without them.
pub(super) fn check_actuation(model: &Model) -> Vec<ModelError> {
    let mut errors = Vec::new();
    let Actuation { actuators, tendons, joint_force_ranges } = &model.actuation;
    let is_single = |link: usize| {
        model.moving_links.get(link).is_some_and(|link| link.joint.joint_type.nv() == 1)
    };
    let mut names = BTreeMap::new();
    let mut delays = 0_usize;
    for actuator in actuators {
        let mut report = |kind| errors.push(ModelError { name: actuator.name.clone(), kind });
        let before = delays;
        delays = delays.saturating_add(actuator.delay);
        if before <= Actuation::MAX_DELAYS && delays > Actuation::MAX_DELAYS {
            report(ModelErrorKind::Delay);
        }
        if names.insert(&actuator.name, ()).is_some() {
            report(ModelErrorKind::DuplicateName);
        }
        let is_known = match actuator.transmission {
            Transmission::Joint(link) => is_single(link),
            Transmission::Tendon(tendon) => tendon < tendons.len(),
        };
        if !is_known {
            report(ModelErrorKind::Transmission);
        }
        check_actuator(actuator, &mut report);
    }
    let mut names = BTreeMap::new();
    for tendon in tendons {
        let mut report = |kind| errors.push(ModelError { name: tendon.name.clone(), kind });
        if names.insert(&tendon.name, ()).is_some() {
            report(ModelErrorKind::DuplicateName);
        }
        if !tendon.joints.iter().all(|joint| is_single(joint.link)) {
            report(ModelErrorKind::Transmission);
        }
        let mut coefficients = tendon.joints.iter().map(|joint| joint.coefficient);
        if !(tendon.offset.is_finite() && coefficients.all(f64::is_finite)) {
            report(ModelErrorKind::NotFinite);
        }
        if tendon.force_range.is_some_and(|[low, high]| !(low < high && low <= 0.0 && high >= 0.0))
        {
            report(ModelErrorKind::ActuatorRange);
        }
    }
    let mut limited = BTreeMap::new();
    for joint in joint_force_ranges {
        let link = model.moving_links.get(joint.link);
        let name = link.map_or(&model.name, |link| &link.joint.name).clone();
        let mut report = |kind| errors.push(ModelError { name: name.clone(), kind });
        if !is_single(joint.link) {
            report(ModelErrorKind::Transmission);
        } else if limited.insert(joint.link, ()).is_some() {
            report(ModelErrorKind::DuplicateName);
        }
        if !is_range(joint.range) {
            report(ModelErrorKind::ActuatorRange);
        }
    }
    errors
}

/// Reports the defects of an actuator's own numbers.
fn check_actuator(actuator: &Actuator, report: &mut impl FnMut(ModelErrorKind)) {
    let Actuator { gear, gain, bias, control_range, force_range, activation, .. } = actuator;
    if let Some(TorqueSpeedLine { stall_force, no_load_speed }) = actuator.torque_speed_line {
        let slope = stall_force / no_load_speed;
        if ![stall_force, no_load_speed, slope].iter().all(|&x| x > 0.0 && x.is_finite()) {
            report(ModelErrorKind::TorqueSpeedLine);
        }
    }
    let laws = [gain, bias]
        .map(|AffineLaw { constant, length, velocity }| finite(&[*constant, *length, *velocity]));
    if !(gear.is_finite() && laws == [true; 2]) {
        report(ModelErrorKind::NotFinite);
    }
    let range = activation.and_then(|activation| activation.range);
    if ![*control_range, *force_range, range].into_iter().flatten().all(is_range) {
        report(ModelErrorKind::ActuatorRange);
    }
    if let Some(Activation { dynamics, .. }) = activation
        && let ActivationDynamics::Filter(time) | ActivationDynamics::ExactFilter(time) = dynamics
        && !(*time >= 0.0 && time.is_finite())
    {
        report(ModelErrorKind::ActivationTime);
    }
}

/// Returns whether the lower end of a range is below the upper end.
fn is_range([low, high]: [f64; 2]) -> bool {
    low < high
}

/// Returns, for each link, whether its joint has a coordinate of its own, or its chain of leaders
/// ends at such a joint. Every mimic joint is visited once.
fn resolves_to_coordinates(model: &Model) -> Vec<bool> {
    let single =
        |i: usize| model.moving_links.get(i).is_some_and(|link| link.joint.joint_type.nq() == 1);
    let mut resolves: Vec<Option<bool>> = alloc::vec![None; model.moving_links.len()];
    for start in 0..model.moving_links.len() {
        let mut at = start;
        let mut path = Vec::new();
        let good = loop {
            if let Some(resolves) = resolves[at] {
                break resolves;
            }
            // A chain that returns to a joint of its own path is a cycle.
            resolves[at] = Some(false);
            path.push(at);
            match model.moving_links[at].joint.mimic {
                None => break true,
                Some(mimic) if !(single(at) && single(mimic.leader)) => break false,
                Some(mimic) => at = mimic.leader,
            }
        };
        path.into_iter().for_each(|i| resolves[i] = Some(good));
    }
    resolves.into_iter().map(|resolves| resolves == Some(true)).collect()
}

/// Returns whether all numbers are finite.
fn finite(numbers: &[f64]) -> bool {
    numbers.iter().all(|x| x.is_finite())
}

/// Returns whether no limit is NaN; infinite limits are allowed and mean no limit.
fn are_numbers(limits: &Limits) -> bool {
    let Limits { lower, upper, velocity, effort } = limits;
    [lower, upper, velocity, effort].into_iter().flatten().all(|limit| !limit.is_nan())
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

#[cfg(test)]
mod tests {
    use alloc::string::String;

    use super::*;
    use crate::model::{DEFAULT_GRAVITY, Joint, Link, Mimic, MovingLink};

    /// Returns a model of parallel links whose joints follow these leaders; the last joint is
    /// spherical.
    fn model(leaders: &[Option<usize>]) -> Result<Model, Vec<ModelError>> {
        let link = |(i, leader): (usize, &Option<usize>)| {
            let last = i + 1 == leaders.len();
            let joint_type = if last { JointType::Spherical } else { JointType::Revolute };
            let name = alloc::format!("{i}");
            let mut joint = Joint::new(name.clone(), joint_type, [0.0, 0.0, 1.0], Pose::identity());
            joint.mimic = leader.map(|leader| Mimic { leader, multiplier: -2.0, offset: 1.0 });
            MovingLink { name, parent: None, joint, inertial: Inertial::default() }
        };
        let links = leaders.iter().enumerate().map(link).collect();
        Model::new("r", DEFAULT_GRAVITY, links, Vec::new())
    }

    /// Each matrix breaks one of the conditions alone.
    #[test]
    fn rotations_keep_lengths_angles_and_orientation() {
        use crate::spatial::Quaternion;
        let w = crate::spatial::Vector3([0.4, -1.1, 0.7]);
        let good = Quaternion::exp(w).matrix().0;
        assert!(is_rotation(&good));
        let cross = |[x, y]: [[f64; 3]; 2]| {
            let entry = |i: usize, j: usize| x[i] * y[j] - x[j] * y[i];
            [x, y, [entry(1, 2), entry(2, 0), entry(0, 1)]]
        };
        let [x, y, z] = good;
        let scaled = |v: [f64; 3], by: f64| v.map(|x| by * x);
        let sheared: [f64; 3] = core::array::from_fn(|i| 0.6 * x[i] + 0.8 * y[i]);
        for bad in [
            cross([scaled(x, 1.01), y]),
            cross([x, scaled(y, 0.99)]),
            cross([x, sheared]),
            [x, y, scaled(z, -1.0)],
            [x, y, scaled(z, 1.01)],
            [y, x, z],
            [[0.0; 3]; 3],
            [[f64::NAN; 3]; 3],
        ] {
            assert!(!is_rotation(&bad), "{bad:?}");
        }
    }

    /// Limits and the links' own inertias become numbers of the generated text, where NaN is no
    /// literal.
    #[test]
    fn stated_values_must_be_finite() {
        let good = model(&[None, None]).expect("good");
        let kinds = |change: &dyn Fn(&mut Limits, &mut Inertial)| -> Vec<ModelErrorKind> {
            let mut links = good.moving_links().to_vec();
            let mut limits = Limits { lower: None, upper: None, velocity: None, effort: None };
            let mut inertial = Inertial::default();
            change(&mut limits, &mut inertial);
            links[0].joint.limits = Some(limits);
            let link =
                Link { name: "f".into(), moving_link: Some(0), pose: Pose::identity(), inertial };
            let model = Model::new("r", DEFAULT_GRAVITY, links, alloc::vec![link]);
            model.err().unwrap_or_default().into_iter().map(|error| error.kind).collect()
        };
        let unlimited = Some(f64::INFINITY);
        assert_eq!(kinds(&|limits, _| (limits.upper, limits.effort) = (unlimited, unlimited)), []);
        let bad = [ModelErrorKind::NotFinite];
        assert_eq!(kinds(&|limits, _| limits.lower = Some(f64::NAN)), bad);
        assert_eq!(kinds(&|limits, _| limits.upper = Some(f64::NAN)), bad);
        assert_eq!(kinds(&|limits, _| limits.velocity = Some(-f64::NAN)), bad);
        assert_eq!(kinds(&|limits, _| limits.effort = Some(f64::NAN)), bad);
        assert_eq!(kinds(&|_, inertial| inertial.mass = f64::NAN), bad);
        assert_eq!(kinds(&|_, inertial| inertial.center_of_mass[1] = f64::INFINITY), bad);
        assert_eq!(kinds(&|_, inertial| inertial.inertia[5] = f64::NAN), bad);
    }

    #[test]
    fn mimic_joints_must_have_a_leader() {
        let bad = |leaders: &[Option<usize>]| -> Vec<String> {
            let errors = model(leaders).expect_err("refused");
            assert!(errors.iter().all(|error| error.kind == ModelErrorKind::Mimic));
            errors.into_iter().map(|error| error.name).collect()
        };
        // A cycle, and a joint that leads into it; itself; a missing leader; a leader with several
        // coordinates.
        assert_eq!(bad(&[Some(1), Some(2), Some(1), None, None]), ["0", "1", "2"]);
        assert_eq!(bad(&[Some(0), None, None]), ["0"]);
        assert_eq!(bad(&[Some(9), Some(0), None]), ["0", "1"]);
        assert_eq!(bad(&[Some(1), Some(3), None, None]), ["0", "1"]);
        assert_eq!(bad(&[None, Some(0), Some(0)]), ["2"]);

        let model = model(&[Some(2), Some(3), Some(1), None, None]).expect("good");
        let resolved = |i| model.mimic(i).map(|m| (m.leader, m.multiplier, m.offset));
        let expected = [Some((3, -8.0, 3.0)), Some((3, -2.0, 1.0)), Some((3, 4.0, -1.0)), None];
        assert_eq!([0, 1, 2, 3].map(resolved), expected);
        assert_eq!((model.q_range(0), model.v_range(2), model.nq()), (0..1, 0..1, 5));
    }
}
