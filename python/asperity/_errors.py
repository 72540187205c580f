"""Errors and warnings of the package."""

import os
import sys
import types
import warnings
from typing import NamedTuple

FOLDER = os.path.dirname(__file__)  #: of the package


class Problem(NamedTuple):
    """One thing that is wrong with an input."""

    file: str | None    #: as it was named; None where the problem is of no file
    line: int | None    #: from 1; None where it has none
    column: int | None  #: in bytes, from 1; None where it has none
    text: str           #: what is wrong, what was found, what is expected

    def __str__(self) -> str:
        place = [str(part) for part in self[:3] if part is not None]
        return ": ".join([":".join(place), self.text] if place else [self.text])


class InputError(ValueError):
    """The input is bad. `problems` has all that is wrong with it, in the order found."""

    def __init__(self, problems: list[Problem]):
        super().__init__(problems)
        self.problems = problems

    def __str__(self) -> str:
        return "\n".join(map(str, self.problems))


def refused(file: str | None, text: str, line: int | None = None) -> InputError:
    """The error for one thing that is wrong."""
    return InputError([Problem(file, line, None, text)])


class ComputeError(RuntimeError):
    """A valid scene that cannot be solved; the text gives the reason."""


class TheoryWarning(UserWarning):
    """A result outside the range of validity of a theory."""


class AccuracyWarning(UserWarning):
    """A result with a larger error than the tolerance: an effect that is left out, an estimated
    error, a grid that is too coarse."""


_shown: set[tuple[str, int, str]] = set()


def issue(lines: list[str], kinds: list[str]) -> None:
    """Issue the warnings of a run, printed lines with the name and class of their kinds, as Python
    warnings that point at the caller of the package.

    Python's default is to show a text once for each line of code. The texts have numbers, which
    differ from solve to solve: with that default a kind is shown once for each line of code.
    """
    level, frame = _caller()
    for line, kind in zip(lines, kinds):
        name, _, family = kind.partition(" ")
        category = AccuracyWarning if family == "accuracy" else TheoryWarning
        text = line.removeprefix("scene: warning: ")
        place = frame.f_code.co_filename, frame.f_lineno, name
        if place in _shown and _is_shown_once(text, category, frame.f_globals.get("__name__", "")):
            continue
        _shown.add(place)
        warnings.warn(text, category, stacklevel=level)


def warn_caller(text: str, category: type[Warning]) -> None:
    """Issue one warning that points at the caller of the package."""
    warnings.warn(text, category, stacklevel=_caller()[0])


def _caller() -> tuple[int, types.FrameType]:
    """The first frame outside the package, and its level for the caller of this function."""
    level, frame = 0, sys._getframe(0)
    while frame.f_back and os.path.dirname(frame.f_code.co_filename) == FOLDER:
        level, frame = level + 1, frame.f_back
    return level, frame


def _is_shown_once(text: str, category: type[Warning], module: str) -> bool:
    """Whether Python's filters show a warning once for each line of code."""
    for action, message, kind, where, line in warnings.filters:
        if issubclass(category, kind) and line == 0 and not any(
                one and not one.match(own) for one, own in ((message, text), (where, module))):
            return action in ("default", "once", "module")
    return True
