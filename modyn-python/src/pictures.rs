//! Pictures for notebooks: the modules and the sparsity of a robot, and its motions.

use modyn_cli::picture::{Sparsity, draw};
use modyn_cli::viewer::{Motion, Scene};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::Given;
use crate::robot::Robot;

#[pymethods]
impl Robot {
    /// Returns a page of HTML that shows the robot in motion, with its shapes. `times`, (n,), s,
    /// must ascend; `trajectory`, (n, nq), has the coordinates at each time. The ground is drawn at
    /// the height `ground`, m; by default at zero, or below the motion.
    #[pyo3(signature = (times, trajectory, ground = None))]
    fn animation(
        &self,
        times: &Bound<'_, PyAny>,
        trajectory: &Bound<'_, PyAny>,
        ground: Option<f64>,
    ) -> PyResult<String> {
        let wrong = |message: &str| PyValueError::new_err(message.to_owned());
        let nq = self.model().nq();
        let trajectory = Given::<f64>::read("animation", "trajectory", &[nq], trajectory)?;
        let times = Given::<f64>::read("animation", "times", &[], times)?;
        if times.states != trajectory.states || !times.as_slice()?.is_sorted() {
            return Err(wrong("there must be as many times as states, in ascending order"));
        }
        let model = self.model();
        let mut scene = Scene::new(model.name());
        let robot = scene.robot(model.clone(), self.shapes());
        let times = times.as_slice()?.to_vec();
        let coordinates = trajectory.as_slice()?.chunks(nq.max(1)).map(<[f64]>::to_vec).collect();
        scene.motion(Motion { name: model.name().into(), robot, times, coordinates, forces: None });
        if let Some(height) = ground {
            if !height.is_finite() {
                return Err(wrong("`ground` must be finite: it is the height of the ground in m"));
            }
            scene.ground(height);
        }
        Ok(scene.page())
    }

    /// Returns the kinematic modules and the sparsity of the mass matrix and of its factors as a
    /// picture for notebooks; `None` for a robot that is too large to draw.
    fn _repr_html_(&self) -> Option<String> {
        let sparsity = Sparsity::of(self.model(), self.modules()).ok()?;
        Some(draw(self.model(), self.modules(), &sparsity))
    }
}
