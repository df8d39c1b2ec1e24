//! Draws a motion as small plots: one for each coordinate, velocity and torque, and one for the
//! energies.

use std::fmt::Write as _;

use modyn_runtime::model::Model;

use super::dynamics::Sample;
use super::motion::Motion;
use super::units::{self, Kind};
use crate::command::numbers::four_digits;
use crate::escape::{markup, shortened};

/// The colours of the curves, which colour-blind readers can distinguish, too (Okabe and Ito).
const COLORS: [&str; 5] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#1d2733"];
const INK: &str = "#1d2733";
const GREY: &str = "#66717e";
const GRID: &str = "#e3e7eb";

/// The largest number of points of a curve; more points cannot be distinguished.
const POINTS: usize = 500;
/// The largest magnitude that is drawn.
const MAX_VALUE: f64 = 1e100;

const WIDTH: f64 = 1280.0;
const MARGIN: f64 = 36.0;
/// The width of the values at an axis.
const LABELS: f64 = 52.0;
const PANEL: f64 = 130.0;
const GAP: (f64, f64) = (18.0, 34.0);
const HEADING: f64 = 58.0;
/// The largest number of panels in a row.
const MAX_COLUMNS: usize = 6;
/// The height of the panel of energies, and the width of their names.
const ENERGIES: (f64, f64) = (220.0, 130.0);

/// The panels of one quantity, which share their axes.
struct Block {
    title: String,
    color: &'static str,
    panels: Vec<(String, Vec<f64>)>,
}

/// Returns the plots as SVG: coordinates, velocities, torques if any is nonzero, and energies.
pub fn of(model: &Model, motion: &Motion) -> String {
    let step = motion.samples.len().div_ceil(POINTS).max(1);
    let last = motion.samples.len() - 1;
    let kept = motion.samples.iter().enumerate().filter(|(i, _)| i % step == 0 || *i == last);
    let samples: Vec<&Sample> = kept.map(|(_, sample)| sample).collect();
    let times: Vec<f64> = samples.iter().map(|sample| sample.time).collect();
    let end = times.last().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);

    let mut body = String::new();
    let mut top = MARGIN + 46.0;
    for block in blocks(model, &samples) {
        top = draw_block(&mut body, &block, &times, end, top);
    }
    let energies = energies(&samples);
    if !energies.is_empty() {
        top = draw_energies(&mut body, &energies, &times, end, top);
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {top:.0}\" \
         width=\"{WIDTH}\" height=\"{top:.0}\" \
         font-family=\"Helvetica, Arial, sans-serif\" fill=\"{INK}\" role=\"img\">\n\
         <title>A motion of {name}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"{MARGIN}\" y=\"{:.1}\" font-size=\"26\" font-weight=\"bold\">{name}</text>\n{body}</svg>\n",
        MARGIN + 12.0,
        name = markup(model.name()),
    )
}

fn blocks(model: &Model, samples: &[&Sample]) -> Vec<Block> {
    let q = units::coordinates(model);
    let v = units::velocities(model);
    let coordinates = model.coordinate_names();
    let velocities = model.velocity_names();
    let mut curves = vec![
        Curves {
            title: "coordinates",
            color: COLORS[0],
            names: &coordinates,
            kinds: &q,
            unit: Kind::coordinate,
            values: |sample| &sample.q,
        },
        Curves {
            title: "velocities",
            color: COLORS[1],
            names: &velocities,
            kinds: &v,
            unit: Kind::velocity,
            values: |sample| &sample.qd,
        },
    ];
    if samples.iter().any(|sample| sample.tau.iter().any(|&tau| tau != 0.0)) {
        curves.push(Curves {
            title: "torques",
            color: COLORS[2],
            names: &velocities,
            kinds: &v,
            unit: Kind::torque,
            values: |sample| &sample.tau,
        });
    }
    curves.iter().flat_map(|curves| curves.grouped(samples)).collect()
}

