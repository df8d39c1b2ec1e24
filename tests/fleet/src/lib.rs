//! The compiled robots of [`fleet`](modyn_tests::fleet): all of them with the feature `whole`, else the small ones.

use std::sync::LazyLock;

use modyn_tests::compiled::Compiled;
use modyn_tests::fleet::Part;

/// The parts of the fleet that are compiled, with their robots.
pub static PARTS: &[(Part, &[Compiled])] = &[
    (Part::Small, modyn_fleet_small::ROBOTS),
    #[cfg(feature = "whole")]
    (Part::Parameters, modyn_fleet_parameters::ROBOTS),
    #[cfg(feature = "whole")]
    (Part::Legged, modyn_fleet_legged::ROBOTS),
    #[cfg(feature = "whole")]
    (Part::Trees, modyn_fleet_trees::ROBOTS),
    #[cfg(feature = "whole")]
    (Part::Complete, modyn_fleet_complete::ROBOTS),
];

/// All robots that are compiled.
pub static ROBOTS: LazyLock<Vec<Compiled>> =
    LazyLock::new(|| PARTS.iter().flat_map(|(_, robots)| robots.iter().copied()).collect());

/// The types of the robots.
pub mod robots {
    #[cfg(feature = "whole")]
    pub use modyn_fleet_complete::robots::*;
    #[cfg(feature = "whole")]
    pub use modyn_fleet_legged::robots::*;
    #[cfg(feature = "whole")]
    pub use modyn_fleet_parameters::robots::*;
    pub use modyn_fleet_small::robots::*;
    #[cfg(feature = "whole")]
    pub use modyn_fleet_trees::robots::*;
}
