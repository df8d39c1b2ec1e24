//! The sources that are mutated, and the tests that run against their mutants.

/// The packages whose mutants are listed.
pub const PACKAGES: &[&str] = &["modyn-runtime", "modyn-codegen"];

/// The sources that are mutated, as patterns of cargo-mutants.
pub const SOURCES: &[&str] = &[
    "modyn-runtime/src/equations/**/*.rs",
    "modyn-runtime/src/joint/*.rs",
    "modyn-runtime/src/spatial/*.rs",
    "modyn-runtime/src/mechanism/*.rs",
    "modyn-runtime/src/model/*.rs",
    "modyn-runtime/src/jacobi.rs",
    "modyn-runtime/src/scalar/*.rs",
    "modyn-codegen/src/passes/*.rs",
    "modyn-codegen/src/trace/**/*.rs",
    "modyn-codegen/src/plan/partition.rs",
];

/// The library that has the function `__mutant`: its sources call it through `crate`, all others by the crate's name.
pub const LIBRARY: (&str, &str) = ("modyn-runtime", "modyn_runtime");

/// The tests of one package, as arguments of cargo. Packages with different features are built one after the other.
pub struct Tests {
    /// The package and its features.
    pub package: &'static [&'static str],
    /// The test binaries.
    pub binaries: &'static [&'static str],
}

/// The tests that run. Tests that start compilers are not among them.
pub const TESTS: &[Tests] = &[
    Tests {
        package: &["-p", "modyn-runtime", "--features", "nalgebra,rayon,serde,num-dual"],
        binaries: &["--lib", "--tests"],
    },
    Tests {
        package: &["-p", "modyn-codegen", "--features", "mjcf"],
        binaries: &[
            "--lib",
            "--test=external_wrenches",
            "--test=general_position",
            "--test=graphs",
            "--test=limb_derivatives",
            "--test=limbs",
            "--test=loops",
            "--test=programs",
            "--test=runtime_parameters",
            "--test=single_precision",
            "--test=singular",
        ],
    },
    Tests {
        package: &["-p", "modyn-tests"],
        binaries: &[
            "--test=changes",
            "--test=configuration",
            "--test=coordinates",
            "--test=coriolis",
            "--test=derivatives",
            "--test=dual",
            "--test=golden",
            "--test=golden_loops",
            "--test=graph",
            "--test=identities",
            "--test=kinematics",
            "--test=model",
            "--test=operation_counts",
            "--test=paper_gripper",
            "--test=regressor",
            "--test=runtime_inertia",
            "--test=shapes",
        ],
    },
    Tests { package: &["-p", "modyn-reproduce"], binaries: &["--test=decomposition"] },
];
