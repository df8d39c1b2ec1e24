//! The pictures of `docs/internals/machine-code.md`.

use std::fmt::Write as _;

use modyn_codegen::graph::{Graph, Id, Node};

use super::{Code, number};

/// The colours of registers.
const COLORS: [&str; 16] = [
    "#cfe3f3", "#f9dcc4", "#d5e8d4", "#e1d5e7", "#fff2cc", "#f8cecc", "#d0cee2", "#b9e0d9",
    "#e6d0de", "#dae8fc", "#fad9d5", "#cdeb8b", "#ffe6cc", "#c3d9ff", "#eeeeee", "#f0e0b0",
];

/// The colours of texts on the coloured boxes, and of texts and lines beside them, which are seen
/// on dark and on light grounds.
const IN_BOX: &str = "#1d2733";
const INK: &str = "#7d8794";

/// Returns the head of a picture.
fn head(width: usize, height: usize, title: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         width=\"{width}\" height=\"{height}\" \
         font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"{INK}\" role=\"img\">\n\
         <title>{title}</title>\n"
    )
}

/// Returns the sign of a node's operation.
fn label(node: Node, inputs: &[&str]) -> String {
    match node {
        Node::Constant(bits) => number(f64::from_bits(bits)),
        Node::Input(i) => inputs[i as usize].into(),
        Node::Neg(_) => "neg".into(),
        Node::Add(..) => "+".into(),
        Node::Sub(..) => "\u{2212}".into(),
        Node::Mul(..) => "\u{d7}".into(),
        Node::Recip(_) => "1/x".into(),
        Node::Sin(_) => "sin".into(),
        Node::Cos(_) => "cos".into(),
        other => panic!("the example has {other:?}"),
    }
}

/// Returns the graph: inputs at the left, each operation right of its operands. Constants are
/// written in the operations that read them.
pub(super) fn graph(graph: &Graph, inputs: &[&str]) -> String {
    let live = graph.live();
    let nodes = graph.nodes();
    let is_drawn = |id: Id| live[id as usize] && !graph.is_constant(id);
    let mut level = vec![0_usize; nodes.len()];
    let mut columns: Vec<Vec<Id>> = Vec::new();
    for (i, node) in nodes.iter().enumerate() {
        let id = i as Id;
        if !is_drawn(id) {
            continue;
        }
        let before = node.operands().filter(|&operand| is_drawn(operand));
        level[i] = before.map(|operand| level[operand as usize] + 1).max().unwrap_or(0);
        columns.resize(columns.len().max(level[i] + 1), Vec::new());
        columns[level[i]].push(id);
    }
    let step = 78;
    let row = 44;
    let rows = columns.iter().map(Vec::len).max().unwrap_or(1);
    let width = columns.len() * step + 70;
    let height = rows * row + 40;
    let mut place = vec![(0.0, 0.0); nodes.len()];
    for (x, column) in columns.iter_mut().enumerate() {
        // The mean height of the operands orders a column.
        let mean = |id: &Id| {
            let before: Vec<f64> = (nodes[*id as usize].operands())
                .filter(|&operand| is_drawn(operand))
                .map(|operand| place[operand as usize].1)
                .collect();
            before.iter().sum::<f64>() / before.len().max(1) as f64
        };
        if x > 0 {
            column.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
        }
        let gap = height as f64 / (column.len() + 1) as f64;
        for (y, &id) in column.iter().enumerate() {
            // An edge between neighbours of equal height would hide one that passes them.
            let shift = if x % 2 == 1 { 9.0 } else { 0.0 };
            place[id as usize] = ((x * step + 45) as f64, gap * (y + 1) as f64 + shift);
        }
    }
    let title = "The graph of the cart and pole: inputs, operations, results";
    let mut text = head(width, height, title);
    for column in &columns {
        for &id in column {
            let (x, y) = place[id as usize];
            for operand in nodes[id as usize].operands().filter(|&operand| is_drawn(operand)) {
                let (from, at) = place[operand as usize];
                let middle = x - 34.0;
                let _ = writeln!(
                    text,
                    "<path d=\"M{from} {at:.1}C{:.1} {at:.1} {middle:.1} {y:.1} {x} {y:.1}\" \
                     fill=\"none\" stroke=\"{INK}\"/>",
                    from + 34.0
                );
            }
        }
    }
    for (x, column) in columns.iter().enumerate() {
        for &id in column {
            let (cx, cy) = place[id as usize];
            let node = nodes[id as usize];
            let is_result = graph.outputs.contains(&id);
            let fill = match (x, is_result) {
                (_, true) => COLORS[2],
                (0, _) => COLORS[1],
                _ => COLORS[0],
            };
            let constants: Vec<String> = (node.operands())
                .filter(|&operand| graph.is_constant(operand))
                .map(|operand| label(nodes[operand as usize], inputs))
                .collect();
            // Constants are in the box, below the operation.
            let half = if constants.is_empty() { 11.0 } else { 17.0 };
            let _ = writeln!(
                text,
                "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"44\" height=\"{}\" rx=\"8\" fill=\"{fill}\" stroke=\"{INK}\"/>",
                cx - 22.0,
                cy - half,
                2.0 * half,
            );
            let lines = [(cy + 15.0 - half, 12, label(node, inputs))];
            let below = constants.iter().map(|constant| (cy + 12.0, 9, constant.clone()));
            for (y, size, line) in lines.into_iter().chain(below) {
                let _ = writeln!(
                    text,
                    "<text x=\"{cx}\" y=\"{y:.1}\" text-anchor=\"middle\" fill=\"{IN_BOX}\" \
                     font-size=\"{size}\">{line}</text>"
                );
            }
        }
    }
    text + "</svg>\n"
}

