"""The programs of the guide run as they are printed, in one session."""

import os
import re

import pytest
from conftest import ROOT, blocks


def test_the_guide(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    os.symlink(ROOT / "robots", tmp_path / "robots")
    programs = blocks("docs/tutorial-python.md")
    assert len(programs) >= 11
    session = {}
    for program in programs:
        exec(compile(program, "tutorial-python.md", "exec"), session)
    shown = capsys.readouterr().out
    assert shown.startswith("<modyn.Robot 'arm7', nq = 7, nv = 7>\n")
    assert re.search(r"^a\.urdf:1:\d+: error\[", shown, re.MULTILINE)
    assert (tmp_path / "motion.html").read_text().startswith("<!doctype html>")


def test_the_readme(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    (program,) = blocks("README.md")
    exec(compile(program, "README.md", "exec"), {})
    # The torques and the entry of the Jacobian are those that the Rust program prints.
    shown = [float(number) for number in re.findall(r"-?\d+\.\d*(?:e[+-]\d+)?", capsys.readouterr().out)]
    printed = re.search(r"joint torques: \[(.*)\] N m\n.* at (.*) m/s", (ROOT / "README.md").read_text())
    expected = [float(number) for number in printed[1].split(",")]
    assert shown[:7] == pytest.approx(expected, abs=6e-3)
    assert shown[7] == pytest.approx(float(printed[2]), abs=6e-4)


def test_the_page_about_jax(monkeypatch):
    pytest.importorskip("jax", reason="JAX is not installed: pip install modyn[jax]")
    monkeypatch.chdir(ROOT)
    programs = blocks("docs/learning.md")
    assert len(programs) == 10
    session = {}
    for program in programs:
        exec(compile(program, "learning.md", "exec"), session)
    # The targets of the last step do not act yet.
    assert (session["motion"].act == session["targets"]).all() and len(session["walker"].activation_names) == 12
