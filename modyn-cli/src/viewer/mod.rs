//! Makes pages that show robots and their motions in a browser: one file, without network access.
//!
//! A motion of points needs nothing else:
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
//!
//! With the feature `picture`, a [`Scene`] shows robots with their shapes and joint sliders.
//!
//! The page is `page/page.html` with the scripts beside it: `algebra.js`, `geometry.js` (triangles
//! of shapes), `robot.js` (poses from coordinates), `renderer.js` (WebGL2), `export.js` (ZIP and
//! GLB) and `viewer.js` (the view and its controls).

mod json;
#[cfg(feature = "picture")]
mod scene;

#[cfg(feature = "picture")]
pub use scene::{Motion, Scene};

use crate::escape::markup;

/// The page, without its parts.
const PAGE: &str = include_str!("page/page.html");

/// The style of the view.
pub const STYLE: &str = include_str!("page/style.css");

/// The script of the view: the class `Viewer`, and all that it needs.
pub const SCRIPT: &str = concat!(
    include_str!("page/algebra.js"),
    include_str!("page/geometry.js"),
    include_str!("page/robot.js"),
    include_str!("page/renderer.js"),
    include_str!("page/export.js"),
    include_str!("page/viewer.js"),
);

/// The positions of the points at an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The time, s.
    pub time: f64,
    /// The positions in the world, m; z points upwards. A point that is not finite is not drawn.
    pub points: Vec<[f64; 3]>,
}

/// Returns a page titled `title` that animates the lines `edges`, pairs of indices of points, over
/// `frames`, whose times must ascend. The animation can be played, paused, moved in time, and
/// viewed from all sides.
#[must_use]
pub fn page(title: &str, edges: &[(usize, usize)], frames: &[Frame]) -> String {
    let mut data = String::from("{");
    json::key(&mut data, "title");
    json::text(&mut data, title);
    data += ",\"robots\":[],\"meshes\":[],\"motions\":[],\"figures\":[{";
    json::key(&mut data, "name");
    json::text(&mut data, title);
    json::key(&mut data, "edges");
    json::list(&mut data, edges, |out, &(from, to)| {
        *out += &format!("[{from},{to}]");
    });
    json::key(&mut data, "times");
    json::numbers(&mut data, frames.iter().map(|frame| &frame.time));
    json::key(&mut data, "points");
    json::list(&mut data, frames, |out, frame| json::numbers(out, frame.points.as_flattened()));
    data += "}]}";
    page_of(title, &data)
}

/// Returns the page with this data.
fn page_of(title: &str, data: &str) -> String {
    // The data and the title are inserted last, so that marks in them are not replaced.
    let (before, after) = PAGE.split_once("__DATA__").unwrap_or((PAGE, ""));
    let before = before.replace("__STYLE__", STYLE).replace("__TITLE__", &markup(title));
    let after = after.replace("__SCRIPT__", SCRIPT);
    [&before, data, &after].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_is_text_and_points_are_data() {
        let frames = [
            Frame { time: 0.0, points: vec![[0.0, -0.0, 1.0], [f64::NAN, 0.123_456_78, 1e-9]] },
            Frame { time: 0.1, points: vec![[0.0; 3], [1.0; 3]] },
        ];
        let html = page("</script><b>__DATA__", &[(0, 1)], &frames);
        assert!(html.contains("<title>&lt;/script&gt;&lt;b&gt;__DATA__</title>"));
        let data = "\"edges\":[[0,1]],\"times\":[0,0.1],\"points\":[[0,0,1,null,0.123457,1e-9],[0,0,0,1,1,1]]";
        assert!(html.contains(data), "{}", &html[html.find("{\"title").unwrap_or(0)..]);
        assert!(!html.contains("</script><b>"));
    }

    #[test]
    fn the_page_needs_nothing_from_elsewhere() {
        let html = page("x", &[], &[]);
        assert!(html.contains("default-src 'none'"));
        for foreign in ["http://", "https://", "src=", "href=", "@import", "url("] {
            assert!(!html.contains(foreign), "{foreign}");
        }
        for mark in ["__STYLE__", "__TITLE__", "__DATA__", "__SCRIPT__"] {
            assert!(!html.contains(mark), "{mark}");
        }
    }
}
