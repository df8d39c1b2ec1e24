//! A part of the fleet: robots as the build script compiled them, and the table [`ROBOTS`] of them.

include!(concat!(env!("OUT_DIR"), "/fleet.rs"));
