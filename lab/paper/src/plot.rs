//! Line charts as SVG that can be read without colour: every line has its own dashes and markers.

use std::ops::Range;
use std::path::Path;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::prelude::*;

/// A scale with its label and unit.
#[derive(Clone, Copy, Debug)]
pub struct Axis<'a> {
    /// The label, with the unit.
    pub label: &'a str,
    /// Whether it is logarithmic; numbers that are not positive are then left out.
    pub logarithmic: bool,
}

impl<'a> Axis<'a> {
    /// Returns a linear scale.
    #[must_use]
    pub fn linear(label: &'a str) -> Self {
        Self { label, logarithmic: false }
    }

    /// Returns a logarithmic scale.
    #[must_use]
    pub fn logarithmic(label: &'a str) -> Self {
        Self { label, logarithmic: true }
    }

    fn place(self, x: f64) -> f64 {
        if self.logarithmic { x.log10() } else { x }
    }

    /// Returns the places of round numbers within a range of places, which are the ticks.
    fn ticks(self, range: &Range<f64>) -> Vec<f64> {
        let (low, high) = (range.start, range.end);
        if self.logarithmic {
            let exponents = low.floor() as i32..=high.ceil() as i32;
            // At most ten numbers: of each decade 1, 2 and 5, or 1 alone.
            let of_decade: &[f64] = if high - low < 3.3 { &[1.0, 2.0, 5.0] } else { &[1.0] };
            let all =
                exponents.flat_map(|k| of_decade.iter().map(move |x| x.log10() + f64::from(k)));
            return all.filter(|at| range.contains(at)).collect();
        }
        let rough = (high - low) / 10.0;
        let decade = 10f64.powf(rough.log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].map(|x| x * decade).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * decade);
        let steps = (low / step).ceil() as i64..=(high / step).floor() as i64;
        steps.map(|k| k as f64 * step).collect()
    }

    fn text(self, at: f64) -> String {
        // Ticks are sums of steps: a rounding error in place of zero becomes zero.
        let value = if self.logarithmic {
            10f64.powf(at)
        } else if at.abs() < 1e-12 {
            0.0
        } else {
            at
        };
        let digits = if self.logarithmic { 1 } else { 3 };
        let rounded: f64 = format!("{value:.digits$e}").parse().unwrap_or(value);
        if rounded == 0.0 || (1e-3..1e5).contains(&rounded.abs()) {
            rounded.to_string()
        } else {
            format!("{rounded:e}")
        }
    }
}

/// A scale in pixels, with its ticks.
struct Scale {
    range: Range<f64>,
    ticks: Vec<f64>,
}

