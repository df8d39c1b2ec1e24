//! Tendons: limits, friction, springs and dampers of `<fixed>` tendons, which act in the function
//! `step`, and the forces of all tendons, which act in no other function.

use std::collections::{BTreeSet, HashMap};

use modyn_runtime::model::{JointFriction, JointSum, SoftTendon, TendonJoint, TendonSpring};

use super::bodies::Bodies;
use super::check::list;
use super::contact_law::softness;
use super::equality::fixed_tendon;
use super::item::Item;
use super::joints::{is_limited, polynomial};
use crate::description::{Kind, ReadOptions, TakenNames};
use crate::diagnostics::{Code, Place};

/// The largest number of tendons and couplings that act in `step`.
const MAX_TENDONS: usize = 1_000;

/// The attributes of the spring and the damper of a tendon.
const SPRING: [&str; 2] = ["stiffness", "damping"];

/// The forces of tendons that do not act in all functions, and the places of these tendons.
#[derive(Default)]
struct LeftOut {
    places: Vec<Place>,
    kinds: BTreeSet<String>,
}

impl LeftOut {
    fn add(&mut self, item: &Item<'_>, kinds: &[&str]) {
        if !kinds.is_empty() {
            self.places.push((Some(item.element().at), None));
            self.kinds.extend(kinds.iter().map(|name| format!("`{name}`")));
        }
    }

    fn kinds(&self, separator: &str) -> String {
        self.kinds.iter().map(String::as_str).collect::<Vec<_>>().join(separator)
    }
}

impl<'e> Bodies<'e, '_, '_> {
    /// Adds the `<fixed>` tendons that act in `step`, and reports the forces of tendons that do not
    /// act in all functions. A constraint can hold the length of a tendon: its forces then do
    /// nothing.
    pub fn tendons(&mut self, options: &ReadOptions) {
        let held = self.held_tendons(options.mimic);
        let known_joints = self.description.joints_by_name().into_iter();
        let joints: HashMap<String, usize> =
            known_joints.map(|(name, joint)| (name.to_owned(), joint)).collect();
        let [mut unread, mut only_in_steps] = <[LeftOut; 2]>::default();
        let mut rubbing = Vec::new();
        let mut names = TakenNames::default();
        for item in self.of_section("tendon") {
            let element = item.element();
            if item.name().is_some_and(|name| held.contains(&name)) {
                continue;
            }
            if item.sets("armature") {
                let message = "the `armature` of a tendon is not read";
                let help = "write `armature=\"0\"`, or give it to the joints";
                self.report.error(Code::NotRead, element.at, None, message, help);
            }
            let is_sound = self.models[item.model].is_sound(&item.chain);
            match fixed_tendon(&item, &joints).filter(|_| is_sound) {
                None => unread.add(&item, &self.acting(&item, &["frictionloss"])),
                Some(sum) => {
                    let [read, left_out]: [Vec<&str>; 2] = match is_linear(&item) {
                        true => [self.acting(&item, &[]), Vec::new()],
                        false => [Vec::new(), self.acting(&item, &[])],
                    };
                    only_in_steps.add(&item, &read);
                    unread.add(&item, &left_out);
                    let given = item.name().unwrap_or_else(|| "tendon".into());
                    let name = names.unique(&given, "tendon");
                    let tendon = self.soft_tendon(&item, name, &sum);
                    if tendon.dry_friction > 0.0 {
                        rubbing.push((Some(element.at), None));
                    }
                    let acts = tendon.range.is_some()
                        || tendon.dry_friction > 0.0
                        || tendon.spring != TendonSpring::default();
                    if acts {
                        self.tendons.push(tendon);
                    }
                }
            }
        }
        self.report_forces(options, [&unread, &only_in_steps]);
        if options.joint_friction != Some(JointFriction::None) {
            let message = "the friction of a tendon acts in `step` only";
            let help = "give its forces with the joint forces of the other functions, or set the option \
                        `joint_friction = none`: it then acts nowhere";
            self.report.warn_once(Code::InactiveFriction, &rubbing, message, help);
        }
    }

