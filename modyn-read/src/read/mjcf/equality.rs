//! Constraints of `<equality>`: joints that follow others, and loops.

use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap};

use modyn_runtime::model::{LoopConstraintKind, LoopSoftness};
use modyn_runtime::spatial::Pose;

use super::bodies::Bodies;
use super::check::list;
use super::contact_law::softness;
use super::item::Item;
use super::joints::displacement;
use super::pose::{from_quaternion, relative};
use super::table;
use crate::description::{EndRecord, Kind, Located, LoopRecord, MimicRecord, TakenNames};
use crate::diagnostics::Code;
use crate::work;

/// A frame on a link, and its pose in the world as the model is drawn.
struct End {
    link: usize,
    on_link: Pose<f64>,
    drawn: Pose<f64>,
}

/// The names to which constraints refer, and the names that are taken.
struct Names {
    joints: HashMap<String, usize>,
    /// The joints of each tendon and their coefficients, each joint once; `None` if the tendon is
    /// not fixed, or a joint does not exist.
    tendons: HashMap<String, Option<Vec<(usize, f64)>>>,
    /// The names of joints and loops.
    taken: TakenNames,
    /// The joints of the tendons of all constraints so far.
    joints_of_tendons: usize,
}

/// Returns whether a constraint acts from the start.
fn is_active(constraint: &Item) -> bool {
    constraint.text("active") != Some("false")
}

/// The largest number of joints of the tendons of all constraints: each constraint looks at all
/// joints of its tendons.
const MAX_JOINTS_OF_TENDONS: usize = 1_000_000;

/// A sum of the displacements of joints with factors, each joint once.
#[derive(Default)]
struct Sum {
    factors: Vec<(usize, f64)>,
    places: HashMap<usize, usize>,
}

impl Sum {
    /// Adds the displacement of a joint with this factor.
    fn add(&mut self, joint: usize, factor: f64) {
        work::count(1);
        let next = self.factors.len();
        match self.places.entry(joint) {
            Entry::Occupied(place) => self.factors[*place.get()].1 += factor,
            Entry::Vacant(place) => {
                place.insert(next);
                self.factors.push((joint, factor));
            }
        }
    }
}

/// Returns the joints of a fixed tendon and their coefficients; `None` for another tendon, or if a
/// joint does not exist.
pub fn fixed_tendon(tendon: &Item, joints: &HashMap<String, usize>) -> Option<Vec<(usize, f64)>> {
    if tendon.element().name != "fixed" {
        return None;
    }
    let mut sum = Sum::default();
    for joint in tendon.element().named("joint") {
        let name = tendon.naming.name(joint.text("joint")?);
        let coefficient = joint.text("coef").and_then(list)?.first().copied()?;
        sum.add(*joints.get(&name)?, coefficient);
    }
    sum.factors.retain(|(_, factor)| *factor != 0.0);
    Some(sum.factors)
}

impl<'e> Bodies<'e, '_, '_> {
    /// Adds the constraints of all models.
    pub fn equality(&mut self) {
        if !self.models[0].settings.flags.equality {
            return;
        }
        let constraints = self.of_section("equality");
        if constraints.is_empty() {
            return;
        }
        let mut names = self.names();
        for item in constraints {
            let element = item.element();
            let is_sound = self.models[item.model].is_sound(&item.chain);
            if !is_sound || !is_active(&item) {
                continue;
            }
            match element.name.as_str() {
                "joint" => self.coupling(&item, &names),
                "tendon" => self.tendon_coupling(&item, &mut names),
                "connect" | "weld" => self.closure(&item, &mut names.taken),
                name if table::row("equality", name).is_some() => {
                    let message = format!("the constraint `<{name}>` of `<equality>` is not read");
                    let help = "remove it, or write `active=\"false\"`";
                    self.report.error(Code::NotRead, element.at, None, message, help);
                }
                _ => {}
            }
        }
    }

