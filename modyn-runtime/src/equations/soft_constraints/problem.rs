//! A step at a state: what does not change between the iterations of its solver, and the solver's full steps.

use alloc::{vec, vec::Vec};

use super::damping::DampingMatrix;
use super::dense::DenseProblem;
use super::free_bodies::{move_free_bodies, turning};
use super::input::{StepConstraints, StepInput};
use super::lengths::RowEntry;
use super::loops::LoopRows;
use super::responses::{Effect, ImplicitDampers, Laws};
use super::rows::{BodyState, ContactOptions, ContactRows, SoftModel, body_twists, softness};
use super::single_rows::{SingleRow, single_rows};
use crate::equations::dynamics::newton_euler::{Accelerations, link_wrenches};
use crate::equations::dynamics::{Elimination, add_free_fall, against_fall, is_base};
use crate::equations::kinematics::coordinates;
use crate::equations::kinematics::links::compute_body_poses;
use crate::equations::{TimeStepInput, Workspace};
use crate::mechanism::{BodyTree, Mechanism};
use crate::scalar::at_most;
use crate::spatial::{Matrix3, Pose, Twist, Vector3, Wrench};
use crate::{ContactSurface, Scalar, StepSettings};

/// The accelerations in a step, and the forces.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftMotion<S> {
    /// The accelerations by the laws.
    pub qdd: Vec<S>,
    /// The accelerations that move the state, but for the rotation of free bodies: dampers act with the
    /// velocities after the step.
    pub damped: Vec<S>,
    /// The force of each contact along the x and y axes of its plane, then along the normal, N.
    pub forces: Vec<[S; 3]>,
}

/// Returns the coordinates and the velocities after a step with the accelerations `qdd` by the laws, and those
/// that move the state. Positions move straight, rotations by the exponential map, as in MuJoCo.
pub fn next_state<S: Scalar>(
    model: &Mechanism<S>,
    soft: &SoftModel<impl Copy>,
    input: TimeStepInput<'_, S>,
    [qdd, damped]: [&[S]; 2],
) -> [Vec<S>; 2] {
    let TimeStepInput { q, qd, dt, .. } = input;
    let mut rates = damped.to_vec();
    move_free_bodies(model, soft, input, qdd, &mut rates);
    // The velocities of a floating joint are in axes that rotate, and straight motion keeps them in the world.
    let rates = rates.into_iter().zip(turning(model, qd)).map(|(rate, turning)| rate + turning);
    let mut next_qd: Vec<S> = qd.iter().zip(rates).map(|(&v, rate)| v + dt * rate).collect();
    let mut next_q = vec![S::zero(); model.nq];
    coordinates::move_straight(model, q, &mut next_qd, dt, &mut next_q);
    [next_q, next_qd]
}

/// Returns the number of lanes of each body.
fn lanes<S: Scalar, T: BodyTree<S>>(tree: &T) -> Vec<usize> {
    let mut lanes: Vec<usize> = Vec::new();
    for (i, body) in tree.mechanism().bodies.iter().enumerate() {
        let of_parent = body.parent.map_or(1, |parent| lanes[parent]);
        lanes.push(tree.limb_root(i).map_or(of_parent, |root| root.limbs));
    }
    lanes
}

/// The rows of contacts, of joints, tendons and couplings, and of loops at accelerations.
#[derive(Clone, Debug)]
pub struct Iterate<S> {
    /// The accelerations of the rows.
    pub accelerations: Vec<S>,
    /// The forces of the rows that keep these accelerations in equilibrium.
    pub balances: Vec<S>,
}

/// A step at a state.
pub struct StepProblem<'a, S, T> {
    pub(super) tree: &'a T,
    elimination: &'a Elimination,
    /// For robots that the factors of a matrix solve.
    dense: Option<DenseProblem<S>>,
    pub(super) input: StepInput<'a, S>,
    /// The joint forces, with the forces of springs and dampers of tendons.
    tau: Vec<S>,
    pub(super) workspace: &'a mut Workspace<S>,
    /// The wrenches of the bodies at zero joint accelerations.
    bias: Vec<Wrench<S>>,
    pub(super) contacts: Vec<ContactRows<S>>,
    /// The rows of joints, tendons and couplings.
    pub(super) single_rows: Vec<SingleRow<S>>,
    loops: Vec<LoopRows<S>>,
    /// The states of the bodies.
    pub(super) states: Vec<BodyState<S>>,
    /// The number of lanes of each row.
    lanes: Vec<usize>,
    /// The dampers that act with the velocities after the step.
    pub(super) damping: DampingMatrix<S>,
    /// The factor of all weights that makes the stiffest row soft.
    pub(super) softening: S,
    /// The largest residual at which the solver ends.
    pub(super) tolerance: S,
    /// The unit of residuals, N.
    pub(super) weight: S,
    /// The accelerations of floating bases in free fall, zero for other joints.
    pub(super) fall: Vec<S>,
    /// The joint accelerations, those of floating bases relative to free fall.
    pub(super) accelerations: Vec<S>,
}

