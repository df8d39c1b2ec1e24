//! The compiler as a library: a URDF to the text of its Rust, with what it costs.
//!
//! `cargo run -p modyn-codegen --example generate -- robots/humanoid.urdf > humanoid.rs`

use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: generate ROBOT.urdf")?;
    let urdf = std::fs::read_to_string(&path)?;
    let start = Instant::now();
    let generated = modyn_codegen::Builder::new().urdf_text(urdf, path).generate()?;
    let elapsed = start.elapsed();
    println!("{}", generated.text);
    for warning in &generated.warnings {
        eprintln!("{warning}");
    }
    for (quantity, count) in &generated.operations {
        eprintln!("{quantity}: {count}");
    }
    for (partition, operations) in &generated.partition_costs {
        eprintln!("forward dynamics with {partition}: {operations} operations");
    }
    eprintln!("{} bytes in {:.1} ms", generated.text.len(), elapsed.as_secs_f64() * 1e3);
    Ok(())
}
