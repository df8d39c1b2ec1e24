//! A part of the fleet: the robots that the build script compiled, and the table [`ROBOTS`] of them.

include!(concat!(env!("OUT_DIR"), "/fleet.rs"));