impl<'a, S: Scalar, T: BodyTree<S>> StepProblem<'a, S, T> {
    /// Returns the problem of a step.
    pub fn new(
        tree: &'a T,
        elimination: &'a Elimination,
        input: StepInput<'a, S>,
        constraints: StepConstraints<'_, S, impl AsRef<[ContactSurface<S>]>>,
        workspace: &'a mut Workspace<S>,
    ) -> Self {
        let StepConstraints { soft, settings } = constraints;
        let model = tree.mechanism();
        let surfaces = settings.surfaces.as_ref();
        let step = input.step;
        let TimeStepInput { q, qd, dt, .. } = step;
        let mut tau = step.tau.to_vec();
        soft.tendons.iter().for_each(|tendon| tendon.add_passive_forces(step, &mut tau));
        elimination.reserve(model, workspace);
        let dense = match elimination {
            Elimination::Recursive(_) => None,
            Elimination::Matrix(_) => {
                Some(DenseProblem::new(model, TimeStepInput { tau: &tau, ..step }, workspace))
            }
        };
        workspace.move_with_forces(tree, q, Some(qd));
        link_wrenches(tree, qd, Accelerations::FreeFall, workspace);
        let bias = workspace.wrenches.clone();
        let mut fall = vec![S::zero(); model.nv];
        for base in (0..model.bodies.len()).filter(|&body| is_base(model, body)) {
            add_free_fall(model, base, qd, workspace, &mut fall);
        }
        let mut poses = vec![Pose::identity(); model.bodies.len()];
        compute_body_poses(tree, workspace, &mut poses);
        body_twists(tree, qd, workspace);
        let mut falls = vec![false; model.bodies.len()];
        for (i, body) in model.bodies.iter().enumerate() {
            falls[i] = body.parent.map_or_else(|| is_base(model, i), |parent| falls[parent]);
        }
        let StepSettings { impratio, coulomb, .. } = *settings;
        let options = ContactOptions { cone: soft.cone, ratio: impratio, coulomb, dt };
        let states: Vec<BodyState<S>> = (0..model.bodies.len())
            .map(|body| BodyState {
                pose: poses[body],
                velocity: workspace.twists[body],
                fall: match falls[body] {
                    true => Matrix3(poses[body].rotation).transposed().mul_vector(model.gravity),
                    false => Vector3::zero(),
                },
            })
            .collect();
        let contacts = soft.contacts.iter().zip(surfaces).flat_map(|(parameters, surface)| {
            ContactRows::of_shape(parameters, &states[parameters.body], surface, options)
        });
        let mut contacts: Vec<ContactRows<S>> = contacts.collect();
        // The laws have the accelerations in the world; bases in free fall have no other ones.
        let mut turning = turning(model, qd);
        let falling = model.dofs.iter().filter(|dof| is_base(model, dof.body));
        falling.for_each(|dof| turning[dof.v] = S::zero());
        body_twists(tree, &turning, workspace);
        for contact in &mut contacts {
            let turned: Vec<S> = contact.acceleration(&workspace.twists[contact.body]).collect();
            for (reference, turned) in contact.law.reference.iter_mut().zip(turned) {
                *reference = *reference - turned;
            }
        }
        let single_rows = single_rows(soft, step);
        body_twists(tree, &fall, workspace);
        let constraints = model.constraints.iter().zip(&soft.loops);
        let loops = constraints.map(|(constraint, parameters)| {
            let rows = LoopRows::new(model, constraint, parameters, step, &poses);
            rows.relative_to_fall(&workspace.twists)
        });
        let loops: Vec<LoopRows<S>> = loops.collect();
        let lanes_of_bodies = lanes(tree);
        let lanes_of_contacts = contacts
            .iter()
            .flat_map(|contact| vec![lanes_of_bodies[contact.body]; contact.count()]);
        let lanes_of_single_rows = single_rows.iter().map(|row| {
            let [entry] = &row.entries[..] else { return 1 };
            let moved = model.dofs.iter().find(|dof| dof.v == entry.dof);
            moved.map_or(1, |dof| lanes_of_bodies[dof.body])
        });
        let lanes_of_loops = loops.iter().flat_map(|rows| vec![1; rows.rows.len()]);
        let lanes = lanes_of_contacts.chain(lanes_of_single_rows).chain(lanes_of_loops).collect();
        let mut problem = Self {
            bias,
            contacts,
            single_rows,
            loops,
            states,
            lanes,
            damping: DampingMatrix::of_step(soft, model),
            softening: S::one(),
            tolerance: settings.tolerance,
            weight: soft.weight,
            accelerations: vec![S::zero(); model.nv],
            fall,
            tree,
            elimination,
            dense: None,
            input,
            tau,
            workspace,
        };
        problem.softening = problem.softening(soft, surfaces);
        problem.dense = dense.map(|dense| {
            let jacobian = problem.jacobian();
            dense.with_rows(&problem.fall, jacobian)
        });
        problem
    }

