//! The biped's step (Sect. 5.1): computed torque along the desired trajectories, and forward dynamics by generated
//! code. Figs. 8 and 9, and the step as an animation.

use modyn::simulate::{Gains, Reference, State as RobotState};
use modyn_cli::viewer;
use modyn_runtime::Interpreter;
use modyn_runtime::model::Inertial;
use modyn_runtime::spatial::Pose;

use crate::motion::{State, instants, integrate};
use crate::plot::{Axis, Chart, Line};
use crate::report::{Failure, Report, Table, power};
use crate::{gait, robots};

modyn::modyn! {
    pub Biped = "../../../robots/biped.urdf",
    modules = [
        ["stance_shank", "stance_thigh", "trunk"],
        ["swing_thigh", "swing_shank", "swing_foot"],
    ]
}

/// The paper's gains, K_p = 225 1/s^2 and K_d = 30 1/s.
pub const GAINS: Gains = Gains { kp: 225.0, kd: 30.0 };

/// The simulated step.
#[derive(Clone, Debug)]
pub struct Walk {
    /// The times, s.
    pub times: Vec<f64>,
    /// The coordinates and velocities.
    pub states: Vec<State>,
}

/// Simulates the step: computed torque by the compiled inverse dynamics, accelerations by the compiled forward
/// dynamics. `offset` is the deviation of each joint from its desired position at the start, rad.
///
/// # Panics
///
/// Never: the lengths are those of the biped.
#[must_use]
pub fn walk(offset: f64) -> Walk {
    let gait::Posture { q, qd, .. } = gait::desired(0.0);
    let q = Biped::integrate(&q, &[offset; Biped::NV]);
    let times = instants(gait::DURATION, 101);
    let geometry = Interpreter::<f64>::new(robots::biped());
    let start = State { q: q.to_vec(), qd: qd.to_vec() };
    let states = integrate(&geometry, start, &times, 1e-8, |t, state| {
        let gait::Posture { q, qd, qdd } = gait::desired(t);
        let mut now = RobotState::<Biped>::at_rest(Biped::NEUTRAL);
        now.q.copy_from_slice(&state.q);
        now.qd.copy_from_slice(&state.qd);
        let tau = now.computed_torque(&Reference { q, qd, qdd }, GAINS);
        Biped::forward_dynamics(&now.q, &now.qd, &tau).to_vec()
    });
    Walk { times, states }
}

impl Walk {
    /// Returns the joint angles of Fig. 9 at each time.
    #[must_use]
    pub fn angles(&self) -> Vec<[f64; 12]> {
        self.states.iter().map(|state| gait::angles(&coordinates(state))).collect()
    }

    /// Returns the largest deviation of a joint from its desired position at each time, rad.
    #[must_use]
    pub fn errors(&self) -> Vec<f64> {
        let error = |(&t, state): (&f64, &State)| {
            let way = Biped::difference(&gait::desired(t).q, &coordinates(state));
            // NaN counts as infinite.
            let size = |x: &f64| if x.is_nan() { f64::INFINITY } else { x.abs() };
            way.iter().map(size).fold(0.0, f64::max)
        };
        self.times.iter().zip(&self.states).map(error).collect()
    }

    /// Returns a page with the walking stick figure.
    ///
    /// # Panics
    ///
    /// Never: the lengths are those of the biped.
    #[must_use]
    pub fn page(&self) -> String {
        const TOE: f64 = 0.075;
        let model = robots::biped();
        let mut interpreter = Interpreter::<f64>::new(model.clone());
        let mut poses = vec![Pose::identity(); model.links().len()];
        let index = |name: &str| model.link_index(name).expect("a link");
        // Feet from heel to toe; legs; the trunk from hip to hip and upwards.
        let points = [
            ("stance_foot", [-TOE, 0.0, 0.0]),
            ("stance_foot", [TOE, 0.0, 0.0]),
            ("stance_shank", [0.0; 3]),
            ("stance_thigh", [0.0; 3]),
            ("trunk", [0.0; 3]),
            ("trunk", [0.0, 0.05, 0.0]),
            ("trunk", [0.0, 0.05, 0.5]),
            ("swing_thigh", [0.0; 3]),
            ("swing_shank", [0.0; 3]),
            ("swing_foot", [0.0; 3]),
            ("swing_foot", [-TOE, 0.0, 0.0]),
            ("swing_foot", [TOE, 0.0, 0.0]),
        ];
        let edges = [(0, 1), (2, 3), (3, 4), (4, 5), (5, 6), (5, 7), (7, 8), (8, 9), (10, 11)];
        let frame = |(&time, state): (&f64, &State)| {
            interpreter.link_poses(&state.q, &mut poses).expect("lengths");
            let points = points.map(|(link, point)| poses[index(link)].transform_point(point));
            viewer::Frame { time, points: points.to_vec() }
        };
        let frames: Vec<_> = self.times.iter().zip(&self.states).map(frame).collect();
        viewer::page("The biped's step", &edges, &frames)
    }
}

fn coordinates(state: &State) -> [f64; 14] {
    std::array::from_fn(|i| state.q[i])
}

/// Returns a chart over the time of the step.
fn chart<'a>(title: &'a str, y: &'a str, lines: Vec<Line>) -> Chart<'a> {
    Chart { title, x: Axis::linear("time (s)"), y: Axis::linear(y), lines }
}

