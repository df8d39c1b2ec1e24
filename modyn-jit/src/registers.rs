//! The places of values: registers, slots of the stack frame, arguments, constants and results.
//!
//! Code is one basic block, so the next use of every value is known. If no register is free, the
//! register whose value has the most distant next use is freed (Belady 1966). That value is stored
//! if it has no other place.

use crate::values::{Definition, Value, Values};

/// No register.
pub(crate) const NONE: u8 = u8::MAX;

/// The place of a value in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Home {
    /// None.
    None,
    /// An offset in the slots.
    Slot(u32),
    /// An offset in the results.
    Result(u32),
}

/// The places of all values at one step.
pub(crate) struct Registers<'a> {
    values: &'a Values,
    /// The size of a number in bytes.
    size: usize,
    /// The registers, in the order in which free ones are taken.
    order: &'static [u8],
    /// The value in each register.
    holds: [Option<Value>; 32],
    /// The register of each value.
    register_of: Vec<u8>,
    homes: Vec<Home>,
    /// The steps that read each value, and the number of these that have passed.
    uses: Vec<Vec<u32>>,
    passed: Vec<u32>,
    /// For each vector, the number of its lanes that are values still to be read.
    lanes_left: Vec<u32>,
    /// Free slots, by the logarithm of their size.
    free: [Vec<u32>; 7],
    /// The size of all slots in bytes.
    pub frame: u32,
    /// The step.
    pub position: u32,
}

impl<'a> Registers<'a> {
    /// Returns the state before the first step. `last` are values that are read after the last
    /// step.
    pub fn new(values: &'a Values, size: usize, order: &'static [u8], last: &[Value]) -> Self {
        let n = values.definitions.len();
        let mut uses: Vec<Vec<u32>> = vec![Vec::new(); n];
        let end = values.steps.len() as u32;
        let reads = values.steps.iter().map(|step| values.reads(step)).chain([last.to_vec()]);
        for (position, read) in (0..=end).zip(reads) {
            for value in read {
                let uses = &mut uses[value as usize];
                if uses.last() != Some(&position) {
                    uses.push(position);
                }
            }
        }
        let mut lanes_left = vec![0; n];
        for (definition, uses) in values.definitions.iter().zip(&uses) {
            if let (Definition::Lane(vector, _), false) = (definition, uses.is_empty()) {
                lanes_left[*vector as usize] += 1;
            }
        }
        Self {
            values,
            size,
            order,
            holds: [None; 32],
            register_of: vec![NONE; n],
            homes: vec![Home::None; n],
            uses,
            passed: vec![0; n],
            lanes_left,
            free: Default::default(),
            frame: 0,
            position: 0,
        }
    }

    /// Returns the size of a value in bytes.
    pub fn bytes(&self, value: Value) -> usize {
        usize::from(self.values.lanes[value as usize]) * self.size
    }

    /// Returns the register of a value, or [`NONE`].
    pub fn register(&self, value: Value) -> u8 {
        self.register_of[value as usize]
    }

    /// Returns the place of a value in memory.
    pub fn home(&self, value: Value) -> Home {
        self.homes[value as usize]
    }

    /// Returns the next step that reads the value, this step or a later one.
    fn next_use(&self, value: Value) -> Option<u32> {
        let v = value as usize;
        self.uses[v].get(self.passed[v] as usize).copied()
    }

    /// Returns the number of steps until a value is read again after this step.
    pub fn distance(&self, value: Value) -> Option<u32> {
        self.next_use(value).map(|next| next - self.position)
    }

    /// Returns whether no later step reads the value.
    pub fn dies(&self, value: Value) -> bool {
        self.next_use(value).is_none()
    }

    /// Returns whether later steps read lanes of the value from memory.
    pub fn has_lanes(&self, value: Value) -> bool {
        self.lanes_left[value as usize] > 0
    }

