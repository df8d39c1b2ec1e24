//! Equal limbs as one limb of lanes: legs on a trunk, arms on a torso, fingers on a palm.
//!
//! Limbs are equal if they have the same joint types in the same tree; their numbers may differ. They
//! are put side by side, a limb a lane: one body stands for one of each, its numbers are lanes of
//! theirs, and the same equations run on it. What such limbs leave on the body that they hang on adds up
//! over the lanes ([`Body::limbs`]); what they get from there is the same for all.

mod coupled;

use std::ops::Range;

use modyn_runtime::equations::Partition;
use modyn_runtime::equations::partition::Block;
use modyn_runtime::joint::Primitive;
use modyn_runtime::model::prepare::{Body, Dof, Prepared, Zero};
use modyn_runtime::spatial::{Pose, Turn};

use crate::expr::Expr;

/// Most limbs that are put side by side: the lanes of the longest vectors.
const MOST: usize = 8;

/// Which limbs of a robot are equal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limbs {
    /// By body of the robot that has one limb in place of equal ones: the bodies it stands for.
    bodies: Vec<Vec<usize>>,
    /// By its degrees of freedom: the entries of the robot's joint vectors, one a lane, and the limbs
    /// that it belongs to.
    velocities: Vec<(Vec<usize>, Option<usize>)>,
    /// By its coordinates: the robot's.
    coordinates: Vec<Vec<usize>>,
}

impl Limbs {
    /// Finds them; `None` if there are none.
    #[must_use]
    pub fn find(model: &Prepared<f64>) -> Option<Self> {
        if model.has_mimics() {
            return None;
        }
        let mut groups = Vec::new();
        find_among(model, &roots(model), &mut groups);
        if groups.is_empty() {
            return None;
        }
        let (mut bodies, mut velocities, mut coordinates) = (Vec::new(), Vec::new(), Vec::new());
        for (i, body) in model.bodies.iter().enumerate() {
            let group = groups.iter().position(|limbs| limbs.iter().any(|limb| limb.contains(&i)));
            let stands_for = match group {
                None => vec![i],
                Some(group) if groups[group][0].contains(&i) => {
                    let place = i - groups[group][0].start;
                    groups[group].iter().map(|limb| limb.start + place).collect()
                }
                Some(_) => continue,
            };
            for k in 0..body.dofs.len() {
                let of = stands_for.iter().map(|&b| model.dofs[model.bodies[b].dofs.start + k].v);
                velocities.push((of.collect(), group));
            }
            for k in 0..body.primitive.nq() {
                coordinates.push(stands_for.iter().map(|&b| model.bodies[b].q + k).collect());
            }
            bodies.push(stands_for);
        }
        Some(Self { bodies, velocities, coordinates })
    }

    /// Whether no limb moves another: all equal ones hang on the world.
    #[must_use]
    pub fn independent(&self, model: &Prepared<f64>) -> bool {
        self.roots(model).all(|parent| parent.is_none())
    }

    /// The parents of the first bodies of equal limbs.
    fn roots<'a>(&'a self, model: &'a Prepared<f64>) -> impl Iterator<Item = Option<usize>> + 'a {
        let several = self.bodies.iter().filter(|bodies| bodies.len() > 1);
        several.filter(|bodies| is_first(model, bodies)).map(|b| model.bodies[b[0]].parent)
    }

    /// The robot with one limb in place of equal ones.
    pub(super) fn merged(&self, model: &Prepared<f64>) -> Prepared<Expr> {
        let mut merged = model.cast();
        let new = |old: usize| self.bodies.iter().position(|bodies| bodies[0] == old);
        let (mut q, mut dofs) = (0, Vec::new());
        let mut bodies = Vec::with_capacity(self.bodies.len());
        for of in &self.bodies {
            let each: Vec<&Body<f64>> = of.iter().map(|&b| &model.bodies[b]).collect();
            let first = dofs.len();
            for k in 0..each[0].dofs.len() {
                let each: Vec<&Dof<f64>> =
                    each.iter().map(|body| &model.dofs[body.dofs.start + k]).collect();
                dofs.push(Dof {
                    body: bodies.len(),
                    v: dofs.len(),
                    component: each[0].component,
                    multiplier: None,
                    armature: optional(&each, |dof| dof.armature),
                    damping: optional(&each, |dof| dof.damping),
                    friction: optional(&each, |dof| dof.friction),
                });
            }
            let several = each.len() > 1 && is_first(model, of);
            let body = abreast(&each, first..dofs.len(), q);
            q += body.primitive.nq();
            bodies.push(Body {
                parent: each[0].parent.and_then(new),
                limbs: if several { each.len() } else { 1 },
                ..body
            });
        }
        (merged.bodies, merged.nq, merged.nv, merged.dofs) = (bodies, q, dofs.len(), dofs);
        // What is said by link has no meaning here.
        merged.links.clear();
        merged.frames.clear();
        merged.coordinates.clear();
        merged.closures.clear();
        merged
    }

