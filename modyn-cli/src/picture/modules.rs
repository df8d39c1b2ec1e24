//! Draws the module tree and the sparsity of the mass matrix and its factors.

use std::fmt::Write as _;

use modyn_runtime::model::{Model, ModuleTree, MovingLink};

use super::Sparsity;
use crate::escape::{markup, shortened};

/// Light colours that colour-blind readers can distinguish (Okabe and Ito); numbers identify
/// modules, too.
const TINTS: [&str; 7] =
    ["#cfe3f3", "#f9dcc4", "#cbe9de", "#f3d9e6", "#fbf3c0", "#d9e2f7", "#e9d5c6"];
/// The colours of names in the boxes, and of texts and lines beside them, which are seen on dark
/// and on light grounds.
const INK: [&str; 2] = ["#1d2733", "#4a5560"];
const LINE: &str = "#7d8794";
/// The colour of nonzero entries.
const ENTRY: &str = "#4b7fa6";

const MARGIN: f64 = 40.0;
const TITLE: f64 = 70.0;
/// The minimal width of a module's box, and its height.
const BOX: (f64, f64) = (140.0, 46.0);
/// The gap between two columns of boxes, and the distance between two rows.
const STEP: (f64, f64) = (36.0, 62.0);
/// The width of a letter in a box, and the space left and right of the name together.
const LETTER: f64 = 6.7;
const PADDING: f64 = 44.0;
/// The longest name that is drawn in full, in characters.
const MAX_NAME_LENGTH: usize = 60;
/// The size of a matrix, and the gap to the next.
const MATRIX: f64 = 250.0;
const BETWEEN: f64 = 46.0;

/// Returns the picture as SVG.
pub fn draw(model: &Model, modules: &ModuleTree, sparsity: &Sparsity) -> String {
    let places = places(modules);
    let columns = places.iter().map(|&(column, _)| column + 1).max().unwrap_or(0);
    let rows = places.iter().map(|&(_, row)| row + 1.0).fold(1.0, f64::max);
    let box_width = box_width(model, modules);
    let tree = (columns as f64 * (box_width + STEP.0) + 70.0, (rows - 1.0) * STEP.1 + BOX.1);
    let width = 2.0 * MARGIN + tree.0 + 3.0 * MATRIX + 2.0 * BETWEEN + 30.0;
    let body = tree.1.max(MATRIX + 60.0);
    let height = TITLE + body + 2.0 * MARGIN;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\" font-family=\"Helvetica, Arial, sans-serif\" fill=\"{LINE}\" role=\"img\">\n\
         <title>Kinematic modules of {name}, and the sparsity of its mass matrix and factors</title>\n\
         <text x=\"{MARGIN}\" y=\"{y}\" font-size=\"26\" font-weight=\"bold\">{name}</text>\n\
         <text x=\"{MARGIN}\" y=\"{below}\" font-size=\"15\">{} moving links in {} kinematic \
         modules, {} degrees of freedom</text>\n",
        model.moving_links().len(),
        modules.modules().len(),
        model.nv(),
        name = markup(model.name()),
        y = MARGIN + 12.0,
        below = MARGIN + 36.0,
    );
    let top = TITLE + MARGIN;
    let picture = TreePicture {
        model,
        modules,
        places: &places,
        box_width,
        corner: [MARGIN, top + (body - tree.1) / 2.0],
    };
    picture.draw(&mut out);
    let blocks = blocks(model, modules);
    let mut left = MARGIN + tree.0 + 30.0;
    for (title, pattern) in [
        ("mass matrix M = U D U<tspan dy=\"-5\" font-size=\"11\">T</tspan>", &sparsity.mass_matrix),
        ("U", &sparsity.u),
        ("D", &sparsity.d),
    ] {
        let picture = MatrixPicture {
            title,
            pattern,
            n: sparsity.n,
            blocks: &blocks,
            corner: [left, top + (body - MATRIX - 60.0) / 2.0 + 14.0],
        };
        picture.draw(&mut out);
        left += MATRIX + BETWEEN;
    }
    out + "</svg>\n"
}

