//! Debuggers find the caller of a function of an object file. The suite `conformance` compares its numbers.

#![cfg(all(feature = "object", target_arch = "x86_64", target_os = "linux"))]

use std::process::Command;

use modyn_codegen::Function;
use modyn_jit::InstructionSet;
use modyn_jit::object::{ObjectBuilder, ObjectFormat, ObjectOptions};
use modyn_tests::conformance::{command, folder, robot};

/// A program that runs a function one instruction at a time. At each instruction, the descriptions of stack frames lead to the
/// caller, with the registers that it had.
const STEPS: &str = r#"
#define _GNU_SOURCE
#include <signal.h>
#include <stdio.h>
#include <ucontext.h>
#include <unwind.h>
#include "robot.h"

static volatile int seen, wrong;
static volatile long steps;
static unsigned long rbx, rbp;
static double q[ROBOT_NQ], qd[ROBOT_NV], tau[ROBOT_NV], qdd[ROBOT_NV];

__attribute__((noinline)) static void caller(void)
{
    __asm__ volatile("pushfq; orq $0x100, (%rsp); popfq");
    robot_forward_dynamics(q, qd, tau, qdd);
    __asm__ volatile("pushfq; andq $~0x100, (%rsp); popfq");
}

static _Unwind_Reason_Code visit(struct _Unwind_Context *context, void *found)
{
    void *function = _Unwind_FindEnclosingFunction((void *)(_Unwind_GetIP(context) - 1));
    if (function != (void *)caller) { return _URC_NO_REASON; }
    *(int *)found = 1;
    if (_Unwind_GetGR(context, 3) != rbx || _Unwind_GetGR(context, 6) != rbp) { wrong++; }
    return _URC_END_OF_STACK;
}

static void step(int number, siginfo_t *information, void *data)
{
    const greg_t *registers = ((ucontext_t *)data)->uc_mcontext.gregs;
    int found = 0;
    (void)number; (void)information;
    if ((unsigned long)registers[REG_RIP] == (unsigned long)robot_forward_dynamics) {
        rbx = (unsigned long)registers[REG_RBX];
        rbp = (unsigned long)registers[REG_RBP];
        seen = 1;
    }
    if (!seen || _Unwind_FindEnclosingFunction((void *)registers[REG_RIP]) == (void *)caller) { return; }
    steps++;
    _Unwind_Backtrace(visit, &found);
    if (!found) { wrong++; }
}

int main(void)
{
    struct sigaction action = { 0 };
    int i;
    if (!robot_is_supported()) { return 3; }
    for (i = 0; i < ROBOT_NQ; i++) { q[i] = 1e9 * (i + 1); }
    action.sa_sigaction = step;
    action.sa_flags = SA_SIGINFO;
    sigaction(SIGTRAP, &action, NULL);
    caller();
    printf("%ld %d\n", steps, wrong);
    return 0;
}
"#;

#[test]
fn debuggers_find_the_caller_at_each_instruction() {
    for instruction_set in InstructionSet::available() {
        let prefix = Some("robot".into());
        let options = ObjectOptions { instruction_set, format: ObjectFormat::Elf, prefix };
        let builder = robot("arm6").functions([Function::ForwardDynamics]);
        let object = builder.generate_object(&options).expect("an object");
        let folder = folder(&format!("steps_{instruction_set:?}"));
        let files = [("robot.o", &*object.bytes), ("robot.h", object.header.as_bytes())];
        for (name, bytes) in files.into_iter().chain([("main.c", STEPS.as_bytes())]) {
            std::fs::write(folder.join(name), bytes).expect("writes");
        }
        let mut gcc = Command::new("gcc");
        gcc.args(["-O0", "-mno-red-zone", "-fno-omit-frame-pointer", "main.c", "robot.o"]);
        command(gcc.args(["-o", "main"]).current_dir(&folder));
        let found = command(&mut Command::new(folder.join("main")));
        let (steps, wrong) = found.trim().split_once(' ').expect("two numbers");
        // The angles are large, so the code is longer than that of small ones.
        assert!(steps.parse::<u32>().expect("a number") > 1000, "{found}");
        assert_eq!(wrong, "0", "{found}");
    }
}
