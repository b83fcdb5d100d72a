"""Exceptions, whose text is that of the command line (where, expected, found, help), and checks of arguments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ._ripstop import CaseError, DeviceError, RunError

__all__ = ["CaseError", "DeviceError", "Interrupted", "RunError", "among", "failed", "refusal", "within"]


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run, whose results so far are in `result`, or during a study, whose rows so far lie in `folder`."""

    def __init__(self, text: str, result: Any = None, folder: str | None = None) -> None:
        super().__init__(text)
        self.result, self.folder = result, folder


def failed(failure: BaseException, result: Any, text: str, folder: str | None = None) -> BaseException:
    """Exception to raise for a failure, with what there is of a result."""
    if isinstance(failure, KeyboardInterrupt):
        return Interrupted(text, result, folder)
    if isinstance(failure, (CaseError, RunError)):
        failure.result = result
    return failure


def refusal(place: str, expected: object, found: object, advice: str = "leave it out") -> CaseError:
    """Refusal of an argument."""
    return CaseError(f"error: {place}\n  expected: {expected}\n  found: {found}\n  help: {advice}")


def within(name: str, value: float | None, low: float, high: float) -> None:
    """Refuses a number outside its limits."""
    if value is not None and not low <= value <= high:
        raise refusal(name, f"{low} to {high}", value)


def among(name: str, value: str | None, known: Sequence[str]) -> None:
    """Refuses a word that is not known."""
    if value is not None and value not in known:
        raise refusal(name, ", ".join(known), repr(value))
