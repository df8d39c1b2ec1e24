//! Where the system refuses executable memory, compilation returns an error that says what to use instead.
//!
//! Unsafe code: a system call by which a child process of this test gives up executable memory. It reads and writes no
//! memory of the process.
#![cfg(target_os = "linux")]
#![allow(unsafe_code)]

use std::process::Command;

use modyn_codegen::{Function, ReadOptions, read};
use modyn_jit::{CompileError, Compiled, InstructionSet};
use modyn_runtime::Interpreter;

/// Set in the child process.
const REFUSED: &str = "MODYN_TEST_REFUSED_MEMORY";

/// Makes the system refuse to make pages executable in this process from now on.
fn refuse() {
    // SAFETY: see the header.
    let code = unsafe {
        let bits = libc::c_ulong::from(libc::PR_MDWE_REFUSE_EXEC_GAIN);
        let zero: libc::c_ulong = 0;
        libc::prctl(libc::PR_SET_MDWE, bits, zero, zero, zero)
    };
    assert_eq!(code, 0, "{}", std::io::Error::last_os_error());
}

#[test]
fn refused_memory_is_an_error() {
    if std::env::var_os(REFUSED).is_none() {
        let mut child = Command::new(std::env::current_exe().expect("this program"));
        let output = child
            .args(["--exact", "memory::refused_memory_is_an_error"])
            .env(REFUSED, "1")
            .output();
        let output = output.expect("a child process");
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.contains("1 passed"), "{said}");
        return;
    }
    if InstructionSet::detect().is_none() {
        return;
    }
    let text = include_str!("../../robots/arm6.urdf");
    let model = read(text, "arm6.urdf", &ReadOptions::default()).expect("good").model;
    let compile = || Compiled::<f64>::new(&model, [Function::ForwardDynamics]);
    compile().map(drop).expect("code before");
    refuse();
    let error = compile().map(drop).expect_err("no code after");
    assert!(matches!(error, CompileError::Memory(_)), "{error}");
    let message = error.to_string();
    assert!(
        message.contains("executable memory") && message.contains("`modyn::Interpreter`"),
        "{message}"
    );
    // What the message recommends works.
    let mut qdd = [0.0_f64; 6];
    let state = [0.3, -0.4, 0.5, 0.6, -0.7, 0.8];
    Interpreter::new(model).forward_dynamics(&state, &state, &state, &mut qdd).expect("fits");
    assert!(qdd.iter().all(|x| x.is_finite() && *x != 0.0));
}
