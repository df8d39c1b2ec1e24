//! The README's chart: times of forward dynamics with warm and with cold caches, beside other
//! software.

use std::fmt::Write as _;

use super::data::Data;

/// The robots: their names in the data, in the README's table and in the chart.
pub(super) const ROBOTS: [(&str, &str, &str); 5] = [
    ("ur5", "UR5, 6 joints", "UR5"),
    ("panda", "Panda, 7 joints", "Panda"),
    ("solo12_ff", "Solo12 quadruped, floating, 18", "Solo12, floating"),
    ("g1", "G1 humanoid, 29 joints", "G1"),
    ("g1_ff", "G1 humanoid, floating, 35", "G1, floating"),
];

/// A program of the chart.
struct Program {
    /// The name in the data.
    measured: &'static str,
    title: &'static str,
    /// A colour that is seen on dark and on light grounds.
    colour: &'static str,
    /// The outline of its marks, from their centre, px.
    shape: &'static str,
}

const PROGRAMS: [Program; 4] = [
    Program {
        measured: "modyn native",
        title: "modyn",
        colour: "#e8871e",
        shape: "m-6 0a6 6 0 1 0 12 0a6 6 0 1 0 -12 0z",
    },
    Program {
        measured: "CasADi C",
        title: "CasADi",
        colour: "#3fa37c",
        shape: "m-5.5 -5.5h11v11h-11z",
    },
    Program {
        measured: "Pinocchio C++",
        title: "Pinocchio",
        colour: "#4b91d1",
        shape: "m0 -7l7 12h-14z",
    },
    Program {
        measured: "MuJoCo",
        title: "MuJoCo",
        colour: "#a07fd6",
        shape: "m0 -7.5l7.5 7.5l-7.5 7.5l-7.5 -7.5z",
    },
];

impl Program {
    /// Returns the mark of a time, full with warm caches, with `title` beside the pointer.
    fn mark(&self, x: f64, y: f64, is_cold: bool, title: &str) -> String {
        let Self { colour, shape, .. } = self;
        let fill = if is_cold { "none" } else { colour };
        format!(
            "<path d=\"M{x:.1} {y}{shape}\" fill=\"{fill}\" stroke=\"{colour}\" stroke-width=\"2\">\
             <title>{title}</title></path>"
        )
    }
}

/// The colour of texts and lines.
const INK: &str = "#7d8794";
/// The range of times, ns, and the places of its ends, px.
const TIMES: [f64; 2] = [40.0, 100_000.0];
const PLACES: [f64; 2] = [150.0, 840.0];
const ROW: f64 = 34.0;
const TOP: f64 = 62.0;

/// Returns the place of a time (ns) on the logarithmic axis, px.
fn place(nanoseconds: f64) -> f64 {
    let part = (nanoseconds / TIMES[0]).ln() / (TIMES[1] / TIMES[0]).ln();
    PLACES[0] + part * (PLACES[1] - PLACES[0])
}

/// Returns the chart, SVG.
pub(super) fn speed() -> String {
    let (warm, cold) = (Data::load("calls"), Data::load("calls-cold"));
    let bottom = TOP + ROW * ROBOTS.len() as f64;
    let (width, height) = (870.0, bottom + 54.0);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"Helvetica, Arial, sans-serif\" font-size=\"14\" fill=\"{INK}\" role=\"img\">\n\
         <title>Time of forward dynamics: full marks with warm caches, outlined marks with cold caches</title>\n"
    );
    // The legend.
    let mut x = PLACES[0];
    for program in PROGRAMS {
        let title = program.title;
        let mark = program.mark(x, 16.0, false, title);
        let _ = writeln!(out, "{mark}<text x=\"{}\" y=\"21\">{title}</text>", x + 12.0);
        x += 105.0;
    }
    let _ = writeln!(out, "<text x=\"{x}\" y=\"21\">full: warm caches; outlined: cold</text>");
    // Lines at round times.
    let times = [(1e2, "0.1"), (1e3, "1"), (1e4, "10"), (1e5, "100")];
    for (time, name) in times {
        let x = place(time);
        let _ = writeln!(
            out,
            "<path d=\"M{x:.1} {}V{bottom}\" stroke=\"{INK}\" stroke-opacity=\"0.6\"/><text x=\"{x:.1}\" y=\"{}\" \
             text-anchor=\"middle\">{name}</text>",
            TOP - 16.0,
            bottom + 20.0
        );
        for part in 2..10 {
            let time = time * f64::from(part);
            if time < TIMES[1] {
                let x = place(time);
                let _ = writeln!(
                    out,
                    "<path d=\"M{x:.1} {}V{bottom}\" stroke=\"{INK}\" stroke-opacity=\"0.15\"/>",
                    TOP - 16.0
                );
            }
        }
    }
    for (row, (robot, _, title)) in ROBOTS.into_iter().enumerate() {
        let y = TOP + ROW * row as f64;
        let _ = writeln!(
            out,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{title}</text>",
            PLACES[0] - 14.0,
            y + 5.0
        );
        for program in PROGRAMS {
            for (data, is_cold) in [(&warm, false), (&cold, true)] {
                let ns = data.find(&["forward dynamics", robot, program.measured], "ns");
                let Some(ns) = ns.and_then(|ns| ns.parse::<f64>().ok()) else { continue };
                let caches = if is_cold { "cold" } else { "warm" };
                let shown = format!("{title}, {}, {caches}: {ns} ns", program.title);
                let _ = writeln!(out, "{}", program.mark(place(ns), y, is_cold, &shown));
            }
        }
    }
    let _ = writeln!(
        out,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">time of forward dynamics of one state, µs \
         (one core of an AMD EPYC, Zen 3)</text>",
        f64::midpoint(PLACES[0], PLACES[1]),
        bottom + 42.0
    );
    out + "</svg>\n"
}
