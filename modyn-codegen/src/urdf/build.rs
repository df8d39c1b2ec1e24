//! From a tree of links and joints to the links that move: what is fixed together becomes one.

use modyn_runtime::{
    joint::JointType,
    model::{self, DEFAULT_GRAVITY, Frame, Inertial, InertialDefect, Joint, Link, Model},
    spatial::Pose,
};

use super::{
    Base, Friction, Mimic, ReadOptions, felt,
    joint::{JointPart, Kind, MimicPart},
    loops, mimics,
    parts::{LinkPart, Parts},
    report::{Place, Report},
    tree::Tree,
};
use crate::error::{Code, Severity, Subject};

/// A moving body: a link that a joint moves, and all that is fixed to it.
struct Body {
    /// The moving link, then those fixed to it, as indices into the parts.
    links: Vec<usize>,
    /// The joint; `None` for a base that floats.
    joint: Option<usize>,
    /// Whether all figures of its inertia could be read.
    sound: bool,
    /// Whether its inertia and its joint are known, so that its motion can be judged.
    known: bool,
}

/// The bodies while they are put together.
struct Assembly {
    links: Vec<Link>,
    bodies: Vec<Body>,
    /// By link of the description: the moving link that carries it, and its pose there.
    place: Vec<(Option<usize>, Pose<f64>)>,
}

/// The model; `None` with errors in the report.
pub fn build(
    parts: &Parts,
    tree: &Tree,
    leaders: &[Option<usize>],
    options: &ReadOptions,
    report: &mut Report<'_>,
) -> Option<Model> {
    let mut assembly = assemble(parts, tree, options.base, report);
    assembly.follow(parts, leaders, options.mimic != Mimic::Independent);
    let Assembly { mut links, mut bodies, place } = assembly;
    if links.is_empty() {
        let help = "make a joint `revolute`, `continuous` or `prismatic`, or let the base float";
        report.error(Code::NoMovingJoint, parts.at, None, "no joint of the robot moves", help);
    }
    for (link, body) in links.iter_mut().zip(&mut bodies) {
        let negative = check_masses(parts, &body.links, report);
        let sound = body.sound
            && check_inertia(parts, &body.links, &link.inertial, negative, options, report);
        if !sound || negative {
            // Its error is reported; with this, the motions of the other bodies can be judged.
            body.known = false;
            link.inertial = STAND_IN;
        }
    }
    check_densities(parts, &bodies, report);
    inactive_friction(parts, &bodies, options.friction, report);
    let carriers: Vec<_> = place.iter().map(|(carrier, _)| *carrier).collect();
    let loop_constraints = loops::loop_constraints(parts, &options.loops, &carriers, report);
    let errors = report.errors();
    let frames = parts.links.iter().zip(place).map(|(part, (link, pose))| Frame {
        name: part.name.text.into(),
        link,
        pose,
        inertial: part.inertial.as_ref().map_or_else(Inertial::default, |own| own.inertial),
    });
    let gravity = options.gravity.unwrap_or(DEFAULT_GRAVITY);
    let model = Model::new(parts.name, gravity, links, frames.collect())
        .and_then(|model| model.with_friction(options.friction.unwrap_or_default()))
        .and_then(|model| {
            if errors > 0 { Ok(model) } else { model.with_loop_constraints(loop_constraints) }
        });
    let model = match model {
        Ok(model) => model,
        // One of the errors above.
        Err(_) if errors > 0 => return None,
        Err(errors) => {
            // All of this has been checked. Should a check be missing, the user hears of it here.
            for error in errors {
                let subject = Subject::Robot(parts.name.into());
                let help = "this is a fault of modyn: please report it with the file";
                report.error(Code::InvalidModel, parts.at, Some(&subject), error.to_string(), help);
            }
            return None;
        }
    };
    check_motions(parts, &bodies, &model, report);
    (report.errors() == 0).then_some(model)
}