/// Returns the place of each module: its column, which is its depth, and its row, in the middle of
/// its children's rows.
fn places(tree: &ModuleTree) -> Vec<(usize, f64)> {
    let modules = tree.modules();
    let mut places = vec![(0, 0.0); modules.len()];
    let mut next = 0.0;
    // In depth-first order a module without children is above all later ones.
    for (m, module) in modules.iter().enumerate() {
        places[m].0 = module.parent.map_or(0, |parent| places[parent].0 + 1);
        if module.children.is_empty() {
            places[m].1 = next;
            next += 1.0;
        }
    }
    for (m, module) in modules.iter().enumerate().rev() {
        if let (Some(&first), Some(&last)) = (module.children.first(), module.children.last()) {
            places[m].1 = f64::midpoint(places[first].1, places[last].1);
        }
    }
    places
}

fn tint(module: usize) -> &'static str {
    TINTS[module % TINTS.len()]
}

/// Returns the width of the boxes, in which every name fits.
fn box_width(model: &Model, modules: &ModuleTree) -> f64 {
    let ends = modules.modules().iter().flat_map(|module| {
        let links = &model.moving_links()[module.links.clone()];
        [(links.first(), 0), (links.last(), 3)] // "to " precedes the last name.
    });
    let letters = ends
        .filter_map(|(link, more)| Some(link?.name.chars().count().min(MAX_NAME_LENGTH) + more));
    (letters.max().unwrap_or(0) as f64 * LETTER + PADDING).max(BOX.0)
}

/// The tree of the modules, from its left upper corner.
struct TreePicture<'a> {
    model: &'a Model,
    modules: &'a ModuleTree,
    /// For each module, its column and its row.
    places: &'a [(usize, f64)],
    box_width: f64,
    corner: [f64; 2],
}

impl TreePicture<'_> {
    fn draw(&self, out: &mut String) {
        let Self { model, modules, places, box_width, corner: [left, top] } = *self;
        let corner = |m: usize| {
            let (column, row) = places[m];
            (left + 70.0 + column as f64 * (box_width + STEP.0), top + row * STEP.1)
        };
        let roots = (0..places.len()).filter(|&m| modules.modules()[m].parent.is_none());
        let rows: Vec<f64> = roots.map(|m| places[m].1).collect();
        let first = rows.first().unwrap_or(&0.0);
        let last = rows.last().unwrap_or(&0.0);
        let base = top + f64::midpoint(*first, *last) * STEP.1 + BOX.1 / 2.0;
        let _ = writeln!(
            out,
            "<circle cx=\"{:.1}\" cy=\"{base:.1}\" r=\"7\"/><text x=\"{:.1}\" y=\"{:.1}\" font-size=\"13\" \
         text-anchor=\"middle\">base</text>",
            left + 14.0,
            left + 14.0,
            base + 24.0
        );
        for (m, module) in modules.modules().iter().enumerate() {
            let (x, y) = corner(m);
            let (from_x, from_y) = match module.parent.map(corner) {
                Some((x, y)) => (x + box_width, y + BOX.1 / 2.0),
                None => (left + 21.0, base),
            };
            let to = y + BOX.1 / 2.0;
            let bend = f64::midpoint(from_x, x);
            let _ = writeln!(
                out,
                "<path d=\"M{from_x:.1} {from_y:.1} C{bend:.1} {from_y:.1} {bend:.1} {to:.1} {x:.1} {to:.1}\" \
             fill=\"none\" stroke=\"{LINE}\" stroke-width=\"2\"/>"
            );
            let links = &model.moving_links()[module.links.clone()];
            let name = |link: Option<&MovingLink>| {
                markup(&shortened(link.map_or("", |link| &link.name), MAX_NAME_LENGTH))
            };
            let first = name(links.first());
            let last = match links.len() {
                0 | 1 => String::new(),
                _ => format!("to {}", name(links.last())),
            };
            let x_text = x + 34.0;
            let [dark, grey] = INK;
            let _ = writeln!(
                out,
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{box_width:.1}\" height=\"{}\" rx=\"9\" \
             fill=\"{}\" stroke=\"{dark}\" \
             stroke-width=\"1.2\"/>\n\
             <text x=\"{:.1}\" y=\"{:.1}\" font-size=\"19\" font-weight=\"bold\" fill=\"{dark}\" \
             text-anchor=\"middle\">{m}</text>\n\
             <text x=\"{x_text:.1}\" y=\"{:.1}\" font-size=\"12\" fill=\"{dark}\">{first}</text>\n\
             <text x=\"{x_text:.1}\" y=\"{:.1}\" font-size=\"11\" fill=\"{grey}\">{last}</text>",
                BOX.1,
                tint(m),
                x + 17.0,
                y + 30.0,
                y + 20.0,
                y + 36.0,
            );
        }
    }
}

