//! Projection: the joint forces of perturbed accelerations.

use alloc::vec::Vec;
use core::ops::Range;

use crate::Scalar;
use crate::equations::Workspace;
use crate::joint::JointTransform;
use crate::mechanism::{Body, BodyTree, Dof, Mechanism, RootwardAccumulator};
use crate::spatial::{
    AccelerationPerturbation, Matrix3, RigidInertia, SpatialAxis, Vector3, VelocityMoments, Wrench,
};

/// The variables of the derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Variable {
    /// Coordinates. Bodies after the joint are displaced, together with their wrenches.
    Coordinates,
    /// Rates. No body is displaced.
    Rates,
}

/// Computes the derivatives of the joint forces, by columns, from `workspace.perturbations`.
///
/// The mass matrix needs the same sweep and is written to `mass_matrix` if that is given. Expects
/// composite inertias and angular velocities; derivatives with respect to coordinates also expect
/// the composites' wrenches.
///
/// A column is transformed from its body towards the root. Columns of consecutive joints can share
/// the lanes of one pack; a column enters the pack at its own joint
/// ([`MergedMechanism::with_column_lanes`](crate::mechanism::MergedMechanism::with_column_lanes)).
pub(super) fn project<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    by: Variable,
    workspace: &Workspace<S>,
    columns: &mut [S],
    mut mass_matrix: Option<&mut [S]>,
) {
    let model = tree.mechanism();
    columns.fill(S::zero());
    if let Some(mass_matrix) = mass_matrix.as_deref_mut() {
        mass_matrix.fill(S::zero());
    }
    let mut end = model.dofs.len();
    while end > 0 {
        let group = columns_before(model, tree.column_lanes(), end);
        end = group.start;
        project_group(
            tree,
            by,
            workspace,
            &group,
            &mut Entries { model, columns, mass_matrix: mass_matrix.as_deref_mut() },
        );
    }
}

/// Returns the last degrees of freedom before `end` whose columns share the lanes of one pack.
fn columns_before<S>(model: &Mechanism<S>, lanes: usize, end: usize) -> Range<usize> {
    let body = |d: usize| model.dofs[d].body;
    let follows = |d: usize| {
        let front = body(d - 1);
        let back = body(d);
        front == back || model.bodies[back].parent == Some(front)
    };
    let mut start = end - 1;
    while start > 0 && end - start < lanes && follows(start) {
        start -= 1;
    }
    start..end
}

/// Transforms the columns of `group` from the body of the last degree of freedom to the root.
fn project_group<S: Scalar, T: BodyTree<S>>(
    tree: &T,
    by: Variable,
    workspace: &Workspace<S>,
    group: &Range<usize>,
    entries: &mut Entries<'_, S>,
) {
    let model = tree.mechanism();
    let mut at = model.dofs[group.end - 1].body;
    // The state at body `at` of the columns from `joined` on.
    let mut swept: Option<SweepState<S>> = None;
    let mut joined = group.end;
    let mut path = RootwardAccumulator::new(tree);
    loop {
        let dofs = model.bodies[at].dofs.clone();
        for other in dofs.clone() {
            let Some(SweepState { wrench, dual }) = &swept else { break };
            let component = model.dofs[other].component;
            let force = wrench.components()[component];
            let work = dual.of(&workspace.perturbations[other]);
            let mass = dual.wrench.components()[component];
            for column in joined..group.end {
                let lane = |x: S| match group.len() {
                    1 => x,
                    _ => tree.extract_lane(x, column - group.start),
                };
                entries.add(other, column, lane(force));
                entries.add(column, other, lane(work));
                entries.add_masses(other, column, lane(mass));
            }
        }
        let composite = (joined > group.start).then(|| Composite::new(at, workspace));
        while joined > group.start.max(dofs.start) {
            joined -= 1;
            let composite = composite.as_ref().expect("made above");
            let masses = entries.add_own_entries(by, workspace, composite, joined);
            swept = Some(match swept {
                Some(swept) => {
                    let swept = swept.numbers();
                    let numbers = masses.numbers();
                    SweepState::of(core::array::from_fn(|k| {
                        let of_group = |d| tree.extract_lane(swept[k], d - group.start);
                        let lane = |d| if d <= joined { numbers[k] } else { of_group(d) };
                        tree.pack(&group.clone().map(lane).collect::<Vec<_>>())
                    }))
                }
                None => masses,
            });
        }
        let body = &model.bodies[at];
        let motion = &workspace.motions[at];
        let Some(parent) = body.parent else { break };
        let Some(whole) = &swept else { break };
        let at_parent = whole.at_parent(body, motion, workspace.relative_velocities[at]);
        swept = Some(SweepState::of(path.accumulate(at, parent, at_parent.numbers())));
        at = parent;
    }
}

