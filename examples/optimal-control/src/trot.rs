//! Model predictive control of a trotting quadruped: torques within their limits, forces of the feet within their friction
//! cones, and ground and pushes that the model does not have.
//!
//! The sequence of contacts is given, the forces are not. The contacts of the model are bilateral: a barrier keeps each
//! force within its friction cone. The derivatives of the steps and of the forces come from `constrained_knot`.

use std::time::Instant;

use modyn::simulate::State;
use modyn::{
    ContactSet as _, ContactSurface, ContactTarget, Robot, StepSettings, Wrench, functions,
};
use mpc::knot::{Knot, Slope, StateCost};
use mpc::matrix::dot;
use mpc::solver::{Limits, Problem, Step};

use crate::StepDuration;
use crate::robots::{
    FrontLeftStance, FrontRightStance, Quadruped, QuadrupedContacts, Settings, TORQUE_LIMIT,
    standing,
};

/// The number of degrees of freedom, and of motors, which follow the six of the base.
const NV: usize = Quadruped::NV;
const MOTORS: usize = NV - 6;
/// The number of steps of the horizon.
pub(crate) const STEPS: usize = 50;
/// The time step of the model, s.
const DT: f64 = 0.02;
/// The solver of the quadruped's problem.
pub(crate) type Solver = mpc::Solver<Trot, NV, MOTORS, STEPS>;

/// The number of steps in which two feet swing, and the number of steps before them in which all feet stand.
const SWING: usize = 10;
const STAND: usize = 3;
const PERIOD: usize = 2 * (SWING + STAND);
/// The height of a swing, m.
const LIFT: f64 = 0.05;
/// The speed of the trot, m/s.
const SPEED: f64 = 0.2;

/// The coefficient of friction that the forces may use.
const FRICTION: f64 = 0.6;
/// The distance to a face of the friction cone below which a force has a cost, N.
const MARGIN: f64 = 0.5;
/// The faces of a pyramid inside the friction cone: a force whose products with these vectors are negative is within it.
const FACES: [[f64; 3]; 4] = {
    let normal = -FRICTION * core::f64::consts::FRAC_1_SQRT_2;
    [[1.0, 0.0, normal], [-1.0, 0.0, normal], [0.0, 1.0, normal], [0.0, -1.0, normal]]
};

// The weights of half of the squared residuals, per second.
/// Of the displacements of the base (1/m^2, 1/rad^2) and of the joints.
const DISPLACEMENT: [f64; 2] = [100.0, 1.0];
/// Of the velocities of the base and of the joints.
const VELOCITY: [f64; 2] = [2.0, 0.02];
/// Of torques, 1/(N m)^2.
const EFFORT: f64 = 0.05;
/// Of the distance of a swinging foot from its path, 1/m^2.
const FOOT: f64 = 1000.0;
/// Of a force beyond its barrier, 1/N^2.
const BARRIER: f64 = 0.1;
/// The weight of the last state's cost, s.
const LAST: f64 = 0.5;

/// Returns the settings of the model's contacts: a foot that touches the ground stops within a time step.
const fn contacts<const FEET: usize>() -> Settings<FEET> {
    let target = ContactTarget { alpha: 0.5 / DT, ..ContactTarget::<f64>::GROUND };
    Settings { targets: [target; FEET], ..Settings::<FEET>::DEFAULT }
}

/// Contacts whose displacements are the places of the feet.
const PLACES: Settings<4> = {
    let target = ContactTarget { tangential: 1.0, ..ContactTarget::<f64>::GROUND };
    Settings { targets: [target; 4], ..Settings::<4>::DEFAULT }
};

/// Returns the places of the feet in the world, m.
fn feet(q: &[f64; 19]) -> [[f64; 3]; 4] {
    Quadruped::constraint_residual(q, &[0.0; NV], &PLACES).displacements.map(|d| d.linear.0)
}

/// The desired state at a step, and the contacts.
pub(crate) struct Stage {
    /// Whether each foot stands: all feet, or the two of a [`Stance`].
    stance: [bool; 4],
    /// The places of the feet, m.
    feet: [[f64; 3]; 4],
    reference: State<Quadruped>,
}

