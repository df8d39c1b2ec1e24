//! Calls of helpers, and of the form for rows of any rank.

use super::Encoder;
use super::encode::{Place, RSP};
use super::frame::{RDI, RDX, RSI, point};
use crate::generate::Generator;
use crate::generate::architecture::Address;
use crate::helper::{Helper, Linkage};
use crate::instruction_set::InstructionSet;

impl Generator<'_, Encoder> {
    /// Writes a call of another function with this one's arguments and results, and returns the
    /// position of its distance.
    pub(super) fn call_again(&mut self) -> usize {
        self.encoder.general(0x8b, RDI, RSP, 0);
        self.encoder.general(0x8b, RSI, RSP, 8);
        // call
        self.encoder.bytes(&[0xe8, 0, 0, 0, 0]);
        self.encoder.code.len() - 4
    }

    /// Writes the load of an address.
    fn address(&mut self, register: u8, address: Address) {
        if let Place::Memory(base, distance) = self.place(address) {
            self.encoder.general(0x8d, register, base, distance);
        }
    }

    /// Writes a call of a helper, and restores the registers that point to memory.
    pub(super) fn call_helper(&mut self, helper: Helper, pointers: [Address; 3], lanes: u8) {
        let [results, more, arguments] = pointers;
        // The angles of a reduction are first: they may be an argument, whose base register the
        // others overwrite.
        self.address(RDX, arguments);
        self.address(RDI, results);
        self.address(RSI, more);
        // mov ecx, lanes
        self.encoder.bytes(&[&[0xb9][..], &u32::from(lanes).to_le_bytes()].concat());
        if self.instruction_set != InstructionSet::Sse2 {
            // vzeroupper
            self.encoder.bytes(&[0xc5, 0xf8, 0x77]);
        }
        match self.linkage {
            Linkage::Addresses(helpers) => {
                // mov rax, helper; call rax
                let address = helpers.address(helper);
                self.encoder.bytes(&[&[0x48, 0xb8][..], &address.to_le_bytes()].concat());
                self.encoder.bytes(&[0xff, 0xd0]);
            }
            Linkage::Relative => {
                // call helper
                self.encoder.bytes(&[0xe8, 0, 0, 0, 0]);
                self.calls.push((self.encoder.code.len() - 4, helper));
            }
        }
        let arrays = self.arrays;
        let frame = self.frame_base();
        point(&mut self.encoder, arrays, frame);
    }
}
