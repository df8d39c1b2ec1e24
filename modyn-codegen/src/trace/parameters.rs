//! What of a robot is an argument of its functions.

use modyn_runtime::Scalar as _;
use modyn_runtime::mechanism::{Mechanism, rigid_inertia};
use modyn_runtime::model::{Inertial, Model};
use modyn_runtime::spatial::{RigidInertia, Symmetric3, Vector3};

use crate::expr::Expr;

/// The parts of a robot that are known at run time only.
#[derive(Clone, Debug, Default)]
pub struct Parameters {
    /// Whether gravity is.
    pub gravity: bool,
    /// Links whose own inertia is.
    pub payload: Vec<Payload>,
}

/// A link whose own inertia is an argument.
#[derive(Clone, Debug)]
pub struct Payload {
    /// The link, as an index into [`Model::frames`].
    pub frame: usize,
    /// What the description says it is.
    pub described: Inertial,
}

impl Parameters {
    /// Those of a model: gravity, and these links, as indices into its frames.
    #[must_use]
    pub fn new(model: &Model, gravity: bool, payload: &[usize]) -> Self {
        let payload = payload
            .iter()
            .map(|&frame| Payload { frame, described: model.frames()[frame].inertial });
        Self { gravity, payload: payload.collect() }
    }

    /// How many numbers they are: gravity's three, then for each link its mass, centre of mass
    /// and inertia about that, as [`Inertial`] has them.
    #[must_use]
    pub fn len(&self) -> usize {
        self.payload.len() * 10 + if self.gravity { 3 } else { 0 }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Puts the inputs from number `next` on where they belong.
    pub(super) fn enter(&self, next: usize, model: &mut Mechanism<Expr>) {
        let mut inputs = (next..).map(Expr::input);
        let mut input = || inputs.next().expect("endless");
        if self.gravity {
            model.gravity = Vector3([input(), input(), input()]);
        }
        for payload in &self.payload {
            let mass = input();
            let center = Vector3([input(), input(), input()]);
            let [xx, xy, xz, yy, yz, zz] = std::array::from_fn(|_| input());
            let inertia = Symmetric3 { xx, xy, xz, yy, yz, zz };
            let own = rigid_inertia(&payload.described).map(Expr::from_f64);
            model.replace_inertia(payload.frame, &own, &RigidInertia::new(mass, center, &inertia));
        }
    }
}