    /// Returns the problem with further dampers that act with the velocities after the step.
    #[must_use]
    pub fn damped_by(mut self, dampers: &DampingMatrix<S>) -> Self {
        self.damping.add(dampers);
        self
    }

    /// Returns, for each row, its acceleration by each unit acceleration of a joint.
    fn jacobian(&mut self) -> Vec<Vec<S>> {
        let nv = self.tree.mechanism().nv;
        let mut jacobian = vec![vec![S::zero(); nv]; self.rows()];
        for dof in 0..nv {
            let mut unit = vec![S::zero(); nv];
            unit[dof] = S::one();
            body_twists(self.tree, &unit, self.workspace);
            self.accelerations = unit;
            for (row, entry) in jacobian.iter_mut().zip(self.row_accelerations()) {
                row[dof] = entry;
            }
        }
        jacobian
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.lanes.len()
    }

    /// Returns the entries of qd of each row of a joint, a tendon or a coupling.
    pub fn joints_of_rows(&self) -> impl Iterator<Item = Vec<usize>> {
        self.single_rows.iter().map(|row| row.entries.iter().map(|entry| entry.dof).collect())
    }

    /// Returns a number that is zero if no limit acts, else positive or NaN.
    pub fn limits(&self) -> S {
        let contacts = self.contacts.iter().map(ContactRows::count).sum();
        let weights = core::iter::repeat_n(S::zero(), contacts)
            .chain(self.single_rows.iter().map(SingleRow::weight_of_limit));
        self.reduce(weights, |a, b| a + b)
    }

    /// Returns the first iterate: the accelerations of the rows at `input.warm_start`, with forces
    /// that the first full step overwrites.
    pub fn first(&mut self) -> Iterate<S> {
        let warm_start = self.input.warm_start.iter().zip(&self.fall);
        let accelerations: Vec<S> = warm_start.map(|(&rate, &fall)| rate - fall).collect();
        body_twists(self.tree, &accelerations, self.workspace);
        self.accelerations = accelerations;
        Iterate { accelerations: self.row_accelerations(), balances: vec![S::zero(); self.rows()] }
    }

    /// Returns the laws at an iterate. All weights are scaled.
    pub(super) fn laws(&self, iterate: &Iterate<S>, scale: S) -> Laws<S> {
        let (contacts, rest) = by_contacts(&self.contacts, &iterate.accelerations);
        let (of_single_rows, of_loops) = rest.split_at(self.single_rows.len());
        let single_rows = self.single_rows.iter().zip(of_single_rows);
        let rows_of_loops = self.loops.iter().flat_map(|closed| &closed.rows);
        let loops = rows_of_loops.zip(of_loops);
        Laws {
            contacts: contacts.map(|(contact, a)| contact.law.scaled(scale).response(a)).collect(),
            single_rows: (single_rows.map(|(row, &a)| row.scaled(scale).response(a)))
                .chain(loops.map(|(row, &a)| row.scaled(scale).response(a)))
                .collect(),
        }
    }

    /// Returns the minimum of the quadratic model of the function at an iterate with these laws.
    pub(super) fn full_step(&mut self, iterate: &Iterate<S>, laws: &Laws<S>) -> Iterate<S> {
        let shares = laws.stiffness_times(&iterate.accelerations);
        let applied: Vec<S> =
            laws.forces().zip(shares).map(|(force, share)| force + share).collect();
        self.accelerate(&applied, Effect::Stiff(laws));
        let accelerations = self.row_accelerations();
        let shares = laws.stiffness_times(&accelerations);
        let balances = applied.iter().zip(shares).map(|(&force, share)| force - share).collect();
        Iterate { accelerations, balances }
    }

