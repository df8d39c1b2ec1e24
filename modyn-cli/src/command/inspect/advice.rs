//! Finds properties of a model that are physically possible, but probably wrong.

use std::collections::{HashMap, HashSet};

use modyn_runtime::Interpreter;
use modyn_runtime::model::{Inertial, Link, Model};
use modyn_runtime::spatial::Pose;

/// A property that the user should check.
pub struct Advice {
    /// The link.
    pub link: String,
    /// The property, and its probable cause.
    pub message: String,
}

/// The radius of gyration of a suspicious link, relative to the robot's size.
const SPREAD: f64 = 2.0;
/// The radius of gyration of a suspiciously small link, relative to the robot's size and in metres.
const SMALL: f64 = 1e-3;
/// The mass of a suspiciously light link, relative to the robot's mass.
const LIGHT: f64 = 1e-6;
/// The mass that a link carries, relative to its own, above which elimination loses digits.
const MAX_CARRIED_RATIO: f64 = 1e4;
/// The number of links with the same inertia, but different masses, that is suspicious.
const REPEATED: usize = 3;

/// Returns advice about all moving links, in order.
pub fn about(model: &Model) -> Vec<Advice> {
    let size = size(model);
    let total = total_mass(model);
    let carried = carried(model);
    let repeated = repeated(model);
    let mut all = Vec::new();
    for link in model.links().iter().filter(|link| link.moving_link.is_some()) {
        let mut say = |message| all.push(Advice { link: link.name.clone(), message });
        let Inertial { mass, center_of_mass, inertia } = link.inertial;
        if mass == 0.0 {
            continue;
        }
        if mass < LIGHT * total {
            say(format!(
                "its mass of {mass} kg is less than a millionth of the robot's {total:.4} kg; in kilograms?"
            ));
        }
        let distance = center_of_mass.iter().map(|x| x * x).sum::<f64>().sqrt();
        if size > 0.0 && distance > SPREAD * size {
            say(format!(
                "its centre of mass is {distance:.4} m away from its origin, in a robot that is {size:.4} m large; \
                 in metres?"
            ));
        }
        if inertia == [0.0; 6] {
            say("it has mass but no rotational inertia: all of its mass is in one point".into());
            continue;
        }
        let moments = link.inertial.principal_moments();
        let radius = (moments.iter().sum::<f64>() / (2.0 * mass)).sqrt();
        if size > 0.0 && radius > SPREAD * size {
            say(format!(
                "its inertia is as if its {mass} kg were {radius:.4} m away from its centre, in a robot that is \
                 {size:.4} m large; in kg m^2?"
            ));
        }
        if radius < SMALL * size.min(1.0) {
            say(format!(
                "its inertia is tiny: as if its {mass} kg were within {radius:.1e} m; in kg m^2?"
            ));
        }
        if repeated(link) {
            say(
                "its inertia is that of other links of other masses, and the same about all axes: \
                 a placeholder?"
                    .into(),
            );
        }
        // The carried mass belongs to the moving body; it is reported for the body's moving link.
        let body = link.moving_link.filter(|&i| model.moving_links()[i].name == link.name);
        if let Some(link) = body
            && carried[link] > MAX_CARRIED_RATIO * model.moving_links()[link].inertial.mass
        {
            say(format!(
                "it carries {:.4} kg, with {:.1e} kg of its own: simulation needs small steps, and single precision \
                 may not do",
                carried[link],
                model.moving_links()[link].inertial.mass
            ));
        }
    }
    all
}

/// Returns the diagonal of the bounding box of all links' origins, at the neutral coordinates, m.
fn size(model: &Model) -> f64 {
    let mut interpreter = Interpreter::<f64>::new(model.clone());
    let mut q = vec![0.0; model.nq()];
    let mut poses = vec![Pose::identity(); model.links().len()];
    if interpreter.neutral(&mut q).is_err() || interpreter.link_poses(&q, &mut poses).is_err() {
        return 0.0;
    }
    let side = |k: usize| {
        let along = poses.iter().map(|pose| pose.translation[k]);
        let (low, high) = along.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    };
    (0..3).map(|k| side(k) * side(k)).sum::<f64>().sqrt()
}

/// Returns the mass of all links, fixed links included, kg.
pub fn total_mass(model: &Model) -> f64 {
    model.links().iter().map(|link| link.inertial.mass).sum()
}

/// Returns, for each moving link, the mass of its descendants, kg.
fn carried(model: &Model) -> Vec<f64> {
    let links = model.moving_links();
    let mut carried = vec![0.0; links.len()];
    // Children come after their parents.
    for (i, link) in links.iter().enumerate().rev() {
        if let Some(parent) = link.parent {
            carried[parent] += link.inertial.mass + carried[i];
        }
    }
    carried
}

/// The bits of an inertia.
type Bits = [u64; 6];

fn bits(link: &Link) -> Bits {
    link.inertial.inertia.map(f64::to_bits)
}

/// Returns whether a link has an isotropic inertia that several links of other masses have, too.
fn repeated(model: &Model) -> impl Fn(&Link) -> bool + '_ {
    let mut masses: HashMap<Bits, Vec<u64>> = HashMap::new();
    for link in model.links().iter().filter(|link| link.moving_link.is_some()) {
        masses.entry(bits(link)).or_default().push(link.inertial.mass.to_bits());
    }
    // For each inertia, whether enough links have it, with different masses.
    let suspicious: HashSet<Bits> = masses
        .into_iter()
        .filter(|(_, m)| m.len() >= REPEATED && m.iter().any(|mass| *mass != m[0]))
        .map(|(inertia, _)| inertia)
        .collect();
    move |link| {
        let inertia = bits(link);
        let [xx, xy, xz, yy, yz, zz] = inertia;
        let is_round = [xy, xz, yz] == [0; 3] && xx == yy && yy == zz;
        is_round && suspicious.contains(&inertia)
    }
}
