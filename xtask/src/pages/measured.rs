//! Tables and numbers of pages that are made of measurements.

use super::chart::ROBOTS;
use super::data::{Data, table};

/// A ratio of times, to two digits.
fn ratio(ratio: f64) -> String {
    if ratio >= 9.95 { format!("{ratio:.0}") } else { format!("{ratio:.1}") }
}

/// The program whose times the others are divided by.
const OWN: &str = "modyn native";

/// The README's table: microseconds of modyn and of the fastest other program.
fn speed_in_short() -> String {
    let (warm, cold) = (Data::load("calls"), Data::load("calls-cold"));
    let cell = |data: &Data, quantity: &str, robot: &str| {
        let ns = |program| data.find(&[quantity, robot, program], "ns")?.parse::<f64>().ok();
        let others = ["CasADi C", "Pinocchio C++"].into_iter().filter_map(ns);
        let fastest = others.reduce(f64::min)?;
        Some([ns(OWN)?, fastest].map(microseconds).join(" / "))
    };
    let rows = ROBOTS.map(|(robot, title, _)| {
        let cell = |data, quantity| cell(data, quantity, robot).unwrap_or("not measured".into());
        let [dynamics, derivatives] = ["forward dynamics", "forward dynamics derivatives"];
        [
            title.into(),
            cell(&warm, dynamics),
            cell(&cold, dynamics),
            cell(&warm, derivatives),
            cell(&cold, derivatives),
        ]
    });
    table("robot | forward dynamics, warm | cold | its derivatives, warm | cold", rows)
}

/// Returns a number of nanoseconds as microseconds, to two digits below ten.
fn microseconds(ns: f64) -> String {
    let us = ns / 1000.0;
    if us < 1.0 {
        format!("{us:.2}")
    } else if us < 9.95 {
        format!("{us:.1}")
    } else {
        format!("{us:.0}")
    }
}

/// The least and the largest of numbers, as text.
fn range(numbers: impl IntoIterator<Item = f64>) -> String {
    let (low, high) =
        numbers.into_iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
    assert!(low <= high);
    if low.round() == high.round() { format!("{low:.0}") } else { format!("{low:.0} to {high:.0}") }
}

/// The interpreter's times over those of generated code.
fn interpreter() -> String {
    let data = Data::load("speed");
    let slow = data.rows.iter().filter(|row| row[2] == "modyn interpreter");
    range(slow.map(|row| {
        let ns = |program| data.number(&[&row[0], &row[1], program], "ns");
        ns("modyn interpreter") / ns(OWN)
    }))
}

/// Batches' times over those of single calls.
fn batched(robot: &str) -> String {
    let data = Data::load("speed");
    let ns = |program| data.number(&["forward dynamics", robot, program], "ns");
    format!("{:.2}", ns("modyn batch") / ns(OWN))
}

/// The first cells of a row of the firmware's table: core, scalar, level of optimisation, function.
type Measurement<'a> = [&'a str; 4];

/// The quotients of a column of the firmware's table: of each row over the `other` row.
fn firmware(title: &str, comparison: &str) -> Vec<f64> {
    let data = Data::load("firmware");
    let quotient = |row: &Vec<String>| {
        let own: Measurement = std::array::from_fn(|i| row[i].as_str());
        let other = other(comparison, own)?;
        let other = other.each_ref().map(String::as_str);
        data.find(&other, title)?;
        Some(data.number(&own, title) / data.number(&other, title))
    };
    let found: Vec<f64> = data.rows.iter().filter_map(quotient).collect();
    assert!(found.len() > 1, "{title}: {found:?}");
    found
}

/// Returns the row of the firmware's table with which a row is compared in `comparison`.
fn other(comparison: &str, [core, scalar, level, function]: Measurement) -> Option<[String; 4]> {
    let has_scalar = scalar == "f32" || core == "M7";
    let is_dynamics = function.ends_with("_dynamics`");
    let renamed = |from, to: &str| Some(to.to_owned() + function.strip_prefix(from)?);
    let (scalar, function) = match (comparison, level) {
        ("shared limbs", "3") if has_scalar && is_dynamics => {
            (scalar, renamed("`legs_shared::", "`legs::")?)
        }
        ("C and Rust", "3") if has_scalar => (scalar, renamed("`arm7_c::", "`arm7::")?),
        ("opt-level s", "s") if function == "`arm7::forward_dynamics`" => (scalar, function.into()),
        ("f64 by software", "3") if is_dynamics && core == "M4F" && scalar == "f64" => {
            ("f32", function.into())
        }
        _ => return None,
    };
    Some([core.into(), scalar.into(), "3".into(), function])
}

