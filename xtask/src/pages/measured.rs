//! Tables and numbers of pages that are made of measurements.

use modyn_codegen::{Base, Builder};

use super::data::{Data, table};
use super::root;

/// A ratio of times, to two digits.
fn ratio(ratio: f64) -> String {
    if ratio >= 9.95 { format!("{ratio:.0}") } else { format!("{ratio:.1}") }
}

/// Times by robot and program, the ratio to the program `reference` in brackets, then the fastest of a program's variants.
fn speed(file: &str, reference: &str) -> String {
    let data = Data::load(file);
    let mut programs: Vec<&str> = Vec::new();
    let mut cases: Vec<[&str; 2]> = Vec::new();
    for row in &data.rows {
        let (case, program) = ([row[0].as_str(), row[1].as_str()], row[2].as_str());
        if !programs.contains(&program) {
            programs.push(program);
        }
        if !cases.contains(&case) {
            cases.push(case);
        }
    }
    let titles = [&["quantity", "robot"], &programs[..]].concat();
    let rows = cases.into_iter().map(|[quantity, robot]| {
        let own = data.number(&[quantity, robot, reference], "ns");
        let cell = |program: &&str| {
            let key = [quantity, robot, program];
            let Some(ns) = data.find(&key, "ns") else { return String::new() };
            let Ok(value) = ns.parse::<f64>() else { return ns.into() };
            let times = match *program == reference {
                true => String::new(),
                false => format!(" ({}x)", ratio(value / own)),
            };
            format!("{ns}{times} {}", data.cell(&key, "variant")).trim_end().into()
        };
        let cells = programs.iter().map(cell);
        [quantity.into(), robot.into()].into_iter().chain(cells).collect::<Vec<_>>()
    });
    table(&titles.join(" | "), rows) + &data.source()
}

/// The README's table.
fn speed_in_short() -> String {
    let (warm, cold) = (Data::load("speed"), Data::load("speed-cold"));
    let robots = [
        ("ur5", "UR5, 6 joints"),
        ("panda", "Panda, 7 joints"),
        ("solo12_ff", "Solo12 quadruped, floating, 18"),
        ("g1", "G1 humanoid, 29 joints"),
        ("g1_ff", "G1 humanoid, floating, 35"),
    ];
    let cell = |data: &Data, quantity: &str, robot: &str| {
        let ns = |program| data.find(&[quantity, robot, program], "ns")?.parse::<f64>().ok();
        let own = ns("modyn native")?;
        let others = [("CasADi C", "CasADi"), ("Pinocchio C++", "Pinocchio")];
        let others = others
            .into_iter()
            .filter_map(|(program, name)| Some(format!("{name} {}x", ratio(ns(program)? / own))));
        Some(format!("{own:.0} ns ({})", others.collect::<Vec<_>>().join(", ")))
    };
    let rows = robots.map(|(robot, title)| {
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
        ns("modyn interpreter") / ns("modyn native")
    }))
}

