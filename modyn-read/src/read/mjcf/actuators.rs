//! Actuators: their laws, and the limits of their forces.

use std::collections::HashMap;

use modyn_runtime::joint::JointType;
use modyn_runtime::model::{
    Activation, ActivationDynamics, Actuator, AffineLaw, FixedTendon, Limits, TendonJoint,
    Transmission,
};
use modyn_runtime::{Interpreter, Portable};

use super::actuator_law::{ActuatorLaw, Range};
use super::bodies::Bodies;
use super::equality::fixed_tendon;
use super::inert_actuators::{Inert, InertActuators};
use super::item::Item;
use super::settings::LEAST;
use super::spring_dampers::{MAX_ACCELERATIONS, MAX_SPRING_DAMPERS};
use crate::description::{Kind, MAX_NUMBER, TakenNames};
use crate::diagnostics::{Code, Subject};

/// An actuator of the model.
struct Described<'e> {
    item: Item<'e>,
    law: ActuatorLaw<'e>,
    transmission: Transmission,
}

/// The joints and tendons of the description by their names.
struct Targets<'e> {
    joints: HashMap<String, usize>,
    tendons: HashMap<String, Tendon<'e>>,
}

/// A tendon of the model.
struct Tendon<'e> {
    item: Item<'e>,
    /// Its joints and their coefficients; `None` if the tendon is not fixed.
    joints: Option<Vec<(usize, f64)>>,
    /// Its index among the tendons of the actuators; `None` if no actuator moves it so far.
    index: Option<usize>,
}

impl<'e> Bodies<'e, '_, '_> {
    /// Adds the actuators, sets the effort limits of joints whose actuators have a limited force,
    /// and warns of actuators that do not act. Constraints of `<equality>` may not have fixed joints
    /// yet.
    pub fn actuators(&mut self) {
        let items = self.of_section("actuator");
        if items.is_empty() {
            self.keyframe_controls(&[]);
            return;
        }
        let mut targets = self.targets(&items);
        let acts = self.models[0].settings.flags.actuation;
        let mut inert = InertActuators::default();
        let mut described = Vec::new();
        let mut is_read = Vec::new();
        // For each joint, the sum of its actuators' largest forces; `None` if one has no limit.
        let mut efforts = vec![Some(0.0); self.description.joints.len()];
        for item in items {
            let index = is_read.len();
            is_read.push(false);
            if !self.models[item.model].is_sound(&item.chain) {
                continue;
            }
            let law = ActuatorLaw::of(&item);
            let transmission = self.transmission(&item, &law, &mut targets);
            if let Ok(Transmission::Joint(joint)) = transmission {
                let effort = self.largest_force(&item, &law);
                efforts[joint] = efforts[joint].zip(effort).map(|(sum, effort)| sum + effort);
            }
            let is_law = inert.add(&item, &law, &transmission);
            match transmission {
                Ok(transmission) if is_law => {
                    is_read[index] = true;
                    described.push(Described { item, law, transmission });
                }
                Err(Inert::Missing) => self.refuse_target(&item, &law),
                _ => {}
            }
        }
        if acts {
            self.set_efforts(efforts);
            inert.report(self.report);
        }
        self.resolve_damping_ratios(&mut described);
        let explicit: Vec<String> =
            described.iter().filter_map(|actuator| actuator.item.name()).collect();
        let mut taken = TakenNames::new(explicit.iter().map(String::as_str));
        for actuator in described {
            self.add_actuator(actuator, &targets, &mut taken);
        }
        self.keyframe_controls(&is_read);
    }

