//! Mutations that know the structure of a description: after random changes of bytes, most texts are not XML.

use std::ops::Range;

use libfuzzer_sys::fuzzer_mutate;

use crate::vocabulary::{MARKUP, VALUES, Vocabulary};

/// Changes `data[..size]` in place, for libFuzzer, and returns the new size.
pub fn mutate(
    data: &mut [u8],
    size: usize,
    max_size: usize,
    seed: u32,
    vocabulary: &Vocabulary,
) -> usize {
    let mut random = Random(u64::from(seed) | 1 << 40);
    if random.below(4) == 0 {
        return fuzzer_mutate(data, size, max_size);
    }
    let mut text = data[..size].to_vec();
    for _ in 0..=random.below(3) {
        change(&mut text, &mut random, vocabulary);
    }
    if random.below(4) == 0
        && let Some(options) = text.last_mut()
    {
        *options = random.below(256) as u8;
    }
    let size = text.len().min(max_size);
    data[..size].copy_from_slice(&text[..size]);
    size
}

fn change(text: &mut Vec<u8>, random: &mut Random, vocabulary: &Vocabulary) {
    match random.below(9) {
        // A value is replaced by one of the lists, or by that of another attribute.
        0..=1 => {
            if let Some(at) = random.pick(&values(text)) {
                text.splice(at, random.of(VALUES, vocabulary.values).bytes());
            }
        }
        2..=3 => {
            let all = values(text);
            if let (Some(at), Some(from)) = (random.pick(&all), random.pick(&all)) {
                let other = text[from].to_vec();
                text.splice(at, other);
            }
        }
        // An element is removed, repeated elsewhere, or inserted from the vocabulary.
        4 => {
            if let Some(at) = random.pick(&elements(text, vocabulary)) {
                text.drain(at);
            }
        }
        5..=6 => {
            let all = elements(text, vocabulary);
            if let (Some(from), Some(to)) = (random.pick(&all), random.pick(&all)) {
                let copy = text[from].to_vec();
                text.splice(to.start..to.start, copy);
            }
        }
        7 => {
            if let Some(at) = random.pick(&elements(text, vocabulary)) {
                text.splice(at.start..at.start, random.of(MARKUP, vocabulary.elements).bytes());
            }
        }
        _ => {
            if let Some(more) = limb(text, random) {
                *text = more.into_bytes();
            }
        }
    }
}

/// Returns the text of a URDF with a joint and its descendants once more, under other names.
fn limb(text: &[u8], random: &mut Random) -> Option<String> {
    let text = std::str::from_utf8(text).ok()?;
    let parts = |start: &str, end: &str| -> Vec<&str> {
        let starts = text.match_indices(start).map(|(at, _)| &text[at..]);
        starts.filter_map(|rest| Some(&rest[..rest.find(end)? + end.len()])).collect()
    };
    let value = |part: &str, before: &str| -> Option<String> {
        let (_, rest) = part.split_once(&format!("{before}\""))?;
        Some(rest.split_once('"')?.0.to_owned())
    };
    let joints = parts("<joint ", "</joint>");
    let edge = |joint: &&str| Some((value(joint, "parent link=")?, value(joint, "child link=")?));
    let first = joints.get(random.below(joints.len().max(1)))?;
    let (mut links, mut copied) = (vec![edge(first)?.1], vec![*first]);
    let mut done = 0;
    while let Some(parent) = links.get(done).cloned() {
        done += 1;
        for joint in
            joints.iter().filter(|joint| !copied.contains(joint)).copied().collect::<Vec<_>>()
        {
            let Some((from, to)) = edge(&joint) else { continue };
            if from == parent && !links.contains(&to) {
                links.push(to);
                copied.push(joint);
            }
        }
    }
    let mut names = links.clone();
    names.extend(copied.iter().filter_map(|joint| value(joint, "joint name=")));
    let own = |part: &&str| value(part, "link name=").is_some_and(|name| links.contains(&name));
    let bodies = parts("<link ", "</link>");
    copied.extend(bodies.iter().filter(|part| own(part)));
    let mut more = copied.concat();
    for name in names {
        more = more.replace(&format!("\"{name}\""), &format!("\"{name}'\""));
    }
    let end = text.rfind("</robot>")?;
    Some(format!("{}{more}{}", &text[..end], &text[end..]))
}

/// Returns the ranges of the texts between quotes and between tags.
fn values(text: &[u8]) -> Vec<Range<usize>> {
    let mut values = Vec::new();
    let (mut open, mut tag_end) = (None, None);
    for (i, &byte) in text.iter().enumerate() {
        if byte == b'<'
            && let Some(start) = tag_end.take()
            && text[start..i].iter().any(|byte| !byte.is_ascii_whitespace())
        {
            values.push(start..i);
        } else if byte == b'>' {
            tag_end = Some(i + 1);
        }
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

/// Returns the ranges of tags, and of containers with their content.
fn elements(text: &[u8], vocabulary: &Vocabulary) -> Vec<Range<usize>> {
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
        let containers = vocabulary.containers.iter();
        let end = containers
            .filter(|(open, _)| rest.starts_with(open.as_bytes()) && text[tag - 2] != b'/');
        let end = end.filter_map(|(_, close)| find(start, close.as_bytes())).next();
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

    /// Returns an element of one of two lists, all with the same probability.
    fn of<'a>(&mut self, first: &[&'a str], second: &[&'a str]) -> &'a str {
        let i = self.below(first.len() + second.len());
        first.get(i).unwrap_or_else(|| &second[i - first.len()])
    }
}
