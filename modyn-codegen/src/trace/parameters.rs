//! The parts of a robot that are arguments of its functions.

use modyn_runtime::Scalar;
use modyn_runtime::equations::singular::{self, PivotWorkspace};
use modyn_runtime::mechanism::{Mechanism, inertia_without, rigid_inertia};
use modyn_runtime::model::{Inertial, Model, PARAMETERS_PER_LINK};
use modyn_runtime::spatial::{RigidInertia, Vector3};

use super::Tracer;
use crate::graph::{Expr, Graph};

/// The parts of a robot that are known at run time only.
#[derive(Clone, Debug, Default)]
pub struct Parameters {
    /// Whether gravity is.
    pub gravity: bool,
    /// The links, as indices into [`Model::frames`], whose own inertia is, with their own inertias in the description.
    pub inertias: Vec<(usize, Inertial)>,
    /// The links, as indices into [`Model::frames`], to which an inertia is added.
    pub payloads: Vec<usize>,
    /// The moving links that carry one of the `inertias`, with their inertia without these, about their origin.
    rest: Vec<(usize, RigidInertia<f64>)>,
}

impl Parameters {
    /// Those of a model: gravity, and links as indices into its frames whose own inertia is an argument, or to which an
    /// inertia is added.
    #[must_use]
    pub fn new(model: &Model, gravity: bool, inertias: &[usize], payloads: &[usize]) -> Self {
        let mut carrying: Vec<usize> =
            inertias.iter().filter_map(|&frame| model.frames()[frame].link).collect();
        carrying.sort_unstable();
        carrying.dedup();
        let rest = |link| (link, inertia_without(model, link, |frame| inertias.contains(&frame)));
        let own = |&frame: &usize| (frame, model.frames()[frame].inertial);
        Self {
            gravity,
            inertias: inertias.iter().map(own).collect(),
            payloads: payloads.to_vec(),
            rest: carrying.into_iter().map(rest).collect(),
        }
    }

    /// Gravity alone.
    pub(super) fn without_inertias(&self) -> Self {
        Self { gravity: self.gravity, ..Self::default() }
    }

    /// How many numbers they are: gravity's three, then for each run-time inertia and for each payload its mass, centre
    /// of mass and inertia about that, as [`Inertial`] has them.
    #[must_use]
    pub fn len(&self) -> usize {
        self.inertial(self.inertias.len() + self.payloads.len())
    }

    /// The numbers as the description has them: this gravity, the links' own inertias, and no payloads.
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

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Where the ten numbers of run-time inertia `k` begin; those of payloads follow.
    #[must_use]
    pub fn inertial(&self, k: usize) -> usize {
        k * PARAMETERS_PER_LINK + if self.gravity { 3 } else { 0 }
    }

    /// Puts the inputs from number `next` on where they belong.
    pub(super) fn enter(&self, next: usize, model: &mut Mechanism<Expr>) {
        let mut inputs = (next..).map(Expr::input);
        let mut input = || inputs.next().expect("endless");
        if self.gravity {
            model.gravity = Vector3([input(), input(), input()]);
        }
        self.remove(model);
        let own = self.inertias.iter().map(|(frame, _)| frame);
        for &frame in own.chain(&self.payloads) {
            let inertial = Inertial {
                mass: input(),
                center_of_mass: std::array::from_fn(|_| input()),
                inertia: std::array::from_fn(|_| input()),
            };
            model.add_inertia(frame, &rigid_inertia(&inertial));
        }
    }

    /// Takes the described inertias of the links away that have others at run time.
    fn remove<S: Scalar>(&self, model: &mut Mechanism<S>) {
        if self.rest.is_empty() {
            return;
        }
        for (link, rest) in &self.rest {
            let body = model.links[*link];
            let body = &mut model.bodies[body];
            body.inertia = rest.map(S::from_f64).placed(&body.link);
        }
        model.minimize();
    }
}

impl Tracer<'_> {
    /// The entries of qd that feel no inertia if all run-time inertias are zero, with the graph of the inertia that each
    /// of them feels: of the scalar's precision, then the parameters. `None` if there is no such entry: then any
    /// inertias will do, since more inertia never makes a mass matrix singular.
    ///
    /// An entry that feels none with some run-time inertias feels none without them, so that no other need be
    /// looked at.
    #[must_use]
    pub fn inertia_pivots(&self) -> Option<(Vec<usize>, Graph)> {
        let felt = |model: &Mechanism<f64>| {
            let mut pivots = vec![0.0; model.nv];
            singular::pivots(model, f64::EPSILON, &mut PivotWorkspace::new(model), &mut pivots);
            pivots.into_iter().map(|pivot| pivot > 0.0).collect::<Vec<bool>>()
        };
        let mut least = self.model.clone();
        self.parameters.remove(&mut least);
        let (described, least) = (felt(self.model), felt(&least));
        let needy: Vec<usize> = (0..least.len()).filter(|&v| described[v] && !least[v]).collect();
        if needy.is_empty() {
            return None;
        }
        let graph = self.trace_groups([1], |model, [epsilon]| {
            let mut pivots = self.vector();
            singular::pivots(model, epsilon[0], &mut PivotWorkspace::new(model), &mut pivots);
            needy.iter().map(|&v| pivots[v]).collect()
        });
        Some((needy, graph))
    }
}
