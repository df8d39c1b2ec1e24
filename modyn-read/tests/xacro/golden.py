"""Writes *.golden: the elements of each *.xacro beside this file, as `xacro` of PyPI expands it.

    pip install xacro==2.1.1 && python modyn-read/tests/xacro/golden.py

A line has the depth of an element, its name and its attributes in order, or a text without its white space.

Writes the results in expressions.golden as well: each expression, a tab, and `=` with the result of `xacro`. `error` is
in its place if `xacro` refuses the expression, and `object` if the result is the text of an object of Python.
"""

import contextlib
import io
import pathlib
import re
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


def result(expression: str) -> str:
    """The text of an attribute whose value is this expression."""
    document = xml.dom.minidom.parseString("<robot><a/></robot>")
    document.documentElement.firstChild.setAttribute("b", "${" + expression + "}")
    try:
        xacro.process_doc(document)
    except Exception:
        return "error"
    text = document.documentElement.firstChild.getAttribute("b")
    escaped = text.replace("\t", "\\t").replace("\n", "\\n")
    return "object" if re.search(r"^<.*>$", text) else f"={escaped}"


path = here / "expressions.golden"
expressions = [line.split("\t")[0] for line in path.read_text().splitlines()]
with contextlib.redirect_stderr(io.StringIO()):
    path.write_text("".join(f"{expression}\t{result(expression)}\n" for expression in expressions))