/// The entries of a joint vector over time.
struct Curves<'a> {
    title: &'static str,
    color: &'static str,
    /// For each entry its name.
    names: &'a [String],
    /// For each entry its kind, which its unit follows from.
    kinds: &'a [Kind],
    unit: fn(Kind) -> &'static str,
    values: fn(&Sample) -> &[f64],
}

impl Curves<'_> {
    /// Returns the entries, grouped by unit.
    fn grouped(&self, samples: &[&Sample]) -> Vec<Block> {
        let panel = |i: usize| {
            let values = samples.iter().map(|sample| (self.values)(sample)[i]);
            (self.names[i].clone(), values.collect())
        };
        let block = |kind: Kind| {
            let entries = (0..self.names.len()).filter(|&i| self.kinds[i] == kind);
            Block {
                title: format!("{} ({})", self.title, (self.unit)(kind)),
                color: self.color,
                panels: entries.map(panel).collect(),
            }
        };
        let blocks = [Kind::Angle, Kind::Displacement, Kind::Quaternion].map(block);
        blocks.into_iter().filter(|block| !block.panels.is_empty()).collect()
    }
}

/// Returns the names and values of the energies that are not always zero.
fn energies(samples: &[&Sample]) -> Vec<(String, Vec<f64>)> {
    let curve = |name: &str, get: fn(&Sample) -> f64| {
        (name.to_owned(), samples.iter().map(|sample| get(sample)).collect::<Vec<f64>>())
    };
    let mut curves = vec![
        curve("kinetic", |s| s.kinetic),
        curve("potential", |s| s.potential),
        curve("work of torques", |s| s.work),
        curve("dissipated", |s| s.dissipated),
        curve("balance", Sample::balance),
    ];
    curves.retain(|(_, values)| values.iter().any(|&x| x != 0.0));
    curves
}

/// A rectangle of the picture, and the intervals of its axes.
struct Axes {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    end: f64,
    low: f64,
    high: f64,
}

impl Axes {
    fn x(&self, time: f64) -> f64 {
        self.left + self.width * time / self.end
    }

    fn y(&self, value: f64) -> f64 {
        self.top + self.height * (self.high - value) / (self.high - self.low)
    }

    /// Draws the grid, with the values at the left if `values`, and the times below if `times`.
    fn draw(&self, out: &mut String, values: bool, times: bool) {
        let &Self { left, top, width, height, end, low, high } = self;
        let right = left + width;
        let bottom = top + height;
        for value in ticks(low, high, 4) {
            let y = self.y(value);
            let _ = writeln!(out, "<path d=\"M{left:.1} {y:.1}H{right:.1}\" stroke=\"{GRID}\"/>");
            if values {
                let x = left - 7.0;
                let y = y + 4.0;
                let _ = writeln!(
                    out,
                    "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"12\" fill=\"{GREY}\" text-anchor=\"end\">{}</text>",
                    four_digits(value)
                );
            }
        }
        let most = if width > 400.0 { 8 } else { 4 };
        for time in ticks(0.0, end, most) {
            let x = self.x(time);
            let _ = writeln!(out, "<path d=\"M{x:.1} {top:.1}V{bottom:.1}\" stroke=\"{GRID}\"/>");
            if times {
                let y = bottom + 16.0;
                let _ = writeln!(
                    out,
                    "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"12\" fill=\"{GREY}\" text-anchor=\"middle\">{}</text>",
                    four_digits(time)
                );
            }
        }
        let _ = writeln!(
            out,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"none\" \
             stroke=\"{GREY}\" stroke-width=\"0.8\"/>"
        );
    }

    /// Draws a curve; it has gaps at values that cannot be drawn.
    fn curve(&self, out: &mut String, times: &[f64], values: &[f64], color: &str) {
        let points: Vec<Option<(f64, f64)>> = times
            .iter()
            .zip(values)
            .map(|(&time, &value)| drawn(value).then(|| (self.x(time), self.y(value))))
            .collect();
        let path: String =
            points.split(Option::is_none).map(|piece| smooth(piece.iter().flatten())).collect();
        let _ = writeln!(
            out,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\" stroke-linejoin=\"round\" \
             stroke-linecap=\"round\"/>"
        );
    }
}

