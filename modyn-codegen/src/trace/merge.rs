//! Several bodies as one body, whose numbers stand for the numbers of each: lanes of limbs, or
//! columns of a table.

use std::ops::Range;

use modyn_runtime::joint::JointOffset;
use modyn_runtime::mechanism::{Body, Dof, JointSpring};
use modyn_runtime::spatial::{AxisRotation, DhTransform, Pose, Vector3};

use crate::graph::Expr;

/// Returns the expression of a number, from its values in all bodies.
pub(super) type Merge<'a> = &'a dyn Fn(&[f64]) -> Expr;

/// Returns the merged numbers of the items; `each` lists the numbers of an item.
fn numbers<'a, T>(
    items: &[&T],
    each: fn(&T, &mut dyn FnMut(f64)),
    merge: Merge<'a>,
) -> impl Iterator<Item = Expr> + use<'a, T> {
    let lists: Vec<Vec<f64>> = items
        .iter()
        .map(|item| {
            let mut list = Vec::new();
            each(item, &mut |x| list.push(x));
            list
        })
        .collect();
    (0..lists[0].len()).map(move |n| merge(&lists.iter().map(|list| list[n]).collect::<Vec<f64>>()))
}

/// Returns a number that some degrees of freedom lack, which count as zero; `None` if all lack it.
pub(super) fn optional(
    dofs: &[&Dof<f64>],
    number: impl Fn(&Dof<f64>) -> Option<f64>,
    merge: Merge<'_>,
) -> Option<Expr> {
    let has = dofs.iter().any(|dof| number(dof).is_some());
    has.then(|| merge(&dofs.iter().map(|dof| number(dof).unwrap_or(0.0)).collect::<Vec<f64>>()))
}

/// Returns bodies with the same elementary joint as one body, with these degrees of freedom and
/// this entry of q.
pub(super) fn merged_body(
    each: &[&Body<f64>],
    dofs: Range<usize>,
    q: usize,
    merge: Merge<'_>,
) -> Body<Expr> {
    let first = each[0];
    let rotations = |rotation: fn(&Body<f64>) -> AxisRotation<f64>| {
        merged_rotation(&each.iter().map(|body| rotation(body)).collect::<Vec<_>>(), merge)
    };
    let mut translations =
        numbers(each, |b, f| b.placement.translation.0.into_iter().for_each(f), merge);
    let mut inertias = numbers(each, |b, f| _ = b.inertia.map(f), merge);
    let mut base_inertias = numbers(each, |b, f| _ = b.base_inertia.map(f), merge);
    let next = "as many for each body";
    Body {
        parent: None,
        elementary_joint: first.elementary_joint,
        q,
        mimic: None,
        dofs,
        offset: merged_offset(&each.iter().map(|body| body.offset).collect::<Vec<_>>(), merge),
        placement: DhTransform {
            azimuth: rotations(|body| body.placement.azimuth),
            translation: Vector3(
                first.placement.translation.0.map(|_| translations.next().expect(next)),
            ),
            tilt: rotations(|body| body.placement.tilt),
        },
        link: Pose::identity(),
        inertia: first.inertia.map(|_| inertias.next().expect(next)),
        base_inertia: first.base_inertia.map(|_| base_inertias.next().expect(next)),
        spring: merged_spring(each, merge),
        compensated: None,
    }
}

/// Returns the springs of bodies as one spring. A body without a spring has one of stiffness zero.
fn merged_spring(each: &[&Body<f64>], merge: Merge<'_>) -> Option<JointSpring<Expr>> {
    let some = each.iter().find_map(|body| body.spring)?;
    let numbers = |body: &&Body<f64>| {
        let mut numbers = Vec::new();
        let none = JointSpring { stiffness: 0.0, ..some };
        body.spring.unwrap_or(none).map(|x| numbers.push(x));
        numbers
    };
    let lists: Vec<Vec<f64>> = each.iter().map(numbers).collect();
    let mut n = 0;
    Some(some.map(|_| {
        n += 1;
        merge(&lists.iter().map(|list| list[n - 1]).collect::<Vec<f64>>())
    }))
}

/// Returns rotations as one rotation; free of operations if all are the same quarter turn.
fn merged_rotation(rotations: &[AxisRotation<f64>], merge: Merge<'_>) -> AxisRotation<Expr> {
    if let (AxisRotation::Quarters(n), true) =
        (rotations[0], rotations.iter().all(|rotation| *rotation == rotations[0]))
    {
        return AxisRotation::Quarters(n);
    }
    let direction = |rotation: &AxisRotation<f64>| match *rotation {
        AxisRotation::Angle { cos, sin } => (cos, sin),
        AxisRotation::Quarters(n) => {
            [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][usize::from(n % 4)]
        }
    };
    let (cos, sin): (Vec<f64>, Vec<f64>) = rotations.iter().map(direction).unzip();
    AxisRotation::Angle { cos: merge(&cos), sin: merge(&sin) }
}

/// Returns offsets as one offset.
fn merged_offset(offsets: &[JointOffset<f64>], merge: Merge<'_>) -> JointOffset<Expr> {
    if let (JointOffset::Quarters(n), true) =
        (offsets[0], offsets.iter().all(|offset| *offset == offsets[0]))
    {
        return JointOffset::Quarters(n);
    }
    let angle = |offset: &JointOffset<f64>| match *offset {
        JointOffset::Angle(angle) => angle,
        JointOffset::Quarters(n) => f64::from(n) * std::f64::consts::FRAC_PI_2,
    };
    JointOffset::Angle(merge(&offsets.iter().map(angle).collect::<Vec<f64>>()))
}