    /// Goes to a step and past its reads.
    pub fn advance(&mut self, position: u32, reads: &[Value]) {
        self.position = position;
        for &value in reads {
            while self.next_use(value).is_some_and(|next| next <= position) {
                self.passed[value as usize] += 1;
            }
        }
    }

    /// Returns the registers that hold values, as bits.
    pub fn occupied(&self) -> u32 {
        let occupied = self.holds.iter().enumerate().filter(|(_, value)| value.is_some());
        occupied.fold(0, |all, (register, _)| all | 1 << register)
    }

    /// Returns the registers of these values.
    pub fn pinned(&self, values: &[Value]) -> u32 {
        let registers = values.iter().map(|&value| self.register(value));
        registers.filter(|&register| register != NONE).fold(0, |all, register| all | 1 << register)
    }

    /// Returns a free register that is not pinned.
    pub fn unoccupied(&self, pinned: u32) -> Option<u8> {
        let taken = self.occupied() | pinned;
        self.order.iter().copied().find(|&register| taken >> register & 1 == 0)
    }

    /// Returns the register whose value has the most distant next use, and the value.
    ///
    /// # Panics
    ///
    /// If all registers are pinned.
    pub fn furthest(&self, pinned: u32) -> (u8, Value) {
        let registers = self.order.iter().copied();
        let unpinned = registers.filter(|&register| pinned >> register & 1 == 0);
        let occupied =
            unpinned.filter_map(|register| Some((register, self.holds[usize::from(register)]?)));
        let next = |value| self.next_use(value).unwrap_or(u32::MAX);
        occupied.max_by_key(|&(_, value)| next(value)).expect("no instruction reads all registers")
    }

    /// Returns whether a value would be lost with its register.
    pub fn is_only_in_register(&self, value: Value) -> bool {
        let computed = matches!(self.values.definitions[value as usize], Definition::Result(..));
        computed && self.home(value) == Home::None
    }

    /// Records that a register holds a value.
    pub fn hold(&mut self, register: u8, value: Value) {
        self.holds[usize::from(register)] = Some(value);
        self.register_of[value as usize] = register;
    }

    /// Records that a value is in no register.
    pub fn evict(&mut self, value: Value) {
        let register = self.register(value);
        if register != NONE {
            self.holds[usize::from(register)] = None;
            self.register_of[value as usize] = NONE;
        }
    }

    /// Gives a value its own slot.
    pub fn give_slot(&mut self, value: Value) -> u32 {
        let bytes = self.bytes(value).next_power_of_two() as u32;
        let slot = self.free[bytes.trailing_zeros() as usize].pop().unwrap_or_else(|| {
            self.frame = self.frame.next_multiple_of(bytes) + bytes;
            self.frame - bytes
        });
        self.homes[value as usize] = Home::Slot(slot);
        slot
    }

    /// Records that a value is among the results.
    pub fn stored(&mut self, value: Value, distance: u32) {
        if self.home(value) == Home::None {
            self.homes[value as usize] = Home::Result(distance);
        }
    }

    /// Frees the memory of a value.
    pub fn forget_home(&mut self, value: Value) {
        if let Home::Slot(slot) = self.home(value) {
            let bytes = self.bytes(value).next_power_of_two();
            self.free[bytes.trailing_zeros() as usize].push(slot);
        }
        self.homes[value as usize] = Home::None;
    }

    /// Frees the places of the values that no later step reads.
    pub fn drop_dead(&mut self, values: &[Value]) {
        for &value in values {
            if self.dies(value) {
                self.drop(value);
            }
        }
    }

    /// Frees the places of a value after its last read, and of the vector whose last lane it was.
    pub fn drop(&mut self, value: Value) {
        self.evict(value);
        let vector = match self.values.definitions[value as usize] {
            Definition::Lane(vector, _) => {
                self.lanes_left[vector as usize] -= 1;
                vector
            }
            Definition::Result(..) => value,
            Definition::Constant(_) | Definition::Argument { .. } => return,
        };
        if !self.has_lanes(vector) && self.dies(vector) {
            self.forget_home(vector);
        }
    }
}