/// Returns the path of cubic curves through points from left to right. Between two points a curve
/// stays between their heights (Fritsch and Butland 1984), so it shows no peak that was not
/// computed.
fn smooth<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> String {
    let points: Vec<(f64, f64)> = points.copied().collect();
    let secant = |i: usize| (points[i + 1].1 - points[i].1) / (points[i + 1].0 - points[i].0);
    let slope = |i: usize| {
        if i == 0 || i + 1 == points.len() {
            return secant(i.min(points.len() - 2));
        }
        let before = secant(i - 1);
        let after = secant(i);
        if before * after > 0.0 { 2.0 * before * after / (before + after) } else { 0.0 }
    };
    let Some((x, y)) = points.first() else { return String::new() };
    let mut path = format!("M{x:.2} {y:.2}");
    for i in 1..points.len() {
        let (x0, y0) = points[i - 1];
        let (x1, y1) = points[i];
        let third = (x1 - x0) / 3.0;
        let a = y0 + third * slope(i - 1);
        let b = y1 - third * slope(i);
        let _ = write!(path, "C{:.2} {a:.2} {:.2} {b:.2} {x1:.2} {y1:.2}", x0 + third, x1 - third);
    }
    path
}

fn heading(out: &mut String, title: &str, top: f64) {
    let _ = writeln!(
        out,
        "<text x=\"{MARGIN}\" y=\"{:.1}\" font-size=\"17\" font-weight=\"bold\">{title}</text>\n\
         <text x=\"{:.1}\" y=\"{0:.1}\" font-size=\"12\" fill=\"{GREY}\" text-anchor=\"end\">time (s)</text>",
        top + 22.0,
        WIDTH - MARGIN,
    );
}

/// Draws a block of panels below `top`, and returns its lower edge.
fn draw_block(out: &mut String, block: &Block, times: &[f64], end: f64, top: f64) -> f64 {
    heading(out, &block.title, top);
    let count = block.panels.len();
    // The number of columns determines the rows; then the columns are reduced to those that the
    // rows need.
    let rows = count.div_ceil(MAX_COLUMNS);
    let columns = count.div_ceil(rows);
    let width = (WIDTH - 2.0 * MARGIN - LABELS + GAP.0) / columns as f64 - GAP.0;
    let (low, high) = span(block.panels.iter().flat_map(|(_, values)| values));
    for (i, (name, values)) in block.panels.iter().enumerate() {
        let row = i / columns;
        let column = i % columns;
        let axes = Axes {
            left: MARGIN + LABELS + column as f64 * (width + GAP.0),
            top: top + HEADING + row as f64 * (PANEL + GAP.1),
            width,
            height: PANEL,
            end,
            low,
            high,
        };
        axes.draw(out, column == 0, i + columns >= count);
        axes.curve(out, times, values, block.color);
        // A letter is about 7 units wide.
        let longest = (width / 7.0) as usize;
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"13\">{}</text>",
            axes.left,
            axes.top - 7.0,
            markup(&shortened(name, longest)),
        );
    }
    top + HEADING + rows as f64 * (PANEL + GAP.1) + 6.0
}