/// The matrices that the sweep fills in.
struct Entries<'a, S> {
    model: &'a Mechanism<S>,
    columns: &'a mut [S],
    mass_matrix: Option<&'a mut [S]>,
}

impl<S: Scalar> Entries<'_, S> {
    /// Adds a column's entries for its own body's degrees of freedom. Returns the column's state at
    /// that body.
    fn add_own_entries(
        &mut self,
        by: Variable,
        workspace: &Workspace<S>,
        composite: &Composite<'_, S>,
        column: usize,
    ) -> SweepState<S> {
        let Dof { body, component, armature, .. } = self.model.dofs[column];
        let mut wrench = composite.required_wrench(&workspace.perturbations[column]);
        let dual = composite.dual_column(component);
        let dofs = self.model.bodies[body].dofs.clone();
        for row in dofs.clone() {
            self.add(row, column, wrench.components()[self.model.dofs[row].component]);
        }
        let masses = dual.wrench.components();
        let mass = masses[component];
        self.add_mass(column, column, armature.map_or(mass, |armature| mass + armature));
        for other in dofs.start..column {
            self.add_masses(other, column, masses[self.model.dofs[other].component]);
        }
        if by == Variable::Coordinates {
            wrench += displaced(workspace.wrenches[body], component);
        }
        SweepState { wrench, dual }
    }

    /// Adds `entry` to the derivative of `row` with respect to `column`.
    fn add(&mut self, row: usize, column: usize, entry: S) {
        let row = &self.model.dofs[row];
        let column = &self.model.dofs[column];
        let sum = &mut self.columns[column.v * self.model.nv + row.v];
        *sum = *sum + row.scale(column.scale(entry));
    }

    /// Adds `entry` to the mass matrix.
    fn add_mass(&mut self, row: usize, column: usize, entry: S) {
        let Some(mass_matrix) = self.mass_matrix.as_deref_mut() else { return };
        let row = &self.model.dofs[row];
        let column = &self.model.dofs[column];
        let sum = &mut mass_matrix[column.v * self.model.nv + row.v];
        *sum = *sum + row.scale(column.scale(entry));
    }

    /// Adds `entry` to both triangles of the mass matrix. If a mimic joint maps both degrees of
    /// freedom to one entry of qd, the entry counts twice.
    fn add_masses(&mut self, row: usize, column: usize, entry: S) {
        self.add_mass(row, column, entry);
        self.add_mass(column, row, entry);
    }
}

/// Returns the change, in the parent frame, of a wrench that is displaced with its body.
pub(super) fn displaced<S: Scalar>(wrench: Wrench<S>, component: usize) -> Wrench<S> {
    match SpatialAxis::of(component) {
        SpatialAxis::Linear(k) => {
            let moment = Vector3::unit(k).cross(wrench.force);
            Wrench { force: Vector3::zero(), moment }
        }
        SpatialAxis::Angular(k) => {
            let s = Vector3::unit(k);
            Wrench { force: s.cross(wrench.force), moment: s.cross(wrench.moment) }
        }
    }
}

/// The composite of a body and its descendants. The body rotates with half of `twice_omega`.
pub(super) struct Composite<'a, S> {
    inertia: &'a RigidInertia<S>,
    /// The velocity moments relative to the body's frame.
    velocities: &'a VelocityMoments<S>,
    twice_omega: Vector3<S>,
    /// The matrix that maps g to 2 integral x x (g x x') dm, with x' relative to the body's frame.
    rotational: Matrix3<S>,
}

impl<'a, S: Scalar> Composite<'a, S> {
    pub(super) fn new(i: usize, workspace: &'a Workspace<S>) -> Self {
        let inertia = &workspace.composite[i];
        let velocities = &workspace.velocities[i];
        let omega = workspace.fields[i].omega;
        let rotational = velocities.rotational();
        Self { inertia, velocities, twice_omega: omega + omega, rotational }
    }