    fn targets(&self, actuators: &[Item<'e>]) -> Targets<'e> {
        let known_joints = self.description.joints_by_name().into_iter();
        let joints: HashMap<String, usize> =
            known_joints.map(|(name, joint)| (name.to_owned(), joint)).collect();
        let moves_tendon = |item: &Item<'e>| item.text("tendon").is_some();
        let mut tendons = HashMap::new();
        if actuators.iter().any(moves_tendon) {
            for item in self.of_section("tendon") {
                let Some(name) = item.name() else { continue };
                let joints = fixed_tendon(&item, &joints);
                // The first of equal names counts.
                tendons.entry(name).or_insert(Tendon { item, joints, index: None });
            }
        }
        Targets { joints, tendons }
    }

    /// Returns the joint or tendon that an actuator moves, as an index of the description.
    fn transmission(
        &mut self,
        item: &Item<'e>,
        law: &ActuatorLaw<'e>,
        targets: &mut Targets<'e>,
    ) -> Result<Transmission, Inert> {
        let (attribute, name) = law.target.ok_or(Inert::Missing)?;
        let name = item.naming.name(name);
        let is_single = |joint: &usize| {
            use JointType::{Continuous, Prismatic, Revolute};
            let kind = self.description.joints[*joint].kind;
            matches!(kind, Kind::Moving(Revolute | Continuous | Prismatic))
        };
        match attribute {
            "joint" | "jointinparent" => {
                let joint = targets.joints.get(&name).ok_or(Inert::Missing)?;
                let several = Inert::Transmission("a ball or free joint");
                is_single(joint).then_some(Transmission::Joint(*joint)).ok_or(several)
            }
            "tendon" => {
                let tendon = targets.tendons.get_mut(&name).ok_or(Inert::Missing)?;
                let single = tendon
                    .joints
                    .as_ref()
                    .filter(|joints| joints.iter().all(|(joint, _)| is_single(joint)));
                let joints = single.ok_or(Inert::Transmission("a `<spatial>` tendon"))?;
                let force = Range::of(&tendon.item, "actuatorfrclimited", "actuatorfrcrange");
                let model = &self.models[tendon.item.model];
                let index = *tendon.index.get_or_insert_with(|| {
                    let joints =
                        joints.iter().map(|&(link, coefficient)| TendonJoint { link, coefficient });
                    self.description.actuation.tendons.push(FixedTendon {
                        name,
                        joints: joints.collect(),
                        offset: 0.0,
                        force_range: force.limits(model),
                    });
                    self.description.actuation.tendons.len() - 1
                });
                Ok(Transmission::Tendon(index))
            }
            "cranksite" => Err(Inert::Transmission("a slider-crank")),
            "site" => Err(Inert::Transmission("a site")),
            _ => Err(Inert::Transmission("contacts of a body")),
        }
    }

    /// Reports an actuator whose joint or tendon does not exist; a part of an attached model may
    /// lack it.
    fn refuse_target(&mut self, item: &Item<'e>, law: &ActuatorLaw<'e>) {
        if !item.naming.prefix.is_empty() {
            return;
        }
        let element = item.element();
        let (message, help) = match law.target {
            None => (
                format!("`<{}>` moves no joint", element.name),
                "write the attribute `joint` or `tendon`",
            ),
            Some((attribute, name)) => (
                format!(
                    "`{attribute}` of `<{}>` is `{}`, which does not exist",
                    element.name,
                    item.naming.name(name)
                ),
                "name a joint of a body, or a tendon",
            ),
        };
        self.report.error(Code::NotRead, element.at, None, message, help);
    }

    /// Returns the largest force of an actuator on its joint, if it is the same in both directions.
    fn largest_force(&self, item: &Item<'e>, law: &ActuatorLaw<'e>) -> Option<f64> {
        let model = &self.models[item.model];
        // The force is a multiple of the control.
        let is_motor =
            [law.gain_type, law.bias_type, law.dynamics_type] == ["fixed", "none", "none"];
        let clamps = self.models[0].settings.flags.clamps_controls;
        let gain = (is_motor && clamps && item.element().name != "plugin").then_some(law.gain[0]);
        let ranges = [(law.force, Some(1.0)), (law.control, gain)].into_iter();
        let bounds = ranges.filter_map(|(range, factor)| {
            let [low, high] = range.limits(model)?;
            (-low == high && high > 0.0).then_some(high * factor?.abs())
        });
        bounds.reduce(f64::min).map(|bound| bound * law.gear.abs())
    }

    /// Sets the effort limits of joints without one.
    fn set_efforts(&mut self, efforts: Vec<Option<f64>>) {
        for (joint, effort) in self.description.joints.iter_mut().zip(efforts) {
            let effort = effort.filter(|effort| *effort > 0.0 && *effort < MAX_NUMBER);
            let none = Limits { lower: None, upper: None, velocity: None, effort: None };
            if effort.is_some() && joint.limits.is_none_or(|limits| limits.effort.is_none()) {
                joint.limits = Some(Limits { effort, ..joint.limits.unwrap_or(none) });
            }
        }
    }

    /// Replaces damping ratios by the damping, which follows from the inertia at the actuator in the
    /// pose in which the model is drawn. Constraints of `<equality>` do not count.
    fn resolve_damping_ratios(&mut self, described: &mut [Described<'e>]) {
        let has_ratio = |actuator: &Described<'e>| actuator.law.damping_ratio().is_some();
        let Some(first) = described.iter().find(|actuator| has_ratio(actuator)) else { return };
        let at = first.item.element().at;
        if self.report.errors() > 0 {
            return;
        }
        let servos = described.iter().filter(|actuator| has_ratio(actuator));
        let moments: Vec<Vec<(usize, f64)>> =
            servos.map(|actuator| self.moments(actuator).collect()).collect();
        let Some(inertias) = self.inertias_at(&moments) else {
            let message = format!(
                "the inertia at an actuator with `dampratio` is not known, or more than \
                 {MAX_SPRING_DAMPERS} actuators have one"
            );
            let help =
                "repair the other errors; if there are none, write `kv` in place of `dampratio`";
            self.report.error(Code::NotRead, at, None, message, help);
            return;
        };
        let servos = described.iter_mut().filter(|actuator| has_ratio(actuator));
        for (Described { law, .. }, inertia) in servos.zip(inertias) {
            law.bias[2] *= -2.0 * libm::sqrt(law.gain[0] * inertia);
        }
    }

    /// Returns the joints that an actuator moves, each with its force per unit of the actuator's.
    fn moments(&self, actuator: &Described<'e>) -> impl Iterator<Item = (usize, f64)> {
        let gear = actuator.law.gear;
        let (single, several) = match actuator.transmission {
            Transmission::Joint(joint) => (Some((joint, gear)), &[][..]),
            Transmission::Tendon(tendon) => {
                (None, &self.description.actuation.tendons[tendon].joints[..])
            }
        };
        let several = several.iter().map(move |joint| (joint.link, gear * joint.coefficient));
        single.into_iter().chain(several)
    }

    /// Returns the inertia at each of these actuators, given the joints that it moves and their
    /// moments: how its force opposes the acceleration of its length. `None` if it is not known.
    fn inertias_at(&self, actuators: &[Vec<(usize, f64)>]) -> Option<Vec<f64>> {
        let model = self.free_model()?;
        let links = model.moving_links().len();
        if actuators.len() > MAX_SPRING_DAMPERS || actuators.len() * links > MAX_ACCELERATIONS {
            return None;
        }
        // The inertias become part of generated text, which must be the same on every host.
        let portable = |numbers: &Vec<f64>| numbers.iter().copied().map(Portable).collect();
        let q: Vec<Portable> = model.keyframes().first().map(|drawn| portable(&drawn.q))?;
        let records = model.moving_links().iter().enumerate();
        let places: HashMap<String, usize> = records
            .map(|(link, record)| (record.joint.name.clone(), model.v_range(link).start))
            .collect();
        let still = vec![Portable(0.0); model.nv()];
        let mut qdd = still.clone();
        let mut robot = Interpreter::<Portable>::new(model);
        let inertia = |moments: &Vec<(usize, f64)>| {
            let name = |joint: usize| self.description.joints[joint].name.text.as_str();
            let places =
                moments.iter().map(|&(joint, moment)| Some((places.get(name(joint))?, moment)));
            let moments: Vec<(&usize, f64)> = places.collect::<Option<_>>()?;
            let mut tau = still.clone();
            moments.iter().for_each(|&(&place, moment)| tau[place].0 += moment);
            robot.forward_dynamics(&q, &still, &tau, &mut qdd).ok()?;
            let inverse: f64 = moments.iter().map(|&(&place, moment)| moment * qdd[place].0).sum();
            inverse.is_finite().then(|| 1.0 / inverse.max(LEAST))
        };
        actuators.iter().map(inertia).collect()
    }

    /// Adds an actuator to the description.
    fn add_actuator(
        &mut self,
        Described { item, mut law, transmission }: Described<'e>,
        targets: &Targets<'e>,
        taken: &mut TakenNames,
    ) {
        let element = item.element();
        let target = self.target_name(transmission).to_owned();
        if law.inheriting().is_some() {
            self.inherit_range(&item, &mut law, transmission, targets);
        }
        let flags = self.models[0].settings.flags;
        let model = &self.models[item.model];
        let [control, force, activation] =
            [law.control, law.force, law.activation].map(|range| range.limits(model));
        let is_empty = |range: Option<[f64; 2]>| range.is_some_and(|[low, high]| low >= high);
        let has_activation = law.dynamics_type != "none";
        if is_empty(control) || is_empty(force) || has_activation && is_empty(activation) {
            let message = "the range of a control, a force or an activation is empty";
            let help = "write the lower bound, then the upper bound above it";
            let subject = Subject::Joint(target.clone());
            self.report.error(Code::InvertedLimits, element.at, Some(&subject), message, help);
            return;
        }
        let time = law.time_constant.max(0.0);
        let dynamics = match law.dynamics_type {
            "integrator" => Some(ActivationDynamics::Integrator),
            "filter" => Some(ActivationDynamics::Filter(time)),
            "filterexact" => Some(ActivationDynamics::ExactFilter(time)),
            _ => None,
        };
        let is_disabled = self.models[0].settings.disabled_groups.contains(&law.group);
        let name = match item.name() {
            Some(name) => name,
            None => taken.unique(&target, "actuator"),
        };
        let affine = |[constant, length, velocity]: [f64; 3], acts: bool| match acts {
            true => AffineLaw { constant, length, velocity },
            false => AffineLaw { constant, ..AffineLaw::default() },
        };
        self.description.actuation.actuators.push(Actuator {
            name,
            transmission,
            gear: law.gear,
            gain: affine(law.gain, law.gain_type == "affine"),
            bias: match law.bias_type {
                "affine" => affine(law.bias, true),
                _ => AffineLaw::default(),
            },
            control_range: control.filter(|_| flags.clamps_controls),
            torque_speed_line: None,
            force_range: force,
            delay: 0,
            activation: dynamics.map(|dynamics| Activation {
                dynamics,
                range: activation,
                early: law.early,
            }),
            enabled: flags.actuation && !is_disabled,
        });
    }

    /// Returns the name of the joint or tendon that an actuator moves.
    fn target_name(&self, transmission: Transmission) -> &str {
        match transmission {
            Transmission::Joint(joint) => &self.description.joints[joint].name.text,
            Transmission::Tendon(tendon) => &self.description.actuation.tendons[tendon].name,
        }
    }

    /// Sets the range that follows from the range of the joint or tendon.
    fn inherit_range(
        &mut self,
        item: &Item<'e>,
        law: &mut ActuatorLaw<'e>,
        transmission: Transmission,
        targets: &Targets<'e>,
    ) {
        let name = self.target_name(transmission).to_owned();
        let range = match transmission {
            Transmission::Joint(joint) => {
                let limits = self.description.joints[joint].limits;
                limits.and_then(|limits| Some([limits.lower?, limits.upper?]))
            }
            Transmission::Tendon(_) => {
                targets.tendons.get(&name).and_then(|tendon| tendon.item.numbers("range"))
            }
        };
        let Some([low, high]) = range.filter(|[low, high]| low != high) else {
            let message = "the actuator has `inheritrange`, and the joint or tendon no range";
            let help = "write the `range` of the joint or tendon, or `ctrlrange`";
            let subject = Subject::Joint(name);
            let at = item.element().at;
            self.report.error(Code::NotRead, at, Some(&subject), message, help);
            return;
        };
        let center = 0.5 * (high + low);
        let radius = 0.5 * (high - low) * law.inherited_range;
        if let Some(inherited) = law.inheriting() {
            inherited.bounds = [center - radius, center + radius];
        }
    }

    /// Lets transmissions know the coordinates of joints that constraints of `<equality>` hold.
    pub fn hold_transmissions(&mut self) {
        if self.held.is_empty() {
            return;
        }
        let actuation = &mut self.description.actuation;
        for tendon in &mut actuation.tendons {
            let held = |joint: &TendonJoint| self.held.get(&joint.link);
            let offsets =
                tendon.joints.iter().filter_map(|joint| Some(joint.coefficient * held(joint)?));
            tendon.offset += offsets.sum::<f64>();
            tendon.joints.retain(|joint| held(joint).is_none());
        }
        let mut taken =
            TakenNames::new(actuation.tendons.iter().map(|tendon| tendon.name.as_str()));
        for actuator in &mut actuation.actuators {
            let Transmission::Joint(joint) = actuator.transmission else { continue };
            let Some(&offset) = self.held.get(&joint) else { continue };
            let name = taken.unique(&self.description.joints[joint].name.text, "tendon");
            actuator.transmission = Transmission::Tendon(actuation.tendons.len());
            let tendon = FixedTendon { name, joints: Vec::new(), offset, force_range: None };
            actuation.tendons.push(tendon);
        }
    }
}
