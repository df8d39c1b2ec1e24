//! Inertias that change at run time: the links' own inertias, and payloads.

use alloc::{string::String, vec, vec::Vec};
use core::cmp::Ordering;
use core::fmt;

use super::Interpreter;
use crate::Scalar;
use crate::equations::singular::{self, PivotWorkspace};
use crate::inertial::PARAMETERS_PER_LINK;
use crate::mechanism::{CompensatedMass, Mechanism, inertia_without, rigid_inertia};
use crate::model::{Inertial, InertialDefect, Model};
use crate::parameters::write_no_inertia;
use crate::scalar::epsilon;
use crate::spatial::RigidInertia;

/// The reason why a link cannot have an inertia or a payload.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum InertialError<S = f64> {
    /// There is no link with this index.
    NoLink {
        /// The index.
        link: usize,
        /// The number of links of the description.
        count: usize,
    },
    /// No rigid body has this inertia.
    Defect(InertialDefect<S>),
    /// A joint would move no inertia, so its acceleration would be infinite.
    NoInertia {
        /// The name of the joint.
        joint: String,
    },
}

impl<S> From<InertialDefect<S>> for InertialError<S> {
    fn from(defect: InertialDefect<S>) -> Self {
        Self::Defect(defect)
    }
}

impl<S: fmt::Display + fmt::LowerExp> fmt::Display for InertialError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoLink { link, count } => {
                write!(f, "there is no link {link}; the description has {count}")
            }
            Self::Defect(defect) => defect.fmt(f),
            Self::NoInertia { joint } => write_no_inertia(f, joint),
        }
    }
}

impl<S: fmt::Debug + fmt::Display + fmt::LowerExp + 'static> core::error::Error
    for InertialError<S>
{
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Defect(defect) => Some(defect),
            Self::NoLink { .. } | Self::NoInertia { .. } => None,
        }
    }
}

/// The two inertias of a link at run time.
#[derive(Clone, Copy, Debug)]
enum InertialKind {
    /// The link's own inertia.
    Own,
    /// The payload, which is added to the link's own inertia.
    Payload,
}

/// A body's inertia, its base inertia, and its compensated mass.
type Described<S> = (RigidInertia<S>, RigidInertia<S>, Option<CompensatedMass<S>>);

/// The present inertias. The bodies' inertias are always summed from the described parts, so that
/// rounding does not accumulate from change to change.
#[derive(Clone, Debug)]
pub(super) struct Inertias<S> {
    /// For each body of the mechanism in the description, its inertia, its base inertia, and its
    /// compensated mass.
    described: Vec<Described<S>>,
    /// The static inertia in the description.
    static_inertia: RigidInertia<S>,
    /// For each body, its inertia without the own inertias of its links.
    rest: Vec<RigidInertia<S>>,
    /// For each link of the description: its own inertia in the description, its present own
    /// inertia, its payload.
    links: Vec<[Inertial<S>; 3]>,
    /// For each body, whether the inertia of one of its links has changed.
    changed: Vec<bool>,
    /// For each entry of qd, whether it moves inertia in the description.
    moves_inertia: Vec<bool>,
    pivots: Vec<S>,
    workspace: PivotWorkspace<S>,
}

impl<S: Scalar + PartialOrd> Inertias<S> {
    /// Returns the inertias of `mechanism`, which must be `model` unchanged.
    fn new(model: &Model, mechanism: &Mechanism<S>) -> Self {
        let exact = Mechanism::new(model);
        let mut rest = vec![RigidInertia::zero(); mechanism.bodies.len()];
        for (link, &body) in exact.links.iter().enumerate() {
            let alone = inertia_without(model, link, |_| true);
            rest[body] = alone.placed(&exact.bodies[body].link).map(S::from_f64);
        }
        let links = model.links().iter().map(|link| {
            let described = link.inertial.map(S::from_f64);
            [described, described, Inertial::default()]
        });
        let mut workspace = PivotWorkspace::new(mechanism);
        let mut pivots = vec![S::zero(); mechanism.nv];
        singular::pivots(mechanism, epsilon(), &mut workspace, &mut pivots);
        Self {
            described: mechanism
                .bodies
                .iter()
                .map(|body| (body.inertia, body.base_inertia, body.compensated))
                .collect(),
            static_inertia: mechanism.static_inertia,
            rest,
            links: links.collect(),
            changed: vec![false; mechanism.bodies.len()],
            moves_inertia: pivots.iter().map(|&pivot| pivot > S::zero()).collect(),
            pivots,
            workspace,
        }
    }