/// Puts each link where it belongs: what is fixed to a moving link is merged into it.
fn assemble(parts: &Parts, tree: &Tree, base: Base, report: &mut Report<'_>) -> Assembly {
    let place = vec![(None, Pose::identity()); parts.links.len()];
    let mut assembly = Assembly { links: Vec::new(), bodies: Vec::new(), place };
    for &link in &tree.order {
        let part = &parts.links[link];
        if let Some(j) = tree.joint[link] {
            let joint = &parts.joints[j];
            let above = tree.parent[j].map_or((None, Pose::identity()), |p| assembly.place[p]);
            let origin = placed(joint, &above.1, report);
            assembly.place[link] = match moving(joint, origin) {
                None => (above.0, origin),
                Some(moved) => {
                    let known = joint.sound && joint.kind != Kind::Unknown;
                    assembly.push(part, above.0, moved, Some(j), known)
                }
            };
            if let (Some(carrier), false) = (assembly.place[link].0, joint.sound) {
                assembly.bodies[carrier].known = false;
            }
        } else if base == Base::Floating {
            let up = [0.0, 0.0, 1.0];
            let joint = Joint::new(base_name(parts), JointType::Floating, up, Pose::identity());
            assembly.place[link] = assembly.push(part, None, joint, None, true);
        }
        assembly.carry(link, part);
    }
    assembly
}

impl Assembly {
    /// Takes a link that moves; its place is itself.
    fn push(
        &mut self,
        part: &LinkPart,
        parent: Option<usize>,
        joint: Joint,
        index: Option<usize>,
        known: bool,
    ) -> (Option<usize>, Pose<f64>) {
        let name = part.name.text.into();
        self.links.push(Link { name, parent, joint, inertial: Inertial::default() });
        self.bodies.push(Body { links: Vec::new(), joint: index, sound: true, known });
        (Some(self.links.len() - 1), Pose::identity())
    }

    /// Adds the inertia of a link of the description to the moving link that carries it.
    fn carry(&mut self, link: usize, part: &LinkPart) {
        // What is fixed to the world moves nothing.
        let (Some(carrier), pose) = self.place[link] else { return };
        let body = &mut self.bodies[carrier];
        body.links.push(link);
        if let Some(own) = &part.inertial {
            let sum = &mut self.links[carrier].inertial;
            *sum = sum.merged(&own.inertial.transformed(&pose));
            body.sound &= own.sound;
        }
    }

    /// Has joints follow their leaders, which may stand anywhere in the tree.
    fn follow(&mut self, parts: &Parts, leaders: &[Option<usize>], follows: bool) {
        let mut moved_by = vec![None; parts.joints.len()];
        for (i, body) in self.bodies.iter().enumerate() {
            if let Some(joint) = body.joint {
                moved_by[joint] = Some(i);
            }
        }
        for (link, body) in self.links.iter_mut().zip(&mut self.bodies) {
            let Some(joint) = body.joint else { continue };
            let Some(mimic) = &parts.joints[joint].mimic else { continue };
            if let Some(leader) = leaders[joint].and_then(|leader| moved_by[leader]) {
                let MimicPart { multiplier, offset, .. } = *mimic;
                link.joint.mimic = Some(model::Mimic { leader, multiplier, offset });
            } else if follows {
                body.known = false;
            }
        }
    }
}

/// A joint's frame in that of the body that carries it, where its parent stands at `above`.
fn placed(joint: &JointPart, above: &Pose<f64>, report: &mut Report<'_>) -> Pose<f64> {
    let origin = above.compose(&joint.origin);
    if origin.translation.iter().all(|x| x.abs() < LARGEST) {
        return origin;
    }
    let message = "its place is too far away to compute with";
    let help = "write `xyz` in m";
    report.error(Code::NotFinite, joint.name.at, Some(&joint.subject()), message, help);
    Pose::identity()
}