/// Batches' times over those of single calls.
fn batched(robot: &str) -> String {
    let data = Data::load("speed");
    let ns = |program| data.number(&["forward dynamics", robot, program], "ns");
    format!("{:.2}", ns("modyn batch") / ns("modyn native"))
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

/// Estimates the speed of a kernel of the table `cuda`, by NVIDIA's data sheet of the H200. Returns the threads that
/// the processor has at a time, the time (ns) of a state or of a rollout's step if all instructions of a thread run at the full
/// rate, and the sum behind the time.
fn h200(robot: &str, kernel: &str, scalar: &str) -> (usize, f64, String) {
    const MULTIPROCESSORS: usize = 132;
    const REGISTERS: usize = 65_536;
    const MAX_WARPS: usize = 64;
    const GIGAHERTZ: f64 = 1.98;
    // A block has 4 warps of 32 threads; a warp's registers are given out in units of 8 a thread.
    let (warps_of_block, warp) = (4, 32);
    let data = Data::load("cuda");
    let key = [robot, kernel, scalar, "sm_90"];
    let registers = (data.number(&key, "registers") as usize).next_multiple_of(8);
    let instructions = data.number(&key, "instructions");
    let blocks = REGISTERS / (registers * warp * warps_of_block);
    let threads = MULTIPROCESSORS * warp * (blocks * warps_of_block).min(MAX_WARPS);
    let lanes = if scalar == "f32" { 128.0 } else { 64.0 };
    let nanoseconds = instructions / (MULTIPROCESSORS as f64 * lanes * GIGAHERTZ);
    let sum = format!(
        "{instructions} instructions / ({MULTIPROCESSORS} * {lanes} * {GIGAHERTZ} GHz) = {nanoseconds:.3} ns a state"
    );
    (threads, nanoseconds, sum)
}

/// The estimates for the kernels of the table `cuda`.
fn cuda_estimates() -> String {
    let data = Data::load("cuda");
    let rows = data.rows.iter().filter(|row| row[data.column("architecture")] == "sm_90");
    let rows = rows.map(|row| {
        let (threads, time, _) = h200(&row[0], &row[1], &row[2]);
        [&row[..3], &[threads.to_string(), format!("{time:.2}")]].concat()
    });
    let titles =
        "robot | kernel | scalar | threads at a time | estimate, ns a state (of a rollout: a step)";
    table(titles, rows) + "\nEstimated from the table `docs/data/cuda.tsv`.\n"
}

/// From how many states on the kernels of forward dynamics in `f64` are faster than batches on cores of a processor, by the
/// estimates for the kernels and the batch times of the table `speed`.
fn cuda_crossover() -> String {
    /// The time to start a kernel and to wait for it, ns.
    const START: f64 = 10_000.0;
    /// The bytes of a copy in a nanosecond: PCI Express 5 with 16 lanes.
    const BYTES: f64 = 63.0;
    const CORES: f64 = 16.0;
    let speed = Data::load("speed");
    let robots = [
        ("Panda", "panda", "panda", Base::Fixed),
        ("Solo12, floating base", "solo12_ff", "solo12", Base::Floating),
        ("G1", "g1", "g1", Base::Fixed),
    ];
    let rows = robots.map(|(title, measured, file, base)| {
        let kernel = h200(title, "`forward_dynamics`", "f64").1;
        let core = speed.number(&["forward dynamics", measured, "modyn batch"], "ns");
        let file = root(&format!("tests/golden/{file}.urdf"));
        let model = Builder::new().urdf(file).base(base).plan().expect("a robot").model;
        // The arguments and the result.
        let copies = 8.0 * (model.nq() + 3 * model.nv()) as f64 / BYTES;
        let from = |core: f64, state: f64| match core - state {
            gain if gain > 0.0 => format!("{:.0}", (START / gain / 100.0).ceil() * 100.0),
            _ => "never".into(),
        };
        [
            title.into(),
            format!("{core}"),
            format!("{kernel:.2}"),
            from(core, kernel),
            from(core / CORES, kernel),
            format!("{copies:.1}"),
            from(core, kernel + copies),
            from(core / CORES, kernel + copies),
        ]
    });
    let titles = "robot | one core, ns a state (measured) | kernel, ns a state | faster than one core from \
        | than 16 cores from | copies, ns a state | with copies, than one core from | with copies, than 16 cores from";
    let date = format!("{} of {}", speed.note("command"), speed.note("date"));
    table(titles, rows)
        + &format!(
            "\nEstimated from the tables `docs/data/cuda.tsv` and `docs/data/speed.tsv` (`{date}`).\n"
        )
}

/// The rows of the firmware's table that its page shows.
fn firmware_in_short() -> String {
    let names: Vec<&str> = "leg::forward_dynamics arm7::brge_solve arm7::mass_matrix arm7::forward_dynamics \
        arm7::inverse_dynamics arm7_c::forward_dynamics legs::forward_dynamics legs_shared::forward_dynamics"
        .split(' ')
        .collect();
    let data = Data::load("firmware");
    let shown = |row: &&Vec<String>| {
        let function = row[3].trim_matches('`');
        names.contains(&function) && (row[2] == "3" || function == "arm7::forward_dynamics")
    };
    let mut rows: Vec<&[String]> = data.rows.iter().filter(shown).map(Vec::as_slice).collect();
    let place = |row: &[String]| names.iter().position(|name| row[3].trim_matches('`') == *name);
    let core = |row: &[String]| data.rows.iter().position(|one| one[..3] == row[..3]);
    rows.sort_by_key(|row| (core(row), place(row)));
    table(&data.titles.join(" | "), rows) + &data.source()
}

/// The rows of the table of machine code that its page shows: forward dynamics and its derivatives.
fn machine_code_in_short() -> String {
    let data = Data::load("machine-code");
    let shown = data.rows.iter().filter(|row| row[1].starts_with("`forward_dynamics"));
    table(&data.titles.join(" | "), shown) + &data.source()
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

/// The models of the collections that are refused, though they are whole and something moves in them.
fn refused_models() -> String {
    let data = Data::load("collected");
    let [verdict, compared, code, why] =
        ["verdict", "compared", "code", "why"].map(|title| data.column(title));
    let is_model = |row: &&Vec<String>| {
        row[verdict] != "accepted" && row[compared] == "loads"
            || row[verdict] == "refused" && row[compared].is_empty()
    };
    let rows: Vec<[String; 4]> = data
        .rows
        .iter()
        .filter(is_model)
        .map(|row| [row[0].clone(), row[1].clone(), format!("`{}`", row[code]), row[why].clone()])
        .collect();
    table("collection | file | code | first error", &rows) + &data.source()
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
        "speed" | "speed-cold" | "contacts-speed" | "contacts-speed-cold" => {
            speed(name, "modyn native")
        }
        "speed-of-c" => speed(name, "modyn, limbs one by one"),
        "speed-in-short" => speed_in_short(),
        "interpreter" => interpreter(),
        "batched-ur5" => batched("ur5"),
        "batched-panda" => batched("panda"),
        "robots-in-short" => robots_in_short(),
        "collections-in-short" => collections_in_short(),
        "collected" => refused_models(),
        "cuda-sum" => h200("Panda", "`forward_dynamics`", "f32").2,
        "cuda-estimates" => cuda_estimates(),
        "cuda-crossover" => cuda_crossover(),
        "firmware" => firmware_in_short(),
        "machine-code" => machine_code_in_short(),
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
