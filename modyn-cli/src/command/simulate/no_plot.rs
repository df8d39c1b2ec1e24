//! `--plot` in a command that was built without the feature `plot`.

use modyn_runtime::model::Model;

use super::motion::Motion;
use crate::command::outcome::Failure;

/// The error that says which feature is missing.
pub fn of(_: &Model, _: &Motion) -> Result<String, Failure> {
    Err(Failure::usage(
        "--plot: this `modyn` was built without plots; install it with the feature `plot`",
    ))
}