/// Returns the rows and columns of each module; none for a module of mimic joints.
fn blocks(model: &Model, tree: &ModuleTree) -> Vec<std::ops::Range<usize>> {
    let is_independent = |link: &usize| model.mimic(*link).is_none();
    let block = |links: std::ops::Range<usize>| {
        let places: Vec<_> = links.filter(is_independent).map(|link| model.v_range(link)).collect();
        match (places.first(), places.last()) {
            (Some(first), Some(last)) => first.start..last.end,
            _ => 0..0,
        }
    };
    tree.modules().iter().map(|module| block(module.links.clone())).collect()
}

/// The pattern of a matrix, from its left upper corner.
struct MatrixPicture<'a> {
    title: &'a str,
    /// For each entry, by columns, whether it can be other than zero.
    pattern: &'a [bool],
    /// The number of rows.
    n: usize,
    /// For each module, its rows and columns.
    blocks: &'a [std::ops::Range<usize>],
    corner: [f64; 2],
}

impl MatrixPicture<'_> {
    fn draw(&self, out: &mut String) {
        let Self { title, pattern, n, blocks, corner: [left, top] } = *self;
        let cell = MATRIX / n.max(1) as f64;
        let _ = writeln!(out, "<g transform=\"translate({left:.1} {top:.1})\">");
        for (m, block) in blocks.iter().enumerate().filter(|(_, block)| !block.is_empty()) {
            let at = block.start as f64 * cell;
            let side = block.len() as f64 * cell;
            let _ = writeln!(
                out,
                "<rect x=\"{at:.2}\" y=\"{at:.2}\" width=\"{side:.2}\" height=\"{side:.2}\" fill=\"{}\"/>",
                tint(m)
            );
        }
        let gap = (cell * 0.1).min(4.0);
        let side = cell - 2.0 * gap;
        for (j, column) in pattern.chunks(n.max(1)).enumerate() {
            for (i, _) in column.iter().enumerate().filter(|(_, entry)| **entry) {
                let _ = write!(
                    out,
                    "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{side:.2}\" height=\"{side:.2}\" \
                 rx=\"{gap:.2}\" fill=\"{ENTRY}\"/>",
                    j as f64 * cell + gap,
                    i as f64 * cell + gap,
                );
            }
        }
        out.push('\n');
        for block in blocks.iter().filter(|block| !block.is_empty()) {
            for at in [block.start, block.end].map(|at| at as f64 * cell) {
                let _ = writeln!(
                    out,
                    "<path d=\"M{at:.2} 0V{MATRIX} M0 {at:.2}H{MATRIX}\" stroke=\"{LINE}\" stroke-width=\"0.8\"/>"
                );
            }
        }
        for (m, block) in blocks.iter().enumerate().filter(|(_, block)| !block.is_empty()) {
            let middle = f64::midpoint(block.start as f64, block.end as f64) * cell;
            let size = (block.len() as f64 * cell).min(14.0);
            let _ = writeln!(
                out,
                "<text x=\"{middle:.1}\" y=\"-6\" font-size=\"{size:.1}\" text-anchor=\"middle\">{m}</text>\
             <text x=\"-6\" y=\"{:.1}\" font-size=\"{size:.1}\" text-anchor=\"end\">{m}</text>",
                middle + 0.35 * size
            );
        }
        let filled = pattern.iter().filter(|&&entry| entry).count();
        let _ = writeln!(
            out,
            "<rect width=\"{MATRIX}\" height=\"{MATRIX}\" fill=\"none\" stroke=\"{LINE}\" stroke-width=\"1.5\"/>\n\
         <text x=\"{x}\" y=\"{y}\" font-size=\"17\" font-weight=\"bold\" text-anchor=\"middle\">{title}</text>\n\
         <text x=\"{x}\" y=\"{below}\" font-size=\"12\" text-anchor=\"middle\">{filled} of {} \
         entries are not zero</text>\n</g>",
            n * n,
            x = MATRIX / 2.0,
            y = MATRIX + 26.0,
            below = MATRIX + 46.0,
        );
    }
}
