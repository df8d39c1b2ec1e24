//! Convex hulls of points: the quickhull algorithm (Barber, Dobkin and Huhdanpaa 1996).

use crate::description::cross;
use crate::work::counted;

/// The largest number of corners of a hull that touch the ground.
const MAX_CORNERS: usize = 16;

/// Returns the corners of the convex hull of these points; of more than [`MAX_CORNERS`] the corners
/// that are farthest from each other.
///
/// # Errors
///
/// Returns the fault of the mesh, as the end of a sentence about it.
pub fn corners(vertices: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, &'static str> {
    let mut indices: Vec<usize> = hull(vertices)?.into_iter().flatten().collect();
    indices.sort_unstable();
    indices.dedup();
    let hull: Vec<[f64; 3]> = indices.into_iter().map(|index| vertices[index]).collect();
    if hull.len() <= MAX_CORNERS {
        return Ok(hull);
    }
    let square = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum();
    let mut chosen = vec![hull[0]];
    let mut distances: Vec<f64> = vec![f64::INFINITY; hull.len()];
    while chosen.len() <= MAX_CORNERS {
        let last = chosen[chosen.len() - 1];
        for (distance, point) in distances.iter_mut().zip(&hull) {
            *distance = distance.min(square(*point, last));
        }
        let farthest = (0..hull.len()).max_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        chosen.push(hull[farthest.unwrap_or_default()]);
    }
    // The first corner was any.
    chosen.remove(0);
    Ok(chosen)
}

/// A triangle of the hull.
struct Facet {
    /// The corners, counterclockwise from outside.
    corners: [usize; 3],
    /// The facet across the edge from each corner to the next.
    neighbors: [usize; 3],
    /// The unit normal, outwards; zero for a facet without an area.
    normal: [f64; 3],
    /// The distance of the plane from the origin along the normal.
    offset: f64,
    /// The points above the plane that no other facet has.
    outside: Vec<usize>,
    is_removed: bool,
}

impl Facet {
    fn new(points: &[[f64; 3]], corners: [usize; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| points[corner]);
        let normal = cross(difference(b, a), difference(c, a));
        let length = libm::sqrt(dot(normal, normal));
        let normal = if length > 0.0 { normal.map(|x| x / length) } else { [0.0; 3] };
        let offset = dot(normal, a);
        Self { corners, neighbors: [0; 3], normal, offset, outside: Vec::new(), is_removed: false }
    }

    fn distance(&self, point: [f64; 3]) -> f64 {
        dot(self.normal, point) - self.offset
    }
}

/// The largest number of facets that are made, most of which are removed again. A hull of a scanned
/// mesh makes some ten for each of its corners; the hull of many points on a circle makes half as
/// many for each point as there are points.
const MAX_FACETS: usize = 5_000_000;

const IN_ONE_PLANE: &str = "has all vertices in one plane";
const TOO_MANY: &str = "has a convex hull of too many vertices in common planes: reduce them, or give \
                        the body an `<inertial>`";
const INCONSISTENT: &str = "has vertices too close to each other for a convex hull";

/// Returns the triangles of the convex hull of these points, with their normals outwards. Points
/// whose distance from the hull is a rounding error are left out. An error if all points are in one
/// plane, or if the hull takes too long.
pub fn hull(points: &[[f64; 3]]) -> Result<Vec<[usize; 3]>, &'static str> {
    let largest = points.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let tolerance = 32.0 * f64::EPSILON * largest;
    let simplex = simplex(points, tolerance).ok_or(IN_ONE_PLANE)?;
    let mut facets: Vec<Facet> = Vec::new();
    // The four facets of a tetrahedron, each without one of the points.
    let [a, b, c, d] = simplex;
    for corners in [[a, b, c], [a, c, d], [a, d, b], [b, d, c]] {
        facets.push(Facet::new(points, corners));
    }
    let neighbors = [[2, 3, 1], [0, 3, 2], [1, 3, 0], [2, 1, 0]];
    for (facet, neighbors) in facets.iter_mut().zip(neighbors) {
        facet.neighbors = neighbors;
    }
    for point in (0..points.len()).filter(|point| !simplex.contains(point)) {
        assign(points, &mut facets, 0, point, tolerance);
    }
    let mut open: Vec<usize> = (0..4).collect();
    let mut made = facets.len();
    // The removed facets are dropped when there may be as many as others.
    let mut most = 1024;
    while let Some(at) = open.pop() {
        if facets[at].is_removed || facets[at].outside.is_empty() {
            continue;
        }
        let height = |point: &usize| facets[at].distance(points[*point]);
        let highest =
            facets[at].outside.iter().copied().max_by(|a, b| height(a).total_cmp(&height(b)));
        let farthest = highest.ok_or(INCONSISTENT)?;
        let (visible, horizon) = visible_from(points[farthest], &mut facets, at, tolerance);
        let first = facets.len();
        for (i, &(from, to, beyond)) in horizon.iter().enumerate() {
            let mut facet = Facet::new(points, [from, to, farthest]);
            let count = horizon.len();
            facet.neighbors = [beyond, first + (i + 1) % count, first + (i + count - 1) % count];
            let across = &mut facets[beyond];
            let edge =
                (0..3).find(|&k| across.corners[k] == to && across.corners[(k + 1) % 3] == from);
            across.neighbors[edge.ok_or(INCONSISTENT)?] = first + i;
            facets.push(facet);
        }
        for at in visible {
            for point in core::mem::take(&mut facets[at].outside) {
                if point != farthest {
                    assign(points, &mut facets, first, point, tolerance);
                }
            }
        }
        open.extend(first..facets.len());
        made += horizon.len();
        if made > MAX_FACETS {
            return Err(TOO_MANY);
        }
        if facets.len() > most {
            drop_removed(&mut facets, &mut open);
            most = 1024 + 2 * facets.len();
        }
    }
    Ok(facets.iter().filter(|facet| !facet.is_removed).map(|facet| facet.corners).collect())
}