/// Writes the section of the page.
///
/// # Errors
///
/// If a file cannot be written.
pub fn report(report: &mut Report) -> Result<(), Failure> {
    report.heading("The biped: Sect. 5.1, Figs. 8 and 9");
    report.text(
        "The biped takes a step by (61)-(64); (63) has the minus that (62) requires. The biped's parameters are those of \
         the authors' public simulator inputs, since the paper's Table 1 is not available. The paper does not state two \
         things: here the swing foot keeps y = 0.2 m, and feet and trunk stay upright. The controller is computed torque \
         with K_p = 225 and K_d = 30; forward dynamics is generated code; the integrator is Dormand and Prince's with a \
         tolerance of 1e-8 a step. The hips' angles are Euler angles about rotating axes: y-x-z of the trunk relative to \
         the thigh for the stance hip, x-y-z of the thigh relative to the trunk for the swing hip.",
    );
    let model = robots::biped();
    let rows = model.moving_links().iter().map(|link| {
        let Inertial { mass, center_of_mass: [_, _, height], inertia: [xx, _, _, yy, _, zz] } =
            link.inertial;
        let numbers = [mass, height, xx, yy, zz].map(|x| x.to_string());
        [link.name.clone(), link.joint.joint_type.name().into()]
            .into_iter()
            .chain(numbers)
            .collect()
    });
    let head =
        ["link", "joint", "mass (kg)", "centre above the joint (m)", "Ixx (kg m^2)", "Iyy", "Izz"];
    report.table(Table::new(&head, rows.collect()));
    let times = instants(gait::DURATION, 101);
    let curve = |f: &dyn Fn(f64) -> f64| times.iter().map(|&t| (t, f(t))).collect::<Vec<_>>();
    let lines = vec![
        Line::new("trunk's centre, x", curve(&|t| gait::trunk(t)[0].re)),
        Line::new("trunk's centre, y", curve(&|t| gait::trunk(t)[1].re)),
        Line::new("swing ankle, x", curve(&|t| gait::swing_ankle(t)[0].re)),
        Line::new("swing ankle, z", curve(&|t| gait::swing_ankle(t)[2].re)),
    ];
    report.plot("fig8.svg", &chart("Fig. 8: designed trajectories", "position (m)", lines))?;
    let (walk, offset) = (walk(0.0), walk(0.05));
    let (angles, perturbed) = (walk.angles(), offset.angles());
    let joints =
        [("stance leg", 0..3), ("stance hip", 3..6), ("swing hip", 6..9), ("swing leg", 9..12)];
    for (name, range) in joints {
        let lines = range.clone().flat_map(|k| {
            let desired = curve(&|t| gait::angles(&gait::desired(t).q)[k].to_degrees());
            let found = times.iter().zip(&angles).map(move |(&t, a)| (t, a[k].to_degrees()));
            let joint = gait::ANGLES[k];
            [Line::new(format!("{joint}: desired"), desired), Line::new("simulated", found)]
        });
        let title = format!("Fig. 9, {name}: desired and simulated joint angles");
        let file = format!("fig9-{}.svg", name.replace(' ', "-"));
        report.plot(&file, &chart(&title, "joint angle (deg)", lines.collect()))?;
    }
    let lines = [1, 2, 7, 9].into_iter().flat_map(|k| {
        let desired = curve(&|t| gait::angles(&gait::desired(t).q)[k].to_degrees());
        let found = times.iter().zip(&perturbed).map(move |(&t, a)| (t, a[k].to_degrees()));
        [Line::new(format!("{}: desired", gait::ANGLES[k]), desired), Line::new("simulated", found)]
    });
    let title = "The same from a start 0.05 rad away in each joint";
    report.plot("fig9-offset.svg", &chart(title, "joint angle (deg)", lines.collect()))?;
    let most = |walk: &Walk| walk.errors().into_iter().fold(0.0, f64::max);
    let end = offset.errors().last().copied().unwrap_or(f64::NAN);
    report.text(format!(
        "The simulated joints stay within {} rad of the desired ones; from the start 0.05 rad away they are within {} \
         rad at the end of the step.",
        power(most(&walk)),
        power(end),
    ));
    report.file("walk.html", "The step as a picture that moves", &walk.page())?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::walk;

    #[test]
    fn simulated_angles_match_the_desired_ones() {
        let walk = walk(0.0);
        assert_eq!(walk.states.len(), 101);
        assert!(walk.errors().iter().all(|&error| error < 1e-6), "Fig. 9");
    }

    #[test]
    fn a_false_start_is_corrected() {
        // Critically damped, K_d^2 = 4 K_p: the remaining deviation is (1 + 15 t) e^-15t times the offset.
        let walk = walk(0.05);
        for (t, error) in walk.times.iter().zip(walk.errors()) {
            let expected = 0.05 * (1.0 + 15.0 * t) * (-15.0 * t).exp();
            assert!((error - expected).abs() < 5e-3, "{error}, {expected} at {t}");
        }
        assert!(walk.errors()[100] < 1e-4);
    }

    #[test]
    fn the_picture_has_every_instant() {
        let page = walk(0.0).page();
        assert!(page.starts_with("<!doctype html>"));
        let times = page.split_once("\"times\":[").and_then(|(_, behind)| behind.split_once(']'));
        let times: Vec<f64> =
            times.expect("times").0.split(',').map(|t| t.parse().expect("a time")).collect();
        assert_eq!(times.len(), 101);
        for (i, t) in times.iter().enumerate() {
            assert!((t - 0.01 * i as f64).abs() < 1e-12, "{t}");
        }
    }
}
