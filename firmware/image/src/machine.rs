//! The parts that differ between processors: entry, faults, and the count of instructions.

use core::arch::asm;

#[cfg(target_arch = "arm")]
mod arm {
    use super::*;

    const SYST_CSR: *mut u32 = 0xe000_e010 as *mut u32;
    const SYST_RVR: *mut u32 = 0xe000_e014 as *mut u32;
    const SYST_CVR: *mut u32 = 0xe000_e018 as *mut u32;

    /// The instructions in a tick: QEMU's boards run at 25 MHz, and with `-icount shift=0` every instruction takes a
    /// nanosecond.
    const PER_TICK: u32 = 40;

    const MASK: u32 = 0x00ff_ffff;

    #[cortex_m_rt::entry]
    fn start() -> ! {
        crate::main()
    }

    #[cortex_m_rt::exception]
    unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
        crate::exit(102)
    }

    /// Starts the clock.
    pub fn prepare() {
        // SAFETY: SysTick's registers (ARMv7-M, B3.3) are at these addresses on every Cortex-M4 and M7,
        // nothing else uses them, and its interrupt stays off.
        unsafe {
            SYST_RVR.write_volatile(MASK);
            SYST_CVR.write_volatile(0);
            SYST_CSR.write_volatile(0b101);
        }
    }

    pub fn instructions() -> u32 {
        // SAFETY: as above; reading has no effect.
        unsafe { SYST_CVR.read_volatile() }
    }

    /// Returns the instructions since `start`; at most 671 million.
    pub fn since(start: u32) -> u32 {
        (start.wrapping_sub(instructions()) & MASK) * PER_TICK
    }

    pub fn stack_pointer() -> usize {
        let pointer: usize;
        // SAFETY: copies a register.
        unsafe { asm!("mov {}, sp", out(reg) pointer, options(nomem, nostack)) };
        pointer
    }

    /// Executes an instruction that does not exist.
    #[cfg(feature = "fail")]
    pub fn fault() {
        // SAFETY: the handler of the fault ends the program.
        unsafe { asm!("udf #0") };
    }
}

#[cfg(target_arch = "riscv32")]
mod riscv {
    use super::*;

    #[riscv_rt::entry]
    fn start() -> ! {
        crate::main()
    }

    // SAFETY: the name and type by which riscv-rt calls the handler of exceptions; nothing else has
    // this name.
    #[unsafe(export_name = "ExceptionHandler")]
    extern "C" fn fault_handler(_: &riscv_rt::TrapFrame) -> ! {
        crate::exit(102)
    }

    pub fn prepare() {}

    pub fn instructions() -> u32 {
        let count: u32;
        // SAFETY: reads a counter (RISC-V privileged architecture, 3.1.10).
        unsafe { asm!("csrr {}, minstret", out(reg) count, options(nomem, nostack)) };
        count
    }

    pub fn since(start: u32) -> u32 {
        instructions().wrapping_sub(start)
    }

    pub fn stack_pointer() -> usize {
        let pointer: usize;
        // SAFETY: copies a register.
        unsafe { asm!("mv {}, sp", out(reg) pointer, options(nomem, nostack)) };
        pointer
    }

    #[cfg(feature = "fail")]
    pub fn fault() {
        // SAFETY: the handler of the fault ends the program.
        unsafe { asm!("unimp") };
    }
}

#[cfg(target_arch = "arm")]
pub use arm::*;
#[cfg(target_arch = "riscv32")]
pub use riscv::*;