/// The rows of the firmware's table that its page shows.
fn firmware_in_short() -> String {
    let names: Vec<&str> =
        "arm7::forward_dynamics arm7_c::forward_dynamics legs::forward_dynamics legs_shared::forward_dynamics"
            .split(' ')
            .collect();
    let data = Data::load("firmware");
    let shown = |row: &&Vec<String>| {
        let is_of_core = [["M4F", "f32"], ["M7", "f64"]].iter().any(|of| row[..2] == *of);
        is_of_core && row[2] == "3" && names.contains(&row[3].trim_matches('`'))
    };
    let mut rows: Vec<&[String]> = data.rows.iter().filter(shown).map(Vec::as_slice).collect();
    let place = |row: &[String]| names.iter().position(|name| row[3].trim_matches('`') == *name);
    let core = |row: &[String]| data.rows.iter().position(|one| one[..3] == row[..3]);
    rows.sort_by_key(|row| (core(row), place(row)));
    table(&data.titles.join(" | "), rows) + &data.source()
}

/// Counts of the real robots, as part of a sentence.
fn robots_in_short() -> String {
    let data = Data::load("robots");
    let (check, differences) =
        (data.column("`modyn check`"), data.column("mass matrix, Pinocchio"));
    let count =
        |accepts: &dyn Fn(&[String]) -> bool| data.rows.iter().filter(|row| accepts(row)).count();
    let all = data.rows.len();
    let usable = count(&|row| row[check].starts_with("usable"));
    let with_option = count(&|row| row[check].starts_with("refused; usable"));
    let loaded = count(&|row| row[differences] != "does not load");
    let compared =
        |row: &[String]| !["loads", "does not load"].contains(&row[differences].as_str());
    let agreeing = |row: &[String]| row[differences..].iter().all(|cell| !cell.contains("DIFFERS"));
    let [both, agree] = [count(&compared), count(&|row| compared(row) && agreeing(row))];
    format!(
        "{all} descriptions of real robots. {usable} of them are usable as they are, {with_option} with an option, and \
         {} are refused. Pinocchio loads {loaded}; {both} of these were computed by both, and {agree} agree",
        all - usable - with_option
    )
}

/// Counts of the public collections, as part of a sentence.
fn collections_in_short() -> String {
    let data = Data::load("collections");
    let sum = |format: &str, title: &str| {
        let (own, column) = (data.column("format"), data.column(title));
        let rows = data.rows.iter().filter(|row| row[own] == format);
        rows.map(|row| row[column].parse::<usize>().expect("a number")).sum::<usize>()
    };
    let titles = ["models that move", "accepted", "by an option", "agree", "differ"];
    let parts = [("mjcf", "MJCF models", "MuJoCo"), ("urdf", "URDFs", "Pinocchio")];
    let parts = parts.map(|(format, name, other)| {
        let [models, accepted, by_option, agree, differ] = titles.map(|title| sum(format, title));
        let options = if by_option > 0 { format!(", {by_option} more by an option") } else { String::new() };
        format!(
            "of {models} {name} in which something moves {accepted} are accepted{options}; {agree} of them agree with {other}, \
             {differ} differ, and {other} does not load the others"
        )
    });
    parts.join("; ")
}

/// The quotient of the numbers in a column of two rows, `file; row; row; column`.
fn quotient(place: &str) -> f64 {
    let [file, row, other, column] = place.split("; ").collect::<Vec<_>>()[..] else {
        panic!("{place:?}")
    };
    let data = Data::load(file);
    data.number(&[row], column) / data.number(&[other], column)
}

/// Returns the text of the mark `name`, if it is made of measurements.
pub(super) fn text_of(name: &str) -> Option<String> {
    let per_cent = |title, comparison| firmware(title, comparison).into_iter().map(|x| 100.0 * x);
    Some(match name {
        "speed-in-short" => speed_in_short(),
        "interpreter" => interpreter(),
        "batched-ur5" => batched("ur5"),
        "batched-panda" => batched("panda"),
        "robots-in-short" => robots_in_short(),
        "collections-in-short" => collections_in_short(),
        "firmware" => firmware_in_short(),
        "f64-by-software" => range(firmware("instructions", "f64 by software")),
        "shared-flash" => range(per_cent("flash, with callees", "shared limbs")),
        "shared-instructions" => range(per_cent("instructions", "shared limbs").map(|x| x - 100.0)),
        "c-instructions" => range(per_cent("instructions", "C and Rust")),
        "c-flash" => range(per_cent("flash, with callees", "C and Rust")),
        "small-flash" => range(per_cent("flash, with callees", "opt-level s").map(|x| 100.0 - x)),
        "small-instructions" => range(per_cent("instructions", "opt-level s").map(|x| x - 100.0)),
        _ => {
            if let Some(place) = name.strip_prefix("ratio ") {
                ratio(quotient(place))
            } else {
                let place = name.strip_prefix("increase ")?;
                format!("{:.0}", 100.0 * (quotient(place) - 1.0))
            }
        }
    })
}
