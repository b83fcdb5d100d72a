"""Words to the user: exceptions with the text of the command line (where, expected, found, help), checks of arguments, and progress."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from ._ripstop import CaseError, DeviceError, RunError

__all__ = [
    "CaseError", "DeviceError", "Interrupted", "Receiver", "RunError", "among", "failed", "has_line", "refusal", "shown", "within", "write",
]  # fmt: skip

#: Receiver of progress: numbers by name, units in the names.
Receiver = Callable[[Mapping[str, float | None]], object]

WIDTH = 79  #: Length of the line of progress.
FIRST = 0.1  #: Time before which no progress is written [s].


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


def line(what: str, at: Mapping[str, float | None]) -> str:
    """Progress in words."""
    number = {name: value for name, value in at.items() if value is not None}
    if "time_us" in number:
        return "{what}, {time_us:.0f} of {end_time_us:.0f} µs, {velocity_m_s:.1f} m/s".format(what=what, **number)
    text = "{what}, {done:.0f} of {of:.0f}".format(what=what, **number) + (f", {number['shots']:.0f} shots" if number.get("shots") else "")
    ends = [f"{number[end]:.0f}" for end in ("low_m_s", "high_m_s") if end in number]
    return text + (f", limit {' to '.join(ends)} m/s" if ends else "")


def has_line(progress: object) -> bool:
    """Whether a line of progress is written: where it is asked for, and without a word in a terminal or the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    in_notebook = ipython is not None and hasattr(ipython.get_ipython(), "kernel")
    return bool(progress) or (progress is None and (sys.stderr.isatty() or in_notebook))


def write(text: str) -> None:
    """Writes a line of progress over the one before."""
    print("\r" + text[:WIDTH].ljust(WIDTH), end="\r", file=sys.stderr, flush=True)


@contextmanager
def shown(progress: bool | Receiver | None, what: str) -> Iterator[Receiver | None]:
    """Receiver of progress while a block runs.

    `progress`: True for a line, False for none, None for a line in a terminal or a notebook, or a function of your own. It is called on your
    thread, ten times a second at most, with numbers by name: of a run `time_us`, `end_time_us`, `velocity_m_s`, `failed_yarns`, `steps`; of a
    study `done`, `of`, `shots`, `low_m_s`, `high_m_s`. What it raises ends the work.
    """
    if callable(progress) or not has_line(progress):
        yield progress if callable(progress) else None
        return
    start = time.monotonic()
    try:
        yield lambda at: write(f"{line(what, at)}, {time.monotonic() - start:.0f} s")
    finally:
        if time.monotonic() - start > FIRST:
            write("")
