"""Writes *.golden: the elements of each *.xacro beside this file, as `xacro` of PyPI expands it.

    pip install xacro==2.1.1 && python modyn-codegen/tests/xacro/golden.py

A line has the depth of an element, its name and its attributes in order, or a text without its white space.
"""

import contextlib
import io
import pathlib
import xml.dom.minidom

import xacro


def lines(node: xml.dom.minidom.Element, depth: int = 0) -> list[str]:
    attributes = sorted((k, v) for k, v in node.attributes.items() if not k.startswith("xmlns"))
    out = [" ".join([str(depth), node.tagName] + [f"{k}={' '.join(v.split())!r}" for k, v in attributes])]
    text = ""
    for child in [*node.childNodes, None]:
        if child is not None and child.nodeType == child.TEXT_NODE:
            text += child.data
        elif child is None or child.nodeType == child.ELEMENT_NODE:
            if text.split():
                out.append(f"{depth + 1} {' '.join(text.split())!r}")
            text = ""
            if child is not None:
                out += lines(child, depth + 1)
    return out


here = pathlib.Path(__file__).parent
for path in sorted(here.glob("*.xacro")):
    with contextlib.redirect_stderr(io.StringIO()):
        root = xacro.process_file(str(path)).documentElement
    path.with_suffix(".golden").write_text("\n".join(lines(root)) + "\n")
