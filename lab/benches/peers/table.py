"""The results as Markdown."""

from contenders import modyn
from measure import COLD


def best(report, contender, robot, quantity, time="ns"):
    """The fastest of a contender's programs that was right, if any; else one that says why not. `time` is `ns`, or `cold`
    for calls with empty caches."""
    rows = [row for row in report["results"]
            if (row["contender"], row["robot"], row["quantity"]) == (contender, robot, quantity)]
    right = [row for row in rows if row[time] is not None]
    return min(right, key=lambda row: row[time]) if right else next(iter(rows), None)


def contenders(report):
    return list(dict.fromkeys(row["contender"] for row in report["results"]))


def cases(report):
    """Each robot and quantity that something was measured for."""
    done = {(row["robot"], row["quantity"]) for row in report["results"]}
    return [(robot, quantity) for quantity in report["quantities"] for robot in report["robots"]
            if (robot, quantity) in done]


def number(ns):
    return f"{ns:.0f}" if ns >= 100 else f"{ns:.1f}"


def cell(report, row, reference):
    if row is None:
        return ""
    if row["ns"] is None:
        return "failed"
    text = number(row["ns"])
    if reference and reference["ns"] and row is not reference:
        text += f" ({row['ns'] / reference['ns']:.2g}x)"
    return f"{text} {row['variant']}" if row["contender"] not in OWN else text


#: Of one program each, so that the column's head says all.
OWN = [name for name, _, _ in modyn.VARIANTS + modyn.BESIDE]
#: The reference of the ratios.
REFERENCE = "modyn native"


def head(report, commit, date):
    """The first lines of a data file."""
    versions = ", ".join(f"{name} {version}" for name, version in report["versions"].items())
    return [f"# command: {report['command']}", f"# date: {date}", f"# commit: {commit}",
            f"# note: {report['machine']}; best of {report['copies']} copies; {versions}"]


def data(report, commit, date, time="ns"):
    """The file `docs/data/speed.tsv`: of each contender, robot and quantity the fastest program that was right."""
    titles = ["quantity", "robot", "program", "ns", *(["ns, 99 %", "ns, most"] if time == "cold" else []), "variant"]
    lines = [*head(report, commit, date), "\t".join(titles)]
    for robot, quantity in cases(report):
        for contender in contenders(report):
            row = best(report, contender, robot, quantity, time)
            # A program without cold calls has no row among them.
            if row and (time == "ns" or row[time] is not None):
                ns = "failed" if row[time] is None else number(row[time])
                variant = "" if contender in OWN or row["ns"] is None else row["variant"]
                tail = [number(row[name]) for name in COLD[1:]] if time == "cold" else []
                lines.append("\t".join([quantity.replace("_", " "), robot, contender, ns, *tail, variant]))
    return "\n".join(lines) + "\n"


def cold_data(report, commit, date):
    """The file `docs/data/speed-cold.tsv`: the same for calls with empty caches."""
    return data(report, commit, date, "cold")


def errors(report):
    """By contender: the largest error of its programs that were timed, relative to the largest number of a result."""
    timed = {name: [row["error"] for row in report["results"] if row["contender"] == name and row["ns"]]
             for name in contenders(report)}
    return {name: max(found) if found else None for name, found in timed.items()}


def errors_data(report, commit, date):
    """The file `docs/data/speed-errors.tsv`."""
    rows = [f"{name}\t{error:.1e}" for name, error in errors(report).items() if error is not None]
    return "\n".join([*head(report, commit, date), "program\tlargest error", *rows]) + "\n"


def markdown(report):
    columns = contenders(report)
    lines = ["# Nanoseconds a call", ""]
    if report["quick"]:
        lines += ["**A quick run: for debugging, not for quoting.**", ""]
    lines += [f"{report['machine']}. f64, one state a call, one core, the best of "
              f"{report['copies']} copies of a program; in brackets times {REFERENCE}'s; then which "
              "of the contender's programs was the fastest (+F: `-ffp-contract=fast -fno-math-errno`).", ""]
    lines += ["| quantity | robot | " + " | ".join(columns) + " |", "|---" * (len(columns) + 2) + "|"]
    for robot, quantity in cases(report):
        reference = best(report, REFERENCE, robot, quantity)
        cells = [cell(report, best(report, column, robot, quantity), reference) for column in columns]
        lines.append(f"| {quantity.replace('_', ' ')} | {robot} | " + " | ".join(cells) + " |")
    lines += ["", "With empty caches:", "", "| quantity | robot | " + " | ".join(columns) + " |",
              "|---" * (len(columns) + 2) + "|"]
    for robot, quantity in cases(report):
        rows = [best(report, column, robot, quantity, "cold") for column in columns]
        cells = [f"{number(row['cold'])} {row['variant']}" if row and row["cold"] else "" for row in rows]
        lines.append(f"| {quantity.replace('_', ' ')} | {robot} | " + " | ".join(cells) + " |")
    lines += ["", "Largest error against modyn's interpreter, in parts of the largest number of a result:", ""]
    for name, error in errors(report).items():
        lines.append(f"- {name}: nothing timed" if error is None else f"- {name}: {error:.1e}")
    failed = {f"{row['contender']}, {row['variant']}, {row['robot']}, {row['quantity']}": row["why"]
              for row in report["results"] if row["why"]}
    missing = {**report["missing"], **failed}
    if missing:
        lines += ["", "Left out:", "", *[f"- {name}: {why}" for name, why in missing.items()]]
    versions = ", ".join(f"{name} {version}" for name, version in report["versions"].items())
    return "\n".join([*lines, "", f"Versions: {versions}.", ""])