/// Returns the life of each value as a bar, from the step that computes it to the last one that
/// reads it, in the colour of the register where it is computed.
pub(super) fn lives(code: &Code) -> String {
    let lives = code.lives();
    let left = 64;
    let step = 15;
    let row = 16;
    let steps = code.values.steps.len();
    let width = left + steps * step + 60;
    let height = lives.len() * row + 60;
    let mut text = head(width, height, "The lives of the values, and their registers");
    let _ = writeln!(
        text,
        "<text x=\"{left}\" y=\"22\">steps, from left to right; the number in a bar is the register</text>"
    );
    for (i, &(value, start, end)) in lives.iter().enumerate() {
        let x = left + start * step;
        let y = 36 + i * row;
        let length = (end - start).max(1) * step;
        let register = code.register(start).expect("a step computes a value in a register");
        let _ = writeln!(
            text,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\" font-size=\"10\">{}</text>\
             <rect x=\"{x}\" y=\"{y}\" width=\"{length}\" height=\"12\" fill=\"{}\" \
             stroke=\"{INK}\" stroke-width=\"0.6\"/>\
             <text x=\"{}\" y=\"{}\" font-size=\"9\" fill=\"{IN_BOX}\">{register}</text>",
            left - 8,
            y + 10,
            code.name(value),
            COLORS[register % 16],
            x + 3,
            y + 9,
        );
    }
    text + "</svg>\n"
}

/// Returns the number of values that are alive after each step, and the steps that store one in the
/// stack frame.
pub(super) fn pressure(code: &Code) -> String {
    let lives = code.lives();
    let steps = code.values.steps.len();
    let mut alive = vec![0_usize; steps];
    for &(_, start, end) in &lives {
        alive[start..end].iter_mut().for_each(|count| *count += 1);
    }
    let most = alive.iter().max().copied().unwrap_or(1);
    let left = 50.0;
    let width = 860.0;
    let height = 300.0;
    let scale_x = (width - left - 20.0) / steps as f64;
    let scale_y = (height - 80.0) / most as f64;
    let at = |step: usize, count: usize| {
        (left + step as f64 * scale_x, height - 40.0 - count as f64 * scale_y)
    };
    let mut text =
        head(width as usize, height as usize, "Values alive in forward dynamics of the Panda");
    let points: Vec<String> = (alive.iter().enumerate())
        .map(|(step, &count)| {
            let (x, y) = at(step, count);
            format!("{x:.1},{y:.1}")
        })
        .collect();
    let _ = writeln!(
        text,
        "<text x=\"{left}\" y=\"24\">values that later steps read, after each step; below, a line \
         for each step that stores one in the \
         stack frame</text>\n<polyline points=\"{}\" fill=\"none\" stroke=\"#4b91d1\"/>",
        points.join(" ")
    );
    for (count, dash) in [(0, ""), (16, " stroke-dasharray=\"5 4\""), (most, "")] {
        let (x, y) = at(0, count);
        let (end, _) = at(steps, count);
        let _ = writeln!(
            text,
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{count}</text>",
            x - 8.0,
            y + 4.0
        );
        if count < most {
            let _ = writeln!(
                text,
                "<path d=\"M{x:.1} {y:.1}H{end:.1}\" stroke=\"{INK}\" fill=\"none\"{dash}/>"
            );
        }
    }
    for step in (0..steps).filter(|&step| code.spills(step)) {
        let (x, y) = at(step, 0);
        let _ = writeln!(text, "<path d=\"M{x:.1} {:.1}v10\" stroke=\"#c05621\"/>", y + 6.0);
    }
    let (x, y) = at(steps / 2, 16);
    let _ = writeln!(
        text,
        "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">16 registers</text>",
        y - 5.0
    );
    text + "</svg>\n"
}
