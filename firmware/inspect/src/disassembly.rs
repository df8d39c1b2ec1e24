//! The functions of a disassembly: the functions that they call, and their stack frames.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error;
use std::process::Command;

/// A function of the image.
#[derive(Debug, Default)]
pub struct Function {
    pub name: String,
    /// The bytes of its code and of the constants in between.
    pub size: u64,
    /// The bytes of its stack frame.
    pub frame: u64,
    /// Whether the compiler gave the frame's size; otherwise it is computed from the instructions that change the stack
    /// pointer.
    pub frame_known: bool,
    /// The functions that it calls or jumps to.
    pub calls: BTreeSet<u64>,
    /// Whether it calls through a register.
    pub indirect: bool,
    /// Whether it jumps back within itself.
    pub loops: bool,
    /// Whether an instruction computes in double precision.
    pub double: bool,
    /// Whether an instruction multiplies and adds with one rounding.
    pub fused: bool,
}

/// Returns all functions, by address.
pub fn read(
    objdump: &str,
    image: &str,
    symbols: &BTreeMap<u64, (String, u64)>,
) -> Result<BTreeMap<u64, Function>, Box<dyn Error>> {
    let output = Command::new(objdump).args(["-d", "--no-show-raw-insn", image]).output()?;
    if !output.status.success() {
        return Err(format!("{objdump} failed: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    let mut functions: BTreeMap<u64, Function> = symbols
        .iter()
        .map(|(&address, (name, size))| {
            (address, Function { name: name.clone(), size: *size, ..Function::default() })
        })
        .collect();
    let text = String::from_utf8(output.stdout)?;
    // Lines such as `00001234 <name>:`.
    let named = |line: &'_ str| -> Option<(usize, u64)> {
        let (address, name) = line.strip_suffix(">:")?.split_once(" <")?;
        Some((name.len(), u64::from_str_radix(address, 16).ok()?))
    };
    let names: BTreeMap<&str, u64> = text
        .lines()
        .filter_map(|line| {
            named(line).map(|(length, at)| (&line[line.len() - 2 - length..line.len() - 2], at))
        })
        .collect();
    for line in text.lines() {
        let Some((address, instruction)) = line.split_once(':') else { continue };
        let Ok(address) = u64::from_str_radix(address.trim(), 16) else { continue };
        let Some((&start, function)) = functions.range_mut(..=address).next_back() else {
            continue;
        };
        if address < start + function.size {
            function.take(start, address, instruction.trim(), &names);
        }
    }
    Ok(functions)
}

impl Function {
    fn take(&mut self, start: u64, address: u64, instruction: &str, names: &BTreeMap<&str, u64>) {
        let (mnemonic, operands) = instruction.split_once(['\t', ' ']).unwrap_or((instruction, ""));
        let operands = operands.trim();
        self.double |= mnemonic.contains(".f64");
        let fused = ["vfma", "vfms", "vfnma", "vfnms", "fmadd", "fmsub", "fnmadd", "fnmsub"];
        self.fused |= fused.iter().any(|name| mnemonic.starts_with(name));
        self.frame += taken(mnemonic, operands);
        // A jump's target is in hexadecimal before the symbol's name. For a jump through a register it is the name that
        // the preceding instruction has loaded.
        let branch = mnemonic.starts_with(['b', 'j', 'c', 't']) && !mnemonic.starts_with("bic");
        let target = operands.split_once('<').and_then(|(before, name)| {
            let number = before.rsplit_once("0x").map(|(_, number)| number.trim());
            let number = number.and_then(|number| u64::from_str_radix(number, 16).ok());
            number.or_else(|| names.get(name.trim_end_matches('>')).copied())
        });
        match target {
            Some(target) if branch => {
                if (start..start + self.size).contains(&target) {
                    self.calls.extend((target == start).then_some(start));
                    self.loops |= target <= address;
                } else {
                    self.calls.insert(target);
                }
            }
            // A jump through a register that holds no return address is a tail call.
            _ => {
                let through = matches!(mnemonic, "blx" | "jalr" | "c.jalr");
                let at_the_end = match mnemonic {
                    "bx" => operands != "lr",
                    "jr" | "c.jr" => operands != "ra",
                    _ => false,
                };
                self.indirect |= through || at_the_end;
            }
        }
    }
}

/// Returns the bytes that an instruction subtracts from the stack pointer.
fn taken(mnemonic: &str, operands: &str) -> u64 {
    let number = |text: &str| -> u64 {
        let text = text.trim().trim_start_matches(['#', '-']);
        match text.strip_prefix("0x") {
            Some(digits) => u64::from_str_radix(digits, 16).unwrap_or(0),
            None => text.parse().unwrap_or(0),
        }
    };
    let registers = operands.matches(',').count() as u64 + 1;
    let last = operands.split('@').next().unwrap_or("").rsplit(',').next().unwrap_or("");
    match mnemonic.trim_end_matches(".w") {
        "push" => 4 * registers,
        "vpush" => (if operands.contains('d') { 8 } else { 4 }) * registers,
        "sub" | "subw" if operands.starts_with("sp") => number(last),
        "stmdb" if operands.starts_with("sp!") => 4 * (registers - 1),
        "addi" | "c.addi16sp" if operands.starts_with("sp") && last.contains('-') => number(last),
        "str" if operands.contains("[sp, #-") => number(last.trim_end_matches(['!', ']'])),
        _ => 0,
    }
}
