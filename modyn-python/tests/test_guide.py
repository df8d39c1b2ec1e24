"""The programs of the guide run as they are printed, in one session."""

import os
import re

import pytest
from conftest import ROOT


def blocks(path):
    return re.findall(r"^```python\n(.*?)^```", path.read_text(), re.DOTALL | re.MULTILINE)


def test_the_guide(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    os.symlink(ROOT / "robots", tmp_path / "robots")
    programs = blocks(ROOT / "docs" / "tutorial-python.md")
    assert len(programs) >= 7
    session = {}
    for program in programs:
        exec(compile(program, "tutorial-python.md", "exec"), session)
    shown = capsys.readouterr().out
    assert shown.startswith("<modyn.Robot 'arm7', nq = 7, nv = 7>\n")
    assert re.search(r"^a\.urdf:1:\d+: error\[", shown, re.MULTILINE)
    assert (tmp_path / "motion.html").read_text().startswith("<!doctype html>")


def test_the_page_about_jax(monkeypatch):
    pytest.importorskip("jax", reason="JAX is not installed: pip install modyn[jax]")
    monkeypatch.chdir(ROOT)
    programs = blocks(ROOT / "docs" / "learning.md")
    assert len(programs) == 6
    session = {}
    for program in programs:
        exec(compile(program, "learning.md", "exec"), session)