impl Stage {
    /// Returns the stage of a step. The robot stands for the length of a horizon, and then trots.
    fn of(step: usize) -> Self {
        let mut reference = State::<Quadruped>::at_rest(standing());
        let mut stance = [true; 4];
        let mut feet = feet(&reference.q);
        if let Some(step) = step.checked_sub(STEPS) {
            let stride = SPEED * PERIOD as f64 * DT;
            let periods = step / PERIOD;
            let phase = step % PERIOD;
            for foot in 0..4 {
                // The front right and the hind left foot swing second.
                let begin = if foot == 1 || foot == 2 { 2 * STAND + SWING } else { STAND };
                let swung = (phase.clamp(begin, begin + SWING) - begin) as f64 / SWING as f64;
                stance[foot] = !(begin..begin + SWING).contains(&phase);
                feet[foot][0] += stride * (periods as f64 + swung);
                feet[foot][2] += LIFT * (core::f64::consts::PI * swung).sin();
            }
            reference.q[0] += SPEED * DT * step as f64;
            reference.qd[0] = SPEED;
        }
        Self { stance, feet, reference }
    }

    /// Returns the displacements of a state's coordinates from the reference, and of its velocities.
    fn displacements(&self, x: &State<Quadruped>) -> [[f64; NV]; 2] {
        let dq = Quadruped::difference(&self.reference.q, &x.q);
        [dq, core::array::from_fn(|i| x.qd[i] - self.reference.qd[i])]
    }

    fn state_cost(&self, x: &State<Quadruped>) -> f64 {
        let [dq, dqd] = self.displacements(x);
        let of = |i: usize| {
            weight(DISPLACEMENT, i) * dq[i] * dq[i] + weight(VELOCITY, i) * dqd[i] * dqd[i]
        };
        0.5 * (0..NV).map(of).sum::<f64>()
    }

    /// Adds the cost of a state times `scale`.
    fn add_state_cost(&self, x: &State<Quadruped>, scale: f64, cost: &mut StateCost<NV>) {
        let [dq, dqd] = self.displacements(x);
        let columns = Quadruped::difference_derivatives(&self.reference.q, &x.q).dv_dto;
        for i in 0..NV {
            let of_displacement = scale * weight(DISPLACEMENT, i);
            if i < 6 {
                let row = core::array::from_fn(|j| columns[j][i]);
                cost.add_of_coordinates(of_displacement, dq[i], &row);
            } else {
                cost.add_of_coordinate(i, of_displacement, dq[i]);
            }
            cost.add_of_velocity(i, scale * weight(VELOCITY, i), dqd[i]);
        }
    }
}

/// Returns the weight of a degree of freedom, from the weights of the base and of the joints.
fn weight([base, joint]: [f64; 2], i: usize) -> f64 {
    if i < 6 { base } else { joint }
}

/// The problem: the stages of the steps, and of the last state.
pub(crate) struct Trot {
    stages: Vec<Stage>,
    /// The step of the trot at the first stage.
    first: usize,
}

impl Trot {
    /// Returns the problem whose first stage is that of a step.
    pub(crate) fn at(first: usize) -> Self {
        Self { stages: (first..=first + STEPS).map(Stage::of).collect(), first }
    }

    /// Moves the problem one step ahead.
    pub(crate) fn advance(&mut self) {
        self.first += 1;
        self.stages.rotate_left(1);
        self.stages[STEPS] = Stage::of(self.first + STEPS);
    }

    /// Returns the cost of a step divided by its duration, under the forces on the standing feet.
    fn cost(
        &self,
        k: usize,
        x: &State<Quadruped>,
        u: &[f64; MOTORS],
        forces: &[Wrench<f64>],
    ) -> f64 {
        let stage = &self.stages[k];
        let mut cost = stage.state_cost(x) + 0.5 * EFFORT * dot(u, u);
        for force in forces {
            for face in &FACES {
                let beyond = beyond(face, force);
                cost += 0.5 * BARRIER * beyond * beyond;
            }
        }
        if stage.stance != [true; 4] {
            let places = feet(&x.q);
            for foot in (0..4).filter(|foot| !stage.stance[*foot]) {
                for (place, desired) in places[foot].iter().zip(stage.feet[foot]) {
                    cost += 0.5 * FOOT * (place - desired) * (place - desired);
                }
            }
        }
        cost
    }

    /// Returns the result of [`Problem::step`] on the contacts of `R`.
    fn step_on<R: Stance<FEET>, const FEET: usize>(
        &self,
        k: usize,
        x: &State<Quadruped>,
        u: &[f64; MOTORS],
    ) -> Step<Quadruped> {
        let dynamics = R::constrained_forward_dynamics(
            &x.q,
            &x.qd,
            &joint_forces(u),
            R::Contacts::ALL,
            &const { contacts::<FEET>() },
        );
        let cost = DT * self.cost(k, x, u, &dynamics.wrenches);
        Step { next: x.semi_implicit_euler(DT, |_| dynamics.qdd), cost }
    }