    fn names(&self) -> Names {
        let known_joints = self.description.joints_by_name().into_iter();
        let joints = known_joints.map(|(name, joint)| (name.to_owned(), joint)).collect();
        // The first of equal names counts.
        let elements = self.of_section("tendon").into_iter().rev();
        let tendons =
            elements.filter_map(|tendon| Some((tendon.name()?, fixed_tendon(&tendon, &joints))));
        Names {
            tendons: tendons.collect(),
            joints,
            taken: TakenNames::new(self.description.joint_names()),
            joints_of_tendons: 0,
        }
    }

    /// Adds a joint that follows another one, or that does not move.
    fn coupling(&mut self, item: &Item<'e>, names: &Names) {
        let at = item.element().at;
        let Some(follower) = self.joint_of(item, "joint1", names) else { return };
        let coefficients = item.text("polycoef").and_then(list).unwrap_or_else(|| vec![0.0, 1.0]);
        let coefficient = |i: usize| coefficients.get(i).copied().unwrap_or(0.0);
        let leader = match item.element().text("joint2") {
            Some(_) => match self.joint_of(item, "joint2", names) {
                Some(leader) => Some((leader, coefficient(1))),
                None => return,
            },
            None => None,
        };
        if leader.is_some() && (2..5).any(|i| coefficient(i) != 0.0) {
            return self.refuse_polynomial(at, Some(follower));
        }
        self.follow(at, follower, leader, coefficient(0));
    }

    fn refuse_polynomial(&mut self, at: usize, joint: Option<usize>) {
        let subject = joint.map(|joint| self.description.joints[joint].subject());
        let message =
            "it follows another joint by a polynomial of a degree above one, which is not read";
        let help = "write `polycoef=\"offset multiplier 0 0 0\"` for a linear relation, or \
                    `active=\"false\"`: both joints \
                    then move freely";
        self.report.error(Code::NotRead, at, subject.as_ref(), message, help);
    }

    /// Lets a joint follow another one: its displacement from the drawn pose is a constant plus the
    /// displacement of the leader times a multiplier.
    fn follow(&mut self, at: usize, follower: usize, leader: Option<(usize, f64)>, constant: f64) {
        let is_constrained = |joint: usize| {
            let joint = &self.description.joints[joint];
            joint.mimic.is_some() || joint.kind == Kind::Fixed
        };
        if is_constrained(follower) {
            let subject = self.description.joints[follower].subject();
            let message = "a second constraint of `<equality>` determines it";
            let help = "keep one of them, or write `active=\"false\"`";
            self.report.error(Code::NotRead, at, Some(&subject), message, help);
            return;
        }
        let drawn = self.drawn[follower];
        match leader.filter(|(_, multiplier)| *multiplier != 0.0) {
            Some((leader, multiplier)) => {
                let offset = drawn + constant - multiplier * self.drawn[leader];
                let leader =
                    Located { text: self.description.joints[leader].name.text.clone(), at };
                self.description.joints[follower].mimic =
                    Some(MimicRecord { leader, multiplier, offset });
            }
            None => {
                let joint = &mut self.description.joints[follower];
                let moved = displacement(joint.kind, joint.axis, drawn + constant);
                joint.origin = joint.origin.compose(&moved);
                joint.kind = Kind::Fixed;
                self.held.insert(follower, drawn + constant);
            }
        }
    }

    /// Returns the names of the fixed tendons whose length a constraint holds.
    pub fn held_tendons(&self) -> BTreeSet<String> {
        if !self.models[0].settings.flags.equality {
            return BTreeSet::new();
        }
        let names = self.names();
        let all = self.of_section("equality").into_iter();
        let constraints = all.filter(|item| {
            item.element().name == "tendon"
                && is_active(item)
                && item.element().text("tendon2").is_none()
        });
        let held = constraints.filter_map(|item| {
            let name = item.naming.name(item.element().text("tendon1")?);
            names.tendons.get(&name)?.as_ref().map(|_| name)
        });
        held.collect()
    }

