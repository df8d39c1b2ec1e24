//! Constraints of `<equality>`: joints that follow others, soft couplings, and loops.

use std::collections::hash_map::Entry;
use std::collections::{BTreeSet, HashMap};

use modyn_runtime::model::{LoopConstraintKind, LoopSoftness, SoftCoupling};
use modyn_runtime::spatial::Pose;

use super::bodies::Bodies;
use super::check::{filled, list};
use super::contact_law::softness;
use super::item::Item;
use super::joints::displacement;
use super::pose::{from_quaternion, relative};
use super::table;
use crate::description::{EndRecord, Kind, Located, LoopRecord, Mimic, MimicRecord, TakenNames};
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

/// Returns the joints, at most two, whose displacements from the drawn pose have a constant sum with
/// these factors, if the first of two sums is a constant plus `slope` times the second one; `None`
/// for more joints.
fn exact([first, second]: [&[(usize, f64)]; 2], slope: f64) -> Option<Vec<(usize, f64)>> {
    let second = if slope == 0.0 { &[] } else { second };
    // The joints of the longer sum that the shorter one cannot cancel.
    if first.len().abs_diff(second.len()) > 2 {
        return None;
    }
    let mut sum = Sum::default();
    first.iter().for_each(|&(joint, factor)| sum.add(joint, factor));
    second.iter().for_each(|&(joint, factor)| sum.add(joint, -slope * factor));
    sum.factors.retain(|(_, factor)| *factor != 0.0);
    (sum.factors.len() <= 2).then_some(sum.factors)
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
    /// Adds the constraints of all models. Joints that follow others have no coordinate of their own,
    /// unless `mimic` says so.
    pub fn equality(&mut self, mimic: Mimic) {
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
                "joint" => self.coupling(&item, &names, mimic),
                "tendon" => self.tendon_coupling(&item, &mut names, mimic),
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
    fn coupling(&mut self, item: &Item<'e>, names: &Names, mimic: Mimic) {
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
        let is_linear = leader.is_none() || (2..5).all(|i| coefficient(i) == 0.0);
        if is_linear && mimic != Mimic::Independent {
            return self.follow(at, follower, leader, coefficient(0));
        }
        let leader = leader.map(|(leader, _)| (leader, 1.0));
        let sums = [&[(follower, 1.0)][..], leader.as_slice()];
        self.soft_coupling(item, sums, &coefficients, mimic);
    }

    /// Adds a coupling that acts in `step` only. `sums` are of displacements from the drawn pose.
    fn soft_coupling(
        &mut self,
        item: &Item<'e>,
        sums: [&[(usize, f64)]; 2],
        polynomial: &[f64],
        mimic: Mimic,
    ) {
        let at = item.element().at;
        let sums = sums.map(|sum| {
            let drawn = sum.iter().map(|(joint, factor)| factor * self.references[*joint].drawn);
            let offset = 0.0 - drawn.sum::<f64>();
            self.joint_sum(sum, offset, at)
        });
        let number = self.couplings.len() + 1;
        let name = item.name().unwrap_or_else(|| format!("coupling_{number}"));
        if mimic != Mimic::Independent {
            self.ignored.couplings.push((Some(at), None));
        }
        self.couplings.push(SoftCoupling {
            name,
            sums,
            polynomial: filled(Some(polynomial), [0.0; 5]),
            softness: softness(item, ["solref", "solimp"], &mut self.ignored.powers),
        });
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
        let drawn = self.references[follower].drawn;
        match leader.filter(|(_, multiplier)| *multiplier != 0.0) {
            Some((leader, multiplier)) => {
                let offset = drawn + constant - multiplier * self.references[leader].drawn;
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

    /// Returns the names of the fixed tendons whose length a constraint holds exactly.
    pub fn held_tendons(&self, mimic: Mimic) -> BTreeSet<String> {
        if !self.models[0].settings.flags.equality || mimic == Mimic::Independent {
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
            let joints = names.tendons.get(&name)?.as_ref()?;
            (joints.len() <= 2).then_some(name)
        });
        held.collect()
    }

    /// Adds the constraint of fixed tendons: exact if it is linear and concerns one joint or two.
    fn tendon_coupling(&mut self, item: &Item<'e>, names: &mut Names, mimic: Mimic) {
        let at = item.element().at;
        let coefficients = item.text("polycoef").and_then(list).unwrap_or_else(|| vec![0.0, 1.0]);
        let coefficient = |i: usize| coefficients.get(i).copied().unwrap_or(0.0);
        let mut ends: [&[(usize, f64)]; 2] = [&[]; 2];
        for (attribute, end) in ["tendon1", "tendon2"].into_iter().zip(&mut ends) {
            let Some(name) = item.element().text(attribute) else { continue };
            let Some(Some(tendon)) = names.tendons.get(&item.naming.name(name)) else {
                let message = "a constraint of a tendon that is not `<fixed>` is not read";
                let help = "write `active=\"false\"`, or constrain joints or a `<fixed>` tendon";
                self.report.error(Code::NotRead, at, None, message, help);
                return;
            };
            *end = tendon;
        }
        let [first, second] = ends;
        names.joints_of_tendons += first.len() + second.len();
        if names.joints_of_tendons > MAX_JOINTS_OF_TENDONS {
            let message =
                format!("the tendons of constraints have more than {MAX_JOINTS_OF_TENDONS} joints");
            let help = "constrain tendons of two joints, or write `<joint>` constraints";
            self.report.error(Code::Excessive, at, None, message, help);
            return;
        }
        let is_linear = second.is_empty() || (2..5).all(|i| coefficient(i) == 0.0);
        let is_exact = is_linear && mimic != Mimic::Independent;
        match exact(ends, coefficient(1)).filter(|_| is_exact).as_deref() {
            // A constraint that moves no joint has no effect.
            Some([]) => {}
            Some([(joint, factor)]) => self.follow(at, *joint, None, coefficient(0) / factor),
            Some([(joint, factor), (leader, other)]) => {
                let leader = Some((*leader, -other / factor));
                self.follow(at, *joint, leader, coefficient(0) / factor);
            }
            _ => self.soft_coupling(item, ends, &coefficients, mimic),
        }
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