    /// Returns the accelerations and the forces after one full step of Newton's method from
    /// `input.warm_start`. If these are the accelerations of the solution, the derivatives of the
    /// result, with these accelerations held constant, are the derivatives of the solution (the
    /// implicit function theorem): the derivatives of Newton's matrix meet a gradient that is zero.
    pub fn refined(&mut self) -> SoftMotion<S> {
        let start = self.first();
        let laws = self.laws(&start, S::one());
        let end = self.full_step(&start, &laws);
        self.motion(&end)
    }

    /// Returns the accelerations and the forces in the step, given the iterate at which the last full step
    /// ended.
    pub fn motion(&mut self, end: &Iterate<S>) -> SoftMotion<S> {
        let laws = self.laws(end, S::one());
        let qdd = self.rates();
        if !self.damping.is_zero() {
            let dampers = self.implicit_dampers();
            let forces: Vec<S> = laws.forces().collect();
            self.accelerate(&forces, Effect::Forces(&dampers));
        }
        SoftMotion {
            qdd,
            damped: self.rates(),
            forces: (self.contacts.iter().zip(&laws.contacts))
                .map(|(contact, response)| contact.in_plane(&response.force))
                .collect(),
        }
    }

    /// Returns the accelerations of the rows, given those of the bodies and joints.
    fn row_accelerations(&self) -> Vec<S> {
        let contacts = self
            .contacts
            .iter()
            .flat_map(|contact| contact.acceleration(&self.workspace.twists[contact.body]));
        let single_rows = self.single_rows.iter().map(|row| row.acceleration(&self.accelerations));
        let twists = &self.workspace.twists;
        let loops = self.loops.iter().flat_map(|rows| rows.accelerations(twists));
        contacts.chain(single_rows).chain(loops).collect()
    }

    /// Returns the acceleration of a body by the joints in the last iterate, relative to free fall.
    pub(super) fn acceleration_of(&self, body: usize) -> Twist<S> {
        self.workspace.twists[body]
    }

    /// Computes the joint accelerations, relative to free fall, under these forces of the rows, and
    /// the accelerations of the bodies.
    fn accelerate(&mut self, forces: &[S], effect: Effect<'_, S>) {
        let partition = match (self.elimination, &self.dense) {
            (Elimination::Recursive(partition), _) => partition,
            (Elimination::Matrix(layout), Some(dense)) => {
                let accelerations = dense.accelerations(layout, forces, effect);
                body_twists(self.tree, &accelerations, self.workspace);
                self.accelerations = accelerations;
                return;
            }
            (Elimination::Matrix(_), None) => unreachable!("the matrix is there from the start"),
        };
        let Self { tree, workspace, contacts, single_rows, .. } = self;
        workspace.wrenches.copy_from_slice(&self.bias);
        let mut tau = self.tau.clone();
        let (of_contacts, of_single_rows) = by_contacts(contacts, forces);
        for (contact, force) in of_contacts {
            let wrench = &mut workspace.wrenches[contact.body];
            *wrench = *wrench - contact.wrench(force);
        }
        for (row, &force) in single_rows.iter().zip(of_single_rows) {
            row.add_force(force, &mut tau);
        }
        match effect {
            Effect::Stiff(laws) => {
                for (contact, response) in contacts.iter().zip(&laws.contacts) {
                    let inertia = contact.inertia(response);
                    let sum = &mut workspace.added_inertia[contact.body];
                    *sum = Some(sum.map_or(inertia, |sum| sum + inertia));
                }
                for (row, &[_, stiffness]) in single_rows.iter().zip(&laws.single_rows) {
                    // A row with several entries needs the factors of the whole matrix.
                    for &RowEntry { dof, factor } in &row.entries {
                        let stiffness = factor * stiffness * factor;
                        let sum = &mut workspace.added_armature[dof];
                        *sum = Some(sum.map_or(stiffness, |sum| sum + stiffness));
                    }
                }
            }
            Effect::Forces(ImplicitDampers { armature, forces }) => {
                // Coupled dampers need the factors of the whole matrix.
                workspace.added_armature.copy_from_slice(&armature.diagonal);
                forces.iter().for_each(|&(dof, force)| tau[dof] = tau[dof] + force);
            }
        }
        let qd = self.input.step.qd;
        against_fall(*tree, partition, qd, &tau, workspace, &mut self.accelerations);
        body_twists(*tree, &self.accelerations, workspace);
        workspace.added_inertia.fill(None);
        workspace.added_armature.fill(None);
    }