    /// Sums the inertias of the bodies into `mechanism`.
    fn update_bodies(&mut self, mechanism: &mut Mechanism<S>) {
        for (body, described) in mechanism.bodies.iter_mut().zip(&self.described) {
            (body.inertia, body.base_inertia, body.compensated) = *described;
        }
        mechanism.static_inertia = self.static_inertia;
        self.changed.fill(false);
        for (frame, [described, link_inertial, payload]) in mechanism.frames.iter().zip(&self.links)
        {
            let changed = link_inertial != described || *payload != Inertial::default();
            if let Some(body) = frame.body.filter(|_| changed) {
                self.changed[body] = true;
                mechanism.bodies[body].inertia = self.rest[body];
                mechanism.bodies[body].compensated = None;
            }
        }
        if !self.changed.contains(&true) {
            return;
        }
        for (frame, [_, link_inertial, payload]) in (0..).zip(&self.links) {
            if mechanism.frames[frame].body.is_some_and(|body| self.changed[body]) {
                mechanism.add_inertia(frame, &rigid_inertia(link_inertial));
                mechanism.add_inertia(frame, &rigid_inertia(payload));
                mechanism.compensate(frame, &rigid_inertia(link_inertial));
            }
        }
        mechanism.update_base_inertias();
    }

    /// Returns the first entry of qd, from the leaves, that no longer moves inertia.
    fn first_singular(&mut self, mechanism: &Mechanism<S>) -> Option<usize> {
        let Self { moves_inertia, pivots, workspace, .. } = self;
        singular::pivots(mechanism, epsilon(), workspace, pivots);
        (0..moves_inertia.len()).rev().find(|&v| moves_inertia[v] && !is_positive(pivots[v]))
    }
}

/// Returns a joint that moves no inertia because its body has none, as an index into the links.
pub(super) fn joint_without_inertia<S: Scalar + PartialOrd>(
    model: &Model,
    mechanism: &Mechanism<S>,
) -> Option<usize> {
    let body = |link: usize| &mechanism.bodies[mechanism.links[link]];
    let is_massless = |link: &usize| body(*link).inertia == RigidInertia::zero();
    let mut massless = (0..model.moving_links().len()).filter(is_massless).peekable();
    // Nearly always the case.
    massless.peek()?;
    let mut pivots = vec![S::zero(); mechanism.nv];
    singular::pivots(mechanism, epsilon(), &mut PivotWorkspace::new(mechanism), &mut pivots);
    massless.find(|&link| {
        let is_own = model.mimic(link).is_none();
        is_own && model.v_range(link).any(|v| !is_positive(pivots[v]))
    })
}

/// Returns whether a pivot belongs to a joint that moves inertia.
fn is_positive<S: Scalar + PartialOrd>(pivot: S) -> bool {
    pivot.partial_cmp(&S::zero()) == Some(Ordering::Greater)
}

/// Returns the link whose joint has entry `v` of qd.
fn link_of(model: &Model, v: usize) -> Option<usize> {
    let moves = |link: &usize| model.mimic(*link).is_none() && model.v_range(*link).contains(&v);
    (0..model.moving_links().len()).find(moves)
}

