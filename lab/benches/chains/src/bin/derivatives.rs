//! Measures the derivatives of forward dynamics of robots, as straight-line code and as loops, with warm and with cold caches. Writes a table:
//!
//! `RUSTFLAGS="-C target-cpu=native" cargo run --release --manifest-path lab/benches/chains/Cargo.toml --bin derivatives`

#[macro_use]
#[path = "../robots.rs"]
mod robots;

include!(concat!(env!("OUT_DIR"), "/derivatives.rs"));
