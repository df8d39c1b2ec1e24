//! Steps of several states at once, a state in each lane, as far as sweeps suffice.

use super::{ALPHA, BETA, BETA_OF_STOPS, COMPLIANCE, FRICTION, GroundRobot, RESTITUTION};
use crate::lanes::{BatchTask, Float, Lanes, MAX_LANES};
use crate::simulate::Ground;
use crate::solve::{Contact, GroundEquations, least_speed, velocity_range};

/// What the steps of several states depend on, a state in each lane: each slice has a row of lanes
/// for each number.
#[derive(Clone, Copy, Debug)]
pub struct StepLanes<'a, T> {
    /// The number of states.
    pub lanes: usize,
    /// The coordinates.
    pub q: &'a [T],
    /// The time steps, s.
    pub dt: &'a [T],
    /// The numbers of the settings.
    pub settings: &'a [T],
    /// The numbers of the contact problem.
    pub problem: &'a [T],
    /// The impulses of the stops in the last step.
    pub stops: &'a [T],
}

impl GroundRobot {
    /// Sweeps over the contacts of several states at once, a state in each lane, from these
    /// impulses on, and sets the velocities after the step. Sets for each lane the residual of its
    /// contacts if it is solved: within the tolerance, and no stop acts. The others are left to
    /// [`solve`](Self::solve), with the impulses of the sweeps.
    pub fn solve_lanes<F: Float>(
        &self,
        ground: &Ground<F>,
        numbers: &StepLanes<'_, F>,
        (impulses, velocities): (&mut [F], &mut [F]),
        solved: &mut [Option<F>],
    ) {
        solved.fill(None);
        let task = LaneTask { robot: self, ground, numbers, impulses, velocities, solved };
        match (self.contacts, self.velocities) {
            (..=4, ..=20) => F::dispatch(LaneSweeps::<_, 4, 12, 20>(task)),
            (..=8, ..=40) => F::dispatch(LaneSweeps::<_, 8, 24, 40>(task)),
            _ => {}
        }
    }
}

/// The arguments of [`GroundRobot::solve_lanes`].
struct LaneTask<'a, F> {
    robot: &'a GroundRobot,
    ground: &'a Ground<F>,
    numbers: &'a StepLanes<'a, F>,
    impulses: &'a mut [F],
    velocities: &'a mut [F],
    solved: &'a mut [Option<F>],
}

/// [`GroundRobot::solve_lanes`] of a robot with at most as many contacts, rows of contacts, and
/// velocities.
struct LaneSweeps<'a, F, const CONTACTS: usize, const ROWS: usize, const VELOCITIES: usize>(
    LaneTask<'a, F>,
);

impl<F: Float, const CONTACTS: usize, const ROWS: usize, const VELOCITIES: usize> BatchTask<F>
    for LaneSweeps<'_, F, CONTACTS, ROWS, VELOCITIES>
{
    #[inline(always)]
    fn run<L: Lanes<Lane = F>>(self) {
        let LaneTask { robot, ground, numbers, impulses, velocities, solved } = self.0;
        let lanes = numbers.lanes;
        let at = robot.places();
        let rows = 3 * robot.contacts;
        let n = robot.velocities;
        let tolerance = L::splat(ground.tolerance);
        let mut first = 0;
        while first + L::LANES <= lanes {
            // No closure: it would not be compiled for the instructions of lanes.
            macro_rules! get {
                ($numbers:expr, $row:expr) => {
                    L::read(&$numbers[($row) * lanes + first..])
                };
            }
            let dt = get!(numbers.dt, 0);
            let mut contacts = [Contact::new(L::zero()); CONTACTS];
            let mut b = [L::zero(); ROWS];
            let mut a = [[L::zero(); ROWS]; ROWS];
            let mut row = 0;
            while row < rows {
                let mut column = 0;
                while column < rows {
                    a[row][column] = get!(numbers.problem, at.mobility + row * rows + column);
                    column += 1;
                }
                b[row] = get!(numbers.problem, at.free + row);
                if row % 3 == 2 {
                    let c = row / 3;
                    let own = GroundRobot::first_number_of(c);
                    contacts[c] = Contact::new(get!(numbers.settings, own + FRICTION));
                    let compliance = get!(numbers.settings, own + COMPLIANCE);
                    a[row][row] = a[row][row] + compliance;
                    let height = get!(numbers.problem, at.heights + c);
                    let before = get!(numbers.problem, at.before + row);
                    let law = [
                        get!(numbers.settings, own + ALPHA),
                        get!(numbers.settings, own + BETA),
                        compliance,
                        get!(numbers.settings, own + RESTITUTION),
                    ];
                    let least = least_speed([height, before, b[row], dt], law);
                    b[row] = b[row] - least;
                }
                row += 1;
            }
            let mut p = [L::zero(); ROWS];
            let mut row = 0;
            while row < rows {
                p[row] = get!(impulses, row);
                row += 1;
            }
            let mut equations = GroundEquations {
                a: &a[..rows],
                b: &b,
                contacts: &mut contacts[..robot.contacts],
                stops: &mut [],
            };
            let residual = equations.sweep_lanes(&mut p, (ground.sweeps, tolerance));
            let mut qd = [L::zero(); VELOCITIES];
            let mut v = 0;
            while v < n {
                qd[v] = get!(numbers.problem, v);
                let mut row = 0;
                while row < rows {
                    let response = get!(numbers.problem, at.responses + row * n + v);
                    qd[v] = response.mul_add(p[row], qd[v]);
                    row += 1;
                }
                v += 1;
            }
            // The largest of what is beyond a stop, and of the impulses of stops: none may be above
            // zero.
            let mut stopped = L::zero();
            let beta = get!(numbers.settings, BETA_OF_STOPS);
            let mut k = 0;
            while k < robot.stops.len() {
                let stop = &robot.stops[k];
                let range = velocity_range(get!(numbers.q, stop.coordinate), stop.range, beta, dt);
                let speed = qd[stop.velocity];
                stopped =
                    stopped.max(range[0] - tolerance - speed).max(speed - range[1] - tolerance);
                stopped = stopped.max(get!(numbers.stops, stop.velocity).abs());
                k += 1;
            }
            let mut row = 0;
            while row < rows {
                p[row].write(&mut impulses[row * lanes + first..]);
                row += 1;
            }
            let mut v = 0;
            while v < n {
                qd[v].write(&mut velocities[v * lanes + first..]);
                v += 1;
            }
            let [mut wrong, mut beyond] = [[F::zero(); MAX_LANES]; 2];
            residual.write(&mut wrong);
            stopped.write(&mut beyond);
            let mut lane = 0;
            while lane < L::LANES {
                let is_solved = wrong[lane].all_at_most(ground.tolerance)
                    && beyond[lane].all_at_most(F::zero());
                solved[first + lane] = if is_solved { Some(wrong[lane]) } else { None };
                lane += 1;
            }
            first += L::LANES;
        }
    }
}
