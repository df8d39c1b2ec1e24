//! Makes a page that animates a stick figure in a browser: one file, without network access.
//!
//! ```
//! use modyn_cli::viewer::{Frame, page};
//!
//! // A rod that rotates about the origin.
//! let frames: Vec<Frame> = (0..50)
//!     .map(|i| {
//!         let time = 0.02 * f64::from(i);
//!         Frame { time, points: vec![[0.0; 3], [time.cos(), 0.0, time.sin()]] }
//!     })
//!     .collect();
//! let html = page("A rod", &[(0, 1)], &frames);
//! assert!(html.starts_with("<!doctype html>"));
//! ```

use std::fmt::Write as _;

use crate::escape::markup;

/// The page, without its title and the motion.
const PAGE: &str = include_str!("page.html");

/// The positions of the points at an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The time, s.
    pub time: f64,
    /// The positions in the world, m; z points upwards. A point that is not finite is not drawn.
    pub points: Vec<[f64; 3]>,
}

/// Returns a page titled `title` that animates the lines `edges`, pairs of indices of points, over `frames`, whose
/// times must ascend. The animation can be played, paused, moved in time, and viewed from all sides.
#[must_use]
pub fn page(title: &str, edges: &[(usize, usize)], frames: &[Frame]) -> String {
    let decimals = decimals(frames);
    let mut data = String::from("{\"edges\":[");
    list(&mut data, edges, |out, (from, to)| {
        let _ = write!(out, "[{from},{to}]");
    });
    data += "],\"times\":[";
    list(&mut data, frames, |out, frame| number(out, frame.time, 6));
    data += "],\"points\":[\n";
    list(&mut data, frames, |out, frame| {
        out.push('[');
        list(out, frame.points.as_flattened(), |out, &x| number(out, x, decimals));
        out.push_str("]\n");
    });
    data += "]}";
    // The title is inserted last, so that marks in it are not replaced.
    PAGE.replace("__MOTION__", &data).replace("__TITLE__", &markup(title))
}

fn list<T>(out: &mut String, items: &[T], mut write: impl FnMut(&mut String, &T)) {
    for (i, item) in items.iter().enumerate() {
        if i > 0 {
            out.push(',');
        }
        write(out, item);
    }
}

/// Writes a JSON number with at most this number of decimals, without trailing zeros.
fn number(out: &mut String, x: f64, decimals: usize) {
    if !x.is_finite() {
        out.push_str("null");
        return;
    }
    let text = format!("{x:.decimals$}");
    let text = if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    out.push_str(if text == "-0" { "0" } else { text });
}

/// Returns the number of decimals that resolves a ten-thousandth of the figure's size.
fn decimals(frames: &[Frame]) -> usize {
    let numbers = frames.iter().flat_map(|frame| frame.points.as_flattened());
    let finite = numbers.filter(|x| x.is_finite());
    let largest = finite.fold(0.0_f64, |most, x| most.max(x.abs()));
    let size = if largest > 0.0 { largest.log10().ceil() } else { 0.0 };
    (4.0 - size).clamp(0.0, 12.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_is_text_and_numbers_are_json() {
        let frames = [
            Frame { time: 0.0, points: vec![[0.0, -0.0, 1.0], [f64::NAN, 0.123_456, 1e-9]] },
            Frame { time: 0.1, points: vec![[0.0; 3], [1.0; 3]] },
        ];
        let html = page("</script><b>__MOTION__", &[(0, 1)], &frames);
        assert!(html.contains("<title>&lt;/script&gt;&lt;b&gt;__MOTION__</title>"));
        assert!(html.contains(
            "{\"edges\":[[0,1]],\"times\":[0,0.1],\"points\":[\n[0,0,1,null,0.1235,0]\n,[0,0,0,1,1,1]\n]}"
        ));
    }

    #[test]
    fn numbers_of_all_sizes_keep_four_digits() {
        let of = |x| decimals(&[Frame { time: 0.0, points: vec![[x, 0.0, f64::INFINITY]] }]);
        assert_eq!([of(0.0), of(1.0), of(0.001), of(50.0), of(1e9)], [4, 4, 7, 2, 0]);
        let mut text = String::new();
        number(&mut text, 100.0, 0);
        assert_eq!(text, "100");
    }

    #[test]
    fn the_page_needs_nothing_from_elsewhere() {
        let html = page("x", &[], &[]);
        assert!(html.contains("default-src 'none'"));
        for foreign in ["http://", "https://", "src=", "href=", "@import", "url("] {
            assert!(!html.contains(foreign), "{foreign}");
        }
    }
}
