//! Plots of a motion.

use std::error::Error;

use modyn_codegen::diagnostics::sanitize_for_display;
use modyn_runtime::model::Model;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;

use super::motion::{Motion, Sample};
use super::units::{self, Kind};
use crate::command::numbers::four_digits;
use crate::command::outcome::Failure;

/// Curves that can be distinguished in one panel: by dashes, and by colour (Okabe and Ito).
const CURVES: [(RGBColor, i32, i32); 6] = [
    (RGBColor(0, 0, 0), 1, 0),
    (RGBColor(0, 114, 178), 10, 4),
    (RGBColor(213, 94, 0), 3, 3),
    (RGBColor(0, 158, 115), 16, 5),
    (RGBColor(204, 121, 167), 6, 9),
    (RGBColor(86, 120, 180), 2, 8),
];
const PANEL: (u32, u32) = (640, 300);
/// The largest number of points of a curve; more cannot be seen.
const POINTS: usize = 500;

/// Numbers beyond this magnitude are not drawn.
const MAX_VALUE: f64 = 1e100;

/// A panel with its curves.
struct Panel {
    title: String,
    unit: &'static str,
    curves: Vec<(String, Vec<f64>)>,
}

/// Returns the plots as SVG: coordinates beside velocities, then joint forces and energies.
pub fn of(model: &Model, motion: &Motion) -> Result<String, Failure> {
    let mut text = String::new();
    draw(&mut text, model, motion)
        .map_err(|error| Failure::usage(format!("error: the plots cannot be drawn: {error}")))?;
    Ok(text)
}

fn draw(text: &mut String, model: &Model, motion: &Motion) -> Result<(), Box<dyn Error>> {
    let step = motion.samples.len().div_ceil(POINTS).max(1);
    let last = motion.samples.len() - 1;
    let kept = motion.samples.iter().enumerate().filter(|(i, _)| i % step == 0 || *i == last);
    let samples: Vec<&Sample> = kept.map(|(_, sample)| sample).collect();
    let panels = panels(model, &samples);
    let rows = panels.len().div_ceil(2) as u32;
    let size = (2 * PANEL.0, 40 + rows * PANEL.1);
    let root = SVGBackend::with_string(text, size).into_drawing_area();
    root.fill(&WHITE)?;
    let root = root.titled(&sanitize_for_display(model.name()), ("sans-serif", 24))?;
    for (panel, area) in panels.iter().zip(root.split_evenly((rows as usize, 2))) {
        draw_panel(panel, &samples, &area)?;
    }
    root.present()?;
    Ok(())
}

fn panels(model: &Model, samples: &[&Sample]) -> Vec<Panel> {
    let (q, v) = (units::coordinates(model), units::velocities(model));
    let part = |title: &str, names: &[String], kinds: &[Kind], get: Get, unit: Unit| {
        grouped(title, (names, kinds), samples, get, unit)
    };
    let (coordinates, velocities) = (model.coordinate_names(), model.velocity_names());
    let mut left = part("coordinates", &coordinates, &q, |s| &s.q, Kind::coordinate);
    let mut right = part("velocities", &velocities, &v, |s| &s.qd, Kind::velocity);
    if samples.iter().any(|sample| sample.tau.iter().any(|&tau| tau != 0.0)) {
        left.extend(part("torques", &velocities, &v, |s| &s.tau, Kind::torque));
    }
    let curve = |name: &str, get: fn(&Sample) -> f64| {
        let values: Vec<f64> = samples.iter().map(|sample| get(sample)).collect();
        (String::from(name), values)
    };
    let mut curves = vec![
        curve("kinetic", |s| s.kinetic),
        curve("potential", |s| s.potential),
        curve("balance", Sample::balance),
        curve("work of torques", |s| s.work),
        curve("dissipated", |s| s.dissipated),
    ];
    curves.retain(|(_, values)| values.iter().any(|&x| x != 0.0));
    if !curves.is_empty() {
        right.push(Panel { title: "energies".into(), unit: "J", curves });
    }
    // Two panels in a row as long as both lists last.
    let mut all = Vec::new();
    let (mut left, mut right) = (left.into_iter(), right.into_iter());
    loop {
        match (left.next(), right.next()) {
            (None, None) => return all,
            (a, b) => all.extend(a.into_iter().chain(b)),
        }
    }
}

type Get = fn(&Sample) -> &[f64];
type Unit = fn(Kind) -> &'static str;

/// Returns the panels of entries with the same unit, a few in each.
fn grouped(
    title: &str,
    (names, kinds): (&[String], &[Kind]),
    samples: &[&Sample],
    get: Get,
    unit: Unit,
) -> Vec<Panel> {
    let mut panels = Vec::new();
    for kind in [Kind::Turn, Kind::Shift, Kind::Quaternion] {
        let entries: Vec<usize> = (0..names.len()).filter(|&i| kinds[i] == kind).collect();
        for entries in entries.chunks(CURVES.len()) {
            let curve = |&i: &usize| {
                (
                    sanitize_for_display(&names[i]),
                    samples.iter().map(|sample| get(sample)[i]).collect(),
                )
            };
            let curves = entries.iter().map(curve).collect();
            panels.push(Panel { title: title.into(), unit: unit(kind), curves });
        }
    }
    panels
}

fn draw_panel(
    panel: &Panel,
    samples: &[&Sample],
    area: &DrawingArea<SVGBackend<'_>, Shift>,
) -> Result<(), Box<dyn Error>> {
    let times: Vec<f64> = samples.iter().map(|sample| sample.time).collect();
    let end = times.last().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
    let all = panel.curves.iter().flat_map(|(_, values)| values).filter(|x| drawn(**x));
    let (low, high) = all.fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    let size = high.abs().max(low.abs());
    // A curve that is constant, or zero within rounding, needs a range, too.
    let room = if size < 1e-9 { 1.0 } else { ((high - low) * 0.08).max(size * 0.05) };
    let mut chart = ChartBuilder::on(area)
        .caption(format!("{} ({})", panel.title, panel.unit), ("sans-serif", 16))
        .margin(10)
        .x_label_area_size(36)
        .y_label_area_size(64)
        // The legend is to the right of the curves.
        .build_cartesian_2d(0.0..end * 1.45, low - room..high + room)?;
    chart
        .configure_mesh()
        .x_desc("time (s)")
        .y_desc(panel.unit)
        .x_labels(8)
        .y_labels(6)
        .y_label_formatter(&|y| label(*y))
        .light_line_style(WHITE)
        .draw()?;
    for ((name, values), (color, dash, gap)) in panel.curves.iter().zip(CURVES) {
        let points = times.iter().copied().zip(values.iter().copied()).filter(|(_, x)| drawn(*x));
        let style = color.stroke_width(2);
        let legend =
            move |(x, y)| DashedPathElement::new([(x, y), (x + 36, y)], dash.max(4), gap, style);
        if gap == 0 {
            chart.draw_series(LineSeries::new(points, style))?
        } else {
            chart.draw_series(DashedLineSeries::new(points, dash, gap, style))?
        }
        .label(name)
        .legend(legend);
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .legend_area_size(44)
        .border_style(BLACK.mix(0.3))
        .background_style(WHITE)
        .label_font(("sans-serif", 12))
        .draw()?;
    Ok(())
}

/// Returns whether a number can be drawn: larger ones would need endless axes and dashes.
fn drawn(x: f64) -> bool {
    x.abs() < MAX_VALUE
}

/// Returns the label of an axis; rounding errors of zero are zero.
fn label(y: f64) -> String {
    four_digits(if y.abs() < 1e-12 { 0.0 } else { y })
}