    /// Adds the derivatives of a step on the contacts of `R`, and the cost of the forces on them, to a knot.
    fn linearize_on<R: Stance<FEET>, const FEET: usize>(
        x: &State<Quadruped>,
        u: &[f64; MOTORS],
        knot: &mut Knot<NV, MOTORS>,
    ) {
        let dynamics = R::constrained_knot(
            &x.q,
            &x.qd,
            &joint_forces(u),
            DT,
            R::Contacts::ALL,
            &const { contacts::<FEET>() },
        );
        knot.step.set::<R>(&dynamics.knot());
        for foot in 0..FEET {
            for face in &FACES {
                let beyond = beyond(face, &dynamics.wrenches[foot]);
                if beyond > 0.0 {
                    let row = |by: &[[Wrench<f64>; NV]; FEET]| -> [f64; NV] {
                        core::array::from_fn(|j| dot(face, &by[foot][j].force.0))
                    };
                    let by_q = row(&dynamics.dwrenches_dq);
                    let by_qd = row(&dynamics.dwrenches_dqd);
                    let by_tau = row(&dynamics.dwrenches_dtau);
                    let by_u = core::array::from_fn(|i| by_tau[6 + i]);
                    knot.add(DT * BARRIER, beyond, &Slope { by_q, by_qd, by_u });
                }
            }
        }
    }
}

/// The quadruped with contacts at the `FEET` feet that stand.
trait Stance<const FEET: usize>:
    Robot<
        Q<f64> = [f64; 19],
        V<f64> = [f64; NV],
        M<f64> = [[f64; NV]; NV],
        PerQuaternion<[[f64; 6]; 6]> = [[[f64; 6]; 6]; 1],
        PerVelocity<Wrench<f64>> = [Wrench<f64>; NV],
        PerContact<ContactTarget<f64>> = [ContactTarget<f64>; FEET],
        PerConstraint<Wrench<f64>> = [Wrench<f64>; FEET],
        PerConstraint<[Wrench<f64>; NV]> = [[Wrench<f64>; NV]; FEET],
    > + functions::ConstrainedForwardDynamics
    + functions::ConstrainedKnot
{
}

impl Stance<4> for Quadruped {}
impl Stance<2> for FrontLeftStance {}
impl Stance<2> for FrontRightStance {}

/// Returns the joint forces of torques of the motors.
fn joint_forces(u: &[f64; MOTORS]) -> [f64; NV] {
    core::array::from_fn(|i| if i < 6 { 0.0 } else { u[i - 6] })
}

/// Returns the part of a force beyond its barrier at a face of the friction cone.
fn beyond(face: &[f64; 3], wrench: &Wrench<f64>) -> f64 {
    (dot(face, &wrench.force.0) + MARGIN).max(0.0)
}

impl Problem<NV, MOTORS> for Trot {
    type Robot = Quadruped;

    fn dt(&self) -> f64 {
        DT
    }

    fn limits(&self) -> Limits<MOTORS> {
        Limits { lower: [-TORQUE_LIMIT; MOTORS], upper: [TORQUE_LIMIT; MOTORS] }
    }

    fn step(&self, k: usize, x: &State<Quadruped>, u: &[f64; MOTORS]) -> Step<Quadruped> {
        match self.stages[k].stance {
            [true, false, false, true] => self.step_on::<FrontLeftStance, 2>(k, x, u),
            [false, true, true, false] => self.step_on::<FrontRightStance, 2>(k, x, u),
            _ => self.step_on::<Quadruped, 4>(k, x, u),
        }
    }

    fn linearize(
        &self,
        k: usize,
        x: &State<Quadruped>,
        u: &[f64; MOTORS],
        knot: &mut Knot<NV, MOTORS>,
    ) {
        let stage = &self.stages[k];
        match stage.stance {
            [true, false, false, true] => Self::linearize_on::<FrontLeftStance, 2>(x, u, knot),
            [false, true, true, false] => Self::linearize_on::<FrontRightStance, 2>(x, u, knot),
            _ => Self::linearize_on::<Quadruped, 4>(x, u, knot),
        }
        stage.add_state_cost(x, DT, &mut knot.state);
        for (i, u) in u.iter().enumerate() {
            knot.input.add_of_input(i, DT * EFFORT, *u);
        }
        if stage.stance != [true; 4] {
            let places = feet(&x.q);
            let columns = Quadruped::constraint_jacobian(&x.q);
            for foot in (0..4).filter(|foot| !stage.stance[*foot]) {
                let errors = places[foot].iter().zip(stage.feet[foot]);
                for (i, (place, desired)) in errors.enumerate() {
                    let row = core::array::from_fn(|j| columns[foot][j].linear.0[i]);
                    knot.state.add_of_coordinates(DT * FOOT, place - desired, &row);
                }
            }
        }
    }

