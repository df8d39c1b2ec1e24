//! The 7-joint arm as a library for C.
include!(concat!(env!("OUT_DIR"), "/arm7.rs"));