/// Draws the energies in one panel, with the name of each curve at its end.
fn draw_energies(
    out: &mut String,
    curves: &[(String, Vec<f64>)],
    times: &[f64],
    end: f64,
    top: f64,
) -> f64 {
    heading(out, "energies (J)", top);
    let (low, high) = span(curves.iter().flat_map(|(_, values)| values));
    let left = MARGIN + LABELS;
    let width = WIDTH - MARGIN - left - ENERGIES.1;
    let axes = Axes { left, top: top + HEADING - 18.0, width, height: ENERGIES.0, end, low, high };
    axes.draw(out, true, true);
    let mut names: Vec<(f64, &str, &str)> = Vec::new();
    for ((name, values), color) in curves.iter().zip(COLORS) {
        axes.curve(out, times, values, color);
        let last = values.iter().rev().find(|x| drawn(**x)).map_or(high, |&x| x);
        names.push((axes.y(last) + 4.0, name, color));
    }
    // Names that would overlap move down.
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = f64::MIN;
    for (y, name, color) in names {
        let y = y.max(free);
        free = y + 16.0;
        let x = left + width + 8.0;
        let _ = writeln!(
            out,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"13\" fill=\"{color}\">{name}</text>"
        );
    }
    axes.top + ENERGIES.0 + GAP.1 + 8.0
}

/// Returns the interval of an axis with a margin, also for values that are constant, or zero within
/// rounding.
fn span<'a>(values: impl Iterator<Item = &'a f64>) -> (f64, f64) {
    let (low, high) =
        values.filter(|x| drawn(**x)).fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    let size = high.abs().max(low.abs());
    let room = if size < 1e-9 { 1.0 } else { ((high - low) * 0.08).max(size * 0.02) };
    (low - room, high + room)
}

/// Returns at most `most` + 1 round values between `low` and `high`.
fn ticks(low: f64, high: f64, most: usize) -> Vec<f64> {
    let least = (high - low) / most as f64;
    let power = 10.0_f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    let step = steps.into_iter().find(|&step| step >= least * (1.0 - 1e-9)).unwrap_or(steps[3]);
    let first = (low / step).ceil();
    // If the spacing of floating-point numbers is wider than the steps, there is nothing to mark.
    let count = ((high / step).floor() - first).clamp(0.0, most as f64) as u32;
    let tick = |i: u32| (first + f64::from(i)) * step;
    let ticks = (0..=count).map(tick).map(|x| if x.abs() < step * 1e-9 { 0.0 } else { x });
    // Rounding may move the first or the last value outside.
    ticks.filter(|x| (low..=high).contains(x)).collect()
}

/// Returns whether a value can be drawn.
fn drawn(x: f64) -> bool {
    x.abs() < MAX_VALUE
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the heights of the end points and of the control points.
    fn heights(path: &str) -> Vec<f64> {
        let numbers = path.split(['M', 'C', ' ']).filter(|text| !text.is_empty());
        numbers.skip(1).step_by(2).map(|text| text.parse().expect("a number")).collect()
    }

    #[test]
    fn curves_pass_through_their_points_and_do_not_overshoot() {
        let points = [(0.0, 0.0), (1.0, 0.0), (2.0, 5.0), (3.0, 1.0), (4.0, 0.5)];
        let heights = heights(&smooth(points.iter()));
        assert_eq!(heights.len(), 1 + 3 * 4);
        for (i, pair) in points.windows(2).enumerate() {
            let low = pair[0].1.min(pair[1].1);
            let high = pair[0].1.max(pair[1].1);
            let between = &heights[3 * i..3 * i + 4];
            assert!((between[0] - pair[0].1).abs() < 0.01 && (between[3] - pair[1].1).abs() < 0.01);
            assert!(
                between.iter().all(|y| (low - 0.01..=high + 0.01).contains(y)),
                "{i}: {between:?}"
            );
        }
        assert_eq!(smooth([(1.0, 2.0)].iter()), "M1.00 2.00");
        assert_eq!(smooth([].iter()), "");
    }

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(ticks(0.0, 2.0, 4), [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(ticks(-0.3, 0.7, 4), [0.0, 0.5]);
        for (low, high) in [(-1e60, 1e60), (1e90, 1.000_000_1e90), (-1.0, 1.0), (1e-300, 1e-299)] {
            let marks = ticks(low, high, 4);
            assert!(marks.len() <= 5, "{marks:?}");
            assert!(marks.iter().all(|x| (low..=high).contains(x)), "{low} {high} {marks:?}");
        }
    }
}