    fn end(&self, x: &State<Quadruped>) -> f64 {
        LAST * self.stages[STEPS].state_cost(x)
    }

    fn linearize_end(&self, x: &State<Quadruped>, cost: &mut StateCost<NV>) {
        self.stages[STEPS].add_state_cost(x, LAST, cost);
    }
}

/// The ground of the simulation: unilateral, and nearly rigid.
const GROUND: StepSettings<f64, [ContactSurface<f64>; 4]> = StepSettings {
    surfaces: [ContactSurface {
        solref: [0.002, 1.0],
        solimp: [0.99, 0.999, 0.0005, 0.5],
        ..ContactSurface::<f64>::GROUND
    }; 4],
    ..StepSettings::<f64, [ContactSurface<f64>; 4]>::DEFAULT
};

/// Returns the solver of the trot, with a motion that stands.
pub(crate) fn solver(problem: &Trot) -> Box<Solver> {
    Box::new(Solver::new(problem, &State::at_rest(standing()), &hold()))
}

/// Returns the torques that stand.
pub(crate) fn hold() -> [f64; MOTORS] {
    let rest = [0.0; NV];
    let active = QuadrupedContacts::ALL;
    let standing_forces =
        Quadruped::constrained_inverse_dynamics(&standing(), &rest, &rest, active, &contacts());
    core::array::from_fn(|i| standing_forces.tau[6 + i])
}

/// A push: a change of the base's velocity, m/s, after a number of steps of the controller.
pub(crate) struct Push {
    pub(crate) step: usize,
    pub(crate) change: [f64; 3],
}

/// Pushes to the side, from behind and down.
pub(crate) const PUSHES: [Push; 3] = [
    Push { step: 100, change: [0.0, 0.3, 0.0] },
    Push { step: 160, change: [0.3, 0.0, 0.0] },
    Push { step: 220, change: [0.0, 0.0, -0.3] },
];

/// The results of a trot.
pub(crate) struct Trotted {
    /// The largest distances of the base from its reference along each axis, m.
    pub(crate) error: [f64; 3],
    /// The displacement of the base's coordinates from the reference at the end.
    pub(crate) last: [f64; 6],
    /// The state at the end.
    pub(crate) state: State<Quadruped>,
    /// The durations of the steps of the controller.
    pub(crate) durations: Vec<StepDuration>,
}

