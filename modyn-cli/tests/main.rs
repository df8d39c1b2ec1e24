//! The tests of the command, one module a topic.

mod check;
mod command;
mod common;
mod compare;
mod docs;
mod generate;
mod hostile;
mod inspect;
mod mjcf;
mod simulate;
