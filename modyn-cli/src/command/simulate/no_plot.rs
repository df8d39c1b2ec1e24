//! The error of `--plot` in a command that was compiled without the feature `plot`.

use modyn_runtime::model::Model;

use super::motion::Motion;
use crate::command::outcome::Failure;

/// Returns the error that names the missing feature.
pub fn of(_: &Model, _: &Motion) -> Result<String, Failure> {
    Err(Failure::usage(
        "--plot: this `modyn` was compiled without the feature `plot`; install it with `--features plot`",
    ))
}
