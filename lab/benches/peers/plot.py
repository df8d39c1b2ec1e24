"""The results as an SVG: bars on a logarithmic axis, told apart by pattern, label and order."""

import math
from xml.sax.saxutils import escape

import table

LEFT, WIDTH, RIGHT, BAR, GAP, HEAD = 250, 520, 90, 13, 16, 22
#: Fills that differ without colour: solid, hatched, dotted, empty.
PATTERNS = """<defs>
<pattern id="p1" width="5" height="5" patternUnits="userSpaceOnUse"><path d="M0,5 L5,0" stroke="#333"/></pattern>
<pattern id="p2" width="5" height="5" patternUnits="userSpaceOnUse"><circle cx="2.5" cy="2.5" r="1" fill="#333"/></pattern>
<pattern id="p3" width="4" height="4" patternUnits="userSpaceOnUse"><path d="M0,2 L4,2" stroke="#333"/></pattern>
<pattern id="p4" width="5" height="5" patternUnits="userSpaceOnUse"><path d="M0,0 L5,5 M0,5 L5,0" stroke="#333" stroke-width="0.6"/></pattern>
<pattern id="p5" width="4" height="4" patternUnits="userSpaceOnUse"><path d="M2,0 L2,4" stroke="#333"/></pattern>
</defs>"""
FILLS = ["#333", "#999", "url(#p1)", "url(#p2)", "url(#p3)", "url(#p4)", "url(#p5)", "#fff"]


def text(x, y, words, anchor="start", size=11, weight="normal"):
    return (f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" '
            f'font-weight="{weight}">{escape(words)}</text>')


def svg(report):
    columns = table.contenders(report)
    groups = []
    for robot, quantity in table.cases(report):
        rows = [table.best(report, column, robot, quantity) for column in columns]
        rows = [row for row in rows if row and row["ns"]]
        if rows:
            groups.append((robot, quantity, rows))
    times = [row["ns"] for _, _, rows in groups for row in rows] or [1, 10]
    low, high = math.floor(math.log10(min(times))), math.ceil(math.log10(max(times)))

    def x(ns):
        return LEFT + WIDTH * (math.log10(ns) - low) / max(1, high - low)

    body, y = [], 70
    for robot, quantity, rows in groups:
        body.append(text(10, y, f"{robot}: {quantity.replace('_', ' ')}", size=12, weight="bold"))
        y += HEAD - BAR
        for row in rows:
            fill = FILLS[columns.index(row["contender"]) % len(FILLS)]
            name = row["contender"]
            body.append(text(LEFT - 6, y + BAR - 3, name, "end"))
            body.append(f'<rect x="{LEFT}" y="{y}" width="{x(row["ns"]) - LEFT:.1f}" height="{BAR - 3}" '
                        f'fill="{fill}" stroke="#333"/>')
            body.append(text(x(row["ns"]) + 4, y + BAR - 3, f"{table.number(row['ns'])} ns"))
            y += BAR
        y += GAP
    grid = []
    for power in range(low, high + 1):
        at = x(10**power)
        grid.append(f'<line x1="{at:.1f}" y1="52" x2="{at:.1f}" y2="{y - GAP}" stroke="#ccc"/>')
        grid.append(text(at, 46, f"{10**power:,} ns" if power >= 0 else f"{10**power} ns", "middle"))
    width = LEFT + WIDTH + RIGHT
    title = "Time a call, nanoseconds, logarithmic; shorter is better"
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {y}" width="{width}" height="{y}" '
        'font-family="sans-serif">', f"<title>{title}</title>", PATTERNS,
        f'<rect width="{width}" height="{y}" fill="#fff"/>', text(10, 20, title, size=14, weight="bold"),
        *grid, *body, "</svg>", ""])