/// The joint, if it moves.
fn moving(part: &JointPart, origin: Pose<f64>) -> Option<Joint> {
    let joint_type = match part.kind {
        Kind::Fixed => return None,
        Kind::Moving(joint_type) => joint_type,
        // It is an error already; the rest can be checked all the same.
        Kind::Unknown => JointType::Revolute,
    };
    Some(Joint {
        second_axis: part.second_axis,
        limits: part.limits,
        drive: part.drive,
        ..Joint::new(part.name.text, joint_type, part.axis, origin)
    })
}

/// What the joint is called that the base floats by: a name that no other joint has.
fn base_name(parts: &Parts) -> String {
    let taken = parts.joints_by_name();
    let numbered = (1..).map(|n| format!("floating_base_{n}"));
    let mut names = std::iter::once("floating_base".into()).chain(numbered);
    names.find(|name: &String| !taken.contains_key(name.as_str())).unwrap_or_default()
}

/// Which joints' motions depend on known figures alone: of the bodies that they carry, and of all
/// that follow them.
fn judged(bodies: &[Body], model: &Model) -> Vec<bool> {
    let mut judged: Vec<bool> = bodies.iter().map(|body| body.known).collect();
    if judged.iter().all(|&known| known) {
        return judged;
    }
    for leader in (0..bodies.len()).filter_map(|i| Some(model.mimic(i)?.leader)) {
        judged[leader] = false;
    }
    // Children come after their parents.
    for (i, link) in model.links().iter().enumerate().rev() {
        if let (false, Some(parent)) = (judged[i], link.parent) {
            judged[parent] = false;
        }
    }
    judged
}

/// Warns of links that move, but have no inertial, nor has a link that is fixed to them.
fn missing_inertials(parts: &Parts, bodies: &[Body], unfelt: &[usize], report: &mut Report<'_>) {
    let mut refused = vec![false; bodies.len()];
    unfelt.iter().for_each(|&i| refused[i] = true);
    let places: Vec<Place> = bodies
        .iter()
        .zip(refused)
        // The joint of a refused one has said so.
        .filter(|(body, refused)| {
            !refused && body.links.iter().all(|&l| parts.links[l].inertial.is_none())
        })
        .filter_map(|(body, _)| body.links.iter().map(|&l| &parts.links[l]).find(|l| !l.auxiliary))
        .map(|link| (link.name.at, Some(link.subject())))
        .collect();
    let message = "it moves, but has no `<inertial>`, so it counts as massless";
    let help =
        "write its mass and inertia, or an `<inertial>` with zeros if it is massless on purpose";
    report.warn_once(Code::MissingInertial, &places, message, help);
}

/// Warns of links of moving bodies whose mass is impossibly large for their inertia.
fn check_densities(parts: &Parts, bodies: &[Body], report: &mut Report<'_>) {
    let links = bodies.iter().flat_map(|body| &body.links).map(|&link| &parts.links[link]);
    let mut places = Vec::new();
    let mut message = String::new();
    for (link, own) in links.filter_map(|link| Some((link, link.inertial.as_ref()?))) {
        let Some(found) = implausible(&own.inertial).filter(|_| own.sound) else { continue };
        if places.is_empty() {
            message = found;
        }
        places.push((own.mass_at, Some(link.subject())));
    }
    report.warn_once(Code::ImplausibleMass, &places, &message, IMPLAUSIBLE_HELP);
}

/// Denser than any material (osmium has 22,600), kg/m^3.
const DENSEST: f64 = 30_000.0;

/// A smaller radius of gyration is that of a point mass after rounding, m.
const POINT: f64 = 1e-6;

