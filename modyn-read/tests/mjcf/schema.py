"""Writes the elements of MJCF and their attributes, as MuJoCo (PyPI `mujoco`, Apache-2.0) knows them, to `schema.tsv`.

A line has the element, after the elements around it, and its attributes.
"""

from pathlib import Path

import mujoco

FILE = Path(__file__).with_suffix(".tsv")


def schema():
    lines, path = [], []
    for line in mujoco.mj_printSchema(False, False).splitlines():
        words = line.split()
        if not words:
            continue
        if len(words) > 1 and words[1] in ("(!)", "(*)", "(?)", "(R)"):
            level = (len(line) - len(line.lstrip())) // 3
            path[level:] = [words[0].replace("(world)", "")]
            lines.append(("/".join(path), words[2:]))
        else:
            lines[-1][1].extend(words)
    text = [f"# MuJoCo {mujoco.__version__}: mj_printSchema"]
    text += [f"{path}\t{' '.join(attributes)}" for path, attributes in lines]
    return "\n".join(text) + "\n"


if __name__ == "__main__":
    FILE.write_text(schema())
