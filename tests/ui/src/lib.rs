//! The messages of the macro. Each case is a program in the folder of this package, with the
//! expected messages of the compiler beside it. `TRYBUILD=overwrite cargo test -p modyn-ui` renews
//! them.
//!
//! trybuild builds the crate `modyn` once more, in `target/tests/trybuild`. Cases that fail are
//! checked by one call of Cargo; cases that run need a build of the runtime as well.

#[cfg(test)]
mod tests {
    use trybuild::TestCases;

    #[test]
    fn errors_are_shown_as_expected() {
        TestCases::new().compile_fail("*.rs");
    }

    #[test]
    fn good_cases_compile_and_run() {
        TestCases::new().pass("pass/*.rs");
    }
}
