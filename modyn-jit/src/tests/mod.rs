//! Tests of the instructions: against a disassembler that shares nothing with the encoder.

mod encoding;