impl Ranged for Scale {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let part = (value - self.range.start) / (self.range.end - self.range.start);
        from + (part * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // Lines between the ticks are not drawn.
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

/// A line of a chart.
#[derive(Clone, Debug)]
pub struct Line {
    /// The label in the legend.
    pub name: String,
    /// Its points.
    pub points: Vec<(f64, f64)>,
}

impl Line {
    /// Returns a line.
    pub fn new(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { name: name.into(), points: points.into_iter().collect() }
    }
}

/// A chart.
#[derive(Clone, Debug)]
pub struct Chart<'a> {
    /// Its title.
    pub title: &'a str,
    /// The horizontal scale.
    pub x: Axis<'a>,
    /// The vertical scale.
    pub y: Axis<'a>,
    /// Its lines.
    pub lines: Vec<Line>,
}

const SIZE: (u32, u32) = (960, 500);

/// The left end of the legend.
const LEGEND: i32 = 700;

/// The colour of texts and axes. A picture in a page does not know the page's colours, so all of these are seen on dark and on
/// light grounds.
const INK: RGBColor = RGBColor(0x7d, 0x87, 0x94);

const COLOURS: [RGBColor; 6] = [
    INK,
    RGBColor(0xd9, 0x53, 0x4f),
    RGBColor(0x4b, 0x91, 0xd1),
    RGBColor(0x3f, 0xa3, 0x7c),
    RGBColor(0xe8, 0x87, 0x1e),
    RGBColor(0xa0, 0x7f, 0xd6),
];

/// The largest number of markers on a line.
const MARKERS: usize = 14;

/// Dash and gap in pixels, and the two pieces of the line in the legend.
const DASHES: [(i32, i32, [[i32; 2]; 2]); 4] = [
    (1, 0, [[0, 15], [15, 30]]),
    (9, 5, [[0, 9], [21, 30]]),
    (3, 4, [[0, 3], [27, 30]]),
    (14, 3, [[0, 13], [17, 30]]),
];

/// The outlines of the markers in pixels: a ring, a triangle, a cross, a square, a diamond.
const SHAPES: [&[(i32, i32)]; 5] = [
    &[(4, 0), (3, 3), (0, 4), (-3, 3), (-4, 0), (-3, -3), (0, -4), (3, -3), (4, 0)],
    &[(-5, 4), (5, 4), (0, -5), (-5, 4)],
    &[(-4, -4), (4, 4), (0, 0), (-4, 4), (4, -4)],
    &[(-4, -4), (4, -4), (4, 4), (-4, 4), (-4, -4)],
    &[(-5, 0), (0, -5), (5, 0), (0, 5), (-5, 0)],
];

impl Chart<'_> {
    /// Writes the chart to a file.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
        let lines: Vec<Vec<(f64, f64)>> = self.lines.iter().map(|line| self.placed(line)).collect();
        let range = |part: fn(&(f64, f64)) -> f64| {
            let all = || lines.iter().flatten().map(part);
            let (low, high) =
                (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
            let margin = (0.04 * (high - low)).max(1e-9 * high.abs()).max(1e-12);
            if low <= high { low - margin..high + margin } else { 0.0..1.0 }
        };
        let (x, y) = (range(|p| p.0), range(|p| p.1));
        let root = SVGBackend::new(path, SIZE).into_drawing_area();
        let font = ("sans-serif", 15).into_font().color(&INK);
        let (left, right) = root.split_horizontally(LEGEND);
        let mut chart = ChartBuilder::on(&left)
            .caption(self.title, ("sans-serif", 20, &INK))
            .margin(12)
            .x_label_area_size(48)
            .y_label_area_size(78)
            .build_cartesian_2d(
                Scale { ticks: self.x.ticks(&x), range: x },
                Scale { ticks: self.y.ticks(&y), range: y },
            )?;
        chart
            .configure_mesh()
            .bold_line_style(INK.mix(0.3))
            .axis_style(INK)
            .x_desc(self.x.label)
            .y_desc(self.y.label)
            .x_label_formatter(&|&at| self.x.text(at))
            .y_label_formatter(&|&at| self.y.text(at))
            .label_style(font.clone())
            .draw()?;
        for (i, (line, points)) in self.lines.iter().zip(lines).enumerate() {
            let style = COLOURS[i % COLOURS.len()].stroke_width(2);
            let (dash, gap, pieces) = DASHES[i % DASHES.len()];
            let every = points.len().div_ceil(MARKERS).max(1);
            // Lines that coincide have their markers at different places.
            let first = (i * every / 5) % every;
            let marked: Vec<_> = points.iter().copied().skip(first).step_by(every).collect();
            if gap == 0 {
                chart.draw_series(LineSeries::new(points, style))?;
            } else {
                chart.draw_series(DashedLineSeries::new(points, dash, gap, style))?;
            }
            let shape = SHAPES[i % SHAPES.len()];
            let marker = |at| EmptyElement::at(at) + PathElement::new(shape, style);
            chart.draw_series(marked.into_iter().map(marker))?;
            let (x, y) = (4, 60 + 26 * i32::try_from(i)?);
            for [from, to] in pieces {
                right.draw(&PathElement::new([(x + from, y), (x + to, y)], style))?;
            }
            let shape = shape.iter().map(|(dx, dy)| (x + 15 + dx, y + dy));
            right.draw(&PathElement::new(shape.collect::<Vec<_>>(), style))?;
            let name = Text::new(line.name.clone(), (x + 38, y - 8), font.clone());
            right.draw(&name)?;
        }
        root.present()?;
        Ok(())
    }

    fn placed(&self, line: &Line) -> Vec<(f64, f64)> {
        let points = line.points.iter().map(|&(x, y)| (self.x.place(x), self.y.place(y)));
        points.filter(|(x, y)| x.is_finite() && y.is_finite()).collect()
    }
}