    /// Returns the forces of a tendon that act: of its spring, its damper, and of these kinds.
    fn acting(&self, item: &Item<'e>, others: &[&'static str]) -> Vec<&'static str> {
        let flags = self.models[0].settings.flags;
        let acts = |name: &&str| match *name {
            "stiffness" => flags.springs,
            "damping" => flags.dampers,
            _ => flags.friction,
        };
        let kinds = SPRING.iter().chain(others).copied();
        kinds.filter(|name| acts(name) && item.sets(name)).collect()
    }

    fn report_forces(&mut self, options: &ReadOptions, [unread, only_in_steps]: [&LeftOut; 2]) {
        let severity = options.unsupported_forces;
        let message = format!("forces of a tendon ({}) are not read", unread.kinds(", "));
        let help = format!(
            "give them with the joint forces: write 0 for {} in it, or set the option `unsupported_forces = warn`",
            unread.kinds(" and ")
        );
        self.report.add_once(severity, Code::NotRead, &unread.places, &message, &help);
        let message =
            format!("forces of a tendon ({}) act in `step` only", only_in_steps.kinds(", "));
        let help = format!(
            "give them with the joint forces: write 0 for {} in it; or set the option `unsupported_forces = warn`: \
             the other functions are without them",
            only_in_steps.kinds(" and ")
        );
        self.report.add_once(severity, Code::NotRead, &only_in_steps.places, &message, &help);
    }

    /// Returns a `<fixed>` tendon with these joints and coefficients. Errors are in the report.
    fn soft_tendon(&mut self, item: &Item<'e>, name: String, sum: &[(usize, f64)]) -> SoftTendon {
        let at = item.element().at;
        let flags = self.models[0].settings.flags;
        let model = &self.models[item.model];
        let range: Option<[f64; 2]> =
            item.numbers("range").filter(|_| is_limited(item, "limited", "range", model));
        if range.is_some_and(|[lower, upper]| lower > upper) {
            let message = "the lower limit of a tendon is above the upper one";
            let help = "write the lower limit first";
            self.report.error(Code::InvertedLimits, at, None, message, help);
        }
        let [dry_friction, stiffness, damping] =
            ["frictionloss", "stiffness", "damping"].map(|name| polynomial(item, name).0);
        if [dry_friction, stiffness, damping].iter().any(|number| *number < 0.0) {
            let message = "`frictionloss`, `stiffness` or `damping` of a tendon is negative";
            let help = "write numbers of at least 0: damping and friction oppose the motion, and springs pull back";
            self.report.error(Code::NegativeJointDynamics, at, None, message, help);
        }
        let is_read = is_linear(item);
        let stiffness = if flags.springs && is_read { stiffness } else { 0.0 };
        let rest = match item.text("springlength").and_then(list).as_deref() {
            Some([length]) if *length != -1.0 => [*length; 2],
            Some([low, high]) if [*low, *high] != [-1.0; 2] => [*low, *high],
            _ => {
                let terms =
                    sum.iter().map(|(joint, factor)| factor * self.references[*joint].spring);
                [terms.sum(); 2]
            }
        };
        if rest[0] > rest[1] {
            let message = "`springlength` of a tendon is an empty range";
            let help = "write the smaller length first";
            self.report.error(Code::InvertedLimits, at, None, message, help);
        }
        let spring = TendonSpring {
            stiffness,
            rest: if stiffness > 0.0 { rest } else { [0.0; 2] },
            damping: if flags.dampers && is_read { damping } else { 0.0 },
        };
        SoftTendon {
            name,
            length: self.joint_sum(sum, 0.0, at),
            range,
            margin: item.number("margin").unwrap_or(0.0),
            limit: softness(item, ["solreflimit", "solimplimit"], &mut self.ignored.powers),
            dry_friction: if flags.friction { dry_friction } else { 0.0 },
            friction: softness(
                item,
                ["solreffriction", "solimpfriction"],
                &mut self.ignored.powers,
            ),
            spring,
        }
    }

    /// Returns a sum of joint coordinates, with joints of the description in place of links. Joints
    /// with several degrees of freedom are an error.
    pub fn joint_sum(&mut self, sum: &[(usize, f64)], offset: f64, at: usize) -> JointSum {
        let is_single = |joint: usize| match self.description.joints[joint].kind {
            Kind::Moving(joint_type) => joint_type.nv() == 1,
            _ => self.held.contains_key(&joint),
        };
        if !sum.iter().all(|(joint, _)| is_single(*joint)) {
            let message = "a tendon or a coupling has a joint that is no hinge and no slide";
            let help = "name joints of the types `hinge` and `slide`";
            self.report.error(Code::NotRead, at, None, message, help);
        }
        let joints = sum.iter().map(|&(link, coefficient)| TendonJoint { link, coefficient });
        JointSum { joints: joints.collect(), offset }
    }

    /// Lets tendons and couplings know the coordinates of joints that constraints of `<equality>`
    /// hold, and reports more tendons than are read.
    pub fn hold_tendons(&mut self) {
        let held = &self.held;
        let lengths = self.tendons.iter_mut().map(|tendon| &mut tendon.length);
        let sums = self.couplings.iter_mut().flat_map(|coupling| &mut coupling.sums);
        for sum in lengths.chain(sums) {
            let offsets = sum
                .joints
                .iter()
                .filter_map(|joint| Some(joint.coefficient * held.get(&joint.link)?));
            sum.offset += offsets.sum::<f64>();
            sum.joints.retain(|joint| !held.contains_key(&joint.link));
        }
        if self.tendons.len() + self.couplings.len() > MAX_TENDONS {
            let message = format!("more than {MAX_TENDONS} tendons and couplings act in `step`");
            let help = "remove the limits, the friction and the springs of tendons that need none";
            let at = self.description.at;
            self.report.error(Code::Excessive, at, None, message, help);
        }
    }
}

/// Returns whether the spring and the damper of a tendon have one coefficient each, and the spring
/// does not yield.
fn is_linear(item: &Item<'_>) -> bool {
    !item.sets("springyield") && !SPRING.iter().any(|name| polynomial(item, name).1)
}
