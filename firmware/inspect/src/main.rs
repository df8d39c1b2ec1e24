//! Proves properties of a linked image, and computes the stack and the code size of its functions.
//!
//! `inspect IMAGE OBJDUMP MEASURED NAME [--no-double] [--loops] [--soft] [--panics]`: reads the symbols and stack sizes of
//! IMAGE, its disassembly by LLVM's OBJDUMP, and the lines that the running image printed; writes rows of a
//! table. Fails if the image has an allocator or a panic. Fails if a robot's function is recursive, has a call whose
//! target is unknown, contains a loop, or took more stack than the computed bound. Fails if the number of instructions
//! differs between states (except states with large angles).
//!
//! - `--no-double`: no function may compute in double precision.
//! - `--loops`: loops over the angles are allowed, as at opt-level "s".
//! - `--soft`: floating-point arithmetic is done by functions, whose instructions depend on the numbers.
//! - `--panics`: the image must contain a panic, which shows that the check finds it.

mod disassembly;
mod graph;

use std::collections::BTreeMap;
use std::error::Error;

use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SymbolKind};

/// The robot whose limbs share code: its functions have loops over the limbs, of fixed lengths.
const SHARED: &str = "legs_shared::";

/// The stack of a measured call besides the function and the closure around it.
const HARNESS: u64 = 64;

/// The dynamics functions, which must be straight-line code. Condition numbers take a fixed number of sweeps, and
/// selecting one link's placement may copy in a loop.
const STRAIGHT: [&str; 4] = ["forward_dynamics", "inverse_dynamics", "mass_matrix", "brge_solve"];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut flag = |name: &str| {
        let found = arguments.iter().position(|argument| argument == name);
        found.map(|at| arguments.remove(at)).is_some()
    };
    let (no_double, loops) = (flag("--no-double"), flag("--loops"));
    let (soft, panics) = (flag("--soft"), flag("--panics"));
    let [image, objdump, measured, name] = arguments.as_slice() else {
        return Err("usage: inspect IMAGE OBJDUMP MEASURED NAME [--no-double] [--loops] [--soft] [--panics]".into());
    };
    let bytes = std::fs::read(image)?;
    let file = object::File::parse(&*bytes)?;
    let names = symbols(&file);
    let mut functions = disassembly::read(objdump, image, &names)?;
    for (address, size) in stack_sizes(&file)? {
        // Bit 0 of a Thumb address marks Thumb code.
        if let Some(function) = functions.get_mut(&(address & !1)) {
            function.frame = size;
            function.frame_known = true;
        }
    }
    let mut faults = Vec::new();
    let all_names = || file.symbols().filter_map(|s| s.name().ok()).map(demangled);
    let found = |what: &dyn Fn(&str) -> bool| all_names().filter(|n| what(n)).collect::<Vec<_>>();
    let panicking = found(&is_panic);
    if panics {
        return if panicking.is_empty() { Err("a panic was not found".into()) } else { Ok(()) };
    }
    faults.extend(panicking.iter().map(|name| format!("panics: {name}")));
    faults.extend(found(&is_allocator).iter().map(|name| format!("allocates: {name}")));
    if no_double {
        faults.extend(found(&is_double).iter().map(|name| format!("double precision: {name}")));
        let double = functions.values().filter(|function| function.double);
        faults.extend(double.map(|function| format!("double precision in {}", function.name)));
    }
    let fused = functions.values().filter(|function| function.fused);
    faults.extend(fused.map(|function| format!("fused multiply-add in {}", function.name)));

    let output = std::fs::read_to_string(measured)?;
    let measured = measurements(&output);
    let closures = functions.values().filter(|function| function.name.contains("::run::"));
    let closures = closures.map(|function| function.frame).max().unwrap_or(0);
    for (&address, function) in &functions {
        let Some(short) = function.name.strip_prefix("image::") else { continue };
        let Some(&Range { least, most: instructions, stack }) = measured.get(short) else {
            continue;
        };
        let walk = match graph::walk(&functions, address) {
            Ok(walk) => walk,
            Err(fault) => {
                faults.push(format!("{short}: {fault}"));
                continue;
            }
        };
        let straight = STRAIGHT.iter().any(|name| short.ends_with(name));
        if function.loops && straight && !loops && !short.starts_with(SHARED) {
            faults.push(format!("{short}: it has a loop"));
        }
        if straight && least != instructions && !soft {
            faults.push(format!("{short}: {least} to {instructions} instructions, by the state"));
        }
        let far = measured.get(&*format!("{short}_far")).copied().unwrap_or_default();
        let (far, most) = (far.most, stack.max(far.stack));
        if most > walk.stack + closures + HARNESS {
            faults
                .push(format!("{short}: took {most} bytes of stack, the bound is {}", walk.stack));
        }
        println!(
            "| {name} | `{short}` | {instructions} | {far} | {most} | {}{} | {} | {} |",
            walk.stack,
            if walk.stack_known { "" } else { "*" },
            function.size,
            walk.flash,
        );
    }
    for name in measured.keys().filter(|name| !name.ends_with("_far")) {
        if !functions.values().any(|function| function.name == format!("image::{name}")) {
            faults.push(format!("{name} is not in the image as a function"));
        }
    }
    if measured.is_empty() {
        faults.push("nothing was measured".into());
    }
    if faults.is_empty() {
        Ok(())
    } else {
        Err(format!("{name}:\n  {}", faults.join("\n  ")).into())
    }
}