/// Returns a message if no body can have this mass and inertia at once. Among all bodies of one volume and mass, a
/// ball has the least inertia, so a body is at least as dense as the ball of its mass and inertia.
pub fn implausible(inertial: &Inertial) -> Option<String> {
    let Inertial { mass, inertia: [xx, _, _, yy, _, zz], .. } = *inertial;
    // A ball of radius r has the moment 2/5 m r^2 about each axis.
    let radius = libm::sqrt((xx + yy + zz) / 3.0 / (0.4 * mass));
    let density = mass / (4.0 / 3.0 * core::f64::consts::PI * radius * radius * radius);
    (radius > POINT && density > DENSEST).then(|| {
        format!(
            "its mass of {mass} kg is too large for its inertia: even a ball with both, of radius {:.3} mm, has \
             {density:.1e} kg/m^3, and no material has more than 2.3e4",
            radius * 1e3
        )
    })
}

pub const IMPLAUSIBLE_HELP: &str =
    "write the mass in kg (not in g), and the inertia in kg m^2 about the centre of mass";

/// Warns of damping and friction if no option says whether they act.
fn inactive_friction(
    parts: &Parts,
    bodies: &[Body],
    chosen: Option<Friction>,
    report: &mut Report<'_>,
) {
    if chosen.is_some() {
        return;
    }
    let places: Vec<Place> = bodies
        .iter()
        .filter_map(|body| body.joint)
        .map(|joint| &parts.joints[joint])
        .filter(|joint| joint.drive.damping > 0.0 || joint.drive.friction > 0.0)
        .map(|joint| (joint.drive_at, Some(joint.subject())))
        .collect();
    let drives =
        || bodies.iter().filter_map(|body| body.joint).map(|joint| &parts.joints[joint].drive);
    let message = match (drives().any(|d| d.damping > 0.0), drives().any(|d| d.friction > 0.0)) {
        (true, false) => "its damping does not act",
        (false, _) => "its friction does not act",
        (true, true) => "its damping and friction do not act",
    };
    let help = "set the option `friction` to `viscous`, `coulomb` or `smooth` if they are to act, to `none` if not";
    report.warn_once(Code::InactiveFriction, &places, message, help);
}

/// Whether each joint feels inertia, and follows in a ratio that one can compute with.
fn check_motions(parts: &Parts, bodies: &[Body], model: &Model, report: &mut Report<'_>) {
    for i in mimics::too_large(model) {
        let joint = bodies[i].joint.map(|j| &parts.joints[j]);
        if let Some((joint, mimic)) = joint.and_then(|j| Some((j, j.mimic.as_ref()?))) {
            let (message, help) = (mimics::TOO_LARGE, mimics::TOO_LARGE_HELP);
            let subject = joint.subject();
            report.error(Code::NotFinite, mimic.leader.at, Some(&subject), message, help);
        }
    }
    let judged = judged(bodies, model);
    let mut unfelt = felt::unfelt(model);
    unfelt.retain(|&i| judged[i]);
    missing_inertials(parts, bodies, &unfelt, report);
    for i in unfelt {
        let code = Code::NoInertiaFelt;
        if let Some(joint) = bodies[i].joint.map(|j| &parts.joints[j]) {
            let message = felt::message(&model.links()[i].name);
            report.error(code, joint.name.at, Some(&joint.subject()), message, felt::HELP);
        } else if let Some(root) = bodies[i].links.first().map(|&link| &parts.links[link]) {
            let (message, help) = (felt::BASE_MESSAGE, felt::BASE_HELP);
            report.error(code, root.name.at, Some(&root.subject()), message, help);
        }
    }
}

/// Whether a link of these has a mass below 0. That is wrong wherever it hangs: in a sum it would go
/// unseen. No option lets it through, since the equations have no meaning with it.
fn check_masses(parts: &Parts, links: &[usize], report: &mut Report<'_>) -> bool {
    let errors = report.errors();
    for link in links.iter().map(|&link| &parts.links[link]) {
        if let Some(own) = link.inertial.as_ref().filter(|own| own.inertial.mass < 0.0) {
            let message = format!("the mass is {} kg", own.inertial.mass);
            let help = "write a mass of at least 0";
            report.error(Code::NegativeMass, own.mass_at, Some(&link.subject()), message, help);
        }
    }
    report.errors() > errors
}

