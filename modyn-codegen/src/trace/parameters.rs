//! The run-time parameters of a robot: gravity, inertias and payloads as arguments of functions.

use modyn_runtime::Scalar;
use modyn_runtime::equations::singular::{self, PivotWorkspace};
use modyn_runtime::mechanism::{CompensatedMass, Mechanism, inertia_without, rigid_inertia};
use modyn_runtime::model::{Inertial, Model, PARAMETERS_PER_LINK};
use modyn_runtime::spatial::{RigidInertia, Vector3};

use super::Tracer;
use crate::graph::{Expr, Graph};

/// The run-time parameters of a robot.
#[derive(Clone, Debug, Default)]
pub struct Parameters {
    /// Whether gravity is a parameter.
    pub gravity: bool,
    /// The links whose own inertia is a parameter, as indices into [`Model::links`], with their
    /// described inertia.
    pub inertias: Vec<(usize, Inertial)>,
    /// The links with a payload, as indices into [`Model::links`].
    pub payloads: Vec<usize>,
    /// The moving links that carry one of the `inertias`, with their inertia without these, about
    /// their origin, and the compensated mass without these on their bodies.
    rest: Vec<(usize, RigidInertia<f64>, Option<CompensatedMass<f64>>)>,
}

impl Parameters {
    /// Returns the parameters of a model: gravity, the links whose own inertia is a parameter, and
    /// the links with a payload, as indices into its links.
    #[must_use]
    pub fn new(model: &Model, gravity: bool, inertias: &[usize], payloads: &[usize]) -> Self {
        let mut carrying: Vec<usize> =
            inertias.iter().filter_map(|&link| model.links()[link].moving_link).collect();
        carrying.sort_unstable();
        carrying.dedup();
        let factors = model.gravity_compensation().iter().enumerate();
        let kept = factors.map(|(i, factor)| if inertias.contains(&i) { 0.0 } else { *factor });
        let model_kept = model.clone().with_gravity_compensation(kept.collect());
        let kept = Mechanism::new(&model_kept.expect("as many finite factors"));
        let rest = |link: usize| {
            let alone = inertia_without(model, link, |other| inertias.contains(&other));
            (link, alone, kept.bodies[kept.links[link]].compensated)
        };
        let described = |&link: &usize| (link, model.links()[link].inertial);
        Self {
            gravity,
            inertias: inertias.iter().map(described).collect(),
            payloads: payloads.to_vec(),
            rest: carrying.into_iter().map(rest).collect(),
        }
    }

    /// Returns the parameters without inertias and payloads.
    pub(super) fn without_inertias(&self) -> Self {
        Self { gravity: self.gravity, ..Self::default() }
    }

    /// Returns the number of scalars: three of gravity, then for each run-time inertia and each
    /// payload the mass, the centre of mass and the inertia about it, in the order of [`Inertial`].
    #[must_use]
    pub fn len(&self) -> usize {
        self.inertial(self.inertias.len() + self.payloads.len())
    }

    /// Returns the default values: `gravity`, the links' described inertias, and no payloads.
    #[must_use]
    pub fn described(&self, gravity: [f64; 3]) -> Vec<f64> {
        let mut numbers = Vec::with_capacity(self.len());
        if self.gravity {
            numbers.extend(gravity);
        }
        for (_, Inertial { mass, center_of_mass, inertia }) in &self.inertias {
            numbers.push(*mass);
            numbers.extend(center_of_mass);
            numbers.extend(inertia);
        }
        numbers.resize(self.len(), 0.0);
        numbers
    }

    /// Returns whether there are no parameters.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the index of the ten numbers of run-time inertia `k`; the numbers of payloads
    /// follow.
    #[must_use]
    pub fn inertial(&self, k: usize) -> usize {
        k * PARAMETERS_PER_LINK + if self.gravity { 3 } else { 0 }
    }

    /// Inserts the inputs from number `next` on into the model.
    pub(super) fn enter(&self, next: usize, model: &mut Mechanism<Expr>) {
        let mut inputs = (next..).map(Expr::input);
        let mut input = || inputs.next().expect("endless");
        if self.gravity {
            model.gravity = Vector3([input(), input(), input()]);
        }
        self.remove(model);
        let inertias = self.inertias.iter().map(|(link, _)| (link, true));
        let payloads = self.payloads.iter().map(|link| (link, false));
        for (&link, is_own) in inertias.chain(payloads) {
            let inertial = Inertial {
                mass: input(),
                center_of_mass: std::array::from_fn(|_| input()),
                inertia: std::array::from_fn(|_| input()),
            };
            let inertia = rigid_inertia(&inertial);
            model.add_inertia(link, &inertia);
            if is_own {
                model.compensate(link, &inertia);
            }
        }
    }

    /// Subtracts the described inertias of links with run-time inertias.
    fn remove<S: Scalar>(&self, model: &mut Mechanism<S>) {
        if self.rest.is_empty() {
            return;
        }
        for (link, rest, compensated) in &self.rest {
            let index = model.links[*link];
            let body = &mut model.bodies[index];
            body.compensated = compensated.map(|mass| mass.map(S::from_f64));
            body.inertia = rest.map(S::from_f64).placed(&body.link);
        }
        model.update_base_inertias();
    }
}

impl Tracer<'_> {
    /// Returns the entries of qd that move no inertia if all run-time inertias are zero, with the
    /// graph of the inertia at each of them. Inputs: the scalar's precision, then the parameters.
    /// Returns `None` if there is no such entry: any inertias are then valid, since more inertia
    /// never makes a mass matrix singular.
    ///
    /// An entry that moves no inertia with some run-time inertias moves none without them. No other
    /// entry has to be checked.
    #[must_use]
    pub fn inertia_pivots(&self) -> Option<(Vec<usize>, Graph)> {
        let moves_inertia = |model: &Mechanism<f64>| {
            let mut pivots = vec![0.0; model.nv];
            singular::pivots(model, f64::EPSILON, &mut PivotWorkspace::new(model), &mut pivots);
            pivots.into_iter().map(|pivot| pivot > 0.0).collect::<Vec<bool>>()
        };
        let mut least = self.model.clone();
        self.parameters.remove(&mut least);
        let described = moves_inertia(self.model);
        let least = moves_inertia(&least);
        let entries: Vec<usize> = (0..least.len()).filter(|&v| described[v] && !least[v]).collect();
        if entries.is_empty() {
            return None;
        }
        let graph = self.trace_groups([1], |model, [epsilon]| {
            let mut pivots = self.vector();
            singular::pivots(model, epsilon[0], &mut PivotWorkspace::new(model), &mut pivots);
            entries.iter().map(|&v| pivots[v]).collect()
        });
        Some((entries, graph))
    }
}
