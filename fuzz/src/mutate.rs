//! Mutations that keep the structure of a description: random changes of bytes mostly destroy the XML.

use std::ops::Range;

use libfuzzer_sys::fuzzer_mutate;

/// Values of attributes: numbers at the limits of computation, names with another meaning elsewhere, and text that
/// would end its attribute.
const VALUES: &[&str] = &[
    "",
    "0",
    "-0",
    "1",
    "-1",
    "0.5",
    "2",
    "1e-12",
    "1e-300",
    "5e-324",
    "1e15",
    "1e50",
    "1e154",
    "1e308",
    "-1e308",
    "nan",
    "inf",
    "0 0 0",
    "1 0 0",
    "0 0 1",
    "0 0 1e-200",
    "1 1 1",
    "1e-8 0 1",
    "0 0 -0.5",
    "1 2",
    "1 2 3 4",
    "a b c",
    "1.5707963267948966 0 0",
    "0 3.141592653589793 0",
    "0.1 0.2 0.3",
    "revolute",
    "continuous",
    "prismatic",
    "fixed",
    "floating",
    "planar",
    "spherical",
    "universal",
    "screw",
    "world",
    "base",
    "fn",
    "Self",
    "ALL",
    "*/",
    "\u{202e}",
    "&quot;; }",
    "&#10;//",
    "&#x85;",
    "#{}",
    "\\",
    "${x}",
    "&lt;",
    "&undefined;",
    "floating_base",
    "\u{1f916}",
];

/// Elements of a description, some of them at invalid places.
const ELEMENTS: &[&str] = &[
    "<origin xyz='0.1 0.2 0.3' rpy='0.3 0.2 0.1'/>",
    "<axis xyz='0 1 0'/>",
    "<axis2 xyz='0 0 1'/>",
    "<mimic joint='a' multiplier='-2' offset='0.5'/>",
    "<dynamics damping='0.1' friction='0.2' armature='0.3'/>",
    "<limit lower='-1' upper='1' effort='2' velocity='3'/>",
    "<mass value='1'/>",
    "<parent link='a'/>",
    "<child link='b'/>",
    "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>",
    "<link name='a'/>",
    "<joint name='a' type='fixed'><parent link='a'/><child link='b'/></joint>",
    "<!DOCTYPE robot>",
    "<![CDATA[>]]>",
    "<!-- -- -->",
    "<?xml version='1.0'?>",
    "<xacro:macro/>",
    "<x xmlns='y'/>",
];

/// Changes `data[..size]` in place, for libFuzzer, and returns the new size.
pub fn mutate(data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    let mut random = Random(u64::from(seed) | 1 << 40);
    if random.below(4) == 0 {
        return fuzzer_mutate(data, size, max_size);
    }
    let mut text = data[..size].to_vec();
    for _ in 0..=random.below(3) {
        change(&mut text, &mut random);
    }
    let size = text.len().min(max_size);
    data[..size].copy_from_slice(&text[..size]);
    size
}

fn change(text: &mut Vec<u8>, random: &mut Random) {
    match random.below(8) {
        // A value is replaced by one from the list, or by that of another attribute.
        0..=1 => {
            if let Some(at) = random.pick(&values(text)) {
                text.splice(at, random.of(VALUES).bytes());
            }
        }
        2..=3 => {
            let all = values(text);
            if let (Some(at), Some(from)) = (random.pick(&all), random.pick(&all)) {
                let other = text[from].to_vec();
                text.splice(at, other);
            }
        }
        // A tag, or the text up to the end of another tag, is removed, repeated elsewhere or invented.
        4 => {
            if let Some(at) = random.pick(&elements(text)) {
                text.drain(at);
            }
        }
        5..=6 => {
            let all = elements(text);
            if let (Some(from), Some(to)) = (random.pick(&all), random.pick(&all)) {
                let copy = text[from].to_vec();
                text.splice(to.start..to.start, copy);
            }
        }
        _ => {
            if let Some(at) = random.pick(&elements(text)) {
                text.splice(at.start..at.start, random.of(ELEMENTS).bytes());
            }
        }
    }
}

/// Returns a range between quotes.
fn values(text: &[u8]) -> Vec<Range<usize>> {
    let mut values = Vec::new();
    let mut open = None;
    for (i, &byte) in text.iter().enumerate() {
        match open {
            None if byte == b'"' || byte == b'\'' => open = Some((i + 1, byte)),
            Some((start, quote)) if byte == quote => {
                values.push(start..i);
                open = None;
            }
            _ => {}
        }
    }
    values
}

/// Returns the range from `<` to the end of the element: of the tag, or of the link or joint.
fn elements(text: &[u8]) -> Vec<Range<usize>> {
    let find = |from: usize, what: &[u8]| {
        text[from..]
            .windows(what.len())
            .position(|part| part == what)
            .map(|i| from + i + what.len())
    };
    let mut elements = Vec::new();
    for start in (0..text.len()).filter(|&i| text[i] == b'<') {
        let rest = &text[start..];
        let Some(tag) = find(start, b">") else { break };
        let whole = [
            (&b"<link"[..], &b"</link>"[..]),
            (b"<joint", b"</joint>"),
            (b"<inertial", b"</inertial>"),
        ];
        let end = whole.iter().filter(|(open, _)| rest.starts_with(open) && text[tag - 2] != b'/');
        let end = end.filter_map(|(_, close)| find(start, close)).next();
        elements.push(start..end.unwrap_or(tag));
    }
    elements
}

/// Numbers from libFuzzer's seed, so that a run can be repeated.
struct Random(u64);

impl Random {
    fn below(&mut self, count: usize) -> usize {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % count
    }

    fn pick(&mut self, all: &[Range<usize>]) -> Option<Range<usize>> {
        (!all.is_empty()).then(|| all[self.below(all.len())].clone())
    }

    fn of<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[self.below(all.len())]
    }
}