/// Drops the facets that are removed; the order of the others is kept.
fn drop_removed(facets: &mut Vec<Facet>, open: &mut Vec<usize>) {
    open.retain(|&facet| !facets[facet].is_removed);
    let mut kept = 0;
    let numbers: Vec<usize> = facets
        .iter()
        .map(|facet| {
            let number = kept;
            kept += usize::from(!facet.is_removed);
            number
        })
        .collect();
    facets.retain(|facet| !facet.is_removed);
    for facet in facets {
        facet.neighbors = facet.neighbors.map(|neighbor| numbers[neighbor]);
    }
    open.iter_mut().for_each(|facet| *facet = numbers[*facet]);
}

/// Gives a point to the first facet from `first` on that it is above.
fn assign(points: &[[f64; 3]], facets: &mut [Facet], first: usize, point: usize, tolerance: f64) {
    let mut later = counted(facets[first..].iter_mut());
    if let Some(facet) = later.find(|facet| facet.distance(points[point]) > tolerance) {
        facet.outside.push(point);
    }
}

/// Removes the facets that a point above facet `at` sees. Returns them, and the edges around them
/// in order, each with the facet beyond it.
fn visible_from(
    point: [f64; 3],
    facets: &mut [Facet],
    at: usize,
    tolerance: f64,
) -> (Vec<usize>, Vec<(usize, usize, usize)>) {
    facets[at].is_removed = true;
    let mut visible = vec![at];
    let mut horizon = Vec::new();
    // A walk around the facets in depth-first order, so that the edges follow each other: the
    // facet, and its edges to cross.
    let mut path = vec![(at, 0, 3)];
    while let Some((facet, edge, left)) = path.pop() {
        if left == 0 {
            continue;
        }
        path.push((facet, (edge + 1) % 3, left - 1));
        let beyond = facets[facet].neighbors[edge];
        if facets[beyond].is_removed {
            continue;
        }
        let from = facets[facet].corners[edge];
        let to = facets[facet].corners[(edge + 1) % 3];
        if facets[beyond].distance(point) > tolerance {
            facets[beyond].is_removed = true;
            visible.push(beyond);
            let back = facets[beyond].neighbors.iter().position(|&one| one == facet).unwrap_or(0);
            path.push((beyond, (back + 1) % 3, 2));
        } else {
            horizon.push((from, to, beyond));
        }
    }
    (visible, horizon)
}

/// Returns four points that are not in one plane, such that the first three are counterclockwise
/// from outside.
fn simplex(points: &[[f64; 3]], tolerance: f64) -> Option<[usize; 4]> {
    let farthest = |distance: &dyn Fn([f64; 3]) -> f64| {
        let distances = points.iter().map(|point| distance(*point)).enumerate();
        distances.max_by(|(_, a), (_, b)| a.total_cmp(b)).filter(|(_, most)| *most > tolerance)
    };
    let origin = *points.first()?;
    let (a, _) = farthest(&|point| length(difference(point, origin)))?;
    let (b, _) = farthest(&|point| length(difference(point, points[a])))?;
    let direction = difference(points[b], points[a]);
    let along = direction.map(|x| x / length(direction));
    let (c, _) = farthest(&|point| length(cross(along, difference(point, points[a]))))?;
    let facet = Facet::new(points, [a, b, c]);
    let (d, _) = farthest(&|point| facet.distance(point).abs())?;
    Some(if facet.distance(points[d]) < 0.0 { [a, b, c, d] } else { [a, c, b, d] })
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: [f64; 3]) -> f64 {
    libm::sqrt(dot(a, a))
}