    /// Modules of the robot as those of it with one limb in place of equal ones; modules do not reach
    /// from a body into limbs.
    #[must_use]
    pub fn partition(&self, of: &Partition) -> Partition {
        let mut merged = Partition { blocks: Vec::new(), pivots: 0 };
        let mut dofs = 0;
        for block in &of.blocks {
            let start = self.bodies.iter().position(|bodies| bodies[0] == block.bodies.start);
            let Some(start) = start else { continue };
            let size = block.dofs.len();
            merged.blocks.push(Block {
                bodies: start..start + block.bodies.len(),
                dofs: dofs..dofs + size,
                pivot: merged.pivots,
                has_children: block.has_children,
            });
            dofs += size;
            merged.pivots += size * size;
        }
        merged
    }

    /// Coordinates, lane by lane.
    pub(super) fn coordinates(&self, q: &[Expr]) -> Vec<Expr> {
        self.coordinates.iter().map(|of| beside(of.iter().map(|&i| q[i]))).collect()
    }

    /// A joint vector, lane by lane.
    pub(super) fn vector(&self, x: &[Expr]) -> Vec<Expr> {
        self.velocities.iter().map(|(of, _)| beside(of.iter().map(|&i| x[i]))).collect()
    }

    /// The robot's joint vector from lanes.
    pub(super) fn vector_apart(&self, x: &[Expr], nv: usize) -> Vec<Expr> {
        let mut apart = vec![constant(0.0); nv];
        for (&x, (of, _)) in x.iter().zip(&self.velocities) {
            for (lane, &i) in of.iter().enumerate() {
                apart[i] = x.lane(lane);
            }
        }
        apart
    }

    /// The robot's matrix by columns from lanes; entries of two different limbs are zero.
    pub(super) fn matrix_apart(&self, columns: &[Expr], nv: usize) -> Vec<Expr> {
        let n = self.velocities.len();
        let mut apart = vec![constant(0.0); nv * nv];
        for (c, (column, of)) in self.velocities.iter().enumerate() {
            for (r, (row, other)) in self.velocities.iter().enumerate() {
                if of.is_some() && other.is_some() && of != other {
                    continue;
                }
                for lane in 0..column.len().max(row.len()) {
                    let at = |of: &[usize]| of[lane.min(of.len() - 1)];
                    apart[at(column) * nv + at(row)] = columns[c * n + r].lane(lane);
                }
            }
        }
        apart
    }
}

/// Whether they are the first bodies of their limbs: they hang on one body, or on the world.
fn is_first(model: &Prepared<f64>, bodies: &[usize]) -> bool {
    bodies.iter().all(|&b| model.bodies[b].parent == model.bodies[bodies[0]].parent)
}

/// The bodies that hang on the world, each with all behind it.
fn roots(model: &Prepared<f64>) -> Vec<Range<usize>> {
    children(model, None, 0..model.bodies.len())
}

/// The bodies among `range` that hang on `parent`, each with all behind it.
fn children(
    model: &Prepared<f64>,
    parent: Option<usize>,
    range: Range<usize>,
) -> Vec<Range<usize>> {
    let starts: Vec<usize> = range.clone().filter(|&i| model.bodies[i].parent == parent).collect();
    let ends = starts.iter().skip(1).copied().chain([range.end]);
    starts.iter().zip(ends).map(|(&start, end)| start..end).collect()
}

/// Groups equal limbs among `limbs`, which hang on one body, and goes on inside the others.
fn find_among(model: &Prepared<f64>, limbs: &[Range<usize>], groups: &mut Vec<Vec<Range<usize>>>) {
    let mut rest = limbs.to_vec();
    while !rest.is_empty() {
        let limb = rest.remove(0);
        let shape = shape(model, &limb);
        let (equal, others): (Vec<_>, Vec<_>) = if shape.contains(&(Primitive::Floating, 0)) {
            (Vec::new(), rest)
        } else {
            rest.into_iter().partition(|other| self::shape(model, other) == shape)
        };
        rest = others;
        if equal.is_empty() {
            let inside = limb.start + 1..limb.end;
            find_among(model, &children(model, Some(limb.start), inside), groups);
            continue;
        }
        let all = [vec![limb], equal].concat();
        // One that is left over stays alone.
        groups.extend(all.chunks(MOST).filter(|some| some.len() > 1).map(<[_]>::to_vec));
    }
}

