//! Constants of a robot that accompany its programs.

use modyn_runtime::equations::identification::{BaseParameter, BaseParameters};
use modyn_runtime::equations::kinematics::coordinates;
use modyn_runtime::mechanism::Mechanism;
use modyn_runtime::model::Model;

use super::Function;
use super::choices::Choices;

/// Constants of a robot that its description implies.
#[derive(Clone, Debug)]
pub struct Constants {
    /// The neutral coordinates: zero for every joint, the identity for quaternions.
    pub neutral: Vec<f64>,
    /// For each link of the description the index of its parent: for a moving link, the moving link
    /// that its joint is on; for a link that is fixed to a moving link, that link. `None` is the
    /// world.
    pub link_parents: Vec<Option<usize>>,
    /// The inertial parameters of the moving links, ten for each link.
    pub inertial_parameters: Vec<f64>,
    /// The base parameters of robots that have the regressor: finding them takes a while.
    pub base_parameters: Option<BaseParameterTable>,
}

/// The base parameters of a robot: a minimal set of combinations of inertial parameters that
/// determines all joint forces.
#[derive(Clone, Debug)]
pub struct BaseParameterTable {
    /// The values.
    pub values: Vec<f64>,
    /// The columns of the regressor that belong to them.
    pub columns: Vec<usize>,
    /// The combinations, as text.
    pub names: Vec<String>,
}

impl Constants {
    /// Returns the constants of a model.
    #[must_use]
    pub fn new(model: &Model, choices: &Choices) -> Self {
        let links = model.moving_links();
        let frames = model.links();
        let mut neutral = vec![0.0; model.nq()];
        coordinates::neutral(&Mechanism::new(model), &mut neutral);
        let link_parents = frames.iter().map(|frame| {
            let carrier = frame.moving_link.and_then(|link| match links[link].name == frame.name {
                true => links[link].parent,
                false => Some(link),
            });
            carrier.and_then(|link| model.link_index(&links[link].name))
        });
        let inertial_parameters =
            (0..links.len()).filter_map(|link| model.inertial_parameters(link)).flatten();
        let has_regressor = choices.functions.contains(&Function::Regressor);
        Self {
            neutral,
            link_parents: link_parents.collect(),
            inertial_parameters: inertial_parameters.collect(),
            base_parameters: has_regressor.then(|| BaseParameterTable::new(model)),
        }
    }
}

impl BaseParameterTable {
    fn new(model: &Model) -> Self {
        let base = BaseParameters::new(model);
        Self {
            values: base.values(model),
            columns: base.regressor_columns(),
            names: base.parameters.iter().map(BaseParameter::name).map(Into::into).collect(),
        }
    }
}