impl<S: Scalar + PartialOrd> Interpreter<S> {
    /// Returns the ten inertial parameters of moving link `link` with the present inertias and
    /// payloads, as [`Model::inertial_parameters`] does with the inertias of the description;
    /// `None` if there is no such link.
    #[must_use]
    pub fn inertial_parameters(&self, link: usize) -> Option<[S; PARAMETERS_PER_LINK]> {
        let mut parameters = self.model.inertial_parameters(link)?.map(S::from_f64);
        let Some(inertias) = &self.inertias else { return Some(parameters) };
        for (frame, [described, link_inertial, payload]) in
            self.model.links().iter().zip(&inertias.links)
        {
            if frame.moving_link != Some(link) {
                continue;
            }
            let pose = frame.pose.map(S::from_f64);
            let parameters_of = |inertial: &Inertial<S>| inertial.transformed(&pose).parameters();
            let [before, after, added] =
                [parameters_of(described), parameters_of(link_inertial), parameters_of(payload)];
            for (k, parameter) in parameters.iter_mut().enumerate() {
                *parameter = *parameter + (after[k] - before[k]) + added[k];
            }
        }
        Some(parameters)
    }

    /// Replaces the own inertia of this link of the description (an index into
    /// [`Model::links`]). `inertial` is in the link's frame.
    ///
    /// Links that are fixed to the link keep their inertia, and the link keeps its
    /// [payload](Self::set_payload). All inertias are summed from the description: after any number
    /// of changes, the robot is the same as after the last change of each link alone. A call takes
    /// time linear in the number of links; the first call allocates.
    ///
    /// # Errors
    ///
    /// If there is no such link, if no rigid body has this inertia, or if a joint that moves
    /// inertia in the description would move none. After an error nothing has changed.
    pub fn set_inertial(
        &mut self,
        link: usize,
        inertial: &Inertial<S>,
    ) -> Result<(), InertialError<S>> {
        self.set_inertial_of_kind(link, InertialKind::Own, inertial)
    }

    /// Sets the payload of this link of the description (an index into [`Model::links`]): an
    /// inertia in the link's frame that is added to the link's own. [`Inertial::default`] removes
    /// the payload.
    ///
    /// ```
    /// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
    /// use modyn_runtime::{Inertial, Interpreter};
    ///
    /// // A pendulum: 2 kg, 0.5 m below its joint.
    /// let mut pendulum = Interpreter::<f64>::new(model);
    /// let bob = pendulum.model().link_index("bob").expect("a link");
    /// let load = Inertial { mass: 2.0, ..Inertial::default() };
    /// pendulum.set_payload(bob, &load).expect("a physical inertia");
    /// let mut columns = [0.0];
    /// pendulum.mass_matrix(&[0.0], &mut columns)?;
    /// assert!((columns[0] - 4.0 * 0.5 * 0.5).abs() < 1e-12);
    /// # Ok::<(), modyn_runtime::ShapeError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As for [`set_inertial`](Self::set_inertial).
    pub fn set_payload(
        &mut self,
        link: usize,
        payload: &Inertial<S>,
    ) -> Result<(), InertialError<S>> {
        self.set_inertial_of_kind(link, InertialKind::Payload, payload)
    }

    fn set_inertial_of_kind(
        &mut self,
        link: usize,
        part: InertialKind,
        inertial: &Inertial<S>,
    ) -> Result<(), InertialError<S>> {
        let count = self.model.links().len();
        if link >= count {
            return Err(InertialError::NoLink { link, count });
        }
        if let Some(defect) = inertial.defect() {
            return Err(defect.into());
        }
        let Self { model, mechanism, inertias, without_inertia, .. } = self;
        let inertias = inertias.get_or_insert_with(|| Inertias::new(model, mechanism));
        let at = match part {
            InertialKind::Own => 1,
            InertialKind::Payload => 2,
        };
        let before = core::mem::replace(&mut inertias.links[link][at], *inertial);
        inertias.update_bodies(mechanism);
        let Some(v) = inertias.first_singular(mechanism) else {
            *without_inertia = joint_without_inertia(model, mechanism);
            return Ok(());
        };
        inertias.links[link][at] = before;
        inertias.update_bodies(mechanism);
        let joint = link_of(model, v)
            .map(|link| model.moving_links()[link].joint.name.clone())
            .unwrap_or_default();
        Err(InertialError::NoInertia { joint })
    }
}
