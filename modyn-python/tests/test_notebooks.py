"""The notebooks of the documentation run from their first cell to their last. They hold what their cells print."""

import json

import pytest
from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def code(path):
    """Returns the text of each cell of code."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]


def test_there_are_notebooks():
    assert [path.stem for path in NOTEBOOKS] == ["identification", "learning", "quadruped"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, monkeypatch):
    """The cells have assertions of their own."""
    cells = code(path)
    if any("import jax\n" in text for text in cells):
        pytest.importorskip("jax", reason="JAX is not installed: pip install modyn[jax]")
    monkeypatch.chdir(path.parent)
    session = {}
    for number, text in enumerate(cells):
        exec(compile(text, f"{path.name}, cell of code {number}", "exec"), session)
    assert sum("assert " in text for text in cells) >= 2


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_outputs_of_a_notebook_are_what_it_prints(path):
    notebook = json.loads(path.read_text(encoding="utf-8"))
    assert (notebook["nbformat"], notebook["nbformat_minor"]) == (4, 5)
    assert len({cell["id"] for cell in notebook["cells"]}) == len(notebook["cells"])
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    for number, cell in enumerate(cells, 1):
        prints = any("print(" in line for line in cell["source"])
        assert cell["execution_count"] == number
        assert [(output["output_type"], output["name"]) for output in cell["outputs"]] == [("stream", "stdout")] * prints
        assert all(0 < sum(map(len, output["text"])) < 2000 for output in cell["outputs"])
