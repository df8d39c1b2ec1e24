//! Helpers have the bits of the runtime's functions. Windows' entries work, run here by their
//! calling convention. All formats are read back.
//!
//! Unsafe code: calls of functions that the tests have assembled, with pointers to as many numbers
//! as they read and write.
#![allow(unsafe_code)]

use std::collections::BTreeMap;

use iced_x86::{Code, Decoder, DecoderOptions, FlowControl};
use modyn_codegen::{Function, FusedFunction};
use modyn_runtime::{Scalar, trig_steps};
use modyn_tests::conformance::numbers::Number;
use modyn_tests::conformance::robot;
use modyn_tests::random::Random;
use object::{Object as _, ObjectSection, ObjectSymbol};

use super::assembler::Assembler;
use super::convention::Convention;
use super::helpers::helper;
use super::text::{Text, text};
use super::unwind::{FrameKind, unwind_information};
use super::{ObjectBuilder, ObjectFormat, ObjectOptions};
use crate::helper::Helper;
use crate::instruction_set::InstructionSet;
use crate::machine::Pages;
use crate::tests::{Fuse, numbers, plan, sets_of_x86_64};
use crate::{Compiled, Options};

/// Numbers of all sizes, special ones, and neighbours of powers of two.
fn samples<F: Fuse>(count: usize) -> Vec<F> {
    let special =
        [0.0, -0.0, 1.0, -1.0, 0.5, 1e-310, 1e-40, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
    let mut random = Random::new(5);
    let any = (0..count).map(|_| {
        let sign = if random.between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
        sign * random.between(-1020.0, 1023.0).exp2()
    });
    let mut all: Vec<f64> = any.chain(special).collect();
    all.extend((0..count).map(|_| random.between(-30.0, 126.0).exp2() * random.between(-1.0, 1.0)));
    all.extend((1..60).flat_map(|k| {
        let power = f64::from(k).exp2() * std::f64::consts::FRAC_PI_2;
        [power, power.next_up(), -power.next_down(), f64::from(k - 30).exp2()]
    }));
    let limit = trig_steps::limit::<f64>();
    all.extend([
        limit,
        limit.next_down(),
        -limit,
        4096.0,
        4095.999,
        6381956970095103.0 * 797_f64.exp2(),
    ]);
    all.into_iter().map(F::from_f64).collect()
}

#[cfg(target_arch = "x86_64")]
fn helpers<F: Fuse>() {
    type Function<F> = extern "sysv64" fn(*mut F, *mut F, *const F, u32);
    let samples = samples::<F>(20_000);
    for (wanted, lanes) in
        [(Helper::Reduce, 4), (Helper::Atan2, 1), (Helper::Logarithm, 2), (Helper::Atan2, 8)]
    {
        let mut assembler = Assembler::new(Vec::new());
        helper::<F>(&mut assembler, wanted);
        let pages = Pages::new(&assembler.finish()).expect("memory");
        // SAFETY: the code at the start is the helper.
        let function = unsafe { std::mem::transmute::<*const u8, Function<F>>(pages.address(0)) };
        for (k, third) in samples.chunks_exact(lanes).enumerate() {
            let shifted = (k * 7 + lanes) % (samples.len() - lanes);
            let mut second = samples[shifted..][..lanes].to_vec();
            let before = second.clone();
            let mut first = vec![F::from_f64(7.0); lanes];
            function(first.as_mut_ptr(), second.as_mut_ptr(), third.as_ptr(), lanes as u32);
            for lane in 0..lanes {
                let y = before[lane];
                let x = third[lane];
                let [expected, other] = match wanted {
                    Helper::Reduce if Scalar::abs(x) < trig_steps::limit() => [F::from_f64(7.0), y],
                    Helper::Reduce => trig_steps::reduce_far(x),
                    Helper::Atan2 => [Scalar::atan2(y, x), y],
                    Helper::Logarithm => [Scalar::ln(y), y],
                };
                let same = first[lane].is_same(expected) && second[lane].is_same(other);
                assert!(same, "{wanted:?} {y:?} {x:?}: {:?} {expected:?}", first[lane]);
            }
        }
    }
}

#[test]
#[cfg(target_arch = "x86_64")]
fn helpers_have_the_bits_of_the_runtime() {
    helpers::<f64>();
    helpers::<f32>();
}

fn start(text: &Text, name: &str) -> usize {
    text.symbols.iter().find(|symbol| symbol.name == name).expect("a symbol").start
}

/// Functions with few and many arguments, on the stack too, of links, and of the poses of all
/// links.
#[test]
#[cfg(target_arch = "x86_64")]
fn entries_of_windows_compute_the_same() {
    type Three = extern "win64" fn(*const f64, *const f64, *const f64, *mut f64);
    type Five = extern "win64" fn(*const f64, *const f64, *const f64, *const f64, *mut f64);
    type OfLink = extern "win64" fn(*const f64, u32, *mut f64) -> i32;
    type One = extern "win64" fn(*const f64, *mut f64);
    let functions = [
        Function::ForwardDynamics,
        Function::ForwardDynamicsVjp,
        Function::Jacobian,
        Function::LinkPoses,
    ];
    let planning = plan("arm6", &functions);
    let frames = planning.model.links().len();
    for instruction_set in InstructionSet::available() {
        let planned =
            text::<f64>(&planning.plan, &planning.model, instruction_set, Convention::Windows);
        let text = planned.expect("code");
        let pages = Pages::new(&text.code).expect("memory");
        let options = Options { instruction_set: Some(instruction_set), ..Options::default() };
        let compiled = Compiled::<f64>::from_plan(&planning, options).expect("code");
        let address = |name: &str| pages.address(start(&text, name));
        for (seed, scale) in (1..).zip([2.0, 1e9]) {
            let states = numbers::<f64>(seed, 24, scale);
            let arguments: Vec<&[f64]> = states.chunks(6).collect();
            let [q, qd, tau, last] = [0, 1, 2, 3].map(|k: usize| arguments[k].as_ptr());
            let compare = |function: Function,
                           results: &[f64],
                           arguments: &[&[f64]],
                           link: Option<usize>| {
                let mut expected = vec![f64::NAN; results.len()];
                let call = compiled.function(function).expect("compiled");
                match link {
                    None => call.one(arguments, &mut expected).expect("fits"),
                    Some(link) => call.link(link, arguments, &mut expected).expect("fits"),
                }
                assert!(results.iter().zip(&expected).all(|(a, b)| a.is_same(*b)), "{function:?}");
            };
            let mut out = vec![f64::NAN; 6];
            // SAFETY: the entries' types.
            let function =
                unsafe { std::mem::transmute::<*const u8, Three>(address("forward_dynamics")) };
            keeps_registers(|| function(q, qd, tau, out.as_mut_ptr()));
            compare(Function::ForwardDynamics, &out, &arguments[..3], None);
            let mut out = vec![f64::NAN; 24];
            // SAFETY: as above.
            let function =
                unsafe { std::mem::transmute::<*const u8, Five>(address("forward_dynamics_vjp")) };
            keeps_registers(|| function(q, qd, tau, last, out.as_mut_ptr()));
            compare(Function::ForwardDynamicsVjp, &out, &arguments, None);
            let mut out = vec![f64::NAN; 12 * frames];
            // SAFETY: as above.
            let function = unsafe { std::mem::transmute::<*const u8, One>(address("link_poses")) };
            keeps_registers(|| function(q, out.as_mut_ptr()));
            compare(Function::LinkPoses, &out, &arguments[..1], None);
            // SAFETY: as above.
            let function = unsafe { std::mem::transmute::<*const u8, OfLink>(address("jacobian")) };
            let mut out = vec![f64::NAN; 36];
            for link in 0..frames {
                assert_eq!(function(q, link as u32, out.as_mut_ptr()), 1);
                compare(Function::Jacobian, &out, &arguments[..1], Some(link));
            }
            assert_eq!(function(q, frames as u32, out.as_mut_ptr()), 0);
        }
    }
}

/// Runs a call between a load of the vector registers that Windows gives back to the caller and a
/// comparison of them.
#[cfg(target_arch = "x86_64")]
fn keeps_registers(mut call: impl FnMut()) {
    extern "win64" fn run(call: *mut &mut dyn FnMut()) {
        // SAFETY: `keeps_registers` passes a pointer to its argument.
        unsafe { (*call)() }
    }
    let mut call: &mut dyn FnMut() = &mut call;
    let numbers: [f64; 12] = std::array::from_fn(|i| 1.5 + i as f64);
    let mut kept = [0.0; 12];
    macro_rules! with {
        ($($register:literal $index:literal,)*) => {
            // SAFETY: the call follows Windows' convention, which the compiler knows; the registers
            // are operands.
            unsafe {
                std::arch::asm!(
                    $(concat!("movsd ", $register, ", [r13 + 8 * ", $index, "]"),)*
                    "mov rdi, [r13 + 80]",
                    "mov rsi, [r13 + 88]",
                    "mov r12, rsp",
                    "and rsp, -16",
                    "sub rsp, 32",
                    "call {run}",
                    "mov rsp, r12",
                    "mov [r14 + 80], rdi",
                    "mov [r14 + 88], rsi",
                    $(concat!("movsd [r14 + 8 * ", $index, "], ", $register),)*
                    run = sym run,
                    in("rcx") &raw mut call,
                    in("r13") numbers.as_ptr(),
                    in("r14") kept.as_mut_ptr(),
                    out("r12") _,
                    clobber_abi("sysv64"),
                );
            }
        };
    }
    with!(
        "xmm6" 0, "xmm7" 1, "xmm8" 2, "xmm9" 3, "xmm10" 4, "xmm11" 5, "xmm12" 6, "xmm13" 7, "xmm14" 8, "xmm15" 9,
    );
    assert_eq!(kept, numbers);
}

#[test]
fn other_architectures_are_refused() {
    let builder = robot("arm6").functions([Function::MassMatrix]);
    let options =
        ObjectOptions { instruction_set: InstructionSet::Neon, ..ObjectOptions::default() };
    let error = builder.generate_object(&options).expect_err("no objects for aarch64");
    let message = "object files are made for x86-64, and Neon is an instruction set of aarch64";
    assert!(error.to_string().contains(message), "{error}");
}

/// The sections, symbols and relocations of each format, and that all code between them is
/// instructions.
#[test]
fn all_formats_can_be_read() {
    let functions = [Function::ForwardDynamics, Function::Jacobian, Function::Difference];
    let builder = robot("joint_zoo").functions(functions).runtime_gravity();
    for format in ObjectFormat::ALL {
        for instruction_set in sets_of_x86_64() {
            let mut options = ObjectOptions::default();
            (options.format, options.instruction_set) = (format, instruction_set);
            options.prefix = Some("zoo".into());
            let made = builder.generate_object(&options).expect("an object");
            let file = object::File::parse(&*made.bytes).expect("an object file");
            assert_eq!(file.architecture(), object::Architecture::X86_64);
            let underscore = if format == ObjectFormat::MachO { "_" } else { "" };
            let symbols: BTreeMap<String, u64> = file
                .symbols()
                .filter(|symbol| symbol.is_global() && symbol.is_definition())
                .map(|symbol| (symbol.name().expect("a name").to_owned(), symbol.address()))
                .collect();
            assert_eq!(
                file.symbols()
                    .filter(ObjectSymbol::is_undefined)
                    .filter(|s| !s.name().unwrap_or("").is_empty())
                    .count(),
                0
            );
            let names = [
                "forward_dynamics",
                "forward_dynamics_with",
                "jacobian",
                "difference",
                "is_supported",
                "default_parameters",
            ];
            assert_eq!(symbols.len(), names.len(), "{symbols:?}");
            let text = file
                .sections()
                .find(|section| section.kind() == object::SectionKind::Text)
                .expect("code");
            // No place of the code changes when it is linked.
            assert_eq!(text.relocations().count(), 0);
            let code = text.data().expect("bytes");
            for name in names {
                let start = symbols[&format!("{underscore}zoo_{name}")] as usize;
                if name == "default_parameters" {
                    assert_eq!(code[start..][..24].len(), 24);
                    continue;
                }
                let decoder =
                    Decoder::with_ip(64, &code[start..], start as u64, DecoderOptions::NONE);
                for instruction in decoder {
                    assert_ne!(instruction.code(), Code::INVALID, "{format:?} {name}");
                    if instruction.flow_control() == FlowControl::Return {
                        break;
                    }
                }
            }
            let relocations = |name: &str| {
                let section = file.section_by_name(name).expect("a section");
                section.relocations().count()
            };
            match format {
                ObjectFormat::Elf => {
                    assert!(relocations(".eh_frame") > 8);
                    assert!(file.section_by_name(".note.GNU-stack").is_some());
                }
                ObjectFormat::Coff => {
                    let table = file.section_by_name(".pdata").expect("a table");
                    assert_eq!(relocations(".pdata") as u64, table.size() / 4);
                    assert!(relocations(".pdata") > 3 * 8);
                }
                ObjectFormat::MachO => {}
            }
            assert!(made.static_library().expect("a library").starts_with(b"!<arch>\n"));
        }
    }
}

/// Undoes the frame of each function by its unwind codes, in the way that Windows does, and finds
/// the registers where the code has stored them.
#[test]
fn unwind_codes_describe_the_code() {
    let functions = [Function::ForwardDynamics, Function::LinkPoses, Function::Jacobian];
    // A function with few arrays of arguments, and one with seven.
    let members = [Function::ForwardDynamicsJvp, Function::StepRk4];
    let fused = members.into_iter().fold(FusedFunction::new("displaced"), FusedFunction::function);
    let builder = robot("arm6").functions(functions).fused([fused]);
    let planning = builder.plan().expect("good");
    for instruction_set in sets_of_x86_64() {
        let planned =
            text::<f64>(&planning.plan, &planning.model, instruction_set, Convention::Windows);
        let text = planned.expect("code");
        for frame in &text.frames {
            let Some(bytes) = unwind_information(frame) else {
                assert!(matches!(frame.kind, FrameKind::Leaf));
                continue;
            };
            // The stores of the prologue, relative to the value of rsp at the entry: pushes, and
            // moves below rbp.
            let mut rsp = 0_i64;
            let mut rbp = None;
            let mut stored: BTreeMap<String, i64> = BTreeMap::new();
            let prologue = usize::from(bytes[1]);
            let code = &text.code[frame.start..][..prologue];
            let decoder = Decoder::with_ip(64, code, frame.start as u64, DecoderOptions::NONE);
            for instruction in decoder {
                let name = format!("{:?}", instruction.mnemonic());
                let operand = format!("{:?}", instruction.op0_register());
                match name.as_str() {
                    "Push" => {
                        rsp -= 8;
                        stored.insert(operand, rsp);
                    }
                    "Mov" if operand == "RBP" => rbp = Some(rsp),
                    "Movups" => {
                        let at = rbp.expect("a frame pointer")
                            + instruction.memory_displacement64() as i64;
                        stored.insert(format!("{:?}", instruction.op1_register()), at);
                    }
                    _ => {}
                }
            }
            let rbp = rbp.expect("a frame pointer");
            // Windows' way back: the codes in their order, from the frame pointer.
            let base = rbp - 16 * i64::from(bytes[3] >> 4);
            assert_eq!(bytes[3] & 15, 5);
            let mut offsets: BTreeMap<String, i64> = BTreeMap::new();
            let mut rsp = base;
            let codes: Vec<[u8; 2]> = bytes[4..][..2 * usize::from(bytes[2])]
                .chunks_exact(2)
                .map(|c| [c[0], c[1]])
                .collect();
            let names = ["RAX", "RCX", "RDX", "RBX", "RSP", "RBP", "RSI", "RDI"];
            let general = |number: usize| {
                names.get(number).map_or_else(|| format!("R{number}"), |&name| name.into())
            };
            let mut k = 0;
            let mut after = u8::MAX;
            while k < codes.len() {
                let [offset, code] = codes[k];
                assert!(offset <= after && usize::from(offset) <= prologue);
                after = offset;
                let operation = code & 15;
                let operand = usize::from(code >> 4);
                let more = codes.get(k + 1).map_or(0, |more| i64::from(u16::from_le_bytes(*more)));
                let mut used = 1;
                match operation {
                    0 => {
                        offsets.insert(general(operand), rsp);
                        rsp += 8;
                    }
                    1 => (rsp, used) = (rsp + 8 * more, 2),
                    2 => rsp += 8 * operand as i64 + 8,
                    3 => rsp = base,
                    4 => {
                        offsets.insert(general(operand), base + 8 * more);
                        used = 2;
                    }
                    8 => {
                        offsets.insert(format!("XMM{operand}"), base + 16 * more);
                        used = 2;
                    }
                    other => panic!("{other}"),
                }
                k += used;
            }
            // The return address is next.
            assert_eq!(rsp, 0);
            assert_eq!(offsets, stored);
        }
    }
}
