//! The README and the pages of `docs/`, one module for each: their examples are this crate's doc tests.

include!(concat!(env!("OUT_DIR"), "/pages.rs"));
