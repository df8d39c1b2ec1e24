//! Checks the elements and attributes of a model by the table, and reports those that are wrong or
//! refused.

use std::collections::BTreeSet;

use super::element::{Attribute, Element};
use super::table::{self, Treatment, Values};
use crate::description::MAX_NUMBER;
use crate::diagnostics::{Code, Report, suggest};
use crate::work::counted;

/// Reports all wrong and refused elements and attributes under `element`. The places of elements
/// with errors, in themselves or in elements that are not read, are added to `unsound`.
pub fn check(element: &Element, unsound: &mut BTreeSet<usize>, report: &mut Report<'_>) {
    for child in counted(element.children.iter()) {
        let errors = report.errors();
        match table::row(&element.name, &child.name).map(|row| row.treatment) {
            None => {
                unknown(element, child, report);
                unsound.insert(element.at);
            }
            Some(Treatment::Harmless) => {}
            Some(Treatment::Refused(help)) => {
                let message = format!("`<{}>` is not read", child.name);
                report.error(Code::NotRead, child.at, None, message, help);
                unsound.insert(element.at);
            }
            Some(Treatment::Read(read, harmless)) => {
                for attribute in &child.attributes {
                    match read.iter().find(|(name, _)| *name == attribute.name) {
                        Some((_, values)) => check_values(child, attribute, *values, report),
                        None if harmless == "*" => {}
                        None if harmless
                            .split_ascii_whitespace()
                            .any(|name| name == attribute.name) => {}
                        None => {
                            let names = read
                                .iter()
                                .map(|(name, _)| *name)
                                .chain(harmless.split_ascii_whitespace());
                            unknown_attribute(child, attribute, names, report);
                        }
                    }
                }
                if report.errors() > errors {
                    unsound.insert(child.at);
                }
                check(child, unsound, report);
            }
        }
    }
}

fn unknown(parent: &Element, child: &Element, report: &mut Report<'_>) {
    let message = format!("`<{}>` in `<{}>` is not read", child.name, parent.name);
    let help = match suggest(&child.name, table::children(&parent.name)) {
        Some(meant) => format!("did you mean `<{meant}>`?"),
        None => {
            "it could change the dynamics: remove it, or replace it by supported elements".into()
        }
    };
    report.error(Code::NotRead, child.at, None, message, help);
}

fn unknown_attribute<'n>(
    element: &Element,
    attribute: &Attribute,
    names: impl Iterator<Item = &'n str>,
    report: &mut Report<'_>,
) {
    let message = format!("the attribute `{}` of `<{}>` is not read", attribute.name, element.name);
    let help = match suggest(&attribute.name, names) {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => "it could change the dynamics: remove it".into(),
    };
    report.error(Code::NotRead, attribute.at, None, message, help);
}

fn check_values(element: &Element, attribute: &Attribute, values: Values, report: &mut Report<'_>) {
    let value = attribute.value.trim();
    let mut refuse = |help: &str| {
        let message =
            format!("`{}=\"{value}\"` of `<{}>` is not read", attribute.name, element.name);
        report.error(Code::NotRead, attribute.at, None, message, help);
    };
    match values {
        Values::Text => {}
        Values::Word(words) | Values::Only(words, _) if words.contains(&value) => {}
        Values::Word(words) => {
            let quoted: Vec<String> = words.iter().map(|word| format!("`{word}`")).collect();
            refuse(&format!("write {}", quoted.join(" or ")));
        }
        Values::Only(_, help) => refuse(help),
        Values::Exactly(count) => check_numbers(attribute, count..=count, report),
        Values::UpTo(count) => check_numbers(attribute, 1..=count, report),
        Values::Any => check_numbers(attribute, 0..=usize::MAX, report),
        Values::Zero(help) => {
            if !value.split_ascii_whitespace().all(|word| word.parse() == Ok(0.0)) {
                refuse(help);
            }
        }
    }
}

/// Reports words that are not finite numbers, or a wrong count of numbers.
fn check_numbers(
    attribute: &Attribute,
    counts: std::ops::RangeInclusive<usize>,
    report: &mut Report<'_>,
) {
    let value = attribute.value.as_str();
    let errors = report.errors();
    let mut rest = value;
    let mut count = 0;
    while let Some(word) = rest.split_ascii_whitespace().next() {
        let skipped = rest.len() - rest.trim_ascii_start().len();
        let offset = value.len() - rest.len() + skipped;
        rest = &rest[skipped + word.len()..];
        count += 1;
        let (code, message, help) = match word.parse::<f64>() {
            Ok(number) if number.abs() < MAX_NUMBER => continue,
            Ok(_) => (
                Code::NotFinite,
                "a number is not finite".into(),
                "write finite numbers in SI units",
            ),
            Err(_) => {
                let help = "write a decimal number such as `0.25` or `2.5e-1`";
                (Code::BadNumber, format!("`{word}` is not a number"), help)
            }
        };
        // A value with entities is longer in the text.
        let at = attribute.value_at + if attribute.literal { offset } else { 0 };
        report.error(code, at, None, message, help);
        if report.errors() - errors == MAX_ERRORS {
            return;
        }
    }
    if !counts.contains(&count) && report.errors() == errors {
        let least = counts.start();
        let most = counts.end();
        let expected = if least == most { least.to_string() } else { format!("{least} to {most}") };
        let message =
            format!("the number of values of `{}` is {count}, not {expected}", attribute.name);
        let help = "write a decimal number for each, separated by spaces";
        report.error(Code::NumberCount, attribute.value_at, None, message, help);
    }
}

/// The largest number of errors about one attribute: a mesh may have a million numbers.
const MAX_ERRORS: usize = 10;

/// Returns exactly `N` numbers of a text; `None` if it has others, which [`check`] reports.
pub fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    list(text)?.try_into().ok()
}

/// Returns the numbers of a text; `None` if one is not finite, which [`check`] reports.
pub fn list(text: &str) -> Option<Vec<f64>> {
    let number = |word: &str| word.parse().ok().filter(|number: &f64| number.abs() < MAX_NUMBER);
    text.split_ascii_whitespace().map(number).collect()
}

/// Returns the given numbers, and defaults for missing ones.
pub fn filled<const N: usize>(given: Option<&[f64]>, defaults: [f64; N]) -> [f64; N] {
    let given = given.unwrap_or_default();
    core::array::from_fn(|k| given.get(k).copied().unwrap_or(defaults[k]))
}
