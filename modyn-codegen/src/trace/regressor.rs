//! The graph of the regressor.

use modyn_runtime::Scalar;
use modyn_runtime::equations::{Workspace, identification::regressor};
use modyn_runtime::model::PARAMETERS_PER_LINK;

use super::Tracer;
use crate::graph::{Expr, Graph};

impl Tracer<'_> {
    /// Returns the graph of the regressor by columns, ten for each moving link. Inputs: `q`, `qd`, `qdd`.
    #[must_use]
    pub fn regressor(&self) -> Graph {
        self.trace(|model, [q, qd, qdd]| {
            let size = model.nv * PARAMETERS_PER_LINK * model.links.len();
            let mut columns = vec![Expr::zero(); size];
            let workspace = &mut Workspace::new(model);
            regressor(model, (&q, &qd, &qdd), workspace, &mut columns);
            columns
        })
    }
}
