//! Inertias that change at run time: a link's own, and payloads.

use alloc::{string::String, vec, vec::Vec};
use core::cmp::Ordering;
use core::fmt;

use super::Interpreter;
use crate::Scalar;
use crate::equations::singular::{self, PivotWorkspace};
use crate::mechanism::{Mechanism, inertia_without, rigid_inertia};
use crate::model::{Inertial, InertialDefect, Model};
use crate::scalar::epsilon;
use crate::spatial::RigidInertia;

/// Why a link cannot be given an inertia or a payload.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum InertialError<S = f64> {
    /// There is no link of that index.
    NoFrame {
        /// The index.
        frame: usize,
        /// How many links the description has.
        count: usize,
    },
    /// No rigid body has this inertia.
    Defect(InertialDefect<S>),
    /// A joint would move no inertia, so that its acceleration would be infinite.
    NoInertia {
        /// The name of the joint.
        joint: String,
    },
}

impl<S: fmt::Display + fmt::LowerExp> fmt::Display for InertialError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFrame { frame, count } => {
                write!(f, "there is no link {frame}; the description has {count}")
            }
            Self::Defect(defect) => defect.fmt(f),
            Self::NoInertia { joint } => write!(
                f,
                "joint `{joint}` would move no inertia that it alone would feel, so its acceleration would be \
                 infinite; give a link that it moves a mass, and a rotational inertia if it turns"
            ),
        }
    }
}

impl<S: fmt::Debug + fmt::Display + fmt::LowerExp + 'static> core::error::Error
    for InertialError<S>
{
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Defect(defect) => Some(defect),
            Self::NoFrame { .. } | Self::NoInertia { .. } => None,
        }
    }
}

/// The two inertias that a link has at run time.
#[derive(Clone, Copy, Debug)]
enum InertialKind {
    /// Its own.
    Own,
    /// The one added to it.
    Payload,
}

/// The inertias at present, and the parts that the bodies' inertias are always summed from anew, so that
/// rounding does not accumulate from change to change.
#[derive(Clone, Debug)]
pub(super) struct Inertias<S> {
    /// By body, as the model was rewritten: the inertia, and the same in base parameters.
    described: Vec<(RigidInertia<S>, RigidInertia<S>)>,
    /// The same of the inertia that does not move.
    static_inertia: RigidInertia<S>,
    /// By body: its inertia without the own inertias of its links.
    rest: Vec<RigidInertia<S>>,
    /// By link of the description: its own inertia in the description, its own now, and its payload.
    links: Vec<[Inertial<S>; 3]>,
    /// By body: whether the inertia of one of its links has changed.
    changed: Vec<bool>,
    /// By entry of qd: whether it feels inertia in the description.
    felt: Vec<bool>,
    pivots: Vec<S>,
    workspace: PivotWorkspace<S>,
}

impl<S: Scalar + PartialOrd> Inertias<S> {
    /// Of `mechanism`, which is `model` unchanged.
    fn new(model: &Model, mechanism: &Mechanism<S>) -> Self {
        let exact = Mechanism::new(model);
        let mut rest = vec![RigidInertia::zero(); mechanism.bodies.len()];
        for (link, &body) in exact.links.iter().enumerate() {
            let alone = inertia_without(model, link, |_| true);
            rest[body] = alone.placed(&exact.bodies[body].link).map(S::from_f64);
        }
        let links = model.frames().iter().map(|frame| {
            let own = frame.inertial.map(S::from_f64);
            [own, own, Inertial::default()]
        });
        let mut workspace = PivotWorkspace::new(mechanism);
        let mut pivots = vec![S::zero(); mechanism.nv];
        singular::pivots(mechanism, epsilon(), &mut workspace, &mut pivots);
        Self {
            described: mechanism
                .bodies
                .iter()
                .map(|body| (body.inertia, body.base_inertia))
                .collect(),
            static_inertia: mechanism.static_inertia,
            rest,
            links: links.collect(),
            changed: vec![false; mechanism.bodies.len()],
            felt: pivots.iter().map(|&pivot| pivot > S::zero()).collect(),
            pivots,
            workspace,
        }
    }

