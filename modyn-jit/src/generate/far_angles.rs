//! Angles that are too large for the fast reduction: the comparison that finds them, and the code
//! after the return that reduces them.

use super::Generator;
use super::architecture::{Address, Architecture};
use crate::helper::Helper;
use crate::registers::NONE;
use crate::values::FarCheck;

/// Instructions outside of the straight path.
pub(super) struct SlowPath {
    /// The position of the jump to them.
    from: usize,
    /// The position after it.
    back: usize,
    /// The registers that hold values.
    occupied: u32,
    /// The places of each angle, its reduction and the number with the multiple's lowest bit; and
    /// the number of lanes.
    angles: Vec<([Address; 3], u8)>,
}

impl<A: Architecture> Generator<'_, A> {
    /// Compares the angles with the limit, and jumps to the code after the return if one is too
    /// large.
    pub(super) fn check(&mut self, check: &FarCheck) {
        let FarCheck { squares, limit, angles } = check;
        let from = A::jump_unless_less(self, [*squares, *limit]);
        let back = self.encoder.position();
        self.registers.drop_dead(&[*squares, *limit]);
        let places = angles.iter().map(|reduced| {
            let all = [reduced.angle, reduced.results[0], reduced.results[1]];
            let places = all.map(|value| match self.registers.register(value) {
                NONE => self.memory(value),
                register => self.saved(register),
            });
            (places, self.lanes(reduced.angle))
        });
        let angles_in_places = places.collect();
        let occupied = self.registers.occupied();
        self.slow_paths.push(SlowPath { from, back, occupied, angles: angles_in_places });
        for reduced in angles {
            for value in reduced.results {
                // The code after the return changes it in memory.
                if self.registers.register(value) != NONE {
                    self.registers.forget_home(value);
                }
            }
            let [r, turns] = reduced.results;
            self.registers.drop_dead(&[reduced.angle, r, turns]);
        }
    }

    /// Writes the code that reduces angles that are too large.
    pub(super) fn slow_paths(&mut self) {
        for SlowPath { from, back, occupied, angles } in std::mem::take(&mut self.slow_paths) {
            let start = self.encoder.position();
            self.encoder.patch(from, start);
            self.save(occupied);
            for ([angle, reduced, multiple], lanes) in angles {
                A::call(self, Helper::Reduce, [reduced, multiple, angle], lanes);
            }
            self.restore(occupied);
            let jump = self.encoder.jump();
            self.encoder.patch(jump, back);
        }
    }
}