    /// Adds the constraint of fixed tendons that concern one joint or two.
    fn tendon_coupling(&mut self, item: &Item<'e>, names: &mut Names) {
        let at = item.element().at;
        let coefficients = item.text("polycoef").and_then(list).unwrap_or_else(|| vec![0.0, 1.0]);
        let coefficient = |i: usize| coefficients.get(i).copied().unwrap_or(0.0);
        // Of the displacements of joints from the drawn pose: their sum with these factors is a
        // constant.
        let mut sum = Sum::default();
        let mut ends = Vec::new();
        for (attribute, scale) in [("tendon1", 1.0), ("tendon2", -coefficient(1))] {
            let Some(name) = item.element().text(attribute) else { continue };
            if attribute == "tendon2" && (2..5).any(|i| coefficient(i) != 0.0) {
                return self.refuse_polynomial(at, None);
            }
            let Some(Some(tendon)) = names.tendons.get(&item.naming.name(name)) else {
                let message = "a constraint of a tendon that is not `<fixed>` is not read";
                let help = "write `active=\"false\"`, or constrain joints or a `<fixed>` tendon";
                self.report.error(Code::NotRead, at, None, message, help);
                return;
            };
            if scale != 0.0 {
                ends.push((tendon, scale));
            }
        }
        // The joints of the longer tendon that the shorter one cannot cancel.
        let lengths = |(tendon, _): &(&Vec<(usize, f64)>, f64)| tendon.len();
        let shorter = if ends.len() == 2 { ends.iter().map(lengths).min() } else { None };
        let longer = ends.iter().map(lengths).max().unwrap_or(0);
        if longer - shorter.unwrap_or(0) > 2 {
            return self.refuse_tendon(at);
        }
        for (tendon, scale) in ends {
            names.joints_of_tendons += tendon.len();
            if names.joints_of_tendons > MAX_JOINTS_OF_TENDONS {
                let message = format!(
                    "the tendons of constraints have more than {MAX_JOINTS_OF_TENDONS} joints"
                );
                let help = "constrain tendons of two joints, or write `<joint>` constraints";
                self.report.error(Code::Excessive, at, None, message, help);
                return;
            }
            tendon.iter().for_each(|(joint, factor)| sum.add(*joint, scale * factor));
        }
        let Sum { mut factors, .. } = sum;
        factors.retain(|(_, factor)| *factor != 0.0);
        match factors[..] {
            [(joint, factor)] => self.follow(at, joint, None, coefficient(0) / factor),
            [(joint, factor), (leader, other)] => {
                self.follow(at, joint, Some((leader, -other / factor)), coefficient(0) / factor);
            }
            _ => self.refuse_tendon(at),
        }
    }

    fn refuse_tendon(&mut self, at: usize) {
        let message = "a constraint of a tendon is read if it concerns one joint or two";
        let help =
            "write it as `<joint>` constraints, or `active=\"false\"`: the joints then move freely";
        self.report.error(Code::NotRead, at, None, message, help);
    }

    /// Returns the index of the joint that an attribute names; `None` with an error in the report,
    /// unless a part of an attached model lacks it.
    fn joint_of(&mut self, item: &Item<'e>, attribute: &str, names: &Names) -> Option<usize> {
        let attribute_given = item.element().attribute(attribute);
        let name = attribute_given.map(|given| item.naming.name(&given.value)).unwrap_or_default();
        let joint = names.joints.get(&name).copied();
        if joint.is_none() && item.naming.prefix.is_empty() {
            let at = attribute_given.map_or(item.element().at, |given| given.at);
            let message = format!(
                "`{attribute}` of `<equality>` is the joint `{name}`, which does not exist"
            );
            self.report.error(Code::MimicTarget, at, None, message, "name a joint of a body");
        }
        joint
    }