    /// Sums up the inertias of the bodies.
    fn update_bodies(&mut self, mechanism: &mut Mechanism<S>) {
        for (body, (inertia, base_inertia)) in mechanism.bodies.iter_mut().zip(&self.described) {
            (body.inertia, body.base_inertia) = (*inertia, *base_inertia);
        }
        mechanism.static_inertia = self.static_inertia;
        self.changed.fill(false);
        for (frame, [described, own, payload]) in mechanism.frames.iter().zip(&self.links) {
            let changed = own != described || *payload != Inertial::default();
            if let Some(body) = frame.body.filter(|_| changed) {
                self.changed[body] = true;
                mechanism.bodies[body].inertia = self.rest[body];
            }
        }
        if !self.changed.contains(&true) {
            return;
        }
        for (frame, [_, own, payload]) in (0..).zip(&self.links) {
            if mechanism.frames[frame].body.is_some_and(|body| self.changed[body]) {
                mechanism.add_inertia(frame, &rigid_inertia(own));
                mechanism.add_inertia(frame, &rigid_inertia(payload));
            }
        }
        mechanism.minimize();
    }

    /// The first entry of qd, from the leaves, that feels no inertia any more.
    fn first_singular(&mut self, mechanism: &Mechanism<S>) -> Option<usize> {
        let Self { felt, pivots, workspace, .. } = self;
        singular::pivots(mechanism, epsilon(), workspace, pivots);
        let positive = |v: usize| pivots[v].partial_cmp(&S::zero()) == Some(Ordering::Greater);
        (0..felt.len()).rev().find(|&v| felt[v] && !positive(v))
    }
}

impl<S: Scalar + PartialOrd> Interpreter<S> {
    /// Gives link `frame` of the description (an index into [`Model::frames`]) another inertia of its own, in its own
    /// frame, in place of the described one. Links that are fixed to the link keep theirs, and so does the
    /// [payload](Self::set_payload).
    ///
    /// All inertias are summed up anew from the description: after any number of changes, the robot is the same as
    /// after the last ones alone. A call takes time linear in the number of links; the first one allocates.
    ///
    /// # Errors
    ///
    /// If there is no such link, if no rigid body has this inertia, or if a joint that feels inertia in the description
    /// would feel none; nothing has changed then.
    pub fn set_inertial(
        &mut self,
        frame: usize,
        inertial: &Inertial<S>,
    ) -> Result<(), InertialError<S>> {
        self.set_inertial_of_kind(frame, InertialKind::Own, inertial)
    }

    /// Adds an inertia to link `frame` of the description (an index into [`Model::frames`]), in the link's frame, in place
    /// of the payload that it had; [`Inertial::default`] is none.
    ///
    /// # Errors
    ///
    /// As for [`set_inertial`](Self::set_inertial).
    pub fn set_payload(
        &mut self,
        frame: usize,
        payload: &Inertial<S>,
    ) -> Result<(), InertialError<S>> {
        self.set_inertial_of_kind(frame, InertialKind::Payload, payload)
    }

    fn set_inertial_of_kind(
        &mut self,
        frame: usize,
        part: InertialKind,
        inertial: &Inertial<S>,
    ) -> Result<(), InertialError<S>> {
        let count = self.model.frames().len();
        if frame >= count {
            return Err(InertialError::NoFrame { frame, count });
        }
        if let Some(defect) = inertial.defect() {
            return Err(InertialError::Defect(defect));
        }
        let Self { model, mechanism, inertias, .. } = self;
        let inertias = inertias.get_or_insert_with(|| Inertias::new(model, mechanism));
        let at = match part {
            InertialKind::Own => 1,
            InertialKind::Payload => 2,
        };
        let before = core::mem::replace(&mut inertias.links[frame][at], *inertial);
        inertias.update_bodies(mechanism);
        let Some(v) = inertias.first_singular(mechanism) else { return Ok(()) };
        inertias.links[frame][at] = before;
        inertias.update_bodies(mechanism);
        let moves =
            |link: &usize| model.mimic(*link).is_none() && model.v_range(*link).contains(&v);
        let link = (0..model.links().len()).find(moves);
        let joint = link.map(|link| model.links()[link].joint.name.clone()).unwrap_or_default();
        Err(InertialError::NoInertia { joint })
    }
}