/// The joint types of a limb, and on which of its bodies each hangs (0 for the first one, whatever it
/// hangs on).
fn shape(model: &Prepared<f64>, limb: &Range<usize>) -> Vec<(Primitive, usize)> {
    let of = |i: usize| {
        let parent = model.bodies[i].parent.and_then(|parent| parent.checked_sub(limb.start));
        (model.bodies[i].primitive, parent.map_or(0, |parent| parent + 1))
    };
    limb.clone().map(of).collect()
}

fn constant(value: f64) -> Expr {
    <Expr as modyn_runtime::Scalar>::from_f64(value)
}

fn beside(numbers: impl Iterator<Item = Expr>) -> Expr {
    Expr::beside(&numbers.collect::<Vec<_>>())
}

/// Constants side by side, as `each` lists them for the items.
fn numbers<T>(items: &[&T], each: impl Fn(&T, &mut dyn FnMut(f64))) -> impl Iterator<Item = Expr> {
    let lists: Vec<Vec<f64>> = items
        .iter()
        .map(|item| {
            let mut list = Vec::new();
            each(item, &mut |x| list.push(x));
            list
        })
        .collect();
    (0..lists[0].len()).map(move |n| beside(lists.iter().map(|list| constant(list[n]))))
}

/// A number that not all have: zero for those.
fn optional(dofs: &[&Dof<f64>], of: impl Fn(&Dof<f64>) -> Option<f64>) -> Option<Expr> {
    let has = dofs.iter().any(|dof| of(dof).is_some());
    has.then(|| beside(dofs.iter().map(|dof| constant(of(dof).unwrap_or(0.0)))))
}

/// Bodies as one.
fn abreast(each: &[&Body<f64>], dofs: Range<usize>, q: usize) -> Body<Expr> {
    let first = each[0];
    let turns = |of: fn(&Body<f64>) -> Turn<f64>| {
        turn(&each.iter().map(|body| of(body)).collect::<Vec<_>>())
    };
    let mut translations = numbers(each, |b, f| b.placement.translation.0.into_iter().for_each(f));
    let mut inertias = numbers(each, |b, f| _ = b.inertia.map(f));
    let mut minimal = numbers(each, |b, f| _ = b.minimal.map(f));
    let next = "as many for each body";
    Body {
        parent: None,
        primitive: first.primitive,
        q,
        mimic: None,
        dofs,
        zero: zero(&each.iter().map(|body| body.zero).collect::<Vec<_>>()),
        placement: modyn_runtime::spatial::Placement {
            azimuth: turns(|body| body.placement.azimuth),
            translation: modyn_runtime::spatial::Vector3(
                first.placement.translation.0.map(|_| translations.next().expect(next)),
            ),
            tilt: turns(|body| body.placement.tilt),
        },
        link: Pose::identity(),
        inertia: first.inertia.map(|_| inertias.next().expect(next)),
        minimal: first.minimal.map(|_| minimal.next().expect(next)),
        limbs: 1,
    }
}

/// Turns as one: free where all are the same quarter turn.
fn turn(turns: &[Turn<f64>]) -> Turn<Expr> {
    if let (Turn::Quarters(n), true) = (turns[0], turns.iter().all(|turn| *turn == turns[0])) {
        return Turn::Quarters(n);
    }
    let direction = |turn: &Turn<f64>| match *turn {
        Turn::Angle { cos, sin } => (cos, sin),
        Turn::Quarters(n) => [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][usize::from(n % 4)],
    };
    Turn::Angle {
        cos: beside(turns.iter().map(|turn| constant(direction(turn).0))),
        sin: beside(turns.iter().map(|turn| constant(direction(turn).1))),
    }
}

/// Zeros as one.
fn zero(zeros: &[Zero<f64>]) -> Zero<Expr> {
    if let (Zero::Quarters(n), true) = (zeros[0], zeros.iter().all(|zero| *zero == zeros[0])) {
        return Zero::Quarters(n);
    }
    let angle = |zero: &Zero<f64>| match *zero {
        Zero::Angle(angle) => angle,
        Zero::Quarters(n) => f64::from(n) * std::f64::consts::FRAC_PI_2,
    };
    Zero::Angle(beside(zeros.iter().map(|zero| constant(angle(zero)))))
}