/// The measurements of calls at several states.
#[derive(Clone, Copy, Default)]
struct Range {
    least: u64,
    most: u64,
    stack: u64,
}

/// Returns the lines `measured FUNCTION INSTRUCTIONS STACK`, by function.
fn measurements(text: &str) -> BTreeMap<&str, Range> {
    let mut found: BTreeMap<&str, Range> = BTreeMap::new();
    for line in text.lines().filter_map(|line| line.strip_prefix("measured ")) {
        let [name, instructions, stack] = line.split(' ').collect::<Vec<_>>()[..] else { continue };
        let (Ok(instructions), Ok(stack)) = (instructions.parse(), stack.parse()) else { continue };
        let first = Range { least: instructions, ..Range::default() };
        let range = found.entry(name).or_insert(first);
        range.least = range.least.min(instructions);
        range.most = range.most.max(instructions);
        range.stack = range.stack.max(stack);
    }
    found
}

fn demangled(name: &str) -> String {
    format!("{:#}", rustc_demangle::demangle(name))
}

/// The symbols that a panic needs: the formatting machinery, or the handler.
fn is_panic(name: &str) -> bool {
    let parts = ["panicking", "rust_begin_unwind", "panic_fmt", "panic_bounds", "unwrap_failed"];
    parts.iter().any(|part| name.contains(part))
}

fn is_allocator(name: &str) -> bool {
    let parts = ["__rust_alloc", "__rust_realloc", "__rg_", "__rdl_", "alloc::", "alloc_error"];
    parts.iter().any(|part| name.contains(part)) || ["malloc", "free", "sbrk"].contains(&name)
}

/// The functions for arithmetic of `f64`, by their names in Arm's run-time ABI and in libgcc.
fn is_double(name: &str) -> bool {
    let name = name.rsplit("::").next().unwrap_or(name);
    let arm = [
        "__aeabi_d",
        "__aeabi_cd",
        "__aeabi_f2d",
        "__aeabi_i2d",
        "__aeabi_ui2d",
        "__aeabi_l2d",
        "__aeabi_ul2d",
    ];
    // Names of integer division begin like those of doubles.
    arm.iter().any(|start| name.starts_with(start)) || name.starts_with("__") && name.contains("df")
}

/// Returns the functions by address.
fn symbols(file: &object::File<'_>) -> BTreeMap<u64, (String, u64)> {
    file.symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0)
        .filter_map(|s| Some((s.address() & !1, (demangled(s.name().ok()?), s.size()))))
        .collect()
}

/// Returns the sizes of stack frames that the compiler has written: an address and a ULEB128 each.
fn stack_sizes(file: &object::File<'_>) -> Result<Vec<(u64, u64)>, Box<dyn Error>> {
    let Some(section) = file.section_by_name(".stack_sizes") else {
        return Err("there is no section .stack_sizes: build with -Z emit-stack-sizes".into());
    };
    let mut data = section.data()?.iter().copied();
    let mut sizes = Vec::new();
    while let Some(first) = data.next() {
        let mut address = u64::from(first);
        for byte in 1..4 {
            address |= u64::from(data.next().ok_or("half an address")?) << (8 * byte);
        }
        let (mut size, mut shift) = (0, 0);
        loop {
            let byte = data.next().ok_or("half a size")?;
            size |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte & 0x80 == 0 {
                break;
            }
        }
        sizes.push((address, size));
    }
    Ok(sizes)
}
