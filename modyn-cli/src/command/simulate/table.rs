//! A motion as a table.

use std::error::Error;

use csv::Writer;
use modyn_runtime::model::Model;

use super::dynamics::Sample;
use super::motion::Motion;
use super::units;
use crate::command::outcome::Failure;
use crate::escape::cell;

/// Returns the motion as CSV, with units in the header.
pub fn of(model: &Model, motion: &Motion) -> Result<String, Failure> {
    write(model, motion)
        .map_err(|error| Failure::usage(format!("error: the table cannot be written: {error}")))
}

fn write(model: &Model, motion: &Motion) -> Result<String, Box<dyn Error>> {
    let mut writer = Writer::from_writer(Vec::new());
    let q = units::coordinates(model);
    let v = units::velocities(model);
    let mut head = vec![String::from("time (s)")];
    let names = model.coordinate_names();
    head.extend(names.iter().zip(&q).map(|(name, kind)| format!("{name} ({})", kind.coordinate())));
    let names = model.velocity_names();
    let velocities = names.iter().zip(&v);
    head.extend(
        velocities.clone().map(|(name, kind)| format!("rate {name} ({})", kind.velocity())),
    );
    head.extend(velocities.map(|(name, kind)| format!("tau {name} ({})", kind.torque())));
    head.extend(["kinetic (J)", "potential (J)", "work (J)", "dissipated (J)"].map(String::from));
    writer.write_record(head.iter().map(|name| cell(name)))?;
    for Sample { time, q, qd, tau, kinetic, potential, work, dissipated, .. } in &motion.samples {
        let numbers = [&[*time][..], q, qd, tau, &[*kinetic, *potential, *work, *dissipated]];
        writer.write_record(numbers.concat().iter().map(ToString::to_string))?;
    }
    Ok(String::from_utf8(writer.into_inner()?)?)
}
