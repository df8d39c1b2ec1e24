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

/// The programs: their names in the data and in the chart, and colours that are seen on dark and on
/// light grounds.
const PROGRAMS: [(&str, &str, &str); 4] = [
    ("modyn native", "modyn", "#e8871e"),
    ("CasADi C", "CasADi", "#3fa37c"),
    ("Pinocchio C++", "Pinocchio", "#4b91d1"),
    ("MuJoCo", "MuJoCo", "#a07fd6"),
];

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
    let (width, height) = (870.0, bottom + 34.0);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" \
         font-family=\"Helvetica, Arial, sans-serif\" font-size=\"14\" fill=\"{INK}\" role=\"img\">\n\
         <title>Time of forward dynamics: dots with warm caches, rings with cold caches</title>\n"
    );
    // The legend.
    let mut x = PLACES[0];
    for (_, name, colour) in PROGRAMS {
        let _ = writeln!(
            out,
            "<circle cx=\"{x}\" cy=\"16\" r=\"6\" fill=\"{colour}\"/><text x=\"{}\" y=\"21\">{name}</text>",
            x + 12.0
        );
        x += 105.0;
    }
    let _ = writeln!(
        out,
        "<circle cx=\"{x}\" cy=\"16\" r=\"6\"/><text x=\"{}\" y=\"21\">warm</text>\n\
         <circle cx=\"{}\" cy=\"16\" r=\"5\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"2.5\"/><text x=\"{}\" y=\"21\">cold</text>",
        x + 12.0,
        x + 75.0,
        x + 87.0
    );
    // Lines at round times.
    let times = [(1e2, "100 ns"), (1e3, "1 us"), (1e4, "10 us"), (1e5, "100 us")];
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
        for (program, name, colour) in PROGRAMS {
            for (data, is_cold) in [(&warm, false), (&cold, true)] {
                let ns = data.find(&["forward dynamics", robot, program], "ns");
                let Some(ns) = ns.and_then(|ns| ns.parse::<f64>().ok()) else { continue };
                let style = if is_cold {
                    format!("r=\"5\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2.5\"")
                } else {
                    format!("r=\"6\" fill=\"{colour}\"")
                };
                let caches = if is_cold { "cold" } else { "warm" };
                let _ = writeln!(
                    out,
                    "<circle cx=\"{:.1}\" cy=\"{y}\" {style}><title>{title}, {name}, {caches}: {ns} ns</title></circle>",
                    place(ns)
                );
            }
        }
    }
    out + "</svg>\n"
}