    /// Returns the wrench that changes the composite's accelerations by `perturbation`: with x'
    /// relative to the body's frame, relative x x + coriolis x 2 x' + 2 omega x (coriolis x x) +
    /// uniform.
    pub(super) fn required_wrench(&self, perturbation: &AccelerationPerturbation<S>) -> Wrench<S> {
        let AccelerationPerturbation { relative, coriolis, uniform, .. } = *perturbation;
        let RigidInertia { mass, first_moment, second_moment } = *self.inertia;
        let rotated = second_moment.full().mul_vector(self.twice_omega);
        Wrench {
            moment: self.inertia.rotational().full().mul_vector(relative)
                + self.rotational.mul_vector(coriolis)
                + rotated.cross(coriolis)
                + first_moment.cross(uniform),
            force: relative.cross(first_moment)
                + coriolis.cross(self.velocities.first)
                + self.twice_omega.cross(coriolis.cross(first_moment))
                + uniform.scale(mass),
        }
    }

    /// Returns the dual column of a unit displacement in `component`.
    fn dual_column(&self, component: usize) -> DualColumn<S> {
        let RigidInertia { first_moment, second_moment, .. } = *self.inertia;
        let coriolis = match SpatialAxis::of(component) {
            SpatialAxis::Linear(k) => {
                let momentum = self.velocities.first + self.twice_omega.cross(first_moment);
                momentum.cross(Vector3::unit(k))
            }
            SpatialAxis::Angular(k) => {
                let spun = self.twice_omega.cross(Vector3::unit(k));
                self.rotational.row(k) + second_moment.full().mul_vector(spun)
            }
        };
        DualColumn { wrench: self.inertia.column(component), coriolis }
    }
}

/// The dual of a perturbation: the power of its terms at a unit displacement of a descendant.
#[derive(Clone, Copy, Debug)]
struct DualColumn<S> {
    /// The dual of the gradient (moment) and of the uniform term (force): the composite's wrench
    /// under the displacement taken as an acceleration.
    wrench: Wrench<S>,
    coriolis: Vector3<S>,
}

impl<S: Scalar> DualColumn<S> {
    fn of(&self, perturbation: &AccelerationPerturbation<S>) -> S {
        self.coriolis.dot(perturbation.coriolis)
            + self.wrench.moment.dot(perturbation.gradient)
            + self.wrench.force.dot(perturbation.uniform)
    }
}

/// The state of a column, or of several columns in lanes, during the sweep towards the root.
#[derive(Clone, Copy, Debug)]
struct SweepState<S> {
    /// The wrench that gives the composite its perturbed accelerations.
    wrench: Wrench<S>,
    /// The power of ancestors' perturbations at a unit displacement of the column's degree of
    /// freedom.
    dual: DualColumn<S>,
}

impl<S: Scalar> SweepState<S> {
    /// Returns the state as seen from the parent. The origin of `body` moves with half of `lever`
    /// relative to the parent's origin.
    fn at_parent(&self, body: &Body<S>, motion: &JointTransform<S>, lever: Vector3<S>) -> Self {
        let DualColumn { wrench, coriolis } = self.dual;
        let wrench = body.wrench_to_parent(motion, wrench);
        let coriolis = body.to_parent(motion, coriolis) + lever.cross(wrench.force);
        let dual = DualColumn { wrench, coriolis };
        Self { wrench: body.wrench_to_parent(motion, self.wrench), dual }
    }

    /// Returns all entries of the state.
    fn numbers(&self) -> [S; 15] {
        let [[a, b, c], [d, e, f]] = [self.wrench.moment.0, self.wrench.force.0];
        let DualColumn { wrench, coriolis: Vector3([m, n, o]) } = self.dual;
        let [[g, h, i], [j, k, l]] = [wrench.moment.0, wrench.force.0];
        [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o]
    }

    fn of([a, b, c, d, e, f, g, h, i, j, k, l, m, n, o]: [S; 15]) -> Self {
        let wrench = |moment, force| Wrench { moment: Vector3(moment), force: Vector3(force) };
        let coriolis = Vector3([m, n, o]);
        let dual = DualColumn { wrench: wrench([g, h, i], [j, k, l]), coriolis };
        Self { wrench: wrench([a, b, c], [d, e, f]), dual }
    }
}