/// Stands in for an inertia that is not known.
const STAND_IN: Inertial =
    Inertial { mass: 1.0, center_of_mass: [0.0; 3], inertia: [1.0, 0.0, 0.0, 1.0, 0.0, 1.0] };

/// Checks whether a body made of these links can exist; `false` with an error in the report.
fn check_inertia(
    parts: &Parts,
    links: &[usize],
    whole: &Inertial,
    negative: bool,
    options: &ReadOptions,
    report: &mut Report<'_>,
) -> bool {
    let with_inertial =
        |link: &usize| Some((&parts.links[*link], parts.links[*link].inertial.as_ref()?));
    let Some((&moving, fixed)) = links.split_first() else {
        return true;
    };
    let moving = &parts.links[moving];
    let at =
        links.iter().find_map(with_inertial).map_or(moving.name.at, |(_, inertial)| inertial.at);
    let figures = [whole.mass].into_iter().chain(whole.center_of_mass).chain(whole.inertia);
    if !figures.clone().all(|x| x.abs() < LARGEST) {
        report.error(Code::NotFinite, at, Some(&moving.subject()), TOO_LARGE, TOO_LARGE_HELP);
        return false;
    }
    let severity = options.unphysical_inertia;
    if negative {
        // The sum says nothing then; the parts that are to be repaired say for themselves.
        for (link, own) in links.iter().filter_map(with_inertial) {
            let Inertial { mass, .. } = own.inertial;
            let repaired = Inertial { mass: mass.abs(), ..own.inertial };
            if let Some(defect) = repaired.defect().filter(|_| mass < 0.0) {
                let (code, help) = advice(&defect);
                report.add(severity, code, own.at, Some(&link.subject()), defect.to_string(), help);
            }
        }
    } else if let Some(defect) = whole.defect() {
        let (code, help) = advice(&defect);
        let message = format!("{defect}{}", fixed_names(parts, fixed));
        report.add(severity, code, at, Some(&moving.subject()), message, help);
        return severity == Severity::Warning;
    }
    true
}

/// Beyond this, products of figures could overflow.
pub const LARGEST: f64 = 1e60;
pub const TOO_LARGE: &str = "the figures of the inertia are too large to compute with";
pub const TOO_LARGE_HELP: &str = "write kg, m and kg m^2";

/// The kind of a defect, and what to do about it.
pub fn advice(defect: &InertialDefect) -> (Code, String) {
    let (code, help) = match defect {
        InertialDefect::NegativeMass(_) => {
            return (Code::NegativeMass, "write a mass of at least 0".into());
        }
        InertialDefect::InertiaWithoutMass => {
            (Code::InertiaWithoutMass, "write the mass, or zeros for the rotational inertia")
        }
        InertialDefect::NotPositiveSemidefinite(_) => (
            Code::IndefiniteInertia,
            "check the signs of ixy, ixz, iyz and whether the inertia is about the centre of mass",
        ),
        _ => (
            Code::TriangleInequality,
            "check ixx, iyy, izz and whether the inertia is about the centre of mass",
        ),
    };
    (code, format!("{help}; or take it as it is with the option `unphysical_inertia = warn`"))
}

fn fixed_names(parts: &Parts, fixed: &[usize]) -> String {
    let mut heavy = fixed
        .iter()
        .map(|&link| &parts.links[link])
        .filter(|link| link.inertial.is_some())
        .map(|link: &LinkPart| format!("`{}`", link.name.text));
    let names: Vec<String> = heavy.by_ref().take(10).collect();
    let more = if heavy.next().is_some() { ", ..." } else { "" };
    if names.is_empty() {
        String::new()
    } else {
        format!(" (together with what is fixed to it: {}{more})", names.join(", "))
    }
}