/// Trots for some steps of the controller on the ground of the simulation. The controller improves its motion once in
/// each step of 20 ms; its feedback runs every millisecond.
pub(crate) fn trot(steps: usize, pushes: &[Push]) -> Trotted {
    let mut problem = Trot::at(0);
    let mut solver = solver(&problem);
    let mut trotted = Trotted {
        error: [0.0; 3],
        last: [0.0; 6],
        state: State::at_rest(standing()),
        durations: vec![],
    };
    for k in 0..steps {
        let start = Instant::now();
        problem.advance();
        solver.advance();
        solver.restart(&problem, &trotted.state);
        let restarted = Instant::now();
        solver.iterate(&problem);
        let iteration = restarted.elapsed();
        trotted.durations.push(StepDuration { whole: start.elapsed(), iteration });
        for push in pushes.iter().filter(|push| push.step == k) {
            for (qd, change) in trotted.state.qd.iter_mut().zip(push.change) {
                *qd += change;
            }
        }
        for ms in 0..20 {
            let u = solver.feedback(&problem, f64::from(ms) / 20.0, &trotted.state);
            trotted.state = trotted.state.step(0.001, &joint_forces(&u), &GROUND).state;
        }
        let [dq, _] = problem.stages[1].displacements(&trotted.state);
        for (largest, error) in trotted.error.iter_mut().zip(dq) {
            *largest = largest.max(error.abs());
        }
        trotted.last.copy_from_slice(&dq[..6]);
    }
    trotted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::check_derivatives;
    use mpc::solver::Iteration;

    type Dynamics =
        modyn::ConstrainedForwardDynamics<[f64; NV], [Wrench<f64>; 4], [modyn::Twist<f64>; 4], f64>;

    /// Returns the dynamics of the quadruped with four contacts, of which the standing feet's are active.
    fn masked_dynamics(stage: &Stage, x: &State<Quadruped>, u: &[f64; MOTORS]) -> Dynamics {
        let [front_left, front_right, hind_left, hind_right] = stage.stance;
        let active = QuadrupedContacts { front_left, front_right, hind_left, hind_right };
        let tau = joint_forces(u);
        Quadruped::constrained_forward_dynamics(&x.q, &x.qd, &tau, active, &contacts())
    }

    /// Returns the cost of a motion with another torque of motor `i` in step `k`. The feedback keeps the motion stable; at
    /// an optimum, the derivative of the cost is zero with any feedback.
    fn cost(problem: &Trot, solver: &Solver, [k, i]: [usize; 2], by: f64) -> f64 {
        let motion = solver.motion();
        let mut x = motion.states[0];
        let mut sum = 0.0;
        for (step, gain) in solver.gains().iter().enumerate() {
            let nominal = &motion.states[step];
            let dq = Quadruped::difference(&nominal.q, &x.q);
            let dqd: [f64; NV] = core::array::from_fn(|i| x.qd[i] - nominal.qd[i]);
            let mut u = motion.inputs[step];
            for ((u, by_q), by_qd) in u.iter_mut().zip(&gain.by_q).zip(&gain.by_qd) {
                *u += dot(by_q, &dq) + dot(by_qd, &dqd);
            }
            if step == k {
                u[i] += by;
            }
            let next = problem.step(step, &x, &u);
            sum += next.cost;
            x = next.next;
        }
        sum + problem.end(&x)
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let problem = Trot::at(STEPS);
        let by = core::array::from_fn(|i| 0.3 * (3.0 * i as f64 + 1.0).sin());
        let x = State {
            q: Quadruped::integrate(&standing(), &by),
            qd: core::array::from_fn(|i| 0.3 * (5.0 * i as f64).cos()),
        };
        let u = core::array::from_fn(|i| 3.0 * (5.0 * i as f64).cos());
        for k in [0, STAND, 2 * STAND + SWING] {
            check_derivatives(&problem, k, &x, &u);
            let expected =
                x.semi_implicit_euler(DT, |_| masked_dynamics(&problem.stages[k], &x, &u).qdd);
            let next = problem.step(k, &x, &u).next;
            for (velocity, expected) in next.qd.iter().zip(expected.qd) {
                assert!((velocity - expected).abs() < 1e-9, "step {k}: {velocity} {expected}");
            }
        }
    }

    /// The conditions of Karush, Kuhn and Tucker, with the gradient by differences of whole motions, while the model
    /// trots: zero for torques within their limits.
    #[test]
    fn the_optimum_has_the_gradient_of_an_optimum() {
        let mut problem = Trot::at(0);
        let mut solver = solver(&problem);
        for _ in 0..STEPS + 8 {
            let next = solver.motion().states[1];
            problem.advance();
            solver.advance();
            solver.restart(&problem, &next);
            solver.iterate(&problem);
        }
        let count = (0..40).take_while(|_| solver.iterate(&problem) != Iteration::Converged);
        assert!(count.count() < 40, "{}", solver.motion().cost);
        let motion = solver.motion();
        assert!((cost(&problem, &solver, [0, 0], 0.0) - motion.cost).abs() < 1e-9 * motion.cost);
        for (k, i) in (0..STEPS).map(|k| (k, k % MOTORS)) {
            assert!(motion.inputs[k][i].abs() < TORQUE_LIMIT);
            let [above, below] = [1e-5, -1e-5].map(|by| cost(&problem, &solver, [k, i], by));
            let slope = (above - below) / 2e-5;
            assert!(slope.abs() < 1e-6, "step {k}, motor {i}: {slope}");
        }
        // Away from the optimum, slopes are larger.
        let beside = [1e-2, 1e-2 + 1e-5].map(|by| cost(&problem, &solver, [0, 1], by));
        assert!((beside[1] - beside[0]) / 1e-5 > 1e-5, "{beside:?}");
        let barriers =
            motion.states.iter().zip(&motion.inputs).enumerate().filter(|(k, (x, u))| {
                let dynamics = masked_dynamics(&problem.stages[*k], x, u);
                let stance = problem.stages[*k].stance;
                (0..4).any(|i| {
                    stance[i] && FACES.iter().any(|face| beyond(face, &dynamics.wrenches[i]) > 0.0)
                })
            });
        assert!(barriers.count() > 3);
    }

    /// Five seconds of trot, with three pushes.
    #[test]
    fn trots_on_ground_that_the_model_does_not_have() {
        let trotted = trot(300, &PUSHES);
        let [x, y, z] = trotted.error;
        assert!(x < 0.06 && y < 0.06 && z < 0.03, "{x} {y} {z}");
        assert!(trotted.last.iter().all(|x| x.abs() < 0.02), "{:?}", trotted.last);
        assert!(trotted.state.q[0] > 0.9, "{:?}", trotted.state.q);
    }
}