    /// Returns the dampers that act with the velocities after the step. Accelerations are relative
    /// to free fall, and the linear velocity of a floating joint is damped in the world, in which the
    /// axes of its entries rotate.
    fn implicit_dampers(&self) -> ImplicitDampers<S> {
        let turning = turning(self.tree.mechanism(), self.input.step.qd);
        let rates = self.fall.iter().zip(turning).map(|(&fall, turning)| fall + turning);
        let armature = self.damping.scaled(self.input.step.dt);
        let resistance = armature.times(&rates.collect::<Vec<S>>());
        let damped = (0..resistance.len()).filter(|&dof| armature.diagonal[dof].is_some());
        let forces = damped.map(|dof| (dof, -resistance[dof])).collect();
        ImplicitDampers { armature, forces }
    }

    /// Returns the accelerations of the joints.
    fn rates(&self) -> Vec<S> {
        self.accelerations.iter().zip(&self.fall).map(|(&rate, &fall)| rate + fall).collect()
    }

    /// Returns the factor of all weights that makes the stiffest row soft.
    fn softening(&self, soft: &SoftModel<S>, surfaces: &[ContactSurface<S>]) -> S {
        let lanes_of_bodies = lanes(self.tree);
        let contacts = surfaces.iter().zip(&soft.contacts).map(|(surface, contact)| {
            let lanes = lanes_of_bodies[contact.body];
            (softness(surface, contact.power).impedance.softening(), lanes)
        });
        let lanes_of_joint = |joint: usize| {
            let dofs = &self.tree.mechanism().dofs;
            dofs.iter().find(|dof| dof.v == joint).map_or(1, |dof| lanes_of_bodies[dof.body])
        };
        let joints = soft.joints.iter().enumerate().flat_map(|(dof, joint)| {
            let softness = joint.iter().flat_map(|joint| joint.stops.softness());
            softness.map(move |softness| (softness.impedance.softening(), lanes_of_joint(dof)))
        });
        let tendons = soft.tendons.iter().flat_map(|tendon| tendon.stops.softness());
        let couplings = soft.couplings.iter().map(|coupling| coupling.softness);
        let others = couplings.chain(tendons).chain(soft.loops.iter().map(|rows| rows.softness));
        let others = others.map(|softness| (softness.impedance.softening(), 1));
        contacts.chain(joints).chain(others).fold(S::one(), |least, (softening, lanes)| {
            (0..lanes)
                .fold(least, |least, lane| at_most(least, self.tree.extract_lane(softening, lane)))
        })
    }

    /// Combines numbers of all rows: rows with as many lanes first, then the lanes.
    pub(super) fn reduce(
        &self,
        numbers: impl Iterator<Item = S>,
        combine: impl Fn(S, S) -> S,
    ) -> S {
        let mut by_lanes: Vec<Option<S>> = Vec::new();
        for (number, &lanes) in numbers.zip(&self.lanes) {
            if by_lanes.len() <= lanes {
                by_lanes.resize(lanes + 1, None);
            }
            let sum = by_lanes[lanes].map_or(number, |sum| combine(sum, number));
            by_lanes[lanes] = Some(sum);
        }
        let in_lanes = by_lanes.iter().enumerate().filter_map(|(n, sum)| Some((n, (*sum)?)));
        let each =
            in_lanes.flat_map(|(n, sum)| (0..n).map(move |lane| self.tree.extract_lane(sum, lane)));
        each.reduce(combine).unwrap_or_else(S::zero)
    }
}

/// Returns the contacts with the numbers of their rows, and the numbers of all other rows.
fn by_contacts<'a, S: Scalar>(
    contacts: &'a [ContactRows<S>],
    mut numbers: &'a [S],
) -> (impl Iterator<Item = (&'a ContactRows<S>, &'a [S])>, &'a [S]) {
    let count = contacts.iter().map(ContactRows::count).sum();
    let rest = &numbers[count..];
    let contacts = contacts.iter().map(move |contact| {
        let (first, others) = numbers.split_at(contact.count());
        numbers = others;
        (contact, first)
    });
    (contacts, rest)
}
