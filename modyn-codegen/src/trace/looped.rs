//! The graphs of a recursion that runs in loops over the bodies: one for each kind of bodies, in
//! which the numbers of a body are inputs.
//!
//! The equations of a sweep over bodies call a function for one body, such as `link_wrench`.
//! `equations/dynamics/one_body.rs` of the runtime calls the same functions with the numbers that
//! pass between a body and its parent as arguments, and is traced once for each kind of body (joint
//! type, free base). The constants of a body are inputs, unless all bodies of the kind have the
//! same constant, which is folded. `program/bodies/` cuts the graph into one routine for each
//! sweep, and assigns places in a body's record to the numbers that the body keeps or exchanges.

use std::cell::RefCell;

use modyn_runtime::Scalar;
use modyn_runtime::equations::dynamics::{BodyRecursion, is_base};
use modyn_runtime::joint::ElementaryJoint;
use modyn_runtime::mechanism::{Body, Dof, Mechanism};
use modyn_runtime::spatial::AxisRotation;

use super::Tracer;
use super::merge::{merged_body, optional};
use crate::graph::bodies::{BodyGraphs, BodyKind, LoopedBody};
use crate::graph::{Expr, Graph, Node};

impl Tracer<'_> {
    /// Returns the graphs of `recursion`; `None` for robots that loops do not suit: those without
    /// joints, with mimic joints, with run-time inertias or with gravity compensation.
    ///
    /// The coordinates of mimic joints belong to several bodies, and the numbers of a body with a
    /// run-time inertia are not constants.
    #[must_use]
    pub fn body_graphs(&self, recursion: &BodyRecursion<Expr>) -> Option<BodyGraphs> {
        let model = self.model;
        let parameters = &self.parameters;
        let is_described = parameters.inertias.is_empty() && parameters.payloads.is_empty();
        let looped = is_described && !model.has_mimics() && !model.compensates_gravity();
        if model.bodies.is_empty() || !looped {
            return None;
        }
        let mut keys: Vec<(ElementaryJoint, bool, bool)> = Vec::new();
        let mut members: Vec<Vec<usize>> = Vec::new();
        let mut bodies = Vec::with_capacity(model.bodies.len());
        for (i, body) in model.bodies.iter().enumerate() {
            // Roots and branches have an azimuth. In a kind without it, its products are
            // folded.
            let has_azimuth = body.placement.azimuth != AxisRotation::Quarters(0);
            let key = (body.elementary_joint, is_base(model, i), has_azimuth);
            let kind = keys.iter().position(|other| *other == key).unwrap_or_else(|| {
                keys.push(key);
                members.push(Vec::new());
                keys.len() - 1
            });
            bodies.push(LoopedBody {
                kind,
                row: members[kind].len(),
                parent: body.parent,
                starts: [body.q, model.dofs_of(i).first().map_or(0, |dof| dof.v)],
            });
            members[kind].push(i);
        }
        let kinds = members.iter().map(|members| self.body_kind(recursion, members)).collect();
        let sent_by_world = |sweep: usize| {
            Graph::trace(|| {
                let mut model = self.model.cast();
                parameters.enter(0, &mut model);
                (recursion.world)(&model).swap_remove(sweep)
            })
        };
        Some(BodyGraphs {
            sweeps: recursion.sweeps,
            world: (0..recursion.sweeps.len()).map(sent_by_world).collect(),
            kinds,
            bodies,
            parameters: parameters.len(),
        })
    }

    /// Returns the graph and the table of bodies of one kind.
    fn body_kind(&self, recursion: &BodyRecursion<Expr>, members: &[usize]) -> BodyKind {
        let body = &self.model.bodies[members[0]];
        let entries = [body.elementary_joint.nq(), body.dofs.len()];
        let [nq, nv] = entries;
        let before = nq + 2 * nv + self.parameters.len();
        let received: usize = recursion.sweeps.iter().map(|(_, numbers)| numbers).sum();
        let columns: RefCell<Vec<Vec<f64>>> = RefCell::default();
        let column = |numbers: &[f64]| {
            if numbers.iter().all(|x| *x == numbers[0]) {
                return Expr::from_f64(numbers[0]);
            }
            let mut columns = columns.borrow_mut();
            columns.push(numbers.to_vec());
            Expr::input(before + received + columns.len() - 1)
        };
        let mut kept = Vec::new();
        let mut sent = Vec::new();
        let graph = Graph::trace(|| {
            let mut model = self.two_bodies(members, &column);
            self.parameters.enter(nq + 2 * nv, &mut model);
            let mut next = 0;
            let mut inputs = |count: usize| -> Vec<Expr> {
                next += count;
                (next - count..next).map(Expr::input).collect()
            };
            let [q, a, b] = [nq, nv, nv].map(&mut inputs);
            inputs(self.parameters.len());
            let received_numbers: Vec<Vec<Expr>> =
                recursion.sweeps.iter().map(|(_, numbers)| inputs(*numbers)).collect();
            let received: Vec<&[Expr]> =
                received_numbers.iter().map(|numbers| &**numbers).collect();
            let results = (recursion.body)(&model, [&q, &a, &b], &received);
            let lengths = |numbers: &[Vec<Expr>]| numbers.iter().map(Vec::len).collect();
            (kept, sent) = (lengths(&results.own), lengths(&results.sent));
            [results.own.concat(), results.sent.concat(), results.result].concat()
        });
        let (graph, columns) = without_unused(&graph, before + received, columns.into_inner());
        let row = |body: usize| columns.iter().map(|column| column[body]).collect();
        let table = (0..members.len()).map(row).collect();
        BodyKind { graph, entries, kept, sent, table }
    }

    /// Returns the mechanism of one body and its parent. `column` returns the expression of a
    /// number, from its values in all bodies of the kind.
    fn two_bodies(&self, members: &[usize], column: &dyn Fn(&[f64]) -> Expr) -> Mechanism<Expr> {
        let model = self.model;
        let each: Vec<&Body<f64>> = members.iter().map(|&i| &model.bodies[i]).collect();
        let nq = each[0].elementary_joint.nq();
        let nv = each[0].dofs.len();
        let mut body = merged_body(&each, 0..nv, 0, column);
        body.parent = (!is_base(model, members[0])).then_some(0);
        let dof = |k: usize| {
            let dofs: Vec<&Dof<f64>> = each.iter().map(|b| &model.dofs[b.dofs.start + k]).collect();
            Dof {
                body: 1,
                component: dofs[0].component,
                v: k,
                multiplier: None,
                armature: optional(&dofs, |dof| dof.armature, column),
                damping: optional(&dofs, |dof| dof.damping, column),
                friction: optional(&dofs, |dof| dof.friction, column),
            }
        };
        Mechanism {
            gravity: model.gravity.0.map(Expr::from_f64).into(),
            gravity_compensation: Vec::new(),
            bodies: vec![Body { parent: None, dofs: 0..0, spring: None, ..body.clone() }, body],
            dofs: (0..nv).map(dof).collect(),
            static_inertia: model.static_inertia.map(Expr::from_f64),
            links: Vec::new(),
            nq,
            nv,
            coordinates: Vec::new(),
            smooth: model.smooth.map(Expr::from_f64),
            frames: Vec::new(),
            constraints: Vec::new(),
        }
    }
}

/// Returns the graph with those columns alone that it reads; columns are its inputs from number
/// `first` on.
fn without_unused(graph: &Graph, first: usize, columns: Vec<Vec<f64>>) -> (Graph, Vec<Vec<f64>>) {
    let live = graph.live();
    let is_read = |i: usize| graph.find(Node::input(i)).is_some_and(|id| live[id as usize]);
    let mut compact = Graph::default();
    let mut inputs = compact.inputs(0..first);
    let mut left = Vec::new();
    for (i, column) in columns.into_iter().enumerate() {
        inputs.push(compact.input(first + left.len()));
        if is_read(first + i) {
            left.push(column);
        }
    }
    compact.outputs = compact.compose(graph, &inputs);
    (compact, left)
}
