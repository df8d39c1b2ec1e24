//! The measures of a robot by which the length of its text is estimated.

use std::collections::HashSet;

use modyn_runtime::model::{Link, Model, Module, ModuleTree};

use super::frames::MAX_OWN_FUNCTIONS;

/// The properties of a robot that the lengths of its functions depend on. A joint of several degrees of freedom counts as
/// several joints in part.
pub struct Measures {
    /// The number of moving links.
    pub links: f64,
    /// The number of moving links with a moving parent. Links on the world have hardly any dynamics.
    pub carried: f64,
    /// The sum over the moving links of their numbers of ancestors.
    pub depths: f64,
    /// The sum of the squares of these numbers.
    pub squares: f64,
    /// The number of entries of the mass matrix.
    pub entries: f64,
    /// The sum over the modules of the cubes of their degrees of freedom.
    pub pivots: f64,
    /// The number of links of the description.
    pub frames: f64,
    /// The number of functions of one link: own functions, and functions that links share.
    pub kernels: f64,
    /// The sum over these functions of the link's number of ancestors.
    pub chains: f64,
    /// The number of links that share a function.
    pub rows: f64,
    /// The number of degrees of freedom.
    pub nv: f64,
    /// The number of floating joints.
    pub bases: f64,
    /// The largest number of kinds of bodies in loops over the bodies. Those of a type of joint run one piece of code on the
    /// main line of a branch, another where a branch begins, and another on the world.
    pub kinds: f64,
    /// The number of constraint rows.
    pub constraint_rows: f64,
    /// The sum over the frames of constraints of the numbers of ancestors of their links.
    pub reach: f64,
    /// The sum over the rows of constraints of the numbers of ancestors of their links.
    pub row_reach: f64,
}

impl Measures {
    /// Returns the measures of a model that is divided into `modules`.
    #[allow(clippy::cast_precision_loss)]
    pub(crate) fn new(model: &Model, modules: &ModuleTree) -> Self {
        let weights =
            model.links().iter().map(|link| 0.75 + 0.25 * link.joint.joint_type.nv() as f64);
        let weights: Vec<f64> = weights.collect();
        let mut depths: Vec<f64> = Vec::with_capacity(weights.len());
        for (link, weight) in model.links().iter().zip(&weights) {
            // Parents come before their children.
            depths.push(weight + link.parent.map_or(0.0, |parent| depths[parent]));
        }
        let carried = model.links().iter().zip(&weights).filter(|(link, _)| link.parent.is_some());
        let mut on_body = vec![0_usize; weights.len() + 1];
        for frame in model.frames() {
            on_body[frame.link.map_or(weights.len(), |link| link)] += 1;
        }
        let kernels = |frames: usize| frames.min(MAX_OWN_FUNCTIONS + 1) as f64;
        let pivot = |module: &Module| {
            let dofs = model.links()[module.links.clone()].iter().map(|l| l.joint.joint_type.nv());
            (dofs.sum::<usize>() as f64).powi(3)
        };
        let depth = |frame: usize| model.frames()[frame].link.map_or(0.0, |link| depths[link]);
        let loops = model.loop_constraints().iter().map(|constraint| {
            let [first, second] = &constraint.ends;
            (constraint.kind.rows() as f64, depth(first.frame) + depth(second.frame))
        });
        let contacts = model.contacts().iter();
        let contacts = contacts.map(|c| (c.kind.rows() as f64, depth(c.end.frame)));
        let constraints: Vec<(f64, f64)> = loops.chain(contacts).collect();
        Self {
            links: weights.iter().sum(),
            carried: carried.map(|(_, weight)| weight).sum(),
            depths: depths.iter().zip(&weights).map(|(depth, weight)| depth * weight).sum(),
            squares: depths
                .iter()
                .zip(&weights)
                .map(|(depth, weight)| depth * depth * weight)
                .sum(),
            entries: (model.nv() as f64).powi(2),
            pivots: modules.modules().iter().map(pivot).sum(),
            frames: model.frames().len() as f64,
            kernels: on_body.iter().map(|&frames| kernels(frames)).sum(),
            chains: on_body
                .iter()
                .zip(&depths)
                .map(|(&frames, depth)| kernels(frames) * depth)
                .sum(),
            rows: on_body.iter().map(|&n| n.saturating_sub(MAX_OWN_FUNCTIONS) as f64).sum(),
            nv: model.nv() as f64,
            bases: model.links().iter().filter(|link| link.joint.joint_type.nv() == 6).count()
                as f64,
            kinds: kinds(model),
            constraint_rows: model.constraint_rows() as f64,
            reach: constraints.iter().map(|(_, depth)| depth).sum(),
            row_reach: constraints.iter().map(|(rows, depth)| rows * depth).sum(),
        }
    }

    /// Returns the measures of a robot with a body of each kind. Straight-line code of this robot is about as long as the pieces
    /// of code in loops over the bodies.
    pub fn of_kinds(&self) -> Self {
        Self { links: self.kinds, carried: self.kinds, ..*self }
    }

    /// Returns the estimated length in bytes of the functions of a link: `step` for each joint of the kinematic path,
    /// `results` for each function, and the calls for links that share one.
    pub(super) fn of_links(&self, step: f64, results: f64) -> f64 {
        step * self.chains + results * self.kernels + 250.0 * self.rows
    }
}

/// Returns [`Measures::kinds`]. A link with a joint of several degrees of freedom has a body for each.
#[allow(clippy::cast_precision_loss)]
fn kinds(model: &Model) -> f64 {
    let mut children = vec![0_usize; model.links().len()];
    for parent in model.links().iter().filter_map(|link| link.parent) {
        children[parent] += 1;
    }
    let kind = |link: &Link| {
        let place = link.parent.map(|parent| children[parent] > 1);
        (std::mem::discriminant(&link.joint.joint_type), link.joint.joint_type.nv(), place)
    };
    let distinct: HashSet<_> = model.links().iter().map(kind).collect();
    distinct.iter().map(|(_, nv, _)| *nv as f64).sum()
}