    /// Adds the loop of a `<connect>` or a `<weld>`.
    fn closure(&mut self, item: &Item<'e>, taken: &mut TakenNames) {
        let element = item.element();
        let is_weld = element.name == "weld";
        let has_sites = element.text("site1").is_some();
        let kind = if has_sites { "site" } else { "body" };
        let [Some(one), Some(other)] = [1, 2].map(|i| self.end(item, &format!("{kind}{i}"))) else {
            return;
        };
        // A constraint between bodies that do not move relative to each other has no effect.
        if self.carriers[one.link] == self.carriers[other.link] {
            return;
        }
        let is_point = !is_weld || item.number("torquescale") == Some(0.0);
        let at_point = |point: [f64; 3]| Pose { translation: point, ..Pose::identity() };
        let (one_pose, other_pose) = if has_sites {
            (one.on_link, other.on_link)
        } else if !is_weld {
            let anchor = at_point(item.numbers("anchor").unwrap_or([0.0; 3]));
            let drawn = one.drawn.compose(&anchor);
            (anchor, at_point(relative(&other.drawn, &drawn).translation))
        } else {
            let written: Option<[f64; 7]> = item.numbers("relpose");
            let given = written.and_then(|[x, y, z, a, b, c, d]| {
                Some(Pose { rotation: from_quaternion([a, b, c, d])?, translation: [x, y, z] })
            });
            let written = given.unwrap_or_else(|| relative(&one.drawn, &other.drawn));
            let anchor = at_point(item.numbers("anchor").unwrap_or([0.0; 3]));
            (written.compose(&anchor), anchor)
        };
        let number = self.description.loops.len() + 1;
        let name = item.name().unwrap_or_else(|| format!("{}_{number}", element.name));
        let end = |link: usize, pose| EndRecord {
            link: Some(self.description.links[link].name.text.clone()),
            at: Some(element.at),
            pose,
        };
        let ends = [end(one.link, one_pose), end(other.link, other_pose)];
        let kind = if is_point { LoopConstraintKind::Point } else { LoopConstraintKind::Rigid };
        self.description.loop_softnesses.push(LoopSoftness {
            constraint: self.description.loops.len(),
            softness: softness(item, ["solref", "solimp"], &mut self.ignored.powers),
            torque_scale: item.number("torquescale").unwrap_or(1.0),
        });
        self.description.loops.push(LoopRecord {
            name: taken.unique(&name, "loop"),
            at: Some(element.at),
            kind: Some(kind),
            ends,
        });
    }

    /// Returns the body or the site that an attribute names; without the attribute, the world.
    /// `None` with an error in the report, or if an attached part lacks it.
    fn end(&mut self, item: &Item<'e>, attribute: &str) -> Option<End> {
        let is_site = attribute.starts_with("site");
        let attribute_given = item.element().attribute(attribute);
        let name = match attribute_given {
            Some(given) if given.value == "world" && !is_site => "world".into(),
            Some(given) => item.naming.name(&given.value),
            None => "world".into(),
        };
        let end = if is_site {
            self.sites.get(&name).map(|(link, pose, _)| End {
                link: *link,
                on_link: *pose,
                drawn: Pose::identity(),
            })
        } else {
            self.places.get(&name).map(|(link, drawn)| End {
                link: *link,
                on_link: Pose::identity(),
                drawn: *drawn,
            })
        };
        if end.is_none() && item.naming.prefix.is_empty() {
            let at = attribute_given.map_or(item.element().at, |given| given.at);
            let what = if is_site { "site" } else { "body" };
            let message = format!(
                "`{attribute}` of `<{}>` is the {what} `{name}`, which does not exist",
                item.element().name
            );
            self.report.error(
                Code::LoopLink,
                at,
                None,
                message,
                format!("name a {what} of the model"),
            );
        }
        end
    }
}
