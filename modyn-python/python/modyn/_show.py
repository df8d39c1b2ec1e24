"""Motions of a robot as animations in notebooks."""

from __future__ import annotations

import html
import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ._modyn import Robot


class Animation:
    """A motion as a page of HTML, which notebooks show."""

    def __init__(self, page: str, height: int) -> None:
        self.page = page
        """the page, one file that needs no network"""
        self.height = height

    def _repr_html_(self) -> str:
        # A frame of its own keeps the page's script apart from the notebook.
        return (
            f'<iframe srcdoc="{html.escape(self.page)}" width="100%" height="{self.height}" '
            'sandbox="allow-scripts allow-downloads" style="border: 0"></iframe>'
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page to a file, for a browser."""
        Path(path).write_text(self.page, encoding="utf-8")


def show(
    robot: Robot,
    trajectory: ArrayLike | None = None,
    *,
    times: ArrayLike | None = None,
    dt: float = 0.01,
    height: int = 480,
    ground: float | None = None,
) -> Animation:
    """Returns the animation of a motion, with the shapes of the description and sliders of the joints.

    `trajectory` has the coordinates at each time, (n, nq); one configuration, (nq,), is a still picture, as is the neutral
    one without a trajectory. `times`, (n,), are in s; by default the states are `dt` apart. The ground is drawn at the
    height `ground`, m; by default at zero, or below the motion if that goes below zero.
    """
    if trajectory is None:
        trajectory = robot.neutral()
    q = np.atleast_2d(np.asarray(trajectory, float))
    when = np.arange(len(q)) * dt if times is None else np.asarray(times, float)
    return Animation(robot.animation(when, q, ground), height)
