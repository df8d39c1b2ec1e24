//! The tests of the command, one module a topic.

mod check;
mod command;
mod common;
mod compare;
mod convert;
mod docs;
mod generate;
mod hostile;
mod inspect;
mod kinematics;
mod mjcf;
mod output_files;
mod simulate;
mod view;
