"""Exceptions and warnings."""

from __future__ import annotations

from typing import NamedTuple


class Diagnostic(NamedTuple):
    """A fault of a description: its place, and what would be right."""

    severity: str
    """`error` or `warning`"""
    code: str
    """the kind of fault, such as `negative-mass`; `modyn explain` lists them"""
    file: str | None
    line: int | None
    """counted from 1"""
    column: int | None
    """counted in characters from 1"""
    subject: str | None
    """the joint, link or robot"""
    message: str
    help: str | None


class DescriptionError(ValueError):
    """A description or an option is wrong.

    `diagnostics` has all faults; `code`, `file`, `line` and `column` are those of the first.
    """

    def __init__(self, message: str, diagnostics: list[Diagnostic]) -> None:
        super().__init__(message, diagnostics)
        self.diagnostics = diagnostics

    def __str__(self) -> str:
        return str(self.args[0])

    @property
    def code(self) -> str | None:
        return self.diagnostics[0].code if self.diagnostics else None

    @property
    def file(self) -> str | None:
        return self.diagnostics[0].file if self.diagnostics else None

    @property
    def line(self) -> int | None:
        return self.diagnostics[0].line if self.diagnostics else None

    @property
    def column(self) -> int | None:
        return self.diagnostics[0].column if self.diagnostics else None


class DescriptionWarning(UserWarning):
    """A description is usable, but probably not what was intended."""

    def __init__(self, message: str, diagnostic: Diagnostic | None = None) -> None:
        super().__init__(message, diagnostic)
        self.diagnostic = diagnostic

    def __str__(self) -> str:
        return str(self.args[0])


class MachineCodeWarning(UserWarning):
    """A function has no machine code here; it is evaluated operation by operation, which is slow."""
